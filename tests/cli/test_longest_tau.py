"""davar-sim --longest-tau: cluster sizes beyond the window, compared with brute force over the
recording. Tests of recordings that may not be distributed are skipped if their folder
(DAVAR_REAL_DATA) is absent.
"""

import csv
import gzip
import json
import math
import os
import random
import struct
import threading
import unittest
from itertools import accumulate
from pathlib import Path

from sim_case import SimCase, as_text

REAL = Path(os.environ.get("DAVAR_REAL_DATA", "../shared/data/real"))
RATE_HZ = 100.0
LSB = 2.0**-7  # deg/s; every arithmetic holds these samples exactly
SAMPLES = 60_000
STRIDE = 211  # odd, so that results fall between the hops
CLUSTERS = 32
TAUS = (1, 2, 4, 8, 16, 32, 64)
LONG = (128, 256, 512, 1024, 2048, 4096, 8192)
LONGEST_S = 100  # 81.92 s is the last octave
FIXED = ("--policy", "fixed", "--stride", STRIDE)
GAPS = {9000: 7, 9100: 1, 31_313: 400}  # sample: how many are missing before it


def needs(name):
    return unittest.skipUnless((REAL / name).is_file(), f"needs the recording {name}")


def counts_of(samples, seed=5):
    """White noise and a random walk, in counts."""
    source, walk, counts = random.Random(seed), 0.0, []
    for _ in range(samples):
        walk += source.gauss(0, 0.4)
        counts.append(round(source.gauss(0, 60) + walk))
    return counts


def recording_of(counts, gaps=None):
    tick, rows = 0, []
    for i, count in enumerate(counts):
        tick += 1 + (gaps.get(i, 0) if gaps else 0)
        rows.append([f"{tick / RATE_HZ:.2f}", repr(count * LSB)])
    return as_text("time_s,gyro_x_dps", rows)


