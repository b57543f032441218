"""The command line: results to standard output, progress to standard error. The commands are in
commands/."""

import argparse
import sys
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np
from davar import places

from . import arithmetic, files
from .commands import analysis, imu, logs, measuring, models
from .effects import own
from .errors import BadInput, internal_error, outside_error, printable

# As --help lists them.
ORDER = (
    "imu",
    "simulate",
    "fit",
    "compare",
    "diagnose",
    "improve",
    "add",
    "open",
    "effects",
    "plot",
    "export",
    "sheet",
    "import",
    "live",
    "fleet",
    "dbc",
    "benchmark",
    "nulls",
)
FOUND = imu.COMMANDS | analysis.COMMANDS | models.COMMANDS | logs.COMMANDS
if places.tests():  # only a checkout of the repository has what these two run
    FOUND |= measuring.COMMANDS
COMMANDS = {name: FOUND[name] for name in ORDER if name in FOUND}


class Parser(argparse.ArgumentParser):
    """Reports command line errors in the same form as other errors."""

    def error(self, message: str) -> NoReturn:
        raise BadInput(f"{message} (see --help)")


def parser() -> Parser:
    top = Parser(
        prog="davarlab",
        description="Compare a gyro error model with a recording, find the missing effect and add "
        "it.",
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
            help="Python file with more effects. It runs with your rights: load only files that "
            "you trust",
        )
    return top


def check_files(options: argparse.Namespace) -> None:
    """Checks that every output can be written and is not an input. A model may overwrite the model
    that it came from."""
    names = ("kalibr", "recording", "held_out", "scenario", "log", "output", "report", "model")
    given: dict[str, Any] = {
        name: path for name in names if (path := getattr(options, name, None)) is not None
    }
    read = [
        given[name]
        for name in ("recording", "held_out", "scenario", "log", "kalibr")
        if name in given
    ]
    if {"report", "model"} <= given.keys():
        files.check_outputs([given["report"]], [given["model"]])
    files.check_outputs(
        [given[name] for name in ("output", "report") if name in given], read + options.effects
    )


def main(arguments: Sequence[str]) -> int:
    """Exit status 0: done, 1: model not adequate, 2: bad input, 3: internal error, 130: Ctrl-C."""
    arithmetic.prepared()
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
            found: int = COMMANDS[options.command][0](options)
            return found
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
