"""--bandwidth auto: the filter of each column is learned from the recording."""

import random
import unittest

from sim_case import SMALL_WINDOW, SimCase, as_text, noise_rows

COUNT = 20_000


def one_pole_rows(count, cutoff, seed=5):
    """Rows of time_s, white noise, and white noise after a one-pole low-pass, cutoff over rate."""
    source = random.Random(seed)
    decay = 2.718281828459045 ** (-6.283185307179586 * cutoff)
    level, rows = 0.0, []
    for i in range(count):
        level = decay * level + (1 - decay) * source.gauss(0.0, 300.0)
        rows.append([f"{i / 100:.2f}", f"{source.gauss(0.0, 300.0):.0f}", f"{level:.0f}"])
    return rows


class Auto(SimCase):
    options = ("--lsb", "1", "--stride", "500", "--bandwidth", "auto")

    def two_columns(self, count=COUNT):
        header = "time_s,gyro_x_counts,gyro_y_counts"
        return self.write("two.csv", as_text(header, one_pole_rows(count, 0.1)))

    def test_each_column_has_its_own_filter(self):
        done = self.sim(
            self.two_columns(), "--column", "gyro_x_counts,gyro_y_counts", *self.options
        )
        self.assertEqual(0, done.returncode, done.stderr)
        white, filtered = done.stderr.splitlines()[:2]
        self.assertIn("gyro_x_counts: white up to half the sample rate", white)
        self.assertIn("--bandwidth none", white)
        self.assertRegex(filtered, r"gyro_y_counts: one-pole low-pass at (9\.|1[01])")

    def test_the_value_that_it_prints_gives_the_same_results(self):
        recording = self.two_columns()
        column = ("--column", "gyro_y_counts")
        learned = self.sim(recording, *column, *self.options)
        value = learned.stderr.splitlines()[0].split("--bandwidth ")[1]
        declared = self.sim(recording, *column, *self.options[:-1], value)
        for one, other in zip(learned.stdout.splitlines()[1:], declared.stdout.splitlines()[1:]):
            for a, b in zip(one.split(","), other.split(",")):
                if a or b:
                    self.assertAlmostEqual(float(a), float(b), delta=2e-3 * abs(float(a)))

    def test_a_pipe_can_be_learned_from(self):
        recording = self.two_columns()
        column = ("--column", "gyro_y_counts")
        file = self.sim(recording, *column, *self.options)
        pipe = self.sim("-", *column, *self.options, stdin=recording.read_bytes())
        self.assertEqual((0, file.stdout, file.stderr), (0, pipe.stdout, pipe.stderr))

    def test_a_short_recording_leaves_the_filter_unknown(self):
        recording = self.recording(4000)
        unknown = self.sim(recording, "--lsb", "0.01", "--stride", "500")
        done = self.sim(recording, "--lsb", "0.01", "--stride", "500", "--bandwidth", "auto")
        self.assertIn("filter unknown: it needs 4352 samples at rest", done.stderr)
        self.assertEqual(unknown.stdout, done.stdout)

    def test_segments_with_a_gap_are_left_out(self):
        rows = noise_rows(9000)
        for i in range(0, 9000, 500):
            rows[i] = None
        recording = self.write("gaps.csv", as_text("time_s,gyro_x_dps", [r for r in rows if r]))
        done = self.sim(recording, *SMALL_WINDOW, "--lsb", "0.01", "--bandwidth", "auto")
        self.assertIn("filter unknown: it needs 4352 samples at rest", done.stderr)

    def test_a_constant_signal_has_no_filter(self):
        rows = [[f"{i / 100:.2f}", "5"] for i in range(6000)]
        recording = self.write("still.csv", as_text("time_s,gyro_x_counts", rows))
        done = self.sim(recording, *self.options)
        self.assertIn("filter unknown: the signal does not change", done.stderr)

    def test_a_device_takes_one_filter(self):
        done = self.sim(
            self.two_columns(900),
            *("--column", "gyro_x_counts,gyro_y_counts", "--device", "true"),
            *self.options,
        )
        self.assert_refused(done, "--bandwidth auto", "one --column")


if __name__ == "__main__":
    unittest.main()
