"""The C suites of lib/, one program each: in the debug build, whose assertions are on. The release
build has those that take seconds (label long), and the properties with more trials.
"""

import json
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"


def programs(preset):
    """(name, command, labels) of every test of a build, from ctest."""
    if not (BUILD / preset / "CTestTestfile.cmake").exists():
        return []
    words = ["ctest", "--test-dir", str(BUILD / preset), "--show-only=json-v1"]
    listed = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    for test in listed["tests"]:
        labels = [one["value"] for one in test["properties"] if one["name"] == "LABELS"]
        yield test["name"], test.get("command", ()), labels[0] if labels else []


def cases():
    for preset in ("debug", "release"):
        for name, command, labels in programs(preset):
            if preset == "debug" and "long" in labels:
                continue  # its numbers do not depend on assertions
            if preset == "release" and not {"long", "property"} & set(labels):
                continue
            name = f"{preset}-{name}"
            marks = [pytest.mark.xdist_group(f"tests/test_library.py::{name}")]
            marks += [pytest.mark.inputs(*command)]
            is_slow = preset == "release" or "slow" in labels
            marks += [pytest.mark.slow] if is_slow else []
            marks += [pytest.mark.soak] if "soak" in labels else []
            yield pytest.param(command, id=name, marks=marks)


@pytest.mark.parametrize("command", list(cases()))
def test_suite(command):
    assert command, "not built"
    done = subprocess.run(command, cwd=ROOT, text=True, errors="replace", capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
