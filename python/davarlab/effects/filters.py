"""Filters of the sensor or its software, described by their power gain. They act on every effect
before them, but not on the noise of counts, which is added after them."""

import numpy as np

from ..arrays import Floats
from ..data.recording import Recording
from ..thresholds import FIT, SHAPE
from .base import INFINITE, Effect, Parameter, Values
from .device import Filter, filter_of
from .spectra import angular

RESPONSES = ("sampled", "bilinear")


def folded(f: Floats, rate_hz: float, cutoff_hz: float, order: int) -> Floats:
    """Of an analogue filter that is sampled: its power gain with all images; of one pole the
    discrete pole exp(-2 pi fc / rate)."""
    if order == 1:
        decay = np.exp(-2 * np.pi * cutoff_hz / rate_hz)
        found: Floats = (1 - decay) ** 2 / np.abs(
            1 - decay * np.exp(-1j * angular(f, rate_hz))
        ) ** 2
        return found
    image = np.arange(-SHAPE.filter_images, SHAPE.filter_images + 1) * rate_hz
    squares = (np.square((f + one) / cutoff_hz) for one in image)  # a power of 4 takes longer
    found = sum(1 / (1 + square * square) for square in squares) / float(
        np.sum(1 / (1 + (image / cutoff_hz) ** 4))
    )
    return found


def low_pass(f: Floats, rate_hz: float, shape: Values) -> Floats:
    """Power gain of a low pass, 1 at low frequencies, in the response that the shape names:
    "sampled", as of an analogue Butterworth filter of order 1 or 2 that is sampled (of order 1: or
    of exponential smoothing); "bilinear", the digital filter of that name; or any, as the programs
    read it after --bandwidth."""
    order, response = int(shape.get("order", 1)), shape.get("response", RESPONSES[0])
    if response not in RESPONSES:
        return power_gain(filter_of(response, rate_hz), f, rate_hz)
    if response == "bilinear":
        edge = min(shape["cutoff_hz"] / rate_hz, 0.499)
        found: Floats = 1 / (
            1
            + (np.tan(np.minimum(np.pi * f / rate_hz, 0.4999 * np.pi)) / np.tan(np.pi * edge))
            ** (2 * order)
        )
        return found
    return folded(f, rate_hz, shape["cutoff_hz"], order)


def moving_average(f: Floats, rate_hz: float, shape: Values) -> Floats:
    """Power gain of the mean of so many samples; of a fraction, the oldest has that part of the
    weight: 1.2 is (1, 0.2) / 1.2."""
    samples = shape["samples"]
    whole = int(samples)
    turn = np.exp(-1j * angular(f, rate_hz))
    start = np.where(
        np.abs(1 - turn) > 1e-9,
        (1 - turn**whole) / np.where(np.abs(1 - turn) > 1e-9, 1 - turn, 1),
        whole,
    )
    found: Floats = np.abs(start + (samples - whole) * turn**whole) ** 2 / samples**2
    return found


def power_gain(found: Filter, f: Floats, rate_hz: float) -> Floats:
    """Of coefficients and moving averages, 1 at frequency 0."""
    turn = np.exp(-1j * angular(f, rate_hz))
    b, a = np.trim_zeros(found.b, "b"), np.trim_zeros(found.a, "b")
    above = np.abs(np.polyval(b[::-1], turn) / np.sum(b)) ** 2 if len(b) else 1.0
    under = np.abs(np.polyval(a[::-1], turn) / np.sum(a)) ** 2 if len(a) else 1.0
    mean = moving_average(f, rate_hz, {"samples": float(max(found.length, 1))})
    gain: Floats = above / under * mean**found.averages
    return gain


def half_power_hz(text: str, rate_hz: float) -> float:
    """Where a filter is at -3 dB; half the rate if it is not."""
    f = np.linspace(0, rate_hz / 2, 2000)
    gain = power_gain(filter_of(text, rate_hz), f, rate_hz)
    below = np.flatnonzero(gain < 0.5)
    if not len(below):
        return float(f[-1])
    pair = [below[0], below[0] - 1]
    return float(np.interp(0.5, gain[pair], f[pair]))


