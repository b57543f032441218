"""A wrong argument is a ValueError that begins with its name. A wrong file gives file, line and
column.
"""

import gzip
import os
import subprocess
import sys
import unittest
from pathlib import Path

import davar
import numpy as np
import together

X = np.random.default_rng(1).normal(0, 1, 2000)


class Arguments(unittest.TestCase):
    def refused(self, begins, call, *arguments, **named):
        with self.subTest(
            begins=begins, **{name: str(value)[:30] for name, value in named.items()}
        ):
            with self.assertRaises(ValueError) as caught:
                call(*arguments, **named)
            self.assertRegex(str(caught.exception), rf"^(\w+ or )?{begins}( or \w+)?: [^\n]+$")
            return str(caught.exception)

    def test_common_rules(self):
        for call in (davar.adev, davar.dynamic):
            for rate_hz in (0, -1, np.nan, np.inf, "fast", None):
                self.refused("rate_hz", call, X, rate_hz)
            for x in (
                X.reshape(2, -1),
                np.float64(1),
                X + 1j,
                ["a", "b"],
                [],
                [1.0],
                np.where(X > 3, np.inf, X),
                np.full(2000, np.nan),
                X > 0,
                X.astype(object),
                list(X) + [None],
                [[1.0], [1.0, 2.0]],
                iter(X),
                {1.0, 2.0},
                None,
                np.ma.masked_all(2000),
                np.arange("2000", "2010", dtype="M8[Y]"),
            ):
                self.refused("x", call, x, 1.0)
            self.assertIn(
                "shape (2, 1000); give one axis at a time",
                self.refused("x", call, X.reshape(2, -1), 1.0),
            )
            self.refused("x", call, np.arange(2000) + 2**60, 1.0, lsb=1.0)
            self.refused("lsb", call, np.arange(2000), 1.0)
            for lsb in (0, -1.0, np.nan, True):
                self.refused("lsb", call, np.arange(2000), 1.0, lsb=lsb)
            for gaps in ([0], [2000], [-1], [1.5], [[1]], "often"):
                self.refused("gaps", call, X, 1.0, gaps=gaps)
            time_s = np.arange(2000.0)
            for stamps in (
                time_s[:-1],
                time_s[::-1],
                np.where(time_s == 5, np.nan, time_s),
                np.zeros(2000),
                "now",
                np.ma.masked_equal(time_s, 7),
                time_s.reshape(2, -1),
                time_s > 3,
            ):
                self.refused("time_s", call, X, time_s=stamps)
            self.refused("gaps", call, X, 1.0, gaps=np.ma.masked_equal([5, 6], 6))
            self.refused("gap", call, X, time_s=time_s, gap=1)

    def test_numbers_at_the_ends_of_a_double(self):
        for scale in (5e307, 1e-300, 5e-324):
            self.refused("x", davar.adev, X * scale, 1.0)
        for scale in (1e-200, 1e200):
            self.assertAlmostEqual(
                davar.adev(X * scale, 1.0).adev[0] / scale / davar.adev(X, 1.0).adev[0],
                1,
                delta=1e-6,
            )

    def test_averaging_times(self):
        for call in (davar.adev, davar.dynamic):
            for taus in (
                "decades",
                "geometric:0",
                "geometric:99",
                "octave:3",
                "geometric:",
                "geometric:\u00b2",
                "",
            ):
                self.refused("taus", call, X, 1.0, taus=taus)
            for taus in (
                [1, 10, 100],
                (1,),
                np.array([1, 2]),
                5,
                [],
            ):  # seconds for AllanTools, samples for davar-sim
                said = self.refused("taus", call, X, 1.0, taus=taus)
                self.assertRegex(said, r"clusters=.*samples.*taus_s=.*seconds")
            for sizes in (
                [],
                [0, 1],
                [2, 1],
                [1, 1],
                [0.5],
                [1, 1001],
                [-1],
                [[1, 2]],
                [np.nan],
                [np.inf],
                [True],
                "octave",
                ["1"],
                [1j],
                np.ma.masked_equal([1, 2], 2),
            ):
                self.refused("clusters", call, X, 1.0, clusters=sizes)
            for times in (
                [],
                [0, 1],
                [2, 1],
                [-1],
                [0.4],
                [1, 1001],
                [[1, 2]],
                [np.nan],
                [np.inf],
                [True],
                "all",
                np.ma.masked_equal([1, 2], 2),
            ):
                self.refused("taus_s", call, X, 1.0, taus_s=times)
            self.assertIn("taus_s=", self.refused("clusters", call, X, 100.0, clusters=[0.01, 0.1]))
            for both in (
                {"taus": "octave", "clusters": [1]},
                {"taus": "octave", "taus_s": [1]},
                {"clusters": [1], "taus_s": [1]},
            ):
                self.refused(next(iter(both)), call, X, 1.0, **both)
        for taus in ("all", "decade"):
            self.refused("taus", davar.dynamic, X, 1.0, taus=taus)
        for name in ("clusters", "taus_s"):
            self.refused(name, davar.dynamic, X, 1.0, **{name: range(1, 34)})
            self.refused(name, davar.Stream, 1.0, lsb=1.0, **{name: [1, 301]})

    def test_kinds_of_data(self):
        for data_type in ("rate", None, "PHASE", 1):
            self.refused("data_type", davar.adev, X, 1.0, data_type=data_type)
        self.refused("x", davar.adev, [1.0, 2.0], 1.0, data_type="phase")
        self.refused("x", davar.adev, X * 1e307, 1e3, data_type="phase")

    def test_error_models(self):
        good = "m,adev_dps,relative_tolerance,tau_s\n1,0.5,0.02,1\n2,0.4,0.02,2\n"
        with together.elsewhere():
            for text in (
                None,
                "",
                good.replace("m,", "n,"),
                good.replace("1,0.5", "1.5,0.5"),
                good.replace("0.5", "-1"),
                good.replace("2,0.4", "1,0.4"),
                good.replace(",2\n", ",3\n"),
                "m,adev_dps,relative_tolerance\n3,1,0\n",
                good.replace("0.4", "x"),
            ):
                if text is not None:
                    Path("table.csv").write_text(text)
                self.refused("model_table", davar.dynamic, X, 1.0, model_table="table.csv")
            self.refused("model_table", davar.dynamic, X, 1.0, model_table=5)

    def test_torn_reads_are_off_by_counts(self):
        for options in ({}, {"arith": "float"}, {"arith": "float", "lsb": 0.01}):
            self.refused("skip_torn_reads", davar.dynamic, X, 1.0, skip_torn_reads=True, **options)

    def test_options_of_the_window(self):
        for named in (
            {"window_max": 3},
            {"window_max": 601},
            {"window_min": 700},
            {"segment": 500},
            {"stride": 0},
            {"grow": 3},
            {"kurtosis": (3, 2)},
            {"kurtosis": 3},
            {"contribution": ("a", "b")},
            {"unstable_rate": 0.5},
            {"unstable_rate": 0.01, "policy": "glr"},
            {"policy": "magic"},
            *(
                {"bandwidth": filter}
                for filter in ("", "wide", "20Hz", "20:3", "average:0", -1, 0, np.nan, 0.001, 900)
            ),
            {"mode": "left"},
            {"arith": "double"},
            {"bits": 12},
            {"window_max": 600.5},
            {"stride": "many"},
            {"full_scale": -1, "arith": "float"},
            {"false_alarms_per_hour": 0},
            {"cut_interval": -1},
            {"block": -1},
            {"window_max": -600},
            {"engine": "steam"},
            {"long_cluster": -1},
            {"long_cluster": 1.5},
            *({"longest_tau_s": seconds} for seconds in (0, -1, np.nan, np.inf, "day", 100, 1e9)),
            {"longest_tau_s": 10**400},
        ):
            self.refused(next(iter(named)), davar.dynamic, X, 1.0, **named)
        self.refused("policy glr", davar.dynamic, X, 1.0, policy="glr", block=2)
        self.refused("policy glr", davar.dynamic, X, 1.0, policy="glr", long_cluster=7, stride=10)
        for x in (X[:100], X * 1e300, X * 1e20, X * 1e-300):
            self.refused("x", davar.dynamic, x, 1.0)
        self.refused("rate_hz", davar.dynamic, X, 1e60)

    def test_streams(self):
        self.refused("lsb or full_scale", davar.Stream, 1.0)
        self.refused("lsb or full_scale", davar.Stream, 1.0, lsb=1.0, full_scale=2.0)
        self.refused("lsb", davar.Stream, 1.0, lsb=0)
        self.refused("rate_hz", davar.Stream, None, lsb=1.0)
        self.refused("bandwidth", davar.Stream, 1.0, lsb=1.0, bandwidth="auto")
        self.refused("window_min", davar.Stream, 1.0, lsb=1.0, window_min=601)
        stream = davar.Stream(1.0, full_scale=1.0)
        self.refused("lsb", stream.push, [1, 2])
        for missing in (0, -1, 1.5, True, "two", None):
            self.refused("missing", stream.gap, missing)
        self.refused("x", stream.push, X.reshape(2, -1))
        stream.finish()
        self.refused("x", stream.push, [1.0])

    def test_a_missing_column(self):
        with self.assertRaisesRegex(AttributeError, "no column bias .*arw_deg_per_sqrt_h"):
            _ = davar.dynamic(X, 1.0).bias


