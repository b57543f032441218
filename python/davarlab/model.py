"""The model file: TOML in, TOML out, every mistake named."""

import json
import re
import textwrap
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from . import files
from .data.recording import Recording, is_force
from .effects import table
from .effects.base import Parameter, Values
from .effects.columns import FOLLOWING
from .effects.filters import RESPONSES, half_power_hz
from .effects.means import TURNING, course_hz
from .errors import BadInput, printable
from .files import StrPath

MOST_BYTES = 1 << 20  # of a file
FIRST = (("angle_random_walk", 0.3), ("bias_instability", 5.0))  # sizes that a fit moves
COMMENT_WIDTH = 98  # of a line, with the two characters that make it a comment, 100
CUTOFF_NEAR = 0.01  # relative
HUGE = 1e100  # TOML has inf, nan and whole numbers without end


@dataclass
class Term:
    """One effect of a model with its parameters in the units of the table."""

    kind: str
    parameters: Values


@dataclass
class Model:
    rate_hz: float | None
    column: str
    terms: list[Term] = field(default_factory=list)

    @property
    def kinds(self) -> list[str]:
        return [term.kind for term in self.terms]


def checked_value(name: str, parameter: Parameter, value: Any, where: str) -> float | str:
    """The value of a parameter that a model file calls `name`."""
    if parameter.values and value in parameter.values:
        found: float | str = value
        return found
    if parameter.form and isinstance(value, str) and value:
        try:
            if parameter.form(value):
                return value
        except BadInput as why:
            raise BadInput(f"{where}: {name}: {why}") from None
    if parameter.values:
        or_else = " or a filter as --bandwidth has it" if parameter.form else ""
        raise BadInput(
            f"{where}: {name} must be one of {', '.join(map(str, parameter.values))}{or_else}"
        )
    if parameter.form:
        raise BadInput(f"{where}: {name} must be the {parameter.unit}, in quotes")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise BadInput(f"{where}: {name} must be a number")
    if not abs(value) < HUGE:
        raise BadInput(f"{where}: {name} must be a finite number")
    if not parameter.low <= value <= parameter.high:
        raise BadInput(
            f"{where}: {name} = {value:g} is outside {parameter.low:g} .. {parameter.high:g}"
        )
    if parameter.whole and value % 1:
        raise BadInput(f"{where}: {name} = {value:g} must be a whole number")
    return float(value)


def checked_term(entry: object, where: str, column: str = "") -> Term:
    """A [[effect]] entry of a model file of the column as a Term; raises BadInput for unknown kinds
    and parameters, missing and impossible values."""
    if not isinstance(entry, dict) or not isinstance(entry.get("kind"), str):
        raise BadInput(f"{where}: an effect needs a kind")
    said = entry["kind"]
    own = (kind for kind in table.TABLE if kind_said(kind, column) == said)
    effect = table.find(next(own, said), where)
    known = {name_said(parameter.name, column): parameter for parameter in effect.parameters}
    for name in entry:
        if name != "kind" and name not in known:
            raise BadInput(f"{where}: {said} has no parameter {name} (it has: {', '.join(known)})")
    missing = [
        name for name, parameter in known.items() if name not in entry and parameter.default is None
    ]
    if missing:
        raise BadInput(f"{where}: {said} needs {missing[0]}")
    values: Values = {
        p.name: checked_value(name, p, entry[name], where)
        for name, p in known.items()
        if name in entry
    }
    if "start_s" in values and values["stop_s"] < values["start_s"]:
        raise BadInput(
            f"{where}: {effect.kind}: stop_s = {values['stop_s']:g} is before start_s = "
            f"{values['start_s']:g}"
        )
    return Term(effect.kind, values)


def load_toml(path: StrPath) -> dict[str, Any]:
    try:
        with files.reading(path) as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise BadInput(f"{path}: larger than {MOST_BYTES} bytes, so it is not a model")
        return parsed(data.decode("utf-8").replace("\r\n", "\n"), path)
    except OSError as why:
        raise BadInput(f"{path}: {why.strerror}") from None
    except UnicodeDecodeError as why:
        raise BadInput(f"{path}: not TOML: {why}") from None


