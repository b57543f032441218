"""The flight of examples/ahrs_flight, with a third-party filter."""

import ctypes
import subprocess
import sys
import warnings

import c_library
import numpy as np
import pytest
import together

EXAMPLE = together.ROOT / "examples/ahrs_flight"
SEEDS = range(301, 304)
SHEET, FED, TRUTH = 0, 2, 3


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """The example, with the filter that its requirements list."""
    site = tmp_path_factory.mktemp("filter")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    words = [*pip, "--no-deps", "--target", site, "-r", EXAMPLE / "requirements.txt"]
    subprocess.run(words, check=True)
    paths = [str(EXAMPLE), str(site)]
    sys.path[:0] = paths
    import flight

    yield flight
    for path in paths:
        sys.path.remove(path)
    for name in [name for name in sys.modules if name.split(".")[0] in ("flight", "ahrs")]:
        del sys.modules[name]


@pytest.fixture(scope="module")
def flown(flight):
    """{regime: (squared error, NEES) of each filter}."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = np.array([flight.compared(4.0, seed) for seed in SEEDS])
    squares, nees = found.mean(axis=0).transpose(2, 0, 1)
    names = [regime.name for regime in flight.REGIMES]
    return {name: (squares[:, i], nees[:, i]) for i, name in enumerate(names)}


@pytest.mark.soak
def test_in_white_vibration_the_fed_filter_is_as_good_as_with_the_truth(flown):
    for name in ("hover", "climb", "rough"):
        squares, _ = flown[name]
        assert abs(np.sqrt(squares[FED] / squares[TRUTH]) - 1) < 0.05, name


@pytest.mark.soak
def test_in_rough_air_it_beats_the_data_sheet_by_more_than_a_quarter(flown):
    squares, nees = flown["rough"]
    ratio = np.sqrt(squares[FED] / squares[SHEET])
    # In steady state, a constant that is too small by k costs sqrt((k^2 + 1) / (2 k)).
    assert np.sqrt(2 * 8 / (8**2 + 1)) * 0.8 < ratio < 0.75
    # Its own variance agrees with its error there.
    assert nees[SHEET] > 5
    assert 0.8 < nees[FED] < 1.25


def test_davar_withholds_arw_in_a_rotor_tone_and_the_filter_keeps_the_value_before(flight):
    arw = flight.measured_arw(flight.flown(SEEDS[0]).counts)
    step = flight.SECONDS * flight.RATE_HZ // flight.STEP
    regimes = {regime.name: i for i, regime in enumerate(flight.REGIMES)}
    tone = arw[(regimes["tone"] * step) :][: step - 1]
    rough = flight.SHEET_ARW * flight.REGIMES[regimes["rough"]].noise
    assert np.max(np.abs(tone[step // 4 :] / rough - 1)) < 0.2


# --- the numbers of docs/KALMAN.md ---

AS_A_LIBRARY = """#include "davar/kalman.h"
double of_sample(double arw, int unit, double rate_hz);
double of_sample(double arw, int unit, double rate_hz)
{
    return davar_rate_variance(davar_rate_density(arw, (davar_rate_unit_t)unit), rate_hz);
}
"""
DEG_PER_S, RAD_PER_S = 0, 1


@pytest.fixture(scope="module")
def of_sample(tmp_path_factory):
    """davar_rate_variance of an ARW, its unit and the rate."""
    folder = tmp_path_factory.mktemp("kalman")
    (folder / "kalman.c").write_text(AS_A_LIBRARY)
    words = ["cc", "-shared", "-fPIC", *c_library.PROGRAM_FLAGS, "kalman.c", "-o", "kalman.so"]
    subprocess.run(words, cwd=folder, check=True)
    found = ctypes.CDLL(str(folder / "kalman.so")).of_sample
    found.argtypes, found.restype = (
        (ctypes.c_double, ctypes.c_int, ctypes.c_double),
        ctypes.c_double,
    )
    return found


@pytest.fixture(scope="module")
def white(flight):
    """Two flights without a tone, and their measured ARW from the fifth second on."""
    regimes = flight.REGIMES
    flight.REGIMES = tuple(regime._replace(tone_dps=0.0, noise=2.0) for regime in regimes)
    found = [flight.flown(seed) for seed in (401, 402)]
    yield [(one, flight.measured_arw(one.counts)) for one in found]
    flight.REGIMES = regimes


@pytest.mark.parametrize(
    ("unit", "to_unit", "factor", "is_consistent"),
    [
        pytest.param(DEG_PER_S, 1.0, 1.0, True, id="deg/s"),
        pytest.param(RAD_PER_S, np.pi / 180, 1.0, True, id="rad/s"),
        pytest.param(RAD_PER_S, 1.0, 1.0, False, id="rad/s not stated"),
        pytest.param(DEG_PER_S, 1.0, 2**0.5, False, id="one-sided"),
        pytest.param(DEG_PER_S, 1.0, 2**-0.5, False, id="half"),
        pytest.param(DEG_PER_S, 1.0, 60.0, False, id="without the 60"),
    ],
)
def test_the_variance_of_a_measured_arw_makes_a_filter_consistent(
    flight, white, of_sample, unit, to_unit, factor, is_consistent
):
    nees = []
    for one, arw in white:
        rate_hz = flight.RATE_HZ / flight.STEP
        variances = [of_sample(value * to_unit * factor, unit, rate_hz) for value in arw]
        nees += list(flight.filtered(one, np.array(variances))[:, 1])
    assert (0.8 < np.mean(nees) < 1.25) == is_consistent, np.mean(nees)
