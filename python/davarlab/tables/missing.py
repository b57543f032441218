"""Missing values of a table: gaps of the sensor, and what is interpolated (docs/LOGS.md)."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..errors import BadInput
from ..files import StrPath
from ..thresholds import GUESS
from . import guess

LISTED = 6  # columns in a message
RATES = ("_dps", "_rad_s")  # how the columns of gyros end, whatever else they are called


def axes_of(names: Collection[str], quantity: str) -> list[str]:
    return [name for name in names if guess.quantity_of(name) == quantity and guess.axis_of(name)]


def sensor_of(names: Collection[str]) -> list[str]:
    """The columns whose noise is measured: of gyros, else of accelerometers."""
    gyros = axes_of(names, "gyro")
    gyros = [name for name in names if name in gyros or name.endswith(RATES)]
    return gyros or axes_of(names, "accel")


@dataclass
class Settled:
    """columns: without missing values; places: of their rows in the table (None: all); empty:
    columns that were left out; said: what was done, in words."""

    columns: dict[str, Floats]
    places: Ints | None = None
    empty: list[str] = field(default_factory=list)
    said: list[str] = field(default_factory=list)


Without = Callable[[Collection[str]], str]  # columns -> the option that skips them


def settled(columns: dict[str, Floats], time: str, path: StrPath, without: Without) -> Settled:
    """Columns of a table in which NaN stands for a missing value; time: the one without any."""
    gone = {name: np.isnan(column) for name, column in columns.items() if name != time}
    gone = {name: where for name, where in gone.items() if where.any()}
    empty = [name for name, where in gone.items() if where.all()]
    check_empty(columns, empty, path)
    made = Settled({name: one for name, one in columns.items() if name not in empty}, empty=empty)
    gone = {name: where for name, where in gone.items() if name not in empty}
    needed = needed_of(made.columns, gone, path, without)
    for name in (slow := [name for name in gone if name not in needed]):
        made.columns[name] = interpolated(columns[name], gone[name], columns.get(time))
    if slow:
        counts = (f"{name} ({np.count_nonzero(gone[name])} missing values)" for name in slow)
        made.said.append(f"interpolated: {', '.join(counts)}")
    if needed:
        keep_whole(made, {name: gone[name] for name in needed}, path, without)
    return made


def check_empty(names: Collection[str], empty: Collection[str], path: StrPath) -> None:
    """Raises BadInput where no column of the sensor has a value, or none at all."""
    sensor = sensor_of(names) or list(names)
    if set(sensor) <= set(empty):
        raise BadInput(f"{path}: column {sensor[0]}: no row has a value")


def needed_of(
    columns: Mapping[str, Floats], gone: Mapping[str, Bools], path: StrPath, without: Without
) -> list[str]:
    """The columns whose missing values are gaps: of the sensor, and of an accelerometer that is as
    fast. Raises BadInput where the columns of the sensor have their values in different rows."""
    sensor = sensor_of(columns)
    if not sensor or not gone:
        return []
    none = np.zeros(len(next(iter(columns.values()))), bool)
    fullest = min(sensor, key=lambda name: np.count_nonzero(gone.get(name, none)))
    rows = ~gone.get(fullest, none)
    slower = [name for name, where in gone.items() if np.mean(where[rows]) >= GUESS.slower_column]
    apart = [name for name in sensor if name in slower]
    if apart:
        raise BadInput(
            f"{path}: column {apart[0]}: a value in {np.count_nonzero(rows & ~gone[apart[0]])} of "
            f"the {np.count_nonzero(rows)} rows with {fullest}; all others would be gaps. To do "
            f"without {', '.join(apart)}, type {without(apart)}"
        )
    beside = [name for name in axes_of(columns, "accel") if name not in slower]
    return [name for name in gone if name in sensor or name in beside]


def keep_whole(made: Settled, gone: Mapping[str, Bools], path: StrPath, without: Without) -> None:
    """Leaves out the rows in which one of these columns has no value. Raises BadInput where none
    would be left."""
    names, lost = list(gone), np.logical_or.reduce(list(gone.values()))
    if lost.all():
        worst = max(names, key=lambda name: np.count_nonzero(gone[name]))
        raise BadInput(
            f"{path}: every row lacks a value, most of them that of column {worst} "
            f"({np.count_nonzero(gone[worst])} of {len(lost)}). To do without it, type "
            f"{without([worst])}"
        )
    lacking = ", ".join(names[:LISTED]) + ", .." * (len(names) > LISTED)
    made.said.append(f"{np.count_nonzero(lost)} of {len(lost)} rows omitted: no value of {lacking}")
    made.columns = {name: column[~lost] for name, column in made.columns.items()}
    made.places = np.flatnonzero(~lost)


def interpolated(values: Floats, gone: Bools, time: Floats | None) -> Floats:
    """A column over its missing values: in time, where there is one that runs forward, else from
    row to row."""
    runs = time is not None and bool(np.all(np.diff(time) >= 0))
    at = time if runs and time is not None else np.arange(len(values))
    out = values.copy()
    out[gone] = np.interp(at[gone], at[~gone], values[~gone])
    return out
