"""The output of davar-sim: coefficients of known noise, JSON lines, a terminal, pace, unstable
windows.
"""

import json
import math
import os
import pty
import subprocess
import time

import numpy as np
import pytest
from sim_case import (
    PROGRAM,
    SMALL_WINDOW,
    as_text,
    assert_refused,
    noise_rows,
    recording,
    results,
    sim,
    write,
)

UNITS = {
    "arw": "deg_per_sqrt_h",
    "bi": "deg_per_h",
    "rrw": "deg_per_h_per_sqrt_h",
    "rr": "deg_per_h2",
    "qn": "deg",
}
LSB = ("--lsb", "0.01")
RATE_HZ = 50.0
SAMPLES = 20_000


# --- coefficients


def flicker(source, number):
    """Noise whose one-sided density is 1/f, at a sample rate of 1."""
    spectrum = np.fft.rfft(source.normal(size=2 * number))
    f = np.fft.rfftfreq(2 * number)
    f[0] = f[1]
    return np.fft.irfft(spectrum / np.sqrt(2 * f), 2 * number)[:number]


# Name: (rates in deg/s of a source of random numbers, the true value in the unit of the column).
SLOPE, ANGLE = 0.02, 0.003
KNOWN = {
    "arw": (lambda source: source.normal(0, 0.4, SAMPLES), 0.4 * 60 / math.sqrt(RATE_HZ)),
    "bi": (
        lambda source: 0.05 * flicker(source, SAMPLES),
        0.05 * math.sqrt(math.pi) * 3600,  # avar = 2 ln 2 h = (2 ln 2 / pi) B^2
    ),
    "rrw": (
        lambda source: np.cumsum(source.normal(0, 0.004, SAMPLES)),
        0.004 * math.sqrt(RATE_HZ) * 3600 * 60,
    ),
    "rr": (lambda source: SLOPE * np.arange(SAMPLES) / RATE_HZ, SLOPE * 3600**2),
    "qn": (lambda source: np.diff(source.normal(0, ANGLE, SAMPLES + 1)) * RATE_HZ, ANGLE),
}


@pytest.mark.parametrize("name", KNOWN)
def test_each_coefficient_is_that_of_its_noise_in_its_own_column(tmp_path, name):
    make, truth = KNOWN[name]
    source = np.random.default_rng(3)
    rates = make(source) + source.normal(0, 1e-4, SAMPLES) * (name == "rr")
    rows = zip((f"{i / RATE_HZ:.2f}" for i in range(SAMPLES)), map(repr, rates.tolist()))
    path = write(tmp_path / "rec.csv", as_text("time_s,gyro_x_dps", rows))
    whole = ("--mode", "trailing", "--law", "fixed", "--window-max", SAMPLES)
    whole = (*whole, "--window-min", SAMPLES, "--stride", SAMPLES, "--bandwidth", "none")
    (row,) = results(path, *whole, "--lsb", 1e-6, "--bits", 32, "--details")
    value, low, high = (
        float(row[f"{name}{limit}_{UNITS[name]}"] or "nan") for limit in ("", "_low", "_high")
    )
    assert value == pytest.approx(truth, rel=0.15)
    assert low < value < high
    for other, unit in UNITS.items():
        present = row[f"{other}_{unit}"] != ""
        limits = [row[f"{other}_{limit}_{unit}"] != "" for limit in ("low", "high")]
        assert [row[f"{other}_upper_{unit}"] != "", *limits] == [not present, present, present]


# --- JSON lines


def test_json_lines_have_the_names_and_values_of_csv(tmp_path):
    table = write(tmp_path / "model.csv", "m,adev_dps,relative_tolerance\n1,0.3,0.1\n")
    for words in ((), ("--details",), ("--model-table", table, "--longest-tau", 1)):
        options = (recording(tmp_path), *LSB, *SMALL_WINDOW, *words)
        lines = sim(*options, "--out", "jsonl").stdout.splitlines()
        rows = results(*options)
        assert len(rows) == 300
        for row, line in zip(rows, map(json.loads, lines), strict=True):
            assert line.pop("channel") == "gyro_x_dps"
            assert line == {name: float(text) if text else None for name, text in row.items()}


# --- a terminal


def on_a_terminal(*arguments):
    """What the program prints there."""
    reader, writer = pty.openpty()
    with subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=writer) as running:
        os.close(writer)
        pieces = []
        try:
            while piece := os.read(reader, 1 << 16):
                pieces.append(piece)
        except OSError:  # Linux: the program has ended
            pass
    os.close(reader)
    assert running.returncode == 0
    return b"".join(pieces).decode().replace("\r\n", "\n")


