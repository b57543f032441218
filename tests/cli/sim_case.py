"""Base of all tests of davar-sim: the program (environment variable DAVAR_SIM), a folder,
recordings.
"""

import csv
import gzip
import io
import os
import random
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ.get("DAVAR_SIM", "davar-sim")
SMALL_WINDOW = ("--window-max", "60", "--window-min", "40", "--segment", "10")


def noise_rows(count, rate_hz=100.0, columns=1, seed=1):
    """Rows of time_s and white noise on a 0.01 deg/s raster, as text fields."""
    source = random.Random(seed)
    return [
        [f"{i / rate_hz:.4f}"]
        + [f"{0.01 * round(source.gauss(5.0, 30.0)):.2f}" for _ in range(columns)]
        for i in range(count)
    ]


def as_text(header, rows):
    return "\n".join([header] + [",".join(row) for row in rows]) + "\n"


class SimCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, content):
        """Writes text or bytes, compressed if the name ends in .gz, and returns the path."""
        path = self.folder / name
        data = content.encode() if isinstance(content, str) else content
        path.write_bytes(gzip.compress(data) if name.endswith(".gz") else data)
        return path

    def recording(self, count=300, name="rec.csv", **details):
        return self.write(name, as_text("time_s,gyro_x_dps", noise_rows(count, **details)))

    def sim(self, *arguments, stdin=None, **keywords):
        """Runs davar-sim; stdin is bytes, the output is text."""
        done = subprocess.run(
            [PROGRAM, *map(str, arguments)],
            input=stdin,
            capture_output=True,
            timeout=600,
            **keywords,
        )
        done.stdout = done.stdout.decode()
        done.stderr = done.stderr.decode(errors="backslashreplace")
        return done

    def results(self, *arguments, **keywords):
        """The rows of a run that must succeed, as dictionaries."""
        done = self.sim(*arguments, **keywords)
        self.assertEqual(0, done.returncode, done.stderr)
        return list(csv.DictReader(io.StringIO(done.stdout)))

    def assert_refused(self, done, *words):
        """Exit status 2, nothing on standard output, one line on standard error with all these
        words.
        """
        self.assertEqual(2, done.returncode, done.stderr)
        self.assertEqual("", done.stdout)
        self.assertEqual(1, done.stderr.count("\n"), done.stderr)
        self.assertTrue(done.stderr.startswith("davar-sim: "), done.stderr)
        for word in words:
            self.assertIn(str(word), done.stderr)
