"""Isolated outliers: found on a record whitened by its own smooth spectrum, cut out before anything
else is fitted; and torn register reads, which are found in counts (DESIGN 13.5)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ..arrays import Bools, Floats, Ints
from ..distributions import chi2_isf, norm_logpdf, norm_logsf, norm_pdf, norm_sf, poisson_logsf
from ..thresholds import EVENTS
from . import counts, signals

# Samples that are looked at together; the result does not depend on it.
PIECE = 1000 * EVENTS.noise_block
SHARES = np.linspace(*EVENTS.torn_shares)


@dataclass(frozen=True)
class Shocks:
    count: int
    amplitude_dps: float
    times: Ints
    log_p: float
    gain: float
    clean: Floats
    raw: Floats
    error_dps: float = 0.0


def self_whitened(y: Floats) -> Floats:
    c = signals.transform(y - np.median(y), spare=True)
    c[0] = 0
    edges = signals.bin_edges(len(y) - 1)
    power = np.add.reduceat(c[1:] ** 2, edges[:-1]) / np.diff(edges)
    scale = np.sqrt(np.maximum(ndimage.median_filter(power, 9), 1e-30))
    for first, end, one in zip(edges, edges[1:], scale):
        c[1 + first : 1 + end] /= one
    return signals.inverse(c, spare=True)


def local_scale(w: Floats, block: int) -> Floats:
    """Robust standard deviation around each sample: by the median and by the upper fifth of the
    sizes, whichever is larger, because the median alone says nothing where a few counts are all
    that there is."""
    block = min(block, len(w))
    blocks = len(w) // block
    rows, spread = w[: blocks * block].reshape(blocks, block), np.empty(blocks)
    together = max(1, signals.PIECE // block)
    for first in range(0, blocks, together):
        some = slice(first, first + together)
        sizes = np.partition(np.abs(rows[some]), [block // 2, 4 * block // 5], axis=1)
        spread[some] = np.maximum(sizes[:, block // 2] / 0.6745, sizes[:, 4 * block // 5] / 1.2816)
    spread = ndimage.maximum_filter1d(spread, 3)
    found, centres = np.empty(len(w)), (np.arange(blocks) + 0.5) * block
    for first in range(0, len(w), signals.PIECE):
        end = min(first + signals.PIECE, len(w))
        found[first:end] = np.interp(np.arange(first, end), centres, spread)
    return found


def local_mean(y: Floats, good: Bools, width: int) -> Floats:
    """Mean of the good samples around each sample."""
    y0 = np.median(y[good])
    total = ndimage.uniform_filter1d(np.where(good, y - y0, 0.0), width)
    found: Floats = y0 + total / np.maximum(
        ndimage.uniform_filter1d(good.astype(float), width), 1e-9
    )
    return found


def find(y: Floats, rate_hz: float, reach_dps: float = 0.0) -> Shocks:
    """Shocks in y (deg/s) and y with the local mean in their place. Nothing within `reach_dps` of
    the local mean is one (counts)."""
    score = self_whitened(y)
    scale = local_scale(score, max(50, int(4 * rate_hz)))
    np.abs(score, out=score)
    score /= np.maximum(scale, 1e-30, out=scale)
    del scale
    if reach_dps:
        score[np.abs(y - ndimage.uniform_filter1d(y, EVENTS.local_samples)) < reach_dps] = 0
    wild = np.flatnonzero(score > EVENTS.wild)
    if not len(wild) or len(wild) > 0.004 * len(y):
        return Shocks(0, 0.0, np.zeros(0, int), 0.0, 0.0, y, y)
    groups = np.split(wild, np.flatnonzero(np.diff(wild) > rate_hz / 2) + 1)
    clean, sizes = y.copy(), []
    near = ndimage.binary_dilation(score > EVENTS.wild, iterations=EVENTS.replaced)
    good = np.flatnonzero(~near)
    clean[near] = local_mean(y, ~near, EVENTS.local_samples)[near]
    for group in groups:
        low, high = max(0, group[0] - 30), min(len(y), group[-1] + 31)
        sizes.append(np.abs(y[group] - np.median(clean[low:high])).max())
    expected = len(y) * 2 * norm_sf(EVENTS.wild)
    peaks = np.array([score[group].max() for group in groups])
    log_p = poisson_logsf(len(groups) - 1, expected)
    log_p = min(log_p, np.log(len(y)) + np.log(2) + norm_logsf(peaks.max()))
    gain = float(np.sum(score[wild] ** 2 / 2 - np.log(len(y))))
    return Shocks(
        len(groups),
        float(np.median(sizes)),
        np.array([g[0] for g in groups]),
        float(log_p),
        gain,
        clean,
        y,
        float(1.25 * np.std(y[good] - clean.mean()) / np.sqrt(len(groups))),
    )


# Torn reads ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Jumps:
    """Single samples of a column that leave their neighbours and come back: index, size and
    standard deviation of the size; both in counts, the size without its sign."""

    column: str
    at: Ints
    size: Floats
    noise: Floats

    def some(self, chosen: Bools) -> "Jumps":
        return Jumps(self.column, self.at[chosen], self.size[chosen], self.noise[chosen])


def jumps_of(column: str, x: Floats, good: Bools) -> Jumps | None:
    """The jumps of a column; None without any, or without counts."""
    part = x[good].astype(np.float64, copy=False)
    count = len(part) - 4
    pieces = [leaving(part, at, min(at + PIECE, count)) for at in range(0, count, PIECE)]
    at, size, noise = (np.concatenate(rows) for rows in zip(*pieces))
    q = counts.step(part) if len(at) else 0.0
    if not q:
        return None
    found = Jumps(
        column, np.flatnonzero(good)[2:-2][at], size / q, np.maximum(noise / q, EVENTS.rounded)
    )
    return found.some(found.size > EVENTS.far / np.sqrt(2) * found.noise)


def leaving(x: Floats, first: int, end: int) -> tuple[Ints, Floats, Floats]:
    """(index, size, noise) of the samples x[2 + index], first <= index < end, that leave their
    neighbours and come back."""
    low = max(0, first - 2 * EVENTS.noise_block)  # as far as the noise beside a sample is looked at
    part = x[low : end + 2 * EVENTS.noise_block + 4]
    beside = [part[:-4], part[1:-3], part[3:-1], part[4:]]
    least = np.minimum(np.minimum(beside[0], beside[1]), np.minimum(beside[2], beside[3]))
    most = np.maximum(np.maximum(beside[0], beside[1]), np.maximum(beside[2], beside[3]))
    usual = (beside[0] + beside[1] + beside[2] + beside[3] - least - most) / 2  # their median
    off = part[2:-2] - usual
    noise = local_scale(off, EVENTS.noise_block)
    nearer = np.maximum(np.abs(beside[1] - usual), np.abs(beside[2] - usual))
    far = (np.abs(off) > EVENTS.far / np.sqrt(2) * noise) & (nearer < np.abs(off) / 2)
    at = np.flatnonzero(far[first - low : end - low]) + first - low
    return at + low, np.abs(off[at]), noise[at]


def torn(columns: Mapping[str, Floats], good: Bools) -> dict[int, list[Jumps]]:
    """Torn register reads: the jumps of 2^k counts, by the power k.

    columns: of gyro and accelerometer, in any unit. good: the samples that were measured.

    A driver or a bus that reads half of an old value is off by a power of two. An ordinary outlier
    may have that size by chance. Therefore the jumps within half an octave of 2^k, on all columns,
    must pass three tests. K is the number of octaves that have jumps.

    - Torn reads explain the jumps `unrelated` * K times better than sizes that are uniform in their
      logarithms. By Markov's inequality, shocks of such sizes pass in less than 1 / `unrelated` of
      the recordings, however many shocks there are.
    - The mean of the jumps near 2^k is `one_size` * K times as likely as with one unknown size per
      kind of sensor. Shocks of one size pass in less than 1 / `one_size` of the recordings.
    - The jumps near 2^k scatter about it as the noise does (chi-square, `scattered`).

    A single jump can pass only if 2^k is above 362 times its noise. A column whose values hardly
    repeat has no counts, so no torn read is found there. Cost: about 20 operations per sample and
    column. Source: DESIGN 13.5.
    """
    if np.count_nonzero(good) < 2 * EVENTS.noise_block:
        return {}
    all_jumps = [
        jumps for name, x in columns.items() if (jumps := jumps_of(name, x, good)) is not None
    ]
    octaves: dict[int, list[Jumps]] = {}
    for power in range(EVENTS.power_least, EVENTS.power_most + 1):
        near = [
            one.some((np.round(np.log2(one.size)) == power) & (2**power > EVENTS.far * one.noise))
            for one in all_jumps
        ]
        if any(len(one.at) for one in near):
            octaves[power] = [one for one in near if len(one.at)]
    found = {}
    for power, near in octaves.items():
        hits = [one.some(np.abs(one.size - 2**power) < EVENTS.hit * one.noise) for one in near]
        hits = [one for one in hits if len(one.at)]
        if are_torn(near, hits, power, len(octaves)):
            found[power] = hits
    return found


def are_torn(jumps: Sequence[Jumps], hits: Sequence[Jumps], power: int, octaves: int) -> bool:
    """Do the jumps of an octave pass the three conditions of torn()."""
    if not hits:
        return False
    size, noise = (
        np.concatenate([getattr(one, name) for one in jumps]) for name in ("size", "noise")
    )
    # Densities of a size: of a torn read, and uniform in its logarithm over the octave.
    ratio = norm_pdf(size, 2**power, noise) * size * np.log(2)
    unrelated = np.log1p(SHARES[:, None] * (ratio - 1)).sum(axis=1)
    off = [(one.size - 2**power) / one.noise for one in hits]
    square = float(sum(np.sum(z**2) for z in off))
    return bool(
        np.logaddexp.reduce(unrelated) - np.log(len(SHARES)) > np.log(EVENTS.unrelated * octaves)
        and of_one_size(hits, power) > np.log(EVENTS.one_size * octaves)
        and square < chi2_isf(EVENTS.scattered, sum(len(z) for z in off))
    )


def of_one_size(hits: Sequence[Jumps], power: int) -> float:
    """Logarithm of how much more likely 2^k is as the mean size than one unknown size per kind of
    sensor, uniform in its logarithm over the octave."""
    total = 0.0
    for kind in {one.column.split("_")[0] for one in hits}:
        own = [one for one in hits if one.column.split("_")[0] == kind]
        weight = np.concatenate([one.noise for one in own]) ** -2.0
        mean = float(np.average(np.concatenate([one.size for one in own]), weights=weight))
        error = float(np.hypot(weight.sum() ** -0.5, EVENTS.grid_counts))
        total += float(norm_logpdf(mean, 2**power, error) + np.log(mean * np.log(2)))
    return total
