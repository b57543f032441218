"""Effects on logged columns and the test for a common cause, in davarlab's own environment (inside_columns.py), and on real recordings."""

import os
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "build/venv-lab/bin/python"
ENVIRONMENT = {"PYTHONPATH": f"{ROOT / 'tools/lab'}:{ROOT / 'tests/lab'}", "DAVAR_LAB_LIBRARY": str(ROOT / "build/tools/tools/lab/libdavar_lab.so"),
               "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real"))
NEVER_A_SENSITIVITY = """
import sys
from davarlab import model
from davarlab.data import recording
from davarlab.candidates import common_cause
from davarlab.diagnosis import diagnose
from davarlab.inference.parts import Part
found = recording.read(sys.argv[1])
terms = [model.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 2.3}), model.Term("bias_instability", {"coefficient_deg_per_h": 30.0})]
state = diagnose.start(found, model.Model(found.rate_hz, "gyro_x_dps", terms))
for axis in "xyz":
    print(common_cause.judge(state.bench, state.parts, Part("g_sensitivity", {"axis": axis})).disagrees)
"""


def setUpModule():
    subprocess.run([ROOT / "tools/davarlab", "effects"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


class Columns(unittest.TestCase):
    def test_what_is_inside(self):
        done = subprocess.run([PYTHON, ROOT / "tests/lab/inside_columns.py"], env=ENVIRONMENT, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_the_drift_of_a_real_sensor_is_no_sensitivity_to_acceleration(self):
        for name in ("adis16405_run1_static.csv.gz", "adis16405_run4_knocks.csv.gz"):
            with self.subTest(name):
                if not (REAL / name).exists():
                    self.skipTest(f"{name} is not here")
                done = subprocess.run([PYTHON, "-c", NEVER_A_SENSITIVITY, REAL / name], env=ENVIRONMENT, text=True, stdout=subprocess.PIPE,
                                      stderr=subprocess.PIPE)
                self.assertEqual(done.stdout.split(), ["True"] * 3, done.stderr)


if __name__ == "__main__":
    unittest.main()
