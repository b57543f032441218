"""Effects that follow a logged column: the temperature, late, squared, with hysteresis or in the
noise, and any other column (DESIGN 4)."""

from functools import partial

import numpy as np
import scipy

from ..arrays import Bools, Floats
from ..data import signals
from ..data.recording import Recording
from ..thresholds import SHAPE, SIGNALS
from . import limits
from .base import INFINITE, Effect, Parameter, Values, one_name
from .means import knots, turns_of

ANY = (-INFINITE, INFINITE)
SOUGHT_TOGETHER = (
    "temperature",
    "temperature_squared",
    "temperature_hysteresis",
    "temperature_noise",
    "follows",
    "noise_follows",
)  # candidates/columns.py
# Kinds that name the column which they follow.
FOLLOWING = ("follows", "noise_follows", "line_follows")
REFERENCE_DEGC = 25.0
LAG = Parameter("lag_s", "s", 0, 1e6, default=0.0, optional=True)
# Columns of which other effects know more; time is no cause.
NOT_FOLLOWED = ("time", "temp_degC", "accel_")


def still(recording: Recording, name: str) -> Floats:
    """A column without the white noise of its own sensor; worked out once."""
    key = ("still", name)
    if key not in recording.measured:
        recording.measured[key] = signals.denoised(recording.column(name)).astype(
            recording.columns[name].dtype, copy=False
        )
    found: Floats = recording.measured[key]
    return found


def lagged(x: Floats, rate_hz: float, lag_s: float, moving: bool = False) -> Floats:
    """x through a body that takes `lag_s` to follow (first order). Before the first sample x stood
    still, or moved on as it begins."""
    if lag_s * rate_hz < 1:
        return x
    decay = np.exp(-1 / (rate_hz * lag_s))
    share, first = (1 - decay) / 2, x[0]
    if moving:
        reach = int(np.clip(lag_s * rate_hz, 1, len(x) - 1))
        first = x[0] - (x[reach] - x[0]) / reach * lag_s * rate_hz
    initial = [first - share * x[0]]
    found: Floats = scipy.signal.lfilter([share, share], [1, -decay], x, zi=initial)[0]
    return found


def play(x: Floats, width: float) -> Floats:
    """Follows x only where x pushes it: x moves freely within `width`. A chain of clips is a clip,
    so blocks of the chain go in parallel."""
    side = int(np.ceil(np.sqrt(len(x))))
    padded = np.append(x, np.full(side * side - len(x), x[-1])).reshape(side, side)
    low, high = padded - width / 2, padded + width / 2
    for j in range(1, side):
        floor, ceiling = low[:, j].copy(), high[:, j].copy()
        low[:, j] = np.minimum(np.maximum(low[:, j - 1], floor), ceiling)
        high[:, j] = np.minimum(np.maximum(high[:, j - 1], floor), ceiling)
    place, starts = x[0], np.empty((side, 1))
    for row in range(side):
        starts[row] = place
        place = min(max(place, low[row, -1]), high[row, -1])
    return np.minimum(np.maximum(starts, low), high).ravel()[: len(x)]


def slow_temperature(recording: Recording) -> Floats:
    return still(recording, "temp_degC")


def temperature(recording: Recording, shape: Values | None, moving: bool = False) -> Floats:
    return lagged(
        slow_temperature(recording), recording.rate_hz, (shape or {}).get("lag_s", 0.0), moving
    )


def temperature_rate(recording: Recording, _: Values, half_s: float = 5.0) -> Floats:
    """The slope of the denoised temperature over twice `half_s`."""
    reach = max(1, int(half_s * recording.rate_hz))
    smooth: Floats = np.pad(temperature(recording, None), reach, mode="reflect", reflect_type="odd")
    return (smooth[2 * reach :] - smooth[: -2 * reach]) * recording.rate_hz / (2 * reach)


def squared(recording: Recording, shape: Values, about_mean: bool = False) -> Floats:
    felt = temperature(recording, shape)
    middle: float = slow_temperature(recording).mean() if about_mean else REFERENCE_DEGC
    return (felt - middle) ** 2


def hysteresis(recording: Recording, shape: Values) -> Floats:
    return play(slow_temperature(recording), shape["width_degC"])


def follow(recording: Recording, shape: Values, denoised: bool = False) -> Floats:
    values = still(recording, shape["column"]) if denoised else recording.column(shape["column"])
    return lagged(values, recording.rate_hz, shape["lag_s"])


def turns(recording: Recording, name: str) -> Floats:
    """The integral of a column over time, from the first sample: revolutions, for a column in
    revolutions per second. Worked out once."""
    key = ("turns", name)
    if key not in recording.measured:
        recording.measured[key] = scipy.integrate.cumulative_trapezoid(
            still(recording, name), recording.time_s, initial=0.0
        )
    found: Floats = recording.measured[key]
    return found


