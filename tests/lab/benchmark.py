"""How often davarlab is right on recordings that its own simulator did not make, beside a model of
the true N and B. SOURCE: awkward (awkward.py) or elsewhere (elsewhere.py). tools/davarlab effects
makes the environment:

build/venv-lab/bin/python tests/lab/benchmark.py SOURCE FIRST_SEED SEEDS [CASE ...]
    [--jobs N] [--rate HZ] [--seconds S] [--rows FILE.json]
"""

import argparse
import json
import multiprocessing
import tempfile
from collections import Counter
from pathlib import Path

import asking
import awkward
import elsewhere
import numpy as np
import scoring
from ingredients.bench import Truth

GOALS = {"right": 0.85, "wrong": 0.02}


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
    row = {"case": case, "seed": seed, "seconds": spent, "clean": truth.clean, "intervals": []}
    if not found:
        return row | {"outcome": "crash", "reasons": [wrong], "untrue": [], "ratio": np.nan}
    outcome, reasons = scoring.outcome(found, truth)
    true = "|".join(["unknown", *truth.observations, *truth.tolerated]).split("|")
    last = found["steps"][-1]
    return row | {
        "outcome": outcome,
        "reasons": [*reasons, f"verdict {found['verdict']}", f"named {scoring.named(found)}"],
        "untrue": sorted(scoring.observed(found) - set(true)),
        "ratio": last["error"] / last["error_floor"],
        "intervals": scoring.intervals(found, truth) if outcome == "right" else [],
    }


def line(row):
    missed = [
        f"{name} {value:.4g} not in {low:.4g} .. {high:.4g}"
        for _, name, hit, value, low, high in row["intervals"]
        if not hit
    ]
    untrue = [f"UNTRUE {kind}" for kind in row["untrue"]]
    head = row["outcome"] if row["outcome"] == "right" else row["outcome"].upper()
    cost = f"{row['ratio']:.2f} of the floor, {row['seconds']:.1f} s"
    return "; ".join(
        [f"{head} {row['case']} {row['seed']}", *row["reasons"], *untrue, *missed, cost]
    )


def shares(rows):
    """The shares of the outcomes."""
    counts = Counter(row["outcome"] for row in rows)
    return {outcome: counts[outcome] / max(1, len(rows)) for outcome in scoring.OUTCOMES}


def summary(rows):
    def said(of):
        return ", ".join(f"{outcome} {one:.1%}" for outcome, one in shares(of).items() if one)

    yield f"{len(rows)} recordings: {said(rows)}"
    yield f"goals: right {GOALS['right']:.0%}, wrong {GOALS['wrong']:.0%} at most"
    clean = [row for row in rows if row["clean"]]
    yield f"clean recordings: {len(clean)}, {said(clean)}"
    yield f"recordings with an untrue observation: {sum(bool(row['untrue']) for row in rows)}"
    ratios, seconds = (np.array([row[name] for row in rows]) for name in ("ratio", "seconds"))
    yield (
        f"error over floor: median {np.nanmedian(ratios):.2f}, "
        f"{np.mean(ratios <= 1.25):.1%} within 1.25, worst {np.nanmax(ratios):.2f}"
    )
    yield f"seconds: median {np.median(seconds):.1f}, worst {max(seconds):.1f}"
    for case in dict.fromkeys(row["case"] for row in rows):
        yield f"  {case:<44}{said([row for row in rows if row['case'] == case])}"
    inside = {}
    for row in rows:
        for kind, name, hit, *_ in row["intervals"]:
            inside.setdefault(f"{kind}.{name}", []).append(hit)
    hits = sum(inside.values(), [])
    if hits:
        yield f"coverage of 95 % intervals {np.mean(hits):.3f} of {len(hits)}"
    for name, of in sorted(inside.items()):
        yield f"  {name:<60}{np.mean(of):.2f} of {len(of)}"


def options():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", choices=SOURCES)
    parser.add_argument("first_seed", type=int)
    parser.add_argument("seeds", type=int)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--rate", type=float)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--rows", metavar="FILE.json", help="also write every row there")
    return parser.parse_args()


def main(chosen):
    cases, _ = SOURCES[chosen.source]
    strange = set(chosen.cases) - set(cases)
    if strange:
        names = ", ".join(sorted(strange))
        raise SystemExit(f"no such case: {names}; there are {', '.join(cases)}")
    jobs = [
        (chosen.source, case, seed, chosen.rate, chosen.seconds)
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
    main(options())
