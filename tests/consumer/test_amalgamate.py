"""The library in one file (tools/support/amalgamate.py) compiles everywhere without a warning, and it is the library."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STRICT = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"]
COMPILERS = (["gcc"], ["clang"], ["arm-none-eabi-gcc", "-mcpu=cortex-m0"],
             ["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"])
BUILDS = (["-O0"], ["-O2", "-DNDEBUG"], ["-O2", "-DDAVAR_PORTABLE"], ["-Os", "-DDAVAR_Q15=0"],
          ["-Os", "-DDAVAR_Q31=0", "-DDAVAR_GRID=0", "-DDAVAR_ADAPTIVE=0", "-DDAVAR_CENTRED=0"])


def run(*command):
    done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    assert done.returncode == 0, f"{command}:\n{done.stdout}"
    return done.stdout


class OneFile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.work = Path(folder.name)
        run(sys.executable, ROOT / "tools/support/amalgamate.py", cls.work)
        (cls.work / "davar").mkdir()
        for header in (ROOT / "lib/include/davar").glob("*.h"):  # so that a program that names them gets the one
            (cls.work / "davar" / header.name).write_text('#include "../davar.h"\n')

    def test_it_compiles_without_a_warning(self):
        there = [compiler for compiler in COMPILERS if shutil.which(compiler[0])]
        self.assertIn(["gcc"], there)
        for compiler in there:
            for options in BUILDS:
                with self.subTest(compiler=compiler, options=options):
                    run(*compiler, *STRICT, *options, "-c", self.work / "davar.c", "-o", self.work / "davar.o")

    def test_it_has_the_names_of_the_library_and_no_others(self):
        def names(*sources):
            objects = self.work / "objects"
            objects.mkdir(exist_ok=True)
            run("sh", "-c", 'cd "$1" && shift && rm -f ./*.o && gcc -std=c11 -O0 -c "$@"', "sh", objects,
                f"-I{ROOT / 'lib/include'}", f"-I{ROOT / 'lib/src'}", *sources)
            return {line.split()[-1] for line in run("nm", "-g", "--defined-only", *objects.glob("*.o")).splitlines() if " " in line}
        self.assertEqual(names(*(ROOT / "lib/src").rglob("*.c")), names(self.work / "davar.c"))

    def test_it_gives_the_same_bits(self):
        def sums(include, *sources):
            run("gcc", *STRICT, "-O2", *include, ROOT / "tests/consumer/options.c", *sources, "-o", self.work / "sums", "-lm")
            return run(self.work / "sums")
        library = sums(["-I", ROOT / "lib/include", "-I", ROOT / "lib/src"], *(ROOT / "lib/src").rglob("*.c"))
        self.assertGreater(len(library.splitlines()), 15)
        self.assertEqual(library, sums(["-I", self.work], self.work / "davar.c"))

    def test_it_passes_the_suites_of_the_interface(self):
        unity = os.environ.get("DAVAR_UNITY_DIR")
        if not unity:
            self.skipTest("DAVAR_UNITY_DIR is not set: tools/test sets it")
        flags = ["-std=c11", "-O2", "-ffp-contract=off", "-I", self.work, "-I", ROOT / "tests/support", "-I", unity, "-DUNITY_INCLUDE_DOUBLE", "-DUNITY_SUPPORT_64"]
        for name, choice in (("checked.o", "-UNDEBUG"), ("test_refused.o", "-DNDEBUG")):  # tests/CMakeLists.txt
            run("gcc", *flags, choice, "-c", self.work / "davar.c", "-o", self.work / name)
        run("gcc", *flags, "-c", Path(unity) / "unity.c", "-o", self.work / "unity.o")
        suites = sorted((ROOT / "tests/api").glob("test_*.c"))
        self.assertGreater(len(suites), 10)
        for suite in suites:
            with self.subTest(suite=suite.name):
                library = self.work / (suite.stem + ".o")
                library = library if library.exists() else self.work / "checked.o"
                run("gcc", *flags, suite, library, self.work / "unity.o", "-o", self.work / suite.stem, "-lm")
                self.assertIn(" 0 Failures", run(self.work / suite.stem))


if __name__ == "__main__":
    unittest.main()
