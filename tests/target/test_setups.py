"""Setups of tools/davar-plan on every bare board: compiled, linked and run, each costs what its
plan states. The wishes are not those from which the table of costs was made.
tests/tools/measured_setups.json repeats some of these figures.
"""

import pytest
import setup_cost
import targets
from planner import choice
from planner.wishes import read

WITHIN = 0.05
FIGURES = (
    "flash_bytes",
    "push_stack_bytes",
    "take_stack_bytes",
    "start_stack_bytes",
    "mean_push_instructions",
    "worst_push_instructions",
)
# Small enough for the RAM of every board, with the stack that the measurement paints.
SMALL = (
    "--rate 100 --lsb 0.05 --bandwidth 33:2",
    "--rate 400 --lsb 0.061 --bandwidth 116 --respond 1.6 --axes 3 --ram 11k",
    "--rate 1000 --lsb 0.061 --bandwidth 250 --respond 0.8 --axes 2 --longest-tau 50 --ram 9k",
    "--rate 50 --type int32 --lsb 0.001 --bandwidth 20:1 --respond 4",
    "--rate 200 --type float --full-scale 500 --bandwidth none --respond 4 --longest-tau 3600 "
    "--ram 11k",
    "--rate 250 --lsb 0.01 --bandwidth 90 --respond 0.6 --arw-percent 16",
    "--rate 416 --lsb 0.061 --bandwidth 150:1 --motion flight",
)
LARGE = (
    "--rate 1000 --axes 3 --lsb 0.061 --bandwidth 250:2 --respond 2 --longest-tau 1000 --ram 20k "
    "--flash 36k",
    "--sensor icm42688@1000 --axes 3 --respond 1",
    "--sensor bmi088@400 --axes 3 --longest-tau 10000 --ram 64k",
    "--rate 500 --axes 3 --lsb 0.061 --bandwidth 120 --false-alarms-per-hour 0.1",
    "--rate 800 --type int32 --lsb 0.002 --bandwidth 200 --false-alarms-per-hour 1 --axes 2 "
    "--longest-tau 400",
    "--rate 2000 --type float --full-scale 2000 --bandwidth 500 --axes 3 --respond 3 --ram 48k",
    "--rate 8000 --axes 3 --lsb 0.061 --bandwidth 258:2:5 --motion flight --respond 0.7",
    "--rate 1600 --type int32 --lsb 1e-3 --bandwidth 523:2 --axes 2 --motion flight --respond 2 "
    "--longest-tau 100",
)
IN_CI = {
    "cortex-m0": (SMALL[0], SMALL[2], SMALL[4], SMALL[6]),
    "cortex-m4f": (SMALL[0], *LARGE[2:5], LARGE[6]),
}


def runs():
    """All for the Cortex-M4F; the Cortex-M0's board is small; in turn four for each other core."""
    for at, core in enumerate(targets.BARE):
        wishes = [of[(at + k) % len(of)] for of in (SMALL, LARGE) for k in (0, 3)]
        wishes = SMALL + LARGE if core == "cortex-m4f" else wishes
        for words in SMALL if targets.MACHINES[core]["small"] else wishes:
            is_soaked = words not in IN_CI.get(core, ())
            yield pytest.param(core, words, marks=pytest.mark.soak if is_soaked else [])


@pytest.mark.parametrize("core, words", list(runs()))
def test_a_setup_costs_what_its_plan_states(core, words, tmp_path):
    plan = choice.plan(read([*words.split(), "--core", core], targets.BARE).wishes)
    setup_cost.write(plan.design, tmp_path)
    found = setup_cost.measure(core, plan.design, tmp_path)
    assert found["ram_bytes"] == plan.cost.ram_bytes
    for figure in FIGURES:
        ratio = found[figure] / getattr(plan.cost, figure)
        assert ratio <= 1 + WITHIN, figure
        assert ratio >= 1 - WITHIN or setup_cost.is_bound(plan.design, figure), figure
