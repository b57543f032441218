"""The command line: one function per command. Results go to standard output, progress to standard error."""

import argparse
import contextlib
import json
import sys
import warnings
from dataclasses import replace

import numpy as np

from . import arithmetic, axes, files, kalibr, option_types, simulate
from . import model as models
from .data import recording as recordings
from .diagnosis import compare, evidence, improve
from .diagnosis import state as state_of
from .effects import own, table
from .errors import BadInput, internal_error, outside_error, printable, shown
from .logs import door
from .report import parameters, terminal, values

DETAIL = 3


def progress(text):
    print(f"davarlab: {printable(text)}", file=sys.stderr, flush=True)


def emit(options, data, text):
    shown(json.dumps(values.plain(data), indent=2) if options.json else text)


def log_options(options):
    """The options for reading a log, from the command line."""
    return door.Options(
        options.rate,
        options.sensor,
        options.unit,
        getattr(options, "rename", []),
        getattr(options, "scale", []),
        options.types,
        options.names.split(",") if options.names else None,
        as_recorded=options.as_recorded,
    )


def given_model(options, path=None):
    """The model of -m: a model file, or a kalibr imu.yaml, which applies to every axis."""
    path = path or options.model
    if str(path).endswith((".yaml", ".yml")):
        return kalibr.of_file(path, getattr(options, "axis", None) or "gyro_z_dps")
    model = models.read(path)
    return replace(model, column=options.axis) if getattr(options, "axis", None) else model


def recorded(options, path):
    """A recording, cached so that all axes share it."""
    kept = options.__dict__.setdefault("recordings", {})
    if path not in kept:
        kept[path] = door.read(path, log_options(options), progress)
        if len(kept[path].gaps):
            progress(
                f"{len(kept[path].gaps)} gaps with {(~kept[path].known).sum()} missing samples"
            )
    return kept[path]


def load(options):
    """(recording, model) for the analysis. axes.py converts those of an accelerometer."""
    given = given_model(options)
    recording, model = axes.for_analysis(recorded(options, options.recording), given)
    models.check_fits(model, recording, options.model)
    if options.command != "fit":
        models.check_noise(model, options.model)
    return recording, model


def load_held_out(options, model):
    if not options.held_out:
        return None
    held_out, model = axes.for_analysis(recorded(options, options.held_out), given_model(options))
    models.check_fits(model, held_out, options.model)
    return held_out


def column_of(options):
    return given_model(options).column


def output_of(options):
    """The output file for the model of this axis."""
    return options.output and (
        str(axes.file_of(options.output, options.axis))
        if getattr(options, "axis", None)
        else options.output
    )


def each_axis(one):
    """A command on the axis of the model, or on all axes of --axes. one(options) -> axes.Found and the text of one axis."""

    def run(options):
        if not options.axes:
            found, text = one(options)
            emit(
                options,
                axes.plain_in_units(found.data, found.column),
                axes.in_units(text, found.column),
            )
            return found.status
        if getattr(options, "report", None):
            raise BadInput("--report works for one axis only: remove --axes")
        columns = axes.columns_of(recorded(options, options.recording), options.axes)
        if options.__dict__.get("output"):
            files.check_outputs(
                [axes.file_of(options.output, column) for column in columns], [options.recording]
            )
        found = []
        for options.axis in columns:
            progress(f"axis {options.axis}")
            found.append(one(options)[0])
        emit(
            options,
            {"axes": {one.column: axes.plain_in_units(one.data, one.column) for one in found}},
            axes.text(found),
        )
        return max(one.status for one in found)

    return run


def run_simulate(options):
    recording = simulate.from_scenario(options.scenario, progress)
    recordings.write(recording, options.output)
    emit(
        options,
        {"recording": options.output, "samples": recording.samples, "rate_hz": recording.rate_hz},
        f"{options.output}: {recording.samples} samples at {recording.rate_hz:g} Hz",
    )
    return 0


