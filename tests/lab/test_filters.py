"""Filters that are not on the list of low_pass: the noise of SciPy's filters, of which the search
finds the density in front of them. One cause, and no bands that imitate the slope."""

import numpy as np
import pytest
from asking import said
from lab_bench import write_csv
from scipy import signal

RATE, ARW, SAMPLES = 1000.0, 0.3, 60_000


def in_series(one, other):
    return np.convolve(one[0], other[0]), np.convolve(one[1], other[1])


SHAPES = {
    "FIR 31": (signal.firwin(31, 100, fs=RATE), [1]),
    "FIR 21": (signal.firwin(21, 150, fs=RATE), [1]),
    "Butterworth 3": signal.butter(3, 120, fs=RATE),
    "Butterworth 4": signal.butter(4, 60, fs=RATE),
    "Bartlett 16": (signal.convolve(np.ones(16), np.ones(16)) / 256, [1]),
    "Bessel 4": signal.bessel(4, 110, fs=RATE, norm="mag"),
    "Chebyshev 3": signal.cheby1(3, 0.5, 100, fs=RATE),
    "elliptic 3": signal.ellip(3, 0.5, 30, 120, fs=RATE),
    "biquad and notch": in_series(signal.butter(2, 150, fs=RATE), signal.iirnotch(80, 2, fs=RATE)),
}


@pytest.mark.slow
@pytest.mark.parametrize("seed, name", enumerate(SHAPES, 70), ids=SHAPES)
def test_any_filter_is_one_cause_and_leaves_the_density_in_front_of_it(lab, seed, name):
    random, lsb = np.random.default_rng(seed), (0.004, 0.03)[seed % 2]
    white = random.normal(0, ARW / 60 * np.sqrt(RATE), SAMPLES + 500)
    rate = signal.lfilter(*SHAPES[name], white)[500:] + 0.4
    columns = {"time_s": np.arange(SAMPLES) / RATE, "gyro_z_dps": np.round(rate / lsb) * lsb}
    recording = write_csv(lab.work / "rec.csv", columns, ["%.3f", "%.4f"])
    found = said("improve", recording, "-o", lab.work / "m.toml")
    assert "low_pass" in found["missing"]
    assert not {"narrow_band", "gauss_markov", "moving_average"} & set(found["missing"])
    (arw,) = (
        one["parameters"]["coefficient_deg_per_sqrt_h"]
        for one in found["fitted"]
        if one["kind"] == "angle_random_walk"
    )
    assert abs(arw["value"] / ARW - 1) < 0.05
    assert arw["low"] < ARW < arw["high"]
