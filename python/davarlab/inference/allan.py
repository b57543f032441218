"""Allan deviations: measured by lib/ itself through a shared library, and expected from a model
(DESIGN 8)."""

import ctypes
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from ..arrays import Bools, Floats
from ..effects.device import library
from ..errors import BadInput
from ..thresholds import JUDGE


def octaves(window: int) -> list[int]:
    """1, 2, 4 ... <= window / 9."""
    return [2**i for i in range(JUDGE.cluster_octaves) if 9 * 2**i <= window]


def drawn(window: int) -> list[int]:
    """The same range with eight sizes in each octave where there are as many: of a drawn curve."""
    octave = octaves(window)[-1:] or [0]
    return sorted({round(2 ** (k / 8)) for k in range(8 * octave[0].bit_length() - 7)})


def windows(
    y: Floats, window: int, taus: Sequence[int], known: Bools | None = None
) -> tuple[Floats, Floats]:
    """Allan deviations of the full windows that follow each other, in the unit of y, and the share
    of their differences that touch known samples only: two arrays (windows, taus). A deviation
    without any such difference is nan."""
    if known is not None and not known.all():
        return masked(y, window, taus, known)
    found = measured(y, window, taus)
    return found, np.ones_like(found)


def masked(y: Floats, window: int, taus: Sequence[int], known: Bools) -> tuple[Floats, Floats]:
    """As measured(), from the differences that lie in known samples."""
    centred = np.where(known, y - y[known].mean(), 0.0)
    total = np.concatenate([[0.0], np.cumsum(centred, dtype=np.float64)])
    lost = np.concatenate([[0], np.cumsum(~known)])
    rows = len(y) // window
    found, shares = np.full((2, rows, len(taus)), np.nan)
    for column, m in enumerate(taus):
        square = ((total[2 * m :] - 2 * total[m:-m] + total[: -2 * m]) / m) ** 2
        valid = lost[2 * m :] == lost[: -2 * m]
        for row in range(rows):
            part = slice(row * window, (row + 1) * window - 2 * m + 1)
            count = np.count_nonzero(valid[part])
            shares[row, column] = count / (window - 2 * m + 1)
            if count:
                found[row, column] = np.sqrt(square[part][valid[part]].sum() / (2 * count))
    return found, shares


def window_of(samples: int, count: int) -> int:
    """Samples of each of so many windows of a record."""
    unit = JUDGE.means if samples >= JUDGE.means_from else 2
    return samples // count // unit * unit


def measured(y: Floats, window: int, taus: Sequence[int]) -> Floats:
    """Allan deviations of the full windows that follow each other, by lib/: (windows, taus), in the
    unit of y. Long averaging times of a long record are measured on block means (8.6)."""
    split = int(np.searchsorted(taus, JUDGE.means * JUDGE.lags_per_cluster))
    if len(y) < JUDGE.means_from or window % JUDGE.means or not 0 < split < len(taus):
        return by_library(y, window, taus)
    means = y[: len(y) // JUDGE.means * JUDGE.means].reshape(-1, JUDGE.means).mean(axis=1)
    longer = [m // JUDGE.means for m in taus[split:]]
    return np.hstack(
        [
            by_library(y, window, taus[:split]),
            by_library(means, window // JUDGE.means, longer),
        ]
    )


def by_library(y: Floats, window: int, taus: Sequence[int]) -> Floats:
    """Allan deviations of the full windows that follow each other, of clusters that begin at every
    sample."""
    centred = y - np.mean(y)
    largest = max(centred.max(), -centred.min())
    unit = 2.0 ** np.frexp(largest)[1]  # the library's full scale has limits
    data = np.divide(centred, unit, out=np.empty(len(centred), np.float32))
    del centred
    rows = len(data) // window
    out = np.full((rows, len(taus)), np.nan)
    array = (ctypes.c_uint32 * len(taus))(*taus)
    scale = float(np.abs(data).max()) * 1.01 or 1.0
    done = library().davar_lab_windows(
        data.ctypes.data_as(ctypes.POINTER(ctypes.c_float)),
        len(data),
        scale,
        window,
        window,
        array,
        len(taus),
        out.ctypes.data_as(ctypes.POINTER(ctypes.c_double)),
        rows,
    )
    if done < 0:
        raise BadInput(f"the library refused a window of {window} samples (status {-1 - done})")
    found: Floats = out[:done] * unit
    return found


@cache
def grid() -> tuple[Floats, Floats]:
    """Frequencies over the sample rate, and the width of each."""
    nu = np.concatenate([np.geomspace(1e-8, 1e-4, 2000), np.geomspace(1e-4, 0.5, 40000)[1:]])
    return np.sqrt(nu[1:] * nu[:-1]), np.diff(nu)


@cache
def response(m: int) -> Floats:
    """What the Allan variance of m samples takes of each frequency of the grid."""
    middle, width = grid()
    squared = np.sin(np.pi * middle * m) ** 2
    ripples = squared * squared  # a power of 4 takes three times as long
    ripples[middle * m > 300] = 0.375  # the grid no longer follows the ripples: their mean
    found: Floats = ripples * width * 4 / (np.sin(np.pi * middle) * m) ** 2
    return found


def on_grid(spectrum: Callable[[Floats], Floats], rate_hz: float) -> Floats:
    return spectrum(grid()[0] * rate_hz)


def expected(power: Floats, taus: Sequence[int]) -> Floats:
    """Allan variance of noise with this ordinate variance on the grid: the integral over the
    response of D (8.1)."""
    return np.array([power @ response(int(m)) for m in taus])


def unit(power: Floats) -> Floats:
    """The same shape with 1 as its largest value, for the square of a faint one would be 0; silence
    counts as white."""
    peak = power.max()
    return power / peak if peak > 0 else np.ones_like(power)


def freedom(
    spectrum: Callable[[Floats], Floats], power: Floats, m: int, window: int, rate_hz: float
) -> float:
    """Degrees of freedom of the overlapping estimate of noise with this spectrum (`power`: on the
    grid): M R0^2 / sum (1 - |k|/M) R_k^2, R the autocovariance of the M = window - 2 m + 1
    differences (8.3)."""
    count = window - 2 * m + 1
    if count > JUDGE.parseval_clusters * m:  # Parseval
        width = grid()[1]
        power = unit(power * response(m) / width)
        return float(2 * count * (power @ width) ** 2 / (power**2 @ width))
    step = max(1, m // JUDGE.lags_per_cluster)
    lags = -(-count // step)
    points = 1 << (2 * lags).bit_length()
    nu = np.arange(points + 1) / (2 * points * step)
    nu[0] = nu[1] / 4
    power = unit(spectrum(nu * rate_hz) * np.sin(np.pi * nu * m) ** 4 / np.sin(np.pi * nu) ** 2)
    covariance = np.fft.irfft(power)[:lags]
    weight = 2 * (1 - np.arange(lags) * step / count)
    weight[0] = 1
    return float(
        count * covariance[0] ** 2 / (step * np.sum(np.maximum(weight, 0) * covariance**2))
    )
