"""WP proves every contract of this folder, and no longer proves it with an injected fault."""

import pytest
from contracts import unproved

pytestmark = [pytest.mark.soak, pytest.mark.inputs("tests/proofs", "lib")]

# File, text, the fault, the assertion that finds it.
FAULTS = (
    (
        "lib/src/number/q15.inc",
        "davar_multiply_i32(head - tail, head + tail)",
        "davar_multiply_i32(tail - head, head + tail)",
        "@ensures",
    ),
    (
        "lib/src/core/slide.inc",
        "(2 * (difference_t)before[lag]) + *before",
        "(2 * (difference_t)before[lag]) + before[1]",
        "head",
    ),
    ("lib/src/core/slide.inc", "after = tail[span];", "after = tail[span - 1U];", "tail"),
)
STEPS = 2_000_000  # three times as many as the right code needs


@pytest.mark.parametrize("bound", ("-DWIDE=0", "-DWIDE=1"))
def test_every_goal_of_the_step_is_proved(bound):
    assert unproved("slide", (bound,))[0] == []


@pytest.mark.parametrize("file, text, fault, assertion", FAULTS)
def test_an_assertion_is_proved_without_a_fault_alone(file, text, fault, assertion):
    narrow, only = ("-DWIDE=0",), (assertion,)
    assert unproved("slide", narrow, None, only, STEPS)[0] == []
    assert unproved("slide", narrow, (file, text, fault), only, STEPS)[0]
