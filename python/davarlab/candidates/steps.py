"""Sudden steps of the bias, at every sample of the record, by generalised least squares
(DESIGN 15)."""

from collections.abc import Sequence

import numpy as np
from scipy import fft

from ..arrays import Floats, Ints
from ..data import signals
from ..distributions import norm_logsf
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit
from ..thresholds import STEP


def alike(level: Floats) -> Floats:
    """C(2 k), k = 0 .. n // 2; C(m) = sum over j of w_j cos(pi j m / n) is even about n. Two steps
    at k and l have the inner product (C(k - l) - C(k + l)) / 2, whitened (15.1)."""
    n = len(level) + 1
    weight = np.arange(n, dtype=float)
    weight *= np.pi / (2 * n)
    np.square(np.sin(weight, out=weight), out=weight)
    weight[1:] *= 2 * n * level
    np.divide(1.0, weight[1:], out=weight[1:])
    found: Floats = fft.rfft(weight).real.copy()
    signals.forget_plans(n)
    return found


def at(same: Floats, k: Ints, n: int) -> Floats:
    """C(2 k), k = 0 .. n."""
    found: Floats = same[np.minimum(k, n - k)]
    return found


def scores(pulled: Floats, same: Floats) -> Floats:
    """The normal score of a step at each sample 1 .. n - 1; pulled: the ordinates over their
    level."""
    pulled = signals.in_time(pulled)
    total = np.cumsum(pulled, out=pulled)[:-1]  # of what comes after: the whole is nothing
    norm = 0.5 * (same[0] - same[1:])
    norm = np.concatenate([norm, norm[: len(total) - len(norm)][::-1]])
    found: Floats = np.negative(total, out=total)
    found /= np.sqrt(np.maximum(norm, 1e-300, out=norm), out=norm)
    return found


def log_chance(peak: float, same: Floats, n: int) -> float:
    """Of a peak that high anywhere: crossings of a Gaussian process from mark to mark, smooth or
    rough, whichever are more."""
    marks = np.unique(np.linspace(0, n // 2, STEP.marks + 1).astype(int)[1:-1])  # each two samples
    norm = 0.5 * (same[0] - at(same, 2 * marks, n))
    inner = 0.5 * (at(same, np.diff(marks), n) - at(same, marks[1:] + marks[:-1], n))
    apart = np.maximum(1 - inner / np.sqrt(norm[1:] * norm[:-1]), 0)
    tries = 1 + np.sum(np.maximum(np.minimum(1, peak * np.sqrt(apart / np.pi)), apart * peak**2))
    return min(0.0, float(np.log(2 * tries) + norm_logsf(peak)))


def search(bench: Bench, parts: Sequence[Part], fit: Fit) -> tuple[Part, float, float]:
    """(part, gain, log p) of the most likely step."""
    data, n = bench.data, len(bench.y)
    same = alike(data.at_ordinates(fit.level))
    c = data.without(fit.coefficients, bench.all_keys(parts))
    score = scores(c / data.at_ordinates(fit.level), same)
    np.abs(score, out=score)
    edge = max(STEP.edge, len(score) // STEP.marks)
    score[:edge] = score[-edge:] = 0
    for known in [
        part.shape["time_s"] for part in parts if part.kind == "bias_step"
    ]:  # two at one instant are one
        score[np.abs(bench.recording.time_s[1:] - known) * bench.recording.rate_hz < STEP.edge] = 0
    place = int(np.argmax(score))
    part = Part("bias_step", {"time_s": float(bench.recording.time_s[place + 1])})
    gain = bench.fit([*parts, part]).log_likelihood - fit.log_likelihood
    bench.forget(part)
    return part, gain, log_chance(float(np.sqrt(max(2 * gain, 0.0))), same, n)
