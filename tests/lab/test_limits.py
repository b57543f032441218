"""Candidates whose coefficient no gyro has, or whose column is the noise of its own sensor, are not
added and the reason is reported. Effects of the size of data sheets are still added. Recordings are
made with numpy only.
"""

import re

import asking
import heat
import lab_bench
import numpy as np
import pytest
from davarlab.candidates import doubts, own_noise
from davarlab.candidates.candidate import Candidate
from davarlab.data import signals
from davarlab.data.recording import Recording
from davarlab.diagnosis import diagnose, fitting
from davarlab.effects import own, table
from davarlab.effects.base import INFINITE
from davarlab.errors import BadInput
from davarlab.inference.parts import Part

MODEL = lab_bench.model(heat.RATE)
SEEDS = (1, 2, 3)


def bench(columns):
    state = fitting.start(Recording(columns, heat.RATE), MODEL)
    return state.bench, state.parts


def doubted(columns, part):
    where, parts = bench(columns)
    return doubts.doubt(where, [], parts, Candidate(part.kind, part, 0.0, 0.0))


G = Part("g_sensitivity", {"axis": "x"})
STILL = Part("g_sensitivity", {"axis": "x"}, "still")  # without the noise of the accelerometer
RECTIFIED = Part("vibration_rectification", {"axis": "x"})
SUDDEN = Part("vibration_rectification", {"axis": "x"}, "sudden")
NOISY = Part("vibration_noise", {"axis": "x"})
WARM = Part("temperature", {"lag_s": 0.0})


def follows(name):
    return Part("follows", {"column": name, "lag_s": 0.0})


def test_the_size_is_that_of_the_recording():
    for made, part, size in (
        (heat.tilted(1, 0.8), STILL, 0.8),
        (heat.tilted(1, -6.0), STILL, -6.0),
        (heat.shaken(1, 0.1, bias=5.0), SUDDEN, 5.0),
        (heat.shaken(1, 0.1, noise=2.0), NOISY, 2.0),
        (heat.heated(1, 0.02), WARM, 0.02),
        (heat.supplied(1, 0.2), follows("supply_V"), 0.2),
    ):
        found = doubts.size_of(*bench(made), part)
        assert abs(found / size - 1) <= 0.15, part


@pytest.mark.slow
def test_a_size_above_the_limit_is_doubted_with_its_reason_and_one_below_is_not():
    for make, part, low, high, unit in (
        (heat.tilted, STILL, 0.2, 6.0, "deg/s/g"),
        (lambda seed, size: heat.shaken(seed, 0.1, bias=size), RECTIFIED, 5.0, 100.0, "deg/s/g^2"),
        (
            lambda seed, size: heat.shaken(seed, min(0.05, 0.3 / size), size),
            NOISY,
            2.0,
            60.0,
            "deg/s per g rms",
        ),
        (heat.heated, WARM, 0.3, 9.0, "deg/s/degC"),
        (heat.supplied, follows("supply_V"), 2.0, 1000.0, "deg/s per V"),
    ):
        for seed in SEEDS:
            why = doubted(make(seed, high), part)
            assert "is not physical" in why
            assert f"{part.effect.limit(part.shape):.3g} {unit}." in why
            assert re.search("Check the unit of (accel_x_g|temp_degC|supply_V)", why)
            assert "physical" not in doubted(make(seed, low), part)


def test_the_unit_of_a_column_that_is_followed_counts():
    milli = heat.supplied(1, 2.0, "supply_mV", 1e-3)
    assert "physical" not in doubted(milli, follows("supply_mV"))
    wrong = heat.supplied(1, 2.0, "supply_V", 1e3)  # kilovolts called volts
    assert "Check the unit of supply_V" in doubted(wrong, follows("supply_V"))
    unknown = heat.supplied(1, 1000.0, "current_A")
    assert "physical" not in doubted(unknown, follows("current_A"))


