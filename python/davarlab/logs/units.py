"""Numbers of known units, as davarlab's columns."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .. import arrays
from ..arrays import Floats, Ints
from ..errors import BadInput
from ..tables import guess, table
from .sensor import Numbers

NAMES = {"gyro": "gyro_{}_dps", "accel": "accel_{}_g"}


def nanoseconds(ticks: npt.ArrayLike, unit_ns: int, where: str, origin: int = 0) -> Ints:
    """Stamps, which count ticks of unit_ns nanoseconds from an origin, as whole nanoseconds. Raises
    BadInput for what 64 bits do not hold."""
    ticks = np.asarray(ticks)
    check_stamps(ticks, unit_ns, where, origin)
    return (ticks.astype(np.int64) + origin) * unit_ns


def check_stamps(ticks: Numbers, unit_ns: float, where: str, origin: int = 0) -> None:
    """Raises BadInput that shows, as the log has it, the first stamp that 64 bits of nanoseconds do
    not hold."""
    wrong = np.flatnonzero(~(np.abs(ticks.astype(np.float64) + origin) * unit_ns < table.SAFE))
    if len(wrong):
        raise BadInput(
            f"{where}: the time stamp {float(ticks[wrong[0]]) + origin:.6g} at sample "
            f"{wrong[0] + 1} is not a valid time"
        )


def scaled(values: Numbers, factor: float) -> Floats:
    """In double precision, or in single where there are very many."""
    kind = np.float32 if len(values) >= arrays.NARROW_FROM else np.float64
    values = np.asarray(values)
    return (
        np.multiply(values, factor, dtype=kind, casting="unsafe")
        if factor != 1 or values.dtype != kind
        else values.astype(kind)
    )


def axes(quantity: str, values: Sequence[Numbers], rate: str, force: str) -> dict[str, Floats]:
    """name -> column of x, y, z (gyro in the unit `rate`, accel in `force`), or of a temperature in
    degC."""
    if quantity == "temp":
        return {"temp_degC": scaled(values[0], 1.0)}
    factor = guess.RATES[rate] if quantity == "gyro" else guess.FORCES[force]
    return {
        NAMES[quantity].format(axis): scaled(column, factor) for axis, column in zip("xyz", values)
    }


def measured(values: Numbers | None) -> bool:
    """Is a temperature one: drivers without a thermometer log 0 or NaN throughout."""
    return values is not None and bool(np.any(np.isfinite(values) & (np.asarray(values) != 0)))
