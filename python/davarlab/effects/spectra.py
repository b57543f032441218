"""Stationary noise: the spectrum describes each effect completely."""

from collections.abc import Callable

import numpy as np
from scipy import fft

from ..arrays import Floats
from ..data.recording import Recording
from ..thresholds import SHAPE
from .base import INFINITE, Effect, Parameter, Values


def angular(f: Floats, rate_hz: float) -> Floats:
    return 2 * np.pi * f / rate_hz


def difference_gain(f: Floats, rate_hz: float) -> Floats:
    found: Floats = 4 * np.sin(angular(f, rate_hz) / 2) ** 2
    return found


def quantization(f: Floats, rate_hz: float, shape: Values) -> Floats:
    """`memory`: correlation of the rounding error of the angle with the one before. 0 where noise
    moves the angle by a count or more per sample; there and only there the error is white."""
    a = shape.get("memory", 0.0)
    found: Floats = (
        rate_hz**2
        * difference_gain(f, rate_hz)
        * (1 - a * a)
        / ((1 - a) ** 2 + a * difference_gain(f, rate_hz))
    )
    return found


def white(f: Floats, rate_hz: float, _: Values) -> Floats:
    return np.full_like(f, rate_hz)


def flicker(f: Floats, rate_hz: float, _: Values) -> Floats:
    return rate_hz / (2 * np.pi * f)


def random_walk(f: Floats, rate_hz: float, _: Values) -> Floats:
    return 1 / rate_hz / difference_gain(f, rate_hz)


def gauss_markov(f: Floats, rate_hz: float, shape: Values) -> Floats:
    decay = np.exp(-1 / (rate_hz * shape["correlation_time_s"]))
    found: Floats = (1 - decay**2) / ((1 - decay) ** 2 + decay * difference_gain(f, rate_hz))
    return found


def narrow_band(f: Floats, rate_hz: float, shape: Values) -> Floats:
    """A line with a width: unit variance, Lorentzian about its frequency, wrapped at the sample
    rate."""
    memory = np.exp(-2 * np.pi * shape["half_width_hz"] / rate_hz)
    level = (1 - memory) ** 2
    found: Floats = sum(
        0.5
        * (1 - memory**2)
        / (level + 4 * memory * np.sin(angular(f + side * shape["frequency_hz"], rate_hz) / 2) ** 2)
        for side in (-1, 1)
    )
    return found


def from_spectrum(
    spectrum: Callable[[Floats], Floats], samples: int, rate_hz: float, rng: np.random.Generator
) -> Floats:
    """Gaussian noise with this spectrum: twice the length is made, so that the end does not know
    the beginning."""
    length = fft.next_fast_len(2 * samples)
    f = np.fft.rfftfreq(length, 1 / rate_hz)
    f[0] = f[1]
    noise = np.fft.rfft(rng.standard_normal(length)) * np.sqrt(spectrum(f))
    noise[0] = 0
    return np.fft.irfft(noise, length)[:samples]


def simulate_random_walk(
    recording: Recording, parameters: Values, rng: np.random.Generator, _: Floats
) -> Floats:
    step = parameters["coefficient_deg_per_h_per_sqrt_h"] / 216000 / np.sqrt(recording.rate_hz)
    return np.cumsum(step * rng.standard_normal(recording.samples))


def simulate_quantization(
    recording: Recording, parameters: Values, rng: np.random.Generator, _: Floats
) -> Floats:
    return (
        np.diff(parameters["coefficient_deg"] * rng.standard_normal(recording.samples + 1))
        * recording.rate_hz
    )


def correlation_times(recording: Recording) -> Floats:
    return np.geomspace(8 / recording.rate_hz, recording.samples / recording.rate_hz / 5, 24)


QUANTIZATION = Effect(
    "quantization",
    "The sensor measures angle in steps, so the rate contains differenced rounding noise.",
    (
        Parameter("coefficient_deg", "deg", 0, INFINITE),
        Parameter("memory", "", -0.95, 0.95, default=0.0),
    ),
    "Log with finer counts. The excess at short tau must fall with the count.",
    "spectrum",
    "slope -1 at the shortest tau",
    quantization,
    simulate=simulate_quantization,
    grid={"memory": lambda _: SHAPE.memories},
    in_front=False,
)
ANGLE_RANDOM_WALK = Effect(
    "angle_random_walk",
    "White thermal and electronic rate noise. Its integral is a random walk of the angle.",
    (Parameter("coefficient_deg_per_sqrt_h", "deg/sqrt(h)", 0, INFINITE, 1 / 60),),
    "Record the sensor at rest. The Allan deviation falls with slope -1/2.",
    "spectrum",
    "slope -1/2",
    white,
)
BIAS_INSTABILITY = Effect(
    "bias_instability",
    "Flicker noise of the electronics changes the bias on every time scale.",
    (Parameter("coefficient_deg_per_h", "deg/h", 0, INFINITE, 1 / 3600),),
    "Record ten times longer. The floor of the Allan deviation stays flat.",
    "spectrum",
    "flat",
    flicker,
)
RATE_RANDOM_WALK = Effect(
    "rate_random_walk",
    "The bias does a random walk (ageing, slow stress).",
    (Parameter("coefficient_deg_per_h_per_sqrt_h", "deg/h/sqrt(h)", 0, INFINITE, 1 / 216000),),
    "Repeat the recording. A random walk differs each time, a ramp or warm-up is the same. Then "
    "keep the temperature constant. If the drift disappears, it was a thermal effect with a lag "
    "or hysteresis.",
    "spectrum",
    "slope +1/2 at long tau",
    random_walk,
    simulate=simulate_random_walk,
)
GAUSS_MARKOV = Effect(
    "gauss_markov",
    "Noise with a single correlation time: a slow fluctuation of the bias.",
    (Parameter("std_dps", "deg/s", 0, INFINITE), Parameter("correlation_time_s", "s", 1e-3, 1e7)),
    "Record at least a hundred correlation times. The hump must stay at the same tau. To exclude "
    "telegraph noise, average over a tenth of the dwell time (twice the correlation time): two "
    "peaks in the histogram are telegraph noise. Then keep the temperature constant. If the "
    "fluctuation disappears, it was a thermal effect with a lag.",
    "spectrum",
    "a hump at 1.9 correlation times",
    gauss_markov,
    grid={"correlation_time_s": correlation_times},
)
NARROW_BAND = Effect(
    "narrow_band",
    "A spectral line with a width: a fan, a resonance of the mount, or an alias of either.",
    (
        Parameter("std_dps", "deg/s", 0, INFINITE),
        Parameter("frequency_hz", "Hz", 1e-6, 1e6),
        Parameter("half_width_hz", "Hz", 1e-9, 1e6),
    ),
    "Change the sample rate. An alias moves, a real line stays. Then switch off fans and supplies.",
    "spectrum",
    "a hump at 0.4 periods, without ripples",
    narrow_band,
)
