"""The table of an error model, as written by `davarlab export MODEL -o TABLE.csv`."""

import os

import numpy as np
import numpy.typing as npt

from ._read import read
from ._types import Floats, Path

COLUMNS = ("m", "adev_dps", "relative_tolerance")
TAU_TOLERANCE = 0.01  # of tau_s from m / rate_hz


def model_of(path: Path, rate_hz: float) -> tuple[npt.NDArray[np.uint32], Floats, Floats]:
    """(cluster sizes, deviations, relative tolerances) for this rate. Raises ValueError with
    model_table.
    """
    try:
        name = os.fspath(path)
        table = read(name)
    except (TypeError, ValueError, OSError, ImportError) as why:
        raise ValueError(f"model_table: {why}") from None
    absent = [column for column in COLUMNS if column not in table.columns]
    if absent:
        raise ValueError(
            f"model_table: {name}: no column {absent[0]} (found: {', '.join(table.columns)}); "
            "davarlab export MODEL -o TABLE.csv writes one"
        )
    m, adev, tolerance = (table[column] for column in COLUMNS)
    if not np.all((m >= 1) & (m < 2**32) & (m == np.floor(m))):
        raise ValueError(
            f"model_table: {name}: column m: cluster sizes expected, whole numbers of at least 1"
        )
    if "tau_s" in table.columns and np.any(
        np.abs(table["tau_s"] - m / rate_hz) > TAU_TOLERANCE * m / rate_hz
    ):
        raise ValueError(
            f"model_table: {name}: column tau_s: made for a different sample rate "
            f"than {rate_hz:g} Hz"
        )
    return (
        m.astype(np.uint32),
        np.ascontiguousarray(adev, np.float64),
        np.ascontiguousarray(tolerance, np.float64),
    )
