"""Samples that repeat the one before: a sensor that is read more often than it measures (DESIGN
13)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy
from scipy import ndimage

from ..arrays import Bools, Floats, Ints
from ..distributions import binom_logsf, norm_cdf, norm_pdf
from ..thresholds import REPEATS
from . import signals


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
    if two < REPEATS.finer * one or off(low) * off(high) > 0:
        return None
    sigma = float(scipy.optimize.brentq(off, low, high))
    return one * rounded_difference(sigma, 0) / rounded_difference(sigma, 1)


def axes_of(columns: Mapping[str, Floats]) -> list[str]:
    """The axes of the gyro, or of an accelerometer without one."""
    gyro = [name for name in columns if name.startswith("gyro_")]
    return gyro or [name for name in columns if name.startswith("accel_")]


def keep_apart(equal: Bools) -> bool:
    """Do equal samples follow each other less often than at random. Those of a sensor that is read
    once a sample follow each other more often, because its noise is smaller for a while or near the
    middle of a count. A sensor that is read too often gives a fresh sample after one or a few
    repeats.
    """
    share = float(equal[1:].mean())
    together = (equal[2:] - share) * (equal[1:-1] - share)
    return bool(together.mean() < -REPEATS.keep_apart * share * (1 - share) / len(equal) ** 0.5)


def hidden(x: Floats, equal: Bools, known: Bools) -> float | None:
    """The share of equal samples that counts explain, where there are more and they keep apart;
    else None."""
    chance, share = by_counts(x, known), float(equal[1:].mean())
    if chance is None or share < 1.2 * chance or not keep_apart(equal):
        return None
    return chance


def chance_of_equal(x: Floats, known: Bools, least: float = 0.01) -> float:
    """Share of samples that equal the one before by their counts alone (from differences of one and
    two counts, whose sizes fall as those of a Gaussian); 1 where the counts are too coarse to say:
    `least` differences of two over those of one."""
    steps = np.abs(np.diff(x))[known[1:] & known[:-1]]
    step = signals.count_of(x[known])
    if (
        not step
    ):  # counts that hardly ever meet: of the finest step there is, up or down, as often as none
        finest = np.min(steps[steps > 1e-9 * np.ptp(x[known])])
        return float(max(np.mean(np.round(steps / finest) == size) for size in (1, 2))) / 2
    sizes = np.round(steps / step)
    one, two = np.mean(sizes == 1), np.mean(sizes == 2)
    return float(one / 2 * np.cbrt(one / two)) if two > least * one else 1.0


def beyond(equal: Bools, tries: int, chance: float) -> Repeats | None:
    """Repeats that are more than chance, where chance explains so few that they can be left out."""
    count = np.count_nonzero(equal)
    if (
        chance > 0.1
        or count < 5
        or count < 1.5 * chance * tries
        or binom_logsf(count - 1, tries, chance) > np.log(REPEATS.false_repeats)
    ):
        return None
    return Repeats(equal, count / tries, chance)


def by_one(x: Floats, known: Bools, equal: Bools, tries: int) -> Repeats | None:
    """Repeats of a single axis, by its counts."""
    chance = chance_of_equal(x, known)
    if chance > REPEATS.clear:
        explained = hidden(x, equal, known)
        if explained is not None:
            return Repeats(equal, np.count_nonzero(equal) / tries, explained, clear=False)
    return beyond(equal, tries, chance)


def by_axes(same: Bools, equal: Bools, both: Bools) -> Repeats | None:
    """Repeats of a sensor of several axes (rows of `same`) whose counts hide them: axes that are
    each equal to the sample before by chance are so together no more often than the product of
    their shares. In blocks, because motion and the place of the bias in a count change the shares;
    and only where they keep apart (see hidden), because a vibration of all axes changes them within
    a block.
    """
    count = len(same)
    length = np.count_nonzero(both) // REPEATS.phase_block * REPEATS.phase_block
    if not length or not keep_apart(equal):
        return None
    blocks = same[:, both][:, :length].reshape(count, -1, REPEATS.phase_block)
    shares, shared = blocks.mean(axis=2), blocks.all(axis=0).mean(axis=1)
    more = shared - shares.prod(axis=0)
    if (
        more.mean()
        <= REPEATS.keep_apart * max(more.std(), 1 / REPEATS.phase_block) / len(more) ** 0.5
    ):
        return None
    share = float(shared.mean())

    def chance_behind(repeated: float) -> float:
        """Share of fresh samples that are equal by chance, if so many are repeats."""
        return float(np.mean((shares - repeated).prod(axis=0)) / (1 - repeated) ** count)

    def off(repeated: float) -> float:
        return repeated + (1 - repeated) * chance_behind(repeated) - share

    most = min(share, float(shares.mean(axis=1).min()))
    repeated = float(scipy.optimize.brentq(off, 0.0, most)) if off(most) > 0 else most
    if repeated < REPEATS.hidden_least:
        return None
    return Repeats(equal, share, max(chance_behind(repeated), 0.0), clear=False)


def quiet_around(columns: Mapping[str, Floats], axes: list[str], equal: Bools) -> bool:
    """Do the axes move less than usual before and after their equal samples: a vibration at its
    turning points, or noise that is small for a while. A sample that is read twice is no calmer."""
    moves = sum(np.abs(np.diff(columns[name])) / np.std(np.diff(columns[name])) for name in axes)
    starts, lengths = runs_of(equal)
    before, after = starts - 2, starts + lengths - 1  # places of differences
    inside = (before >= 0) & (after < len(moves))
    around = np.concatenate([moves[before[inside]], moves[after[inside]]])
    return bool(len(around) and around.mean() < REPEATS.calm * moves[~equal[1:]].mean())


def find(columns: Mapping[str, Floats], known: Bools) -> Repeats | None:
    """The repeats beyond chance, or None."""
    if not known.any():
        return None
    both = known & np.concatenate([[False], known[:-1]])
    changes: dict[str, Bools] = {}
    for name in axes_of(columns):  # neither a dead one nor one in other words
        still = np.diff(columns[name], prepend=np.nan) == 0
        if np.ptp(columns[name][known]) and not any(
            np.array_equal(still, other) for other in changes.values()
        ):
            changes[name] = still
    if not changes:
        return None
    axes, same = list(changes), np.array(list(changes.values()))
    equal, tries = both & same.all(axis=0), np.count_nonzero(both)
    if len(axes) == 1:
        return by_one(columns[axes[0]], known, equal, tries)
    chance = float(
        np.prod([chance_of_equal(columns[name], known, REPEATS.phase_matters) for name in axes])
    )
    if chance > REPEATS.clear:
        return by_axes(same, equal, both)
    found = beyond(equal, tries, chance)
    return None if found and quiet_around(columns, axes, equal) else found


def held(columns: Mapping[str, Floats], axis: str, known: Bools) -> Bools:
    """True where an axis alone keeps a value for longer than its counts do by chance, from its
    second sample on. None of those that change seldom anyway."""
    x = columns[axis]
    same = known & np.concatenate([[False], known[:-1]]) & (np.diff(x, prepend=np.nan) == 0)
    others = [name for name in axes_of(columns) if name != axis]
    all_others = np.full(len(x), bool(others))
    for name in others:
        all_others &= np.diff(columns[name], prepend=np.nan) == 0
    starts, lengths = runs_of(same)
    local = ndimage.uniform_filter1d(same.astype(float), 2 * REPEATS.phase_block)
    usual, stuck = float(np.median(local)), np.zeros(len(starts), bool)
    for _ in range(2):  # the first time without long runs, the second with their usual length
        if usual > REPEATS.seldom:
            return np.zeros(len(x), bool)
        chance = np.log(REPEATS.false_repeats / max(len(starts), 1)) / np.log(
            max(usual, 1 / REPEATS.phase_block)
        )
        beside = local[starts + lengths // 2] * 2 * REPEATS.phase_block - lengths
        stuck = (lengths > 1 + chance) & (beside < REPEATS.seldom * 2 * REPEATS.phase_block)
        rest = lengths[~stuck]
        usual = max(usual, float(np.mean(rest > 1))) if len(rest) else usual
    found = np.zeros(len(x), bool)
    for start, length in zip(starts[stuck], lengths[stuck]):
        if all_others[start : start + length].mean() < 0.5:
            found[start : start + length] = True
    return found


def runs_of(same: Bools) -> tuple[Ints, Ints]:
    """First sample and length of each run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(int)))
    return edges[::2], edges[1::2] - edges[::2]
