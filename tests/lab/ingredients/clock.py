"""When the sensor measures, when it is read, and what is lost on the way."""

import numpy as np


def held(bench, at):
    """Sample i shows what the sensor had at sample at[i]."""
    bench.slow, bench.white = (bench.white + bench.slow)[at], np.zeros(bench.count)
    bench.accel = bench.accel[:, at]
    bench.truth.observations.add("repeated_samples")


def repeated_each(bench):
    """The host reads twice, or three times, as often as the sensor measures."""
    each = int(bench.rng.integers(2, 4))
    bench.white /= np.sqrt(each)
    held(bench, np.arange(bench.count) // each * each)


def repeated_slower(bench):
    """The sensor's own rate is a little lower than the host's: a sample is sometimes read twice."""
    ratio = bench.rng.uniform(0.7, 0.95)
    bench.white *= np.sqrt(ratio)
    held(bench, np.floor(np.floor(np.arange(bench.count) * ratio) / ratio).astype(int))


def repeated_behind_counts(bench):
    """A sensor that is read 1.2 to 1.9 times a sample, behind counts as large as its noise: nobody
    can see which samples are repeats.
    """
    count = np.std(bench.white) / bench.rng.uniform(0.8, 3)
    bench.slow = np.round((bench.white + bench.slow) / count) * count
    bench.white = np.zeros(bench.count)
    held(bench, (np.arange(bench.count) / bench.rng.uniform(1.2, 1.9)).astype(int))
    bench.truth.tolerated.add("coarse_counts")
    bench.truth.unknown_is_right, bench.truth.covers = True, False


def repeated_stale(bench):
    """The bus fails at random; the driver answers with the last value."""
    stale = bench.rng.random(bench.count) < bench.rng.uniform(0.05, 0.2)
    stale[0] = False
    held(bench, np.maximum.accumulate(np.where(stale, 0, np.arange(bench.count))))


def jittered_stamps(bench):
    """An even clock; the stamps are of the arrival at a busy host, partly in bunches."""
    late = bench.rng.exponential(bench.rng.uniform(0.2, 1.5) / bench.rate, bench.count)
    bench.stamps = (
        np.maximum.accumulate(bench.t + late) + 1e-5 * np.arange(bench.count) / bench.count
    )
    bench.stamps = np.round(bench.stamps + 1e-6 * np.arange(bench.count), 6)
    bench.truth.observations.add("jitter")


def uneven_clock(bench):
    """The samples themselves come at uneven times, as the stamps say: a line is a line in time, not
    in samples. First of the ingredients.
    """
    steps = (
        1
        + 0.3 * bench.rng.uniform(-1, 1, bench.count)
        + 0.01 * np.sin(2 * np.pi * np.arange(bench.count) / bench.count)
    )
    bench.t = bench.stamps = np.round((np.cumsum(steps) - steps[0]) / bench.rate, 6)
    bench.truth.tolerated.add("jitter")


def lost_samples(bench):
    """3 %, one to five in a row; the stamps tell."""
    lost, mean = np.zeros(bench.count, bool), bench.rng.uniform(1, 5)
    starts = bench.rng.choice(bench.count - 40, int(0.03 * bench.count / mean), replace=False)
    for start, length in zip(starts, bench.rng.geometric(1 / mean, len(starts))):
        lost[start : start + length] = True
    bench.keep = np.flatnonzero(~lost)
    bench.truth.observations.add("lost_samples")
