"""Recordings in text: the values are those of csv and Python's own numbers, or the file is
rejected. Written and read again it is the same. Damaged text: test_logs.py.
"""

import csv
import gzip
import io
import re
from decimal import Decimal

import numpy as np
import pytest
from davarlab.data import recording as recordings
from davarlab.errors import BadInput
from davarlab.tables import table
from hypothesis import assume, given
from hypothesis import strategies as st
from lawful import examples

NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
CLOCKS = {"time_s", "t", "time"}
MISSING = {"", "nan", "inf", "-infinity", "null", "na"}  # in small letters, of WORDS
LARGEST = 1e30
WORDS = (
    *("", "0", "-0", "+1", "1.5", " 2 ", "-3e2", "1e-310", "5e-324", "1e29", "1e30", "1e400"),
    *("-1E+5", "nan", "NaN", "inf", "-Infinity", "null", "NA", "true", "0x10", "1_0", "1__0"),
    *("\u0661", "\u00b2", "1,5", "1;5", "1.2.3", "--1", "1e", "e1", ".", "-.5", "5.", "1 2"),
    *('"1"', '"1', "'1'", "\t1", "1\r", "\x0b1", "1\x00", "\ufeff1", "1d5", "1f", "1L"),
    *("9223372036854775807", "9223372036854775808", "18446744073.709551616"),
    *("1700000000.000000001", "1700000000123456789", "2024-01-01 00:00:00"),
    *("2024-13-45 00:00:00", "9999-12-31T23:59:59Z", "0000-01-01 00:00:00"),
    *("2024-02-30 00:00:00.5", "0.1", "123456789.123456789"),
)
WRITTEN = st.floats(-1e29, 1e29)
PLAIN = st.one_of(
    WRITTEN.map(repr),
    st.integers(-(10**18), 10**18).map(str),
    st.decimals(-(10**6), 10**6, places=6).map(str),
)
FIELD = st.one_of(PLAIN, PLAIN, st.sampled_from(WORDS))
HEADER = st.lists(
    st.sampled_from(
        ("time_s", "gyro_z_dps", "gyro_x_rad_s", "temp_degC", "accel_x_g", "other", "t", "time")
    ),
    min_size=1,
    max_size=4,
    unique=True,
)


@st.composite
def tables(draw, field=FIELD):
    """(names, rows of fields)."""
    names = draw(HEADER)
    row = st.lists(field, min_size=len(names), max_size=len(names))
    return names, draw(st.lists(row, min_size=1, max_size=8))


def is_number(text):
    return bool(NUMBER.fullmatch(text)) and abs(float(text)) < LARGEST


def numbers_of(found, name):
    """The values read, as Decimals: the time with its origin."""
    origin = found.origin if name == found.time else 0
    return [origin + Decimal(value) for value in found.columns[name].tolist()]


def taken(work, data):
    """The table; None where it is rejected, or has no names, which every command rejects."""
    try:
        found = table.read(work.file("r.csv", data))
        return found if found.named else None
    except BadInput as why:
        assert "r.csv" in str(why)
        return None


def independently(data):
    """(names, columns of Decimals) by csv; None if a field is not a number. A column without any
    number is not read where its name is unknown or another one is the time. None for a value that
    is missing.
    """
    try:
        rows = csv.reader(io.StringIO(data, newline=""), strict=True)
        rows = [row for row in rows if row and (len(row) > 1 or row[0].strip())]
    except csv.Error:
        return None
    if "\0" in data:
        return None
    names, rows = rows[0], [[field.strip(" \t") for field in row] for row in rows[1:]]
    if all(len(row) == len(names) + 1 and not row[-1] for row in rows):
        rows = [row[:-1] for row in rows]  # each row ends with a comma
    if any(len(row) != len(names) for row in rows):
        return None
    some = {name for name, *column in zip(names, *rows) if any(map(NUMBER.fullmatch, column))}
    spare = {"other"} | (CLOCKS if some & CLOCKS else set()) if some else set()
    kept = [place for place, name in enumerate(names) if name in some or name not in spare]
    names, *rows = [[row[place] for place in kept] for row in (names, *rows)]
    cells = [[None if field.lower() in MISSING else field for field in row] for row in rows]
    if not rows or not all(field is None or is_number(field) for row in cells for field in row):
        return None
    return names, [[field and Decimal(field) for field in column] for column in zip(*cells)]


