"""Bad options: exit status 2, one line with the name of the option, nothing on standard output."""

import unittest

from sim_case import SimCase

REFUSED = {
    "--window-max": [
        "0",
        "2",
        "601",
        "-4",
        "abc",
        "",
        "600.0",
        "6e2",
        " 600",
        "99999999999",
        "4294967296",
        "4294967294",
    ],
    "--window-min": ["0", "602", "401", "x", "18446744073709551617"],
    "--segment": ["0", "400", "500", "-1", "1.5"],
    "--stride": ["0", "16777217", "-1", "x", "4294967296"],
    "--engine": ["", "grids", "0"],
    "--grow": ["1", "3", "600", "x"],
    "--shrink": ["1", "3", "600", "x"],
    "--kurtosis": [
        "3.3:2.5",
        "2.5",
        "2.5:",
        ":3.3",
        "-1:3",
        "nan:3",
        "2:inf",
        "a:b",
        "2.5:3.3:4",
        "2.5,3.3",
    ],
    "--unstable-rate": ["0", "-0.01", "0.00009", "0.11", "1", "1%", "x", "", "nan"],
    "--contribution": ["1:0", "-1:0", "0", "0:x", "0:1e999"],
    "--taus": [
        "0",
        "0,1",
        "1,301",
        "301",
        "2,1",
        "1,1",
        "1,,2",
        "1,2,",
        ",1",
        "a",
        "1,b",
        "-1",
        "1,99999999999",
        "fourier",
        "geometric:",
        "geometric:0",
        "geometric:33",
        "geometric:x",
        "geometrical",
        "octaves",
        ",".join(str(m) for m in range(1, 34)),
    ],
    "--rate": ["0", "-100", "nan", "inf", "x", "", "1e999", "100Hz", "1e51"],
    "--lsb": ["0", "-0.05", "nan", "x", "1e-999", "1e999", "1e51", "1e-51"],
    "--gap": ["0", "1", "0.5", "-2", "x"],
    "--bits": ["0", "8", "17", "33", "x"],
    "--policy": ["none", "OR", "", "kurtosi"],
    "--mode": ["center", "", "Trailing"],
    "--arith": ["double", "", "q15"],
    "--out": ["xml", "", "CSV", "can:", "can:vcan0", "slcan:/dev/ttyACM0"],
    "--pace": ["0", "-1", "x", "", "nan", "inf", "fast"],
    "--progress": ["yes", ""],
    "--column": ["", ",", "gyro_x_dps,", "gyro_x_dps,gyro_x_dps", "gyro_z_dps"],
}


class BadOption(SimCase):
    def test_a_bad_value_is_rejected_and_the_option_reported(self):
        path = self.recording()
        for option, values in REFUSED.items():
            for value in values:
                with self.subTest(option=option, value=value):
                    self.assert_refused(self.sim(path, option, value), option)

    def test_full_scale_is_checked_where_it_counts(self):
        path = self.recording()
        for value in ("0", "-1", "x", "1e30"):
            with self.subTest(value=value):
                self.assert_refused(
                    self.sim(path, "--arith", "float", "--full-scale", value), "--full-scale"
                )

    def test_options_are_checked_before_the_recording(self):
        self.assert_refused(
            self.sim(self.folder / "nothing.csv", "--window-max", "0"), "--window-max"
        )

    def test_bounds_that_depend_on_each_other(self):
        path = self.recording()
        self.assert_refused(
            self.sim(path, "--window-max", "100", "--window-min", "200"), "--window-min"
        )
        self.assert_refused(self.sim(path, "--window-max", "100", "--segment", "80"), "--segment")
        self.assert_refused(self.sim(path, "--window-max", "100", "--taus", "1,51"), "--taus")

    def test_an_unstable_rate_has_no_second_meaning(self):
        path = self.recording()
        rate = ("--unstable-rate", "0.01")
        for other in (("--kurtosis", "2:4"), ("--contribution", "0:1")):
            self.assert_refused(self.sim(path, *rate, *other), "--unstable-rate", "either it or")
        self.assert_refused(
            self.sim(path, *rate, "--policy", "glr"), "--unstable-rate", "--false-alarms-per-hour"
        )

    def test_an_option_of_frames_needs_frames(self):
        path = self.recording()
        for option in (("--can-base", "5D0"), ("--can-content", "fd"), ("--raw",)):
            for out in ((), ("--out", "jsonl"), ("--out", "mavlink:udp:127.0.0.1:9")):
                with self.subTest(option=option, out=out):
                    self.assert_refused(
                        self.sim(path, *option, *out), option[0], "needs --out can:IFACE"
                    )

    def test_trailing_windows_may_be_odd_and_grow_by_one(self):
        path = self.recording(count=700)
        rows = self.results(
            path,
            "--mode",
            "trailing",
            "--window-max",
            "601",
            "--window-min",
            "401",
            "--stride",
            "100",
        )
        self.assertGreater(len(rows), 1)

    def test_a_stride_may_be_at_most_as_long_as_the_window(self):
        path = self.recording(count=700)
        rows = self.results(path, "--window-max", "300", "--stride", "300")
        self.assertEqual(["299", "599"], [row["epoch"] for row in rows])
        self.assert_refused(
            self.sim(path, "--window-max", "300", "--stride", "301"),
            "--stride",
            "would never count",
        )
        self.assert_refused(
            self.sim(path, "--window-max", "702", "--stride", "701"), "at least 701"
        )

    def test_unknown_options(self):
        path = self.recording()
        self.assert_refused(self.sim(path, "--windowmax", "600"), "--windowmax")
        self.assert_refused(self.sim(path, "--window", "600"), "--window")
        self.assert_refused(self.sim(path, "-q"), "-q")
        self.assert_refused(self.sim("--frobnicate"), "--frobnicate")

    def test_missing_and_superfluous_values(self):
        path = self.recording()
        self.assert_refused(self.sim(path, "--rate"), "--rate", "needs a value")
        self.assert_refused(self.sim(path, "--details=yes"), "--details", "takes no value")

    def test_missing_and_superfluous_arguments(self):
        path = self.recording()
        self.assert_refused(self.sim(), "no recording")
        self.assert_refused(self.sim("--rate", "5"), "no recording")
        self.assert_refused(self.sim(path, path), "unexpected argument")
        done = self.sim(path, "--column", "gyro_x_dps", "--rate", "100", "gyro_y_dps")
        self.assert_refused(done, "unexpected argument 'gyro_y_dps'")

    def test_control_characters_in_an_argument_do_not_break_the_line(self):
        self.assert_refused(self.sim("no\nsuch\rfile"), "no?such?file")

    def test_help_and_version_need_no_recording(self):
        for option, start in (("--help", "usage: davar-sim REC"), ("--version", "davar-sim ")):
            done = self.sim(option)
            self.assertEqual(0, done.returncode)
            self.assertTrue(done.stdout.startswith(start))
            self.assertEqual("", done.stderr)

    def test_help_names_every_option(self):
        text = self.sim("--help").stdout
        for option in [*REFUSED, "--details", "--full-scale", "--version"]:
            self.assertIn(option, text)


if __name__ == "__main__":
    unittest.main()
