"""How often the verdict is right: every effect, pairs, none, and effects outside the table, over
many seeds. `tools/davarlab benchmark`.

Sizes: a scenario's parameters are drawn per seed around a size that stands clearly above the
baseline's Allan deviation ("visible"); "hard" takes 0.4 of the amplitude.
"""

import time
from collections import Counter
from multiprocessing import Pool

import elsewhere
import numpy as np
import oracle
from davarlab import simulate
from davarlab.diagnosis import diagnose, improve
from davarlab.errors import BadInput
from davarlab.model import Model, Term
from lab_bench import terms

RATE_HZ, COLUMN = 50.0, "gyro_z_dps"
HARD = 0.4
SIZES = elsewhere.SIZES | {
    "gauss_markov": {
        "std_dps": (0.003, 0.008),
        "correlation_time_s": (np.log(2), np.log(60), elsewhere.LOG),
    },
    "sinusoid": {
        "amplitude_dps": (0.002, 0.02),
        "frequency_hz": (np.log(0.01), np.log(20), elsewhere.LOG),
    },
    "vibration_rectification": {"coefficient_dps_per_g2": (3, 8), "axis": "xyz"},
    "bias_step": {"time_s": (1000, 6000), "step_dps": (0.012, 0.03)},
    "intermittent_line": {
        "start_s": (500, 5000),
        "frequency_hz": (np.log(0.5), np.log(20), elsewhere.LOG),
        "amplitude_dps": (0.006, 0.02),
        "stop_s": (100, 1500),
    },
    "narrow_band": {"std_dps": (0.01, 0.03), "frequency_hz": (3, 20), "half_width_hz": (0.1, 0.5)},
    "moving_average": {"samples": (1.5, 3)},
}
# of either sign
SIGNED = {"rate_ramp", "temperature", "temperature_rate", "g_sensitivity", "bias_step", "warm_up"}
SIGNED |= {"vibration_rectification"}
PAIRS = (
    ("temperature", "sinusoid"),
    ("gauss_markov", "vibration_noise"),
    ("low_pass", "rate_ramp"),
    ("g_sensitivity", "shocks"),
    ("quantization", "warm_up"),
    ("noise_step", "rate_random_walk"),
)


def drawn(kind, rng, scale):
    """Parameters of an effect at a size that a person would see, times `scale`."""
    sign, axis = rng.choice([-1.0, 1.0]), str(rng.choice(["x", "y", "z"]))
    found = elsewhere.drawn({name: of for name, of in SIZES[kind].items() if name != "axis"}, rng)
    for name, value in found.items():
        if name.startswith("coefficient") or name in ("std_dps", "amplitude_dps", "step_dps"):
            found[name] = value * scale * (sign if kind in SIGNED else 1)
        elif name in ("ratio", "samples"):
            found[name] = 1 + (value - 1) * scale
        elif name == "cutoff_hz":
            found[name] = value / scale**0.5
    return found | ({"axis": axis} if "axis" in SIZES[kind] else {})


def sweep(t, rng):
    low = rng.uniform(0.1, 2)
    return 0.01 * np.sin(2 * np.pi * (low * t + 0.5 * 2 * low / t[-1] * t**2))


def breathing_noise(t, rng):
    return 0.035 * (1 + np.sin(2 * np.pi * t / rng.uniform(300, 900))) * rng.standard_normal(len(t))


def square_wave(t, rng):
    return 0.008 * np.sign(np.sin(2 * np.pi * t / rng.uniform(40, 400) + 1))


OUTSIDE = {"sweeping tone": sweep, "breathing noise": breathing_noise, "square wave": square_wave}


def scenarios(size):
    """name -> kinds in it; names of effects outside the table have none."""
    found = {"none": [], **{kind: [kind] for kind in SIZES}}
    if size == "visible":
        found |= {" + ".join(pair): list(pair) for pair in PAIRS} | dict.fromkeys(OUTSIDE)
    return found


def base_of(rng):
    return terms(rng.uniform(0.2, 0.4), rng.uniform(2, 8))


def one(job):
    """One recording: what was in it and what was said."""
    name, kinds, size, seed = job
    rng = np.random.default_rng([seed, sum(map(ord, name))])
    base = base_of(rng)
    hidden = [Term(kind, drawn(kind, rng, HARD if size == "hard" else 1.0)) for kind in kinds or []]
    recording = simulate.make(base + hidden, RATE_HZ, COLUMN, seed=int(rng.integers(1 << 31)))
    if kinds is None:
        recording.columns[COLUMN] = recording.columns[COLUMN] + OUTSIDE[name](recording.time_s, rng)
    begin = time.perf_counter()
    found = diagnose.diagnose(recording, Model(RATE_HZ, COLUMN, base))
    spent = time.perf_counter() - begin
    result = improve.improved(recording, Model(RATE_HZ, COLUMN, base), found)
    named = sorted(result.added) == sorted(kinds or [])
    right = {
        "outside": result.verdict == "unknown",
        "clean": result.verdict == "none",
        "known": named and result.verdict in (kinds or []),
    }
    of = "outside" if kinds is None else "known" if kinds else "clean"
    return {
        "name": name,
        "seed": seed,
        "of": of,
        "right": right[of],
        "said": result.verdict
        if result.verdict in ("unknown", "none")
        else " + ".join(result.added),
        "first": found.ranking[0].kind in (kinds or []),
        "all_named": set(kinds or []) <= set(result.added),
        "p_value": result.judgement.p_value,
        "covered": covered(result, base + hidden) if named and kinds is not None else {},
        "seconds": spent,
        "over_floor": result.steps[-1].error / result.steps[-1].error_floor,
        "oracle_gain": oracle.gain(hidden[0], base, recording) if len(hidden) == 1 else None,
    }


