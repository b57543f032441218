"""A compiler flag leaves every bit of the library's results unchanged, or the library does not
compile with it. The table lists flags one by one.
"""

import functools
import os
import re
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from compiling import LAUNCHER, run

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import result_cache

ROOT = Path(__file__).resolve().parents[2]

PASSED = result_cache.ResultCache(
    ROOT / "build/cache/flags"
)  # a row is cached until the library, the program or the compiler changes
FUSED = re.compile(
    r"\t(vfn?m(add|sub)|fn?m(add|sub)\b|fn?m(add|sub)\.|vfn?m[as])"
)  # one instruction for a product and a sum

# Error texts of the library.
IEEE, NAN, UNSAFE, EXCESS, SINGLE = (
    "without -ffast-math",
    "without -ffinite-math-only",
    "without -funsafe-math-optimizations",
    "-mfpmath=sse",
    "without -fsingle-precision-constant",
)

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
        "-m32 -idirafter /usr/include/x86_64-linux-gnu": EXCESS,
    },
    "clang-14": {
        "-O2 -ffast-math": IEEE,
        "-Ofast": IEEE,
        "-ffp-model=fast": IEEE,
        "-ffinite-math-only": NAN,
    },
}
SAME = {
    "gcc": [
        "-O0",
        "-O1",
        "-O2",
        "-O3 -funroll-loops",
        "-Os",
        "-Og",
        "-O1 -fno-inline",
        "-O2 -flto",
        "-O2 -mfma",
        "-O2 -mfma -std=c11",
        "-O3 -march=x86-64-v3",
        "-O2 -mfma -ffp-contract=fast",
        "-O1 -mfma -ffp-contract=on",
        "-O1 -mrecip",
        "-O1 -mpc32",
        "-O1 -fno-signed-zeros",
        "-O1 -fno-trapping-math",
        "-O1 -frounding-math",
        "-O1 -fsignaling-nans",
        "-O1 -fno-math-errno",
        "-O1 -fcx-limited-range",
        "-O1 -fexcess-precision=fast",
        "-O1 -ffloat-store",
        "-O1 -mlong-double-64",
        "-O1 -fshort-enums",
        "-O1 -funsigned-char",
        "-O1 -fwrapv",
        "-O1 -ftrapv",
        "-O2 -fno-strict-aliasing",
        "-O1 -fpack-struct",
        "-O1 -fno-common",
        "-O1 -fno-builtin",
        "-O1 -ffreestanding",
        "-O1 -std=gnu2x",
        "-O1 -fsanitize=undefined -fno-sanitize-recover=all",
    ],
    "clang-14": [
        "-O0",
        "-O2",
        "-O3",
        "-Oz",
        "-O2 -mfma",
        "-O3 -march=x86-64-v3",
        "-O2 -mfma -ffp-contract=fast",
        "-O1 -ffp-model=strict",
        "-O2 -mrecip=all",
        "-O2 -funsafe-math-optimizations",
        "-O2 -fassociative-math -fno-signed-zeros",
        "-O2 -freciprocal-math",
        "-O1 -fno-signed-zeros",
        "-O1 -fapprox-func",
        "-O1 -fno-honor-nans",
        "-O1 -fno-honor-infinities",
        "-O1 -frounding-math",
        "-O1 -fdenormal-fp-math=positive-zero",
        "-O1 -fshort-enums",
        "-O1 -funsigned-char",
        "-O1 -fwrapv",
    ],
}
# Machines that fuse by default; the tests only check their instructions.
CROSS = {
    "arm-none-eabi-gcc": [
        "-O2 -mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard",
        "-Os -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard",
    ],
    "aarch64-linux-gnu-gcc": ["-O2"],
    "riscv64-linux-gnu-gcc": ["-O2"],
}
CARRY = {
    "state/image.c",
    "number/absent.c",
}  # they move floating-point numbers without computing


def tearDownModule():
    print(f"cached: {PASSED.hits}")


@functools.cache
def library():
    """Both files of tools/support/amalgamate.py."""
    folder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(folder.cleanup)
    run(sys.executable, ROOT / "tools/support/amalgamate.py", folder.name)
    return Path(folder.name)


def compiled(compiler, flags, folder):
    """The two objects."""
    folder.mkdir()
    made = []
    for source in (library() / "davar.c", ROOT / "tests/consumer/flags.c"):
        made.append(folder / f"{source.stem}.o")
        run(
            *LAUNCHER,
            compiler,
            *flags.split(),
            "-w",
            "-I",
            ROOT / "lib/include",
            "-c",
            source.name,
            "-o",
            made[-1],
            folder=source.parent,
        )
    return made


