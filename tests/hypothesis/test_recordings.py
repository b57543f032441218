"""Recordings in text: the values are those of csv and Python's own numbers, or the file is
rejected. Written and read again it is the same.
"""

import csv
import gzip
import io
import math
import re
import unittest
from decimal import Decimal
from profile import examples

import asked
import numpy as np
from damage import damaged
from davarlab.data import recording as recordings
from davarlab.data import table
from davarlab.errors import BadInput
from hypothesis import given
from hypothesis import strategies as st

NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
CLOCKS = {"time_s", "t", "time"}
LARGEST = 1e30
ROWS = "".join(
    f"{1700000000 + place / 50:.3f},{math.sin(place * place % 997):.6g},{place % 7 - 3}\n"
    for place in range(40)
)
VALID = f"# sensor: a\n# unit: \u00b5\ntime_s,gyro_z_dps,temp_degC\n{ROWS}".encode()
WORDS = [
    "",
    "0",
    "-0",
    "+1",
    "1.5",
    " 2 ",
    "-3e2",
    "1e-310",
    "5e-324",
    "1e29",
    "1e30",
    "1e400",
    "-1E+5",
    "nan",
    "NaN",
    "inf",
    "-Infinity",
    "null",
    "NA",
    "true",
    "0x10",
    "1_0",
    "1__0",
    "\u0661",
    "\u00b2",
    "1,5",
    "1;5",
    "1.2.3",
    "--1",
    "1e",
    "e1",
    ".",
    "-.5",
    "5.",
    "1 2",
    '"1"',
    '"1',
    "'1'",
    "\t1",
    "1\r",
    "\x0b1",
    "1\x00",
    "\ufeff1",
    "1d5",
    "1f",
    "1L",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073.709551616",
    "1700000000.000000001",
    "1700000000123456789",
    "2024-01-01 00:00:00",
    "2024-13-45 00:00:00",
    "9999-12-31T23:59:59Z",
    "0000-01-01 00:00:00",
    "2024-02-30 00:00:00.5",
    "0.1",
    "123456789.123456789",
]
PLAIN = st.one_of(
    st.floats(-1e29, 1e29).map(repr),
    st.integers(-(10**18), 10**18).map(str),
    st.decimals(-(10**6), 10**6, places=6).map(str),
)
FIELD = st.one_of(PLAIN, PLAIN, st.sampled_from(WORDS))
NAMES = st.lists(
    st.sampled_from(
        ["time_s", "gyro_z_dps", "gyro_x_rad_s", "temp_degC", "accel_x_g", "other", "t", "time"]
    ),
    min_size=1,
    max_size=4,
    unique=True,
)


def is_number(text):
    return bool(NUMBER.fullmatch(text)) and abs(float(text)) < LARGEST


@st.composite
def tables(draw, field=FIELD):
    """(names, rows of fields)."""
    names = draw(NAMES)
    return names, draw(
        st.lists(st.lists(field, min_size=len(names), max_size=len(names)), min_size=1, max_size=8)
    )


def numbers_of(found, name):
    """The values read, as Decimals: the time with its origin."""
    origin = found.origin if name == found.time else 0
    return [origin + Decimal(value) for value in found.columns[name].tolist()]


