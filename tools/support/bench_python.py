"""Compares davar's Python package with AllanTools, with an expert's loop in numba and with the time
to read the samples, all with numpy arrays in one thread and in one run.

bench.py calls it in build/venv-bench, with PYTHONPATH and DAVAR_LIBRARY set. Prints one JSON
object: for each task, a figure per competitor; null: numba is not installed.
"""

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import allantools
import bench_numba
import davar
import numpy as np
import numpy.typing as npt

RATE_HZ = 100.0
LSB_DPS = 0.01
RECORDS = (1_000_000, 10_000_000)
WINDOWS = (600, 6000, 60_000)
EPOCHS = 1_000_000  # at every sample
CALLS = 30  # of AllanTools, one per epoch
REPEATS = 5
OCTAVES = 2 ** np.arange(8)

Times = dict[str, float | None]


def seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """The least processor time of a call."""
    spent = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return min(spent)


def record(count: int) -> Times:
    """Milliseconds for the Allan deviation of a complete record of floats at octave taus."""
    x = np.random.default_rng(1).normal(0.3, 0.2, count)
    taus_s = davar.adev(x, RATE_HZ).taus_s
    loop, found = bench_numba.compiled(bench_numba.octaves), np.empty(len(taus_s))
    if loop is not None:
        loop(x[:1000], found[:1])
    return {
        "davar": 1e3 * seconds(lambda: davar.adev(x, RATE_HZ)),
        "numba": loop and 1e3 * seconds(lambda: loop(x, found)),
        "AllanTools": 1e3
        * seconds(lambda: allantools.oadev(x, rate=RATE_HZ, data_type="freq", taus=taus_s), 2),
        "reading": 1e3 * seconds(lambda: x.sum()),
    }


def options(window: int) -> dict[str, Any]:
    return {
        "rate_hz": RATE_HZ,
        "lsb": LSB_DPS,
        "law": "fixed",
        "mode": "trailing",
        "window_max": window,
        "window_min": window,
        "segment": 0,
    }


def noise(count: int) -> bench_numba.Counts:
    """White noise of 20 counts."""
    return np.rint(np.random.default_rng(2).normal(37, 20, count)).astype(np.int16)


def of_allantools(x: bench_numba.Counts, window: int, taus_s: npt.ArrayLike) -> float:
    """Nanoseconds of AllanTools per epoch: one call for each, on the window of that epoch."""
    part = x[:window] * LSB_DPS
    return 1e9 * seconds(
        lambda: allantools.oadev(part, rate=RATE_HZ, data_type="freq", taus=taus_s), CALLS
    )


def every_sample(window: int) -> Times:
    """Nanoseconds per epoch, for an epoch at every sample: eight deviations of int16 counts. davar
    without a fit, with one every tenth epoch and with one at each epoch.
    """
    x = noise(window + EPOCHS)

    def ours(fit_every: int, **changed: Any) -> float:
        given = {"x": x, "clusters": OCTAVES, **options(window), **changed}
        return 1e9 * seconds(lambda: davar.dynamic(fit_every=fit_every, **given), 3) / EPOCHS

    loop, found = bench_numba.compiled(bench_numba.sliding), np.empty((EPOCHS + 1, len(OCTAVES)))
    if loop is not None:
        loop(x[: window + 9], window, OCTAVES, found)
    return {
        "davar": ours(0),
        "davar, floats": ours(0, x=x * LSB_DPS, lsb=None),
        "davar, fit every 10th": ours(10),
        "davar, every fit": ours(1),
        "numba": loop and 1e9 * seconds(lambda: loop(x, window, OCTAVES, found), 3) / EPOCHS,
        "AllanTools": of_allantools(x, window, OCTAVES / RATE_HZ),
        "reading": 1e9 * seconds(lambda: x.sum()) / EPOCHS,
    }


def adaptive(window: int) -> Times:
    """Nanoseconds per epoch, for an epoch at every sample: the window and the statistics that
    dynamic() has by default. No competitor has them.
    """
    x = noise(EPOCHS)

    def ours(fit_every: int) -> float:
        given: dict[str, Any] = {
            "rate_hz": RATE_HZ,
            "lsb": LSB_DPS,
            "clusters": OCTAVES,
            "window_max": window,
        }
        return 1e9 * seconds(lambda: davar.dynamic(x, fit_every=fit_every, **given), 3) / EPOCHS

    return {
        "davar": ours(0),
        "davar, fit every 10th": ours(10),
        "davar, every fit": ours(1),
    }


def every_hundredth(window: int) -> Times:
    """Nanoseconds per epoch, for an epoch every 100 samples: octaves, coefficients and intervals;
    of AllanTools, deviations only.
    """
    x = noise(window + EPOCHS)
    found = davar.dynamic(x, stride=100, **options(window))
    spent = seconds(lambda: davar.dynamic(x, stride=100, **options(window)), 3)
    return {
        "davar, every fit": 1e9 * spent / len(found.epoch),
        "AllanTools": of_allantools(x, window, found.taus_s),
    }


def main() -> None:
    figures = {f"record of {count} samples, ms": record(count) for count in RECORDS}
    for window in WINDOWS:
        figures[f"window {window}, every sample, ns"] = every_sample(window)
    figures[f"adaptive window up to {WINDOWS[0]}, every sample, ns"] = adaptive(WINDOWS[0])
    for window in WINDOWS:
        figures[f"window {window}, every 100th, ns"] = every_hundredth(window)
    json.dump(figures, sys.stdout)


if __name__ == "__main__":
    main()
