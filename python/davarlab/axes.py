"""Several axes of one recording in one go, accelerometers among them, and the one table of what was
found.

An accelerometer goes through the same arithmetic with m/s for deg: its white noise, in deg/sqrt(h)
of a gyro, is the velocity random walk in m/s/sqrt(h), and so on for every unit. Its column is given
to the analysis under another name, without the accelerometer beside it, so that no effect of
acceleration is looked for in acceleration itself."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .arrays import Floats
from .data.recording import Recording
from .effects import table
from .errors import BadInput
from .inference.estimate import Estimate, as_shown
from .model import Model, is_accel, kind_said, name_said
from .tables.constants import FORCE, GRAVITY_MPS2, TO_DPS, UG_PER_MPS2

TO_MPS2 = {"g": GRAVITY_MPS2, "mg": 1e-3 * GRAVITY_MPS2, "m_s2": 1.0, "mps2": 1.0}
SHOWN = {
    "deg": ("m/s", 1.0),
    "deg/h": ("ug", UG_PER_MPS2 / 3600),
    "deg/h/sqrt(h)": ("ug/sqrt(h)", UG_PER_MPS2 / 3600),
    "deg/s": ("m/s^2", 1.0),
    "deg/sqrt(h)": ("m/s/sqrt(h)", 1.0),
    "deg/h^2": ("ug/h", UG_PER_MPS2 / 3600),
}  # unit of a gyro's parameter: of an accelerometer's, factor


@dataclass
class Found:
    """One axis: its column, the exit status, what --json says of it, (model, estimates) for the
    table."""

    column: str
    status: int
    data: dict[str, Any]
    model: Model
    entries: list[dict[str, Estimate]]


def columns_of(recording: Recording, words: str) -> list[str]:
    """The columns that --axes names: gyro, accel, all, or columns, comma-separated."""
    usable = [name for name in recording.columns if unit_of(name)]
    kinds = {
        "gyro": [name for name in usable if name.startswith("gyro_")],
        "accel": [name for name in usable if is_accel(name)],
        "all": usable,
    }
    out: list[str] = []
    for word in words.split(","):
        found = kinds.get(word, [word])
        if not found or not set(found) <= set(usable):
            raise BadInput(
                f"--axes {word}: {recording.name} has no such axis (there are: "
                f"{', '.join(usable) or 'none'})"
            )
        out += found
    return list(dict.fromkeys(out))


def of_page(recording: Recording) -> list[str]:
    """The columns that a page can analyse: gyros, then accelerometers."""
    return recording.gyros + [
        name for name in recording.columns if is_accel(name) and unit_of(name)
    ]


def unit_of(name: str) -> str | None:
    """dps, rad_s, g, ..; None for a column that is neither a gyro's nor an accelerometer's."""
    units = TO_MPS2 if is_accel(name) else TO_DPS
    return next((unit for unit in units if name.endswith("_" + unit)), None)


def for_analysis(recording: Recording, model: Model) -> tuple[Recording, Model]:
    """(recording, model) as the analysis takes them."""
    if not is_accel(model.column):
        return recording, model
    recording.column(model.column)  # raises where there is none
    rows = recording.rows and (recording.rows[0], as_force(recording.rows[1], model.column))
    columns = as_force(recording.columns, model.column)
    return replace(recording, columns=columns, rows=rows, measured={}), replace(
        model, column=force_name(model.column)
    )


def as_force(columns: Mapping[str, Floats], accel: str) -> dict[str, Floats]:
    """Columns with an accelerometer in m/s^2 under the name of the analysis, without the others."""
    force = columns[accel] * TO_MPS2[unit_of(accel) or "g"]
    return {name: column for name, column in columns.items() if not is_accel(name)} | {
        force_name(accel): force
    }


def force_name(column: str) -> str:
    return f"{FORCE}{column}"


def called(model: Model, column: str) -> Model:
    """A model of the analysis, by the column of the recording."""
    return replace(model, column=column)


def said(data: Any, column: str) -> Any:
    """What --json says, with the keys and the kinds of effects as the files of the column call
    them."""
    if not is_accel(column):
        return data
    if isinstance(data, dict):
        return {key_said(name, column): said(value, column) for name, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [said(value, column) for value in data]
    return kind_said(data, column) if isinstance(data, str) else data


def key_said(key: str, column: str) -> str:
    """A key of what --json says, or several with dots between: a kind, or a quantity with its
    unit."""
    return ".".join(name_said(kind_said(name, column), column) for name in key.split("."))


def file_of(path: str | Path, column: str) -> Path:
    """OUT.toml of one axis: OUT_gyro_x.toml."""
    path, short = Path(path), "_".join(column.split("_")[:2])
    return path.with_name(f"{path.stem}_{short}{path.suffix}")


def rows_of(found: Iterable[Found]) -> dict[str, dict[str, str]]:
    """(label, {column: text}) of the table, in the order in which the effects come."""
    rows: dict[str, dict[str, str]] = {}
    for one in found:
        adequate = one.data.get("final", one.data)["adequacy"] != "no"
        for term, entry in zip(one.model.terms, as_shown(one.entries, adequate)):
            for parameter in table.find(term.kind).parameters:
                value = entry.get(parameter.name)
                if value is None or isinstance(value.value, str):
                    continue
                unit, factor = parameter.unit, 1.0
                if is_accel(one.column):
                    unit, factor = SHOWN.get(unit, (unit, 1.0))
                size = parameter is table.find(term.kind).size
                label = (
                    kind_said(term.kind, one.column)
                    + ("" if size else f" {name_said(parameter.name, one.column)}")
                    + (f" [{unit}]" if unit else "")
                )
                between = (
                    " undetermined"
                    if value.undetermined
                    else f" ({value.low * factor:.4g} .. {value.high * factor:.4g})"
                    if value.low is not None and value.high is not None
                    else ""
                )
                rows.setdefault(label, {})[one.column] = f"{value.number * factor:.4g}{between}"
    return rows


def next_steps(data: dict[str, Any]) -> list[str]:
    """Where an unexplained misfit is, and what to log or to try."""
    unknown = data.get("unknown")
    return [data["answer_said"], *unknown["next"]] if unknown else []


def text(found: Iterable[Found]) -> str:
    """The table: for each axis a row for each parameter, then what the judge says."""
    out = [f"{'axis':<14}{'effect':<44}value (95 %)"]
    rows = rows_of(found)
    for one in found:
        own = [
            (label, values[one.column]) for label, values in rows.items() if one.column in values
        ]
        out += [
            f"{one.column if place == 0 else '':<14}{label:<44}{value:<34}".rstrip()
            for place, (label, value) in enumerate(own)
        ]
        steps = one.data.get("steps") or [one.data]
        last = one.data.get("refitted") or steps[0] if len(steps) == 1 else steps[-1]
        error = (
            f", error {last['error']:.4f} (floor {last['error_floor']:.4f})"
            if "error" in last
            else ""
        )
        adequacy = one.data.get("final", one.data)["adequacy"]
        out.append(f"{'' if own else one.column:<14}{'adequacy':<44}{adequacy}{error}")
        if "missing" in one.data:  # a diagnosis
            out.append(f"{'':<14}{'missing':<44}{one.data['missing_said']}")
            out += [f"{'':<14}{'next':<44}{step}" for step in next_steps(one.data)]
    return "\n".join(out)
