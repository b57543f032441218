"""Any log, by what is in it: which sensors it holds, and a Recording of one of them."""

import importlib
import os
import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from .. import files
from ..arrays import Ints
from ..data import clock, plausible
from ..data import recording as recordings
from ..data.recording import Recording
from ..errors import BadInput, of_extra
from ..files import StrPath
from ..tables import table as tables
from ..thresholds import RECORD
from . import sensor as sensors
from . import text
from .options import Options
from .sensor import Log, Samples, Sensor

SECOND = 10**9
FAR_S = 1_000_000  # from 0, beyond which stamps are counted from a whole second near the first


Reader = Callable[[StrPath, Options], Log]
Result = TypeVar("Result")


def by(module: str, name: str, extra: str = "logs") -> Reader:
    """A reader of this room: path, Options -> a log with its sensors and read(name). Its library,
    of an extra, is loaded when it is needed."""

    def read(path: StrPath, options: Options) -> Log:
        with of_extra(extra):
            room = importlib.import_module("." + module, __package__)
        log: Log = getattr(room, name)(path, options)
        return log

    return read


def blackbox(path: StrPath, options: Options) -> Log:
    """Raises BadInput: the Python library that reads a packed log is under the GPL."""
    name = Path(path)
    raise BadInput(
        f"{path}: a packed Blackbox log. Type blackbox_decode --unit-rotation deg/s "
        f"{shlex.quote(str(path))}, and use {name.with_name(name.stem)}.01.csv"
    )


ROS, HDF5_FILE = by("ros", "Log"), by("matlab", "hdf5")
# (how it begins, its name, who reads it)
FORMATS = (
    (b"ULog", "PX4 ULog", by("ulog", "Log")),
    (b"\xa3\x95", "ArduPilot DataFlash", by("dataflash", "Log")),
    (b"FMT, ", "ArduPilot DataFlash text", by("dataflash", "TextLog")),
    (b"#ROSBAG", "ROS 1 bag", ROS),
    (b"SQLite format 3\0", "ROS 2 db3", ROS),
    (b"\x89MCAP0\r\n", "MCAP", ROS),
    (b"MATLAB 5.0", "MATLAB 5", by("matlab", "version_5")),
    (b"\x93NUMPY", "NumPy npy", by("arrays", "npy", "lab")),
    (b"PK\x03\x04", "NumPy npz", by("arrays", "npz", "lab")),
    (b"PAR1", "Parquet", by("arrays", "table", "lab")),
    (b"H Product:Blackbox", "Blackbox", blackbox),
)
GZIP = b"\x1f\x8b"
HDF5 = b"\x89HDF\r\n\x1a\n"  # at the beginning, or behind the 512 bytes of MATLAB 7.3
ENDINGS = {
    ".ulg": "PX4 ULog",
    ".bin": "ArduPilot DataFlash",
    ".bag": "ROS 1 bag",
    ".db3": "ROS 2 db3",
    ".mcap": "MCAP",
    ".mat": "MATLAB",
    ".npy": "NumPy npy",
    ".npz": "NumPy npz",
    ".parquet": "Parquet",
    ".h5": "HDF5",
    ".hdf5": "HDF5",
}


def format_of(path: StrPath) -> tuple[str, Reader]:
    """(name, reader) by the first bytes; a folder is a ROS 2 bag, what nobody else knows is text.
    Raises BadInput for a file that is not what its name says."""
    if os.path.isdir(path):
        check_inside(path)
        return "ROS 2 bag", ROS
    try:
        with files.reading(path) as file:
            head = file.read(1024)
    except OSError as why:
        raise BadInput(f"{path}: {why.strerror or why}") from None
    if HDF5 in (head[:8], head[512:520]):
        return "MATLAB 7.3 or HDF5", HDF5_FILE
    found = next(
        ((name, reader) for magic, name, reader in FORMATS if head.startswith(magic)), None
    )
    said = ENDINGS.get(Path(path).suffix.lower())
    if not found and said:
        raise BadInput(
            f"{path}: "
            + (
                "empty"
                if not head
                else f"not {said}, in spite of its name: it begins with {shown(head[:8])}"
            )
        )
    if not found and b"\0" in head and not head.startswith((GZIP, *tables.UTF_16)):
        raise BadInput(
            f"{path}: a binary file of a format that davarlab does not read (it begins with "
            f"{shown(head[:8])}). Export it as CSV or text with the program of its maker"
        )
    return found or ("CSV", text.log)


