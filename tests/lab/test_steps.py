"""Steps of the bias and lines that are there for a while."""

import unittest

import benchmark_effects
import numpy as np
from davarlab import model, simulate
from davarlab.candidates import intermittent, steps
from davarlab.data import signals
from davarlab.data.recording import Recording
from davarlab.diagnosis import improve
from davarlab.errors import BadInput
from davarlab.thresholds import LINE, STEP, TRIES
from scipy import stats

RATE, COUNT = 50.0, 100000
TIME = np.arange(COUNT) / RATE
MODEL = model.Model(
    RATE,
    "gyro_z_dps",
    [
        model.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3}),
        model.Term("bias_instability", {"coefficient_deg_per_h": 5.0}),
    ],
)


def noise(rng):
    f = np.fft.rfftfreq(2 * COUNT, 1 / RATE)
    f[0] = f[1]
    flicker = np.fft.irfft(
        np.fft.rfft(rng.standard_normal(2 * COUNT)) * 5 / 3600 * np.sqrt(RATE / (2 * np.pi * f))
    )[:COUNT]
    return 0.3 / 60 * RATE**0.5 * rng.standard_normal(COUNT) + flicker


def improved(y):
    return improve.improve(Recording({"gyro_z_dps": y}, RATE), MODEL)


def holds(estimate, value):
    return estimate.low <= value <= estimate.high


class Search(unittest.TestCase):
    def test_the_score_of_a_step_by_least_squares(self):
        rng, n = np.random.default_rng(1), 400
        level = 1 + 30 / np.arange(1, n) ** 1.3
        c = rng.standard_normal(n - 1) * np.sqrt(level)
        found = steps.scores(c / level, steps.alike(level))
        for place in (3, 77, 200, 391):
            course = signals.transform((np.arange(n) >= place).astype(float))[1:]
            score = np.sum(course * c / level) / np.sqrt(np.sum(course**2 / level))
            self.assertAlmostEqual(found[place - 1], score, places=8)

    def test_the_chance_of_a_step_holds_in_noise_that_walks_or_not(self):
        for tilt in (0.0, 1.0, 2.0):
            n, hits = 5000, 0
            level = 1 + 200 * (np.arange(1, n) / 10.0) ** -tilt if tilt else np.ones(n - 1)
            same = steps.alike(level)
            for seed in range(200):
                c = np.random.default_rng([2, seed]).standard_normal(n - 1) * np.sqrt(level)
                score = np.abs(steps.scores(c / level, same))
                score[: STEP.edge] = score[-STEP.edge :] = 0
                hits += steps.log_chance(float(score.max()), same, n) < np.log(0.05)
            self.assertLess(hits, stats.binom.ppf(0.999, 200, 0.05), tilt)

    def test_the_chance_of_a_line_for_a_while_holds(self):
        n, hits = 20000, 0
        for seed in range(60):
            w = np.random.default_rng([3, seed]).standard_normal(n)
            _, nu, low, high = intermittent.strongest(w)
            for _ in range(LINE.visit_rounds):
                gain, low, high = intermittent.best_interval(w, nu)
                nu = intermittent.best_frequency(w, nu, low, high)
            hits += np.log(TRIES.of_visit * n * gain**2) - gain < np.log(0.05)
        self.assertLess(hits, stats.binom.ppf(0.999, 60, 0.05))


