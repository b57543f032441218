"""A disabled feature (davar/options.h) is rejected with its own error, and all other results have
the same bits. A wrong combination does not compile.
"""

import re

import pytest
from compiling import INCLUDE, OPTIONS, PROGRAM_INCLUDE, ROOT, SOURCES, WARN, attempt, program, run

FLAGS = [*WARN, "-O0", "-ffp-contract=off"]
LEAN = ("LAWS", "Q31")
SIZES = """#include "davar/davar.h"
#include "davar/fit.h"
#include <stdio.h>
int main(void) { printf("%zu %zu", sizeof(davar_result_t), sizeof(davar_plan_t)); return 0; }
"""


def features(way):
    """Bits of the digit: adaptive 1, stride 2. 4 and 5 are law glr, 5 with a stride;
    a: engine auto; c and l, a cascade and limits, need their number type alone.
    """
    return 0 if way[1] in "cl" else int(way[1])


# Features that a configuration of options.c needs.
NEEDS = {
    "LAWS": lambda way: features(way) & 5,
    "Q15": lambda way: way[0] == "q",
    "Q31": lambda way: way[0] in "wf",
}


def ways(folder, flags, sources):
    """{configuration: (status of init, checksum of the results, number of gaps)}."""
    made = program(folder, [*FLAGS, *flags, *PROGRAM_INCLUDE], [OPTIONS, *sources])
    lines = run(made).splitlines()
    found = (line.split(" ", 1) for line in lines)
    return {way: tuple(said.rsplit(" ", 2)) for way, said in found}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Those of the library, from its sources."""
    return ways(tmp_path_factory.mktemp("whole"), INCLUDE, SOURCES)


def test_every_configuration_has_results_and_auto_is_grid(whole):
    assert {status for status, _, _ in whole.values()} == {"ok"}
    assert len({total for _, total, _ in whole.values()}) > 15
    for way in [way for way in whole if way.endswith("a")]:
        assert whole[way[:-1]] == whole[way]


def test_every_stream_has_gaps(whole):
    """Three from calls of davar_gap. NaN and both infinities add one each."""
    for way, (_, _, gaps) in whole.items():
        assert gaps == ("0" if way[1] in "cl" else "6" if way[0] == "f" else "3"), way


@pytest.mark.parametrize(
    "left_out",
    (
        ("LAWS",),
        ("Q15",),
        LEAN,
        pytest.param(("Q31",), marks=pytest.mark.soak),
    ),
)
def test_disabled_features_are_rejected_and_others_have_the_same_bits(
    whole, one_file, tmp_path, left_out
):
    flags = ["-I", one_file, *(f"-DDAVAR_{name}=0" for name in left_out)]
    found = ways(tmp_path, flags, [one_file / "davar.c"])
    for way, answer in found.items():
        refused = any(NEEDS[name](way) for name in left_out)
        if way[1] == "l" and "LAWS" in left_out:  # init does not read the settings of the laws
            continue
        assert answer == (("disabled in this build", "0" * 16, "0") if refused else whole[way]), way
    assert found.keys() == whole.keys()


@pytest.mark.parametrize(
    "flags",
    (
        ["-DNDEBUG"],  # the single file, complete
        ["-DDAVAR_PORTABLE", "-DDAVAR_ASSERT(condition)=((void)0)", "-DDAVAR_TAUS_MAX=8"],
    ),
)
def test_other_builds_have_the_same_bits(whole, one_file, tmp_path, flags):
    assert whole == ways(tmp_path, ["-I", one_file, *flags], [one_file / "davar.c"])


def test_the_sizes_that_the_pages_state(tmp_path):
    readme, costs = (
        (ROOT / page).read_text(encoding="utf-8") for page in ("README.md", "docs/COST.md")
    )
    (tmp_path / "sizes.c").write_text(SIZES)
    sizes = {}
    for taus in (8, 32):
        flags = [f"-DDAVAR_TAUS_MAX={taus}", *INCLUDE]
        run("gcc", *FLAGS, *flags, tmp_path / "sizes.c", "-o", tmp_path / "sizes")
        result, plan = map(int, run(tmp_path / "sizes").split())
        assert re.search(rf"(?m)^\| {taus}( \(default\))? \| {result} \| {plan} \|$", costs)
        pairs = taus * (taus + 1) // 2
        assert (result, plan) == (48 * taus + 232, 100 * taus + 4 * pairs + 304)
        sizes[taus] = result + plan
    readme, costs = (" ".join(page.split()) for page in (readme, costs))
    assert "232 bytes plus 48 bytes per tau" in costs
    assert "304 bytes plus 100 bytes per tau plus 4 bytes per pair of taus" in costs
    assert f"({sizes[8]} bytes with `-DDAVAR_TAUS_MAX=8`)" in readme


@pytest.mark.parametrize(
    "options, why",
    (
        (("-DDAVAR_Q15=0", "-DDAVAR_Q31=0"), "one number type must be there"),
        (("-DDAVAR_TAUS_MAX=0",), "DAVAR_TAUS_MAX: 1 to 32"),
        (("-DDAVAR_TAUS_MAX=33",), "DAVAR_TAUS_MAX: 1 to 32"),
    ),
)
def test_a_wrong_combination_does_not_compile(options, why):
    status, said = attempt("gcc", *FLAGS, *INCLUDE, *options, "-fsyntax-only", OPTIONS)
    assert status != 0
    assert why in said
