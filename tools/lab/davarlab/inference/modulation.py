"""White noise whose level changes while the rest of the spectrum does not: what that does to the whitened residual (DESIGN 5)."""

import numpy as np

from ..data import signals
from ..effects.changes import vibration_square

GROUPS = 8


def variance_shapes(parts, recording, blocks):
    """Rows of the variance of the blocks that the parts say: the constant first."""
    rows = [np.ones(len(blocks.energy))]
    for part in parts:
        if part.kind == "vibration_noise":
            rows.append(part.effect.variants.get(part.form, vibration_square)(recording, part.shape["axis"], blocks))
        if part.kind == "noise_step":
            time = (np.arange(len(blocks.energy)) + 0.5) * blocks.period_s
            rows.append(((time >= part.shape["start_s"]) & (time < part.shape["stop_s"])).astype(float))
    return np.array(rows)


def white_share(bench, parts, fit):
    """The share of the sensor's white noise in the fitted spectrum, per bin."""
    noise = [part for part in parts if part.role == "spectrum"]
    if not noise:
        return np.ones_like(fit.level)
    rows = bench.rows(parts)
    white = [i for i, part in enumerate(noise) if part.kind == "angle_random_walk"]
    return np.clip((sum((fit.sizes[i] * rows[i] for i in white), np.zeros_like(fit.level)) + bench.fixed(parts)) / fit.level, 0, 1)


def local(variance, share, mean):
    """Variance of the whitened residual where the white noise has this share; `variance`: that of all ordinates together (5.2)."""
    return np.maximum(1 + share / max(mean, 1e-6) * (variance - 1), 0.05)


def levelled(c, variance, share):
    """Whitened ordinates with the change of the white level divided out, in each frequency as far as it is white."""
    mean, out = share.mean(), np.zeros_like(c)
    groups = np.minimum((share * GROUPS).astype(int), GROUPS - 1)
    for group in np.unique(groups):
        chosen = groups == group
        x = signals.inverse(np.concatenate([[0.0], np.where(chosen, c, 0.0)]))
        out += signals.transform(x / np.sqrt(local(variance, share[chosen].mean(), mean)))[1:]
    return out


def dispersion(bench, share, blocks, variance):
    """How much more than chi-square the energy of each bin scatters: mean of the squared local variance over its squared mean (5.3)."""
    mean = float(np.sum(share * bench.data.counts) / np.sum(bench.data.counts))
    relative = variance / variance.mean()
    found = []
    for value in share:
        here = local(relative, value, mean)
        found.append(np.mean(here ** 2) / np.mean(here) ** 2)
    return np.array(found)


def discounted(gain, before, after, counts, scatter):
    """A gain of spectra in the units that it would have if bins scattered as chi-square: weighted where the spectra differ (5.3)."""
    weight = counts * np.log(np.maximum(after, 1e-300) / np.maximum(before, 1e-300)) ** 2
    total = float(weight.sum())
    return gain if total <= 0 else gain * total / float(np.sum(weight * scatter))
