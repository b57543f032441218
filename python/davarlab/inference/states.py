"""A few levels or a continuum? Telegraph noise and Gauss-Markov share a spectrum; their amplitudes
differ (DESIGN 6)."""

from collections.abc import Iterable, Sequence
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


def gauss_markov_log_likelihood(values: Floats, std: float, noise: float, decay: float) -> float:
    """Kalman filter of a first-order process in white noise; once its gain has settled it is a
    plain recursive filter."""
    mean, variance, total = 0.0, std**2, 0.0
    grow, white = std**2 * (1 - decay**2), noise**2
    for i, value in enumerate(values):
        spread, before = variance + white, variance
        miss, gain = value - mean, variance / spread
        total -= 0.5 * (log(2 * pi * spread) + miss * miss / spread)
        mean = decay * (mean + gain * miss)
        variance = decay * decay * variance * (1 - gain) + grow
        if abs(variance - before) < 1e-9 * before:
            rest = values[i + 1 :]
            means = rest
            if len(rest):
                filtering = [0.0, decay * gain], [1.0, -decay * (1 - gain)]
                means = scipy.signal.lfilter(*filtering, rest, zi=[mean])[0]
            found: float = total - 0.5 * float(
                len(rest) * log(2 * pi * spread) + np.sum((rest - means) ** 2) / spread
            )
            return found
    return total


def bounded(logarithms: Iterable[float]) -> list[float]:
    """Their exponentials, kept where arithmetic is safe however far a search strays."""
    return [exp(max(-60.0, min(60.0, value))) for value in logarithms]


def blocks_for(x: Floats, rate_hz: float, dwell_s: float) -> tuple[Floats, int]:
    """Means of x over a small part of the dwell, and the length of a block in samples."""
    block = min(
        max(1, int(max(dwell_s / LEVELS.blocks_per_dwell * rate_hz, len(x) / LEVELS.blocks_most))),
        len(x) // LEVELS.blocks_least,
    )
    values = averaged(x, block)
    return values - values.mean(), block


def fit_levels(
    x: Floats, rate_hz: float, std: float, dwell_s: float, white: float, levels: int = 2
) -> tuple[float, float, float, float]:
    """(log-likelihood, amplitude, dwell, middle of the levels) of a chain of levels in white noise;
    std, dwell_s: of the two-level chain with its spectrum. The mean is not the middle: few dwells
    are not shared out evenly."""
    values, block = blocks_for(x, rate_hz, dwell_s)
    period, noise = block / rate_hz, max(white / sqrt(block / rate_hz), 1e-12)

    def loss(p: Sequence[float]) -> float:
        level, spread, dwell = bounded(p[:3])
        chain = level, spread, staying(period, dwell, levels)
        return -chain_of_levels(values - p[3] * level, chain, levels)[0]

    first = [
        log(std / sqrt(mean_square(levels))),
        log(noise * 1.1),
        log(dwell_s / 2 * levels / (levels - 1)),
    ]
    starts = [
        [first[0] + size, *first[1:], off]
        for size in (-0.4, 0.0, 0.4)
        for off in (0.0, -0.5, 0.5, -1.0, 1.0)
    ]
    found = scipy.optimize.minimize(
        loss, min(starts, key=loss), method="Nelder-Mead", options=LEVELS.simplex
    )
    level, _, dwell = bounded(found.x[:3])
    return (
        -found.fun,
        level,
        dwell,
        float(np.mean(x[: len(values) * block])) + float(found.x[3]) * level,
    )


def fit_continuum(x: Floats, rate_hz: float, std: float, dwell_s: float, white: float) -> float:
    """Log-likelihood of a first-order process in white noise, on the same blocks."""
    values, block = blocks_for(x, rate_hz, dwell_s)
    period, noise = block / rate_hz, max(white / sqrt(block / rate_hz), 1e-12)

    def loss(p: Sequence[float]) -> float:
        size, spread, dwell = bounded(p)
        return -gauss_markov_log_likelihood(values, size, spread, exp(-2 * period / dwell))

    found: float = -scipy.optimize.minimize(
        loss,
        [log(std), log(noise * 1.1), log(dwell_s)],
        method="Nelder-Mead",
        options=LEVELS.simplex,
    ).fun
    return found


def decoded(
    x: Floats,
    rate_hz: float,
    level: float,
    dwell_s: float,
    white: float,
    levels: int = 2,
    resolution: int = 240,
) -> tuple[Floats, float, float, float]:
    """Of x around the middle of its levels: posterior mean of the state (places()) at every sample;
    its divergence from what the chain says beforehand; the sum of its variance / (2 noise^2), what
    doubt about the state costs per squared amplitude (6.3); and its mean square."""
    block = min(
        max(1, int(dwell_s * rate_hz / resolution), len(x) // 60000), len(x) // LEVELS.blocks_least
    )
    values = averaged(x, block)
    noise = max(white / sqrt(block / rate_hz), 1e-9)
    stay = staying(block / rate_hz, dwell_s, levels)
    total, chance = chain_of_levels(values, (level, noise, stay), levels, True)
    state, square = places(levels) @ chance, places(levels) ** 2 @ chance
    doubt = float(np.sum(square - state**2)) / (2 * noise**2)
    known = (
        -0.5 * np.sum((values - level * state) ** 2 / noise**2 + np.log(2 * pi * noise**2))
        - level**2 * doubt
    )
    centres = (np.arange(len(state)) + 0.5) * block
    return (
        np.interp(np.arange(len(x)), centres, state),
        float(known) - total,
        doubt,
        float(square.mean()),
    )


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
