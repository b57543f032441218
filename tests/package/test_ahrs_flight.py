"""The flight of examples/ahrs_flight, with a third-party filter."""

import sys
import unittest
import warnings

import numpy as np
import together

sys.path.insert(0, str(together.ROOT / "examples/ahrs_flight"))
import flight

SEEDS = range(301, 304)
SHEET, FED, TRUTH = 0, 2, 3


class Flights(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = np.array([flight.compared(4.0, seed) for seed in SEEDS])
        cls.squares, cls.nees = found.mean(axis=0).transpose(2, 0, 1)

    def at(self, name):
        return [regime.name for regime in flight.REGIMES].index(name)

    def test_in_white_vibration_the_fed_filter_is_as_good_as_with_the_truth(self):
        for name in ("hover", "climb", "rough"):
            with self.subTest(regime=name):
                fed, truth = self.squares[FED, self.at(name)], self.squares[TRUTH, self.at(name)]
                self.assertLess(abs(np.sqrt(fed / truth) - 1), 0.05)

    def test_in_rough_air_it_beats_the_data_sheet_by_more_than_a_quarter(self):
        rough = self.at("rough")
        ratio = np.sqrt(self.squares[FED, rough] / self.squares[SHEET, rough])
        self.assertLess(ratio, 0.75)
        # In steady state, a constant that is too small by k costs sqrt((k^2 + 1) / (2 k)).
        self.assertGreater(ratio, np.sqrt(2 * 8 / (8**2 + 1)) * 0.8)

    def test_its_own_variance_agrees_with_its_error_there(self):
        rough = self.at("rough")
        self.assertGreater(self.nees[SHEET, rough], 5)
        self.assertGreater(self.nees[FED, rough], 0.8)
        self.assertLess(self.nees[FED, rough], 1.25)


class Noise(unittest.TestCase):
    def test_davar_withholds_arw_in_a_rotor_tone_and_the_filter_keeps_the_value_before(self):
        counts = flight.flown(SEEDS[0]).counts
        arw = flight.measured_arw(counts)
        step = flight.SECONDS * flight.RATE_HZ // flight.STEP
        regimes = [regime.name for regime in flight.REGIMES]
        tone = arw[(regimes.index("tone") * step) :][: step - 1]
        rough = flight.SHEET_ARW * flight.REGIMES[regimes.index("rough")].noise
        self.assertLess(np.max(np.abs(tone[step // 4 :] / rough - 1)), 0.2)


if __name__ == "__main__":
    unittest.main()
