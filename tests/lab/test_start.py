"""How a command starts: libraries that few need are loaded at their first use. What stands for
scipy.stats until then, deep tails included.
"""

import subprocess
import sys

import asking
import numpy as np
import pytest
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
TRIES = np.geomspace(3000, 1e7, 12).astype(int)[:, None]
CHANCE = 10.0 ** np.linspace(-9, 0, 30)[:, None, None]
LAWS = [  # name, arguments
    *((f"norm_{name}", (X,)) for name in ("pdf", "cdf", "sf", "logsf")),
    *(("norm_pdf", (X, 2, 3.0)), ("norm_logpdf", (X, 2, 3.0))),
    *((f"norm_{name}", (P,)) for name in ("ppf", "isf")),
    *((f"chi2_{name}", (RATIOS * FREEDOM, FREEDOM)) for name in ("cdf", "sf")),
    *((f"chi2_{name}", (P, FREEDOM)) for name in ("ppf", "isf")),
    ("f_sf", (RATIOS, FREEDOM[:, :, None], FREEDOM)),
    ("binom_logsf", (K, TRIES, CHANCE)),
    ("poisson_logsf", (K, np.geomspace(1e-6, 1e5, 40)[:, None])),
    # single precision is computed in double
    *(("norm_sf", (np.float32(20.0),)), ("norm_pdf", (np.float32(20.0), 0, np.float32(1)))),
    ("chi2_sf", (np.float32(300.0), 1)),
]


def test_libraries_that_few_need_are_not_loaded():
    code = (
        "import sys, davarlab.cli; print(*sys.modules)\n"
        "import davarlab.workbench.server; print(*sys.modules)"
    )
    words = [sys.executable, "-c", code]
    lab = asking.ROOT / "python"
    printed = subprocess.run(words, cwd=lab, text=True, capture_output=True, check=True).stdout
    command, page = (set(line.split()) for line in printed.splitlines())
    assert (NEEDED_BY_FEW | PAGE_AND_REPORT) & command == set()
    assert NEEDED_BY_FEW & page == set()


@pytest.mark.parametrize("name, arguments", LAWS)
def test_a_law_is_that_of_scipy_in_13_digits(name, arguments):
    law, function = name.split("_")
    exact = [np.float64(one) if isinstance(one, np.float32) else one for one in arguments]
    with np.errstate(divide="ignore"):  # log of what is smaller than a float
        found = getattr(own, name)(*arguments)
        expected = getattr(getattr(stats, law), function)(*exact)
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=0)
