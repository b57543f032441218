"""Tables of numbers in text files, plain or gzip, read in a stream: ten million rows take little more memory than their numbers."""

import contextlib
import gzip
import re
import zlib
from dataclasses import dataclass

import numpy as np

from ..errors import BadInput
from . import guess, signals

LARGEST = 1e30  # whose square is still a number, and which no sensor says
BLOCK_BYTES = 1 << 22
FAR = 1e6  # from 0, beyond which a time is kept as a whole origin and what is above it: a double alone has Unix times to 0.24 us
FORMS = {"whole": r"[+-]?[0-8]?\d{1,18}", "decimal": r"[+-]?\d{1,9}\d?[.,]\d{1,9}", "date": r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(\.\d{1,9})?Z?"}
QUOTED = '(?=(?:[^"]*"[^"]*")*[^"]*$)'  # behind which every quote is closed again: not inside of one
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


@dataclass
class Form:
    """How the rows of a file are to be read: its names and separator, a decimal comma or point, and which column is its time, in what form (of
    FORMS, "" for a plain number), counted from what origin (whole, in the unit of the column)."""
    names: list
    separator: str
    decimal: str = "."
    time: str = ""
    kind: str = ""
    origin: int = 0

    def of(self, row):
        """The fields of a row of text."""
        fields = row.split() if self.separator == " " else re.split(self.separator + QUOTED, row)
        return [field.strip().strip('"').replace(self.decimal, ".") for field in fields]


def form_of(names, separator, block):
    """Of a file by its first row of numbers."""
    first = next((line for line in block.split(b"\n") if line.strip()), b"").decode("utf-8", errors="replace").strip()
    quoted = first if separator != "," else " ".join(re.findall(r'"[^"]*"', first))  # between commas a decimal comma stands in quotes
    found = Form(names, separator, "," if re.search(r"\d,\d", quoted) else ".")
    found.time = next((name for name in names if name == "time_s"), next((name for name in names if guess.quantity_of(name) == "time"), ""))
    fields = found.of(first)
    if found.time and len(fields) == len(names):
        value = fields[names.index(found.time)]
        kind = next((kind for kind, pattern in FORMS.items() if re.fullmatch(pattern, value)), "")
        origin = origin_of(value, kind)
        if kind == "date" or abs(origin) > FAR:
            found.kind, found.origin = kind, origin
    return found


def origin_of(value, kind):
    """The whole number at or below a first time, as text of a form; 0 for what is no number."""
    if kind == "date":
        return int(np.datetime64(value.rstrip("Z"), "s").astype(np.int64))
    if kind == "whole":
        return int(value)
    return int(float(value)) if is_number(value) and abs(float(value)) < LARGEST else 0


def types_of(form):
    """The pyarrow type of each column."""
    from pyarrow import decimal128, float64, int64, timestamp
    times = {"whole": int64(), "decimal": decimal128(28, 9), "date": timestamp("ns", "UTC")}
    return {name: times[form.kind] if name == form.time and form.kind else float64() for name in form.names}


def since(column, form):
    """A column of times as seconds, or whatever its unit is, since the origin."""
    if form.kind == "whole":
        return (column.to_numpy() - form.origin).astype(np.float64)
    pieces = []
    for chunk in column.chunks:  # 16 bytes each, of which the lower 8 hold what fits in them; or 8
        words = np.frombuffer(chunk.buffers()[1], np.int64)
        pieces.append(words[::2][chunk.offset:chunk.offset + len(chunk)] if form.kind == "decimal" else words[chunk.offset:chunk.offset + len(chunk)])
    return (np.concatenate(pieces) - form.origin * 10**9) / 1e9


def parsed(block, form):
    """The numbers of a block, one array per name; None where a row is not as it should be, or not as pyarrow takes numbers."""
    from pyarrow import ArrowInvalid, BufferReader, csv
    try:
        found = csv.read_csv(BufferReader(block), csv.ReadOptions(use_threads=False, block_size=len(block) + 1, column_names=form.names),
                             csv.ParseOptions(delimiter=form.separator, quote_char='"' if b'"' in block else False, double_quote=False),
                             csv.ConvertOptions(column_types=types_of(form), null_values=[], decimal_point=form.decimal))
    except ArrowInvalid:
        return None
    columns = [since(column, form) if name == form.time and form.kind else column.to_numpy() - (form.origin if name == form.time else 0)
               for name, column in zip(form.names, found.columns)]
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
    """(name -> column, Form); line: that of the header."""
    parts, rows, form = [[] for _ in names], 0, None
    for block in blocks(stream):
        form = form or form_of(names, separator, block)
        block = re.sub(rb"(?m)^ +| +(?=\r?$)", b"", re.sub(rb"[ \t]+", b" ", block)) if separator == " " else block
        found = parsed(block, form)
        found = by_row(block, form, line, path) if found is None else found
        rows += len(found[0])
        line += block.count(b"\n")
        for name, part, column in zip(names, parts, found):
            part.append(column if name == form.time or rows < signals.NARROW_FROM else column.astype(np.float32))
    if not rows:
        raise BadInput(f"{path}: no samples")
    return {name: joined(part, rows >= signals.NARROW_FROM and name != form.time) for name, part in zip(names, parts)}, form


def by_row(block, form, line, path):
    """The same row by row: names the line and the column of what is no number, and reads what only Python takes for one (a leading +)."""
    found = []
    for number, row in enumerate(block.split(b"\n"), line + 1):
        row = text_of(row, path)
        if row:
            found.append(numbers(form.of(row), form, f"{path}:{number}"))
    return np.array(found).reshape(-1, len(form.names)).T


def numbers(fields, form, where):
    if len(fields) != len(form.names):
        raise BadInput(f"{where}: {len(fields)} fields, the header has {len(form.names)}")
    try:
        values = [above(field, form) if name == form.time else float(field) for name, field in zip(form.names, fields)]
    except ValueError:
        name, field = next(pair for pair in zip(form.names, fields) if not is_number(pair[1]))
        raise BadInput(f"{where}: column {name}: not a number: {field.strip()!r}") from None
    for name, value in zip(form.names, values):
        if not abs(value) < LARGEST:
            raise BadInput(f"{where}: column {name}: not a finite number below {LARGEST:g}")
    return np.array(values)


def above(field, form):
    """A time since the origin."""
    if form.kind == "date":
        return float((np.datetime64(field.rstrip("Z"), "ns").astype(np.int64) - form.origin * 10**9) / 1e9)
    return float(field) - form.origin


def is_number(field):
    with contextlib.suppress(ValueError):
        float(field)
        return True
    return False


@dataclass
class Table:
    """columns: name -> numbers; line: of the header; time: the column that is taken for the time ("" for none), which counts from origin, a
    whole number of its unit."""
    notes: dict
    columns: dict
    line: int
    time: str
    origin: int


def separated(row, separators, below):
    """(separator, names): the first of the separators that the header holds; spaces where the row below has as many fields."""
    separator = next((one for one in separators if one in row and (one != " " or len(row.split()) == len(below.split()) > 1)), ",")
    fields = row.split() if separator == " " else row.split(separator)
    return separator, [name.strip().strip('"').strip() for name in fields]


def read(path, separators=",", naming=lambda names, where: names):
    """The Table in a file; the first of the separators that its header holds is the file's."""
    with opened(path) as stream:
        notes, row, line = header(stream, path)
        below = stream.peek(1 << 12).split(b"\n")[0].decode("utf-8", errors="replace") if " " in separators else ""
        separator, names = separated(row, separators, below)
        check_names(names, f"{path}:{line}")
        columns, form = read_columns(stream, naming(names, path), line, path, separator)
        return Table(notes, columns, line, form.time, form.origin)
