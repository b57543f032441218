"""Deterministic effects: a function of time or of the accelerometer, times one coefficient."""

from functools import partial

import numpy as np
import scipy

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording
from ..errors import BadInput
from ..thresholds import SHAPE, SIGNALS
from . import limits
from .base import INFINITE, Effect, Parameter, Values, one_name

ANY = (-INFINITE, INFINITE)
# Lines, whose course has a sine and a cosine.
TURNING = ("sinusoid", "intermittent_line", "drifting_line", "line_follows")
AXIS = Parameter("axis", "x, y, z", *ANY, values=("x", "y", "z"))


def axes(recording: Recording) -> list[str]:
    return [axis for axis in "xyz" if f"accel_{axis}_g" in recording.columns]


def ramp(recording: Recording, _: Values) -> Floats:
    return recording.time_s


def line(recording: Recording, shape: Values, turn: float = 0.0) -> Floats:
    if recording.even_time:
        return signals.sine(shape["frequency_hz"] / recording.rate_hz, recording.samples, turn)
    found: Floats = np.sin(2 * np.pi * (shape["frequency_hz"] * recording.time_s + turn))
    return found


def line_for_a_while(recording: Recording, shape: Values, turn: float = 0.0) -> Floats:
    time, found = recording.time_s, line(recording, shape, turn)
    found[(time < shape["start_s"]) | (time >= shape["stop_s"])] = 0.0
    return found


def knots(text: str) -> Floats:
    """The numbers in a text; none where it has anything else."""
    try:
        return np.array([float(word) for word in text.split()])
    except ValueError:
        return np.zeros(0)


def course_hz(shape: Values, where: str = "") -> Floats:
    """The frequencies of a drifting line at its knots. Raises BadInput for anything else."""
    found = knots(shape["course_hz"])
    if len(found) < SHAPE.course_least or not (found > 0).all() or not np.isfinite(found).all():
        raise BadInput(
            f"{where + ': ' * bool(where)}drifting_line: course_hz must be {SHAPE.course_least} or "
            "more frequencies in Hz, separated by spaces: those at even times from the first "
            "sample to the last"
        )
    return found


def turns_of(course: Floats, time: Floats, last: float) -> Floats:
    """Turns since the first of these times of a line whose frequency passes through knots at even
    times up to the last one."""
    marks = np.linspace(time[0], last, len(course))
    found: Floats = scipy.interpolate.CubicSpline(marks, course).antiderivative()(time)
    return found


def drifting(recording: Recording, shape: Values, turn: float = 0.0) -> Floats:
    time = recording.time_s
    turns = turns_of(course_hz(shape), time, time[-1])
    found: Floats = np.sin(2 * np.pi * (turns + turn))
    return found


def step(recording: Recording, shape: Values) -> Floats:
    found: Floats = (recording.time_s >= shape["time_s"]).astype(float)
    return found


def warm_up(recording: Recording, shape: Values) -> Floats:
    found: Floats = np.exp(-recording.time_s / shape["time_constant_s"])
    return found


def acceleration(recording: Recording, shape: Values) -> Floats:
    return recording.column(f"accel_{shape['axis']}_g")


def still_acceleration(recording: Recording, shape: Values) -> Floats:
    return signals.denoised(acceleration(recording, shape))


def vibration_square(recording: Recording, shape: Values, window_s: float = 2.0) -> Floats:
    return signals.local_mean_square(
        acceleration(recording, shape), int(window_s * recording.rate_hz)
    )


def time_constants(recording: Recording) -> Floats:
    span = recording.samples / recording.rate_hz
    return np.geomspace(span / 300, span, 20)


def sudden_vibration_square(recording: Recording, shape: Values) -> Floats:
    return signals.mean_square_between(
        acceleration(recording, shape),
        max(2, int(recording.rate_hz)),
        max(SIGNALS.scatter_least, int(60 * recording.rate_hz)),
    )


