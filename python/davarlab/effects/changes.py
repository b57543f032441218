"""Effects that a spectrum cannot describe: a variance that changes, outliers, jumps between
levels."""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording
from . import limits
from .base import INFINITE, Effect, Parameter, Values
from .means import AXIS, axes
from .spectra import correlation_times, gauss_markov

if TYPE_CHECKING:
    from ..inference.changes import Blocks


def vibration_square(
    recording: Recording, axis: str, blocks: "Blocks", together: int = 1
) -> Floats:
    """Mean square of the accelerometer's fast part around each block, over so many blocks together,
    g^2."""
    window, count = max(3, int(recording.rate_hz)), len(blocks.energy)
    key = ("vibration square", axis, blocks.length)
    if key not in recording.measured:
        fast = signals.high_passed(recording.column(f"accel_{axis}_g"), window)
        square = (fast[: count * blocks.length].reshape(count, blocks.length) ** 2).mean(axis=1)
        recording.measured[key] = square * window / (window - 1)
    found: Floats = ndimage.uniform_filter1d(recording.measured[key], together, mode="nearest")
    return found


def lorentzian(f: Floats, rate_hz: float, shape: Values) -> Floats:
    """Unit telegraph noise: levels 2 apart (+1 and -1, correlation time half the mean dwell), each
    switch to any of the others."""
    levels = shape.get("levels", 2.0)
    found: Floats = (
        (levels**2 - 1)
        / 3
        * gauss_markov(
            f, rate_hz, {"correlation_time_s": shape["mean_dwell_s"] * (levels - 1) / levels}
        )
    )
    return found


def simulate_telegraph(
    recording: Recording, parameters: Values, rng: np.random.Generator, _: Floats
) -> Floats:
    flips = rng.random(recording.samples) < 1 - np.exp(
        -1 / (recording.rate_hz * parameters["mean_dwell_s"])
    )
    levels = int(parameters.get("levels", 2))
    if levels > 2:
        moves = np.cumsum(
            np.where(flips, rng.integers(1, levels, recording.samples), 0)
        ) + rng.integers(levels)
        found: Floats = parameters["amplitude_dps"] * (2.0 * (moves % levels) - (levels - 1))
        return found
    found = parameters["amplitude_dps"] * np.where(
        (np.cumsum(flips) + rng.integers(2)) % 2, 1.0, -1.0
    )
    return found


def simulate_shocks(
    recording: Recording, parameters: Values, rng: np.random.Generator, _: Floats
) -> Floats:
    hit = rng.random(recording.samples) < parameters["rate_per_hour"] / 3600 / recording.rate_hz
    found: Floats = parameters["amplitude_dps"] * hit * rng.choice([-1.0, 1.0], recording.samples)
    return found


def simulate_noise_step(
    recording: Recording, parameters: Values, rng: np.random.Generator, white: Floats
) -> Floats:
    inside = (recording.time_s >= parameters["start_s"]) & (recording.time_s < parameters["stop_s"])
    found: Floats = white * inside * (parameters["ratio"] - 1)
    return found


def simulate_vibration_noise(
    recording: Recording, parameters: Values, rng: np.random.Generator, _: Floats
) -> Floats:
    square = signals.local_mean_square(
        recording.column(f"accel_{parameters['axis']}_g"), int(recording.rate_hz)
    )
    found: Floats = (
        parameters["coefficient_dps_per_g"]
        * np.sqrt(square)
        * rng.standard_normal(recording.samples)
    )
    return found


TELEGRAPH_NOISE = Effect(
    "telegraph_noise",
    "A trap in the electronics switches the bias between two or a few evenly spaced levels.",
    (
        Parameter("amplitude_dps", "deg/s (half the jump)", 0, INFINITE),
        Parameter("mean_dwell_s", "s", 1e-3, 1e7),
        Parameter("levels", "", 2, 5, default=2.0, whole=True, searched=True),
    ),
    "Average over a tenth of the dwell time. The histogram then has one peak per level.",
    "states",
    "a hump at 0.95 dwell times",
    lorentzian,
    simulate=simulate_telegraph,
    grid={
        "mean_dwell_s": lambda recording: 2 * correlation_times(recording),
        "levels": lambda _: (2.0,),
    },
)
VIBRATION_NOISE = Effect(
    "vibration_noise",
    "Vibration adds white noise in proportion to its local rms.",
    (Parameter("coefficient_dps_per_g", "deg/s per g rms", 0, INFINITE), AXIS),
    "Shake the sensor at two levels. The rate noise must grow with the rms.",
    "variance",
    "slope -1/2, higher while it vibrates",
    simulate=simulate_vibration_noise,
    grid={"axis": axes},
    needs=("accel",),
    variants={"over 5 s": partial(vibration_square, together=5)},
    most={"": limits.PER_G_OF_NOISE},
)
NOISE_STEP = Effect(
    "noise_step",
    "The white noise is larger for some time: a supply, a radio or a loose mount.",
    (
        Parameter("ratio", "", 0, INFINITE),
        Parameter("start_s", "s", 0, INFINITE),
        Parameter("stop_s", "s", 0, INFINITE),
    ),
    "Find out which device was switched on at these times, and switch it on again.",
    "variance",
    "slope -1/2, higher in the interval",
    simulate=simulate_noise_step,
    nothing=1.0,
)
SHOCKS = Effect(
    "shocks",
    "Knocks and single outlier samples.",
    (
        Parameter("amplitude_dps", "deg/s", 0, INFINITE),
        Parameter("rate_per_hour", "1/h", 0, INFINITE),
    ),
    "Check the accelerometer at the same times, and knock the sensor on purpose.",
    "events",
    "slope -1/2 at short tau",
    simulate=simulate_shocks,
)
