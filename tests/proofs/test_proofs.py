"""Every proof of this folder gives exactly the alarms of alarms.txt, and detects an injected fault
in its subject.
"""

import shutil

import pytest
from proving import ROOT, listed, prove

pytestmark = pytest.mark.inputs("tests/proofs", "lib", "port/wire", "tools/support")

# Proof, its bounds.
CASES = (
    ("decode", ()),
    ("slcan", ()),
    ("number", ()),
    ("slide", ()),
    ("push", ()),
    ("push", ("-DWIDE=1", "-DGAPS=3U")),
    ("push", ("-DSTRIDE=4", "-DGAPS=3U")),
    ("restore", ("-DWIDE=0",)),
    ("restore", ("-DWIDE=1",)),
)
SHORT = ("-DPUSHES=12U", "-DGAPS=2U")
# Proof, file, original text, the fault, bounds that are enough to find it.
FAULTS = (
    (
        "decode",
        "port/wire/decode.c",
        "if (frame->length != message_length(message)) {",
        "if (frame->length > 80U) {",
        (),
    ),
    ("decode", "port/wire/decode.c", "wire->adev[t] =", "wire->adev[t + 1U] =", ()),
    (
        "slcan",
        "port/wire/slcan.c",
        "if ((length != bare) && (length != bare + STAMP)) {",
        "if (length > bare + STAMP) {",
        (),
    ),
    ("slcan", "port/wire/slcan.c", "(length < HEAD)", "(length < HEAD - 1U)", ()),
    (
        "number",
        "lib/src/detector/logarithm.c",
        "(mantissa >> 26U) & 31U",
        "(mantissa >> 26U) & 63U",
        (),
    ),
    ("number", "lib/src/number/real.h", ">> (31U - zeros)", ">> (32U - zeros)", ()),
    (
        "slide",
        "lib/src/pipeline/slide.inc",
        "*(head - span)",
        "*(head - span - 1U)",
        ("-DLARGEST=16U",),
    ),
    (
        "slide",
        "lib/src/pipeline/type_q15.inc",
        "typedef int32_t difference_t",
        "typedef int16_t difference_t",
        ("-DLARGEST=16U",),
    ),
    (
        "restore",
        "lib/src/state/image.c",
        "(left < sizeof part) ? left : sizeof part",
        "left",
        ("-DWIDE=0",),
    ),
    ("restore", "lib/src/state/image.c", "& 15U]", "& 31U]", ("-DWIDE=0",)),
    *(
        (
            "push",
            "lib/src/pipeline/allan.inc",
            "((ring->next < age) ? ring",
            "((ring->next + 1U < age) ? ring",
            bounds,
        )
        for bounds in (SHORT, ("-DSTRIDE=4", "-DPUSHES=12U", "-DGAPS=0U"))
    ),
    (
        "push",
        "lib/src/core/gaps.c",
        "gaps->count == gaps->capacity",
        "gaps->count > gaps->capacity",
        SHORT,
    ),
    (
        "push",
        "lib/src/pipeline/type_q31.inc",
        "typedef int64_t difference_t",
        "typedef int32_t difference_t",
        ("-DWIDE=1", "-DPUSHES=4U", "-DGAPS=0U"),
    ),
)


@pytest.mark.parametrize("name, bounds", CASES)
def test_a_proof_has_no_other_alarms_than_those_listed(name, bounds):
    assert prove(name, bounds)[0] == listed(name)


@pytest.mark.parametrize("name, file, text, fault, bounds", FAULTS)
def test_a_proof_finds_a_fault(name, file, text, fault, bounds, tmp_path):
    for part in ("lib", "port/wire"):
        shutil.copytree(ROOT / part, tmp_path / part)
    source = tmp_path / file
    before = source.read_text()
    assert text in before
    source.write_text(before.replace(text, fault, 1))
    assert prove(name, bounds, tmp_path)[0] - listed(name)