def are_knots(text: str) -> bool:
    """Is a text the frequencies of knots."""
    found = knots(text)
    return len(found) >= SHAPE.course_least and bool(np.isfinite(found).all())


def turning_with(recording: Recording, shape: Values, turn: float = 0.0) -> Floats:
    """A line at `multiple` times a column, plus `apart_hz`. None while it has stopped."""
    name = shape["column"]
    phase = shape["multiple"] * turns(recording, name) + turn
    if shape["apart_hz"]:
        time = recording.time_s
        phase += turns_of(knots(shape["apart_hz"]), time, time[-1])
    found: Floats = np.sin(2 * np.pi * phase) * running(recording, name)
    return found


def running(recording: Recording, name: str) -> Bools:
    """Where a column is above SHAPE.stopped of its largest magnitude."""
    size = np.abs(still(recording, name))
    found: Bools = size > SHAPE.stopped * size.max()
    return found


def aliases_hz(recording: Recording, shape: Values) -> Floats:
    """Where the samples show a line at a multiple of a column, while there is one."""
    true = shape["multiple"] * still(recording, shape["column"])
    if shape["apart_hz"]:
        apart = knots(shape["apart_hz"])
        marks = np.linspace(0, 1, len(apart))
        true = true + np.interp(np.linspace(0, 1, len(true)), marks, apart)
    true = true[running(recording, shape["column"])]
    found: Floats = np.abs(true - recording.rate_hz * np.round(true / recording.rate_hz))
    return found


def lags(recording: Recording) -> list[float]:
    return [
        lag
        for lag in SHAPE.lags_s
        if lag <= SHAPE.lag_share * recording.samples / recording.rate_hz
    ]


def widths(recording: Recording) -> list[float]:
    return [share * float(np.ptp(slow_temperature(recording))) for share in SHAPE.hysteresis_widths]


def clocklike(x: Floats) -> bool:
    """Does it go up with the samples: an index, a clock."""
    line = x[0] + (x[-1] - x[0]) * np.linspace(0, 1, len(x))
    return bool(np.ptp(x) <= 0 or np.max(np.abs(x - line)) < SHAPE.clocklike * np.ptp(x))


def may_follow(recording: Recording, gyro: str | None = None) -> list[str]:
    """The columns that `follows` may look at; `gyro`: the column that follows, of which none may be
    a copy."""
    found = [
        name
        for name, values in recording.columns.items()
        if name != gyro and not name.startswith(NOT_FOLLOWED) and not clocklike(values)
    ]
    if gyro is None:
        return found
    own = np.diff(recording.columns[gyro])
    return [
        name
        for name in found
        if not abs(signals.correlation(own, np.diff(recording.columns[name]))) > SIGNALS.copy
    ]


def growth(warm: Floats, shape: Values) -> Floats:
    """How the standard deviation of the white noise goes with the temperature, which is `warm` from
    its mean; 1 there."""
    slope = shape["relative_per_degC"] + shape.get("curvature_per_degC2", 0.0) * warm
    found: Floats = np.exp(np.clip(slope * warm, -20, 20))
    return found


def simulate_temperature_noise(
    recording: Recording, parameters: Values, _: np.random.Generator, white: Floats
) -> Floats:
    slow = slow_temperature(recording)
    return white * (growth(slow - slow.mean(), parameters) - 1)


def added_variance(x: Floats, shape: Values) -> Floats:
    """What a column x adds to the variance of the white noise, 1 at the reference."""
    away = np.abs(x - shape["origin"])
    reach = abs(shape["reference"] - shape["origin"]) or 1.0
    found: Floats = (away / reach) ** shape["power"]
    return found


def simulate_noise_follows(
    recording: Recording, parameters: Values, rng: np.random.Generator, _: Floats
) -> Floats:
    found: Floats = (
        parameters["coefficient_dps"]
        * np.sqrt(added_variance(still(recording, parameters["column"]), parameters))
        * rng.standard_normal(recording.samples)
    )
    return found


