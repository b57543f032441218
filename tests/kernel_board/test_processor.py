"""The kernel of the kernel tests starts on every processor. The state that the host needs for each
process is simulated up to the size of the kernel's buffer (AMX: 11008 bytes). A processor that
needs more is reported. Runs on the host. DAVAR_KERNEL: the kernel.
"""

import os
import platform
import subprocess
import tempfile
import unittest
from pathlib import Path

import pytest

pytestmark = pytest.mark.soak

ROOT = Path(__file__).resolve().parents[2]
KERNEL = os.environ.get("DAVAR_KERNEL", "linux")
HERE = Path(__file__).parent
BUFFER = 65536  # host_xstate of tools/support/uml/kernel.patch
OLD_BUFFER, AMX = 2696, 11008


@unittest.skipUnless(platform.machine() == "x86_64", "XSTATE is of x86-64")
class Processor(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        subprocess.run(
            [
                "cc",
                "-O1",
                "-Wall",
                "-Wextra",
                "-Werror",
                "-o",
                self.folder / "wide",
                HERE / "wide_processor.c",
            ],
            check=True,
        )

    def guest(self, size):
        """Runs a command in the guest on a processor with `size` bytes of state; 0: on this one."""
        kernel = self.folder / "kernel"
        wide = f"{self.folder}/wide {size} " if size else ""
        kernel.write_text(f'#!/bin/sh\nexec {wide}{KERNEL} "$@"\n')
        kernel.chmod(0o755)
        return subprocess.run(
            [ROOT / "tools/support/uml/run", "-t", "600", kernel, "echo", "started"],
            text=True,
            capture_output=True,
            check=False,
        )

    def test_this_processor(self):
        done = self.guest(0)
        self.assertEqual((0, "started\n"), (done.returncode, done.stdout), done.stderr)

    def test_processors_up_to_the_size_of_the_buffer(self):
        for size in (OLD_BUFFER, OLD_BUFFER + 8, AMX, BUFFER - 1):
            with self.subTest(size=size):
                done = self.guest(size)
                self.assertEqual((0, "started\n"), (done.returncode, done.stdout), done.stderr)

    def test_a_processor_that_needs_more_is_reported(self):
        for size in (BUFFER, BUFFER + 8):
            with self.subTest(size=size):
                done = self.guest(size)
                self.assertEqual((125, ""), (done.returncode, done.stdout))
                self.assertIn(
                    "The processor's state (XSTATE) does not fit into host_xstate: enlarge it in "
                    "tools/support/uml/kernel.patch",
                    done.stderr,
                )
