"""Isolated outliers: found on a record whitened by its own smooth spectrum, cut out before anything
else is fitted."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage, stats

from ..arrays import Bools, Floats, Ints
from . import signals

THRESHOLD = 5.6
REACH = 4


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
    c = signals.transform(y - np.median(y))
    c[0] = 0
    edges = signals.bin_edges(len(y) - 1)
    power = np.add.reduceat(c[1:] ** 2, edges[:-1]) / np.diff(edges)
    c[1:] /= np.sqrt(np.repeat(np.maximum(ndimage.median_filter(power, 9), 1e-30), np.diff(edges)))
    return signals.inverse(c)


def local_scale(w: Floats, block: int) -> Floats:
    """Robust standard deviation around each sample: by the median and by the upper fifth of the
    sizes, whichever is larger, because the median alone says nothing where a few counts are all
    that there is."""
    block = min(block, len(w))
    blocks = len(w) // block
    sizes = np.partition(
        np.abs(w[: blocks * block].reshape(blocks, block)), [block // 2, 4 * block // 5], axis=1
    )
    spread = np.maximum(sizes[:, block // 2] / 0.6745, sizes[:, 4 * block // 5] / 1.2816)
    spread = ndimage.maximum_filter1d(spread, 3)
    return np.interp(np.arange(len(w)), (np.arange(blocks) + 0.5) * block, spread)


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
    w = self_whitened(y)
    score = np.abs(w) / np.maximum(local_scale(w, max(50, int(4 * rate_hz))), 1e-30)
    if reach_dps:
        score[np.abs(y - ndimage.uniform_filter1d(y, 201)) < reach_dps] = 0
    wild = np.flatnonzero(score > THRESHOLD)
    if not len(wild) or len(wild) > 0.004 * len(y):
        return Shocks(0, 0.0, np.zeros(0, int), 0.0, 0.0, y, y)
    groups = np.split(wild, np.flatnonzero(np.diff(wild) > rate_hz / 2) + 1)
    clean, sizes = y.copy(), []
    near = ndimage.binary_dilation(score > THRESHOLD, iterations=REACH)
    good = np.flatnonzero(~near)
    clean[near] = local_mean(y, ~near, 201)[near]
    for group in groups:
        low, high = max(0, group[0] - 30), min(len(y), group[-1] + 31)
        sizes.append(np.abs(y[group] - np.median(clean[low:high])).max())
    expected = len(y) * 2 * stats.norm.sf(THRESHOLD)
    peaks = np.array([score[group].max() for group in groups])
    log_p = stats.poisson.logsf(len(groups) - 1, expected)
    log_p = min(log_p, np.log(len(y)) + np.log(2) + stats.norm.logsf(peaks.max()))
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