def covered(result, true):
    """kind.parameter -> is its true value in the interval."""
    truth = {(t.kind, name): value for t in true for name, value in t.parameters.items()}
    return {
        f"{term.kind}.{name}": bool(e.low <= truth[term.kind, name] <= e.high)
        for term, entry in zip(result.model.terms, result.estimates)
        for name, e in entry.items()
        if e.low is not None and (term.kind, name) in truth
    }


def run(seeds, size, only, jobs, progress):
    there = scenarios(size)
    chosen = only.split(",") if only else list(there)
    if unknown := set(chosen) - set(there):
        names = ", ".join(there)
        raise BadInput(f"--only: no scenario {min(unknown)!r} of size {size} (there are: {names})")
    work = [(name, there[name], size, seed) for name in there if name in chosen for seed in seeds]
    rows = []
    with Pool(min(jobs, len(work))) as pool:
        for row in pool.imap(one, work):
            rows.append(row)
            if not row["right"]:
                progress(f"{row['name']} {row['seed']}: {row['said']} p {row['p_value']:.2g}")
            if len(rows) % max(1, len(seeds)) == 0:
                progress(f"{len(rows)} of {len(work)}")
    return summary(rows, seeds, size)


def share(values):
    values = list(values)
    return float(np.mean(values)) if values else None


def summary(rows, seeds, size):
    of = {
        kind: [row for row in rows if row["of"] == kind] for kind in ("known", "clean", "outside")
    }
    inside, confusion = {}, {}
    for row in rows:
        confusion.setdefault(row["name"], Counter())[row["said"]] += 1
        for key, value in row["covered"].items():
            inside.setdefault(key, []).append(value)
    solved = [row["over_floor"] for row in of["known"] if row["right"]]
    measured = [row for row in rows if row["oracle_gain"] is not None]
    detectable = [row for row in measured if row["oracle_gain"] > oracle.CALLABLE]
    by_oracle = {
        name: {
            "gain_median": float(
                np.median([row["oracle_gain"] for row in measured if row["name"] == name])
            ),
            "callable": sum(row["name"] == name for row in detectable),
            "named": sum(row["name"] == name and row["all_named"] for row in detectable),
        }
        for name in dict.fromkeys(row["name"] for row in measured)
    }
    return {
        "size": size,
        "seeds": len(seeds),
        "whole_right": share(row["right"] for row in of["known"]),
        "first_right": share(row["first"] for row in of["known"]),
        "clean_kept": share(row["right"] for row in of["clean"]),
        "outside_unknown": share(row["right"] for row in of["outside"]),
        "true_models_rejected_at_5_percent": share(
            row["p_value"] < 0.05 for row in of["known"] + of["clean"] if row["right"]
        ),
        "coverage": share(sum(inside.values(), [])),
        "coverage_by_parameter": {k: [share(v), len(v)] for k, v in sorted(inside.items())},
        "callable_named": share(row["all_named"] for row in detectable),
        "oracle": by_oracle,
        "error_over_floor_median": float(np.median(solved)) if solved else None,
        "error_over_floor_95": float(np.percentile(solved, 95)) if solved else None,
        "seconds_median": float(np.median([row["seconds"] for row in rows])),
        "seconds_worst": float(max(row["seconds"] for row in rows)),
        "confusion": confusion,
    }


def text(s):
    yield f"size {s['size']}, {s['seeds']} seeds"
    yield from (f"{key:<36}{value:.3f}" for key, value in s.items() if isinstance(value, float))
    yield "\nan oracle that knows noise and shape: median gain in log-likelihood, recordings that"
    yield f"it can detect (above {oracle.CALLABLE:.1f}), of them named"
    for name, one in s["oracle"].items():
        yield f"  {name:<34}{one['gain_median']:>10.1f}{one['callable']:>4}{one['named']:>4}"
    yield "\nin the recording: what was said (count)"
    for name, counts in s["confusion"].items():
        yield f"  {name}: " + ", ".join(f"{said} {n}" for said, n in counts.most_common())
    yield "\ncoverage of 95 % intervals"
    for key, (value, n) in s["coverage_by_parameter"].items():
        yield f"  {key:<60}{value:.2f} of {n}"
