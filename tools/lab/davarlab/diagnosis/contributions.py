"""The Allan deviation of each effect of a fitted model by itself, over the whole record
(DESIGN 8)."""

from collections.abc import Iterable, Sequence

import numpy as np

from ..arrays import Floats
from ..data.recording import Recording
from ..inference import allan, changes, modulation
from ..inference.parts import Bench, Part, spectrum_of
from ..model import Model
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
    """A known course: what lib/ measures of it."""
    course = np.zeros(len(bench.y))
    for key, value, unit in zip(bench.keys(part), coefficients, bench.courses(part)):
        scale = bench.data.scale(key)
        course += value / scale * (unit - unit.mean()) if scale else 0.0
    measured: Floats = allan.windows(course, len(course) // 2 * 2, taus)[0][0]
    return measured


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


def of_state(state: State, recording: Recording, model: Model) -> list[Contribution]:
    """(kind, taus in s, deviations in deg/s) of every part that has one; a filter has none. Cost:
    one pass of lib/ per known course."""
    bench, y = state.bench, recording.rate_dps(model.column)
    taus = allan.octaves(len(y) // 2 * 2)
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
            deviation = allan.windows(state.shocks.raw - state.shocks.clean, len(y) // 2 * 2, taus)[
                0
            ][0]
        elif part.kind in shares and white is not None:
            deviation = white * np.sqrt(shares[part.kind])
        if deviation is not None:
            found.append((part.kind, np.array(taus) / bench.data.rate_hz, deviation))
    return found
