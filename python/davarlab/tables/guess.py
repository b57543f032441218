"""What one column of a log is: quantity, axis and unit, by its name and by its own numbers."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Floats
from ..files import StrPath
from ..thresholds import GUESS
from .constants import DEG_PER_RAD, GRAVITY_MPS2

SECONDS = {"s": 1.0, "ms": 1e-3, "0.1ms": 1e-4, "10us": 1e-5, "us": 1e-6, "100ns": 1e-7, "ns": 1e-9}
RATES = {"deg/s": 1.0, "mdeg/s": 1e-3, "rad/s": DEG_PER_RAD}
FORCES = {"g": 1.0, "mg": 1e-3, "m/s^2": 1 / GRAVITY_MPS2}
DEGREES = {"degC": 1.0, "0.01 degC": 0.01}
Known = Mapping[str, tuple[str, float, str]]  # column or quantity -> unit, factor, found by what
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
# A decoded blackbox log: the gyro after its filters (ADC) and before them (Unfilt of Betaflight,
# Raw of INAV, RAW of Rotorflight), whole deg/s; without a place, all three axes.
BLACKBOX = re.compile(r"gyro(ADC|Unfilt|Raw|RAW)\[[012]?\]")
TICK_OF_XSENS = "sampletimefine"  # of an MTi 0.1 ms, of a Movella DOT 1 us
WORDS = {
    "time": r"^(time|times|zeit|tiempo|tempo|datetime|timestamp|stamp|t|clock|elapsed|secs?|seconds"
    r"|us|ms|ns|[umn]secs?|micros|millis|nanos|(micro|milli|nano)sec(ond)?s?|chiptime|gpst|tow"
    r"|sow)$",
    "gyro": r"^([xyz]?(gyr|gyros?|giro|gyroscope)\d*[xyz]?\d*|[gw][xyz]\d*|w|omega[xyz]?\d*"
    r"|angvel[xyz]?|angular|pqr|wb|rate|(roll|pitch|yaw)(speed|rate))$",
    "accel": r"^([xyz]?(acc|accel|accelerometer|acceleration)\d*[xyz]?\d*|a[xyz]\d*|a|fb"
    r"|specific)$",
    "temp": r"^(temp|temps|temperature|temperatura|degc|celsius|imutemp)$",
}
# The axis within a word: gx, accy2, x1, xgyro, yawspeed.
JOINED = re.compile(
    r"([xyz]?)(?:gyr|gyros?|giro|gyroscope|omega|angvel|acc|accel|accelerometer|acceleration|[gwa])"
    r"\d*([xyz]?)\d*|([xyz])\d+|(roll|pitch|yaw)(?:speed|rate)"
)
LETTER = re.compile(r"(?<![A-Za-z])([agw][XYZ]|degC)(?![A-Za-z])")  # gX is one word
# T(\u00b0), T [C], t_degC: no time.
CELSIUS = re.compile(
    r"t[ _]*[\[(]?[ _]*([\u00b0\u00ba\ufffd] ?c?|c|deg ?c|celsius)[\])]?", re.IGNORECASE
)
BODY = {"p": "x", "q": "y", "r": "z"}  # rates of a body, where a name says nothing else
# Words of what is computed, wanted or another vector, and no measured rate or acceleration.
UNMEASURED = re.compile(
    r"setpoints?|sp|command(ed)?|cmd|desired|demand(ed)?|target|bias|drift|offset|gravity|grav"
    r"|variance|var|std|stddev|cov|covariance\d*|mag|magn|magnetic|magnetometer"
)
TERMS = re.compile(r"axis ?[pidfs]\b")  # of a PID controller (Betaflight)
# Units that nothing else on an axis has, as they are written in names.
ONLY = (
    (
        "gyro",
        re.compile(
            r"((?<![a-z])(rad(ians?)?|deg(rees?)?|d)( ?/ ?|[ _.*\u00b7]| per |_per_)"
            r"(s|sec|seconds?)(\^?-1)?|(?<![a-z])m?dps)(?![a-z0-9^\u00b2/])"
        ),
    ),
    ("accel", re.compile(r"(?<![a-z])m ?/ ?s ?(\^2|2|\u00b2)(?![a-z0-9])|m_s2|mps2")),
)
IN_G = re.compile(r"[xyz]([ _-]?axis)? ?[\[(]m?g[\])]")  # alone: [mg] may be milligauss
UNIT_WORDS = {"dps", "deg", "rad", "s", "g", "ms", "m", "s2", "mps2", "raw", "counts", "lsb"}
# What is x, y, z (or xyz[0], [1], [2]) in a file, by its name.
FILES = (
    ("gyro", re.compile(r"\b(gyr|gyro\w*|giro|rotation rate|angular (velocity|rate)|angvel)\b")),
    ("accel", re.compile(r"\b(acc\d*|accel\w*|linear)\b")),
)
NEUTRAL = {"axis", "value", "values", "data", "uncalib", "uncalibrated", "calibrated"} | UNIT_WORDS
# Columns that only these loggers write beside x, y, z in rad/s and m/s^2; on a telephone of Apple,
# the uncalibrated accelerometer of the first is in g.
LOGGERS = {
    "seconds_elapsed": "Sensor Logger",
    "timestamp_sample": "PX4",
    "device_id": "PX4",
}
DOCUMENTED = {"gyro": "rad/s", "accel": "m/s^2"}
STAMP = r"^(time|times|timestamp|timestamps|stamp|stamps)$"
DEGREE = re.compile(
    "[\u00b0\u00ba\ufffd](?=/s)"
)  # the sign, and what is left of it in another encoding
# The power of a unit, which is no axis: [rad s^-1], m/s^2.
POWER = re.compile(r"(?<=[sm])\^?-\d|\^-?\d")
SAID = (
    ("mdeg/s", r"mdps|mdeg"),
    ("rad/s", r"rad"),
    ("deg/s", r"dps|deg|(^|[^a-z])d/s"),
    ("m/s^2", r"m_?s_?2|mps2|m/s|m[ .*\u00b7]?s\^?-2"),
    ("mg", r"(^|[^a-z])mg($|[^a-z])"),
    ("g", r"(^|[^a-z])g($|[^a-z])"),
    ("counts", r"raw|lsb|count|adc"),
    ("0.1ms", r"(^|[^\d.])(0\.1 ?m|100 ?[u\u00b5\u03bc])s"),
    ("10us", r"(^|[^\d.])(0\.01 ?m|10 ?[u\u00b5\u03bc])s"),
    ("100ns", r"(^|[^\d.])(0\.1 ?[u\u00b5\u03bc]|100 ?n)s"),
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
    the factor to s, deg/s, g or degC. by: what the unit was found by, where that is not simply the
    name or the numbers; doubt: why it may be another, with the next step, "" without a reason;
    unused: why the column keeps its name, though it is known what it is."""

    name: str
    quantity: str
    axis: str = ""
    unit: str = ""
    factor: float = 1.0
    sure: bool = True
    by: str = ""
    doubt: str = ""
    unused: str = ""

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
    name = LETTER.sub(lambda found: found.group().lower(), name)
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", name)
    return [token for token in re.split(r"[^A-Za-z0-9]+", spaced.lower()) if token]


