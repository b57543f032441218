"""The library in one file (tools/support/amalgamate.py) compiles everywhere without a warning.
test_options.py compares its results.
"""

import pytest
from compiling import INCLUDE, SOURCES, WARN, objects, run

LEAN = ["-DDAVAR_Q31=0", "-DDAVAR_LAWS=0"]
GCC, CLANG, M0 = ("gcc",), ("clang-14",), ("arm-none-eabi-gcc", "-mcpu=cortex-m0")
M4 = ("arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
BUILDS = [
    (GCC, ["-O1", "-DNDEBUG"]),
    (GCC, ["-O0", "-DDAVAR_Q15=0"]),
    (GCC, ["-O0", *LEAN]),
    (CLANG, ["-fsyntax-only"]),
    (CLANG, ["-fsyntax-only", "-DNDEBUG", *LEAN]),
    (CLANG, ["-fsyntax-only", "-DDAVAR_PORTABLE", "-DDAVAR_Q15=0"]),
    (M0, ["-O0"]),
    (M4, ["-O0", "-DDAVAR_PORTABLE"]),
]
LONG_BUILDS = [
    (compiler, options)
    for compiler in (GCC, CLANG, M0, M4)
    for options in (["-O0"], ["-O2", "-DDAVAR_PORTABLE"], ["-Os", "-DDAVAR_Q15=0"], ["-Os", *LEAN])
]


@pytest.mark.parametrize(
    "compiler, options",
    [*BUILDS, *(pytest.param(*one, marks=pytest.mark.soak) for one in LONG_BUILDS)],
)
def test_it_compiles_without_a_warning(one_file, tmp_path, compiler, options):
    flags = [*WARN, "-ffp-contract=off", *options, "-o", tmp_path / "davar.o", "-c"]
    run(*compiler, *flags, one_file / "davar.c")


def test_it_has_the_names_of_the_library_and_no_others(one_file, tmp_path):
    def names(*sources):
        made = objects(tmp_path / "names", [*WARN, "-O0", "-ffp-contract=off", *INCLUDE], sources)
        lines = run("nm", "-g", "--defined-only", *made).splitlines()
        return {line.split()[-1] for line in lines if " " in line}

    assert names(*SOURCES) == names(one_file / "davar.c")
