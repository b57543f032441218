"""From wishes to candidates: everything that a setup needs, in samples."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from . import programs
from .floors import Floor, floor
from .wishes import ENGINES, Wishes, suits_small

RESPOND_S = 5.0  # usual wishes
ARW_PERCENT = 10.0
FALSE_ALARMS_PER_HOUR = 0.01

WINDOWS = (8, 4, 2)  # results per window: fewer need less memory, and a shorter window
TAUS_USUAL = 8
TAUS_MOST = 32  # of window and cascade
SUM_BITS = {"int16": 32, "int32": 80, "float": 66}  # W m^2, lib/DESIGN.md (2.4)
WINDOW_LEAST = 16
WINDOW_MOST = {"int16": 65536, "int32": 1 << 24, "float": 1 << 24}
BLOCK = 10  # of law glr
BLOCKS_LEAST, BLOCKS_MOST = 8, 768
SIZES_AFTER_CUT = 8, 32  # largest cluster size of law glr: a window after a cut has two of them
STRIDE_MOST = 100  # of law glr: an alarm waits for the next result
MEAN_WINDOW = 2 / 3  # of law glr in unchanged noise, over its longest
CASCADE_LEAST = 64
CASCADE_TAUS_MOST = 24
CASCADE_CLUSTERS = 32
CASCADE_BITS = {"int16": 31, "int32": 27, "float": 28}  # of the largest size, (11.4)
GAPS_LEAST, GAPS_MOST = 4, 65534  # even, so that the memory has no padding
NUMBER = {"int16": "Q15", "int32": "Q31", "float": "F32"}


@dataclass(frozen=True)
class Design:
    """One way to meet the wishes. Lengths in samples."""

    wishes: Wishes
    law: str  # "fixed" or "glr"
    engine: str  # "slide", "grid" or "small"
    fit: (
        str  # "arw": of the window; "curve": and deviations of a cascade; "terms": and a fit of all
    )
    window: int
    shortest: int
    stride: int
    taus: tuple[int, ...]
    cascade_shortest: int = 0
    cascade_taus: int = 0

    @property
    def long_taus(self) -> tuple[int, ...]:
        """Cluster sizes of the cascade."""
        return tuple(self.cascade_shortest << i for i in range(self.cascade_taus))

    @property
    def taus_max(self) -> int:
        """DAVAR_TAUS_MAX: of one result."""
        if self.fit == "terms":
            return len(self.taus) + self.cascade_taus
        return max(len(self.taus), self.cascade_taus)

    @property
    def gaps(self) -> int:
        """That a window stores: of lost samples, one more restarts it once in 10^4 windows."""
        if self.engine == "small":
            return 0
        usual = (self.window + self.stride) * self.wishes.lost_percent / 100
        count = math.ceil(usual + 4 * math.sqrt(usual)) + GAPS_LEAST
        return min(count + count % 2, GAPS_MOST)

    @property
    def gap_bytes(self) -> int:
        """Of an instance, beyond the macro, which has room for the least."""
        return 4 * (self.gaps - GAPS_LEAST)

    @property
    def taus_s(self) -> list[float]:
        """All averaging times."""
        return [m / self.wishes.rate_hz for m in self.taus + self.long_taus]

    @property
    def respond_s(self) -> float:
        """Until a result of a fixed window depends on the new noise alone."""
        return (self.window + self.stride) / self.wishes.rate_hz

    @property
    def memory(self) -> tuple[str, tuple[int, ...]]:
        """The memory of an instance: its macro (Q15: DAVAR_MEMORY, GRID_Q15: DAVAR_MEMORY_GRID) and
        the arguments.
        """
        number = NUMBER[self.wishes.type]
        by = "GLR_" if self.law == "glr" else "GRID_" if self.engine == "grid" else ""
        return by + number, (self.window, self.stride, self.taus[-1], len(self.taus))

    @property
    def floor(self) -> Floor | None:
        """Of each axis; None: the setup is not for flight."""
        return floor(self.wishes)

    @property
    def filtered(self) -> bool:
        """Its samples are not declared white."""
        return self.wishes.bandwidth != "none"

    @property
    def kind(self) -> str:
        """Its row among the windows of the cost table."""
        filtered = self.engine != "small" or self.filtered
        return f"{self.wishes.type} {self.law} {self.engine}" + ("" if filtered else " white")


def noise_counts(wishes: Wishes) -> float:
    """The typical white noise of a sample before the filter, in counts; 0: unknown."""
    if wishes.noise is None or wishes.lsb is None or wishes.type == "float":
        return 0.0
    return wishes.noise / 60 * math.sqrt(wishes.rate_hz) / wishes.lsb


def _filter_samples(wishes: Wishes) -> int:
    """From this cluster size on, a filter matters little. Raises BadOption for a bad filter."""
    if wishes.bandwidth is None:
        return 1
    return 2 * programs.passed_samples(wishes.bandwidth, wishes.rate_hz)


def _octaves(largest: float, most: int) -> tuple[int, ...]:
    return tuple(1 << i for i in range(most) if i == 0 or (1 << i) <= largest)


def _largest_size(wishes: Wishes, window: int) -> float:
    """The largest cluster size that the exact sums and the 25 % rule allow."""
    return min(window / 9, math.sqrt(2 ** SUM_BITS[wishes.type] / window))


def _taus(wishes: Wishes, window: int) -> tuple[int, ...]:
    usual = max(TAUS_USUAL, math.ceil(math.log2(_filter_samples(wishes))) + 3)
    return _octaves(_largest_size(wishes, window), min(usual, 16))


def _with_cascade(design: Design) -> Iterator[Design]:
    """The design with what the longest wished averaging time needs."""
    longest = design.wishes.longest_tau_s
    samples = 0.0 if longest is None else longest * design.wishes.rate_hz
    if samples <= design.taus[-1]:
        yield replace(design, fit="arw")
        return
    if design.engine == "small":
        return
    shortest = max(CASCADE_LEAST, 2 * design.taus[-1])
    count = 1 + max(0, math.ceil(math.log2(samples / shortest) - 1e-9))
    fits_sums = (shortest << (count - 1)) <= 2 ** CASCADE_BITS[design.wishes.type]
    if count <= min(CASCADE_TAUS_MOST, TAUS_MOST - len(design.taus)) and fits_sums:
        for fit in ("terms", "curve"):
            yield replace(design, fit=fit, cascade_shortest=shortest, cascade_taus=count)


def _engines(wishes: Wishes, stride: int) -> tuple[str, ...]:
    """Those to choose from: the others need a stride."""
    if stride == 1:
        return ("slide",)
    possible = ENGINES if suits_small(wishes) else ENGINES[:2]
    return (wishes.engine,) if wishes.engine else possible


def _fixed(wishes: Wishes, strides: Iterable[float]) -> Iterator[Design]:
    """Fixed windows with these strides for each of WINDOWS, or the longest ones."""
    for results, wished in zip(WINDOWS, strides):
        stride = max(1, int(min(wished, WINDOW_MOST[wishes.type] / results)))
        window = results * stride
        if window >= WINDOW_LEAST:
            taus = _taus(wishes, window)
            for engine in _engines(wishes, stride):
                base = Design(wishes, "fixed", engine, "arw", window, window, stride, taus)
                yield from _with_cascade(base)


def fixed(wishes: Wishes) -> list[Design]:
    """Fixed windows for the wished time of response, best first."""
    respond = RESPOND_S if wishes.respond_s is None else wishes.respond_s
    return list(_fixed(wishes, (respond * wishes.rate_hz / (results + 1) for results in WINDOWS)))


def fixed_of_window(wishes: Wishes, window: int) -> list[Design]:
    """Fixed windows of about that length, best first."""
    return list(_fixed(wishes, (window / results for results in WINDOWS)))


def glr(wishes: Wishes, window: int) -> list[Design]:
    """Law glr with that window on average, best first."""
    blocks = min(math.ceil(window / MEAN_WINDOW / BLOCK), BLOCKS_MOST)
    alarms = wishes.false_alarms_per_hour or FALSE_ALARMS_PER_HOUR
    wishes = replace(wishes, false_alarms_per_hour=alarms)
    longest = BLOCK * max(blocks, 2 * BLOCKS_LEAST)
    respond = (wishes.respond_s or RESPOND_S) * wishes.rate_hz
    largest = min(max(respond / 8, SIZES_AFTER_CUT[0]), SIZES_AFTER_CUT[1])
    largest = max(largest, 2 ** math.ceil(math.log2(2 * _filter_samples(wishes))))
    taus = _octaves(min(largest, _largest_size(wishes, longest)), 16)
    shortest = BLOCK * max(2, math.ceil(2 * taus[-1] / BLOCK))
    stride = min(max(BLOCK, int(respond / 8) // BLOCK * BLOCK), STRIDE_MOST)
    design = Design(wishes, "glr", "grid", "arw", longest, shortest, stride, taus)
    return list(_with_cascade(design))
