"""The Allan deviation of each effect of a fitted model by itself, over the whole record
(DESIGN 8)."""

from collections.abc import Iterable, Sequence

import numpy as np
import scipy

from ..arrays import Floats, Ints
from ..inference import allan, changes, modulation
from ..inference.parts import Bench, Part, spectrum_of
from .state import State

Contribution = tuple[str, Floats, Floats]  # kind, taus in s, deviations in deg/s


def of_spectrum(
    bench: Bench, parts: Sequence[Part], part: Part, size: float, taus: Sequence[int]
) -> Floats:
    filters = [other for other in parts if other.role == "filter"] if part.effect.in_front else []
    spectrum = spectrum_of(
        [part, *filters],
        [size],
        bench.data.rate_hz,
        bench.counts if part.kind == "quantization" else None,
    )
    return np.sqrt(allan.expected(allan.on_grid(spectrum, bench.data.rate_hz), taus))


def of_course(
    bench: Bench, part: Part, coefficients: Iterable[float], taus: Sequence[int]
) -> Floats:
    """A known course: what lib/ measures of it at the octaves, and the curve of a line, or a smooth
    one, through that."""
    course, octaves = np.zeros(len(bench.y)), allan.octaves(len(bench.y) // 2 * 2)
    for key, value, unit in zip(bench.keys(part), coefficients, bench.courses(part)):
        scale = bench.data.scale(key)
        course += value / scale * (unit - unit.mean()) if scale else 0.0
    measured = allan.windows(course, len(course) // 2 * 2, octaves)[0][0]
    if not part.turning:
        return smooth(octaves, measured, taus)
    largest = int(np.argmax(measured))
    lobes = of_line(part.shape["frequency_hz"] / bench.data.rate_hz, np.array(octaves))
    size = float(measured[largest] / lobes[largest])
    return size * of_line(part.shape["frequency_hz"] / bench.data.rate_hz, np.array(taus))


def of_line(nu: float, m: Ints) -> Floats:
    """Of a line of size 1; nu: its frequency over the sample rate. Never quite 0, as a curve over a
    logarithm."""
    found: Floats = np.maximum(
        np.sin(np.pi * nu * m) ** 2 / np.maximum(np.abs(m * np.sin(np.pi * nu)), 1e-30), 1e-15
    )
    return found


def smooth(octaves: Sequence[int], deviations: Floats, taus: Sequence[int]) -> Floats:
    """The smooth curve over a logarithmic axis through the deviations at the octaves, without a new
    extreme between them."""
    if len(octaves) < 2:
        return np.full(len(taus), deviations[0])
    known = np.log(np.maximum(deviations, 1e-30))
    found: Floats = np.exp(
        scipy.interpolate.PchipInterpolator(np.log(octaves), known)(np.log(taus))
    )
    return found


def white_shares(state: State) -> dict[str, float]:
    """kind -> share of the mean white variance that a part whose variance changes adds."""
    changing = [part.kind for part in state.parts if modulation.adds(part)]
    if not changing or state.blocks is None:
        return {}
    rows = modulation.variance_shapes(state.parts, state.bench.recording, state.blocks)
    sizes, variance, _ = changes.fit(state.blocks, rows)
    return {
        kind: size * row.mean() / variance.mean()
        for kind, size, row in zip(changing, sizes[1:], rows[1:])
    }


def of_state(state: State) -> list[Contribution]:
    """(kind, taus in s, deviations in deg/s) of every part that has one; a filter has none. Cost:
    one pass of lib/ per known course."""
    bench, window = state.bench, len(state.bench.y) // 2 * 2
    octaves, taus = allan.octaves(window), allan.drawn(window)
    sizes, coefficients, found, white = (
        iter(state.fit.sizes),
        iter(state.fit.coefficients),
        [],
        None,
    )
    shares = white_shares(state)
    for part in state.parts:
        deviation = None
        if part.role == "spectrum":
            deviation = of_spectrum(bench, state.parts, part, next(sizes), taus)
            white = deviation if part.kind == "angle_random_walk" else white
        elif part.role == "mean":
            deviation = of_course(bench, part, [next(coefficients) for _ in bench.keys(part)], taus)
        elif part.role == "events":
            shocks = allan.windows(state.shocks.raw - state.shocks.clean, window, octaves)[0][0]
            deviation = smooth(octaves, shocks, taus)
        elif part.kind in shares and white is not None:
            deviation = white * np.sqrt(shares[part.kind])
        if deviation is not None:
            found.append((part.kind, np.array(taus) / bench.data.rate_hz, deviation))
    return found
