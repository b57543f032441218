"""tools/davar-sim behaves like the program: same output, same exit status, the caller's folder."""

import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COMMAND = ROOT / "tools/davar-sim"


def run(*arguments, cwd):
    return subprocess.run([COMMAND, *arguments], cwd=cwd, text=True, capture_output=True)


class DavarSim(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def test_a_relative_path_is_relative_to_the_caller(self):
        rows = "".join(f"{i / 100:.2f},{(i * 7919) % 101 * 0.01:.2f}\n" for i in range(700))
        (self.work / "rec.csv").write_text("time_s,gyro_z_dps\n" + rows)
        done = run(
            "rec.csv", "--lsb", "0.01", "--stride", "100", "--bandwidth", "none", cwd=self.work
        )
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue(done.stdout.startswith("epoch,time_s,window_samples,"), done.stdout)

    def test_an_error_keeps_its_exit_status_and_leaves_standard_output_empty(self):
        done = run("no such file.csv", cwd=self.work)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("no such file.csv", done.stderr)
