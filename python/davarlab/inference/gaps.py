"""Missing samples: drawn from what the spectrum and the known samples leave open (DESIGN 12)."""

import numpy as np
from scipy import fft

from ..arrays import Bools, Floats
from ..data import signals
from ..thresholds import FIT


def first_level(y: Floats, known: Bools) -> Floats:
    """Variance per ordinate 1 .. n-1 from products of known samples alone (12.2): what the first
    draw starts from. From a fill by means the loop of draws and fits would take as many rounds as
    halve the share of missing samples away."""
    count = len(y)
    values = np.where(known, y - y[known].mean(), 0.0)
    products, pairs = (
        np.fft.irfft(np.abs(np.fft.rfft(x, 2 * count)) ** 2)[: count // FIT.level_lags]
        for x in (values, known.astype(float))
    )
    lags = len(products)
    covariance = (
        products / np.maximum(pairs, 0.5) * np.cos(0.5 * np.pi * np.arange(lags) / lags) ** 2
    )
    spectrum = 2 * np.fft.rfft(covariance, 2 * count).real[1:count] - covariance[0]
    edges = signals.bin_edges(count - 1)
    width = np.diff(edges)
    level = np.add.reduceat(spectrum, edges[:-1]) / width
    usual = np.median(level)  # below 0 where few pairs of samples are known of a walk
    level = np.repeat(
        np.maximum(level, FIT.level_floor * (usual if usual > 0 else np.abs(level).mean())), width
    )
    found: Floats = level * (covariance[0] / level.mean())  # the floor adds none to the variance
    return found


def conditional_draw(y: Floats, known: Bools, level: Floats, rng: np.random.Generator) -> Floats:
    """y with its missing samples drawn, given the known ones and the variance `level` of each
    ordinate 1 .. n-1. Solves (12.1) by conjugate gradients: four cosine transforms an iteration."""
    if known.all():
        return y
    mean = y[known].mean()
    about, missing, level = extended(np.where(known, y - mean, 0.0), ~known, level)
    pull = signals.transform(about) / level
    push = rng.standard_normal(len(about))
    push /= np.sqrt(np.mean(push**2)) * np.sqrt(
        level
    )  # of the variance that is asked, not by chance
    # The mean and the draw apart: beside a strong slow course the fast part of a draw would be lost
    # in its tolerance.
    about[missing] = sum(
        solved(signals.inverse(one)[missing], missing, level) for one in (-pull, push)
    )
    return np.where(known, y, mean + about[: len(y)])


def extended(values: Floats, missing: Bools, level: Floats) -> tuple[Floats, Bools, Floats]:
    """The same for a record with missing samples after it, up to a length whose transforms are
    fast, and with the level of ordinate 0."""
    count = len(values)
    length = fft.next_fast_len(count, real=True)
    more = length - count
    ordinates = np.arange(length) * (count / length)
    return (
        np.append(values, np.zeros(more)),
        np.append(missing, np.ones(more, bool)),
        np.interp(ordinates, np.arange(1, count), level),
    )


def within(x: Floats, missing: Bools, weight: Floats) -> Floats:
    """The block of C' diag(weight) C between missing samples, times x."""
    whole = np.zeros(len(missing))
    whole[missing] = x
    return signals.inverse(weight * signals.transform(whole))[missing]


def solved(right: Floats, missing: Bools, level: Floats) -> Floats:
    """x of Q_mm x = right; the covariance of the missing samples is the preconditioner."""
    x, rest = np.zeros_like(right), right.copy()
    shaped = within(rest, missing, level)
    direction, size = shaped.copy(), rest @ shaped
    first = size
    for _ in range(FIT.draw_iterations):
        ahead = within(direction, missing, 1 / level)
        step = size / (direction @ ahead)
        x += step * direction
        rest -= step * ahead
        shaped = within(rest, missing, level)
        size, before = rest @ shaped, size
        if size <= FIT.draw_residual**2 * first:
            break
        direction = shaped + size / before * direction
    return x