def quantity_of(name: str) -> str:
    """time, gyro, accel, temp or other: by the first word that says one of them, else by a unit
    that nothing else on an axis has."""
    words = tokens(name)
    if "phase" in words:  # of a clock; its unit is one of time
        return "other"
    if CELSIUS.fullmatch(name.strip()):
        return "temp"
    if (
        words
        and (words[0] == "t" or any(re.match(STAMP, word) for word in words))
        and not axis_of(name)
    ):  # t_gyro, gyro_time
        return "time"
    for quantity in ("gyro", "accel", "temp", "time"):
        if quantity == "time" and "per" in words:  # of a rate: RadPerSec
            continue
        if any(re.match(WORDS[quantity], word) for word in words):
            return quantity if quantity in ("temp", "time") or measured(words) else "other"
    if not axis_of(name) or not measured(words):
        return "other"
    if body_rate(words):
        return "gyro"
    text = DEGREE.sub("deg", name.lower())
    found = [quantity for quantity, unit in ONLY if unit.search(text)]
    return next(iter(found), "accel" if IN_G.fullmatch(text) else "other")


def measured(words: Sequence[str]) -> bool:
    """May words of a gyro or an accelerometer be those of a measured rate or acceleration."""
    turned = "angular" in words and any(word.startswith("accel") for word in words)
    return (
        not turned
        and not any(map(UNMEASURED.fullmatch, words))
        and not TERMS.match(" ".join(words))
    )


