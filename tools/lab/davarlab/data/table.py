"""Tables of numbers in text files, plain or gzip, read in a stream: ten million rows take little
more memory than their numbers."""

import contextlib
import csv
import gzip
import io
import os
import re
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Protocol

import numpy as np

from .. import files
from ..arrays import Floats
from ..errors import BadInput
from ..files import StrPath
from . import guess, signals

LARGEST = 1e30  # whose square is still a number, and which no sensor says
BLOCK_BYTES = 1 << 22
# From 0, beyond which a time is kept as a whole origin and what is above it: a double alone has
# Unix times to 0.24 us.
FAR = 1e6
FORMS = {
    "whole": r"[+-]?[0-8]?\d{1,18}",
    "decimal": r"[+-]?\d{1,9}\d?[.,]\d{1,9}",
    "date": r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(\.\d{1,9})?Z?",
}
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# What no name of a column holds.
UNNAMED = re.compile('[,"\x00-\x1f\x7f-\x9f\u2028\u2029\ufeff\ud800-\udfff]')
SHOWN = 80  # characters of a field in a message
UNPACKED_BYTES, UNPACKED_TIMES = 64 << 20, 100  # of a gzip file
LINE_BYTES = 1 << 20  # of the longest line that a table may have
SAFE = 1 << 62  # whole numbers below it can be taken from each other in 64 bits
# Columns that davar-sim and `davarlab live --record` write, and no sensor.
RESULTS = {"epoch", "window_samples", "arw_deg_per_sqrt_h"}


class Stream(Protocol):
    """What is read of a file, packed or not."""

    def read(self, size: int = -1, /) -> bytes: ...

    def readline(self, size: int = -1, /) -> bytes: ...

    def peek(self, size: int, /) -> bytes: ...


class Unpacked(gzip.GzipFile):
    """The text of a gzip file, as far as it is believed: so that a few kilobytes do not fill the
    memory. As davar-sim."""

    def __init__(self, raw: io.BufferedReader, path: StrPath) -> None:
        super().__init__(fileobj=raw)
        self.path, self.most = (
            path,
            max(UNPACKED_BYTES, UNPACKED_TIMES * os.fstat(raw.fileno()).st_size),
        )

    def believed(self, text: bytes) -> bytes:
        if self.tell() > self.most:
            raise BadInput(
                f"{self.path}: the gzip file expands to more than 64 MiB and 100 times its size. "
                "If it is a recording, unpack it first"
            )
        return text

    def read(self, size: int | None = -1) -> bytes:
        return self.believed(super().read(size))

    def readline(self, size: int | None = -1) -> bytes:
        return self.believed(super().readline(size))


@contextlib.contextmanager
def opened(path: StrPath) -> Iterator[Stream]:
    """The bytes of a file, unpacked; damage that shows later is named too."""
    try:
        with files.reading(path) as raw:
            packed = raw.read(2) == b"\x1f\x8b"
            raw.seek(0)
            yield Unpacked(raw, path) if packed else raw
    except (EOFError, zlib.error, gzip.BadGzipFile) as why:
        raise BadInput(f"{path}: damaged gzip file ({why})") from None
    except OSError as why:
        raise BadInput(f"{path}: {why.strerror or why}") from None


def text_of(row: bytes, path: StrPath) -> str:
    if b"\0" in row:
        raise BadInput(f"{path}: not a text file in UTF-8")
    return row.decode("utf-8", errors="replace").strip(" \t\r\n")


def header(stream: Stream, path: StrPath) -> tuple[dict[str, str], str, int]:
    """The `# key: value` notes, the row of names, and its line number; the stream then stands at
    the numbers."""
    notes = {}
    for line, raw in enumerate(iter(lambda: stream.readline(LINE_BYTES + 1), b""), 1):
        check_length(raw, f"{path}:{line}")
        row = text_of(raw, path).removeprefix("\ufeff" if line == 1 else "").lstrip(" ")
        if row.startswith("#"):
            key, _, value = row[1:].partition(":")
            notes[key.strip()] = value.strip()
        elif row:
            return notes, row, line
    raise BadInput(f"{path}: no header row and no samples")


def check_length(row: bytes, where: StrPath) -> None:
    if len(row) > LINE_BYTES:
        raise BadInput(f"{where}: a line longer than {LINE_BYTES} bytes")


def is_name(name: str) -> bool:
    """Can a header of commas hold it, and does it come back as it is?"""
    return (
        bool(name)
        and name == name.strip()
        and not name.startswith("#")
        and not UNNAMED.search(name)
    )


def check_names(names: Sequence[str], where: StrPath) -> None:
    """Every column has a name of its own, and they are those of samples."""
    if set(names) >= RESULTS:
        raise BadInput(
            f"{where}: results of davar-sim or davarlab live, one row per epoch. Use the recording "
            "that they were computed from"
        )
    met = set()
    for name in names:
        if not name:
            raise BadInput(f"{where}: a column without a name")
        if name in met:
            raise BadInput(f"{where}: column {name} appears twice")
        met.add(name)


