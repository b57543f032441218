"""Runs every method of bench/methods on every signal, and writes a page with its plot. It takes
several minutes.
"""

import argparse
import sys
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import measures
import numpy as np
import page
import runners
import signals
from signals import Floats

ROOT = Path(__file__).resolve().parents[1]
SEEDS = 8
REFERENCE = "25 lines of C"
TIMED = 200_000  # samples
ALTERNATIONS = 15


@dataclass
class Results:
    """By method: what was measured of it."""

    missing: dict[str, str] = field(default_factory=dict)
    errors: dict[str, dict[str, Floats]] = field(default_factory=lambda: defaultdict(dict))
    covered: dict[str, dict[str, Floats]] = field(default_factory=lambda: defaultdict(dict))
    delays_s: dict[str, Floats] = field(default_factory=dict)
    alarms_per_hour: dict[str, float] = field(default_factory=dict)
    ratios: dict[str, list[float | None]] = field(default_factory=dict)  # push, with answers
    instructions: dict[str, float | None] = field(default_factory=dict)


def accuracy(
    found: Results, method: runners.Method, signal: str, records: list[signals.Record]
) -> None:
    answers = [method.answers(record) for record in records]
    pairs = list(zip(answers, records))
    name = method.name
    found.errors[name][signal] = np.concatenate([measures.errors(*pair) for pair in pairs])
    found.covered[name][signal] = np.concatenate([measures.covered(*pair) for pair in pairs])
    if signal == "steps":
        found.delays_s[name] = np.concatenate([measures.delays_s(*pair) for pair in pairs])
    if signal == "rest":
        found.alarms_per_hour[name] = float(
            np.mean([measures.alarms_per_hour(*pair) for pair in pairs])
        )


def cost(found: Results, method: runners.Method, reference: runners.Method, samples: int) -> None:
    """Times relative to the reference: the median ratio of alternating runs."""
    record = signals.simulated("rest", 0, round(samples / 100))
    found.ratios[method.name] = []
    for with_answers in (False, True):
        pairs = [
            [one.nanoseconds(record, with_answers) for one in (reference, method)]
            for _ in range(ALTERNATIONS if method.program else 1)
        ]
        both = [own / given for given, own in pairs if given and own]
        ratio = float(np.median(both)) if both else None
        found.ratios[method.name].append(ratio)
    found.instructions[method.name] = method.instructions(record)


def measured(seeds: int, quick: bool) -> Results:
    """quick: records of 20 s (steps: 200 s), and few samples to time."""
    found = Results()
    every = runners.every()
    short = signals.simulated("rest", 0, 20)
    found.missing = {one.name: why for one in every if (why := runners.missing(one, short))}
    here = [one for one in every if one.name not in found.missing]
    for signal in signals.SIGNALS:
        seconds = (200 if signal == "steps" else 20) if quick else None
        records = [signals.simulated(signal, repetition, seconds) for repetition in range(seeds)]
        for method in here:
            print(f"{signal}: {method.name}", file=sys.stderr)
            accuracy(found, method, signal, records)
    for name, record in signals.recordings().items():
        for method in here:
            accuracy(found, method, name, [record])
    reference = next(one for one in every if one.name == REFERENCE)
    for method in here:
        print(f"cost: {method.name}", file=sys.stderr)
        cost(found, method, reference, TIMED // 10 if quick else TIMED)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench/run", description=__doc__)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=ROOT / "docs/quality",
        help="folder (default docs/quality)",
    )
    parser.add_argument(
        "--seeds", type=int, default=SEEDS, help="records of each signal (default 8)"
    )
    parser.add_argument(
        "--quick", action="store_true", help="one short record each, to see that it runs"
    )
    options = parser.parse_args()
    seeds = 1 if options.quick else options.seeds
    found = measured(seeds, options.quick)
    options.output.mkdir(parents=True, exist_ok=True)
    page.write(options.output, found, runners.every(), seeds)
    print(options.output / page.NAME)


if __name__ == "__main__":
    main()
