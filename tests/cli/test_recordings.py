"""Alarms of policy glr in recordings of a real sensor, at one false alarm in 100 h."""

import pytest
from sim_case import REAL, needs, results

AXES = "gyro_x_dps,gyro_y_dps,gyro_z_dps"
GLR = "--lsb 0.05 --policy glr --stride 10 --false-alarms-per-hour 0.01 --long-cluster 80"
REST, KNOCKS = "adis16405_run1_static.csv.gz", "adis16405_run4_knocks.csv.gz"
pytestmark = [needs(REST), needs(KNOCKS)]


def alarms(name):
    """(axis, time in s, cluster, level after over before) of each alarm. The recordings have 100 Hz
    and 2 h 46 min each."""
    return [
        (
            row["channel"],
            float(row["time_s"]),
            int(row["change_m"]),
            float(row["change_newer"]) / float(row["change_older"]),
        )
        for row in results(REAL / name, "--column", AXES, *GLR.split())
        if row["alarm"] == "1"
    ]


@pytest.mark.slow
def test_no_alarm_at_rest():
    assert alarms(REST) == []


def test_knocks_and_a_gentle_movement_and_nothing_else():
    found = alarms(KNOCKS)
    single = [time for _, time, m, _ in found if m == 1]
    clusters = [time for _, time, m, _ in found if m == 80]
    slow = [ratio for axis, _, m, ratio in found if m == 80 and axis == "gyro_x_dps"]
    assert all(117 <= time <= 120 or 4045 <= time <= 4048 for time in single), found
    assert min(single) < 120 and max(single) > 4045, found
    assert all(3940 <= time <= 4000 for time in clusters), found
    assert len(slow) == 2, found  # louder, by about the rise of ADEV(1 s), and back
    assert 2 < slow[0] < 4 and slow[1] < 0.5, found
