"""Effects on a logged column, tried: temperature late, squared, with hysteresis, in the noise; any
other column (DESIGN 4).

Their shapes are scanned on the slow ordinates of block means at a given level of the noise,
milliseconds a shape; only the best one is fitted in full, and once more at the level that it
leaves."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

import numpy as np
import scipy
from scipy import fft

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording
from ..effects import columns, table
from ..effects.base import Effect, Values, needed
from ..inference import changes, modulation
from ..inference.changes import Blocks
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit
from ..thresholds import CHANCE, COLUMN, SEARCH, SHAPE, TRIES
from .candidate import Candidate, log_tail
from .ranking import shapes_of

Found = TypeVar("Found", bound=Candidate | None)


def block_means(x: Floats, length: int) -> Floats:
    count = len(x) // length
    means: Floats = x[: count * length].reshape(count, length).mean(axis=1)
    return means


def block_length(samples: int) -> int:
    """Samples per mean; of a few lengths the first that makes a fast transform."""
    least = -(-samples // COLUMN.means_most)
    return next(
        (
            length
            for length in range(least, 2 * least)
            if fft.next_fast_len(samples // length, True) == samples // length
        ),
        least,
    )


def coarse(recording: Recording, names: Iterable[str]) -> Recording:
    """The recording in block means, with these columns, denoised before they were averaged."""
    length = block_length(recording.samples)
    index = np.arange(recording.samples // length, dtype=float)
    small: Recording = recording.measured.setdefault(
        "coarse", Recording({"index": index}, recording.rate_hz / length)
    )
    for name in names:
        if name not in small.columns:
            small.columns[name] = block_means(recording.column(name), length)
            small.measured["still", name] = block_means(columns.still(recording, name), length)
    return small


class Scan:
    """Gains of courses at a fixed level of the noise, beside the columns of the parts."""

    def __init__(
        self,
        bench: Bench,
        parts: Sequence[Part],
        level: Floats,
        coefficients: Floats,
        names: Iterable[str],
    ) -> None:
        self.small = coarse(bench.recording, names)
        keys, data = bench.all_keys(parts), bench.data
        self.used = min(self.small.samples // 2, data.samples - 1)
        f = signals.frequencies(data.samples, data.rate_hz, 0, self.used)
        self.weight = 1 / np.sqrt(np.interp(np.log(f), np.log(data.f_bin), level))
        rest = data.without(coefficients, keys)[: self.used]
        basis = np.array([data.columns[key][0][: self.used] * self.weight for key in keys]).reshape(
            len(keys), self.used
        )
        self.basis = np.linalg.qr(basis.T)[0].T if len(keys) else basis
        self.rest = self.without(rest * self.weight)

    def without(self, c: Floats) -> Floats:
        rest: Floats = c - self.basis.T @ (self.basis @ c)
        return rest

    def ordinates(self, part: Part) -> Floats:
        """Of the course of a part, worked out once: they know nothing of the level."""
        if part.key not in self.small.measured:
            regressor = needed(part.effect.variants.get(part.form, part.effect.regressor))
            x = regressor(self.small, part.shape)
            self.small.measured[part.key] = signals.transform(x - x.mean())[1 : self.used + 1]
        found: Floats = self.small.measured[part.key]
        return found

    def gain(self, part: Part) -> float:
        whole = self.ordinates(part) * self.weight
        c = self.without(whole)
        power = c @ c
        return float((c @ self.rest) ** 2 / power / 2) if power > 1e-9 * (whole @ whole) else 0.0


def with_lags(effect: Effect, shape: Values) -> list[Part]:
    """Parts of this shape; what the gyro felt before the record began matters only where it feels
    late."""
    return [
        Part(effect.kind, shape, form)
        for form in effect.forms
        if form != "moving before" or shape.get("lag_s", 0.0) > 0
    ]


def finer(part: Part, recording: Recording) -> list[Part]:
    """The part with its lag or width moved a little."""
    name = next((name for name in ("width_degC", "lag_s") if part.shape.get(name)), None)
    limit = SHAPE.lag_share * recording.samples / recording.rate_hz
    return (
        [
            part.moved(name, part.shape[name] * step)
            for step in np.exp2(np.arange(-6, 7) / 8)
            if name != "lag_s" or part.shape[name] * step <= limit
        ]
        if name
        else []
    )


def best_of(
    bench: Bench, parts: Sequence[Part], fit: Fit, tried: Sequence[Part], names: Iterable[str]
) -> tuple[Part, Fit]:
    """(part, its full fit) of the likeliest of the parts tried, of which there is at least one,
    beside `parts` whose fit is given.
    Tried parts of which the scan knows only the slow half are judged by it; the winner by the full
    likelihood."""
    scan = Scan(bench, parts, fit.level, fit.coefficients, names)
    part = max(tried, key=scan.gain)
    full = bench.fit([*parts, part], near=fit.level)
    scan = Scan(
        bench,
        parts,
        full.level,
        bench.coefficients_of(bench.all_keys(parts), [*parts, part], full),
        names,
    )
    second = max(tried, key=scan.gain)
    second = max([second] + finer(second, bench.recording), key=scan.gain)
    if second.key != part.key:
        other = bench.fit([*parts, second], near=full.level)
        part, full, loser = (
            (second, other, part)
            if other.log_likelihood > full.log_likelihood
            else (part, full, second)
        )
        bench.forget(loser)
    return at_once_unless(bench, parts, part, full)


def at_once_unless(bench: Bench, parts: Sequence[Part], part: Part, full: Fit) -> tuple[Part, Fit]:
    """(part, fit) without its lag, unless the recording can tell it. How late the temperature
    itself is felt, identifiable.py weighs."""
    if part.kind == "temperature" or not part.shape.get("lag_s"):
        return part, full
    prompt = part.moved("lag_s", 0.0)
    other = bench.fit([*parts, prompt], near=full.level)
    return (
        (prompt, other)
        if other.log_likelihood > full.log_likelihood - CHANCE.tell_apart
        else (part, full)
    )


def thermal(
    bench: Bench, parts: Sequence[Part], fit: Fit, kind: str, shapes: Sequence[Values] | None = None
) -> Candidate | None:
    """The best candidate of one kind on the temperature beside the parts; None without a
    temperature that moves."""
    effect = table.find(kind)
    if np.ptp(bench.recording.column("temp_degC")) <= 0:
        return None
    shapes = shapes_of(effect, bench.recording) if shapes is None else shapes
    tried = [part for shape in shapes for part in with_lags(effect, shape)]
    if not tried:
        return None
    part, full = best_of(bench, parts, fit, tried, ("temp_degC",))
    return Candidate(kind, part, full.log_likelihood - fit.log_likelihood, 0.0)


def judged(candidate: Found, trials: float) -> Found:
    if candidate is not None:
        candidate.log_p = log_tail(candidate.gain, trials)
    return candidate


def plain_temperature(parts: Sequence[Part]) -> Part | None:
    """The part that says that the temperature is felt at once; None when there is none."""
    return next(
        (part for part in parts if part.kind == "temperature" and not part.shape.get("lag_s")), None
    )


def replacing(
    bench: Bench, parts: Sequence[Part], fit: Fit, kind: str, old: Part
) -> Candidate | None:
    """The best candidate of a kind in place of a part of the model; its gain is over the model with
    that part."""
    rest = [part for part in parts if part is not old]
    shapes = [
        shape
        for shape in shapes_of(table.find(kind), bench.recording)
        if kind != "temperature" or shape["lag_s"] > 0
    ]
    without = bench.fit(rest)
    found = thermal(bench, rest, without, kind, shapes)
    if found:
        found.gain += without.log_likelihood - fit.log_likelihood
        found.replaces = (old,)
    return found


def on_temperature(bench: Bench, parts: Sequence[Part], fit: Fit) -> Iterator[Candidate | None]:
    """Temperature and what may be mistaken for it: alone, or in place of or beside one that the
    model has."""
    kinds, plain = [part.kind for part in parts], plain_temperature(parts)
    if plain:
        yield judged(
            replacing(bench, parts, fit, "temperature", plain),
            TRIES.of_column["temperature beside"],
        )
    elif "temperature" not in kinds:
        yield judged(thermal(bench, parts, fit, "temperature"), TRIES.of_column["temperature"])
    if "temperature_squared" not in kinds:
        yield judged(
            thermal(bench, parts, fit, "temperature_squared"),
            TRIES.of_column["temperature_squared"],
        )
    if "temperature_hysteresis" not in kinds:
        beside = thermal(bench, parts, fit, "temperature_hysteresis")
        instead = replacing(bench, parts, fit, "temperature_hysteresis", plain) if plain else None
        better = instead and (not beside or instead.gain > beside.gain - CHANCE.tell_apart)
        yield judged(
            instead if better else beside,
            TRIES.of_column["temperature_hysteresis"],
        )


def in_the_noise(bench: Bench, parts: Sequence[Part], blocks: Blocks) -> Candidate:
    """White noise that goes with the temperature. A level that moves for other reasons too must not
    pass for it, so the gain is divided by what stays restless."""
    relative, gain = modulation.best_growth(parts, bench.recording, blocks)
    part = Part("temperature_noise", {"relative_per_degC": relative, "curvature_per_degC2": 0.0})
    variance = changes.fit(
        blocks, modulation.variance_shapes([*parts, part], bench.recording, blocks)
    )[1]
    return judged(
        Candidate(
            part.kind, part, gain / changes.restless(blocks.energy / variance, blocks.length), 0.0
        ),
        TRIES.of_column["temperature_noise"],
    )


class NoiseScan:
    """Gains of a column in the variance of the white noise, beside what the parts say of it."""

    def __init__(self, bench: Bench, parts: Sequence[Part], blocks: Blocks, name: str) -> None:
        self.recording, self.blocks, self.name = bench.recording, blocks, name
        self.rows = modulation.variance_shapes(parts, bench.recording, blocks)
        _, self.before, self.without = changes.fit(blocks, self.rows)
        x = columns.still(bench.recording, name)
        self.low, self.high = float(x.min()), float(x.max())

    def part(self, origin: float, power: float) -> Part:
        """The reference is the value that is farthest from the origin."""
        far = self.high if self.high - origin > origin - self.low else self.low
        shape = {"column": self.name, "origin": origin, "reference": far, "power": power}
        return Part("noise_follows", shape)

    def fitted(self, part: Part) -> tuple[Floats, float]:
        """(variance, likelihood gained) with the part."""
        row = modulation.variance_shapes([part], self.recording, self.blocks)[1]
        _, variance, likelihood = changes.fit(self.blocks, np.vstack([self.rows, row]))
        return variance, likelihood - self.without

    def best(self) -> Candidate:
        """Neither a touch nor a level that moves for other reasons must pass for it."""
        tried = [
            self.part(origin, power)
            for origin in {0.0, self.low, self.high}
            for power in COLUMN.powers
            if not self.low < origin < self.high
        ]
        part = max(tried, key=lambda one: self.fitted(one)[1])
        if self.fitted(part)[1] > SEARCH.certain:
            part = self.finer(part)
        variance = self.fitted(part)[0]
        gain = changes.steady_gain(self.blocks, self.before, variance) / changes.restless(
            self.blocks.energy / variance, self.blocks.length
        )
        return Candidate("noise_follows", part, gain, 0.0)

    def finer(self, part: Part) -> Part:
        """The part with its origin, outside of the column, and its power at their best."""
        span = self.high - self.low
        above = part.shape["origin"] >= self.high

        def moved(x: Floats) -> Part:
            origin = (self.high + span * abs(x[0])) if above else (self.low - span * abs(x[0]))
            return self.part(float(origin), float(np.clip(np.exp(x[1]), 0.5, 8.0)))

        away = part.shape["origin"] - (self.high if above else self.low)
        start = np.array([abs(away) / span, np.log(part.shape["power"])])
        found = scipy.optimize.minimize(
            lambda x: -self.fitted(moved(x))[1],
            start,
            method="Nelder-Mead",
            options={
                "maxfev": 80,
                "xatol": 0.01,
                "fatol": 0.5,
                "initial_simplex": start + np.array([[0, 0], [0.5, 0], [0, 0.3]]),
            },
        )
        return moved(found.x)


def noise_following(
    bench: Bench, parts: Sequence[Part], blocks: Blocks, gyro: str | None
) -> list[Candidate]:
    """White noise that goes with a logged column, the best shape of each. Not with another axis,
    whose noise has the same cause."""
    names = [
        name
        for name in columns.may_follow(bench.recording, gyro)
        if not name.startswith("gyro_") and np.ptp(columns.still(bench.recording, name)) > 0
    ]
    found = [NoiseScan(bench, parts, blocks, name).best() for name in names]
    found = [judged(one, TRIES.of_column["noise_follows"] * len(names)) for one in found]
    return sorted(found, key=lambda one: one.log_p - 1e-9 * one.gain)


def following(bench: Bench, parts: Sequence[Part], fit: Fit, gyro: str | None) -> list[Candidate]:
    """Every other logged column that the model does not follow yet, best lag and form of each."""
    known = [part.shape["column"] for part in parts if part.kind == "follows"]
    names = [name for name in columns.may_follow(bench.recording, gyro) if name not in known]
    effect, found = table.find("follows"), []
    for name in names:
        lags = (
            (0.0,) if name.startswith("gyro_") else columns.lags(bench.recording)
        )  # axes that are askew leak at once
        tried = [
            Part("follows", {"column": name, "lag_s": lag}, form)
            for lag in lags
            for form in effect.forms
        ]
        part, full = best_of(bench, parts, fit, tried, (name,))
        at_once = tried[0]
        other = full if part.key == at_once.key else bench.fit([*parts, at_once], near=fit.level)
        part, full = (
            (at_once, other)
            if other.log_likelihood
            > full.log_likelihood - (CHANCE.tell_apart if part.shape["lag_s"] else 0.0)
            else (part, full)
        )
        one = Candidate("follows", part, full.log_likelihood - fit.log_likelihood, 0.0)
        for shape in (part, at_once):
            bench.forget(shape)
        found.append(judged(one, TRIES.of_column["follows"] * len(names)))
    return sorted(found, key=lambda one: one.log_p - 1e-9 * one.gain)


def tried(
    bench: Bench, parts: Sequence[Part], fit: Fit, gyro: str | None, blocks: Blocks | None = None
) -> list[Candidate]:
    """Candidates on the logged columns, of `follows` one per column. gyro: the column of the
    model."""
    found = following(bench, parts, fit, gyro)
    unsteady = bench.counts is not None and bench.counts.unsteady
    if not unsteady and all(part.kind != "noise_follows" for part in parts):
        blocks = blocks or bench.blocks(parts, fit)
        found += noise_following(bench, parts, blocks, gyro)[:1]
    if "temp_degC" in bench.recording.columns and np.ptp(bench.recording.columns["temp_degC"]) > 0:
        found += [one for one in on_temperature(bench, parts, fit) if one]
        if all(part.kind != "temperature_noise" for part in parts):
            blocks = blocks or bench.blocks(parts, fit)
            found.append(in_the_noise(bench, parts, blocks))
    return found