def fit_one(options):
    recording, model = load(options)
    state, fitted, entries = improve.fit(recording, model, progress)
    column, output = column_of(options), output_of(options)
    if output:
        models.write(axes.called(fitted, column), output)
    data = {
        "effects": values.fitted(fitted, entries),
        "model": output,
        **values.judgement(state.judgement),
        "observations": values.observations(state.seen),
        "intervals_hold": state.judgement.adequate,
    }
    return axes.Found(column, 0, data, fitted, entries), terminal.fit(
        fitted, entries, state.judgement, state.seen
    )


def report(options, recording, model, found, state=None):
    """Writes the page of --report for a comparison (state: the refitted model) or an improvement."""
    if not options.report:
        return
    from .report import contents, page  # the pictures take a second to load

    progress("drawing the report")
    named = {
        "recording": options.recording,
        "model": options.model,
        "held-out recording": getattr(options, "held_out", None),
    }
    run = contents.Run(
        options.typed,
        recording,
        model,
        {role: path for role, path in named.items() if path},
        [word for path in options.effects for word in ("--effects", path)]
        + (["--rate", f"{options.rate:g}"] if options.rate else []),
        getattr(options, "output", None),
    )
    page.write(
        contents.of_comparison(run, found, state) if state else contents.of_improvement(run, found),
        options.report,
    )


def compare_one(options):
    recording, model = load(options)
    state = state_of.judged(state_of.start(recording, model, progress))
    found = compare.compare(recording, model, progress, state)
    report(options, recording, model, found, state)
    return (
        axes.Found(
            column_of(options),
            0 if found.adequate else 1,
            values.comparison(found),
            model,
            improve.as_it_is(model),
        ),
        terminal.comparison(found, evidence.notes(recording, model)),
    )


def diagnose_one(options):
    recording, model = load(options)
    held_out = load_held_out(options, model)
    found = improve.improve(recording, model, held_out, progress, DETAIL)
    report(options, recording, model, found)
    return axes.Found(
        column_of(options), 0, values.diagnosis(found), found.model, found.estimates
    ), terminal.diagnosis(found)


def improve_one(options):
    recording, model = load(options)
    held_out = load_held_out(options, model)
    found = improve.improve(recording, model, held_out, progress, DETAIL if options.report else 0)
    column, output = column_of(options), output_of(options)
    if output:
        models.write(axes.called(found.model, column), output)
    report(options, recording, model, found)
    return (
        axes.Found(
            column,
            0 if found.judgement.adequate else 1,
            values.improvement(found, output),
            found.model,
            found.estimates,
        ),
        terminal.improvement(found),
    )


def start_value(effect, parameter, rate_hz):
    """The start value of a parameter that the user did not give: its default, otherwise the middle of its grid for a one-hour
    recording, its first word, or 0.001."""
    if parameter.default is not None:
        return parameter.default
    if parameter.text:
        return ""
    hour = recordings.Recording({"time_s": range(int(3600 * rate_hz))}, rate_hz)
    with contextlib.suppress(BadInput, LookupError):
        values = list(effect.grid[parameter.name](hour))
        return values[len(values) // 2] if parameter.values else float(values[len(values) // 2])
    return (
        parameter.values[0] if parameter.values else min(max(1e-3, parameter.low), parameter.high)
    )


def run_add(options):
    model, effect = models.read(options.model), table.find(options.kind)
    values = {p.name: start_value(effect, p, model.rate_hz or 50.0) for p in effect.parameters}
    assumed = dict(values)
    named = [p.name for p in effect.parameters if p.values or p.text]
    for pair in options.parameters:
        name, equals, value = pair.partition("=")
        if not equals or name not in values:
            raise BadInput(f"{pair}: unknown parameter. {effect.kind} has: {', '.join(values)}")
        try:
            values[name] = value if name in named else float(value)
        except ValueError:
            raise BadInput(f"{pair}: not a number") from None
        assumed.pop(name, None)
    model.terms.append(models.checked_term({"kind": options.kind, **values}, options.kind))
    models.check_lines(model.terms, model.rate_hz, options.model)
    models.write(model, options.output)
    tell_assumed(effect, assumed)
    emit(
        options,
        {"model": options.output, "effects": model.kinds},
        f"{options.output}: {', '.join(model.kinds)}",
    )
    return 0


def tell_assumed(effect, assumed):
    """Reports assumed start values. fit finds sizes from any start, but shapes only from a close one."""
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
                f". fit changes {', '.join(shapes)} little or not at all: set NAME=VALUE, or use improve to find it"
                if shapes
                else ""
            )
        )


