"""What the library itself computes, by the programs davar-plan and davar-promise of tools/plan."""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from .wishes import BadOption, Wishes

PROGRAM = Path(
    os.environ.get(
        "DAVAR_PLAN", Path(__file__).resolve().parents[2] / "build/tools/tools/plan/davar-plan"
    )
)
PROMISE = PROGRAM.with_name("davar-promise")


AMALGAMATE = Path(__file__).resolve().parents[2] / "tools/support/amalgamate.py"


class FitPlan(NamedTuple):
    """text: C of the plan. whitening: settings of law glr, lines of an initialiser."""

    text: str
    whitening: tuple[str, ...]


@cache
def run(program: Path, *words: str) -> str:
    """The output of a program. Raises BadOption with its error."""
    done = subprocess.run([program, *words], text=True, capture_output=True, check=False)
    if done.returncode:
        raise BadOption(done.stderr.strip().removeprefix(f"{program.name}: "))
    return done.stdout


def _promised(*words: str) -> dict[str, float]:
    lines = run(PROMISE, *words).splitlines()
    return {name: float(value) for name, value in map(str.split, lines)}


def single_files() -> dict[str, str]:
    """davar as two files: name -> content. Raises BadOption."""
    if not AMALGAMATE.exists():
        raise BadOption("--self-contained: needs the sources of davar: run it in a checkout")
    with tempfile.TemporaryDirectory() as folder:
        run(Path(sys.executable), str(AMALGAMATE), folder)
        return {name: Path(folder, name).read_text("utf-8") for name in ("davar.h", "davar.c")}


def memory(pointer: int, name: str, arguments: Sequence[int]) -> int:
    """Bytes of a macro of the library, as in Design.memory. pointer: bytes of one on the core."""
    return int(_promised("memory", str(pointer), name, _list(arguments))["bytes"])


def passed_samples(bandwidth: str, rate_hz: float) -> int:
    """The first octave of cluster sizes that a filter passes. Raises BadOption."""
    return int(_promised(bandwidth, repr(rate_hz))["passed_samples"])


def _list(sizes: Sequence[int]) -> str:
    return ",".join(map(str, sizes))


def promise(
    wishes: Wishes, taus: Sequence[int], window: int, noise: float, alarm: Sequence[int] = ()
) -> dict[str, float]:
    """What the library promises for a window of so many samples, and for the alarms of law glr.
    noise: of a sample in counts. alarm: longest window and stride of law glr, in samples.
    """
    words = [_list(taus), wishes.bandwidth or "-", repr(wishes.rate_hz), str(window), repr(noise)]
    if alarm:
        words += [repr(wishes.false_alarms_per_hour), *map(str, alarm)]
    return _promised(*words)


def fit_plan(wishes: Wishes, taus: Sequence[int], long_taus: Sequence[int] = ()) -> FitPlan:
    """The plan of the fit for the filter and the cluster sizes of the window, and of a cascade."""
    words = ["--taus", _list(taus), "--name", "davar_setup_plan"]
    if long_taus:
        words += ["--long", _list(long_taus)]
    if wishes.bandwidth is not None:
        words += ["--bandwidth", wishes.bandwidth, "--rate", repr(wishes.rate_hz)]
    return _fit_plan(words)


def small_plan(wishes: Wishes, taus: Sequence[int], window: int, stride: int) -> FitPlan:
    """The same for davar/small.h: a constant, for a window of so many samples."""
    return _fit_plan(
        [
            *("--taus", _list(taus), "--name", "davar_setup_plan"),
            *("--bandwidth", str(wishes.bandwidth), "--rate", repr(wishes.rate_hz)),
            *("--lsb", repr(wishes.lsb), "--window", str(window), "--stride", str(stride)),
        ]
    )


def _fit_plan(words: Sequence[str]) -> FitPlan:
    text = run(PROGRAM, *words)
    body, _, comment = text.partition("/* Law glr with this filter:")
    found = re.findall(r"\.(whiten_\w+) = ([-+.e0-9]+)", comment)
    settings = tuple(f".{name} = {value}" for name, value in found if float(value) != 0)
    body = body.split("\n\n", 1)[1]  # without its comment and includes
    return FitPlan(body.rstrip() + "\n", (", ".join(settings),) if settings else ())
