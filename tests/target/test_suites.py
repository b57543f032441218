"""The Unity suites of lib/ on every target, in the emulator. The result of a passed image is
cached, because the same bytes give the same result.
"""

import re
from functools import cache

import pytest
import result_cache
import targets
from on_boards import IN_CI, boards

BEYOND_16_KB = set(
    re.findall(
        r"\w+",
        """wrap glr glr_numbers recorded fit fit_white cascade codec float init results state
        telemetry tracking""",
    )
)
SMALL = set(re.findall(r"\w+", "number song runs edf small"))
PASSED = result_cache.ResultCache(targets.ROOT / "build/cache/emulated")


@cache
def built(target, kind="suites"):
    """{suite: its image}, as listed by the build; images of removed suites do not count."""
    where = targets.build(target, kind)
    suites = (where / "suites.txt").read_text(encoding="ascii").split(";")
    return {suite: where / f"test_{suite}.elf" for suite in suites}


def suites_of(target):
    return SMALL if targets.MACHINES[target]["small"] else SMALL | BEYOND_16_KB


def check(target, image):
    def passes():
        status, output = targets.execute(target, image)
        assert status == 0, output
        assert re.search(r"^\d+ Tests 0 Failures 0 Ignored", output, re.MULTILINE)
        return True

    PASSED.check(result_cache.content_key(*targets.identity(target, image)), passes)


@pytest.mark.parametrize("target", boards(targets.MACHINES))
def test_the_build_has_every_suite(target):
    assert set(built(target)) == suites_of(target)


@pytest.mark.parametrize(
    "target, suite",
    [
        pytest.param(target, suite, marks=[] if target in IN_CI else pytest.mark.soak)
        for target in targets.MACHINES
        for suite in sorted(suites_of(target))
    ],
)
def test_a_suite_passes(target, suite):
    check(target, built(target)[suite])


@pytest.mark.soak
def test_cortex_m3_in_plain_c():
    """Where there are hand-written instructions, also their C versions. Images without any equal
    those of cortex-m3, byte for byte.
    """
    usual, plain = built("cortex-m3"), built("cortex-m3", "portable")
    assert set(usual) == set(plain)
    others = {name for name in plain if plain[name].read_bytes() != usual[name].read_bytes()}
    assert {"init", "results", "state", "wrap"} <= others
    for suite in sorted(others):
        check("cortex-m3", plain[suite])
