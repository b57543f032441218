"""What the columns of somebody's log are: names, units and factors, guessed from what they are
called and from their numbers."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
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
)


@dataclass
class Guess:
    """A column of the file: what it is (time, gyro, accel, temp, other), its axis, its unit, and
    the factor to s, deg/s, g or degC."""

    name: str
    quantity: str
    axis: str = ""
    unit: str = ""
    factor: float = 1.0
    sure: bool = True

    @property
    def column(self) -> str:
        """The name that davarlab gives it."""
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
    return ordered


def weighed(found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """Gravity is 1 g: whatever the accelerometer's numbers are, at rest their norm tells the
    unit."""
    unsaid = [guess for guess in found if guess.quantity == "accel" and not guess.sure]
    if len(unsaid) != 3:
        return
    norm = float(np.sqrt(sum(np.mean(columns[guess.name]) ** 2 for guess in unsaid)))
    unit = next((unit for unit, one in FORCES.items() if 0.8 < norm * one < 1.25), "counts")
    for guess in unsaid:
        guess.unit, guess.factor = unit, FORCES.get(unit, 1 / norm if norm else 1.0)
