"""Asks davarlab from outside: writes files, runs its command line in this process or in a copy of
it, reads its JSON.
"""

import contextlib
import io
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/lab"))
os.environ.setdefault("DAVAR_LAB_LIBRARY", str(ROOT / "build/tools/tools/lab/libdavar_lab.so"))
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


def out_of_time(*_):
    raise TimeoutError("out of time")


def last_line(text):
    return (text.getvalue().strip().splitlines() or [""])[-1]


def ask(arguments, limit_s=900):
    """(JSON or None, exit status or None, what went wrong, seconds)."""
    from davarlab import cli

    out, err, begin = io.StringIO(), io.StringIO(), time.perf_counter()
    signal.signal(signal.SIGALRM, out_of_time)
    signal.alarm(limit_s)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = cli.main([*map(str, arguments), "--json"])
        found = json.loads(out.getvalue()) if out.getvalue() else None
        wrong = "" if found else f"status {status}: {last_line(err)}"
    except (Exception, SystemExit) as why:  # a benchmark counts crashes, it does not die of them
        place = traceback.extract_tb(why.__traceback__)[-1]
        found, status, wrong = (
            None,
            None,
            f"{type(why).__name__}: {why} ({place.name}:{place.lineno}), after: {last_line(err)}",
        )
    finally:
        signal.alarm(0)
    return found, status, wrong, time.perf_counter() - begin


def run(*arguments):
    """A command with its exit status and what it printed, as subprocess says them."""
    from davarlab import cli

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = cli.main([*map(str, arguments)])
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())


def typed(*arguments):
    """The same in a process of its own, as tools/davarlab would start it: a copy of this one, which
    has loaded the libraries once.
    """
    from davarlab import cli

    def answer():
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        sys.exit(cli.main([*map(str, arguments)]))

    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = multiprocessing.get_context("fork").Process(target=answer)
        process.start()
        process.join()
        out.seek(0)
        err.seek(0)
        return subprocess.CompletedProcess(arguments, process.exitcode, out.read(), err.read())
