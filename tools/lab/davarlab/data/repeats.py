"""Samples that repeat the one before: a sensor that is read more often than it measures (DESIGN
13)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import Bools, Floats
from ..distributions import binom_logsf, norm_cdf, norm_pdf
from . import signals

CHANCE = 1e-6  # of a sensor without repeats, per recording
CLEAR = 0.01  # chance of equal samples, up to which each one that is equal is a repeat
APART = 6.0  # standard deviations
FINER = 0.1  # differences of two counts over those of one, from which the noise hides the counts


@dataclass
class Repeats:
    """equal: True where a sample repeats the one before on all axes of the sensor; share: of the
    samples; chance: the share that counts explain; clear: counts explain so few that those which
    are equal can be left out."""

    equal: Bools
    share: float
    chance: float
    clear: bool = True


def rounded_difference(sigma: float, size: int) -> float:
    """Chance that two counted samples differ by so many counts, up or down, where their difference
    has this standard deviation in counts and the bias lies anywhere in a count."""
    x = (size + np.array([-1, 0, 1])) / sigma
    each = sigma * (x * norm_cdf(x) + norm_pdf(x)) @ np.array([1, -2, 1])
    return float(each if size == 0 else 2 * each)


def by_counts(x: Floats, known: Bools) -> float | None:
    """Share of samples of an axis that equal the one before by their counts alone, exactly for
    Gaussian noise: from the differences of one and of two counts. None where the noise is too small
    for that."""
    step = signals.count_of(x[known])
    if not step:
        return None
    sizes = np.round(np.abs(np.diff(x))[known[1:] & known[:-1]] / step)
    one, two = float(np.mean(sizes == 1)), float(np.mean(sizes == 2))

    def off(sigma: float) -> float:
        return rounded_difference(sigma, 2) / rounded_difference(sigma, 1) - two / max(one, 1e-9)

    low, high = 0.3, 30.0
    if two < FINER * one or off(low) * off(high) > 0:
        return None
    sigma = float(scipy.optimize.brentq(off, low, high))
    return one * rounded_difference(sigma, 0) / rounded_difference(sigma, 1)


def axes_of(columns: Mapping[str, Floats]) -> list[str]:
    """The axes of the gyro, or of an accelerometer without one."""
    gyro = [name for name in columns if name.startswith("gyro_")]
    return gyro or [name for name in columns if name.startswith("accel_")]


def hidden(columns: Mapping[str, Floats], equal: Bools, known: Bools) -> float | None:
    """The share of equal samples that counts explain, where there are more and they keep apart;
    else None.

    Equal samples of a sensor that is read once a sample follow each other more often than by
    chance, because its noise is smaller for a while or near the middle of a count. A sensor that is
    read too often gives a fresh sample after one or a few repeats.
    """
    found = [by_counts(columns[name], known) for name in axes_of(columns)]
    sure = [one for one in found if one is not None]
    share = float(equal[1:].mean())
    if not sure or not 0 < share < 1 or len(sure) < len(found):
        return None
    chance = float(np.prod(sure))
    together = (equal[2:] - share) * (equal[1:-1] - share)
    if share < 1.2 * chance or together.mean() > -APART * share * (1 - share) / len(equal) ** 0.5:
        return None
    return chance


def chance_of_equal(x: Floats, known: Bools) -> float | None:
    """Share of samples that equal the one before by their counts alone (from differences of one and
    two counts, whose sizes fall as those of a Gaussian), or None where the counts are too coarse to
    say, or the axis is dead."""
    if not np.ptp(x[known]):
        return None
    steps = np.abs(np.diff(x))[known[1:] & known[:-1]]
    step = signals.count_of(x[known])
    if (
        not step
    ):  # counts that hardly ever meet: of the finest step there is, up or down, as often as none
        finest = np.min(steps[steps > 1e-9 * np.ptp(x[known])])
        return float(max(np.mean(np.round(steps / finest) == size) for size in (1, 2))) / 2
    sizes = np.round(steps / step)
    one, two = np.mean(sizes == 1), np.mean(sizes == 2)
    return one / 2 * np.cbrt(one / two) if two > 0.01 * one else None


def find(columns: Mapping[str, Floats], known: Bools) -> Repeats | None:
    """The repeats beyond chance, or None."""
    if not known.any():
        return None
    both = known & np.concatenate([[False], known[:-1]])
    equal, chance = both.copy(), 1.0
    for name in axes_of(columns):
        x = columns[name]
        equal &= np.diff(x, prepend=x[0]) == 0
        by_counts = chance_of_equal(x, known)
        chance *= 1.0 if by_counts is None else by_counts
    count, tries = np.count_nonzero(equal), np.count_nonzero(both)
    if chance > CLEAR:
        explained = hidden(columns, equal, known)
        if explained is not None:
            return Repeats(equal, count / tries, explained, clear=False)
    if (
        chance > 0.1
        or count < 5
        or count < 1.5 * chance * tries
        or binom_logsf(count - 1, tries, chance) > np.log(CHANCE)
    ):
        return None
    return Repeats(equal, count / tries, chance)
