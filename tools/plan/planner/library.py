"""What the library itself computes for a design, by the program davar-plan of tools/plan."""

import os
import re
import subprocess
from functools import cache
from pathlib import Path
from typing import NamedTuple

from .design import Design
from .wishes import BadOption

PROGRAM = Path(
    os.environ.get(
        "DAVAR_PLAN", Path(__file__).resolve().parents[3] / "build/tools/tools/plan/davar-plan"
    )
)
PROMISE = PROGRAM.with_name("davar-promise")


class FitPlan(NamedTuple):
    """text: C of the plan. whitening: settings of law glr, lines of an initialiser."""

    text: str
    whitening: tuple[str, ...]


def run(*words: str) -> str:
    """The output of the program. Raises BadOption with its error."""
    done = subprocess.run([PROGRAM, *words], text=True, capture_output=True, check=False)
    if done.returncode:
        raise BadOption(done.stderr.strip().removeprefix("davar-plan: "))
    return done.stdout


def promise(design: Design, window: int, noise: float) -> dict[str, float]:
    """What the library promises for a window of so many samples, and for the alarms of law glr."""
    wishes = design.wishes
    words = [
        ",".join(map(str, design.taus)),
        wishes.bandwidth or "-",
        repr(wishes.rate_hz),
        str(window),
        repr(noise),
    ]
    if design.law == "glr":
        alarms = repr(wishes.false_alarms_per_hour)
        words += [alarms, str(design.window), str(design.stride)]
    try:
        return _promised(*words)
    except subprocess.CalledProcessError:
        fit_plan(design)  # raises BadOption if the filter is the reason
        raise


@cache
def _promised(*words: str) -> dict[str, float]:
    done = subprocess.run([PROMISE, *words], text=True, capture_output=True, check=True)
    return {name: float(value) for name, value in map(str.split, done.stdout.splitlines())}


def filter_options(design: Design) -> list[str]:
    wishes = design.wishes
    if wishes.bandwidth is None:
        return []
    return ["--bandwidth", wishes.bandwidth, "--rate", repr(wishes.rate_hz)]


def fit_plan(design: Design) -> FitPlan:
    """The plan of the fit for the cluster sizes and the filter of a design."""
    sizes = ",".join(map(str, design.taus))
    slow = ",".join(map(str, design.long_taus)) if design.fit == "terms" else ""
    options = [*(["--long", slow] if slow else []), *filter_options(design)]
    text = run("--taus", sizes, "--name", "davar_setup_plan", *options)
    body, _, comment = text.partition("/* Law glr with this filter:")
    found = re.findall(r"\.(whiten_\w+) = ([-+.e0-9]+)", comment)
    settings = tuple(f".{name} = {value}" for name, value in found if float(value) != 0)
    body = body.split("\n\n", 1)[1]  # without its comment and includes
    return FitPlan(body.rstrip() + "\n", (", ".join(settings),) if settings else ())
