"""The sensor's own filter, and its counts."""

import numpy as np
from scipy import signal

from .bench import N


def counted(bench):
    """Counts that show in the stop band."""
    count = bench.rng.uniform(0.005, 0.03)
    bench.slow = np.round(bench.slow / count) * count
    bench.truth.extra.add("quantization")
    bench.truth.tolerated.add("coarse_counts")


def two_tap_average(bench):
    """The same filter as a bilinear pole at a quarter of the rate: no recording can tell them
    apart.
    """
    bench.through(lambda x: signal.lfilter([0.5, 0.5], [1], x))
    bench.hide("moving_average", {"samples": 2}, {"low_pass"})
    if bench.rng.random() < 0.5:
        counted(bench)


def average_of_several(bench):
    """Its gain has zeros below half the rate."""
    count = int(bench.rng.integers(3, 7))
    bench.through(lambda x: signal.lfilter(np.ones(count) / count, [1], x))
    bench.hide("moving_average", {"samples": count})


def dead_zone(bench):
    """A driver that reports 0 for small rates, with or without a step at the ends of the zone."""
    x = bench.white + bench.slow
    zone = bench.rng.uniform(0.3, 1.2) * np.std(bench.white)
    beyond = x if bench.rng.random() < 0.5 else x - np.sign(x) * zone
    count = bench.rng.uniform(0.001, 0.004)
    bench.slow = np.round(np.where(np.abs(x) < zone, 0.0, beyond) / count) * count
    bench.white, bench.more["bias"] = np.zeros(bench.count), 0.0
    bench.truth.observations.add("dead_zone")
    bench.truth.unknown_is_right, bench.truth.covers = True, False


def butterworth(bench):
    cutoff = 0.2 * bench.rate
    if bench.rng.random() < 0.5:
        bench.through(lambda x: signal.lfilter(*signal.butter(2, cutoff, fs=bench.rate), x))
    else:
        # before the converter: ten times as fast, then every tenth; the white noise above half the
        # rate folds back
        fine = N / 60 * np.sqrt(10 * bench.rate) * bench.rng.standard_normal(10 * bench.count)
        white = signal.lfilter(*signal.butter(2, cutoff, fs=10 * bench.rate), fine)[::10]
        b, a = signal.butter(2, cutoff, fs=bench.rate)
        bench.slow, bench.white = white + signal.lfilter(b, a, bench.slow), np.zeros(bench.count)
    counted(bench)
    bench.hide("low_pass", {"cutoff_hz": cutoff})
    bench.truth.shape["low_pass", "order"] = (2, 2)


def one_pole(bench):
    cutoff = bench.rate * bench.rng.uniform(0.06, 0.2)
    a = np.exp(-2 * np.pi * cutoff / bench.rate)
    bench.through(lambda x: signal.lfilter([1 - a], [1, -a], x))
    bench.hide("low_pass", {"cutoff_hz": cutoff})


def bias_subtracted(bench):
    """The driver subtracts its own running mean: an exponential one, which is a high pass of first
    order.
    """
    period = bench.rng.uniform(0.03, 0.12) * bench.t[-1]
    bench.through(lambda x: x - bench.lagged(x, period / (2 * np.pi)))
    bench.hide("high_pass", {"corner_period_s": period})


def rounded_angle(bench):
    """An integrator's whole counts, each of several times the noise of the angle in a sample."""
    per_sample = N / 60 / np.sqrt(bench.rate)
    count = per_sample * bench.rng.uniform(2, 6)
    bias = bench.rng.uniform(0.02, 0.35) * count * bench.rate
    angle = np.cumsum(
        np.concatenate(
            [[bench.rng.random() * count], (bench.white + bench.slow + bias) / bench.rate]
        )
    )
    bench.slow, bench.white = (
        np.diff(np.round(angle / count)) * count * bench.rate,
        np.zeros(bench.count),
    )
    bench.more["bias"] = 0.0
    bench.truth.kinds["quantization"] = {"coefficient_deg": count / np.sqrt(12)}
    bench.truth.observations.add("coarse_counts|quantization")
    bench.truth.extra.add("quantization")


def rounded_rate(bench):
    sigma = N / 60 * np.sqrt(bench.rate)
    share = bench.rng.uniform(0.22, 1.0)  # noise in counts
    count, bias = sigma / share, bench.rng.uniform(-0.5, 0.5)
    bench.slow = np.round((bench.white + bench.slow + bias) / count) * count
    bench.white, bench.more["bias"] = np.zeros(bench.count), 0.0
    (bench.truth.observations if share < 0.6 else bench.truth.tolerated).add("coarse_counts")


def clipped(bench):
    y = bench.white + bench.slow
    limit = np.quantile(np.abs(y), 1 - bench.rng.uniform(0.003, 0.02))
    bench.slow, bench.white = np.clip(y, -limit, limit), np.zeros(bench.count)
    bench.truth.observations.add("clipped")
    bench.truth.unknown_is_right, bench.truth.covers = True, False
