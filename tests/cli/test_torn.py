"""Torn register reads: --skip-torn-reads skips them, and ARW is that of the other samples."""

import csv
import io
import math
import random
import unittest

from sim_case import SMALL_WINDOW, SimCase, as_text

RATE_HZ, LSB, SIGMA = 104.0, 0.00875, 3.0  # an LSM6DSL
TRUE_ARW = 60.0 * SIGMA * LSB / math.sqrt(RATE_HZ)
ROWS = 120_000
FIXED = ("--lsb", LSB, "--policy", "fixed", "--mode", "trailing", "--bandwidth", "none")
SKIPPED = "davar-sim: gyro_x_counts: {} torn register reads skipped\n"


def counts(rows, seed, sigma=SIGMA, offset=-250):
    source = random.Random(seed)
    return [round(offset + source.gauss(0.0, sigma)) for _ in range(rows)]


def tear(samples, seed, apart=1000, power=256):
    """Every 1000th sample on average, none of the first 100 and no two of four in a row."""
    source, torn, at = random.Random(seed), list(samples), 100
    places = []
    while (at := at + 4 + int(source.expovariate(1 / apart))) < len(torn) - 1:
        torn[at] += source.choice((-power, power))
        places.append(at)
    return torn, places


def rows(samples, times=True):
    return [
        ([f"{i / RATE_HZ:.6f}"] if times else []) + [str(count)] for i, count in enumerate(samples)
    ]


