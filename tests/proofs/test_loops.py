"""Every loop of the library ends: it is counted, by its text, or loops.txt gives the reason."""

import re
from collections import Counter
from pathlib import Path

import pytest
from loops import Loop, all_loops, is_counted

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


UP = "for (uint32_t i = 0U; i < count; i++)"
MEMBERS = "for (uint32_t i = 0U; i < stage->count; i++)"
HEADS = (
    "for (uint32_t i = 0U; i < count; i += n)",
    "for (uint32_t i = 0U; i < count;)",
    "for (uint32_t i = 9U; i >= 0U; i--)",
    "for (uint32_t i = 0U; i <= count; i++)",
    "for (uint32_t i = 0U; i != count; i++)",
    "for (uint32_t i = 0U; i < next(count); i++)",
    "while (i < count)",
)


@pytest.mark.parametrize(
    "head, body, counted",
    (
        (UP, "{ a[i] = 0U; }", True),
        *((UP, f"{{ {body} }}", False) for body in ("i--;", "count++;", "f(&i);", "f(&count);")),
        (UP, "{ i = 0U; }", False),
        *((head, "{ a[i] = 0U; }", False) for head in HEADS),
        (MEMBERS, "{ a[i] = 0U; }", True),
        (MEMBERS, "{ stage->count++; }", False),
        (MEMBERS, "{ law->judge(stage); }", False),
        (MEMBERS, "{ f(&stage->count); }", False),
        ("while (i < count)", "{ f(a[i]); i++; }", True),
        ("while (i < count)", "{ if (a[i]) { continue; } i++; }", False),
    ),
)
def test_a_loop_that_may_not_end_is_not_counted(head, body, counted):
    assert is_counted(Loop("a.c", 1, "f", head, body, (), "")) == counted