TEMPERATURE = Effect(
    "temperature",
    "The bias follows the temperature of the die.",
    (Parameter("coefficient_dps_per_degC", "deg/s/degC", *ANY), LAG),
    "Heat and cool the sensor twice. The bias must follow both times.",
    "mean",
    "that of the temperature, at long tau",
    regressor=temperature,
    needs=("temp_degC",),
    grid={"lag_s": lags},
    variants={"moving before": partial(temperature, moving=True)},
    slow=True,
    most={"": limits.PER_DEGC},
)
TEMPERATURE_RATE = Effect(
    "temperature_rate",
    "Thermal gradients inside the package make the bias follow the rate of change of the "
    "temperature.",
    (Parameter("coefficient_dps_per_degC_per_s", "deg/s/(degC/s)", *ANY),),
    "Heat to the same temperature at two rates. The bias differs during heating, but not "
    "afterwards.",
    "mean",
    "that of the temperature's slope",
    regressor=temperature_rate,
    needs=("temp_degC",),
    variants={"over 1 s": partial(temperature_rate, half_s=0.5)},
    slow=True,
    most={"": limits.PER_DEGC_PER_S},
)
TEMPERATURE_SQUARED = Effect(
    "temperature_squared",
    "The bias depends on the temperature quadratically, with its vertex at 25 degC.",
    (Parameter("coefficient_dps_per_degC2", "deg/s/degC^2", *ANY), LAG),
    "Hold three temperatures, 10 degC apart. The bias at the middle one is off the line through "
    "the other two.",
    "mean",
    "that of the temperature, at long tau",
    regressor=squared,
    needs=("temp_degC",),
    grid={"lag_s": lags},
    variants={"about its mean": partial(squared, about_mean=True)},
    slow=True,
    most={"": limits.PER_DEGC2},
)
TEMPERATURE_HYSTERESIS = Effect(
    "temperature_hysteresis",
    "Friction between package and die: after a reversal, the bias follows the temperature only "
    "after it has changed by a width.",
    (
        Parameter("coefficient_dps_per_degC", "deg/s/degC", *ANY),
        Parameter("width_degC", "degC", 0, 1e3),
    ),
    "Heat and cool over the same range. At a given temperature, the bias differs between heating "
    "and cooling, however slow they are.",
    "mean",
    "that of the temperature, at long tau",
    regressor=hysteresis,
    needs=("temp_degC",),
    grid={"width_degC": widths},
    slow=True,
    most={"": limits.PER_DEGC},
)
TEMPERATURE_NOISE = Effect(
    "temperature_noise",
    "The white noise changes with the temperature.",
    (
        Parameter("relative_per_degC", "1/degC at the mean temperature", -10, 10),
        Parameter("curvature_per_degC2", "1/degC^2", -10, 10, default=0.0, optional=True),
    ),
    "Hold two temperatures. The noise of single samples must differ, and return with the "
    "temperature.",
    "variance",
    "slope -1/2, its level changes with the temperature",
    simulate=simulate_temperature_noise,
    needs=("temp_degC",),
    sized=False,
    most={"": limits.NOISE_PER_DEGC},
)
FOLLOWS = Effect(
    "follows",
    "The bias follows another logged column: a supply, a neighbouring axis or a current.",
    (
        Parameter("coefficient", "deg/s per unit of the column", *ANY),
        Parameter("column", "name of a column", *ANY, form=one_name),
        LAG,
    ),
    "Change that quantity alone, up and down twice. The bias must follow both times.",
    "mean",
    "that of the column",
    regressor=follow,
    grid={"column": may_follow, "lag_s": lags},
    variants={"still": partial(follow, denoised=True)},
    most=limits.FOLLOWED,
)
NOISE_FOLLOWS = Effect(
    "noise_follows",
    "Another logged column adds white noise: a rotor speed, a load or a supply.",
    (
        Parameter("coefficient_dps", "deg/s per sample at the reference", 0, INFINITE),
        Parameter("column", "name of a column", *ANY, form=one_name),
        Parameter("origin", "of the column, without added noise", *ANY, searched=True),
        Parameter("reference", "of the column", *ANY, searched=True),
        Parameter("power", "of the added variance", 0.5, 8, searched=True),
    ),
    "Hold two values of that quantity. The noise of single samples must differ, and return with "
    "it.",
    "variance",
    "slope -1/2, higher while that column is",
    simulate=simulate_noise_follows,
)
LINE_FOLLOWS = Effect(
    "line_follows",
    "A spectral line whose frequency is a multiple of another logged column: the speed of a rotor "
    "or a motor. Below 1 % of the largest value of the column, there is none.",
    (
        Parameter("amplitude_dps", "deg/s", 0, INFINITE),
        Parameter("column", "name of a column", *ANY, form=one_name),
        Parameter("multiple", "Hz per unit of the column", 1e-30, 1e30, searched=True),
        Parameter(
            "apart_hz",
            "frequencies in Hz by which the line is apart from it, at even times from the first "
            "sample to the last, separated by spaces",
            *ANY,
            form=are_knots,
            default="",
            optional=True,
            searched=True,
        ),
    ),
    "Change that quantity alone. The line must move in proportion to it.",
    "mean",
    "a hump at 0.4 periods with ripples that change with that column",
    regressor=turning_with,
)
