"""Effects on logged columns, the test for a common cause, and candidates that are doubted with the
reason: against formulas of their own (heat.py) and on real recordings.
"""

import os
import re
from pathlib import Path
from types import SimpleNamespace

import asking
import heat
import lab_bench
import numpy as np
import pytest
from davarlab import model, simulate
from davarlab.candidates import columns, common_cause, doubts, own_noise
from davarlab.candidates.candidate import Candidate
from davarlab.data import recording as logged
from davarlab.data import signals
from davarlab.data.observations import Observation
from davarlab.data.recording import Recording
from davarlab.diagnosis import combs, diagnose, evidence, fitting, improve
from davarlab.effects import own, table
from davarlab.effects.base import INFINITE
from davarlab.effects.columns import may_follow
from davarlab.errors import BadInput
from davarlab.inference import changes
from davarlab.inference.parts import Bench, Part

MODEL, BASE = lab_bench.model(heat.RATE), lab_bench.terms()
REAL = Path(os.environ.get("DAVAR_REAL_DATA", asking.ROOT.parent / "shared/data/real"))
ALONG_X = Part("g_sensitivity", {"axis": "x"})


def recording(case, how, seed):
    return Recording(heat.make(case, how, seed), heat.RATE)


def test_a_clock_or_a_copy_of_the_gyro_is_not_followed():
    found = recording("none", "walk", 1)
    found.columns |= {
        "index": np.arange(found.samples) * 1.0,
        "gyro_z_rad_s": found.columns["gyro_z_dps"] * np.pi / 180,
        "gyro_x_dps": np.random.default_rng(2).standard_normal(found.samples),
    }
    assert may_follow(found, "gyro_z_dps") == ["gyro_x_dps"]


@pytest.mark.parametrize(
    "wrong", ({"column": "gyro_z_dps"}, {"origin": 5.0}, {"origin": 0.0, "reference": 1e-300})
)
def test_noise_that_follows_a_column_needs_two_values_of_another_column(wrong):
    shape = {"column": "rpm", "origin": 0.0, "reference": 5.0, "power": 2.0, **wrong}
    with pytest.raises(BadInput, match="m.toml: noise_follows: .*(itself|differ from origin)"):
        sensor(kind="noise_follows", coefficient_dps=0.1, **shape)


def sensor(**entry):
    given = {"sensor": {"column": "gyro_z_dps", "rate_hz": 50.0}, "effect": [entry]}
    return model.from_toml(given, "m.toml")


def test_a_lag_may_be_left_out_and_a_column_is_a_word():
    given = {"coefficient_dps_per_degC": 0.01}
    assert sensor(kind="temperature", **given).terms[0].parameters == given
    found = sensor(kind="follows", column='V "raw"', coefficient=0.1, lag_s=3)
    assert 'column = "V \\"raw\\""' in model.text_of(found)
    for column in (3.0, "", "a,b", "gyro_z_dps"):
        with pytest.raises(BadInput, match="m.toml.*(name of a column|follow itself)"):
            sensor(kind="follows", column=column, coefficient=0.1)


def test_all_kinds_are_simulated_and_fitted():
    terms = BASE + [
        model.Term("temperature", {"coefficient_dps_per_degC": 0.02, "lag_s": 60.0}),
        model.Term("follows", {"coefficient": 0.1, "column": "supply_V"}),
        model.Term("temperature_noise", {"relative_per_degC": 0.08}),
    ]
    found = simulate.make(terms, 50.0, seed=4, duration_s=3600)
    state = fitting.judged(fitting.start(found, model.Model(50.0, "gyro_z_dps", terms)))
    shapes = {part.kind: part.shape for part in state.parts}
    assert abs(shapes["temperature_noise"]["relative_per_degC"] - 0.08) <= 0.01
    assert state.adequacy.p_value > 0.01
    assert 30 < shapes["temperature"]["lag_s"] < 120, shapes


