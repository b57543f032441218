"""Runs checks that need hours: fuzz targets, Hypothesis with random examples, a week of virtual
time, 100 tabs of the workbench, new samples of mutants, and the tests that are too slow for
tools/test. Standard library only.

A check runs in slices. After each, the state is in build/soak/COMMIT, so a later call of the same
commit continues. A check that has found something does not continue. build/soak/clean.json keeps
the last commit on which each check found nothing.
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
from functools import cache, partial
from pathlib import Path

from check import (
    ALL_TOOLS,
    BUILD,
    PARTS,
    ROOT,
    Broken,
    packages,
    setup_functions,
    test_python,
    use_ccache,
)

LOGS, SOAK = BUILD / "log", BUILD / "soak"
SLICE_S, NOTICE_S = 300.0, 2.0
WEEK_H, LEAST_H = 168, 6  # of virtual time
TIMES = "8"  # as many examples as in tools/test, drawn at random
# Seconds of real time after which a guest counts as hung, however busy the machine is.
HANG_S = "1800"
# The longest input of each fuzz target.
LONGEST = {
    "tracked": 160,
    "calls": 400,
    "fits": 600,
    "cascades": 200,
    "selections": 200,
    "floors": 200,
    "messages": 600,
    "source": 9000,
    "recording": 300,
    "options": 300,
}
MUTATED = ("lib", "host_sim", "gateway", "planner", "davarlab")


def run(command: Sequence[str], log: str, **variables: str) -> tuple[int, str]:
    """Runs a command with its output in build/log; returns (exit status, output)."""
    done = subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, **variables},
        text=True,
        errors="replace",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    (LOGS / log).write_text(done.stdout)
    return done.returncode, done.stdout


SETTING_UP = threading.RLock()


@cache
def set_up(words: str, log: str) -> str:
    """Functions of tools/support/setup.sh, once; one at a time."""
    with SETTING_UP:
        return setup_functions(words, log)


@cache
def python() -> str:
    """The Python of the tests, after everything that they run is built."""
    with SETTING_UP:
        for words in ("debug", "release", *(f"tools {target}" for target in ALL_TOOLS)):
            set_up(f"build {words}", "soak-build.log")
        return test_python()


def built(preset: str) -> Path:
    set_up(f"build {preset}", f"soak-build-{preset}.log")
    return BUILD / preset


def pytest(*words: str) -> list[str]:
    return [python(), "-m", "pytest", "-q", "-rfE", "--gear=soak", *words]


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
    for what it finds; parts: of tools/test, whose Debian packages it needs; whole: in one slice.
    """

    hours: float
    slice: Callable[[float, int, Path], Done]
    parts: tuple[str, ...]
    whole: bool = False
    packages: tuple[str, ...] = ()


ONCE = 1e-5  # hours of a check that runs once, however long it takes
FUZZER = ("clang-14", "libclang-rt-14-dev")
SLOW_TESTS = (
    *FUZZER,
    "BOARDS",
    "dpkg-dev",
    "frama-c-base",
    "why3",
    "z3",
    "cvc4",
)


def fuzz(name: str, hours: float, number: int, folder: Path) -> Done:
    """Runs a fuzz target from another seed in each slice; what reaches new code stays."""
    target, corpus = built("fuzz") / f"tests/fuzz/fuzz_{name}", BUILD / f"fuzz/corpus/{name}"
    if not number or not corpus.exists():
        unpack = [sys.executable, "-B", "tests/fuzz/corpus.py", "unpack", name]
        if run(unpack, f"soak-{name}-corpus.log")[0]:
            raise Broken(f"the corpus of {name} cannot be unpacked")
    found = SOAK / f"found-{name}"
    found.mkdir(parents=True, exist_ok=True)
    words = [str(target), f"-seed={number + 1}", f"-max_total_time={max(1, round(3600 * hours))}"]
    words += [f"-max_len={LONGEST[name]}", f"-artifact_prefix={folder}/{name}-"]
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


