"""A recording: samples on a uniform grid with the columns that were logged beside them."""

import gzip
import io
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .. import files
from ..errors import BadInput

TO_DPS = {"dps": 1.0, "rad_s": 180.0 / np.pi}
MINIMUM_SAMPLES = 1000
LARGEST = 1e30  # whose square is still a number, and which no sensor says
SPREAD_DPS = (1e-15, 1e15)  # of a rate whose unit may be right
RATES_HZ = (1e-9, 1e9)  # that a gyro may have
DOUBTFUL_RATE = 0.01  # between --rate and the time stamps, as in davar-sim


@dataclass
class Recording:
    """Columns by name (all of one length), the sample rate, and where samples are missing (index of the first sample after)."""
    columns: dict
    rate_hz: float
    name: str = ""
    notes: dict = field(default_factory=dict)
    gaps: np.ndarray = field(default_factory=lambda: np.array([], int))
    measured: dict = field(default_factory=dict)  # Allan deviations of its columns that were asked for before (compare.py)

    @property
    def samples(self):
        return len(next(iter(self.columns.values())))

    @property
    def time_s(self):
        """Seconds from the first sample."""
        if "time_s" in self.columns and len(self.gaps):
            return self.columns["time_s"] - self.columns["time_s"][0]
        return np.arange(self.samples) / self.rate_hz

    def column(self, name):
        if name not in self.columns:
            raise BadInput(f"{self.name}: no column {name} (there are: {', '.join(self.columns)})")
        return self.columns[name]

    def rate_dps(self, name):
        """A gyro column in deg/s."""
        unit = next((unit for unit in TO_DPS if name.endswith("_" + unit)), None)
        if unit is None:
            raise BadInput(f"{self.name}: column {name} is not in deg/s or rad/s (its name must end in _dps or _rad_s)")
        rate = self.column(name) * TO_DPS[unit]
        spread = float(np.ptp(rate))
        if spread and not SPREAD_DPS[0] < spread < SPREAD_DPS[1]:
            raise BadInput(f"{self.name}: column {name}: values {spread:.3g} deg/s apart are no gyro's")
        return rate


def open_bytes(path):
    try:
        data = Path(path).read_bytes()
    except OSError as why:
        raise BadInput(f"{path}: {why.strerror}") from None
    if data[:2] != b"\x1f\x8b":
        return data
    try:
        return gzip.decompress(data)
    except (OSError, EOFError, zlib.error) as why:
        raise BadInput(f"{path}: damaged gzip file ({why})") from None


def open_text(path):
    text = open_bytes(path).decode("utf-8", errors="replace")
    if "\0" in text:
        raise BadInput(f"{path}: not a text file in UTF-8")
    return text


def split_header(text, path):
    """The `# key: value` notes, the column names, and the line number and offset where the numbers begin."""
    notes, offset, line = {}, 0, 0
    while offset < len(text):
        end = text.find("\n", offset)
        end = len(text) if end < 0 else end
        row, offset, line = text[offset:end].strip().lstrip("\ufeff"), end + 1, line + 1
        if row.startswith("#"):
            key, _, value = row[1:].partition(":")
            notes[key.strip()] = value.strip()
        elif row:
            return notes, [name.strip() for name in row.split(",")], line, offset
    raise BadInput(f"{path}: no header row and no samples")


def check_names(names, where):
    """Every column has a name of its own."""
    for name in names:
        if not name:
            raise BadInput(f"{where}: a column without a name")
        if names.count(name) > 1:
            raise BadInput(f"{where}: column {name} is there twice")


def locate_bad_row(text, first_line, names, path):
    """Names the line and column that numpy could not read."""
    for number, row in enumerate(io.StringIO(text), first_line + 1):
        fields = row.strip().split(",")
        if not row.strip():
            continue
        if len(fields) != len(names):
            raise BadInput(f"{path}:{number}: {len(fields)} fields, the header has {len(names)}")
        for name, value in zip(names, fields):
            try:
                float(value)
            except ValueError:
                raise BadInput(f"{path}:{number}: column {name}: not a number: {value.strip()!r}") from None
    raise BadInput(f"{path}: unreadable numbers")


