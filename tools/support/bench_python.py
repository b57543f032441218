"""Compares davar's Python package with AllanTools, both with numpy arrays in one thread:
nanoseconds and their ratio, in one run.

bench.py calls it in build/venv-bench, with PYTHONPATH and DAVAR_LIBRARY set. Prints one JSON
object.
"""

import json
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import allantools
import davar
import numpy as np
import numpy.typing as npt

RATE_HZ = 100.0
RECORD = 1_000_000
WINDOWS = (600, 6000, 60_000)
EPOCHS = 100_000  # of davar
CALLS = 30  # of AllanTools, one per epoch
REPEATS = 5


def seconds(work: Callable[[int], object], repeats: int) -> float:
    """Median processor time of calls."""
    spent = []
    for i in range(repeats):
        start = time.process_time()
        work(i)
        spent.append(time.process_time() - start)
    return statistics.median(spent)


def record(x: npt.NDArray[np.float64]) -> dict[str, float]:
    """The Allan deviation of a complete record at octave taus."""
    taus_s = davar.adev(x, RATE_HZ).taus_s
    ours = seconds(lambda i: davar.adev(x, RATE_HZ), REPEATS)
    theirs = seconds(
        lambda i: allantools.oadev(x, rate=RATE_HZ, data_type="freq", taus=taus_s), REPEATS
    )
    return {"davar_ms": 1e3 * ours, "allantools_ms": 1e3 * theirs, "ratio": theirs / ours}


def windows(x: npt.NDArray[np.float64], window: int, stride: int) -> dict[str, float]:
    """An epoch every `stride` samples: deviations and coefficients with their intervals, compared
    with AllanTools' deviations of each window.
    """
    options: dict[str, Any] = {
        "policy": "fixed",
        "mode": "trailing",
        "window_max": window,
        "window_min": window,
        "segment": 0,
        "stride": stride,
    }
    part = x[: window + EPOCHS] if stride == 1 else x
    epochs = davar.dynamic(part, RATE_HZ, **options)
    ours = seconds(lambda i: davar.dynamic(part, RATE_HZ, **options), 3) / len(epochs.epoch)
    ends = epochs.epoch[np.linspace(0, len(epochs.epoch) - 1, CALLS).astype(int)] + 1
    theirs = seconds(
        lambda i: allantools.oadev(
            part[ends[i] - window : ends[i]], rate=RATE_HZ, data_type="freq", taus=epochs.taus_s
        ),
        CALLS,
    )
    return {
        "davar_ns_per_epoch": 1e9 * ours,
        "allantools_ns_per_epoch": 1e9 * theirs,
        "ratio": theirs / ours,
    }


def main() -> None:
    x = np.random.default_rng(1).normal(0.3, 0.2, RECORD)
    found = {f"python_adev_{RECORD}": record(x)}
    for window in WINDOWS:
        for stride in (1, 100):
            found[f"python_dynamic_{window}_every_{stride}"] = windows(x, window, stride)
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()
