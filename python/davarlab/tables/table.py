"""Tables of numbers in text files, plain or gzip, read in a stream: ten million rows take little
more memory than their numbers. A row without a value of the sensor is a gap, other missing values
are interpolated."""

import contextlib
import gzip
import io
import itertools
import os
import re
import shlex
import sys
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any, Protocol

import numpy as np

from .. import arrays, files
from ..arrays import Floats, Ints
from ..errors import BadInput
from ..files import StrPath
from . import dialect, guess, labelled, missing, sentences, tagged
from .dialect import Dialect

LARGEST = 1e30  # whose square is still a number, and which no sensor says
BLOCK_BYTES = 1 << 22
# From 0, beyond which a time is kept as a whole origin and what is above it: a double alone has
# Unix times to 0.24 us.
FAR = 1e6
FORMS = {
    "whole": r"[+-]?[0-8]?\d{1,18}",
    "decimal": r"[+-]?\d{1,9}\d?[.,]\d{1,9}",
    "date": dialect.DATE.pattern,
    "clock": dialect.CLOCK.pattern,
}
DAY_S = 86400
# What no name of a column holds.
UNNAMED = re.compile('[,"\x00-\x1f\x7f-\x9f\u2028\u2029\ufeff\ud800-\udfff]')
SHOWN = 80  # characters of a field in a message
EMPTY = ",;| \t"
UNPACKED_BYTES, UNPACKED_TIMES = 64 << 20, 100  # of a gzip file
LINE_BYTES = 1 << 20  # of the longest line that a table may have
LONG_BYTES = 1 << 16  # a row with quotes beyond which pyarrow 19 may crash
HEAD_LINES = 200  # that are looked at for the dialect, comments not counted
UTF_16 = (b"\xff\xfe", b"\xfe\xff")
ENDS = re.compile(rb"(?m)[ \t]*;[ \t]*(?=\r?$)")  # as dialect.END, in a block of rows
# The usual spellings of dialect.MISSING, for pyarrow; by_row() takes the others.
NULLS = ["", "-", "--", "nan", "NaN", "NAN", "-nan", "-NaN", "null", "NULL", "Null", "none", "None"]
NULLS += ["NONE", "na", "NA", "n/a", "N/A", "#N/A", "<NA>", "NaT", "nil", "-nan(ind)", "-1.#IND"]
SAFE = 1 << 62  # whole numbers below it can be taken from each other in 64 bits
# Columns that davar-sim and `davarlab live --record` write, and no sensor.
RESULTS = {"epoch", "window_samples", "arw_deg_per_sqrt_h"}


# (names of columns as they are called, as the file has them, its path) -> names.
Naming = Callable[[list[str], list[str], StrPath], list[str]]


class Stream(Protocol):
    """What is read of a file, packed or not."""

    def read(self, size: int = -1, /) -> bytes: ...

    def readline(self, size: int = -1, /) -> bytes: ...


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
    text = row.decode("utf-8", errors="replace").strip(" \t\r\n")
    if "\r" in text and not is_comment(text):
        raise BadInput(f"{path}: a carriage return within a line")
    return text


@dataclass
class Head:
    """The beginning of a file. notes: its `# key: value` lines; comments: (line, text) of them;
    raw: the lines from the first that is none; start: the line of raw[0]."""

    notes: dict[str, str] = field(default_factory=dict)
    comments: list[tuple[int, str]] = field(default_factory=list)
    raw: list[bytes] = field(default_factory=list)
    start: int = 1

    def rows(self, texts: Sequence[bytes], path: StrPath) -> list[tuple[int, str]]:
        """(line, text) of the rows, without comments and blank lines."""
        found = [(place, text_of(text, path)) for place, text in enumerate(texts, self.start)]
        found[0] = found[0][0], found[0][1].removeprefix("\ufeff").lstrip(" ")
        return [(line, text) for line, text in found if text and not is_comment(text)]


def is_comment(text: str) -> bool:
    return text.startswith(dialect.COMMENTS)


