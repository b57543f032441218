"""The noise of a gyro in motion: davar's floor, between rotor lines and motion (docs/FLIGHT.md)."""

import warnings
from dataclasses import dataclass

import davar
import numpy as np

from ..arrays import Floats
from ..errors import BadInput
from ..thresholds import DEVICE
from . import counts
from .recording import Recording


@dataclass
class Floor:
    """values: of the windows that have one, deg/sqrt(h), if they are not rare; windows: how many
    there are; why: the most frequent reason of those without (floor_why of davar.dynamic; 0: there
    is none); most: what half of those that have an upper limit only are below; filter: that was
    stated, None without."""

    values: list[float]
    windows: int
    why: int = 0
    most: float | None = None
    filter: str | None = None


def measured(recording: Recording, column: str, filter: str | None) -> Floor:
    """The floor of a gyro every half second. Its counts are found, because their rounding is no
    noise of the gyro. Raises BadInput where davar rejects the filter or the record."""
    there = slice(None) if recording.known is None else recording.known
    rates = np.asarray(recording.columns[column][there], np.float64)
    stride = max(
        2, 2 * round(DEVICE.flight_stride_s * recording.rate_hz / 2)
    )  # even, as a window is
    count = counts.step(rates)
    try:
        # Motion hides ARW in most windows.
        with warnings.catch_warnings(action="ignore", category=UserWarning):
            found = davar.dynamic(
                np.round((rates - rates[0]) / count).astype(np.int32) if count else rates,
                lsb=count or None,
                bits=32 if count else None,
                time_s=recording.time_s[there],
                bandwidth=filter or "none",
                stride=stride,
                window_max=max(DEVICE.flight_window, stride),
                floor=True,
            )
    except ValueError as why:
        raise BadInput(f"noise of {column} in motion: {why}") from None
    return of_windows(
        found.floor_deg_per_sqrt_h, found.floor_high_deg_per_sqrt_h, found.floor_why, filter
    )


def of_windows(values: Floats, highs: Floats, reasons: Floats, filter: str | None) -> Floor:
    without = reasons[reasons > 0].astype(int)
    limits = highs[(reasons > 0) & np.isfinite(highs)]
    found = [float(one) for one in values[reasons == 0]]
    return Floor(
        found if len(found) > DEVICE.rare_floor * len(reasons) else [],
        len(reasons),
        int(np.bincount(without).argmax()) if len(without) else 0,
        float(np.median(limits)) if len(limits) else None,
        filter,
    )
