"""A draft of a release, and the Python with the packaging tools, each once in a run."""

import fcntl
from pathlib import Path

import packaging_tools
import pytest

ROOT = packaging_tools.ROOT


class Release:
    """The packages of a draft, and their layouts."""

    def __init__(self, folder):
        self.folder, self.layout = folder, folder / "layout"

    def package(self, pattern):
        """The only file of the release with this name."""
        (found,) = self.folder.glob(pattern)
        return found


@pytest.fixture(scope="session")
def draft(tmp_path_factory):
    """Workers of one run share it."""
    folder = tmp_path_factory.getbasetemp()
    if "popen-gw" in folder.name:
        folder = folder.parent
    with open(folder / "release.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "release").exists():
            packaging_tools.run(
                ROOT / "tools/release", "--draft", "--out", folder / "release", DAVAR_BUILT=""
            )
    return Release(folder / "release")


@pytest.fixture(scope="session")
def tools():
    """The folder with pio, conan and python; only tools/soak needs it."""
    words = "python_environment venv-packages tools/support/requirements-packages.txt"
    said = packaging_tools.run(
        "bash", "-c", f". tools/support/setup.sh && {words}", folder=ROOT
    ).splitlines()
    return Path(said[-1]).parent
