"""davarlab on recordings that its own simulator did not make (elsewhere.py); each of them was called something else once."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "build/venv-lab/bin/python"
ENVIRONMENT = {"PYTHONPATH": ROOT / "tools/lab", "DAVAR_LAB_LIBRARY": ROOT / "build/tools/tools/lab/libdavar_lab.so"}
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


def setUpModule():
    subprocess.run([ROOT / "tools/davarlab", "effects"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


class Elsewhere(unittest.TestCase):
    def diagnosed(self, case, seed):
        with tempfile.TemporaryDirectory() as folder:
            recording, model = Path(folder) / "rec.csv", Path(folder) / "model.toml"
            model.write_text(MODEL)
            subprocess.run([PYTHON, ROOT / "tests/lab/elsewhere.py", case, str(seed), recording], check=True)
            done = subprocess.run([ROOT / "tools/davarlab", "diagnose", recording, "-m", model, "--json"], text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)
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

    def test_an_angle_in_whole_counts_is_quantization_and_nothing_unknown(self):
        self.assertEqual(self.diagnosed("quantization", 0), ["quantization"])

    def test_a_rate_in_coarse_counts_lacks_nothing(self):
        self.assertEqual(self.diagnosed("clean coarse lsb", 2), [])

    def test_levels_that_switch_fast_leave_no_doubt_behind_that_looks_like_more(self):
        self.assertEqual(self.diagnosed("telegraph fast", 0), ["telegraph_noise"])

    def test_vibration_that_starts_suddenly_rectifies_suddenly(self):
        self.assertEqual(self.diagnosed("vibration_rectification band", 1), ["vibration_rectification"])

    def test_the_level_of_vibration_is_not_that_of_a_single_second(self):
        self.assertEqual(self.diagnosed("vibration_noise white", 4), ["vibration_noise"])


class Inside(unittest.TestCase):
    def test_small_things_against_brute_force(self):
        self.passes("inside.py")

    def test_what_is_said_of_made_up_results(self):
        self.passes("saying.py")

    def passes(self, name):
        done = subprocess.run([PYTHON, ROOT / "tests/lab" / name], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env={name: str(value) for name, value in ENVIRONMENT.items()})
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
