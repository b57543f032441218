"""Lines that drift, that follow a logged column or are there for a while, and steps of the bias:
against brute force and simulations with numpy.
"""

import re

import lab_bench
import numpy as np
import pytest
from awkward import band
from davarlab import model, simulate
from davarlab.candidates import drifting, intermittent, lines, steps
from davarlab.candidates.candidate import Candidate
from davarlab.data import signals
from davarlab.diagnosis import improve
from davarlab.inference.parts import Bench, Part
from davarlab.report import verdict, words
from davarlab.thresholds import LINE, STEP, TRIES
from lab_bench import run
from scipy import interpolate, stats

RATE, COUNT = 100.0, 90_000


def followed(line, rng):
    """(course in turns a sample, gain over the energy of the line) of a line in noise."""
    z, time = drifting.beside_zero(line + rng.standard_normal(COUNT), 0.23, 0.31)
    _, knots = drifting.followed(z, time, COUNT - 1.0)
    course = interpolate.CubicSpline(np.linspace(0, COUNT - 1, len(knots)), knots)
    gain = drifting.gathered(z, time, COUNT - 1.0, knots)[0]
    middle = (int(0.23 * COUNT) + len(z) // 2) / COUNT
    return middle + course(np.arange(COUNT)), gain / (np.sum(line**2) / 2)


@pytest.mark.parametrize("seed, moves", [(1, 0.4), (2, 1.5), (3, 2.5)])
def test_the_course_of_a_line_in_noise_is_followed_and_a_line_with_a_width_has_none(seed, moves):
    """Frequency within 3 mHz but at the ends, and nearly all of the line's energy, though it is
    below the noise of single samples. A band forgets its phase.
    """
    rng, u = np.random.default_rng(seed), np.arange(COUNT) / COUNT
    f = 0.27 + moves / RATE * np.cumsum(np.cos(9 * u + seed)) / COUNT
    course, gain = followed(0.5 * np.sin(2 * np.pi * np.cumsum(f)), rng)
    inside = slice(COUNT // 20, -COUNT // 20)
    assert np.abs(course - f)[inside].max() * RATE < 3e-3
    assert gain > 0.9
    assert followed(0.5 * band(COUNT, 0.27, 0.2 / RATE, rng), rng)[1] < 0.5


def test_a_steady_line_does_not_drift():
    """Whatever else the model lacks: a second line, and a slow wave."""
    for seed in range(6):
        rng, count = np.random.default_rng([seed, 9]), 60_000
        first, second = rng.uniform(1, 49, 2)
        y, at = 0.05 * rng.standard_normal(count), np.arange(count) / RATE
        for hz, size in ((first, 0.02), (second, 0.02), (0.0015, 0.04)):
            y += size * np.sin(2 * np.pi * (hz * at + rng.random()))
        bench, white = Bench(lab_bench.of_gyro(y, RATE), y), [Part("angle_random_walk")]
        shape = {"std_dps": 0.0, "frequency_hz": first, "half_width_hz": 0.001}
        narrow = Candidate("narrow_band", Part("narrow_band", shape), 100.0, -90.0)
        assert drifting.search(bench, white, bench.fit(white), narrow) is None, seed


def test_a_model_with_a_course_is_simulated_found_and_explains(lab):
    course = 'kind = "drifting_line"\namplitude_dps = 0.05\ncourse_hz = "9 9.2 9.9 9.7"\n'
    recording, better = lab.simulated(f"[[effect]]\n{course}", 4, 900), "better.toml"
    done = run("improve", recording, "-m", lab.model, "-o", lab.work / better)
    assert done.returncode == 0, done.stderr
    assert "lacks drifting line: " in done.stdout
    assert re.search(r"course (8\.9|9)\S* to (9\.9|10)\S* Hz \(\d+ knots\)", done.stdout)
    assert run("compare", recording, "-m", lab.work / better).returncode == 0


def with_a_rotor(
    seed, amplitude, multiple=1 / 60, logged=lambda rpm, rng: rpm, seconds=600, stops_s=600
):
    """A line at a multiple of a speed that wanders by half, and the speed as it is logged; both are
    0 when it has stopped.
    """
    rng, count = np.random.default_rng([seed, 31]), int(RATE * seconds)
    marks = np.linspace(0, count, seconds // 30)
    rpm = interpolate.CubicSpline(marks, rng.uniform(1500, 2300, len(marks)))(np.arange(count))
    turns, on = multiple * np.cumsum(rpm) / RATE, np.arange(count) < stops_s * RATE
    line = amplitude * np.sin(2 * np.pi * turns + 1) * on
    made, rpm = lab_bench.of_gyro(0.03 * rng.standard_normal(count) + line, RATE), rpm * on
    made.columns["rpm"] = logged(rpm, rng)
    made.columns["supply_V"] = 5 - np.linspace(0, 0.1, count) + 0.002 * rng.standard_normal(count)
    made.columns["load"] = 0.05 * np.cumsum(rng.standard_normal(count))
    return made


ROTORS = {
    "weak": {"amplitude": 0.004},
    "an alias": {"amplitude": 0.02, "multiple": 4 / 60},
    "a noisy speed": {
        "amplitude": 0.02,
        "logged": lambda rpm, rng: rpm + 20 * rng.standard_normal(len(rpm)),
    },
    "a rotor that stops": {
        "amplitude": 0.02,
        "logged": lambda rpm, rng: np.clip(rpm + 20 * rng.standard_normal(len(rpm)), 0, None),
        "stops_s": 350,
    },
    "huge numbers below 0": {
        "amplitude": 0.02,
        "logged": lambda rpm, rng: -1e12 * rpm,
        "named": 1 / 60e12,
    },
    "a speed ten times slower": {
        "amplitude": 0.02,
        "logged": lambda rpm, rng: np.repeat(rpm[::10], 10),
    },
}


@pytest.mark.parametrize("name", ROTORS)
def test_a_line_that_turns_with_a_column_is_named_with_its_multiple(name):
    row = dict(ROTORS[name])
    named = row.pop("named", row.get("multiple", 1 / 60))
    made = with_a_rotor(4, **row)
    found = improve.improve(made, model.first(RATE, "gyro_z_dps"))
    assert (found.added, found.judgement.adequate) == (["line_follows"], True)
    entry = found.estimates[-1]
    assert entry["column"].value == "rpm"
    assert entry["multiple"].value == pytest.approx(named, rel=1e-3)
    assert entry["amplitude_dps"].value == pytest.approx(row["amplitude"], rel=0.15)
    missing = words.in_ascii(verdict.of_missing(found))
    said = re.search(r"\(([\d.e-]+) times a speed in rpm\)", missing)
    assert float(said[1]) == pytest.approx(60 * named, rel=1e-3)
    again = improve.fit(made, model.of_text(model.text_of(found.model), name))
    assert again[0].judgement.adequate  # the model file says all of it


@pytest.mark.parametrize("moves_hz, kind", [(0.0, "sinusoid"), (0.8, "drifting_line")])
def test_a_line_of_its_own_turns_with_no_column(moves_hz, kind):
    made = with_a_rotor(5, 0.0)
    hz = 31.3 + moves_hz * np.sin(2 * np.pi * made.time_s / 400)
    made.columns["gyro_z_dps"] += 0.02 * np.sin(2 * np.pi * np.cumsum(hz) / RATE)
    found = improve.improve(made, model.first(RATE, "gyro_z_dps"))
    assert found.added == [kind]


def test_the_score_of_a_step_by_least_squares():
    rng, n = np.random.default_rng(1), 400
    level = 1 + 30 / np.arange(1, n) ** 1.3
    c = rng.standard_normal(n - 1) * np.sqrt(level)
    found = steps.scores(c / level, steps.alike(level))
    for place in (3, 77, 200, 391):
        course = signals.transform((np.arange(n) >= place).astype(float))[1:]
        score = np.sum(course * c / level) / np.sqrt(np.sum(course**2 / level))
        assert abs(found[place - 1] - score) < 5e-9


def step_by_chance(seed, tilt, n=5000):
    """log p of the largest step in noise that walks, or not."""
    level = 1 + 200 * (tilt > 0) * (np.arange(1, n) / 10.0) ** -tilt
    c, same = np.random.default_rng([2, seed]).standard_normal(n - 1), steps.alike(level)
    score = np.abs(steps.scores(c / np.sqrt(level), same))
    score[: STEP.edge] = score[-STEP.edge :] = 0
    return steps.log_chance(float(score.max()), same, n)


def visit_by_chance(seed, _, n=20000):
    """log p of the strongest line for a while in white noise."""
    w = np.random.default_rng([3, seed]).standard_normal(n)
    _, nu, low, high = intermittent.strongest(w)
    for _ in range(LINE.interval_rounds):
        gain, low, high = intermittent.best_interval(w, nu)
        nu = intermittent.best_frequency(w, nu, low, high)
    return np.log(TRIES.of_interval * n * gain**2) - gain


def multiple_by_chance(seed, _):
    """log p of the strongest line that turns with a column, in white noise."""
    made, white = with_a_rotor(seed, 0.0, seconds=300), [Part("angle_random_walk")]
    bench = Bench(made, made.columns["gyro_z_dps"])
    found = lines.with_a_column(bench, white, bench.fit(white))
    return found.log_p if found else 0.0


@pytest.mark.parametrize(
    "log_p, tilt, tries",
    [
        *((step_by_chance, tilt, 200) for tilt in (0.0, 1.0, 2.0)),
        (visit_by_chance, 0, 60),
        (multiple_by_chance, 0, 60),
    ],
)
def test_the_chance_of_a_step_or_of_a_line_that_comes_or_turns_holds(log_p, tilt, tries):
    hits = sum(log_p(seed, tilt) < np.log(0.05) for seed in range(tries))
    assert hits < stats.binom.ppf(0.999, tries, 0.05)


@pytest.mark.parametrize(
    "kind, times, holds",
    [
        ("bias_step", {"time_s": 100.0}, {"step_dps": 0.05}),
        (
            "intermittent_line",
            {"start_s": 100.0, "stop_s": 200.0},
            {"amplitude_dps": 0.05, "frequency_hz": 7.0},
        ),
    ],
)
def test_in_a_model_file_it_is_fitted_and_simulated(kind, times, holds):
    term = model.checked_term({"kind": kind, **times, **holds}, "here")
    given = model.Model(50.0, "gyro_z_dps", [*lab_bench.terms(), term])
    found = improve.fit(simulate.make(given.terms, 50.0, duration_s=400.0), given)[2][2]
    for name, true in holds.items():
        assert found[name].low <= true <= found[name].high
