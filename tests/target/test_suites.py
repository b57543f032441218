"""The Unity suites of lib/ on every target, in the emulator."""

import re
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import targets

BEYOND_16_KB = {"wrap", "glr", "fit", "fit_mixture", "fit_plan", "fit_white", "codec", "float", "gaps", "init", "instances", "results", "state",
                "storage", "tracking"}
SUITES = {"arena", "arithmetic", "slide", "real", "rough", "scaled", "runs", "stationarity", "confidence", "taus"} | BEYOND_16_KB


def built(target, kind):
    """The folder of the images, without those of suites that are no more."""
    for image in targets.folder(target, kind).glob("test_*.elf"):
        image.unlink()
    return targets.build(target, kind)


class Suites(unittest.TestCase):
    def run_on(self, target, expected):
        where = built(target, "suites")
        self.assertEqual(expected, {path.stem[5:] for path in where.glob("test_*.elf")})
        for suite in sorted(expected):
            with self.subTest(target=target, suite=suite):
                self.run_image(target, where / f"test_{suite}.elf")

    def run_image(self, target, image):
        status, output = targets.execute(target, image)
        self.assertEqual(0, status, output)
        self.assertRegex(output, re.compile(r"^\d+ Tests 0 Failures 0 Ignored", re.MULTILINE))

    def test_cortex_m3_in_plain_c(self):
        """Where there are hand-written instructions, their twins in C as well. Images without any are those of test_cortex_m3,
        byte for byte."""
        usual, plain = targets.build("cortex-m3", "suites"), built("cortex-m3", "portable")
        others = {path for path in plain.glob("test_*.elf") if path.read_bytes() != (usual / path.name).read_bytes()}
        self.assertLessEqual({plain / f"test_{suite}.elf" for suite in ("gaps", "init", "instances", "results", "slide", "state",
                                                                        "storage", "wrap")}, others)
        for image in sorted(others):
            with self.subTest(suite=image.stem):
                self.run_image("cortex-m3", image)


def add(target):
    expected = SUITES - BEYOND_16_KB if targets.MACHINES[target]["small"] else SUITES
    name = "test_" + target.replace("-", "_")
    setattr(Suites, name, lambda self: self.run_on(target, expected))


for _target in targets.MACHINES:
    add(_target)

if __name__ == "__main__":
    unittest.main()
