"""Recordings from files: CSV as in davar-sim; other logs with davarlab, if it is installed."""

import gzip
import os
import re
import stat
import zlib
from dataclasses import dataclass, field

import numpy as np

from . import errors
from ._samples import median_step
from ._types import Array

LOGS = (
    b"ULog",
    b"\xa3\x95",
    b"FMT, ",
    b"#ROSBAG",
    b"SQLite format 3\0",
    b"\x89MCAP",
    b"MATLAB 5.0",
    b"\x93NUMPY",
    b"PK\x03\x04",
    b"PAR1",
    b"\x89HDF",
)
NUMBER = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII
)  # the intersection of davar-sim and numpy: no infinity and no NaN


@dataclass
class Recording:
    """A recording from a file. recording["gyro_z_dps"] is a column."""

    columns: dict[str, Array]
    """Samples (N) by name. A name ends in the unit: time_s, gyro_z_dps, temp_degC ..."""
    rate_hz: float | None
    """Samples per second, from the median time step; None without time_s."""
    notes: dict[str, str] = field(default_factory=dict)
    """The `# key: value` lines of a CSV, or the metadata of the log."""

    def __getitem__(self, name: str) -> Array:
        if name not in self.columns:
            raise KeyError(f"no column {name} (the columns are: {', '.join(self.columns)})")
        return self.columns[name]

    @property
    def time_s(self) -> Array | None:
        """Time stamps, seconds (N), or None."""
        return self.columns.get("time_s")


def read(path: "str | os.PathLike[str]", sensor: str | None = None) -> Recording:
    """Reads the recording in a file.

    Samples are unchanged, and time_s shows the gaps.

    Args:
        path: CSV, plain or gzip: optional `# key: value` lines, a header row, then numbers. PX4
            ULog, ArduPilot DataFlash, ROS bags, MCAP and MATLAB need the extras lab and logs (pip
            install "davar[lab,logs]"), NumPy and Parquet the extra lab.
        sensor: selects one if a log has several.

    Raises:
        ValueError: the message names file, line and column.
        OSError: a file cannot be read.
        ImportError: an extra is not installed.
    """
    name = os.fspath(path)
    if os.path.isdir(name):
        return of_log(name, sensor)
    found = os.stat(name)
    if not stat.S_ISREG(found.st_mode):
        raise ValueError(f"{name}: not a regular file")
    if not found.st_size:  # those of /proc too: reading them may block
        raise ValueError(f"{name}: no header row and no samples")
    with open(name, "rb") as file:
        head = file.read(1024)
    if head.startswith(LOGS) or (b"\0" in head and not head.startswith(b"\x1f\x8b")):
        return of_log(name, sensor)
    return of_csv(name)


def of_log(path: str, sensor: str | None) -> Recording:
    absent = errors.missing()
    if absent:
        raise ImportError(
            f"{path}: not CSV; other logs need the extra lab ({errors.not_installed(absent)})"
        )
    from davarlab.logs import formats
    from davarlab.logs.options import Options

    try:
        found = formats.samples(path, Options(sensor=sensor))
    except errors.NotInstalled as why:
        raise ImportError(str(why)) from None
    except errors.BadInput as why:
        raise ValueError(str(why)) from None
    columns = {name: np.asarray(column) for name, column in found.columns.items()}
    return Recording(
        columns,
        rate_of(columns, path) or found.rate_hz,
        {str(key): str(value) for key, value in found.notes.items()},
    )


def rate_of(columns: dict[str, Array], path: str) -> float | None:
    if "time_s" not in columns or len(columns["time_s"]) < 2:
        return None
    try:
        return 1 / median_step(columns["time_s"])
    except ValueError:
        raise ValueError(f"{path}: column time_s: the median time step is 0") from None


def lines_of(path: str) -> list[str]:
    with open(path, "rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    try:
        with gzip.open(path, "rb") if packed else open(path, "rb") as file:
            return file.read().decode("utf-8-sig").replace("\r\n", "\n").split("\n")
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file in UTF-8") from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as why:
        raise ValueError(f"{path}: damaged gzip file ({why})") from None


def of_csv(path: str) -> Recording:
    lines = lines_of(path)
    notes, first = {}, 0
    while first < len(lines) and (lines[first].startswith("#") or not lines[first].strip()):
        key, _, value = lines[first].lstrip("#").partition(":")
        notes.update({key.strip(): value.strip()} if key.strip() else {})
        first += 1
    if first == len(lines):
        raise ValueError(f"{path}: no header row and no samples")
    names = [name.strip() for name in lines[first].split(",")]
    for name in names:
        if not name or names.count(name) > 1:
            raise ValueError(
                f"{path}:{first + 1}: "
                + (f"column {name} appears twice" if name else "a column without a name")
            )
    while lines and not lines[-1].strip():
        lines.pop()
    columns = dict(zip(names, numbers(lines, first + 1, names, path)))
    if "time_s" in columns:
        back = np.flatnonzero(np.diff(columns["time_s"]) < 0)
        if len(back):
            raise ValueError(
                f"{path}:{first + 3 + back[0]}: column time_s: time runs backwards, found "
                f"{columns['time_s'][back[0] + 1]:.15g}"
            )
    return Recording(columns, rate_of(columns, path), notes)


def numbers(lines: list[str], first: int, names: list[str], path: str) -> Array:
    """(columns, rows) of the lines from line `first` onward."""
    rows = lines[first:]
    if not rows:
        raise ValueError(f"{path}:{first}: no rows after the header")
    try:
        table: Array = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2)
        good = table.shape == (len(rows), len(names)) and np.isfinite(table).all()
    except ValueError:
        good = False
    if not good:
        wrong = (
            wrong_in(row, names, f"{path}:{number}") for number, row in enumerate(rows, first + 1)
        )
        raise ValueError(next(filter(None, wrong), f"{path}: not a table of numbers"))
    return np.ascontiguousarray(table.T)


def wrong_in(row: str, names: list[str], where: str) -> str | None:
    """The fault in a row, or None."""
    if not row.strip():
        return f"{where}: an empty row between rows"
    fields = row.split(",")
    if len(fields) != len(names):
        return f"{where}: {len(fields)} fields, the header has {len(names)}"
    for name, one in zip(names, fields):
        text = one.strip()
        if not NUMBER.fullmatch(text) or not np.isfinite(float(text)):
            return f"{where}: column {name}: not a finite number, found {one.strip()!r}"
    return None
