"""Measures what a setup of tools/davar-plan costs on an emulated bare board: compiles it with the
library, links it, runs it.
"""

import hashlib
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import targets

ROOT = targets.ROOT
sys.path.insert(0, str(ROOT / "tools/plan"))

FLAGS = ("-std=c11", "-Os", "-DNDEBUG", "-ffunction-sections", "-fdata-sections")
ARCHITECTURE = {
    "cortex_m": ("-mthumb", "--specs=nano.specs"),
    "riscv": ("-mcmodel=medany", "--specs=picolibc.specs"),
}
SAMPLE = {"int16": ("int16_t", "1"), "int32": ("int32_t", "100"), "float": ("float", "0.01f")}
Figures = dict[str, float]


def processor(target: str) -> list[str]:
    board = targets.MACHINES[target]
    return [*board["cpu"].split(), *ARCHITECTURE[board["core"]]]


def compiler(target: str) -> str:
    return targets.MACHINES[target]["toolchain"] + "gcc"


def library(target: str, options: Sequence[str], where: Path) -> Path:
    """An archive of the library with these options, made once for each content of lib/."""
    sources = sorted((ROOT / "lib/src").rglob("*.c"))
    content = hashlib.sha256(" ".join([target, *FLAGS, *options]).encode())
    for path in sorted((ROOT / "lib").rglob("*.[ch]*")) + sorted((ROOT / "lib").rglob("*.inc")):
        content.update(path.read_bytes())
    folder = where / "library" / content.hexdigest()[:16]
    archive = folder / "libdavar.a"
    if not archive.exists():
        folder.mkdir(parents=True, exist_ok=True)
        objects = []
        for source in sources:
            objects.append(folder / f"{source.parent.name}-{source.stem}.o")
            compile_one(target, source, objects[-1], options)
        making = folder / "new.a"
        making.unlink(missing_ok=True)
        targets.run(
            [targets.MACHINES[target]["toolchain"] + "ar", "rcs", making, *objects], "archiving"
        )
        making.rename(archive)
    return archive


def compile_one(target: str, source: Path, made: Path, options: Sequence[str]) -> None:
    launcher = os.environ.get("CMAKE_C_COMPILER_LAUNCHER", "").split()
    targets.run(
        [
            *launcher,
            compiler(target),
            *processor(target),
            *FLAGS,
            *options,
            f"-I{ROOT / 'lib/include'}",
            f"-I{ROOT / 'lib/src'}",
            "-c",
            source,
            "-o",
            made,
        ],
        f"compiling {source.name} for {target}",
    )


def board(target: str, where: Path) -> list[Path]:
    """The objects of the board's own code."""
    machine, folder = targets.MACHINES[target], where / "board"
    folder.mkdir(parents=True, exist_ok=True)
    places = ROOT / "port/bare_metal"
    options = [
        f"-DBOARD_CLOCK_PER_US={machine['clock_mhz']}U",
        f"-DBOARD_TIMER={machine['timer']}",
        f"-DBOARD_UART={machine['uart']}",
        "-fno-tree-loop-distribute-patterns",
        f"-I{places}",
    ]
    objects = []
    for name in ("board.c", f"{machine['core']}.c", "semihosting.c", machine["driver"]):
        objects.append(folder / f"{name}.o")
        if not objects[-1].exists():
            compile_one(target, places / name, objects[-1], options)
    return objects


def link(target: str, objects: Sequence[Path], image: Path, *options: str) -> None:
    machine = targets.MACHINES[target]
    flash, ram = machine["flash"].split(), machine["ram"].split()
    script = ROOT / "port/bare_metal" / f"{machine['core']}.ld"
    symbols = (
        f"flash_at={flash[0]}",
        f"flash_size={flash[1]}",
        f"ram_at={ram[0]}",
        f"ram_size={ram[1]}",
    )
    targets.run(
        [
            compiler(target),
            *processor(target),
            "-nostartfiles",
            f"-T{script}",
            *(f"-Wl,--defsym={symbol}" for symbol in symbols),
            "-Wl,--gc-sections",
            *options,
            *objects,
            "-lm",
            "-o",
            image,
        ],
        f"linking {image.name} for {target}",
    )


def bytes_of(target: str, image: Path) -> tuple[int, int]:
    """Flash and RAM of an image."""
    size = targets.MACHINES[target]["toolchain"] + "size"
    text, data, bss = map(int, targets.run([size, image], "size").splitlines()[1].split()[:3])
    return text + data, data + bss


def linked(target: str, folder: Path, options: Sequence[str], where: Path) -> tuple[int, int]:
    """Flash and RAM that a setup adds to an empty program."""
    sizes = []
    for name, empty in (("empty", ["-DEMPTY"]), ("linked", [])):
        main, image = folder / f"{name}.o", folder / f"{name}.elf"
        compile_one(
            target,
            ROOT / "tests/target/setup.c",
            main,
            [*options, *empty, f"-I{folder}", "-ffreestanding"],
        )
        objects = [main] if empty else [main, folder / "davar_setup.o", library(target, options_of(options), where)]
        link(target, objects, image, "-Wl,-emain")
        sizes.append(bytes_of(target, image))
    return sizes[1][0] - sizes[0][0], sizes[1][1] - sizes[0][1]


def options_of(options: Sequence[str]) -> list[str]:
    return [option for option in options if option.startswith("-DDAVAR_")]


def measure(target: str, design, folder: Path) -> Figures:
    """The figures of a setup in `folder`, by compiling, linking and running it."""
    from planner import text

    where = ROOT / "build" / f"setup-{target}"
    sample, unit = SAMPLE[design.wishes.type]
    options = [*(f"-D{define}" for define in text.defines(design))]
    compile_one(target, folder / "davar_setup.c", folder / "davar_setup.o", options)
    measured = [
        *options,
        f"-DSAMPLE={sample}",
        f"-DUNIT={unit}",
        f"-DWINDOW={design.window}U",
        f"-DSTRIDE={design.stride}U",
        *(["-DCURVE"] if design.cascade_taus else []),
    ]
    flash, ram = linked(target, folder, measured, where)
    main, image = folder / "measured.o", folder / "measured.elf"
    compile_one(
        target,
        ROOT / "tests/target/setup.c",
        main,
        [*measured, "-DMEASURED", f"-I{folder}", f"-I{ROOT / 'port/bare_metal'}",
         f"-DBOARD_CLOCK_PER_US={targets.MACHINES[target]['clock_mhz']}U"],
    )
    link(
        target,
        [main, folder / "davar_setup.o", *board(target, where), library(target, options, where)],
        image,
    )
    status, output = targets.execute(target, image, shift=targets.counting_shift(target))
    raw = {name: int(value) for name, value in re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)}
    if status or "stack_take" not in raw:
        shown = "\n".join(output.splitlines()[:10])
        raise targets.TargetError(f"{target}: the setup failed (status {status}):\n{shown}")
    return {
        "flash_bytes": flash,
        "ram_bytes": ram,
        "push_stack_bytes": raw["stack_push"],
        "take_stack_bytes": raw["stack_take"],
        "start_stack_bytes": raw["stack_start"],
        "mean_push_instructions": raw["mean_push_x100"] / 100,
        "worst_push_instructions": raw["worst_push"],
        "mean_take_instructions": raw["mean_take"],
        "worst_take_instructions": raw["worst_take"],
        "curve_instructions": raw.get("curve", 0),
    }
