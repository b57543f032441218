"""Raw samples of a sender (DAVAR_Raw): which sample of which run each one is.

A sender counts its samples; eighteen bits of that go out. Which sample it was follows from the epochs: results come at most
half of those counts behind their samples."""

import math
import struct
from collections import deque

COUNTS = 1 << 18  # of Index
HELD_MAX = COUNTS // 2  # samples, and how far an epoch may be from them


def written(single):
    """A float32 as the number that it was before: 0.05, not 0.0500000007."""
    return next(value for value in (float(f"{single:.{digits}g}") for digits in range(6, 10))
                if struct.pack("<f", value) == struct.pack("<f", single))


class Run:
    """Samples without a loss between them: counts (int), or rates (float)."""

    def __init__(self, index):
        self.index, self.values = index, []  # index: of the first, modulo COUNTS

    def end(self):
        return (self.index + len(self.values)) % COUNTS

    def start(self, epoch):
        """The index of the first one, counted from the sender's first sample, beside a recent epoch."""
        last = self.index + len(self.values) - 1
        return epoch - HELD_MAX + (last - epoch + HELD_MAX) % COUNTS - len(self.values) + 1


class Samples:
    """Those of one run of a sender, held until its setup and an epoch are known and a frame has told the session."""

    def __init__(self):
        self.runs, self.held, self.passed = deque(), 0, -1  # passed: the last that was passed on

    def take(self, signals):
        """The samples of a frame. Returns how many of those that were held too long are given up."""
        values = [signals[name] for name in ("Count0", "Count1", "Count", "RateDps") if name in signals]
        if not self.runs or self.runs[-1].end() != signals["Index"]:
            self.runs.append(Run(signals["Index"]))
        self.runs[-1].values += values
        self.held += len(values)
        given_up = 0
        while self.held > HELD_MAX:
            given_up += len(self.runs[0].values)
            self.held -= len(self.runs.popleft().values)
        return given_up

    def drop(self):
        """Gives up what is held; returns how many."""
        held, self.runs, self.held = self.held, deque(), 0
        return held

    def split(self):
        """Of two runs of a sender whose samples are held here: gives up those of the first, keeps those behind the widest jump. Returns (how many were
        given up, what is kept as Samples)."""
        ends = [self.passed + 1, *(run.end() for run in self.runs)]
        jumps = [(run.index - end) % COUNTS for run, end in zip(self.runs, ends)]
        first = max(range(len(jumps)), key=lambda at: min(jumps[at], COUNTS - jumps[at]), default=0)
        kept = Samples()
        kept.runs = deque(list(self.runs)[first:])
        kept.held = sum(len(run.values) for run in kept.runs)
        return self.drop() - kept.held, kept

    def release(self, epoch, unit):
        """[(index, deg/s)] of what is held, in order; a late one, and one that is no number, are left out."""
        found = sorted((run.start(epoch) + offset, value * unit if isinstance(value, int) else value)
                       for run in self.runs for offset, value in enumerate(run.values))
        found = [(index, value) for index, value in found if index > self.passed and not math.isnan(value)]
        self.drop()
        self.passed = found[-1][0] if found else self.passed
        return found
