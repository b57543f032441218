"""Plans of a setup for a chip: what the planner finds for options of its command
line. Nothing is kept between two requests."""

import io
import os
import shlex
import zipfile
from dataclasses import replace
from typing import Unpack

from davar import places

from ..errors import BadInput
from ..report.values import Json
from .schema import Plan

os.environ.setdefault("DAVAR_PLAN", str(places.shared("build/tools/tools/plan/davar-plan")))

from planner import choice, costs, programs, report, sensors, wishes
from planner.__main__ import files

FOLDER = "setup"  # of the files, in the command to type
ROUND_RATES = (50, 100, 200, 400, 500, 800, 1000, 2000, 4000, 8000)  # Hz, to offer
COSTS = (
    "flash_bytes",
    "ram_bytes",
    "stack_bytes",
    "mean_instructions",
    "worst_push_instructions",
)


def missing() -> str | None:
    """What the planner needs and does not find, and what to do. None: nothing."""
    absent = [
        str(path) for path in (programs.PROGRAM, programs.PROMISE) if not os.access(path, os.X_OK)
    ]
    if not absent:
        return None
    return (
        f"The planner cannot run, because {' and '.join(absent)} cannot be executed. "
        "tools/davarlab open builds what is missing. It needs gcc, make and cmake."
    )


def _rates(part: Json) -> list[float]:
    """Sample rates of a gyro to offer; only these exist if its data sheet lists them."""
    listed = [float(rate) for rate in part.get("bandwidth_at_rate", {})]
    least, most = part["rate_least_hz"], part["rate_most_hz"]
    fitting = [float(rate) for rate in ROUND_RATES if least <= rate <= most]
    return listed or fitting or [least]


def planner() -> Json:
    """What can be stated: gyros by name, cores, types. missing: see above."""
    return {
        "missing": missing(),
        "cores": costs.cores(),
        "types": wishes.TYPES,
        "axes_most": wishes.AXES_MOST,
        "sensors": [
            {
                "name": name,
                "title": part["title"],
                "source": part["source"],
                "rates": _rates(part),
            }
            for name, part in sorted(sensors.PARTS.items(), key=lambda one: str(one[1]["title"]))
        ],
    }


def _read(options: Plan) -> tuple[wishes.Wishes, str]:
    """(the wishes, the command line that states them)."""
    if why := missing():
        raise BadInput(why)
    words = [
        word
        for name, value in options.items()
        for word in (f"--{name.replace('_', '-')}", str(value))
        if value
    ]
    words += ["-o", FOLDER]
    try:
        read = wishes.read(words, costs.cores()).wishes
    except wishes.BadOption as why:
        raise BadInput(str(why)) from None
    return read, shlex.join(["tools/davar-plan", *words])


def _gyro(stated: wishes.Wishes) -> Json:
    """The options that describe the gyro without its name."""
    found = {
        "rate": f"{stated.rate_hz:g}",
        "type": stated.type,
        "lsb": stated.lsb and f"{stated.lsb:g}",
        "bandwidth": stated.bandwidth,
        "noise": stated.noise and f"{stated.noise:.3g}",
    }
    return {name: text for name, text in found.items() if text}


def _row(core: str, found: choice.Plan | None) -> Json:
    """What a plan costs on a core. None: no plan fits it."""
    shown = report.as_json(found) if found else {}
    return {"core": core, "fits": found is not None, **{name: shown.get(name) for name in COSTS}}


def _rows(stated: wishes.Wishes, found: choice.Plan | None) -> list[Json]:
    """A row for each core; found: the plan for the stated one."""
    return [
        _row(core, found if core == stated.core else choice.find(replace(stated, core=core)))
        for core in costs.table()
    ]


def _relaxed(why: choice.Impossible) -> list[dict[str, str]]:
    """The options to change, by their names in a request: one entry for each button."""
    named = [{one.option.removeprefix("--").replace("-", "_"): one.value} for one in why.relaxed]
    return (
        [{name: value for one in named for name, value in one.items()}] if why.together else named
    )


def plan(**options: Unpack[Plan]) -> Json:
    """The plan for these options in words and figures, or why there is none and what would
    help; and what it costs on every core."""
    stated, command = _read(options)
    answer: Json = {
        "command": command,
        "gyro": _gyro(stated),
        "limits": {"flash_bytes": stated.flash_bytes, "ram_bytes": stated.ram_bytes},
    }
    try:
        found = choice.plan(stated)
    except choice.Impossible as why:
        reasons = [*why.reasons, *why.hints]
        return answer | {
            "impossible": reasons,
            "relax": _relaxed(why),
            "cores": _rows(stated, None),
        }
    except wishes.BadOption as why:
        raise BadInput(str(why)) from None
    return answer | {
        "subject": report.subject(found),
        "gives": report.gives(found),
        "costs": report.takes(found),
        "how": report.how(found),
        "check": report.remarks(found),
        "cores": _rows(stated, found),
    }


def setup(**options: Unpack[Plan]) -> bytes:
    """The files that the command line writes, in a zip archive."""
    stated, command = _read(options)
    try:
        contents = files(choice.plan(stated), command)
    except (choice.Impossible, wishes.BadOption) as why:
        raise BadInput(str(why)) from None
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in contents.items():
            archive.writestr(f"{FOLDER}/{name}", text)
    return made.getvalue()