class Steps(unittest.TestCase):
    def test_one_and_two_are_found_where_they_are(self):
        for places, sizes in (((700.0,), (0.012,)), ((500.0, 1400.0), (0.015, -0.02))):
            y = noise(np.random.default_rng([4, len(places)])) + sum(
                size * (place <= TIME) for place, size in zip(places, sizes)
            )
            found = improved(y)
            self.assertEqual(found.diagnosis.added, ["bias_step"] * len(places))
            values = sorted(found.estimates[2:], key=lambda entry: entry["time_s"].value)
            for value, place, size in zip(values, places, sizes):
                self.assertLess(abs(value["time_s"].value - place), 4)
                self.assertAlmostEqual(value["step_dps"].value, size, delta=0.004)
                self.assertGreater(value["time_s"].high, value["time_s"].low)

    def test_what_moves_slowly_is_no_step(self):
        for name, course in (
            (
                "rate_random_walk",
                np.cumsum(np.random.default_rng(5).standard_normal(COUNT))
                * 60
                / 216000
                / RATE**0.5,
            ),
            ("rate_ramp", 100 / 3600**2 * TIME),
            ("warm_up", 0.05 * np.exp(-TIME / 300)),
        ):
            found = improved(noise(np.random.default_rng([6, len(name)])) + course)
            self.assertNotIn("bias_step", found.diagnosis.added, name)

    def test_in_a_model_file_it_is_fitted_and_simulated(self):
        term = model.checked_term({"kind": "bias_step", "time_s": 100.0, "step_dps": 0.05}, "here")
        y = simulate.make([*MODEL.terms, term], RATE, duration_s=400.0).columns["gyro_z_dps"]
        self.assertAlmostEqual(y[6000:9000].mean() - y[2000:5000].mean(), 0.05, delta=0.005)
        entries = improve.fit(
            Recording({"gyro_z_dps": y}, RATE),
            model.Model(RATE, "gyro_z_dps", [*MODEL.terms, term]),
        )[2]
        self.assertTrue(holds(entries[2]["step_dps"], 0.05))


class Lines(unittest.TestCase):
    def test_a_machine_that_runs_for_a_while(self):
        for start, stop, f, size in ((300.0, 700.0, 7.3, 0.01), (1500.0, 1520.0, 3.1, 0.05)):
            rng = np.random.default_rng([7, int(start)])
            on = (start <= TIME) & (stop > TIME)
            found = improved(noise(rng) + on * size * np.sin(2 * np.pi * f * TIME + 1))
            self.assertEqual(found.diagnosis.added, ["intermittent_line"])
            value = found.estimates[-1]
            self.assertLess(abs(value["frequency_hz"].value - f), 0.1 / (stop - start))
            self.assertLess(abs(value["start_s"].value - start), 8)
            self.assertLess(abs(value["stop_s"].value - stop), 8)
            self.assertAlmostEqual(value["amplitude_dps"].value / size, 1, delta=0.15)

    def test_a_weak_one_is_named_where_the_sizes_of_the_file_are_the_true_ones(self):
        """The likeliest sizes of the given effects may do a little worse on the Allan deviation
        than the true ones: then those stay.
        """
        found = benchmark_effects.one(("intermittent_line", ["intermittent_line"], "visible", 7002))
        self.assertEqual(
            (found["verdict"], found["added"]), ("intermittent_line", ["intermittent_line"])
        )
        self.assertLessEqual(found["after"], found["before"])

    def test_a_line_that_is_always_there_is_none(self):
        found = improved(noise(np.random.default_rng(8)) + 0.01 * np.sin(2 * np.pi * 7.3 * TIME))
        self.assertEqual(found.diagnosis.added, ["sinusoid"])

    def test_in_a_model_file_it_is_fitted_and_simulated(self):
        said = {
            "kind": "intermittent_line",
            "frequency_hz": 7.0,
            "amplitude_dps": 0.05,
            "start_s": 100.0,
            "stop_s": 200.0,
        }
        terms = [*MODEL.terms, model.checked_term(said, "here")]
        y = simulate.make(terms, RATE, duration_s=400.0).columns["gyro_z_dps"]
        entries = improve.fit(
            Recording({"gyro_z_dps": y}, RATE), model.Model(RATE, "gyro_z_dps", terms)
        )[2]
        self.assertTrue(holds(entries[2]["amplitude_dps"], 0.05))
        self.assertTrue(holds(entries[2]["frequency_hz"], 7.0))
        with self.assertRaisesRegex(
            BadInput, "intermittent_line: stop_s = 50 is before start_s = 100"
        ):
            model.checked_term({**said, "stop_s": 50.0}, "here")


if __name__ == "__main__":
    unittest.main()
