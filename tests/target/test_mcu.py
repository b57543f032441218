"""tools/davar-mcu: the same bytes as davar-sim --mode trailing, on every target; equal errors for
bad options.
"""

import csv
import math
import random
import subprocess
from functools import cache

import pytest
import targets
from on_boards import boards

ROOT = targets.ROOT
SAMPLES = 100_000
TAUS = "--taus 1,2,4,8,16,32,64,128"
SHORT, LONG = 3000, SAMPLES
JOBS = {
    "the paper's window law": f"{TAUS} --stride 50",
    "both criteria": f"{TAUS} --stride 500 --mode trailing --law and",
    "fixed window, no moments": "--law fixed --segment 0 --stride 97",
    "law glr": "--taus 1,2,4,8,16,32,64 --law glr --window-max 320 --stride 50",
    "a stride on a grid": f"{TAUS} --stride 20 --engine grid",
    "gaps restart the window": "--stride 60 --window-max 300",
    "a cascade": "--law fixed --stride 600 --longest-tau 300",
    "a cascade after a filter": "--law fixed --mode trailing --stride 600 --longest-tau 20 "
    "--bandwidth 30",
}


def random_job(draw):
    """Options for which every target has enough memory."""
    longest = 2 * draw.randrange(20, 100)
    shortest = 2 * draw.randrange(10, longest // 2 + 1)
    most = shortest // 2
    taus = sorted(draw.sample(range(1, most + 1), min(draw.randrange(1, 9), most)))
    options = (
        f"--window-max {longest} --window-min {shortest} --segment {draw.randrange(1, shortest)} "
        f"--taus {','.join(map(str, taus))} --stride {draw.choice((1, 11, 20, 40))} "
        f"--law {draw.choice(('fixed', 'kurtosis', 'or', 'and'))} "
        f"--lsb {draw.choice(('0.01', '0.002'))}"
    )
    return options + (" --shrink 0" if draw.random() < 0.3 else "")


DRAW = random.Random(20261121)
RUNS = [
    *((LONG, f"--lsb 0.01 {options}") for options in JOBS.values()),
    (SHORT, f"--lsb 0.01 {TAUS}"),  # a result at every sample
    (SHORT, f"--lsb 2 {TAUS} --stride 20"),  # noise below half a count
    *((SHORT, random_job(DRAW)) for _ in range(5)),
]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Noise that changes its size, with gaps: two near each other, one of them long. In the last
    fifth the gyro turns slowly.
    """
    folder, found = tmp_path_factory.mktemp("recordings"), {}
    for samples in (SHORT, LONG):
        noise, time_s = random.Random(3), 0.0
        found[samples] = folder / f"{samples}.csv"
        with found[samples].open("w") as file:
            file.write("time_s,gyro_z_dps\n")
            for i in range(samples):
                time_s += 0.06 if i in (5000, 40000, 40010, 40020, 40030, 40040) else 0.01
                sigma = 0.2 if (i // 20000) % 2 == 0 else 0.8
                turn = 10 * math.sin(i / 100) if i >= 80000 else 0.5
                file.write(f"{time_s:.2f},{noise.gauss(turn, sigma):.2f}\n")
    return found


def command(name, *arguments):
    words = [ROOT / "tools" / name, *map(str, arguments)]
    done = subprocess.run(words, text=True, capture_output=True, check=False)
    return done.returncode, done.stdout, done.stderr


@cache
def simulated(recording, options):
    return command("davar-sim", recording, "--mode", "trailing", *options.split())


@pytest.mark.parametrize("samples, options", RUNS)
@pytest.mark.parametrize("target", boards(targets.MACHINES))
def test_the_same_bytes_as_davar_sim(target, samples, options, recordings):
    options += " --details"
    expected = simulated(recordings[samples], options)
    assert expected[0] == 0, expected[2]
    assert len(expected[1].splitlines()) > 50
    actual = command("davar-mcu", "--target", target, recordings[samples], *options.split())
    assert actual == expected


def test_the_runs_have_every_kind_of_result(recordings):
    """What is 0 in all of them could be lost on its way from a device."""
    outputs = [simulated(recordings[run], f"{options} --details")[1] for run, options in RUNS]
    rows = [row for output in outputs for row in csv.DictReader(output.splitlines())]
    for name in ("unstable", "coarse", "filtered", "flat_from", "flat_to", "gaps_in_window"):
        assert {row[name] for row in rows} - {"0"}, name


# Options, words of the error; None: those of davar-sim.
REFUSED = (
    ("cortex-m4f", "--window-max 0", None),
    ("cortex-m4f", "--law guess", None),
    ("cortex-m4f", "--lsb -1", None),
    ("cortex-m4f", "--lsb 0.01 --mode centred", "give --mode trailing"),
    ("z80", "", "found 'z80'"),
    (
        "cortex-m0",
        "--lsb 0.01 --window-max 6000 --window-min 99 --segment 9 --taus 1,2,4",
        "too little memory",
    ),
    *(
        (
            "cortex-m0",
            "--lsb 0.01 --window-max 1200 --law fixed --longest-tau 40000 " + options,
            words,
        )
        for options, words in (
            ("--stride 1", "the cascade of --longest-tau: shorten --window-max"),
            ("--stride 600 --taus 1,2,3,4,5,6,7,8,9,10", "shorten --taus or --longest-tau"),
        )
    ),
)


@pytest.mark.parametrize("target, options, words", REFUSED)
def test_a_job_that_the_device_cannot_do_is_reported(target, options, words, recordings):
    found = command("davar-mcu", "--target", target, recordings[SHORT], *options.split())
    assert found[:2] == (2, "")
    if words:
        assert words in found[2]
    else:
        assert found == simulated(recordings[SHORT], options)
