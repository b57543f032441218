"""The floor of a setup for flight: what davar/floor.h gets, and its plan."""

import re
from dataclasses import dataclass
from typing import NamedTuple

from . import programs
from .wishes import BadOption, Wishes

FAST_HZ = 1000.0  # a floor works on sums of counts that come faster, at twice that or more
SLOWEST_HZ = 400.0  # of the sums, if a low-pass leaves too few frequencies of faster ones
SLOW_HZ = 800.0  # below, its block has half as many samples
SUMMED_MOST = 255  # so that a sum of 24 bits has 32
BITS = {"int16": 16, "int32": 24}  # of a count
NEEDED = 23  # usable frequencies for a value, DAVAR_FLOOR_NEEDED
LIMITED = 8  # and for an upper limit


@dataclass(frozen=True)
class Floor:
    """What the floors of all axes work on: samples, or sums of them."""

    summed: int  # samples in a sum
    rate_hz: float
    lsb: float
    rail: int
    block: int  # sums between results; a window has four blocks and 32
    bandwidth: str  # with that of the sums

    @property
    def every_s(self) -> float:
        return self.block / self.rate_hz

    @property
    def window_s(self) -> float:
        return (4 * self.block + 32) / self.rate_hz


def floor(wishes: Wishes) -> Floor | None:
    """The floor of a setup for flight; None: it has none. The fewest samples in a sum behind which
    enough frequencies are usable, or that leave most of them."""
    if wishes.motion != "flight" or wishes.lsb is None or wishes.bandwidth is None:
        return None
    least = min(max(1, int(wishes.rate_hz // FAST_HZ)), SUMMED_MOST)
    most = min(max(least, int(wishes.rate_hz // SLOWEST_HZ)), SUMMED_MOST)
    choices = [
        _of(wishes, wishes.lsb, wishes.bandwidth, summed) for summed in range(least, most + 1)
    ]
    enough = (one for one in choices if _usable(one) >= NEEDED)
    return next(enough, None) or max(choices, key=_usable)


def _of(wishes: Wishes, lsb: float, bandwidth: str, summed: int) -> Floor:
    rate = wishes.rate_hz / summed
    return Floor(
        summed,
        rate,
        lsb / summed,
        rail=summed * (2 ** (BITS[wishes.type] - 1) - 1),
        block=128 if rate < SLOW_HZ else 256,
        bandwidth=_of_sums(bandwidth, summed),
    )


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


class FloorPlan(NamedTuple):
    """text: C of the plan, an initialiser. usable: frequencies."""

    text: str
    usable: int


def plan(wishes: Wishes) -> FloorPlan | None:
    """The plan of the floor; None: there is none. Raises BadOption."""
    chosen = floor(wishes)
    if chosen is None:
        return None
    programs.passed_samples(wishes.bandwidth or "", wishes.rate_hz)  # is the filter itself good?
    try:
        return _planned(chosen)
    except BadOption:
        raise BadOption(
            f"--motion: flight works on sums of {chosen.summed} samples at this rate, and "
            f"{chosen.bandwidth} is too long a filter: push samples before it"
        ) from None


def _planned(floor: Floor) -> FloorPlan:
    """Raises BadOption for a filter that the library rejects."""
    words = ["--rate", repr(floor.rate_hz), "--lsb", repr(floor.lsb), "--rail", str(floor.rail)]
    text = programs.run(programs.PROGRAM, "--floor", *words, "--bandwidth", floor.bandwidth)
    usable = re.search(r"\.usable = (\d+)", text)
    assert usable
    return FloorPlan(text[text.index("= {") + 2 :].rstrip().rstrip(";"), int(usable[1]))


def _usable(floor: Floor) -> int:
    """Frequencies; 0 for a filter that the library rejects."""
    try:
        return _planned(floor).usable
    except BadOption:
        return 0
