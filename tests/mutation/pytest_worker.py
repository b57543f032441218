"""Runs test modules in forked processes. Imports the modules of its command line before, so that
these need not. Reads a job in JSON from each line of its input, and answers with a line. mutants.py
starts it.
"""

import contextlib
import importlib
import json
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
from pathlib import Path

import pytest


def cpu_seconds():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


class Plugin:
    """Selects and orders the tests of a module, and notes what each test uses and reaches."""

    def __init__(self, tests, reached, most_s):
        self.tests, self.reached, self.most_s = tests, reached, most_s
        self.noted, self.failed = {}, []

    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if not item.get_closest_marker("soak")]
        if self.tests:
            place = {name: number for number, name in enumerate(self.tests)}
            items[:] = sorted(
                (item for item in items if item.nodeid in place),
                key=lambda item: place[item.nodeid],
            )

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        before = cpu_seconds()
        result = yield
        noted = [cpu_seconds() - before, []]
        if self.reached:
            content = self.reached.read_bytes()
            noted[1] = [match.start() for match in re.finditer(b"\1", content)]
            with open(self.reached, "r+b") as file:
                file.write(bytes(len(content)))
        self.noted[item.nodeid] = noted
        if self.most_s and cpu_seconds() > self.most_s:
            item.session.shouldstop = "enough"
        return result

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.failed.append(report.nodeid)


def child(job, answer):
    os.setsid()
    log = os.open(job["log"], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    os.dup2(log, 1)
    os.dup2(log, 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if job["limit_s"]:
        resource.setrlimit(resource.RLIMIT_CPU, (job["limit_s"], job["limit_s"] + 2))
    os.environ.update(job["variables"], PYTEST_DISABLE_PLUGIN_AUTOLOAD="1")
    tempfile.tempdir = os.environ["TMPDIR"] = str(answer.parent)
    reached = job["variables"].get("DAVAR_MUTANTS_REACHED")
    plugin = Plugin(job["tests"], Path(reached) if reached else None, job["most_s"])
    words = ["-q", "-p", "no:cacheprovider", "-p", "no:davar-run", "-p", "no:xdist"]
    words += ["-x"] if job["tests"] else []
    words += ["-o", "addopts=", "--import-mode=importlib", f"--basetemp={answer.parent}/pytest"]
    status = pytest.main([*words, job["module"]], plugins=[plugin])
    answer.write_text(json.dumps({"failed": plugin.failed, "tests": plugin.noted}))
    os._exit(int(status))


def run(job):
    with tempfile.TemporaryDirectory(prefix="mutant-", ignore_cleanup_errors=True) as folder:
        answer = Path(folder, "answer.json")
        process = os.fork()
        if process == 0:
            try:
                child(job, answer)
            finally:
                os._exit(99)

        def end(*_):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process, signal.SIGKILL)

        signal.signal(signal.SIGALRM, end)
        signal.alarm(job["hang_s"])
        _, status, used = os.wait4(process, 0)
        signal.alarm(0)
        end()
        told = json.loads(answer.read_text()) if answer.exists() else {"failed": [], "tests": {}}
        shutil.rmtree(folder, ignore_errors=True)
        seconds = used.ru_utime + used.ru_stime
        return {"status": os.waitstatus_to_exitcode(status), "seconds": seconds, **told}


def main():
    for name in sys.argv[1:]:
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    for line in sys.stdin:
        print(json.dumps(run(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
