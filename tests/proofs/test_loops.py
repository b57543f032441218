"""Every loop of the library ends: it is counted, by its text, or loops.txt gives the reason."""

import re
from collections import Counter
from pathlib import Path

import pytest
from loops import all_loops, is_counted

pytestmark = pytest.mark.inputs("tests/proofs", "lib", "addons", "tests/style/c_text.py")

ROWS = [
    tuple(line.split(" | "))
    for line in Path(__file__).with_name("loops.txt").read_text().splitlines()
    if line and not line.startswith("#")
]
KINDS = ("asserted", "bounded", "domain", "retry")


def test_every_loop_is_counted_or_listed():
    loops = all_loops()
    assert len(loops) > 250, "the loops were not recognised"
    found = Counter(loop[0:1] + loop[2:4] for loop in loops if not is_counted(loop))
    assert found == Counter(row[:3] for row in ROWS)
    assert {row[3] for row in ROWS} <= set(KINDS)


def test_an_asserted_loop_has_its_assertion():
    body = {loop[0:1] + loop[2:4]: " ".join(loop.body.split()) for loop in all_loops()}
    for *loop, kind, reason in ROWS:
        if kind == "asserted":
            assert re.match(r"DAVAR_ASSERT\(.*\);$", reason)
            assert reason in body[tuple(loop)]
