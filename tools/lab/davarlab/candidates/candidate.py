"""A candidate: an effect beside the model, its gain in likelihood and what chance would give (DESIGN 4)."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from ..inference.parts import Part

# What chance does with a free shape: the tail of the gain is TRIALS times that of one chi-square (a line: TRIALS n exp(-gain)),
# DESIGN 4. Measured by parametric bootstrap, `tools/davarlab nulls`, 240 recordings of 2 h, rounded up in the second digit.
# Not measured: angle_random_walk and bias_instability (in every model there), filters (no gain at all by chance: a bound).
TRIALS = {
    "quantization": 0.66,
    "angle_random_walk": 0.5,
    "bias_instability": 1.0,
    "rate_random_walk": 0.35,
    "gauss_markov": 3.7,
    "telegraph_noise": 3.7,
    "low_pass": 1.0,
    "moving_average": 1.0,
    "high_pass": 3.0,
    "warm_up": 2.1,
    "rate_ramp": 0.83,
    "sinusoid": 3.1,
    "temperature_rate": 1.8,
    "g_sensitivity": 4.8,
    "vibration_rectification": 8.0,
    "vibration_noise": 2.8,
    "noise_step": 1.1e4,
}
OWN_TRIALS = 3.0  # of an effect of one's own
BAND_TRIALS, BAND_SAMPLES, BAND_GROWTH = (
    150.0,
    1e4,
    0.4,
)  # lines with a width: TRIALS (n / SAMPLES)^GROWTH exp(-gain)


@dataclass
class Candidate:
    """`gain` in log-likelihood, `log_p` of that gain by chance, the part as it would join."""

    kind: str
    part: Part
    gain: float
    log_p: float
    replaces: Part | None = None  # the part of the model in whose place it joins


def log_tail(gain, trials):
    x = max(2 * gain, 0.0)
    tail = stats.chi2.logsf(x, 1) if x < 500 else -x / 2 - 0.5 * np.log(np.pi * x / 2)
    return min(0.0, float(np.log(trials) + tail))


def log_chance(kind, gain):
    """Of a gain by an effect with its own count of tries."""
    return log_tail(gain, TRIALS.get(kind, OWN_TRIALS))


def log_tail_of_line(kind, gain, samples):
    tries = (
        TRIALS[kind] * samples
        if kind == "sinusoid"
        else BAND_TRIALS * (samples / BAND_SAMPLES) ** BAND_GROWTH
    )
    return min(0.0, float(np.log(tries) - max(gain, 0.0)))
