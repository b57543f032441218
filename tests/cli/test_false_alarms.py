"""How often the window law reports plain white noise as unstable: the figures of the README."""

import unittest

from sim_case import SimCase


class FalseAlarms(SimCase):
    def setUp(self):
        super().setUp()
        self.path = self.recording(count=200_000)

    def rate(self, *options):
        rows = self.results(self.path, "--lsb", "0.01", *options)
        return sum(row["unstable"] == "1" for row in rows) / len(rows)

    def test_the_paper_s_bounds_are_wrong_for_one_window_in_five(self):
        self.assertAlmostEqual(0.19, self.rate(), delta=0.04)

    def test_both_criteria_together_have_few_errors(self):
        self.assertAlmostEqual(0.03, self.rate("--policy", "and"), delta=0.015)

    def test_wider_bounds_have_almost_no_errors(self):
        self.assertLess(self.rate("--kurtosis", "2:4", "--contribution", "0:0.2"), 0.01)

    def test_a_stated_rate_is_kept_at_every_length(self):
        for longest in ("300", "600", "2000"):
            lengths = ("--window-max", longest, "--window-min", longest, "--segment", "100")
            rate = self.rate("--unstable-rate", "0.01", "--policy", "or", *lengths)
            self.assertLess(rate, 0.02)  # 100 to 700 independent windows
        self.assertLess(self.rate("--unstable-rate", "0.01"), 0.012)


if __name__ == "__main__":
    unittest.main()