def test_every_effect_on_a_column_has_a_limit():
    for kind, effect in table.TABLE.items():
        if effect.needs:
            shape = {name: "x" for name in effect.shape_names if name == "axis"}
            assert effect.limit(shape) > 0, kind
            assert effect.limit(shape) < INFINITE, kind
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
    with asking.undone():
        own.load(lab.file("own.py", OWN.replace("MOST", '{"": 0.5}')))
        where, parts = bench(heat.supplied(1, 2.0))
        assert "is 0.5 deg/s/V" in doubts.of_size(where, parts, Part("supply"))
        where, parts = bench(heat.supplied(1, 0.2))
        assert doubts.of_size(where, parts, Part("supply")) == ""


@pytest.mark.parametrize("most", ['{"": "much"}', '{"": -1.0}', "0.5"])
def test_a_limit_that_is_no_number_is_refused(lab, most):
    with asking.undone(), pytest.raises(BadInput, match="own.py: supply: most"):
        own.load(lab.file("own.py", OWN.replace("MOST", most)))


def asked(columns, part):
    where, parts = bench(columns)
    return own_noise.doubt(where, parts, part) != ""


def test_a_column_of_white_noise_is_its_own_noise():
    for seed in range(8):
        found, rng = heat.still(seed)
        count = len(found["time_s"])
        found |= {
            "accel_x_g": 1e-4 * rng.standard_normal(count),
            "temp_degC": 25 + 0.02 * rng.standard_normal(count),
            "supply_V": 5 + 0.002 * rng.standard_normal(count),
        }
        where, parts = bench(found)
        for part in (G, RECTIFIED, NOISY, WARM, follows("supply_V")):
            for form in part.effect.forms:
                one = Part(part.kind, part.shape, form)
                why = own_noise.doubt(where, parts, one)
                assert "white noise of the sensor itself" in why, (seed, one)


@pytest.mark.slow
def test_columns_that_move_are_more_than_their_noise():
    for seed in range(8):
        assert not asked(heat.tilted(seed, 0.0), G)
        assert not asked(heat.shaken(seed, 0.01), G)
        assert not asked(heat.shaken(seed, 0.01), RECTIFIED)
        assert not asked(heat.shaken(seed, 0.01), NOISY)
        assert not asked(heat.make("none", "walk", seed, heat.SECONDS), WARM)
        assert not asked(heat.supplied(seed, 0.0), follows("supply_V"))


def test_tilts_are_no_vibration():
    for seed in SEEDS:
        assert asked(heat.tilted(seed, 0.0), RECTIFIED)
        assert asked(heat.tilted(seed, 0.0), NOISY)


def test_a_line_is_more_than_noise_wherever_it_is():
    for frequency in (0.3, 7.0, 24.0):
        found, _ = heat.still(1)
        wave = 0.004 * np.sin(2 * np.pi * frequency * found["time_s"])
        found["accel_x_g"] = found["accel_x_g"] + wave
        assert not asked(found, G), frequency


def test_a_column_of_few_counts_that_hardly_moves_is_no_error():
    found, _ = heat.still(1)
    found["accel_x_g"] = np.where(found["time_s"] > 900, 0.004, 0.0)
    assert not asked(found, G)


def test_noise_in_gyro_and_accelerometer_at_once_is_no_sensitivity():
    """A reference that both converters share: 6 deg/s/g on 0.1 mg."""
    for seed in SEEDS:
        found, rng = heat.still(seed)
        for axis in "xyz":
            found[f"accel_{axis}_g"] = 1e-4 * rng.standard_normal(len(found["time_s"]))
        found["gyro_z_dps"] = found["gyro_z_dps"] + 6.0 * found["accel_x_g"]
        said = diagnose.diagnose(Recording(found, heat.RATE), MODEL)
        assert "g_sensitivity" not in said.added
        assert "g_sensitivity" not in said.states[-1].model_kinds
        assert re.search(r"of 5|of 6|of 7|sensor itself", said.doubtful["g_sensitivity"])


@pytest.mark.slow
def test_a_rectification_of_the_noise_of_a_column_is_not_added():
    for seed in SEEDS:
        found, _ = heat.still(seed)
        square = signals.local_mean_square(found["accel_x_g"], int(2 * heat.RATE))
        found["gyro_z_dps"] = found["gyro_z_dps"] + 14000 * (square - square.mean())
        said = diagnose.diagnose(Recording(found, heat.RATE), MODEL)
        assert "vibration_rectification" not in said.states[-1].model_kinds
        assert "is not physical" in said.doubtful["vibration_rectification"]
