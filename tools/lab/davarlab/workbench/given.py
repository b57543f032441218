"""Numbers that a page sent."""

import contextlib
import math

from ..errors import BadInput


def whole(value, what):
    """A whole number that a page sent."""
    try:
        return int(value)
    except (TypeError, ValueError):
        raise BadInput(f"{what}: a whole number expected, found {value!r}") from None


def real(value, what):
    """A finite number that a page sent."""
    with contextlib.suppress(TypeError, ValueError):
        if math.isfinite(float(value)):
            return float(value)
    raise BadInput(f"{what}: a number expected, found {value!r}")
