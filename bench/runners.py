"""Every method of methods/: a program made of a C file, or the dictionary METHODS of a Python file.
Each maps a record to its answers, one for each STRIDE samples: sigma, low and high (deg/s), alarm.
"""

import importlib.util
import re
import resource
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from signals import Floats, NotHere, Record

HERE = Path(__file__).resolve().parent
PROGRAMS = HERE.parent / "build/tools/bench"
INSTRUCTIONS_OF = 10_000  # samples
RUNS = 9  # of method.h


@dataclass(frozen=True)
class Method:
    name: str
    file: Path
    answers: Callable[[Record], Floats]
    bytes_of_state: int | None = None
    program: Path | None = None

    def about(self) -> str:
        """The first sentence of its file."""
        text = self.file.read_text()
        comment = text[3 : text.index('"""' if self.file.suffix == ".py" else "*/", 3)]
        return re.split(
            r"(?<=[.?])\s", " ".join(comment.replace("\n *", "\n").split()), maxsplit=1
        )[0]

    def nanoseconds(self, record: Record, with_answers: bool) -> float | None:
        """Per sample. Of a Python method: what the second half of the record takes, and only with
        answers.
        """
        if self.program:
            printed = run(self.program, "take" if with_answers else "push", self.name, record)
            return float(printed)
        if not with_answers:
            return None
        half = Record(
            record.counts[::2].copy(), record.rate_hz, record.lsb_dps, 0.0, record.sigma_dps
        )
        spent = [min(seconds(self, one) for _ in range(3)) for one in (half, record)]
        return 1e9 * (spent[1] - spent[0]) / (record.counts.size - half.counts.size)

    def instructions(self, record: Record) -> float | None:
        """Of this machine per push, counted by valgrind. None: of no C method, or no valgrind."""
        if not self.program or not shutil.which("valgrind"):
            return None
        counted = []
        for length in (INSTRUCTIONS_OF, 2 * INSTRUCTIONS_OF):
            part = Record(
                record.counts[:length], record.rate_hz, record.lsb_dps, 0.0, record.sigma_dps
            )
            words = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
            text = run(self.program, "push", self.name, part, words, errors=True).decode()
            counted.append(int(re.findall(r"Collected : (\d+)", text)[0]))
        return (counted[1] - counted[0]) / (RUNS * INSTRUCTIONS_OF)


def processor_time() -> float:
    """Seconds, with those of programs that have ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def seconds(method: Method, record: Record) -> float:
    start = processor_time()
    method.answers(record)
    return processor_time() - start


def run(
    program: Path,
    what: str,
    name: str,
    record: Record,
    words: list[str] | None = None,
    errors: bool = False,
) -> bytes:
    """What a C program prints for a record; errors: on standard error."""
    known = (record.rate_hz, record.lsb_dps, record.cutoff, record.sheet_dps)
    done = subprocess.run(
        [*(words or []), str(program), what, name, *(f"{one:.17g}" for one in known)],
        input=record.counts.tobytes(),
        capture_output=True,
    )
    if done.returncode:
        raise RuntimeError(f"{name}: {done.stderr.decode()}")
    return done.stderr if errors else done.stdout


def of_c(file: Path) -> list[Method]:
    program = PROGRAMS / f"bench-{file.stem}"
    listed = subprocess.run([program, "list"], check=True, text=True, stdout=subprocess.PIPE).stdout

    def method(name: str, size: str) -> Method:
        def answers(record: Record) -> Floats:
            return np.frombuffer(run(program, "run", name, record)).reshape(-1, 4)

        return Method(name, file, answers, int(size), program)

    return [method(*line.split("\t")) for line in listed.splitlines()]


def of_python(file: Path) -> list[Method]:
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return [Method(name, file, answers) for name, answers in module.METHODS.items()]


def every() -> list[Method]:
    """davar first, then the others by file."""
    files = sorted((HERE / "methods").iterdir(), key=lambda one: (one.stem != "davar", one.name))
    found = [of_c(file) for file in files if file.suffix == ".c"]
    found += [of_python(file) for file in files if file.suffix == ".py"]
    return [method for methods in found for method in methods]


def missing(method: Method, record: Record) -> str | None:
    """Why a method does not run here."""
    try:
        method.answers(record)
    except NotHere as why:
        return str(why)
    return None
