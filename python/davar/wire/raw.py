"""Raw samples of a sender (DAVAR_Raw): which sample of which run each one is.

A sender counts its samples, what it lost among them; eighteen bits of that go out. Which sample it
was follows from the ones before, and across a silence from how far the epochs went on meanwhile."""

import math
import struct
from collections import deque
from collections.abc import Mapping
from typing import Any

COUNTS = 1 << 18  # of Index
HELD_MAX = COUNTS // 2  # samples, and how far off the place may be where they are expected
FAR = COUNTS // 4  # from here on a jump may hide whole turns of Index
SWAPPED = 64  # samples that frames may be late by

Sample = tuple[int, float]  # index, deg/s


def written(single: float) -> float:
    """A float32 as the number that it was before: 0.05, not 0.0500000007."""
    return next(
        value
        for value in (float(f"{single:.{digits}g}") for digits in range(6, 10))
        if struct.pack("<f", value) == struct.pack("<f", single)
    )


class Run:
    """Samples without a loss between them: counts (int), or rates (float)."""

    def __init__(self, index: int) -> None:
        self.index = index  # of the first, modulo COUNTS
        self.values: list[int | float] = []
        self.jumped = self.waited = (
            False  # jumped: not the one that was due; waited: held back when its place was known
        )

    def end(self) -> int:
        return (self.index + len(self.values)) % COUNTS

    def start(self, near: int) -> int:
        """The index of the first one, such that the last is nearest to a given one."""
        last = self.index + len(self.values) - 1
        return near - HELD_MAX + (last - near + HELD_MAX) % COUNTS - len(self.values) + 1


class Samples:
    """Those of one run of a sender, held until its setup and an epoch are known and a frame has
    told the session."""

    def __init__(self) -> None:
        self.runs: deque[Run] = deque()
        self.held = 0
        # The last index that was passed on; how far it was ahead of the epoch: at first, not
        # behind.
        self.passed, self.lead = -1, HELD_MAX - FAR // 16
        self.dated = False  # has a State come since the newest run began

    def take(self, signals: Mapping[str, Any]) -> int:
        """The samples of a frame. Returns how many of those that were held too long are given
        up."""
        values = [
            signals[name] for name in ("Count0", "Count1", "Count", "RateDps") if name in signals
        ]
        due = self.runs[-1].end() if self.runs else (self.passed + 1) % COUNTS
        if not self.runs or due != signals["Index"]:
            self.runs.append(Run(signals["Index"]))
            self.runs[-1].jumped = due != signals["Index"]
            jump = (signals["Index"] - due) % COUNTS
            self.dated = self.dated and min(jump, COUNTS - jump) < FAR
        self.runs[-1].values += values
        self.held += len(values)
        given_up = max(0, self.held - HELD_MAX)
        self.forget(given_up)
        return given_up

    def forget(self, count: int) -> None:
        """Gives up the oldest."""
        self.held -= count
        while count:
            run = self.runs[0]
            gone = min(count, len(run.values))
            del run.values[:gone]
            run.index = (run.index + gone) % COUNTS
            count -= gone
            if not run.values:
                self.runs.popleft()

    def sure(self) -> bool:
        """Is all that is held one frame that only waits for its next."""
        return len(self.runs) == 1 and self.runs[0].waited and len(self.runs[0].values) <= 2

    def drop(self) -> int:
        """Gives up what is held; returns how many."""
        held, self.runs, self.held = self.held, deque(), 0
        return held

    def split(self) -> tuple[int, "Samples"]:
        """Of two runs of a sender whose samples are held here: gives up those of the first, keeps
        those behind the widest jump. Returns (how many were given up, what is kept as Samples)."""
        ends = [self.passed + 1, *(run.end() for run in self.runs)]
        jumps = [(run.index - end) % COUNTS for run, end in zip(self.runs, ends)]
        first = max(range(len(jumps)), key=lambda at: min(jumps[at], COUNTS - jumps[at]), default=0)
        kept = Samples()
        kept.runs = deque(list(self.runs)[first:])
        kept.held = sum(len(run.values) for run in kept.runs)
        return self.drop() - kept.held, kept

    def release(self, epoch: int, unit: float, last: bool = False) -> tuple[list[Sample], int]:
        """([(index, deg/s)] of what is held, in order; how many are left out: late ones, and runs
        that the next one belies). What is no number is not there. A lone frame behind a jump waits
        for the next, unless these are the last."""
        runs, self.runs, self.held = list(self.runs), deque(), 0
        if runs[-1].jumped and len(runs[-1].values) <= 2 and not last:
            self.runs.append(runs.pop())
            self.runs[0].waited = True
            self.held = len(self.runs[0].values)
        if not runs:
            return [], 0
        starts = [run.start(epoch + self.lead) for run in runs]
        sound = [
            (run, start)
            for run, start, after in zip(runs, starts, [*starts[1:], starts[-1]])
            if start < after + SWAPPED
        ]
        found = sorted(
            (start + offset, value * unit if isinstance(value, int) else value)
            for run, start in sound
            for offset, value in enumerate(run.values)
        )
        kept = [(index, value) for index, value in found if index > self.passed]
        if kept:
            self.passed = kept[-1][0]
            self.lead = self.passed - epoch
        left_out = sum(len(run.values) for run in runs) - len(kept)
        return [(index, value) for index, value in kept if not math.isnan(value)], left_out
