"""Candidates whose coefficient no gyro has, or whose column is the noise of its own sensor, are not
added and the reason is reported. Effects of the size of data sheets are still added. Recordings are
made with numpy only.
"""

import unittest

import heat
import numpy as np
from davarlab import model
from davarlab.candidates import doubts, own_noise
from davarlab.candidates.candidate import Candidate
from davarlab.data import signals
from davarlab.data.recording import Recording
from davarlab.diagnosis import diagnose
from davarlab.diagnosis import state as state_of
from davarlab.effects import own, table
from davarlab.effects.base import INFINITE
from davarlab.errors import BadInput
from davarlab.inference.parts import Part
from test_lab import Folder

MODEL = model.Model(
    heat.RATE,
    "gyro_z_dps",
    [
        model.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3}),
        model.Term("bias_instability", {"coefficient_deg_per_h": 5.0}),
    ],
)
SECONDS = 1800
SEEDS = (1, 2, 3)


def still(seed):
    """A gyro at rest beside the noise of an accelerometer of 2 mg, and a random generator."""
    found, rng = heat.make("none", "walk", seed, SECONDS), np.random.default_rng([seed, 33])
    count = len(found["time_s"])
    return found | {f"accel_{axis}_g": 0.002 * rng.standard_normal(count) for axis in "xyz"}, rng


def tilted(seed, size):
    """Slow tilts of 10 mg."""
    found, rng = still(seed)
    for axis in "xyz":
        tilt = heat.walk(len(found["time_s"]), rng)
        found[f"accel_{axis}_g"] += 0.01 * tilt / tilt.std()
        if axis == "x":
            found["gyro_z_dps"] = found["gyro_z_dps"] + size * 0.01 * tilt / tilt.std()
    return found


def shaken(seed, level, noise=0.0, bias=0.0):
    """Three bursts of white vibration along x. noise: deg/s per g rms; bias: deg/s/g^2."""
    found, rng = still(seed)
    t = found["time_s"]
    on = sum(
        ((t > start * SECONDS) & (t < (start + 0.08) * SECONDS)).astype(float)
        for start in (0.15, 0.45, 0.8)
    )
    found["accel_x_g"] = found["accel_x_g"] + level * on * rng.standard_normal(len(t))
    found["gyro_z_dps"] = (
        found["gyro_z_dps"]
        + noise * level * on * rng.standard_normal(len(t))
        + bias * level**2 * on
    )
    return found


def heated(seed, size):
    found = heat.make("none", "cycles", seed, SECONDS)
    rng, t = np.random.default_rng([seed, 34]), found["time_s"]
    warm = np.sin(2 * np.pi * 4 * t / t[-1] + rng.uniform(0, 6))
    return found | {
        "temp_degC": 25 + warm / max(1.0, size) + 1e-4 * rng.standard_normal(len(t)),
        "gyro_z_dps": found["gyro_z_dps"] + size * warm / max(1.0, size),
    }


def supplied(seed, size, name="supply_V", unit=1.0):
    found, rng = still(seed)
    volts = heat.walk(len(found["time_s"]), rng)
    volts *= 0.05 / volts.std() / max(1.0, size)
    return found | {
        name: (5 + volts + 1e-6 * rng.standard_normal(len(volts))) / unit,
        "gyro_z_dps": found["gyro_z_dps"] + size * volts,
    }


def bench(columns):
    state = state_of.start(Recording(columns, heat.RATE), MODEL)
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


class Sizes(unittest.TestCase):
    def test_the_size_is_that_of_the_recording(self):
        for made, part, size in (
            (tilted(1, 0.8), STILL, 0.8),
            (tilted(1, -6.0), STILL, -6.0),
            (shaken(1, 0.1, bias=5.0), SUDDEN, 5.0),
            (shaken(1, 0.1, noise=2.0), NOISY, 2.0),
            (heated(1, 0.02), WARM, 0.02),
            (supplied(1, 0.2), follows("supply_V"), 0.2),
        ):
            found = doubts.size_of(*bench(made), part)
            self.assertAlmostEqual(found / size, 1, delta=0.15, msg=part)

    def test_a_size_above_the_limit_is_doubted_with_its_reason_and_one_below_is_not(self):
        for make, part, low, high, unit in (
            (tilted, STILL, 0.2, 6.0, "deg/s/g"),
            (lambda seed, size: shaken(seed, 0.1, bias=size), RECTIFIED, 5.0, 100.0, "deg/s/g^2"),
            (
                lambda seed, size: shaken(seed, min(0.05, 0.3 / size), size),
                NOISY,
                2.0,
                60.0,
                "deg/s per g rms",
            ),
            (heated, WARM, 0.3, 9.0, "deg/s/degC"),
            (supplied, follows("supply_V"), 2.0, 1000.0, "deg/s per V"),
        ):
            for seed in SEEDS:
                with self.subTest(part.kind, seed=seed):
                    why = doubted(make(seed, high), part)
                    self.assertIn("is not physical", why)
                    self.assertIn(f"{part.effect.limit(part.shape):.3g} {unit}.", why)
                    self.assertRegex(why, "Check the unit of (accel_x_g|temp_degC|supply_V)")
                    self.assertNotIn("physical", doubted(make(seed, low), part))

    def test_the_unit_of_a_column_that_is_followed_counts(self):
        milli = supplied(1, 2.0, "supply_mV", 1e-3)
        self.assertNotIn("physical", doubted(milli, follows("supply_mV")))
        wrong = supplied(1, 2.0, "supply_V", 1e3)  # kilovolts called volts
        self.assertIn("Check the unit of supply_V", doubted(wrong, follows("supply_V")))
        unknown = supplied(1, 1000.0, "current_A")
        self.assertNotIn("physical", doubted(unknown, follows("current_A")))

    def test_every_effect_on_a_column_has_a_limit(self):
        for kind, effect in table.TABLE.items():
            if effect.needs:
                shape = {name: "x" for name in effect.shape_names if name == "axis"}
                self.assertLess(0, effect.limit(shape), kind)
                self.assertLess(effect.limit(shape), INFINITE, kind)
        find = table.find("follows")
        self.assertEqual(find.limit({"column": "vdd_V"}), 1000 * find.limit({"column": "vdd_mV"}))
        self.assertEqual(find.limit({"column": "current"}), INFINITE)


