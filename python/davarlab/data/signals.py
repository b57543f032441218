"""Plain operations on sampled signals."""

from collections.abc import Callable, Iterable

import numpy as np
from scipy import fft, ndimage

from .. import arrays
from ..arrays import Complexes, Floats, Ints
from ..thresholds import COUNTS, SIGNALS

PIECE = 1 << 18  # samples that are worked out together where whole records would fill the memory
WAVE_PIECE = 1024  # samples of a sine that are worked out from one angle


def foretold(x: Floats) -> bool:
    """Does each sample follow from those before it, but for the rounding of the numbers: a counter,
    a pure sine, a pattern that repeats."""
    rows = np.lib.stride_tricks.sliding_window_view(x - x.mean(), SIGNALS.foretold_from + 1)
    rows = rows[:: max(1, len(rows) // SIGNALS.foretold_samples)]
    best = np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0]
    return bool(np.std(rows[:, -1] - rows[:, :-1] @ best) < SIGNALS.foretold_within * np.std(x))


def forget_plans(samples: int, kind: Callable[[Floats], Floats] = fft.rfft) -> None:
    """After transforms of a long record in lengths that hardly recur: scipy keeps the tables of the
    last 16 lengths, up to 16 bytes per sample each. Short ones take their place."""
    for length in range(2, 18) if samples >= arrays.NARROW_FROM else ():
        for precision in (np.float32, np.float64):
            kind(np.zeros(length, precision))


def transform(x: Floats, spare: bool = False) -> Floats:
    """The orthonormal cosine transform (DCT-II) along the first axis. spare: x may be overwritten,
    here and in inverse()."""
    found: Floats = fft.dct(x, type=2, norm="ortho", axis=0, overwrite_x=spare)
    return found


def inverse(c: Floats, spare: bool = False) -> Floats:
    found: Floats = fft.idct(c, type=2, norm="ortho", axis=0, overwrite_x=spare)
    return found


def in_time(ordinates: Floats) -> Floats:
    """The record of mean zero with these ordinates 1 .. n - 1, in their precision."""
    whole = np.zeros(len(ordinates) + 1, ordinates.dtype)
    whole[1:] = ordinates
    return inverse(whole, spare=True)


def sine(turns: float, samples: int, first: float = 0.0) -> Floats:
    """sin(2 pi (turns i + first)) of i = 0 .. samples - 1: of the angles within a piece, and of
    those at which the pieces begin."""
    length = min(WAVE_PIECE, samples)
    within = 2 * np.pi * turns * np.arange(length)
    begin = 2 * np.pi * ((turns * length * np.arange(-(-samples // length)) + first) % 1.0)
    pieces = np.stack([np.sin(begin), np.cos(begin)], 1) @ np.stack(
        [np.cos(within), np.sin(within)]
    )
    found: Floats = pieces.reshape(-1)[:samples]
    return found


def turned_back(
    x: Floats, turns: float, pieces: int, time: Floats | None = None
) -> tuple[Complexes, Floats]:
    """(sums of x turned back by so many turns per unit of time, mean times) of so many pieces;
    time: of each sample, without it their index."""
    edges = np.linspace(0, len(x), pieces + 1).astype(int)
    within = np.exp(-2j * np.pi * turns * np.arange(np.diff(edges).max()))
    sums, middle = np.empty(pieces, complex), np.empty(pieces)
    for piece, (first, end) in enumerate(zip(edges, edges[1:])):
        if time is None:
            begin = np.exp(-2j * np.pi * (turns * first % 1))
            sums[piece] = begin * (x[first:end] @ within[: end - first])
            middle[piece] = (first + end - 1) / 2
        else:
            at = time[first:end]
            sums[piece] = x[first:end] @ np.exp(-2j * np.pi * turns * at)
            middle[piece] = at.mean()
    return sums, middle


def frequencies(samples: int, rate_hz: float, first: int = 0, end: int | None = None) -> Floats:
    """Of the ordinates 1 .. samples - 1 of the transform, in Hz; of some of them by their index
    from 0."""
    return np.arange(first + 1, samples if end is None else end + 1) * rate_hz / (2 * samples)


def line_edges() -> Floats:
    """Distances of the edges of bins from a line, on one side of it, in half widths."""
    first, end, step = SIGNALS.edges_even
    found: Floats = np.concatenate(
        [
            np.arange(first, end, step),
            end * SIGNALS.edges_ratio ** np.arange(SIGNALS.edges_grown),
        ]
    )
    return found


def bin_edges(ordinates: int, bands: Iterable[tuple[float, float]] = ()) -> Ints:
    """Starts of the bins and the end: single ordinates first, then a geometric series, and one
    towards the end; about each of the bands (centre, half width in ordinates) half a half width,
    growing away from it."""
    first = min(SIGNALS.single_ordinates, ordinates)
    count = int(np.log(ordinates / first) / np.log(SIGNALS.bin_ratio)) + 2
    grown = np.round(np.geomspace(first, ordinates, count)).astype(int)
    nearest = max(first, ordinates // SIGNALS.top_nearest)
    top = (
        np.round(
            nearest
            * SIGNALS.top_ratio
            ** np.arange(int(np.log(ordinates / nearest / 2) / np.log(SIGNALS.top_ratio)))
        )
        if 2 * nearest < ordinates
        else []
    )
    beside = line_edges()
    fine = [
        np.round(centre + np.concatenate([-beside, beside]) * width).astype(int)
        for centre, width in bands
    ]
    edges = np.unique(
        np.concatenate(
            [np.arange(first), grown, ordinates - np.asarray(top, int), [ordinates], *fine]
        )
    )
    found: Ints = edges[(edges >= 0) & (edges <= ordinates)]
    return found


def denoised(x: Floats) -> Floats:
    """x without the white noise of its own sensor: each octave of its spectrum is kept in the share
    that stands above the floor (a Wiener filter). A course that is smooth to begin with passes
    unchanged."""
    mean = x.mean()
    c = transform(x - mean, spare=True)
    power = c[1:] ** 2
    floor = power[len(power) // 2 :].mean()
    edges = np.unique(np.round(np.geomspace(1, len(power) + 1, 60)).astype(int)) - 1
    level = np.add.reduceat(power, edges[:-1]) / np.diff(edges)
    keep = np.clip(1 - 1.5 * floor / np.maximum(level, 1e-300), 0, 1)
    seen = np.flatnonzero(keep > 0.3)
    keep[seen[-1] + 1 if len(seen) else 0 :] = (
        0  # single low ordinates may be empty: those of a ramp are, every other one
    )
    for first, end, one in zip(edges, edges[1:], keep):
        c[1 + first : 1 + end] *= one
    found: Floats = inverse(c, spare=True)
    found += mean
    return found


def count_of(x: Floats) -> float:
    """The step in which x comes: the least distance between two of its values, where they repeat; 0
    where hardly any does."""
    steps = np.diff(np.sort(x))
    steps = steps[
        steps > 1e-9 * (x.max(initial=-np.inf) - x.min(initial=np.inf))
    ]  # sums of counts differ by their rounding
    return float(steps.min()) if 0 < len(steps) < len(x) / COUNTS.distinct else 0.0


def high_passed(x: Floats, window: int) -> Floats:
    """x without what moves slower than about `window` samples."""
    found: Floats = x - ndimage.uniform_filter1d(x, window, mode="nearest")
    return found


def sudden_changes(square: Floats, second: int) -> Ints:
    """Where the level of a square changes within a second by more than a factor of `sudden`: the
    first samples after. Levels are running medians over ten seconds, which keep edges."""
    level = np.log(np.maximum(ndimage.median_filter(square, 10 * second, mode="nearest"), 1e-30))
    change = np.abs(level[second:] - level[:-second])
    peak = (change > np.log(SIGNALS.sudden)) & (
        change == ndimage.maximum_filter1d(change, 4 * second + 1)
    )
    return np.unique(
        [likely_change(square, place + second // 2, 2 * second) for place in np.flatnonzero(peak)]
    ).astype(int)


def likely_change(square: Floats, place: int, reach: int) -> int:
    """The most likely place, within `reach` samples, of one change of the variance."""
    low = max(0, place - 2 * reach)
    total = np.cumsum(square[low : place + 2 * reach])
    before = np.arange(max(1, place - reach - low), min(len(total), place + reach - low))
    first, rest = total[before - 1], total[-1] - total[before - 1]
    after = len(total) - before
    loss = before * np.log(np.maximum(first / before, 1e-30)) + after * np.log(
        np.maximum(rest / after, 1e-30)
    )
    return low + int(before[np.argmin(loss)])


def mean_square_between(x: Floats, second: int, window: int) -> Floats:
    """As local_mean_square of what moves faster than a second, but never across a sudden change of
    vibration."""
    square = high_passed(x, second) ** 2 * second / max(second - 1, 1)
    steps: Floats = np.diff(x, prepend=x[0])  # differences know nothing of what is to come
    parts = np.split(square, sudden_changes(steps**2, second))
    return np.concatenate(
        [
            ndimage.uniform_filter1d(part, min(window, len(part)), mode="reflect")
            for part in parts
            if len(part)
        ]
    )


def local_mean_square(x: Floats, window: int) -> Floats:
    """Of what moves faster than the window, per sample; the mean that is taken off counts as one of
    its degrees of freedom. At a slow rate the window is as short as still shows a scatter."""
    window = max(window, SIGNALS.scatter_least)
    found: Floats = (
        ndimage.uniform_filter1d(high_passed(x, window) ** 2, window, mode="nearest")
        * window
        / max(window - 1, 1)
    )
    return found


def correlation(a: Floats, b: Floats) -> float:
    spread = np.std(a) * np.std(b)
    return float(np.mean((a - a.mean()) * (b - b.mean())) / spread) if spread > 0 else 0.0