def timed(command: Sequence[str], name: str, number: int, into: Path, **variables: str) -> Done:
    """Runs pytest or another check as one slice, with its output if it fails."""
    start = time.monotonic()
    status, output = run(command, f"soak-{name}.log", **variables)
    passed = re.search(r"(\d+) passed", output)
    done = Done(
        (time.monotonic() - start) / 3600, counts={"tests": int(passed[1] if passed else 0)}
    )
    if status:
        done.found.append(kept(into, f"{name}-{number}.log", output))
    return done


def random_examples(hours: float, number: int, folder: Path) -> Done:
    """The next module of tests/hypothesis, once."""
    names = sorted((ROOT / "tests/hypothesis").glob("test_*.py"))
    name = names[number % len(names)]
    words = pytest("--gear=all", str(name))
    return timed(words, name.stem, number, folder, DAVAR_HYPOTHESIS=TIMES, DAVAR_AGAIN="1")


def slow_tests(hours: float, number: int, folder: Path) -> Done:
    """Every test marked soak that needs no kernel of its own."""
    words = pytest("-n2", "--dist=loadgroup", "--ignore=tests/kernel", "tests")
    return timed(words, "tests", number, folder)


def m32(hours: float, number: int, folder: Path) -> Done:
    """The C suites as a 32-bit program."""
    words = ["ctest", "--test-dir", str(built("m32")), "--label-exclude", "long", "--parallel", "2"]
    return timed([*words, "--output-on-failure"], "m32", number, folder)


def mutants(part: str, hours: float, number: int, folder: Path) -> Done:
    """A sample of mutants that nobody has seen: its seed is the day."""
    seed = time.strftime("%Y%m%d")
    words = ["tools/davar-mutants", "--of", part, "--sample", "60", "--seed", seed, "--unlisted"]
    return timed(words, f"mutants-{part}", number, folder)


def linux() -> str:
    """The User-Mode Linux kernel of tests/kernel, built once and shared by all clones."""
    there = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "davar/uml")
    return set_up(f"tools/support/uml/kernel.sh '{there}'", "uml.log")


def guest(*words: str) -> list[str]:
    """A command on that kernel, in virtual time. Files that it writes are lost."""
    path = f"PATH={Path(python()).parent}:{os.environ['PATH']}"
    seen = f"DAVAR_SEEN={os.environ.get('DAVAR_SEEN', '')}"
    run_guest = ["tools/support/uml/run", "-T", "-t", HANG_S, linux()]
    return [*run_guest, "env", path, seen, "DAVAR_BUILT=1", *words]


def kernel(hours: float, number: int, folder: Path) -> Done:
    """The tests of CAN, serial lines and GPIO, but those of a day (the check `week`)."""
    done = Done()
    for path in sorted((ROOT / "tests/kernel").glob("test_*.py")):
        if path.name != "test_day.py":
            words = guest(*pytest(str(path.relative_to(ROOT))))
            done.add(timed(words, path.stem, number, folder))
    return done


def week(hours: float, number: int, folder: Path) -> Done:
    """Hours of virtual time: davar-sim restarted every two hours, recorded by one davarlab live,
    whose memory must not grow (tests/kernel/test_day.py).
    """
    hours = max(LEAST_H, 2 * round(hours / 2))
    words = guest(f"DAVAR_DAY_HOURS={hours}", *pytest("-s", "tests/kernel/test_day.py"))
    done = timed(words, "week", number, folder)
    output = (LOGS / "soak-week.log").read_text()
    results = re.search(r"^(\d+) results$", output, re.MULTILINE)
    memory = re.findall(r" (\d+) KiB", output)
    done.hours, done.counts = hours, {"results": int(results[1]) if results else 0}
    done.counts["most KiB"] = max(map(int, memory), default=0)
    return done


def tabs(hours: float, number: int, folder: Path) -> Done:
    """100 tabs of one workbench server."""
    script = [python(), "-B", "tests/workbench/soak_tabs.py", "--seconds", f"{3600 * hours:.0f}"]
    library = str(BUILD / "tools/python/libdavar_lab.so")
    log, paths = "soak-tabs.log", str(ROOT / "python")
    status, output = run(script, log, DAVAR_LAB_LIBRARY=library, PYTHONPATH=paths)
    lines = [line for line in output.splitlines() if line.startswith("{")]
    done = Done(hours, counts=json.loads(lines[-1]) if lines else {})
    if status:
        done.found.append(kept(folder, f"tabs-{number}.log", output))
    return done


