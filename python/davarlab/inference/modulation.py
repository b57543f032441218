"""White noise whose level changes while the rest of the spectrum does not: what that does to the
whitened residual (DESIGN 5)."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import scipy

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording
from ..effects import columns
from ..effects.base import Values, needed
from ..effects.changes import vibration_square
from ..thresholds import CHANCE, CHANGE
from . import changes
from .changes import Blocks
from .parts import Bench, Part
from .whittle import Fit


def adds(part: Part) -> bool:
    """Does an effect add to the variance of the blocks, a row of its own."""
    return part.role == "variance" and part.effect.sized


def variance_shapes(parts: Sequence[Part], recording: Recording, blocks: Blocks) -> Floats:
    """Rows of the variance of the blocks that the parts say: the white noise first, constant or as
    the temperature has it."""
    rows = [white_growth(parts, recording, blocks)]
    for part in parts:
        if part.kind == "vibration_noise":
            rows.append(
                part.effect.variants.get(part.form, vibration_square)(
                    recording, part.shape["axis"], blocks
                )
            )
        elif part.kind == "noise_follows":
            rows.append(added_variance(recording, part.shape, blocks))
        elif part.kind == "noise_step":
            time = (np.arange(len(blocks.energy)) + 0.5) * blocks.period_s
            rows.append(
                ((time >= part.shape["start_s"]) & (time < part.shape["stop_s"])).astype(float)
            )
        elif adds(part):
            rows.append(own_variance(recording, part, blocks))
    return np.array(rows)


def white_growth(parts: Sequence[Part], recording: Recording, blocks: Blocks) -> Floats:
    """The variance of the white noise per block, 1 at the mean temperature (5.5)."""
    found = np.ones(len(blocks.energy))
    for part in parts:
        if part.kind == "temperature_noise":
            found *= columns.growth(block_temperature(recording, blocks), part.shape) ** 2
    return found


def added_variance(recording: Recording, shape: Values, blocks: Blocks) -> Floats:
    """The mean over each block of what a column adds, from some of its samples."""
    key = ("noise course", shape["column"], blocks.length)
    if key not in recording.measured:
        x, count = columns.still(recording, shape["column"]), len(blocks.energy)
        rows = x[: count * blocks.length].reshape(count, blocks.length)
        recording.measured[key] = rows[:, :: max(1, blocks.length // CHANGE.block_samples)]
    found: Floats = columns.added_variance(recording.measured[key], shape).mean(axis=1)
    return found


def own_variance(recording: Recording, part: Part, blocks: Blocks) -> Floats:
    """The mean square over each block of what an effect of one's own says, worked out once."""
    key = ("own noise", part.key, blocks.length)
    deviation = needed(part.effect.variants.get(part.form, part.effect.regressor))
    code, found = recording.measured.get(key, (None, None))
    if code is not deviation:  # its author may have changed it
        found = block_means(deviation(recording, part.shape) ** 2, blocks)
        recording.measured[key] = deviation, found
    course: Floats = found
    return course


def block_means(x: Floats, blocks: Blocks) -> Floats:
    count = len(blocks.energy)
    found: Floats = x[: count * blocks.length].reshape(count, blocks.length).mean(axis=1)
    return found


def block_temperature(recording: Recording, blocks: Blocks) -> Floats:
    """Of each block, from the mean of the record, degC."""
    slow = columns.slow_temperature(recording)
    found: Floats = block_means(slow, blocks) - slow.mean()
    return found


def changing(parts: Sequence[Part]) -> bool:
    """May the parts let the white level change."""
    return any(part.role == "variance" for part in parts)


def constant(rows: Floats) -> bool:
    """Does nothing change the white level."""
    return len(rows) == 1 and np.ptp(rows[0]) == 0


def growth_loss(
    parts: Sequence[Part], recording: Recording, blocks: Blocks
) -> tuple[Callable[[Floats], float], float]:
    """(minus the log-likelihood of the blocks with noise that grows by so much, linear and
    quadratic, over the range of the temperature, in place of the parts' own; that range, degC)."""
    others = [part for part in parts if part.kind != "temperature_noise"]
    rows = variance_shapes(others, recording, blocks)
    warm = block_temperature(recording, blocks)
    span = float(np.ptp(warm))

    def loss(grown: Floats) -> float:
        factor = columns.growth(warm, growth_shape(grown, span)) ** 2
        return -changes.fit(blocks, np.vstack([rows[:1] * factor, rows[1:]]))[2]

    return loss, span


def growth_shape(grown: Floats, span: float) -> Values:
    """temperature_noise that grows by so much over a range of temperature."""
    return {
        "relative_per_degC": float(grown[0]) / span,
        "curvature_per_degC2": float(grown[1]) / span**2,
    }


