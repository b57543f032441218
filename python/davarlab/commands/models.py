"""simulate, add, effects, export and sheet: models, and what is made of them."""

import argparse
import contextlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from .. import axes, files, simulate
from .. import model as models
from ..data import recording as recordings
from ..effects import table
from ..effects.base import Effect, Parameter
from ..errors import BadInput
from ..report import parameters
from . import option_types
from .shared import LOG, OUT, Command, argument, emit, progress, recorded

PARAMETER_FILES = {name: form.what for name, form in parameters.FORMATS.items()}
PLAN = "plan"  # of --to


def run_simulate(options: argparse.Namespace) -> int:
    recording = simulate.from_scenario(options.scenario, progress)
    recordings.write(recording, options.output)
    emit(
        options,
        {"recording": options.output, "samples": recording.samples, "rate_hz": recording.rate_hz},
        f"{options.output}: {recording.samples} samples at {recording.rate_hz:g} Hz",
    )
    return 0


def start_value(effect: Effect, parameter: Parameter, rate_hz: float) -> float | str:
    """The start value of a parameter that the user did not give: its default, otherwise the middle
    of its grid for a one-hour recording, its first word, or 0.001."""
    if parameter.default is not None:
        return parameter.default
    if parameter.form:
        return ""
    time = np.broadcast_to(0.0, int(3600 * rate_hz))  # only its length counts; it takes no memory
    hour = recordings.Recording({"time_s": time}, rate_hz)
    with contextlib.suppress(BadInput, LookupError):
        values = list(effect.grid[parameter.name](hour))
        return values[len(values) // 2] if parameter.values else float(values[len(values) // 2])
    return (
        parameter.values[0] if parameter.values else min(max(1e-3, parameter.low), parameter.high)
    )


def run_add(options: argparse.Namespace) -> int:
    model, effect = models.read(options.model), table.find(options.kind)
    values = {p.name: start_value(effect, p, model.rate_hz or 50.0) for p in effect.parameters}
    assumed = dict(values)
    named = {
        p.name: {str(value): value for value in p.values}
        for p in effect.parameters
        if p.values or p.form
    }
    for pair in options.parameters:
        name, equals, value = pair.partition("=")
        if not equals or name not in values:
            raise BadInput(f"{pair}: unknown parameter. {effect.kind} has: {', '.join(values)}")
        try:
            values[name] = named[name].get(value, value) if name in named else float(value)
        except ValueError:
            raise BadInput(f"{pair}: not a number") from None
        assumed.pop(name, None)
    model.terms.append(models.checked_term({"kind": options.kind, **values}, options.kind))
    models.check_lines(model.terms, model.rate_hz, options.model)
    models.check_filters(model.terms, model.rate_hz, options.model)
    models.write(model, options.output)
    tell_assumed(effect, assumed)
    emit(
        options,
        {"model": options.output, "effects": model.kinds},
        f"{options.output}: {', '.join(model.kinds)}",
    )
    return 0


def tell_assumed(effect: Effect, assumed: Mapping[str, float | str]) -> None:
    """Reports assumed start values. fit finds sizes from any start, but shapes only from a close
    one."""
    shapes = [
        name
        for name in effect.shape_names
        if name in assumed and next(p for p in effect.parameters if p.name == name).default is None
    ]
    if assumed:
        said = ", ".join(
            f"{name} = {value if isinstance(value, str) else format(value, '.6g')}"
            for name, value in assumed.items()
        )
        progress(
            f"{effect.kind}: assumed start values for fit: {said}"
            + (
                f". fit changes {', '.join(shapes)} little or not at all: set NAME=VALUE, or use "
                "improve to find it"
                if shapes
                else ""
            )
        )


def run_effects(options: argparse.Namespace) -> int:
    rows: list[dict[str, Any]] = [
        {
            "kind": e.kind,
            "physics": e.physics,
            "signature": e.signature,
            "confirm": e.confirm,
            "role": e.role,
            "parameters": [
                {"name": p.name, "unit": p.unit, "low": p.low, "high": p.high} for p in e.parameters
            ],
        }
        for e in table.TABLE.values()
    ]
    text = "\n".join(
        f"{r['kind']}: {r['physics']}\n  Allan deviation: {r['signature']}\n  confirm: "
        f"{r['confirm']}\n"
        + "\n".join(
            f"  {p['name']}" + (f" [{p['unit']}]" if p["unit"] else "") for p in r["parameters"]
        )
        for r in rows
    )
    emit(options, {"effects": rows}, text)
    return 0


def export_plan(options: argparse.Namespace, given: models.Model) -> int:
    """The filter of a model for davar_plan_init_filtered."""
    from ..diagnosis import improve
    from ..report import declared

    where = options.models[0]
    files.check_ending(options.output, (".h",))
    entries = recording = None
    if options.recording:
        recording, model = axes.for_analysis(recorded(options, options.recording), given)
        models.check_fits(model, recording, where)
        state, given, entries = improve.fit(recording, model, progress)
        if not state.judgement.adequate:
            raise BadInput(
                f"{where}: the model does not fit {options.recording}, so the error of its cutoff "
                "is not known. Find what is missing with improve. Without --recording, the "
                "cutoff counts as known to 10 %"
            )
    found = declared.declare(given, where, options.window, entries, recording)
    default = declared.default_said(given, found.lsb, found.window)
    made = declared.text(found, declared.notes(found, given, where, options.recording))
    files.write_whole(options.output, made.encode())
    emit(
        options,
        {
            "file": options.output,
            "format": options.to,
            **declared.plain(found),
            "device_default": default or None,
        },
        f"{made}{options.output}",
    )
    return 0


def run_export(options: argparse.Namespace) -> int:
    given = [(path, models.read(path)) for path in options.models]
    if options.recording and options.to != PLAN:
        raise BadInput("--recording: only --to plan uses it")
    if options.to == PLAN:
        if len(given) > 1:
            raise BadInput(
                "--to plan takes one model: the axes of a gyro share a filter and a plan"
            )
        return export_plan(options, given[0][1])
    if options.to:
        made = parameters.text(options.to, given, options.inflate, options.bias_time)
        files.write_whole(options.output, made.encode())
        emit(options, {"file": options.output, "format": options.to}, f"{made}{options.output}")
        return 0
    from ..report import export

    files.check_ending(options.output, (".h", ".csv"))
    if len(given) > 1:
        raise BadInput(
            "export: the table for the device takes one model (--to FORMAT takes one model per "
            "axis)"
        )
    table = export.table_of(given[0][1], options.window, options.tolerance, options.models[0])
    files.write_whole(options.output, export.text(table, options.output).encode())
    emit(options, {"table": options.output}, options.output)
    return 0


def run_sheet(options: argparse.Namespace) -> int:
    from .. import kalibr

    if bool(options.kalibr) == bool(options.numbers):
        raise BadInput("sheet: give either numbers with their units, or --kalibr imu.yaml")
    made = (
        kalibr.of_file(options.kalibr, options.column, options.rate)
        if options.kalibr
        else kalibr.of_sheet(options.numbers, options.column, options.rate)
    )
    models.write(made, options.output)
    if not made.rate_hz:
        progress(f"{options.output}: no sample rate, which export needs. Give it with --rate HZ")
    emit(
        options,
        {"model": options.output, "effects": made.kinds},
        f"{options.output}: {', '.join(made.kinds)}",
    )
    return 0


# command: (function, what it does, arguments)
COMMANDS: dict[str, Command] = {
    "simulate": (
        run_simulate,
        "simulates a recording from listed effects",
        [argument("scenario"), OUT],
    ),
    "add": (
        run_add,
        "adds an effect to a model",
        [
            argument("model"),
            argument("kind"),
            argument("parameters", nargs="*", help="NAME=VALUE"),
            OUT,
        ],
    ),
    "effects": (run_effects, "lists every effect", []),
    "export": (
        run_export,
        "writes the model as a table for the device (C, or CSV for davar-sim --model-table), or "
        "as parameters of another program",
        [
            argument(
                "models",
                nargs="+",
                metavar="model",
                help="one model; with --to, one model per axis",
            ),
            argument(
                "-o", "--output", required=True, help="TABLE.h or TABLE.csv; with --to, any name"
            ),
            argument(
                "--to",
                choices=(*PARAMETER_FILES, PLAN),
                help="; ".join(f"{name}: {what}" for name, what in PARAMETER_FILES.items())
                + "; plan: the filter for davar_plan_init_filtered and --bandwidth (FILTER.h)",
            ),
            argument(
                "--recording",
                metavar="REC",
                help="with --to plan: fit the model to this recording, and export the fitted "
                "cutoff with its standard error (without: the model's cutoff, known to 10 percent)",
            ),
            argument(
                "--inflate",
                type=option_types.positive,
                default=1.0,
                metavar="X",
                help="multiply the noise by X (the written file explains when this is useful)",
            ),
            argument(
                "--bias-time",
                type=option_types.positive,
                default=300.0,
                metavar="SECONDS",
                help="averaging time T of the conversion from bias instability to bias random "
                "walk, for a model without random walk (default 300)",
            ),
            argument(
                "--window",
                type=option_types.whole,
                default=6000,
                help="window of the device in samples (default 6000)",
            ),
            argument(
                "--tolerance",
                type=float,
                default=0.02,
                help="uncertainty of the model: the relative standard deviation of its Allan "
                "deviation (default 0.02)",
            ),
            *LOG,
        ],
    ),
    "sheet": (
        run_sheet,
        "makes a model from data sheet numbers or a kalibr file",
        [
            argument(
                "numbers",
                nargs="*",
                metavar="NUMBER",
                help="number with its unit as printed, for example 0.3deg/rt-hr 10deg/hr, "
                "'5 mdps/sqrt(Hz)', or for an accelerometer 100ug/sqrt(Hz) 40ug. Bias "
                "instability is the coefficient B of IEEE 952. If the data sheet gives the minimum "
                "of the Allan deviation, divide it by 0.664",
            ),
            argument("--kalibr", metavar="IMU.yaml"),
            argument(
                "--column",
                default="gyro_z_dps",
                help="column of the recording that the model describes (default gyro_z_dps)",
            ),
            OUT,
            argument(
                "--rate",
                type=option_types.positive,
                metavar="HZ",
                help="samples per second, which export needs",
            ),
        ],
    ),
}