@given(made=tables())
@examples(300)
def test_a_table_is_read_as_csv_reads_it_or_rejected(work, made):
    names, rows = made
    data = ",".join(names) + "\n" + "".join(",".join(row) + "\n" for row in rows)
    found, wanted = taken(work, data), independently(data)
    if found is None and wanted and (len(wanted[0]) < len(names) or None in sum(wanted[1], [])):
        return  # a column without numbers is skipped, or the table is rejected
    if found is None or wanted is None:
        assert wanted is None, data
        # a date may be the time
        assert found is None or found.time and "-" in rows[0][names.index(found.time)][1:], data
        return
    stamp = found.time and rows[0][names.index(found.time)].strip()
    count = len(wanted[1][0])
    kept = range(count) if found.places is None else found.places.tolist()
    lost = set(range(count)) - set(kept)
    assert all(any(column[row] is None for column in wanted[1]) for row in lost), data
    assert None not in dict(zip(*wanted)).get(found.time, []), data
    exactly = stamp and re.fullmatch(r"[0-9]{1,18}|[0-9]{1,10}\.[0-9]{1,9}", stamp)
    for name, column in zip(*wanted):
        if name not in found.columns:
            assert set(column) == {None}, data
            continue
        for value, row in zip(numbers_of(found, name), kept, strict=True):
            exact = column[row]
            if exact is None:
                assert value.is_finite(), (name, data)
                continue
            if name != found.time:
                assert float(value) == float(exact), (name, data)
                continue
            size = abs(exact - found.origin) if exactly else max(abs(exact), abs(found.origin))
            allowed = max(Decimal("1e-9"), size * Decimal("2.3e-16"))
            assert abs(value - exact) <= allowed, (name, data)


@given(made=tables(st.one_of(st.floats(-1e9, 1e9), st.integers(-(10**9), 10**9)).map(repr)))
@examples(60)
def test_a_decimal_comma_changes_nothing(work, made):
    names, rows = made
    assume(len(names) > 1 and any("." in field for field in rows[0]))  # these show what it is
    text = ";".join(names) + "\n" + "".join(";".join(row) + "\n" for row in rows)
    points, commas = taken(work, text), taken(work, text.replace(".", ","))
    for name, column in points.columns.items():
        assert column.tolist() == commas.columns[name].tolist()


def test_a_point_among_decimal_commas_may_stand_for_thousands(work):
    assert taken(work, "time_s;gyro_z_dps\n0,5;1,5\n1,0;1.500\n") is None


@pytest.mark.parametrize(
    "first, second",
    [
        ("1700000000.000", "20146744073.709551616"),
        ("-8000000000000000000", "8000000000000000000"),
        ("1700000000.5", "9999999999.5"),
    ],
)
def test_indices_above_64_bits_do_not_wrap(work, first, second):
    found = taken(work, f"time_s,gyro_z_dps\n{first},0\n{second},0\n")
    wanted = float(Decimal(second) - found.origin)
    assert abs(found.columns["time_s"][1] - wanted) <= abs(float(second)) * 1e-15


@pytest.mark.parametrize(
    "date",
    ["9999-12-31 23:59:59", "2024-13-01 00:00:00", "1600-01-01 00:00:00", "2024-01-01 24:61:00"],
)
@pytest.mark.parametrize("line", [2, 3])
def test_a_bad_date_is_reported_with_its_line(work, date, line):
    rows = ["2024-01-01 00:00:01,0"]
    rows.insert(line - 2, f"{date},0")
    path = work.file("r.csv", "\n".join(["time,gyro_z_dps", *rows, ""]))
    with pytest.raises(BadInput, match=rf"r.csv:{line}: column time: not a number"):
        table.read(path)


COLUMN = st.text(
    st.characters(
        blacklist_categories=("Cs", "Cc", "Zl", "Zp", "Zs"), blacklist_characters=',"#\ufeff'
    ),
    min_size=1,
    max_size=8,
)
NOTE = COLUMN.filter(str.isprintable)


@given(
    data=st.data(),
    count=st.integers(1, 40),
    names=st.lists(COLUMN, max_size=3, unique=True),
    ending=st.sampled_from((".csv", ".csv.gz")),
    origin_ns=st.sampled_from((0, 1_700_000_000 * 10**9, -86400 * 10**9)),
    notes=st.dictionaries(NOTE.filter(lambda key: ":" not in key), NOTE, max_size=2),
)
@examples(80)
def test_a_recording_comes_back_to_nine_digits_and_a_nanosecond(
    work, data, count, names, ending, origin_ns, notes
):
    names = [one for one in names if one not in ("time_s", "gyro_z_dps")] + ["gyro_z_dps"]
    assume(not set(names) >= table.RESULTS)
    stamps = data.draw(st.lists(st.integers(0, 10**13), min_size=count, max_size=count))
    columns = {"time_s": np.sort(np.array(stamps) / 1e6)}
    for name in names:
        columns[name] = np.array(data.draw(st.lists(WRITTEN, min_size=count, max_size=count)))
    path, again = work / f"r{ending}", work / f"again{ending}"
    recordings.write_columns(columns, notes, path, origin_ns)
    found = table.read(path)
    assert list(found.columns) == list(columns)
    assert found.notes == notes
    for name in names:
        wanted = [float(f"{value:.9g}") for value in columns[name].tolist()]
        assert found.columns[name].tolist() == wanted
    for value, was in zip(numbers_of(found, "time_s"), columns["time_s"].tolist()):
        exact = Decimal(was) + Decimal(origin_ns) / 10**9
        assert abs(value - exact) < Decimal("2.6e-9")
    recordings.write_columns(found.columns, found.notes, again, found.origin * 10**9)
    texts = [one.read_bytes() for one in (path, again)]
    texts = [gzip.decompress(one) if ending.endswith("gz") else one for one in texts]
    if origin_ns > 0:
        assert texts[0] == texts[1]
