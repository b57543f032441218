"""The smallest setup of tools/davar-plan: its bytes on a core, and the bits of its results there,
which are those of the host.
"""

import subprocess
from pathlib import Path

import c_library
import pytest
import setup_cost
import targets
from on_boards import on_every_board
from planner import choice, programs
from planner.wishes import read

PROBE = targets.ROOT / "tests/support/small_probe.c"
WISHES = "--rate 100 --lsb 0.05 --lost 0 --motion none --bandwidth"
# (core, filter) -> flash and RAM. They may not grow; docs/COST.md states them.
BYTES = {
    ("cortex-m4f", "none"): (5000, 1648),
    ("cortex-m4f", "33:2"): (5696, 1992),
    ("cortex-m0", "none"): (6360, 1648),
    ("cortex-m0", "33:2"): (7040, 1992),
}


def design_of(core, bandwidth):
    words = [*WISHES.split(), bandwidth, "--core", core]
    design = choice.plan(read(words, targets.BARE).wishes).design
    assert design.engine == "small"
    return design


@pytest.mark.parametrize("core, bandwidth", BYTES)
def test_the_smallest_setup_keeps_its_bytes(core, bandwidth, tmp_path):
    design = design_of(core, bandwidth)
    setup_cost.write(design, tmp_path)
    found = setup_cost.measure(core, design, tmp_path)
    flash, ram = BYTES[core, bandwidth]
    assert found["ram_bytes"] == ram
    assert found["flash_bytes"] <= flash


def window_flags(design):
    return [f"-DWINDOW={design.window}U", f"-DSTRIDE={design.stride}U"]


def on_the_board(core, design, folder):
    """What the setup prints on the emulated board."""
    where = targets.ROOT / "build" / f"setup-{core}"
    setup_cost.write(design, folder)
    options = [f"-D{define}" for define in setup_cost.text.defines(design)]
    setup, main, image = (folder / name for name in ("setup.o", "main.o", "small.elf"))
    setup_cost.compile_one(core, folder / "davar_setup.c", setup, options)
    flags = ["-DSMALL", "-DON_BOARD", *window_flags(design), f"-I{folder}"]
    flags += [f"-I{targets.ROOT / 'port/bare_metal'}"]
    setup_cost.compile_one(core, PROBE, main, [*options, *flags])
    objects = [main, setup, *setup_cost.board(core, where)]
    setup_cost.link(core, [*objects, setup_cost.archive(core, options, where)], image)
    status, output = targets.execute(core, image)
    assert status == 0, output
    return output


def on_the_host(design, folder):
    """What the complete library prints on this machine."""
    plan = programs.fit_plan(design.wishes, design.taus).text
    text = plan.replace("davar_setup_plan", "own_plan")
    (folder / "own_plan.c").write_text(
        f'#include "davar/fit.h"\n#include "davar/version.h"\n{text}', encoding="utf-8"
    )
    taus = ",".join(map(str, design.taus))
    wishes, program = design.wishes, folder / "complete"
    flags = [f"-DRATE={wishes.rate_hz!r}", f"-DUNIT={wishes.lsb!r}", f"-DTAUS={taus}"]
    sources = [PROBE, folder / "own_plan.c", *c_library.SOURCES]
    command = ["gcc", "-std=c11", "-O2", "-ffp-contract=off", *c_library.FLAGS, *flags]
    command += [*window_flags(design), *map(str, sources), "-lm", "-o", str(program)]
    subprocess.run(command, check=True, capture_output=True)
    return subprocess.run([program], check=True, capture_output=True, text=True).stdout


@on_every_board
@pytest.mark.parametrize("bandwidth", ("none", "33:2"))
def test_a_board_gives_the_bits_that_the_complete_library_gives_on_the_host(
    target, bandwidth, tmp_path: Path
):
    design = design_of(target, bandwidth)
    assert on_the_board(target, design, tmp_path) == on_the_host(design, tmp_path)
