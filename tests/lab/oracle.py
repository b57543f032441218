"""How much of a hidden effect a recording can show at all: the gain of an oracle that knows noise
and shape (DESIGN 4).
"""

import numpy as np
from davarlab import simulate
from davarlab.data import signals
from davarlab.effects import table
from davarlab.thresholds import CHANCE
from scipy import stats

# Gain from which the one test that an oracle makes detects an effect: by chance as often as all
# tests of a search together.
CALLABLE = stats.chi2.isf(CHANCE.family_wise, 1) / 2


def power_of(terms, recording):
    """(spectrum of the stationary terms behind the sensor's filters, per ordinate of the
    orthonormal cosine transform, (deg/s)^2; what the filters leave of everything in front of them).
    """
    f, rate = signals.frequencies(recording.samples, recording.rate_hz), recording.rate_hz
    found, behind, passed = np.zeros(len(f)), np.zeros(len(f)), np.ones(len(f))
    for term in terms:
        effect, values = table.find(term.kind), term.parameters
        if effect.role == "filter":
            behind += values.get(effect.behind, 0.0) ** 2
            passed = passed * effect.spectrum(f, rate, effect.shape_of(values))
        elif effect.role in ("spectrum", "states"):
            power = effect.dps(values) ** 2 * effect.spectrum(f, rate, effect.shape_of(values))
            (found if simulate.in_front(term) else behind)[:] += power
    return found * passed + behind, passed


def growth(term, base, recording):
    """Variance of every sample's white noise with an effect over that without it."""
    effect, values = table.find(term.kind), term.parameters
    if term.kind != "vibration_noise":
        return (1 + effect.simulate(recording, values, None, np.ones(recording.samples))) ** 2
    felt = recording.column(f"accel_{values['axis']}_g")
    square = signals.local_mean_square(felt, int(recording.rate_hz))
    (white,) = (one for one in base if one.kind == "angle_random_walk")
    power = table.find(white.kind).dps(white.parameters) ** 2 * recording.rate_hz
    return 1 + values["coefficient_dps_per_g"] ** 2 * square / power


def gain(term, base, recording):
    """Log-likelihood that a model of the truth is ahead, on average, of one without the term; base:
    the other true terms. Half the energy of a known course over the spectrum; for spectra, filters
    and variances the divergence of the two likelihoods. Level and shape of all else are known: a
    search, which fits them, has less; but levels that can be seen one by one tell more than their
    spectrum, which stands here, and shocks are drawn anew.
    """
    role, (noise, passed) = table.find(term.kind).role, power_of(base, recording)
    if role in ("mean", "events"):
        course = simulate.contribution(term, recording, np.random.default_rng(0), None)
        energy = signals.transform(course - course.mean())[1:] ** 2
        return float(np.sum((passed if simulate.in_front(term) else 1.0) * energy / noise) / 2)
    if role == "variance":
        ratio = growth(term, base, recording)
    else:
        ratio = power_of([*base, term], recording)[0] / noise
    return float(np.sum(ratio - 1 - np.log(ratio)) / 2)
