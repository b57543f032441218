"""What the tests of the lab share: the usual model and its noise (flicker: elsewhere.py; or as
davarlab simulates it), recordings and CSV files from columns, a folder to run commands in."""

import numpy as np
from asking import run, said
from davarlab import simulate
from davarlab.data.recording import Recording
from davarlab.model import Model, Term
from elsewhere import flicker_fft as flicker

BASE = """[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 0.3
[[effect]]
kind = "bias_instability"
coefficient_deg_per_h = 5.0
"""
SENSOR = '[sensor]\nrate_hz = 50.0\ncolumn = "gyro_z_dps"\n'
FLEET = SENSOR.replace("50.0", "20.0") + BASE.replace("0.3", "0.35").replace("5.0", "8.0")


def terms(n=0.3, b=5.0):
    return [
        Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": n}),
        Term("bias_instability", {"coefficient_deg_per_h": b}),
    ]


def model(rate_hz=50.0, n=0.3, b=5.0, column="gyro_z_dps"):
    return Model(rate_hz, column, terms(n, b))


def noise(count, rate_hz, rng, n=0.3, b=5.0):
    """White noise and flicker of a gyro, deg/s; n: deg/sqrt(h), b: deg/h."""
    slow = flicker(count, b / 3600, rng, 2)
    return n / 60 * rate_hz**0.5 * rng.standard_normal(count) + slow


def simulated(*more, seed=3, seconds=3600.0, rate_hz=50.0):
    """davarlab's own simulation of the usual noise and of more terms: (kind, parameters)."""
    made = [*terms(), *(Term(kind, values) for kind, values in more)]
    return simulate.make(made, rate_hz, seed=seed, duration_s=seconds)


def beside_a_line(seed):
    """(recording, model): white noise, flicker and a strong band at 0.5 Hz, with what makes
    them."""
    more = "narrow_band", {"std_dps": 0.02, "frequency_hz": 0.5, "half_width_hz": 0.01}
    made = Model(50.0, "gyro_z_dps", [*terms(), Term(*more)])
    return simulated(more, seed=seed, seconds=1200.0), made


def of_gyro(y, rate_hz=50.0):
    return Recording({"time_s": np.arange(len(y)) / rate_hz, "gyro_z_dps": y}, rate_hz)


def write_csv(path, columns, form="%.9g"):
    """Columns by name; form: one for all, or one of each column."""
    np.savetxt(
        path,
        np.column_stack(list(columns.values())),
        fmt=form,
        delimiter=",",
        header=",".join(columns),
        comments="",
    )
    return path


class Lab:
    """A folder and commands in it."""

    def __init__(self, work):
        self.work = work
        self.model = self.file("model.toml", SENSOR + BASE)

    def file(self, name, text):
        (self.work / name).write_text(text)
        return self.work / name

    def contents(self):
        return {path: path.read_bytes() for path in self.work.iterdir() if path.is_file()}

    def simulated(self, effect="", seed=3, seconds=3600, options=()):
        text = f"{SENSOR}[simulate]\nseed = {seed}\nduration_s = {seconds}\n{BASE}{effect}"
        recording = self.work / "rec.csv"
        done = run("simulate", self.file("scenario.toml", text), "-o", recording, *options)
        assert done.returncode == 0, done.stderr
        return recording

    def diagnosed(self, recording, *options):
        return said("diagnose", recording, "-m", self.model, *options)

    def refused(self, words, *arguments, lines=1):
        """Status 2, the words in the last line, nothing on standard output and nothing written."""
        before = self.contents()
        done = run(*arguments)
        assert (done.returncode, done.stdout) == (2, ""), done.stderr
        printed = done.stderr.splitlines()
        assert lines is None or len(printed) == lines, done.stderr
        assert all(line.startswith("davarlab: ") for line in printed), done.stderr
        assert words in printed[-1], done.stderr
        assert self.contents() == before
        return done.stderr