def parsed(text: str, path: StrPath) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except ValueError as why:  # also of a whole number of thousands of digits
        raise BadInput(f"{path}: not TOML: {why}") from None
    except RecursionError:
        raise BadInput(f"{path}: nested too deeply for a model") from None


def check_lines(terms: Iterable[Term], rate_hz: float | None, where: StrPath) -> None:
    """A line above half the sample rate cannot be told from its alias below."""
    for term in terms:
        if term.kind not in TURNING or term.kind == "line_follows":  # of a column, aliases too
            continue
        name = "course_hz" if term.kind == "drifting_line" else "frequency_hz"
        highest = (
            course_hz(term.parameters, str(where)).max()
            if name == "course_hz"
            else term.parameters[name]
        )
        if rate_hz and highest > rate_hz / 2:
            raise BadInput(
                f"{where}: {term.kind}: {name} = {highest:g} is above half the sample rate of "
                f"{rate_hz:g} Hz"
            )


def check_filters(terms: Iterable[Term], rate_hz: float | None, where: StrPath) -> None:
    """A filter that a low-pass states as its response decides where it is at -3 dB."""
    for term in terms:
        response = str(term.parameters.get("response", RESPONSES[0]))
        if not rate_hz or response in RESPONSES:
            continue
        try:
            actual = half_power_hz(response, rate_hz)
        except BadInput as why:
            raise BadInput(f"{where}: {term.kind}: response at {rate_hz:g} Hz: {why}") from None
        if abs(term.parameters["cutoff_hz"] / actual - 1) > CUTOFF_NEAR:
            raise BadInput(
                f"{where}: {term.kind}: cutoff_hz = {term.parameters['cutoff_hz']:g}, but its "
                f"response is at -3 dB at {actual:.4g} Hz: give cutoff_hz = {actual:.4g}"
            )


def check_fits(model: Model, recording: Recording, where: StrPath) -> None:
    """Raises BadInput unless the recording has the rate and the columns that the model speaks
    of."""
    rates = [recording.rate_hz, recording.read_hz or recording.rate_hz]
    if model.rate_hz and all(abs(rate / model.rate_hz - 1) > 0.05 for rate in rates):
        raise BadInput(
            f"{where}: rate_hz = {model.rate_hz:g}, but {recording.name} has "
            f"{recording.rate_hz:.6g} Hz. Remove rate_hz from the model, or fit without -m"
        )
    check_lines(model.terms, recording.rate_hz, where)
    recording.rate_dps(model.column)
    for kind in model.kinds:
        for need in table.find(kind).needs:
            if not any(name.startswith(need) for name in recording.columns):
                raise BadInput(f"{recording.name}: {kind} needs a column {need}...")


def check_noise(model: Model, where: str) -> None:
    """Raises BadInput where all noise of a model has the size 0."""
    noises = [term for term in model.terms if table.find(term.kind).role in ("spectrum", "states")]
    if noises and not any(table.find(term.kind).dps(term.parameters) for term in noises):
        raise BadInput(
            f"{where}: its noise is 0, so it cannot be compared with a recording. Use fit to find "
            "the values"
        )


def rate_of(model: Model, where: StrPath) -> float:
    """The sample rate of a model in Hz. Raises BadInput where it has none, as from a data sheet."""
    if not model.rate_hz:
        raise BadInput(
            f"{where}: the model has no rate_hz. Add rate_hz = HZ below [sensor], or give --rate "
            "HZ to davarlab sheet"
        )
    return model.rate_hz


def first(rate_hz: float | None, column: str) -> Model:
    """What one believes before anything was looked at: white noise and bias instability."""
    terms = [Term(kind, {table.find(kind).size.name: value}) for kind, value in FIRST]
    return Model(rate_hz, column, terms)


ACCEL_KINDS = {"angle_random_walk": "velocity_random_walk"}


def is_accel(column: str) -> bool:
    return column.startswith("accel_")


def in_metres(column: str) -> bool:
    """Does m/s stand for deg: the column is an accelerometer's, in a file or in the analysis."""
    return is_accel(column) or is_force(column)


def kind_said(kind: str, column: str) -> str:
    """A kind as a model file of the column calls it."""
    return ACCEL_KINDS.get(kind, kind) if in_metres(column) else kind


