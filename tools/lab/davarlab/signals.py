"""Plain operations on sampled signals."""

import numpy as np
from scipy import fft, ndimage


def transform(x):
    """The orthonormal cosine transform (DCT-II) along the first axis."""
    return fft.dct(x, type=2, norm="ortho", axis=0)


def inverse(c):
    return fft.idct(c, type=2, norm="ortho", axis=0)


def frequencies(samples, rate_hz):
    """Of the ordinates 1 .. samples - 1 of the transform."""
    return np.arange(1, samples) * rate_hz / (2 * samples)


def denoised(x, samples_per_second):
    """x without the white noise of its own sensor: each octave of its spectrum is kept in the share that stands above
    the floor (a Wiener filter). A course that is smooth to begin with passes unchanged."""
    del samples_per_second
    mean = x.mean()
    c = transform(x - mean)
    power = c[1:] ** 2
    floor = power[len(power) // 2:].mean()
    edges = np.unique(np.round(np.geomspace(1, len(power) + 1, 60)).astype(int)) - 1
    level = np.add.reduceat(power, edges[:-1]) / np.diff(edges)
    keep = np.clip(1 - 1.5 * floor / np.maximum(level, 1e-300), 0, 1)
    gone = np.flatnonzero(keep < 0.3)
    if len(gone):
        keep[gone[0]:] = 0
    c[1:] *= np.repeat(keep, np.diff(edges))
    return inverse(c) + mean


def high_passed(x, window):
    """x without what moves slower than about `window` samples."""
    return x - ndimage.uniform_filter1d(x, window, mode="nearest")


def local_mean_square(x, window):
    return ndimage.uniform_filter1d(high_passed(x, window) ** 2, window, mode="nearest")
