"""How a text file writes its table: separator, decimal point or comma, preamble, names and units,
found from its first lines, as a person would who opens it in an editor.

Sentences like those of NMEA 0183 are rows, too: `$TAG,number,..*CHECKSUM`, with a time in front of
the $ or none. The checksum is that of NMEA 0183 (two digits, exclusive or) or VectorNav's 16 bits
(four digits, CRC-16-CCITT)."""

import csv
import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from ..errors import BadInput
from ..files import StrPath
from ..thresholds import GUESS
from . import guess

COMMENTS = ("#", "%", "//")
# (separator, decimal) as they are tried; the first of those that explain the rows equally well.
WRITTEN = (
    (",", "."),
    (";", "."),
    ("\t", "."),
    (" ", "."),
    ("|", "."),
    (";", ","),
    ("\t", ","),
    (" ", ","),
    (",", ","),
)
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
DATE = re.compile(r"\d{4}[-/]\d\d?[-/]\d\d?[T ]\d\d?:\d\d?:\d\d?([.:]\d{1,9})?Z?", re.ASCII)
CLOCK = re.compile(r"\d\d?:[0-5]\d:[0-5]\d(\.\d{1,9})?", re.ASCII)  # a time of day
NAMED = {",": "commas", ";": "semicolons", "\t": "tabs", " ": "spaces", "|": "bars"}
# What stands for a value that is missing, MSVC's -1.#IND and R's NA among them.
MISSING = re.compile(
    r"|[+-]?(nan(\(\w*\))?|inf|infinity|1\.#[a-z]+)|null|nil|none|nat|<na>|#?n/?a|-+",
    re.ASCII | re.IGNORECASE,
)
BOOLEAN = re.compile("true|false", re.IGNORECASE)
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}", re.ASCII)
# Words of a row of units.
UNITS = set(
    re.findall(
        r"\S+",
        "deg degree degrees degc c k rad radian radians dps mdps mdeg g mg gauss mgauss m mps "
        "mps2 s2 s sec secs second seconds ms msec us usec \u00b5s \u03bcs ns nsec hz pa hpa kpa "
        "bar mbar v mv a ma n ut \u00b5t \u03bct nt count counts lsb raw bool int float double "
        "string",
    )
)
SIGN = re.compile(r"[-%\u00b0\u00ba]?")  # of a unit without a word
END = re.compile(r"[ \t]*;[ \t]*$")
COLUMNS_MOST = 10_000
SKIP = "_"  # name of a column that is not read
EXAMPLES = "time_us, gyro_x_dps, accel_x_g or temp_degC"
REPLACED = re.compile(r"NAME_\d+|\.\.")  # what a message shows for a name that is to be typed
LISTED_MOST = 12  # names in such a message
# A sample rate that a text above the numbers states: its number, the unit in front or behind. A
# rate of nothing needs the unit.
STATED = re.compile(
    r"(?<![a-z])(?:(?P<whole>f_?s|odr|rate_hz|"
    r"(?:(?:sampl\w*|updat\w*|output|data|log\w*|measurement|acquisition)[ _-]*)+(?:rate|freq\w*))"
    r"|rate|freq\w*|sampl\w*|log\w*|record\w*)(?: ?\(odr\))?"
    r"(?:[ _]*[(\[]?(?P<front>k?hz|sps)[)\]]?)?(?: is| of| at| @)?[\s:=,;\"]*"
    r"(?P<number>\d+\.?\d*(?:e[+-]?\d+)?)(?![\d.]|,\d)\s*(?P<behind>k?hz|sps|samples)?"
    r"(?!\s*(?:[a-z%\u00b0]|\u00b5s))",  # FS: 2000 dps is a full scale
    re.IGNORECASE | re.ASCII,
)
SHOWN = 60  # characters of a row in a message


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


def with_point(field: str, decimal: str) -> str:
    """A number as float() takes it. Raises ValueError for what is no number: a point in a file with
    decimal commas may stand for thousands."""
    text = field.replace(",", ".") if decimal == "," and "." not in field else field
    if not NUMBER.fullmatch(text) or decimal == "," and "." in field:
        raise ValueError(field)
    return text


def is_date(field: str) -> bool:
    return bool(DATE.fullmatch(field) or CLOCK.fullmatch(field))


def is_number(field: str, decimal: str) -> bool:
    try:
        with_point(field, decimal)
    except ValueError:
        return is_date(field)
    return True


def is_missing(field: str) -> bool:
    return bool(MISSING.fullmatch(field))


