"""The detector of changes in doubles, directly from the formulas (7.1) to (7.9): slow, and
independent of the library's arithmetic.

Every comparison stores its margin: the distance of the two sides, in units of the larger rounding
that the library may have there. Below 1 the library may decide differently.
"""

from math import inf, log, sqrt

RECORDS = 4
RECENT = 64
CUTS = 5


class Window:
    """A section of blocks that are treated as having one variance: its beginning."""

    def __init__(self):
        self.at = 0


class Detector:
    def __init__(self, block, shock, per_hour, rate_hz=100.0, cut_s=300.0, longest=6000):
        self.block, self.nu, self.shock = block, block - 1, shock
        self.floor = block * self.nu
        self.longest = longest // block
        self.levels = next(n for n in range(1, 10) if 3 * 2 ** (n - 1) >= self.longest)
        self.outlier = 5.0 if block < 18 else 3.0
        self.h_alarm = log(3600 / per_hour * rate_hz / block) + 1.2
        self.h_cut = log(cut_s * rate_hz / block) + 1.8
        self.near, self.far, self.half = 150 // block, 600 // block, 300 // block
        self.b = []  # None: dropped
        self.sums, self.counts = [0], [0]
        self.cut, self.alarm = Window(), Window()
        self.waiting = []
        self.phi = {1: 1.0, 8: 1.0}
        self.before = {1: None, 8: None}
        self.seen = {1: 0, 8: 0}
        self.eight = []
        self.past = [[0, True, True]]  # place, counts, settled
        self.turn = 0
        self.margin = inf

    # dispersion (7.3)

    def learn(self, n, b, divisor, memory):
        step, self.before[n] = (None if self.before[n] is None else log(b) - self.before[n]), log(b)
        if step is None:
            self.seen[n] = 1
            return
        phi = self.phi[n]
        square = min(step * step / divisor, 9 * phi)
        self.phi[n] = min(
            14.0, max(0.25, phi + (square - phi) * max(memory, 1 / (self.seen[n] + 15)))
        )
        self.seen[n] += 1

    def dispersion(self):
        return max(1.0, 1.0 + 1.125 * (max(self.phi.values()) - 1.0))

    # sums over blocks [s, e)

    def total(self, s, e):
        return self.sums[e] - self.sums[s], self.counts[e] - self.counts[s]

    def gain(self, s, k, e):
        def part(a, b):
            total, n = self.total(a, b)
            return n * log(total / n)

        return self.nu / 2 * (part(s, e) - part(s, k) - part(k, e))

    def above(self, left, right, rounding):
        self.margin = min(self.margin, abs(left - right) / rounding)
        return left > right

    # the scan (7.4) to (7.6)

    def ages(self, now):
        yield from (2, 3, 5 if now % 2 else 4)
        half = now & -now
        if 1 < half < 2 ** (self.levels - 1):
            yield from (3 * half, 5 * half)

    def scan(self, s, h):
        now, f, best, split = len(self.b), self.dispersion(), 0.0, None
        excesses = [0.0]
        for age in self.ages(now):
            k = now - age
            n = min(self.total(s, k)[1], self.total(k, now)[1]) if k > s else 0
            if n < 2:
                continue
            excess = self.gain(s, k, now) - f * (1 + 1 / (3 * self.nu * n)) * (h - log(n))
            excesses.append(excess)
            if excess > best + 1e-9:
                best, split = excess, k
        excesses.sort()
        if len(excesses) > 1 and excesses[-1] - excesses[-2] > 1e-9:  # alike: the same split
            self.margin = min(self.margin, (excesses[-1] - excesses[-2]) / 0.03)
        return split

    def shorten(self, window):
        if len(self.b) - window.at > self.longest:
            coarse = 2 ** (self.levels - 1)
            window.at = (window.at // coarse + 1) * coarse

    def advance(self, b):
        self.b.append(b)
        self.sums.append(self.sums[-1] + (b or 0))
        self.counts.append(self.counts[-1] + (b is not None))
        self.shorten(self.alarm)
        self.shorten(self.cut)

    # shocks (7.7)

    def exceeds(self, b, factor):
        total, n = self.total(self.cut.at, len(self.b))
        return self.above(b * n / total, 1 + (factor - 1) * sqrt(self.dispersion()), 0.03)

    def waits(self, b):
        if self.waiting:
            over = [self.above(w / b, 3.0, 1e-9) for w in self.waiting]  # each moves the margin
            calm = any(over) or not self.exceeds(b, 543 / 256)
            if not calm and len(self.waiting) < self.shock:
                return True
            for w in self.waiting:
                self.advance(None if calm else w)
            self.dropped = len(self.waiting) if calm else 0
            self.waiting = []
            return False
        total, n = self.total(self.cut.at, len(self.b))
        return (
            self.shock > 0
            and n * self.nu >= 100
            and total > 4 * self.floor * n
            and self.exceeds(b, self.outlier)
        )

    # a block

    def push(self, b):
        self.margin, self.dropped, self.is_alarm, is_cut = inf, 0, False, False
        self.learn(1, b, 2 * (2 / self.nu) * (1 + 1 / self.nu), 2**-11)
        self.eight.append(b)
        if len(self.eight) == 8:
            self.learn(8, sum(self.eight), 4 / (8 * self.nu), 2**-8)
            self.eight = []
        if self.waits(b):
            self.waiting.append(b)
            return
        self.advance(b)
        cut, alarm = self.scan(self.cut.at, self.h_cut), self.scan(self.alarm.at, self.h_alarm)
        if cut is not None:
            self.cut.at, is_cut = cut, True
        if alarm is not None:
            self.alarm.at, self.is_alarm = alarm, True
        if self.cut.at < self.alarm.at:
            self.cut.at, is_cut = self.alarm.at, True
        self.note(is_cut)

    def skip(self):
        self.margin, self.dropped, self.is_alarm = inf, len(self.waiting), False
        for _ in range(len(self.waiting) + 1):
            self.advance(None)
        self.waiting = []
        self.note(False)

    # windows (7.8)

    def record(self, age, bound):
        now = len(self.b)
        if now - age <= bound:
            return bound
        coarse = next(2**n for n in range(10) if RECORDS * 2**n > age)
        return -(-(now - age) // coarse) * coarse

    def alike(self, s, k, e, limit):
        if self.total(s, k)[1] == 0 or self.total(k, e)[1] == 0:
            return True
        return not self.above(self.gain(s, k, e), limit * self.dispersion(), 0.02)

    def grow(self, begin, end, bound, near):
        age = len(self.b) - begin
        while begin != bound:
            age += age - (len(self.b) - end)
            older = self.record(age, bound)
            if not self.alike(older, begin, end, near if end - older <= self.far else 1.5):
                break
            begin = older
        return begin

    def trailing(self):
        return self.grow(self.record(self.near, self.cut.at), len(self.b), self.cut.at, 4.0)

    def note(self, is_cut):
        now = len(self.b)
        if self.past and now - self.past[0][0] > self.longest:
            self.past.pop(0)
        if is_cut:
            if len(self.past) == CUTS:
                self.past.pop(0)
                self.past[0][1:] = True, True
            self.past.append([self.cut.at, True, False])
        self.turn = self.turn + 1 if self.turn + 1 < len(self.past) else 0
        if self.turn < len(self.past) and not self.past[self.turn][2]:
            self.past[self.turn][1] = self.is_step(self.turn)
            self.past[self.turn][2] = now - self.past[self.turn][0] >= self.half

    def is_step(self, i):
        now, k = len(self.b), self.past[i][0]
        if now - k >= RECENT:
            return True
        before = k - self.past[i - 1][0] if i else self.half
        after = self.past[i + 1][0] - k if i + 1 < len(self.past) else now - k
        s, e = max(k - min(before, self.half), now - RECENT), k + min(after, self.half)
        if self.total(s, k)[1] == 0 or self.total(k, e)[1] == 0:
            return True
        there = [b for b in self.b[s:e] if b is not None]
        n, mean = len(there), sum(there) / len(there)
        middle = (n - 1) / 2
        spread = sum((t - middle) ** 2 for t in range(n))
        z = sum((t - middle) * (b / mean - 1) for t, b in enumerate(there)) * sqrt(
            self.nu / (2 * spread)
        )
        f = self.dispersion()
        return self.above(self.gain(s, k, e) / f - z * z / (2 * f), 4.0, 0.3)

    def centred(self):
        """None while no block is in the middle."""
        now, widest = len(self.b), 2 * self.half
        if now < self.half:
            return None
        end, begin = now, now - widest
        bound = self.past[0][0] if len(self.past) == CUTS else self.record(self.longest, -inf)
        for place, counts, _ in reversed(self.past):
            if counts and now - place < self.half:
                end = place
        for place, counts, _ in self.past:
            if counts and now - place >= self.half and place >= begin:
                begin = place
            if place < end:
                bound = place
        if now - bound > widest:
            first = self.record(widest, bound)
            grown = self.grow(first, end, bound, 1.5)
            begin = grown if grown != first else begin
        return begin, end
