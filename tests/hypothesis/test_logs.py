"""Damaged logs of other programs: each is read or rejected in one line. Values that are read were
in the log. A length field in a file is not trusted.
"""

import csv
import tempfile
import unittest
from decimal import Decimal
from pathlib import Path
from profile import examples

import asked
import numpy as np
import writing_logs as writing
from damage import damaged
from davarlab.data import table
from hypothesis import given
from hypothesis import strategies as st

TRUTH = writing.Truth(count=24)


def made(write, name):
    """The bytes of a small log."""
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder) / name) or Path(folder) / name
        return path.read_bytes()


LOGS = {  # name: its bytes
    "a.ulg": made(lambda path: writing.ulog(path, TRUTH, gyros=1), "a.ulg"),
    "a.bin": made(lambda path: writing.dataflash(path, TRUTH, instances=1), "a.bin"),
    "a.log": made(lambda path: writing.dataflash_text(path, TRUTH), "a.log"),
    "a.bag": made(lambda path: writing.ros1(path, TRUTH), "a.bag"),
    "a.db3": made(lambda path: writing.ros2(path, TRUTH, "db3"), "a"),
    "a.mcap": made(lambda path: writing.ros2(path, TRUTH, "mcap"), "a"),
    "a5.mat": made(lambda path: writing.matlab_5(path, TRUTH), "a.mat"),
    "a73.mat": made(lambda path: writing.matlab_73(path, TRUTH), "a.mat"),
    "a.npy": made(lambda path: writing.npy(path, TRUTH), "a.npy"),
    "a.npz": made(lambda path: writing.npz(path, TRUTH), "a.npz"),
    "a.parquet": made(lambda path: writing.table(path, TRUTH), "a.parquet"),
}


def setUpModule():
    asked.bounded()


class Importing(asked.Lawful):
    def imported(self, name, data):
        out = self.work / "out.csv"
        done = self.asked(out, "import", self.file(name, data), "-o", out)
        if name in ("a.bag", "a.mcap"):  # the readers of other logs look for it, and are rejected
            self.assertNotIn("memory", done.stderr)
        return done


class Logs(Importing):
    pass  # its tests are added below, two per log


def attack(name):
    @given(damaged(LOGS[name]))
    @examples(60)
    def test(self, data):
        self.imported(name, data)

    return test


def message_ends(name):
    """The message ends of logs that are a sequence of messages: nothing in them shows that another
    message followed. By the layouts in writing_logs.
    """
    data = LOGS[name]
    if name == "a.bin":
        return set(range(2 * 89, len(data), 40))
    if name == "a.ulg":
        found = [16]
        while found[-1] < len(data):
            found.append(found[-1] + 3 + int.from_bytes(data[found[-1] : found[-1] + 2], "little"))
        return set(found)
    return set(range(len(data))) if name == "a.log" else set()


