"""How often the verdict is right: every effect, pairs, none, and effects outside the table, over
many seeds.

Sizes: a scenario's parameters are drawn per seed around a size that stands clearly above the
baseline's Allan deviation ("visible"); "hard" takes 0.4 of the amplitude.
"""

import time
from multiprocessing import Pool

import elsewhere
import numpy as np
import oracle
from davarlab import simulate
from davarlab.diagnosis import diagnose, improve
from davarlab.errors import BadInput
from davarlab.model import Model, Term

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
    single = {kind: [kind] for kind in SIZES}
    pairs = {" + ".join(pair): list(pair) for pair in PAIRS} if size == "visible" else {}
    return {
        "none": [],
        **single,
        **pairs,
        **(dict.fromkeys(OUTSIDE) if size == "visible" else {}),
    }


def one(job):
    """One recording: what was in it and what was said."""
    name, kinds, size, seed = job
    rng = np.random.default_rng([seed, sum(map(ord, name))])
    base = [
        Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": rng.uniform(0.2, 0.4)}),
        Term("bias_instability", {"coefficient_deg_per_h": rng.uniform(2, 8)}),
    ]
    hidden = [Term(kind, drawn(kind, rng, HARD if size == "hard" else 1.0)) for kind in kinds or []]
    recording = simulate.make(base + hidden, RATE_HZ, COLUMN, seed=int(rng.integers(1 << 31)))
    if kinds is None:
        recording.columns[COLUMN] = recording.columns[COLUMN] + OUTSIDE[name](recording.time_s, rng)
    begin = time.perf_counter()
    found = diagnose.diagnose(recording, Model(RATE_HZ, COLUMN, base))
    spent = time.perf_counter() - begin
    result = improve.improved(recording, Model(RATE_HZ, COLUMN, base), found)
    truth = {
        (t.kind, k): v
        for t in base + hidden
        for k, v in t.parameters.items()
        if not isinstance(v, str)
    }
    covered = {}
    if kinds is not None and sorted(result.added) == sorted(kinds):
        for term, entry in zip(result.model.terms, result.estimates):
            for key, e in entry.items():
                if (term.kind, key) in truth and e.low is not None:
                    covered[f"{term.kind}.{key}"] = bool(e.low <= truth[term.kind, key] <= e.high)
    last = result.steps[-1]
    return {
        "name": name,
        "seed": seed,
        "kinds": kinds,
        "verdict": result.verdict,
        "added": result.added,
        "first": found.ranking[0].kind,
        "p_value": result.judgement.p_value,
        "given_p": result.steps[0].p_value,
        "covered": covered,
        "seconds": spent,
        "before": result.steps[0].error,
        "after": last.error,
        "floor": last.error_floor,
        "oracle_gain": oracle.gain(hidden[0], base, recording) if len(hidden) == 1 else None,
        "alternatives": [one.kind for one in found.alternatives],
        "tests": {k: v for k, v in found.states[-1].adequacy.tests.items() if v < 0.01},
    }


def right(row):
    if row["kinds"] is None:
        return row["verdict"] == "unknown"
    if not row["kinds"]:
        return row["verdict"] == "none"
    return row["verdict"] in row["kinds"] and sorted(row["added"]) == sorted(row["kinds"])


def run(seeds, size, only, jobs, progress):
    unknown = set(only.split(",") if only else []) - set(scenarios(size))
    if unknown:
        raise BadInput(
            f"--only: no scenario {min(unknown)!r} of size {size} (there are: "
            f"{', '.join(scenarios(size))})"
        )
    chosen = {
        name: kinds
        for name, kinds in scenarios(size).items()
        if not only or name in only.split(",")
    }
    work = [(name, kinds, size, seed) for name, kinds in chosen.items() for seed in seeds]
    rows = []
    with Pool(min(jobs, len(work))) as pool:
        for row in pool.imap(one, work):
            rows.append(row)
            if not right(row):
                progress(
                    f"{row['name']} {row['seed']}: {row['verdict']} {row['added']} first "
                    f"{row['first']} p {row['p_value']:.2g} {row['tests']}"
                )
            if len(rows) % max(1, len(seeds)) == 0:
                progress(f"{len(rows)} of {len(work)}")
    return summary(rows, seeds, size)


