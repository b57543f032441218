"""Asks davarlab from outside: runs its command line in this process, reads its JSON."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
os.environ.setdefault("DAVAR_LAB_LIBRARY", str(ROOT / "build/tools/python/libdavar_lab.so"))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # imported before numpy, or it is too late

MODEL = """[sensor]
column = "{column}"
[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = {n!r}
[[effect]]
kind = "bias_instability"
coefficient_deg_per_h = {b!r}
"""


@contextlib.contextmanager
def undone(*signals):
    """Restores signal handlers, the table of effects and the list of loaded ones."""
    from davarlab.effects import own, table

    kept = {number: signal.getsignal(number) for number in signals}
    try:
        with mock.patch.dict(table.TABLE), mock.patch.dict(own.LOADED):
            yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)


def run(*arguments):
    """A command with its exit status and what it printed, as subprocess returns them."""
    from davarlab import cli

    out, err = io.StringIO(), io.StringIO()
    with (
        undone(signal.SIGINT, signal.SIGTERM),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            status = cli.main([*map(str, arguments)])
        except SystemExit as why:  # --help
            status = why.code
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())


def said(*arguments, statuses=(0,)):
    """The JSON of a command that ends with one of the statuses."""
    done = run(*arguments, "--json")
    assert done.returncode in statuses, done.stderr
    return json.loads(done.stdout)
