"""Tables of numbers in text files, plain or gzip, read in a stream: ten million rows take little more memory than their numbers."""

import contextlib
import gzip
import zlib

import numpy as np

from ..errors import BadInput
from . import signals

LARGEST = 1e30  # whose square is still a number, and which no sensor says
BLOCK_BYTES = 1 << 22
RESULTS = {"epoch", "window_samples", "arw_deg_per_sqrt_h"}  # columns that davar-sim and `davarlab live --record` write, and no sensor


@contextlib.contextmanager
def opened(path):
    """The bytes of a file, unpacked; damage that shows later is named too."""
    try:
        with open(path, "rb") as raw:
            packed = raw.read(2) == b"\x1f\x8b"
            raw.seek(0)
            yield gzip.GzipFile(fileobj=raw) if packed else raw
    except (EOFError, zlib.error, gzip.BadGzipFile) as why:
        raise BadInput(f"{path}: damaged gzip file ({why})") from None
    except OSError as why:
        raise BadInput(f"{path}: {why.strerror or why}") from None


def text_of(row, path):
    if b"\0" in row:
        raise BadInput(f"{path}: not a text file in UTF-8")
    return row.decode("utf-8", errors="replace").strip().lstrip("\ufeff")


def header(stream, path):
    """The `# key: value` notes, the row of names, and its line number; the stream then stands at the numbers."""
    notes = {}
    for line, row in enumerate(iter(stream.readline, b""), 1):
        row = text_of(row, path)
        if row.startswith("#"):
            key, _, value = row[1:].partition(":")
            notes[key.strip()] = value.strip()
        elif row:
            return notes, row, line
    raise BadInput(f"{path}: no header row and no samples")


def check_names(names, where):
    """Every column has a name of its own, and they are those of samples."""
    if set(names) >= RESULTS:
        raise BadInput(f"{where}: results of davar-sim or davarlab live, one row per epoch; the samples that they were made from are needed")
    for name in names:
        if not name:
            raise BadInput(f"{where}: a column without a name")
        if names.count(name) > 1:
            raise BadInput(f"{where}: column {name} is there twice")


def blocks(stream):
    """The rest of a stream in blocks of whole rows."""
    while block := stream.read(BLOCK_BYTES):
        yield block + stream.readline()


def parsed(block, names, separator):
    """The numbers of a block, one array per name; None where a row is not as it should be, or not as pyarrow takes numbers."""
    from pyarrow import ArrowInvalid, BufferReader, csv, float64
    try:
        found = csv.read_csv(BufferReader(block), csv.ReadOptions(use_threads=False, block_size=len(block) + 1, column_names=names),
                             csv.ParseOptions(delimiter=separator, quote_char=False, double_quote=False),
                             csv.ConvertOptions(column_types=dict.fromkeys(names, float64()), null_values=[]))
    except ArrowInvalid:
        return None
    columns = [column.to_numpy() for column in found.columns]
    return columns if all((np.abs(column) < LARGEST).all() for column in columns) else None


def joined(parts, narrow):
    """One column from its blocks, which are let go."""
    kind = np.float32 if narrow else np.float64
    out = np.empty(sum(map(len, parts)), kind)
    place = 0
    for index, part in enumerate(parts):
        out[place:place + len(part)] = part
        place, parts[index] = place + len(part), None
    return out


def read_columns(stream, names, line, path, separator=","):
    """name -> column; line: that of the header."""
    parts, rows = [[] for _ in names], 0
    for block in blocks(stream):
        found = parsed(block, names, separator)
        found = by_row(block, names, line, path, separator) if found is None else found
        rows += len(found[0])
        line += block.count(b"\n")
        for name, part, column in zip(names, parts, found):
            part.append(column if name == "time_s" or rows < signals.NARROW_FROM else column.astype(np.float32))
    if not rows:
        raise BadInput(f"{path}: no samples")
    return {name: joined(part, rows >= signals.NARROW_FROM and name != "time_s") for name, part in zip(names, parts)}


def by_row(block, names, line, path, separator):
    """The same row by row: names the line and the column of what is no number, and reads what only Python takes for one (a leading +)."""
    found = []
    for number, row in enumerate(block.split(b"\n"), line + 1):
        row = text_of(row, path)
        if row:
            found.append(numbers(row.split(separator), names, f"{path}:{number}"))
    return np.array(found).reshape(-1, len(names)).T


def numbers(fields, names, where):
    if len(fields) != len(names):
        raise BadInput(f"{where}: {len(fields)} fields, the header has {len(names)}")
    try:
        values = [float(field) for field in fields]
    except ValueError:
        name, field = next(pair for pair in zip(names, fields) if not is_number(pair[1]))
        raise BadInput(f"{where}: column {name}: not a number: {field.strip()!r}") from None
    for name, value in zip(names, values):
        if not abs(value) < LARGEST:
            raise BadInput(f"{where}: column {name}: not a finite number below {LARGEST:g}")
    return np.array(values)


def is_number(field):
    with contextlib.suppress(ValueError):
        float(field)
        return True
    return False


def read(path, separators=",", naming=lambda names, where: names):
    """(notes, columns, line of the header) of a file; the first of the separators that its header holds is the file's."""
    with opened(path) as stream:
        notes, row, line = header(stream, path)
        separator = next((s for s in separators if s in row), ",")
        names = [name.strip() for name in row.split(separator)]
        check_names(names, f"{path}:{line}")
        return notes, read_columns(stream, naming(names, path), line, path, separator), line
