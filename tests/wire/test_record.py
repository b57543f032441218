"""The recorder of davarlab live: rows are written on arrival, memory does not grow, columns have
names.
"""

import csv
import tempfile
import unittest
from pathlib import Path

from davarlab import errors
from davarlab.wire import frames as wire
from davarlab.wire import record

ROOT = Path(__file__).resolve().parents[2]


def result(n, channel=0, taus=3):
    return wire.Result(
        channel,
        n % 16,
        n,
        {"arw_deg_per_sqrt_h": 0.1 + n, "kurtosis": float("nan")},
        {index: 1e-3 * (index + n) for index in range(taus)},
    )


def known(*clusters):
    channel = wire.Channel()
    channel.setup["rate_hz"] = 100.0
    channel.clusters = dict(enumerate(clusters))
    return channel


class Record(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "arw.csv"

    def recorder(self):
        found = record.Recorder(self.path)
        self.addCleanup(found.output.file.close)
        return found

    def rows(self):
        with open(self.path, encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_each_row_is_in_the_file_when_add_returns(self):
        recorder, channel = self.recorder(), known(1, 2, 16)
        for n in range(100):
            recorder.add(result(n), channel)
            self.assertEqual(n + 1, len(self.rows()))
        last = self.rows()[-1]
        self.assertEqual(
            ("99", "0.99", "99.1", "", "0.101"),
            tuple(
                last[name]
                for name in ("epoch", "time_s", "arw_deg_per_sqrt_h", "kurtosis", "adev_16")
            ),
        )
        self.assertEqual(["adev_1", "adev_2", "adev_16"], [*last][-3:])

    def test_rows_wait_for_the_names_of_their_columns(self):
        recorder, channel = self.recorder(), wire.Channel()
        for n in range(9):
            recorder.add(result(n), channel)
        self.assertEqual([], self.rows())
        channel.setup["rate_hz"], channel.clusters = 100.0, {0: 1, 1: 2, 2: 4}
        recorder.add(result(9), channel)
        self.assertEqual(
            [f"{0.01 * n:.9g}" for n in range(10)], [row["time_s"] for row in self.rows()]
        )

    def test_sizes_whose_deviation_comes_later_have_a_column_from_the_start(self):
        recorder, channel = self.recorder(), known(*(2**t for t in range(32)))
        for n in range(32):
            one = result(n, taus=32)
            one.adev = {t: value if t <= n else float("nan") for t, value in one.adev.items()}
            recorder.add(one, channel)
        rows = self.rows()
        self.assertEqual([f"adev_{2**t}" for t in range(32)], [*rows[0]][-32:])
        for n, row in enumerate(rows):
            self.assertEqual(
                [t > n for t in range(32)], [row[f"adev_{2**t}"] == "" for t in range(32)]
            )
        self.assertEqual(0, recorder.left_out)

    def test_they_do_not_wait_for_ever(self):
        recorder = self.recorder()
        for n in range(10000):
            recorder.add(result(n), wire.Channel())
            self.assertLess(len(recorder.waiting), record.WAITING_MAX)
        self.assertEqual(10000, len(self.rows()))
        self.assertIn("adev_tau2", self.rows()[0])

    def test_values_without_a_column_are_counted(self):
        recorder = self.recorder()
        recorder.add(result(0), known(1, 2, 4))
        recorder.add(result(0, channel=1), known(1, 3, 5))
        self.assertEqual(2, recorder.left_out)
        first, second = self.rows()
        self.assertEqual(("1", "0.001", ""), (second["channel"], first["adev_2"], second["adev_2"]))

    def test_an_end_before_the_names_writes_the_known_columns(self):
        recorder = self.recorder()
        recorder.add(result(5), wire.Channel())
        recorder.close()
        self.assertEqual(["5"], [row["epoch"] for row in self.rows()])

    def test_a_file_that_cannot_be_written_is_reported(self):
        with self.assertRaisesRegex(
            errors.BadInput, "^--record: /nowhere/x.csv: No such file or directory$"
        ):
            record.Recorder("/nowhere/x.csv")


if __name__ == "__main__":
    unittest.main()
