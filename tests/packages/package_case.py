"""Shared by the tests of the packages: the release that tools/test has made, a folder to work in,
commands that must succeed.
"""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "tests/packages"
CONSUMER = ROOT / "tests/consumer/consumer.c"
SAYS = r"^davar \d+\.\d+\.\d+ epoch 99 window 60\n$"  # printed by the consumer
RELEASE = Path(os.environ["DAVAR_RELEASE"])
TOOLS = Path(sys.executable).parent  # pio, conan, compote


def run(*command, folder=None, status=0, **variables):
    """The output of a command that must end with this status; a failure shows all of it."""
    done = subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env={**os.environ, **variables},
    )
    assert done.returncode == status, (
        f"{' '.join(map(str, command))}: exit status {done.returncode}\n{done.stdout}"
    )
    return done.stdout


def build(source, binary, *settings):
    run("cmake", "-S", source, "-B", binary, *settings)
    run("cmake", "--build", binary)


def package(pattern):
    """The only file of the release with this name."""
    found = list(RELEASE.glob(pattern))
    assert len(found) == 1, f"{pattern}: {found}"
    return found[0]


class PackageCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)
