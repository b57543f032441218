"""Runs the jobs of tools/test in parallel, counts their results and prints each part in one piece.
Standard library only.
"""

import heapq
import itertools
import json
import os
import shutil
import subprocess
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed, wait
from functools import partial
from pathlib import Path
from typing import ParamSpec, TypeVar

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
LOGS = BUILD / "log"
JOBS = str(os.cpu_count() or 2)
STOPPED = threading.Event()  # set by Ctrl-C: no further job starts


class Slots:
    """So many jobs run at once: those that resume first, then new ones in the order of asking."""

    def __init__(self, count: int) -> None:
        self.free = count
        self.waiting: list[tuple[bool, int]] = []  # a heap
        self.numbers = itertools.count()
        self.changed = threading.Condition()

    def take(self, resumes: bool = False) -> None:
        with self.changed:
            place = (not resumes, next(self.numbers))
            heapq.heappush(self.waiting, place)
            self.changed.wait_for(lambda: self.free > 0 and self.waiting[0] == place)
            heapq.heappop(self.waiting)
            self.free -= 1
            self.changed.notify_all()

    def give(self) -> None:
        with self.changed:
            self.free += 1
            self.changed.notify_all()


# two more than cores: some jobs wait for a browser or the clock of a device
SLOTS = Slots(int(JOBS) + 2)

P = ParamSpec("P")
T = TypeVar("T")


class Tally:
    """Counts of one part; `lines` are for a person to read (failures, names of skipped tests)."""

    def __init__(
        self, passed: int = 0, failed: int = 0, skipped: int = 0, lines: Iterable[str] = ()
    ) -> None:
        self.passed, self.failed, self.skipped, self.lines = passed, failed, skipped, list(lines)
        self.cached = 0  # how many results came from a ResultCache

    def add(self, other: "Tally") -> None:
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped
        self.lines += other.lines
        self.cached += other.cached

    def must(self) -> None:
        """Raises Broken if anything failed."""
        if self.failed:
            raise Broken("\n".join(self.lines))

    def __str__(self) -> str:
        counts = f"{self.passed} passed, {self.failed} failed, {self.skipped} skipped"
        return counts + (f", {self.cached} cached" if self.cached else "")


Job = Callable[[], Tally]


class Broken(Exception):
    """A job cannot run: a build fails or a tool is missing."""


def run(command: Sequence[str], log: str, env: Mapping[str, str] | None = None) -> tuple[int, str]:
    """Runs a command with its output in build/log; returns (exit status, output)."""
    done = subprocess.run(
        command,
        cwd=ROOT,
        env=env,
        text=True,
        errors="replace",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    (LOGS / log).write_text(done.stdout)
    return done.returncode, done.stdout


def tool(*command: str, log: str | None = None) -> Tally:
    """Runs an external tool as one test, which passes if the tool succeeds."""
    if not shutil.which(command[0]):
        raise Broken(f"{command[0]} is not installed")
    status, output = run(list(command), log or f"{Path(command[0]).name}.log")
    return Tally(failed=1, lines=[output]) if status else Tally(passed=1)


def once(work: Callable[P, T]) -> Callable[P, T]:
    """`work`, done once for each argument. A second caller waits for the first and gets its result
    or its failure. While it waits, another job runs.
    """
    done: dict[object, Future[T]] = {}
    lock = threading.Lock()

    def result(*words: P.args, **named: P.kwargs) -> T:
        key = (words, *named.items())
        with lock:
            first = key not in done
            future = done.setdefault(key, Future())
        if first:
            try:
                future.set_result(work(*words, **named))
            except BaseException as why:
                future.set_exception(why)
        elif not future.done():
            SLOTS.give()
            try:
                wait([future])
            finally:
                SLOTS.take(resumes=True)
        return future.result()

    return result


class JobTimes:
    """The duration of each job in the last run. For a new job: the entry of `typical` for its name,
    or for its part.
    """

    def __init__(self, path: Path | str, typical: Mapping[str, float]) -> None:
        self.path, self.typical = Path(path), typical
        try:
            self.measured = {
                str(name): float(value) for name, value in json.loads(self.path.read_text()).items()
            }
        except (OSError, ValueError, AttributeError, TypeError):  # no such file, or a damaged one
            self.measured = {}

    def expected(self, name: str) -> float:
        return self.measured.get(
            name, self.typical.get(name, self.typical.get(name.split()[0], 0.0))
        )

    def store(self, taken: dict[str, float]) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(self.measured | taken, indent=0, sort_keys=True))


def named(part: str, job: Job) -> str:
    """The name of a job in build/log/seconds.json."""
    values = [*job.args, *job.keywords.values()] if isinstance(job, partial) else []
    words = [str(word) for word in values if isinstance(word, (str, int))]
    return " ".join(word for word in dict.fromkeys([part, *words]) if word != "1/1")[:200]


def attempt(job: Job) -> tuple[Tally, float]:
    """(tally, seconds) of one job; a job that breaks is one failure."""
    SLOTS.take()
    try:
        if STOPPED.is_set():
            return Tally(), 0.0
        start = time.monotonic()
        try:
            tally = job()
        except Exception as why:
            tally = Tally(
                failed=1, lines=[str(why) if isinstance(why, Broken) else traceback.format_exc()]
            )
        return tally, time.monotonic() - start
    finally:
        SLOTS.give()


def show(name: str, results: Sequence[tuple[Tally, float]]) -> Tally:
    """Prints one part: a line with its counts and the seconds of all its jobs, then the lines for
    the user. Returns its tally.
    """
    tally = Tally()
    for one, _ in results:
        tally.add(one)
    print(f"{name:<13} {tally}  ({sum(seconds for _, seconds in results):.0f} s)", flush=True)
    for line in dict.fromkeys(
        tally.lines
    ):  # a broken build is reported once, not by every job that needs it
        print("    " + line.rstrip().replace("\n", "\n    "), flush=True)
    return tally


def run_parts(parts: Mapping[str, Sequence[Job]], times: JobTimes | None = None) -> Tally:
    """Runs the jobs of these parts {name: jobs}, the longest first, and prints a part when its last
    job is done.
    """
    total, taken = Tally(), dict[str, float]()
    jobs = [
        (times.expected(named(part, job)) if times else 0, part, number)
        for part, them in parts.items()
        for number, job in enumerate(them)
    ]
    with ThreadPoolExecutor(max(len(jobs), 1)) as pool:  # SLOTS limits how many run
        submitted = {
            (part, number): pool.submit(attempt, parts[part][number])
            for _, part, number in sorted(jobs, key=lambda job: -job[0])
        }
        futures = {
            part: [submitted[part, number] for number in range(len(them))]
            for part, them in parts.items()
        }
        try:
            for _ in as_completed(submitted.values()):
                for part in [
                    part for part, them in futures.items() if all(job.done() for job in them)
                ]:
                    results = [job.result() for job in futures.pop(part)]
                    taken |= {
                        named(part, job): round(spent, 1)
                        for job, (_, spent) in zip(parts[part], results)
                    }
                    total.add(show(part, results))
        except BaseException:
            STOPPED.set()
            raise
    if times:
        times.store(taken)
    return total
