"""Starts inside_awkward.py in davarlab's own environment."""

import unittest

from apart import passes


class Awkward(unittest.TestCase):
    def test_in_the_environment_of_the_workbench(self):
        passes(self, "inside_awkward.py")


if __name__ == "__main__":
    unittest.main()
