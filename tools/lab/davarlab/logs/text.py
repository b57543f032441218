"""Text, however its table is written (data/dialect.py): davarlab's own recordings as they are,
others by guesses."""

import contextlib
import math
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Floats
from ..data import dialect, guess, signals, table
from ..data import recording as recordings
from ..errors import BadInput
from ..files import StrPath
from . import named
from .sensor import Samples, Sensor

if TYPE_CHECKING:
    from .formats import Options


def renamed(names: list[str], mapping: Iterable[str], path: StrPath) -> list[str]:
    """`old=new` pairs; new names must carry a unit."""
    for pair in mapping:
        old, equals, new = pair.partition("=")
        if not equals or old not in names:
            raise BadInput(
                f"--rename {pair}: {path} has no column {old!r} (there are: {', '.join(names)})"
            )
        if new in names and new != old:
            raise BadInput(f"--rename {pair}: {path} has a column {new} already")
        if not table.is_name(new):
            raise BadInput(f"--rename {pair}: not a name for a column")
        names = [new if name == old else name for name in names]
    return names


def check_renames(mapping: Iterable[str], scales: Sequence[str]) -> None:
    """Raises BadInput where a column would get a name that contradicts the unit in its own one, and
    no --scale turns the one into the other."""
    for pair in mapping:
        old, _, new = pair.partition("=")
        quantity = guess.quantity_of(new)
        said, wanted = (
            guess.said_unit(name, quantity) if quantity in guess.UNITS else ""
            for name in (old, new)
        )
        if (
            said in guess.UNITS.get(quantity, {})
            and wanted
            and said != wanted
            and not any(scale.startswith(f"{new}=") for scale in scales)
        ):
            factor = guess.UNITS[quantity][said] / guess.UNITS[quantity][wanted]
            raise BadInput(
                f"--rename {pair}: column {old}: its name has unit {said}, but {new} is in "
                f"{wanted}. Add --scale {new}={factor:.9g}, or remove --rename where davarlab "
                "reads the column by its name"
            )


def factor_of(pair: str, names: Iterable[str]) -> tuple[str, float]:
    """A `NAME=FACTOR` pair of --scale."""
    name, _, factor = pair.partition("=")
    if name not in names:
        raise BadInput(f"--scale {pair}: no column {name!r} (there are: {', '.join(names)})")
    with contextlib.suppress(ValueError):
        if float(factor) and math.isfinite(float(factor)):
            return name, float(factor)
    raise BadInput(f"--scale {pair}: a finite factor other than 0 expected")


def scaled(columns: dict[str, Floats], scales: Sequence[str]) -> dict[str, Floats]:
    for pair in scales:
        name, factor = factor_of(pair, columns)
        columns[name] = columns[name] * factor
    return columns


def clock_column(pair: str, columns: dict[str, Floats], path: StrPath) -> tuple[str, str, Floats]:
    """(column, its new name, values in s or as a fractional frequency) of a COLUMN=KIND pair. KIND:
    phase in s, phase_ms, phase_us, phase_ns, frequency (fractional), or the nominal frequency of a
    column in Hz."""
    name, _, kind = pair.partition("=")
    if name not in columns:
        raise BadInput(
            f"--clock {pair}: {path} has no column {name!r} (there are: {names(columns)})"
        )
    values = columns[name]
    if values.dtype != np.float64:
        raise BadInput(
            f"--clock {pair}: {len(values)} samples of {path} are read in single precision, which "
            f"is too coarse for a clock. Split the file into parts below {signals.NARROW_FROM} "
            "samples"
        )
    what, _, unit = kind.partition("_")
    if what == "phase" and (unit or "s") in guess.SECONDS:
        return name, ended(name, "phase_s"), values * guess.SECONDS[unit or "s"]
    if kind == "frequency":
        return name, ended(name, "fractional_frequency"), values
    with contextlib.suppress(ValueError):
        if 0 < float(kind) < math.inf:
            made = (values - float(kind)) / float(kind)
            return name, ended(name, "fractional_frequency"), made
    raise BadInput(
        f"--clock {pair}: phase, phase_ms, phase_us, phase_ns, frequency, or the nominal frequency "
        "in Hz expected"
    )


def names(columns: Iterable[str]) -> str:
    return ", ".join(columns)


def ended(name: str, end: str) -> str:
    return name if name.endswith(end) else f"{name}_{end}"


def with_clocks(
    columns: dict[str, Floats], pairs: Iterable[str], path: StrPath
) -> dict[str, Floats]:
    """The columns, with those of clocks in s or as fractional frequencies, called so."""
    for pair in pairs:
        old, new, values = clock_column(pair, columns, path)
        if new != old and new in columns:
            raise BadInput(f"--clock {pair}: {path} has a column {new} already")
        columns = {
            (new if name == old else name): (values if name == old else column)
            for name, column in columns.items()
        }
    return columns


def is_own(names: Collection[str], rate_hz: float | None) -> bool:
    """Are the columns called as davarlab calls them: then nothing is guessed."""
    return any(
        name.endswith(tuple("_" + unit for unit in recordings.TO_DPS)) or recordings.is_clock(name)
        for name in names
    ) and (
        "time_s" in names
        or bool(rate_hz)
        and not any(guess.quantity_of(name) == "time" for name in names)
    )


class Own:
    """A recording of davarlab's: one sensor, every column as it is."""

    def __init__(self, found: table.Table) -> None:
        self.found = found
        self.sensors = [
            Sensor("recording", frozenset(["gyro"]), len(next(iter(found.columns.values()))))
        ]

    def read(self, name: str) -> Samples:
        found = self.found
        return Samples(
            found.columns,
            notes=dict(found.notes),
            line=found.line,
            origin_ns=found.origin * 10**9,
            said=found.said,
        )


def log(path: StrPath, options: "Options") -> Own | named.Log:
    found = table.read(
        path, options.names, lambda names, where: renamed(names, options.renames, where)
    )
    if not found.named and not options.renames:
        first = ", ".join(f"{column[0]:g}" for column in found.columns.values())
        raise BadInput(
            f"{path}:{found.line + 1}: no names above the {found.count} columns "
            f"({first[: table.SHOWN]}). Type a name for each, or {dialect.SKIP} to skip one: "
            f"{dialect.example(found.count)}"
        )
    found.columns = with_clocks(found.columns, options.clocks, path)
    if options.plain or is_own(found.columns, options.rate_hz) and not options.units:
        return Own(found)
    return named.Log(
        path,
        {name: one.shape for name, one in found.columns.items()},
        found.columns.get,
        options.units,
        "CSV",
        True,
        found.line,
        {found.time: found.origin},
        found.said,
    )