@pytest.mark.slow
def test_columns_that_have_nothing_to_do_with_the_gyro_gain_nothing():
    """200 candidates, of which chance lets two pass 1 %."""
    few = 0
    for seed in range(25):
        columns_of = heat.make("none", ("cycles", "walk")[seed % 2], seed, 600) | {
            "supply_V": heat.walk(30000, np.random.default_rng(seed + 70)),
            "gyro_x_dps": heat.make("none", "walk", seed + 99, 600)["gyro_z_dps"],
        }
        found = Recording(columns_of, heat.RATE)
        state = fitting.start(found, MODEL)
        few += sum(
            one.log_p < np.log(0.01)
            for one in columns.tried(state.bench, state.parts, state.fit, "gyro_z_dps")
        )
    assert few <= 6


def judged(columns_of, part=ALONG_X):
    state = fitting.start(Recording(columns_of, heat.RATE), MODEL)
    return common_cause.judge(state.bench, state.parts, part)


def test_a_sensitivity_is_one_number_and_a_hidden_cause_is_not():
    for seed in (1, 2, 3):
        true, false = (judged(columns_of) for columns_of in heat.accelerometers(seed))
        assert (true.confirmed, true.disagrees, true.why) == (True, False, "")
        assert (false.confirmed, false.disagrees) == (False, True)
        assert "common cause" in false.why


def test_axes_that_drift_together_are_said_and_others_not():
    alone, other = (heat.make("none", "walk", seed)["gyro_z_dps"] for seed in (3, 4))
    drift = 0.05 * heat.walk(180000, np.random.default_rng(9)) / 200
    both, apart = (
        Recording({"gyro_z_dps": alone + one, "gyro_x_dps": other + one}, heat.RATE)
        for one in (drift, 0 * drift)
    )
    assert "gyro_x_dps" in common_cause.several_axes(both, "gyro_z_dps")
    assert common_cause.several_axes(apart, "gyro_z_dps") == ""
    for kind, said in (("rate_random_walk", True), ("quantization", False)):
        notes = " ".join(evidence.notes(both, MODEL, [kind]))
        assert ("Shared drift: gyro_x_dps" in notes, "drift" in notes) == (said, said)


def test_an_axis_that_shares_no_more_than_a_drift_is_not_followed():
    for seed in (3, 5, 7):
        alone, rng = heat.make("none", "walk", seed), np.random.default_rng(seed)
        drift = 1.5e-5 * heat.walk(180000, rng)
        noise = 4 * np.std(np.diff(alone["gyro_z_dps"])) * rng.standard_normal(180000)
        turned = drift + heat.make("none", "walk", seed + 1)["gyro_z_dps"]
        found = judged(
            alone | {"gyro_z_dps": alone["gyro_z_dps"] + drift + noise, "gyro_x_dps": turned},
            Part("follows", {"column": "gyro_x_dps", "lag_s": 0.0}),
        )
        assert (found.confirmed, found.disagrees) == (False, True), found
        assert "common cause" in found.why


def test_what_motion_leaves_behind_is_not_named_and_a_short_touch_forbids_nothing():
    touched, moved = ([Observation("motion", [[1.0, 2.0]], share, "")] for share in (0.005, 0.05))
    left = (Part("noise_step", {}), Part("vibration_noise", {"axis": "x"}), Part("shocks"))
    for part in left:
        assert "moved in 5 % of the record" in doubts.of_motion(moved, part)
        assert doubts.of_motion(touched, part) == ""
    follows = Part("follows", {"column": "supply_V", "lag_s": 0.0})
    for part in (ALONG_X, Part("narrow_band", {}), follows):
        assert doubts.of_motion(moved, part) == ""


def test_a_leak_is_small_and_a_turn_about_an_oblique_axis_is_not():
    rng, moved = np.random.default_rng(8), [Observation("motion", [[1.0, 2.0]], 0.05, "")]
    quiet, rocking = (
        heat.make("none", "walk", 8),
        np.sin(np.arange(180000) / heat.RATE) * (1 + 0.2 * rng.standard_normal(180000)),
    )
    for size, seen, column, named in (
        (0.02, moved, "gyro_x_dps", True),
        (0.15, moved, "gyro_x_dps", False),
        (0.15, [], "gyro_x_dps", True),
        (0.4, [], "gyro_x_dps", False),
        (0.02, [], "gyro_x_rad_s", True),
    ):
        part = Part("follows", {"column": column, "lag_s": 0.0})
        logged = {
            "gyro_z_dps": quiet["gyro_z_dps"] + size * rocking,
            column: np.radians(rocking) if "rad" in column else rocking,
        }
        state = fitting.start(Recording(quiet | logged, heat.RATE), MODEL)
        why = doubts.doubt(state.bench, seen, state.parts, Candidate("follows", part, 0.0, 0.0))
        assert ("rotates about an axis" in why) == (not named), why
        assert (why == "") == named, why


