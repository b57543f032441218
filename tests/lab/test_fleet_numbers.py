"""The rates that davarlab fleet states, against counting: false rejects of limits, outliers among
normal values, hidden effects where there is none.
"""

import math
from unittest import mock

import numpy as np
import pytest
from davarfleet import limits, population
from davarlab import simulate
from davarlab.diagnosis import improve
from davarlab.model import Model, Term
from davarlab.thresholds import CHANCE
from scipy import stats

N = "angle_random_walk.coefficient_deg_per_sqrt_h"
SENSORS = 300


def within(count, tries, share):
    """Is a count what chance gives, in 9 998 of 10 000 cases."""
    low, high = stats.binom.ppf([1e-4, 1 - 1e-4], tries, share)
    return low <= count <= high


def white(coefficient, seed):
    """[value, low, high] of a sensor of white noise, 100 s at 20 Hz."""
    terms = [Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": coefficient})]
    made = simulate.make(terms, 20.0, seed=seed, duration_s=100.0)
    one = improve.fit(made, Model(20.0, "gyro_z_dps", terms))[2][0]["coefficient_deg_per_sqrt_h"]
    return [one.value, one.low, one.high]


@pytest.mark.slow
def test_units_at_the_limit_and_beside_it_fail_as_often_as_is_stated():
    error = 1 / math.sqrt(2 * 2000)  # of a logarithm of 2000 normal values: theory, not the code
    estimates = [white(0.3, seed) for seed in range(SENSORS)]
    for side in (1, -1):
        for off in (0.0, -1.5, 1.0):  # of the limit from the truth, in standard errors
            limit = limits.Limit(N, 0.3 * math.exp(-side * off * error), side)
            test = limits.Test((limit,), 0.2, False)
            fails = sum(
                limits.outcome(test, {"coefficients": {N: one}})[0] == "fail" for one in estimates
            )
            stated = limits.chance_of_fail(limit, 0.3, limits.error_of(*estimates[0])[0], True, 0.2)
            assert abs(stated - stats.norm.cdf(off - stats.norm.isf(0.2))) <= 0.01
            assert within(fails, SENSORS, stated), (
                f"side {side}, off {off}: {fails} of {SENSORS} fail, stated {stated:.3f}"
            )


def outcome(test, *estimate, **row):
    return limits.outcome(test, {"coefficients": {"x": list(estimate)}, **row})


def test_a_coefficient_with_an_even_interval():
    rng, reach = np.random.default_rng(2), 2e-4 * CHANCE.normal_95
    limit = limits.Limit("x", 0.001, 1)
    test = limits.Test((limit,), 0.05, False)
    values = 0.0012 + 2e-4 * rng.standard_normal(4000)
    fails = sum(outcome(test, v, v - reach, v + reach)[0] == "fail" for v in values)
    assert within(fails, 4000, limits.chance_of_fail(limit, 0.0012, 2e-4, False, 0.05)), fails


def test_what_is_not_known_does_not_pass():
    test, fits = limits.Test((limits.Limit("x", 1.0, 1),), 0.025, True), {"adequacy": "statistical"}
    assert outcome(test, 0.5, None, None, **fits) == ("no result", ["x <= 1"])
    assert limits.outcome(test, {"coefficients": {}, **fits})[0] == "no result"
    assert outcome(test, 0.0, 0.0, 0.2, **fits)[0] == "pass"
    assert outcome(test, 0.5, 0.4, 0.625, adequacy="no") == ("fail", ["model adequate"])


def test_the_value_that_95_of_100_units_fail_from():
    wide = math.exp(0.02 * CHANCE.normal_95)
    rows = [{"coefficients": {"x": [v, v / wide, v * wide]}} for v in (0.9, 1.0, 1.1)]
    test = limits.Test((limits.Limit("x", 1.5, 1),), 0.025, False)
    said = limits.stated(test, rows)[0]
    chance = limits.chance_of_fail(test.limits[0], said["caught_from"], 0.02, True, 0.025)
    assert abs(chance - 0.95) < 5e-8
    assert said["median"] == 1.0


def test_one_group_in_a_hundred_of_normal_values_has_one():
    rng = np.random.default_rng(77)
    for count in (8, 30, 250):
        x = rng.standard_normal((4000, count))
        off = np.abs(x - np.median(x, axis=1, keepdims=True))
        most = population.threshold(count) * 1.4826 * np.median(off, axis=1)
        found = np.sum(off.max(axis=1) > most)
        # both the threshold (4000 draws) and this count scatter: sqrt(2) of one
        assert abs(found - 40) < 4 * math.sqrt(2 * 40), count


def test_a_unit_with_a_tenth_more_noise_is_found():
    noise = np.append(0.3 * np.exp(0.01 * np.random.default_rng(3).standard_normal(50)), 0.33)
    row = {"batch": "", "axis": "z", "outlier": []}
    units = [
        {**row, "file": str(place), "coefficients": {"x": [v, v * 0.99, v / 0.99]}}
        for place, v in enumerate(noise)
    ]
    assert [one["file"] for one in population.summary(units, "z", "", "x")["outliers"]] == ["50"]


def rows(gains):
    return [{"gains": {f"kind {place}": value for place, value in enumerate(row)}} for row in gains]


def hidden(own, null):
    """What a batch with these gains hides, beside what chance gives."""
    return population.hidden(rows(own), "z", "", [row["gains"] for row in rows(null)])


def gains(rng, *shape):
    return rng.chisquare(1, shape) / 2


def test_where_nothing_is_hidden_p_is_evenly_spread():
    rng, found = np.random.default_rng(11), []
    with mock.patch.object(population, "PERMUTATIONS", 1000):
        for _ in range(150):
            own, null = gains(rng, 40, 6), gains(rng, 30, 6)
            found.append(min(one["p_value"] for one in hidden(own, null)))
    assert stats.kstest(found, "uniform").pvalue > 1e-3


def test_a_shift_of_one_kind_is_named_and_p_is_that_of_a_permutation_test():
    rng = np.random.default_rng(5)
    own, null = gains(rng, 60, 1) + 0.12, gains(rng, 50, 1)
    reference = stats.permutation_test(
        (np.minimum(own[:, 0], null.max()), null[:, 0]),
        lambda x, y: x.mean() - y.mean(),
        alternative="greater",
        n_resamples=20000,
        rng=np.random.default_rng(1),
    ).pvalue
    found = hidden(own, null)[0]["p_value"]
    assert abs(found - reference) <= 4 * math.sqrt(2 * reference / 20000)


def batches(own, null):
    """Rows of a batch B with these gains and of an A with some of the null."""
    kinds = ("temperature", "temperature_hysteresis", "gauss_markov")
    for place, gain in enumerate(np.vstack([own, null[:20]])):
        batch = "B" if place < len(own) else "A"
        row = {"file": str(place), "axis": "z", "batch": batch, "gains": dict(zip(kinds, gain))}
        yield row | ({"chance": dict(zip(kinds, null[place]))} if place < len(null) else {})


def test_of_two_kinds_that_gain_alike_the_simpler_is_named_whichever_falls_below_the_threshold():
    """Gains of a coefficient of temperature and of its hysteresis differ by a little noise: p
    of the one is below 1 % and of the other above.
    """
    named = []
    for seed in range(120):
        rng = np.random.default_rng(seed)
        own, null = (
            np.hstack([x, x + rng.normal(0, 0.2, x.shape), gains(rng, *x.shape)])
            for x in (gains(rng, 40, 1) + 0.36, gains(rng, 60, 1))
        )
        with mock.patch.object(population, "PERMUTATIONS", 4000):
            found = population.hidden_effects(list(batches(own, null)))
        said = {one["kind"]: one for one in found if one["batch"] == "B"}
        if any(one["found"] for one in said.values()):
            (one,) = (one for one in said.values() if one["named"])
            below = said["temperature"]["p_value"] < 0.01
            named.append((one["kind"], below, "temperature_hysteresis" in one["alternatives"]))
    assert ("temperature", False, True) in named  # found through the other alone
    assert len(named) > 40
    # by chance twice the scatter is exceeded on a side in one of 44
    assert within(sum(kind != "temperature" for kind, _, _ in named), len(named), 0.023), named
    assert within(sum(not told for _, _, told in named), len(named), 2 * 0.023), named


def test_one_unit_that_shows_it_all_does_not_speak_for_its_batch():
    rng = np.random.default_rng(6)
    own, null = gains(rng, 60, 3), gains(rng, 50, 3)
    own[7, 1] = 500.0
    assert min(one["p_value"] for one in hidden(own, null)) > 0.01


def test_a_drift_by_date_is_found_within_batches_that_differ():
    rng, days = np.random.default_rng(8), np.arange(60)
    values = (1 + days % 2) * np.exp(0.002 * days + 0.02 * rng.standard_normal(60))
    rows = [
        {"batch": "AB"[day % 2], "start_s": 1.77e9 + 86400.0 * day, "coefficients": coefficients}
        for day, coefficients in zip(days, ({"x": [v, v * 0.99, v / 0.99]} for v in values))
    ]
    said = population.trend(rows, "z", "x", "start_s")
    assert said["low"] < 0.002 < said["high"]
    assert said["p_value"] < 1e-4
