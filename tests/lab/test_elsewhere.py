"""davarlab on recordings that its own simulator did not make (elsewhere.py); each of them was
called something else once.
"""

import tempfile
import unittest
from pathlib import Path

import asking
import elsewhere

MODEL = """[sensor]
rate_hz = 50.0
column = "gyro_z_dps"
[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 0.3
[[effect]]
kind = "bias_instability"
coefficient_deg_per_h = 5.0
"""


class Elsewhere(unittest.TestCase):
    def diagnosed(self, case, seed):
        with tempfile.TemporaryDirectory() as folder:
            recording, model = Path(folder) / "rec.csv", Path(folder) / "model.toml"
            model.write_text(MODEL)
            elsewhere.write(elsewhere.recording(case, seed)[0], recording)
            found, status, wrong, _ = asking.ask(["diagnose", recording, "-m", model])
        self.assertEqual((0, ""), (status, wrong))
        return "unknown" if found["verdict"] == "unknown" else found["missing"]

    def test_the_response_of_a_low_pass_is_that_of_the_sensor_not_of_the_simulator(self):
        for way in ("bilinear", "response"):
            self.assertEqual(self.diagnosed(f"low_pass {way}", 0), ["low_pass"])

    def test_a_low_pass_is_asked_again_for_its_response_once_the_ramp_is_known(self):
        self.assertEqual(self.diagnosed("low_pass pole + rate_ramp", 1), ["low_pass", "rate_ramp"])

    def test_a_fan_has_harmonics(self):
        self.assertEqual(self.diagnosed("sinusoid fan", 0), ["sinusoid"] * 3)

    def test_a_temperature_that_rises_steadily_is_still_the_temperature(self):
        self.assertEqual(self.diagnosed("temperature ramp", 0), ["temperature"])

    def test_levels_that_switch_fast_leave_no_doubt_behind_that_looks_like_more(self):
        self.assertEqual(self.diagnosed("telegraph fast", 0), ["telegraph_noise"])

    def test_vibration_that_starts_suddenly_rectifies_suddenly(self):
        self.assertEqual(
            self.diagnosed("vibration_rectification band", 1), ["vibration_rectification"]
        )

    def test_the_level_of_vibration_is_not_that_of_a_single_second(self):
        self.assertEqual(self.diagnosed("vibration_noise white", 4), ["vibration_noise"])


if __name__ == "__main__":
    unittest.main()
