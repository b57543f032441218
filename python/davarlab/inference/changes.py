"""White noise whose variance changes: the likelihood of the energies of short blocks (DESIGN 5)."""

from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import Floats, Ints
from ..thresholds import CHANGE


@dataclass
class Blocks:
    """Mean squares of the whitened residual in blocks of `length` samples."""

    energy: Floats
    length: int
    period_s: float
    # Of each energy: its length, fewer where counts scatter more than Gaussian noise.
    freedom: float
    known: Floats | None = None  # relative variance that is divided out already


def block_length(rate_hz: float) -> int:
    return max(8, int(rate_hz))


def blocks_of(w: Floats, rate_hz: float, known: tuple[Floats, float] | None = None) -> Blocks:
    """known: (relative variance of the blocks, scatter of their energies over that of Gaussian
    noise), from the counts."""
    length = block_length(rate_hz)
    count = len(w) // length
    energy, (variance, scatter) = (
        (w[: count * length].reshape(count, length) ** 2).mean(axis=1, dtype=np.float64),
        known or (None, 1.0),
    )
    return Blocks(
        energy if variance is None else energy / variance,
        length,
        length / rate_hz,
        length / scatter,
        variance,
    )


def log_likelihood(blocks: Blocks, variance: Floats) -> float:
    return -0.5 * blocks.freedom * float(np.sum(np.log(variance) + blocks.energy / variance))


def steady_gain(blocks: Blocks, before: Floats, after: Floats) -> float:
    """Gain in likelihood from one variance to another without the few blocks (CHANGE.touch_blocks)
    that tell most for it: a touch is no vibration."""
    each = (
        0.5
        * blocks.freedom
        * (np.log(before / after) + blocks.energy / before - blocks.energy / after)
    )
    return float(np.sort(each)[: -CHANGE.touch_blocks].sum())


def fit(blocks: Blocks, shapes: Floats) -> tuple[Floats, Floats, float]:
    """Non-negative sizes of the shapes (rows) of the variance, and the log-likelihood."""
    variance = np.full(len(blocks.energy), blocks.energy.mean())
    for _ in range(30):
        design = (shapes / variance).T
        norm = np.maximum(np.linalg.norm(design, axis=0), 1e-30)
        sizes = scipy.optimize.nnls(design / norm, blocks.energy / variance)[0] / norm
        variance, old = np.maximum(sizes @ shapes, 1e-6 * blocks.energy.mean()), variance
        if np.max(np.abs(variance / old - 1)) < 1e-7:
            break
    return sizes, variance, log_likelihood(blocks, variance)


def size_covariance(blocks: Blocks, shapes: Floats, variance: Floats) -> Floats:
    design = shapes / variance * np.sqrt(blocks.freedom / 2)
    return np.linalg.pinv(design @ design.T)


def best_interval(blocks: Blocks, variance: Floats) -> tuple[int, int, float, float]:
    """The interval of blocks with the most likely larger variance: (first, last + 1, ratio of
    variances, gain)."""
    relative = blocks.energy / variance
    total = np.concatenate([[0], np.cumsum(relative)])

    def gain(first: Ints, last: Ints) -> Floats:
        inside, n = total[last] - total[first], last - first
        a, b = inside / n, (total[-1] - inside) / np.maximum(len(relative) - n, 1)
        mean = total[-1] / len(relative)
        value = (
            len(relative) * np.log(mean)
            - n * np.log(a)
            - (len(relative) - n) * np.log(np.maximum(b, 1e-12))
        )
        return np.where((a > b) & (n < len(relative)), value * blocks.freedom / 2, 0)

    count = len(relative)
    step = max(1, count // 360)
    marks = np.append(np.arange(0, count, step), count)
    first, last = (marks[i] for i in np.triu_indices(len(marks), 1))
    best = int(np.argmax(gain(first, last)))
    low, high = first[best], last[best]
    for _ in range(3):
        starts = np.arange(max(0, low - 2 * step), min(high - 1, low + 2 * step) + 1)
        low = starts[np.argmax(gain(starts, np.full(len(starts), high)))]
        stops = np.arange(max(low + 1, high - 2 * step), min(count, high + 2 * step) + 1)
        high = stops[np.argmax(gain(np.full(len(stops), low), stops))]
    inside = relative[low:high].mean()
    outside = (relative.sum() - relative[low:high].sum()) / max(count - (high - low), 1)
    return int(low), int(high), inside / outside, float(gain(np.array([low]), np.array([high]))[0])


def excess_scatter(blocks: Blocks, variance: Floats, share: Floats) -> Floats:
    """How much more than chi-square each block scatters, >= 1, where `share` of its variance is
    known from a short stretch of the accelerometer only: its mean square has a scatter of its own,
    which enters as share^2 (5.4)."""
    score = (blocks.energy / variance - 1) ** 2 * blocks.freedom / 2 - 1
    weight = share**2
    total = float(np.sum(weight**2))
    return 1 + weight * max(0.0, float(np.sum(weight * score)) / total if total > 0 else 0.0)


def restless(energy: Floats, length: int) -> float:
    """How much more than chance the level of the noise moves between stretches; at least 1."""
    count = min(CHANGE.restless_stretches, len(energy))
    edges = np.linspace(0, len(energy), count + 1).astype(int)
    sizes = np.diff(edges)
    means = np.add.reduceat(energy, edges[:-1]) / sizes
    return max(
        1.0,
        float(np.sum(sizes * length / 2 * (means / energy.mean() - 1) ** 2) / max(count - 1, 1)),
    )
