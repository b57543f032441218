"""Runs checks that need hours: the fuzz targets, Hypothesis with random examples, a week of virtual
time, and 100 tabs of the workbench. Standard library only.

A check runs in slices. After each, the state is in build/soak/COMMIT, so a later call of the same
commit continues. A check that has found something does not continue.
"""

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path

from c_suites import FUZZ, must_run, program, use_ccache
from checks import PARTS
from python_suites import Python, guest, hypothesis, lab, python_module
from runner import BUILD, JOBS, LOGS, ROOT, Broken, run

SLICE_S, NOTICE_S = 300.0, 2.0
WEEK_H, LEAST_H = 168, 6  # of virtual time
TIMES = "4"  # as many examples as in tools/test, drawn at random


@dataclass
class Done:
    """What a check has done. hours: of real or virtual time; slices: how many; counts: of what it
    did, added up over the slices, "most ..." excepted; found: a line for each fault.
    """

    hours: float = 0.0
    slices: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    found: list[str] = field(default_factory=list)

    def add(self, other: "Done") -> None:
        self.hours += other.hours
        self.slices += 1
        for name, count in other.counts.items():
            before = self.counts.get(name, 0)
            self.counts[name] = max(before, count) if name.startswith("most ") else before + count
        self.found += other.found


@dataclass
class Check:
    """hours: how long it runs; slice: runs it for so many hours, as the nth slice, with a folder
    for what it finds; part: of tools/test, whose Debian packages it needs; whole: in one slice.
    """

    hours: float
    slice: Callable[[float, int, Path], Done]
    part: str
    whole: bool = False


def fuzz(name: str, hours: float, number: int, folder: Path) -> Done:
    """Runs a fuzz target from another seed in each slice; what reaches new code stays."""
    target, corpus = program(f"tests/fuzz/fuzz_{name}", "fuzz"), BUILD / f"fuzz/corpus/{name}"
    if not number or not corpus.exists():
        unpack = [sys.executable, "-B", "tests/fuzz/corpus.py", "unpack", name]
        must_run("unpacking the corpus", f"soak-{name}-corpus.log", unpack)
    found = BUILD / f"soak/found-{name}"
    found.mkdir(parents=True, exist_ok=True)
    words = [target, f"-seed={number + 1}", f"-max_total_time={max(1, round(3600 * hours))}"]
    words += [f"-max_len={FUZZ[name][1]}", f"-artifact_prefix={folder}/{name}-"]
    status, output = run([*words, str(found), str(corpus)], f"soak-fuzz-{name}.log")
    runs = re.findall(r"^(?:Done |#)(\d+)", output, re.MULTILINE)
    edges = re.findall(r" cov: (\d+) ", output)
    done = Done(hours, counts={"runs": int(runs[-1]) if runs else 0})
    done.counts["most edges"] = max(map(int, edges), default=0)
    if status:
        input_of = re.search(r"Test unit written to (\S+)", output)
        done.found.append(input_of[1] if input_of else kept(folder, f"{name}-{number}.log", output))
    return done


def kept(folder: Path, name: str, text: str) -> str:
    """Writes the output of a slice that failed. Returns its path."""
    (folder / name).write_text(text)
    return str(folder / name)


def module(
    folder: str, name: str, log: str, setting: Callable[[], Python], number: int, into: Path
) -> Done:
    """Runs a module of tests/ as one slice, timed, with its output if it fails."""
    start = time.monotonic()
    tally = python_module("soak", f"tests/{folder}", name, setting)
    done = Done((time.monotonic() - start) / 3600, counts={"tests": tally.passed})
    if tally.failed:
        done.found.append(kept(into, f"{log}-{number}.log", "\n".join(tally.lines)))
    return done


def random_examples(hours: float, number: int, folder: Path) -> Done:
    """The next module of tests/hypothesis, once."""
    names = sorted(path.name for path in (ROOT / "tests/hypothesis").glob("test_*.py"))

    def setting() -> Python:
        command, variables = hypothesis()
        return command, {**variables, "DAVAR_HYPOTHESIS": TIMES}

    name = names[number % len(names)]
    return module("hypothesis", name, Path(name).stem, setting, number, folder)


def week(hours: float, number: int, folder: Path) -> Done:
    """Hours of virtual time: davar-sim restarted every two hours, recorded by one davarlab live,
    whose memory must not grow (tests/kernel/test_day.py).
    """
    hours = max(LEAST_H, 2 * round(hours / 2))

    def setting() -> Python:
        command, variables = guest()
        return [*command[:-1], f"DAVAR_DAY_HOURS={hours}", command[-1]], variables

    done = module("kernel", "test_day.py", "week", setting, number, folder)
    output = (LOGS / "soak-test_day.log").read_text()
    results = re.search(r"^(\d+) results$", output, re.MULTILINE)
    memory = re.findall(r" (\d+) KiB", output)
    done.hours, done.counts = hours, {"results": int(results[1]) if results else 0}
    done.counts["most KiB"] = max(map(int, memory), default=0)
    return done


def tabs(hours: float, number: int, folder: Path) -> Done:
    """100 tabs of one workbench server."""
    (python, *_), variables = lab()
    script = [python, "-B", "tests/workbench/soak_tabs.py", "--seconds", f"{3600 * hours:.0f}"]
    log = "soak-tabs.log"
    status, output = run(script, log, {**os.environ, **variables})
    lines = [line for line in output.splitlines() if line.startswith("{")]
    done = Done(hours, counts=json.loads(lines[-1]) if lines else {})
    if status:
        done.found.append(kept(folder, f"tabs-{number}.log", output))
    return done


