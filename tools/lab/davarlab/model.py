"""The model file: TOML in, TOML out, every mistake named."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from .effects import table
from .errors import BadInput


@dataclass
class Term:
    """One effect of a model with its parameters in the units of the table."""
    kind: str
    parameters: dict


@dataclass
class Model:
    rate_hz: float | None
    column: str
    terms: list = field(default_factory=list)

    @property
    def kinds(self):
        return [term.kind for term in self.terms]


def checked_value(effect, parameter, value, where):
    if parameter.values:
        if value not in parameter.values:
            raise BadInput(f"{where}: {parameter.name} must be one of {', '.join(parameter.values)}")
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise BadInput(f"{where}: {parameter.name} must be a number")
    if not parameter.low <= value <= parameter.high:
        raise BadInput(f"{where}: {parameter.name} = {value:g} is outside {parameter.low:g} .. {parameter.high:g}")
    return float(value)


def checked_term(entry, where):
    """A [[effect]] entry as a Term; raises BadInput for unknown kinds and parameters, missing and impossible values."""
    if not isinstance(entry, dict) or "kind" not in entry:
        raise BadInput(f"{where}: an effect needs a kind")
    effect = table.find(entry["kind"], where)
    known = {parameter.name: parameter for parameter in effect.parameters}
    for name in entry:
        if name != "kind" and name not in known:
            raise BadInput(f"{where}: {effect.kind} has no parameter {name} (it has: {', '.join(known)})")
    missing = [name for name, parameter in known.items() if name not in entry and parameter.default is None]
    if missing:
        raise BadInput(f"{where}: {effect.kind} needs {missing[0]}")
    return Term(effect.kind, {name: checked_value(effect, p, entry[name], where) for name, p in known.items()
                              if name in entry})


def load_toml(path):
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as why:
        raise BadInput(f"{path}: {why.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as why:
        raise BadInput(f"{path}: not TOML: {why}") from None


def terms_of(data, path):
    entries = data.get("effect", [])
    if not isinstance(entries, list):
        raise BadInput(f"{path}: effects are written as [[effect]]")
    return [checked_term(entry, f"{path}: effect {i}") for i, entry in enumerate(entries, 1)]


def read(path):
    data = load_toml(path)
    sensor = data.get("sensor", {})
    for key in data:
        if key not in ("sensor", "effect"):
            raise BadInput(f"{path}: unknown table {key}")
    if not isinstance(sensor.get("column"), str):
        raise BadInput(f"{path}: [sensor] needs column, the name of the gyro column")
    rate = sensor.get("rate_hz")
    if rate is not None and (isinstance(rate, bool) or not isinstance(rate, (int, float)) or not rate > 0):
        raise BadInput(f"{path}: rate_hz must be a positive number")
    return Model(rate, sensor["column"], terms_of(data, path))


def text_of(model):
    lines = ["[sensor]"]
    if model.rate_hz:
        lines.append(f"rate_hz = {float(model.rate_hz)!r}")
    lines.append(f'column = "{model.column}"')
    for term in model.terms:
        lines += ["", "[[effect]]", f'kind = "{term.kind}"']
        lines += [f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {float(value)!r}"
                  for name, value in term.parameters.items()]
    return "\n".join(lines) + "\n"


def write(model, path):
    try:
        Path(path).write_text(text_of(model), encoding="utf-8")
    except OSError as why:
        raise BadInput(f"{path}: {why.strerror}") from None
