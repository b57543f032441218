"""Every proof of this folder gives exactly the alarms of alarms.txt, and detects an injected fault
in its subject.
"""

import shutil

import pytest
from proving import ROOT, listed, prove

pytestmark = pytest.mark.inputs("tests/proofs", "lib", "addons", "tools/support")

NIGHT = pytest.mark.soak  # each takes a minute
# Proof, its bounds.
CASES = (
    ("decode", ()),
    ("slcan", ()),
    ("number", ()),
    ("slide", ()),
    ("push", ()),
    pytest.param("push", ("-DWIDE=1", "-DGAPS=3U"), marks=NIGHT),
    pytest.param("push", ("-DSTRIDE=4", "-DGAPS=3U"), marks=NIGHT),
    ("restore", ("-DWIDE=0",)),
    ("restore", ("-DWIDE=1",)),
)
TWICE_ROUND = ("-DPUSHES=18U", "-DGAPS=0U")  # the ring of nine samples
FEW_WIDE = ("-DWIDE=1", "-DPUSHES=4U", "-DGAPS=0U")
NARROW, SIZES = ("-DWIDE=0",), ("-DLARGEST=16U",)
RING = ("((ring->next < age) ? ring", "((ring->next + 1U < age) ? ring")
WIDTH = "typedef int%d_t difference_t"
# Proof, file, original text, the fault, bounds that are enough to find it.
FAULTS = (
    ("decode", "addons/can/src/decode.c", "wire->adev[t] =", "wire->adev[t + 1U] =", ()),
    ("slcan", "addons/can/src/slcan.c", "(length < HEAD)", "(length < HEAD - 1U)", ()),
    ("number", "lib/src/number/real.h", ">> (31U - zeros)", ">> (32U - zeros)", ()),
    ("slide", "lib/src/core/slide.inc", "*(head - span)", "*(head - span - 1U)", SIZES),
    ("restore", "addons/state/src/image.c", "& 15U]", "& 31U]", NARROW),
    ("push", "lib/src/core/allan.inc", *RING, TWICE_ROUND),
    ("push", "lib/src/number/q31.inc", WIDTH % 64, WIDTH % 32, FEW_WIDE),
)


@pytest.mark.parametrize("name, bounds", CASES)
def test_a_proof_has_no_other_alarms_than_those_listed(name, bounds):
    assert prove(name, bounds)[0] == listed(name)


@pytest.mark.parametrize("name, file, text, fault, bounds", FAULTS)
def test_a_proof_finds_a_fault(name, file, text, fault, bounds, tmp_path):
    for part in ("lib", "addons"):
        shutil.copytree(ROOT / part, tmp_path / part)
    source = tmp_path / file
    before = source.read_text()
    assert text in before
    source.write_text(before.replace(text, fault, 1))
    assert prove(name, bounds, tmp_path)[0] - listed(name)
