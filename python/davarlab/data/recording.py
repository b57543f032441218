"""A recording: samples on a uniform grid with the columns that were logged beside them."""

import shlex
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np

from .. import files
from ..arrays import Bools, Floats, Ints
from ..errors import BadInput, printable
from ..files import StrPath
from ..tables import table
from ..tables.constants import FORCE, TO_DPS
from ..thresholds import RECORD
from . import clock, repeats
from .clock import Clock

MINIMUM_SAMPLES: int = RECORD.minimum_samples
WRITTEN = 1 << 14  # rows that are written at once


@dataclass
class Recording:
    """Columns by name (all of one length) on an even grid, and the sample rate. known: True where a
    sample was measured, None when all were; the values of the others are interpolated and stand for
    nothing. gaps: index of the first sample after each run of missing ones."""

    columns: dict[str, Floats]
    rate_hz: float
    name: str = ""
    notes: dict[str, str] = field(default_factory=dict)
    gaps: Ints = field(default_factory=lambda: np.array([], int))
    # What was worked out of it before: observations, Allan deviations.
    measured: dict[Any, Any] = field(default_factory=dict)
    known: Bools | None = None
    clock: Clock | None = None
    # Of the stamps: time_s is counted from it, where doubles alone would round it (Unix times).
    origin_ns: int = 0
    # Its user says that rate, units and levels are right, however implausible.
    as_recorded: bool = False
    # Why units that were guessed may be wrong, with the next step, by quantity.
    doubts: dict[str, str] = field(default_factory=dict)
    # Rate of the file, when the sensor measures less often and its repeats are left out.
    read_hz: float | None = None
    # Time and columns of the rows without repeats as they were read, where the grid has another
    # order or rate.
    rows: tuple[Floats, dict[str, Floats]] | None = None

    @property
    def samples(self) -> int:
        return len(next(iter(self.columns.values())))

    @property
    def measured_samples(self) -> int:
        """How many samples there are, without the missing ones of the grid."""
        return self.samples if self.known is None else int(np.count_nonzero(self.known))

    @property
    def missing_samples(self) -> int:
        return self.samples - self.measured_samples

    @property
    def even_time(self) -> bool:
        """Is time_s a whole number of periods at each sample, in their order."""
        return not self.clock or not (
            self.clock.cut or self.clock.kind == "uneven" and self.clock.places is not None
        )

    @property
    def time_s(self) -> Floats:
        """Seconds from the first sample, on the grid; of an uneven clock by its stamps: a line goes
        on in time, not in samples. Worked out each time."""
        if self.clock and self.clock.kind == "uneven" and self.clock.places is not None:
            stamps: Floats = self.columns["time_s"] - self.columns["time_s"][0]
            return stamps
        time: Floats = np.arange(self.samples, dtype=float)
        time /= self.rate_hz
        for place, seconds in self.clock.cut if self.clock else ():
            time[place:] += seconds
        return time

    @property
    def gyros(self) -> list[str]:
        """The columns of gyros, by the unit in their names."""
        return [name for name in self.columns if name.endswith(tuple("_" + one for one in TO_DPS))]

    def column(self, name: str) -> Floats:
        if name not in self.columns:
            raise BadInput(f"{self.name}: no column {name} (there are: {', '.join(self.columns)})")
        return self.columns[name].astype(np.float64, copy=False)

    def rate_dps(self, name: str) -> Floats:
        """A gyro column in deg/s; what axes.py makes of an accelerometer in m/s^2."""
        factor, unit = rate_unit(name)
        if factor is None:
            raise BadInput(
                f"{self.name}: column {name} is not in deg/s or rad/s (its name must end in _dps "
                "or _rad_s)"
            )
        rate = self.column(name) * factor
        spread = float(np.ptp(rate))
        if spread and not RECORD.spread_dps[0] < spread < RECORD.spread_dps[1]:
            raise BadInput(
                f"{self.name}: column {as_logged(name)}: a range of {spread:.3g} {unit} is not "
                "that of a sensor"
            )
        return rate