CHECKS = {
    **{f"fuzz-{name}": Check(2.0, partial(fuzz, name), "fuzz") for name in FUZZ},
    "hypothesis": Check(1.0, random_examples, "hypothesis"),
    "week": Check(WEEK_H, week, "kernel", whole=True),
    "tabs": Check(1.0, tabs, "workbench", whole=True),
}


def clock(hours: float) -> str:
    """Hours and minutes."""
    return f"{round(60 * hours) // 60}:{round(60 * hours) % 60:02d}"


class Soak:
    """The checks that were asked for, with what each has done so far in `folder`."""

    def __init__(self, names: Sequence[str], share: float, folder: Path) -> None:
        self.names, self.share, self.folder = names, share, folder
        self.lock, self.stopped = threading.Lock(), threading.Event()
        self.file = folder / "state.json"
        folder.mkdir(parents=True, exist_ok=True)
        there = json.loads(self.file.read_text()) if self.file.exists() else {}
        self.done = {name: Done(**entry) for name, entry in there.items()}

    def wanted(self, name: str) -> float:
        return CHECKS[name].hours * self.share

    def left(self, name: str) -> float:
        """Hours that a check has to run; 0 if it has found something."""
        done = self.done.get(name, Done())
        return 0.0 if done.found else max(0.0, self.wanted(name) - done.hours)

    def work(self, name: str) -> None:
        """Runs a check to its end, in slices."""
        check = CHECKS[name]
        while (left := self.left(name)) > 1e-9 and not self.stopped.is_set():
            hours = left if check.whole else min(left, SLICE_S / 3600)
            try:
                made = check.slice(hours, self.done.get(name, Done()).slices, self.folder)
            except Broken as why:
                made = Done(found=[f"cannot run: {str(why).strip().splitlines()[-1]}"])
            # Ctrl-C reaches the programs too, perhaps before it is noticed here
            if self.stopped.wait(NOTICE_S if made.found else 0.0):
                return  # an interrupted slice does not count
            with self.lock:
                self.done.setdefault(name, Done()).add(made)
                self.save()
            if made.found or self.left(name) <= 1e-9:
                print(self.row(name), flush=True)

    def save(self) -> None:
        text = json.dumps({name: asdict(done) for name, done in self.done.items()}, indent=1)
        part = self.file.with_suffix(".part")
        part.write_text(text + "\n")
        part.replace(self.file)

    def row(self, name: str) -> str:
        done = self.done.get(name, Done())
        counts = ", ".join(
            f"{count:_} {what.removeprefix('most ')}".replace("_", " ")
            for what, count in done.counts.items()
        )
        hours = f"{clock(done.hours)} of {clock(self.wanted(name))}"
        return f"{name:<15}{hours:>18}  {counts:<52}  {'; '.join(done.found) or 'nothing'}"

    def table(self) -> str:
        head = f"{'check':<15}{'h:min':>18}  {'done':<52}  found"
        return "\n".join([head, *map(self.row, self.names)])

    def run(self) -> int:
        """Runs everything that is left, two at a time on two cores. Returns the exit status."""
        with ThreadPoolExecutor(int(JOBS)) as pool:
            running = [pool.submit(self.work, name) for name in self.names]
            try:
                for one in running:
                    one.result()
            except KeyboardInterrupt:
                self.stopped.set()
                pool.shutdown(cancel_futures=True)
        print(f"\n{self.table()}\n")
        if any(self.done.get(name, Done()).found for name in self.names):
            print(
                "A check has found something. Its input or its output is in the file named above."
            )
            return 1
        if any(self.left(name) > 1e-9 for name in self.names):
            print("Interrupted. The same command continues.")
            return 130
        return 0


def commit() -> str:
    """The commit that is checked, marked if files have changed since; "tree" outside a
    repository.
    """
    words = ["git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    done = subprocess.run(words, cwd=ROOT, text=True, capture_output=True)
    return done.stdout.strip() or "tree"


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="tools/soak",
        description="Runs checks that need hours, and prints one table: every fuzz target (2 h "
        "each), Hypothesis with random examples (1 h), a week of virtual time of davarlab live, "
        "and 100 tabs of the workbench (1 h). Ctrl-C interrupts; the same command on the same "
        "commit continues. Exit status 1: a check has found something.",
    )
    parser.add_argument(
        "--only", metavar="NAME,NAME", default="", help=f"of {', '.join(CHECKS)} (default: all)"
    )
    parser.add_argument(
        "--share", type=float, default=1.0, metavar="X", help="this share of the hours (default 1)"
    )
    parser.add_argument("--again", action="store_true", help="forget what this commit has done")
    parser.add_argument("--packages", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    names = [name for name in options.only.split(",") if name] or list(CHECKS)
    if unknown := [name for name in names if name not in CHECKS]:
        parser.error(f"--only {unknown[0]}: no such check (there are: {', '.join(CHECKS)})")
    if not 0 < options.share <= 1000:
        parser.error(f"--share {options.share:g}: a number above 0, at most 1000, expected")
    if options.packages:
        needed = [PARTS[CHECKS[name].part].packages_in(False) for name in names]
        print("\n".join(dict.fromkeys(["cmake", "make", "gcc", *sum(map(list, needed), [])])))
        return 0
    use_ccache(os.environ)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job may ignore it
    LOGS.mkdir(parents=True, exist_ok=True)
    folder = BUILD / "soak" / commit()
    if options.again:
        shutil.rmtree(folder, ignore_errors=True)
    return Soak(names, options.share, folder).run()


if __name__ == "__main__":
    sys.exit(main())
