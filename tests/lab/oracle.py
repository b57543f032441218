"""How much of a hidden effect a recording can show at all: the gain of an oracle that knows noise
and shape (DESIGN 4).
"""

import numpy as np
from davarlab import simulate
from davarlab.data import signals
from davarlab.effects import table
from davarlab.thresholds import CHANCE
from scipy import stats

# Gain from which the one test that an oracle makes calls it: by chance as often as all tests of a
# search together.
CALLABLE = stats.chi2.isf(CHANCE.family_wise, 1) / 2


def spectrum_of(terms, recording):
    """Of the stationary terms behind the sensor's filters, per ordinate of the orthonormal cosine
    transform, (deg/s)^2.
    """
    f = signals.frequencies(recording.samples, recording.rate_hz)
    found, behind = np.zeros(len(f)), np.zeros(len(f))
    for term in terms:
        effect, parameters = table.find(term.kind), term.parameters
        if effect.role == "filter":
            behind += parameters.get(effect.behind, 0.0) ** 2
        elif effect.role in ("spectrum", "states"):
            power = effect.dps(parameters) ** 2 * effect.spectrum(
                f, recording.rate_hz, effect.shape_of(parameters)
            )
            (found if simulate.in_front(term) else behind)[:] += power
    return found * power_gain(terms, recording) + behind


def power_gain(terms, recording):
    """What the filters among the terms leave of everything in front of them."""
    f, gain = signals.frequencies(recording.samples, recording.rate_hz), 1.0
    for effect, parameters in ((table.find(term.kind), term.parameters) for term in terms):
        gain = (
            gain * effect.spectrum(f, recording.rate_hz, effect.shape_of(parameters))
            if effect.role == "filter"
            else gain
        )
    return gain


def growth(term, base, recording):
    """Variance of every sample's white noise with an effect over that without it."""
    if term.kind == "vibration_noise":
        square = signals.local_mean_square(
            recording.column(f"accel_{term.parameters['axis']}_g"), int(recording.rate_hz)
        )
        white = (
            sum(
                table.find(one.kind).dps(one.parameters) ** 2
                for one in base
                if one.kind == "angle_random_walk"
            )
            * recording.rate_hz
        )
        return 1 + term.parameters["coefficient_dps_per_g"] ** 2 * square / white
    return (
        1
        + table.find(term.kind).simulate(
            recording, term.parameters, None, np.ones(recording.samples)
        )
    ) ** 2


def gain(term, base, recording):
    """Log-likelihood that a model of the truth is ahead, on average, of one without the term; base:
    the other true terms. Half the energy of a known course over the spectrum; for spectra, filters
    and variances the divergence of the two likelihoods. Level and shape of all else are known: a
    search, which fits them, has less; but levels that can be seen one by one tell more than their
    spectrum, which stands here, and shocks are drawn anew.
    """
    role, noise = table.find(term.kind).role, spectrum_of(base, recording)
    if role in ("mean", "events"):
        course = simulate.contribution(term, recording, np.random.default_rng(0), None)
        passed = power_gain(base, recording) if simulate.in_front(term) else 1.0
        return float(
            np.sum(passed * signals.transform(course - course.mean())[1:] ** 2 / noise) / 2
        )
    if role == "variance":
        ratio = growth(term, base, recording)
    else:
        ratio = spectrum_of([*base, term], recording) / noise
    return float(np.sum(ratio - 1 - np.log(ratio)) / 2)
