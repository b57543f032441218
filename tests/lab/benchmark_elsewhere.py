"""How often davarlab is right on recordings that its own simulator did not make (elsewhere.py),
beside a model of N and B as they are:

PYTHONPATH=tools/lab build/venv-lab/bin/python tests/lab/benchmark_elsewhere.py
    FIRST_SEED SEEDS [CASE ...]
"""

import sys
import time

import elsewhere
import numpy as np
from davarlab.data.recording import Recording
from davarlab.diagnosis import diagnose, improve
from davarlab.model import Model, Term

N, B = "coefficient_deg_per_sqrt_h", "coefficient_deg_per_h"


def covered(found, model, truth):
    """(kind, parameter, is the truth in the interval, value, low, high) of every number of the
    right model.
    """
    fitted, estimates = improve.fitted_model(found.states[-1], model)
    rows = []
    for term, entry in zip(fitted.terms, estimates):
        for name, e in entry.items():
            value = truth[term.kind].get(name) if fitted.kinds.count(term.kind) == 1 else None
            if isinstance(value, float) and e.high > e.low:
                rows.append((term.kind, name, e.low <= value <= e.high, value, e.low, e.high))
    return rows


def one(case, seed):
    columns, effects, n, b = elsewhere.recording(case, seed)
    model = Model(
        elsewhere.RATE,
        "gyro_z_dps",
        [Term("angle_random_walk", {N: n}), Term("bias_instability", {B: b})],
    )
    begin = time.perf_counter()
    found = diagnose.diagnose(Recording(columns, elsewhere.RATE, case), model)
    spent = time.perf_counter() - begin
    right = found.verdict != "unknown" and sorted(set(found.added)) == sorted(effects)
    truth = {"angle_random_walk": {N: n}, "bias_instability": {B: b}, **effects}
    return right, found, spent, covered(found, model, truth) if right else []


def main(first, seeds, cases):
    verdicts, inside, seconds = [], {}, []
    for case in cases or elsewhere.CASES:
        for seed in range(first, first + seeds):
            right, found, spent, rows = one(case, seed)
            verdicts.append(right)
            seconds.append(spent)
            for kind, name, hit, *_ in rows:
                inside.setdefault(f"{kind}.{name}", []).append(hit)
            missed = [
                f"{name} {value:.4g} not in {low:.4g} .. {high:.4g}"
                for _, name, hit, value, low, high in rows
                if not hit
            ]
            failed = [
                f"{name} {p:.1g}"
                for name, p in found.states[-1].adequacy.tests.items()
                if p < 0.01 and not right
            ]
            print(
                f"{'right' if right else 'WRONG'} {case} {seed}: {found.verdict} {found.added}",
                *failed,
                *missed,
                flush=True,
            )
    print(
        f"{sum(verdicts)} of {len(verdicts)} right; {np.median(seconds):.2f} s, worst "
        f"{max(seconds):.2f} s"
    )
    hits = [hit for row in inside.values() for hit in row]
    print(f"coverage {np.mean(hits):.3f} of {len(hits)}")
    for name, row in sorted(inside.items()):
        print(f"  {name:<60}{np.mean(row):.2f} of {len(row)}")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])