def one_signal(seconds, rate, frequencies):
    """What is said of these lines of a recording of so many seconds."""
    count = int(seconds * rate)
    made = Recording({"time_s": np.arange(count) / rate}, rate)
    bench = SimpleNamespace(recording=made, y=np.zeros(count))
    return combs.one_signal(bench, [Part("sinusoid", {"frequency_hz": f}) for f in frequencies])


def test_harmonics_of_something_slow_are_one_wave_and_those_of_a_machine_are_lines():
    why, members = one_signal(7200, 1.0, (0.0125, 0.0375, 0.05137, 0.0625))
    assert "repeats every 80 s" in why
    assert [part.shape["frequency_hz"] for part in members] == [0.0125, 0.0375, 0.0625]
    for seconds, rate, others in (
        (7200, 1.0, (0.0125, 0.0375, 0.0643)),
        (7200, 1.0, (0.2, 0.4, 0.6)),
        (7200, 1.0, (0.0125, 0.0375)),
        (7200, 1.0, (0.0125, 0.1237, 0.3171)),
        (7200, 1.0, (0.0125, 0.0375, 0.0375)),
        (600, 100.0, (0.03, 7.13, 23.4)),
        (600, 100.0, (0.005, 7.0, 13.0)),
        (600, 100.0, (0.0, 7.0, 13.0)),
    ):
        assert one_signal(seconds, rate, others) is None, others


def test_many_lines_on_one_comb_are_one_signal_and_lines_anywhere_are_lines():
    rng = np.random.default_rng(1)
    for _ in range(20):
        base, beat = rng.uniform(0.3, 45), rng.uniform(0.02, 0.1)
        teeth = base * np.append(rng.choice(np.arange(2, 9), 5, replace=False), 1)
        teeth[:2] += [beat, -beat]
        folded = np.abs(teeth - 100 * np.round(teeth / 100)) + rng.uniform(-1e-4, 1e-4, 6)
        assert len(one_signal(1800, 100.0, folded)[1]) == 6, teeth
        for count in (5, 8, 12, 20):
            assert one_signal(1800, 100.0, rng.uniform(0.15, 50, count)) is None


def test_levels_between_turns_are_those_of_the_orientation():
    for seed in range(6):
        rng, t = np.random.default_rng([9, seed]), np.arange(24000) / 20
        white = 0.002 * rng.standard_normal(len(t))
        turns = np.sort(rng.uniform(0.1, 0.9, 4)) * t[-1]
        level = 15 / 3600 * rng.choice([-1, -0.3, 0.4, 1], 5)[np.searchsorted(turns, t)]
        walk = np.cumsum(rng.standard_normal(len(t))) * 2e-5
        seen = [Observation("motion", [[at - 1, at + 1] for at in turns], 0.003, "")]
        for slow, of_turns in ((level, np.ptp(level) > 0), (walk, False)):
            y = white + slow
            bench = Bench(Recording({"gyro_z_dps": y}, 20.0), y)
            parts = [Part("angle_random_walk"), Part("bias_instability")]
            for part in (Part("rate_random_walk"), Part("bias_step", {"time_s": turns[1] + 2})):
                gain = bench.fit([*parts, part]).log_likelihood - bench.fit(parts).log_likelihood
                one = Candidate(part.kind, part, gain, -gain)
                if gain > 10:
                    said = doubts.of_turns(bench, seen, parts, one)
                    assert ("turned over" in said) == of_turns, (seed, part)