CHECKS = {
    "tests": Check(ONCE, slow_tests, tuple(PARTS), whole=True, packages=SLOW_TESTS),
    "m32": Check(ONCE, m32, (), whole=True, packages=("gcc-12-multilib",)),
    "kernel": Check(ONCE, kernel, ("kernel",), whole=True),
    **{f"mutants-{name}": Check(ONCE, partial(mutants, name), (), whole=True) for name in MUTATED},
    **{f"fuzz-{name}": Check(2.0, partial(fuzz, name), (), packages=FUZZER) for name in LONGEST},
    "hypothesis": Check(1.0, random_examples, ("hypothesis",)),
    "week": Check(WEEK_H, week, ("kernel",), whole=True),
    "tabs": Check(1.0, tabs, ("workbench",), whole=True),
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
        self.clean_file = folder.parent / "clean.json"
        known = self.clean_file.exists()
        self.clean = json.loads(self.clean_file.read_text()) if known else {}

    def wanted(self, name: str) -> float:
        return CHECKS[name].hours * self.share

    def left(self, name: str) -> float:
        """Hours that a check has to run; 0 if it has found something."""
        done = self.done.get(name, Done())
        left = self.wanted(name) - done.hours
        return 0.0 if done.found or left < 1e-9 else left

    def work(self, name: str) -> None:
        """Runs a check to its end, in slices."""
        check = CHECKS[name]
        while (left := self.left(name)) > 0 and not self.stopped.is_set():
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
            if made.found or not self.left(name):
                print(self.row(name), flush=True)

    def save(self) -> None:
        text = json.dumps({name: asdict(done) for name, done in self.done.items()}, indent=1)
        part = self.file.with_suffix(".part")
        part.write_text(text + "\n")
        part.replace(self.file)
        done = [name for name in self.done if not self.left(name) and not self.done[name].found]
        clean = self.clean | dict.fromkeys(done, self.folder.name)
        self.clean_file.write_text(json.dumps(clean, indent=1) + "\n")

    def row(self, name: str) -> str:
        done = self.done.get(name, Done())
        counts = ", ".join(
            f"{count:_} {what.removeprefix('most ')}".replace("_", " ")
            for what, count in done.counts.items()
        )
        hours = f"{clock(done.hours)} of {clock(self.wanted(name))}"
        found = "; ".join(done.found) or "nothing"
        if done.found:
            found += f" (nothing was found on {self.clean.get(name, 'any earlier commit')})"
        return f"{name:<16}{hours:>18}  {counts:<52}  {found}"

    def table(self) -> str:
        head = f"{'check':<16}{'h:min':>18}  {'done':<52}  found"
        return "\n".join([head, *map(self.row, self.names)])

    def run(self) -> int:
        """Runs everything that is left, two at a time on two cores. Returns the exit status."""
        with ThreadPoolExecutor(os.cpu_count() or 2) as pool:
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
        if any(self.left(name) > 0 for name in self.names):
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
        description="Runs checks for a night, and prints one table: tests that are too slow for "
        "tools/test, the suites as a 32-bit program, CAN and GPIO on a kernel of their own, new "
        "samples of mutants, every fuzz target (2 h each), Hypothesis with random examples (1 h), "
        "a week of virtual time of davarlab live, and 100 tabs of the workbench (1 h). If a check "
        "finds something, the table names the last commit on which it found nothing. Ctrl-C "
        "interrupts; the same command on the same commit continues. Exit status 1: a check has "
        "found something.",
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
        parts = list(dict.fromkeys(part for name in names for part in CHECKS[name].parts))
        extra = [package for name in names for package in CHECKS[name].packages]
        print("\n".join(packages(parts, extra)))
        return 0
    use_ccache()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job may ignore it
    LOGS.mkdir(parents=True, exist_ok=True)
    os.environ["DAVAR_AGAIN"] = "1"  # a night repeats what passed by day
    folder = SOAK / commit()
    if options.again:
        shutil.rmtree(folder, ignore_errors=True)
    return Soak(names, options.share, folder).run()


if __name__ == "__main__":
    sys.exit(main())
