"""--motion flight: the floors of a written setup are those of davar/floor.h and of davar-sim, and a
wish without a floor is one line that says what to type.
"""

import csv
import re
import subprocess

import numpy as np
import pytest
from planner_case import ROOT, SIM, choice, command, planned, refused, run

PROBE = (ROOT / "tests/tools/floor_probe.c").read_text()
STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-O1")
LOW_PASS = "davar_filter_low_pass(&f,"
INT16, INT32 = 32767, 8388607
# Options, samples in a sum, rail of a sample, block, and the calls of the library for the filter.
FLIGHTS = [
    ("--rate 1000 --lsb 0.05 --bandwidth none", 1, INT16, 256, ""),
    ("--rate 500 --lsb 0.05 --bandwidth none --axes 3", 1, INT16, 128, ""),
    ("--rate 1999 --lsb 0.05 --bandwidth none", 1, INT16, 256, ""),
    (
        "--rate 8000 --axes 3 --lsb 0.061 --bandwidth 258:2:5",
        8,
        8 * INT16,
        256,
        f"{LOW_PASS} 258.0 / 8000.0, 2, 0.01 * 5.0); davar_filter_sum(&f, 8)",
    ),
    (  # sums of eight leave too few frequencies
        "--rate 8000 --lsb 0.061 --bandwidth 258:2",
        10,
        10 * INT16,
        256,
        f"{LOW_PASS} 258.0 / 8000.0, 2, 0.01 * 10.0); davar_filter_sum(&f, 10)",
    ),
    (
        "--rate 1000 --axes 2 --lsb 0.061 --bandwidth 250:2",
        2,
        2 * INT16,
        128,
        f"{LOW_PASS} 250.0 / 1000.0, 2, 0.01 * 10.0); davar_filter_sum(&f, 2)",
    ),
    (
        "--rate 1600 --axes 2 --type int32 --lsb 1e-4 --bandwidth biquad:700",
        1,
        INT32,
        256,
        "davar_filter_biquad(&f, 700.0 / 1600.0)",
    ),
    (
        "--rate 6664 --lsb 0.07 --type int32 --bandwidth 3000:1 --false-alarms-per-hour 0.1",
        6,
        6 * INT32,
        256,
        f"{LOW_PASS} 3000.0 / 6664.0, 1, 0.01 * 10.0); davar_filter_sum(&f, 6)",
    ),
    (
        "--rate 2000 --axes 2 --lsb 0.05 --bandwidth none --longest-tau 40",
        2,
        2 * INT16,
        256,
        "davar_filter_sum(&f, 2)",
    ),
    (
        "--rate 2000 --lsb 0.05 --bandwidth 2000+sum:4 --longest-tau 40 --flash 28k",
        2,
        2 * INT16,
        256,
        f"{LOW_PASS} 2000.0 / 8000.0, 2, 0.01 * 10.0); davar_filter_sum(&f, 8)",
    ),
]