class OwnEffects(Folder):
    FORM = """
from davarlab.effects.base import Effect, Parameter
SUPPLY = Effect("supply", "The bias follows the supply.",
                (Parameter("coefficient_dps_per_V", "deg/s/V", -1e9, 1e9),),
                "Change the supply.", "mean", "that of the voltage",
                regressor=lambda recording, shape: recording.column("supply_V"),
                needs=("supply_V",), most=MOST)
"""

    def loaded(self, most):
        own.load(self.file("own.py", self.FORM.replace("MOST", most)))
        self.addCleanup(table.TABLE.pop, "supply")

    def test_a_limit_of_an_own_effect_counts(self):
        self.loaded('{"": 0.5}')
        where, parts = bench(supplied(1, 2.0))
        self.assertIn("is 0.5 deg/s/V", doubts.of_size(where, parts, Part("supply")))
        where, parts = bench(supplied(1, 0.2))
        self.assertEqual(doubts.of_size(where, parts, Part("supply")), "")

    def test_a_limit_that_is_no_number_is_refused(self):
        for most in ('{"": "much"}', '{"": -1.0}', "0.5"):
            with self.assertRaisesRegex(BadInput, "own.py: supply: most"):
                self.loaded(most)


class OwnNoise(unittest.TestCase):
    def asked(self, columns, part):
        where, parts = bench(columns)
        return own_noise.doubt(where, parts, part) != ""

    def test_a_column_of_white_noise_is_its_own_noise(self):
        for seed in range(8):
            found, rng = still(seed)
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
                    self.assertIn("white noise of the sensor itself", why, (seed, one))

    def test_columns_that_move_are_more_than_their_noise(self):
        for seed in range(8):
            self.assertFalse(self.asked(tilted(seed, 0.0), G))
            self.assertFalse(self.asked(shaken(seed, 0.01), G))
            self.assertFalse(self.asked(shaken(seed, 0.01), RECTIFIED))
            self.assertFalse(self.asked(shaken(seed, 0.01), NOISY))
            self.assertFalse(self.asked(heat.make("none", "walk", seed, SECONDS), WARM))
            self.assertFalse(self.asked(supplied(seed, 0.0), follows("supply_V")))

    def test_tilts_are_no_vibration(self):
        for seed in SEEDS:
            self.assertTrue(self.asked(tilted(seed, 0.0), RECTIFIED))
            self.assertTrue(self.asked(tilted(seed, 0.0), NOISY))

    def test_a_line_is_more_than_noise_wherever_it_is(self):
        for frequency in (0.3, 7.0, 24.0):
            found, _ = still(1)
            wave = 0.004 * np.sin(2 * np.pi * frequency * found["time_s"])
            found["accel_x_g"] = found["accel_x_g"] + wave
            self.assertFalse(self.asked(found, G), frequency)

    def test_a_column_of_few_counts_that_hardly_moves_is_no_error(self):
        found, _ = still(1)
        found["accel_x_g"] = np.where(found["time_s"] > 900, 0.004, 0.0)
        self.assertFalse(self.asked(found, G))


class Verdicts(unittest.TestCase):
    def test_noise_in_gyro_and_accelerometer_at_once_is_no_sensitivity(self):
        """A reference that both converters share: 6 deg/s/g on 0.1 mg."""
        for seed in SEEDS:
            found, rng = still(seed)
            for axis in "xyz":
                found[f"accel_{axis}_g"] = 1e-4 * rng.standard_normal(len(found["time_s"]))
            found["gyro_z_dps"] = found["gyro_z_dps"] + 6.0 * found["accel_x_g"]
            said = diagnose.diagnose(Recording(found, heat.RATE), MODEL)
            self.assertNotIn("g_sensitivity", said.added)
            self.assertNotIn("g_sensitivity", said.states[-1].model_kinds)
            self.assertRegex(said.doubtful["g_sensitivity"], r"of 5|of 6|of 7|sensor itself")

    def test_a_rectification_of_the_noise_of_a_column_is_not_added(self):
        for seed in SEEDS:
            found, _ = still(seed)
            square = signals.local_mean_square(found["accel_x_g"], int(2 * heat.RATE))
            found["gyro_z_dps"] = found["gyro_z_dps"] + 14000 * (square - square.mean())
            said = diagnose.diagnose(Recording(found, heat.RATE), MODEL)
            self.assertNotIn("vibration_rectification", said.states[-1].model_kinds)
            self.assertIn("is not physical", said.doubtful["vibration_rectification"])

    def test_effects_of_the_size_of_data_sheets_are_added(self):
        for made, kind in (
            (tilted(4, 0.2), "g_sensitivity"),
            (shaken(4, 0.15, noise=2.0), "vibration_noise"),
            (shaken(4, 0.1, bias=5.0), "vibration_rectification"),
            (heated(4, 0.16), "temperature"),
            (supplied(4, 2.0), "follows"),
        ):
            said = diagnose.diagnose(Recording(made, heat.RATE), MODEL)
            self.assertIn(kind, said.added, said.doubtful)


if __name__ == "__main__":
    unittest.main()
