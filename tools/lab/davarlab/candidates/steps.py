"""Sudden steps of the bias, at every sample of the record, by generalised least squares
(DESIGN 15)."""

from collections.abc import Sequence

import numpy as np
from scipy import fft, stats

from ..arrays import Floats
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit
from ..thresholds import STEP


def residual_over_level(bench: Bench, parts: Sequence[Part], level: Fit) -> tuple[Floats, Floats]:
    """The gyro's ordinates without the courses of the parts, and the level of each ordinate."""
    data = bench.data
    return data.without(level.coefficients, bench.all_keys(parts)), data.at_ordinates(level.level)


def alike(level: Floats) -> Floats:
    """C(m) = sum over j of w_j cos(pi j m / n), m = 0 .. 2 n: two steps at k and l have the inner
    product (C(k - l) - C(k + l)) / 2, whitened."""
    n = len(level) + 1
    weight = np.zeros(n + 1)
    weight[1:n] = 1 / (2 * n * np.sin(np.pi * np.arange(1, n) / (2 * n)) ** 2 * level)
    half = fft.irfft(weight, 2 * n) * n  # sum over j of w_j cos
    return np.append(half, half[0])


def scores(c: Floats, level: Floats, same: Floats) -> Floats:
    """The normal score of a step at each sample 1 .. n - 1."""
    n = len(c) + 1
    pulled = fft.idct(np.concatenate([[0.0], c / level]), type=2, norm="ortho")
    total = -np.cumsum(pulled)[:-1]  # of what comes after: the whole is nothing
    norm = 0.5 * (same[0] - same[2 * np.arange(1, n)])
    found: Floats = total / np.sqrt(np.maximum(norm, 1e-300))
    return found


def log_chance(peak: float, same: Floats, n: int) -> float:
    """Of a peak that high anywhere: crossings of a Gaussian process from mark to mark, smooth or
    rough, whichever are more."""
    marks = np.unique(np.linspace(0, n, STEP.marks + 1).astype(int)[1:-1])
    norm = 0.5 * (same[0] - same[2 * marks])
    inner = 0.5 * (same[np.diff(marks)] - same[marks[1:] + marks[:-1]])
    apart = np.maximum(1 - inner / np.sqrt(norm[1:] * norm[:-1]), 0)
    tries = 1 + np.sum(np.maximum(np.minimum(1, peak * np.sqrt(apart / np.pi)), apart * peak**2))
    return min(0.0, float(np.log(2 * tries) + stats.norm.logsf(peak)))


def search(bench: Bench, parts: Sequence[Part], fit: Fit) -> tuple[Part, float, float]:
    """(part, gain, log p) of the most likely step."""
    c, level = residual_over_level(bench, parts, fit)
    same = alike(level)
    score = np.abs(scores(c, level, same))
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
    return part, gain, log_chance(float(np.sqrt(max(2 * gain, 0.0))), same, len(c) + 1)