def test_a_touch_is_no_vibration():
    rng, calm = np.random.default_rng(4), np.ones(600)
    energy, shaken, touched = calm * rng.chisquare(100, 600) / 100, calm.copy(), calm.copy()
    shaken[200:260] = touched[300:302] = 3.0
    for variance, lasting in ((shaken, True), (touched, False)):
        blocks = changes.Blocks(energy * variance, 100, 1.0, 100.0)
        gain = changes.steady_gain(blocks, np.full(600, blocks.energy.mean()), variance)
        assert (gain > 20) == lasting, gain


@pytest.mark.slow
def test_the_drift_of_a_real_sensor_is_no_sensitivity_to_acceleration():
    for name in ("adis16405_run1_static.csv.gz", "adis16405_run4_knocks.csv.gz"):
        path = REAL / name
        if not path.exists():
            pytest.skip(f"{name} is not here")
        found = logged.read(path)
        state = fitting.start(found, lab_bench.model(found.rate_hz, 2.3, 30.0, "gyro_x_dps"))
        for axis in "xyz":
            part = Part("g_sensitivity", {"axis": axis})
            assert common_cause.judge(state.bench, state.parts, part).disagrees, axis


# Coefficients that no gyro has, and columns that are the noise of their own sensor.


SEEDS = (1, 2, 3)
STILL = Part("g_sensitivity", {"axis": "x"}, "still")  # without the noise of the accelerometer
RECTIFIED = Part("vibration_rectification", {"axis": "x"})
SUDDEN = Part("vibration_rectification", {"axis": "x"}, "sudden")
NOISY = Part("vibration_noise", {"axis": "x"})
WARM = Part("temperature", {"lag_s": 0.0})


def follows(name):
    return Part("follows", {"column": name, "lag_s": 0.0})


def rectified(seed, size):
    return heat.shaken(seed, 0.1, bias=size)


def noisy(seed, size):
    return heat.shaken(seed, min(0.05, 0.3 / size), size)


def benched(columns):
    state = fitting.start(Recording(columns, heat.RATE), MODEL)
    return state.bench, state.parts


def doubted(columns, part):
    where, parts = benched(columns)
    return doubts.doubt(where, [], parts, Candidate(part.kind, part, 0.0, 0.0))


@pytest.mark.parametrize(
    "make, part, size",
    [
        *((heat.tilted, STILL, size) for size in (0.8, -6.0)),
        (rectified, SUDDEN, 5.0),
        (lambda seed, size: heat.shaken(seed, 0.1, size), NOISY, 2.0),
        (heat.heated, WARM, 0.02),
        (heat.supplied, follows("supply_V"), 0.2),
    ],
)
def test_the_size_is_that_of_the_recording(make, part, size):
    assert abs(doubts.size_of(*benched(make(1, size)), part) / size - 1) <= 0.15


@pytest.mark.slow
@pytest.mark.parametrize(
    "make, part, low, high, unit",
    [
        (heat.tilted, STILL, 0.2, 6.0, "deg/s/g"),
        (rectified, RECTIFIED, 5.0, 100.0, "deg/s/g^2"),
        (noisy, NOISY, 2.0, 60.0, "deg/s per g rms"),
        (heat.heated, WARM, 0.3, 9.0, "deg/s/degC"),
        (heat.supplied, follows("supply_V"), 2.0, 1000.0, "deg/s per V"),
    ],
)
def test_a_size_above_the_limit_is_doubted_with_its_reason_and_one_below_is_not(
    make, part, low, high, unit
):
    for seed in SEEDS:
        why = doubted(make(seed, high), part)
        assert "is not physical" in why
        assert f"{part.effect.limit(part.shape):.3g} {unit}." in why
        assert re.search("Check the unit of (accel_x_g|temp_degC|supply_V)", why)
        assert "physical" not in doubted(make(seed, low), part)


@pytest.mark.parametrize(
    "column, size, unit, said",
    [
        ("supply_mV", 2.0, 1e-3, False),
        ("supply_V", 2.0, 1e3, True),  # kilovolts called volts
        ("current_A", 1000.0, 1.0, False),
    ],
)
def test_the_unit_of_a_column_that_is_followed_counts(column, size, unit, said):
    why = doubted(heat.supplied(1, size, column, unit), follows(column))
    assert ("physical" in why, f"Check the unit of {column}" in why) == (said, said)