def head(stream: Stream, path: StrPath, skip: int) -> Head:
    """Comments, then the first lines, without the first `skip` of the file; the
    stream then stands behind them."""
    found, rows, size = Head(), 0, 0
    for line, raw in enumerate(iter(lambda: stream.readline(LINE_BYTES + 1), b""), 1):
        check_length(raw, f"{path}:{line}")
        if line == 1 and raw[:2] in UTF_16:
            raise BadInput(
                f"{path}: text in UTF-16. Type iconv -f UTF-16 -t UTF-8 {path} > NEW.csv, and use "
                "NEW.csv"
            )
        if line <= skip:
            continue
        row = text_of(raw, path).removeprefix("\ufeff" if line == 1 else "").lstrip(" ")
        if is_comment(row):
            key, _, value = row.lstrip("#%/").partition(":")
            found.notes[key.strip()] = value.strip()
            found.comments.append((line, row))
            size += len(raw)
        rows += bool(row) and not is_comment(row)
        if rows:
            found.start = found.start if found.raw else line
            found.raw.append(raw)
            size += len(raw)
        if rows == HEAD_LINES or size > LINE_BYTES:
            break
    if not rows and found.comments:
        raise BadInput(
            f"{path}: the first {len(found.comments)} lines are comments, which begin with # or %, "
            "and no row was found. If they are rows (NovAtel), "
            f"type tr -d '#%' < {shlex.quote(str(path))} | tr ';*' , > NEW.csv, and use NEW.csv"
        )
    if not rows:
        raise BadInput(f"{path}: no header row and no samples")
    return found


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


def check_names(names: Sequence[str], where: StrPath, count: int) -> None:
    """Every column that is read, of `count`, has a name of its own, and they are those of
    samples."""
    if set(names) >= RESULTS:
        raise BadInput(
            f"{where}: results of davar-sim or davarlab live, one row per epoch. Use the recording "
            "that they were computed from"
        )
    met = set()
    for name in names:
        if name in met:
            raise BadInput(f"{where}: column {name} appears twice. Type {dialect.example(count)}")
        met.add(name)


def blocks(stream: Stream, first: bytes, line: int, path: StrPath) -> Iterator[bytes]:
    """Lines that were read already and the rest of a stream behind them, in blocks of whole rows;
    line: the one above."""
    if first:
        line += first.count(b"\n")
        yield first
    while block := stream.read(BLOCK_BYTES):
        rest = stream.readline(LINE_BYTES + 1)
        line += block.count(b"\n") + rest.count(b"\n")
        check_length(rest, f"{path}:{line + 1}")
        yield block + rest


@dataclass
class Form:
    """How the rows of a file are to be read: as its dialect says; names and places: of the columns
    that are read, of `count`; called: what all are called without --rename; which column is its
    time, in what form (of FORMS, "" for a plain number), counted from what origin (whole, in the
    unit of the column); stamp: the first time, as text."""

    dialect: Dialect
    names: list[str]
    places: list[int]
    called: list[str]
    time: str = ""
    kind: str = ""
    origin: int = 0
    stamp: str = ""

    @property
    def count(self) -> int:
        return len(self.dialect.names)


def clock_in(names: Sequence[str]) -> str:
    """The column that is taken for the time; "" for none."""
    clocks = [name for name in names if guess.quantity_of(name) == "time"]
    return "time_s" if "time_s" in clocks else next(iter(clocks), "")


def form_of(found: Dialect, names: dict[int, str], called: list[str], first: str) -> Form:
    """Of a file by its first row of numbers; names: place -> name of the columns that are read."""
    made = Form(found, list(names.values()), list(names), called)
    made.time = clock_in(made.names)
    fields = found.fields(first)
    if made.time and len(fields) == made.count:
        value = made.stamp = fields[made.places[made.names.index(made.time)]]
        kind = next(
            (kind for kind, pattern in FORMS.items() if re.fullmatch(pattern, value, re.ASCII)), ""
        )
        with contextlib.suppress(
            ValueError
        ):  # what is no time is said with its line, when the rows are read
            origin = (
                date_ns(value, made.time) // 10**9
                if kind == "date"
                else 0
                if kind == "clock"
                else int(Decimal(found.number(value)))
                if abs(float(found.number(value))) < LARGEST
                else 0
            )
            if kind in ("date", "clock") or FAR < abs(origin) < SAFE:
                made.kind, made.origin = kind, origin
    return made


def date_ns(text: str, name: str) -> int:
    """Nanoseconds from 1970 to a date. The `Chip Time` of WitMotion ends in a count of milliseconds
    (16:44:16.5 is 5 ms after the second), as everything behind a colon does. Raises ValueError for
    what is none, and for one that 64 bits of nanoseconds do not reach (1678 to 2261)."""
    if not re.fullmatch(FORMS["date"], text, re.ASCII):
        raise ValueError(text)
    numbers = re.split(r"\D", text.rstrip("Z"))
    year, month, day, hour, minute, second = (one.rjust(2, "0") for one in numbers[:6])
    whole = np.datetime64(f"{year}-{month}-{day}T{hour}:{minute}:{second}", "s")
    seconds = int(whole.astype(np.int64))
    if abs(seconds) * 10**9 >= 2 * SAFE - 10**9:
        raise ValueError(text)
    part = "".join(numbers[6:])
    counted = "chip" in name.lower() or text.count(":") > 2
    return seconds * 10**9 + int((part.rjust(3, "0") if counted else part).ljust(9, "0"))


