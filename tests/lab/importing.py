"""Logs of other programs, imported: shared by test_logs.py and test_dialects.py."""

import csv

import numpy as np
import writing_logs as writing
from asking import run
from lab_bench import Lab

SINGLE = 2e-7  # relative, of float32 and of nine digits


class Logs(Lab):
    """A folder with the log of a known gyro, and what import makes of it."""

    def __init__(self, work):
        super().__init__(work)
        self.out = self.work / "out.csv"
        self.truth = writing.Truth()

    def imported(self, log, *options):
        """(notes, name -> values as text) of the recording that import writes."""
        done = run("import", log, "-o", self.out, *options)
        assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
        lines = self.out.read_text().splitlines()
        notes = [line for line in lines if line.startswith("#")]
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
        return notes, dict(zip(rows[0], zip(*rows[1:])))

    def rejected(self, log, *said, options=()):
        """Exit status 2, one line with all that is said, nothing left behind."""
        self.out.unlink(missing_ok=True)
        line = self.refused(said[0], "import", log, "-o", self.out, *options)
        assert all(words in line for words in said), line
        assert not self.out.exists()

    def check(self, columns, gyro=1.0, accel=True, temp=True, first=0):
        for axis, name in enumerate("xyz"):
            rates = np.float64(columns[f"gyro_{name}_dps"])
            np.testing.assert_allclose(rates, self.truth.gyro[axis] * gyro, rtol=SINGLE, atol=1e-8)
            if accel:
                forces = np.float64(columns[f"accel_{name}_g"])[first::2]
                true = self.truth.accel[axis][first::2]
                np.testing.assert_allclose(forces, true, rtol=SINGLE, atol=1e-7)
        if temp:  # after its last stamp it is held
            np.testing.assert_allclose(np.float64(columns["temp_degC"]), self.truth.temp, atol=0.12)

    def check_stamps(self, columns, ns):
        whole = [
            int(second) * 10**9 + int(part.ljust(9, "0") or 0)
            for second, _, part in (text.partition(".") for text in columns["time_s"])
        ]
        assert whole == [int(one) for one in ns]
