"""What comes out of a setup: compiles its very files for the host and runs them."""

import hashlib
import math
import os
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from . import text
from .choice import Plan
from .wishes import BadOption

ROOT = Path(__file__).resolve().parents[2]
RUNNER = ROOT / "tools/plan/simulated.c"
CACHE = ROOT / "build/simulated"
FLAGS = ("-std=c11", "-O2", "-DNDEBUG", "-ffp-contract=off")
PARTS = ("cascade", "floor", "average", "small")  # of addons, in a setup
PLACES = (
    "lib/include",
    "lib/src",
    *(f"addons/{part}/include" for part in PARTS),
    "host_sim",
    "tools/plan",
)
SAMPLE = {"int16": "int16_t", "int32": "int32_t", "float": "float"}
WINDOWS = 500
CHANGES = {"glr": 300, "fixed": 40}  # of the noise; a fixed window follows all in the same way
MOVING = "0.5 Hz and 5 deg/s"  # of simulated.c
COUNTS = 30.0  # noise of a sample if none is stated
OF_FULL_SCALE = 1e-3  # the same for floats


@dataclass(frozen=True)
class Simulated:
    """Shares of the results from 0 to 1, and of those with ARW. None: not simulated."""

    noise: float  # deg/sqrt(h)
    present: float
    holds: float | None
    arw_percent: float | None
    respond_s: float
    moving_present: float | None
    moving_holds: float | None
    moving_arw_percent: float | None
    floor_present: float | None
    floor_holds: float | None


def _run(command: Sequence[str | Path], what: str) -> str:
    """The output of a command. Raises BadOption if it cannot run or fails."""
    try:
        done = subprocess.run(command, text=True, capture_output=True, check=False)
    except OSError:
        raise BadOption(f"--simulate: needs {command[0]}: install a C compiler") from None
    if done.returncode:
        first = (done.stderr.strip() or f"exit status {done.returncode}").splitlines()[0]
        raise BadOption(f"--simulate: {what}: {first}")
    return done.stdout


def _library(defines: Sequence[str]) -> Path:
    """The library with these options, compiled once for each content of its sources."""
    places = ("lib", *(f"addons/{part}" for part in PARTS))
    sources = sorted([*ROOT.glob("lib/src/*/*.c")])
    sources += [path for part in PARTS for path in sorted(ROOT.glob(f"addons/{part}/src/*.c"))]
    if not sources or not RUNNER.exists():
        raise BadOption("--simulate: needs the sources of davar: run it in a checkout")
    content = hashlib.sha256(" ".join([*FLAGS, *defines]).encode())
    for path in sorted(path for place in places for path in (ROOT / place).rglob("*")):
        if path.suffix in (".c", ".h", ".inc"):
            content.update(path.read_bytes())
    made = CACHE / content.hexdigest()[:16] / "libdavar.a"
    if not made.exists():
        made.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=made.parent) as folder:
            objects = [Path(folder) / f"{s.parent.name}-{s.stem}.o" for s in sources]
            for source, compiled in zip(sources, objects):
                _run([*_compiler(defines), "-c", source, "-o", compiled], "compiling the library")
            archive = Path(folder) / "new.a"
            _run(["ar", "rcs", archive, *objects], "archiving the library")
            os.replace(archive, made)
    return made


def _compiler(defines: Sequence[str]) -> list[str]:
    return [
        os.environ.get("CC", "cc"),
        *FLAGS,
        *(f"-D{define}" for define in defines),
        *(f"-I{ROOT / place}" for place in PLACES),
    ]


def noise_of(plan: Plan) -> float:
    """The stated noise, or a usual one, in deg/sqrt(h)."""
    wishes = plan.design.wishes
    if wishes.noise is not None:
        return wishes.noise
    unit = (
        OF_FULL_SCALE * (wishes.full_scale or 0)
        if wishes.type == "float"
        else COUNTS * (wishes.lsb or 0)
    )
    return float(60 * unit / wishes.rate_hz**0.5)


def simulate(plan: Plan, seed: int = 1) -> Simulated:
    """Runs the setup on the declared noise, filter and counts. Raises BadOption."""
    design, wishes = plan.design, plan.design.wishes
    defines, slow = text.defines(design), wishes.motion == "slow"
    noise, unit = noise_of(plan), 1.0 if wishes.type == "float" else wishes.lsb or 1.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, content in text.files(design, "davar - a setup.", ["To simulate."]).items():
            (folder / file).write_text(content, encoding="utf-8")
        program = folder / "simulated"
        _run(
            [
                *_compiler(defines),
                f"-I{folder}",
                f"-DSAMPLE={SAMPLE[wishes.type]}",
                f"-DUNIT_IS_COUNT={int(wishes.type != 'float')}",
                *(["-DGLR"] if design.law == "glr" else []),
                *(["-DMOVING"] if slow else []),
                *(["-DFLOOR"] if design.floor else []),
                RUNNER,
                folder / "davar_setup.c",
                ROOT / "host_sim/setup/bandwidth.c",
                _library(defines),
                "-lm",
                "-o",
                program,
            ],
            "compiling the setup",
        )
        arguments = [wishes.bandwidth or "-", noise, unit, WINDOWS, CHANGES[design.law], seed]
        lines = _run([program, *map(str, arguments)], "running the setup").splitlines()
    found = {key: float(value) for key, value in map(str.split, lines)}
    found = {key: value for key, value in found.items() if not math.isnan(value)}
    return Simulated(
        noise=noise,
        present=found["present"],
        holds=found.get("holds"),
        arw_percent=found.get("arw_percent"),
        respond_s=found["respond_samples"] / wishes.rate_hz,
        moving_present=found.get("moving_present"),
        moving_holds=found.get("moving_holds"),
        moving_arw_percent=found.get("moving_arw_percent"),
        floor_present=found.get("floor_present"),
        floor_holds=found.get("floor_holds"),
    )
