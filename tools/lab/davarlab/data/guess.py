"""What the columns of somebody's log are: names, units and factors, guessed from what they are
called and from their numbers."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Floats

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
RATES = {"deg/s": 1.0, "mdeg/s": 1e-3, "rad/s": 180 / np.pi}
FORCES = {"g": 1.0, "mg": 1e-3, "m/s^2": 1 / 9.80665}
DEGREES = {"degC": 1.0, "0.01 degC": 0.01}
UNITS = {
    "time": SECONDS,
    "gyro": RATES,
    "accel": FORCES,
    "temp": DEGREES,
}  # factor to s, deg/s, g, degC; of counts a person must say it
AXES = {
    "x": "x",
    "y": "y",
    "z": "z",
    "0": "x",
    "1": "y",
    "2": "z",
    "roll": "x",
    "pitch": "y",
    "yaw": "z",
}
# Scatter from sample to sample, below which a rate without a unit is in rad/s: 0.3 deg/s are a bad
# gyro's.
QUIET_RAD = 0.006
ARW = (0.03, 5.0)  # deg/sqrt(h), of MEMS gyros at rest
# Least time from sample to sample, for rates up to 10 kHz.
STEPS = (("ns", 1e5), ("us", 50.0), ("ms", 0.5), ("s", 0.0))
WORDS = {
    "time": r"^(time|times|datetime|timestamp|stamp|t|clock|secs?|seconds|us|ms|ns|[umn]secs?"
    r"|micros|millis|nanos|(micro|milli|nano)seconds)$",
    "gyro": r"^(gyr|gyro|gyros|giro|gyroscope|omega|w|g[xyz]|w[xyz]|gyr[xyz]|gyro[xyz]"
    r"|angvel|angular|rate|p|q|r)$",
    "accel": r"^(a|acc|accel|accelerometer|acceleration|specific|a[xyz]|acc[xyz]|accel[xyz])$",
    "temp": r"^(temp|temps|temperature|temperatura|degc|celsius|imutemp)$",
}
# Median norm of an accelerometer without gravity, in m/s^2 or g.
LINEAR = 0.5
ARW_LEAST_S = 20.0
HALF_OF_NORMAL = 0.6745  # of a standard deviation: the median of the magnitude
# Means over so many seconds; turned in all at least by so much; squared correlation at least.
GRAVITY_S, TURNED_RAD, GRAVITY_AGREES = 0.25, 1.0, 0.5
STAMP = r"^(time|times|timestamp|timestamps|stamp|stamps)$"
DEGREE = re.compile(
    "[\u00b0\u00ba\ufffd](?=/s)"
)  # the sign, and what is left of it in another encoding
# The power of a unit, which is no axis: [rad s^-1], m/s^2.
POWER = re.compile(r"(?<=[sm])\^?-\d|\^-?\d")
SAID = (
    ("mdeg/s", r"mdps|mdeg"),
    ("rad/s", r"rad"),
    ("deg/s", r"dps|deg"),
    ("m/s^2", r"m_?s_?2|mps2|m/s|m[ .*\u00b7]?s\^?-2"),
    ("mg", r"(^|[^a-z])mg($|[^a-z])"),
    ("g", r"(^|[^a-z])g($|[^a-z])"),
    ("counts", r"raw|lsb|count|adc"),
    ("ns", r"n(s|secs?)\]?\)?$|(^|[^a-z])ns[^a-z]|nano"),
    ("us", r"(u|\u00b5|\u03bc)(s|secs?)\]?\)?$|(^|[^a-z])us[^a-z]|micro\w*\]?\)?$"),
    ("ms", r"(m(s|secs?)|milli\w*)\]?\)?$|(^|[^a-z])ms[^a-z]"),
    ("s", r"(^|[^a-z])(s|secs?|seconds?)\]?\)?$"),
    # Of sensor_msgs/Imu, where nothing else is said.
    ("rad/s", r"angular_?velocity"),
    ("m/s^2", r"linear_?acceleration"),
)


@dataclass
class Guess:
    """A column of the file: what it is (time, gyro, accel, temp, other), its axis, its unit, and
    the factor to s, deg/s, g or degC. how: what says the unit; doubt: another one is as likely, in
    words."""

    name: str
    quantity: str
    axis: str = ""
    unit: str = ""
    factor: float = 1.0
    sure: bool = True
    how: str = ""
    doubt: str = ""

    @property
    def column(self) -> str:
        """The name that davarlab gives it."""
        if self.quantity == "accel" and not self.unit:
            return self.name
        return {
            "time": "time_s",
            "gyro": f"gyro_{self.axis}_dps",
            "accel": f"accel_{self.axis}_g",
            "temp": "temp_degC",
        }.get(self.quantity, self.name)


def without_powers(name: str) -> str:
    """A name of the same length without the powers of its unit."""
    return POWER.sub(lambda found: " " * len(found.group()), name)


def tokens(name: str) -> list[str]:
    spaced = re.sub(r"([a-z])([A-Z])", r"\1 \2", name)
    return [token for token in re.split(r"[^A-Za-z0-9]+", spaced.lower()) if token]


def quantity_of(name: str) -> str:
    """time, gyro, accel, temp or other: by the first word that says one of them."""
    words = tokens(name)
    if "phase" in words:  # of a clock; its unit is one of time
        return "other"
    if (
        words
        and (words[0] == "t" or any(re.match(STAMP, word) for word in words))
        and not axis_of(name)
    ):  # t_gyro, gyro_time
        return "time"
    for quantity in ("gyro", "accel", "temp", "time"):
        if any(re.match(WORDS[quantity], word) for word in words):
            return quantity
    return "other"


def axis_of(name: str) -> str:
    words = tokens(without_powers(name))
    for word in reversed(words):
        if word in AXES:
            return AXES[word]
    last = next(
        (word[-1] for word in words if re.match(r"^(gyro?|w|g|a|acc|accel)[xyz]$", word)), ""
    )
    return last or {"p": "x", "q": "y", "r": "z"}.get(words[-1] if words else "", "")


def said_unit(name: str, quantity: str) -> str:
    found = [unit for unit, pattern in SAID if re.search(pattern, DEGREE.sub("deg", name.lower()))]
    return next(
        (
            unit
            for unit in found
            if unit in UNITS[quantity] or unit == "counts" and quantity in ("gyro", "accel")
        ),
        "",
    )


def whole(values: Floats) -> bool:
    return bool(np.all(values == np.round(values)) and np.ptp(values) > 20)


def unit_by_numbers(quantity: str, values: Floats) -> tuple[str, float]:
    """(unit, factor) where the name says none."""
    if quantity == "time":
        step = float(np.median(np.diff(values))) if len(values) > 1 else 0.01
        unit = next(unit for unit, least in STEPS if step >= least) if whole(values) else "s"
    elif whole(values):
        return "counts", 1.0
    elif quantity == "gyro":
        unit = "rad/s" if np.std(np.diff(values)) / np.sqrt(2) < QUIET_RAD else "deg/s"
    elif quantity == "temp":
        unit = "0.01 degC" if abs(np.mean(values)) > 500 else "degC"
    else:
        unit = "g"
    return unit, UNITS[quantity][unit]


def units_of(name: str, values: npt.ArrayLike) -> dict[str, str]:
    """quantity -> the unit that a column would have if it were one."""
    values = np.asarray(values, float)
    told = {quantity: said_unit(name, quantity) for quantity in UNITS}
    rising = bool(np.all(np.diff(values) >= 0))
    return {
        quantity: told[quantity]
        or ("s" if quantity == "time" and not rising else unit_by_numbers(quantity, values)[0])
        for quantity in UNITS
    }


def of_column(name: str, values: Floats) -> Guess:
    """The guess for one column; of one that cannot be told it stays `other`, by its own name."""
    quantity, axis = quantity_of(name), axis_of(name)
    if (
        quantity == "other"
        or quantity in ("gyro", "accel")
        and not axis
        or quantity == "time"
        and not np.all(np.diff(values) >= 0)
    ):
        return Guess(name, "other")
    unit = said_unit(name, quantity)
    if unit == "counts" or not unit:
        found, factor = ("counts", 1.0) if unit else unit_by_numbers(quantity, values)
        return Guess(name, quantity, axis, found, factor, quantity == "temp" and found == "degC")
    return Guess(name, quantity, axis, unit, UNITS[quantity][unit])


def of(columns: Mapping[str, npt.NDArray[Any]]) -> list[Guess]:
    """Guesses for the columns of a file (name -> numbers), in their order: one time, one
    temperature, one of each axis; the norm of the accelerometer says its unit where its name does
    not."""
    found, taken = {}, set()
    guesses = [of_column(name, np.asarray(values, float)) for name, values in columns.items()]
    for guess in sorted(
        guesses, key=lambda guess: guess.column != guess.name
    ):  # who bears a name already keeps it
        if guess.quantity != "other" and guess.column in taken:
            guess = Guess(guess.name, "other")
        taken.add(guess.column)
        found[guess.name] = guess
    ordered = [found[name] for name in columns]
    weighed(ordered, columns)
    measured(ordered, columns)
    return ordered


def weighed(found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """Gravity is 1 g: whatever the accelerometer's numbers are, its norm tells the unit. Without
    gravity nothing tells it, and the columns keep their names."""
    unsaid = [guess for guess in found if guess.quantity == "accel" and not guess.sure]
    if len(unsaid) != 3:
        return
    axes = np.array([columns[guess.name] for guess in unsaid], float)
    norm = float(np.median(np.linalg.norm(axes, axis=0)))
    unit = next((unit for unit, one in FORCES.items() if 0.8 < norm * one < 1.25), "counts")
    linear = unit == "counts" and norm < LINEAR and not all(map(whole, axes))
    for guess in unsaid:
        guess.unit, guess.factor = unit, FORCES.get(unit, 1 / norm if norm else 1.0)
        if linear:
            guess.unit, guess.factor = "", 1.0
            guess.doubt = (
                f"linear acceleration: gravity is missing in it (its norm is {norm:.2g}), so its "
                "unit is not known and it is not used (--unit accel=m/s^2 or g uses it)"
            )


def measured(found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """The unit of a gyro whose name says none: gravity that turns as it says, the unit of the
    accelerometer beside it, or its noise, if a gyro can have that in one unit only."""
    unsaid = [
        guess
        for guess in found
        if guess.quantity == "gyro" and not guess.sure and guess.unit in ("deg/s", "rad/s")
    ]
    if not unsaid:
        return
    unit, how = by_gravity(unsaid, found, columns)
    if not unit and any(one.quantity == "accel" and one.unit == "m/s^2" for one in found):
        unit, how = "rad/s", "the accelerometer in m/s^2 beside it"
    arw = arw_of(unsaid, found, columns)
    able = [one for one in ("deg/s", "rad/s") if arw and ARW[0] < arw * RATES[one] < ARW[1]]
    if not unit and len(able) == 1:
        unit, how = able[0], f"its noise of {arw * RATES[able[0]]:.2g} deg/sqrt(h)"
    for one in unsaid:
        one.unit, one.how = unit or one.unit, how
        one.factor = RATES[one.unit]
        if not unit:
            said = (
                f"in deg/s, its angle random walk would be {arw:.2g} deg/sqrt(h), in rad/s "
                f"{arw * RATES['rad/s']:.2g}"
                if arw
                else "nothing tells it"
            )
            one.doubt = (
                f"the unit of the gyro is not known ({said}). Use --unit gyro=rad/s or --unit "
                "gyro=deg/s"
            )


def arw_of(
    gyros: list[Guess], found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]
) -> float:
    """The quietest axis's angle random walk in deg/sqrt(h) if it is in deg/s, from the usual
    difference of neighbouring means over 1 s, which no filter of the sensor takes away; 0 without a
    time, or below 20 s."""
    time = next((one for one in found if one.quantity == "time"), None)
    if time is None:
        return 0.0
    seconds = np.asarray(columns[time.name], float) * time.factor
    span = float(seconds[-1] - seconds[0])
    if not span > ARW_LEAST_S:
        return 0.0
    together = max(1, round(len(seconds) / span))
    count = len(seconds) // together
    means = [
        np.asarray(columns[one.name], float)[: count * together].reshape(count, -1).mean(axis=1)
        for one in gyros
    ]
    usual = min(float(np.median(np.abs(np.diff(one)))) / HALF_OF_NORMAL for one in means)
    return 60 * usual / float(np.sqrt(2)) * float(np.sqrt(span / count))


def by_gravity(
    gyros: list[Guess], found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]
) -> tuple[str, str]:
    """(unit, what says it): the direction u of gravity in the sensor turns by -w x u a second, w in
    rad/s. ("", "") where it does not turn enough, or not as the gyro says."""
    time = next((one for one in found if one.quantity == "time"), None)
    force = {one.axis: one for one in found if one.quantity == "accel"}
    rate = {one.axis: one for one in gyros}
    if time is None or set(force) != set("xyz") or set(rate) != set("xyz"):
        return "", ""
    seconds = np.asarray(columns[time.name], float) * time.factor
    w, a = (
        np.array([columns[of[axis].name] * of[axis].factor for axis in "xyz"], float)
        for of in ({axis: replace(one, factor=1.0) for axis, one in rate.items()}, force)
    )
    step = float(np.median(np.diff(seconds))) if len(seconds) > 1 else 0.0
    together = int(GRAVITY_S / step) if step > 0 else 0
    if not 1 <= together <= a.shape[1] // 4:
        return "", ""
    count = a.shape[1] // together
    a, w = (x[:, : count * together].reshape(3, count, together).mean(axis=2) for x in (a, w))
    u = a / np.maximum(np.linalg.norm(a, axis=0), 1e-12)
    middle, between = (u[:, 1:] + u[:, :-1]) / 2, (w[:, 1:] + w[:, :-1]) / 2
    said = -np.cross(between, middle, axis=0) * together * step
    turned = np.diff(u, axis=1)
    if np.linalg.norm(turned, axis=0).sum() < TURNED_RAD:
        return "", ""
    both = float(np.sum(said * turned))
    sizes = float(np.sum(said**2)), float(np.sum(turned**2))
    if both**2 < GRAVITY_AGREES * sizes[0] * sizes[1]:
        return "", ""
    slope = abs(both) / sizes[0]
    for unit, factor in (("rad/s", 1.0), ("deg/s", np.pi / 180)):
        if 0.5 < slope / factor < 2:
            return unit, f"gravity, which turns as it says (slope {slope / factor:.2f})"
    return "", ""
