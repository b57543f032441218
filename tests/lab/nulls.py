"""What chance alone does on recordings of an accepted model: gains of the candidates, the tries
(thresholds.TRIES) that they come to (DESIGN 4), and how often a true model is called inadequate
(DESIGN 7). `tools/davarlab nulls`.

Parametric bootstrap: the benchmark's clean recordings (noise and bias instability drawn per seed,
decoy columns), every candidate tried.
"""

from multiprocessing import Pool

import numpy as np
from benchmark_effects import COLUMN, RATE_HZ, base_of
from davarlab import simulate
from davarlab.data.recording import MINIMUM_SAMPLES
from davarlab.diagnosis import fitting, search
from davarlab.errors import BadInput
from davarlab.model import Model
from davarlab.thresholds import TRIES
from scipy import stats

LEVELS = (0.01, 0.05, 0.1, 0.3, 0.5)
TAIL = (0.3, 0.2, 0.1, 0.05)  # shares of the largest gains that the count of tries is read from


def one(job):
    """Of one clean recording: gains by chance, kind -> log-likelihood units (none unless `tried`);
    p-values by test, and of the whole.
    """
    seed, seconds, tried = job
    rng = np.random.default_rng([seed, 40961])
    base = base_of(rng)
    made = simulate.make(base, RATE_HZ, COLUMN, seed=int(rng.integers(1 << 31)), duration_s=seconds)
    state, gains = fitting.start(made, Model(RATE_HZ, COLUMN, base)), {}
    if tried:
        ranking = search.ranking(state)
        gains = {c.kind: max(c.gain, 0.0) for c in reversed(ranking)}
        line = next(c for c in ranking if c.kind == "sinusoid")  # its own law, (4.1)
        gains["sinusoid"] = np.log(TRIES.of_kind["sinusoid"]) - line.log_p
    found = fitting.judged(state).adequacy
    return gains, {**found.tests, "whole model": found.p_value}


def tries(kind, gains):
    """C of p = C P(chi2_1 > 2 gain) (a line: of (4.1)): the largest over a few tail
    shares, and its standard error.
    """
    best = (0.0, 0.0)
    for share in TAIL:
        gain = float(np.quantile(gains, 1 - share))
        tail = np.exp(-gain) if kind == "sinusoid" else stats.chi2.sf(2 * gain, 1)
        if gain > 0 or kind == "sinusoid":
            best = max(best, (share / tail, share / tail / np.sqrt(share * len(gains))))
    return best


def run(count, first, seconds, tried, jobs, progress):
    least = MINIMUM_SAMPLES / RATE_HZ
    if seconds < least:
        raise BadInput(f"--seconds: {seconds:g}; at least {least:g} are needed")
    rows = []
    with Pool(min(jobs, count)) as pool:
        for row in pool.imap(one, [(seed, seconds, tried) for seed in range(first, first + count)]):
            rows.append(row)
            if len(rows) % 20 == 0:
                progress(f"{len(rows)} of {count}")
    found, chances = {}, [row[1] for row in rows]
    for kind in rows[0][0]:
        gains = np.array([row[0][kind] for row in rows])
        c, error = tries(kind, gains)
        found[kind] = {
            "trials": c,
            "standard_error": error,
            "in_use": (TRIES.of_kind | TRIES.of_column).get(kind, TRIES.of_own_effect),
            "gain_95": float(np.quantile(gains, 0.95)),
            "gain_99": float(np.quantile(gains, 0.99)),
            "largest": float(gains.max()),
        }
    rejected = {
        name: [float(np.mean([row[name] < level for row in chances])) for level in LEVELS]
        for name in chances[0]
    }
    return {"recordings": len(rows), "candidates": found, "levels": LEVELS, "rejected": rejected}


def text(result):
    yield f"{result['recordings']} recordings of true models: share rejected at"
    yield " " * 26 + "".join(f"{100 * level:>7g} %" for level in result["levels"])
    for name, shares in result["rejected"].items():
        yield f"{name:<26}" + "".join(f"{100 * share:>9.1f}" for share in shares)
    if result["candidates"]:
        yield f"\n{'':<26}{'trials':>10}{'+-':>9}{'in use':>9}{'95 %':>8}{'99 %':>8}{'largest':>9}"
    for kind, e in result["candidates"].items():
        numbers = f"{e['trials']:>10.3g}{e['standard_error']:>9.2g}{e['in_use']:>9.3g}"
        yield f"{kind:<26}{numbers}{e['gain_95']:>8.2f}{e['gain_99']:>8.2f}{e['largest']:>9.2f}"
