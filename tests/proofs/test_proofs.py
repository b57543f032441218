"""Every proof of this folder leaves the alarms of alarms.txt and no other, and finds a fault that is planted in what it proves."""

import shutil
import tempfile
import unittest
from pathlib import Path

from proving import ROOT, listed, prove

# proof: (file of lib/src, what stands there, the fault, bounds that are enough to find it)
PLANTS = {
    "decode": [("wire/decode.c", "if (frame->length != message_length(message)) {", "if (frame->length > 80U) {", ()),
               ("wire/decode.c", "wire->adev[t] =", "wire->adev[t + 1U] =", ())],
    "slcan": [("wire/slcan.c", "if ((length != bare) && (length != bare + STAMP)) {", "if (length > bare + STAMP) {", ()),
              ("wire/slcan.c", "(length < HEAD)", "(length < HEAD - 1U)", ())],
    "number": [("number/logarithm.c", "(mantissa >> 26U) & 31U", "(mantissa >> 26U) & 63U", ()),
               ("number/real.h", ">> (31U - zeros)", ">> (32U - zeros)", ())],
    "slide": [("window/slide.h", "*(head - span)", "*(head - span - 1U)", ("-DLARGEST=16U",)),
              ("window/number_q15.h", "typedef int32_t difference_t", "typedef int16_t difference_t", ("-DLARGEST=16U",))],
    "restore": [("state.c", "(left < sizeof part) ? left : sizeof part", "left", ("-DWIDE=0",)),
                ("state.c", "& 15U]", "& 31U]", ("-DWIDE=0",))],
    "push": [("window/ring.h", "((ring->next < age) ? ring", "((ring->next + 1U < age) ? ring", ("-DPUSHES=12U", "-DGAPS=2U")),
             ("window/gaps.c", "gaps->count == gaps->capacity", "gaps->count > gaps->capacity", ("-DPUSHES=12U", "-DGAPS=2U"))],
}


class Proofs(unittest.TestCase):
    def holds(self, name, *bounds):
        alarms, _ = prove(name, bounds)
        self.assertEqual(alarms, listed(name))
        for file, fault, planted, enough in PLANTS[name] if bounds in ((), ("-DWIDE=0",)) else ():
            with self.subTest(planted=f"{file}: {planted}"):
                self.assertTrue(self.alarms_of_plant(name, file, fault, planted, enough) - listed(name))

    def alarms_of_plant(self, name, file, text, fault, bounds):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(ROOT / "lib", f"{folder}/lib")
            source = Path(folder, "lib/src", file)
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

    def test_restore_q15(self):
        self.holds("restore", "-DWIDE=0")

    def test_restore_q31(self):
        self.holds("restore", "-DWIDE=1")


if __name__ == "__main__":
    unittest.main()
