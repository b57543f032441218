"""tests/lab/observing.py in davarlab's own environment."""

import unittest

from test_elsewhere import Inside as Started, setUpModule  # noqa: F401


class Inside(Started):
    def test_small_things_against_brute_force(self):
        self.passes("observing.py")

    test_what_is_said_of_made_up_results = None


if __name__ == "__main__":
    unittest.main()