def test_a_terminal_shows_a_table_with_units_of_the_values_that_csv_has(tmp_path):
    """A window in eight results, unless --stride says otherwise."""
    path = recording(tmp_path, 4000)
    options = (path, *LSB, "--window-max", 800, "--bandwidth", "none", "--floor")
    head, units, *lines = on_a_terminal(*options).splitlines()
    assert (head.split()[:4], units.split()[:2]) == (
        ["time", "channel", "ARW", "95"],
        ["s", "deg/sqrt(h)"],
    )
    rows = results(*options, "--stride", 100)
    assert len(lines) == len(rows) > 20
    for line, row in zip(lines, rows, strict=True):
        shown = line.split()
        assert shown[:2] == [f"{float(row['time_s']):.2f}", "gyro_x_dps"]
        wanted = [row[f"arw_{end}deg_per_sqrt_h"] for end in ("", "low_", "high_")]
        if wanted[0]:
            value, low, high = (f"{float(one):.4g}" for one in wanted)
            assert shown[2:6] == [value, low, "to", high]
        assert row["window_samples"] in shown[3:]
    assert_refused(sim(*options, "--out", "table", "--details"), "--details", "csv or jsonl")
    asked = on_a_terminal(*options, "--out", "csv", "--stride", 100)
    assert asked == sim(*options, "--stride", 100).stdout
    assert sim(*options, "--out", "table").stdout.splitlines() == [head, units, *lines]


def test_the_table_says_why_a_result_has_no_angle_random_walk(tmp_path):
    rng = np.random.default_rng(8)
    rates = np.convolve(rng.normal(0, 0.3, 4019), np.ones(20) / 20, "valid")
    rows = zip((f"{i / RATE_HZ:.2f}" for i in range(4000)), map(repr, rates.tolist()))
    path = write(tmp_path / "rec.csv", as_text("time_s,gyro_x_dps", rows))
    options = (path, *LSB, "--window-max", 800, "--stride", 100)
    lines = sim(*options, "--out", "table").stdout.splitlines()[2:]
    rows = results(*options)
    assert {row["filtered"] for row in rows} >= {"1"}
    for line, row in zip(lines, rows, strict=True):
        known = bool(row["arw_deg_per_sqrt_h"])
        assert (" to " in line) == known
        assert ("hidden by a filter" in line) == (row["filtered"] == "1" and not known)


# --- pace and progress


@pytest.mark.parametrize(
    ("pace", "rate_hz", "gap_s", "least_s"),
    [("realtime", 100.0, 0, 0.95), ("20000", 0.1, 0, 0.048), ("10", 100.0, 4, 0.48)],
)
def test_a_pace_takes_the_time_of_the_recording(tmp_path, pace, rate_hz, gap_s, least_s):
    """Gaps take time too. Even the slowest machine needs less than 1000 s over 20000."""
    rows = noise_rows(100, rate_hz=rate_hz)
    for row in rows[50:]:
        row[0] = f"{float(row[0]) + gap_s:.4f}"
    path = write(tmp_path / "rec.csv", as_text("time_s,gyro_x_dps", rows))
    begin = time.monotonic()
    done = sim(path, *LSB, *SMALL_WINDOW, "--pace", pace)
    assert least_s < time.monotonic() - begin < 500
    assert done.stdout == sim(path, *LSB, *SMALL_WINDOW, "--pace", "max").stdout
    assert "running" not in done.stderr  # no terminal


def test_progress_is_a_line_a_second_when_asked_for(tmp_path):
    words = (*LSB, *SMALL_WINDOW, "--pace", "realtime", "--progress", "always")
    done = sim(recording(tmp_path, count=150), *words)
    assert done.stderr.startswith("davar-sim: running ")
    assert 60 <= int(done.stderr.split()[2]) <= 99
    assert done.stderr.split()[3] == "%"


@pytest.mark.parametrize(
    ("words", "low", "high"),
    [
        ("", 0.15, 0.23),  # the bounds of the paper are wrong for one window in five
        ("--law and", 0.015, 0.045),
        ("--kurtosis 2:4 --contribution 0:0.2", 0.0, 0.01),
        ("--unstable-rate 0.01", 0.0, 0.012),
    ],
)
def test_the_share_of_unstable_windows_in_white_noise(tmp_path, words, low, high):
    """The figures of docs/FIRMWARE.md. More: tests/statistics/monitor.c."""
    rows = results(recording(tmp_path, count=100_000), *LSB, *words.split())
    share = sum(row["unstable"] == "1" for row in rows) / len(rows)
    assert low <= share <= high