def worth(fields: Sequence[str], decimal: str) -> float:
    """How well a row of fields looks like one of numbers; 0: not at all."""
    numbers = sum(is_number(one, decimal) for one in fields)
    missing = sum(map(is_missing, fields))
    return max(0.0, numbers - (len(fields) - missing - numbers) / 2)


def tried(rows: Sequence[str], separator: str, decimal: str) -> tuple[float, int]:
    """(how well a separator and a decimal sign explain the rows, the number of fields then)."""
    found: dict[int, float] = defaultdict(float)
    for row in rows:
        fields = split(row, separator)
        # Of one field, no separator is seen.
        if len(fields) > 1 or (separator, decimal) == (",", ".") or '"' in row:
            found[len(fields)] += worth(fields, decimal)
    count = max(found, key=lambda one: found[one], default=0)
    return found.get(count, 0.0), count


def written(rows: Sequence[str]) -> tuple[str, str, int]:
    """(separator, decimal, fields in a row); where no row holds numbers, by the first of them."""
    best = (0.0, WRITTEN[0], 0)
    for one in WRITTEN:
        if one == (",", ",") and not any('"' in row for row in rows):
            continue  # between commas, a decimal comma stands in quotes
        value, count = tried(rows, *one)
        if value > best[0]:
            best = (value, one, count)
    if best[0]:
        return *best[1], best[2]
    separator = next((one for one in ";\t," if one in rows[0]), ",")
    return separator, ".", len(split(rows[0], separator))


def recognised(names: Iterable[str]) -> int:
    """How many different things names say their columns are."""
    said = {(guess.quantity_of(name), guess.axis_of(name), name) for name in names}
    return sum(
        quantity in ("time", "temp") or quantity in ("gyro", "accel") and bool(axis)
        for quantity, axis, _ in said
    )


def is_unit(text: str) -> bool:
    words = re.findall(r"[^\W\d_]+\d?", text.lower())
    return set(words) <= UNITS if words else bool(SIGN.fullmatch(text.strip("[]() ")))


def are_units(fields: Sequence[str]) -> bool:
    """Are these the units below the names: most of them are, and none is a number."""
    said = [one for one in fields if one]
    return 2 * sum(map(is_unit, said)) > len(said) and not any(is_number(one, ".") for one in said)


def may_name(fields: Sequence[str], decimal: str) -> bool:
    """Can a row be the names? A number among them is one where others say what they are."""
    if recognised(fields):
        return True
    return any(fields) and not any(
        is_number(one, decimal) or one and is_missing(one) or BOOLEAN.fullmatch(one)
        for one in fields
    )


def grouped(above: Sequence[str], below: Sequence[str]) -> list[str]:
    """Names in two rows, of which the upper one is written over the first of a group."""
    out, group = [], ""
    for upper, lower in zip(above, below):
        group = upper or group
        out.append(f"{group} {lower}".strip())
    return out


def with_unit(name: str, unit: str) -> str:
    """A name with the unit below it, where it does not say one itself."""
    bare = unit.strip("[]() -")
    said = any(guess.said_unit(name, quantity) for quantity in guess.UNITS)
    return f"{name} [{bare}]" if bare and not said else name


@dataclass
class Dialect:
    """names: of all columns, "" for none; named: the file has names; first: index of the first row
    of numbers; bare: places of columns without any number, of which the `blank` hold nothing;
    dates: of those with dates or times of day; ended: a semicolon ends the rows, whatever separates
    their fields; said: how the rows are read, where that is not plain CSV."""

    separator: str
    decimal: str
    names: list[str]
    named: bool
    first: int
    bare: set[int] = field(default_factory=set)
    blank: set[int] = field(default_factory=set)
    dates: set[int] = field(default_factory=set)
    ended: bool = False
    said: list[str] = field(default_factory=list)

    def fields(self, row: str) -> list[str]:
        """The fields of a row of text."""
        return split(END.sub("", row) if self.ended else row, self.separator)

    def number(self, text: str) -> str:
        """A field as float() takes it. Raises ValueError."""
        return with_point(text, self.decimal)


@dataclass
class Header:
    """names; first, last: the rows that they stand in, by index, units included."""

    names: list[str]
    first: int
    last: int
    units: bool = False


