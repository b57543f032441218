"""The CSV files of davar-sim and davarlab import in pandas, and by PlotJuggler's rules: a column
has the type of its first value. PlotJuggler itself does not run here: `plotjuggler` follows
plotjuggler_plugins/DataLoadCSV of its repository (commit 0a7615bd).
"""

import contextlib
import csv
import io
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lab"))

import asking
import numpy as np
import pandas

DEMO = asking.ROOT / "data/demo_disturbance.csv.gz"
CONVERT = (
    'pandas.read_csv("arw.csv", comment="#").to_csv("plot.csv", index=False, float_format="%.12f")'
)


def plotjuggler(text):
    """Name -> "number", "epoch" (decimals are lost) or "text", from the first value of each column
    that has one.
    """
    rows = csv.DictReader(io.StringIO(text))
    types = {}
    for row in rows:
        for name, value in row.items():
            if value and name not in types:
                number = re.fullmatch(r"[-+]?[\d.,]+", value)
                whole = number and "." not in value and 1.4e9 < int(value) < 2e9
                types[name] = "text" if not number else "epoch" if whole else "number"
    return types


class Csv(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        command = [os.environ["DAVAR_SIM"], DEMO, "--column", "gyro_z_dps", "--lsb", "0.001"]
        cls.results = subprocess.run(
            [*command, "--stride", "100", "--details"],
            stdout=subprocess.PIPE,
            check=True,
            text=True,
        ).stdout
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder, "out.csv")
            done = asking.run("import", DEMO, "-o", out)
            assert done.returncode == 0, done.stderr
            cls.recording = out.read_text()

    def check_numbers(self, text):
        """pandas gives every number as it is written, and an empty field as NaN."""
        found = pandas.read_csv(io.StringIO(text), comment="#")
        lines = [line for line in text.splitlines() if not line.startswith("#")]
        rows = [[float(value or "nan") for value in row] for row in csv.reader(lines[1:])]
        self.assertEqual(lines[0].split(","), list(found.columns))
        self.assertTrue(all(kind.kind in "iufb" for kind in found.dtypes), found.dtypes)
        np.testing.assert_allclose(found.to_numpy(float), np.array(rows), rtol=1e-15)

    def test_pandas_reads_every_column_as_numbers(self):
        self.check_numbers(self.results)
        self.check_numbers(self.recording)

    def test_plotjuggler_reads_what_the_command_of_the_page_writes(self):
        self.assertIn(CONVERT, (asking.ROOT / "docs/RECORDINGS.md").read_text())
        page = "time_s,arw\n1700000000,3e-05\n1700000000.01,0.5\n"
        self.assertEqual({"time_s": "epoch", "arw": "text"}, plotjuggler(page))
        for text in (self.results, self.recording, page):
            with tempfile.TemporaryDirectory() as folder:
                Path(folder, "arw.csv").write_text(text)
                with contextlib.chdir(folder):
                    eval(CONVERT)
                plot = Path(folder, "plot.csv").read_text()
            types = plotjuggler(plot)
            self.assertEqual({"number"}, set(types.values()), types)
            self.check_close(text, plot)

    def check_close(self, text, plot):
        """Twelve decimals."""
        before, after = (
            pandas.read_csv(io.StringIO(one), comment="#").to_numpy(float) for one in (text, plot)
        )
        np.testing.assert_allclose(after, before, rtol=1e-15, atol=6e-13)


if __name__ == "__main__":
    unittest.main()
