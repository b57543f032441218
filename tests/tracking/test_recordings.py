"""Alarms of policy glr in recordings of a real sensor, both channels at one false alarm in 100 h.
Skipped if the folder of the real recordings (DAVAR_REAL_DATA) is absent.
"""

import csv
import io
import os
import subprocess
import unittest
from pathlib import Path

PROGRAM = os.environ.get("DAVAR_SIM", "davar-sim")
REAL = Path(os.environ.get("DAVAR_REAL_DATA", "../shared/data/real"))


def needs(name):
    return unittest.skipUnless((REAL / name).is_file(), f"needs the recording {name}")


def alarms(name):
    """(axis, time in s, cluster, level before, level after) of each alarm."""
    done = subprocess.run(
        [
            PROGRAM,
            REAL / name,
            "--column",
            "gyro_x_dps,gyro_y_dps,gyro_z_dps",
            "--lsb",
            "0.05",
            "--policy",
            "glr",
            "--stride",
            "10",
            "--false-alarms-per-hour",
            "0.01",
            "--long-cluster",
            "80",
        ],
        stdout=subprocess.PIPE,
        check=True,
        encoding="ascii",
    )
    return [
        (
            row["channel"],
            float(row["time_s"]),
            int(row["change_m"]),
            float(row["change_older"]),
            float(row["change_newer"]),
        )
        for row in csv.DictReader(io.StringIO(done.stdout))
        if row["alarm"] == "1"
    ]


class Adis16405(unittest.TestCase):
    """100 Hz, 2 h 46 min each."""

    @needs("adis16405_run1_static.csv.gz")
    def test_no_alarm_in_the_static_run(self):
        self.assertEqual([], alarms("adis16405_run1_static.csv.gz"))

    @needs("adis16405_run4_knocks.csv.gz")
    def test_knocks_and_a_gentle_movement_and_nothing_else(self):
        found = alarms("adis16405_run4_knocks.csv.gz")
        single = [time for _, time, m, _, _ in found if m == 1]
        slow = [
            (time, newer / older)
            for axis, time, m, older, newer in found
            if m == 80 and axis == "gyro_x_dps"
        ]
        self.assertTrue(all(117 <= time <= 120 or 4045 <= time <= 4048 for time in single), found)
        self.assertTrue(
            any(time < 120 for time in single) and any(time > 4045 for time in single), found
        )
        self.assertTrue(all(3940 <= time <= 4000 for _, time, m, _, _ in found if m == 80), found)
        self.assertEqual(2, len(slow), found)  # louder, by about the rise of ADEV(1 s), and back
        self.assertTrue(2 < slow[0][1] < 4 and slow[1][1] < 0.5, found)


if __name__ == "__main__":
    unittest.main()
