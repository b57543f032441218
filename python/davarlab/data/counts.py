"""Counts: the step in which a sensor's rate, or its angle, comes, known from the record's own grid;
what the rounding adds (DESIGN 14)."""

from dataclasses import dataclass, field

import numpy as np
import scipy
from scipy import ndimage

from ..arrays import Floats, Ints
from ..distributions import norm_cdf
from ..thresholds import COUNTS, EVENTS
from . import signals

PHASES = np.linspace(*COUNTS.phase_grid)


@dataclass
class Counts:
    """q: the step, deg/s; of: "rate" or "angle"; sigma and mean per sample in counts; `added`: the
    variance per ordinate that the rounding adds, over q^2, on an even grid of frequencies from 0 to
    half the rate; kurtosis: excess that the rounding gives to samples (rates)."""

    q: float
    of: str
    rate_hz: float
    sigma_counts: float
    mean_counts: float
    added: Floats = field(repr=False)
    kurtosis: float = 0.0

    def level(self, f: Floats) -> Floats:
        """Variance per ordinate, (deg/s)^2, behind any filter."""
        return self.q**2 * np.interp(
            np.asarray(f) / self.rate_hz, np.linspace(0, 0.5, len(self.added)), self.added
        )

    @property
    def coarse(self) -> bool:
        """Does the rounding do more than add white noise, or white noise of an angle."""
        return self.sigma_counts < (COUNTS.fine if self.of == "rate" else COUNTS.smeared)

    @property
    def reach_dps(self) -> float:
        """How far single samples go from their mean by noise and rounding alone; 0 where rounding
        does not matter to that."""
        return (
            self.q * (EVENTS.wild * self.sigma_counts + 1)
            if self.coarse or self.of == "angle"
            else 0.0
        )

    @property
    def unsteady(self) -> bool:
        """Does the noise of the rounding change with the bias in a way that is not known block by
        block."""
        return self.of == "angle" and self.sigma_counts < COUNTS.suspended

    @property
    def sparse(self) -> bool:
        """Are most samples of one value, so that a short section may have no other."""
        return self.coarse and self.kurtosis > 1

    @property
    def suspends(self) -> tuple[str, ...]:
        """Tests of adequacy that such counts fail by themselves."""
        if not self.coarse:
            return ()
        return (
            ("amplitudes", "time and frequency", "largest cell")
            if self.unsteady
            else ("amplitudes", "jumps")
            if self.sparse
            else ("amplitudes",)
        )


def levels_of(x: Floats, together: bool = False) -> Floats | None:
    """Distinct values; `together`: those that differ by the rounding of a sum only are one. None
    where hardly any repeats."""
    values = np.unique(x)
    edges: Ints = np.arange(len(values))
    if together and len(values) > 2:
        steps = np.diff(values)
        order = np.sort(steps)
        ratio = order[1:] / order[:-1]
        least = order[np.argmax(ratio)]
        if ratio.max() > COUNTS.split and least < COUNTS.sum_rounding * np.abs(values).max():
            edges = np.concatenate([[0], np.flatnonzero(steps > least) + 1])
    if len(edges) < 2 or len(edges) * COUNTS.distinct > len(x):
        return None
    found: Floats = np.add.reduceat(values, edges) / np.diff(np.append(edges, len(values)))
    return found


def step_of(levels: Floats) -> float:
    """The count that an even grid through the levels has; 0 when there is none."""
    steps = np.diff(levels)
    least = steps[steps < 1.5 * steps.min()]
    for part in (1, 2, 3):
        place = np.concatenate([[0], np.cumsum(np.round(steps * part / np.median(least)))])
        q, start = np.polyfit(place, levels - levels[0], 1)
        if np.sqrt(np.mean((levels - levels[0] - start - q * place) ** 2)) < COUNTS.uneven * q:
            return float(q)
    return 0.0