def hops_of(m, first):
    """A stage has two sizes with one hop: 4 and 8 hops long."""
    octave = (m // first).bit_length() - 1
    return m // (4 << (octave % 2))


def brute_force(sums, m, first, end, gaps):
    """(Allan deviation in counts, number of differences) of one size after `end` samples."""
    hop = hops_of(m, first)
    generation = CLUSTERS * m // hop
    hops = end // hop
    current = max(hops - 1, 0) // generation
    oldest = max(current - 1, 0) * generation + 1
    squares = []
    for e in range(oldest, hops + 1):
        start, stop = e * hop - 2 * m, e * hop
        if start >= 0 and not any(start < gap < stop for gap in gaps):
            squares.append((sums[stop] - 2 * sums[stop - m] + sums[start]) ** 2)
    deviation = math.sqrt(sum(squares) / (2 * len(squares))) / m if squares else None
    return deviation, len(squares)


class Values(SimCase):
    @classmethod
    def setUpClass(cls):
        cls.counts = counts_of(SAMPLES)
        cls.sums = [0, *accumulate(cls.counts)]
        cls.plain = recording_of(cls.counts)
        cls.broken = recording_of(cls.counts, GAPS)

    def check(self, text, gaps, *options, first=128, sizes=LONG):
        """Compares every row whose newest hops have certainly been added (11.2)."""
        rows = self.results(
            self.write("rec.csv", text), "--longest-tau", LONGEST_S, "--details", *options
        )
        compared = 0
        for row in rows:
            end = int(row["epoch"]) + 1
            if end % hops_of(first, first) <= len(sizes) + 3:
                continue
            for m in sizes:
                deviation, number = brute_force(self.sums, m, first, end, gaps)
                self.assertEqual(number, int(row[f"differences_{m}"]), (end, m))
                if number == 0:
                    self.assertEqual("", row[f"adev_{m}"])
                    continue
                self.assertAlmostEqual(1, float(row[f"adev_{m}"]) / (deviation * LSB), 7, (end, m))
                compared += 1
        self.assertGreater(compared, 200)
        return rows

    def test_int16_counts(self):
        self.check(self.plain, {}, *FIXED, "--mode", "trailing", "--lsb", LSB, "--bits", 16)

    def test_int32_counts(self):
        self.check(self.plain, {}, *FIXED, "--mode", "trailing")

    def test_floats(self):
        self.check(self.plain, {}, *FIXED, "--mode", "trailing", "--arith", "float")

    def test_gaps_in_every_arithmetic(self):
        for options in (("--lsb", LSB), (), ("--arith", "float")):
            with self.subTest(options=options):
                self.check(self.broken, GAPS, *FIXED, "--mode", "trailing", *options)

    def test_glr_gives_the_cascade_every_sample_at_once(self):
        """Samples of the window wait in a queue. The last result has no later ones."""
        count = SAMPLES - 10  # between two hops
        text = recording_of(self.counts[:count], GAPS)
        glr = ("--policy", "glr", "--stride", 10, "--window-max", 600, "--lsb", LSB)
        options = ("--longest-tau", LONGEST_S, "--taus", "1,2,4,8,16,32,64", "--details")
        rows = self.results(self.write("rec.csv", text), *glr, *options)
        for row in rows[:-1]:  # the window of an epoch waits for later samples
            end = int(row["epoch"]) + 1
            if end % 32 > 14:
                number = brute_force(self.sums, 128, 128, end, GAPS)[1]
                self.assertLessEqual(number, int(row["differences_128"]))
        for m in LONG:
            deviation, number = brute_force(self.sums, m, 128, count, GAPS)
            self.assertEqual(str(number), rows[-1][f"differences_{m}"])
            self.assertAlmostEqual(1, float(rows[-1][f"adev_{m}"]) / (deviation * LSB), 7)

    def test_a_first_size_that_no_octave_gives(self):
        sizes = tuple(140 << k for k in range(7))
        options = (*FIXED, "--mode", "trailing", "--lsb", LSB, "--taus", "1,7,35")
        self.check(self.plain, {}, *options, first=140, sizes=sizes)

    def test_centred_windows_end_at_the_newest_sample(self):
        """The window of an epoch ends half its length later, and so do the long sizes."""
        options = (*FIXED, "--window-max", 600, "--window-min", 600, "--lsb", LSB, "--details")
        path = self.write("rec.csv", self.plain)
        rows = self.results(path, *options, "--longest-tau", LONGEST_S)
        for row in rows[: -600 // STRIDE - 1]:
            end = int(row["epoch"]) + 1 + 300
            if end % 32 > 14:
                for m in LONG:
                    self.assertEqual(
                        brute_force(self.sums, m, 128, end, {})[1], int(row[f"differences_{m}"])
                    )
        last = [brute_force(self.sums, m, 128, SAMPLES, {}) for m in LONG]
        for m, (deviation, number) in zip(LONG, last):
            self.assertEqual(str(number), rows[-1][f"differences_{m}"])
            self.assertAlmostEqual(1, float(rows[-1][f"adev_{m}"]) / (deviation * LSB), 7)

    def test_the_window_s_sizes_stay_as_they_are(self):
        path = self.write("rec.csv", self.broken)
        options = ("--lsb", LSB, "--stride", 500)
        for one, other in zip(
            self.results(path, *options), self.results(path, *options, "--longest-tau", LONGEST_S)
        ):
            for m in TAUS:
                self.assertEqual(one[f"adev_{m}"], other[f"adev_{m}"])
            for name in ("epoch", "window_samples", "kurtosis", "contribution", "unstable"):
                self.assertEqual(one[name], other[name])

    def test_the_coefficients_are_those_of_the_whole_curve(self):
        """0.4 counts per sample are a rate random walk that 6 s do not show."""
        path = self.write("rec.csv", self.plain)
        options = ("--lsb", LSB, "--mode", "trailing", *FIXED, "--bandwidth", "none")
        short = self.results(path, *options)[-1]
        row = self.results(path, *options, "--longest-tau", LONGEST_S)[-1]
        truth = 0.4 * LSB * math.sqrt(RATE_HZ) * 3600 * 60
        self.assertEqual("", short["rrw_deg_per_h_per_sqrt_h"])
        self.assertAlmostEqual(1, float(row["rrw_deg_per_h_per_sqrt_h"]) / truth, delta=0.4)
        self.assertAlmostEqual(
            1, float(row["arw_deg_per_sqrt_h"]) / (60 * LSB * 60 / math.sqrt(RATE_HZ)), delta=0.05
        )

    def test_several_columns_have_a_cascade_each(self):
        twice = [
            f"{line},{2 * float(line.split(',')[1])!r}" for line in self.plain.splitlines()[1:]
        ]
        path = self.write("two.csv", "\n".join(["time_s,gyro_x_dps,gyro_y_dps", *twice]) + "\n")
        rows = self.results(
            path, "--column", "gyro_x_dps,gyro_y_dps", "--lsb", LSB, *FIXED, "--longest-tau", 20
        )
        for one, other in zip(rows[-2::-2], rows[-1::-2]):
            for m in (128, 2048 // 2):
                if one[f"adev_{m}"]:
                    ratio = float(other[f"adev_{m}"]) / float(one[f"adev_{m}"])
                    self.assertAlmostEqual(2, ratio, 7)


class Form(SimCase):
    def setUp(self):
        super().setUp()
        self.path = self.write("rec.csv", recording_of(counts_of(4000)))
        self.options = (self.path, "--lsb", LSB, "--stride", 600, "--longest-tau", 5.12)

    def test_columns_ascend_after_the_window_s(self):
        names = list(self.results(*self.options, "--details")[0])
        sizes = [*TAUS, 128, 256, 512]
        at = names.index("adev_1")
        self.assertEqual([f"adev_{m}" for m in sizes], names[at : at + len(sizes)])
        for m in (128, 512):
            for prefix in ("adev_low", "adev_high", "differences"):
                self.assertIn(f"{prefix}_{m}", names)
        self.assertNotIn("adev_1024", names)

    def test_an_octave_is_reached_in_spite_of_the_digits_of_time_stamps(self):
        """The median step of 0.1 s is a rate of 9.9999999..."""
        rows = [[repr(i * 0.1), repr(count * LSB)] for i, count in enumerate(counts_of(2000))]
        for seconds, last in ((12.8, 128), (25.6, 256), (51.2, 512), (25.5, 128)):
            with self.subTest(seconds):
                path = self.write("rec.csv", as_text("time_s,gyro_x_dps", rows))
                found = self.results(path, "--lsb", LSB, "--longest-tau", seconds, "--stride", 600)
                self.assertEqual(f"adev_{last}", list(found[0])[-1])

    def test_a_size_needs_two_clusters(self):
        rows = self.results(*self.options, "--mode", "trailing", "--policy", "fixed")
        self.assertEqual(
            [int(row["epoch"]) >= 2 * 512 for row in rows], [row["adev_512"] != "" for row in rows]
        )

    def test_json_lines_have_the_same(self):
        rows = self.results(*self.options)
        lines = self.sim(*self.options, "--out", "jsonl").stdout.splitlines()
        for row, line in zip(rows, map(json.loads, lines), strict=True):
            self.assertEqual(float(row["adev_256"]), line["adev_256"])

    def test_a_model_table_may_have_long_sizes_only(self):
        table = "m,adev_dps,relative_tolerance\n512,0.02,0.1\n"
        rows = self.results(*self.options, "--model-table", self.write("model.csv", table))
        self.assertNotEqual("", rows[-1]["model_health"])
        self.assertNotEqual("", rows[-1]["model_deviation_512"])
        self.assertEqual("", rows[-1]["model_deviation_64"])

    def test_frames_carry_every_size_and_its_length(self):
        """Setup names one setting per result, so the lengths arrive in turn."""
        primary, secondary = os.openpty()
        got = []

        def drain():
            try:
                while chunk := os.read(primary, 4096):
                    got.append(chunk)
            except OSError:
                return

        reader = threading.Thread(target=drain, daemon=True)
        reader.start()
        options = (*self.options, "--stride", 100)
        done = self.sim(*options, "--out", f"slcan:{os.ttyname(secondary)}")
        self.assertEqual(0, done.returncode, done.stderr)
        os.close(secondary)
        reader.join(5)
        lines = b"".join(got).decode().split("\r")
        setup = [bytes.fromhex(line[5:]) for line in lines if line.startswith("t5D6")]
        lengths = {
            frame[2] - 32: int.from_bytes(frame[4:], "little") for frame in setup if frame[2] >= 32
        }
        self.assertEqual(dict(enumerate([*TAUS, 128, 256, 512])), lengths)
        adevs = [bytes.fromhex(line[5:]) for line in lines if line.startswith("t5D3")]
        last = {frame[2] & 31: struct.unpack("<f", frame[4:])[0] for frame in adevs[-10:]}
        row = self.results(*options)[-1]
        for t, m in lengths.items():
            self.assertAlmostEqual(1, last[t] / float(row[f"adev_{m}"]), 6)


class Refused(SimCase):
    def refuse(self, value, *words, options=()):
        path = self.recording()
        done = self.sim(path, "--lsb", 0.01, "--longest-tau", value, *options)
        self.assert_refused(done, "--longest-tau", *words)

    def test_the_range_is_reported(self):
        for value in ("1.27", "1e-300"):
            self.refuse(value, "from 1.28 s to less than", "100 Hz", "64 samples", f"found {value}")
        self.refuse("21475000", "to less than 21474836.5 s")  # 2^31 samples
        self.refuse("1e300", "to less than 21474836.5 s")

    def test_wide_counts_and_floats_reach_less_far(self):
        wide = ("--bits", 32, "--lsb", 1e-6, "--rate", 100)
        path = self.write("rec.csv", as_text("gyro_x_dps", [[f"{i % 7}"] for i in range(900)]))
        for options, most in ((wide, "2684354.56"), (("--arith", "float"), "5368709.12")):
            done = self.sim(path, "--rate", 100, "--longest-tau", 1e7, *options)
            self.assert_refused(done, "--longest-tau", f"to less than {most} s")

    def test_there_must_be_room_after_the_window(self):
        every = ",".join(str(m) for m in range(1, 33))
        self.refuse("10", "at most 31 cluster sizes", "found 32", options=("--taus", every))
        most = ",".join(str(m) for m in range(1, 32))
        self.refuse("2.5", "less than 2.48 s", options=("--taus", most))
        path = self.recording(700)
        rows = self.results(path, "--longest-tau", 2, "--taus", most, "--stride", 600)
        self.assertEqual("adev_124", list(rows[0])[-1])

    def test_the_window_must_not_reach_too_far(self):
        options = ("--window-max", 262144, "--taus", "1,131072", "--policy", "fixed")
        path = self.recording(600)
        done = self.sim(path, "--longest-tau", 1e5, "--mode", "trailing", "--segment", 0, *options)
        self.assertEqual(2, done.returncode)

    def test_words_are_no_times(self):
        for value in ("", "x", "0", "-5", "nan", "inf", "1h"):
            self.refuse(value)


class Real(SimCase):
    """Days and hours of real gyros, compared with brute force over their samples."""

    def check(self, name, gap_s, rate_hz, first, sizes, *options):
        times, values = [], []
        with gzip.open(REAL / name, "rt", encoding="ascii") as file:
            for row in csv.DictReader(line for line in file if not line.startswith("#")):
                times.append(float(row["time_s"]))
                values.append(float(row["gyro_x_dps"]))
        gaps = [i for i in range(1, len(times)) if times[i] - times[i - 1] > gap_s]
        sums = [0.0, *accumulate(values)]
        found = self.results(
            REAL / name,
            *("--column", "gyro_x_dps", "--mode", "trailing", "--policy", "fixed", "--details"),
            *("--bandwidth", "none", "--longest-tau", 1e5 / rate_hz, *options),
        )
        end = int(found[-1]["epoch"]) + 1
        self.assertGreater(end % hops_of(first, first), len(sizes) + 3)
        for m in sizes:
            deviation, number = brute_force(sums, m, first, end, gaps)
            self.assertEqual(str(number), found[-1][f"differences_{m}"])
            if number > 0:
                self.assertAlmostEqual(1, float(found[-1][f"adev_{m}"]) / deviation, 4)
        return [float(found[-1][f"adev_{m}"]) for m in sizes if found[-1][f"adev_{m}"]]

    @needs("sensehat_lsm9ds1_bench_3days.csv.gz")
    def test_three_days_of_a_driver_that_subtracts_a_bias(self):
        sizes = [128 << k for k in range(10)]
        curve = self.check(
            *("sensehat_lsm9ds1_bench_3days.csv.gz", 30, 0.1, 128, sizes),
            *("--gap", 3, "--stride", 590),
        )
        self.assertEqual(7, len(curve))  # up to 22 h
        for one, other in zip(curve, curve[1:]):
            self.assertLess(other, 0.7 * one)

    @needs("sensehat_lsm9ds1_iss_3h.csv.gz")
    def test_three_hours_in_orbit(self):
        sizes = [64 << k for k in range(6)]
        curve = self.check(
            *("sensehat_lsm9ds1_iss_3h.csv.gz", 1e9, 0.5157, 64, sizes),
            *("--rate", 0.5157, "--window-max", 300, "--stride", 293, "--lsb", 0.0175),
        )
        self.assertEqual(6, len(curve))  # up to 66 min
        self.assertGreater(curve[4], 1.3 * curve[1])  # the cycle of 93 min


if __name__ == "__main__":
    unittest.main()
