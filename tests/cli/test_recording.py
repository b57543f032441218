"""Recordings in all their forms: the same samples give the same results."""

import gzip
import statistics
import unittest

from sim_case import SMALL_WINDOW, SimCase, as_text, noise_rows

FIXED_WINDOW = ("--policy", "fixed", *SMALL_WINDOW, "--lsb", "0.01")


class Forms(SimCase):
    """One text, written in many ways."""

    def setUp(self):
        super().setUp()
        self.text = as_text("time_s,gyro_x_dps", noise_rows(200))
        self.expected = self.sim(self.write("plain.csv", self.text), *FIXED_WINDOW)
        self.assertEqual(0, self.expected.returncode, self.expected.stderr)
        self.assertEqual(201, self.expected.stdout.count("\n"))

    def assert_same(self, content, name="form.csv"):
        done = self.sim(self.write(name, content), *FIXED_WINDOW)
        self.assertEqual("", done.stderr)
        self.assertEqual(self.expected.stdout, done.stdout)

    def test_comment_lines(self):
        self.assert_same("# sensor: none\n#\n\n" + self.text)

    def test_byte_order_mark(self):
        self.assert_same("\ufeff" + self.text)
        self.assert_same("\ufeff# note: x\n" + self.text)

    def test_windows_line_ends(self):
        self.assert_same(self.text.replace("\n", "\r\n"))

    def test_no_newline_at_the_end(self):
        self.assert_same(self.text.rstrip("\n"))
        self.assert_same(self.text.replace("\n", "\r\n").rstrip("\n"))

    def test_blank_lines_at_the_end(self):
        self.assert_same(self.text + "\n\n  \n\t\r\n")

    def test_spaces_around_names_and_values(self):
        self.assert_same(
            "\n".join(" " + line.replace(",", " ,\t") + "  " for line in self.text.splitlines())
        )

    def test_plus_signs_and_exponents(self):
        lines = self.text.splitlines()
        rows = [line.split(",") for line in lines[1:]]
        self.assert_same(
            as_text(
                lines[0], [["+" + time, f"{round(100 * float(rate))}e-2"] for time, rate in rows]
            )
        )

    def test_gzip_by_content_not_by_name(self):
        self.assert_same(gzip.compress(self.text.encode()))
        path = self.write("plain_named.txt", self.text).rename(self.folder / "named.csv.gz")
        self.assertEqual(self.expected.stdout, self.sim(path, *FIXED_WINDOW).stdout)

    def test_gzip_in_several_members(self):
        middle = self.text.index("\n", 1000) + 5
        self.assert_same(
            gzip.compress(self.text[:middle].encode()) + gzip.compress(self.text[middle:].encode())
        )

    def test_standard_input(self):
        for data in (self.text.encode(), gzip.compress(self.text.encode())):
            self.assertEqual(self.expected.stdout, self.sim("-", *FIXED_WINDOW, stdin=data).stdout)
            self.assertEqual(
                self.expected.stdout, self.sim("/dev/stdin", *FIXED_WINDOW, stdin=data).stdout
            )

    def test_other_columns_do_not_matter(self):
        rows = [line.split(",") for line in self.text.splitlines()[1:]]
        self.assert_same(
            as_text(
                "temp_degC,time_s,accel_x_g,gyro_x_dps,gyro_y_dps",
                [["20", time, "1", rate, "5"] for time, rate in rows],
            )
        )

    def test_counts_and_their_size(self):
        rows = [line.split(",") for line in self.text.splitlines()[1:]]
        counts = [[time, str(round(100 * float(rate)))] for time, rate in rows]
        self.assert_same(as_text("time_s,gyro_x_counts", counts))

    def test_no_time_but_a_rate(self):
        rows = [[line.split(",")[1]] for line in self.text.splitlines()[1:]]
        done = self.sim(
            self.write("form.csv", as_text("gyro_x_dps", rows)), *FIXED_WINDOW, "--rate", "100"
        )
        self.assertEqual(self.expected.stdout, done.stdout)

    def test_a_line_longer_than_most(self):
        header, rest = self.text.split("\n", 1)
        padded = header + "\n" + rest.replace(",", "," + " " * 100000, 1)
        self.assert_same(padded)


