"""The library with its default options, compiled once for all tests of this folder."""

import os
import subprocess

import pytest
from planner_case import ROOT


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    sources = sorted((ROOT / "lib/src").rglob("*.c"))
    options = ["-std=c11", "-O1", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections"]
    options += [f"-I{ROOT / place}" for place in ("lib/include", "lib/src")]
    subprocess.run(["gcc", *options, "-c", *sources], check=True, cwd=folder)
    objects = sorted(path.name for path in folder.glob("*.o"))
    assert len(objects) == len(sources), "two sources have the same name"
    subprocess.run(["ar", "rcs", "libdavar.a", *objects], check=True, cwd=folder)
    return os.fspath(folder / "libdavar.a")