def is_force(name: str) -> bool:
    """Is a column an accelerometer's, as the analysis takes it."""
    return name.startswith(f"{FORCE}accel_")


def as_logged(name: str) -> str:
    """A column of the analysis as the recording calls it."""
    return name.removeprefix(FORCE) if is_force(name) else name


def rate_unit(name: str) -> tuple[float | None, str]:
    """(factor of a column to the rate of the analysis, None: it is none; unit of that rate)."""
    if is_force(name):
        return 1.0, "m/s^2"
    found = (factor for unit, factor in TO_DPS.items() if name.endswith("_" + unit))
    return next(found, None), "deg/s"


def counted(known: int, missing: int) -> int:
    """How many samples a recording counts for."""
    return known + missing * (known >= RECORD.known_least * (known + missing))


def check_enough(known: int, missing: int, path: StrPath, why: str = "") -> None:
    count = counted(known, missing)
    if count < MINIMUM_SAMPLES:
        raise BadInput(f"{path}: {count} samples; at least {MINIMUM_SAMPLES} are needed{why}")


def no_time(columns: Mapping[str, Floats]) -> str:
    """What to type for columns without a time: a column that always runs forward may be one, unless
    it counts the rows."""
    steps = ((name, np.diff(column)) for name, column in columns.items())
    runs = [name for name, step in steps if len(step) and np.all(step > 0) and np.any(step != 1)]
    maybe = (
        f"If {runs[0]} is the time, type --unit {shlex.quote(f'{runs[0]}=s')} (or ms, us, ns). "
        "Otherwise, type"
        if runs
        else "Type"
    )
    return f"no column time_s and no --rate. {maybe} --rate HZ"


def clock_of(
    columns: dict[str, Floats],
    rate_hz: float | None,
    path: StrPath,
    line: int | None,
    places: Ints | None,
) -> Clock:
    if "time_s" in columns:
        return clock.analysed(clock.found(columns["time_s"], rate_hz, path, line), path)
    if not rate_hz:
        raise BadInput(f"{path}: {no_time(columns)}")
    return Clock(float(rate_hz), places)


def fresh(
    columns: dict[str, Floats], rate_hz: float, path: StrPath, places: Ints | None
) -> tuple[Floats, dict[str, Floats], Clock] | None:
    """Time and columns of the rows without repeats, and the clock of the sensor, where that was
    read more often than it measures. The analysis needs that rate: a recording with repeats has a
    lower white noise, and at even intervals no frequency differs from its image.
    """
    count = len(next(iter(columns.values())))
    found = repeats.find(columns, np.ones(count, bool))
    if not found or not found.clear or count - np.count_nonzero(found.equal) < MINIMUM_SAMPLES:
        return None
    rows = ~found.equal
    index = np.arange(count) if places is None else places
    time = columns.get("time_s", index / rate_hz)[rows]
    own = clock.behind_repeats(time, rate_hz, found.share, path)
    if not own:
        return None
    return time, {name: column[rows] for name, column in columns.items()}, own


def on_grid(columns: dict[str, Floats], found: Clock) -> tuple[dict[str, Floats], Bools | None]:
    """(columns on the grid of a clock, where they are known or None)."""
    if found.places is None:
        return columns, None
    known = np.zeros(found.places[-1] + 1, bool)
    known[found.places] = True
    return {
        name: filled(column if found.rows is None else column[found.rows], known)
        for name, column in columns.items()
    }, known


def gaps_of(known: Bools | None) -> Ints:
    return np.array([], int) if known is None else np.flatnonzero(known[1:] & ~known[:-1]) + 1


def filled(values: Floats, known: Bools) -> Floats:
    """Values at the known samples of a grid, the rest interpolated."""
    out = np.empty(len(known), values.dtype)
    out[known] = values
    out[~known] = np.interp(np.flatnonzero(~known), np.flatnonzero(known), values)
    return out


