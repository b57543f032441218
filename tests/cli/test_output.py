"""The output of davar-sim: columns, numbers, formats, pace and notes."""

import json
import math
import time
import unittest

from sim_case import SMALL_WINDOW, SimCase, as_text, noise_rows

COLUMNS = [
    "epoch",
    "time_s",
    "window_samples",
    "kurtosis",
    "contribution",
    "unstable",
    "arw_deg_per_sqrt_h",
    "arw_low_deg_per_sqrt_h",
    "arw_high_deg_per_sqrt_h",
    "bi_deg_per_h",
    "rrw_deg_per_h_per_sqrt_h",
    "rr_deg_per_h2",
    "qn_deg",
    "filtered",
]
LSB = ("--lsb", "0.01")


def adev(rates, m):
    """Overlapping Allan deviation, computed from its definition."""
    means = [sum(rates[i : i + m]) / m for i in range(len(rates) - m + 1)]
    squares = [(means[i + m] - means[i]) ** 2 for i in range(len(means) - m)]
    return math.sqrt(sum(squares) / (2 * len(squares)))


def kurtosis(rates):
    mean = sum(rates) / len(rates)
    second = sum((rate - mean) ** 2 for rate in rates) / len(rates)
    return sum((rate - mean) ** 4 for rate in rates) / len(rates) / second**2


