"""Shapes (time constants, cut-offs, frequencies) by maximum likelihood, one after the other."""

import numpy as np
from scipy import optimize

SPAN = {"sinusoid": None}


def numeric_shapes(part):
    return [name for name, value in part.shape.items() if isinstance(value, float)] if part.role in (
        "spectrum", "filter", "mean") and part.form != "decoded" else []


def half_width(bench, part):
    """How far to look, in natural logarithm; of a line half its lobe, within which there is one peak only."""
    if part.kind == "sinusoid":
        return 0.5 / (part.shape["frequency_hz"] * bench.recording.samples / bench.recording.rate_hz)
    return 0.45


def refine_one(bench, parts, index, name):
    part = parts[index]
    centre, width = part.shape[name], half_width(bench, part)

    def loss(x):
        moved = part.moved(name, float(centre * np.exp(x)))
        trial = parts[:index] + [moved] + parts[index + 1:]
        value = -bench.fit(trial).log_likelihood
        if moved.role == "mean":
            bench.forget(moved)
        return value

    best = optimize.minimize_scalar(loss, bounds=(-width, width), method="bounded",
                                    options={"xatol": width * 2e-3, "maxiter": 24})
    if best.fun >= -bench.fit(parts).log_likelihood:
        return parts
    bench.forget(part)
    return parts[:index] + [part.moved(name, float(centre * np.exp(best.x)))] + parts[index + 1:]


def refined(bench, parts, sweeps=1, only=None):
    """Parts with their shapes at the maximum of the likelihood; `only`: kinds to move."""
    parts = list(parts)
    for _ in range(sweeps):
        for index in range(len(parts)):
            if only is None or parts[index].kind in only:
                for name in numeric_shapes(parts[index]):
                    parts = refine_one(bench, parts, index, name)
    return parts
