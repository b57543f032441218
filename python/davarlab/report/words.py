"""Names, numbers, phrases of a report, for a page or a terminal. verdict.py has the sentences."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from ..data.recording import Recording
from ..diagnosis.improve import Estimates
from ..effects import table
from ..effects.base import Parameter
from ..errors import printable
from ..inference.estimate import Estimate
from ..model import ACCEL_KINDS, kind_said, unit_said
from ..thresholds import CHANCE, SHAPE

TINY = 1e-12  # below this a p-value says "never"; its digits are those of an approximation
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PLAIN_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
NAMES = {
    "angle_random_walk": "white noise",  # of a gyro and of an accelerometer
    "gauss_markov": "Gauss-Markov noise",
    "low_pass": "low pass of the sensor",
    "g_sensitivity": "g-sensitivity",
    "warm_up": "warm-up",
    "noise_follows": "noise that follows a column",
    "line_follows": "line that follows a column",
}

UNITS = ("dps", "s", "hz", "hour", "per")


def name(kind: str) -> str:
    return NAMES.get(kind, kind.replace("_", " "))


def named(kind: str, column: str) -> str:
    """The name of an effect of a model of the column."""
    said = kind_said(kind, column)
    return said.replace("_", " ") if kind in ACCEL_KINDS else name(kind)


def title(kind: str, parameters: Mapping[str, Any], column: str = "") -> str:
    """The name of one effect, with the number or the column that tells it from others of its
    kind."""
    if kind == "sinusoid":
        return f"line at {number(parameters['frequency_hz'], 3)} Hz"
    if kind == "narrow_band":
        return f"narrow band at {number(parameters['frequency_hz'], 3)} Hz"
    if kind == "temperature":
        return "follows temp_degC"
    if kind == "follows":
        return f"follows {parameters['column']}"
    if kind in ("noise_follows", "line_follows"):
        return f"{kind.replace('_', ' ')} {parameters['column']}"
    return named(kind, column)


def listed(kinds: Iterable[Any], shown: Callable[[Any], str] = name, joint: str = " and ") -> str:
    """Lists each kind once, in order of first appearance, with its count."""
    found = Counter(map(shown, kinds))
    names = [f"{text} ({count} times)" if count > 1 else text for text, count in found.items()]
    return (
        "nothing"
        if not names
        else names[0]
        if len(names) == 1
        else f"{', '.join(names[:-1])}{joint}{names[-1]}"
    )


def course(value: str) -> str:
    """A word of a parameter; of a list of numbers, which is the course of a frequency, its range
    and how many there are."""
    words = value.split()
    if len(words) < SHAPE.course_least:
        return value
    low, high = (f(map(float, words)) for f in (min, max))
    return f"{number(low, 5)} to {number(high, 5)} Hz ({len(words)} knots)"


def number(value: float | str | None, digits: int = 4) -> str:
    """Formats a number with `digits` significant digits and a typeset power of ten."""
    if value is None or value != value:
        return "–"
    if isinstance(value, str):
        return course(value)
    if abs(value) == float("inf"):
        return "∞" if value > 0 else "−∞"
    if value == 0 or 1e-4 <= abs(value) < 1e6:
        return (
            f"{value:.0f}" if abs(value) >= 10 ** (digits - 1) else f"{value:.{digits}g}"
        ).replace("-", "−")
    mantissa, power = f"{value:.{digits - 2}e}".split("e")
    return f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPT)}".replace("-", "−")


def bounds(estimate: Estimate) -> Callable[[float], str]:
    """Returns a formatter with enough digits to distinguish the two ends of an interval."""
    digits = next(
        (d for d in range(4, 10) if number(estimate.low, d) != number(estimate.high, d)), 9
    )
    return lambda value: number(value, digits)


def chance(p: float) -> str:
    return (
        "below 10⁻¹²"
        if p < TINY
        else f"{p:.2f}"
        if p >= 0.1
        else number(p, 3)
        if p < 1e-4
        else f"{p:.2g}"
    )


def p_is(p: float) -> str:
    """A p inside a sentence."""
    return "p < 10⁻¹²" if p < TINY else f"p = {chance(p)}"


def evidence(
    before: float, after: float | None, count: int, added: bool, alternative: bool = False
) -> str:
    """Rates one of `count` candidates from its p-values with the initial and the final model."""
    likely = before * count < CHANCE.family_wise
    if added:
        return (
            "conclusive"
            if before * count < 1e-6
            else "strong"
            if likely
            else "only with the other added effects"
        )
    if after is not None and after * count < CHANCE.family_wise:
        return "strong"
    if likely:
        return "indistinguishable from it" if alternative else "imitates an added effect"
    return "weak" if before < 0.05 else "not significant"


def label(parameter: Parameter) -> str:
    """The name of a parameter in a sentence. A coefficient needs no name."""
    words = [word for word in parameter.name.split("_") if word not in UNITS]
    return "" if words[0] == "coefficient" else " ".join(words) + " "


def response(text: str) -> str:
    """Any response of a low pass by its coefficients, which are in the model file; "": none."""
    return (
        f"of its own, {len(re.split('[:,]', text)) - 1} numbers" if text.startswith("ba:") else ""
    )


def bare_value(parameter: Parameter, estimate: Estimate) -> str:
    if isinstance(estimate.value, str):
        return label(parameter) + (response(estimate.value) or course(estimate.value))
    said = f"{label(parameter)}{number(estimate.value, 3)} {parameter.unit.split(' (')[0]}".rstrip()
    if parameter.name == "multiple":
        said += f" ({number(60 * estimate.value, 4)} times a speed in rpm)"
    return said


def value_with_interval(parameter: Parameter, estimate: Estimate) -> str:
    if estimate.low is None:
        return bare_value(parameter, estimate) + (
            " (undetermined)" if estimate.undetermined else ""
        )
    return (
        bare_value(parameter, estimate)
        + f", 95\u00a0%: {number(estimate.low, 3)} to {number(estimate.high, 3)}"
    )


def strength(
    kind: str,
    estimates: Estimates,
    column: str,
    shown: Callable[[Parameter, Estimate], str] = value_with_interval,
) -> str:
    """The fitted size and shape of an effect of a model of the column."""
    return "; ".join(
        shown(replace(p, unit=unit_said(p.unit, column)), estimates[p.name])
        for p in table.find(kind).parameters
        if p.name in estimates
    )


def clause(kind: str) -> str:
    """The physics of an effect, as a clause inside a sentence."""
    first = table.find(kind).physics.rstrip(".").split(": ")[0].split(" (")[0]
    return first[0].lower() + first[1:]


def seconds(value: float) -> str:
    """A time in seconds, from two minutes on also in minutes or hours."""
    text = f"{number(value, 3)} s"
    if value < 120:
        return text
    return (
        f"{text} ({number(value / 60, 2)} min)"
        if value < 7200
        else f"{text} ({number(value / 3600, 2)} h)"
    )


def brief(value: float) -> str:
    """A time of two digits, in s, min or h."""
    size, unit = (1, "s") if value < 120 else (60, "min") if value < 7200 else (3600, "h")
    return f"{number(value / size, 2)} {unit}"


def factor(ratio: float) -> str:
    return f"{max(ratio, 1 / max(ratio, 1e-9)):.3g}"


def away(ratio: float) -> str:
    """How far a ratio is from 1, up or down alike."""
    far = max(ratio, 1 / max(ratio, 1e-9))
    return f"{far:.1f}\N{MULTIPLICATION SIGN}" if far >= 1.1 else f"{100 * (far - 1):.2g} %"


def times(ratio: float) -> str:
    if 0.9 < ratio < 1.1:
        return f"{100 * abs(ratio - 1):.2g} % {'above' if ratio > 1 else 'below'} the model"
    return f"{ratio:.2g} times the model"


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def gap_note(recording: Recording) -> str | None:
    """A note on how gaps affect the results; None without gaps."""
    if not len(recording.gaps):
        return None
    missing = recording.samples - recording.measured_samples
    return (
        f"The recording has {len(recording.gaps)} gaps with {missing} missing "
        "samples. No Allan deviation spans a gap, so long averaging times use less data."
    )


def in_c_comment(text: str) -> str:
    """A text of somebody, such as a file name, that a comment in C can hold in one line."""
    return printable(text).replace("*/", "* /").replace("/*", "/ *")


def in_ascii(text: str) -> str:
    """Replaces every character outside ASCII, for terminals of any encoding."""
    text = re.sub("·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda found: "e" + found[1].translate(PLAIN_DIGITS), text)
    return (
        text.replace("\u00a0", " ")
        .replace("−", "-")
        .replace("–", "-")
        .replace("∞", "inf")
        .replace("10⁻¹²", "1e-12")
    )
