"""A few levels or a continuum? Telegraph noise and Gauss-Markov share a spectrum; their amplitudes
differ (DESIGN 6)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import exp, log, pi, sqrt

import numpy as np
import scipy
from scipy import special

from ..arrays import Floats, Ints
from ..distributions import chi2_cdf, chi2_sf
from ..effects.device import chain_of_levels
from ..thresholds import LEVELS


def averaged(x: Floats, block: int) -> Floats:
    count = len(x) // block
    found: Floats = x[: count * block].reshape(count, block).mean(axis=1)
    return found


def places(levels: int) -> Floats:
    """Where the levels lie, 2 apart, the highest first."""
    return np.arange(levels - 1, -levels, -2.0)


def mean_square(levels: int) -> float:
    """Of places that are all as likely."""
    return (levels**2 - 1) / 3


def staying(period: float, dwell: float, levels: int = 2) -> float:
    """The chance to be on the same level a period later, when every switch goes to any of the
    others."""
    return (1 + (levels - 1) * exp(-levels / (levels - 1) * period / dwell)) / levels


@dataclass(frozen=True)
class Noise:
    """What levels stand beside: processes of first order in white noise, as a Kalman filter has
    it (6.3)."""

    times_s: Floats  # correlation times
    variances: Floats
    white: float  # two-sided density

    def rows(self, period_s: float) -> Floats:
        """(decay, variance) of each process from value to value."""
        return np.column_stack([np.exp(-period_s / self.times_s), self.variances])

    def beside(self, std: float, time_s: float) -> "Noise":
        """With one more process."""
        times, variances = np.append(self.times_s, time_s), np.append(self.variances, std**2)
        return Noise(times, variances, self.white)


def noise_of(f: Floats, density: Floats, shortest_s: float, longest_s: float) -> Noise:
    """White noise and processes with these correlation times, a factor of LEVELS.process_ratio
    apart, whose density (two-sided, at the frequencies f) is nearest to a given one."""
    count = int(np.ceil(log(longest_s / shortest_s) / log(LEVELS.process_ratio))) + 1
    times = np.geomspace(shortest_s, longest_s, min(count, LEVELS.processes_most))
    rows = 2 * times[:, None] / (1 + (2 * pi * f * times[:, None]) ** 2)
    relative = np.vstack([rows, np.ones_like(f)]) / density
    sizes = scipy.optimize.nnls(relative.T, np.ones(len(f)))[0]
    there = sizes[:-1] > 0
    return Noise(
        times[there], sizes[:-1][there], max(float(sizes[-1]), LEVELS.white_least * density.min())
    )


def bounded(logarithms: Iterable[float]) -> list[float]:
    """Their exponentials, kept where arithmetic is safe however far a search strays."""
    return [exp(max(-60.0, min(60.0, value))) for value in logarithms]


def block_of(x: Floats, rate_hz: float, dwell_s: float, per_dwell: int) -> int:
    """Samples in a small part of the dwell."""
    shortest = max(dwell_s / per_dwell * rate_hz, len(x) / LEVELS.blocks_most)
    return min(max(1, int(shortest)), len(x) // LEVELS.blocks_least)


def chained(
    values: Floats,
    period_s: float,
    noise: Noise,
    chain: tuple[float, float],
    levels: int,
    posterior: bool = False,
) -> tuple[float, Floats]:
    """chain_of_levels of means over a period; chain: half the distance of neighbouring levels, and
    the dwell. The middle of the levels is free: few dwells are not shared out evenly."""
    amplitude, dwell_s = chain
    middle = [1.0, LEVELS.middle * float(np.mean(values**2))]
    leave = 1 - staying(period_s, dwell_s, levels) if levels > 1 else 0.0
    rows = np.vstack([noise.rows(period_s), middle])
    white = noise.white / period_s
    return chain_of_levels(values, rows, white, (amplitude, leave), levels, posterior)


Loss = Callable[[Floats], float]
Found = tuple[float, float, float]  # log-likelihood, amplitude, dwell


def least_of(loss: Loss, first: Floats) -> tuple[float, list[float]]:
    """(the least loss, exponentials of where it is)."""
    found = scipy.optimize.minimize(loss, first, method="Nelder-Mead", options=LEVELS.simplex)
    return float(found.fun), bounded(found.x)


def fit_levels(
    x: Floats,
    rate_hz: float,
    noise: Noise,
    start: tuple[float, float],
    levels: int = 2,
    hopeless: float = -np.inf,
) -> Found:
    """(log-likelihood, amplitude, dwell) of a chain of levels. start: standard deviation and dwell
    of the two-level chain with its spectrum; `hopeless`: a likelihood there, below which the
    maximum is not sought."""
    std, dwell_s = start
    block = block_of(x, rate_hz, dwell_s, LEVELS.blocks_per_dwell)
    values, period = averaged(x, block), block / rate_hz

    def loss(p: Floats) -> float:
        level, dwell = bounded(p)
        return -chained(values, period, noise, (level, dwell), levels)[0]

    first = np.log([std / sqrt(mean_square(levels)), dwell_s / 2 * levels / (levels - 1)])
    starts = [first + [size, 0.0] for size in LEVELS.first_sizes]
    losses = [loss(one) for one in starts]
    best = starts[int(np.argmin(losses))]
    least, (level, dwell) = min(losses), bounded(best)
    if -least >= hopeless:
        least, (level, dwell) = least_of(loss, best)
    return -least, level, dwell


def fit_continuum(x: Floats, rate_hz: float, noise: Noise, start: tuple[float, float]) -> float:
    """Log-likelihood of one more process of first order, on the same blocks."""
    std, dwell_s = start
    block = block_of(x, rate_hz, dwell_s, LEVELS.blocks_per_dwell)
    values, period = averaged(x, block), block / rate_hz

    def loss(p: Floats) -> float:
        size, time = bounded(p)
        return -chained(values, period, noise.beside(size, time), (0.0, dwell_s), 1)[0]

    return -least_of(loss, np.log([std, dwell_s / 2]))[0]


def decoded(
    x: Floats, rate_hz: float, noise: Noise, level: float, dwell_s: float, levels: int = 2
) -> tuple[Floats, float]:
    """(posterior mean of the state (places()) at every sample of x, its mean square)."""
    block = block_of(x, rate_hz, dwell_s, LEVELS.decoded_per_dwell)
    values = averaged(x, block)
    chance = chained(values, block / rate_hz, noise, (level, dwell_s), levels, True)[1]
    state, square = places(levels) @ chance, places(levels) ** 2 @ chance
    centres = (np.arange(len(state)) + 0.5) * block
    return np.interp(np.arange(len(x)), centres, state), float(square.mean())


def many_switches(dwell_s: float, x: Floats, rate_hz: float) -> bool:
    """Can a record of this length show chance at work: some dwells (LEVELS.switches_least), each of
    some samples."""
    return 4 / rate_hz < dwell_s < len(x) / rate_hz / LEVELS.switches_least


def dwells(path: Floats, levels: int, shortest: float = 0.0) -> tuple[Ints, Ints]:
    """(level, samples) of each dwell of a decoded path, without the first and the last, which the
    record cuts; and without those below `shortest` of the mean."""
    level = np.clip(np.round((levels - 1 - path) / 2), 0, levels - 1).astype(int)
    sure = np.flatnonzero(np.abs(path - places(levels)[level]) < 0.5)
    starts = sure[np.diff(level[sure], prepend=-1) != 0]
    lengths = np.diff(starts, append=len(path))
    long = lengths >= shortest * lengths.mean()
    at = level[starts[long]]
    first = np.flatnonzero(np.diff(at, prepend=-1))
    return at[first][1:-1], np.add.reduceat(lengths[long], first)[1:-1]


def uneven(lengths: Ints) -> bool:
    """Are dwells as uneven as those of a gamma distribution of shape LEVELS.joined (Moran's test)?
    Short dwells that are not seen make the others more even than exponential ones."""
    count = len(lengths)
    if count < 2:
        return True
    spread = np.log(lengths.mean()) - np.log(lengths).mean()
    expected = np.log(LEVELS.joined) - special.digamma(LEVELS.joined)
    found = 2 * count * spread * np.euler_gamma / expected / (1 + (count + 1) / (6 * count))
    return bool(chi2_cdf(found, count - 1) > LEVELS.uneven_chance)


def anywhere(at: Ints, levels: int) -> bool:
    """Does a switch go to any other level as often, and not only to the next one, as a course does
    that slides."""
    moves = np.zeros((levels, levels))
    np.add.at(moves, (at[:-1], at[1:]), 1)
    expected = moves.sum(axis=1, keepdims=True) / (levels - 1) * (1 - np.eye(levels))
    there = expected > 0
    off = float(np.sum((moves[there] - expected[there]) ** 2 / expected[there]))
    free = np.count_nonzero(there.any(axis=1)) * (levels - 2)
    return bool(free == 0 or chi2_sf(off, free) > LEVELS.uneven_chance)


def like_chance(path: Floats, levels: int = 2) -> bool:
    """Do the switches come at random: five of them at least, dwells on each level that are uneven,
    no length that most of them share (a clock with a few of its periods cut in two still ticks),
    and to any level."""
    at, lengths = dwells(path, levels)
    if len(lengths) + 1 < LEVELS.switches_least:
        return False
    ordered = np.sort(lengths)
    alike = np.searchsorted(ordered, LEVELS.alike_dwells * ordered, side="right") - np.arange(
        len(ordered)
    )
    return bool(
        alike.max() <= max(3, 0.4 * len(ordered))
        and all(uneven(lengths[at == level]) for level in range(levels))
        and anywhere(dwells(path, levels, LEVELS.passing)[0], levels)
    )
