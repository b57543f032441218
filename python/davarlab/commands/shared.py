"""What commands share: where results and progress go, how recordings and models are read, arguments
of the same name."""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from .. import model as models
from ..data import recording as recordings
from ..errors import BadInput, printable, shown
from ..logs import formats
from ..logs.options import Options
from ..report import values
from . import option_types

Argument = tuple[tuple[str, ...], dict[str, Any]]  # names and settings, as of add_argument()
# What runs a command and returns its exit status, what it does, its arguments.
Command = tuple[Callable[[argparse.Namespace], int], str, list[Argument]]


def progress(text: str) -> None:
    print(f"davarlab: {printable(text)}", file=sys.stderr, flush=True)


def emit(options: argparse.Namespace, data: Any, text: str) -> None:
    shown(json.dumps(values.plain(data), indent=2) if options.json else text)


def argument(*names: str, **settings: Any) -> Argument:
    return names, settings


def log_options(options: argparse.Namespace) -> Options:
    """The options for reading a log, from the command line."""
    return Options(
        options.rate,
        options.sensor,
        options.unit,
        getattr(options, "rename", []),
        getattr(options, "scale", []),
        options.types,
        options.names,
        as_recorded=options.as_recorded,
        skip_lines=options.skip_lines,
    )


def given_model(options: argparse.Namespace, path: str | None = None) -> models.Model:
    """The model of -m: a model file, or a kalibr imu.yaml, which applies to every axis; where a
    command needs none, a first one for this axis, or for the last gyro."""
    path = path or options.model
    if path is None:
        return models.first(None, getattr(options, "axis", None) or last_axis(options))
    if str(path).endswith((".yaml", ".yml")):
        from .. import kalibr  # YAML is needed here only

        return kalibr.of_file(path, getattr(options, "axis", None) or "gyro_z_dps")
    model = models.read(path)
    return replace(model, column=options.axis) if getattr(options, "axis", None) else model


def recorded(options: argparse.Namespace, path: str) -> recordings.Recording:
    """A recording, cached so that all axes share it."""
    kept: dict[str, recordings.Recording] = options.__dict__.setdefault("recordings", {})
    if path not in kept:
        found = kept[path] = formats.read(path, log_options(options), progress)
        if len(found.gaps):
            missing = found.samples - found.measured_samples
            progress(f"{len(found.gaps)} gaps with {missing} missing samples")
    return kept[path]


def last_axis(options: argparse.Namespace) -> str:
    found = recorded(options, options.recording)
    if not found.gyros:
        raise BadInput(
            f"{options.recording}: no column is a gyro in deg/s or rad/s (there are: "
            f"{', '.join(found.columns)}). For an accelerometer, type --axes accel. For a clock, "
            "use davar.adev in Python"
        )
    return found.gyros[-1]


REC = argument(
    "recording",
    help="CSV, or a PX4, ArduPilot, ROS, MATLAB, NumPy or Parquet log, with at least "
    f"{recordings.MINIMUM_SAMPLES} samples",
)
MODEL = argument("-m", "--model", required=True, help="model file (TOML), or a kalibr imu.yaml")
MODEL_MAYBE = argument(
    "-m",
    "--model",
    help="model file (TOML), or a kalibr imu.yaml; default: white noise and bias instability "
    "of the last gyro axis",
)
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
    help="process several axes instead of the column of the model: gyro, accel, all, or "
    "columns separated by commas. Prints one table and writes one model file per axis "
    "(OUT_gyro_x.toml)",
)
SENSOR = argument(
    "--sensor",
    metavar="NAME",
    help="sensor, topic or instance to read from a log (davarlab import LOG --list lists them)",
)
NAMES = argument(
    "--names",
    type=option_types.names,
    metavar="A,B,..",
    help="names for the columns of a text or of a NumPy array, in their order, instead of those of "
    "the file: time_us,gyro_x_dps,gyro_y_dps,_,temp_degC .. (_ skips a column)",
)
SKIP = argument(
    "--skip-lines",
    type=option_types.natural,
    default=0,
    metavar="N",
    help="lines at the beginning of a text file that are not read",
)
LOG = [
    RATE,
    SENSOR,
    argument(
        "--unit",
        action="append",
        default=[],
        metavar="NAME=UNIT",
        help="unit of a column, or of all gyro, accel, temp or time columns, instead of the "
        "guessed one: rad/s, deg/s, mdeg/s, g, mg, m/s^2, degC, s, ms, 0.1ms, 10us, us, "
        "100ns, ns, or a number, "
        "the factor to deg/s, g, degC or s",
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
        help="message types that the ROS 2 bag does not contain: PACKAGE/msg/NAME.msg, or a folder "
        "of them",
    ),
    NAMES,
    SKIP,
]
