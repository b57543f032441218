"""Units as data sheets print them: deg/sqrt(hr), °/√h, mdps/√Hz, °/sec/√Hz rms. They determine
which effect a number is the size of."""

import re
import unicodedata
from fractions import Fraction
from typing import NamedTuple

from ..errors import BadInput
from ..tables.constants import DEG_PER_RAD, GRAVITY_MPS2

LONGEST = 60  # characters of a unit: degrees per second per square root of hertz has 43
POWER = r"-?\d(?:\.\d+|/[1-9])?"
ROOT = r"(?<![a-z])(?:sqrt|(?:square[\s-]*)?root(?:\s+of\b)?|rt)[\s-]*"
NO_UNIT = r",?\s*[(-]?(?:\brms\b|\btyp(?:ical\b|\b\.?)|\b1\s*(?:σ|sigma\b))\)?"
SIGNS = str.maketrans(
    {"º": "°", "˚": "°", "∘": "°", "−": "-", "‐": "-", "–": "-", "⁄": "/", "∕": "/"}
    | dict.fromkeys("·⋅•×", "*")
)


ZERO, HALF, ONE = Fraction(0), Fraction(1, 2), Fraction(1)


class Unit(NamedTuple):
    """Its size in deg, m, s and Hz, and their powers."""

    size: float = 1.0
    deg: Fraction = ZERO
    m: Fraction = ZERO
    s: Fraction = ZERO
    hz: Fraction = ZERO

    def times(self, other: "Unit", power: Fraction = ONE) -> "Unit":
        """This unit times a power of another one. Raises OverflowError."""
        powers = (mine + power * theirs for mine, theirs in zip(self[1:], other[1:]))
        return Unit(self.size * other.size ** float(power), *powers)


QUANTITIES = {
    **dict.fromkeys(("deg", "degs", "degree", "degrees", "°"), Unit(1.0, deg=ONE)),
    **dict.fromkeys(("rad", "rads", "radian", "radians"), Unit(DEG_PER_RAD, deg=ONE)),
    "dps": Unit(1.0, deg=ONE, s=-ONE),
    **dict.fromkeys(("m", "metre", "metres", "meter", "meters"), Unit(1.0, m=ONE)),
    "g": Unit(GRAVITY_MPS2, m=ONE, s=-2 * ONE),
}
PREFIXES = {"m": 1e-3, "u": 1e-6, "μ": 1e-6}
PER = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), Unit(1.0, s=ONE)),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), Unit(3600.0, s=ONE)),
    **dict.fromkeys(("hz", "hertz"), Unit(1.0, hz=ONE)),
}
# powers of s and Hz in the unit of a gyro; of an accelerometer, s has one less
KINDS = {
    (-HALF, ZERO): "angle_random_walk",
    (-ONE, -HALF): "angle_random_walk",
    (-ONE, ZERO): "bias_instability",
    (-3 * HALF, ZERO): "rate_random_walk",
    (-2 * ONE, -HALF): "rate_random_walk",
}


def plain(text: str) -> str:
    """A unit with one sign each for degree, root, per and times, without words that change no
    number."""
    text = unicodedata.normalize("NFKC", text.translate(SIGNS)).translate(SIGNS)
    for pattern, sign in ((NO_UNIT, ""), (ROOT, "√"), (r"\bper\b", "/"), (r"\*\*", "^")):
        text = re.sub(pattern, sign, text, flags=re.IGNORECASE)
    return text.strip()


class Reader:
    """Reads a unit of plain() from left to right."""

    def __init__(self, text: str) -> None:
        self.rest, self.capitals = text, text.upper() == text

    def take(self, pattern: str) -> str | None:
        """What comes next, if it matches."""
        found = re.match(rf"\s*({pattern})", self.rest, re.IGNORECASE)
        if found:
            self.rest = self.rest[found.end() :]
        return found[1] if found else None

    def ratio(self) -> Unit:
        """PRODUCT, or PRODUCT/FACTOR/FACTOR. In deg/s*h, what is divided by is unclear."""
        found = self.product()
        while self.take("/"):
            found = found.times(self.factor(), -ONE)
        return found

    def product(self) -> Unit:
        """FACTOR*FACTOR, FACTOR-FACTOR or FACTOR FACTOR."""
        found = self.factor()
        while self.take(r"[*-]|(?=[a-zμ°√(])") is not None:
            found = found.times(self.factor())
        return found

    def factor(self) -> Unit:
        """√FACTOR, WORD or (RATIO), each with or without a power: s^2, s2, h^(1/2)."""
        if self.take("√"):
            return Unit().times(self.factor(), HALF)
        found = self.group() if self.take(r"\(") else self.word()
        power = self.take(rf"\^?\s*(?:\({POWER}\)|{POWER})")
        return Unit().times(found, Fraction(power.strip("^() "))) if power else found

    def group(self) -> Unit:
        found = self.ratio()
        if not self.take(r"\)"):
            raise BadInput("a ) is missing, or stands elsewhere")
        return found

    def word(self) -> Unit:
        """A quantity, with or without a prefix, or what a sheet states it per."""
        said = self.take("[a-zμ]*°|[a-zμ]+")
        if said is None:
            raise BadInput(f"a unit expected, found '{self.rest.strip()}'")
        name = said.lower()
        if name in QUANTITIES or name in PER:
            return (QUANTITIES | PER)[name]
        if name[0] not in PREFIXES or name[1:] not in QUANTITIES:
            raise BadInput(f"unknown unit '{said}'")
        if said[0] == "M" and not self.capitals:
            raise BadInput(f"the M of {said} is mega. Type {name}")
        return Unit(PREFIXES[name[0]]).times(QUANTITIES[name[1:]])


def unit_of(text: str) -> Unit:
    """Raises BadInput for what is no unit."""
    if len(text) > LONGEST:  # in which parentheses nest only so deep
        raise BadInput(f"a unit has at most {LONGEST} characters")
    reader = Reader(plain(text))
    try:
        found = reader.ratio()
    except OverflowError:
        raise BadInput("its powers are too high") from None
    if reader.rest.strip():
        raise BadInput(f"'{reader.rest.strip()}' follows a complete unit")
    return found


def meaning(text: str) -> tuple[bool, str, float]:
    """Of a unit: is it one of an accelerometer, the kind of effect, and the factor to deg and s; of
    an accelerometer to m and s. Raises BadInput for what sizes no effect of a data sheet."""
    unit = unit_of(text)
    accel = (unit.deg, unit.m) == (ZERO, ONE)
    kind = KINDS.get((unit.s + accel, unit.hz))
    if kind is None or not (accel or (unit.deg, unit.m) == (ONE, ZERO)):
        raise BadInput(f"'{text}' is not a unit of a random walk or a bias instability")
    if kind == "bias_instability" and re.search(r"\brms\b", text, re.I) and "h" not in plain(text):
        raise BadInput(
            f"'{text}' is the noise of all frequencies together. Divide it by the root of its "
            "bandwidth in Hz (1.57 times the cutoff of one pole, 1.11 of two), and type it per √Hz"
        )
    return accel, kind, unit.size
