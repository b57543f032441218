"""Recordings with a known truth, and what davarlab must find beside ARW 0.3 deg/sqrt(h) and bias
instability 5 deg/h: one table. Short ones; docs/lab_benchmark.md has the statistics in full.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import awkward
import elsewhere
import heat
import lab_bench as bench
import numpy as np
from davarlab import model as models
from davarlab.data import recording
from davarlab.data.recording import Recording
from davarlab.diagnosis import improve
from davarlab.model import Model, Term
from davarlab.report import values
from scipy import signal

RATE, COUNT = 50.0, 100_000
TIME = np.arange(COUNT) / RATE
VISIT = ("frequency_hz", "amplitude_dps", "start_s", "stop_s")


@dataclass(frozen=True)
class Scenario:
    """make: the recording; missing: the kinds that are added, None: not tested;
    includes: one of them.

    near: kind.parameter -> (true value, how far off the estimate may be); holds: kind.parameter ->
    a true value in the 95 % interval; absent: kinds that are neither added nor alternatives; truth:
    what scoring.py compares the answer with.
    """

    make: Callable[[], Recording]
    missing: tuple | None = None
    includes: str = ""
    near: dict = field(default_factory=dict)
    holds: dict = field(default_factory=dict)
    absent: tuple = ()
    model: Model | None = field(default_factory=bench.model)  # None: a first model, fitted
    verdict: str | None = "known"  # any but unknown; None: not tested
    truth: object | None = None


class Analysed:
    """A scenario with davarlab's answer as JSON, and the parts of the last model of the search."""

    def __init__(self, scenario):
        made = scenario.make()
        if isinstance(made, tuple):
            made, truth = made
            scenario = replace(scenario, truth=truth)
        given = scenario.model
        if given is None:
            given = improve.fit(made, models.first(made.rate_hz, "gyro_z_dps"))[1]
        found = improve.improve(made, given)
        self.scenario = scenario
        self.json = values.plain(values.diagnosis(found))
        self.kinds = [part.kind for part in found.diagnosis.states[-1].parts]

    def estimates(self, name):
        """Those of kind.parameter: one of each effect of the kind, in the order of time."""
        kind, _, parameter = name.partition(".")
        of_kind = [one["parameters"] for one in self.json["fitted"] if one["kind"] == kind]
        if all("time_s" in one for one in of_kind):
            of_kind.sort(key=lambda one: one["time_s"]["value"])
        return [one[parameter] for one in of_kind]


def simulated(*more, seed=3, seconds=3600.0, **expected):
    missing = tuple(sorted(kind for kind, _ in more))
    return Scenario(lambda: bench.simulated(*more, seed=seed, seconds=seconds), missing, **expected)


def from_elsewhere(case, seed, *missing):
    def make():
        return Recording(elsewhere.recording(case, seed)[0], elsewhere.RATE, case)

    return Scenario(make, missing)


def from_awkward(case, seed, rate=None, seconds=None, missing=None, scored=True, **more):
    def make():
        columns, truth = awkward.case(case, seed, rate, seconds)
        made = recording.of_columns(columns, None, case, {}, 1)
        return (made, truth) if scored else made

    more = {"verdict": None, **more}
    return Scenario(make, missing, model=bench.model(rate or awkward.CASES[case][1]), **more)


def heated(case, how, *missing, seed=5, **expected):
    return Scenario(lambda: Recording(heat.make(case, how, seed), heat.RATE), missing, **expected)


def limited(make, kind):
    """An effect of the size of data sheets."""
    return Scenario(lambda: Recording(make(), heat.RATE), includes=kind, verdict=None)


def added(course, *missing, seed=(), **expected):
    """A course, then noise from the same generator. Nothing in missing: not tested."""

    def make():
        rng = np.random.default_rng(list(seed))
        there = course(rng) if callable(course) else course
        return bench.of_gyro(bench.noise(COUNT, RATE, rng) + there)

    return Scenario(make, missing or None, verdict=None, **expected)


def telegraph(levels, amplitude, dwell, rng, count=COUNT):
    """Each switch to any of the other levels."""
    time, state, path = np.arange(count) / RATE, int(rng.integers(levels)), []
    switches = np.cumsum(rng.exponential(dwell, int(20 + 4 * time[-1] / dwell)))
    for _ in range(len(switches) + 1):
        path.append(state)
        state = (state + int(rng.integers(1, levels))) % levels
    return amplitude * (2 * np.array(path)[np.searchsorted(switches, time)] - (levels - 1))


def levels_of(levels, amplitude, dwell):
    course = telegraph(levels, amplitude, dwell, np.random.default_rng([4, levels, dwell]))
    near = {
        "telegraph_noise.levels": (levels, 0),
        "telegraph_noise.amplitude_dps": (amplitude, 0.06 * amplitude),
        "telegraph_noise.mean_dwell_s": (dwell, 0.5 * dwell),
    }
    return added(course, "telegraph_noise", seed=(3, levels, dwell), near=near)


