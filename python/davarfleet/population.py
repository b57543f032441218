"""What many units say together: spread of each coefficient, outliers, batches, trends; and effects
that no single recording shows.
"""

import functools
from collections.abc import Iterable, Sequence

import numpy as np
import scipy
from davarlab.arrays import Floats
from davarlab.distributions import norm_isf
from davarlab.effects import table
from davarlab.thresholds import CHANCE

from . import limits
from .store import Found, Row

Gains = dict[str, float]  # of candidates, by kind

# share of groups (a coefficient in a batch) of normal values in which one is called an outlier
OUTLIER = 0.01
CAPPED = (
    0.99  # quantile of the gains of batch and chance together, above which a gain counts no more
)
LEAST = 8  # units of a group, from which something is said of it
PERMUTATIONS = 20000
NEAR = 0.1  # p of the batch, up to which an effect beside one that is found may be what is named
DRAWS, DRAWN_TO = (
    4000,
    1000,
)  # of the largest deviation of so many normal values; beyond: as if the spread was known
TO_SIGMA = 1.482602218505602  # of the median absolute deviation
SLOPES_MAX = 1000  # units that the slopes of all pairs are taken of


def groups(rows: Iterable[Row], key: str) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row[key], []).append(row)
    return dict(sorted(found.items(), key=lambda item: str(item[0])))


def estimates(rows: Iterable[Row], name: str) -> tuple[list[Row], Floats]:
    """Rows that have a coefficient with an interval; (value, low, high) of each, shape (n, 3)."""
    have = [row for row in rows if row["coefficients"].get(name, [0, None])[1] is not None]
    return have, np.array([row["coefficients"][name] for row in have], float).reshape(-1, 3)


def in_logarithm(values: Floats) -> bool:
    """Is a coefficient compared in its logarithm: all of its values are above 0."""
    return bool(len(values) > 0 and np.all(values[:, 0] > 0) and np.mean(values[:, 1] > 0) > 0.5)


