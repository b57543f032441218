"""What commands share: where results and progress go, how recordings and models are read, arguments of the same name."""

import json
import sys
from dataclasses import replace

from .. import kalibr, option_types
from .. import model as models
from ..data import recording as recordings
from ..errors import printable, shown
from ..logs import door
from ..report import values


def progress(text):
    print(f"davarlab: {printable(text)}", file=sys.stderr, flush=True)


def emit(options, data, text):
    shown(json.dumps(values.plain(data), indent=2) if options.json else text)


def argument(*names, **settings):
    return names, settings


def log_options(options):
    """How a log is to be read, from the command line."""
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
    """The model of -m: a model file, or a kalibr imu.yaml, which is one of every axis."""
    path = path or options.model
    if str(path).endswith((".yaml", ".yml")):
        return kalibr.of_file(path, getattr(options, "axis", None) or "gyro_z_dps")
    model = models.read(path)
    return replace(model, column=options.axis) if getattr(options, "axis", None) else model


def recorded(options, path):
    """A recording, read once for all axes."""
    kept = options.__dict__.setdefault("recordings", {})
    if path not in kept:
        kept[path] = door.read(path, log_options(options), progress)
        if len(kept[path].gaps):
            progress(
                f"{len(kept[path].gaps)} gaps: {(~kept[path].known).sum()} samples of the even grid are missing"
            )
    return kept[path]


REC = argument(
    "recording",
    help=f"CSV, or a log of PX4, ArduPilot, ROS, MATLAB, NumPy or Parquet; at least {recordings.MINIMUM_SAMPLES} samples",
)
MODEL = argument("-m", "--model", required=True, help="model file (TOML), or a kalibr imu.yaml")
OUT = argument("-o", "--output", required=True)
OUT_MAYBE = argument("-o", "--output")
HELD_OUT = argument("--held-out", help="a second recording of the same sensor")
REPORT = argument(
    "--report", metavar="R.html", help="one page with pictures that opens in any browser"
)
BASE = argument(
    "--base",
    type=option_types.identifier,
    default=0x5D0,
    metavar="HEX",
    help="identifier of channel 0 (default 5D0)",
)
RATE = argument(
    "--rate",
    type=option_types.positive,
    metavar="HZ",
    help="samples per second, when the recording has no time_s (which decides)",
)
AXES = argument(
    "--axes",
    metavar="AXES",
    help="gyro, accel, all, or columns, comma-separated, instead of the column of the model: one table, "
    "and one model file for each axis (OUT_gyro_x.toml)",
)
SENSOR = argument(
    "--sensor",
    metavar="NAME",
    help="which of the sensors, topics or instances of a log (davarlab import LOG --list names them)",
)
LOG = [
    RATE,
    SENSOR,
    argument(
        "--unit",
        action="append",
        default=[],
        metavar="NAME=UNIT",
        help="over what was guessed: of a column, or of gyro, accel, temp or time; rad/s, "
        "deg/s, mdeg/s, g, mg, m/s^2, degC, s, ms, us, ns, or a number: the factor to deg/s, g, degC or s",
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
        help="message types that a ROS 2 bag does not bring: PACKAGE/msg/NAME.msg, or a folder of them",
    ),
    argument(
        "--names",
        metavar="A,B,..",
        help="names of the columns of a NumPy array without: time,gyro_x,gyro_y,gyro_z,temp ..",
    ),
]
