"""The floor of a setup for flight: what davar/floor.h gets, and its plan."""

import re
from dataclasses import dataclass

from . import programs
from .wishes import BadOption, Wishes

FAST_HZ = 1000.0  # a floor works on sums of counts that come faster, at twice that or more
SLOWEST_HZ = 400.0  # of the sums, if a low-pass leaves too few frequencies of faster ones
SUMMED_MOST = 255  # so that a sum of 24 bits has 32
BITS = {"int16": 16, "int32": 24}  # of a count
HOP = 32  # samples from segment to segment
NEEDED = 23  # usable frequencies for a value, DAVAR_FLOOR_NEEDED
LIMITED = 8  # and for an upper limit, DAVAR_FLOOR_LIMITED


@dataclass(frozen=True)
class Floor:
    """What the floors of all axes work on: samples, or sums of them; and their plan."""

    summed: int  # samples in a sum
    rate_hz: float
    lsb: float
    rail: int
    plan: str  # an initialiser in C
    segments: int  # of a block
    usable: int  # frequencies

    @property
    def block(self) -> int:
        """Sums between results."""
        return HOP * self.segments

    @property
    def every_s(self) -> float:
        return self.block / self.rate_hz

    @property
    def window_s(self) -> float:
        return (4 * self.block + HOP) / self.rate_hz


def floor(wishes: Wishes) -> Floor | None:
    """The floor of a setup for flight; None: it has none. The fewest samples in a sum behind which
    enough frequencies are usable, or that leave most of them. Raises BadOption."""
    if wishes.motion != "flight" or wishes.lsb is None or wishes.bandwidth is None:
        return None
    programs.passed_samples(wishes.bandwidth, wishes.rate_hz)  # is the filter itself good?
    least = min(max(1, int(wishes.rate_hz // FAST_HZ)), SUMMED_MOST)
    most = min(max(least, int(wishes.rate_hz // SLOWEST_HZ)), SUMMED_MOST)
    best = None
    for summed in range(least, most + 1):
        one = _planned(wishes, wishes.lsb, _of_sums(wishes.bandwidth, summed), summed)
        if one and one.usable >= NEEDED:
            return one
        if one and (best is None or one.usable > best.usable):
            best = one
    if best is None:
        raise BadOption(
            f"--motion: flight works on sums of {least} samples at this rate, and "
            f"{_of_sums(wishes.bandwidth, least)} is too long a filter: push samples before it"
        )
    return best


def _planned(wishes: Wishes, lsb: float, bandwidth: str, summed: int) -> Floor | None:
    """None for a filter that the library rejects."""
    rate, rail = wishes.rate_hz / summed, summed * (2 ** (BITS[wishes.type] - 1) - 1)
    words = ["--rate", repr(rate), "--lsb", repr(lsb / summed), "--rail", str(rail)]
    try:
        text = programs.run(programs.PROGRAM, "--floor", *words, "--bandwidth", bandwidth)
    except BadOption:
        return None
    segments, usable = (re.search(rf"\.{name} = (\d+)", text) for name in ("segments", "usable"))
    assert segments and usable
    plan = text[text.index("= {") + 2 :].rstrip().rstrip(";")
    return Floor(summed, rate, lsb / summed, rail, plan, int(segments[1]), int(usable[1]))


def _of_sums(bandwidth: str, summed: int) -> str:
    """A filter and then sums, which may be those of sums."""
    before, _, last = bandwidth.rpartition("+")
    found = re.fullmatch(r"sum:([0-9]+)", last)
    if summed == 1:
        return bandwidth
    if found:
        summed *= int(found[1])
    elif bandwidth != "none":
        before = bandwidth
    return f"{before}+sum:{summed}".removeprefix("+")
