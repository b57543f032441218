"""The way of the search: where it ends."""

import unittest
from dataclasses import dataclass, replace
from unittest import mock

from davarlab.diagnosis import search


@dataclass(frozen=True)
class Judgement:
    adequate: bool


@dataclass(frozen=True)
class Step:
    name: str
    judgement: Judgement


class End(unittest.TestCase):
    def ends(self, *adequate, late=()):
        """Names of the steps that are kept; late: those that the tests in time refute."""
        steps = [Step(name, Judgement(good)) for name, good in zip("abcde", adequate)]
        again = mock.Mock(
            side_effect=lambda one: replace(one, judgement=Judgement(one.name not in late))
        )
        with mock.patch.object(search, "judged", again):
            return "".join(step.name for step in search.best(steps))

    def test_it_ends_at_the_last_adequate_step(self):
        self.assertEqual(self.ends(False, False, True), "abc")
        self.assertEqual(self.ends(False, True, False), "ab")
        self.assertEqual(self.ends(True, False, False), "a")
        self.assertEqual(self.ends(False, True, True, False, late="c"), "ab")

    def test_without_an_adequate_step_all_are_kept(self):
        self.assertEqual(self.ends(False, False, False), "abc")
        self.assertEqual(self.ends(False, True, False, late="b"), "abc")


if __name__ == "__main__":
    unittest.main()
