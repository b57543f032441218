"""The likelihood of a recording in the cosine domain, and its maximum (DESIGN 1 to 3)."""

from dataclasses import dataclass

import numpy as np
from scipy import linalg, optimize

from ..data import signals

ITERATIONS = 60
HALVINGS = 12


@dataclass
class Fit:
    """Sizes (>= 0) of the spectra, coefficients of the columns, log-likelihood, level per bin."""
    sizes: np.ndarray
    coefficients: np.ndarray
    log_likelihood: float
    level: np.ndarray
    covariance: np.ndarray


class Data:
    """A recording in the cosine domain: the gyro and, on demand, columns; all products summed per bin and remembered."""

    def __init__(self, y, rate_hz):
        self.rate_hz, self.samples = rate_hz, len(y)
        self.f = signals.frequencies(len(y), rate_hz)
        self.edges = signals.bin_edges(len(y) - 1)
        self.starts, self.counts = self.edges[:-1], np.diff(self.edges).astype(float)
        self.f_bin = np.add.reduceat(self.f, self.starts) / self.counts
        self.columns, self.products, self.spectra = {}, {}, {}
        self.add("gyro", y)

    def add(self, key, x):
        """Columns are scaled to unit norm inside; `scale` undoes it. A constant column has scale 0."""
        c = signals.transform(x - x.mean())[1:]
        norm = 1.0 if key == "gyro" else float(np.sqrt(c @ c))
        ok = key == "gyro" or norm > 1e-9 * max(1e-30, float(np.abs(x).max()))
        self.columns[key] = (c / norm if ok else c * 0, norm if ok else 0.0)

    def scale(self, key):
        return self.columns[key][1]

    def product(self, a, b):
        key = (a, b) if a <= b else (b, a)
        if key not in self.products:
            self.products[key] = np.add.reduceat(self.columns[a][0] * self.columns[b][0], self.starts)
        return self.products[key]

    def binned(self, key, spectrum):
        """A spectrum at the bins (narrow enough that the value at the mean frequency is the mean within 2e-4)."""
        if key not in self.spectra:
            self.spectra[key] = spectrum(self.f_bin)
        return self.spectra[key]

    def whitened(self, level, coefficients, keys):
        """The residual with the model's spectrum divided out: unit white noise when the model is true."""
        c = self.columns["gyro"][0].copy()
        for key, value in zip(keys, coefficients):
            c -= value * self.columns[key][0]
        return c / np.sqrt(np.interp(np.log(self.f), np.log(self.f_bin), level))


def generalised_least_squares(data, keys, level):
    """Coefficients of the columns, their covariance, and the energy of the residual per bin."""
    energy = data.product("gyro", "gyro")
    if not keys:
        return np.zeros(0), np.zeros((0, 0)), energy, np.zeros_like(energy)
    cross = np.array([data.product(key, "gyro") for key in keys])
    gram = np.array([[data.product(a, b) for b in keys] for a in keys])
    inverse = linalg.pinvh((gram / level).sum(axis=2))
    beta = inverse @ (cross / level).sum(axis=1)
    residual = energy - 2 * beta @ cross + np.einsum("i,ijb,j->b", beta, gram, beta)
    leverage = np.einsum("ij,jib->b", inverse, gram) / level
    return beta, inverse, np.maximum(residual, 0), leverage


def log_likelihood(data, energy, level):
    return -0.5 * float(np.sum(data.counts * np.log(level) + energy / level))


def non_negative_step(shapes, energy, counts, level):
    """One step of Fisher scoring: weighted least squares of energy/counts on the shapes, sizes >= 0."""
    weight = np.sqrt(counts / 2) / level
    design = shapes.T * weight[:, None]
    norm = np.linalg.norm(design, axis=0)
    return optimize.nnls(design / norm, energy / counts * weight)[0] / norm


def maximise(data, shapes, keys, near=None, restricted=False, fixed=0.0):
    """Fits sizes of `shapes` (rows) and coefficients of the columns `keys`; `near`: a level to start from. With `restricted`,
    leverages of the columns are taken off the degrees of freedom (REML, DESIGN 3). `fixed`: what is known of the level (counts)."""
    counts = data.counts
    energy = data.product("gyro", "gyro")
    level = near if near is not None else np.maximum(energy / counts, 1e-30)
    if near is None and keys:
        first = non_negative_step(shapes, energy - fixed * counts, counts, level.mean() + 0 * level)
        level = np.maximum(shapes.T @ first + fixed, 1e-12 * level.max())
    sizes, before = None, -np.inf
    for _ in range(ITERATIONS):
        beta, covariance, residual, leverage = generalised_least_squares(data, keys, level)
        free = np.maximum(counts - leverage, 1e-3 * counts) if restricted else counts
        step, seen = non_negative_step(shapes, residual * counts / free - fixed * counts, counts, level), residual * counts / free
        least = log_likelihood(data, seen, level) if sizes is not None else -np.inf
        for _ in range(HALVINGS):  # where one ordinate holds nearly all the energy, whole steps go to and fro
            level = np.maximum(shapes.T @ step + fixed, 1e-12 * energy.sum() / counts.sum())
            if log_likelihood(data, seen, level) >= least - 1e-9 * abs(least):
                break
            step = 0.5 * (sizes + step)
        sizes, now = step, log_likelihood(data, residual, level)
        if abs(now - before) < 1e-6 * (1 + abs(now) * 1e-6):
            break
        before = now
    beta, covariance, residual, leverage = generalised_least_squares(data, keys, level)
    return Fit(sizes, beta, log_likelihood(data, residual, level), level, covariance)


def size_covariance(data, shapes, level):
    """Of the sizes, from the Fisher information."""
    design = shapes * np.sqrt(data.counts / 2) / level
    return linalg.pinvh(design @ design.T)
