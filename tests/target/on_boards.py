"""Which boards a test runs on: CI has a Cortex-M0 and a Cortex-M4F; tools/soak runs the others."""

import re
from functools import cache

import pytest
import targets

IN_CI = ("cortex-m0", "cortex-m4f")
REFERENCE = "cortex-m4f"


def boards(names=targets.BARE, in_ci=IN_CI):
    """Boards as parameters."""
    return [
        pytest.param(name, marks=[] if name in in_ci else pytest.mark.soak, id=name)
        for name in names
    ]


on_every_board = pytest.mark.parametrize("target", boards())


def figures_in(output):
    return {name: int(value) for name, value in re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)}


@cache
def figures_of(target, name):
    """{figure: value} that an image prints while it counts instructions."""
    image = targets.build(target, image=name) / f"{name}.elf"
    status, output = targets.execute(target, image, shift=targets.counting_shift(target))
    assert status == 0, f"{target}: {output}"
    return figures_in(output)
