"""open, import, live, fleet and dbc: logs, many recordings, and sensors on a wire."""

import argparse

from .. import files
from ..data import plausible
from ..errors import BadInput, of_extra
from ..logs import formats
from . import option_types
from .shared import (
    AXES,
    BASE,
    LOG,
    MODEL,
    NAMES,
    OUT,
    OUT_MAYBE,
    SENSOR,
    SKIP,
    Command,
    argument,
    emit,
    log_options,
    progress,
)


def run_import(options: argparse.Namespace) -> int:
    how = log_options(options)
    if options.list:
        sensors = formats.listed(options.log, how)
        emit(
            options,
            {
                "sensors": [
                    {"name": one.name, "gives": sorted(one.gives), "samples": one.samples}
                    for one in sensors
                ]
            },
            "\n".join(one.said for one in sensors) or "no sensors",
        )
        return 0
    if not options.output:
        raise BadInput("import: -o REC.csv or --list is missing")
    found = formats.samples(options.log, how)
    count = len(next(iter(found.columns.values())))
    if (doubted := formats.doubted(found)) and not options.as_recorded:
        raise BadInput(
            f"{options.log}: doubtful: {next(iter(doubted.values()))} (or {plausible.CONFIRM})"
        )
    rate = formats.write(found, options.output, options.rate, options.log)
    for line in formats.said(found):
        progress(line)
    for one in [] if options.as_recorded else formats.doubts(found, rate):
        progress(f"{options.log}: doubtful: {one}")
    emit(
        options,
        {
            "recording": options.output,
            "samples": count,
            "rate_hz": rate,
            "columns": list(found.columns),
            "guesses": [vars(one) for one in found.guesses],
        },
        f"{options.output}: {count} samples at {rate:.6g} Hz: {', '.join(found.columns)}",
    )
    return 0


def run_live(options: argparse.Namespace) -> int:
    from davar.wire import live  # python-can and cantools are needed here only

    return live.run(options)


def run_open(options: argparse.Namespace) -> int:
    from ..workbench import server  # a web server is needed here only

    return server.run(options)


def run_fleet(options: argparse.Namespace) -> int:
    with of_extra("fleet"):
        from davarfleet import command  # Dask is needed here only

    status: int = command.run(options, progress, emit)
    return status


def run_dbc(options: argparse.Namespace) -> int:
    from davar.wire import dbc

    channels = sorted(set(options.channel or [0]))
    files.write_whole(options.output, dbc.moved(options.base, channels).encode())
    emit(
        options, {"dbc": options.output, "base": options.base, "channels": channels}, options.output
    )
    return 0


# command: (function, what it does, arguments)
COMMANDS: dict[str, Command] = {
    "open": (
        run_open,
        "opens the workbench in a browser; without a recording, it offers a tutorial and accepts "
        "a dropped file",
        [
            argument("recording", nargs="?", help="any log, with any column names"),
            argument("-m", "--model", help="model file (TOML)"),
            SENSOR,
            NAMES,
            SKIP,
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
    "import": (
        run_import,
        "converts another log to a recording",
        [
            argument(
                "log",
                help="PX4 ULog, ArduPilot DataFlash, ROS 1 or 2 bag, MCAP, MATLAB, NumPy, Parquet "
                "or any CSV",
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
        "checks, shows and records the stream of a sensor (docs/STREAMS.md, docs/DIALECTS.md), and "
        "reconnects to a lost source",
        [
            argument(
                "source",
                help="can:IFACE, slcan:PATH[@BAUD], mavlink:udp:HOST:PORT (of this computer), "
                "mavlink:serial:PATH[@BAUD], dronecan:IFACE or cyphal:IFACE[@SUBJECT]",
            ),
            argument(
                "--record",
                metavar="FILE.csv",
                help="write the results to this file as they arrive. An existing file is appended "
                "to; if it has other columns, FILE-2.csv is written instead",
            ),
            argument(
                "--raw",
                metavar="REC.csv",
                help="write the raw samples as a recording for the other commands (the sender also "
                "needs --raw), with one file per channel and restart: REC-2.csv ...",
            ),
            argument("--count", type=option_types.whole, metavar="N", help="stop after N results"),
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
                help="regular expression whose first group, found in the path, is the batch of a "
                "recording",
            ),
            argument(
                "--limits", metavar="L.toml", help="limits that decide pass or fail of each unit"
            ),
            argument(
                "--scheduler",
                metavar="ADDRESS",
                help="scheduler of a Dask cluster with this davarlab on its workers "
                "(tcp://HOST:8786)",
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
                help="number of units (default 200) for which a recording of the fitted model is "
                "also simulated, as the null distribution; 0: do not test whole batches for "
                "effects",
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
}