def body_rate(words: Sequence[str]) -> str:
    """The axis of a name that ends in p, q or r, but for its unit; "" of others."""
    last = [word for word in words if word not in UNIT_WORDS][-1:]
    return BODY.get(last[0], "") if last else ""


def axis_of(name: str) -> str:
    """x, y or z: by a letter or a word, else by p, q, r or 0, 1, 2; "" where a name has none."""
    words = tokens(without_powers(name))
    for word in reversed(words):
        if word in AXES and not word.isdigit():
            return AXES[word]
    for word in words:
        found = JOINED.fullmatch(word)
        axis = next(filter(None, found.groups()), "") if found else ""
        if axis:
            return AXES[axis]
    digit = next((word for word in reversed(words) if word in AXES), "")
    return AXES.get(digit, "") or body_rate(words)


def in_file(path: StrPath) -> str:
    """gyro or accel, where the name of a file says that it is of one of them; "" else."""
    words = tokens(Path(path).name)
    text = " ".join(words)
    found = [quantity for quantity, pattern in FILES if pattern.search(text)]
    return found[0] if len(found) == 1 and measured(words) else ""


def by_file(names: Sequence[str], path: StrPath) -> tuple[list[str], str]:
    """(names of columns, what was done in words): x, y, z of a file whose name says what they are
    are called so, where no other column is."""
    quantity = in_file(path)
    if not quantity or any(quantity_of(name) == quantity and axis_of(name) for name in names):
        return list(names), ""
    unit, logger = "", next((LOGGERS[name] for name in names if name in LOGGERS), "")
    if logger and (quantity == "gyro" or "uncalibrated" not in tokens(Path(path).name)):
        unit = DOCUMENTED[quantity]
    made = [called(name, quantity, unit) for name in names]
    met = [name for name, new in zip(names, made) if name != new]
    if not met:
        return made, ""
    how = f", {unit} by the documentation of {logger}" if unit else ""
    return made, f"{', '.join(met)}: {quantity} by the file's name{how}"


def called(name: str, quantity: str, unit: str = "") -> str:
    """The name of a column that says no more than an axis, with the quantity and the unit; any
    other as it is."""
    words = [word for word in tokens(without_powers(name)) if word not in NEUTRAL]
    if quantity_of(name) != "other" or words not in (["x"], ["y"], ["z"]):
        if words[:1] != ["xyz"] or len(words) != 2 or words[1] not in AXES:
            return name
        name = AXES[words[1]]
    said = f" [{unit}]" if unit and not said_unit(name, quantity) else ""
    return f"{quantity}_{name}{said}"


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


def scatter_of(values: npt.NDArray[Any]) -> float:
    return float(np.std(np.diff(np.asarray(values, float))) / np.sqrt(2))


