"""benchmark and nulls: how often the search is right. They run modules of tests/lab, which only a
checkout has."""

import argparse
import importlib
import sys
from types import ModuleType

from davar import places

from . import option_types
from .shared import Command, argument, emit, progress


def from_tests(name: str) -> ModuleType:
    """A module of tests/lab: what it measures is the search itself, so it is no part of the
    package."""
    folder = str(places.tests())
    if folder not in sys.path:
        sys.path.append(folder)
    return importlib.import_module(name)


def run_benchmark(options: argparse.Namespace) -> int:
    benchmark = from_tests("benchmark_effects")

    result = benchmark.run(
        range(options.first_seed, options.first_seed + options.seeds),
        options.size,
        options.only,
        options.jobs,
        progress,
    )
    emit(options, result, "\n".join(benchmark.text(result)))
    return 0


def run_nulls(options: argparse.Namespace) -> int:
    nulls = from_tests("nulls")

    result = nulls.run(
        options.recordings,
        options.first_seed,
        options.seconds,
        not options.adequacy_only,
        options.jobs,
        progress,
    )
    emit(options, result, "\n".join(nulls.text(result)))
    return 0


# command: (function, what it does, arguments)
COMMANDS: dict[str, Command] = {
    "benchmark": (
        run_benchmark,
        "measures how often the verdict is right",
        [
            argument("--seeds", type=option_types.whole, default=20),
            argument("--first-seed", type=option_types.natural, default=0),
            argument("--size", choices=("visible", "hard"), default="visible"),
            argument("--only", help="scenarios, separated by commas"),
            argument("--jobs", type=option_types.whole, default=2),
        ],
    ),
    "nulls": (
        run_nulls,
        "measures the null distribution of each candidate, by parametric bootstrap",
        [
            argument("--recordings", type=option_types.whole, default=300),
            argument("--first-seed", type=option_types.natural, default=0),
            argument("--seconds", type=option_types.positive, default=7200.0),
            argument(
                "--adequacy-only", action="store_true", help="p-values only, three times faster"
            ),
            argument("--jobs", type=option_types.whole, default=2),
        ],
    ),
}