class Torn(SimCase):
    def counted(self, name, samples):
        return self.write(name, as_text("time_s,gyro_x_counts", rows(samples)))

    def arw(self, path, *options):
        """Root of the mean square over windows that do not overlap."""
        found = [
            float(row["arw_deg_per_sqrt_h"])
            for row in self.results(path, *FIXED, "--stride", 600, *options)
            if row["arw_deg_per_sqrt_h"]
        ]
        # Of ROWS / 600 windows: a fit of 600 samples withholds some, but never most of them.
        self.assertGreater(len(found), ROWS / 600 / 2)
        return math.sqrt(sum(value**2 for value in found) / len(found))

    def test_arw_is_that_of_the_sensor(self):
        for seed in (1, 2, 3):
            clean = counts(ROWS, seed)
            torn, places = tear(clean, seed)
            path = self.counted("torn.csv", torn)
            right = self.arw(self.counted("clean.csv", clean))
            with self.subTest(seed=seed):
                self.assertGreater(self.arw(path), 1.1 * TRUE_ARW)
                skipped = self.arw(path, "--skip-torn-reads")
                # The mean of 200 windows scatters by 0.2 %, and rounding adds 1/12 count^2: 0.5 %.
                self.assertAlmostEqual(right, skipped, delta=0.01 * right)
                self.assertAlmostEqual(TRUE_ARW, skipped, delta=0.01 * TRUE_ARW)
                done = self.sim(path, *FIXED, "--stride", 600, "--skip-torn-reads")
                self.assertIn(SKIPPED.format(len(places)), done.stderr)
                self.assertIn(f"{len(places)} gaps ({len(places)} samples missing)", done.stderr)

    def test_without_torn_reads_nothing_changes(self):
        path = self.counted("clean.csv", counts(3000, 4))
        plain = self.sim(path, *FIXED)
        done = self.sim(path, *FIXED, "--skip-torn-reads")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertEqual(plain.stdout, done.stdout)
        self.assertEqual(plain.stderr + SKIPPED.format(0), done.stderr)

    def test_a_torn_row_is_as_a_lost_row(self):
        """Also beside gaps, at the edges of the blocks of a copy, and without time stamps."""
        clean = counts(3000, 5)
        torn, places = tear(clean, 5, apart=60)
        for at in (511, 512, 513, 1023, 1024, 2998):
            if not set(places) & set(range(at - 3, at + 4)):
                torn[at] += 256
                places.append(at)
        lines = rows(torn)
        kept = [line for i, line in enumerate(lines) if i not in set(places)]
        lost = self.write("lost.csv", as_text("time_s,gyro_x_counts", kept))
        expected = self.results(lost, *FIXED, *SMALL_WINDOW)
        path = self.write("torn.csv", as_text("time_s,gyro_x_counts", lines))
        self.assertEqual(expected, self.results(path, *FIXED, *SMALL_WINDOW, "--skip-torn-reads"))
        bare = self.write("bare.csv", as_text("gyro_x_counts", rows(torn, times=False)))
        found = self.results(bare, *FIXED, *SMALL_WINDOW, "--rate", RATE_HZ, "--skip-torn-reads")
        for row, other in zip(expected, found, strict=True):
            self.assertAlmostEqual(float(row["time_s"]), float(other["time_s"]), places=5)
            self.assertEqual(row["kurtosis"], other["kurtosis"])
            self.assertEqual(row["adev_1"], other["adev_1"])

    def test_a_sample_beside_a_gap_is_not_judged(self):
        samples = counts(2000, 6)
        samples[1000] += 256
        lines = rows(samples)
        for lost in (999, 1001):
            kept = [line for i, line in enumerate(lines) if i != lost]
            path = self.write("gap.csv", as_text("time_s,gyro_x_counts", kept))
            done = self.sim(path, *FIXED, "--skip-torn-reads")
            self.assertIn(SKIPPED.format(0), done.stderr)
            self.assertIn("1 gaps (1 samples missing)", done.stderr)

    def test_a_row_is_skipped_in_every_column(self):
        left, right = counts(2000, 7), counts(2000, 8)
        left[700] += 256
        right[701] -= 512
        right[1300] += 1024
        text = as_text(
            "time_s,gyro_x_counts,gyro_y_counts",
            [[f"{i / RATE_HZ:.6f}", str(a), str(b)] for i, (a, b) in enumerate(zip(left, right))],
        )
        path = self.write("two.csv", text)
        done = self.sim(
            path, *FIXED, "--column", "gyro_x_counts,gyro_y_counts", "--skip-torn-reads"
        )
        self.assertIn("gyro_x_counts: 1 torn register reads skipped", done.stderr)
        self.assertIn("gyro_y_counts: 2 torn register reads skipped", done.stderr)
        # one gap of two rows and one of a row
        self.assertIn("2 gaps (3 samples missing)", done.stderr)
        epochs = [row["time_s"] for row in csv.DictReader(io.StringIO(done.stdout))]
        for at in (700, 701, 1300):
            self.assertNotIn(f"{at / RATE_HZ:.6f}", {f"{float(time):.6f}" for time in epochs})

    def test_saturated_samples_stay(self):
        samples = counts(3000, 9, offset=0)
        samples[1500:1510] = [32767] * 10
        path = self.counted("rail.csv", samples)
        for options in ((), ("--skip-torn-reads",)):
            done = self.sim(path, *FIXED, "--bits", 16, *options)
            self.assertIn("10 samples saturated", done.stderr)
        self.assertIn(SKIPPED.format(0), done.stderr)

    def test_auto_learns_from_the_other_samples(self):
        torn, places = tear(counts(80_000, 10), 10, apart=4000)
        path = self.counted("torn.csv", torn)
        options = ("--lsb", LSB, "--stride", 600, "--bandwidth", "auto", "--skip-torn-reads")
        done = self.sim(path, *options)
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn(SKIPPED.format(len(places)), done.stderr)
        self.assertIn("white up to half the sample rate, no filter", done.stderr)

    def test_it_needs_counts(self):
        path = self.recording()
        for options in ((), ("--arith", "float"), ("--arith", "float", "--lsb", "0.01")):
            self.assert_refused(
                self.sim(path, *options, "--skip-torn-reads"), "--skip-torn-reads", "--lsb"
            )
        self.assert_refused(
            self.sim(path, "--lsb", "0.01", "--skip-torn-reads=1"), "--skip-torn-reads", "no value"
        )

    def test_too_few_rows_that_stay(self):
        samples = counts(600, 11)
        samples[300] += 256
        path = self.counted("short.csv", samples)
        centred = ("--lsb", LSB, "--policy", "fixed")
        self.assertEqual(0, self.sim(path, *centred, "--window-max", 1200).returncode)
        done = self.sim(path, *centred, "--window-max", 1200, "--skip-torn-reads")
        self.assert_refused(done, "too short", "599")


if __name__ == "__main__":
    unittest.main()
