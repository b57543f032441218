"""tools/soak: slices, resuming, faults and the table, with short checks of its own."""

import contextlib
import io
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import soak


class Soak(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name) / "commit"
        self.slices = []

    def check(self, name, hours, whole=False, fault=None):
        """A check that records its slices; the slice with the number `fault` finds something."""

        def run(length, number, folder):
            self.slices.append((name, round(length, 3), number))
            found = ["input-1"] if number == fault else []
            return soak.Done(length, counts={"runs": 1000, "most edges": 10 - number}, found=found)

        return soak.Check(hours, run, ("fuzz",), whole)

    def soaked(self, checks, share=1.0, stop_after=None):
        """(exit status, printed text)."""
        with (
            mock.patch.object(soak, "CHECKS", checks),
            contextlib.redirect_stdout(io.StringIO()) as said,
        ):
            one = soak.Soak(list(checks), share, self.folder)
            if stop_after:
                save = one.save
                one.save = lambda: (save(), len(self.slices) >= stop_after and one.stopped.set())
            return one.run(), said.getvalue()

    def test_slices_add_up_and_a_check_of_one_slice_has_one(self):
        checks = {"a": self.check("a", 0.2), "b": self.check("b", 7, whole=True)}
        status, said = self.soaked(checks)
        self.assertEqual(status, 0)
        of_a = [one[1:] for one in self.slices if one[0] == "a"]
        self.assertEqual(of_a, [(0.083, 0), (0.083, 1), (0.033, 2)])
        self.assertIn(("b", 7, 0), self.slices)
        row = next(line for line in said.splitlines() if line.startswith("a "))
        self.assertRegex(row, r"^a +0:12 of 0:12  3 000 runs, 10 edges +nothing$")

    def test_an_interrupted_run_continues(self):
        status, said = self.soaked({"a": self.check("a", 0.3)}, stop_after=2)
        self.assertEqual(status, 130)
        self.assertIn("0:10 of 0:18", said)
        self.assertIn("continues", said)
        status, said = self.soaked({"a": self.check("a", 0.3)})
        self.assertEqual(status, 0)
        self.assertEqual([number for *_, number in self.slices], [0, 1, 2, 3])

    def test_a_check_that_has_found_something_stops_for_good(self):
        checks = {"a": self.check("a", 1, fault=1), "b": self.check("b", 0.1)}
        status, said = self.soaked(checks)
        self.assertEqual(status, 1)
        self.assertRegex(said, r"a +0:10 of 1:00 .* input-1")
        self.assertRegex(said, r"b +0:06 of 0:06 .* nothing")
        self.assertIn("(nothing was found on any earlier commit)", said)
        count = len(self.slices)
        self.assertEqual(self.soaked(checks)[0], 1)
        self.assertEqual(len(self.slices), count)

    def test_the_last_commit_without_a_finding_is_named(self):
        self.assertEqual(self.soaked({"a": self.check("a", 0.1)})[0], 0)
        self.folder = self.folder.with_name("later")
        status, said = self.soaked({"a": self.check("a", 0.1, fault=0)})
        self.assertEqual(status, 1)
        self.assertIn("(nothing was found on commit)", said)

    def test_a_check_that_cannot_run_says_why(self):
        def broken(*_):
            raise soak.Broken("lines\nno compiler")

        status, said = self.soaked({"a": soak.Check(1, broken, ("fuzz",))})
        self.assertEqual((status, "cannot run: no compiler" in said), (1, True), said)

    def test_wrong_options_are_rejected_in_one_line(self):
        for words, name in ((["--only", "fuzz-x"], "fuzz-x"), (["--share", "0"], "--share 0")):
            done = subprocess.run(
                [sys.executable, soak.__file__, *words], text=True, capture_output=True
            )
            self.assertEqual(done.returncode, 2)
            self.assertIn(name, done.stderr.splitlines()[-1])