def unit_by_numbers(quantity: str, values: Floats) -> tuple[str, float]:
    """(unit, factor) where the name says none."""
    if quantity == "time":
        step = float(np.median(np.diff(values))) if len(values) > 1 else 0.01
        unit = (
            next(unit for unit, least in GUESS.least_steps if step >= least)
            if whole(values)
            else "s"
        )
    elif whole(values):
        return "counts", 1.0
    elif quantity == "gyro":
        unit = "rad/s" if scatter_of(values) < GUESS.quiet_rad else "deg/s"
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


def agrees(unit: str, values: Floats, rate_hz: float) -> bool:
    """Do stamps in this unit have a stated rate: by their median or their mean step, to within a
    tenth, or to within a count of whole ones."""
    steps = np.diff(values)
    wanted = 1 / (rate_hz * SECONDS[unit])
    near = max(GUESS.rate_near * wanted, 0.999 if whole(values) and wanted >= 1 else 0.0)
    return any(abs(step - wanted) <= near for step in (np.median(steps), np.mean(steps)))


def of_time(name: str, values: Floats, rates: Sequence[float]) -> Guess:
    """The guess for a time without a unit in its name. rates: in Hz, as the file states them."""
    unit, step = unit_by_numbers("time", values)[0], float(np.median(np.diff(values)))
    by = doubt = ""
    if TICK_OF_XSENS in "".join(tokens(name)):
        usual = "us" if step * SECONDS["0.1ms"] > GUESS.slowest_mti_s else "0.1ms"
        stated = (one for one in ("0.1ms", "us") for rate in rates if agrees(one, values, rate))
        unit, by = next(stated, usual), "by the documentation of Xsens"
    elif rates and step > 0:
        fitting = [one for rate in rates for one in SECONDS if agrees(one, values, rate)]
        usual_hz = GUESS.usual_hz[0] <= 1 / (step * SECONDS[unit]) <= GUESS.usual_hz[1]
        if not fitting or usual_hz and unit not in fitting:
            doubt = contradicted(step, unit, rates[0])
        elif unit not in fitting:
            unit = fitting[0]
            by = f"by the stated rate of {' or '.join(f'{rate:g}' for rate in rates)} Hz"
    elif step > 0 and whole(values):
        doubt = unusual(step, unit)
    return Guess(name, "time", "", unit, SECONDS[unit], False, by, doubt)


def contradicted(step: float, unit: str, rate_hz: float) -> str:
    """What is doubtful about stamps that have a stated rate in no usual unit."""
    return (
        f"a rate of {rate_hz:g} Hz is stated, but the time stamps are {step:.6g} apart, which is "
        f"{1 / (step * SECONDS[unit]):.5g} Hz in {unit}. Use --unit time=UNIT"
    )


def unusual(step: float, unit: str) -> str:
    """What is doubtful about whole stamps that give a rate that a log rarely has in this unit, and
    a usual one in another; "" where nothing is."""
    rates = {one: 1 / (step * size) for one, size in SECONDS.items()}
    usual = [one for one, rate in rates.items() if GUESS.usual_hz[0] <= rate <= GUESS.usual_hz[1]]
    if rates[unit] <= GUESS.usual_hz[1] or not usual:
        return ""
    others = ", ".join(f"{rates[one]:.5g} Hz in {one}" for one in usual)
    return (
        f"the time stamps are whole numbers, {step:.6g} apart, which is {rates[unit]:.5g} Hz in "
        f"{unit}, but {others}. Use --unit time=UNIT"
    )


def of_column(name: str, values: Floats, rates: Sequence[float] = ()) -> Guess:
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
    if BLACKBOX.fullmatch(name):
        return Guess(name, quantity, axis, "deg/s", by="by the documentation of Betaflight")
    if quantity == "time" and not unit and len(values) > 1:
        return of_time(name, values, rates)
    if unit == "counts" or not unit:
        found, factor = ("counts", 1.0) if unit else unit_by_numbers(quantity, values)
        return Guess(name, quantity, axis, found, factor, quantity == "temp" and found == "degC")
    return Guess(name, quantity, axis, unit, UNITS[quantity][unit])
