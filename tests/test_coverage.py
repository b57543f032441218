"""One build with everything that a compiler can observe: the C suites and davar-sim run under the
address and undefined-behaviour sanitizers, and every line, branch and condition of lib/ must have
been decided (MC/DC), except those in coverage_exceptions.txt.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build/instrumented"
COVERED = ("lib/", "addons/")
# Assertions are off in this build. The program that has them on compiles lib/ differently.
NOT_COUNTED = ("test_assert",)
# A macro, perhaps compared with a number. Empty: the text of a macro, expanded.
CONSTANT = re.compile(r"(!?(DAVAR|NUMBER)_[A-Z0-9_]+( == \d+U?)?)?")


def run(*words, **variables):
    done = subprocess.run(
        [*map(str, words)],
        cwd=ROOT,
        text=True,
        errors="replace",
        capture_output=True,
        env={**os.environ, **variables},
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-20_000:]
    return done.stdout


def exceptions():
    """{(file, source line)} of coverage_exceptions.txt, whose lines are file | line | reason."""
    rows = [
        [field.strip() for field in line.split(" | ")]
        for line in (ROOT / "tests/coverage_exceptions.txt").read_text().splitlines()
        if line and not line.startswith("#")
    ]
    assert all(len(row) == 3 for row in rows)
    return {(name, source) for name, source, _ in rows}


@pytest.fixture(scope="module")
def suites():
    """Runs every suite that takes no seconds, and keeps a profile of each program."""
    profiles = BUILD / "profiles"
    shutil.rmtree(profiles, ignore_errors=True)
    words = ["ctest", "--test-dir", BUILD, "--label-exclude", "long", "--output-on-failure"]
    return run(*words, "--parallel", 2, LLVM_PROFILE_FILE=str(profiles / "%m.profraw"))


class Report:
    """What llvm-cov reports for the files in COVERED, with all programs added up."""

    def __init__(self, text):
        self.sources, self.found = {}, defaultdict(lambda: defaultdict(list))
        for entry in json.loads(text)["data"][0]["files"]:
            path = Path(entry["filename"])
            name = os.path.relpath(path, ROOT)
            if name.startswith(COVERED):
                self.sources[name] = path.read_text().splitlines()
                self.add(name, entry)

    def add(self, name, entry):
        for line, _, count, counted, entered, gap in entry["segments"]:
            if counted and entered and not gap:
                self.found["region"][name, line, 0, line, 999].append([count > 0])
        for first, column, last, end, taken, not_taken, *_ in entry["branches"]:
            place = name, first, column, last, end
            self.found["branch"][place].append([taken > 0, not_taken > 0])
        for first, column, last, end, *_, covered in entry.get("mcdc_records", []):
            self.found["condition"][name, first, column, last, end].append(covered)

    def line(self, name, number):
        """The source line by which an exception names a place: of a function, its declaration."""
        above, line = self.sources[name][number - 2 : number]
        return (above if line == "{" else line).strip()

    def text(self, name, first, column, last, end):
        lines = self.sources[name][first - 1 : last]
        lines[-1] = lines[-1][: end - 1]
        lines[0] = lines[0][max(column - 1, 0) :]
        return " ".join(" ".join(lines).split())

    def missing(self, what):
        """(how many outcomes there are, those that no program had)."""
        excepted, count, wrong = exceptions(), 0, []
        for place, seen in sorted(self.found[what].items()):
            text, outcomes = self.text(*place), [any(one) for one in zip(*seen)]
            source = self.line(place[0], place[1])
            constants = constants_of(text, what, len(outcomes))
            count += len(outcomes) - len(constants)
            if (place[0], source) not in excepted:
                wrong += [
                    f"{place[0]}:{place[1]}: {what} {number + 1} of {text}"
                    for number, had in enumerate(outcomes)
                    if not had and number not in constants
                ]
        assert count, f"the report has no {what}"
        return count, wrong


def constants_of(text, what, outcomes):
    """The outcomes that a constant of the build decides (DAVAR_LAWS): no test can turn them."""
    parts = [part.strip(" ()") for part in re.split(r"&&|\|\|", text)]
    fixed = [CONSTANT.fullmatch(part) is not None for part in parts]
    if what == "branch":
        return set(range(outcomes)) if fixed == [True] else set()
    return {i for i, one in enumerate(fixed) if one} if len(parts) == outcomes else set()


@pytest.fixture(scope="module")
def report(suites):
    programs = [
        path
        for path in sorted((BUILD / "tests").glob("test_*"))
        if path.is_file() and os.access(path, os.X_OK) and path.name not in NOT_COUNTED
    ]
    profile = BUILD / "profile"
    run("llvm-profdata-19", "merge", "-o", profile, *sorted(BUILD.glob("profiles/*.profraw")))
    objects = [f"-object={path}" for path in programs]
    return Report(run("llvm-cov-19", "export", f"-instr-profile={profile}", *objects))


@pytest.mark.parametrize("what", ["region", "branch", "condition"])
def test_every_outcome_was_seen(report, what):
    count, wrong = report.missing(what)
    print(f"lib/: {count - len(wrong)} of {count} outcomes of kind {what}")
    assert not wrong, "\n".join(wrong)


def test_davar_sim_under_the_sanitizers():
    """Everything of tests/cli again, with the instrumented program."""
    words = [sys.executable, "-m", "pytest", "-q", "--gear=quick", ROOT / "tests/cli"]
    run(
        *words,
        DAVAR_SIM=str(BUILD / "host_sim/davar-sim"),
        LLVM_PROFILE_FILE="/dev/null",
        PYTEST_XDIST_WORKER="",
    )
