"""The output of davar-sim: columns, coefficients of known noise, formats, pace and notes."""

import json
import math
import time

import numpy as np
import pytest
from sim_case import SMALL_WINDOW, as_text, noise_rows, recording, results, sim, write

UNITS = {
    "arw": "deg_per_sqrt_h",
    "bi": "deg_per_h",
    "rrw": "deg_per_h_per_sqrt_h",
    "rr": "deg_per_h2",
    "qn": "deg",
}
COMMON = ["epoch", "time_s", "window_samples", "kurtosis", "contribution", "unstable"]
FIT = [
    *(f"arw{limit}_deg_per_sqrt_h" for limit in ("", "_low", "_high")),
    *(f"{name}_{unit}" for name, unit in UNITS.items() if name != "arw"),
    "filtered",
]
TRACKING = [
    *("alarm", "cut_age_samples", "dispersion", "change_m", "change_older", "change_newer"),
    *("change_gain", "young", "steady_samples", "steady", "steady_low", "steady_high"),
]
DETAILS = [
    *("gaps_in_window", "coarse"),
    *(f"{name}_upper_{unit}" for name, unit in UNITS.items()),
    *(f"{name}_{limit}_{UNITS[name]}" for name in list(UNITS)[1:] for limit in ("low", "high")),
]
LIMITS = [f"{name}_{m}" for m in (1, 5) for name in ("adev_low", "adev_high", "differences")]
LSB = ("--lsb", "0.01")
RATE_HZ = 50.0
SAMPLES = 20_000


@pytest.mark.parametrize(
    ("words", "columns"),
    [
        ("", [*COMMON, *FIT, "adev_1", "adev_2", "adev_4"]),
        ("--taus 1,3,9", [*COMMON, *FIT, "adev_1", "adev_3", "adev_9"]),
        (
            "--law glr --window-max 100 --window-min 20 --segment 0 --taus 1",
            [*COMMON, *FIT, *TRACKING, "adev_1"],
        ),
        ("--taus 1,5 --details", [*COMMON, *FIT, "adev_1", "adev_5", *LIMITS, *DETAILS]),
    ],
)
def test_columns_are_as_documented(tmp_path, words, columns):
    shown = sim(recording(tmp_path), *LSB, *SMALL_WINDOW, *words.split()).stdout
    assert shown.split("\n")[0].split(",") == columns


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


def test_law_glr_reports_a_change_in_its_columns(tmp_path):
    source = np.random.default_rng(4)
    rates = source.normal(0, 0.5, 6000) * np.where(np.arange(6000) < 3000, 1, 3)
    rows = [[f"{i / 100:.2f}", repr(float(rate))] for i, rate in enumerate(rates)]
    path = write(tmp_path / "rec.csv", as_text("time_s,gyro_x_dps", rows))
    found = results(path, "--law", "glr", "--stride", 10, "--lsb", 1e-3)
    alarms = [row for row in found if row["alarm"] == "1"]
    first = alarms[0]
    assert 3000 <= int(first["epoch"]) < 3100
    scale = math.sqrt(int(first["change_m"]))
    assert float(first["change_older"]) * scale == pytest.approx(0.5, rel=0.1)
    assert float(first["change_newer"]) * scale == pytest.approx(1.5, rel=0.5)
    assert float(first["change_gain"]) > 10
    before = [row for row in found if int(row["epoch"]) < 3000]
    assert {row["change_m"] for row in before} == {""}
    assert all(int(row["cut_age_samples"]) == int(row["epoch"]) + 1 for row in before)
    last = found[-1]
    assert int(last["cut_age_samples"]) == int(last["window_samples"]) == 3000
    assert 0.5 < float(before[-1]["dispersion"]) < 2
    assert {row["young"] for row in found} == {"0", "1"}
    assert [row["young"] for row in (before[-1], last)] == ["0", "0"]


