"""Starts inside_states.py in davarlab's own environment."""

import unittest

from apart import passes


class States(unittest.TestCase):
    def test_in_the_environment_of_the_workbench(self):
        passes(self, "inside_states.py")


if __name__ == "__main__":
    unittest.main()
