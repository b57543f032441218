"""Published Allan deviations, through the command line. Tests of recordings that may not be
distributed are skipped if the folder of the real recordings (DAVAR_REAL_DATA) is absent.
"""

import csv
import gzip
import math
import os
import unittest
from decimal import Decimal
from pathlib import Path

from sim_case import SimCase, as_text

REAL = Path(os.environ.get("DAVAR_REAL_DATA", "../shared/data/real"))


def needs(name):
    return unittest.skipUnless((REAL / name).is_file(), f"needs the recording {name}")


def nine_digits(value):
    return f"{value:.9g}"


def whole_record(count, *options):
    """One window over the complete recording: the ordinary overlapping Allan deviation."""
    return (
        "--mode",
        "trailing",
        "--policy",
        "fixed",
        "--window-max",
        count,
        "--window-min",
        count,
        "--stride",
        count,
        "--details",
        *options,
    )


class Nbs14(SimCase):
    """NIST SP 1065 (Riley), 1000 points; published to seven digits."""

    OVERLAPPING = {1: "0.2922319", 10: "0.09159953", 100: "0.03241343"}
    CLASSICAL = {1: "0.2922319", 10: "0.09965736", 100: "0.03897804"}

    def setUp(self):
        super().setUp()
        numbers = [1234567890]
        while len(numbers) < 1000:
            numbers.append(16807 * numbers[-1] % 2147483647)
        self.points = [n / 2147483647 for n in numbers]
        self.record = self.write(
            "nbs14.csv",
            as_text("time_s,gyro_z_dps", ([str(i), repr(y)] for i, y in enumerate(self.points))),
        )

    def check(self, *options):
        (row,) = self.results(self.record, *whole_record(1000, "--taus", "1,10,100", *options))
        for m, published in self.OVERLAPPING.items():
            self.assertEqual(float(published), float(f"{float(row[f'adev_{m}']):.7g}"))
        return row

    def test_overlapping_deviation_in_every_arithmetic(self):
        self.check()
        self.check("--arith", "float")
        self.check("--lsb", repr(1 / 2147483647), "--bits", "32")

    def test_nine_digits_against_the_definition(self):
        row = self.check()
        for m in self.OVERLAPPING:
            means = [math.fsum(self.points[i : i + m]) / m for i in range(1000 - m + 1)]
            squares = [(means[i + m] - means[i]) ** 2 for i in range(len(means) - m)]
            expected = math.sqrt(math.fsum(squares) / (2 * len(squares)))
            self.assertEqual(nine_digits(expected), row[f"adev_{m}"])

    def test_classical_deviation_from_averaged_points(self):
        """ADEV(m) without overlap is ADEV(1) of the record averaged over m points."""
        for m, published in self.CLASSICAL.items():
            means = [math.fsum(self.points[i : i + m]) / m for i in range(0, 1000, m)]
            record = self.write(
                f"by{m}.csv",
                as_text("time_s,gyro_z_dps", ([str(i), repr(y)] for i, y in enumerate(means))),
            )
            (row,) = self.results(
                record, *whole_record(len(means), "--taus", "1", "--segment", "1")
            )
            self.assertEqual(float(published), float(f"{float(row['adev_1']):.7g}"))


class Adis16405(SimCase):
    """One million samples; the published wavelet variances (twice) are overlapping Allan variances,
    to eleven digits.
    """

    @needs("adis16405_run1_static.csv.gz")
    def test_gyro_axes_at_every_published_size_to_nine_digits(self):
        with open(REAL / "adis16405_run1_published_avar.csv", encoding="ascii") as file:
            table = [
                row
                for row in csv.DictReader(line for line in file if not line.startswith("#"))
                if row["wvx2_gyro_x"]
            ]
        sizes = [row["m"] for row in table]
        rows = self.results(
            REAL / "adis16405_run1_static.csv.gz",
            "--column",
            "gyro_x_dps,gyro_y_dps,gyro_z_dps",
            "--lsb",
            "0.05",
            *whole_record(1000000, "--taus", ",".join(sizes)),
        )
        self.assertEqual(3, len(rows))
        self.assertEqual(18, len(sizes))
        for row in rows:
            axis = row["channel"][len("gyro_") : -len("_dps")]
            for published in table:
                expected = math.sqrt(float(published[f"wvx2_gyro_{axis}"]))
                self.assertEqual(
                    nine_digits(expected),
                    row[f"adev_{published['m']}"],
                    f"{axis} m = {published['m']}",
                )


class Oscillator(SimCase):
    """A quartz oscillator compared with a maser; Stable32's overlapping deviations, five digits.
    Not a gyro, near 1e-11.
    """

    @needs("ocxo_frequency_stable32.csv.gz")
    def test_stable32_deviations(self):
        with gzip.open(REAL / "ocxo_frequency_stable32.csv.gz", "rt") as file:
            lines = file.read().splitlines()
        published = [
            line.split(":")[1].split(",") for line in lines if line.startswith("# stable32_oadev:")
        ]
        data = [line.split(",") for line in lines if line[:1].isdigit()]
        fractions = ([time, f"{Decimal(hz) / Decimal(10**7) - 1:.20f}"] for time, hz in data)
        record = self.write("ocxo.csv", as_text("time_s,fractional_1", fractions))
        sizes = ",".join(m.strip() for m, *_ in published)
        (row,) = self.results(record, *whole_record(len(data), "--taus", sizes))
        self.assertEqual(20, len(published))
        for m, _, differences, deviation in published:
            self.assertEqual(int(differences), int(row[f"differences_{m.strip()}"]))
            self.assertLess(
                abs(float(row[f"adev_{m.strip()}"]) / float(deviation) - 1), 5e-5, f"m = {m}"
            )


if __name__ == "__main__":
    unittest.main()
