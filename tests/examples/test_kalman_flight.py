"""The flight of examples/kalman_flight: a filter with davar's noise is as good as one with the true
noise, for every seed.
"""

import csv
import io
import math
import statistics
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SEEDS = range(101, 107)
FLIGHTS = 20


def run(*command):
    return subprocess.run([str(word) for word in command], text=True, capture_output=True)


class Flight(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        for command in (
            ("cmake", "-S", ROOT / "examples/kalman_flight", "-B", folder.name),
            ("cmake", "--build", folder.name),
        ):
            done = run(*command)
            assert done.returncode == 0, done.stdout + done.stderr
        cls.program = Path(folder.name, "flight")
        cls.loud = [cls.fly("--seed", seed, "--flights", FLIGHTS) for seed in SEEDS]

    @classmethod
    def fly(cls, *options):
        """(phase, belief) -> rms error, NEES over 3, share of seconds within the 95 % bounds."""
        done = run(cls.program, *options)
        assert done.returncode == 0, done.stderr
        return {
            (row["phase"], row["belief"]): tuple(
                float(row[name]) for name in ("rms_deg", "nees_over_3", "share_within_95")
            )
            for row in csv.DictReader(io.StringIO(done.stdout))
        }

    def of(self, number, phase, belief):
        """Mean and standard error over the seeds of one figure."""
        values = [flight[phase, belief][number] for flight in self.loud]
        return statistics.mean(values), statistics.stdev(values) / math.sqrt(len(values))

    def test_in_noise_that_triples_the_fed_filter_beats_the_one_from_the_bench(self):
        (bench, bench_error), (fed, fed_error) = (
            self.of(0, "loud", "bench"),
            self.of(0, "loud", "fed"),
        )
        self.assertGreater(bench - fed, 5 * math.hypot(bench_error, fed_error))
        # Steady state of one axis: random walk of 0.015 deg/sqrt(s), measured to 0.05 deg once a
        # second; a gain for 0.005 deg/sqrt(s).
        for belief, gained, said in (("true", 0.015, fed), ("bench", 0.005, bench)):
            ahead = (gained**2 + math.sqrt(gained**4 + 4 * gained**2 * 0.05**2)) / 2
            k = ahead / (ahead + 0.05**2)
            behind = ((1 - k) ** 2 * 0.015**2 + k**2 * 0.05**2) / (1 - (1 - k) ** 2)
            self.assertAlmostEqual(
                said / math.sqrt(behind), 1, delta=0.06, msg=belief
            )  # the bias, which both learn, adds a little

    def test_it_is_consistent_in_every_phase_and_they_are_not(self):
        for phase in ("quiet", "loud", "after"):
            mean, error = self.of(1, phase, "fed")
            truth, truth_error = self.of(1, phase, "true")
            self.assertLess(
                abs(mean - truth), 0.02, phase
            )  # the flights are the same, so there is no random difference
            self.assertLess(abs(truth - 1), 4 * truth_error + 0.01, phase)
        self.assertGreater(self.of(1, "loud", "bench")[0], 3)
        self.assertLess(self.of(1, "quiet", "worst")[0], 0.75)

    def test_in_noise_that_does_not_change_feeding_costs_nothing(self):
        for law in ("glr", "or", "fixed"):
            flight = self.fly("--seed", 7, "--flights", FLIGHTS, "--steady", "--law", law)
            for phase in ("quiet", "loud", "after"):
                self.assertLess(
                    flight[phase, "fed"][0] / flight[phase, "bench"][0], 1.005, (law, phase)
                )

    def test_the_same_seed_gives_the_same_flight_and_a_wrong_option_is_rejected(self):
        twice = [run(self.program, "--flights", 2, "--seed", 5).stdout for _ in range(2)]
        self.assertEqual(twice[0], twice[1])
        self.assertNotEqual(twice[0], run(self.program, "--flights", 2, "--seed", 6).stdout)
        for wrong in (("--law", "x"), ("--flights", "0"), ("--flights",), ("--nosuch", "1")):
            done = run(self.program, *wrong)
            self.assertEqual((done.returncode, done.stdout), (2, ""), wrong)
            self.assertIn("usage: flight", done.stderr)


if __name__ == "__main__":
    unittest.main()
