"""Tests of tools/test: parts run in parallel, each is printed in one piece, and a shared
requirement is built once.
"""

import contextlib
import io
import json
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import c_suites
import checks
import mcdc_report
import result_cache
import runner
from python_suites import shares
from runner import Tally


def printed(parts):
    """(total, lines) of a run of {name: jobs}."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        total = runner.run_parts(parts)
    return total, text.getvalue().splitlines()


def breaks():
    raise runner.Broken("no compiler\nat all")


class Mcdc(unittest.TestCase):
    def missing(self, line, *covered):
        """What the report lists for one decision, all of `line`, with these conditions."""
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder, "lib/a.c")
            source.parent.mkdir()
            source.write_text(line + "\n")
            record = [1, 1, 1, len(line) + 1, 0, 0, 0, list(covered)]
            files = [{"filename": str(source), "mcdc_records": [record]}]
            return mcdc_report.missing(json.dumps({"data": [{"files": files}]}), Path(folder))

    def test_a_condition_that_no_test_turned_is_listed(self):
        counted, listed = self.missing("(DAVAR_GRID && a) || (b > c)", False, True, False)
        self.assertEqual(listed, ["lib/a.c: C3 never turned: (DAVAR_GRID && a) || (b > c)"])
        self.assertIn("1 of 2 conditions", counted)

    def test_only_a_constant_of_the_build_is_left_out(self):
        self.assertEqual(self.missing("!DAVAR_Q15 || a", False, True)[1], [])
        self.assertEqual(len(self.missing("davar_is(DAVAR_Q15) || a", False, True)[1]), 1)

    def test_nothing_is_left_out_of_a_decision_that_is_not_understood(self):
        self.assertEqual(len(self.missing("DAVAR_Q15 || is(a && b)", False, True)[1]), 1)

    def test_a_report_without_decisions_fails(self):
        report = json.dumps({"data": [{"files": []}]})
        self.assertEqual(len(mcdc_report.missing(report, Path("/"))[1]), 1)


class Parts(unittest.TestCase):
    def test_at_least_as_many_jobs_run_at_once_as_there_are_cores(self):
        cores = int(runner.JOBS)
        meeting = threading.Barrier(cores)

        def job():
            meeting.wait(timeout=600)
            return Tally(1)

        total, _ = printed({"a": [job] * cores})
        self.assertEqual((cores, 0), (total.passed, total.failed), total.lines)

    def test_a_part_that_fails_stops_no_other_and_its_text_is_in_one_piece(self):
        crash = {}
        total, lines = printed(
            {
                "a": [breaks, lambda: Tally(2), breaks],
                "b": [lambda: crash["it"]],
                "c": [lambda: Tally(3, skipped=1, lines=["skipped: one"])] * 2,
            }
        )
        self.assertEqual((8, 3, 2), (total.passed, total.failed, total.skipped))
        at = next(n for n, line in enumerate(lines) if line.startswith("a "))
        self.assertRegex(lines[at], r"^a +2 passed, 2 failed, 0 skipped  \(0 s\)$")
        self.assertEqual(["    no compiler", "    at all"], lines[at + 1 : at + 3])
        self.assertEqual(1, lines.count("    no compiler"), "the same failure is printed once")
        self.assertIn("    KeyError: 'it'", lines)

    def test_the_longest_jobs_start_first_also_without_measured_times(self):
        with tempfile.TemporaryDirectory() as folder:
            path, begun = Path(folder, "log/seconds.json"), []
            parts = {
                "a": [partial(lambda name: begun.append(name) or Tally(1), name) for name in "xyz"]
            }
            times = runner.JobTimes(path, {"a y": 3, "a": 1})
            self.assertEqual(
                [1, 3, 1, 0], [times.expected(name) for name in ("a x", "a y", "a z", "b")]
            )
            with contextlib.redirect_stdout(io.StringIO()):
                runner.run_parts(parts, times)
            self.assertEqual({"a x", "a y", "a z"}, set(runner.JobTimes(path, {}).measured))
            self.assertEqual("xyz", "".join(sorted(begun)))
            path.write_text('{"a z": 9, "a')  # truncated: treated as empty
            self.assertEqual(3, runner.JobTimes(path, {"a y": 3}).expected("a y"))

    def test_the_shares_of_a_module_are_its_tests_each_once(self):
        module = "import unittest\nclass A(unittest.TestCase):\n" + "".join(
            f"    def test_{n}(self): print('ran', {n})\n" for n in range(7)
        )
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "test_seven.py").write_text(module)
            ran = [
                subprocess.run(
                    [
                        sys.executable,
                        "-B",
                        runner.ROOT / "tools/support/share.py",
                        share,
                        folder,
                        "test_seven.py",
                    ],
                    text=True,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    check=True,
                ).stdout
                for share in shares(3)
            ]
        self.assertEqual(list("0123456"), sorted(re.findall(r"ran (\d)", "".join(ran))))
        self.assertEqual([3, 2, 2], [text.count("ran ") for text in ran])

    def test_every_job_has_a_name_of_its_own(self):
        names = [
            runner.named(name, job) for name, part in checks.PARTS.items() for job in part.jobs
        ]
        self.assertEqual(len(set(names)), len(names))
        for typical in checks.TYPICAL:
            self.assertTrue(
                any(typical in (name, name.split()[0]) for name in names), f"no such job: {typical}"
            )

    def test_the_quick_gear_is_a_choice_of_what_all_runs(self):
        quick, installed = checks.chosen(SimpleNamespace(all=False, only=""))
        everything, all_packages = checks.chosen(SimpleNamespace(all=True, only=""))
        self.assertEqual(list(checks.PARTS), list(everything))
        self.assertLessEqual(set(quick), set(everything))
        self.assertLess(set(installed), set(all_packages))
        for name, jobs in quick.items():
            for job in jobs:
                modules = [
                    other.args[:4] for other in everything[name] if isinstance(other, partial)
                ]
                self.assertTrue(job in everything[name] or job.args[:4] in modules, job)
        only, _ = checks.chosen(SimpleNamespace(all=False, only="lab"))
        self.assertEqual({"lab": checks.PARTS["lab"].jobs}, only)

    def test_a_cached_result_is_dropped_when_anything_that_it_reads_has_changed(self):
        with tempfile.TemporaryDirectory() as folder:
            source, header, ran = Path(folder, "a.c"), Path(folder, "a.h"), []
            entry = {"directory": folder, "command": f"gcc -O1 -o a.o -c {source}"}
            cache = result_cache.ResultCache(Path(folder, "cache"))

            def check(result, *settings):
                key = result_cache.content_key(
                    "1.0", entry["command"], *settings, *result_cache.compiled_from(entry)
                )
                return cache.check(key, lambda: ran.append(1) or result)

            source.write_text('#include "a.h"\n#include <stdio.h>\n')
            header.write_text("")
            self.assertEqual(
                {"a.c", "a.h", "stdio.h"},
                {path.name for path in result_cache.compiled_from(entry)}
                & {"a.c", "a.h", "stdio.h"},
            )
            self.assertEqual(
                [False, False, True, True], [check(False), check(False), check(True), check(False)]
            )
            self.assertEqual((3, 1), (len(ran), cache.hits))
            with mock.patch.dict("os.environ", DAVAR_AGAIN="1"):
                self.assertFalse(check(False))
            header.write_text("/* NOLINT */")
            self.assertFalse(check(False))
            self.assertFalse(check(False, "-bugprone-*"))
            self.assertEqual(6, len(ran))

    def test_the_result_of_a_suite_is_cached_until_its_bytes_change(self):
        """Four tests of ctest: two that count cases, one that fails and one that reads its
        environment.
        """
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "build/log").mkdir(parents=True)
            suites = {
                "unit/a": "2 Tests 0 Failures 0 Ignored",
                "unit/b": "3 Tests 0 Failures 0 Ignored",
                "long/fails": "1 Tests 1 Failures 0 Ignored",
            }
            lines = [
                "cmake_minimum_required(VERSION 3.20)",
                "project(suites NONE)",
                "enable_testing()",
            ]
            for name, summary in suites.items():
                program = root / Path(name).name
                program.write_text(f"#!/bin/sh\necho x >> {program}.runs\necho '{summary}'\n")
                program.chmod(0o755)
                lines += [
                    f"add_test(NAME {name} COMMAND {program})",
                    f"set_tests_properties({name} PROPERTIES LABELS {Path(name).parent})",
                ]
            lines += [
                f"add_test(NAME long/env COMMAND {root / 'a'})",
                "set_tests_properties(long/env PROPERTIES LABELS long ENVIRONMENT X=1)",
            ]
            (root / "CMakeLists.txt").write_text("\n".join(lines))
            presets = {
                kind: [
                    {"name": name, "configurePreset": name} for name in ("any", "quick", "coverage")
                ]
                for kind in ("buildPresets", "testPresets")
            }
            presets["configurePresets"] = [
                {"name": name, "generator": "Unix Makefiles", "binaryDir": f"build/{name}"}
                for name in ("any", "quick", "coverage")
            ]
            (root / "CMakePresets.json").write_text(json.dumps({"version": 3, **presets}))
            places = {"ROOT": root, "BUILD": root / "build", "LOGS": root / "build/log"}
            with (
                mock.patch.multiple(runner, **places),
                mock.patch.multiple(c_suites, LEFT_OUT={"quick": "long"}, **places),
            ):
                first, second = c_suites.ctest("any"), c_suites.ctest("any")
                with (root / "b").open("a") as program:
                    program.write("# other bytes\n")
                third, fourth, fifth = (
                    c_suites.ctest("any"),
                    c_suites.ctest("quick"),
                    c_suites.ctest("coverage"),
                )
            self.assertEqual(
                [(7, 1, 0), (7, 1, 2), (7, 1, 1), (5, 0, 2), (7, 1, 0)],
                [
                    (one.passed, one.failed, one.cached)
                    for one in (first, second, third, fourth, fifth)
                ],
            )
            self.assertEqual(
                [6, 3, 4],
                [len(Path(root, f"{name}.runs").read_text()) // 2 for name in ("a", "b", "fails")],
            )

    def test_a_job_that_resumes_goes_before_new_ones(self):
        slots, order = runner.Slots(1), []

        def work(name, resumes):
            slots.take(resumes)
            order.append(name)
            slots.give()

        slots.take()
        threads = []
        for name, resumes in (("first", False), ("second", False), ("resumed", True)):
            threads.append(threading.Thread(target=work, args=(name, resumes)))
            threads[-1].start()
            while len(slots.waiting) < len(threads):
                time.sleep(0.001)
        slots.give()
        for thread in threads:
            thread.join()
        self.assertEqual(["resumed", "first", "second"], order)

    def test_a_shared_requirement_is_made_once_and_its_failure_fails_both_parts(self):
        made = []

        @runner.once
        def build(preset):
            made.append(preset)
            if preset == "broken":
                breaks()
            return Tally(1)

        total, _ = printed(
            {name: [lambda: build("good"), lambda: build("broken")] for name in "abc"}
        )
        self.assertEqual((3, 3, ["broken", "good"]), (total.passed, total.failed, sorted(made)))


if __name__ == "__main__":
    unittest.main()
