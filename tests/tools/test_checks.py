"""tools/test itself: the parts run beside each other, each is printed whole, and what one needs is built once."""

import contextlib
import io
import sys
import threading
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import checks  # noqa: E402


def printed(parts):
    """(total, lines) of a run of {name: jobs}."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        total = checks.run_parts(parts)
    return total, text.getvalue().splitlines()


def breaks():
    raise checks.Broken("no compiler\nat all")


class Parts(unittest.TestCase):
    def test_as_many_jobs_run_at_once_as_there_are_cores(self):
        cores = int(checks.JOBS)
        meeting = threading.Barrier(cores)

        def job():
            meeting.wait(timeout=600)
            return checks.Tally(1)

        total, _ = printed({"a": [job] * cores})
        self.assertEqual((cores, 0), (total.passed, total.failed), total.lines)

    def test_a_part_that_fails_stops_no_other_and_its_text_is_in_one_piece(self):
        crash = {}
        total, lines = printed({"a": [breaks, lambda: checks.Tally(2), breaks], "b": [lambda: crash["it"]],
                                "c": [lambda: checks.Tally(3, skipped=1, lines=["skipped: one"])] * 2})
        self.assertEqual((8, 3, 2), (total.passed, total.failed, total.skipped))
        at = next(n for n, line in enumerate(lines) if line.startswith("a "))
        self.assertRegex(lines[at], r"^a +2 passed, 2 failed, 0 skipped  \(0 s\)$")
        self.assertEqual(["    no compiler", "    at all"], lines[at + 1:at + 3])
        self.assertEqual(1, lines.count("    no compiler"), "the same failure is told once")
        self.assertIn("    KeyError: 'it'", lines)

    def test_what_two_parts_need_is_made_once_and_its_failure_is_that_of_both(self):
        made = []

        @checks.once
        def build(preset):
            made.append(preset)
            if preset == "broken":
                breaks()
            return checks.Tally(1)

        total, _ = printed({name: [lambda: build("good"), lambda: build("broken")] for name in "abc"})
        self.assertEqual((3, 3, ["broken", "good"]), (total.passed, total.failed, sorted(made)))


if __name__ == "__main__":
    unittest.main()