def cut(name):
    """A truncated log is rejected, or all of it is read. After a complete message, the content
    before it is read.
    """
    ends = message_ends(name)

    @given(
        st.one_of(st.integers(0, len(LOGS[name]) - 1), st.sampled_from(sorted(ends)[:-1] or [0]))
    )
    @examples(25)
    def test(self, length):
        if self.imported(name, LOGS[name][:length]).returncode != 0:
            return
        with open(self.work / "out.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        if length not in ends:
            self.assertEqual(len(rows), TRUTH.count)
        rows = rows[:-1] if name == "a.log" else rows  # nothing shows that a number in text was cut
        for axis, letter in enumerate("xyz"):
            np.testing.assert_allclose(
                [float(row[f"gyro_{letter}_dps"]) for row in rows],
                TRUTH.gyro[axis][: len(rows)],
                rtol=2e-7,
                atol=1e-8,
            )

    return test


for one in LOGS:
    setattr(Logs, f"test_damaged_{one.replace('.', '_')}", attack(one))
    setattr(Logs, f"test_cut_{one.replace('.', '_')}", cut(one))


class Known(Importing):
    """Faults that were found once."""

    def test_a_type_that_kills_scipy(self):
        data = LOGS["a5.mat"].replace(b"\x09\0\0\0\xc0\0\0\0", b"\0\0\0\0\xc0\0\0\0", 1)
        self.assertNotEqual(data, LOGS["a5.mat"])
        self.assertEqual(self.imported("a5.mat", data).returncode, 2)

    def test_a_database_whose_last_sample_was_zeros(self):
        for cut in (1, 303, 4096, len(LOGS["a.db3"]) // 2):
            done = self.imported("a.db3", LOGS["a.db3"][:-cut])
            self.assertEqual(done.returncode, 2)
            self.assertIn("cut short", done.stderr)


NAMES = st.one_of(
    st.text(st.characters(blacklist_categories=("Cs",)), min_size=1, max_size=6),
    st.sampled_from(
        (
            "a,b",
            "a\nb",
            '"a"',
            " a",
            "#a",
            "time",
            "temp",
            "accel_x",
            "epoch",
            "\x1b[2J",
            "a\u2028b",
        )
    ),
)
STAMPS = st.one_of(
    st.integers(0, 2**62 // 1000),
    st.integers(-(2**63), 2**63 - 1),
    st.integers(1_700_000_000_000_000, 1_700_000_001_000_000),
)
VALUES = st.one_of(
    st.floats(-1e6, 1e6),
    st.floats(-1e6, 1e6),
    st.floats(),
    st.sampled_from((5e-324, 1e29, 1e30, 1e300, -0.0)),
)


class Tables(Importing):
    """Arrays with names, of any names and values."""

    def back(self):
        """The rows of the import, with the time in whole nanoseconds."""
        with open(self.work / "out.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.reader(line for line in file if not line.startswith("#")))
        return rows[0], list(zip(*rows[1:]))

    @given(st.lists(NAMES, max_size=3, unique=True))
    @examples(150)
    def test_columns_of_any_name(self, names):
        columns = {
            f"gyro_{axis}_dps": TRUTH.gyro[place].astype(float) for place, axis in enumerate("xyz")
        }
        columns = (
            {"time_s": np.arange(TRUTH.count) / 50}
            | columns
            | {name: np.full(TRUTH.count, 1.0 + place) for place, name in enumerate(names)}
        )
        path = self.work / "a.parquet"
        writing.parquet.write_table(writing.pyarrow.table(columns), path)
        if self.imported(path.name, path.read_bytes()).returncode == 0:
            found, values = self.back()
            self.assertEqual(len(found), len(columns))
            self.assertEqual(list(found[:4]), list(columns)[:4])
            again = table.read(self.work / "out.csv")
            self.assertEqual(list(again.columns), found)
            for place in range(4, len(found)):
                self.assertEqual(len(set(values[place])), 1)

    @given(
        st.lists(st.tuples(STAMPS, VALUES, VALUES, VALUES), min_size=4, max_size=7),
        st.sampled_from((np.float64, np.float32)),
        st.sampled_from((np.int64, np.uint64, np.float64)),
        st.booleans(),
        st.sampled_from((("ns", 1), ("us", 1000), ("ms", 10**6))),
    )
    @examples(300)
    def test_any_values(self, rows, kind, clock, ordered, tick):
        rows = sorted(rows) if ordered else rows
        if clock == np.uint64 and any(row[0] < 0 for row in rows):
            return
        stamps = np.array([row[0] for row in rows], clock)
        with np.errstate(over="ignore"):
            gyro = np.array([row[1:] for row in rows]).astype(kind)
        path = self.work / "a.npz"
        np.savez(path, **{f"timestamp_{tick[0]}": stamps, "gyro_dps": gyro})
        if self.imported(path.name, path.read_bytes()).returncode != 0:
            return
        found, values = self.back()
        self.assertEqual(found, ["time_s", "gyro_x_dps", "gyro_y_dps", "gyro_z_dps"])
        for axis in range(3):
            self.assertEqual(
                [float(one) for one in values[1 + axis]],
                [float(f"{one:.9g}") for one in gyro[:, axis].tolist()],
            )
        for text, stamp in zip(values[0], stamps.tolist(), strict=True):
            exact = Decimal(stamp) * tick[1] / 10**9
            # a nanosecond, as far as the 53 bits of a double reach: 97 days
            self.assertLessEqual(
                abs(Decimal(text) - exact), max(Decimal("1.1e-9"), abs(exact) * Decimal("3e-16"))
            )


if __name__ == "__main__":
    unittest.main()
