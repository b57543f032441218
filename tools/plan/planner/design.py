"""From wishes to candidates: everything that a setup needs, in samples."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from .wishes import Wishes

ARW_PERCENT = 10.0  # usual wishes
RESPOND_S = 5.0
FALSE_ALARMS_PER_HOUR = 0.01
RESULTS_PER_RESPOND = 9  # eight strides are a window, one passes until the next result
TAUS_MOST = 8
TAUS_LEAST = 4
TAUS_ALL = 32  # largest DAVAR_TAUS_MAX
SUM_BITS = {"int16": 32, "int32": 80, "float": 66}  # window m^2 4^bits, lib/DESIGN.md (2.4)
WINDOW_MOST = {"int16": 65536, "int32": 1 << 24, "float": 1 << 24}
BLOCK = 10
BLOCKS_LEAST, BLOCKS_MOST = 8, 768
CASCADE_LEAST = 64
CASCADE_TAUS_MOST = 24
CASCADE_CLUSTERS = 32
GAPS = 4


@dataclass(frozen=True)
class Design:
    """One way to meet the wishes."""

    wishes: Wishes
    law: str  # "fixed" or "glr"
    window: int
    shortest: int  # window after a cut; fixed: the window
    stride: int
    taus: tuple[int, ...]
    fit: str  # "arw" or "terms"
    cascade_shortest: int = 0
    cascade_taus: int = 0

    @property
    def sizes(self) -> int:
        """All cluster sizes: DAVAR_TAUS_MAX."""
        return len(self.taus) + self.cascade_taus

    @property
    def taus_s(self) -> list[float]:
        rate = self.wishes.rate_hz
        slow = [self.cascade_shortest << i for i in range(self.cascade_taus)]
        return [m / rate for m in (*self.taus, *slow)]

    @property
    def kind(self) -> str:
        """The row of the cost table."""
        slow = "cascade" if self.cascade_taus else "window"
        return f"{self.wishes.type} {self.law} {slow} {self.fit}"
