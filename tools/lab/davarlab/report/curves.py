"""What the page and the report draw, as plain values. Both draw it with the same code
(workbench/page/chart)."""

import re
from collections.abc import Iterable, Sequence
from typing import cast

import numpy as np

from ..arrays import Floats, Ints
from ..diagnosis import judge
from ..diagnosis.contributions import Contribution
from ..diagnosis.judge import Cell
from ..distributions import chi2_ppf
from .values import Json

ENVELOPE = 1200  # points of a record
COLUMNS = 5  # drawn beside the gyro
FORCE = re.compile(r"^(\w)_force_mps2$")  # an accelerometer's column in the analysis (axes.py)
BAND = (0.025, 0.975)  # of 95 %


def deviation(cells: Sequence[Cell], effects: Iterable[Contribution]) -> Json:
    """The curve over the whole record: measured, model, its 95 % band, and each effect's own where
    it has one (8.1)."""
    stop = max(cell.stop_s - cell.start_s for cell in cells)
    row = [cell for cell in cells if cell.stop_s - cell.start_s == stop]
    freedom = np.array([cell.freedom for cell in row])
    model = np.array([cell.model_dps for cell in row])
    low, high = (model * np.sqrt(chi2_ppf(p, freedom) / freedom) for p in BAND)
    taus = [cell.tau_s for cell in row]
    return {
        "tau_s": taus,
        "measured": [cell.measured_dps for cell in row],
        "model": model.tolist(),
        "low": low.tolist(),
        "high": high.tolist(),
        "effects": [
            {"kind": kind, "deviation": at(taus, own_taus, own)} for kind, own_taus, own in effects
        ],
    }


def at(taus: Sequence[float], own_taus: Floats, deviations: Floats) -> list[float]:
    found = np.interp(np.log(taus), np.log(own_taus), np.log(np.maximum(deviations, 1e-30)))
    return cast(list[float], np.exp(found).tolist())


def failure_map(cells: Sequence[Cell]) -> list[Json]:
    return [
        {
            "tau_s": cell.tau_s,
            "start_s": cell.start_s,
            "stop_s": cell.stop_s,
            "measured": cell.measured_dps,
            "model": cell.model_dps,
            "ratio": cell.ratio,
            "z": cell.z,
            "proven": bool(off),
        }
        for cell, off in zip(cells, judge.proven(cells))
    ]


def residual(f_hz: Floats, power: Floats, counts: Ints) -> Json:
    """Measured over model at groups of frequencies, and the 95 % range of a true model."""
    low, high = (np.sqrt(chi2_ppf(p, counts) / counts) for p in BAND)
    return {
        "f_hz": f_hz.tolist(),
        "ratio": np.sqrt(power).tolist(),
        "low": low.tolist(),
        "high": high.tolist(),
    }


def envelope(
    name: str, values: Floats, rate_hz: float, edges_s: tuple[float, float] | None = None
) -> Json:
    """A column, or a stretch of it, thinned so that no extreme is lost. That of an accelerometer is
    in m/s^2 here, whatever the unit in its name."""
    start, stop = (0, len(values)) if edges_s is None else (int(edge * rate_hz) for edge in edges_s)
    start = max(0, start)
    part = values[start : min(len(values), max(stop, start + 2))]
    edges = np.linspace(0, len(part), min(ENVELOPE, len(part)), endpoint=False).astype(int)
    return {
        "column": FORCE.sub(r"accel_\1 (m/s^2)", name),
        "time_s": ((start + edges) / rate_hz).tolist(),
        "low": np.minimum.reduceat(part, edges).tolist(),
        "high": np.maximum.reduceat(part, edges).tolist(),
    }
