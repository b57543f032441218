"""How a command starts. Every command and every process of the page waits for the libraries that
the start loads, so those that few need are loaded at their first use.
"""

import subprocess
import sys

import asking
import numpy as np
from davarlab import distributions as own
from scipy import stats

NEEDED_BY_FEW = {
    *("scipy.stats", "scipy.signal", "scipy.optimize", "scipy.interpolate", "cantools", "can"),
    *("h5py", "pyarrow", "pymavlink", "pyulog", "rosbags", "matplotlib"),
}
PAGE_AND_REPORT = {"yaml", "jinja2", "starlette", "pydantic"}
P = np.concatenate([10.0 ** np.arange(-300, 0, 0.7), np.linspace(0, 1, 101)])
X = np.concatenate([-np.geomspace(1e-9, 1e3, 60)[::-1], [0.0], np.geomspace(1e-9, 1e3, 60)])
FREEDOM = np.concatenate([[1.0, 2.0, 3.0, 4.5, 401.0], np.geomspace(10, 1e8, 12)])[:, None]
RATIOS = np.concatenate([[0.0], np.geomspace(1e-6, 1e4, 60)])  # x over its mean
K = np.unique(np.geomspace(1, 3000, 40).astype(int)) - 1


def test_libraries_that_few_need_are_not_loaded():
    code = (
        "import sys, davarlab.cli; print(*sys.modules)\n"
        "import davarlab.workbench.server; print(*sys.modules)"
    )
    command, page = subprocess.run(
        [sys.executable, "-c", code],
        cwd=asking.ROOT / "tools/lab",
        text=True,
        stdout=subprocess.PIPE,
        check=True,
    ).stdout.splitlines()
    assert (NEEDED_BY_FEW | PAGE_AND_REPORT) & set(command.split()) == set()
    assert NEEDED_BY_FEW & set(page.split()) == set()


# They stand for scipy.stats, deep tails included.


def same(found, expected, digits=13):
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, expected, rtol=10.0**-digits, atol=0)


def test_normal():
    for name in ("pdf", "cdf", "sf", "logsf"):
        same(getattr(own, f"norm_{name}")(X), getattr(stats.norm, name)(X))
    same(own.norm_pdf(X, 2, 3.0), stats.norm.pdf(X, 2, 3.0))
    same(own.norm_logpdf(X, 2, 3.0), stats.norm.logpdf(X, 2, 3.0))
    same(own.norm_ppf(P), stats.norm.ppf(P))
    same(own.norm_isf(P), stats.norm.isf(P))


def test_chi_squared():
    x = RATIOS * FREEDOM
    same(own.chi2_cdf(x, FREEDOM), stats.chi2.cdf(x, FREEDOM))
    same(own.chi2_sf(x, FREEDOM), stats.chi2.sf(x, FREEDOM))
    same(own.chi2_ppf(P, FREEDOM), stats.chi2.ppf(P, FREEDOM))
    same(own.chi2_isf(P, FREEDOM), stats.chi2.isf(P, FREEDOM))


def test_ratio_of_variances():
    freedom = FREEDOM[:, :, None]
    same(own.f_sf(RATIOS, freedom, FREEDOM), stats.f.sf(RATIOS, freedom, FREEDOM))


def test_counts():
    chance = 10.0 ** np.linspace(-9, 0, 30)[:, None, None]
    tries = np.geomspace(3000, 1e7, 12).astype(int)[:, None]
    with np.errstate(divide="ignore"):  # log of what is smaller than a float
        same(own.binom_logsf(K, tries, chance), stats.binom.logsf(K, tries, chance))
        expected = np.geomspace(1e-6, 1e5, 40)[:, None]
        same(own.poisson_logsf(K, expected), stats.poisson.logsf(K, expected))


def test_single_precision_is_computed_in_double():
    x = np.float32(20.0)
    for found, expected in (
        (own.norm_sf(x), stats.norm.sf(20.0)),
        (own.norm_pdf(x, 0, np.float32(1)), stats.norm.pdf(20.0)),
        (own.chi2_sf(np.float32(300.0), 1), stats.chi2.sf(300.0, 1)),
    ):
        same(found, expected)