def read_numbers(text, line, names, path):
    if not text.strip():
        raise BadInput(f"{path}: no samples")
    try:
        table = np.loadtxt(io.StringIO(text), delimiter=",", ndmin=2, comments=None)
    except ValueError:
        locate_bad_row(text, line, names, path)
    if table.shape[1] != len(names):
        locate_bad_row(text, line, names, path)
    bad = np.argwhere(~(np.abs(table) < LARGEST))
    if len(bad):
        rows = [i for i, row in enumerate(io.StringIO(text), line + 1) if row.strip()]
        raise BadInput(f"{path}:{rows[bad[0][0]]}: column {names[bad[0][1]]}: not a finite number below {LARGEST:g}")
    return table


def agreed(rate_hz, stamped_hz, path):
    """The rate that was given, if any; time stamps that contradict it win, so it is refused."""
    if rate_hz and abs(stamped_hz / rate_hz - 1) > DOUBTFUL_RATE:
        raise BadInput(f"--rate: {rate_hz:g} Hz, but column time_s of {path} says {stamped_hz:.6g} Hz; it decides: leave --rate out, "
                       "or mend time_s")
    return rate_hz or stamped_hz


def clock(columns, rate_hz, path, line):
    """The rate and the gaps that the time stamps say; the median step is the period."""
    if "time_s" not in columns:
        if not rate_hz:
            raise BadInput(f"{path}: no column time_s and no --rate")
        return rate_hz, np.array([], int)
    if not len(columns["time_s"]) > 1:
        raise BadInput(f"{path}: one sample has no rate")
    steps = np.diff(columns["time_s"])
    back = np.flatnonzero(steps < 0)
    if len(back):
        raise BadInput(f"{path}:{line + back[0] + 2}: column time_s: time runs backwards")
    step = np.median(steps)
    mean = (columns["time_s"][-1] - columns["time_s"][0]) / len(steps)
    if not mean > 0:
        raise BadInput(f"{path}: column time_s: time stands still")
    jitter = step < 0.5 * mean and np.percentile(steps, 99) < 20 * mean
    if jitter or step <= 0:  # arrival times of a bursty host: the samples are as steady as their count
        return agreed(rate_hz, 1.0 / mean, path), np.array([], int)
    regular = steps[np.abs(steps - step) < 0.5 * step]
    return agreed(rate_hz, 1.0 / regular.mean(), path), np.flatnonzero(steps > 1.5 * step) + 1


def read(path, rate_hz=None):
    """Reads a CSV or .csv.gz recording. Raises BadInput that names file, line and column."""
    text = open_text(path)
    notes, names, line, offset = split_header(text, path)
    check_names(names, f"{path}:{line}")
    table = read_numbers(text[offset:], line, names, path)
    if len(table) < MINIMUM_SAMPLES:
        raise BadInput(f"{path}: {len(table)} samples; at least {MINIMUM_SAMPLES} are needed")
    columns = dict(zip(names, np.ascontiguousarray(table.T)))
    rate, gaps = clock(columns, rate_hz, path, line)
    if not RATES_HZ[0] < rate < RATES_HZ[1]:
        raise BadInput(f"{path}: column time_s says {rate:g} samples per second")
    return Recording(columns, float(rate), str(path), notes, gaps)


def write(recording, path):
    """Writes CSV (gzip when the name ends in .gz), whole or not at all."""
    table = np.column_stack(list(recording.columns.values()))
    text = io.StringIO()
    text.writelines(f"# {key}: {value}\n" for key, value in recording.notes.items())
    text.write(",".join(recording.columns) + "\n")
    np.savetxt(text, table, fmt="%.9g", delimiter=",")
    data = text.getvalue().encode()
    files.write_whole(path, gzip.compress(data, 1) if Path(path).suffix == ".gz" else data)