def continuum(std, tau):
    def course(rng):
        decay = np.exp(-1 / RATE / tau)
        kicks = rng.standard_normal(COUNT)
        return std * signal.lfilter([np.sqrt(1 - decay**2)], [1, -decay], kicks)

    return added(course, "gauss_markov", seed=(5, tau))


def stepped(*steps):
    """Steps (time, size) of the bias."""
    near = {
        "bias_step.time_s": [(place, 4) for place, _ in steps],
        "bias_step.step_dps": [(size, 0.004) for _, size in steps],
    }
    course = sum(size * (place <= TIME) for place, size in steps)
    return added(course, *["bias_step"] * len(steps), seed=(4, len(steps)), near=near)


def visited(start, stop, f, size):
    """A machine that runs for a while."""
    off = (0.1 / (stop - start), 0.15 * size, 8, 8)
    near = {
        f"intermittent_line.{name}": (true, some)
        for name, true, some in zip(VISIT, (f, size, start, stop), off)
    }
    course = (start <= TIME) * (stop > TIME) * size * np.sin(2 * np.pi * f * TIME + 1)
    return added(course, "intermittent_line", seed=(7, int(start)), near=near)


def low_passed(share):
    """White noise behind SciPy's bilinear filter, in counts; without a model."""

    def make():
        rng = np.random.default_rng(round(1000 * share))
        white = 0.2 / 60 * 10 * rng.standard_normal(60000)
        passed = signal.lfilter(*signal.butter(1, share * 100, fs=100.0), white)
        return bench.of_gyro(np.round(passed / 0.005) * 0.005, 100.0)

    return Scenario(make, model=None, absent=("moving_average",), verdict=None)


WARM = ("temperature", {"coefficient_dps_per_degC": 0.02})
LATE = bench.model(heat.RATE)
LATE.terms.append(Term("temperature", {"coefficient_dps_per_degC": 0.012}))
G_X = {"coefficient_dps_per_g": 0.9, "axis": "x"}