class Read(asked.Lawful):
    def read(self, data):
        """The table; None where it is rejected, or has no names, which every command rejects."""
        try:
            found = table.read(self.file("r.csv", data))
            return found if found.named else None
        except BadInput as why:
            self.assertIn("r.csv", str(why))
            return None

    def independently(self, data):
        """(names, columns of Decimals) by csv; None if a field is not a number. A column
        without any number is not read where its name is unknown or another one is the time."""
        try:
            rows = [
                row
                for row in csv.reader(io.StringIO(data, newline=""), strict=True)
                if row and (len(row) > 1 or row[0].strip())
            ]
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
        if not rows or any(len(row) != len(names) or not all(map(is_number, row)) for row in rows):
            return None
        return names, [[Decimal(row[place]) for row in rows] for place in range(len(names))]

    @given(tables())
    @examples(400)
    def test_a_table_is_read_as_csv_reads_it_or_rejected(self, made):
        names, rows = made
        data = ",".join(names) + "\n" + "".join(",".join(row) + "\n" for row in rows)
        found, wanted = self.read(data), self.independently(data)
        if found is None and wanted and len(wanted[0]) < len(names):
            return  # a column without numbers is skipped, or the table is rejected
        if found is None or wanted is None:
            self.assertTrue(
                wanted is None
                and (found is None or found.time and "-" in rows[0][names.index(found.time)][1:]),
                f"{'refused' if found is None else 'taken: ' + str(found.columns)}: {data!r}",
            )
            return
        form = found.time and re.fullmatch(
            r"[0-9]{1,18}|[0-9]{1,10}\.[0-9]{1,9}", rows[0][names.index(found.time)].strip()
        )  # stamps that are kept exactly
        for name, column in zip(*wanted):
            for value, exact in zip(numbers_of(found, name), column):
                if name == found.time:
                    size = abs(exact - found.origin) if form else max(abs(exact), abs(found.origin))
                    self.assertLessEqual(
                        abs(value - exact),
                        max(Decimal("1e-9"), size * Decimal("2.3e-16")),
                        (name, data),
                    )
                else:
                    self.assertEqual(float(value), float(exact), (name, data))

    @given(tables(st.one_of(st.floats(-1e9, 1e9), st.integers(-(10**9), 10**9)).map(repr)))
    @examples(100)
    def test_a_decimal_comma_changes_nothing(self, made):
        names, rows = made
        if len(names) == 1 or not any("." in field for field in rows[0]):
            return  # header and first row identify the file
        text = ";".join(names) + "\n" + "".join(";".join(row) + "\n" for row in rows)
        points, commas = self.read(text), self.read(text.replace(".", ","))
        self.assertEqual(
            {name: column.tolist() for name, column in points.columns.items()},
            {name: column.tolist() for name, column in commas.columns.items()},
        )

    def test_a_point_among_decimal_commas_may_stand_for_thousands(self):
        self.assertIsNone(self.read("time_s;gyro_z_dps\n0,5;1,5\n1,0;1.500\n"))

    def test_indices_above_64_bits_do_not_wrap(self):
        for first, second in (
            ("1700000000.000", "20146744073.709551616"),
            ("-8000000000000000000", "8000000000000000000"),
            ("1700000000.5", "9999999999.5"),
        ):
            found = self.read(f"time_s,gyro_z_dps\n{first},0\n{second},0\n")
            self.assertAlmostEqual(
                found.columns["time_s"][1],
                float(Decimal(second) - found.origin),
                delta=abs(float(second)) * 1e-15,
            )

    def test_bad_dates_are_reported_with_their_line(self):
        for date in (
            "9999-12-31 23:59:59",
            "2024-13-01 00:00:00",
            "1600-01-01 00:00:00",
            "2024-01-01 24:61:00",
        ):
            for rows in (
                f"{date},0\n2024-01-01 00:00:01,0\n",
                f"2024-01-01 00:00:01,0\n{date},0\n",
            ):
                with self.assertRaisesRegex(BadInput, r"r.csv:[23]: column time: not a number"):
                    table.read(self.file("r.csv", f"time,gyro_z_dps\n{rows}"))

    def test_one_long_line_is_rejected_quickly(self):
        for data in (
            b"a,b\n" + b"," * 3_000_000,
            b"a," * 3_000_000,
            b"a,b\n1,2\n" + b'","' * 300_000,
            b"," * 1_000_000 + b"\n1\n",
        ):
            self.asked(
                self.work / "out.csv",
                "import",
                self.file("r.csv", data),
                "-o",
                self.work / "out.csv",
            )

    @given(
        st.one_of(
            st.binary(max_size=200),
            damaged(VALID),
            damaged(VALID).map(gzip.compress),
            damaged(gzip.compress(VALID, mtime=0)),
            st.text(
                st.sampled_from('time_s,gyro_z_dps\n\r\t;#: "0123456789.eE+-\ufeff\x00\x1b'),
                max_size=200,
            ),
        )
    )
    @examples(300)
    def test_any_bytes_are_read_or_rejected(self, data):
        self.asked(
            self.work / "out.csv", "import", self.file("r.csv", data), "-o", self.work / "out.csv"
        )


COLUMN = st.text(
    st.characters(
        blacklist_categories=("Cs", "Cc", "Zl", "Zp", "Zs"), blacklist_characters=',"#\ufeff'
    ),
    min_size=1,
    max_size=8,
)
NOTE = COLUMN.filter(str.isprintable)
VALUES = st.floats(-1e29, 1e29)


class Written(asked.Lawful):
    """Writes a recording and reads it back."""

    @given(
        st.data(),
        st.integers(1, 40),
        st.dictionaries(COLUMN, st.just(0), max_size=3),
        st.sampled_from((".csv", ".csv.gz")),
        st.sampled_from((0, 1_700_000_000 * 10**9, -86400 * 10**9)),
        st.dictionaries(NOTE.filter(lambda key: ":" not in key), NOTE, max_size=2),
    )
    @examples(120)
    def test_comes_back_to_nine_digits_and_a_nanosecond(
        self, data, count, names, ending, origin_ns, notes
    ):
        names = [name for name in names if name != "time_s"] + ["gyro_z_dps"]
        names = list(dict.fromkeys(names))
        if set(names) >= table.RESULTS:
            return
        time = np.sort(
            np.array(data.draw(st.lists(st.integers(0, 10**13), min_size=count, max_size=count)))
            / 1e6
        )
        columns = {"time_s": time} | {
            name: np.array(data.draw(st.lists(VALUES, min_size=count, max_size=count)))
            for name in names
        }
        path = self.work / f"r{ending}"
        recordings.write_columns(columns, notes, path, origin_ns)
        found = table.read(path)
        self.assertEqual(list(found.columns), list(columns))
        self.assertEqual(found.notes, notes)
        for name in names:
            np.testing.assert_array_equal(
                found.columns[name], [float(f"{value:.9g}") for value in columns[name].tolist()]
            )
        for value, was in zip(numbers_of(found, "time_s"), time.tolist()):
            self.assertLess(
                abs(value - Decimal(was) - Decimal(origin_ns) / 10**9), Decimal("2.6e-9")
            )
        again = self.work / f"again{ending}"
        recordings.write_columns(found.columns, found.notes, again, found.origin * 10**9)
        once, twice = (
            gzip.decompress(one.read_bytes()) if ending.endswith("gz") else one.read_bytes()
            for one in (path, again)
        )
        if origin_ns > 0:
            self.assertEqual(once, twice)


if __name__ == "__main__":
    unittest.main()
