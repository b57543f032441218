"""Text, however its table is written (tables/dialect.py): davarlab's own recordings as they are,
others by guesses."""

import contextlib
import math
import re
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from ..arrays import Floats
from ..errors import BadInput
from ..files import StrPath
from ..tables import guess, table
from ..tables.constants import TO_DPS
from ..thresholds import GUESS
from . import hint, named
from .options import Options
from .sensor import Samples, Sensor

CHANGES_LEAST = 20  # of coarse stamps: with fewer, the rate would be off by more than 5 %
COUNTS = "counts"  # of whatever unit: the factor decides
GYROFLOW, FACTORS = "GYROFLOW IMU LOG", {"tscale": 0.001, "gscale": 1.0, "ascale": 1.0}
TENTHS = re.compile(r'"?blackbox_high_resolution\W+1\b')  # above a table of Blackbox Explorer
THROTTLE = "rcCommand[3]"  # of Betaflight, from 1000 to 2000
ACCEL = re.compile(r"accel_[xyz]_(g|mg|m_s2|mps2)")


def renamed(
    names: list[str], mapping: Iterable[str], path: StrPath, written: Sequence[str] = ()
) -> list[str]:
    """`old=new` pairs; new names must carry a unit. written: the names in the file, where columns
    are called otherwise."""
    now = dict(zip(written, names))
    for pair in mapping:
        old, equals, new = pair.partition("=")
        old = old if old in names else now.get(old, old)
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


def other(name: str) -> bool:
    """Is a name one of an axis that davarlab calls otherwise: gx_dps, accel_x_ms2."""
    quantity = guess.quantity_of(name)
    return bool(guess.axis_of(name)) and (
        quantity == "gyro"
        and name.endswith(tuple("_" + unit for unit in TO_DPS))
        and not name.startswith("gyro_")
        or quantity == "accel"
        and name.startswith("accel_")
        and not ACCEL.fullmatch(name)
    )


def is_own(names: Collection[str], rate_hz: float | None) -> bool:
    """Are the columns called as davarlab calls them: then nothing is guessed. Those of an
    accelerometer count where no other column may be a gyro."""
    gyros = any(guess.quantity_of(name) == "gyro" for name in names)
    if any(map(other, names)):
        return False
    return any(
        name.endswith(tuple("_" + unit for unit in TO_DPS)) or not gyros and ACCEL.fullmatch(name)
        for name in names
    ) and (
        "time_s" in names
        or bool(rate_hz)
        and not any(guess.quantity_of(name) == "time" for name in names)
    )


class Own:
    """A recording of davarlab's: one sensor, every column as it is."""

    def __init__(self, found: table.Table, path: StrPath) -> None:
        self.found, self.path = found, path
        self.sensors = [
            Sensor("recording", frozenset(["gyro"]), len(next(iter(found.columns.values()))))
        ]

    def read(self, name: str) -> Samples:
        found = self.found
        if found.time == "time_s":
            check_time(found, self.path, [])
        return Samples(
            found.columns,
            notes=dict(found.notes),
            line=found.line,
            origin_ns=found.origin * 10**9,
            said=found.said,
            places=found.places,
        )


def check_time(found: table.Table, path: StrPath, units: Sequence[str]) -> None:
    """Raises BadInput that says how to do without a time that runs backwards, or that is written
    too coarsely to tell the rate. units: as of --unit."""
    name = found.time
    others = [
        column
        for column, values in found.columns.items()
        if column != name and guess.quantity_of(column) == "time" and np.all(np.diff(values) >= 0)
    ]
    if not name or others or len(found.columns[name]) < 2:
        return
    steps = np.diff(found.columns[name])
    back = np.flatnonzero(steps < 0)
    if len(back):
        where = f"{path}:{table.line_of(found, int(back[0]) + 1, path)}"
        way_on = table.without_time(found.form, rate_of(found, units))
        raise BadInput(f"{where}: column {name}: time runs backwards{way_on}")
    if np.median(steps) == 0 and np.count_nonzero(steps) < CHANGES_LEAST:
        stamp = found.form.stamp
        digits = re.sub(r"[eE].*|[^0-9]", "", stamp).lstrip("0")
        have = f" have {len(digits)} digits and" * ("e" in stamp.lower())
        raise BadInput(
            f"{path}: column {name}: the time stamps ({stamp[: table.SHOWN]} ..){have} do not tell "
            f"neighbouring rows apart{table.without_time(found.form)}"
        )


