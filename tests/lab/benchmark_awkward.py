"""How often davarlab is right about awkward sensors (awkward.py), beside a model of the true N and
B; benchmark_elsewhere.py does the same with the recordings of elsewhere.py. tools/davarlab effects
makes the environment:

build/venv-lab/bin/python tests/lab/benchmark_awkward.py FIRST_SEED SEEDS [CASE ...]
    [--jobs N] [--rate HZ] [--seconds S] [--rows FILE.json]
"""

import argparse
import json
import multiprocessing
import tempfile
from pathlib import Path

import asking
import awkward
import elsewhere
import numpy as np
import scoring
from ingredients.bench import Truth

GOALS = {"right": 0.85, "wrong": 0.02, "clean": 0.97, "rounded angles": 0.9}


def of_awkward(case, seed, rate, seconds):
    """(columns, truth, N, B)."""
    return *awkward.case(case, seed, rate, seconds), awkward.N, awkward.B


def of_elsewhere(case, seed, *_):
    columns, effects, n, b = elsewhere.recording(case, seed)
    truth = Truth(groups=[{kind} for kind in effects], clean=not effects)
    truth.kinds = effects | {
        "angle_random_walk": {"coefficient_deg_per_sqrt_h": n},
        "bias_instability": {"coefficient_deg_per_h": b},
    }
    return columns, truth, n, b


# where recordings come from: (cases, how one is made)
SOURCES = {
    "awkward": (awkward.CASES, of_awkward),
    "elsewhere": (elsewhere.CASES, of_elsewhere),
}


def one(job):
    """A row of the benchmark: plain values."""
    source, case, seed, rate, seconds = job
    columns, truth, n, b = SOURCES[source][1](case, seed, rate, seconds)
    with tempfile.TemporaryDirectory() as folder:
        recording, model = Path(folder) / "rec.csv", Path(folder) / "model.toml"
        awkward.write(columns, recording)
        model.write_text(asking.MODEL.format(column="gyro_z_dps", n=n, b=b))
        found, _, wrong, spent = asking.ask(["diagnose", recording, "-m", model])
    row = {
        "case": case,
        "seed": seed,
        "seconds": spent,
        "clean": truth.clean,
        "outcome": "crash",
        "reasons": [wrong],
    }
    if not found:
        return row
    outcome, reasons = scoring.outcome(found, truth)
    last = found["steps"][-1]
    untrue = scoring.observed(found) - set(
        "|".join(["unknown", *truth.observations, *truth.tolerated]).split("|")
    )
    return row | {
        "outcome": outcome,
        "reasons": reasons,
        "verdict": found["verdict"],
        "named": scoring.named(found),
        "alternatives": sorted(scoring.alternatives(found)),
        "observations": sorted(scoring.observed(found)),
        "untrue_observations": sorted(untrue),
        "ratio": last["error"] / last["error_floor"],
        "intervals": scoring.intervals(found, truth) if outcome == "right" else [],
    }


def line(row):
    missed = [
        f"{name} {value:.4g} not in {low:.4g} .. {high:.4g}"
        for _, name, hit, value, low, high in row.get("intervals", [])
        if not hit
    ]
    said = f"{row['verdict']} {row['named']}" if "verdict" in row else ""
    beside = [
        f"{word} {row[name]}"
        for word, name in (
            ("or", "alternatives"),
            ("observed", "observations"),
            ("UNTRUE", "untrue_observations"),
        )
        if row.get(name)
    ]
    head = row["outcome"] if row["outcome"] == "right" else row["outcome"].upper()
    ratio = f"{row['ratio']:.2f} of the floor, " if "ratio" in row else ""
    return "; ".join(
        [
            f"{head} {row['case']} {row['seed']}: {said}",
            *beside,
            *row["reasons"],
            *missed,
            f"{ratio}{row['seconds']:.1f} s",
        ]
    )


def share(rows, outcome):
    return sum(row["outcome"] == outcome for row in rows) / max(1, len(rows))


def summary(rows):
    yield f"{len(rows)} recordings: " + ", ".join(
        f"{outcome} {share(rows, outcome):.1%}" for outcome in scoring.OUTCOMES
    )
    yield (
        f'goals: right {share(rows, "right"):.1%} ({GOALS["right"]:.0%}), wrong with "explains" '
        f"{share(rows, 'wrong'):.1%} ({GOALS['wrong']:.0%} at most)"
    )
    for name, of in (
        ("clean", [r for r in rows if r["clean"]]),
        ("rounded angles", [r for r in rows if r["case"] == "rounded_angle"]),
    ):
        if of:
            yield f"goal: {name} right {share(of, 'right'):.1%} of {len(of)} ({GOALS[name]:.0%})"
    untrue = sum(bool(row.get("untrue_observations")) for row in rows)
    ratios, seconds = (
        [row["ratio"] for row in rows if "ratio" in row],
        [row["seconds"] for row in rows],
    )
    yield f"recordings with an untrue observation: {untrue}"
    if ratios:
        yield (
            f"error over floor: median {np.median(ratios):.2f}, "
            f"{np.mean(np.array(ratios) <= 1.25):.1%} within 1.25, worst {max(ratios):.2f}"
        )
    yield f"seconds: median {np.median(seconds):.1f}, worst {max(seconds):.1f}"
    for case in dict.fromkeys(row["case"] for row in rows):
        of = [row for row in rows if row["case"] == case]
        yield f"  {case:<44}" + " ".join(
            f"{outcome} {sum(r['outcome'] == outcome for r in of)}"
            for outcome in scoring.OUTCOMES
            if share(of, outcome)
        )
    yield from coverage(rows)


def coverage(rows):
    inside = {}
    for row in rows:
        for kind, name, hit, *_ in row.get("intervals", []):
            inside.setdefault(f"{kind}.{name}", []).append(hit)
    hits = [hit for of in inside.values() for hit in of]
    if hits:
        yield f"coverage of 95 % intervals {np.mean(hits):.3f} of {len(hits)}"
    for name, of in sorted(inside.items()):
        yield f"  {name:<60}{np.mean(of):.2f} of {len(of)}"


def options(about):
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("first_seed", type=int)
    parser.add_argument("seeds", type=int)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--rate", type=float)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--rows", metavar="FILE.json", help="also write every row there")
    return parser.parse_args()


def main(source, about):
    chosen, (cases, _) = options(about), SOURCES[source]
    strange = set(chosen.cases) - set(cases)
    if strange:
        raise SystemExit(
            f"no such case: {', '.join(sorted(strange))}; there are {', '.join(cases)}"
        )
    jobs = [
        (source, case, seed, chosen.rate, chosen.seconds)
        for case in chosen.cases or cases
        for seed in range(chosen.first_seed, chosen.first_seed + chosen.seeds)
    ]
    rows = []
    with multiprocessing.Pool(chosen.jobs) as pool:
        for row in pool.imap(one, jobs):
            rows.append(row)
            print(line(row), flush=True)
    print(*summary(rows), sep="\n")
    if chosen.rows:
        Path(chosen.rows).write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main("awkward", __doc__)