def header_of(rows: Sequence[list[str]], count: int, decimal: str) -> Header | None:
    """The names in the rows above the numbers: the row with a name for each column that says most,
    alone or with the groups above it; and the units in the row below it."""
    able = [
        place
        for place, fields in enumerate(rows)
        if len(fields) == count and may_name(fields, decimal)
    ]
    found = [Header(rows[place], place, place) for place in able]
    found += [
        Header(grouped(rows[place - 1], rows[place]), place - 1, place)
        for place in able
        if place - 1 in able and not are_units(rows[place])
    ]
    if not found:
        return None
    best = max(found, key=lambda one: (recognised(one.names), len(set(one.names))))
    below = best.last + 1
    if below in able and are_units(rows[below]):
        names = [with_unit(name, unit) for name, unit in zip(best.names, rows[below])]
        return Header(names, best.first, below, True)
    return best


def in_comments(
    comments: Sequence[tuple[int, str]], line: int, separator: str, count: int
) -> list[str] | None:
    """The names in the last comment above a line (numpy.savetxt, rostopic, EuRoC)."""
    text = next((text for place, text in reversed(comments) if place < line), "")
    for one in dict.fromkeys((separator, ",", ";", "\t", " ")):
        names = split(text.lstrip("#%/ \t"), one)
        if len(names) == count and recognised(names):
            return names
    return None


def example(count: int) -> str:
    """What to type for so many columns, in words that are to be replaced."""
    names = [f"NAME_{place + 1}" for place in range(count)]
    shown = names if count <= LISTED_MOST else [*names[:2], "..", names[-1]]
    return f"a name such as {EXAMPLES} for each, or {SKIP} to skip one: --names {','.join(shown)}"


def check_given(given: Sequence[str]) -> None:
    """Raises BadInput for names that were typed as a message shows them."""
    for one in filter(REPLACED.fullmatch, given):
        raise BadInput(
            f"--names: {one} stands for a name. Type what the column holds ({EXAMPLES}), or {SKIP} "
            "to skip it"
        )


def rates_in(texts: Iterable[str]) -> list[float]:
    """The sample rates that texts above the numbers state, in Hz."""
    found = []
    for one in (one for text in texts for one in STATED.finditer(text)):
        unit = one["front"] or one["behind"]
        if unit or one["whole"]:
            found.append(float(one["number"]) * (1e3 if (unit or "").lower() == "khz" else 1))
    return [rate for rate in dict.fromkeys(found) if rate > 0]


def check_thousands(rows: Sequence[Sequence[str]], path: StrPath) -> None:
    """Raises BadInput where decimal commas may as well stand for thousands."""
    cells = list(zip(*rows))
    commas = [one for column in cells for one in column if "," in one]
    mixed = any(
        any("," in one for one in column) and any(one and "," not in one for one in column)
        for column in cells
    )
    if len(commas) >= GUESS.few_thousands and mixed and all(map(THOUSANDS.fullmatch, commas)):
        raise BadInput(
            f"{path}: {commas[0]} may be {commas[0].replace(',', '.')} or "
            f"{commas[0].replace(',', '')}. Type tr , . < {path} > NEW.csv if the comma is a "
            f"decimal comma, or tr -d , < {path} > NEW.csv if it separates thousands"
        )


@dataclass
class Body:
    """The rows of numbers among the first rows. first: the index of the first; count: of their
    columns, without what separators at the end of each row add; filled, blank: which columns have a
    number, and which hold nothing."""

    first: int
    count: int
    filled: set[int]
    blank: set[int]


def body_of(fields: Sequence[list[str]], width: int, decimal: str) -> Body:
    """Of rows of fields of which those with `width` are the numbers."""
    able = [place for place, one in enumerate(fields) if len(one) == width and worth(one, decimal)]
    filled = {
        column
        for place in able
        for column, one in enumerate(fields[place])
        if is_number(one, decimal)
    }
    whole = [
        place
        for place in able
        if all(
            is_number(fields[place][one], decimal) or is_missing(fields[place][one])
            for one in filled
        )
    ]
    full = (place for place in whole if not any(is_missing(fields[place][one]) for one in filled))
    first = next(full, (whole or able or [len(fields) and 1])[0])
    while first - 1 in whole:
        first -= 1
    rows = [one for one in fields[first:] if len(one) == width]
    blank = {
        column for column in range(width) if rows and all(is_missing(one[column]) for one in rows)
    }
    count = width
    while count > 1 and count - 1 in blank and not any(one[count - 1] for one in rows):
        count -= 1
    return Body(first, count, filled, blank)


