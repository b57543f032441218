"""Noise of a gyro in use, by its power spectrum over that of white noise: next to rotor lines, in
motion, and nowhere flat.
"""

import numpy as np


def shaped(random, spectrum, count):
    """Gaussian noise with a power spectrum over that of white noise of variance 1."""
    f = np.fft.rfftfreq(2 * count)
    white = np.fft.rfft(random.normal(size=2 * count))
    return np.fft.irfft(white * np.sqrt(spectrum(f)))[:count]


def motion(f, power, corner):
    return power / (1 + (f / corner) ** 4)


def bump(f, centre, width, power):
    return power * np.exp(-0.5 * ((f - centre) / width) ** 2)


def rotors(f):
    lines = [
        bump(f, c * h, 0.0012 * h, 3000 / h**2)
        for c in (0.071, 0.075, 0.08, 0.083)
        for h in (1, 2, 3)
    ]
    return 1 + motion(f, 1e5, 0.006) + sum(lines) + bump(f, 0.11, 0.03, 20)


SPECTRA = {
    "white": np.ones_like,
    "motion of 70 dB": lambda f: 1 + motion(f, 1e7, 0.004),
    "rotors": rotors,
    "nowhere flat": lambda f: (
        1
        + 30 * np.exp(-(((f - 0.27) / 0.09) ** 2))
        + motion(f, 3e3, 0.01)
        + bump(f, 0.26, 0.003, 800)
        + 2 * (f < 0.3)
        + 3 * (0.5 - f)
    ),
    "slope of 100": lambda f: 10 ** (2 * (1 - 2 * f)),
}


def allan_variance(spectrum, m, count=200_000):
    """Of noise with this spectrum over that of white noise of variance 1 (IEEE Std 952)."""
    f = (np.arange(count) + 0.5) / (2 * count)
    return np.mean(spectrum(f) * 2 * np.sin(np.pi * f * m) ** 4 / (m * np.sin(np.pi * f)) ** 2)
