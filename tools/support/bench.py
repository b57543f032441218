"""The figures of tools/davar-bench: the library (a C program), davar-sim on a long CSV file, the
Python package, and AllanTools.

tools/davar-bench builds everything and calls this. It needs the standard library; AllanTools is
optional.
"""

import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import bench_csv
import target_cost
import targets as boards

Figures = dict[str, Any]  # numbers, None for what is not installed
ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "build/tools"
WINDOW = 600
WINDOWS = 50
CLUSTERS = [1, 2, 4, 8, 16, 32, 64, 128]


def library_figures() -> Figures:
    """The C program prints one `key value` line per figure."""
    output = subprocess.run(
        [PROGRAMS / "tests/bench/davar-bench"], check=True, text=True, stdout=subprocess.PIPE
    ).stdout
    return {key: float(value) for key, value in (line.split() for line in output.splitlines())}


def allantools_ns_per_sample() -> float | None:
    """One value per sample is one call per sample, on the window that ends there. None if
    AllanTools is not installed.
    """
    try:
        import allantools
    except ImportError:
        return None
    noise = random.Random(2)
    data = [noise.gauss(0.37, 0.2) for _ in range(WINDOW + WINDOWS)]
    spent = []
    for i in range(WINDOWS):
        window = data[i : i + WINDOW]
        start = time.perf_counter()
        allantools.oadev(window, rate=1.0, data_type="freq", taus=CLUSTERS)
        spent.append(time.perf_counter() - start)
    return 1e9 * statistics.median(spent)


def python_figures() -> bench_csv.Figures | None:
    """The figures of bench_python.py, in this Python. None if AllanTools is not installed."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT / "python"),
        "DAVAR_LIBRARY": str(PROGRAMS / "python/libdavar_python.so"),
        "OPENBLAS_NUM_THREADS": "1",
        "NUMBA_NUM_THREADS": "1",
    }
    done = subprocess.run(
        [sys.executable, "-B", ROOT / "tools/support/bench_python.py"],
        env=environment,
        text=True,
        capture_output=True,
    )
    if done.returncode:
        print(
            "davar-bench: cannot measure the Python package: "
            f"{(done.stderr.splitlines() or ['no reason'])[-1]}",
            file=sys.stderr,
        )
        return None
    figures: bench_csv.Figures = json.loads(done.stdout)
    return figures


def numba_ns_per_sample(figures: bench_csv.Figures | None) -> float | None:
    return (figures or {}).get(f"window {WINDOW}, every sample, ns", {}).get("numba")


def show(figures: Figures) -> None:
    fixed = figures["fixed_every_sample_8_taus_ns_per_sample"]
    rows = [
        ("davar, fixed", fixed),
        ("davar, float", figures["float_every_sample_8_taus_ns_per_sample"]),
        ("an expert's loop in numba", figures["numba_ns_per_sample"]),
        ("brute force in C, cumulative sum", figures["brute_force_ns_per_sample"]),
        ("AllanTools oadev, called per window", figures["allantools_per_window_ns_per_sample"]),
        ("reading the samples", figures["reading_ns_per_sample"]),
    ]
    print(f"Allan deviation at every sample, {len(CLUSTERS)} octave taus, window {WINDOW}")
    print(f"{'':<38}{'ns per sample':>14}{'times davar':>14}")
    for name, value in rows:
        print(
            f"{name:<38}"
            + (f"{value:>14,.1f}{value / fixed:>14,.1f}" if value else f"{'not installed':>14}")
        )
    print(
        f"{'davar, blocks of 64, newest only':<38}{figures['block64_8_taus_ns_per_sample']:>14,.1f}"
    )
    print("\nThe complete chain: kurtosis, contribution, window law, deviations, fit, intervals")
    print(
        f"{'a result at every sample':<38}"
        f"{figures['full_chain_every_sample_ns_per_sample']:>14,.1f}"
    )
    print(
        f"{'... and a fit at every 10th':<38}"
        f"{figures['full_chain_fit_every_10_ns_per_sample']:>14,.1f}"
    )
    print(f"{'a result every 60 samples':<38}{figures['grid_8_taus_ns_per_sample']:>14,.1f}")
    print(f"\nCost of window 65536 over window 64   {figures['flatness_65536_over_64']:>14.2f}")
    print(f"... 65536 over 256, a result every 4  {figures['grid_flatness_65536_over_256']:>14.2f}")


def show_all(
    figures: Figures,
    csv: bench_csv.Figures,
    python: bench_csv.Figures | None,
    targets: target_cost.Costs,
) -> None:
    show(figures)
    print("\nThe simulator, compared with counting the lines and with reading the file in pandas")
    bench_csv.show(csv)
    if python:
        print("\nThe Python package, compared with numba, AllanTools, and reading the samples")
        bench_csv.show(python)
    print("\nOn emulated microcontrollers (instructions, bytes)\n" + target_cost.printed(targets))


def measure() -> tuple[Figures, bench_csv.Figures | None]:
    """(library, Python package or None)."""
    figures = library_figures()
    allantools = allantools_ns_per_sample()
    figures["allantools_per_window_ns_per_sample"] = allantools and round(allantools)
    python = python_figures()
    figures["numba_ns_per_sample"] = numba_ns_per_sample(python)
    return figures, python


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools/davar-bench")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        figures, python = measure()
        csv, targets = bench_csv.measure(), target_cost.measure_all()
    except (boards.TargetError, OSError, subprocess.SubprocessError) as why:
        print(f"davar-bench: {why}", file=sys.stderr)
        return 2
    if options.json:
        print(
            json.dumps(
                {"host": figures, "csv": csv, "python": python, "targets": targets}, indent=2
            )
        )
    else:
        show_all(figures, csv, python, targets)
    return 0


if __name__ == "__main__":
    sys.exit(main())
