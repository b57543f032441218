"""WP proves every contract of this folder, and no longer proves it with an injected fault. Results
are cached until the library, this folder or Frama-C change.
"""

import unittest

from contracts import HERE, ROOT, run, unproved
from test_proofs import PASSED, result_cache

FAULTS = [  # file, text, the fault, the assertion that finds it
    (
        "lib/src/pipeline/type_q15.inc",
        "davar_multiply_i32(head - tail, head + tail)",
        "davar_multiply_i32(tail - head, head + tail)",
        "@ensures",
    ),
    (
        "lib/src/pipeline/slide.inc",
        "(2 * (difference_t)before[lag]) + *before",
        "(2 * (difference_t)before[lag]) + before[1]",
        "head",
    ),
    ("lib/src/pipeline/slide.inc", "after = tail[span];", "after = tail[span - 1U];", "tail"),
]
STEPS = 2_000_000  # three times as many as the right code needs


class Contracts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        versions = [run(["frama-c", "-version"]), run(["why3", "config", "list-supported-provers"])]
        versions += [run(["z3", "--version"]), run(["cvc4", "--version"])]
        files = [*(ROOT / "lib").rglob("*"), *HERE.glob("contract*"), HERE / "test_contracts.py"]
        cls.reads = [*versions, *sorted(path for path in files if path.is_file())]

    def holds(self, work, *key):
        PASSED.check(result_cache.content_key(*key, *self.reads), work)

    def proved(self, *bounds):
        failed, _ = unproved("slide", bounds)
        self.assertEqual(failed, [])
        return True

    def found(self, file, text, fault, assertion):
        """The assertion is proved without the fault, but not with it."""
        narrow = ("-DWIDE=0",)
        self.assertEqual(unproved("slide", narrow, None, (assertion,), STEPS)[0], [])
        self.assertTrue(unproved("slide", narrow, (file, text, fault), (assertion,), STEPS)[0])
        return True

    def test_slide_q15(self):
        self.holds(lambda: self.proved("-DWIDE=0"), "-DWIDE=0")

    def test_slide_q31(self):
        self.holds(lambda: self.proved("-DWIDE=1"), "-DWIDE=1")

    def test_faults(self):
        for fault in FAULTS:
            with self.subTest(fault[2]):
                self.holds(lambda fault=fault: self.found(*fault), *fault)


if __name__ == "__main__":
    unittest.main()