def best_growth(parts: Sequence[Part], recording: Recording, blocks: Blocks) -> tuple[float, float]:
    """The exponent of temperature_noise without curvature, of the parts' own or beside them, at the
    maximum of the likelihood of the blocks: (relative_per_degC, gain over none)."""
    loss, span = growth_loss(parts, recording, blocks)
    if span <= 0:
        return 0.0, 0.0

    def straight(grown: float) -> float:
        return loss(np.array([grown, 0.0]))

    tried = np.linspace(-CHANGE.growth_most, CHANGE.growth_most, 17)
    best = int(np.argmin([straight(grown) for grown in tried]))
    found = scipy.optimize.minimize_scalar(
        straight,
        bounds=(tried[max(best - 1, 0)], tried[min(best + 1, 16)]),
        method="bounded",
        options={"xatol": 1e-4 * CHANGE.growth_most},
    )
    return float(found.x) / span, float(straight(0.0) - found.fun)


def bent_growth(parts: Sequence[Part], recording: Recording, blocks: Blocks) -> Values:
    """The shape of temperature_noise; with a curvature where the record shows one (5.5)."""
    relative, gain = best_growth(parts, recording, blocks)
    loss, span = growth_loss(parts, recording, blocks)
    if span <= 0:
        return {"relative_per_degC": relative, "curvature_per_degC2": 0.0}
    first = np.array([relative * span, 0.0])
    options = {"initial_simplex": first + CHANGE.growth_simplex, "xatol": 1e-3, "fatol": 1e-2}
    found = scipy.optimize.minimize(loss, first, method="Nelder-Mead", options=options)
    bends = loss(np.zeros(2)) - gain - found.fun > CHANCE.bend
    return growth_shape(found.x if bends else first, span)


def regrown(bench: Bench, parts: list[Part], fit: Fit) -> list[Part]:
    """The parts with the law of temperature_noise refitted."""
    if not any(part.kind == "temperature_noise" for part in parts):
        return parts
    shape = bent_growth(parts, bench.recording, bench.blocks(parts, fit))
    return [
        replace(part, shape=shape) if part.kind == "temperature_noise" else part for part in parts
    ]


def white_share(bench: Bench, parts: Sequence[Part], fit: Fit) -> Floats:
    """The share of the sensor's white noise in the fitted spectrum, per bin."""
    noise = [part for part in parts if part.role == "spectrum"]
    if not noise:
        return np.ones_like(fit.level)
    rows = bench.rows(parts)
    white = [i for i, part in enumerate(noise) if part.kind == "angle_random_walk"]
    return np.clip(
        (
            sum((fit.sizes[i] * rows[i] for i in white), np.zeros_like(fit.level))
            + bench.fixed(parts)
        )
        / fit.level,
        0,
        1,
    )


def local(variance: Floats, share: Floats | float, mean: float) -> Floats:
    """Variance of the whitened residual where the white noise has this share; `variance`: that of
    all ordinates together (5.2)."""
    return np.maximum(1 + share / max(mean, 1e-6) * (variance - 1), 0.05)


def levelled(c: Floats, variance: Floats, share: Floats) -> Floats:
    """Whitened ordinates with the change of the white level divided out, in each frequency as far
    as it is white."""
    mean, out = share.mean(), np.zeros_like(c)
    groups = np.minimum((share * CHANGE.share_groups).astype(int), CHANGE.share_groups - 1)
    for group in np.unique(groups):
        chosen = groups == group
        x = signals.in_time(np.where(chosen, c, 0.0))
        out += signals.transform(x / np.sqrt(local(variance, share[chosen].mean(), mean)))[1:]
    return out


def dispersion(bench: Bench, share: Floats, variance: Floats) -> Floats:
    """How much more than chi-square the energy of each bin scatters: mean of the squared local
    variance over its squared mean (5.3)."""
    mean = float(np.sum(share * bench.data.counts) / np.sum(bench.data.counts))
    relative = variance / variance.mean()
    found = []
    for value in share:
        here = local(relative, value, mean)
        found.append(np.mean(here**2) / np.mean(here) ** 2)
    return np.array(found)


def crowding(bench: Bench, share: Floats, variance: Floats) -> Floats:
    """How much more than chi-square a few neighbouring ordinates have together, at most: they go
    with each other where the noise is loud for a while, by its level there over its mean (5.3)."""
    mean = float(np.sum(share * bench.data.counts) / np.sum(bench.data.counts))
    loudest = max(
        np.mean(piece)
        for piece in np.array_split(
            variance / variance.mean(), min(CHANGE.crowded_pieces, len(variance))
        )
    )
    return local(loudest, share, mean)


def discounted(
    gain: float, before: Floats, after: Floats, counts: Floats, scatter: Floats
) -> float:
    """A gain of spectra in the units that it would have if bins scattered as chi-square: weighted
    where the spectra differ (5.3)."""
    weight = counts * np.log(np.maximum(after, 1e-300) / np.maximum(before, 1e-300)) ** 2
    total = float(weight.sum())
    return gain if total <= 0 else gain * total / float(np.sum(weight * scatter))
