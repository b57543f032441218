"""AllanTools' own tests of oadev with davar.adev in its place, and the results of Stable32 that
its source distribution contains. The table is in docs/PYTHON.md.

pytest loads this module as a plugin, which replaces allantools.oadev.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import allantools
import numpy as np
import pytest
import together
from together import davar

PAGE = together.ROOT / "docs/PYTHON.md"
FILES = (
    "ocxo/test_ocxo.py",  # first: it opens files of its folder, and the others change the folder
    "nbs14/test_nbs14_10point.py",
    "nbs14/test_nbs14_1000point.py",
    "phasedat/test_phasedat.py",
    "phasedat/test_phasedat_with_ci.py",
    "pink_frequency/test_pink.py",
    "Keysight53230A_ti_noise_floor/test_TIC.py",
    "gps/test_gps.py",
    "Cs5071A/test_CS5071A_decade.py",
    "test_dataset.py",
    "functional_tests/test_3ch.py",
    "functional_tests/test_ns.py",
    "functional_tests/test_overwrite.py",
)
# The intervals in the tests of GPS and Cs are AllanTools' own, around deviations that other tests
# compare. They would double the time.
USES_OADEV = (
    "(oadev or compute_functions or 3ch or test_ns or overwrite) "
    "and not (TestGPS and ci) and not (TestCS and ci)"
)
DIFFERENT = {  # intended, see the page
    "test_3ch.py::test_3ch_1": "AssertionError",
    "test_ns.py::test_ns": "ValueError: taus_s: cluster sizes up to 249 samples",
}
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


def oadev(data, rate=1.0, data_type="phase", taus=None):
    """davar.adev with the arguments and the results of allantools.oadev."""
    times = {"taus": taus} if taus is None or isinstance(taus, str) else {"taus_s": taus}
    found = davar.adev(data, rate, data_type=data_type, **times)
    return found.taus_s, found.adev, found.high - found.adev, found.n


def pytest_configure():
    allantools.oadev = allantools.allantools.oadev = oadev


@pytest.fixture(scope="module")
def suite(tmp_path_factory):
    """AllanTools' tests, which only its source distribution contains; a download is kept."""
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


@pytest.mark.soak
def test_its_own_tests_pass_except_two_intended_differences(suite, wheel):
    done = subprocess.run(
        [sys.executable, "-B", "-m", "pytest", "-rpf", "-p", "test_allantools"]
        + ["-p", "no:cacheprovider", "-k", USES_OADEV, *(suite / name for name in FILES)],
        cwd=suite / "ocxo",
        env={
            **os.environ,
            "PYTHONPATH": f"{wheel.davar}:{Path(__file__).parent}",
            "COLUMNS": "200",
        },
        text=True,
        capture_output=True,
    )
    failed = dict(re.findall(r"^FAILED \S*?([^/\s]+) - (.*)$", done.stdout, re.MULTILINE))
    assert set(failed) == set(DIFFERENT), done.stdout + done.stderr
    for name, why in DIFFERENT.items():
        assert failed[name].startswith(why)
    passed = re.findall(r"^PASSED ", done.stdout, re.MULTILINE)
    assert f"{len(passed)} of the {len(passed) + 2} tests" in PAGE.read_text()


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
