"""The angle random walk read off the record itself, to check a fitted model with (DESIGN 7.6)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..arrays import Bools, Floats
from ..thresholds import READING
from . import allan
from .parts import Bench, Part, spectrum_of, unit_spectrum
from .whittle import Fit

WHITE = "angle_random_walk"
Limits = tuple[float, float, float]  # value, and the ends of its 99 % interval


@dataclass(frozen=True)
class Reading:
    """The angle random walk of the model, and as the record reads without it, in deg/sqrt(h):
    60 times the Allan deviation around 1 s, and the density at low frequencies."""

    model: float
    deviation: Limits
    density: Limits

    @property
    def off(self) -> float:
        """The least factor by which both readings say that the model is off, as a signed logarithm
        (positive: its angle random walk is too small); 0: they do not say so."""
        low = min(self.deviation[1], self.density[1])
        high = max(self.deviation[2], self.density[2])
        model = max(self.model, READING.none)
        if low > model:
            return float(np.log(low / model))
        return float(np.log(max(high, READING.none) / model)) if high < model else 0.0

    @property
    def ratio(self) -> float:
        """The mean of the readings over the model's angle random walk."""
        return (self.deviation[0] + self.density[0]) / 2 / max(self.model, READING.none)


class Cell(Protocol):
    """An Allan deviation of the whole record, measured and as the model gives it."""

    tau_s: float
    measured_dps: float
    model_dps: float
    freedom: float


def flat(part: Part, rate_hz: float) -> bool:
    """Is a noise white at the frequencies that are read: white noise, and what may stand for it."""
    f = np.geomspace(READING.low_hz, min(READING.high_hz, rate_hz / 2), READING.points)
    found = unit_spectrum(part, f, rate_hz)
    return bool(found.max() < READING.flat * found.min())


def limits(values: Floats, errors: Floats, shared: float) -> Limits:
    """The pooled level of white noise, whose square is given, and its interval. shared: by how much
    the mean scatters more because the values go together."""
    weight = errors**-2.0
    value = float(values @ weight / weight.sum())
    reach = READING.errors * shared * float(weight.sum() ** -0.5)
    low, middle, high = (60 * np.sqrt(max(value + by, 0.0)) for by in (-reach, 0.0, reach))
    return float(middle), float(low), float(high)


def of_deviations(
    parts: Sequence[Part], rate_hz: float, cells: Sequence[Cell], unit: Floats, stands: Floats
) -> Limits:
    """Of Allan deviations, without what the model has of lines and of slow noise. unit: sizes of
    white noise alone; stands: those of what is white there."""
    taus = [round(cell.tau_s * rate_hz) for cell in cells]

    def variance(sizes: Floats) -> Floats:
        return allan.expected(allan.on_grid(spectrum_of(parts, sizes, rate_hz), rate_hz), taus)

    measured = np.array([cell.measured_dps for cell in cells]) ** 2
    model = np.array([cell.model_dps for cell in cells]) ** 2
    error = model * np.sqrt(2 / np.array([cell.freedom for cell in cells]))
    white = variance(unit)
    return limits((measured - model + variance(stands)) / white, error / white, READING.shared)


def of_density(
    bench: Bench, parts: Sequence[Part], fit: Fit, kept: Bools, unit: Floats, stands: Floats
) -> Limits:
    """Of the density at the bins that are kept."""
    data, level = bench.data, fit.level[kept]
    square = bench.whitened(parts, fit) ** 2
    ratio = np.add.reduceat(square, data.starts, dtype=np.float64)[kept] / data.counts[kept]
    white, there = (
        spectrum_of(parts, sizes, data.rate_hz)(data.f_bin[kept]) for sizes in (unit, stands)
    )
    error = level * np.sqrt(2 / data.counts[kept])
    return limits((level * (ratio - 1) + there) / white, error / white, 1.0)


def between_lines(bench: Bench, parts: Sequence[Part]) -> Bools:
    """The bins whose density is read."""
    data, f = bench.data, bench.data.f_bin
    kept: Bools = (f >= READING.low_hz) & (f <= READING.high_hz)
    for part in parts:
        if "frequency_hz" in part.shape:
            reach = part.shape.get("half_width_hz", 0.0) + data.rate_hz / data.samples
            kept &= np.abs(f - part.shape["frequency_hz"]) > READING.line_widths * reach
    return kept


def read_off(
    bench: Bench, parts: Sequence[Part], fit: Fit, whole: Sequence[Cell]
) -> Reading | None:
    """The two readings beside the model; None where the record has none, or the model no white
    noise. whole: the Allan deviations of the whole record."""
    rate = bench.data.rate_hz
    noise = [part for part in parts if part.role == "spectrum"]
    size = next((s for part, s in zip(noise, fit.sizes) if part.kind == WHITE), None)
    cells = [cell for cell in whole if READING.from_tau_s <= cell.tau_s <= READING.to_tau_s]
    kept = between_lines(bench, parts)
    if size is None or not cells or np.count_nonzero(kept) < READING.bins_least:
        return None
    white, stands = np.zeros((2, len(fit.sizes)))
    for place, part in enumerate(noise):
        white[place] = part.kind == WHITE
        stands[place] = fit.sizes[place] * flat(part, rate)
    return Reading(
        60 * float(np.sqrt(size)),
        of_deviations(parts, rate, cells, white, stands),
        of_density(bench, parts, fit, kept, white, stands),
    )
