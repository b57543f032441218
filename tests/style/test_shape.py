"""How much there is to read before a change or a first result. None of it may grow.

`python3 tests/style/test_shape.py` prints them.
"""

import re

import pytest
from c_text import c_files, includes, resolve, text_of

CORE_HEADERS = [f"lib/include/davar/{name}.h" for name in ("davar", "types", "instance", "options")]


def lines_of(names):
    return sum(text_of(name).count("\n") for name in names)


def face():
    """davar/davar.h and what it includes: all that a program sees before its first result."""
    found = []
    left = ["lib/include/davar/davar.h"]
    while left:
        name = left.pop()
        if name not in found:
            found.append(name)
            left += [file for one in includes(name) if (file := resolve(name, one))]
    return found


def public_functions(names):
    """The functions that these headers declare, each number type's for itself."""
    declared = r"^(?!static|typedef)(?:DAVAR_NODISCARD )?[\w *]+?\b\*?(davar_\w+)\("
    return {one for name in names for one in re.findall(declared, text_of(name), re.MULTILINE)}


# Name: (today's value, the most that this test allows, the goal).
SHAPE = {
    "lines to read before a change of a push": (
        lines_of([*c_files("lib/src/core/"), *CORE_HEADERS]),
        3000,
        3000,
    ),
    "lines of lib": (lines_of(c_files("lib/")), 13190, 10500),
    "lines of addons": (lines_of(c_files("addons/")), 6570, 4600),
    "lines of davar/davar.h and its includes": (lines_of(face()), 652, 300),
    "functions that it declares": (len(public_functions(face())), 25, 25),
}


@pytest.mark.parametrize("name", SHAPE)
def test_there_is_no_more_to_read(name):
    today, most, goal = SHAPE[name]
    assert goal <= most
    assert today <= most


if __name__ == "__main__":
    for name, (today, _, goal) in SHAPE.items():
        print(f"{name:<46} {today:6d}, goal {goal:5d}")