def blocks(stream: Stream, line: int, path: StrPath) -> Iterator[bytes]:
    """The rest of a stream behind a line in blocks of whole rows."""
    while block := stream.read(BLOCK_BYTES):
        rest = stream.readline(LINE_BYTES + 1)
        line += block.count(b"\n") + rest.count(b"\n")
        check_length(rest, f"{path}:{line + 1}")
        yield block + rest


def split(row: str, separator: str) -> list[str]:
    """The fields of a row, without the quotes about them; as they stand where a quote does not
    close."""
    if separator == " ":
        fields = row.split()
    elif '"' in row:
        try:
            fields = next(
                csv.reader([row], delimiter=separator, skipinitialspace=True, strict=True)
            )
        except csv.Error:
            fields = row.split(separator)
    else:
        fields = row.split(separator)
    return [field.strip(" \t") for field in fields]


@dataclass
class Form:
    """How the rows of a file are to be read: its names and separator, a decimal comma or point, and
    which column is its time, in what form (of FORMS, "" for a plain number), counted from what
    origin (whole, in the unit of the column)."""

    names: list[str]
    separator: str
    decimal: str = "."
    time: str = ""
    kind: str = ""
    origin: int = 0

    def of(self, row: str) -> list[str]:
        """The fields of a row of text."""
        return split(row, self.separator)

    def number(self, field: str) -> str:
        """A field as float() takes it. Raises ValueError for what is no number: a point in a file
        with decimal commas may stand for thousands."""
        text = field.replace(",", ".") if self.decimal == "," and "." not in field else field
        if not NUMBER.fullmatch(text) or self.decimal == "," and "." in field:
            raise ValueError(field)
        return text


def form_of(names: list[str], separator: str, block: bytes) -> Form:
    """Of a file by its first row of numbers."""
    first = (
        next((line for line in block.split(b"\n") if line.strip()), b"")
        .decode("utf-8", errors="replace")
        .strip()
    )
    quoted = (
        first if separator != "," else " ".join(re.findall(r'"[^"]*"', first))
    )  # between commas a decimal comma stands in quotes
    found = Form(names, separator, "," if re.search(r"\d,\d", quoted) else ".")
    found.time = next(
        (name for name in names if name == "time_s"),
        next((name for name in names if guess.quantity_of(name) == "time"), ""),
    )
    fields = found.of(first)
    if found.time and len(fields) == len(names):
        value = fields[names.index(found.time)]
        kind = next(
            (kind for kind, pattern in FORMS.items() if re.fullmatch(pattern, value, re.ASCII)), ""
        )
        with contextlib.suppress(
            ValueError
        ):  # what is no time is said with its line, when the rows are read
            origin = (
                date_ns(value) // 10**9
                if kind == "date"
                else int(Decimal(found.number(value)))
                if abs(float(found.number(value))) < LARGEST
                else 0
            )
            if kind == "date" or FAR < abs(origin) < SAFE:
                found.kind, found.origin = kind, origin
    return found


def date_ns(text: str) -> int:
    """Nanoseconds from 1970 to a date. Raises ValueError for what is none, and for one that 64 bits
    of nanoseconds do not reach (1678 to 2261)."""
    if not re.fullmatch(FORMS["date"], text, re.ASCII):
        raise ValueError(text)
    whole, _, part = text.rstrip("Z").partition(".")
    seconds = int(np.datetime64(whole, "s").astype(np.int64))
    if abs(seconds) * 10**9 >= 2 * SAFE - 10**9:
        raise ValueError(text)
    return seconds * 10**9 + int(part.ljust(9, "0"))


def types_of(form: Form) -> dict[str, Any]:
    """The pyarrow type of each column."""
    from pyarrow import decimal128, float64, int64, timestamp

    times = {"whole": int64(), "decimal": decimal128(28, 9), "date": timestamp("ns", "UTC")}
    return {
        name: times[form.kind] if name == form.time and form.kind else float64()
        for name in form.names
    }


def since(column: Any, form: Form) -> Floats | None:
    """A column of times as seconds, or whatever its unit is, since the origin; None where 64 bits
    do not hold them."""
    if form.kind == "whole":
        ticks, unit = column.to_numpy(), 1
    else:
        pieces, unit = [], 10**9
        for (
            chunk
        ) in column.chunks:  # 16 bytes each, of which the lower 8 hold what fits in them; or 8
            words = np.frombuffer(chunk.buffers()[1], np.int64)
            if form.kind == "decimal":
                if np.any(words[1::2] != words[::2] >> 63):
                    return None
                words = words[::2]
            pieces.append(words[chunk.offset : chunk.offset + len(chunk)])
        ticks = np.concatenate(pieces)
    origin = form.origin * unit
    if abs(origin) >= SAFE or np.any((ticks >= SAFE) | (ticks <= -SAFE)):
        return None
    found: Floats = (ticks - origin).astype(np.float64) / unit
    return found


