"""The verdict on a model: statistically adequate, practically adequate within 5 %, or neither
(DESIGN 7)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypedDict

import numpy as np
from scipy import special

from ..arrays import Floats
from ..distributions import chi2_isf, chi2_ppf
from ..inference.reading import Reading
from ..thresholds import CHANCE, JUDGE


@dataclass
class Cell:
    """One window and one tau: measured and model Allan deviation, and how far apart they are."""

    tau_s: float
    start_s: float
    stop_s: float
    measured_dps: float
    model_dps: float
    ratio: float
    z: float
    freedom: float


class Deviation(TypedDict):
    """A deviation in one window and at one tau. percent: its bound with 99 % confidence, 0 if it is
    not proven. ratio: the measured Allan deviation over the model's."""

    percent: float
    ratio: float
    tau_s: float
    start_s: float
    stop_s: float


@dataclass(frozen=True)
class Judgement:
    """adequacy: "statistical", "practical" or "no". largest: the largest proven deviation {percent,
    ratio, tau_s, start_s, stop_s}, None when no deviation is proven. percent is the bound with 99 %
    confidence, ratio the measured Allan deviation over the model's. shown_to_tau_s: the longest tau
    at which the record confirms a fit within 5 %; 0: no tau. shown_from_tau_s: the shortest that is
    tested. spoiled_by: the observation for which no model is adequate, "" without one. farthest:
    the least likely deviation, proven or not; None when no averaging time can be tested, and then
    no model is adequate. reading: None where the record has none."""

    adequacy: str
    error: float
    floor: float
    p_value: float
    largest: Deviation | None
    shown_to_tau_s: float
    spoiled_by: str = ""
    farthest: Deviation | None = None
    shown_from_tau_s: float = 0.0
    reading: Reading | None = None

    @property
    def misread(self) -> bool:
        """Does the record contradict the angle random walk of the model."""
        return self.reading is not None and abs(self.reading.off) > np.log(JUDGE.tolerance)

    @property
    def adequate(self) -> bool:
        return self.adequacy != "no"

    @property
    def testable(self) -> bool:
        """Is the recording plausible, with an averaging time that can be tested."""
        return not self.spoiled_by and self.error == self.error


def error_of(cells: Sequence[Cell]) -> float:
    return (
        float(np.sqrt(np.mean([np.log10(max(cell.ratio, 1e-9)) ** 2 for cell in cells])))
        if cells
        else float("nan")
    )


def floor_of(cells: Sequence[Cell]) -> float:
    if not cells:
        return float("nan")
    half = np.array([cell.freedom for cell in cells]) / 2
    square = special.polygamma(1, half) + (special.digamma(half) - np.log(half)) ** 2
    return float(np.sqrt(np.mean(square) / 4) / np.log(10))


def proven(cells: Sequence[Cell]) -> Floats:
    """The least factor by which each true ratio differs from 1, as a signed logarithm, from its
    family-wise 99 % interval; 0: no deviation is proven (7.2)."""
    if not cells:
        return np.zeros(0)
    freedom, tail = (
        np.array([cell.freedom for cell in cells]),
        CHANCE.family_wise / (2 * len(cells)),
    )
    ratio = np.log([max(cell.ratio, 1e-9) for cell in cells])
    low = ratio - 0.5 * np.log(chi2_isf(tail, freedom) / freedom)
    high = ratio - 0.5 * np.log(np.maximum(chi2_ppf(tail, freedom), 1e-300) / freedom)
    off: Floats = np.maximum(low, 0.0) + np.minimum(high, 0.0)
    return off


def largest_of(cells: Sequence[Cell]) -> tuple[Deviation | None, float]:
    """The largest proven deviation and its signed logarithm."""
    if not cells:
        return None, 0.0
    off = proven(cells)
    worst = int(np.argmax(np.abs(off)))
    if off[worst] == 0:
        return None, 0.0
    return deviation_of(cells[worst], 100 * float(np.expm1(off[worst]))), float(off[worst])


def deviation_of(cell: Cell, percent: float = 0.0) -> Deviation:
    return {
        "percent": percent,
        "ratio": cell.ratio,
        "tau_s": cell.tau_s,
        "start_s": cell.start_s,
        "stop_s": cell.stop_s,
    }


def farthest_of(cells: Sequence[Cell]) -> Deviation | None:
    """The least likely deviation, proven or not; None without a cell."""
    return deviation_of(max(cells, key=lambda cell: abs(cell.z))) if cells else None


def shown_to(cells: Sequence[Cell]) -> float:
    """The longest tau up to which the whole record shows that the model is within the tolerance
    (TOST at 5 %) (7.3)."""
    shown = 0.0
    for cell in over_all(cells):
        spread = np.sqrt(special.polygamma(1, cell.freedom / 2)) / 2
        if abs(np.log(max(cell.ratio, 1e-9))) + JUDGE.one_sided_95 * spread > np.log(
            JUDGE.tolerance
        ):
            break
        shown = cell.tau_s
    return float(shown)


def judged(
    cells: list[Cell],
    short: list[Cell],
    p_value: float,
    spoiled_by: str = "",
    reading: Reading | None = None,
) -> Judgement:
    """short: cells of short windows, which the error does not count. p_value: of the residual
    (inference/adequacy.py). spoiled_by, reading: see Judgement."""
    error, floor = error_of(cells), floor_of(cells)
    largest, off = largest_of(cells + short)
    word = (
        "no"
        if spoiled_by or error != error  # nothing can be tested
        else "statistical"
        if off == 0 and p_value >= CHANCE.adequate_p
        else "practical"
        if error <= CHANCE.above_floor * floor and abs(off) <= np.log(JUDGE.tolerance)
        else "no"
    )
    found = Judgement(
        word,
        error,
        floor,
        p_value,
        largest,
        shown_to(cells),
        spoiled_by,
        largest or farthest_of(cells),
        min((cell.tau_s for cell in cells), default=0.0),
        reading,
    )
    return replace(found, adequacy="no") if found.misread else found


def over_all(cells: Sequence[Cell]) -> list[Cell]:
    """The cells of the whole record."""
    longest = max((cell.stop_s - cell.start_s for cell in cells), default=0.0)
    return [cell for cell in cells if cell.stop_s - cell.start_s == longest]
