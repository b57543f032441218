"""A compiler flag leaves every bit of the library's results unchanged, or the library does not
compile with it. TOGETHER has many flags in few builds.
"""

import re
import shutil
from pathlib import Path

import pytest
from compiling import INCLUDE, OPTIONS, PROGRAM_INCLUDE, ROOT, SOURCES, attempt, objects, run

# One instruction for a product and a sum.
FUSED = re.compile(r"\t(vfn?m(add|sub)|fn?m(add|sub)\b|fn?m(add|sub)\.|vfn?m[as])")
LONG = pytest.mark.soak

# Error texts of the library.
IEEE = "without -ffast-math"
NAN = "without -ffinite-math-only"
UNSAFE = "without -funsafe-math-optimizations"
EXCESS = "-mfpmath=sse"
SINGLE = "without -fsingle-precision-constant"

REFUSED = {
    "gcc": {
        "-O2 -ffast-math": IEEE,
        "-Ofast": IEEE,
        "-ffinite-math-only": NAN,
        "-O2 -funsafe-math-optimizations": UNSAFE,
        "-fassociative-math -fno-signed-zeros -fno-trapping-math": UNSAFE,
        "-freciprocal-math": UNSAFE,
        "-fsingle-precision-constant": SINGLE,
        "-mfpmath=387": EXCESS,
        "-mfpmath=both": EXCESS,
    },
    "clang-14": {
        "-O2 -ffast-math": IEEE,
        "-Ofast": IEEE,
        "-ffp-model=fast": IEEE,
        "-ffinite-math-only": NAN,
    },
}
TOGETHER = {
    "gcc": [
        "-O1 -mfma -ffp-contract=fast -mrecip -mpc32 -fno-signed-zeros -fno-trapping-math "
        "-fno-math-errno -fcx-limited-range -fexcess-precision=fast -fno-builtin",
        "-O2 -march=x86-64-v3 -funroll-loops -std=gnu2x -fno-common -fpack-struct -fwrapv",
        "-O0 -frounding-math -fsignaling-nans -ffloat-store -mlong-double-64 -fshort-enums "
        "-funsigned-char -ftrapv -fsanitize=undefined -fno-sanitize-recover=all",
    ],
    "clang-14": [
        "-O1 -mfma -ffp-contract=fast -mrecip=all -funsafe-math-optimizations -freciprocal-math "
        "-fassociative-math -fno-signed-zeros -fapprox-func -fno-honor-nans",
        "-O0 -ffp-model=strict -fno-honor-infinities -fshort-enums "
        "-fdenormal-fp-math=positive-zero -funsigned-char -fwrapv",
    ],
}
LEVELS = {
    "gcc": ["-O2", "-O3 -mfma", "-Os", "-Og", "-O2 -flto", "-O2 -fno-strict-aliasing"],
    "clang-14": ["-O2 -mfma", "-O3 -march=x86-64-v3", "-Oz"],
}
# Machines that fuse by default: their disassembly shows whether the library prevents it.
CROSS = {"arm-none-eabi-gcc": ["-O1 -mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard"]}
LONG_CROSS = {
    "arm-none-eabi-gcc": ["-Os -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard"],
    "aarch64-linux-gnu-gcc": ["-O1", "-O2"],
    "riscv64-linux-gnu-gcc": ["-O2"],
}
# They move numbers without computing.
CARRY = {"addons/state/src/image.c", "lib/src/number/absent.c"}


def rows(table, *marks):
    return [pytest.param(*row, marks=marks) for row in pairs(table)]


def pairs(table):
    return [(compiler, row) for compiler, flags in table.items() for row in flags]


def is_fused(path, objdump="objdump"):
    return bool(FUSED.search(run(objdump, "-d", "--no-show-raw-insn", path)))


def can_run(flags):
    """A processor without the instructions is not a failure: the test then checks only the
    disassembly.
    """
    known = Path("/proc/cpuinfo").read_text()
    return not ("-mfma" in flags or "v3" in flags) or (" fma " in known and " avx2 " in known)


def compiled(one_file, folder, compiler, flags):
    """The objects of the library and of the program."""
    flags = [*flags.split(), "-w", *PROGRAM_INCLUDE]
    return objects(folder, flags, [one_file / "davar.c", OPTIONS], [compiler])


def bits(one_file, folder, compiler, flags):
    made = compiled(one_file, folder, compiler, flags)
    assert "-flto" in flags or not is_fused(made[0]), "a product and a sum are fused"
    run(compiler, *flags.split(), "-w", *made, "-o", folder / "program", "-lm")
    return run(folder / "program") if can_run(flags) else None


@pytest.fixture(scope="module")
def expected(one_file, tmp_path_factory):
    found = bits(one_file, tmp_path_factory.mktemp("expected"), "gcc", "-O1 -std=c11")
    assert found.count(" ok ") == found.count("\n") == 30
    return found


@pytest.mark.parametrize("compiler, flags", pairs(REFUSED))
def test_a_flag_that_bends_arithmetic_is_rejected_by_name(one_file, compiler, flags):
    status, said = attempt(compiler, *flags.split(), "-w", "-fsyntax-only", one_file / "davar.c")
    assert status != 0
    assert REFUSED[compiler][flags] in said


@pytest.mark.parametrize("compiler, flags", [*pairs(TOGETHER), *rows(LEVELS, LONG)])
def test_any_other_flag_leaves_every_bit(one_file, expected, tmp_path, compiler, flags):
    assert bits(one_file, tmp_path, compiler, flags) in (expected, None)


def test_a_program_that_flushes_subnormals_gets_the_same_bits(one_file, expected, tmp_path):
    """If it is linked with this flag, a program sets the processor so."""
    made = compiled(one_file, tmp_path, "gcc", "-O1 -std=c11")
    run("gcc", *made, "-ffast-math", "-o", tmp_path / "program", "-lm")
    assert run(tmp_path / "program") == expected


def test_the_disassembly_shows_a_fused_instruction(tmp_path):
    (tmp_path / "probe.c").write_text(
        "double fused(double a, double b, double c) { return a * b + c; }\n"
    )
    (probe,) = objects(tmp_path, ["-O2", "-mfma"], [tmp_path / "probe.c"])
    assert is_fused(probe)


@pytest.mark.parametrize("compiler, flags", [*pairs(CROSS), *rows(LONG_CROSS, LONG)])
def test_no_machine_fuses_a_product_with_a_sum(one_file, tmp_path, compiler, flags):
    if not shutil.which(compiler):
        pytest.skip(f"{compiler}: not installed")
    made = compiled(one_file, tmp_path, compiler, flags)
    assert not is_fused(made[0], compiler.replace("gcc", "objdump"))


def test_every_source_that_computes_includes_the_check():
    wrong = set()
    for source in SOURCES:
        reads = run("gcc", *INCLUDE, "-M", source)
        if "number/strict.h" not in reads and re.search(
            r"\b(float|double|NAN|INFINITY)\b", source.read_text()
        ):
            wrong.add(str(source.relative_to(ROOT)))
    assert wrong == CARRY


@pytest.mark.soak
def test_a_32_bit_program_must_use_sse(one_file, tmp_path):
    (tmp_path / "gnu").mkdir()
    (tmp_path / "gnu/stubs-32.h").touch()  # of the C library for 32 bits, which may be absent
    places = ("-idirafter", "/usr/include/x86_64-linux-gnu", "-idirafter", tmp_path)
    status, said = attempt("gcc", "-m32", *places, "-fsyntax-only", one_file / "davar.c")
    assert status != 0
    assert EXCESS in said
