"""Published Allan deviations, through the command line."""

import csv
import gzip
import math
from decimal import Decimal

import pytest
from sim_case import REAL, as_text, needs, results, write


def whole_record(path, count, *options):
    """One window over the complete recording: the ordinary overlapping Allan deviation."""
    one = ("--window-max", count, "--window-min", count, "--stride", count, "--details")
    return results(path, "--mode", "trailing", "--law", "fixed", *one, *options)


# --- NIST SP 1065 (Riley), 1000 points; published to seven digits

OVERLAPPING = {1: "0.2922319", 10: "0.09159953", 100: "0.03241343"}


@pytest.mark.parametrize(
    "words", [(), ("--arith", "float"), ("--lsb", repr(1 / 2147483647), "--bits", "32")]
)
def test_nbs14_in_every_arithmetic(tmp_path, words):
    numbers = [1234567890]
    while len(numbers) < 1000:
        numbers.append(16807 * numbers[-1] % 2147483647)
    points = [n / 2147483647 for n in numbers]
    rows = ([i, repr(y)] for i, y in enumerate(points))
    path = write(tmp_path / "nbs14.csv", as_text("time_s,gyro_z_dps", rows))
    (row,) = whole_record(path, 1000, "--taus", "1,10,100", *words)
    for m, published in OVERLAPPING.items():
        assert float(f"{float(row[f'adev_{m}']):.7g}") == float(published)
        means = [math.fsum(points[i : i + m]) / m for i in range(1000 - m + 1)]
        squares = [(means[i + m] - means[i]) ** 2 for i in range(len(means) - m)]
        expected = math.sqrt(math.fsum(squares) / (2 * len(squares)))
        assert words or row[f"adev_{m}"] == f"{expected:.9g}"


@needs("adis16405_run1_static.csv.gz")
def test_adis16405_at_every_published_size_to_nine_digits():
    """One million samples; the published wavelet variances (twice) are overlapping Allan variances,
    to eleven digits.
    """
    with open(REAL / "adis16405_run1_published_avar.csv", encoding="ascii") as file:
        table = list(csv.DictReader(line for line in file if not line.startswith("#")))
    table = [row for row in table if row["wvx2_gyro_x"]]
    assert len(table) == 18
    words = ("--column", "gyro_x_dps,gyro_y_dps,gyro_z_dps", "--lsb", "0.05")
    sizes = ",".join(row["m"] for row in table)
    rows = whole_record(REAL / "adis16405_run1_static.csv.gz", 1000000, *words, "--taus", sizes)
    assert [row["channel"] for row in rows] == words[1].split(",")
    for row in rows:
        axis = row["channel"][len("gyro_") : -len("_dps")]
        for published in table:
            expected = math.sqrt(float(published[f"wvx2_gyro_{axis}"]))
            assert row[f"adev_{published['m']}"] == f"{expected:.9g}", (axis, published["m"])


@needs("ocxo_frequency_stable32.csv.gz")
def test_stable32_deviations_of_an_oscillator(tmp_path):
    """A quartz oscillator compared with a maser, near 1e-11; five digits."""
    with gzip.open(REAL / "ocxo_frequency_stable32.csv.gz", "rt") as file:
        lines = file.read().splitlines()
    marked = [line for line in lines if line.startswith("# stable32_oadev:")]
    published = [line.split(":")[1].replace(" ", "").split(",") for line in marked]
    data = [line.split(",") for line in lines if line[:1].isdigit()]
    rows = ([time, f"{Decimal(hz) / Decimal(10**7) - 1:.20f}"] for time, hz in data)
    path = write(tmp_path / "ocxo.csv", as_text("time_s,fractional_1", rows))
    sizes = ",".join(m for m, *_ in published)
    (row,) = whole_record(path, len(data), "--taus", sizes)
    assert len(published) == 20
    for m, _, differences, deviation in published:
        assert row[f"differences_{m}"] == differences
        assert float(row[f"adev_{m}"]) == pytest.approx(float(deviation), rel=5e-5)
