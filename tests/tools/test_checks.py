"""tools/test itself: the parts run beside each other, each is printed whole, and what one needs is built once."""

import contextlib
import io
import json
import re
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import checks  # noqa: E402
import remembered  # noqa: E402


def printed(parts):
    """(total, lines) of a run of {name: jobs}."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        total = checks.run_parts(parts)
    return total, text.getvalue().splitlines()


def breaks():
    raise checks.Broken("no compiler\nat all")


class Parts(unittest.TestCase):
    def test_at_least_as_many_jobs_run_at_once_as_there_are_cores(self):
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

    def test_the_jobs_that_took_longest_are_begun_first_also_in_a_tree_that_knows_only_a_guess(self):
        with tempfile.TemporaryDirectory() as folder:
            path, begun = Path(folder, "log/seconds.json"), []
            parts = {"a": [checks.partial(lambda name: begun.append(name) or checks.Tally(1), name) for name in "xyz"]}
            seconds = remembered.Seconds(path, {"a y": 3, "a": 1})
            self.assertEqual([1, 3, 1, 0], [seconds.expected(name) for name in ("a x", "a y", "a z", "b")])
            with contextlib.redirect_stdout(io.StringIO()):
                checks.run_parts(parts, seconds)
            self.assertEqual({"a x", "a y", "a z"}, set(remembered.Seconds(path, {}).known))
            self.assertEqual("xyz", "".join(sorted(begun)))
            path.write_text('{"a z": 9, "a')  # cut short: as if there were none
            self.assertEqual(3, remembered.Seconds(path, {"a y": 3}).expected("a y"))

    def test_the_shares_of_a_module_are_its_tests_each_once(self):
        module = "import unittest\nclass A(unittest.TestCase):\n" + "".join(f"    def test_{n}(self): print('ran', {n})\n" for n in range(7))
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "test_seven.py").write_text(module)
            ran = [subprocess.run([sys.executable, "-B", checks.ROOT / "tools/support/share.py", share, folder, "test_seven.py"], text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=True).stdout for share in checks.shares(3)]
        self.assertEqual(list("0123456"), sorted(re.findall(r"ran (\d)", "".join(ran))))
        self.assertEqual([3, 2, 2], [text.count("ran ") for text in ran])

    def test_every_job_has_a_name_of_its_own(self):
        names = [checks.named(part, job) for part, (_, jobs) in checks.PARTS.items() for job in jobs]
        self.assertEqual(len(set(names)), len(names))
        for guess in checks.GUESS:
            self.assertTrue(any(guess in (name, name.split()[0]) for name in names), f"no such job: {guess}")

    def test_what_passed_is_asked_again_when_anything_it_reads_has_changed_or_when_it_failed(self):
        with tempfile.TemporaryDirectory() as folder:
            source, header, asked = Path(folder, "a.c"), Path(folder, "a.h"), []
            entry = {"directory": folder, "command": f"gcc -O1 -o a.o -c {source}"}
            passed = remembered.Passed(Path(folder, "cache"))

            def ask(answer, *settings):
                key = remembered.content_key("1.0", entry["command"], *settings, *remembered.compiled_from(entry))
                return passed.check(key, lambda: asked.append(1) or answer)

            source.write_text('#include "a.h"\n#include <stdio.h>\n')
            header.write_text("")
            self.assertEqual({"a.c", "a.h", "stdio.h"}, {path.name for path in remembered.compiled_from(entry)} & {"a.c", "a.h", "stdio.h"})
            self.assertEqual([False, False, True, True], [ask(False), ask(False), ask(True), ask(False)])
            self.assertEqual((3, 1), (len(asked), passed.known))
            with mock.patch.dict("os.environ", DAVAR_AGAIN="1"):
                self.assertFalse(ask(False))
            header.write_text("/* NOLINT */")
            self.assertFalse(ask(False))
            self.assertFalse(ask(False, "-bugprone-*"))
            self.assertEqual(6, len(asked))

    def test_a_suite_is_known_until_its_bytes_change(self):
        """A ctest of four: two that count cases, one that fails, one that reads its environment."""
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "build/log").mkdir(parents=True)
            suites = {"unit/a": "2 Tests 0 Failures 0 Ignored", "unit/b": "3 Tests 0 Failures 0 Ignored", "long/fails": "1 Tests 1 Failures 0 Ignored"}
            lines = ["cmake_minimum_required(VERSION 3.20)", "project(suites NONE)", "enable_testing()"]
            for name, said in suites.items():
                program = root / Path(name).name
                program.write_text(f"#!/bin/sh\necho x >> {program}.asked\necho '{said}'\n")
                program.chmod(0o755)
                lines += [f"add_test(NAME {name} COMMAND {program})", f"set_tests_properties({name} PROPERTIES LABELS {Path(name).parent})"]
            lines += [f"add_test(NAME long/env COMMAND {root / 'a'})", "set_tests_properties(long/env PROPERTIES LABELS long ENVIRONMENT X=1)"]
            (root / "CMakeLists.txt").write_text("\n".join(lines))
            presets = {kind: [{"name": name, "configurePreset": name} for name in ("any", "quick", "coverage")] for kind in ("buildPresets", "testPresets")}
            presets["configurePresets"] = [{"name": name, "generator": "Unix Makefiles", "binaryDir": f"build/{name}"} for name in ("any", "quick", "coverage")]
            (root / "CMakePresets.json").write_text(json.dumps({"version": 3, **presets}))
            with mock.patch.multiple(checks, ROOT=root, BUILD=root / "build", LOGS=root / "build/log", LEFT_OUT={"quick": "long"}):
                first, second = checks.ctest("any"), checks.ctest("any")
                with (root / "b").open("a") as program:
                    program.write("# other bytes\n")
                third, fourth, fifth = checks.ctest("any"), checks.ctest("quick"), checks.ctest("coverage")
            self.assertEqual([(7, 1, 0), (7, 1, 2), (7, 1, 1), (5, 0, 2), (7, 1, 0)],
                             [(one.passed, one.failed, one.known) for one in (first, second, third, fourth, fifth)])
            self.assertEqual([6, 3, 4], [len(Path(root, f"{name}.asked").read_text()) // 2 for name in ("a", "b", "fails")])

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
