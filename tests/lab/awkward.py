"""Recordings of awkward sensors: what real ones do and textbooks do not. Numpy and scipy only,
nothing of davarlab. 100 Hz, one hour, ARW 0.3 deg/sqrt(h), BI 5 deg/h unless a scenario says
otherwise; all else is drawn.

A recording is a row of ingredients in the order of physics: what moves the rate, then the sensor's
own filter, its counts, its clock.
"""

import numpy as np
from elsewhere import DEG, ar1, flicker_fft, flicker_kasdin, flicker_sum
from scipy import signal

RATE, SECONDS = 100.0, 3600.0
N, B = 0.3, 5.0  # ARW deg/sqrt(h), BI deg/h


class Bench:
    """One recording in the making."""

    def __init__(self, rng, rate, seconds):
        self.rng, self.rate, self.count = rng, rate, int(round(rate * seconds))
        self.t = np.arange(self.count) / rate
        self.sigma = N / 60 * np.sqrt(rate)
        self.white = self.sigma * rng.standard_normal(self.count)
        flicker = (flicker_sum, flicker_fft, flicker_kasdin)[rng.integers(3)]
        self.slow = flicker(self.count, B / DEG, rng)
        self.keep = slice(None)
        self.temperature = self.celsius(str(rng.choice(["walk", "cycles", "chamber"])))
        self.accel = np.zeros((3, self.count))
        self.more, self.bias = {}, 0.2

    def celsius(self, how):
        """A course of the temperature; each turns more than once or has a corner."""
        rng, span = self.rng, self.t[-1]
        if how == "cycles":
            turns = 2 * np.pi * rng.uniform(3, 6) * self.t / span
            return 25 + rng.uniform(2, 4) * np.sin(turns + rng.uniform(0, 6))
        if how == "walk":
            walk = np.interp(self.t, np.linspace(0, span, 40), np.cumsum(rng.standard_normal(40)))
            return 25 + rng.uniform(5, 8) * (walk - walk.min()) / np.ptp(walk)
        steps = np.repeat(rng.permutation(np.linspace(-4, 4, 6)), -(-self.count // 6))[: self.count]
        a = np.exp(-1 / (self.rate * rng.uniform(60, 180)))
        return 25 + signal.lfilter([1 - a], [1, -a], steps, zi=[a * steps[0]])[0]

    def noise(self):
        return self.sigma * self.rng.standard_normal(self.count)

    def becomes(self, y):
        """The rate from here on, in place of all that came before."""
        self.slow, self.white = y, np.zeros(self.count)

    def columns(self):
        rng = self.rng
        table = {
            "time_s": self.t,
            "gyro_z_dps": self.white + self.slow + self.bias,
            "temp_degC": self.temperature + 0.02 * rng.standard_normal(self.count),
        }
        for axis, gravity, felt in zip("xyz", (0.0, 0.0, 1.0), self.accel):
            table[f"accel_{axis}_g"] = gravity + felt + 0.002 * rng.standard_normal(self.count)
        return {name: values[self.keep] for name, values in (table | self.more).items()}


def logistic(x):
    return 1 / (1 + np.exp(-np.clip(x, -50, 50)))


def decoys(bench):
    """Columns that move and that the gyro does not follow: bursts of vibration, the sensor set down
    anew about the other axes, other axes, volts (loads that are switched, a battery that empties,
    ripple of the logger).
    """
    rng, t = bench.rng, bench.t
    for start in rng.uniform(0, 0.85, rng.integers(2, 5)) * t[-1]:
        on = (t >= start) & (t < start + rng.uniform(20, 300))
        bench.accel += rng.uniform(0.02, 0.1) * on * rng.standard_normal((3, bench.count))
    turns = np.zeros((2, bench.count))
    for axis, centre in enumerate(rng.uniform(0.1, 0.9, 2) * t[-1]):
        tilt = rng.uniform(0.3, 1.5) * logistic((t - centre) / rng.uniform(1, 5))
        turns[axis] = np.gradient(tilt, 1 / bench.rate)
        bench.accel[1 - axis] += np.sin(np.radians(tilt))
    for axis, turn in zip("xy", turns):
        turn = turn + bench.noise() + flicker_fft(bench.count, B / DEG, rng)
        bench.more[f"gyro_{axis}_dps"] = turn
    loads = np.searchsorted(np.cumsum(rng.exponential(200, 60)), t) % 2
    ripple = 0.05 * ar1(bench.count, np.exp(-1 / (30 * bench.rate)), rng)
    volts = 5 - 0.1 * t / t[-1] - 0.15 * loads + ripple
    bench.more["supply_V"] = volts + 0.002 * rng.standard_normal(bench.count)


def motion_turned(bench):
    """Turned by hand about the vertical: a few seconds each, with the tremor of the hand."""
    rng, turn, held = bench.rng, np.zeros(bench.count), np.zeros(bench.count)
    number = rng.integers(2, 6)
    slots = rng.permutation(12)[:number]  # clear of each other and of the ends
    for centre in (slots + rng.uniform(0.3, 0.7, number)) / 12 * bench.t[-1]:
        width = rng.uniform(0.6, 2)
        shape = np.exp(-0.5 * ((bench.t - centre) / width) ** 2)
        degrees = rng.choice([-1, 1]) * rng.uniform(15, 90)
        turn += degrees / (width * np.sqrt(2 * np.pi)) * shape
        held += shape
    tremor = band(bench.count, 8 / bench.rate, 2 / bench.rate, rng) * held
    bench.slow += turn + tremor
    for axis, along, shaken in (("x", 0.05, 0.5), ("y", -0.03, 0.4)):
        bench.more[f"gyro_{axis}_dps"] = along * turn + shaken * tremor + bench.noise()
    bench.accel += 0.02 * held * rng.standard_normal((3, bench.count))


def band(count, nu, half_width, rng):
    """Unit variance about a frequency: an oscillator whose amplitude and phase are kicked. All in
    cycles per sample.
    """
    decay, turns = np.exp(-2 * np.pi * half_width), 2 * np.pi * nu * np.arange(count)
    return ar1(count, decay, rng) * np.cos(turns) + ar1(count, decay, rng) * np.sin(turns)


def narrow_band(bench, low=17, high=38):
    share, width = bench.rng.uniform(low, high) / RATE, bench.rng.uniform(0.15, 0.5) / RATE
    bench.slow += bench.rng.uniform(0.02, 0.06) * band(bench.count, share, width, bench.rng)


def low_band(bench):
    """A band where the slope of a low pass begins."""
    narrow_band(bench, 8, 30)


def line(bench):
    f, amplitude = bench.rate * bench.rng.uniform(0.02, 0.4), bench.rng.uniform(0.006, 0.02)
    bench.slow += amplitude * np.sin(2 * np.pi * f * bench.t + bench.rng.uniform(0, 6))


def along(bench, course):
    """A line whose frequency takes this course."""
    amplitude = bench.rng.uniform(0.02, 0.05)
    bench.slow += amplitude * np.sin(2 * np.pi * np.cumsum(course) / bench.rate)


def drifting_line(bench):
    f, moves = bench.rate * bench.rng.uniform(0.17, 0.38), bench.rng.uniform(0.3, 1.5)
    u = bench.t / bench.t[-1]
    straight = bench.rng.random() < 0.5
    course = u if straight else np.sin(2 * np.pi * u * bench.rng.uniform(0.5, 2)) / 2
    along(bench, f + moves * course)


def drifting_as_it_warms(bench):
    """Fast at first, then slower and slower: a fan or an oscillator after power-on."""
    f, moves = bench.rate * bench.rng.uniform(0.1, 0.35), bench.rng.uniform(0.5, 3)
    along(bench, f - moves * np.expm1(-bench.t / bench.rng.uniform(0.06, 0.3) / bench.t[-1]))


def gauss_markov(bench):
    std, time = bench.rng.uniform(0.006, 0.015), np.exp(bench.rng.uniform(np.log(2), np.log(30)))
    bench.slow += std * ar1(bench.count, np.exp(-1 / (bench.rate * time)), bench.rng)


def counted(bench):
    """Counts that show in the stop band."""
    count = bench.rng.uniform(0.005, 0.03)
    bench.slow = np.round(bench.slow / count) * count


def average(bench, taps):
    bench.becomes(signal.lfilter(np.ones(taps) / taps, [1], bench.white + bench.slow))


def two_tap_average(bench):
    """The same filter as a bilinear pole at a quarter of the rate: no recording can tell them
    apart.
    """
    average(bench, 2)
    if bench.rng.random() < 0.5:
        counted(bench)


def average_of_several(bench):
    """Its gain has zeros below half the rate."""
    average(bench, int(bench.rng.integers(3, 7)))


def butterworth(bench):
    """Half of them before the converter: ten times as fast, then every tenth; the white noise above
    half the rate folds back.
    """
    b, a = signal.butter(2, 0.2, fs=1.0)
    if bench.rng.random() < 0.5:
        bench.becomes(signal.lfilter(b, a, bench.white + bench.slow))
    else:
        fine = bench.sigma * np.sqrt(10) * bench.rng.standard_normal(10 * bench.count)
        white = signal.lfilter(*signal.butter(2, 0.02, fs=1.0), fine)[::10]
        bench.becomes(white + signal.lfilter(b, a, bench.slow))
    counted(bench)


def dead_zone(bench):
    """A driver that reports 0 for small rates, with or without a step at the ends of the zone."""
    x = bench.white + bench.slow
    zone = bench.rng.uniform(0.3, 1.2) * np.std(bench.white)
    beyond = x if bench.rng.random() < 0.5 else x - np.sign(x) * zone
    count = bench.rng.uniform(0.001, 0.004)
    bench.becomes(np.round(np.where(np.abs(x) < zone, 0.0, beyond) / count) * count)
    bench.bias = 0.0


def repeated_behind_counts(bench):
    """A sensor that is read 1.2 to 1.9 times a sample, behind counts as large as its noise: nobody
    can see which samples are repeats.
    """
    count = np.std(bench.white) / bench.rng.uniform(0.8, 3)
    y = np.round((bench.white + bench.slow) / count) * count
    at = (np.arange(bench.count) / bench.rng.uniform(1.2, 1.9)).astype(int)
    bench.becomes(y[at])
    bench.accel = bench.accel[:, at]


def lost_samples(bench):
    """3 %, one to five in a row; the stamps tell."""
    lost, mean = np.zeros(bench.count, bool), bench.rng.uniform(1, 5)
    starts = bench.rng.choice(bench.count - 40, int(0.03 * bench.count / mean), replace=False)
    for start, length in zip(starts, bench.rng.geometric(1 / mean, len(starts))):
        lost[start : start + length] = True
    bench.keep = np.flatnonzero(~lost)


def recording(name, ingredients, seed, rate=RATE, seconds=SECONDS):
    """The columns; the name is part of the seed."""
    bench = Bench(np.random.default_rng([seed, *name.encode()]), rate, seconds)
    for ingredient in ingredients:
        ingredient(bench)
    return bench.columns()