def parsed(block: bytes, form: Form) -> list[Floats] | None:
    """The numbers of a block, one array per name; None where a row is not as it should be, or not
    as pyarrow takes numbers."""
    from pyarrow import ArrowInvalid, BufferReader, csv

    if block.startswith("\ufeff".encode()):  # which pyarrow leaves out
        return None
    try:
        found = csv.read_csv(
            BufferReader(block),
            csv.ReadOptions(use_threads=False, block_size=len(block) + 1, column_names=form.names),
            csv.ParseOptions(
                delimiter=form.separator,
                quote_char='"' if b'"' in block else False,
                double_quote=False,
            ),
            csv.ConvertOptions(
                column_types=types_of(form), null_values=[], decimal_point=form.decimal
            ),
        )
    except ArrowInvalid:
        return None
    columns = [
        since(column, form)
        if name == form.time and form.kind
        else column.to_numpy() - (form.origin if name == form.time else 0)
        for name, column in zip(form.names, found.columns)
    ]
    usable = [one for one in columns if one is not None and (np.abs(one) < LARGEST).all()]
    return usable if len(usable) == len(columns) else None


def joined(parts: list[Floats], narrow: bool) -> Floats:
    """One column from its blocks, which are let go."""
    kind = np.float32 if narrow else np.float64
    out: Floats = np.empty(sum(map(len, parts)), kind)
    place = 0
    while parts:
        part = parts.pop(0)
        out[place : place + len(part)] = part
        place += len(part)
    return out


def read_columns(
    stream: Stream, names: list[str], line: int, path: StrPath, separator: str = ","
) -> tuple[dict[str, Floats], Form]:
    """(name -> column, Form); line: that of the header."""
    parts: list[list[Floats]] = [[] for _ in names]
    rows = 0
    form: Form | None = None
    for block in blocks(stream, line, path):
        form = form or form_of(names, separator, block)
        block = (
            re.sub(rb"(?m)^ +| +(?=\r?$)", b"", re.sub(rb"[ \t]+", b" ", block))
            if separator == " "
            else block
        )
        found = parsed(block, form)
        found = by_row(block, form, line, path) if found is None else found
        rows += len(found[0])
        line += block.count(b"\n")
        for name, part, column in zip(names, parts, found):
            part.append(
                column
                if name == form.time or rows < signals.NARROW_FROM
                else column.astype(np.float32)
            )
    if form is None or not rows:
        raise BadInput(f"{path}: no samples")
    return {
        name: joined(part, rows >= signals.NARROW_FROM and name != form.time)
        for name, part in zip(names, parts)
    }, form


def by_row(block: bytes, form: Form, line: int, path: StrPath) -> list[Floats]:
    """The same row by row: names the line and the column of what is no number, and reads what only
    Python takes for one (a leading +)."""
    found = []
    for number, raw in enumerate(block.split(b"\n"), line + 1):
        row = text_of(raw, path)
        if row:
            found.append(numbers(form.of(row), form, f"{path}:{number}"))
    return list(np.array(found).reshape(-1, len(form.names)).T)


def numbers(fields: Sequence[str], form: Form, where: StrPath) -> Floats:
    if len(fields) != len(form.names):
        raise BadInput(f"{where}: {len(fields)} fields, the header has {len(form.names)}")
    values = []
    for name, field in zip(form.names, fields):
        try:
            values.append(above(field, form) if name == form.time else float(form.number(field)))
        except ValueError:
            raise BadInput(f"{where}: column {name}: not a number: {field[:SHOWN]!r}") from None
        if not abs(values[-1]) < LARGEST:
            raise BadInput(f"{where}: column {name}: not a finite number below {LARGEST:g}")
    return np.array(values)


def above(field: str, form: Form) -> float:
    """A time since the origin, exact to the last digit that a double then has."""
    if form.kind == "date":
        return (date_ns(field) - form.origin * 10**9) / 1e9
    text = form.number(field)
    return float(Decimal(text) - form.origin) if abs(float(text)) < LARGEST else float(text)


@dataclass
class Table:
    """columns: name -> numbers; line: of the header; time: the column that is taken for the time
    ("" for none), which counts from origin, a whole number of its unit."""

    notes: dict[str, str]
    columns: dict[str, Floats]
    line: int
    time: str
    origin: int


def separated(row: str, separators: str, below: str) -> tuple[str, list[str]]:
    """(separator, names): the first of the separators that the header holds; spaces where the row
    below has as many fields."""
    separator = next(
        (
            one
            for one in separators
            if one in row and (one != " " or len(row.split()) == len(below.split()) > 1)
        ),
        ",",
    )
    return separator, [name.strip('"').strip() for name in split(row, separator)]


def read(
    path: StrPath,
    separators: str = ",",
    naming: Callable[[list[str], StrPath], list[str]] = lambda names, where: names,
) -> Table:
    """The Table in a file; the first of the separators that its header holds is the file's."""
    with opened(path) as stream:
        notes, row, line = header(stream, path)
        below = (
            stream.peek(1 << 12).split(b"\n")[0].decode("utf-8", errors="replace")
            if " " in separators
            else ""
        )
        separator, names = separated(row, separators, below)
        check_names(names, f"{path}:{line}")
        columns, form = read_columns(stream, naming(names, path), line, path, separator)
        return Table(notes, columns, line, form.time, form.origin)
