"""Base of the tests of tools/davar-plan from wishes: the command, and the files of a plan."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
KEYS = (
    "flash_bytes",
    "ram_bytes",
    "stack_bytes",
    "worst_push_instructions",
    "mean_instructions",
    "defines",
    "arw_percent",
    "respond_s",
    "taus_s",
)
# The example of issue 34: it once took a dozen builds to fit it.
EXAMPLE = (
    "--rate 1000 --axes 3 --type int16 --lsb 0.061 --bandwidth 250:2 --respond 2 "
    "--longest-tau 1000 --ram 20k --flash 24k --core cortex-m4f"
)
WISHES = (
    EXAMPLE,
    EXAMPLE.replace("--flash 24k", ""),
    "--sensor icm42688@1000 --axes 3 --core cortex-m0",
    "--rate 100 --lsb 0.05 --bandwidth 33:2 --core cortex-m0",
    "--rate 100 --lsb 0.05 --core rv32imac --false-alarms-per-hour 0.01 --bandwidth none",
    "--rate 500 --type int32 --lsb 1e-4 --bandwidth 100 --core cortex-m7 --longest-tau 3600",
    "--rate 200 --type float --full-scale 500 --bandwidth 50:1 --core rv64gc --respond 0.5",
)


def command(words):
    return subprocess.run(
        [ROOT / "tools/davar-plan", *words], text=True, capture_output=True, check=False
    )


class Planned(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def planned(self, words):
        """The plan as JSON, with its files in self.work / "setup"."""
        done = command([*words.split(), "-o", str(self.work / "setup"), "--json"])
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        return json.loads(done.stdout)

    def gcc(self, *options):
        return subprocess.run(
            ["gcc", "-std=c11", "-I", ROOT / "lib/include", "-I", ROOT / "lib/src", *options],
            text=True,
            capture_output=True,
            check=False,
            cwd=self.work,
        )

    def run_setup(self, program, words, *options):
        """The lines that a program of this folder prints; the files of the plan are part of it."""
        done = self.gcc(
            "-O2",
            "@setup/davar_setup.args",
            "-I",
            "setup",
            *options,
            ROOT / "tests/tools" / program,
            "setup/davar_setup.c",
            *sorted((ROOT / "lib/src").rglob("*.c")),
            "-lm",
            "-o",
            "run",
        )
        self.assertEqual(0, done.returncode, done.stderr)
        return subprocess.run(
            [self.work / "run", *map(str, words)], text=True, capture_output=True, check=True
        ).stdout.splitlines()