class Csv(SimCase):
    def header(self, *options):
        return self.sim(self.recording(), *LSB, *options).stdout.split("\n")[0].split(",")

    def test_columns_are_as_documented(self):
        self.assertEqual([*COLUMNS, "adev_1", "adev_2", "adev_4"], self.header(*SMALL_WINDOW))
        self.assertEqual(
            [*COLUMNS, "adev_1", "adev_3", "adev_9"], self.header(*SMALL_WINDOW, "--taus", "1,3,9")
        )
        self.assertEqual(self.header("--taus", "geometric:12"), self.header("--taus", "geometric"))
        self.assertEqual(
            [*COLUMNS, "adev_1", "adev_4", "adev_16", "adev_66"],
            self.header("--taus", "geometric:4"),
        )

    def test_details_are_appended(self):
        self.assertEqual(
            [
                *COLUMNS,
                "adev_1",
                "adev_5",
                "adev_low_1",
                "adev_high_1",
                "differences_1",
                "adev_low_5",
                "adev_high_5",
                "differences_5",
                "gaps_in_window",
                "coarse",
                "arw_upper_deg_per_sqrt_h",
                "bi_upper_deg_per_h",
                "rrw_upper_deg_per_h_per_sqrt_h",
                "rr_upper_deg_per_h2",
                "qn_upper_deg",
                "bi_low_deg_per_h",
                "bi_high_deg_per_h",
                "rrw_low_deg_per_h_per_sqrt_h",
                "rrw_high_deg_per_h_per_sqrt_h",
                "rr_low_deg_per_h2",
                "rr_high_deg_per_h2",
                "qn_low_deg",
                "qn_high_deg",
            ],
            self.header(*SMALL_WINDOW, "--taus", "1,5", "--details"),
        )

    def test_noise_below_half_a_count_is_reported_in_words(self):
        quiet = self.recording(1000)
        for lsb, coarse in (("0.8", True), ("0.001", False)):
            done = self.sim(quiet, "--lsb", lsb, *SMALL_WINDOW, "--details")
            self.assertEqual(
                coarse, "results: the noise is below half a count" in done.stderr, done.stderr
            )

    def test_a_coefficient_has_a_value_or_an_upper_bound(self):
        for row in self.results(self.recording(), *LSB, *SMALL_WINDOW, "--details"):
            for name, unit in (
                ("arw", "deg_per_sqrt_h"),
                ("bi", "deg_per_h"),
                ("rrw", "deg_per_h_per_sqrt_h"),
                ("rr", "deg_per_h2"),
                ("qn", "deg"),
            ):
                value = row[f"{name}_{unit}"]
                self.assertNotEqual(value == "", row[f"{name}_upper_{unit}"] == "")
                limits = [row[f"{name}_{limit}_{unit}"] for limit in ("low", "high")]
                self.assertEqual([value == ""] * 2, [limit == "" for limit in limits])
                if value:
                    self.assertLessEqual(float(limits[0]), float(value))
                    self.assertLessEqual(float(value), float(limits[1]))

    def test_numbers_equal_their_definition_to_nine_digits(self):
        rows = noise_rows(300)
        rates = [float(rate) for _, rate in rows]
        path = self.write("rec.csv", as_text("time_s,gyro_x_dps", rows))
        options = ("--policy", "fixed", "--mode", "trailing", *SMALL_WINDOW, "--taus", "1,2,7,30")
        for arithmetic, counts_dps in ((LSB, 0.0), ((*LSB, "--bits", "32"), 0.0), ((), 2.0**-30)):
            for row in self.results(path, *options, *arithmetic)[100:]:
                window = rates[int(row["epoch"]) - 59 : int(row["epoch"]) + 1]
                for m in (1, 2, 7, 30):
                    close = math.isclose(
                        adev(window, m), float(row[f"adev_{m}"]), rel_tol=6e-9, abs_tol=counts_dps
                    )
                    self.assertTrue(close, (row["epoch"], m))
                self.assertAlmostEqual(1.0, float(row["kurtosis"]) / kurtosis(window), delta=1e-5)

    def test_a_value_the_window_cannot_support_is_an_empty_field(self):
        path = self.write(
            "flat.csv",
            as_text("time_s,gyro_x_dps", [[f"{i / 100:.2f}", "1.5"] for i in range(100)]),
        )
        for row in self.results(path, *LSB, *SMALL_WINDOW):
            self.assertEqual(("", "", "0"), (row["kurtosis"], row["contribution"], row["adev_1"]))

    def test_epochs_of_a_stride_are_the_last_of_each_block(self):
        rows = self.results(self.recording(count=305), *LSB, *SMALL_WINDOW, "--stride", "20")
        self.assertEqual([str(e) for e in range(19, 305, 20)], [row["epoch"] for row in rows])

    def test_a_stride_picks_rows_of_a_fixed_window(self):
        path = self.recording(count=305)
        options = ("--policy", "fixed", *LSB, *SMALL_WINDOW)
        every = self.results(path, *options)
        self.assertEqual(305, len(every))
        self.assertEqual(every[19::20], self.results(path, *options, "--stride", "20"))

    def test_both_engines_of_a_stride_give_the_same_bytes(self):
        path = self.recording(count=3000)
        for options in (
            (),
            ("--mode", "trailing"),
            ("--policy", "fixed", "--out", "jsonl"),
            ("--arith", "float", "--full-scale", "2000"),
        ):
            auto, grid = (
                self.sim(path, *LSB, *SMALL_WINDOW, *options, "--stride", "20", *engine)
                for engine in ((), ("--engine", "grid"))
            )
            self.assertEqual((0, auto.stdout), (grid.returncode, grid.stdout))

    def test_a_trailing_window_has_all_received_samples_until_it_is_full(self):
        rows = self.results(
            self.recording(), *LSB, *SMALL_WINDOW, "--policy", "fixed", "--mode", "trailing"
        )
        self.assertEqual(("39", "40"), (rows[0]["epoch"], rows[0]["window_samples"]))
        self.assertEqual(("58", "59"), (rows[19]["epoch"], rows[19]["window_samples"]))
        self.assertEqual(("299", "60"), (rows[-1]["epoch"], rows[-1]["window_samples"]))

    def test_time_keeps_its_digits_late_in_a_long_run(self):
        rows = [[f"{1700000000 + i / 1000:.3f}", row[1]] for i, row in enumerate(noise_rows(200))]
        path = self.write("late.csv", as_text("time_s,gyro_x_dps", rows))
        self.assertEqual(
            [row[0].rstrip("0").rstrip(".") for row in rows],
            [row["time_s"] for row in self.results(path, *LSB, *SMALL_WINDOW, "--rate", "1000")],
        )

    def test_settings_follow_the_longest_window(self):
        path = self.recording(count=600)
        self.assertEqual(
            self.results(
                path, *LSB, "--window-max", "300", "--window-min", "200", "--segment", "50"
            ),
            self.results(path, *LSB, "--window-max", "300"),
        )