class Files(unittest.TestCase):
    def read(self, text, name="rec.csv"):
        with together.elsewhere():
            Path(name).write_bytes(text if isinstance(text, bytes) else text.encode())
            return davar.read(name)

    def test_the_contents(self):
        text = (
            "# sensor: it\n# serial: 7\ntime_s,gyro_z_dps\n"
            + "".join(f"{i / 50:.2f},{i}\n" for i in range(10))
            + "\n"
        )
        for made in (
            self.read(text),
            self.read(gzip.compress(text.encode()), "rec.csv.gz"),
            self.read(text.replace("\n", "\r\n")),
        ):
            self.assertEqual(made.notes, {"sensor": "it", "serial": "7"})
            self.assertAlmostEqual(made.rate_hz, 50.0)
            self.assertEqual(made["gyro_z_dps"].tolist(), list(range(10)))
        self.assertIsNone(self.read("gyro_z_dps\n1\n2\n").rate_hz)

    def test_bad_values(self):
        for text, begins in (
            ("", "rec.csv: no header"),
            ("a_dps\n", "rec.csv:1: no rows"),
            ("a,b\n1,2\n3\n", "rec.csv:3: 1 fields"),
            ("# k: v\na,b\n1,2\n3,x\n", "rec.csv:4: column b: not a finite number, found 'x'"),
            ("a,b\n1,nan\n", "rec.csv:2: column b"),
            ("a,a\n1,2\n", "rec.csv:1: column a appears twice"),
            ("a,\n1,2\n", "rec.csv:1: a column without"),
            ("a\n1\n\n2\n", "rec.csv:3: an empty row"),
            ("time_s,a\n1,2\n3,4\n2,5\n", "rec.csv:4: column time_s: time runs backwards"),
            (b"a\n\xff\xfe\n", "rec.csv: not a text"),
            (gzip.compress(b"a\n1\n" * 99)[:-9], "rec.csv: damaged gzip"),
        ):
            with self.subTest(begins):
                with self.assertRaises(ValueError) as caught:
                    self.read(text)
                self.assertTrue(str(caught.exception).startswith(begins), caught.exception)
        with self.assertRaises(FileNotFoundError):
            davar.read("nowhere.csv")

    def test_the_numbers_are_those_of_davar_sim(self):
        """A field that only one of them accepts."""
        rows = [f"{i},{i * 7919 % 101}\n" for i in range(700)]
        for field in (
            "1",
            "+1",
            "1.",
            ".5",
            "1e3",
            "1E-3",
            " 2\t",
            "00012",
            "1e-400",
            "1e0000001",
            "0." + "1" * 300,
            "1_0",
            "\uff10",
            "\u0663",
            "1e",
            "e3",
            "0x10",
            "0x1p3",
            "inf",
            "nan",
            "",
            "1e400",
            "1d3",
            "1f",
            '"1"',
            "--1",
            "1 2",
            "1#2",
            "1;",
            "\u22121",
            ".",
            "+",
            "9" * 400,
            "True",
            "None",
            "1j",
        ):
            with self.subTest(field):
                rows[300] = f"300,{field}\n"
                text = "time_s,gyro_z_dps\n" + "".join(rows)
                taken = (
                    subprocess.run(
                        [os.environ["DAVAR_SIM"], "-", "--stride", "100"],
                        input=text.encode(),
                        capture_output=True,
                    ).returncode
                    == 0
                )
                if taken:
                    self.assertEqual(self.read(text)["gyro_z_dps"][300], float(field))
                else:
                    with self.assertRaisesRegex(ValueError, "^rec.csv:302: column gyro_z_dps: "):
                        self.read(text)

    def test_nothing_but_a_regular_file_is_opened(self):
        with together.elsewhere():
            os.mkfifo("pipe.csv")
            for name in ("pipe.csv", "/dev/null"):
                with self.assertRaisesRegex(ValueError, f"^{name}: not a regular file$"):
                    davar.read(name)

    def test_a_file_of_proc_does_not_wait(self):
        with together.elsewhere():
            os.symlink("/proc/kmsg", "kmsg.csv")
            for name in ("/proc/kmsg", "kmsg.csv"):
                done = subprocess.run(
                    [sys.executable, "-c", f"import davar; davar.read({name!r})"],
                    capture_output=True,
                    text=True,
                    timeout=600,
                )
                self.assertEqual(
                    (done.returncode, done.stderr.splitlines()[-1]),
                    (1, f"ValueError: {name}: no header row and no samples"),
                )

    def test_another_log_without_the_extra(self):
        for head in (b"ULog\x01\x12\x35", b"\x93NUMPY\x01\x00", b"PAR1", b"no text \x00\x01"):
            with self.assertRaisesRegex(
                ImportError, r"^rec.ulg: not CSV; .*pip install \"davar\[lab\]\""
            ):
                self.read(head + bytes(40), "rec.ulg")


if __name__ == "__main__":
    unittest.main()
