"""tools/test leaves out a test only if its result cannot have changed: the inputs that a part
declares in tests/parts.toml are complete, and a change of one repeats its tests.
"""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = tomllib.loads((ROOT / "tests/parts.toml").read_text())
EVERYWHERE = ["tests/conftest.py", "tests/parts.toml", "pyproject.toml", "LICENSE"]
EVERYWHERE += [f"tools/requirements-{name}.txt" for name in ("lab", "test")]
# In --all a quick one; tools/soak proves the others.
PROVED_EACH_TIME = ("readers",)
pytestmark = pytest.mark.slow


def copied(folder, names):
    for name in names:
        source, target = ROOT / name, folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "build", ".git")
            shutil.copytree(source, target, ignore=ignored, dirs_exist_ok=True)
        else:
            shutil.copy2(source, target)


def run(folder, *words):
    """pytest in another tree, as a person would start it there."""
    outside = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("DAVAR_", "PYTEST_")) and name != "PYTHONPATH"
    }
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:hypothesispytest", "-q", *words],
        cwd=folder,
        env=outside | {"DAVAR_BUILT": "1"},
        text=True,
        capture_output=True,
    )


def whole_inputs():
    for name, part in PARTS.items():
        if (ROOT / "tests" / name).is_dir() and "." not in part["inputs"]:
            marks = [] if name in PROVED_EACH_TIME else [pytest.mark.soak]
            yield pytest.param(name, marks=marks)


@pytest.mark.parametrize("part", list(whole_inputs()))
def test_a_part_passes_where_only_its_inputs_exist(part, tmp_path):
    copied(tmp_path, [*EVERYWHERE, f"tests/{part}", *PARTS[part]["inputs"]])
    (tmp_path / "build").symlink_to(ROOT / "build")
    done = run(tmp_path, "--gear=all", f"tests/{part}")
    assert done.returncode == 0, done.stdout[-8000:]


@pytest.fixture
def small(tmp_path):
    """A tree with one part, whose two tests read one file."""
    copied(tmp_path, ["tests/conftest.py", "pyproject.toml"])
    (tmp_path / "tests/small").mkdir()
    (tmp_path / "tests/parts.toml").write_text('[small]\nfinds = "a fault"\ninputs = ["number"]\n')
    (tmp_path / "number").write_text("1")
    (tmp_path / "tests/small/test_small.py").write_text(
        "import pathlib\nimport pytest\n\n"
        "def test_number():\n    assert int(pathlib.Path('number').read_text()) < 3\n\n"
        "@pytest.mark.slow\ndef test_slow():\n    pass\n\n"
        "@pytest.mark.soak\ndef test_soak():\n    pass\n"
    )
    return tmp_path


@pytest.mark.parametrize("words", [(), ("-n2", "--dist=loadgroup")])
def test_only_a_change_repeats_a_test_that_passed(small, words):
    first, second = run(small, *words), run(small, *words)
    assert "2 passed" in first.stdout and "2 unchanged" in second.stdout, second.stdout
    assert (first.returncode, second.returncode) == (0, 0)
    (small / "number").write_text("3")
    for _ in range(2):  # a failure is repeated until it passes
        failing = run(small, *words)
        assert failing.returncode == 1 and "1 failed" in failing.stdout
    (small / "number").write_text("1")
    assert "2 unchanged" in run(small, *words).stdout