class Columns(SimCase):
    def three_axes(self):
        header = "time_s,accel_x_g,gyro_x_dps,gyro_y_dps,gyro_z_dps"
        return self.write("axes.csv", as_text(header, noise_rows(200, columns=4)))

    def test_the_first_gyro_column_is_the_default(self):
        path = self.three_axes()
        self.assertEqual(
            self.results(path, "--column", "gyro_x_dps", *FIXED_WINDOW),
            self.results(path, *FIXED_WINDOW),
        )

    def test_the_only_other_column_is_the_default(self):
        path = self.write("temp.csv", as_text("time_s,temp_degC", noise_rows(200)))
        done = self.sim(path, *FIXED_WINDOW)
        self.assertEqual(0, done.returncode)
        self.assertIn("note: column temp_degC", done.stderr)

    def test_several_columns_come_epoch_by_epoch_in_the_given_order(self):
        wanted = ["gyro_z_dps", "gyro_x_dps", "gyro_y_dps"]
        path = self.three_axes()
        for arguments in (
            (path, "--column", *wanted),
            (path, "--column", ",".join(wanted)),
            ("--column", wanted[0], path, "--column", ",".join(wanted[1:])),
            (path, *(word for name in wanted for word in ("--column", name))),
        ):
            rows = self.results(*arguments, *FIXED_WINDOW)
            self.assertEqual(wanted * 200, [row["channel"] for row in rows])
            self.assertEqual([str(i // 3) for i in range(600)], [row["epoch"] for row in rows])

    def test_a_column_gives_the_same_results_alone_and_in_company(self):
        path = self.three_axes()
        alone = self.results(path, "--column", "gyro_y_dps", *FIXED_WINDOW)
        together = self.results(path, "--column", "gyro_x_dps", "gyro_y_dps", *FIXED_WINDOW)
        company = [row for row in together if row.pop("channel") == "gyro_y_dps"]
        self.assertEqual(alone, company)

    def test_rad_per_second_is_converted(self):
        rows = noise_rows(200)
        degrees = self.results(
            self.write("a.csv", as_text("time_s,gyro_x_dps", rows)), *FIXED_WINDOW
        )
        radians = [[time, repr(float(rate) * 0.017453292519943295)] for time, rate in rows]
        path = self.write("b.csv", as_text("time_s,gyro_x_rad_s", radians))
        self.assertEqual(degrees, self.results(path, *FIXED_WINDOW))


class Rate(SimCase):
    def arw(self, path, *options):
        return float(self.results(path, *FIXED_WINDOW, *options)[100]["arw_deg_per_sqrt_h"])

    def test_the_rate_is_the_median_step(self):
        rows = noise_rows(201, rate_hz=50.0)
        steady = self.arw(self.write("steady.csv", as_text("time_s,gyro_x_dps", rows)))
        for row in rows[150:]:
            row[0] = f"{float(row[0]) + 1e-3:.4f}"
        shifted = self.write("shifted.csv", as_text("time_s,gyro_x_dps", rows))
        self.assertAlmostEqual(1.0, self.arw(shifted) / steady, places=7)

    def test_the_median_of_an_even_number_of_steps_is_the_mean_of_the_middle_two(self):
        steps = [0.25, 0.5, 0.125, 0.75] * 50
        times = [sum(steps[:i]) for i in range(len(steps) + 1)]
        rows = [[repr(time), row[1]] for time, row in zip(times, noise_rows(201))]
        path = self.write("steps.csv", as_text("time_s,gyro_x_dps", rows))
        median = statistics.median(steps)
        self.assertEqual(self.arw(path, "--gap", "9"), self.arw(path, "--rate", repr(1.0 / median)))

    def test_a_given_rate_wins(self):
        path = self.recording(count=200)
        self.assertAlmostEqual(2.0, self.arw(path) / self.arw(path, "--rate", "400"), places=7)
        self.assertIn(
            "note: using --rate 400, but the time stamps give 100 Hz",
            self.sim(self.recording(400), "--rate", "400").stderr,
        )
        self.assertNotIn("time stamps", self.sim(self.recording(400), "--rate", "101").stderr)

    def test_two_rows_are_enough_to_know_the_rate(self):
        path = self.write("two.csv", "time_s,gyro_x_dps\n0,1\n0.5,2\n")
        rows = self.results(path, "--window-max", "4", "--taus", "1", "--lsb", "1")
        self.assertEqual(["0", "0.5"], [row["time_s"] for row in rows])

    def test_uneven_time_stamps_are_pointed_out(self):
        rows = noise_rows(300)
        for i, row in enumerate(rows):
            row[0] = f"{0.01 * (i // 10 * 10 + i % 10 / 5):.4f}"
        done = self.sim(self.write("jitter.csv", as_text("time_s,gyro_x_dps", rows)), *FIXED_WINDOW)
        self.assertEqual(0, done.returncode)
        self.assertIn("note: ", done.stderr)
        self.assertIn("give --rate 10", done.stderr)


class Gaps(SimCase):
    def with_gap(self, step_periods):
        rows = noise_rows(200)
        for row in rows[100:]:
            row[0] = f"{float(row[0]) + 0.01 * (step_periods - 1.0):.6f}"
        return self.write("gap.csv", as_text("time_s,gyro_x_dps", rows))

    def gaps(self, path, *options):
        done = self.sim(path, *FIXED_WINDOW, "--details", *options)
        self.assertEqual(0, done.returncode, done.stderr)
        return done

    def test_a_long_step_is_a_gap_and_its_samples_are_counted(self):
        self.assertIn("1 gaps (4 samples missing)", self.gaps(self.with_gap(5.0)).stderr)
        self.assertIn("1 gaps (1 samples missing)", self.gaps(self.with_gap(1.6)).stderr)

    def test_a_slightly_long_step_is_not_a_gap(self):
        self.assertEqual("", self.gaps(self.with_gap(1.4)).stderr)

    def test_the_gap_factor_decides(self):
        self.assertEqual("", self.gaps(self.with_gap(5.0), "--gap", "6").stderr)
        self.assertIn("1 gaps", self.gaps(self.with_gap(1.4), "--gap", "1.3").stderr)

    def test_a_given_rate_switches_gaps_off_unless_a_factor_is_given(self):
        path = self.with_gap(5.0)
        self.assertEqual("", self.gaps(path, "--rate", "100").stderr)
        self.assertIn(
            "1 gaps (4 samples missing)", self.gaps(path, "--rate", "100", "--gap", "1.5").stderr
        )

    def test_differences_across_the_gap_are_excluded(self):
        rows = self.results(self.with_gap(5.0), *FIXED_WINDOW, "--details")
        far, near = rows[40], rows[100]
        self.assertEqual(
            ("0", "59", "57"), (far["gaps_in_window"], far["differences_1"], far["differences_2"])
        )
        self.assertEqual(
            ("1", "58", "54"),
            (near["gaps_in_window"], near["differences_1"], near["differences_2"]),
        )

    def test_the_time_of_an_epoch_after_the_gap_is_its_time_stamp(self):
        rows = self.results(self.with_gap(5.0), *FIXED_WINDOW)
        self.assertEqual(["0.99", "1.04"], [rows[99]["time_s"], rows[100]["time_s"]])


if __name__ == "__main__":
    unittest.main()