class Arithmetic(SimCase):
    def setUp(self):
        super().setUp()
        self.path = self.recording(count=500)

    def run_with(self, *options):
        return self.results(self.path, *SMALL_WINDOW, *options)

    def test_16_and_32_bit_engines_give_the_same_bytes(self):
        rows = noise_rows(500)
        wide = [[time, "400.00" if i == 450 else rate] for i, (time, rate) in enumerate(rows)]
        narrow_path = self.write("narrow.csv", as_text("time_s,gyro_x_dps", rows))
        wide_path = self.write("wide.csv", as_text("time_s,gyro_x_dps", wide))
        narrow = self.results(narrow_path, *LSB, *SMALL_WINDOW)
        self.assertEqual(narrow[:380], self.results(wide_path, *LSB, *SMALL_WINDOW)[:380])

    def test_fixed_and_float_agree(self):
        fixed = self.run_with("--lsb", "0.01")
        for other in (self.run_with("--arith", "float"), self.run_with()):
            for a, b in zip(fixed, other):
                for name in ("adev_1", "adev_2", "adev_4"):
                    self.assertAlmostEqual(1.0, float(a[name]) / float(b[name]), delta=1e-6)

    def test_the_chosen_count_size_is_reported(self):
        self.assertIn(
            "note: no --lsb: using counts of 2^-", self.sim(self.path, *SMALL_WINDOW).stderr
        )
        self.assertEqual("", self.sim(self.path, *SMALL_WINDOW, *LSB).stderr)

    def test_zeros_only(self):
        path = self.write(
            "zero.csv", as_text("time_s,gyro_x_dps", [[f"{i}", "0"] for i in range(100)])
        )
        for options in ((), ("--arith", "float"), LSB):
            self.assertEqual(
                {"0"}, {row["adev_1"] for row in self.results(path, *SMALL_WINDOW, *options)}
            )

    def test_coarse_counts_are_pointed_out(self):
        rows = [[f"{i}", f"{1e7 + i % 7 * 1e-4:.4f}"] for i in range(100)]
        path = self.write("offset.csv", as_text("time_s,freq_hz", rows))
        for options in ((), ("--arith", "float")):
            self.assertIn("subtract a constant", self.sim(path, *SMALL_WINDOW, *options).stderr)

    def test_no_saturation_is_counted_in_a_recording_that_fits(self):
        for options in (("--lsb", "0.01", "--bits", "24"), ("--arith", "float"), ()):
            self.assertNotIn("saturated", self.sim(self.path, *SMALL_WINDOW, *options).stderr)

    def test_saturation_is_counted(self):
        done = self.sim(self.path, *SMALL_WINDOW, "--arith", "float", "--full-scale", "0.125")
        self.assertRegex(done.stderr, r"[1-9]\d* samples saturated")

    def test_options_without_effect_are_pointed_out(self):
        self.assertIn(
            "--full-scale is not used",
            self.sim(self.path, *SMALL_WINDOW, "--full-scale", "9").stderr,
        )
        self.assertIn(
            "--bits is not used", self.sim(self.path, *SMALL_WINDOW, "--bits", "16").stderr
        )
        self.assertIn(
            "--lsb is not used", self.sim(self.path, *SMALL_WINDOW, *LSB, "--arith", "float").stderr
        )


class JsonLines(SimCase):
    def test_the_same_names_and_values_as_csv(self):
        path = self.recording()
        options = (*LSB, *SMALL_WINDOW, "--details")
        done = self.sim(path, *options, "--out", "jsonl")
        objects = [json.loads(line) for line in done.stdout.splitlines()]
        rows = self.results(path, *options)
        self.assertEqual(len(rows), len(objects))
        for row, object_ in zip(rows, objects):
            self.assertEqual("gyro_x_dps", object_.pop("channel"))
            self.assertEqual(
                {name: float(text) if text else None for name, text in row.items()}, object_
            )

    def test_an_odd_column_name_is_quoted(self):
        path = self.write("odd.csv", as_text('time_s,"gyro\\ x"', noise_rows(100)))
        line = self.sim(path, *LSB, *SMALL_WINDOW, "--out", "jsonl").stdout.splitlines()[0]
        self.assertEqual('"gyro\\ x"', json.loads(line)["channel"])


class Pace(SimCase):
    def timed(self, *options, rate_hz=100.0):
        begin = time.monotonic()
        rows = self.results(
            self.recording(count=100, rate_hz=rate_hz), *LSB, *SMALL_WINDOW, *options
        )
        return time.monotonic() - begin, rows

    def test_real_time_takes_the_time_of_the_recording(self):
        seconds, rows = self.timed("--pace", "realtime")
        self.assertGreater(seconds, 0.95)
        self.assertEqual(self.timed()[1], rows)

    def test_a_factor_shortens_it(self):
        """A recording of 1000 s: even the slowest machine needs less."""
        seconds, rows = self.timed("--pace", "20000", rate_hz=0.1)
        self.assertGreater(seconds, 0.048)
        self.assertLess(seconds, 500)
        self.assertEqual(self.timed("--pace", "max", rate_hz=0.1)[1], rows)

    def test_gaps_take_time_too(self):
        rows = noise_rows(100)
        for row in rows[50:]:
            row[0] = f"{float(row[0]) + 4.0:.4f}"
        path = self.write("gap.csv", as_text("time_s,gyro_x_dps", rows))
        begin = time.monotonic()
        self.results(path, *LSB, *SMALL_WINDOW, "--pace", "10")
        self.assertGreater(time.monotonic() - begin, 0.48)


class Progress(SimCase):
    def test_no_progress_without_a_terminal(self):
        self.assertEqual("", self.sim(self.recording(), *LSB, *SMALL_WINDOW, "--pace", "2").stderr)

    def test_a_line_a_second_when_asked_for(self):
        done = self.sim(
            self.recording(count=150),
            *LSB,
            *SMALL_WINDOW,
            "--pace",
            "realtime",
            "--progress",
            "always",
        )
        self.assertRegex(done.stderr, r"^davar-sim: running +\d+ %\n")


if __name__ == "__main__":
    unittest.main()