def clock_s(text: str) -> float:
    """A time of day in seconds. Raises ValueError for what is none."""
    if not dialect.CLOCK.fullmatch(text):
        raise ValueError(text)
    hour, minute, second = text.split(":")
    return int(hour) * 3600 + int(minute) * 60 + float(second)


def after_midnight(times: Floats) -> Floats:
    """Times of day that continue after midnight."""
    days = np.cumsum(np.diff(times, prepend=times[:1]) < -DAY_S / 2)
    continued: Floats = times + DAY_S * days
    return continued


def types_of(form: Form) -> dict[str, Any]:
    """The pyarrow type of each column that is read, by its place."""
    from pyarrow import decimal128, float64, int64, time64, timestamp

    times = {"whole": int64(), "decimal": decimal128(28, 9), "date": timestamp("ns", "UTC")}
    times["clock"] = time64("ns")
    return {
        str(place): times[form.kind] if name == form.time and form.kind else float64()
        for place, name in zip(form.places, form.names)
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
    if form.kind == "date" and "chip" in form.time.lower():
        return None
    quotes = block.count(b'"')
    if quotes % 2:  # one is not closed
        return None
    if quotes and max(map(len, block.split(b"\n"))) > LONG_BYTES:
        return None
    try:
        found = csv.read_csv(
            BufferReader(block),
            csv.ReadOptions(
                use_threads=False,
                block_size=len(block) + 1,
                column_names=[str(place) for place in range(form.count)],
            ),
            csv.ParseOptions(
                delimiter=form.dialect.separator,
                quote_char='"' if quotes else False,
                double_quote=False,
            ),
            csv.ConvertOptions(
                column_types=types_of(form),
                include_columns=[str(place) for place in form.places],
                null_values=NULLS,
                decimal_point=form.dialect.decimal,
            ),
        )
    except ArrowInvalid:
        return None
    if quotes and found.num_rows != sum(map(bool, map(bytes.strip, block.split(b"\n")))):
        return None  # a line that ends within quotes
    columns = []
    for name, column in zip(form.names, found.columns):
        timed = name == form.time
        whole = timed and bool(form.kind)
        if timed and column.null_count:
            return None
        values = since(column, form) if whole else column.to_numpy()
        if (
            values is None
            or not ((np.abs(values) < LARGEST) | (not timed) & np.isnan(values)).all()
        ):
            return None
        columns.append(values - form.origin if timed and not whole else values)
    return columns


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


def let_go() -> None:
    """Returns to the system what pyarrow keeps of the blocks that it has parsed."""
    if "pyarrow" in sys.modules:
        sys.modules["pyarrow"].default_memory_pool().release_unused()


def read_columns(
    rows: Iterable[bytes], form: Form, line: int, path: StrPath
) -> tuple[dict[str, Floats], str]:
    """(name -> column, what was left out at the end); rows: in blocks; line: the one above them."""
    parts: list[list[Floats]] = [[] for _ in form.names]
    count, cut = 0, ""
    for block in rows:
        if form.dialect.ended:
            block = ENDS.sub(b"", block)
        if form.dialect.separator == " ":
            block = re.sub(rb"(?m)^ +| +(?=\r?$)", b"", re.sub(rb"[ \t]+", b" ", block))
        found = parsed(block, form)
        if found is None:
            found, cut = by_row(block, form, line, path)
        count += len(found[0])
        line += block.count(b"\n")
        for name, part, column in zip(form.names, parts, found):
            part.append(
                column
                if name == form.time or count < arrays.NARROW_FROM
                else column.astype(np.float32)
            )
    if not count:
        raise BadInput(f"{path}: no samples")
    return {
        name: joined(part, count >= arrays.NARROW_FROM and name != form.time)
        for name, part in zip(form.names, parts)
    }, cut


def by_row(block: bytes, form: Form, line: int, path: StrPath) -> tuple[list[Floats], str]:
    """The same row by row: names the line and the column of what is no number, and reads what only
    Python takes for one (a leading +). Leaves out a last row that was cut off, and says so."""
    found, cut = [], ""
    rows = block.split(b"\n")
    for number, raw in enumerate(rows, line + 1):
        row = text_of(raw, path)
        if is_blank(row, form) or is_comment(row):
            continue
        fields = form.dialect.fields(row)
        if number == line + len(rows) and len(fields) < form.count:
            cut = f"line {number} is cut off and skipped"
        else:
            found.append(numbers(fields, form, f"{path}:{number}"))
    return list(np.array(found).reshape(-1, len(form.names)).T), cut


def is_blank(row: str, form: Form) -> bool:
    """A row of nothing but separators is blank, if a time places the others."""
    return not (row.strip(EMPTY) if form.time else row)


def numbers(fields: Sequence[str], form: Form, where: StrPath) -> Floats:
    if len(fields) != form.count:
        raise BadInput(f"{where}: {len(fields)} fields, the rows above have {form.count}")
    if any(text.startswith('"') for text in fields):
        raise BadInput(f"{where}: a quote that is not closed")
    values = []
    for name, place in zip(form.names, form.places):
        text = fields[place]
        if name != form.time and dialect.is_missing(text):
            values.append(np.nan)
            continue
        try:
            values.append(
                above(text, form) if name == form.time else float(form.dialect.number(text))
            )
        except ValueError:
            raise BadInput(
                f"{where}: column {name}: not a number: {text[:SHOWN]!r}{way_on(name, form)}"
            ) from None
        if not abs(values[-1]) < LARGEST:
            raise BadInput(
                f"{where}: column {name}: not a finite number below {LARGEST:g}{way_on(name, form)}"
            )
    return np.array(values)


def way_on(name: str, form: Form) -> str:
    """What to type where a column beside the gyro has no numbers."""
    if guess.quantity_of(name) == "gyro" or form.count == 1:
        return ""
    if name == form.time:
        return without_time(form)
    return f". To do without this column, type {without([name], form)}"


def without(names: Collection[str], form: Form) -> str:
    """The --names that skip columns, and name the others as the file does."""
    typed = [dialect.SKIP] * form.count
    for name, place in zip(form.names, form.places):
        called = UNNAMED.sub(" ", form.called[place]).strip()
        typed[place] = dialect.SKIP if name in names else called
    return f"--names {shlex.quote(','.join(typed))}"


def without_time(form: Form, rate_hz: str = "") -> str:
    """What to type where the time cannot be used; rate_hz: of its median step, "" where unknown."""
    times = [name for name in form.names if guess.quantity_of(name) == "time"]
    if len(times) == form.count:
        return ""
    known = f". Its median step gives {rate_hz} Hz" * bool(rate_hz)
    typed = f"{without(times, form)} --rate {rate_hz or 'HZ'}"
    return f"{known}. To do without this column, type {typed}"


def above(text: str, form: Form) -> float:
    """A time since the origin, exact to the last digit that a double then has."""
    if form.kind == "date":
        return (date_ns(text, form.time) - form.origin * 10**9) / 1e9
    if form.kind == "clock":
        return clock_s(text)
    text = form.dialect.number(text)
    return float(Decimal(text) - form.origin) if abs(float(text)) < LARGEST else float(text)


@dataclass
class Table:
    """columns: name -> numbers; line: the one above the numbers; form: of the rows; places: of
    the samples among them, which are those with all values of the sensor (None: all rows); named:
    the file or its reader has names for the columns, else they are column_1 ..; said: how the file
    was read, where it is not plain CSV; rates: in Hz, that the text above
    the numbers states; above: that text, by lines; wire: how its rows stand in sentences."""

    notes: dict[str, str]
    columns: dict[str, Floats]
    line: int
    form: Form
    places: Ints | None
    named: bool
    said: list[str]
    rates: list[float]
    above: list[str]
    wire: sentences.Sentences | sentences.Monitor | labelled.Labelled | tagged.Tagged | None = None

    @property
    def time(self) -> str:
        """The column that is taken for the time, "" for none."""
        return self.form.time

    @property
    def origin(self) -> int:
        """What the time counts from, a whole number of its unit."""
        return self.form.origin

    @property
    def count(self) -> int:
        """Of the columns in the file, with those that are skipped."""
        return self.form.count


def line_of(found: Table, sample: int, path: StrPath) -> int:
    """The line in which a sample of a table stands, for a message."""
    row = sample if found.places is None else int(found.places[sample])
    with opened(path) as stream:
        lines = enumerate(iter(stream.readline, b""), 1)
        below = ((number, raw) for number, raw in lines if number > found.line)
        if found.wire:
            below = ((number, found.wire.rows([raw], number, path)[0]) for number, raw in below)
        texts = ((number, text_of(raw, path)) for number, raw in below)
        rows = (
            number
            for number, text in texts
            if not is_blank(text, found.form) and not is_comment(text)
        )
        return next(itertools.islice(rows, row, None))


def columns_called(found: Dialect) -> list[str]:
    """The names of all columns; column_2 .. for those without, "" for those without anything."""
    return [
        name or f"column_{place + 1}" * (place not in found.blank)
        for place, name in enumerate(found.names)
    ]


def left_out(found: Dialect, names: Sequence[str], given: Sequence[str] | None) -> dict[int, str]:
    """place -> why: columns that are not read. A gyro, an accelerometer, a temperature and the only
    time are, so that what is no number in them is an error."""
    clocks = {place for place, name in enumerate(names) if guess.quantity_of(name) == "time"}
    out = {place: "" for place, name in enumerate(given or ()) if name == dialect.SKIP}
    idle = found.bare | {place for place in found.dates if names[place] != clock_in(names)}
    if len(found.bare) == len(names):
        return out
    for place in idle - set(out):
        if not dialect.recognised([names[place]]) or clocks - idle and place in clocks:
            out[place] = "text" if place not in found.blank else "empty" if names[place] else ""
    return out


def with_parts(columns: dict[str, Floats], time: str) -> list[str]:
    """Adds to a time in whole seconds what a second column has of each (sec and usec, as of struct
    timeval), which is then left out; says so."""
    if not time or guess.said_unit(time, "time") != "s":
        return []
    whole = columns[time]
    for name, parts in columns.items():
        size = guess.SECONDS.get(guess.said_unit(name, "time"), 1.0)
        if (
            size < 1
            and guess.quantity_of(name) == "time"
            and np.all(whole == np.floor(whole))
            and np.all((parts >= 0) & (parts * size < 1))
        ):
            columns[time] = whole + columns.pop(name) * size
            return [f"{name} added to {time}"]
    return []


def read(
    path: StrPath,
    given: Sequence[str] | None = None,
    naming: Naming = lambda names, written, where: names,
    skip: int = 0,
) -> Table:
    """The Table in a file, however it is written (dialect.py). given: names for its columns, over
    those of the file; naming: renames them; skip: lines at the beginning that are not read."""
    with opened(path) as stream:
        top = head(stream, path, skip)
        wire = (
            sentences.sentences_in(top.raw)
            or labelled.labelled_in(top.raw)
            or sentences.monitor_in(top.raw)
            or tagged.tagged_in(top.raw)
        )
        texts = top.raw if wire is None else wire.rows(top.raw, top.start, path)
        rows = top.rows(texts, path)
        given = wire.named(given) if wire else given
        comments = wire.comments(top.comments) if isinstance(wire, tagged.Tagged) else top.comments
        found = dialect.sniffed(rows, comments, given, path)
        line = rows[found.first][0] if found.first < len(rows) else top.start + len(top.raw)
        if isinstance(wire, labelled.Labelled):  # the first row may have begun above
            line = top.start
        written = columns_called(found)
        called, by_file = guess.by_file(written, path)
        names = naming(called, written, path)
        out = left_out(found, names, given)
        kept = {place: name for place, name in enumerate(names) if place not in out}
        if not kept:
            raise BadInput(f"{path}:{line}: no column of numbers is left to read")
        check_names(list(kept.values()), f"{path}:{line - 1}", len(names))
        form = form_of(found, kept, called, rows[found.first][1] if found.first < len(rows) else "")
        rest = blocks(stream, b"".join(top.raw[line - top.start :]), line - 1, path)
        if wire:
            rest = wire.translated(rest, line - 1, path)
        columns, cut = read_columns(rest, form, line - 1, path)
    let_go()
    if form.kind == "clock":
        columns[form.time] = after_midnight(columns[form.time])
    added = with_parts(columns, form.time)
    whole = missing.settled(columns, form.time, path, lambda names: without(names, form))
    gone = [f"{names[place]} ({why})" for place, why in out.items() if why]
    gone += [f"{name} (empty)" for name in whole.empty]
    said = [
        *([f"{skip} line{'s' * (skip > 1)} skipped, as chosen"] if skip else []),
        *([wire.said] if wire and wire.said else []),
        *found.said,
        *([by_file] if by_file else []),
        *added,
        *([f"skipped: {', '.join(gone)}"] if gone else []),
        *([cut] if cut else []),
        *whole.said,
    ]
    above = [text for at, text in rows if at < line]
    stated = dialect.rates_in([*(f"{key}: {value}" for key, value in top.notes.items()), *above])
    return Table(
        top.notes,
        whole.columns,
        line - 1,
        form,
        whole.places,
        found.named,
        said,
        stated,
        above,
        wire,
    )