SCENARIOS = {
    "clean": simulated(verdict="none"),
    "temperature": simulated(
        WARM, verdict="temperature", holds={"temperature.coefficient_dps_per_degC": 0.02}
    ),
    "line": simulated(
        ("sinusoid", {"frequency_hz": 0.7, "amplitude_dps": 0.02}),
        seconds=1200.0,
        holds={"sinusoid.amplitude_dps": 0.02, "sinusoid.frequency_hz": 0.7},
    ),
    "shocks": simulated(
        ("shocks", {"rate_per_hour": 20.0, "amplitude_dps": 0.5}),
        seed=2,
        holds={"shocks.rate_per_hour": 20.0, "shocks.amplitude_dps": 0.5},
    ),
    "strong vibration noise": simulated(
        ("vibration_noise", {"coefficient_dps_per_g": 2.0, "axis": "x"}), seed=6, seconds=7200.0
    ),
    "vibration noise beside noise with memory": simulated(
        ("vibration_noise", {"coefficient_dps_per_g": 0.8, "axis": "y"}),
        ("gauss_markov", {"std_dps": 0.006, "correlation_time_s": 8.0}),
        seed=11,
        seconds=7200.0,
    ),
    "levels beside flicker": simulated(
        ("telegraph_noise", {"amplitude_dps": 0.0075, "mean_dwell_s": 75.0}), seconds=7200.0
    ),
    "a continuum beside flicker": simulated(
        ("gauss_markov", {"std_dps": 0.0075, "correlation_time_s": 37.5}), seconds=7200.0
    ),
    "shocks beside a strong sensitivity": simulated(
        ("g_sensitivity", G_X),
        ("shocks", {"rate_per_hour": 30.0, "amplitude_dps": 0.6}),
        seconds=7200.0,
    ),
    # made by elsewhere.py; each of them was called something else once
    "low pass, bilinear": from_elsewhere("low_pass bilinear", 0, "low_pass"),
    "low pass, response": from_elsewhere("low_pass response", 0, "low_pass"),
    "low pass beside a ramp": from_elsewhere(
        "low_pass pole + rate_ramp", 1, "low_pass", "rate_ramp"
    ),
    "a fan": from_elsewhere("sinusoid fan", 0, *["sinusoid"] * 3),
    "a rising temperature": from_elsewhere("temperature ramp", 0, "temperature"),
    "fast telegraph": from_elsewhere("telegraph fast", 0, "telegraph_noise"),
    "vibration that starts suddenly": from_elsewhere(
        "vibration_rectification band", 1, "vibration_rectification"
    ),
    "vibration noise": from_elsewhere("vibration_noise white", 4, "vibration_noise"),
    # made by awkward.py
    "columns that move": from_awkward("clean decoys", 1, rate=20.0),
    "a line with a width": from_awkward("narrow_band", 1, seconds=600.0),
    "two taps": from_awkward("two_tap_average", 1, seconds=600.0),
    "second order": from_awkward("butterworth", 1, seconds=600.0),
    "turned by hand": from_awkward("motion_turned", 1, rate=20.0),
    "lost samples": from_awkward("line + lost_samples", 1, rate=20.0),
    **{
        f"a band beside a filter, {seed}": from_awkward(
            "low_band + butterworth",
            seed,
            seconds=600.0,
            scored=False,
            missing=("low_pass", "narrow_band"),
        )
        for seed in (1, 2, 3)
    },
    **{
        f"slow noise behind an average, {seed}": from_awkward(
            "gauss_markov + average_of_several",
            seed,
            seconds=900.0,
            scored=False,
            missing=("gauss_markov", "moving_average"),
        )
        for seed in (1, 2, 3, 4)
    },
    **{
        f"{case}, {seed}": from_awkward(case, seed, seconds=900.0, missing=("drifting_line",))
        for case in ("drifting_line", "drifting_as_it_warms")
        for seed in (1, 2)
    },
    **{
        f"{case}, {seed}": from_awkward(case, seed, seconds=300.0, missing=(), verdict="unknown")
        for case in ("dead_zone", "repeated_behind_counts")
        for seed in (1, 2, 3)
    },
    # made by heat.py
    "late heat, cycles": heated(
        "lag",
        "cycles",
        "temperature",
        near={"temperature.lag_s": (60, 25)},
        absent=("rate_random_walk",),
    ),
    "late heat, walk": heated(
        "lag",
        "walk",
        "temperature",
        near={"temperature.lag_s": (60, 25)},
        absent=("rate_random_walk",),
    ),
    "late heat, one cycle": heated("lag", "cycle", "temperature", verdict="temperature"),
    "a parabola": heated("square", "walk", "temperature_squared"),
    "hysteresis": heated(
        "hysteresis",
        "cycles",
        "temperature_hysteresis",
        near={"temperature_hysteresis.width_degC": (1.0, 0.3)},
    ),
    "a random walk": heated("walk", "cycles", "rate_random_walk", absent=("temperature",)),
    "noise that goes with the temperature": heated(
        "noise",
        "walk",
        "temperature_noise",
        near={"temperature_noise.relative_per_degC": (0.05, 0.01)},
    ),
    "a supply": heated("supply", "walk", "follows", near={"follows.column": "supply_V"}),
    "a neighbour": heated("leak", "walk", "follows", near={"follows.column": "gyro_x_dps"}),
    "a temperature of the model felt late": heated(
        "lag", "cycles", "temperature", seed=6, model=LATE
    ),
    "a tilt": limited(lambda: heat.tilted(4, 0.2), "g_sensitivity"),
    "noisy vibration": limited(lambda: heat.shaken(4, 0.15, noise=2.0), "vibration_noise"),
    "rectified vibration": limited(
        lambda: heat.shaken(4, 0.1, bias=5.0), "vibration_rectification"
    ),
    "warmth": limited(lambda: heat.heated(4, 0.16), "temperature"),
    "volts": limited(lambda: heat.supplied(4, 2.0), "follows"),
    # levels, steps and visits
    **{
        f"{levels} levels, {amplitude}": levels_of(levels, amplitude, dwell)
        for levels, amplitude, dwell in (
            (2, 0.008, 20),
            (3, 0.008, 20),
            (3, 0.006, 60),
            (4, 0.008, 20),
        )
    },
    "a continuum of 5 s": continuum(0.008, 5),
    "a continuum of 20 s": continuum(0.006, 20),
    "a step": stepped((700.0, 0.012)),
    "two steps": stepped((500.0, 0.015), (1400.0, -0.02)),
    "a slow walk": added(
        np.cumsum(np.random.default_rng(5).standard_normal(COUNT)) * 60 / 216000 / RATE**0.5,
        seed=(6, 16),
        absent=("bias_step",),
    ),
    "a ramp": added(100 / 3600**2 * TIME, seed=(6, 9), absent=("bias_step",)),
    "a warm-up": added(0.05 * np.exp(-TIME / 300), seed=(6, 7), absent=("bias_step",)),
    "a visit": visited(300.0, 700.0, 7.3, 0.01),
    "a short visit": visited(1500.0, 1520.0, 3.1, 0.05),
    "a steady line": added(0.01 * np.sin(2 * np.pi * 7.3 * TIME), "sinusoid", seed=(8,)),
    **{f"a cutoff at {share}": low_passed(share) for share in (0.03, 0.1, 0.2, 0.3, 0.42)},
}
# One of each way to find something; the quick gear leaves the others out.
QUICK = {
    *("clean", "temperature", "line", "turned by hand", "dead_zone, 1", "late heat, one cycle"),
    *("a temperature of the model felt late", "a random walk", "a step", "a visit"),
}