def run_effects(options):
    rows = [
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
        f"{r['kind']}: {r['physics']}\n  Allan deviation: {r['signature']}\n  confirm: {r['confirm']}\n"
        + "\n".join(
            f"  {p['name']}" + (f" [{p['unit']}]" if p["unit"] else "") for p in r["parameters"]
        )
        for r in rows
    )
    emit(options, {"effects": rows}, text)
    return 0


def run_plot(options):
    files.check_ending(options.output, (".png", ".pdf", ".svg"))
    from .report import plot

    recording, model = load(options)
    found = compare.compare(recording, model, progress)
    plot.draw(found, options.output)
    emit(options, {"picture": options.output}, options.output)
    return 0


def run_export(options):
    given = [(path, models.read(path)) for path in options.models]
    if options.to:
        made = parameters.text(options.to, given, options.inflate, options.bias_time)
        files.write_whole(options.output, made.encode())
        emit(options, {"file": options.output, "format": options.to}, f"{made}{options.output}")
        return 0
    from .report import export

    files.check_ending(options.output, (".h", ".csv"))
    if len(given) > 1:
        raise BadInput(
            "export: the table for the device takes one model (--to FORMAT takes one model per axis)"
        )
    table = export.table_of(given[0][1], options.window, options.tolerance, options.models[0])
    files.write_whole(options.output, export.text(table, options.output).encode())
    emit(options, {"table": options.output}, options.output)
    return 0


def run_sheet(options):
    if bool(options.kalibr) == bool(options.numbers):
        raise BadInput("sheet: give either numbers with their units, or --kalibr imu.yaml")
    made = (
        kalibr.of_file(options.kalibr, options.column, options.rate)
        if options.kalibr
        else kalibr.of_sheet(options.numbers, options.column, options.rate)
    )
    models.write(made, options.output)
    emit(
        options,
        {"model": options.output, "effects": made.kinds},
        f"{options.output}: {', '.join(made.kinds)}",
    )
    return 0


def run_import(options):
    how = log_options(options)
    if options.list:
        found = door.listed(options.log, how)
        emit(
            options,
            {
                "sensors": [
                    {"name": one.name, "gives": sorted(one.gives), "samples": one.samples}
                    for one in found
                ]
            },
            "\n".join(one.said for one in found) or "no sensors",
        )
        return 0
    if not options.output:
        raise BadInput("import: -o REC.csv or --list is missing")
    found = door.samples(options.log, how)
    count, columns = len(next(iter(found.columns.values()))), list(found.columns)
    rate = door.write(found, options.output, options.rate, options.log)
    for line in door.said(found.guesses):
        progress(line)
    for one in [] if options.as_recorded else door.doubts(found, rate):
        progress(f"{options.log}: doubtful: {one}")
    emit(
        options,
        {
            "recording": options.output,
            "samples": count,
            "rate_hz": rate,
            "columns": columns,
            "guesses": [vars(one) for one in found.guesses],
        },
        f"{options.output}: {count} samples at {rate:.6g} Hz: {', '.join(columns)}",
    )
    return 0


def run_benchmark(options):
    from .diagnosis import benchmark

    result = benchmark.run(
        range(options.first_seed, options.first_seed + options.seeds),
        options.size,
        options.only,
        options.jobs,
        progress,
    )
    emit(options, result, benchmark.text(result))
    return 0


def run_live(options):
    from .wire import live  # python-can and cantools are needed here only

    return live.run(options)


def run_open(options):
    from .workbench import server  # a web server is needed here only

    return server.run(options)


def run_fleet(options):
    from .fleet import command  # Dask is needed here only

    return command.run(options, progress, emit)