def test_every_effect_on_a_column_has_a_limit():
    for kind, effect in table.TABLE.items():
        if effect.needs:
            shape = {name: "x" for name in effect.shape_names if name == "axis"}
            assert 0 < effect.limit(shape) < INFINITE, kind
    find = table.find("follows")
    assert find.limit({"column": "vdd_V"}) == 1000 * find.limit({"column": "vdd_mV"})
    assert find.limit({"column": "current"}) == INFINITE


OWN = """
from davarlab.effects.base import Effect, Parameter
SUPPLY = Effect("supply", "The bias follows the supply.",
                (Parameter("coefficient_dps_per_V", "deg/s/V", -1e9, 1e9),),
                "Change the supply.", "mean", "that of the voltage",
                regressor=lambda recording, shape: recording.column("supply_V"),
                needs=("supply_V",), most=MOST)
"""


def test_a_limit_of_an_own_effect_counts(lab):
    for most in ('{"": "much"}', '{"": -1.0}', "0.5"):
        with asking.undone(), pytest.raises(BadInput, match="own.py: supply: most"):
            own.load(lab.file("own.py", OWN.replace("MOST", most)))
    with asking.undone():
        own.load(lab.file("own.py", OWN.replace("MOST", '{"": 0.5}')))
        for size, said in ((2.0, True), (0.2, False)):
            why = doubts.of_size(*benched(heat.supplied(1, size)), Part("supply"))
            assert ("is 0.5 deg/s/V" in why, why != "") == (said, said)


def of_own_noise(columns, part):
    return own_noise.doubt(*benched(columns), part)


def test_a_column_of_white_noise_is_its_own_noise():
    for seed in range(8):
        found, rng = heat.still(seed)
        for name, level, size in (
            ("accel_x_g", 0, 1e-4),
            ("temp_degC", 25, 0.02),
            ("supply_V", 5, 0.002),
        ):
            found[name] = level + size * rng.standard_normal(len(found["time_s"]))
        where, parts = benched(found)
        for part in (ALONG_X, RECTIFIED, NOISY, WARM, follows("supply_V")):
            for form in part.effect.forms:
                one = Part(part.kind, part.shape, form)
                why = own_noise.doubt(where, parts, one)
                assert "white noise of the sensor itself" in why, (seed, one)


@pytest.mark.slow
def test_columns_that_move_are_more_than_their_noise_but_a_tilt_is_no_vibration():
    for seed in range(8):
        shaken, tilted = heat.shaken(seed, 0.01), heat.tilted(seed, 0.0)
        for made, part, noise in (
            *((shaken, part, False) for part in (ALONG_X, RECTIFIED, NOISY)),
            *((tilted, part, part is not ALONG_X) for part in (ALONG_X, RECTIFIED, NOISY)),
            (heat.make("none", "walk", seed, heat.SECONDS), WARM, False),
            (heat.supplied(seed, 0.0), follows("supply_V"), False),
        ):
            assert bool(of_own_noise(made, part)) == noise, (seed, part)


def test_a_line_wherever_it_is_and_one_count_are_more_than_noise():
    found, _ = heat.still(1)
    t = found["time_s"]
    lines = (found["accel_x_g"] + 0.004 * np.sin(2 * np.pi * f * t) for f in (0.3, 7.0, 24.0))
    for x in (*lines, np.where(t > 900, 0.004, 0.0)):
        assert not of_own_noise({**found, "accel_x_g": x}, ALONG_X)


@pytest.mark.parametrize("seed", SEEDS)
def test_noise_in_gyro_and_accelerometer_at_once_is_no_sensitivity(seed):
    """A reference that both converters share: 6 deg/s/g on 0.1 mg."""
    found, rng = heat.still(seed)
    for axis in "xyz":
        found[f"accel_{axis}_g"] = 1e-4 * rng.standard_normal(len(found["time_s"]))
    found["gyro_z_dps"] = found["gyro_z_dps"] + 6.0 * found["accel_x_g"]
    said = diagnose.diagnose(Recording(found, heat.RATE), MODEL)
    assert "g_sensitivity" not in {*said.added, *said.states[-1].model_kinds}
    assert re.search(r"of 5|of 6|of 7|sensor itself", said.doubtful["g_sensitivity"])


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_a_rectification_of_the_noise_of_a_column_is_not_added(seed):
    found, _ = heat.still(seed)
    square = signals.local_mean_square(found["accel_x_g"], int(2 * heat.RATE))
    found["gyro_z_dps"] = found["gyro_z_dps"] + 14000 * (square - square.mean())
    said = diagnose.diagnose(Recording(found, heat.RATE), MODEL)
    assert "vibration_rectification" not in said.states[-1].model_kinds
    assert "is not physical" in said.doubtful["vibration_rectification"]