def name_said(name: str, column: str) -> str:
    """A parameter as a model file of the column calls it: where that is an accelerometer's, with
    m/s for deg (coefficient_m_per_s_per_sqrt_h)."""
    if not in_metres(column):
        return name
    return re.sub(r"deg(?![a-zA-Z])", "m_per_s", name).replace("dps", "mps2")


def unit_said(unit: str, column: str) -> str:
    """The unit of a gyro's parameter, for a column."""
    if not in_metres(column):
        return unit
    rates = re.sub(r"deg/s(?!\w)", "m/s^2", unit.replace("deg/s^2", "m/s^3"))
    return re.sub(r"\bdeg\b", "m/s", rates)


def terms_of(data: dict[str, Any], path: StrPath, column: str) -> list[Term]:
    entries = data.get("effect", [])
    if not isinstance(entries, list):
        raise BadInput(f"{path}: effects are written as [[effect]]")
    return [
        checked_term(entry, f"{path}: effect {i}", column) for i, entry in enumerate(entries, 1)
    ]


def table_in(data: dict[str, Any], name: str, path: StrPath) -> dict[str, Any]:
    """A [table] of the file, empty when it is absent."""
    found = data.get(name, {})
    if not isinstance(found, dict):
        raise BadInput(f"{path}: {name} is written as [{name}]")
    return found


def from_toml(data: dict[str, Any], path: StrPath) -> Model:
    """The model in a file's data. [simulate], which makes a scenario of a model, is let be."""
    for key in data:
        if key not in ("sensor", "simulate", "effect"):
            raise BadInput(f"{path}: unknown table {key}")
    sensor = table_in(data, "sensor", path)
    column, rate = sensor.get("column"), sensor.get("rate_hz")
    if not isinstance(column, str) or not column or not set(column).isdisjoint(",\n\r"):
        raise BadInput(f"{path}: [sensor] needs column, the name of the gyro column")
    if rate is not None and (
        isinstance(rate, bool) or not isinstance(rate, (int, float)) or not 0 < rate < HUGE
    ):
        raise BadInput(f"{path}: rate_hz must be a positive number")
    terms = terms_of(data, path, column)
    check_lines(terms, rate, path)
    check_filters(terms, rate, path)
    for term in terms:
        if term.kind in FOLLOWING and term.parameters["column"] == column:
            raise BadInput(f"{path}: {term.kind}: {column} cannot follow itself")
        if term.kind == "noise_follows":
            ends = term.parameters["origin"], term.parameters["reference"]
            if abs(ends[1] - ends[0]) <= 1e-9 * max(map(abs, ends)) or max(map(abs, ends)) < 1e-30:
                raise BadInput(f"{path}: noise_follows: reference must differ from origin")
    return Model(rate, column, terms)


def read(path: StrPath) -> Model:
    return from_toml(load_toml(path), path)


def of_text(text: str, where: StrPath) -> Model:
    """The model that text_of() wrote."""
    return from_toml(parsed(text, where), where)


def quoted(text: str) -> str:
    """A text as TOML, which takes no DEL as it is; JSON does."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def text_of(model: Model) -> str:
    lines = ["[sensor]"]
    if model.rate_hz:
        lines.append(f"rate_hz = {float(model.rate_hz)!r}")
    lines.append(f"column = {quoted(model.column)}")
    for term in model.terms:
        lines += ["", "[[effect]]", f'kind = "{kind_said(term.kind, model.column)}"']
        for name, value in term.parameters.items():
            text = quoted(value) if isinstance(value, str) else repr(float(value))
            lines.append(f"{name_said(name, model.column)} = {text}")
    return "\n".join(lines) + "\n"


def write(model: Model, path: StrPath, said: str = "") -> None:
    """Writes the model file. said: lines for comments in front of it."""
    files.write_whole(path, (comment(said) + text_of(model)).encode())


def comment(text: str) -> str:
    """Lines as comments of TOML, wrapped."""
    lines = [
        line for one in text.splitlines() for line in textwrap.wrap(printable(one), COMMENT_WIDTH)
    ]
    return "".join(f"# {line}\n" for line in lines)