def recording(samples, rail=None):
    """Noise, a line that sweeps, and motion, as counts, and where samples are lost; two samples at
    the rail."""
    noise, at = np.random.default_rng(7), np.arange(samples)
    line = 300 * np.sin(2 * np.pi * (0.1 + 0.1 * at / samples) * at)
    counts = np.rint(noise.normal(0, 30, samples) + line + 900 * np.sin(1e-3 * at)).astype(int)
    if rail:
        counts[[samples // 6, samples // 6 + 300]] = rail
    lost = np.zeros(samples, bool)
    lost[samples // 2 : samples // 2 + 70] = True
    lost[noise.integers(0, samples // 3, 5)] = True
    return counts, lost


def floors(folder, words, summed, rail, block, filter, clip=False):
    """What floor_probe.c prints for a self-contained setup with these options."""
    done = run(
        [*words.split(), "--motion", "flight", "--core", "cortex-m4f", "-o", str(folder)]
        + ["--self-contained"]
    )
    assert (done.status, done.err) == (0, "")
    given = dict(zip(words.split()[::2], words.split()[1::2]))
    defined = {
        "SAMPLE": f"{given.get('--type', 'int16')}_t",
        "RATE": float(given["--rate"]),
        "LSB": float(given["--lsb"]),
        "SUMMED": summed,
        "RAIL": rail,
        "BLOCK": block,
        "FILTER": filter,
    }
    (folder / "program.c").write_text(PROBE)
    options = [f"-D{name}={value}" for name, value in defined.items()]
    made = [*STRICT, "-ffp-contract=off", *options, "davar.c", "program.c", "-lm", "-o", "program"]
    done = subprocess.run(["gcc", *made], text=True, capture_output=True, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    counts, lost = recording(summed * block * 20, clip and rail // summed)
    lines = "\n".join("g" if gone else str(count) for count, gone in zip(counts, lost))
    done = subprocess.run([folder / "program"], input=lines, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout.splitlines()[-1]
    return [
        (int(why), *map(float.fromhex, numbers))
        for why, *numbers in map(str.split, done.stdout.splitlines())
    ]


@pytest.mark.parametrize("flight", FLIGHTS)
def test_the_floors_of_a_setup_are_those_of_the_library(flight, tmp_path):
    found = floors(tmp_path, *flight)
    assert len(found) > 30
    assert {why for why, *_ in found[:3]} == {1}
    assert sum(why == 0 for why, *_ in found) > 20


@pytest.mark.parametrize("flight", (FLIGHTS[0], FLIGHTS[4]))
def test_a_clipped_sample_takes_the_value_also_within_a_sum(flight, tmp_path):
    found = floors(tmp_path, *flight, clip=True)
    why = [one[0] for one in found]
    assert set(why) == {0, 1, 3}
    assert why.count(3) >= 6  # of two runs


def test_they_are_those_of_davar_sim(tmp_path):
    words, *more = FLIGHTS[0]
    found = floors(tmp_path, words, *more)
    counts, lost = recording(20 * 256)
    rows = [
        f"{0.001 * i:.3f},{0.05 * count:.2f}"
        for i, (count, gone) in enumerate(zip(counts, lost))
        if not gone
    ]
    options = "--lsb 0.05 --bandwidth none --floor --law fixed --window-max 64 --stride 8"
    done = subprocess.run(
        [SIM, "-", *options.split()],
        input="\n".join(["time_s,gyro_z_dps", *rows]),
        text=True,
        capture_output=True,
        check=True,
    )
    names = [f"floor_{part}deg_per_sqrt_h" for part in ("", "low_", "high_")]
    shown = [tuple(row[name] for name in names) for row in csv.DictReader(done.stdout.splitlines())]
    distinct = [one for one, before in zip(shown, [None, *shown]) if one != before and one[0]]
    first = found[: len(found) // 2]  # before the restart
    assert [tuple(map(float, one)) for one in distinct] == [
        pytest.approx(numbers, rel=1e-6) for why, *numbers in first if why == 0
    ]


# --- what the planner promises and refuses ---


def in_flight(words):
    return f"{words} --motion flight --core cortex-m4f"


@pytest.mark.parametrize(
    "words, every, window",
    (
        ("--rate 1000 --lsb 0.05 --bandwidth none", 0.256, 1.056),
        ("--rate 500 --lsb 0.05 --bandwidth none", 0.256, 1.088),
        ("--sensor icm42688@8000 --axes 3", 0.256, 1.056),
        ("--sensor bmi160@3200", 0.24, 0.99),
    ),
)
def test_the_report_states_the_floor_and_a_simulation_counts_it(words, every, window):
    found = planned(f"{in_flight(words)} --simulate")
    assert found["motion"] == "flight"
    assert found["floor_stride_s"] == pytest.approx(every)
    assert found["floor_window_s"] == pytest.approx(window)
    assert found["simulated"]["floor_present"] > 0.99
    assert found["simulated"]["floor_holds"] > 0.93
    text = command(in_flight(words)).out
    assert f"in flight, the floor every {every:g} s from a window of {window:.3g} s" in text
    still = planned(words + " --motion none --core cortex-m4f --simulate")
    assert still["floor_window_s"] is still["simulated"]["floor_present"] is None


PLAIN = "--rate 8000 --lsb 0.05"
ERRORS = (
    (PLAIN, "needs the filter.* give --bandwidth FILTER, or none for raw samples"),
    ("--sensor bno085@400", "needs the filter"),
    (
        "--rate 100 --type float --full-scale 500 --bandwidth none",
        "needs counts: state --type int16 or int32, and --lsb",
    ),
    (f"{PLAIN} --bandwidth average2:512", "average2:512[+]sum:8 is too long a filter"),
)


@pytest.mark.parametrize("words, said", ERRORS)
def test_a_wish_without_a_floor_is_one_line(words, said):
    done = command(in_flight(words))
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert re.match(f"davar-plan: --motion: flight .*{said}", done.err), done.err


def test_the_limits_of_usable_frequencies_are_those_of_the_library():
    header = (ROOT / "addons/floor/include/davar/floor.h").read_text()
    for name in ("NEEDED", "LIMITED"):
        stated = re.search(rf"#define DAVAR_FLOOR_{name} (\d+)U", header)
        assert getattr(choice.floors, name) == int(stated[1])


@pytest.mark.parametrize(
    "bandwidth, usable", (("120:2", 21), ("20:1", 9), ("biquad:30", 14), ("30:2", 6))
)
def test_a_filter_that_leaves_no_value_names_one_that_does(bandwidth, usable):
    words = in_flight(f"{PLAIN} --bandwidth {bandwidth}")
    found = refused(words)
    assert f"leaves {usable} usable frequencies, and the floor needs 23" in found["impossible"]
    assert ("only have an upper limit" in found["impossible"]) == (usable >= 8)
    still = command(words.replace("--motion flight", "--motion none")).status == 0
    assert found["relax"] == ([{"option": "--motion", "value": "none"}] if still else [])
    assert still == (bandwidth != "biquad:30")
    for certain in re.findall(r"state --bandwidth (\S+)", " ".join(found["hints"])):
        other = words.replace(f"--bandwidth {bandwidth}", f"--bandwidth {certain}")
        assert command(other).status == 0
    assert ("state --bandwidth" in " ".join(found["hints"])) == (bandwidth == "120:2")
