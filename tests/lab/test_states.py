"""Telegraph noise with two and more levels, against sums over all paths and drawn by formulas of
this file.
"""

import itertools
import unittest

import numpy as np
from davarlab import model, simulate
from davarlab.data.recording import Recording
from davarlab.diagnosis import improve
from davarlab.errors import BadInput
from davarlab.inference import states
from scipy import signal, stats

RATE, COUNT = 50.0, 100000
MODEL = model.Model(
    RATE,
    "gyro_z_dps",
    [
        model.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3}),
        model.Term("bias_instability", {"coefficient_deg_per_h": 5.0}),
    ],
)


def telegraph(levels, amplitude, dwell, rng):
    """Each switch to any of the other levels."""
    time, state, path = np.arange(COUNT) / RATE, int(rng.integers(levels)), []
    switches = np.cumsum(rng.exponential(dwell, int(20 + 4 * time[-1] / dwell)))
    for _ in range(len(switches) + 1):
        path.append(state)
        state = (state + int(rng.integers(1, levels))) % levels
    return amplitude * (2 * np.array(path)[np.searchsorted(switches, time)] - (levels - 1))


def noise(rng):
    f = np.fft.rfftfreq(2 * COUNT, 1 / RATE)
    f[0] = f[1]
    flicker = np.fft.irfft(
        np.fft.rfft(rng.standard_normal(2 * COUNT)) * 5 / 3600 * np.sqrt(RATE / (2 * np.pi * f))
    )[:COUNT]
    return 0.3 / 60 * RATE**0.5 * rng.standard_normal(COUNT) + flicker


def improved(y):
    return improve.improve(Recording({"gyro_z_dps": y}, RATE), MODEL)


class Chains(unittest.TestCase):
    def test_three_levels_as_the_sum_over_all_paths(self):
        values = np.random.default_rng(1).normal(size=7)
        for level, noise_, stay in ((0.8, 1.0, 0.9), (2.0, 0.3, 0.6)):
            whole, mean = 0.0, 0.0
            for path in itertools.product((2, 0, -2), repeat=len(values)):
                chance = (
                    np.prod([stay if a == b else (1 - stay) / 2 for a, b in zip(path, path[1:])])
                    / 3
                )
                density = chance * np.prod(stats.norm.pdf(values, level * np.array(path), noise_))
                whole, mean = whole + density, mean + density * np.array(path)
            likelihood, state = states.smoothed(values, level, noise_, stay, 3)
            self.assertAlmostEqual(likelihood, np.log(whole), places=7)
            np.testing.assert_allclose(state, mean / whole, atol=1e-9)

    def test_the_mean_dwell_says_how_likely_a_level_stays(self):
        rng = np.random.default_rng(2)
        for levels in (2, 3, 4):
            level = telegraph(levels, 0.5, 0.4, rng)
            same = np.mean(level[:-10] == level[10:])
            self.assertAlmostEqual(states.staying(10 / RATE, 0.4, levels), same, delta=0.01)

    def test_the_simulator_makes_what_is_asked_for(self):
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
        self.assertAlmostEqual(2000 / np.sum(np.diff(y) != 0), 2.0, delta=0.25)

    def test_levels_are_a_whole_number(self):
        with self.assertRaisesRegex(BadInput, "levels = 2.5 must be a whole number"):
            model.checked_term(
                {
                    "kind": "telegraph_noise",
                    "amplitude_dps": 0.01,
                    "mean_dwell_s": 2.0,
                    "levels": 2.5,
                },
                "here",
            )


class Switches(unittest.TestCase):
    """Decoded paths, one value per sample, places 2 apart."""

    def path(self, levels, dwells):
        return np.repeat(levels, np.maximum(1, np.round(dwells).astype(int))).astype(float)

    def chosen(self, rng, count, levels):
        return levels - 1 - 2 * (np.cumsum(rng.integers(1, levels, count)) % levels)

    def test_random_ones_are_telegraph_noise(self):
        for seed in range(40):
            rng = np.random.default_rng([6, seed])
            levels, count = int(rng.integers(2, 6)), int(rng.integers(6, 400))
            path = self.path(self.chosen(rng, count, levels), rng.exponential(300, count))
            self.assertTrue(states.like_chance(path, levels), seed)

    def test_those_of_a_load_that_is_switched_evenly_are_not(self):
        for seed in range(40):
            rng = np.random.default_rng([7, seed])
            count, duty = int(rng.integers(60, 200)), rng.uniform(0.1, 0.5)
            share = np.where(np.arange(count) % 2, duty, 1 - duty)
            dwells = 500 * share * (1 + rng.uniform(0.1, 0.3) * rng.uniform(-1, 1, count))
            path = self.path(1 - 2 * (np.arange(count) % 2), dwells)
            self.assertFalse(states.like_chance(path), seed)

    def test_a_sawtooth_passes_through_the_levels(self):
        for seed in range(40):
            rng = np.random.default_rng([8, seed])
            levels = int(rng.integers(3, 6))
            teeth = 300 * rng.exponential(1, 200)  # of random length: only the order tells
            path = self.path(
                np.tile(np.arange(levels - 1, -levels, -2), 200), np.repeat(teeth, levels)
            )
            self.assertFalse(states.like_chance(path, levels), seed)


class Levels(unittest.TestCase):
    def test_their_number_is_found_beside_flicker(self):
        for levels, amplitude, dwell in (
            (2, 0.008, 20),
            (3, 0.008, 20),
            (3, 0.006, 60),
            (4, 0.008, 20),
        ):
            found = improved(
                noise(np.random.default_rng([3, levels, dwell]))
                + telegraph(levels, amplitude, dwell, np.random.default_rng([4, levels, dwell]))
            )
            self.assertEqual(found.diagnosis.added, ["telegraph_noise"], levels)
            value = found.estimates[-1]
            self.assertEqual(value["levels"].value, levels)
            self.assertAlmostEqual(value["amplitude_dps"].value / amplitude, 1, delta=0.06)
            self.assertLess(abs(np.log(value["mean_dwell_s"].value / dwell)), 0.5)

    def test_a_continuum_has_none(self):
        for std, tau in ((0.008, 5), (0.006, 20)):
            rng, decay = np.random.default_rng([5, tau]), np.exp(-1 / RATE / tau)
            course = std * signal.lfilter(
                [np.sqrt(1 - decay**2)], [1, -decay], rng.standard_normal(COUNT)
            )
            self.assertEqual(improved(noise(rng) + course).diagnosis.added, ["gauss_markov"])


if __name__ == "__main__":
    unittest.main()
