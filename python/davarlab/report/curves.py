"""What the page and the report draw, as plain values. Both draw it with the same code
(workbench/page/chart)."""

from collections.abc import Iterable, Sequence
from typing import cast

import numpy as np

from ..arrays import Floats, Ints
from ..data.recording import as_logged, is_force
from ..diagnosis import judge
from ..diagnosis.contributions import Contribution
from ..diagnosis.judge import Cell
from ..distributions import chi2_ppf
from .values import Json

ENVELOPE = 1200  # points of a record
COLUMNS = 5  # drawn beside the gyro
BAND = (0.025, 0.975)  # of 95 %


def deviation(cells: Sequence[Cell], effects: Iterable[Contribution]) -> Json:
    """The whole record: measured, with its 95 % interval, and the model, with the 95 % range of a
    true one; and as curves with eight points an octave, the model and each effect that has one
    (8.1)."""
    stop = max(cell.stop_s - cell.start_s for cell in cells)
    row = [cell for cell in cells if cell.stop_s - cell.start_s == stop]
    spread = [chi2_ppf(p, np.array([cell.freedom for cell in row])) for p in BAND]
    low, high = (np.sqrt(of / [cell.freedom for cell in row]) for of in spread)
    measured = np.array([cell.measured_dps for cell in row])
    model = np.array([cell.model_dps for cell in row])
    taus, effects = [cell.tau_s for cell in row], list(effects)
    return {
        "tau_s": taus,
        "measured": measured.tolist(),
        "measured_low": (measured / high).tolist(),
        "measured_high": (measured / low).tolist(),
        "model": model.tolist(),
        "low": (model * low).tolist(),
        "high": (model * high).tolist(),
        "effects": [
            {"kind": kind, "deviation": at(taus, own_taus, own), "curve": own.tolist()}
            for kind, own_taus, own in effects
        ],
        "curve": curve(taus, model, effects),
    }


def curve(taus: Sequence[float], model: Floats, effects: Sequence[Contribution]) -> Json:
    """The model between its values at `taus`: its effects together, moved onto these values,
    because effects of known course may also cancel each other."""
    if not effects:
        return {"tau_s": list(taus), "model": model.tolist()}
    fine = effects[0][1]
    together = np.sqrt(np.sum([own**2 for _, _, own in effects], axis=0))
    onto = np.log(model / at(taus, fine, together))
    moved = together * np.exp(np.interp(np.log(fine), np.log(taus), onto))
    return {"tau_s": fine.tolist(), "model": moved.tolist()}


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
    """A column, or a stretch of it, thinned so that no extreme is lost. That of the accelerometer
    that is analysed is in m/s^2, whatever the unit in its name."""
    start, stop = (0, len(values)) if edges_s is None else (int(edge * rate_hz) for edge in edges_s)
    start = max(0, start)
    part = values[start : min(len(values), max(stop, start + 2))]
    edges = np.linspace(0, len(part), min(ENVELOPE, len(part)), endpoint=False).astype(int)
    return {
        "column": f"{as_logged(name)[:7]} (m/s^2)" if is_force(name) else name,
        "time_s": ((start + edges) / rate_hz).tolist(),
        "low": np.minimum.reduceat(part, edges).tolist(),
        "high": np.maximum.reduceat(part, edges).tolist(),
    }