def rate_of(found: table.Table, units: Sequence[str]) -> str:
    """The rate in Hz by the median step of the time, in its unit as it was given or is guessed; ""
    where it is unknown."""
    steps = np.diff(found.columns[found.time])
    forward = np.cumsum(np.maximum(steps, 0))
    one = guess.of_column(found.time, forward, found.rates)
    pairs = (pair.partition("=") for pair in units)
    given = (unit for name, _, unit in pairs if name in (found.time, "time"))
    factor = next((guess.SECONDS[unit] for unit in given if unit in guess.SECONDS), None)
    if found.form.kind in ("date", "clock"):
        factor = 1.0
    usual = float(np.median(steps)) * (factor or one.factor)
    return f"{1 / usual:.6g}" if usual > 0 and (factor or not one.doubt) else ""


def in_tenths(found: table.Table) -> guess.Known:
    """The units of a decoded blackbox log that Betaflight wrote with its option
    blackbox_high_resolution: gyro and stick commands are in tenths. The option is stated above the
    table, or is seen by a throttle above 2500, which ends at 2000 otherwise."""
    stated = any(map(TENTHS.match, found.above))
    throttle = found.columns.get(THROTTLE)
    if not stated and (throttle is None or not np.nanmax(throttle) > GUESS.throttle_most):
        return {}
    by = "its header" if stated else THROTTLE
    known = {}
    for name in found.columns:
        if guess.BLACKBOX.fullmatch(name.partition(" ")[0]):
            unit = guess.said_unit(name.partition(" ")[2], "gyro") or "deg/s"
            factor = guess.RATES[unit] / 10
            known[name] = f"0.1 {unit}", factor, f"by {by}, which shows blackbox_high_resolution"
    return known


def known_of(found: table.Table) -> guess.Known:
    """The units that a file states by other than names: dates are in seconds, and the log of
    Gyroflow (.gcsv) has factors to seconds, rad/s and g above its table."""
    if any(guess.BLACKBOX.match(name) for name in found.columns):
        return in_tenths(found)
    if found.form.kind in ("date", "clock"):
        return {found.time: ("s", 1.0, "as it is written")}
    if not (found.above and found.above[0].startswith(GYROFLOW)):
        return {}
    pairs = (re.split("[,:] *", line) for line in found.above)
    said = {pair[0]: float(pair[1]) for pair in pairs if pair[0] in FACTORS and len(pair) == 2}
    scale = {name: said.get(name, default) for name, default in FACTORS.items()}
    unit = next((one for one, size in guess.SECONDS.items() if size == scale["tscale"]), COUNTS)
    return {
        "time": (unit, scale["tscale"], "by its tscale"),
        "gyro": (COUNTS, scale["gscale"] * guess.RATES["rad/s"], "by its gscale"),
        "accel": (COUNTS, scale["ascale"], "by its ascale"),
    }


def log(path: StrPath, options: Options) -> Own | named.Log:
    found = table.read(
        path,
        options.names,
        lambda names, written, where: renamed(names, options.renames, where, written),
        options.skip_lines,
    )
    if not found.named and not options.renames:
        first = ", ".join(f"{column[0]:g}" for column in found.columns.values())
        raise BadInput(
            f"{path}:{found.line + 1}: no names above the {found.count} columns "
            f"({first[: table.SHOWN]}). {hint.said(found.columns, found.count, found.rates)}"
        )
    if options.plain or is_own(found.columns, options.rate_hz) and not options.units:
        return Own(found, path)
    check_time(found, path, options.units)
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
        [options.rate_hz] if options.rate_hz else found.rates,
        found.places,
        known_of(found),
    )