def shown(head: bytes) -> str:
    """The first bytes of a file in a message: as text if they are text, else in hexadecimal."""
    text = head.decode("latin-1")
    return repr(text) if text.isascii() and text.isprintable() else f"the bytes {head.hex(' ')}"


def check_inside(folder: StrPath) -> None:
    """Raises BadInput unless all that is in a folder are files and folders: the library that reads
    a bag opens them by their names."""
    try:
        inside = [one for one in os.scandir(folder) if not one.is_dir()]
    except OSError as why:
        raise BadInput(f"{folder}: {why.strerror or why}") from None
    for one in inside:
        files.check_regular(one.path)


def guarded(path: StrPath, name: str, work: Callable[[], Result]) -> Result:
    """work(), with whatever the libraries raise of a damaged file as one BadInput."""
    try:
        return work()
    except (BadInput, BrokenPipeError):
        raise
    except MemoryError:
        raise BadInput(
            f"{path}: damaged, or not {name}, or too large for the memory of this machine"
        ) from None
    except Exception as why:
        said = " ".join(str(why).split())[:160] or type(why).__name__
        raise BadInput(f"{path}: damaged, or not {name} ({said})") from None


def opened(path: StrPath, options: Options) -> tuple[Log, str]:
    """(the log, the name of its format)."""
    name, reader = format_of(path)
    if options.skip_lines and reader is not text.log:
        raise BadInput(f"--skip-lines: {path} is {name}, which has no lines")
    return guarded(path, name, lambda: reader(path, options)), name


def listed(path: StrPath, options: Options | None = None) -> Sequence[Sensor]:
    """The sensors in a log."""
    log, _ = opened(path, options or Options())
    return log.sensors


def gyros(path: StrPath, options: Options) -> list[str | None]:
    """The sensors to analyse, for a command that takes several: the one that was named, or all that
    may be chosen without it. None: the only one."""
    several = [] if options.sensor else sensors.unnamed(listed(path, options))
    return [one.name for one in several] if len(several) > 1 else [options.sensor]


def samples(path: StrPath, options: Options) -> Samples:
    """The Samples of the sensor that was named, or of the only gyro, with what was measured beside
    it. Raises BadInput."""
    log, name = opened(path, options)
    main = sensors.chosen(log.sensors, options.sensor, path)
    found = guarded(path, name, lambda: log.read(main.name))
    for other, quantity in sensors.companions(log.sensors, main):
        if any(name.startswith(quantity) for name in found.columns):
            continue
        there = guarded(path, name, partial(log.read, other.name))
        columns = {
            name: column for name, column in there.columns.items() if name.startswith(quantity)
        }
        if there.stamps_ns is not None and len(there.stamps_ns) and columns:
            found.beside.append((there.stamps_ns, columns))
            found.notes[f"beside, {', '.join(columns)}"] = (
                f"{other.name}, with its own time stamps, interpolated to the gyro time stamps"
            )
    return checked(found, main.name, path, options)


def checked(found: Samples, name: str, path: StrPath, options: Options) -> Samples:
    """Samples that every command can go on with: columns of one length and finite, what was beside
    them at their times, stamps in seconds."""
    count = (
        len(found.stamps_ns)
        if found.stamps_ns is not None
        else len(next(iter(found.columns.values()), ()))
    )
    where = path if found.line is not None else f"{path}: {name}"
    if not count:
        raise BadInput(f"{where}: no samples")
    if found.stamps_ns is not None:
        place(found, found.stamps_ns)
    if options.renames and found.line is None:
        names = text.renamed(list(found.columns), options.renames, path)
        found.columns = dict(zip(names, found.columns.values()))
    text.check_renames(options.renames, options.scales)
    text.scaled(found.columns, options.scales)
    for column, values in found.columns.items():
        sensors.check_finite(values, f"{where}: column {column}")
    odd = next((name for name in found.columns if not tables.is_name(name)), None)
    if odd is not None:
        raise BadInput(
            f"{where}: column {odd[: tables.SHOWN]!r}: not a valid column name of a recording (use "
            "--rename OLD=NEW)"
        )
    return found


