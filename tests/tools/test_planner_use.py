"""README's setup in use: in motion, with a sensor that sticks, and while the noise changes. SciPy's
analogue low-pass at eight times the rate makes the noise.
"""

import math

import numpy as np
import pytest
from planner_case import compiled, fed
from scipy import signal

pytestmark = pytest.mark.slow
RATE, ARW, LSB, FASTER = 1000.0, 0.119, 0.0609756, 8
WHITE, CONSTANT = 1, 3  # davar_noise_t
WINDOW, STRIDE = 4440, 555


@pytest.fixture(scope="module")
def setup(tmp_path_factory):
    words = "--sensor icm42688@1000 --axes 3 --core cortex-m4f"
    return compiled(tmp_path_factory.mktemp("use") / "setup", words)


def noise(samples, seed):
    """deg/s of white noise after two analogue poles at 250 Hz."""
    white = np.random.default_rng(seed).normal(
        0, ARW / 60 * math.sqrt(RATE * FASTER), FASTER * samples
    )
    return signal.lfilter(*signal.butter(2, 2 * 250 / RATE / FASTER), white)[::FASTER]


def counts_of(rate):
    return np.rint(rate / LSB).astype(int)


@pytest.mark.parametrize(("hz", "dps"), ((0.1, 1), (0.5, 0.2), (0.1, 20), (0.5, 5), (2, 1)))
def test_slow_motion_leaves_a_value(setup, hz, dps):
    samples = 200 * WINDOW
    turn = dps * np.sin(2 * np.pi * hz / RATE * np.arange(samples) + 1)
    found = fed(setup, counts_of(noise(samples, int(10 * hz + dps)) + turn))[8:]
    present, value, low, high = found[:, :4].T
    assert np.mean(present) >= 0.98
    kept = present == 1
    assert np.mean((low[kept] <= ARW) & (high[kept] >= ARW)) >= 0.94
    assert abs(np.mean(value[kept]) / ARW - 1) < 0.02
    assert np.all(np.isfinite(high))
    assert np.mean(high >= ARW) >= 0.97


@pytest.mark.parametrize(("hz", "dps", "share"), ((120, 5, 0), (20, 5, 0), (2, 20, 0.75)))
def test_fast_motion_leaves_a_limit_that_holds(setup, hz, dps, share):
    """README: one result in four has a limit only, and in vibration all have."""
    samples = 60 * WINDOW
    turn = dps * np.sin(2 * np.pi * hz / RATE * np.arange(samples))
    present, _, low, high = fed(setup, counts_of(noise(samples, hz) + turn))[8:, :4].T
    assert np.all(np.isfinite(high))
    assert np.mean(high >= ARW) >= 0.97
    kept = present == 1
    assert np.mean(kept) == pytest.approx(share, abs=0.08 if share else 0)
    assert not kept.any() or np.mean((low <= ARW)[kept]) >= 0.9


def test_a_stuck_sensor_is_constant_before_its_arw_falls(setup):
    rate = noise(40 * WINDOW, 3)
    stuck = np.arange(len(rate)) >= 20 * WINDOW + 300
    counts = np.where(stuck, counts_of(rate)[20 * WINDOW + 300], counts_of(rate))
    found = fed(setup, counts)
    epoch = STRIDE * (np.arange(len(found)) + 1) + (len(counts) // STRIDE - len(found)) * STRIDE
    dead = epoch > 20 * WINDOW + 300 + 150  # more than 0.15 s of equal samples
    assert np.all(found[dead, 4] == CONSTANT)
    assert not found[dead, 0].any()
    alive = found[~dead]
    assert np.mean(alive[8:, 4] == WHITE) > 0.97


@pytest.mark.parametrize("times", (3, 1.5))
def test_results_of_mixed_noise_are_unstable(setup, times):
    rate = noise(60 * WINDOW, 5)
    begin = 40 * WINDOW + 200
    rate[begin:] *= times
    found = fed(setup, counts_of(rate))
    epoch = len(rate) // STRIDE * STRIDE - STRIDE * np.arange(len(found))[::-1]
    mixed = (epoch > begin + WINDOW / 4) & (epoch < begin + WINDOW)
    assert np.all(found[mixed, 5] == 1)
    assert not found[epoch < begin][:, 5].any()
    assert not found[epoch > begin + 2 * WINDOW][:, 5].any()
