"""Is a logged column no more than the white noise of its own sensor? Such a column cannot explain
anything (DESIGN 4)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording
from ..distributions import f_sf
from ..effects.base import needed
from ..inference import modulation
from ..inference.parts import Bench, Part
from ..thresholds import CAUSE, CHANCE
from .common_cause import sensor_noise

SQUARES = ("vibration_noise", "vibration_rectification")


def names_of(recording: Recording, part: Part) -> list[str]:
    """The columns that an effect is worked out of; none for one that needs no column."""
    if "column" in part.shape:
        return [part.shape["column"]]
    if "accel" in part.effect.needs and "axis" in part.shape:
        return [f"accel_{part.shape['axis']}_g"]
    return [name for name in recording.columns if name.startswith(part.effect.needs)]


def doubt(bench: Bench, parts: Sequence[Part], part: Part) -> str:
    """A sentence if the columns of the part are their own noise; otherwise ""."""
    names = names_of(bench.recording, part)
    if part.role not in ("mean", "variance") or not names or more(bench, parts, part, names):
        return ""
    return (
        f"the power of {' and '.join(names)} is not above the white noise of the sensor itself, "
        "which cannot act on the gyro. Record while this quantity changes"
    )


def more(bench: Bench, parts: Sequence[Part], part: Part, names: Sequence[str]) -> bool:
    """Does one of the columns have more power, in any octave, than the white noise of its sensor?
    For effects of vibration, its square is compared with the square of the noise, for these
    parts."""
    recording = bench.recording
    if part.kind in SQUARES:
        quiet = replace(
            recording,
            columns=recording.columns | {name: noise(recording, name) for name in names},
            measured={},
        )
        true, own = (square(bench, one, parts, part) for one in (recording, quiet))
        return louder(true, own)
    return any(moves(recording, name) for name in names)


def moves(recording: Recording, name: str) -> bool:
    """Does a column have more power than its own noise? Computed once for each column."""
    key = ("moves", name)
    if key not in recording.measured:
        recording.measured[key] = louder(recording.column(name), noise(recording, name))
    return bool(recording.measured[key])


def louder(x: Floats, own: Floats) -> bool:
    """Does x have significantly more power than its own noise in any octave, and more than the
    error of the level of the noise?"""
    true, noise_of = octaves(x), octaves(own)
    return any(
        one > CAUSE.own_noise_most * other
        and f_sf(one / max(CAUSE.own_noise_most * other, 1e-300), count, count) * len(true)
        < CHANCE.family_wise
        for (one, count), (other, _) in zip(true, noise_of)
    )


def noise(recording: Recording, name: str) -> Floats:
    """White noise of the level of the column's own sensor: that of half of the frequencies or of
    the quietest seconds, whichever is lower. Seeded."""
    x = recording.column(name)
    logged = levels(x - x.mean(), recording.rate_hz)
    white: Floats = np.random.default_rng(0).standard_normal(recording.samples)
    white *= np.sqrt(min(a / b for a, b in zip(logged, levels(white, recording.rate_hz))))
    return white


def levels(x: Floats, rate_hz: float) -> tuple[float, float]:
    """Two levels of the noise of a record."""
    return middle(x), sensor_noise(x, rate_hz)


def middle(x: Floats) -> float:
    """The median power of an ordinate."""
    power = signals.transform(x)[1:]
    power *= power
    return float(np.median(power, overwrite_input=True))


def square(bench: Bench, recording: Recording, parts: Sequence[Part], part: Part) -> Floats:
    """The mean square of the vibration of a recording over a second or two, whatever the form."""
    if part.role == "variance":
        blocks = bench.blocks(parts, bench.fit(parts))
        plain = replace(part, form="raw")
        found: Floats = modulation.variance_shapes([plain], recording, blocks)[-1]
        return found
    return needed(part.effect.regressor)(recording, part.shape)


def octaves(x: Floats) -> list[tuple[float, int]]:
    """(mean power of the ordinates, their number) per octave."""
    power = signals.transform(x - x.mean(), spare=True)[1:]
    power *= power
    edges = np.unique(np.minimum(2 ** np.arange(2, 64, dtype=float), len(power)).astype(int))
    edges = np.concatenate([[0], edges])
    return [(float(power[low:high].mean()), int(high - low)) for low, high in zip(edges, edges[1:])]
