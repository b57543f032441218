"""Every proof of this folder gives exactly the alarms of alarms.txt, and detects an injected fault
in its subject. Results are cached until the library, this folder or Frama-C change.
"""

import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from proving import HERE, ROOT, listed, prove

sys.path.insert(0, str(ROOT / "tools/support"))
import result_cache

# proof, and its bounds: (file, original text, the fault, bounds that are enough to find it)
STRIDE = ("-DSTRIDE=4",)
PLANTS = {
    "decode": [
        (
            "port/wire/decode.c",
            "if (frame->length != message_length(message)) {",
            "if (frame->length > 80U) {",
            (),
        ),
        ("port/wire/decode.c", "wire->adev[t] =", "wire->adev[t + 1U] =", ()),
    ],
    "slcan": [
        (
            "port/wire/slcan.c",
            "if ((length != bare) && (length != bare + STAMP)) {",
            "if (length > bare + STAMP) {",
            (),
        ),
        ("port/wire/slcan.c", "(length < HEAD)", "(length < HEAD - 1U)", ()),
    ],
    "number": [
        ("lib/src/detector/logarithm.c", "(mantissa >> 26U) & 31U", "(mantissa >> 26U) & 63U", ()),
        ("lib/src/number/real.h", ">> (31U - zeros)", ">> (32U - zeros)", ()),
    ],
    "slide": [
        ("lib/src/pipeline/slide.inc", "*(head - span)", "*(head - span - 1U)", ("-DLARGEST=16U",)),
        (
            "lib/src/pipeline/type_q15.inc",
            "typedef int32_t difference_t",
            "typedef int16_t difference_t",
            ("-DLARGEST=16U",),
        ),
    ],
    "restore": [
        (
            "lib/src/state/image.c",
            "(left < sizeof part) ? left : sizeof part",
            "left",
            ("-DWIDE=0",),
        ),
        ("lib/src/state/image.c", "& 15U]", "& 31U]", ("-DWIDE=0",)),
    ],
    "push": [
        (
            "lib/src/pipeline/allan.inc",
            "((ring->next < age) ? ring",
            "((ring->next + 1U < age) ? ring",
            ("-DPUSHES=12U", "-DGAPS=2U"),
        ),
        (
            "lib/src/core/gaps.c",
            "gaps->count == gaps->capacity",
            "gaps->count > gaps->capacity",
            ("-DPUSHES=12U", "-DGAPS=2U"),
        ),
    ],
    "push q31": [
        (
            "lib/src/pipeline/type_q31.inc",
            "typedef int64_t difference_t",
            "typedef int32_t difference_t",
            ("-DWIDE=1", "-DPUSHES=4U", "-DGAPS=0U"),
        )
    ],
    "push at a stride": [
        (
            "lib/src/pipeline/allan.inc",
            "((ring->next < age) ? ring",
            "((ring->next + 1U < age) ? ring",
            (*STRIDE, "-DPUSHES=12U", "-DGAPS=0U"),
        )
    ],
}


PASSED = result_cache.ResultCache(ROOT / "build/cache/proofs")


def tearDownModule():
    print(f"cached: {PASSED.hits}")


class Proofs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        version = subprocess.run(
            ["frama-c", "-version"], text=True, stdout=subprocess.PIPE, check=True
        ).stdout
        files = [
            path
            for folder in (ROOT / "lib", ROOT / "port/wire", HERE)
            for path in sorted(folder.rglob("*"))
            if path.suffix in (".c", ".h", ".inc", ".py", ".txt")
        ]
        cls.reads = [version, *files]

    def holds(self, which, *bounds):
        PASSED.check(
            result_cache.content_key(which, *bounds, *self.reads),
            lambda: self.prove(which, *bounds),
        )

    def prove(self, which, *bounds):
        name = which.split()[0]
        alarms, _ = prove(name, bounds)
        self.assertEqual(alarms, listed(name))
        for file, fault, planted, enough in PLANTS.get(which, ()):
            self.assertTrue(
                self.alarms_of_plant(name, file, fault, planted, enough) - listed(name),
                f"{file}: {planted}",
            )
        return True

    def alarms_of_plant(self, name, file, text, fault, bounds):
        with tempfile.TemporaryDirectory() as folder:
            for part in ("lib", "port/wire"):
                shutil.copytree(ROOT / part, f"{folder}/{part}")
            source = Path(folder, file)
            before = source.read_text()
            self.assertIn(text, before)
            source.write_text(before.replace(text, fault, 1))
            return prove(name, bounds, folder)[0]

    def test_decode(self):
        self.holds("decode")

    def test_slcan(self):
        self.holds("slcan")

    def test_number(self):
        self.holds("number")

    def test_slide(self):
        self.holds("slide")

    def test_push(self):
        self.holds("push")

    def test_push_q31(self):
        self.holds("push q31", "-DWIDE=1", "-DGAPS=3U")

    def test_push_at_a_stride(self):
        self.holds("push at a stride", *STRIDE, "-DGAPS=3U")

    def test_restore_q15(self):
        self.holds("restore", "-DWIDE=0")

    def test_restore_q31(self):
        self.holds("restore q31", "-DWIDE=1")


if __name__ == "__main__":
    unittest.main()
