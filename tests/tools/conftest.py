"""The library with its default options, compiled once for all tests of this folder."""

import os
import subprocess

import c_library
import pytest


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    options = ["-std=c11", "-O1", "-ffp-contract=off"]
    options += c_library.FLAGS
    subprocess.run(["gcc", *options, "-c", *c_library.SOURCES], check=True, cwd=folder)
    objects = sorted(path.name for path in folder.glob("*.o"))
    assert len(objects) == len(c_library.SOURCES), "two sources have the same name"
    subprocess.run(["ar", "rcs", "libdavar.a", *objects], check=True, cwd=folder)
    return os.fspath(folder / "libdavar.a")