def test_law_glr_reports_the_steady_level_in_its_columns(tmp_path):
    rates = np.random.default_rng(6).normal(0, 0.5, 20_000).tolist()
    path = write(tmp_path / "rec.csv", as_text("gyro_x_dps", ([repr(rate)] for rate in rates)))
    rows = results(path, "--law", "glr", "--stride", 1000, "--lsb", 1e-3, "--rate", 100)
    low, level, high = (float(rows[-1][f"steady{limit}"]) for limit in ("_low", "", "_high"))
    assert low < level < high < low + 0.05
    assert low < 0.5 < high
    assert int(rows[-1]["steady_samples"]) == pytest.approx(20_000, abs=100)
    assert rows[0]["steady"] == ""
    assert max(int(row["window_samples"]) for row in rows) == 6000  # 600 blocks


# --- notes


@pytest.mark.parametrize(
    ("words", "note"),
    [
        ("", "note: no --lsb: using counts of 2^-"),
        ("--full-scale 9", "--full-scale is not used"),
        ("--bits 16", "--bits is not used"),
        ("--lsb 0.01 --arith float", "--lsb is not used"),
        ("--lsb 0.01 --block 20", "only --law glr uses it"),
        ("--lsb 0.8", "300 of 300 results: the noise is below half a count"),
        ("--lsb 0.01", None),
        ("--lsb 0.001", None),
    ],
)
def test_notes(tmp_path, words, note):
    done = sim(recording(tmp_path), *SMALL_WINDOW, *words.split())
    assert (note in done.stderr) if note else done.stderr == ""


def test_coarse_and_filtered_results_are_marked(tmp_path):
    source = np.random.default_rng(5)
    white = source.normal(0, 30, 6001)
    smooth = np.convolve(white, np.ones(8) / 8, "same")
    kinds = {"white": white, "coarse": white / 100, "filtered": smooth}
    for name, values in kinds.items():
        rows = [[f"{i / 100:.2f}", round(value)] for i, value in enumerate(values.tolist())]
        path = write(tmp_path / f"{name}.csv", as_text("time_s,gyro_x_counts", rows))
        words = ("--lsb", 0.01, "--stride", 600, "--details", "--law", "fixed")
        done = sim(path, *words)
        found = results(path, *words)
        for column in ("coarse", "filtered"):
            marked = sum(row[column] == "1" for row in found)
            assert (marked >= len(found) - 1) if column == name else marked == 0, (name, column)
            assert ("results: the noise is below" in done.stderr) == (name == "coarse")
            assert ("results withheld" in done.stderr) == (name == "filtered")


def test_coarse_counts_are_pointed_out(tmp_path):
    rows = [[i, f"{1e7 + i % 7 * 1e-4:.4f}"] for i in range(100)]
    path = write(tmp_path / "offset.csv", as_text("time_s,freq_hz", rows))
    for words in ((), ("--arith", "float")):
        assert "subtract a constant" in sim(path, *SMALL_WINDOW, *words).stderr


@pytest.mark.parametrize("value", ("1.5", "0"))
def test_a_value_the_window_cannot_support_is_an_empty_field(tmp_path, value):
    rows = [[f"{i / 100:.2f}", value] for i in range(100)]
    path = write(tmp_path / "flat.csv", as_text("time_s,gyro_x_dps", rows))
    for words in ((), LSB, ("--arith", "float")):
        for row in results(path, *words, *SMALL_WINDOW):
            assert (row["kurtosis"], row["contribution"], row["adev_1"]) == ("", "", "0")


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


def test_an_odd_column_name_is_quoted(tmp_path):
    path = write(tmp_path / "odd.csv", as_text('time_s,"gyro\\\tx"', noise_rows(100)))
    line = sim(path, *LSB, *SMALL_WINDOW, "--out", "jsonl").stdout.splitlines()[0]
    assert json.loads(line)["channel"] == '"gyro\\\tx"'


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
