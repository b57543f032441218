"""What the rate takes from other columns, or seems to; and columns that it takes nothing from."""

import numpy as np
from elsewhere import DEG, ar1, flicker_fft

from .bench import B, N
from .lines import band


def supply(bench):
    """Volts: loads that are switched, a battery that empties, ripple of the logger."""
    rng = bench.rng
    loads = np.cumsum(rng.exponential(200, 60))
    volts = (
        5
        - 0.1 * bench.t / bench.t[-1]
        - 0.15 * (np.searchsorted(loads, bench.t) % 2)
        + 0.05 * ar1(bench.count, np.exp(-1 / (30 * bench.rate)), rng)
    )
    bench.more["supply_V"] = volts + 0.002 * rng.standard_normal(bench.count)
    return volts


def supply_voltage(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.08, 0.2)
    bench.slow += coefficient * (supply(bench) - 5)
    bench.hide("follows", {"coefficient": coefficient})
    bench.truth.shape["follows", "column"] = "supply_V"


def rocking(bench):
    """Degrees per second about x, as on water: it tilts gravity into y."""
    f, rng = bench.rng.uniform(0.08, 0.3), bench.rng
    rate = rng.uniform(0.5, 1.5) * band(bench.count, f / bench.rate, 0.1 * f / bench.rate, rng)
    bench.accel[1] += np.sin(np.radians(np.cumsum(rate - rate.mean()) / bench.rate))
    sigma = N / 60 * np.sqrt(bench.rate)
    bench.more["gyro_x_dps"] = rate + sigma * rng.standard_normal(bench.count) - 0.1
    bench.more["gyro_y_dps"] = sigma * rng.standard_normal(bench.count) + 0.3
    bench.truth.tolerated.add("motion")
    return rate


def axis_leak(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.01, 0.03)
    bench.slow += coefficient * rocking(bench)
    bench.hide("follows", {"coefficient": coefficient})
    bench.truth.shape["follows", "column"] = "gyro_x_dps"


def common_cause(bench):
    """A reference drifts that gyro and accelerometer share, each through a filter of its own.
    Nobody logs it.
    """
    rng = bench.rng
    cause = ar1(bench.count, np.exp(-1 / (bench.rate * rng.uniform(60, 300))), rng)
    through = bench.lagged(cause, rng.uniform(5, 20))
    sigma = N / 60 * np.sqrt(bench.rate)
    bench.slow += rng.uniform(0.005, 0.012) * through
    for axis in "xy":
        bench.more[f"gyro_{axis}_dps"] = rng.uniform(
            0.004, 0.012
        ) * through + sigma * rng.standard_normal(bench.count)
    bench.accel += rng.uniform(4e-4, 9e-4) * cause
    bench.truth.groups.append({"gauss_markov", "rate_random_walk", "common_cause"})
    bench.truth.extra |= {"low_pass"}
    bench.truth.said = "common cause"


def decoys(bench):
    """Columns that move and that the gyro does not follow: bursts of vibration, the sensor set down
    anew about the other axes, volts, other axes.
    """
    rng = bench.rng
    for start in rng.uniform(0, 0.85, rng.integers(2, 5)) * bench.t[-1]:
        on = (bench.t >= start) & (bench.t < start + rng.uniform(20, 300))
        bench.accel += rng.uniform(0.02, 0.1) * on * rng.standard_normal((3, bench.count))
    sigma, turns = N / 60 * np.sqrt(bench.rate), np.zeros((2, bench.count))
    for axis, centre in enumerate(rng.uniform(0.1, 0.9, 2) * bench.t[-1]):
        tilt = rng.uniform(0.3, 1.5) / (
            1 + np.exp(-np.clip((bench.t - centre) / rng.uniform(1, 5), -50, 50))
        )
        turns[axis] = np.gradient(tilt, 1 / bench.rate)
        bench.accel[1 - axis] += np.sin(np.radians(tilt))
    for axis, turn in zip("xy", turns):
        bench.more[f"gyro_{axis}_dps"] = (
            turn + sigma * rng.standard_normal(bench.count) + flicker_fft(bench.count, B / DEG, rng)
        )
    supply(bench)
    bench.truth.tolerated.add("motion")


def clean(bench):
    bench.truth.clean = True
