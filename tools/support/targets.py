"""The emulated boards: how to build for each, how to run an image. Standard library only."""

import fcntl
import functools
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NotRequired, TypedDict

ROOT = Path(__file__).resolve().parents[2]


class Board(TypedDict):
    """The fields of an entry of boards.json that the tools read."""

    core: str
    toolchain: str
    cpu: str
    emulator: str
    small: bool
    # of bare boards
    flash: NotRequired[str]
    ram: NotRequired[str]
    driver: NotRequired[str]
    clock_mhz: NotRequired[int]
    timer: NotRequired[str]
    uart: NotRequired[str]


MACHINES: dict[str, Board] = json.loads(
    (ROOT / "port/bare_metal/boards.json").read_text(encoding="ascii")
)
# These count instructions and have a timer interrupt and a UART.
BARE = [target for target, board in MACHINES.items() if board["core"] != "linux"]


class TargetError(Exception):
    """A build or a run that failed. The text gives the command and its output."""


def folder(target: str, kind: str = "target") -> Path:
    return ROOT / "build" / f"{kind}-{target}"


def taus_max(target: str, kind: str) -> int:
    """Cluster sizes of a result: eight for measurements; as many as the RAM allows for other
    images.
    """
    if kind == "target" or MACHINES[target]["small"]:
        return 24 if kind == "long" else 8
    return 32


def job_kind(target: str, has_cascade: bool) -> str:
    """The images that run a job. A small board has others for a job with a cascade: more cluster
    sizes, and less memory for windows.
    """
    return "long" if has_cascade and MACHINES[target]["small"] else "job"


def run(command: Sequence[str | Path], what: str) -> str:
    done = subprocess.run(
        command,
        text=True,
        errors="replace",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if done.returncode:
        raise TargetError(f"{what} failed:\n{done.stdout}")
    return done.stdout


def tool(target: str, name: str, *arguments: str | Path) -> str:
    """What a tool of the target's tool chain prints."""
    return run([MACHINES[target]["toolchain"] + name, *map(str, arguments)], f"{name} for {target}")


def build(target: str, kind: str = "target", image: str | None = None) -> Path:
    """Configures and builds the images of a target (or one of them): "target" to measure, "job" and
    "long" (job_kind) for davar-mcu, "suites" with Unity (needs DAVAR_UNITY_DIR), "portable" the
    same without hand-written instructions. Returns the folder.
    """
    toolchain = ROOT / "port/bare_metal/targets" / f"{MACHINES[target]['core']}.cmake"
    where = folder(target, kind)
    where.mkdir(parents=True, exist_ok=True)
    with open(where / "lock", "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # concurrent builds run one after the other
        unity = os.environ["DAVAR_UNITY_DIR"] if kind in ("suites", "portable") else ""
        command = [
            "cmake",
            "-S",
            str(ROOT / "port/bare_metal"),
            "-B",
            str(where),
            f"-DCMAKE_TOOLCHAIN_FILE={toolchain}",
            f"-DDAVAR_TARGET={target}",
            "-DCMAKE_BUILD_TYPE=Release",
            f"-DDAVAR_TAUS_MAX={taus_max(target, kind)}",
            f"-DDAVAR_PORTABLE={'ON' if kind == 'portable' else 'OFF'}",
            f"-DDAVAR_UNITY_DIR={unity}",
        ]
        asked, stamp = (
            "\n".join([*command, json.dumps(MACHINES[target])]),
            where / "configured",
        )  # make handles changes of the CMake files
        if not stamp.exists() or stamp.read_text(encoding="utf-8") != asked:
            run(command, f"configuring {target}")
            stamp.write_text(asked, encoding="utf-8")
        run(
            [
                "cmake",
                "--build",
                str(where),
                "--parallel",
                str(os.cpu_count() or 2),
                *(["--target", image] if image else []),
            ],
            f"building {target}",
        )
    return where


def counting_shift(target: str) -> int:
    """With this shift the board's clock counts instructions (board.h)."""
    return {"cortex_m": 8, "riscv": 0}[MACHINES[target]["core"]]


def command(
    target: str,
    image: str | Path,
    arguments: str = "",
    shift: int | None = None,
    serial: str = "null",
) -> list[str]:
    """The emulator's command line. Bare board: with shift, an instruction takes exactly 2^shift ns
    of the board's time (None: not exact); serial is the destination of the UART (null, pty,
    file:PATH).
    """
    if target not in BARE:
        return [*MACHINES[target]["emulator"].split(), str(image), *arguments.split()]
    icount = ["-icount", f"shift={shift}"] if shift is not None else []
    semihosting = f"enable=on,target=native,arg={Path(image).stem}" + "".join(
        f",arg={word}" for word in arguments.split()
    )
    return [
        *MACHINES[target]["emulator"].split(),
        "-display",
        "none",
        "-monitor",
        "none",
        "-serial",
        serial,
        *icount,
        "-semihosting-config",
        semihosting,
        "-kernel",
        str(image),
    ]


def execute(
    target: str,
    image: Path,
    arguments: str = "",
    shift: int | None = None,
    serial: str = "null",
    timeout: float = 1200,
) -> tuple[int, str]:
    """Runs one image (a path) on a target and returns (exit status, output)."""
    done = subprocess.run(
        command(target, image, arguments, shift, serial),
        text=True,
        errors="replace",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=timeout,
        check=False,
    )
    return done.returncode, done.stdout


@functools.cache
def emulator_version(target: str) -> str:
    return run([MACHINES[target]["emulator"].split()[0], "--version"], "querying the emulator")


def identity(target: str, image: str | Path) -> list[str | Path]:
    """Everything that the result of an image without input depends on: its bytes and the emulator
    (result_cache.content_key).
    """
    return [emulator_version(target), *command(target, "image"), Path(image)]


def main(arguments: Sequence[str]) -> int:
    """targets.py list | build TARGET SIZES | run TARGET SIZES JOB RESULTS, for tools/davar-mcu.
    SIZES: window, or cascade for --longest-tau.
    """
    if arguments == ["list"]:
        print(*MACHINES)
        return 0
    verb, target, sizes, *files = arguments
    kind = job_kind(target, sizes == "cascade")
    try:
        if verb == "build":
            build(target, kind, "replay")
            return 0
        status, output = execute(
            target, folder(target, kind) / "replay.elf", " ".join(files), timeout=36000
        )
        sys.stderr.write(output)
        return status
    except TargetError as why:
        print(f"davar-mcu: {why}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
