"""The library in one file (tools/support/amalgamate.py) compiles everywhere without a warning and
gives the same results.
"""

import os
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

from compiling import objects, run

ROOT = Path(__file__).resolve().parents[2]
STRICT = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"]
COMPILERS = (
    ["gcc"],
    ["clang"],
    ["arm-none-eabi-gcc", "-mcpu=cortex-m0"],
    ["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
)
BUILDS = (
    ["-O0"],
    ["-O2", "-DNDEBUG"],
    ["-O2", "-DDAVAR_PORTABLE"],
    ["-Os", "-DDAVAR_Q15=0"],
    ["-Os", "-DDAVAR_Q31=0", "-DDAVAR_GRID=0", "-DDAVAR_LAWS=0", "-DDAVAR_CENTRED=0"],
)


class OneFile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.work = Path(folder.name)
        run(sys.executable, ROOT / "tools/support/amalgamate.py", cls.work)
        (cls.work / "davar").mkdir()
        for header in (ROOT / "lib/include/davar").iterdir():
            if header.suffix == ".h":  # a program that includes it gets the single file
                (cls.work / "davar" / header.name).write_text('#include "../davar.h"\n')
            else:  # the list of fields, which a suite expands
                shutil.copy(header, cls.work / "davar")

    def test_it_compiles_without_a_warning(self):
        there = [compiler for compiler in COMPILERS if shutil.which(compiler[0])]
        self.assertIn(["gcc"], there)
        for compiler in there:
            for options in BUILDS:
                with self.subTest(compiler=compiler, options=options):
                    objects(
                        self.work / "any", [*STRICT, *options], [self.work / "davar.c"], compiler
                    )

    def test_it_has_the_names_of_the_library_and_no_others(self):
        def names(*sources):
            made = objects(
                self.work / "names",
                ["-std=c11", "-O0", f"-I{ROOT / 'lib/include'}", f"-I{ROOT / 'lib/src'}"],
                sources,
            )
            return {
                line.split()[-1]
                for line in run("nm", "-g", "--defined-only", *made).splitlines()
                if " " in line
            }

        self.assertEqual(names(*(ROOT / "lib/src").rglob("*.c")), names(self.work / "davar.c"))

    def test_it_gives_the_same_bits(self):
        def sums(include, *sources):
            run(
                "gcc",
                *objects(
                    self.work / "same",
                    [*STRICT, "-O2", *include],
                    [ROOT / "tests/consumer/options.c", *sources],
                ),
                "-o",
                self.work / "sums",
                "-lm",
            )
            return run(self.work / "sums")

        library = sums(
            ["-I", ROOT / "lib/include", "-I", ROOT / "lib/src"], *(ROOT / "lib/src").rglob("*.c")
        )
        self.assertGreater(len(library.splitlines()), 15)
        self.assertEqual(library, sums(["-I", self.work], self.work / "davar.c"))

    def test_it_passes_the_suites_of_the_interface(self):
        unity = os.environ.get("DAVAR_UNITY_DIR")
        if not unity:
            self.skipTest("DAVAR_UNITY_DIR is not set: tools/test sets it")
        flags = [
            "-std=c11",
            "-O2",
            "-ffp-contract=off",
            "-I",
            self.work,
            "-I",
            ROOT / "tests/support",
            "-I",
            unity,
            "-DUNITY_INCLUDE_DOUBLE",
            "-DUNITY_SUPPORT_64",
        ]
        (checked,) = objects(self.work / "checked", [*flags, "-UNDEBUG"], [self.work / "davar.c"])
        (refused,) = objects(
            self.work / "refused", [*flags, "-DNDEBUG"], [self.work / "davar.c"]
        )  # tests/CMakeLists.txt
        (unity_object,) = objects(self.work / "unity", flags, [Path(unity) / "unity.c"])
        suites = sorted((ROOT / "tests/api").glob("test_*.c"))
        self.assertGreater(len(suites), 10)
        for suite in suites:
            with self.subTest(suite=suite.name):
                library = refused if suite.stem == "test_refused" else checked
                run(
                    "gcc",
                    *objects(self.work / "suites", flags, [suite]),
                    library,
                    unity_object,
                    "-o",
                    self.work / suite.stem,
                    "-lm",
                )
                self.assertIn(" 0 Failures", run(self.work / suite.stem))


if __name__ == "__main__":
    unittest.main()
