"""The Unity suites of lib/ on every target, in the emulator. The result of a passed image is
cached, because the same bytes give the same result.
"""

import re
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import result_cache
import targets

BEYOND_16_KB = {
    "wrap",
    "glr",
    "glr_numbers",
    "recorded",
    "fit",
    "fit_white",
    "cascade",
    "codec",
    "float",
    "init",
    "results",
    "state",
    "telemetry",
    "tracking",
}
SUITES = {
    "number",
    "slide",
    "song",
    "runs",
    "edf",
} | BEYOND_16_KB


PASSED = result_cache.ResultCache(targets.ROOT / "build/cache/emulated")


def tearDownModule():
    print(f"cached: {PASSED.hits}")


def built(target, kind):
    """{suite: its image}, as listed by the build; images of removed suites do not count."""
    where = targets.build(target, kind)
    return {
        suite: where / f"test_{suite}.elf"
        for suite in (where / "suites.txt").read_text(encoding="ascii").split(";")
    }


class Suites(unittest.TestCase):
    def run_on(self, target, expected):
        images = built(target, "suites")
        self.assertEqual(expected, set(images))
        for suite, image in sorted(images.items()):
            with self.subTest(target=target, suite=suite):
                self.run_image(target, image)

    def run_image(self, target, image):
        def passes():
            status, output = targets.execute(target, image)
            self.assertEqual(0, status, output)
            self.assertRegex(output, re.compile(r"^\d+ Tests 0 Failures 0 Ignored", re.MULTILINE))
            return True

        PASSED.check(result_cache.content_key(*targets.identity(target, image)), passes)

    def test_cortex_m3_in_plain_c(self):
        """Where there are hand-written instructions, also their C versions. Images without any
        equal those of test_cortex_m3, byte for byte.
        """
        usual, plain = built("cortex-m3", "suites"), built("cortex-m3", "portable")
        self.assertEqual(set(usual), set(plain))
        others = {
            suite
            for suite, image in plain.items()
            if image.read_bytes() != usual[suite].read_bytes()
        }
        self.assertLessEqual(
            {"init", "results", "slide", "state", "wrap"}, others
        )
        for suite in sorted(others):
            with self.subTest(suite=suite):
                self.run_image("cortex-m3", plain[suite])


def add(target):
    expected = SUITES - BEYOND_16_KB if targets.MACHINES[target]["small"] else SUITES
    name = "test_" + target.replace("-", "_")
    setattr(Suites, name, lambda self: self.run_on(target, expected))


for _target in targets.MACHINES:
    add(_target)

if __name__ == "__main__":
    unittest.main()
