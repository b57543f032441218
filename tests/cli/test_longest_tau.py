"""davar-sim --longest-tau: cluster sizes beyond the window, compared with brute force over the
recording.
"""

import csv
import gzip
import math
import random
from itertools import accumulate

import pytest
from sim_case import REAL, as_text, needs, results, write

RATE_HZ = 100.0
LSB = 2.0**-7  # deg/s; every arithmetic holds these samples exactly
SAMPLES = 60_000
STRIDE = 211  # odd, so that results fall between the hops
CLUSTERS = 32
TAUS = (1, 2, 4, 8, 16, 32, 64)
LONG = (128, 256, 512, 1024, 2048, 4096, 8192)
LONGEST = ("--longest-tau", 100, "--details")  # 81.92 s is the last octave
FIXED = ("--law", "fixed", "--stride", STRIDE)
TRAILING = (*FIXED, "--mode", "trailing")
GAPS = {9000: 7, 9100: 1, 31_313: 400}  # sample: how many are missing before it


def counts_of(samples, seed=5):
    """White noise and a random walk, in counts."""
    source, walk, counts = random.Random(seed), 0.0, []
    for _ in range(samples):
        walk += source.gauss(0, 0.4)
        counts.append(round(source.gauss(0, 60) + walk))
    return counts


def recording_of(counts, gaps):
    tick, rows = 0, []
    for i, count in enumerate(counts):
        tick += 1 + gaps.get(i, 0)
        rows.append([f"{tick / RATE_HZ:.2f}", repr(count * LSB)])
    return as_text("time_s,gyro_x_dps", rows)


COUNTS = counts_of(SAMPLES)
SUMS = [0, *accumulate(COUNTS)]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("long")
    return {
        "plain": write(folder / "plain.csv", recording_of(COUNTS, {})),
        "gaps": write(folder / "gaps.csv", recording_of(COUNTS, GAPS)),
        "between hops": write(folder / "hops.csv", recording_of(COUNTS[:-10], GAPS)),
    }


