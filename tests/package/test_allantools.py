"""The results of Stable32 that AllanTools' source distribution contains. The table is in
docs/PYTHON.md.
"""

import subprocess
import sys

import allantools
import numpy as np
import pytest
import together
from together import davar

PAGE = together.ROOT / "docs/PYTHON.md"
# Record: the file, its type, and the files with the results of Stable32.
RECORDS = {
    "PHASE.DAT of Stable32": (
        "phasedat/PHASE.DAT",
        "phase",
        ("phasedat/phase_dat_oadev.txt", "phasedat/phase_dat_oadev_octave.txt"),
    ),
    "OCXO": ("ocxo/ocxo_frequency.txt", "freq", ("ocxo/stable32_oadev_alltau.txt",)),
    "flicker frequency noise": (
        "pink_frequency/pink_frequency.txt",
        "freq",
        ("pink_frequency/oadev.txt", "pink_frequency/s32_oadev_octave.txt"),
    ),
    "noise floor of a Keysight 53230A": (
        "Keysight53230A_ti_noise_floor/tic_phase.txt",
        "phase",
        ("Keysight53230A_ti_noise_floor/tic_oadev.txt",),
    ),
    "GPS receiver": ("gps/gps_1pps_phase_data.txt.gz", "phase", ("gps/stable32_OADEV_octave.txt",)),
    "5071A Cs clock": (
        "Cs5071A/5071A_phase.txt.gz",
        "phase",
        ("Cs5071A/oadev_decade.txt", "Cs5071A/oadev_all.txt"),
    ),
}


@pytest.fixture(scope="module")
def suite(tmp_path_factory):
    """AllanTools' records, which only its source distribution contains; a download is kept."""
    pins = (together.ROOT / "tools/requirements-bench.txt").read_text().splitlines()
    pin = next(line for line in pins if line.startswith("AllanTools=="))
    kept, folder = together.ROOT / "build/cache" / pin, tmp_path_factory.mktemp("allantools")
    if not list(kept.glob("*.tar.gz")):
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
        words = [*pip, "--no-binary", "AllanTools", "--dest", kept, pin]
        if subprocess.run(words).returncode:
            pytest.skip("pip could not download the source of AllanTools")
    subprocess.run(["tar", "-xzf", *kept.glob("*.tar.gz"), "-C", folder], check=True)
    return next(folder.glob("allantools-*/tests"))


def results(path):
    """Columns of a result of Stable32: size, tau, differences, noise type, low, deviation, high."""
    return np.loadtxt(path, unpack=True)


@pytest.mark.parametrize("record", RECORDS)
def test_every_digit_of_stable32_and_the_table_of_the_page(suite, record):
    data, kind, names = RECORDS[record]
    x = np.loadtxt(suite / data)
    scale = x.mean() if record == "OCXO" else 1.0  # a frequency in Hz
    count = 0
    for name in names:
        sizes, _, n, _, _, deviation, _ = results(suite / name)
        found = davar.adev(x, 1.0, data_type=kind, clusters=sizes)
        np.testing.assert_array_equal(found.n, n)
        assert [f"{a:.4e}" for a in found.adev / scale] == [f"{b:.4e}" for b in deviation]
        count += sizes.size
    assert f"| {record} | {x.size} | {kind} | {count} | {count} |\n" in PAGE.read_text()


def test_intervals_where_one_noise_type_holds(suite):
    """Stable32 finds white frequency noise at every averaging time of PHASE.DAT only."""
    x = np.loadtxt(suite / "phasedat/PHASE.DAT")
    sizes, _, _, alpha, *_ = results(suite / "phasedat/phase_dat_oadev_octave.txt")
    assert set(alpha) == {0}
    found = davar.adev(x, 1.0, data_type="phase", clusters=sizes)
    for m, deviation, low, high in zip(sizes, found.adev, found.low, found.high):
        freedom = allantools.edf_greenhall(0, 2, int(m), x.size, overlapping=True)
        theirs = allantools.confidence_interval(deviation, freedom, ci=0.95)
        assert (high - low) / (theirs[1] - theirs[0]) == pytest.approx(1, abs=0.1)
