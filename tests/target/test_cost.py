"""The cost of davar on each target stays within 2 % of docs/cost.json; the README shows that file;
the path of a sample has no forbidden operation.
"""

import json
import re
import sys
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import call_graph
import target_cost
import targets

WORSE = 1.02
PUSH = (
    "davar_push_q15",
    "davar_push_q31",
    "davar_cascade_push_q15",
    "davar_cascade_push_q31",
)
# The functions of the laws that a sample calls: push, place and judge of glr, judge of [SONG18].
LAW_FUNCTIONS = ("glr_push", "glr_place", "glr_judge", "judge_kurtosis", "judge_or", "judge_and")
GAPS = ("davar_q15_gap", "davar_q31_gap")
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

    def test_a_stride_costs_about_as_much_as_every_sample(self):
        """A stride of 2 copies the sums at every second sample."""
        for target, figures in self.recorded.items():
            single = figures["every_sample_instructions_per_sample"]
            for engine, most in (("auto2", 1.13), ("auto10", 1.1), ("auto60", 1.1)):
                with self.subTest(target=target, engine=engine):
                    self.assertLessEqual(
                        figures[f"{engine}_instructions_per_sample"], most * single
                    )
                    self.assertLessEqual(
                        figures[f"{engine}_worst_push_instructions"],
                        1.3 * figures["fixed_worst_push_instructions"],
                    )

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
                # Law glr passes a gap on with the first sample after it; a restart there divides.
                self.assertEqual([], call_graph.offences(target, where / "paths.elf", PUSH, GAPS))

    def test_the_check_of_the_path_finds_existing_calls(self):
        """The evaluation of a result divides in floating point, so the check must fail for it."""
        for target in targets.BARE:
            where = targets.build(target)
            with self.subTest(target=target):
                self.assertTrue(
                    call_graph.offences(target, where / "paths.elf", ("davar_fit_8_taus",))
                )

    def test_the_check_of_the_path_finds_a_division_in_any_function_of_a_law(self):
        for target in targets.BARE:
            image = targets.build(target) / "paths.elf"
            code = call_graph.disassembly(target, image)
            for function in LAW_FUNCTIONS:
                found = code[function]
                worse = code | {function: found._replace(operations=found.operations | {"udiv"})}
                with (
                    self.subTest(target=target, function=function),
                    mock.patch.object(call_graph, "disassembly", return_value=worse),
                ):
                    self.assertEqual(
                        [f"{target}: udiv in {function}"],
                        call_graph.offences(target, image, PUSH, GAPS),
                    )

    def test_the_check_of_the_path_follows_a_law_into_the_pipeline(self):
        """Only law glr can restart, which divides: it passes gaps on while it takes samples."""
        for target in targets.BARE:
            image = targets.build(target) / "paths.elf"
            with self.subTest(target=target):
                self.assertTrue(call_graph.offences(target, image, PUSH))

    def test_what_an_instruction_takes_of_the_stack(self):
        literals = {"r4": (1 << 32) - 612, "r3": 612}
        for line, taken in (
            ("push {r4, r5, lr}", 12),
            ("stmdb sp!, {r4-r7, lr}", 20),
            ("vpush {d8-d9}", 16),
            ("sub sp, #164 @ 0xa4", 164),
            ("sub.w sp, sp, #1264", 1264),
            ("str.w lr, [sp, #-8]!", 8),
            ("add sp, r4", 612),
            ("add sp, r3", 0),
            ("add sp,sp,-48", 48),
            ("c.addi16sp sp,-320", 320),
            ("add sp,sp,48", 0),
            ("sub sp,sp,t0", call_graph.UNBOUNDED),
            ("sub.w sp, sp, r3", call_graph.UNBOUNDED),
        ):
            with self.subTest(line=line):
                self.assertEqual(taken, call_graph.taken(line, literals))

    def test_no_bound_of_the_stack_without_an_end_or_a_goal(self):
        target = targets.BARE[0]
        image = targets.build(target) / "paths.elf"
        code = call_graph.disassembly(target, image)
        for goal in ("davar_push_q15", "a pointer"):
            step = code["push_steps"]
            worse = code | {"push_steps": step._replace(goals=step.goals | {goal})}
            with (
                self.subTest(goal=goal),
                mock.patch.object(call_graph, "disassembly", return_value=worse),
                self.assertRaisesRegex(targets.TargetError, f"push_steps > {goal}"),
            ):
                call_graph.stack(target, image, ("davar_push_q15",))

    def test_the_check_of_the_path_objects_to_other_pointers_and_absent_laws(self):
        target = targets.BARE[0]
        image = targets.build(target) / "paths.elf"
        laws = call_graph.tables(target, image)
        del laws["davar_law_or"]
        for name in laws:
            laws[name] = {}
        with mock.patch.object(call_graph, "tables", return_value=laws):
            found = call_graph.offences(target, image, PUSH, GAPS)
        self.assertIn(f"{target}: davar_law_or does not exist", found)
        self.assertTrue([line for line in found if "a pointer at offset" in line], found)