def sniffed(
    rows: Sequence[tuple[int, str]],
    comments: Sequence[tuple[int, str]],
    given: Sequence[str] | None,
    path: StrPath,
) -> Dialect:
    """The Dialect of a file by its first rows and comments, as (line, text); given: names over
    those of the file. Raises BadInput that says what to type."""
    check_given(given or ())
    texts = [text for _, text in rows]
    ended = are_ended(texts)
    texts = [END.sub("", text) for text in texts] if ended else texts
    separator, decimal, width = written(texts)
    if width > COLUMNS_MOST:
        raise BadInput(f"{path}:{rows[0][0]}: {width} columns; at most {COLUMNS_MOST} are read")
    fields = [split(text, separator) for text in texts]
    body = body_of(fields, width, decimal)
    if not body.filled and len(rows) > 1:
        raise BadInput(
            f"{path}:{rows[1][0]}: no numbers in this row or the first ones below: "
            f"{texts[1][:SHOWN]!r}. Rows of numbers between commas, semicolons, tabs or spaces are "
            "needed"
        )
    if decimal == ",":
        check_thousands([one for one in fields[body.first :] if len(one) == width], path)
    count, heads = body.count, fields[: body.first]
    header = (
        header_of([unended(one, count) for one in heads], count, decimal)
        or header_of(heads, width, decimal)
        or header_of([of_columns(one, count) for one in heads], count, decimal)
    )
    first = header.last + 1 if header and given is None else body.first
    line = rows[min(first, len(rows) - 1)][0]
    names = header.names if header else in_comments(comments, line, separator, count)
    if given is None and names is None:
        check_above(heads, count, rows, path)
    if given is not None and len(given) not in (count, width):
        raise BadInput(
            f"--names: {len(given)} names, but {path} has {count} columns "
            f"(line {line}: {texts[min(first, len(rows) - 1)][:SHOWN]})"
        )
    said = as_read(separator, decimal, header, rows, first)
    if header and (spare := heads[header.first][len(header.names) :]) and any(spare):
        said.append(f"names without a column: {', '.join(filter(None, spare))}")
    if header is None and names is not None:
        said.append("names from the comment above the numbers")
    named = list(given) if given is not None else names or []
    return Dialect(
        separator,
        decimal,
        named + [""] * (width - len(named)),
        bool(named),
        first,
        set(range(width)) - body.filled,
        body.blank,
        {
            place
            for place in body.filled
            if all(is_date(one[place]) for one in fields[first:] if len(one) == width)
        },
        ended,
        said,
    )


def unended(fields: list[str], count: int) -> list[str]:
    """Fields without the empty ones behind the last column."""
    return fields[:count] if not any(fields[count:]) else fields


def of_columns(names: list[str], count: int) -> list[str]:
    """Names of the columns that there are, without those behind them: only where these are no gyro
    that the others lack."""
    rest = names[count:]
    gyro = [
        any(guess.quantity_of(name) == "gyro" for name in some) for some in (names[:count], rest)
    ]
    return names[:count] if rest and recognised(names[:count]) and gyro != [False, True] else names


def are_ended(texts: Sequence[str]) -> bool:
    """Does a semicolon end most rows, and separate nothing in any."""
    ends = sum(text.endswith(";") for text in texts)
    return 2 * ends > len(texts) and not any(";" in END.sub("", text) for text in texts)


def check_above(
    heads: Sequence[Sequence[str]], count: int, rows: Sequence[tuple[int, str]], path: StrPath
) -> None:
    """Raises BadInput where a row above the numbers has names, but not one for each column."""
    for fields, (line, _) in reversed(list(zip(heads, rows))):
        if not recognised(fields):
            continue
        commas = (
            " Decimal commas between commas cannot be distinguished: if there are any, write ; "
            "between the numbers."
            if len(fields) < count <= 2 * len(fields)
            else ""
        )
        raise BadInput(
            f"{path}:{line}: {len(fields)} names above rows of {count} fields.{commas} Type "
            f"{example(count)}"
        )


def as_read(
    separator: str,
    decimal: str,
    header: Header | None,
    rows: Sequence[tuple[int, str]],
    first: int,
) -> list[str]:
    """How a file is read, in words; nothing where it is plain CSV."""
    out = []
    if separator != ",":
        out.append(f"separated by {NAMED[separator]}")
    if decimal == ",":
        out.append("decimal commas")
    if skipped := header.first if header else first:
        out.append(f"{skipped} line{'s' * (skipped > 1)} above the table skipped")
    if header and header.last > header.first:
        lines = f"lines {rows[header.first][0]} to {rows[header.last][0]}"
        out.append(f"names{' and units' * header.units} from {lines}")
    return out
