"""The statements of docs/FLIGHT.md about drift, floor and total noise, with another seed."""

import sys

import numpy as np
import pytest
import together

EXAMPLE = together.ROOT / "examples/strapdown"


@pytest.fixture(scope="module")
def found():
    """{(airframe, samples): (drift, floor, its upper limit, total at 1 ms to 1 s)}."""
    sys.path.insert(0, str(EXAMPLE))
    import strapdown

    random = np.random.default_rng(77)
    results = {}
    for airframe in (0.0, 30.0):
        rate_dps = strapdown.rates(random, airframe)
        sigma = strapdown.ARW / 60 * np.sqrt(strapdown.FAST_HZ)
        noise = sigma * random.normal(size=len(rate_dps))
        for name, take in strapdown.TAKES.items():
            results[airframe, name] = strapdown.measured(rate_dps, noise, take)
    yield results
    sys.path.remove(str(EXAMPLE))
    del sys.modules["strapdown"]


@pytest.mark.slow
@pytest.mark.parametrize("airframe", [0.0, 30.0])
def test_the_drift_comes_from_the_gyro_and_is_below_the_floor(found, airframe):
    drift, floor, high, *total = found[airframe, "mean of 8"]
    assert drift == pytest.approx(0.5, rel=4 / np.sqrt(2 * 299))  # of as many seconds
    assert drift < high and floor < high
    assert floor < 2 * drift or airframe > 0
    assert total[0] > 8 * drift and total[-1] > 1000 * drift


@pytest.mark.slow
@pytest.mark.parametrize("airframe", [0.0, 30.0])
def test_dropping_samples_keeps_the_variance_of_the_fast_rate(found, airframe):
    drift, _, high, *_ = found[airframe, "every 8th"]
    assert drift == pytest.approx(8**0.5 * 0.5, rel=4 / np.sqrt(2 * 299))
    assert drift < high