# Noise that follows a column: laws of the true noise, of which davarlab knows none.

NOISE_S, NOISE_RATE = 1800, 50.0


def logged_with_noise(seed, law):
    rng, t = np.random.default_rng([seed, 21]), np.arange(NOISE_S * 50) / NOISE_RATE
    rest = rng.normal(size=(5, len(t)))
    found = {
        "rpm": np.clip(3000 + 2500 * np.sin(2 * np.pi * t / 400) + 50 * rest[0], 0, None),
        "heater_A": 0.35 + 0.8 * (np.sin(2 * np.pi * t / 217) > 0.3) + 0.02 * rest[1],
        "supply_V": 5 - 0.4 * t / NOISE_S + 0.003 * rest[2],
        "load": 0.05 * np.cumsum(rest[3]),
    }
    made = lab_bench.of_gyro(0.035 * rest[4] * law(found, t))
    made.columns.update(found)
    return made


NOISE_LAWS = {
    "rpm": lambda of, t: 1 + (of["rpm"] / 4000) ** 2,
    "heater_A": lambda of, t: 1 + 0.5 * (of["heater_A"] > 0.75),
    "supply_V": lambda of, t: 1 + 1.5 * (5 - of["supply_V"]) / 0.4,
    "": lambda of, t: np.ones_like(t),
    "a step": lambda of, t: 1 + 0.5 * ((t > 700) & (t < 1100)),
}


@pytest.mark.parametrize("name", NOISE_LAWS)
def test_the_column_that_the_noise_follows_is_named(name):
    for seed in range(3):
        made = logged_with_noise(seed, NOISE_LAWS[name])
        found = improve.improve(made, model.first(made.rate_hz, "gyro_z_dps"))
        wanted = {"": [], "a step": ["noise_step"]}.get(name, ["noise_follows"])
        assert (found.added, found.judgement.adequate) == (wanted, True)
        if name in made.columns:
            (part,) = (part for part in found.state.parts if part.kind == "noise_follows")
            assert part.shape["column"] == name
            again = improve.fit(made, found.model)
            assert again[0].judgement.adequate  # the model file says all of it


@pytest.mark.parametrize("period_s", (400.0, 0.77))
def test_noise_that_follows_a_column_is_simulated_and_measured_alike(period_s):
    """Also of a column that is faster than the blocks whose energy is compared."""
    made = logged_with_noise(7, NOISE_LAWS[""])
    t = np.arange(made.samples) / NOISE_RATE
    made.columns["rpm"] = 2700 * (1 + np.sin(2 * np.pi * t / period_s)) * (t > NOISE_S / 2)
    shape = {"column": "rpm", "origin": 0.0, "reference": 5500.0, "power": 3.0}
    effect = table.find("noise_follows")
    for size in (0.02, 0.06):
        rng = np.random.default_rng([int(100 * size), 22])
        added = effect.simulate(made, {**shape, "coefficient_dps": size}, rng, None)
        again = Recording(made.columns | {"gyro_z_dps": made.columns["gyro_z_dps"] + added}, 50.0)
        given = model.from_toml(
            {
                "sensor": {"column": "gyro_z_dps", "rate_hz": 50.0},
                "effect": [
                    {"kind": "angle_random_walk", "coefficient_deg_per_sqrt_h": 0.3},
                    {"kind": "noise_follows", "coefficient_dps": 0.04, **shape},
                ],
            },
            "m.toml",
        )
        _, _, entries = improve.fit(again, given)
        found = entries[1]["coefficient_dps"]
        assert found.low - 0.02 * size < size < found.high + 0.02 * size
