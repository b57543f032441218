"""One recording in the making, and what is true of it."""

from dataclasses import dataclass, field

import numpy as np
from elsewhere import DEG, flicker_fft, flicker_kasdin, flicker_sum
from scipy import signal

RATE, SECONDS = 100.0, 3600.0
N, B = 0.3, 5.0  # ARW deg/sqrt(h), BI deg/h


@dataclass
class Truth:
    kinds: dict = field(
        default_factory=dict
    )  # kind -> its true parameters, for the coverage of intervals
    groups: list = field(
        default_factory=list
    )  # of each group one kind must be named: names of the same thing
    extra: set = field(
        default_factory=set
    )  # kinds that may be named besides and are true of the recording too
    observations: set = field(default_factory=set)  # must be said; "a|b": one of them
    tolerated: set = field(default_factory=set)  # may be said
    shape: dict = field(
        default_factory=dict
    )  # (kind, parameter) -> the range, or the word, that it must have
    said: str = ""  # words that must stand in the answer, outside the candidates
    unknown_is_right: bool = False  # no effect of the table describes it whole
    clean: bool = False
    covers: bool = True  # N and B are those of the recording


class Bench:
    """One recording in the making."""

    def __init__(self, rng, rate, seconds):
        self.rng, self.rate, self.count = rng, rate, int(round(rate * seconds))
        self.t = np.arange(self.count) / rate
        self.stamps = self.t
        self.white = N / 60 * np.sqrt(rate) * rng.standard_normal(self.count)
        flicker = (flicker_sum, flicker_fft, flicker_kasdin)[rng.integers(3)]
        self.slow = flicker(self.count, B / DEG, rng)
        self.keep = slice(None)
        self.temperature = self.celsius(str(rng.choice(["walk", "cycles", "chamber"])))
        self.gravity = np.array([0.0, 0.0, 1.0])
        self.accel = np.zeros((3, self.count))
        self.more = {}
        self.truth = Truth()

    def celsius(self, how):
        """A course of the temperature; each turns more than once or has a corner."""
        rng, span = self.rng, self.t[-1]
        if how == "cycles":
            cycles = rng.uniform(3, 6)
            return 25 + rng.uniform(2, 4) * np.sin(
                2 * np.pi * cycles * self.t / span + rng.uniform(0, 6)
            )
        if how == "warming":
            return 22 + rng.uniform(5, 9) * -np.expm1(-self.t / rng.uniform(0.1, 0.4) / span)
        if how == "walk":
            walk = np.interp(self.t, np.linspace(0, span, 40), np.cumsum(rng.standard_normal(40)))
            return 25 + rng.uniform(5, 8) * (walk - walk.min()) / np.ptp(walk)
        steps = np.repeat(rng.permutation(np.linspace(-4, 4, 6)), -(-self.count // 6))[: self.count]
        return 25 + self.lagged(steps, rng.uniform(60, 180))

    def lagged(self, x, lag_s):
        """A first-order lag that begins at rest."""
        a = np.exp(-1 / (self.rate * lag_s))
        return signal.lfilter([1 - a], [1, -a], x, zi=[a * x[0]])[0]

    def sign(self):
        return float(self.rng.choice([-1, 1]))

    def hide(self, kind, parameters, same=()):
        self.truth.kinds[kind] = parameters
        self.truth.groups.append({kind, *same})

    def through(self, a_filter):
        """The sensor's own filter: all that came before passes."""
        self.slow, self.white = a_filter(self.white + self.slow), np.zeros(self.count)

    def columns(self):
        rng = self.rng
        y = self.white + self.slow
        table = {
            "time_s": self.stamps,
            "gyro_z_dps": y + self.more.pop("bias", 0.2),
            "temp_degC": self.temperature + 0.02 * rng.standard_normal(self.count),
        }
        for axis, gravity, felt in zip("xyz", self.gravity, self.accel):
            table[f"accel_{axis}_g"] = gravity + felt + 0.002 * rng.standard_normal(self.count)
        table.update(self.more)
        return {name: values[self.keep] for name, values in table.items()}