def run_dbc(options):
    from .wire import dbc

    channels = sorted(set(options.channel or [0]))
    files.write_whole(options.output, dbc.moved(options.base, channels).encode())
    emit(
        options, {"dbc": options.output, "base": options.base, "channels": channels}, options.output
    )
    return 0


def run_nulls(options):
    from .diagnosis import nulls

    result = nulls.run(
        options.recordings,
        options.first_seed,
        options.seconds,
        not options.adequacy_only,
        options.jobs,
        progress,
    )
    emit(options, result, nulls.text(result))
    return 0


def argument(*names, **settings):
    return names, settings


REC = argument(
    "recording",
    help=f"CSV, or a PX4, ArduPilot, ROS, MATLAB, NumPy or Parquet log, with at least {recordings.MINIMUM_SAMPLES} samples",
)
MODEL = argument("-m", "--model", required=True, help="model file (TOML), or a kalibr imu.yaml")
OUT = argument("-o", "--output", required=True)
OUT_MAYBE = argument("-o", "--output")
HELD_OUT = argument("--held-out", help="a second recording of the same sensor")
REPORT = argument(
    "--report", metavar="R.html", help="write a page with plots that opens in any browser"
)
BASE = argument(
    "--base",
    type=option_types.identifier,
    default=0x5D0,
    metavar="HEX",
    help="CAN identifier of channel 0 (default 5D0)",
)
RATE = argument(
    "--rate",
    type=option_types.positive,
    metavar="HZ",
    help="samples per second of a recording without time_s",
)

AXES = argument(
    "--axes",
    metavar="AXES",
    help="process several axes instead of the column of the model: gyro, accel, all, or columns separated by commas. "
    "Prints one table and writes one model file per axis (OUT_gyro_x.toml)",
)
SENSOR = argument(
    "--sensor",
    metavar="NAME",
    help="sensor, topic or instance to read from a log (davarlab import LOG --list lists them)",
)
LOG = [
    RATE,
    SENSOR,
    argument(
        "--unit",
        action="append",
        default=[],
        metavar="NAME=UNIT",
        help="unit of a column, or of all gyro, accel, temp or time columns, instead of the guessed one: rad/s, "
        "deg/s, mdeg/s, g, mg, m/s^2, degC, s, ms, us, ns, or a number, the factor to deg/s, g, degC or s",
    ),
    argument(
        "--as-recorded",
        action="store_true",
        help="accept the recorded rate, units and levels; skip the plausibility checks",
    ),
    argument(
        "--types",
        action="append",
        default=[],
        metavar="PATH",
        help="message types that the ROS 2 bag does not contain: PACKAGE/msg/NAME.msg, or a folder of them",
    ),
    argument(
        "--names",
        metavar="A,B,..",
        help="column names for a NumPy array without names: time,gyro_x,gyro_y,gyro_z,temp ..",
    ),
]

PARAMETER_FILES = {name: form.what for name, form in parameters.FORMATS.items()}