def place(found: Samples, stamps_ns: Ints) -> None:
    """Stamps as a column time_s, and what was measured beside, each at its own times, where the
    gyro was read: interpolated between its own."""
    first = int(stamps_ns[0])
    found.origin_ns = first // SECOND * SECOND if abs(first) > FAR_S * SECOND else 0
    for stamps, columns in found.beside:
        own = (stamps - found.origin_ns) / SECOND
        for name, column in columns.items():
            if np.any(np.isfinite(column)):
                order = np.argsort(own, kind="stable")
                found.columns[name] = np.interp(
                    (stamps_ns - found.origin_ns) / SECOND, own[order], column[order]
                ).astype(column.dtype)
    found.columns = {"time_s": (stamps_ns - found.origin_ns) / SECOND, **found.columns}
    found.stamps_ns, found.beside = None, []


def recording_of(found: Samples, path: StrPath, rate_hz: float | None) -> Recording:
    """A Recording on the even grid of the clock."""
    made = recordings.of_columns(
        found.columns, rate_hz or found.rate_hz, path, found.notes, found.line, found.places
    )
    made.origin_ns, made.doubts = found.origin_ns, doubted(found)
    return made


def doubted(found: Samples) -> dict[str, str]:
    """quantity -> why its unit, which was guessed, may be wrong."""
    return {one.quantity: one.doubt for one in found.guesses if one.doubt}


def read(
    path: StrPath, options: Options | None = None, told: Callable[[str], None] = lambda text: None
) -> Recording:
    """The recording in any log, ready for every command. told: hears what was guessed. Raises
    BadInput that names file and reason."""
    options = options or Options()
    found = samples(path, options)
    count = len(next(iter(found.columns.values())))
    why = f" ({', '.join(found.said)})" if found.said else ""
    if count < RECORD.known_least * recordings.MINIMUM_SAMPLES:
        recordings.check_enough(count, 0, path, why)
    made = replace(recording_of(found, path, options.rate_hz), as_recorded=options.as_recorded)
    recordings.check_enough(count, made.missing_samples if not made.rows else 0, path, why)
    note = None if options.as_recorded else plausible.note(found.columns, made.rate_hz)
    for line in (
        *understood(found, made, count, options.rate_hz),
        *said(found),
        *([note] if note else []),
        *(f"doubtful: {one} (or {plausible.CONFIRM})" for one in plausible.of_recording(made)),
    ):
        told(f"{path}: {line}")
    return made


def understood(found: Samples, made: Recording, count: int, rate_hz: float | None) -> Iterator[str]:
    """What a log is, where its columns are not called as davarlab calls them."""
    if any(one.name != one.column for one in found.guesses):
        by = "--rate" if rate_hz else "its time stamps" if "time_s" in found.columns else "the log"
        axes = ", ".join(one for one in made.columns if one.startswith(("gyro_", "accel_")))
        yield f"{count} samples at {made.read_hz or made.rate_hz:.6g} Hz by {by}: {axes}"


def doubts(found: Samples, rate_hz: float) -> list[str]:
    """What is implausible about Samples, before they are on a grid."""
    return plausible.of_recording(
        recordings.Recording(found.columns, rate_hz, notes=found.notes, doubts=doubted(found))
    )


def said(found: Samples) -> Iterator[str]:
    """How a file was read where that was not plain, and what was guessed: a line for each column
    that is not as davarlab would call it."""
    if found.said:
        yield ", ".join(found.said)
    for one in found.guesses:
        if one.unused:
            yield f"{one.name}: {one.unused}"
        elif one.quantity != "other" and (one.name != one.column or not one.sure):
            by = one.by or f"by its {'name' if one.sure else 'numbers'}"
            how = f"{one.unit} {by}" if one.unit else "unchanged"
            yield f"{one.name} -> {one.column}, {how}" + (
                "" if one.sure else f" (--unit {shlex.quote(f'{one.name}=UNIT')} overrides it)"
            )


def write(found: Samples, path: StrPath, rate_hz: float | None, source: StrPath) -> float:
    """Samples as a CSV recording, every one as it was measured: no gap is filled, and where rows
    without a time lack values, the others get one. Returns the rate. Raises BadInput where they are
    no recording: no time and no rate, time that runs backwards."""
    rate = rate_hz or found.rate_hz
    if "time_s" in found.columns:
        rate = clock.found(found.columns["time_s"], rate, source, found.line).rate_hz
    elif not rate:
        raise BadInput(f"{source}: {recordings.no_time(found.columns)}")
    if found.places is not None and "time_s" not in found.columns:
        found.columns = {"time_s": found.places / rate, **found.columns}
    recordings.write_columns(found.columns, found.notes, path, found.origin_ns)
    return rate
