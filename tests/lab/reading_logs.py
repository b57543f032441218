"""What the tests of logs share: a folder with the log of a known gyro and what import makes of it,
and a short text of one."""

import csv

import numpy as np
import writing_logs as writing
from asking import run
from lab_bench import Lab

SINGLE = 2e-7  # relative, of float32 and of nine digits


COUNT = 1200
RATE_HZ = 100
RNG = np.random.default_rng(20)
GYRO = np.round(RNG.normal(0, 0.3, (COUNT, 3)), 5)
FORCE = np.round(RNG.normal([0.02, -0.03, 1.0], 0.004, (COUNT, 3)), 5)
TEMP = np.round(25 + np.arange(COUNT) / 1000, 3)
TIME = np.arange(COUNT) / RATE_HZ
OWN = "gyro_x_dps,gyro_y_dps,gyro_z_dps"
US = np.arange(COUNT) * (1_000_000 // RATE_HZ)
MS, NS = np.arange(COUNT) * 10, np.arange(COUNT) * 10_000_000
RADIANS = np.round(np.radians(GYRO), 9)
MPS2 = np.round(FORCE * 9.80665, 6)
OTHER = np.round(RNG.normal(0.3, 0.2, (COUNT, 3)), 5)  # no gyro
STEPS = np.arange(COUNT)
NAMES = "t,gx_dps,gy_dps,gz_dps\n"


def rows(*columns, separator=",", end=""):
    """Text of columns of numbers or text, of one length."""
    return "".join(
        separator.join(one if isinstance(one, str) else f"{one:.10g}" for one in row) + end + "\n"
        for row in zip(*(column.tolist() for column in map(np.asarray, columns)))
    )


def stamped_rows(separator, *columns):
    """Text of columns of words, of whole numbers or of ten digits."""
    return rows(*([str(one) for one in column] for column in columns), separator=separator)


def plain(separator=",", end=""):
    return rows(TIME, *GYRO.T, separator=separator, end=end)


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

    def check_gyro(self, columns, atol=1e-6, first=0, time=True):
        for axis, name in enumerate("xyz"):
            rates = np.float64(columns[f"gyro_{name}_dps"])
            np.testing.assert_allclose(rates, GYRO[first:, axis], atol=atol, err_msg=name)
        if time:
            stamps = np.float64(columns["time_s"])
            np.testing.assert_allclose(stamps - stamps[0], TIME[: COUNT - first], atol=1e-9)

    def said(self, log, *options):
        return run("import", log, "-o", self.out, *options).stderr

    def proposed(self, log):
        """The --names that a refusal says to type."""
        return self.said(log).split("--names ")[1].split()[0]
