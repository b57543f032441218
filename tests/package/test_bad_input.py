"""A wrong argument is a ValueError that begins with its name; a wrong file one that names file, line and column."""

import gzip
import unittest
from pathlib import Path

import davar
import numpy as np

import together

X = np.random.default_rng(1).normal(0, 1, 2000)


class Arguments(unittest.TestCase):
    def refused(self, begins, call, *arguments, **named):
        with self.subTest(begins=begins, **{name: str(value)[:30] for name, value in named.items()}):
            with self.assertRaises(ValueError) as caught:
                call(*arguments, **named)
            self.assertRegex(str(caught.exception), rf"^(\w+ or )?{begins}( or \w+)?: [^\n]+$")

    def test_what_all_share(self):
        for call in (davar.adev, davar.dynamic):
            for rate_hz in (0, -1, np.nan, np.inf, "fast", None):
                self.refused("rate_hz", call, X, rate_hz)
            for x in (X.reshape(2, -1), np.float64(1), X + 1j, ["a", "b"], [], [1.0], np.where(X > 3, np.inf, X), np.full(2000, np.nan)):
                self.refused("x", call, x, 1.0)
            self.refused("lsb", call, np.arange(2000), 1.0)
            for lsb in (0, -1.0, np.nan):
                self.refused("lsb", call, np.arange(2000), 1.0, lsb=lsb)
            for gaps in ([0], [2000], [-1], [1.5], [[1]], "often"):
                self.refused("gaps", call, X, 1.0, gaps=gaps)
            time_s = np.arange(2000.0)
            for stamps in (time_s[:-1], time_s[::-1], np.where(time_s == 5, np.nan, time_s), np.zeros(2000), "now"):
                self.refused("time_s", call, X, time_s=stamps)
            self.refused("gap", call, X, time_s=time_s, gap=1)

    def test_numbers_at_the_ends_of_a_double(self):
        for scale in (5e307, 1e-300, 5e-324):
            self.refused("x", davar.adev, X * scale, 1.0)
        for scale in (1e-200, 1e200):
            self.assertAlmostEqual(davar.adev(X * scale, 1.0).adev[0] / scale / davar.adev(X, 1.0).adev[0], 1, delta=1e-6)

    def test_cluster_sizes(self):
        for call in (davar.adev, davar.dynamic):
            for taus in ([], [0, 1], [2, 1], [1, 1], [0.5], list(range(1, 34)), [1, 1001], "all", "geometric:0", "geometric:99", "octave:3", "geometric:\u00b2", [-1]):
                self.refused("taus", call, X, 1.0, taus=taus)

    def test_options_of_the_window(self):
        for named in ({"window_max": 3}, {"window_max": 601}, {"window_min": 700}, {"segment": 500}, {"stride": 0}, {"grow": 3}, {"kurtosis": (3, 2)},
                      {"kurtosis": 3}, {"contribution": ("a", "b")}, {"policy": "magic"}, {"mode": "left"}, {"arith": "double"}, {"bits": 12},
                      {"window_max": 600.5}, {"stride": "many"}, {"full_scale": -1, "arith": "float"}, {"false_alarms_per_hour": 0},
                      {"cut_interval": -1}, {"block": -1}, {"window_max": -600}):
            self.refused(next(iter(named)), davar.dynamic, X, 1.0, **named)
        self.refused("policy glr", davar.dynamic, X, 1.0, policy="glr", block=2)
        for x in (X[:100], X * 1e300, X * 1e20, X * 1e-300):
            self.refused("x", davar.dynamic, x, 1.0)
        self.refused("rate_hz", davar.dynamic, X, 1e60)

    def test_streams(self):
        self.refused("lsb or full_scale", davar.Stream, 1.0)
        self.refused("lsb or full_scale", davar.Stream, 1.0, lsb=1.0, full_scale=2.0)
        self.refused("lsb", davar.Stream, 1.0, lsb=0)
        self.refused("rate_hz", davar.Stream, None, lsb=1.0)
        self.refused("window_min", davar.Stream, 1.0, lsb=1.0, window_min=601)
        stream = davar.Stream(1.0, full_scale=1.0)
        self.refused("lsb", stream.push, [1, 2])
        self.refused("missing", stream.gap, 0)
        stream.finish()
        self.refused("x", stream.push, [1.0])

    def test_a_column_that_is_not_there(self):
        with self.assertRaisesRegex(AttributeError, "no column bias .*arw_deg_per_sqrt_h"):
            davar.dynamic(X, 1.0).bias


class Files(unittest.TestCase):
    def read(self, text, name="rec.csv"):
        with together.elsewhere():
            Path(name).write_bytes(text if isinstance(text, bytes) else text.encode())
            return davar.read(name)

    def test_what_is_there(self):
        text = "# sensor: it\n# serial: 7\ntime_s,gyro_z_dps\n" + "".join(f"{i / 50:.2f},{i}\n" for i in range(10)) + "\n"
        for made in (self.read(text), self.read(gzip.compress(text.encode()), "rec.csv.gz"), self.read(text.replace("\n", "\r\n"))):
            self.assertEqual(made.notes, {"sensor": "it", "serial": "7"})
            self.assertAlmostEqual(made.rate_hz, 50.0)
            self.assertEqual(made["gyro_z_dps"].tolist(), list(range(10)))
        self.assertIsNone(self.read("gyro_z_dps\n1\n2\n").rate_hz)

    def test_what_is_wrong(self):
        for text, begins in (("", "rec.csv: no header"), ("a_dps\n", "rec.csv:1: no rows"), ("a,b\n1,2\n3\n", "rec.csv:3: 1 fields"),
                             ("# k: v\na,b\n1,2\n3,x\n", "rec.csv:4: column b: not a finite number, found 'x'"),
                             ("a,b\n1,nan\n", "rec.csv:2: column b"), ("a,a\n1,2\n", "rec.csv:1: column a is there twice"),
                             ("a,\n1,2\n", "rec.csv:1: a column without"), ("a\n1\n\n2\n", "rec.csv:3: an empty row"),
                             ("time_s,a\n1,2\n3,4\n2,5\n", "rec.csv:4: column time_s: time runs backwards"), (b"a\n\xff\xfe\n", "rec.csv: not a text"),
                             (gzip.compress(b"a\n1\n" * 99)[:-9], "rec.csv: damaged gzip")):
            with self.subTest(begins):
                with self.assertRaises(ValueError) as caught:
                    self.read(text)
                self.assertTrue(str(caught.exception).startswith(begins), caught.exception)
        with self.assertRaises(FileNotFoundError):
            davar.read("nowhere.csv")

    def test_another_log_without_the_extra(self):
        for head in (b"ULog\x01\x12\x35", b"\x93NUMPY\x01\x00", b"PAR1", b"no text \x00\x01"):
            with self.assertRaisesRegex(ImportError, r"^rec.ulg: no CSV; .*pip install \"davar\[lab\]\""):
                self.read(head + bytes(40), "rec.ulg")


if __name__ == "__main__":
    unittest.main()
