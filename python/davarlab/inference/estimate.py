"""Parameters of a fitted model in the units of the model file, with 95 % intervals from the joint
curvature (DESIGN 3)."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy import linalg

from ..arrays import Floats
from ..data.events import Shocks
from ..data.recording import Recording
from ..distributions import chi2_ppf
from ..effects import table
from ..effects.device import filter_of
from ..thresholds import CHANCE, FIT
from . import changes, modulation
from .changes import Blocks
from .parts import Bench, Part
from .refine import numeric_shapes, turns
from .whittle import Fit, size_covariance


@dataclass
class Estimate:
    """A parameter with its 95 % interval. low, high None: it has none, because it is a word or was
    taken as it is, or, when `undetermined`, because the record says next to nothing about it."""

    value: float | str
    low: float | None = None
    high: float | None = None
    undetermined: bool = False

    @property
    def number(self) -> float:
        """The value of a parameter that is no word."""
        return cast(float, self.value)


Entry = dict[str, Estimate]  # of a part, by the name of the parameter


def as_shown(entries: Sequence[Entry], adequate: bool) -> list[Entry]:
    """Without intervals where the model fails: they assume that it fits."""
    if adequate:
        return list(entries)
    return [{name: Estimate(one.value) for name, one in entry.items()} for entry in entries]


def superfluous(kind: str, entry: Entry) -> bool:
    """Does the interval of an effect contain its absence."""
    effect = table.find(kind)
    sizes = [effect.size.name] if effect.sized else effect.shape_names
    there = [entry[name] for name in sizes if name in entry]
    if not there or effect.role == "filter":
        return False
    return all(contains(one, effect.nothing) for one in there)


def contains(size: Estimate, nothing: float) -> bool:
    """May a size be that of an absent effect."""
    if size.low is None or size.high is None:
        return size.undetermined and size.value == nothing
    return size.low <= nothing <= size.high


Place = tuple[int, str]  # of a shape: index of its part, name


def vector_likelihood(
    bench: Bench, parts: Sequence[Part], sizes: Floats, coefficients: Floats
) -> float:
    """Log-likelihood with every parameter given."""
    data, keys = bench.data, bench.all_keys(parts)
    level = np.maximum(bench.rows(parts).T @ sizes + bench.fixed(parts), 1e-30)
    energy = data.product("gyro", "gyro").copy()
    for i, a in enumerate(keys):
        energy -= 2 * coefficients[i] * data.product("gyro", a)
        for j, b in enumerate(keys):
            energy += coefficients[i] * coefficients[j] * data.product(a, b)
    return -0.5 * float(np.sum(data.counts * np.log(level) + np.maximum(energy, 0) / level))


def with_shapes(parts: Sequence[Part], moves: Iterable[tuple[Place, float]]) -> list[Part]:
    parts = list(parts)
    for (index, name), factor in moves:
        parts[index] = parts[index].moved(name, parts[index].shape[name] * float(np.exp(factor)))
    return parts


def curvature(function: Callable[[Floats], float], steps: Floats) -> Floats:
    """Minus the Hessian of `function` at 0."""
    count, centre = len(steps), function(np.zeros(len(steps)))
    unit = np.diag(steps)
    single = [(function(unit[i]), function(-unit[i])) for i in range(count)]
    hessian = np.zeros((count, count))
    for i in range(count):
        hessian[i, i] = (single[i][0] + single[i][1] - 2 * centre) / steps[i] ** 2
        for j in range(i):
            both = function(unit[i] + unit[j]) + function(-unit[i] - unit[j])
            cross = both + 2 * centre - sum(single[i]) - sum(single[j])
            hessian[i, j] = hessian[j, i] = cross / (2 * steps[i] * steps[j])
    return -hessian


def standard_errors(
    bench: Bench, parts: Sequence[Part], fit: Fit
) -> tuple[Floats, dict[Place, float], Floats]:
    """Of log sizes, log shapes, and coefficients (absolute), jointly. Sizes at zero are left out
    (infinite)."""
    places = [(i, name) for i, part in enumerate(parts) for name in numeric_shapes(part)]
    live = np.flatnonzero(fit.sizes > 0)
    own = (
        np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
        if len(fit.coefficients)
        else np.zeros(0)
    )
    steps = np.concatenate(
        [np.full(len(live), 0.05), [shape_step(bench, parts[i]) for i, _ in places], own]
    )

    tried = {}

    def at(x: Floats) -> float:
        sizes = fit.sizes.copy()
        sizes[live] *= np.exp(x[: len(live)])
        moved = with_shapes(parts, zip(places, x[len(live) : len(live) + len(places)]))
        tried.update(
            {
                part.key: part
                for part, old in zip(moved, parts)
                if part != old and part.effect.regressor
            }
        )
        return vector_likelihood(
            bench, moved, sizes, fit.coefficients + x[len(live) + len(places) :]
        )

    matrix = curvature(at, steps)
    for part in tried.values():
        bench.forget(part)
    scale = 1 / np.sqrt(np.maximum(np.abs(np.diag(matrix)), 1e-30))
    inverse = linalg.pinvh(matrix * np.outer(scale, scale), rtol=1e-8) * np.outer(scale, scale)
    errors = np.sqrt(np.maximum(np.diag(inverse), 0))
    sizes = np.full(len(fit.sizes), np.inf)
    passed = np.zeros(len(fit.sizes))  # noise that the filter has passed; sizes are powers
    spectra = [part for part in parts if part.role == "spectrum"]
    passed[: max(len(spectra), 1)] = [part.effect.in_front for part in spectra] or [True]
    sizes[live] = np.hypot(errors[: len(live)], 2 * filter_level(bench, parts) * passed[live])
    return (
        sizes,
        dict(zip(places, errors[len(live) : len(live) + len(places)])),
        errors[len(live) + len(places) :],
    )


def filter_level(bench: Bench, parts: Sequence[Part]) -> float:
    """Relative standard error of the angle random walk in front of filters that were learned."""
    responses = [part.any_response for part in parts if part.any_response]
    levels = [filter_of(response, bench.data.rate_hz).level for response in responses]
    return float(np.linalg.norm(levels))


def shape_step(bench: Bench, part: Part) -> float:
    if part.kind == "sinusoid":
        return 0.1 / turns(bench, part)
    return 0.03


def interval(value: float, error: float, relative: bool) -> Estimate:
    value, reach = float(value), CHANCE.normal_95 * error
    if (
        not np.isfinite(value)
        or not np.isfinite(reach)
        or reach <= 0
        or relative
        and reach > np.log(FIT.vague_factor)
    ):
        return Estimate(value, undetermined=True)
    if relative:
        low, high = sorted((float(value * np.exp(-reach)), float(value * np.exp(reach))))
        return Estimate(value, low, high)
    return Estimate(value, float(value - reach), float(value + reach))


def wider(one: Entry, two: Entry) -> Entry:
    """Estimates of `one`, with intervals that hold those of `two` too: of the same parameters, the
    model put in another way."""
    return {name: widened(estimate, two[name]) for name, estimate in one.items()}


def widened(one: Estimate, two: Estimate) -> Estimate:
    if one.low is None or one.high is None or two.low is None or two.high is None:
        return one
    return Estimate(one.value, min(one.low, two.low), max(one.high, two.high))


def of_share(one: Estimate, share: float) -> Estimate:
    """An estimate from this share of the samples, the rest drawn: what is drawn says nothing, so
    the interval is that of all samples, wider by the square root of their ratio (12.4)."""
    if one.low is None or one.high is None or share == 1:
        return one
    times, value = 1 / np.sqrt(share), one.number
    if one.low > 0:
        ends = [value * (end / value) ** times for end in (one.low, one.high)]
    else:
        ends = [value + (end - value) * times for end in (one.low, one.high)]
    return Estimate(value, float(ends[0]), float(ends[1]))


def spectrum_estimate(scale: float, size: float, error: float, bound: float) -> Estimate:
    """`bound`: standard error of the size itself, for one that is fitted as nothing."""
    if size <= 0:
        return (
            Estimate(0.0, 0.0, float(np.sqrt(CHANCE.normal_95 * bound)) / scale)
            if np.isfinite(bound)
            else Estimate(0.0, undetermined=True)
        )
    return interval(np.sqrt(size) / scale, error / 2, True)


def mean_estimates(
    bench: Bench, part: Part, keys: Sequence[str], values: Floats, errors: Floats
) -> Estimate:
    scales = np.array([bench.data.scale(key) or np.inf for key in keys])
    values, errors = values / scales, errors / scales
    if part.turning:
        size = float(np.hypot(*values))
        return interval(
            size, float(np.sqrt(np.sum((values * errors) ** 2)) / max(size, 1e-300)), False
        )
    return interval(values[0] / part.effect.size.scale, errors[0] / part.effect.size.scale, False)


def all_estimates(
    bench: Bench,
    parts: Sequence[Part],
    fit: Fit,
    blocks: Blocks | None = None,
    shocks: Shocks | None = None,
) -> list[Entry]:
    """One dictionary name -> Estimate per part, in the order of the parts."""
    size_errors, shape_errors, coefficient_errors = standard_errors(bench, parts, fit)
    found, s, c = [], 0, 0
    behind = max(1, sum(part.role == "spectrum" for part in parts))
    dynamic = dynamic_estimates(bench, parts, fit, blocks)
    bounds = np.sqrt(np.diag(size_covariance(bench.data, bench.rows(parts), fit.level)))
    for index, part in enumerate(parts):
        entry = {}
        if part.role == "spectrum":
            entry[part.effect.size.name] = spectrum_estimate(
                part.effect.size.scale, fit.sizes[s], size_errors[s], bounds[s]
            )
            s += 1
        elif part.role == "mean":
            keys = bench.keys(part)
            entry[part.effect.size.name] = mean_estimates(
                bench,
                part,
                keys,
                fit.coefficients[c : c + len(keys)],
                coefficient_errors[c : c + len(keys)],
            )
            c += len(keys)
        elif part.behind:
            entry[part.behind] = spectrum_estimate(
                1.0, fit.sizes[behind], size_errors[behind], bounds[behind]
            )
            behind += 1
        elif part.kind == "shocks":
            assert shocks is not None  # cut out of the record before the fit
            entry = shock_estimates(shocks, bench.recording)
        for name, value in part.effect.said(part.shape).items():
            error = shape_errors.get((index, name))
            entry[name] = Estimate(value) if error is None else interval(value, error, True)
        entry.update(instants(bench, part, entry, fit.level))
        entry.update(dynamic.get(part.kind, {}))
        if part.form == "decoded":
            entry[part.effect.size.name] = of_levels(
                entry[part.effect.size.name], bench.decoded[part.key], bench.squares[part.key]
            )
            switches = max(
                2.0, bench.recording.samples / bench.recording.rate_hz / part.shape["mean_dwell_s"]
            )
            entry["mean_dwell_s"] = interval(
                part.shape["mean_dwell_s"], 1 / np.sqrt(switches), True
            )
        found.append(entry)
    return found


def instants(bench: Bench, part: Part, entry: Entry, level: Floats) -> Entry:
    """When a step was, when a line came and went, and its frequency; nothing of other parts."""
    span = bench.recording.samples / bench.recording.rate_hz
    if part.kind == "bias_step":
        return {
            "time_s": instant(bench, part.shape["time_s"], entry["step_dps"].number ** 2, level)
        }
    if part.kind != "intermittent_line":
        return {}
    frequency, power = part.shape["frequency_hz"], entry["amplitude_dps"].number ** 2
    noise = np.interp(np.log(frequency), np.log(bench.data.f_bin), level)
    found = {
        name: instant(bench, min(part.shape[name], span), power / 2, level, frequency)
        for name in ("start_s", "stop_s")
    }
    seconds = max(found["stop_s"].number - found["start_s"].number, 1 / bench.recording.rate_hz)
    error = np.sqrt(6 * noise / max(power * seconds * bench.recording.rate_hz, 1e-300)) / (
        np.pi * seconds
    )  # Cramer and Rao
    return {**found, "frequency_hz": interval(frequency, min(float(error), frequency), False)}


def instant(
    bench: Bench, time_s: float, power: float, level: Floats, frequency: float | None = None
) -> Estimate:
    """A change of that power in the noise: by the noise of single samples, as it is at its
    frequency or over the time in doubt, the likeliest place moves by CHANGE_DOUBT noise / power
    samples in 95 of 100 cases."""
    reach = 1 / bench.recording.rate_hz
    for _ in range(5):
        noise = np.interp(np.log(frequency or 0.5 / reach), np.log(bench.data.f_bin), level)
        reach = max(
            1 / bench.recording.rate_hz,
            float(FIT.change_doubt * noise / max(power, 1e-300) / bench.recording.rate_hz),
        )
    return Estimate(
        time_s,
        max(0.0, time_s - reach),
        min(time_s + reach, bench.recording.samples / bench.recording.rate_hz),
    )


def dynamic_estimates(
    bench: Bench, parts: Sequence[Part], fit: Fit, blocks: Blocks | None
) -> dict[str, Entry]:
    """White level and what modulates it, from the energies of blocks."""
    dynamic = [part for part in parts if part.role == "variance"]
    if not dynamic:
        return {}
    blocks = blocks or bench.blocks(parts, fit)
    rows = modulation.variance_shapes(parts, bench.recording, blocks)
    sizes, variance, _ = changes.fit(blocks, rows)
    errors = np.sqrt(np.diag(changes.size_covariance(blocks, rows, variance)))
    white_index = next(
        (
            i
            for i, p in enumerate(q for q in parts if q.role == "spectrum")
            if p.kind == "angle_random_walk"
        ),
        0,
    )
    share = float(np.average(modulation.white_share(bench, parts, fit), weights=bench.data.counts))
    share = max(share, 1e-6)
    quiet = sizes[0] / variance.mean()
    share = (
        share if quiet > 1 - share else 1.0
    )  # where nothing white would be left, all of it counts as white
    sizes, errors = (
        sizes / variance.mean() / share,
        np.minimum(errors / variance.mean() / share, 1e6),
    )  # of the white noise, mean 1
    sizes[0] = max(
        sizes[0] - (1 / share - 1), 1e-9
    )  # the rest of the spectrum is in the blocks too, and constant
    level = fit.sizes[white_index]  # (deg/s)^2/Hz, mean
    found = {
        "angle_random_walk": {
            "coefficient_deg_per_sqrt_h": interval(
                60 * np.sqrt(level * sizes[0]), errors[0] / sizes[0] / 2, True
            )
        }
    } | growth_estimates(dynamic, bench.recording, blocks, share)
    order = [part for part in parts if modulation.adds(part)]
    for part, size, error in zip(order, sizes[1:], errors[1:]):
        kind = part.kind
        if kind != "noise_step":
            white = level * bench.recording.rate_hz
            found[kind] = {
                part.effect.size.name: interval(np.sqrt(size * white), error / size / 2, True)
                if size > 0
                else Estimate(0.0, 0.0, float(np.sqrt(CHANCE.normal_95 * error * white)))
            }
        if kind == "noise_step":
            ratio = np.sqrt(1 + size / sizes[0])
            found[kind] = {
                "ratio": interval(
                    ratio,
                    (error / sizes[0] + size * errors[0] / sizes[0] ** 2) / (2 * ratio**2),
                    True,
                )
            } | ends(dynamic, blocks, ratio)
    return found


def ends(parts: Sequence[Part], blocks: Blocks, ratio: float) -> Entry:
    """Where a noise step begins and stops: within a block, and within what the likelihood of a
    block on the wrong side leaves open."""
    part = next(part for part in parts if part.kind == "noise_step")
    nats = 0.5 * blocks.length * abs(ratio**2 - 1 - 2 * np.log(max(ratio, 1e-3)))
    reach = blocks.period_s * (0.5 + 3 / max(nats, 1e-3))
    return {
        name: Estimate(
            part.shape[name], float(part.shape[name] - reach), float(part.shape[name] + reach)
        )
        for name in ("start_s", "stop_s")
    }


def growth_estimates(
    parts: Sequence[Part], recording: Recording, blocks: Blocks, share: float
) -> dict[str, Entry]:
    """Of temperature_noise: the energies of the blocks know it as far as the spectrum is white."""
    part = next((one for one in parts if one.kind == "temperature_noise"), None)
    warm = modulation.block_temperature(recording, blocks) if part else np.zeros(1)
    if part is None or np.ptp(warm) <= 0:
        return {}
    names = list(part.effect.said(part.shape))  # without a curvature of 0
    powers = np.array([warm, warm**2])[: len(names)]
    design = powers - powers.mean(axis=1, keepdims=True)
    errors = np.sqrt(np.diag(np.linalg.pinv(2 * blocks.length * design @ design.T)))
    return {
        part.kind: {
            name: interval(part.shape[name] / share, error / share, False)
            for name, error in zip(names, errors)
        }
    }


def of_levels(estimate: Estimate, course: Floats, square: float) -> Estimate:
    """The size of levels where the column is their posterior mean: sum(y m) / (n square), the
    maximum of the chain's likelihood, for the sum(y m) / sum(m^2) of least squares (6.4). square:
    mean of the squared state, 1 of two levels."""
    factor = float(np.mean(course**2)) / square
    if estimate.low is None or estimate.high is None:
        return estimate
    return Estimate(estimate.number * factor, estimate.low * factor, estimate.high * factor)


def shock_estimates(shocks: Shocks, recording: Recording) -> Entry:
    hours = recording.samples / recording.rate_hz / 3600
    low, high = (
        chi2_ppf(0.025, 2 * shocks.count) / 2,
        chi2_ppf(0.975, 2 * shocks.count + 2) / 2,
    )
    amplitude = shocks.amplitude_dps
    return {
        "amplitude_dps": Estimate(
            amplitude, amplitude - 1.96 * shocks.error_dps, amplitude + 1.96 * shocks.error_dps
        ),
        "rate_per_hour": Estimate(shocks.count / hours, low / hours, high / hours),
    }
