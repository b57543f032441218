"""The flight of examples/kalman_flight: a filter with davar's noise is as good as one with the true
noise, for every seed.
"""

import csv
import io
import math
import statistics
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SEEDS, FLIGHTS = range(101, 107), 20
PHASES = ("quiet", "loud", "after")
FIGURES = ("rms_deg", "nees_over_3", "share_within_95")

pytestmark = pytest.mark.slow


def run(*command):
    return subprocess.run([str(word) for word in command], text=True, capture_output=True)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flight")
    source = ROOT / "examples/kalman_flight"
    for command in (("-S", source, "-B", folder), ("--build", folder)):
        done = run("cmake", *command)
        assert done.returncode == 0, done.stdout + done.stderr
    return folder / "flight"


def fly(program, *options):
    """(phase, belief) -> rms error, NEES over 3, share of seconds within the 95 % bounds."""
    done = run(program, *options, "--flights", FLIGHTS)
    assert done.returncode == 0, done.stderr
    rows = csv.DictReader(io.StringIO(done.stdout))
    return {(row["phase"], row["belief"]): [float(row[name]) for name in FIGURES] for row in rows}


@pytest.fixture(scope="module")
def of(program):
    """Mean and standard error over the seeds of one figure."""
    flights = [fly(program, "--seed", seed) for seed in SEEDS]

    def figure(number, phase, belief):
        values = [flight[phase, belief][number] for flight in flights]
        return statistics.mean(values), statistics.stdev(values) / math.sqrt(len(values))

    return figure


def test_in_noise_that_triples_the_fed_filter_beats_the_one_from_the_bench(of):
    (bench, bench_error), (fed, fed_error) = of(0, "loud", "bench"), of(0, "loud", "fed")
    assert bench - fed > 5 * math.hypot(bench_error, fed_error)
    # Steady state of one axis: random walk of 0.015 deg/sqrt(s), measured to 0.05 deg once a
    # second; a gain for 0.005 deg/sqrt(s). The bias, which both learn, adds a little.
    for gained, said in ((0.015, fed), (0.005, bench)):
        ahead = (gained**2 + math.sqrt(gained**4 + 4 * gained**2 * 0.05**2)) / 2
        k = ahead / (ahead + 0.05**2)
        behind = ((1 - k) ** 2 * 0.015**2 + k**2 * 0.05**2) / (1 - (1 - k) ** 2)
        assert said / math.sqrt(behind) == pytest.approx(1, abs=0.06)


def test_it_is_consistent_in_every_phase_and_they_are_not(of):
    for phase in PHASES:
        mean, _ = of(1, phase, "fed")
        truth, truth_error = of(1, phase, "true")
        # the flights are the same, so there is no random difference
        assert mean == pytest.approx(truth, abs=0.02), phase
        assert abs(truth - 1) < 4 * truth_error + 0.01, phase
    assert of(1, "loud", "bench")[0] > 3
    assert of(1, "quiet", "worst")[0] < 0.75


@pytest.mark.parametrize("law", ["glr", "or", "fixed"])
def test_in_noise_that_does_not_change_feeding_costs_nothing(program, law):
    flight = fly(program, "--seed", 7, "--steady", "--law", law)
    for phase in PHASES:
        assert flight[phase, "fed"][0] / flight[phase, "bench"][0] < 1.005, phase


def test_the_same_seed_gives_the_same_flight_and_a_wrong_option_is_rejected(program):
    once, again, other = (run(program, "--flights", 2, "--seed", n).stdout for n in (5, 5, 6))
    assert once == again != other
    for wrong in (("--law", "x"), ("--flights", "0"), ("--flights",), ("--nosuch", "1")):
        done = run(program, *wrong)
        assert (done.returncode, done.stdout) == (2, ""), wrong
        assert "usage: flight" in done.stderr
