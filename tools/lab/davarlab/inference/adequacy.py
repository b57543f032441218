"""Is the whole model adequate? Standardised residuals in frequency, time and amplitude, one honest p-value (DESIGN 7)."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import fft, ndimage, stats

from ..data import signals

BANDS = 14
TIMES = 24
STEPS = 1200
STEP_ORDINATES = 3000
COUNTS_TOGETHER = 16
# How many independent tests the list of judge() amounts to: measured on recordings of true models (`tools/davarlab nulls`).
INDEPENDENT = 5


@dataclass
class Adequacy:
    """p of the whole, the p-values of the tests by name, and the cells (bands x times) as normal scores."""
    p_value: float
    tests: dict
    cells: np.ndarray
    band_hz: np.ndarray


def normal_score(energy, freedom):
    """Wilson and Hilferty: a chi-square over its freedom as a normal score."""
    return (np.cbrt(energy) - 1 + 2 / (9 * freedom)) / np.sqrt(2 / (9 * freedom))


def spectrum_score(c, free):
    edges = np.unique(np.round(np.geomspace(4, len(c), 70)).astype(int))
    counts = np.diff(edges)
    z = normal_score(np.add.reduceat(c[:edges[-1]] ** 2, edges[:-1])[:len(counts)] / counts, counts)
    return float(stats.chi2.sf(np.sum(z ** 2), max(len(z) - free, 1)))


def cells_of(c, kurtosis=0.0):
    """Energies of octave bands in equal stretches of time, as normal scores after each band's own mean is taken out.
    kurtosis: excess of the samples; energy in a share of the band scatters by that share of it more."""
    edges = np.unique(np.round(np.geomspace(len(c) / 2 ** (BANDS - 1), len(c), BANDS)).astype(int))
    edges = edges[edges > 12 * TIMES]
    edges = np.concatenate([[min(12 * TIMES, len(c) // 4)], edges])
    rows = []
    for low, high in zip(edges[:-1], edges[1:]):
        if high - low < 8 * TIMES:
            continue
        part = np.zeros(len(c) + 1)
        part[low + 1:high + 1] = c[low:high]
        x = signals.inverse(part)
        length = len(x) // TIMES
        energy = (x[:length * TIMES].reshape(TIMES, length) ** 2).sum(axis=1)
        freedom = (high - low) / TIMES / (1 + kurtosis / 2 * (high - low) / len(c))
        rows.append(normal_score(energy / energy.mean(), freedom))
    return np.array(rows).reshape(-1, TIMES), edges


def kurtosis_scores(w, counted=False):
    """Two-sided p-values of the kurtosis of the whitened residual, averaged over 1, 4, 16 ... samples. Counts (`counted`) are no Gaussians
    until many are averaged: COUNTS_TOGETHER at least."""
    found = []
    for width in 4 ** np.arange(7):
        count = len(w) // width
        if count < 400:
            break
        if not counted or width >= COUNTS_TOGETHER:
            found.append(float(stats.kurtosistest(w[:count * width].reshape(count, width).sum(axis=1)).pvalue))
    return found


def jump_p(c):
    """Largest change of a running mean of the whitened residual at a few lengths, against chance."""
    w = signals.inverse(np.concatenate([[0.0], c]))
    best = 1.0
    for width in [width for width in (16, 64, 256, 1024) if 2 * width <= len(w)]:
        total = np.concatenate([[0.0], np.cumsum(w)])
        means = (total[width:] - total[:-width]) / np.sqrt(width)
        peak = np.abs(means).max()
        best = min(best, len(w) / width * max(peak ** 2, 4) * 2 * stats.norm.sf(peak))  # Slepian's process
    return float(min(1.0, 2 * best))


@cache
def step_courses(count):
    """Of a step at each place, the ordinates up to what its spectrum has to do with the frequency alone."""
    return np.sin(np.pi * np.outer(np.arange(1, STEPS) / STEPS, np.arange(1, count + 1)))


def step_p(c, level):
    """The most likely single step of the bias, by generalised least squares at STEPS places, against chance by the crossings of a Gaussian
    process with that correlation from place to place (7.5)."""
    count = min(STEP_ORDINATES, len(c))
    k = np.arange(1, count + 1)
    sine = step_courses(count)
    course = 1 / (np.sin(np.pi * k / (2 * (len(c) + 1))) * np.sqrt(level[:count]))
    norm = np.sqrt(np.einsum("sk,sk,k->s", sine, sine, course ** 2))
    peak = np.abs(sine @ (course * c[:count]) / norm).max()
    alike = np.einsum("sk,sk,k->s", sine[1:], sine[:-1], course ** 2) / (norm[1:] * norm[:-1])
    apart = 1 - alike  # neighbours say nearly the same where the noise is white, hardly where it walks
    tries = 1 + np.sum(np.minimum(1, peak * np.sqrt(np.maximum(apart, 0) / np.pi)))
    return float(min(1.0, tries * 2 * stats.norm.sf(peak)))


def judge(c, level, free, rate_hz, extra=None, counted=False, suspended=(), kurtosis=0.0):
    """c: whitened residual ordinates; level: the model's at each ordinate; free: fitted
    parameters; extra: further p-values by name; counted: the gyro comes in counts that its noise does not cover; suspended: tests that its counts fail by themselves."""
    tests = {"spectrum": spectrum_score(c, free), "bias step": step_p(c, level)}
    cells, edges = cells_of(c, kurtosis)
    if cells.size:  # a short record has none
        tests["time and frequency"] = float(stats.chi2.sf(np.sum(cells ** 2) * TIMES / (TIMES - 1), cells.size))
        tests["largest cell"] = float(min(1.0, cells.size * 2 * stats.norm.sf(np.abs(cells).max())))
    w = signals.inverse(np.concatenate([[0.0], c]))
    power = np.abs(fft.rfft(w, fft.next_fast_len(2 * len(w), real=True))) ** 2 / len(c)
    tests["line"] = float(min(1.0, 1.5 * len(c) * np.exp(-power[8:-8].max())))
    narrow = ndimage.uniform_filter1d(c ** 2, 401)[200:-200:100]
    tests["narrow band"] = float(min(1.0, 0.8 * len(narrow) * stats.chi2.sf(401 * narrow.max(), 401)))
    scores = kurtosis_scores(w, counted)
    tests["amplitudes"] = float(min(1.0, min(scores, default=1.0) * len(scores)))
    tests["jumps"] = jump_p(c)
    tests.update(extra or {})
    tests = {name: p for name, p in tests.items() if name not in suspended}
    return Adequacy(float(1 - (1 - min(tests.values())) ** INDEPENDENT), tests, cells, edges * rate_hz / (2 * len(c)))
