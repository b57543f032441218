"""Samples that repeat the one before: a sensor that is read more often than it measures (DESIGN
13)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import stats

from ..arrays import Bools, Floats
from . import signals

CHANCE = 1e-6  # of a sensor without repeats, per recording


@dataclass
class Repeats:
    """equal: True where a sample repeats the one before on all axes of the gyro; share: of the
    samples; chance: the share that counts explain."""

    equal: Bools
    share: float
    chance: float


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
    for name in (name for name in columns if name.startswith("gyro_")):
        x = columns[name]
        equal &= np.diff(x, prepend=x[0]) == 0
        by_counts = chance_of_equal(x, known)
        chance *= 1.0 if by_counts is None else by_counts
    count, tries = np.count_nonzero(equal), np.count_nonzero(both)
    if (
        chance > 0.1
        or count < 5
        or count < 1.5 * chance * tries
        or stats.binom.logsf(count - 1, tries, chance) > np.log(CHANCE)
    ):
        return None
    return Repeats(equal, count / tries, chance)
