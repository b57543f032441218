"""Numbers of known units, as davarlab's columns."""

import numpy as np

from ..data import guess, signals

NAMES = {"gyro": "gyro_{}_dps", "accel": "accel_{}_g"}


def scaled(values, factor):
    """In double precision, or in single where there are very many."""
    kind = np.float32 if len(values) >= signals.NARROW_FROM else np.float64
    values = np.asarray(values)
    return np.multiply(values, factor, dtype=kind, casting="unsafe") if factor != 1 or values.dtype != kind else values.astype(kind)


def axes(quantity, values, rate, force):
    """name -> column of x, y, z (gyro in the unit `rate`, accel in `force`), or of a temperature in degC."""
    if quantity == "temp":
        return {"temp_degC": scaled(values[0], 1.0)}
    factor = guess.RATES[rate] if quantity == "gyro" else guess.FORCES[force]
    return {NAMES[quantity].format(axis): scaled(column, factor) for axis, column in zip("xyz", values)}


def measured(values):
    """Is a temperature one: drivers without a thermometer log 0 or NaN throughout."""
    return values is not None and bool(np.any(np.isfinite(values) & (np.asarray(values) != 0)))
