"""The model as a table for the device: C for the firmware's monitor, CSV for davar-sim
--model-table."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..errors import BadInput
from ..inference import allan
from ..inference.parts import part_of, spectrum_of
from ..model import Model, is_accel, kind_said, name_said, rate_of
from .words import in_c_comment

DEVICE_ROLES, DEVICE_KINDS = ("spectrum", "states", "filter"), ("rate_ramp", "sinusoid")


def noise_variance(model: Model, taus: Sequence[int], rate_hz: float) -> Floats:
    """Allan variance of the stationary part of a model and of its ramp and lines; what a static
    device sees."""
    pairs = [(part_of(term), term.parameters) for term in model.terms]
    noise = [
        (part, values)
        for part, values in pairs
        if part.effect.role in ("spectrum", "states", "filter")
    ]
    sizes = [part.effect.dps(values) ** 2 for part, values in noise if part.role == "spectrum"] or [
        0.0
    ]
    sizes += [values.get(part.behind, 0.0) ** 2 for part, values in noise if part.behind]
    total = allan.expected(
        allan.on_grid(spectrum_of([part for part, _ in noise], sizes, rate_hz), rate_hz), taus
    )
    tau = np.array(taus) / rate_hz
    for part, values in pairs:
        if part.kind == "rate_ramp":
            total += part.effect.dps(values) ** 2 * tau**2 / 2
        elif part.kind == "sinusoid":
            x = np.pi * values["frequency_hz"] * tau
            total += part.effect.dps(values) ** 2 * np.sin(x) ** 4 / x**2
    return total


@dataclass
class Table:
    """What the error model expects: per cluster size the Allan deviation (deg/s) and how far the
    model may be off."""

    model: Model
    taus: list[int]
    adev_dps: Floats
    tolerance: float


def table_of(model: Model, window: int, tolerance: float, where: str = "the model") -> Table:
    """`window`: samples of the device's window; `tolerance`: one standard deviation of the model's
    own Allan deviation; `where`: the model's file."""
    rate_hz = rate_of(model, where)
    if not 0 <= tolerance < 1:
        raise BadInput("--tolerance: a share from 0 to 1 expected")
    taus = allan.octaves(window)
    if not taus:
        raise BadInput(f"--window: {window} samples are too few")
    variance = noise_variance(model, taus, rate_hz)
    if not np.all(variance > 0):
        raise BadInput(f"{where}: the model has no noise to compare the device with")
    return Table(model, taus, np.sqrt(variance), tolerance)


def description(table: Table) -> list[str]:
    column, lines = table.model.column, []
    for term in table.model.terms:
        values = (
            f"{name_said(name, column)} = {value if isinstance(value, str) else f'{value:.6g}'}"
            for name, value in term.parameters.items()
        )
        lines.append(f"{kind_said(term.kind, column)}: {', '.join(values)}")
    left_out = [
        kind_said(term.kind, column)
        for term in table.model.terms
        if part_of(term).effect.role not in DEVICE_ROLES and term.kind not in DEVICE_KINDS
    ]
    return lines + (
        [
            "Not in the table, which contains only stationary noise, ramp and lines: "
            f"{', '.join(left_out)}"
        ]
        if left_out
        else []
    )


def c_text(table: Table) -> str:
    """A C header for davar_monitor_init (addons/monitor/include/davar/monitor.h)."""
    lines = [
        "/* Written by davarlab export: the Allan deviation that the error model predicts, for "
        "davar_monitor_init.",
        " *",
    ]
    lines += [f" *   {in_c_comment(line)}" for line in description(table)]
    lines += [
        " *",
        f" * Rate {table.model.rate_hz:g} Hz. relative_tolerance: one standard deviation of the "
        "model itself. */",
        "#ifndef DAVAR_MODEL_TABLE_H",
        "#define DAVAR_MODEL_TABLE_H",
        "",
        '#include "davar/monitor.h"',
        "",
        f"#define DAVAR_MODEL_TAU_COUNT {len(table.taus)}",
        "",
        "static const davar_model_tau_t davar_model_table[DAVAR_MODEL_TAU_COUNT] = {",
        f"    /* m, adev_{'mps2' if is_accel(table.model.column) else 'dps'}, "
        "relative_tolerance */",
    ]
    lines += [
        f"    {{ {m}U, {adev:.9e}, {table.tolerance:.6f} }},"
        for m, adev in zip(table.taus, table.adev_dps)
    ]
    return "\n".join(lines + ["};", "", "#endif"]) + "\n"


def csv_text(table: Table) -> str:
    """The same for davar-sim --model-table."""
    rate_hz = table.model.rate_hz
    assert rate_hz  # table_of() refuses a model without
    lines = [f"# {line}" for line in description(table)] + ["m,tau_s,adev_dps,relative_tolerance"]
    lines += [
        f"{m},{m / rate_hz:.9g},{adev:.9g},{table.tolerance:.6g}"
        for m, adev in zip(table.taus, table.adev_dps)
    ]
    return "\n".join(lines) + "\n"


def text(table: Table, path: str | Path) -> str:
    """In the form that the name asks for: .csv, else C."""
    return csv_text(table) if str(path).endswith(".csv") else c_text(table)