def share(values):
    values = list(values)
    return float(np.mean(values)) if values else None


def summary(rows, seeds, size):
    known = [row for row in rows if row["kinds"]]
    outside = [row for row in rows if row["kinds"] is None]
    clean = [row for row in rows if row["kinds"] == []]
    covered, pooled = {}, []
    for row in rows:
        for key, value in row["covered"].items():
            covered.setdefault(key, []).append(value)
            pooled.append(value)
    solved = [row["after"] / row["floor"] for row in known if right(row)]
    confusion = {}
    for row in rows:
        entry = confusion.setdefault(row["name"], {})
        said = (
            " + ".join(row["added"])
            if row["verdict"] not in ("unknown", "none")
            else row["verdict"]
        )
        entry[said] = entry.get(said, 0) + 1
    return {
        "size": size,
        "seeds": len(seeds),
        "whole_right": share(right(r) for r in known),
        "first_right": share(r["first"] in r["kinds"] for r in known),
        "clean_kept": share(right(r) for r in clean),
        "outside_unknown": share(right(r) for r in outside),
        "true_models_rejected_at_5_percent": share(
            r["p_value"] < 0.05 for r in rows if right(r) and r["kinds"] is not None
        ),
        "coverage": share(pooled),
        "coverage_by_parameter": {k: [share(v), len(v)] for k, v in sorted(covered.items())},
        "callable_named": share(
            set(r["kinds"]) <= set(r["added"])
            for r in rows
            if (r["oracle_gain"] or 0) > oracle.CALLABLE
        ),
        "oracle": against_oracle(rows),
        "error_over_floor_median": float(np.median(solved)) if solved else None,
        "error_over_floor_95": float(np.percentile(solved, 95)) if solved else None,
        "seconds_median": float(np.median([r["seconds"] for r in rows])),
        "seconds_worst": float(max(r["seconds"] for r in rows)),
        "confusion": confusion,
    }


def against_oracle(rows):
    """Per scenario with one effect: median gain of the oracle, recordings that it can call, those
    of them that were named.
    """
    found = {}
    for name in dict.fromkeys(row["name"] for row in rows if row["oracle_gain"] is not None):
        gains = [
            (row["oracle_gain"], set(row["kinds"]) <= set(row["added"]))
            for row in rows
            if row["name"] == name
        ]
        called = [named for gain, named in gains if gain > oracle.CALLABLE]
        found[name] = {
            "gain_median": float(np.median([gain for gain, _ in gains])),
            "callable": len(called),
            "named": sum(called),
        }
    return found


def text(s):
    lines = [f"size {s['size']}, {s['seeds']} seeds"]
    lines += [f"{key:<36}{value:.3f}" for key, value in s.items() if isinstance(value, float)]
    lines += [
        "",
        "an oracle that knows noise and shape: median gain in log-likelihood, recordings that it "
        f"can call (above {oracle.CALLABLE:.1f}), of them named",
    ]
    lines += [
        f"  {name:<34}{one['gain_median']:>10.1f}{one['callable']:>4}{one['named']:>4}"
        for name, one in s["oracle"].items()
    ]
    lines += ["", "in the recording: what was said (count)"]
    lines += [
        f"  {name}: "
        + ", ".join(f"{said} {n}" for said, n in sorted(entry.items(), key=lambda i: -i[1]))
        for name, entry in s["confusion"].items()
    ]
    lines += ["", "coverage of 95 % intervals"]
    lines += [
        f"  {key:<60}{value:.2f} of {n}" for key, (value, n) in s["coverage_by_parameter"].items()
    ]
    return "\n".join(lines)
