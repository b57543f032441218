"""open, import, live, fleet and dbc: logs, many recordings, and sensors on a wire."""

from .. import files, option_types
from ..errors import BadInput
from ..logs import door
from .shared import (
    AXES,
    BASE,
    LOG,
    MODEL,
    OUT,
    OUT_MAYBE,
    SENSOR,
    argument,
    emit,
    log_options,
    progress,
)


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
        raise BadInput("import: -o REC.csv is missing (or --list)")
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


def run_live(options):
    from ..wire import live  # python-can and cantools are needed here only

    return live.run(options)


def run_open(options):
    from ..workbench import server  # a web server is needed here only

    return server.run(options)


def run_fleet(options):
    from davarfleet import command  # Dask is needed here only

    return command.run(options, progress, emit)


def run_dbc(options):
    from ..wire import dbc

    channels = sorted(set(options.channel or [0]))
    files.write_whole(options.output, dbc.moved(options.base, channels).encode())
    emit(
        options, {"dbc": options.output, "base": options.base, "channels": channels}, options.output
    )
    return 0


# command: (function, what it does, arguments)
COMMANDS = {
    "open": (
        run_open,
        "the workbench in a browser; without a recording it offers the tutorial's, and a place to drop one",
        [
            argument("recording", nargs="?", help="any log, columns of any name"),
            argument("-m", "--model", help="model file (TOML)"),
            SENSOR,
            argument(
                "--port",
                type=option_types.port,
                default=0,
                metavar="N",
                help="default: any that is free",
            ),
            argument("--no-browser", action="store_true", help="only print the address"),
        ],
    ),
    "import": (
        run_import,
        "makes a recording of another log",
        [
            argument(
                "log",
                help="PX4 ULog, ArduPilot DataFlash, ROS 1 and 2 bags, MCAP, MATLAB, NumPy, Parquet, CSV of any kind",
            ),
            OUT_MAYBE,
            *LOG,
            argument("--list", action="store_true", help="the sensors in it"),
            argument("--rename", action="append", default=[], help="OLD=NEW"),
            argument("--scale", action="append", default=[], help="NAME=FACTOR"),
        ],
    ),
    "live": (
        run_live,
        "checks, shows and records the stream of a CAN or serial source; waits for one that is lost",
        [
            argument("source", help="can:IFACE or slcan:PATH[@BAUD]"),
            argument(
                "--record",
                metavar="FILE.csv",
                help="also write the results there, as they come; a file that is there "
                "is continued with a new stretch, or, when it has other columns, FILE-2.csv is written",
            ),
            argument(
                "--raw",
                metavar="REC.csv",
                help="also write the raw samples there, a recording for every other command (the sender needs "
                "--raw too); one for each channel and restart: REC-2.csv ...",
            ),
            argument(
                "--count", type=option_types.whole, metavar="N", help="stop after so many results"
            ),
            argument(
                "--idle",
                type=option_types.positive,
                metavar="SECONDS",
                help="stop when nothing has come for so long",
            ),
            BASE,
        ],
    ),
    "fleet": (
        run_fleet,
        "many recordings against one model: a table, and a page of the population",
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
                help="fleet.parquet, fleet.html, fleet.json and what is done so far; "
                "the same command goes on from there",
            ),
            argument(
                "--batch",
                metavar="REGEX",
                help="the batch of a recording: what this finds in its path (its first group)",
            ),
            argument("--limits", metavar="L.toml", help="pass or fail of each unit"),
            argument(
                "--scheduler",
                metavar="ADDRESS",
                help="of a Dask cluster with this davarlab on its workers (tcp://HOST:8786)",
            ),
            argument(
                "--workers",
                type=option_types.whole,
                default=2,
                metavar="N",
                help="processes of this machine (default 2)",
            ),
            argument(
                "--chance",
                type=option_types.natural,
                default=200,
                metavar="N",
                help="of so many units (default 200) also a recording is drawn where nothing "
                "is missing, to know what chance gives; 0: no effects of whole batches",
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
                help="default 0; may be given more than once",
            ),
        ],
    ),
}
