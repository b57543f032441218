"""Alarms of law glr in recordings of a real sensor, at one false alarm in 100 h."""

import pytest
from sim_case import REAL, needs, results

AXES = "gyro_x_dps,gyro_y_dps,gyro_z_dps"
GLR = "--lsb 0.05 --law glr --stride 10 --false-alarms-per-hour 0.01"
REST, KNOCKS = "adis16405_run1_static.csv.gz", "adis16405_run4_knocks.csv.gz"
pytestmark = [needs(REST), needs(KNOCKS)]


def alarms(name):
    """(axis, time in s, level after over before) of each alarm. The recordings have 100 Hz and
    2 h 46 min each."""
    return [
        (
            row["channel"],
            float(row["time_s"]),
            float(row["change_newer"]) / float(row["change_older"]),
        )
        for row in results(REAL / name, "--column", AXES, *GLR.split())
        if row["alarm"] == "1"
    ]


@pytest.mark.slow
def test_no_alarm_at_rest():
    assert alarms(REST) == []


def test_knocks_and_nothing_else():
    found = alarms(KNOCKS)
    times = [time for _, time, _ in found]
    assert all(117 <= time <= 120 or 4045 <= time <= 4048 for time in times), found
    assert min(times) < 120 and max(times) > 4045, found
    ratios = [ratio for axis, _, ratio in found if axis == "gyro_x_dps"]
    assert len(ratios) == 4, found  # louder and back, twice
    assert min(ratios[::2]) > 2 and max(ratios[1::2]) < 0.5, found
