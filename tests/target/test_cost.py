"""The cost of davar on each target stays within 2 % of docs/cost.json; the README shows that file;
the path of a sample has no forbidden operation.
"""

import json
import re
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import target_cost
import targets

WORSE = 1.02
WITHOUT_DOUBLE_FPU = ("cortex-m0", "cortex-m3", "cortex-m4f", "cortex-m33", "rv32imac")


class Cost(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.recorded = json.loads(target_cost.RECORD.read_text(encoding="utf-8"))

    def test_no_figure_is_worse_than_recorded(self):
        for target in targets.BARE:
            measured = target_cost.measure(target)
            self.assertEqual(
                set(measured),
                set(self.recorded[target]),
                "renew with tools/davar-bench --targets --write",
            )
            for name, value in measured.items():
                with self.subTest(target=target, figure=name):
                    self.assertLessEqual(value, WORSE * self.recorded[target][name])
            with self.subTest(target=target, figure="floating point"):
                self.check_floating_point(target, targets.folder(target))

    def check_floating_point(self, target, where):
        """ARW with a plan of the host links no more floating-point code of the compiler than ADEV:
        none on a core without a double FPU.
        """
        names = {}
        for use in ("adev", "adev_arw"):
            found = target_cost.symbols(target, where / f"linked-{target_cost.LINKED[use][0]}.elf")
            names[use] = {
                name for name in found if re.match(r"__aeabi_[fd]|__\w*[sd]f(2|3|si|di)?$", name)
            }
        self.assertIn("davar_fit_white_ready_4_taus", found)
        self.assertEqual(names["adev"], names["adev_arw"])
        if target in WITHOUT_DOUBLE_FPU:
            self.assertEqual(set(), names["adev"])

    def test_readme_and_docs_show_the_recorded_tables(self):
        for table in target_cost.TABLES:
            with self.subTest(table=table.name):
                self.assertIn(
                    target_cost.enclosed(table, self.recorded),
                    table.page.read_text(encoding="utf-8"),
                )

    def test_a_sample_s_path_has_no_division_no_float_and_no_library_call(self):
        for target in targets.BARE:
            where = targets.build(target)
            with self.subTest(target=target):
                roots = ("davar_push_q15", "davar_push_q31")
                # Policy glr: a sample after a gap does the work of davar_gap in other policies; a
                # restart divides.
                self.assertEqual(
                    [],
                    target_cost.offences(target, where / "paths.elf", roots, gaps=("window_gap",)),
                )

    def test_the_check_of_the_path_finds_existing_calls(self):
        """The evaluation of a result divides in floating point, so the same check must fail for it."""
        for target in targets.BARE:
            where = targets.build(target)
            with self.subTest(target=target):
                self.assertTrue(
                    target_cost.offences(target, where / "paths.elf", ("davar_fit_8_taus",))
                )


if __name__ == "__main__":
    unittest.main()
