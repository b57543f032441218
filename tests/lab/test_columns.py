"""Effects on logged columns and the test for a common cause, against formulas of their own
(heat.py) and on real recordings.
"""

import os
from pathlib import Path
from types import SimpleNamespace

import heat
import lab_bench
import numpy as np
import pytest
from asking import ROOT
from davarlab import model, simulate
from davarlab.candidates import columns, common_cause, doubts
from davarlab.candidates.candidate import Candidate
from davarlab.data import recording as logged
from davarlab.data.observations import Observation
from davarlab.data.recording import Recording
from davarlab.diagnosis import combs, evidence, fitting
from davarlab.effects import columns as effects
from davarlab.errors import BadInput
from davarlab.inference import changes
from davarlab.inference.parts import Bench, Part

MODEL, BASE = lab_bench.model(heat.RATE), lab_bench.terms()
REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real"))
ALONG_X = Part("g_sensitivity", {"axis": "x"})


def recording(case, how, seed):
    return Recording(heat.make(case, how, seed), heat.RATE)


def lines(*frequencies):
    return [Part("sinusoid", {"frequency_hz": f}) for f in frequencies]


def test_play_is_the_chain_of_its_pushes():
    rng = np.random.default_rng(1)
    for count in (1, 2, 1000, 1023):
        x = np.cumsum(rng.standard_normal(count))
        np.testing.assert_allclose(effects.play(x, 3.0), heat.loop(x, 3.0), atol=1e-12)


def test_a_lag_is_late_by_its_time():
    x = np.linspace(0, 36, 180000)  # 0.01 a second
    assert abs(x[-1] - effects.lagged(x, 50.0, 60.0)[-1] - 0.6) < 5e-4
    assert abs(x[100] - effects.lagged(x, 50.0, 60.0, moving=True)[100] - 0.6) < 5e-4
    np.testing.assert_array_equal(effects.lagged(x, 50.0, 0.0), x)


def test_a_clock_or_a_copy_of_the_gyro_is_not_followed():
    found = recording("none", "walk", 1)
    found.columns |= {
        "index": np.arange(found.samples) * 1.0,
        "gyro_z_rad_s": found.columns["gyro_z_dps"] * np.pi / 180,
        "gyro_x_dps": np.random.default_rng(2).standard_normal(found.samples),
    }
    assert effects.may_follow(found, "gyro_z_dps") == ["gyro_x_dps"]


def sensor(**entry):
    return model.of(
        {"sensor": {"column": "gyro_z_dps", "rate_hz": 50.0}, "effect": [entry]}, "m.toml"
    )


def test_a_lag_may_be_left_out_and_a_column_is_a_word():
    assert sensor(kind="temperature", coefficient_dps_per_degC=0.01).terms[0].parameters == {
        "coefficient_dps_per_degC": 0.01
    }
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
    alone = heat.make("none", "walk", 3)
    drift = 0.05 * heat.walk(180000, np.random.default_rng(9)) / 200
    both = alone | {
        "gyro_z_dps": alone["gyro_z_dps"] + drift,
        "gyro_x_dps": heat.make("none", "walk", 4)["gyro_z_dps"] + drift,
    }
    assert "gyro_x_dps" in common_cause.several_axes(Recording(both, heat.RATE), "gyro_z_dps")
    assert "Shared drift: gyro_x_dps" in " ".join(
        evidence.notes(Recording(both, heat.RATE), MODEL, ["rate_random_walk"])
    )
    assert "drift" not in " ".join(
        evidence.notes(Recording(both, heat.RATE), MODEL, ["quantization"])
    )
    apart = alone | {"gyro_x_dps": heat.make("none", "walk", 4)["gyro_z_dps"]}
    assert common_cause.several_axes(Recording(apart, heat.RATE), "gyro_z_dps") == ""


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


def test_harmonics_of_something_slow_are_one_wave_and_those_of_a_machine_are_lines():
    bench = SimpleNamespace(
        recording=Recording({"time_s": np.arange(7200.0)}, 1.0), y=np.zeros(7200)
    )
    why, members = combs.one_signal(bench, lines(0.0125, 0.0375, 0.05137, 0.0625))
    assert "repeats every 80 s" in why
    assert [part.shape["frequency_hz"] for part in members] == [0.0125, 0.0375, 0.0625]
    for others in (
        (0.0125, 0.0375, 0.0643),
        (0.2, 0.4, 0.6),
        (0.0125, 0.0375),
        (0.0125, 0.1237, 0.3171),
        (0.0125, 0.0375, 0.0375),
    ):
        assert combs.one_signal(bench, lines(*others)) is None, others


def test_many_lines_on_one_comb_are_one_signal_and_lines_anywhere_are_lines():
    bench = SimpleNamespace(
        recording=Recording({"time_s": np.arange(180000) / 100}, 100.0), y=np.zeros(180000)
    )
    rng = np.random.default_rng(1)
    for _ in range(20):
        base, beat = rng.uniform(0.3, 45), rng.uniform(0.02, 0.1)
        teeth = base * np.append(rng.choice(np.arange(2, 9), 5, replace=False), 1)
        teeth[:2] += [beat, -beat]
        folded = np.abs(teeth - 100 * np.round(teeth / 100)) + rng.uniform(-1e-4, 1e-4, 6)
        assert len(combs.one_signal(bench, lines(*folded))[1]) == 6, teeth
    short = SimpleNamespace(recording=bench.recording, y=np.zeros(60000))
    for others in ((0.03, 7.13, 23.4), (0.005, 7.0, 13.0), (0.0, 7.0, 13.0)):
        assert combs.one_signal(short, lines(*others)) is None, others
    for count in (5, 8, 12, 20):
        for _ in range(20):
            anywhere = lines(*rng.uniform(0.15, 50, count))
            assert combs.one_signal(bench, anywhere) is None


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
