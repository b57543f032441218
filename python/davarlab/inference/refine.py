"""Shapes (time constants, cut-offs, frequencies) by maximum likelihood, one after the other."""

from collections.abc import Collection, Sequence

import numpy as np
import scipy

from ..arrays import Floats
from ..data import signals
from ..thresholds import FIT, LINE
from .parts import Bench, Part


def numeric_shapes(part: Part) -> list[str]:
    fixed = {parameter.name for parameter in part.effect.parameters if parameter.searched}
    if part.any_response:
        fixed |= {"cutoff_hz", "order"}
    return (
        [
            name
            for name, value in part.shape.items()
            if isinstance(value, float) and value and name not in fixed
        ]
        if part.role in ("spectrum", "filter", "mean") and part.form != "decoded"
        else []
    )


def half_width(bench: Bench, part: Part, name: str) -> float:
    """How far to look, in natural logarithm; of a line half its lobe, within which there is one
    peak only."""
    if part.kind == "sinusoid":
        return 0.5 / turns(bench, part)
    if part.kind == "narrow_band" and name == "frequency_hz":
        found: float = min(0.45, 2 * part.shape["half_width_hz"] / part.shape["frequency_hz"])
        return found
    return 0.45


def bounds(bench: Bench, part: Part, name: str) -> tuple[float, float]:
    """Where a shape makes sense on this recording: (least, most)."""
    rate, samples = bench.data.rate_hz, bench.data.samples
    widest = (
        min(0.03 * rate, LINE.turning * part.shape["frequency_hz"])
        if part.kind == "narrow_band"
        else np.inf
    )
    parameter = next(p for p in part.effect.parameters if p.name == name)
    least, most = {
        ("gauss_markov", "correlation_time_s"): (8 / rate, np.inf),
        ("low_pass", "cutoff_hz"): (0, rate),
        ("high_pass", "corner_period_s"): (FIT.bias_tracked_s, np.inf),
        ("narrow_band", "frequency_hz"): (0, rate / 2),
        ("narrow_band", "half_width_hz"): (0.75 * rate / samples, widest),
    }.get((part.kind, name), (0, np.inf))
    return max(least, parameter.low), min(most, parameter.high)


def turns(bench: Bench, part: Part) -> float:
    found: float = part.shape["frequency_hz"] * bench.recording.samples / bench.recording.rate_hz
    return found


def on_peak(bench: Bench, part: Part, w: Floats) -> Part:
    """The line where the power of the whitened residual of the others peaks, within half a lobe.
    One pass over the record."""
    recording, f_hz = bench.recording, part.shape["frequency_hz"]
    time = None if recording.even_time else recording.time_s * recording.rate_hz
    turned, middle = signals.turned_back(w, f_hz / recording.rate_hz, LINE.pieces, time)
    reach = 0.5 / len(w)
    best = scipy.optimize.minimize_scalar(
        lambda off: -(np.abs(turned @ np.exp(-2j * np.pi * off * middle)) ** 2),
        bounds=(-reach, reach),
        method="bounded",
        options={"xatol": 1e-4 * reach},
    )
    return part.moved("frequency_hz", f_hz + float(best.x) * recording.rate_hz)


def line_refined(bench: Bench, parts: list[Part], index: int) -> list[Part]:
    """The parts with the line at this place on its peak, if that is likelier."""
    before, keys = bench.fit(parts), bench.all_keys(parts)
    coefficients = before.coefficients.copy()
    coefficients[[keys.index(key) for key in bench.keys(parts[index])]] = 0.0
    w = signals.in_time(bench.data.whitened(before.level, coefficients, keys))
    moved = on_peak(bench, parts[index], w)
    trial = [*parts[:index], moved, *parts[index + 1 :]]
    better = bench.fit(trial, near=before.level).log_likelihood > before.log_likelihood
    bench.forget(parts[index] if better else moved)
    return trial if better else parts


def refine_one(bench: Bench, parts: list[Part], index: int, name: str) -> list[Part]:
    part = parts[index]
    if part.kind == "sinusoid" and turns(bench, part) > LINE.white_turns:
        return line_refined(bench, parts, index)
    centre, width = part.shape[name], half_width(bench, part, name)
    least, most = bounds(bench, part, name)
    before = bench.fit(parts)

    def at(x: float) -> Part:
        return part.moved(name, float(min(max(centre * np.exp(x), least), most)))

    def loss(x: float) -> float:
        moved = at(x)
        trial = [*parts[:index], moved, *parts[index + 1 :]]
        value = -bench.fit(trial, near=before.level).log_likelihood
        if moved.effect.regressor:
            bench.forget(moved)
        return value

    best = scipy.optimize.minimize_scalar(
        loss,
        bounds=(-width, width),
        method="bounded",
        options={"xatol": width * 2e-3, "maxiter": 24},
    )
    if best.fun >= -before.log_likelihood:
        return parts
    bench.forget(part)
    parts = [*parts[:index], at(best.x), *parts[index + 1 :]]
    beyond = part.role == "filter" and abs(best.x) > FIT.reach_end * width
    return refine_one(bench, parts, index, name) if beyond else parts


def sweeps_for(parts: Sequence[Part], kind: str) -> int:
    """Two of a kind give way to each other in turns, each by little."""
    return (
        FIT.rounds_of_two
        if kind == "warm_up" and sum(part.kind == kind for part in parts) > 1
        else 1
    )


def refined(
    bench: Bench,
    parts: Sequence[Part],
    sweeps: int = 1,
    only: Collection[str] | None = None,
    only_last: bool = False,
) -> list[Part]:
    """Parts with their shapes at the maximum of the likelihood; `only`: kinds to move; `only_last`:
    the last part alone."""
    parts = list(parts)
    for _ in range(sweeps):
        for index in range(len(parts)):
            if (only is None or parts[index].kind in only) and (
                not only_last or index == len(parts) - 1
            ):
                for name in numeric_shapes(parts[index]):
                    parts = refine_one(bench, parts, index, name)
    return parts
