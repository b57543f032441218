"""The flight of examples/ahrs_flight, with a third-party filter."""

import subprocess
import sys
import warnings

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
