"""The signals that the methods are compared on: simulated gyros whose noise is known, and the
recordings in data/ that state it. Counts are int16; LOST marks a sample that is missing.
"""

import gzip
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.signal import butter, lfilter

Floats = npt.NDArray[Any]
Counts = npt.NDArray[np.int16]

DATA = Path(__file__).resolve().parents[1] / "data"
STRIDE = 10  # samples between answers, as in method.h
LOST = -32768
SEED = 61  # of every simulated record, with the place of its signal and its repetition
LSB_DPS = 0.01
UNKNOWN, WHITE = -1.0, 0.0  # cutoffs


class NotHere(Exception):
    """This machine lacks what a method needs; the message names it."""


@dataclass(frozen=True)
class Record:
    """A recording with the noise that it has."""

    counts: Counts
    rate_hz: float
    lsb_dps: float
    cutoff: float  # of the low-pass that is declared, over the rate; WHITE or UNKNOWN
    sigma_dps: Floats  # the true white noise of a sample, before the filter, at each answer

    @property
    def sheet_dps(self) -> float:
        """What a data sheet states: the noise at the start."""
        return float(self.sigma_dps[0])


@dataclass(frozen=True)
class Signal:
    """How to simulate records. Functions take seconds."""

    about: str
    seconds: int = 300
    rate_hz: float = 100.0
    sigma_counts: float = 20.0
    level: Callable[[Floats], Floats] = np.ones_like  # of the noise, relative
    added: Callable[[Floats, np.random.Generator], Floats] | None = None  # counts
    cutoff: float = WHITE  # of a digital Butterworth low-pass of two poles, over the rate
    is_declared: bool = True
    gap_rate: float = 0.0  # of runs of one to eight lost samples, per sample


def steps(t: Floats) -> Floats:
    return np.where(t % 120 < 60, 1.0, 2.0)


def drifts(t: Floats, rng: np.random.Generator) -> Floats:
    """Flicker and random walk: their Allan deviations are that of 20 counts of white noise at 64
    and at 256 samples.
    """
    shape = np.fft.rfftfreq(t.size)
    shape[1:] **= -0.5
    flicker: Floats = np.fft.irfft(np.fft.rfft(rng.normal(size=t.size)) * shape, t.size)
    half_power = np.sqrt(4 * np.log(2))  # Allan deviation of 1/f noise of this density
    walk: Floats = np.cumsum(rng.normal(0, 20 * 3**0.5 / 256, t.size))
    return np.asarray(20 / 8 / half_power * flicker + walk)


def motion(t: Floats, rng: np.random.Generator) -> Floats:
    """20 deg/s at 0.1 Hz and 5 deg/s at 0.4 Hz."""
    phase = rng.uniform(0, 2 * np.pi, 2)
    return np.asarray(
        2000 * np.sin(0.2 * np.pi * t + phase[0]) + 500 * np.sin(0.8 * np.pi * t + phase[1])
    )


def rotors(t: Floats, rng: np.random.Generator) -> Floats:
    """Four rotors near 95 Hz, each with two harmonics, 1 to 0.5 deg/s; their speeds wander."""
    total = np.zeros_like(t)
    wander = np.sin(2 * np.pi * (t / 7 + rng.uniform()))
    for rotor in range(4):
        hertz = 90 + 3 * rotor + 2 * wander + rng.normal(0, 0.3)
        angle = 2 * np.pi * np.cumsum(hertz) * (t[1] - t[0]) + rng.uniform(0, 2 * np.pi)
        total += 100 * np.sin(angle) + 70 * np.sin(2 * angle) + 50 * np.sin(3 * angle)
    return total


def flight(t: Floats, rng: np.random.Generator) -> Floats:
    return motion(5 * t, rng) + rotors(t, rng)


SIGNALS = {
    "rest": Signal("white noise of 20 counts, 0.2 deg/s at 100 Hz", seconds=3600),
    "steps": Signal("twice the noise in every second minute", seconds=1800, level=steps),
    "slow change": Signal(
        "half to twice the noise, period 120 s", level=lambda t: 2 ** np.sin(2 * np.pi * t / 120)
    ),
    "bursts": Signal(
        "three times the noise for 1 s in 20", level=lambda t: np.where(t % 20 < 1, 3.0, 1.0)
    ),
    "gaps": Signal("runs of 1 to 8 lost samples, one in 400 samples", gap_rate=1 / 400),
    "drift": Signal(
        "flicker and random walk as large as the noise at 0.64 and 2.56 s", added=drifts
    ),
    "coarse": Signal("noise of half a count", sigma_counts=0.5),
    "filter": Signal("after a low-pass of two poles at 20 Hz, which is declared", cutoff=0.2),
    "unknown": Signal("the same low-pass, which is not declared", cutoff=0.2, is_declared=False),
    "motion": Signal("motion of 20 deg/s at 0.1 Hz and 5 deg/s at 0.4 Hz", added=motion),
    "rotors": Signal(
        "1 kHz, lines of four rotors at 90 to 300 Hz", seconds=60, rate_hz=1000.0, added=rotors
    ),
    "flight": Signal(
        "1 kHz, rotors, motion of 20 deg/s at 0.5 Hz and 5 at 2 Hz, a declared low-pass at 250 Hz",
        seconds=60,
        rate_hz=1000.0,
        added=flight,
        cutoff=0.25,
    ),
}


def simulated(name: str, repetition: int, seconds: int | None = None) -> Record:
    """A record of a signal; the same one for the same arguments."""
    signal = SIGNALS[name]
    rng = np.random.default_rng([SEED, list(SIGNALS).index(name), repetition])
    t = np.arange(round((seconds or signal.seconds) * signal.rate_hz)) / signal.rate_hz
    sigma = signal.sigma_counts * signal.level(t)
    x = sigma * rng.normal(size=t.size)
    if signal.added:
        x = x + signal.added(t, rng)
    if signal.cutoff:
        x = lfilter(*butter(2, 2 * signal.cutoff), x)
    counts = np.rint(x).astype(np.int16)
    for start in np.flatnonzero(rng.uniform(size=t.size) < signal.gap_rate):
        counts[start : start + rng.integers(1, 9)] = LOST
    return Record(
        counts,
        signal.rate_hz,
        LSB_DPS,
        signal.cutoff if signal.is_declared else UNKNOWN,
        LSB_DPS * sigma[STRIDE - 1 :: STRIDE],
    )


def recordings() -> dict[str, Record]:
    """The recordings in data/ whose header states their angle random walk."""
    found = {}
    for path in sorted(DATA.glob("*.csv.gz")):
        text = gzip.decompress(path.read_bytes()).decode()
        header = dict(re.findall(r"^# (\w+): (.*)$", text, re.MULTILINE))
        if "truth_arw_deg_per_sqrt_h" not in header:
            continue
        rows = [line.split(",") for line in text.splitlines() if line[:1].isdigit()]
        time_s, rate_dps = np.array(rows, float).T[:2]
        rate_hz = 1 / float(np.median(np.diff(time_s)))
        truth = header["truth_arw_deg_per_sqrt_h"].split(", ")
        start, arw = np.array([one.split(":") for one in truth], float).T
        newest = time_s[STRIDE - 1 :: STRIDE]
        sigma = arw[np.searchsorted(start, newest, "right") - 1] / 60 * rate_hz**0.5
        lsb = float(header["lsb_dps"])
        counts = np.rint(rate_dps / lsb).astype(np.int16)
        found[path.name.split(".")[0]] = Record(counts, rate_hz, lsb, WHITE, sigma)
    return found