def figures_of(name):
    """{target: {figure: value}} of an image on every bare board."""
    figures = {}
    for target in targets.BARE:
        image = targets.build(target, image=name) / f"{name}.elf"
        status, output = targets.execute(target, image, shift=targets.counting_shift(target))
        assert status == 0, f"{target}: {output}"
        found = re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)
        figures[target] = {name: int(value) for name, value in found}
    return figures


# Instructions that a sample costs more with the cascade: mean of q15, worst of noise.
CASCADE_BUDGET = {"cortex-m4f": (25.0, 300), "cortex-m0": (40.0, 300)}
# ... and with davar/torn.h: mean and worst, as docs/FIRMWARE.md states them.
TORN_BUDGET = {"cortex-m4f": (56.0, 235), "cortex-m0": (78.0, 308)}


class CascadeCost(unittest.TestCase):
    """tests/target/cascade.c on every bare board."""

    @classmethod
    def setUpClass(cls):
        cls.figures = figures_of("cascade_cost")

    def test_a_sample_keeps_its_budget(self):
        for target, (mean, worst) in CASCADE_BUDGET.items():
            with self.subTest(target=target):
                figures = self.figures[target]
                self.assertLessEqual(figures["cascade_q15_narrow_push_x100"] / 100, mean)
                self.assertLessEqual(figures["cascade_q15_narrow_worst_push"], worst)

    def test_every_core_computes_the_same_bits(self):
        self.assertEqual(1, len({figures["cascade_checksum"] for figures in self.figures.values()}))

    def test_18_sizes_take_2016_bytes(self):
        for target, figures in self.figures.items():
            with self.subTest(target=target):
                self.assertEqual(2016, figures["cascade_memory_bytes"])


class TornCost(unittest.TestCase):
    """tests/target/torn.c on every bare board."""

    @classmethod
    def setUpClass(cls):
        cls.figures = figures_of("torn_cost")

    def test_a_sample_keeps_its_budget(self):
        for target, (mean, worst) in TORN_BUDGET.items():
            with self.subTest(target=target):
                figures = self.figures[target]
                self.assertLessEqual(figures["torn_push_x100"] / 100, mean)
                self.assertLessEqual(figures["torn_worst_push"], worst)

    def test_every_core_finds_the_same_samples(self):
        self.assertEqual(1, len({figures["torn_checksum"] for figures in self.figures.values()}))
        self.assertEqual({1}, {figures["torn_reads"] for figures in self.figures.values()})

    def test_an_axis_takes_20_bytes(self):
        for target, figures in self.figures.items():
            with self.subTest(target=target):
                self.assertEqual(20, figures["torn_t_bytes"])


# Instructions of a sample and of a block on a Cortex-M4F, and bytes, by the number of gyros:
# lib/src/select/DESIGN.md.
SELECT_BUDGET = {2: (115, 1119, 256), 3: (427, 2197, 420), 4: (604, 3505, 620)}


class SelectCost(unittest.TestCase):
    """tests/target/select.c on every bare board."""

    @classmethod
    def setUpClass(cls):
        cls.figures = figures_of("select_cost")

    def test_a_sample_and_a_block_keep_their_budget(self):
        figures = self.figures["cortex-m4f"]
        for gyros, (add, update, size) in SELECT_BUDGET.items():
            with self.subTest(gyros=gyros):
                self.assertLessEqual(figures[f"select{gyros}_add"], WORSE * add)
                self.assertLessEqual(figures[f"select{gyros}_update"], WORSE * update)
                self.assertEqual(figures[f"select{gyros}_bytes"], size)

    def test_every_core_computes_the_same_bits(self):
        self.assertEqual(1, len({figures["select_checksum"] for figures in self.figures.values()}))


if __name__ == "__main__":
    unittest.main()
