"""Programs in which one call fails or a signal arrives: support/faults.c, preloaded."""

import contextlib
import itertools
import os
import signal
import subprocess
from pathlib import Path

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def interposer(folder, *flags):
    built = folder / "faults.so"
    source = Path(__file__).parent / "faults.c"
    command = ["cc", "-shared", "-fPIC", "-O1", *flags, "-o", built, source, "-ldl"]
    subprocess.run(command, check=True)
    return built


def environment(built, mark, fault=""):
    """The environment of a program with the fault "function:kind:n", which then creates `mark`."""
    mark.unlink(missing_ok=True)
    words = {"LD_PRELOAD": str(built), "FAULT": fault, "FAULT_MARK": str(mark)}
    return {**os.environ, **words}


def every(run, fault):
    """Yields (n, run("function:kind:n")) for n = 1, 2, ... while the program makes n such calls:
    until it is None.
    """
    for n in itertools.count(1):
        done = run(f"{fault}:{n}")
        if done is None:
            assert n > 1, fault
            return
        yield n, done


@contextlib.contextmanager
def default_signals():
    """Restores the default action of the stop signals inside the block. Programs would inherit
    signals that the process that started the tests ignores.
    """
    before = {number: signal.signal(number, signal.SIG_DFL) for number in STOPS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
