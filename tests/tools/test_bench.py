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
        csv = {"rows, ns": {"davar-sim": 70.0, "wc -l": 1.4}}
        python = {"record, ms": {"davar": 1.0, "numba": None, "AllanTools": 4.0}}
        for beside, figures in (
            (None, defaultdict(lambda: 2.0)),
            (python, defaultdict(lambda: 2.0, numba_ns_per_sample=None)),
            (None, defaultdict(lambda: 2.0, allantools_per_window_ns_per_sample=None)),
        ):
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                bench.show_all(figures, csv, beside, targets)
            for target, values in targets.items():
                self.assertIn(
                    f"| {target} | {values['every_sample_instructions_per_sample']:.0f} |",
                    said.getvalue(),
                )
            absent = beside is not None or None in figures.values()
            self.assertEqual(absent, "not installed" in said.getvalue())
