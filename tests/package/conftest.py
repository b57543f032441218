"""Builds the source distribution and the wheel of the Python package once in a run, and installs
the wheel outside the checkout. The tests of this folder import davar from there.
"""

import contextlib
import fcntl
import importlib
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import release
import result_cache

ROOT = Path(__file__).resolve().parents[2]
BUILT = ("CMakeLists.txt", "LICENSE", "pyproject.toml", "cmake", "data", "docs/PYTHON.md")
BUILT += ("addons", "host_sim", "lib", "packaging", "port", "python", "tools")
QUICK = "cmake.define.CMAKE_C_FLAGS_RELEASE=-O1 -DNDEBUG"  # the bits are those of -O3


class Wheel(NamedTuple):
    dist: Path  # the folder of the source distribution and the wheel
    site: Path  # the wheel, installed
    davar: Path  # only davar, as in an environment without the extra
    numpy: Path  # only numpy


@contextlib.contextmanager
def locked(path):
    """The workers of a run enter one after the other."""
    with open(path, "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def must_run(*command):
    done = subprocess.run(
        [str(word) for word in command],
        cwd=ROOT,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert done.returncode == 0, done.stdout


def distributions():
    """The folder with both files, made from the present sources."""
    files = [ROOT / name for name in release.tree() if name.startswith(BUILT)]
    cache = ROOT / "build/cache/wheel"
    folder = cache / result_cache.content_key(*files)[:16]
    if not folder.exists():
        shutil.rmtree(cache, ignore_errors=True)
        made = cache / "new"
        must_run(sys.executable, "-m", "build", "--outdir", made, "-C", QUICK, ".")
        made.rename(folder)
    return folder


def install(dist, folder):
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    must_run(*pip, "--no-deps", "--no-index", "--target", folder / "site", *dist.glob("*.whl"))
    (folder / "library").mkdir()
    for path in (folder / "site").glob("davar[!lf]*"):
        (folder / "library" / path.name).symlink_to(path)
    (folder / "library/davar").symlink_to(folder / "site/davar")
    (folder / "numpy").mkdir()
    for path in Path(np.__file__).parents[1].glob("numpy*"):
        (folder / "numpy" / path.name).symlink_to(path)


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.getbasetemp()
    with locked(ROOT / "build/wheel.lock"):
        dist = distributions()
    install(dist, folder)
    return Wheel(dist, folder / "site", folder / "library", folder / "numpy")


@pytest.fixture(scope="module", autouse=True)
def installed(wheel):
    """`import davar` finds the installed package, also if another davar was imported before."""
    others = {
        name: sys.modules.pop(name) for name in list(sys.modules) if name.split(".")[0] == "davar"
    }
    sys.path.insert(0, str(wheel.davar))
    importlib.invalidate_caches()
    try:
        yield importlib.import_module("davar")
    finally:
        sys.path.remove(str(wheel.davar))
        for name in [name for name in sys.modules if name.split(".")[0] == "davar"]:
            del sys.modules[name]
        sys.modules.update(others)


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A new folder, as the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
