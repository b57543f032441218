"""The cost of davar on each target stays within 2 % of docs/cost.json; the README shows that file;
the path of a sample has no forbidden operation.
"""

import json
import re

import call_graph
import pytest
import target_cost
import targets
from on_boards import IN_CI, REFERENCE, figures_of, on_every_board

WORSE = 1.02
PUSH = ("davar_push_q15", "davar_push_q31", "davar_cascade_push_q15", "davar_cascade_push_q31")
# The functions of the laws that a sample calls: push, place and judge of glr, judge of [SONG18].
LAW_FUNCTIONS = ("glr_push", "glr_place", "glr_judge", "judge_kurtosis", "judge_or", "judge_and")
# Law glr passes a gap on with the first sample after it; a restart there divides.
GAPS = ("davar_q15_gap", "davar_q31_gap")
WITHOUT_DOUBLE_FPU = ("cortex-m0", "cortex-m3", "cortex-m4f", "cortex-m33", "rv32imac")
RECORDED = json.loads(target_cost.RECORD.read_text(encoding="utf-8"))


@on_every_board
def test_no_figure_is_worse_than_recorded(target):
    """Nor does ARW with a plan of the host link more floating-point code of the compiler than ADEV:
    none on a core without a double FPU.
    """
    measured, recorded = target_cost.measure(target), RECORDED[target]
    assert set(measured) == set(recorded), "renew with tools/davar-bench --targets --write"
    worse = {name: value for name, value in measured.items() if value > WORSE * recorded[name]}
    assert worse == {}
    linked = []
    for use in ("adev", "adev_arw"):
        image = targets.folder(target) / f"linked-{target_cost.LINKED[use][0]}.elf"
        linked.append(set(target_cost.symbols(target, image)))
    of_adev, of_arw = (
        {name for name in names if re.match(r"__aeabi_[fd]|__\w*[sd]f(2|3|si|di)?$", name)}
        for names in linked
    )
    assert "davar_fit_white_ready_4_taus" in linked[1]
    assert of_adev == of_arw
    assert target not in WITHOUT_DOUBLE_FPU or of_adev == set()


@pytest.mark.parametrize("target", RECORDED)
@pytest.mark.parametrize("engine, most", (("auto2", 1.13), ("auto10", 1.1), ("auto60", 1.1)))
def test_a_stride_costs_about_as_much_as_every_sample(target, engine, most):
    """A stride of 2 copies the sums at every second sample."""
    figures = RECORDED[target]
    single, worst = (
        figures["every_sample_instructions_per_sample"],
        figures["fixed_worst_push_instructions"],
    )
    assert figures[f"{engine}_instructions_per_sample"] <= most * single
    assert figures[f"{engine}_worst_push_instructions"] <= 1.3 * worst


@pytest.mark.parametrize("table", target_cost.TABLES, ids=lambda table: table.name)
def test_readme_and_docs_show_the_recorded_tables(table):
    assert target_cost.enclosed(table, RECORDED) in table.page.read_text(encoding="utf-8")


# --- the path of a sample ---


@pytest.fixture
def image(target):
    return targets.build(target) / "paths.elf"


@on_every_board
def test_a_sample_s_path_has_no_division_no_float_and_no_library_call(target, image):
    """The evaluation of a result divides in floating point, and law glr can restart, which divides:
    there the check must fail.
    """
    assert call_graph.offences(target, image, PUSH, GAPS) == []
    assert call_graph.offences(target, image, ("davar_fit_8_taus",))
    assert call_graph.offences(target, image, PUSH)


@on_every_board
def test_the_check_of_the_path_finds_a_division_in_any_function_of_a_law(
    target, image, monkeypatch
):
    code = call_graph.disassembly(target, image)
    for function in LAW_FUNCTIONS:
        found = code[function]
        worse = code | {function: found._replace(operations=found.operations | {"udiv"})}
        monkeypatch.setattr(call_graph, "disassembly", lambda *_, worse=worse: worse)
        expected = [f"{target}: udiv in {function}"]
        assert call_graph.offences(target, image, PUSH, GAPS) == expected


@pytest.mark.parametrize(
    "line, taken",
    (
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
    ),
)
def test_what_an_instruction_takes_of_the_stack(line, taken):
    assert call_graph.taken(line, {"r4": (1 << 32) - 612, "r3": 612}) == taken


# --- parts with an image of their own ---

# Image, figures with their limits in CI. Those of cascade.c, torn.c and floor.c are of a sample
# (mean and worst, as docs/FIRMWARE.md states them), with bytes; those of select.c are of a sample,
# of a block and bytes, by the number of gyros (addons/select/DESIGN.md).
BUDGETS = {
    ("cascade_cost", "cortex-m4f"): {"q15_narrow_push_x100": 2500, "q15_narrow_worst_push": 300},
    ("cascade_cost", "cortex-m0"): {"q15_narrow_push_x100": 4000, "q15_narrow_worst_push": 300},
    ("torn_cost", "cortex-m4f"): {"push_x100": 5600, "worst_push": 235},
    ("torn_cost", "cortex-m0"): {"push_x100": 7800, "worst_push": 308},
    ("floor_cost", "cortex-m4f"): {"all_x100": 15000, "worst_push": 4000},
    ("select_cost", "cortex-m4f"): {
        f"{gyros}_{what}": WORSE * most
        for gyros, limits in {2: (115, 1119), 3: (427, 2197), 4: (604, 3505)}.items()
        for what, most in zip(("add", "update"), limits)
    },
}
EXACT = {
    "cascade_cost": {"cascade_memory_bytes": 2016},
    "torn_cost": {"torn_t_bytes": 20, "torn_reads": 1},
    "floor_cost": {"floor_t_bytes": 1360},
    "select_cost": {"select2_bytes": 256, "select3_bytes": 420, "select4_bytes": 620},
}


@pytest.mark.parametrize("name, target", BUDGETS)
def test_a_sample_keeps_its_budget(name, target):
    assert target in IN_CI
    figures, part = figures_of(target, name), name.removesuffix("_cost")
    for figure, most in BUDGETS[name, target].items():
        separator = "" if part == "select" else "_"
        assert figures[f"{part}{separator}{figure}"] <= most


@on_every_board
@pytest.mark.parametrize("name", EXACT)
def test_every_core_computes_the_same_bits_in_as_many_bytes(name, target):
    figures, checksum = figures_of(target, name), name.replace("_cost", "_checksum")
    assert figures[checksum] == figures_of(REFERENCE, name)[checksum]
    wordy = EXACT[name] if target in IN_CI or name != "select_cost" else {}
    assert {figure: figures[figure] for figure in wordy} == wordy