@functools.cache
def key_of(compiler):
    """Everything that the bits depend on, except the flags."""
    version = (
        run(compiler, "--version")
        + Path("/proc/cpuinfo").read_text().split("flags")[1].split("\n")[0]
    )
    return result_cache.content_key(
        version,
        (library() / "davar.c").read_text(),
        (ROOT / "tests/consumer/flags.c").read_text(),
        Path(__file__).read_text(),
    )


def is_fused(path, objdump="objdump"):
    """True if the disassembly has such an instruction."""
    return bool(FUSED.search(run(objdump, "-d", "--no-show-raw-insn", path)))


def can_run(flags):
    """A processor without the instructions is not a failure: the test then checks only the
    disassembly.
    """
    known = Path("/proc/cpuinfo").read_text()
    return not ("-mfma" in flags or "v3" in flags) or (" fma " in known and " avx2 " in known)


class Flags(unittest.TestCase):
    def each(self, work, cases):
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for case, answer in zip(cases, pool.map(lambda case: work(*case), cases)):
                with self.subTest(" ".join(case)):
                    self.assertEqual(*answer)

    def test_a_flag_that_bends_arithmetic_is_rejected_by_name(self):
        def refusal(compiler, flags):
            done = subprocess.run(
                [compiler, *flags.split(), "-w", "-fsyntax-only", library() / "davar.c"],
                text=True,
                stderr=subprocess.PIPE,
            )
            return (
                (True, True)
                if done.returncode and REFUSED[compiler][flags] in done.stderr
                else (REFUSED[compiler][flags], done.stderr)
            )

        self.each(
            refusal, [(compiler, flags) for compiler, table in REFUSED.items() for flags in table]
        )

    def test_any_other_flag_leaves_every_bit(self):
        def is_same(compiler, flags):
            return PASSED.check(
                result_cache.content_key(expected, key_of(compiler), flags),
                lambda: bits(compiler, flags) == expected,
            ), True

        def bits(compiler, flags):
            folder = Path(parent) / f"{compiler} {flags}".replace("/", "_")
            objects = compiled(compiler, flags, folder)
            run(compiler, *flags.split(), "-w", *objects, "-o", folder / "flags", "-lm")
            self.assertFalse(
                "-flto" not in flags and is_fused(objects[0]),
                f"{compiler} {flags}: a product and a sum are fused",
            )
            return run(folder / "flags").strip() if can_run(flags) else expected

        with tempfile.TemporaryDirectory() as parent:
            expected = bits("gcc", "-O1 -std=c11")
            self.assertRegex(expected, "^[0-9a-f]{16}$")
            self.each(
                is_same, [(compiler, flags) for compiler, table in SAME.items() for flags in table]
            )

    def test_a_program_that_flushes_subnormals_gets_the_same_bits(self):
        with tempfile.TemporaryDirectory() as parent:
            objects = compiled("gcc", "-O2", Path(parent) / "objects")
            sums = set()
            # if it is linked with this flag, a program sets the processor so
            for flags in ([], ["-ffast-math"]):
                run("gcc", *objects, *flags, "-o", Path(parent) / "flags", "-lm")
                sums.add(run(Path(parent) / "flags"))
            self.assertEqual(1, len(sums), sums)

    def test_no_machine_fuses_a_product_with_a_sum(self):
        def fused(compiler, flags):
            folder = Path(parent) / f"{compiler} {flags}"
            objects = compiled(compiler, flags, folder)
            return False, is_fused(objects[0], compiler.replace("gcc", "objdump"))

        with tempfile.TemporaryDirectory() as parent:
            probe = Path(parent) / "probe.c"
            probe.write_text("double fused(double a, double b, double c) { return a * b + c; }\n")
            run("gcc", "-O2", "-mfma", "-c", probe, "-o", probe.with_suffix(".o"))
            self.assertTrue(is_fused(probe.with_suffix(".o")), "the test is blind")
            self.each(
                fused, [(compiler, flags) for compiler, table in CROSS.items() for flags in table]
            )

    def test_every_source_that_computes_includes_the_check(self):
        wrong = set()
        for source in (ROOT / "lib/src").rglob("*.c"):
            reads = run("gcc", "-I", ROOT / "lib/include", "-I", ROOT / "lib/src", "-M", source)
            if "number/strict.h" not in reads and re.search(
                r"\b(float|double|NAN|INFINITY)\b", source.read_text()
            ):
                wrong.add(str(source.relative_to(ROOT / "lib/src")))
        self.assertEqual(CARRY, wrong)


if __name__ == "__main__":
    unittest.main()
