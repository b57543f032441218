"""--bandwidth auto: the filter of each column is learned from the recording."""

import math
import random

import pytest
from sim_case import (
    SMALL_WINDOW,
    as_text,
    noise_rows,
    parsed,
    recording,
    sim,
    write,
)

OPTIONS = ("--lsb", "1", "--stride", "500")
AUTO = ("--bandwidth", "auto")
NEEDS = "filter unknown: it needs 4352 samples at rest"


def one_pole_rows(count, cutoff, seed=5):
    """Rows of time_s, white noise, and white noise after a one-pole low-pass, cutoff over rate."""
    source = random.Random(seed)
    decay = math.exp(-2 * math.pi * cutoff)
    level, rows = 0.0, []
    for i in range(count):
        level = decay * level + (1 - decay) * source.gauss(0.0, 300.0)
        rows.append([f"{i / 100:.2f}", f"{source.gauss(0.0, 300.0):.0f}", f"{level:.0f}"])
    return rows


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    text = as_text("time_s,gyro_x_counts,gyro_y_counts", one_pole_rows(20_000, 0.1))
    return write(tmp_path_factory.mktemp("auto") / "two.csv", text)


def test_each_column_has_its_own_filter(two):
    done = sim(two, "--column", "gyro_x_counts,gyro_y_counts", *OPTIONS, *AUTO)
    assert done.returncode == 0, done.stderr
    white, filtered = done.stderr.splitlines()[:2]
    assert "gyro_x_counts: white up to half the sample rate" in white
    assert white.endswith("--bandwidth none")
    words, _, _ = filtered.partition(" Hz")
    assert words.startswith("davar-sim: gyro_y_counts: a filter with -3 dB at ")
    assert float(words.split()[-1]) == pytest.approx(10, abs=1)
    rows = parsed(done.stdout)
    truth = 300 * 60 / math.sqrt(100)  # of both: the filter passes the lowest frequencies
    for column in ("gyro_x_counts", "gyro_y_counts"):
        values = [row["arw_deg_per_sqrt_h"] for row in rows if row["channel"] == column]
        values = [float(value) for value in values if value]
        assert len(values) > 25
        assert sum(values) / len(values) == pytest.approx(truth, rel=0.1)


def test_the_value_that_it_prints_gives_the_same_results(two):
    column = ("--column", "gyro_y_counts")
    learned = sim(two, *column, *OPTIONS, *AUTO)
    value = learned.stderr.splitlines()[0].split("--bandwidth ")[1]
    declared = sim(two, *column, *OPTIONS, "--bandwidth", value)
    for one, other in zip(parsed(learned.stdout), parsed(declared.stdout), strict=True):
        for a, b in zip(one.values(), other.values()):
            assert (a, b) == ("", "") or float(b) == pytest.approx(float(a), rel=2e-3)
    pipe = sim("-", *column, *OPTIONS, *AUTO, stdin=two.read_bytes())
    assert (pipe.stdout, pipe.stderr) == (learned.stdout, learned.stderr)


def test_what_cannot_be_learned_from_leaves_the_filter_unknown(tmp_path):
    short = recording(tmp_path, 4000)
    words = (short, "--lsb", "0.01", "--stride", "500")
    assert NEEDS in sim(*words, *AUTO).stderr
    assert sim(*words, *AUTO).stdout == sim(*words).stdout
    rows = [row for i, row in enumerate(noise_rows(9000)) if i % 500]
    gaps = write(tmp_path / "gaps.csv", as_text("time_s,gyro_x_dps", rows))
    assert NEEDS in sim(gaps, *SMALL_WINDOW, "--lsb", "0.01", *AUTO).stderr
    rows = [[f"{i / 100:.2f}", 5] for i in range(6000)]
    still = write(tmp_path / "still.csv", as_text("time_s,gyro_x_counts", rows))
    assert "filter unknown: the signal does not change" in sim(still, *OPTIONS, *AUTO).stderr