def is_filter(text: str) -> bool:
    filter_of(text, 0.0)
    return True


def leaked(f: Floats, rate_hz: float, shape: Values) -> Floats:
    """The variance of an ordinate of white noise after a moving average, minus the power gain,
    times the number of samples (DESIGN 2.3). It comes from the ends of the record. At a zero of the
    gain, nothing else is left."""
    samples, turn = shape["samples"], angular(f, rate_hz)
    weights = np.ones(int(np.ceil(samples)))
    weights[-1] -= len(weights) - samples
    found = np.zeros_like(turn)
    for lag in range(1, len(weights)):
        product = weights[lag:] @ weights[:-lag] / samples**2
        found -= 2 * product * (lag * np.cos(turn * lag) + np.sin(turn * lag) / np.sin(turn))
    return found


def zeros(rate_hz: float, shape: Values) -> list[float]:
    """Frequencies up to half the rate, in Hz, where a moving average of nearly a whole number of
    samples leaves nothing."""
    whole = round(shape["samples"])
    if abs(shape["samples"] - whole) > SHAPE.nearly_whole:
        return []
    return [rate_hz * turn / whole for turn in range(1, whole // 2 + 1)]


def high_pass(f: Floats, rate_hz: float, shape: Values) -> Floats:
    """Power gain of what is left when a slow mean is subtracted."""
    square = (f * shape["corner_period_s"]) ** 2
    found: Floats = square / (1 + square)
    return found


def settle(recording: Recording, shape: Values) -> Floats:
    """How the first sample, which the software took for the bias, is forgotten."""
    found: Floats = np.exp(-2 * np.pi * recording.time_s / shape["corner_period_s"])
    return found


def cutoffs(recording: Recording) -> Floats:
    return np.geomspace(recording.rate_hz / 500, recording.rate_hz * 0.45, 12)


def lengths(_: Recording) -> Floats:
    return np.array([1.1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 32])


def corner_periods(recording: Recording) -> Floats:
    span = recording.samples / recording.rate_hz
    first = max(span / 1000, FIT.bias_tracked_s)
    return np.geomspace(first, span / 3, 16) if first < span / 3 else np.zeros(0)


LOW_PASS = Effect(
    "low_pass",
    "The sensor's own bandwidth attenuates every effect before it. Quantization noise is added "
    "after it.",
    (
        Parameter("cutoff_hz", "Hz", 1e-3, 1e6),
        Parameter(
            "response",
            "",
            -INFINITE,
            INFINITE,
            values=RESPONSES,
            default=RESPONSES[0],
            form=is_filter,
        ),
        Parameter("order", "", 1, 2, values=(1, 2), default=1),
        Parameter("noise_behind_dps", "deg/s", 0, INFINITE, default=0.0),
    ),
    "Change the bandwidth setting of the sensor. The corner of the spectrum must move.",
    "filter",
    "slope between 0 and -1/2 below the time constant",
    low_pass,
    grid={"cutoff_hz": cutoffs, "response": lambda _: RESPONSES, "order": lambda _: (1, 2)},
    behind="noise_behind_dps",
    variants={"behind": low_pass},
)
MOVING_AVERAGE = Effect(
    "moving_average",
    "The sensor outputs a moving average of its samples, so consecutive outputs are correlated.",
    (Parameter("samples", "", 1, 1e6),),
    "Change the decimation or averaging setting of the sensor. The zeros of the spectrum must "
    "move.",
    "filter",
    "slope between 0 and -1/2 below the length of the mean",
    moving_average,
    grid={"samples": lengths},
)
HIGH_PASS = Effect(
    "high_pass",
    "Software subtracts its own slow estimate of the bias.",
    (Parameter("corner_period_s", "s", 1e-3, 1e7),),
    "Switch off the bias correction of the driver. Without it, a slow constant rotation no longer "
    "fades in the output.",
    "filter",
    "falls faster than -1/2 at long tau",
    high_pass,
    regressor=settle,
    grid={"corner_period_s": corner_periods},
    slow=True,
)