@functools.cache
def threshold(count: int) -> float:
    """Robust deviations |x - median| / (1.4826 MAD) that the largest of so many normal values
    exceeds in 1 of 100 groups. By simulation, since the scatter of the MAD itself matters.
    """
    if count > DRAWN_TO:
        return float(norm_isf(OUTLIER / (2 * count)))
    rng, largest = np.random.default_rng(count), []
    for _ in range(DRAWS // 400):
        largest.append(np.max(np.abs(robust(rng.standard_normal((400, count)))), axis=1))
    return float(np.quantile(np.concatenate(largest), 1 - OUTLIER))


def robust(x: Floats) -> Floats:
    """(x - median) / (1.4826 MAD) along the last axis."""
    off = x - np.median(x, axis=-1, keepdims=True)
    spread = TO_SIGMA * np.median(np.abs(off), axis=-1, keepdims=True)
    found: Floats = off / np.maximum(spread, 1e-300)
    return found


def summary(rows: Sequence[Row], axis: str, batch: str, name: str) -> Found | None:
    """One coefficient of one batch: median, spread, and how much of the spread the intervals
    explain; marks outliers in the rows.
    """
    have, values = estimates(rows, name)
    if not len(values):
        return None
    logarithm = in_logarithm(values)
    x = np.log(values[:, 0]) if logarithm else values[:, 0]
    errors = np.array([limits.error_of(*one)[0] for one in values])
    scale = 1.0 if logarithm else abs(float(np.median(x))) or 1.0
    spread = float(TO_SIGMA * np.median(np.abs(x - np.median(x))))
    outliers, limit = [], None
    if len(x) >= LEAST and spread > 0:
        limit = threshold(len(x))
        for row, off in zip(have, robust(x)):
            if abs(off) > limit:
                row["outlier"].append(f"{name}: {off:+.1f}")
                outliers.append(
                    {
                        "file": row["file"],
                        "value": row["coefficients"][name][0],
                        "robust_deviations": float(off),
                    }
                )
    own = float(np.sqrt(max(spread**2 - np.median(errors) ** 2, 0.0)))
    return {
        "axis": axis,
        "batch": batch,
        "coefficient": name,
        "units": len(x),
        "median": float(np.median(values[:, 0])),
        "low_5": float(np.quantile(values[:, 0], 0.05)),
        "high_95": float(np.quantile(values[:, 0], 0.95)),
        "spread": spread / scale,
        "measurement": float(np.median(errors)) / scale,
        "between_units": own / scale,
        "threshold": limit,
        "outliers": outliers,
    }


def compared(rows: Sequence[Row], axis: str, name: str) -> Found | None:
    """Do the batches differ in a coefficient (Kruskal and Wallis)."""
    found = [estimates(part, name)[1] for part in groups(rows, "batch").values()]
    found = [values[:, 0] for values in found if len(values) >= LEAST]
    if len(found) < 2 or np.ptp(np.concatenate(found)) == 0:
        return None
    return {"axis": axis, "coefficient": name, "p_value": float(scipy.stats.kruskal(*found).pvalue)}


def trend(rows: Sequence[Row], axis: str, name: str, against: str) -> Found | None:
    """A coefficient, apart from the median of its batch, against date (against: start_s) or mean
    temperature: Spearman's p, the median slope of all pairs with its 95 % interval, relative and
    per day or per degree.
    """
    rows = [row for row in rows if row.get(against) is not None]
    places, sizes = list[float](), list[float]()
    for part in groups(rows, "batch").values():
        have, values = estimates(part, name)
        if len(values) and in_logarithm(values):
            sizes += list(np.log(values[:, 0]) - np.median(np.log(values[:, 0])))
            places += [row[against] for row in have]
    x, y = np.array(places) / (86400 if against == "start_s" else 1), np.array(sizes)
    if len(x) < 2 * LEAST or np.ptp(x) == 0 or np.ptp(y) == 0:
        return None
    step = -(-len(x) // SLOPES_MAX)
    slope = scipy.stats.theilslopes(y[::step], x[::step])
    return {
        "axis": axis,
        "coefficient": name,
        "against": {"start_s": "date", "temperature_degC": "temperature"}[against],
        "units": len(x),
        "p_value": float(scipy.stats.spearmanr(x, y).pvalue),
        "slope": float(slope[0]),
        "low": float(slope[2]),
        "high": float(slope[3]),
    }


def capped(rows: Sequence[Row], chance: Sequence[Gains]) -> tuple[list[str], Floats, Floats]:
    """(kinds, gains of the units, gains by chance), shapes (units, kinds) and (drawn, kinds); the
    largest hundredth counts as the next.
    """
    kinds = sorted({kind for gains in chance for kind in gains})
    own = np.array([[row["gains"].get(kind, 0.0) for kind in kinds] for row in rows])
    null = np.array([[gains.get(kind, 0.0) for kind in kinds] for gains in chance])
    if not kinds or not len(own):
        return kinds, own, null
    most = np.quantile(np.vstack([own, null]), CAPPED, axis=0)
    return kinds, np.minimum(own, most), np.minimum(null, most)


def name_one(near: Sequence[Found], rows: Sequence[Row], chance: Sequence[Gains]) -> None:
    """What is named in a batch that lacks something: of the kinds near its p the one that gains
    most beyond chance, or, among those that it does not beat by twice the scatter of the difference
    over the units, the one with the fewest free parameters. It counts as found, and the others of
    these are its alternatives: which of two kinds that gain alike falls below a threshold is
    chance. Puts `found`, `named`, `tied` and `alternatives` into the entries.
    """
    kinds, own, null = capped(rows, chance)
    beyond = own - null.mean(axis=0) if kinds else own
    place = {one["kind"]: kinds.index(one["kind"]) for one in near}
    first = max(near, key=lambda one: beyond[:, place[one["kind"]]].mean())
    tied = []
    for one in near:
        lead = beyond[:, place[first["kind"]]] - beyond[:, place[one["kind"]]]
        scatter = np.sqrt(
            np.var(lead) / len(own)
            + np.var(null[:, place[first["kind"]]] - null[:, place[one["kind"]]]) / len(null)
        )
        if one is first or lead.mean() < 2 * scatter:
            tied.append(one)
    chosen = min(
        tied, key=lambda one: (free_parameters(one["kind"]), -beyond[:, place[one["kind"]]].mean())
    )
    others = [one["kind"] for one in tied if one is not chosen]
    chosen.update(found=True, named=True, tied=others, alternatives=others)


def free_parameters(kind: str) -> int:
    return sum(not parameter.optional for parameter in table.find(kind).parameters)


def hidden(
    rows: Sequence[Row], axis: str, batch: str, chance: Sequence[Gains], seed: int = 0
) -> list[Found]:
    """Effects that the model lacks in a batch as a whole. The gains of each candidate over the
    units of the batch, summed, against those of recordings drawn from the fitted models: is the sum
    larger than that of as many drawn from both together? By permutation, of the largest
    standardised sum over all candidates, so that p_value is of the family of all candidates of the
    batch. The largest hundredth of the gains counts as the next: a unit that shows an effect by
    itself is named by itself, and does not speak for its batch.
    """
    kinds, own, null = capped(rows, chance)
    if len(own) < LEAST or len(null) < LEAST or not kinds:
        return []
    everything, count = np.vstack([own, null]), len(own)
    total = everything.sum(axis=0)
    spread = np.std(everything, axis=0) * np.sqrt(count * len(null) / (len(everything) - 1))
    alive = spread > 1e-9

    def deviations(sums: Floats) -> Floats:
        off: Floats = (sums[:, alive] - count * total[alive] / len(everything)) / spread[alive]
        return off

    if not alive.any():
        return []
    rng, blocks = np.random.default_rng(seed), list[Floats]()
    for _ in range(PERMUTATIONS // 500):
        picked = np.argpartition(rng.random((500, len(everything))), count - 1, axis=1)[:, :count]
        chosen = np.zeros((500, len(everything)))
        np.put_along_axis(chosen, picked, 1.0, axis=1)
        blocks.append(deviations(chosen @ everything).max(axis=1))
    largest, found = np.concatenate(blocks), deviations(own.sum(axis=0)[None])[0]
    return [
        {
            "axis": axis,
            "batch": batch,
            "kind": kind,
            "units": count,
            "mean_gain": float(own[:, place].mean()),
            "by_chance": float(null[:, place].mean()),
            "deviations": float(z),
            "p_value": float((1 + np.sum(largest >= z)) / (1 + len(largest))),
        }
        for (place, kind), z in zip(
            [(place, kind) for place, kind in enumerate(kinds) if alive[place]], found
        )
    ]


def hidden_effects(rows: Sequence[Row]) -> list[Found]:
    """Of all axes and batches, most certain first; `found`: beyond CHANCE.family_wise over all of
    them, or named; `named`: see name_one().
    """
    out = []
    parts = [
        (axis, batch, part)
        for axis, own in groups(rows, "axis").items()
        for batch, part in groups(own, "batch").items()
    ]
    for axis, batch, part in parts:
        chance = [row["chance"] for row in rows if row["axis"] == axis and "chance" in row]
        tested = sorted(hidden(part, axis, batch, chance), key=lambda one: -one["deviations"])
        for one in tested:
            one["p_value"] = min(1.0, one["p_value"] * len(parts))
            one.update(
                found=one["p_value"] < CHANCE.family_wise, named=False, tied=[], alternatives=[]
            )
        if any(one["found"] for one in tested):
            name_one([one for one in tested if one["p_value"] < NEAR], part, chance)
        out += tested
    return sorted(out, key=lambda one: -one["deviations"])


def names_of(rows: Iterable[Row]) -> list[str]:
    return list(dict.fromkeys(name for row in rows for name in row["coefficients"]))


def summarised(rows: Iterable[Row]) -> Found:
    """What the population says, plain values. rows: those that did not fail; each gets `outlier`, a
    list of words.
    """
    rows = sorted(
        rows, key=lambda row: (row["file"], row["axis"])
    )  # sums and draws go over them in this order, whatever order they came in
    for row in rows:
        row["outlier"] = []
    by_axis = [(axis, part, names_of(part)) for axis, part in groups(rows, "axis").items()]
    found = [
        summary(one, axis, batch, name)
        for axis, part, names in by_axis
        for name in names
        for batch, one in groups(part, "batch").items()
    ]
    trends = [
        one
        for axis, part, names in by_axis
        for name in names
        for against in ("start_s", "temperature_degC")
        if (one := trend(part, axis, name, against))
    ]
    for one in trends:
        one["found"] = one["p_value"] * len(trends) < CHANCE.family_wise
    batches = [
        one
        for axis, part, names in by_axis
        for name in names
        if (one := compared(part, axis, name))
    ]
    for one in batches:
        one["found"] = one["p_value"] * len(batches) < CHANCE.family_wise
    return {
        "coefficients": [one for one in found if one],
        "trends": trends,
        "batches": batches,
        "hidden": hidden_effects(rows),
    }
