"""Torn register reads: --skip-torn-reads skips them, and ARW is that of the other samples."""

import math
import random
import re

import pytest
from sim_case import SMALL_WINDOW, as_text, parsed, results, sim, write

RATE_HZ, LSB, SIGMA = 104.0, 0.00875, 3.0  # an LSM6DSL
TRUE_ARW = 60.0 * SIGMA * LSB / math.sqrt(RATE_HZ)
ROWS = 120_000
FIXED = ("--lsb", LSB, "--law", "fixed", "--mode", "trailing", "--bandwidth", "none")
SKIP = "--skip-torn-reads"


def counts(rows, seed, offset=-250):
    source = random.Random(seed)
    return [round(offset + source.gauss(0.0, SIGMA)) for _ in range(rows)]


def tear(samples, seed, apart=1000):
    """Every 1000th sample on average, none of the first 100 and no two of four in a row."""
    source, torn, at = random.Random(seed), list(samples), 100
    places = []
    while (at := at + 4 + int(source.expovariate(1 / apart))) < len(torn) - 1:
        torn[at] += source.choice((-256, 256))
        places.append(at)
    return torn, places


def rows_of(*columns):
    return [[f"{i / RATE_HZ:.6f}", *row] for i, row in enumerate(zip(*columns))]


def recorded(folder, name, rows):
    header = ",".join(["time_s", "gyro_x_counts", "gyro_y_counts"][: len(rows[0])])
    return write(folder / name, as_text(header, rows))


def skipped(done):
    """(torn reads of each column, gaps, missing samples) on standard error."""
    reads = re.findall(r"_counts: (\d+) torn register reads skipped\n", done.stderr)
    lost = re.search(r"(\d+) gaps \((\d+) samples missing\)", done.stderr)
    return [int(one) for one in reads], *(map(int, lost.groups()) if lost else (0, 0))


def arw(text):
    """Root of the mean square over windows that do not overlap."""
    found = [float(row["arw_deg_per_sqrt_h"] or "nan") for row in parsed(text)]
    found = [value for value in found if not math.isnan(value)]
    assert len(found) > ROWS / 600 / 2  # a fit of 600 samples withholds some, never most
    return math.sqrt(sum(value**2 for value in found) / len(found))


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3))]
)
def test_arw_is_that_of_the_sensor(tmp_path, seed):
    clean = counts(ROWS, seed)
    torn, places = tear(clean, seed)
    words = (*FIXED, "--stride", 600)
    right = arw(sim(recorded(tmp_path, "clean.csv", rows_of(clean)), *words).stdout)
    path = recorded(tmp_path, "torn.csv", rows_of(torn))
    assert arw(sim(path, *words).stdout) > 1.1 * TRUE_ARW
    done = sim(path, *words, SKIP)
    # The mean of 200 windows scatters by 0.2 %, and rounding adds 1/12 count^2: 0.5 %.
    assert arw(done.stdout) == pytest.approx(right, rel=0.01)
    assert arw(done.stdout) == pytest.approx(TRUE_ARW, rel=0.01)
    assert skipped(done) == ([len(places)], len(places), len(places))


def test_a_torn_row_is_as_a_lost_row(tmp_path):
    """Also beside gaps, at the edges of the blocks of a copy, and without time stamps."""
    clean = counts(3000, 5)
    torn, places = tear(clean, 5, apart=60)
    for at in (511, 512, 513, 1023, 1024, 2998):
        if not set(places) & set(range(at - 3, at + 4)):
            torn[at] += 256
            places.append(at)
    lines = rows_of(torn)
    kept = [line for i, line in enumerate(lines) if i not in set(places)]
    words = (*FIXED, *SMALL_WINDOW, "--details")
    expected = results(recorded(tmp_path, "lost.csv", kept), *words)
    assert results(recorded(tmp_path, "torn.csv", lines), *words, SKIP) == expected
    bare = write(tmp_path / "bare.csv", as_text("gyro_x_counts", [line[1:] for line in lines]))
    found = results(bare, *words, "--rate", RATE_HZ, SKIP)
    for row, other in zip(expected, found, strict=True):
        assert float(other["time_s"]) == pytest.approx(float(row["time_s"]), abs=5e-6)
        for name in ("epoch", "kurtosis", "adev_1", "differences_4", "gaps_in_window"):
            assert row[name] == other[name]


def test_a_row_is_skipped_in_every_column(tmp_path):
    left, right = counts(2000, 7), counts(2000, 8)
    left[700] += 256
    right[701] -= 512
    right[1300] += 1024
    path = recorded(tmp_path, "two.csv", rows_of(left, right))
    done = sim(path, *FIXED, "--column", "gyro_x_counts,gyro_y_counts", SKIP)
    assert skipped(done) == ([1, 2], 2, 3)  # one gap of two rows and one of a row
    times = {f"{float(row['time_s']):.6f}" for row in parsed(done.stdout)}
    assert not times & {f"{at / RATE_HZ:.6f}" for at in (700, 701, 1300)}


@pytest.mark.parametrize("lost", [999, 1001])
def test_a_sample_beside_a_gap_is_not_judged(tmp_path, lost):
    samples = counts(2000, 6)
    samples[1000] += 256
    lines = [line for i, line in enumerate(rows_of(samples)) if i != lost]
    assert skipped(sim(recorded(tmp_path, "gap.csv", lines), *FIXED, SKIP)) == ([0], 1, 1)