def of_columns(
    columns: dict[str, Floats],
    rate_hz: float | None,
    path: StrPath,
    notes: dict[str, str],
    line: int | None,
    places: Ints | None = None,
) -> Recording:
    """A Recording of columns that were read from the file `path`, whose header stands in `line`, on
    the even grid of the clock; places: on it, of samples without time_s, None: all in turn. What
    was lost is filled by interpolation, a placeholder.
    """
    read = clock_of(columns, rate_hz, path, line, places)
    if not RECORD.sane_hz[0] < read.rate_hz < RECORD.sane_hz[1]:
        raise BadInput(f"{path}: column time_s gives {read.rate_hz:g} samples per second")
    without_repeats = fresh(columns, read.rate_hz, path, places)
    time, rows, used = without_repeats or (columns.get("time_s"), columns, read)
    columns, known = on_grid(rows, used)
    return Recording(
        columns,
        used.rate_hz,
        str(path),
        notes,
        gaps_of(known),
        known=known,
        clock=used,
        read_hz=read.rate_hz if without_repeats else None,
        rows=(time, rows)
        if time is not None and (without_repeats or used.kind == "uneven")
        else None,
    )


def read(path: StrPath, rate_hz: float | None = None) -> Recording:
    """Reads a CSV or .csv.gz recording. Raises BadInput that names file, line and column."""
    found = table.read(path)
    made = of_columns(found.columns, rate_hz, path, found.notes, found.line, found.places)
    made.origin_ns = found.origin * 10**9
    check_enough(made.measured_samples, made.missing_samples, path)
    return made


def write(recording: Recording, path: StrPath) -> None:
    """Writes CSV (gzip when the name ends in .gz), whole or not at all."""
    write_columns(recording.columns, recording.notes, path, recording.origin_ns)


def write_columns(
    columns: Mapping[str, Floats], notes: dict[str, str], path: StrPath, origin_ns: int = 0
) -> None:
    """The same of columns of one length: nine digits, but of time_s as many as there are down to a
    nanosecond."""
    lines = text_of(columns, notes, origin_ns)
    files.write_whole(path, packed(lines) if Path(path).suffix == ".gz" else lines)


def text_of(
    columns: Mapping[str, Floats], notes: dict[str, str], origin_ns: int
) -> Iterator[bytes]:
    """The bytes of a CSV recording, a piece at a time."""
    yield (
        "".join(f"# {printable(key)}: {printable(value)}\n" for key, value in notes.items())
        + ",".join(columns)
        + "\n"
    ).encode()
    row = ",".join("%s" if name == "time_s" else "%.9g" for name in columns) + "\n"
    count = len(next(iter(columns.values())))
    for first in range(0, count, WRITTEN):
        pieces = [column[first : first + WRITTEN] for column in columns.values()]
        lists = [
            stamps_text(piece, origin_ns)
            if name == "time_s"
            else cast("list[float]", piece.tolist())
            for name, piece in zip(columns, pieces)
        ]
        values = [value for together in zip(*lists) for value in together]
        yield (row * len(lists[0]) % tuple(values)).encode()


def stamps_text(seconds: Floats, origin_ns: int) -> list[str]:
    """Stamps since an origin, as text."""
    if not origin_ns:
        values = cast("list[float]", np.asarray(seconds, np.float64).tolist())
        return [f"{value:.9f}".rstrip("0").rstrip(".") for value in values]
    whole = origin_ns + np.round(np.asarray(seconds, np.float64) * 1e9).astype(np.int64)
    return [f"{'-' * (ns < 0)}{abs(ns) // 10**9}.{abs(ns) % 10**9:09d}" for ns in whole.tolist()]


def packed(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """Pieces of bytes, in one gzip stream."""
    packer = zlib.compressobj(1, wbits=31)
    for piece in pieces:
        yield packer.compress(piece)
    yield packer.flush()