# command: (function, what it does, arguments)
COMMANDS = {
    "simulate": (
        run_simulate,
        "simulates a recording from listed effects",
        [argument("scenario"), OUT],
    ),
    "fit": (
        each_axis(fit_one),
        "fits the parameters, with 95 %% intervals",
        [REC, MODEL, OUT_MAYBE, AXES, *LOG],
    ),
    "compare": (
        each_axis(compare_one),
        "compares model and measurement: where the model fails, and by how much",
        [REC, MODEL, REPORT, AXES, *LOG],
    ),
    "diagnose": (
        each_axis(diagnose_one),
        "finds the missing physical effect",
        [REC, MODEL, HELD_OUT, REPORT, AXES, *LOG],
    ),
    "improve": (
        each_axis(improve_one),
        "adds missing effects until the model is adequate",
        [REC, MODEL, HELD_OUT, OUT_MAYBE, REPORT, AXES, *LOG],
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
    "open": (
        run_open,
        "opens the workbench in a browser; without a recording, it offers a tutorial and accepts a dropped file",
        [
            argument("recording", nargs="?", help="any log, with any column names"),
            argument("-m", "--model", help="model file (TOML)"),
            SENSOR,
            argument(
                "--port",
                type=option_types.port,
                default=0,
                metavar="N",
                help="default: any free port",
            ),
            argument("--no-browser", action="store_true", help="only print the address"),
        ],
    ),
    "effects": (run_effects, "lists every effect", []),
    "plot": (
        run_plot,
        "plots Allan deviation, failure map and residual spectrum (.png, .pdf or .svg)",
        [REC, MODEL, OUT, *LOG],
    ),
    "export": (
        run_export,
        "writes the model as a table for the device (C, or CSV for davar-sim --model-table), or as parameters of another program",
        [
            argument(
                "models", nargs="+", metavar="model", help="one model; with --to, one model per axis"
            ),
            argument(
                "-o", "--output", required=True, help="TABLE.h or TABLE.csv; with --to, any name"
            ),
            argument(
                "--to",
                choices=tuple(PARAMETER_FILES),
                help="; ".join(f"{name}: {what}" for name, what in PARAMETER_FILES.items()),
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
                help="averaging time T of the conversion from bias instability to bias random walk, for a model without random walk "
                "(default 300)",
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
                help="uncertainty of the model: the relative standard deviation of its Allan deviation "
                "(default 0.02)",
            ),
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
                help="number with its unit, for example 0.005deg/s/sqrt(Hz) 10deg/h, or for an accelerometer 100ug/sqrt(Hz) 40ug. "
                "Bias instability is the coefficient B of IEEE 952. If the data sheet gives the minimum of the Allan deviation, "
                "divide it by 0.664",
            ),
            argument("--kalibr", metavar="IMU.yaml"),
            argument(
                "--column",
                default="gyro_z_dps",
                help="column of the recording that the model describes (default gyro_z_dps)",
            ),
            OUT,
            RATE,
        ],
    ),
    "import": (
        run_import,
        "converts another log to a recording",
        [
            argument(
                "log",
                help="PX4 ULog, ArduPilot DataFlash, ROS 1 or 2 bag, MCAP, MATLAB, NumPy, Parquet or any CSV",
            ),
            OUT_MAYBE,
            *LOG,
            argument("--list", action="store_true", help="only list the sensors in the log"),
            argument("--rename", action="append", default=[], help="OLD=NEW"),
            argument("--scale", action="append", default=[], help="NAME=FACTOR"),
        ],
    ),
    "live": (
        run_live,
        "checks, shows and records the stream of a CAN or serial source, and reconnects to a lost one",
        [
            argument("source", help="can:IFACE or slcan:PATH[@BAUD]"),
            argument(
                "--record",
                metavar="FILE.csv",
                help="write the results to this file as they arrive. An existing file is appended to; "
                "if it has other columns, FILE-2.csv is written instead",
            ),
            argument(
                "--raw",
                metavar="REC.csv",
                help="write the raw samples as a recording for the other commands (the sender also needs --raw), "
                "with one file per channel and restart: REC-2.csv ...",
            ),
            argument(
                "--count", type=option_types.whole, metavar="N", help="stop after N results"
            ),
            argument(
                "--idle",
                type=option_types.positive,
                metavar="SECONDS",
                help="stop when nothing has arrived for this time",
            ),
            BASE,
        ],
    ),
    "fleet": (
        run_fleet,
        "compares many recordings with one model: a table and a page on the population",
        [
            argument(
                "files",
                nargs="+",
                metavar="FILES",
                help="recordings and logs: paths, globs, http:// and s3:// addresses",
            ),
            MODEL,
            argument(
                "-o",
                "--output",
                dest="folder",
                required=True,
                metavar="OUT/",
                help="folder for fleet.parquet, fleet.html, fleet.json and finished work; "
                "the same command continues an interrupted run",
            ),
            argument(
                "--batch",
                metavar="REGEX",
                help="regular expression whose first group, found in the path, is the batch of a recording",
            ),
            argument("--limits", metavar="L.toml", help="limits that decide pass or fail of each unit"),
            argument(
                "--scheduler",
                metavar="ADDRESS",
                help="scheduler of a Dask cluster with this davarlab on its workers (tcp://HOST:8786)",
            ),
            argument(
                "--workers",
                type=option_types.whole,
                default=2,
                metavar="N",
                help="processes on this machine (default 2)",
            ),
            argument(
                "--chance",
                type=option_types.natural,
                default=200,
                metavar="N",
                help="number of units (default 200) for which a recording of the fitted model is also simulated, as the null "
                "distribution; 0: do not test whole batches for effects",
            ),
            AXES,
            *LOG,
        ],
    ),
    "dbc": (
        run_dbc,
        "writes tools/davar.dbc for another base identifier or other channels",
        [
            OUT,
            BASE,
            argument(
                "--channel",
                type=option_types.channel,
                action="append",
                metavar="N",
                help="default 0; may be repeated",
            ),
        ],
    ),
    "benchmark": (
        run_benchmark,
        "measures how often the verdict is right",
        [
            argument("--seeds", type=option_types.whole, default=20),
            argument("--first-seed", type=option_types.natural, default=0),
            argument("--size", choices=("visible", "hard"), default="visible"),
            argument("--only", help="scenarios, separated by commas"),
            argument("--jobs", type=option_types.whole, default=2),
        ],
    ),
    "nulls": (
        run_nulls,
        "measures the null distribution of each candidate, by parametric bootstrap",
        [
            argument("--recordings", type=option_types.whole, default=300),
            argument("--first-seed", type=option_types.natural, default=0),
            argument("--seconds", type=option_types.positive, default=7200.0),
            argument(
                "--adequacy-only", action="store_true", help="p-values only, three times faster"
            ),
            argument("--jobs", type=option_types.whole, default=2),
        ],
    ),
}


