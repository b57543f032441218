"""tests/lab/observing.py in davarlab's own environment."""

import unittest

import test_elsewhere


def setUpModule():
    test_elsewhere.setUpModule()


class Inside(unittest.TestCase):
    def test_small_things_against_formulas_of_their_own(self):
        test_elsewhere.Inside.passes(self, "observing.py")


if __name__ == "__main__":
    unittest.main()