RATE_RAMP = Effect(
    "rate_ramp",
    "The bias drifts at a constant rate: ageing, or a supply that drifts.",
    (Parameter("coefficient_deg_per_h2", "deg/h^2", *ANY, 1 / 3600**2),),
    "Record twice as long. A ramp continues, a warm-up flattens, a random walk changes direction.",
    "mean",
    "slope +1",
    regressor=ramp,
    slow=True,
)
SINUSOID = Effect(
    "sinusoid",
    "A periodic motion or electrical interference at one frequency.",
    (Parameter("amplitude_dps", "deg/s", 0, INFINITE), Parameter("frequency_hz", "Hz", 1e-6, 1e6)),
    "Change the sample rate. An alias moves, a real line stays. Then switch off fans and supplies.",
    "mean",
    "a hump at 0.4 periods with ripples after it",
    regressor=line,
)
INTERMITTENT_LINE = Effect(
    "intermittent_line",
    "A spectral line between two times, from a machine that runs for some time.",
    (
        Parameter("amplitude_dps", "deg/s", 0, INFINITE),
        Parameter("frequency_hz", "Hz", 1e-6, 1e6, searched=True),
        Parameter("start_s", "s", 0, INFINITE, searched=True),
        Parameter("stop_s", "s", 0, INFINITE, searched=True),
    ),
    "Find out which device was switched on at these times, and switch it on again. The line must "
    "return.",
    "mean",
    "a hump at 0.4 periods in these windows only",
    regressor=line_for_a_while,
)
DRIFTING_LINE = Effect(
    "drifting_line",
    "A spectral line whose frequency drifts: a fan, an oscillator or a resonance that warms up, or "
    "an alias of one.",
    (
        Parameter("amplitude_dps", "deg/s", 0, INFINITE),
        Parameter(
            "course_hz",
            "frequencies in Hz at even times from the first sample to the last, separated by "
            "spaces",
            *ANY,
            form=one_name,
            searched=True,
        ),
    ),
    "Log temperature, supply voltage and the speed of nearby fans. The frequency must follow one "
    "of them. Then change the sample rate: an alias moves, a real line stays.",
    "mean",
    "a hump at 0.4 periods with ripples that change over time",
    regressor=drifting,
)
BIAS_STEP = Effect(
    "bias_step",
    "The bias jumps once: a stress that relaxes, a supply that switches, or a range or register "
    "that changes.",
    (Parameter("step_dps", "deg/s", *ANY), Parameter("time_s", "s", 0, INFINITE, searched=True)),
    "Repeat the recording. A step occurs at another time or not at all. Find out what happened at "
    "that time.",
    "mean",
    "slope up to +1/2 in the windows that hold the step only",
    regressor=step,
)
G_SENSITIVITY = Effect(
    "g_sensitivity",
    "Acceleration deforms the structure: the rate follows the specific force along an axis.",
    (Parameter("coefficient_dps_per_g", "deg/s/g", *ANY), AXIS),
    "Turn the sensor over (+1 g, -1 g). The bias changes by twice the coefficient.",
    "mean",
    "that of the accelerometer",
    regressor=acceleration,
    grid={"axis": axes},
    needs=("accel",),
    variants={"still": still_acceleration},
    most={"": limits.PER_G},
)
VIBRATION_RECTIFICATION = Effect(
    "vibration_rectification",
    "Vibration is rectified into a bias in proportion to its mean square.",
    (Parameter("coefficient_dps_per_g2", "deg/s/g^2", *ANY), AXIS),
    "Shake the sensor at two levels. The bias grows with the square of the rms.",
    "mean",
    "steps of bias while it vibrates",
    regressor=vibration_square,
    grid={"axis": axes},
    needs=("accel",),
    variants={f"over {s} s": partial(vibration_square, window_s=s) for s in (1, 5)}
    | {"sudden": sudden_vibration_square},
    slow=True,
    most={"": limits.PER_G2},
)
WARM_UP = Effect(
    "warm_up",
    "After power-on the bias settles exponentially.",
    (Parameter("amplitude_dps", "deg/s", *ANY), Parameter("time_constant_s", "s", 1e-3, 1e7)),
    "Switch the sensor off for an hour and on again. The same curve must return.",
    "mean",
    "slope up to +1 at long tau",
    regressor=warm_up,
    grid={"time_constant_s": time_constants},
    slow=True,
)
