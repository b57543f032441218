"""Telegraph noise with two and more levels, against sums over all paths and drawn by formulas of
this file.
"""

import itertools

import numpy as np
from davarlab import model, simulate
from davarlab.inference import states
from lab_scenarios import RATE, telegraph
from scipy import stats


def test_three_levels_as_the_sum_over_all_paths():
    values = np.random.default_rng(1).normal(size=7)
    for level, noise_, stay in ((0.8, 1.0, 0.9), (2.0, 0.3, 0.6)):
        whole, mean = 0.0, 0.0
        for path in itertools.product((2, 0, -2), repeat=len(values)):
            chance = (
                np.prod([stay if a == b else (1 - stay) / 2 for a, b in zip(path, path[1:])]) / 3
            )
            density = chance * np.prod(stats.norm.pdf(values, level * np.array(path), noise_))
            whole, mean = whole + density, mean + density * np.array(path)
        likelihood, state = states.smoothed(values, level, noise_, stay, 3)
        assert abs(likelihood - np.log(whole)) < 5e-8
        np.testing.assert_allclose(state, mean / whole, atol=1e-9)


def test_the_mean_dwell_says_how_likely_a_level_stays():
    rng = np.random.default_rng(2)
    for levels in (2, 3, 4):
        level = telegraph(levels, 0.5, 0.4, rng)
        same = np.mean(level[:-10] == level[10:])
        assert abs(states.staying(10 / RATE, 0.4, levels) - same) <= 0.01


def test_the_simulator_makes_what_is_asked_for():
    terms = [
        model.checked_term(
            {
                "kind": "telegraph_noise",
                "amplitude_dps": 0.01,
                "mean_dwell_s": 2.0,
                "levels": 3,
            },
            "here",
        )
    ]
    y = simulate.make(terms, RATE, duration_s=2000.0).columns["gyro_z_dps"]
    levels = np.unique(np.round(y - y.min(), 9))
    np.testing.assert_allclose(levels, [0, 0.02, 0.04], atol=1e-9)
    assert abs(2000 / np.sum(np.diff(y) != 0) - 2.0) <= 0.25


# Decoded paths, one value per sample, places 2 apart.


def path(levels, dwells):
    return np.repeat(levels, np.maximum(1, np.round(dwells).astype(int))).astype(float)


def chosen(rng, count, levels):
    return levels - 1 - 2 * (np.cumsum(rng.integers(1, levels, count)) % levels)


def test_random_ones_are_telegraph_noise():
    for seed in range(40):
        rng = np.random.default_rng([6, seed])
        levels, count = int(rng.integers(2, 6)), int(rng.integers(6, 400))
        found = path(chosen(rng, count, levels), rng.exponential(300, count))
        assert states.like_chance(found, levels), seed


def test_those_of_a_load_that_is_switched_evenly_are_not():
    for seed in range(40):
        rng = np.random.default_rng([7, seed])
        count, duty = int(rng.integers(60, 200)), rng.uniform(0.1, 0.5)
        share = np.where(np.arange(count) % 2, duty, 1 - duty)
        dwells = 500 * share * (1 + rng.uniform(0.1, 0.3) * rng.uniform(-1, 1, count))
        found = path(1 - 2 * (np.arange(count) % 2), dwells)
        assert not states.like_chance(found), seed


def test_a_sawtooth_passes_through_the_levels():
    for seed in range(40):
        rng = np.random.default_rng([8, seed])
        levels = int(rng.integers(3, 6))
        teeth = 300 * rng.exponential(1, 200)  # of random length: only the order tells
        found = path(np.tile(np.arange(levels - 1, -levels, -2), 200), np.repeat(teeth, levels))
        assert not states.like_chance(found, levels), seed
