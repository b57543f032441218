"""Two levels or a continuum? Telegraph noise and Gauss-Markov share a spectrum; their amplitudes differ (DESIGN 6)."""

from math import exp, log, pi, sqrt

import numpy as np
from scipy import optimize

BLOCKS_MAX = 6000
SWITCHES_LEAST = 5
ALIKE = 1.15  # dwells within this factor are alike: 5 % of exponential ones at most
SEARCH = {"maxfev": 90, "xatol": 1e-2, "fatol": 0.05}


def averaged(x, block):
    count = len(x) // block
    return x[:count * block].reshape(count, block).mean(axis=1)


def two_level_log_likelihood(x, level, noise, stay):
    """Forward algorithm of a symmetric two-level chain in white noise."""
    up, total = 0.5, 0.0
    scale, shift = 2 * level / noise ** 2, -0.5 * (level / noise) ** 2 - log(noise * sqrt(2 * pi))
    for value in x:
        up = up * stay + (1 - up) * (1 - stay)
        lean = max(-600.0, min(600.0, scale * value))
        # density = common * exp(+-lean/2)
        a, b = up * exp(0.5 * lean), (1 - up) * exp(-0.5 * lean)
        total += log(a + b) + shift - 0.5 * (value / noise) ** 2
        up = a / (a + b)
    return total


def gauss_markov_log_likelihood(x, std, noise, decay):
    """Kalman filter of a first-order process in white noise."""
    mean, variance, total = 0.0, std ** 2, 0.0
    grow, white = std ** 2 * (1 - decay ** 2), noise ** 2
    for value in x:
        spread = variance + white
        miss = value - mean
        total -= 0.5 * (log(2 * pi * spread) + miss * miss / spread)
        gain = variance / spread
        mean = decay * (mean + gain * miss)
        variance = decay * decay * variance * (1 - gain) + grow
    return total


def bounded(logarithms):
    """Their exponentials, kept where arithmetic is safe however far a search strays."""
    return [exp(max(-60.0, min(60.0, value))) for value in logarithms]


def blocks_for(x, rate_hz, dwell_s):
    """Means of x over an eighth of the dwell, and the length of a block in samples."""
    block = max(1, int(max(dwell_s / 8 * rate_hz, len(x) / BLOCKS_MAX)))
    values = averaged(x, block)
    return (values - values.mean()).tolist(), block


def fit_levels(x, rate_hz, std, dwell_s, white):
    """(log-likelihood, amplitude, dwell) of a two-level chain in white noise."""
    values, block = blocks_for(x, rate_hz, dwell_s)
    period, noise = block / rate_hz, max(white / sqrt(block / rate_hz), 1e-12)

    def loss(p):
        level, spread, dwell = bounded(p)
        return -two_level_log_likelihood(values, level, spread, 0.5 * (1 + exp(-2 * period / dwell)))

    found = optimize.minimize(loss, [log(std), log(noise * 1.1), log(dwell_s)], method="Nelder-Mead", options=SEARCH)
    level, _, dwell = bounded(found.x)
    return -found.fun, level, dwell


def fit_continuum(x, rate_hz, std, dwell_s, white):
    """Log-likelihood of a first-order process in white noise, on the same blocks."""
    values, block = blocks_for(x, rate_hz, dwell_s)
    period, noise = block / rate_hz, max(white / sqrt(block / rate_hz), 1e-12)

    def loss(p):
        size, spread, dwell = bounded(p)
        return -gauss_markov_log_likelihood(values, size, spread, exp(-2 * period / dwell))

    return -optimize.minimize(loss, [log(std), log(noise * 1.1), log(dwell_s)], method="Nelder-Mead", options=SEARCH).fun


def smoothed(values, level, noise, stay):
    """(log-likelihood of the chain, posterior mean of its state -1 .. 1) of each value."""
    scale = 2 * level / noise ** 2
    lean = [max(-60.0, min(60.0, scale * value)) for value in values]
    forward, up, total = [], 0.5, 0.0
    for value in lean:
        up = up * stay + (1 - up) * (1 - stay)
        a, b = up * exp(value / 2), (1 - up) * exp(-value / 2)
        total += log(a + b)
        up = a / (a + b)
        forward.append(up)
    back, state = 0.5, [0.0] * len(lean)
    for i in range(len(lean) - 1, -1, -1):
        a, b = forward[i] * back, (1 - forward[i]) * (1 - back)
        state[i] = (a - b) / (a + b)
        a, b = back * exp(lean[i] / 2), (1 - back) * exp(-lean[i] / 2)
        a, b = a * stay + b * (1 - stay), b * stay + a * (1 - stay)
        back = a / (a + b)
    fixed = -0.5 * np.sum((np.asarray(values) ** 2 + level ** 2) / noise ** 2 + np.log(2 * pi * noise ** 2))
    return total + float(fixed), np.array(state)


def decoded(x, rate_hz, level, dwell_s, white, resolution=240):
    """Posterior mean of the state (-1 .. 1) at every sample; its divergence from what the chain says beforehand; and the sum of
    (1 - state^2) / (2 noise^2), what doubt about the state costs per squared amplitude (6.3)."""
    block = max(1, int(dwell_s * rate_hz / resolution), len(x) // 60000)
    values = averaged(x - x.mean(), block)
    noise = max(white / sqrt(block / rate_hz), 1e-9)
    total, state = smoothed(values.tolist(), level, noise, 0.5 * (1 + exp(-2 * block / rate_hz / dwell_s)))
    doubt = float(np.sum(1 - state ** 2)) / (2 * noise ** 2)
    known = -0.5 * np.sum((values - level * state) ** 2 / noise ** 2 + np.log(2 * pi * noise ** 2)) - level ** 2 * doubt
    centres = (np.arange(len(state)) + 0.5) * block
    return np.interp(np.arange(len(x)), centres, state), float(known) - total, doubt


def many_switches(dwell_s, x, rate_hz):
    """Can a record of this length show chance at work: SWITCHES_LEAST dwells, each of some samples."""
    return 4 / rate_hz < dwell_s < len(x) / rate_hz / SWITCHES_LEAST


def like_chance(path):
    """Do the switches come at random: five of them at least, dwells that scatter as exponential ones do, and no length that most of them share
    (a clock with a few of its periods cut in two still ticks)."""
    up = path[np.abs(path) > 0.5] > 0
    places = np.flatnonzero(np.abs(path) > 0.5)[1:][np.diff(up.astype(int)) != 0]
    if len(places) < SWITCHES_LEAST:
        return False
    dwells = np.sort(np.diff(places))
    alike = np.searchsorted(dwells, ALIKE * dwells, side="right") - np.arange(len(dwells))
    if alike.max() > max(3, 0.4 * len(dwells)):
        return False
    return len(dwells) < 7 or float(np.std(dwells) / np.mean(dwells)) > 0.4
