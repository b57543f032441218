"""The bundled recording equals its script's output, is small, and states that it is simulated."""

import gzip
import runpy
import unittest
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "data"
BUNDLED = DATA / "demo_disturbance.csv.gz"


class DemoData(unittest.TestCase):
    def test_the_script_makes_the_same_recording(self):
        made = runpy.run_path(str(DATA / "make_demo.py"))["content"]()
        # The text must agree; how well zlib packs it may differ between versions.
        self.assertEqual(gzip.decompress(BUNDLED.read_bytes()), gzip.decompress(made))

    def test_it_is_small_and_states_that_it_is_simulated(self):
        self.assertLess(BUNDLED.stat().st_size, 300_000)
        self.assertIn("SIMULATED", gzip.decompress(BUNDLED.read_bytes()).decode().splitlines()[0])
