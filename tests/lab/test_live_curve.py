"""The Allan curve of the Live view, computed from one result: sizes, intervals, fitted terms."""

import math

import numpy as np
from davar.wire import frames as wire
from davarlab.workbench.curve import curve, fitted, limits
from scipy import stats

RATE_HZ = 100.0
TERMS = (  # column, factor and power of tau in (1.2), of a coefficient in deg and s
    ("qn_deg", 1, 3, -2),
    ("arw_deg_per_sqrt_h", 60, 1, -1),
    ("bi_deg_per_h", 3600, 2 * math.log(2) / math.pi, 0),
    ("rrw_deg_per_h_per_sqrt_h", 3600 * 60, 1 / 3, 1),
    ("rr_deg_per_h2", 3600**2, 1 / 2, 2),
)


def result(adev, sizes=None, values=None, uncertainty=None):
    channel = wire.Channel()
    channel.setup["rate_hz"] = RATE_HZ
    channel.clusters = dict(enumerate(sizes or [2**t for t in range(len(adev))]))
    return wire.Result(
        0, 0, 0, values or {}, dict(enumerate(adev)), dict(enumerate(uncertainty or [])), of=channel
    )


def absent(found, name):
    return [value is None for value in found[name]]


def test_sizes_ascend_to_two_to_the_31_and_some_have_no_deviation_yet():
    found = curve(result([0.1] * 32))
    assert found["m"] == [2**t for t in range(32)]
    assert found["tau_s"][-1] == 2**31 / RATE_HZ
    assert found["adev"] == [0.1] * 32
    assert all(found[name] == [None] * 32 for name in ("low", "high", "fitted"))
    values = {"arw_deg_per_sqrt_h": 0.6}
    found = curve(result([0.1, 0.05, math.nan], None, values, [0.1, 0.2, math.nan]))
    for name in ("adev", "low", "high", "fitted"):
        assert absent(found, name) == [False, False, True], name
    found = curve(result([3.0, 1.0, 2.0], [64, 1, 8]))  # in any order of their frames
    assert (found["m"], found["adev"]) == ([1, 8, 64], [1.0, 2.0, 3.0])


def test_what_the_sender_has_not_said_yet_is_absent():
    one = result([0.1, 0.2], None, {"arw_deg_per_sqrt_h": 0.6})
    one.sender.setup.clear()
    found = curve(one)
    assert (found["tau_s"], found["fitted"]) == (None, [None, None])
    one.sender.clusters.clear()
    assert curve(one) is None
    assert curve(result([])) is None


def test_both_limits_follow_from_half_the_width():
    for edf in (2.6, 3, 5, 10, 100, 1e4, 1e6):
        low, high = (math.sqrt(edf / stats.chi2.ppf(p, edf)) for p in (0.975, 0.025))
        np.testing.assert_allclose(limits(2.0, (high - low) / 2), (2 * low, 2 * high), rtol=1e-4)
    for uncertainty in (math.nan, math.inf):
        assert limits(2.0, uncertainty) is None
    assert limits(math.nan, 0.1) is None


def test_the_terms_add_their_variances():
    for taken in range(1, 32):
        given, parts = {}, []
        for k, (name, unit, factor, power) in enumerate(TERMS):
            given[name] = 0.1 + k if taken >> k & 1 else math.nan
            parts += [(given[name] / unit, factor, power)] if taken >> k & 1 else []
        for tau_s in (0.01, 1.0, 86400.0):
            variance = sum(factor * value**2 * tau_s**power for value, factor, power in parts)
            assert abs(fitted(given, tau_s) / math.sqrt(variance) - 1) <= 1e-12
    assert fitted({"bi_deg_per_h": math.nan, "kurtosis": 3.0}, 1.0) is None