def step(x: Floats) -> float:
    """The count in which x comes, whatever its offset, scale and the digits of its file; 0 where
    there is none. The wildest samples are left out, and of more than `step_samples` an even
    selection is used."""
    x = x[:: max(1, len(x) // COUNTS.step_samples)]
    low, high = np.quantile(x, [0.005, 0.995])
    x = x[(x >= low) & (x <= high)]
    found = (levels_of(x), levels_of(x, True))
    steps = [step_of(levels) for levels in found if levels is not None]
    return next(
        (
            q
            for q in steps
            if q and abs(np.mean(np.exp(2j * np.pi * (x - x[0]) / q))) > COUNTS.on_grid
        ),
        0.0,
    )


# A rate in counts ---------------------------------------------------------------------------------


def chances(phase: Floats, sigma: float) -> tuple[Ints, Floats]:
    """(count, its chance) per phase: of a rate whose mean lies `phase` counts above a count, with
    that noise."""
    reach = int(np.ceil(0.5 + 6 * sigma)) + 1
    k = np.arange(-reach, reach + 1)
    edges = (np.arange(-reach, reach + 2) - 0.5 - np.asarray(phase)[..., None]) / sigma
    return k, np.diff(norm_cdf(edges), axis=-1)


def rounded(sigma: float, phase: Floats = PHASES) -> tuple[Floats, Floats, Floats]:
    """Mean and variance, in counts, of what comes out, and how much more than that of a Gaussian
    the square of its deviation scatters."""
    k, p = chances(phase, sigma)
    mean = p @ k
    square = (k - mean[:, None]) ** 2
    variance = np.maximum(np.sum(p * square, axis=1), 1e-12)
    return mean, variance, (np.sum(p * square**2, axis=1) / variance**2 - 1) / 2


def phase_of(mean: Floats, sigma: float) -> Floats:
    """The true mean, in counts, behind means of rounded samples."""
    whole = np.round(mean)
    known = np.maximum.accumulate(rounded(sigma)[0]) + 1e-12 * np.arange(
        len(PHASES)
    )  # flat where there is hardly any noise
    return whole + np.interp(mean - whole, known, PHASES)


def probit_sigma(k: Floats) -> float:
    """Noise of rounded samples k (whole numbers), by ordered probit in short blocks with a mean of
    their own."""
    blocks: Floats = k[: len(k) // COUNTS.probit * COUNTS.probit].reshape(-1, COUNTS.probit)
    blocks = blocks[:: max(1, len(blocks) // COUNTS.probit_blocks)]
    means = blocks.mean(axis=1)
    whole = np.round(means)
    reach = 6
    tally = np.stack(
        [
            (np.clip(blocks - whole[:, None], -reach, reach) == j).sum(axis=1)
            for j in range(-reach, reach + 1)
        ],
        axis=1,
    )

    def loss(log_sigma: float) -> float:
        sigma = np.exp(log_sigma)
        phase = phase_of(means, sigma) - whole
        edges = (np.arange(-reach, reach) + 0.5 - phase[:, None]) / sigma
        p = np.diff(
            norm_cdf(np.pad(edges, ((0, 0), (1, 1)), constant_values=((0, 0), (-np.inf, np.inf)))),
            axis=1,
        )
        return -float(np.sum(tally * np.log(np.maximum(p, 1e-12))))

    found = scipy.optimize.minimize_scalar(
        loss, bounds=(np.log(0.05), np.log(1.5)), method="bounded", options={"xatol": 1e-3}
    )
    out: float = float(np.exp(found.x)) * np.sqrt(COUNTS.probit / (COUNTS.probit - 1))
    return out


def slow_phase(k: Floats, sigma: float) -> Floats:
    """The bias in counts around each sample."""
    return phase_of(ndimage.uniform_filter1d(k, COUNTS.probit, mode="nearest"), sigma)


def block_variances(k: Floats, sigma: float, length: int) -> list[Floats]:
    """Variance, in counts, that the bias gives to each block of `length` samples, and the scatter
    of rounded()."""
    phase = slow_phase(k, sigma)
    count = len(k) // length
    return [
        np.interp(phase - np.round(phase), PHASES, course)[: count * length]
        .reshape(count, length)
        .mean(axis=1)
        for course in rounded(sigma)[1:]
    ]


# An angle in counts -------------------------------------------------------------------------------


def error_spectrum(increments: Floats, mean: Floats) -> Floats:
    """Variance per ordinate of the rounding error of an angle, in counts, on an even grid of
    frequencies; increments: autocovariance of the true angle's steps per sample; mean: the course
    of their mean. Exact for Gaussian steps:
    cov(L) = sum over k of
             cos(2 pi k mean L) exp(-2 pi^2 k^2 var(angle over L samples)) / (2 pi^2 k^2)."""
    lag = np.arange(len(increments))
    spread = np.concatenate(
        [[0.0], np.cumsum(increments[0] + 2 * np.concatenate([[0.0], np.cumsum(increments[1:])]))]
    )[: len(lag)]
    spread = np.maximum(spread, COUNTS.angle_noise**2 * lag)
    covariance = np.zeros(len(lag))
    covariance[0] = 1 / 12
    for k in range(1, COUNTS.harmonics + 1):
        fade = np.exp(-2 * (np.pi * k) ** 2 * spread[1:]) / (2 * (np.pi * k) ** 2)
        seen = np.flatnonzero(fade > 1e-9)
        last = seen[-1] + 1 if len(seen) else 0
        turns = (
            np.cos(2 * np.pi * k * np.outer(mean, lag[1 : last + 1])).mean(axis=0)
            if last
            else np.zeros(0)
        )
        covariance[1 : last + 1] += fade[:last] * turns
    return np.maximum(even_transform(covariance), 0)


def even_transform(covariance: Floats) -> Floats:
    """cov(0) + 2 sum cov(L) cos(2 pi nu L), nu from 0 to 1/2 in as many steps."""
    return np.fft.rfft(np.concatenate([covariance[:-1], covariance[:0:-1]])).real


def differenced() -> Floats:
    """Power gain of the difference of neighbours on the grid."""
    found: Floats = 4 * np.sin(np.pi * np.linspace(0, 0.5, COUNTS.lags + 1)) ** 2
    return found


# Which of the two ---------------------------------------------------------------------------------


def bands_of(k: Floats) -> tuple[Floats, Floats, Ints]:
    """(frequency over rate, robust level, ordinates) of bands in the upper part of the spectrum of
    k."""
    c = signals.transform(k - k.mean())[1:] ** 2
    edges = np.unique(np.linspace(len(c) // 20, len(c), COUNTS.count_bands + 1).astype(int))
    level = np.array([np.median(c[a:b]) for a, b in zip(edges[:-1], edges[1:])]) / 0.4549
    return (edges[1:] + edges[:-1]) / 4 / len(c), np.maximum(level, 1e-9), np.diff(edges)


def responses(nu: Floats) -> Floats:
    """Power gains of what a sensor may have in front of its counts: nothing, a pole, a mean over
    two samples."""
    decay = np.exp(-2 * np.pi * np.geomspace(0.02, 0.7, 12))[:, None]
    poles = (1 - decay) ** 2 / ((1 - decay) ** 2 + decay * 4 * np.sin(np.pi * nu) ** 2)
    b = np.array([0.05, 0.1, 0.17, 0.25, 0.4])[:, None]
    return np.vstack(
        [np.ones((1, len(nu))), poles, 1 - 4 * b / (1 + b) ** 2 * np.sin(np.pi * nu) ** 2]
    )


def misfit(
    level: Floats, count: Ints, rows: Floats, known: Floats | float = 0.0
) -> tuple[float, Floats]:
    """Twice the log-likelihood that sizes >= 0 of the rows, beside what is known, lose; and the
    sizes."""
    fitted = level
    for _ in range(8):
        weight = np.sqrt(count) / fitted
        sizes = scipy.optimize.nnls((rows * weight).T, np.maximum(level - known, 0) * weight)[0]
        fitted = np.maximum(sizes @ rows + known, 1e-6 * level)
    return float(np.sum(np.log(level / fitted) ** 2 * count / COUNTS.median_scatter)), sizes


def as_rate(nu: Floats, level: Floats, count: Ints) -> float:
    return min(
        misfit(level, count, np.vstack([gain, np.ones_like(nu)]))[0] for gain in responses(nu)
    )


def as_angle(
    nu: Floats, level: Floats, count: Ints, mean: Floats, gain: Floats, dense: Floats
) -> tuple[float, Floats, float, float]:
    """(misfit, error spectrum, sigma per sample, size of the error were it free) behind a response,
    at the bands and on the grid."""
    grid = np.linspace(0, 0.5, COUNTS.lags + 1)
    error: Floats = np.full(COUNTS.lags + 1, 1 / 12)
    for _ in range(COUNTS.angle_rounds):
        known = np.interp(nu, grid, differenced() * error)
        loss, sizes = misfit(level, count, gain[None, :], known)
        increments = np.fft.irfft(np.maximum(sizes[0], 1e-6) * dense)[: COUNTS.lags + 1]
        if increments[0] > COUNTS.fine**2:
            break
        error = error_spectrum(increments, mean)
    free = misfit(level, count, np.vstack([gain, known]))[1][1]
    return loss, error, float(np.sqrt(max(increments[0], 0))), float(free)


def of_angle(k: Floats) -> tuple[Floats, float] | None:
    """(error spectrum, sigma) when k fits as differences of a counted angle, clearly better than as
    a counted rate; else None."""
    nu, level, count = bands_of(k)
    pieces = np.array([piece.mean() for piece in np.array_split(k, COUNTS.angle_means)])
    gains = list(zip(responses(nu), responses(np.linspace(0, 0.5, COUNTS.lags + 1))))
    loss, error, sigma, size = first = as_angle(nu, level, count, pieces, *gains[0])
    if loss > COUNTS.enough * len(nu):
        loss, error, sigma, size = min(
            (as_angle(nu, level, count, pieces, *one) for one in gains[1:]), key=lambda one: one[0]
        )
        if first[0] < loss + COUNTS.simpler:
            loss, error, sigma, size = first
    least, most = COUNTS.as_known
    if least < size < most and as_rate(nu, level, count) - loss > COUNTS.telling:
        return error, sigma
    return None


def found(y: Floats, rate_hz: float) -> Counts | None:
    """Counts of the record y (deg/s, as it was logged), or None."""
    q = step(y)
    if not q:
        return None
    k = whole_numbers(y, q)
    crude = float(np.std(np.diff(k)) / np.sqrt(2))
    found = of_angle(k - np.round(k.mean())) if crude < COUNTS.angle_up_to else None
    if found:
        return Counts(q, "angle", rate_hz, found[1], float(k.mean()), differenced() * found[0])
    sigma = probit_sigma(k) if crude < 0.75 else float(np.sqrt(max(crude**2 - 1 / 12, 1e-6)))
    if sigma >= COUNTS.fine:
        return Counts(q, "rate", rate_hz, sigma, float(k.mean()), np.array([1, 1]) / 12)
    variance, scatter = (float(course.mean()) for course in block_variances(k, sigma, 1))
    return Counts(
        q,
        "rate",
        rate_hz,
        sigma,
        float(k.mean()),
        np.full(2, variance - sigma**2),
        max(0.0, 2 * (scatter - 1)),
    )


def whole_numbers(y: Floats, q: float) -> Floats:
    """y in counts; the grid need not go through 0."""
    start = y[len(y) // 2]
    offset = start - q * np.round(start / q)
    found: Floats = np.round((y - offset) / q)
    return found


def relative_variance(y: Floats, counts: Counts | None, length: int) -> tuple[Floats, float] | None:
    """Variance of each block of `length` samples over their mean, as far as it is known from the
    counts, and how much more its energy scatters than that of Gaussian noise; None where counts do
    not move it."""
    if counts is None or counts.of != "rate" or not counts.coarse:
        return None
    variance, scatter = block_variances(whole_numbers(y, counts.q), counts.sigma_counts, length)
    return variance / variance.mean(), max(1.0, float(scatter.mean()))


def explained(y: Floats, counts: Counts, length: int) -> tuple[float, float, float, float]:
    """(slope, its standard error, chi-square per degree of freedom before and after) of the
    variances of blocks against those that the counts give them: a slope of 1 says that the counts
    explain why the noise changes."""
    k = whole_numbers(y, counts.q)
    expected, scatter = block_variances(k, counts.sigma_counts, length)
    measured = k[: len(expected) * length].reshape(-1, length).var(axis=1, ddof=1)
    weight = (length - 1) / 2 / (expected**2 * np.maximum(scatter, 0.1))
    x, z = (
        expected - np.average(expected, weights=weight),
        measured - np.average(measured, weights=weight),
    )
    power = float(np.sum(weight * x**2))
    slope = float(np.sum(weight * x * z)) / max(power, 1e-300)
    relative = measured / expected
    chi = [
        float(np.var(v / v.mean()) * (length - 1) / 2 / scatter.mean())
        for v in (measured, relative)
    ]
    return slope, float(np.sqrt(max(chi[1], 1) / max(power, 1e-300))), chi[0], chi[1]
