"""tools/davar-bench prints a table of figures for every program and target, never a traceback."""

import contextlib
import io
import json
import sys
import unittest
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import bench

ROOT = Path(__file__).resolve().parents[2]


class Shown(unittest.TestCase):
    def test_all_figures_and_those_of_a_machine_without_allantools(self):
        targets = json.loads((ROOT / "docs/cost.json").read_text(encoding="utf-8"))
        python = {"python_adev_1000": {"davar_ms": 1.0, "allantools_ms": 4.0, "ratio": 4.0}}
        for beside, figures in (
            (python, defaultdict(lambda: 2.0)),
            (None, defaultdict(lambda: 2.0, allantools_per_window_ns_per_sample=None)),
        ):
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                bench.show_all(figures, beside, targets)
            for target, values in targets.items():
                self.assertIn(
                    f"| {target} | {values['every_sample_instructions_per_sample']:.0f} |",
                    said.getvalue(),
                )
            self.assertEqual(beside is None, "not installed" in said.getvalue())


if __name__ == "__main__":
    unittest.main()
