"""The floor of a setup for flight: what davar/floor.h gets, and its plan."""

import re
from dataclasses import dataclass
from typing import NamedTuple

from . import programs
from .wishes import BadOption, Wishes

FAST_HZ = 1000.0  # a floor works on sums of counts that come faster, at twice that or more
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
    """The floor of a setup for flight; None: it has none."""
    if wishes.motion != "flight" or wishes.lsb is None or wishes.bandwidth is None:
        return None
    summed = min(max(1, int(wishes.rate_hz // FAST_HZ)), SUMMED_MOST)
    rate = wishes.rate_hz / summed
    return Floor(
        summed,
        rate,
        wishes.lsb / summed,
        rail=summed * (2 ** (BITS[wishes.type] - 1) - 1),
        block=128 if rate < SLOW_HZ else 256,
        bandwidth=_of_sums(wishes.bandwidth, summed),
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
    words = ["--rate", repr(chosen.rate_hz), "--lsb", repr(chosen.lsb), "--rail", str(chosen.rail)]
    try:
        text = programs.run(programs.PROGRAM, "--floor", *words, "--bandwidth", chosen.bandwidth)
    except BadOption:
        raise BadOption(
            f"--motion: flight works on sums of {chosen.summed} samples at this rate, and "
            f"{chosen.bandwidth} is too long a filter: push samples before it"
        ) from None
    usable = re.search(r"\.usable = (\d+)", text)
    assert usable
    return FloorPlan(text[text.index("= {") + 2 :].rstrip().rstrip(";"), int(usable[1]))