def hops_of(m, first):
    """A stage has two sizes with one hop: 4 and 8 hops long."""
    octave = (m // first).bit_length() - 1
    return m // (4 << (octave % 2))


def brute_force(m, first, end, gaps, sums=SUMS):
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


def assert_size(row, m, wanted):
    deviation, number = wanted
    assert int(row[f"differences_{m}"]) == number, (row["epoch"], m)
    if number == 0:
        assert row[f"adev_{m}"] == ""
    else:
        assert float(row[f"adev_{m}"]) == pytest.approx(deviation * LSB, rel=5e-8)


@pytest.mark.parametrize("kind", ["plain", "gaps"])
@pytest.mark.parametrize(
    "words",
    [("--lsb", LSB, "--bits", 16), (), ("--arith", "float"), ("--lsb", LSB, "--taus", "1,7,35")],
    ids=["int16", "int32", "float", "a first size that no octave gives"],
)
def test_every_row_is_brute_force(recordings, kind, words):
    """Rows whose newest hops have certainly been added (11.2)."""
    first = 140 if "1,7,35" in words else 128
    sizes = [first << k for k in range(7)]
    rows, compared = results(recordings[kind], *LONGEST, *TRAILING, *words), 0
    for row in rows:
        end = int(row["epoch"]) + 1
        if end % hops_of(first, first) > len(sizes) + 3:
            for m in sizes:
                assert_size(row, m, brute_force(m, first, end, GAPS if kind == "gaps" else {}))
                compared += 1
    assert compared > 200


def test_glr_gives_the_cascade_every_sample_at_once(recordings):
    """Samples of the window wait in a queue. The last result has no later ones."""
    glr = ("--law", "glr", "--stride", 10, "--window-max", 600, "--lsb", LSB)
    octaves = ("--taus", ",".join(map(str, TAUS)))
    rows = results(recordings["between hops"], *glr, *LONGEST, *octaves)
    for row in rows[:-1]:  # the window of an epoch waits for later samples
        end = int(row["epoch"]) + 1
        if end % 32 > 14:
            assert brute_force(128, 128, end, GAPS)[1] <= int(row["differences_128"])
    for m in LONG:
        assert_size(rows[-1], m, brute_force(m, 128, SAMPLES - 10, GAPS))


def test_centred_windows_end_at_the_newest_sample(recordings):
    """The window of an epoch ends half its length later, and so do the long sizes."""
    words = (*FIXED, "--window-max", 600, "--window-min", 600, "--lsb", LSB)
    rows = results(recordings["plain"], *words, *LONGEST)
    for row in rows[: -600 // STRIDE - 1]:
        end = int(row["epoch"]) + 1 + 300
        if end % 32 > 14:
            for m in LONG:
                assert int(row[f"differences_{m}"]) == brute_force(m, 128, end, {})[1]
    for m in LONG:
        assert_size(rows[-1], m, brute_force(m, 128, SAMPLES, {}))


def test_the_coefficients_are_those_of_the_whole_curve(recordings):
    """0.4 counts per sample are a rate random walk that 6 s do not show."""
    words = (recordings["plain"], "--lsb", LSB, *TRAILING, "--bandwidth", "none")
    short, row = results(*words)[-1], results(*words, *LONGEST)[-1]
    assert short["rrw_deg_per_h_per_sqrt_h"] == ""
    truth = 0.4 * LSB * math.sqrt(RATE_HZ) * 3600 * 60
    assert float(row["rrw_deg_per_h_per_sqrt_h"]) == pytest.approx(truth, rel=0.4)
    truth = 60 * LSB * 60 / math.sqrt(RATE_HZ)
    assert float(row["arw_deg_per_sqrt_h"]) == pytest.approx(truth, rel=0.05)


@pytest.mark.parametrize(("seconds", "last"), [(12.8, 128), (25.5, 128), (25.6, 256)])
def test_an_octave_is_reached_in_spite_of_the_digits_of_time_stamps(tmp_path, seconds, last):
    """The median step of 0.1 s is a rate of 9.9999999..."""
    rows = [[repr(i * 0.1), repr(count * LSB)] for i, count in enumerate(COUNTS[:2000])]
    path = write(tmp_path / "rec.csv", as_text("time_s,gyro_x_dps", rows))
    found = results(path, "--lsb", LSB, "--longest-tau", seconds, "--stride", 600)
    assert list(found[0])[-1] == f"adev_{last}"


def real(name, gap_s, rate_hz, first, count, *options):
    """The deviations of the last row, compared with brute force over the samples."""
    times, values = [], []
    with gzip.open(REAL / name, "rt", encoding="ascii") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            times.append(float(row["time_s"]))
            values.append(float(row["gyro_x_dps"]))
    gaps = [i for i in range(1, len(times)) if times[i] - times[i - 1] > gap_s]
    sums, sizes = [0.0, *accumulate(values)], [first << k for k in range(count)]
    words = ("--column", "gyro_x_dps", "--mode", "trailing", "--law", "fixed", "--details")
    words = (*words, "--bandwidth", "none", "--longest-tau", 1e5 / rate_hz)
    last = results(REAL / name, *words, *options)[-1]
    end = int(last["epoch"]) + 1
    assert end % hops_of(first, first) > len(sizes) + 3
    for m in sizes:
        deviation, number = brute_force(m, first, end, gaps, sums)
        assert last[f"differences_{m}"] == str(number)
        if number > 0:
            assert float(last[f"adev_{m}"]) == pytest.approx(deviation, rel=5e-5)
    return [float(last[f"adev_{m}"]) for m in sizes if last[f"adev_{m}"]]


@needs("sensehat_lsm9ds1_bench_3days.csv.gz")
def test_three_days_of_a_driver_that_subtracts_a_bias():
    name = "sensehat_lsm9ds1_bench_3days.csv.gz"
    curve = real(name, 30, 0.1, 128, 10, "--gap", 3, "--stride", 590)
    assert len(curve) == 7  # up to 22 h
    assert all(other < 0.7 * one for one, other in zip(curve, curve[1:]))


@needs("sensehat_lsm9ds1_iss_3h.csv.gz")
def test_three_hours_in_orbit():
    options = ("--rate", 0.5157, "--window-max", 300, "--stride", 293, "--lsb", 0.0175)
    curve = real("sensehat_lsm9ds1_iss_3h.csv.gz", 1e9, 0.5157, 64, 6, *options)
    assert len(curve) == 6  # up to 66 min
    assert curve[4] > 1.3 * curve[1]  # the cycle of 93 min
