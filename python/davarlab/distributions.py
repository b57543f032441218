"""Common distributions, from scipy.special. The results agree with scipy.stats to 1e-13,
whose import takes half as long again as everything else that a command loads.

Arguments are numbers or arrays, which broadcast; they are not checked. Results are double
precision, even of single."""

from typing import Any

import numpy as np
from scipy import special

from .arrays import Floats, Ints

Numbers = float | Floats | Ints


def norm_pdf(x: Numbers, mean: Numbers = 0.0, sigma: Numbers = 1.0) -> Any:
    z = np.subtract(x, mean, dtype=float) / sigma
    return np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) / sigma


def norm_logpdf(x: Numbers, mean: Numbers = 0.0, sigma: Numbers = 1.0) -> Any:
    z = np.subtract(x, mean, dtype=float) / sigma
    return -(z**2) / 2 - np.log(np.sqrt(2 * np.pi)) - np.log(sigma, dtype=float)


def norm_cdf(x: Numbers) -> Any:
    return special.ndtr(x, dtype=float)


def norm_sf(x: Numbers) -> Any:
    return special.ndtr(-x, dtype=float)


def norm_logsf(x: Numbers) -> Any:
    return special.log_ndtr(-x, dtype=float)


def norm_ppf(p: Numbers) -> Any:
    return special.ndtri(p, dtype=float)


def norm_isf(p: Numbers) -> Any:
    return -norm_ppf(p)


def chi2_cdf(x: Numbers, freedom: Numbers) -> Any:
    """x >= 0, freedom > 0, as in all of chi2."""
    return special.chdtr(freedom, x, dtype=float)


def chi2_sf(x: Numbers, freedom: Numbers) -> Any:
    return special.chdtrc(freedom, x, dtype=float)


def chi2_ppf(p: Numbers, freedom: Numbers) -> Any:
    return 2 * special.gammaincinv(freedom / 2, p, dtype=float)


def chi2_isf(p: Numbers, freedom: Numbers) -> Any:
    return special.chdtri(freedom, p, dtype=float)


def f_sf(x: Numbers, above: Numbers, below: Numbers) -> Any:
    """Of a ratio of variances with these degrees of freedom; x >= 0."""
    return special.fdtrc(above, below, x, dtype=float)


def binom_logsf(k: Numbers, tries: Numbers, chance: Numbers) -> Any:
    """Of more than k hits, 0 <= k < tries."""
    with np.errstate(divide="ignore"):
        return np.log(special.betainc(k + 1, tries - k, chance, dtype=float))


def poisson_logsf(k: Numbers, expected: Numbers) -> Any:
    """Of more than k events, k >= 0."""
    with np.errstate(divide="ignore"):
        return np.log(special.pdtrc(k, expected, dtype=float))
