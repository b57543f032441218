"""WP proves every contract of this folder, and no longer proves it with an injected fault."""

import pytest
from contracts import unproved

pytestmark = [pytest.mark.soak, pytest.mark.inputs("tests/proofs", "lib")]

TAP = ("(2 * (difference_t)before[lag]) + *before", "(2 * (difference_t)before[lag]) + before[1]")
STEPS = 2_000_000  # three times as many as the right code needs


@pytest.mark.parametrize("bound", ("-DWIDE=0", "-DWIDE=1"))
def test_every_goal_of_the_step_is_proved(bound):
    assert unproved("slide", (bound,))[0] == []


def test_an_assertion_is_proved_without_a_fault_alone():
    narrow, only = ("-DWIDE=0",), ("head",)
    assert unproved("slide", narrow, None, only, STEPS)[0] == []
    assert unproved("slide", narrow, ("lib/src/core/slide.inc", *TAP), only, STEPS)[0]