class Parser(argparse.ArgumentParser):
    """Reports command line errors in the same form as other errors."""

    def error(self, message):
        raise BadInput(f"{message} (see --help)")


def parser():
    top = Parser(
        prog="davarlab",
        description="Compare a gyro error model with a recording, find the missing effect and add it.",
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, (_, what, arguments) in COMMANDS.items():
        command = commands.add_parser(name, help=what, description=what.replace("%%", "%"))
        for names, settings in arguments:
            command.add_argument(*names, **settings)
        command.add_argument(
            "--json", action="store_true", help="print one JSON object on standard output"
        )
        command.add_argument(
            "--effects",
            action="append",
            default=[],
            metavar="FILE.py",
            help="Python file with more effects. It runs with your rights: load only files that you trust",
        )
    return top


def check_files(options):
    """Checks that every output can be written and is not an input. A model may overwrite the model that it came from."""
    given = {
        name: getattr(options, name, None)
        for name in (
            "kalibr",
            "recording",
            "held_out",
            "scenario",
            "log",
            "output",
            "report",
            "model",
        )
    }
    read = [
        given[name]
        for name in ("recording", "held_out", "scenario", "log", "kalibr")
        if given[name] is not None
    ] + options.effects
    if given["report"] is not None:
        files.check_outputs([given["report"]], [given["model"]])
    files.check_outputs(
        [given[name] for name in ("output", "report") if given[name] is not None], read
    )


def main(arguments):
    """Exit status 0: done, 1: model not adequate, 2: bad input, 3: internal error, 130: Ctrl-C."""
    arithmetic.on_one_thread()
    try:
        options = parser().parse_args(arguments)
        for path in options.effects:
            own.load(path)
        options.typed = arguments
        check_files(options)
        with (
            np.errstate(all="ignore"),
            warnings.catch_warnings(),
        ):  # NaN is reported where it is checked
            warnings.simplefilter("ignore", RuntimeWarning)
            return COMMANDS[options.command][0](options)
    except BadInput as why:
        print(f"davarlab: {printable(why)}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("davarlab: stopped", file=sys.stderr)
        return 130
    except MemoryError:
        print("davarlab: not enough memory for this amount of data", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader closed the pipe (| head)
        return 0
    except OSError as why:
        return outside_error(why)
    except Exception as why:
        return internal_error(why)
