"""Measures what setups of tools/davar-plan cost on the emulated bare boards: compiles them with the
library, links them, runs them. Fits the table from which the planner computes costs.

    python3 tools/support/setup_cost.py            renews python/planner/costs.json
    python3 tools/support/setup_cost.py ROW ...    renews these rows: sizes, flat, floor, small

Called by tools/davar-bench --setups. Standard library only.
"""

import hashlib
import json
import os
import re
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import c_library
import targets

ROOT = targets.ROOT
sys.path.insert(0, str(ROOT / "python"))

from planner import costs, text  # noqa: E402
from planner.design import TAUS_MOST, Design  # noqa: E402
from planner.wishes import TYPES, Wishes  # noqa: E402

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


def archive(target: str, options: Sequence[str], where: Path) -> Path:
    """An archive of the library with these options, made once for each content of its files."""
    content = hashlib.sha256(" ".join([target, *FLAGS, *options]).encode())
    folders = (ROOT / "lib", ROOT / "addons")
    for path in sorted(path for folder in folders for path in folder.rglob("*")):
        if path.suffix in (".c", ".h", ".inc"):
            content.update(path.read_bytes())
    folder = where / "library" / content.hexdigest()[:16]
    made = folder / "libdavar.a"
    if not made.exists():
        folder.mkdir(parents=True, exist_ok=True)
        objects = []
        for source in c_library.SOURCES:
            objects.append(folder / f"{source.parent.name}-{source.stem}.o")
            compile_one(target, source, objects[-1], options)
        making = folder / "new.a"
        making.unlink(missing_ok=True)
        targets.run(
            [targets.MACHINES[target]["toolchain"] + "ar", "rcs", making, *objects], "archiving"
        )
        making.rename(made)
    return made


def compile_one(target: str, source: Path, made: Path, options: Sequence[str]) -> None:
    launcher = os.environ.get("CMAKE_C_COMPILER_LAUNCHER", "").split()
    targets.run(
        [
            *launcher,
            compiler(target),
            *processor(target),
            *FLAGS,
            *options,
            *c_library.FLAGS,
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
        objects = (
            [main]
            if empty
            else [main, folder / "davar_setup.o", archive(target, options_of(options), where)]
        )
        link(target, objects, image, "-Wl,-emain")
        sizes.append(bytes_of(target, image))
    return sizes[1][0] - sizes[0][0], sizes[1][1] - sizes[0][1]


def options_of(options: Sequence[str]) -> list[str]:
    return [option for option in options if option.startswith("-DDAVAR_")]


def write(design: Design, folder: Path) -> None:
    """Writes the C files of a design."""
    for name, content in text.files(design, "davar - a setup.", ["For a measurement."]).items():
        (folder / name).write_text(content, encoding="utf-8")


def measure(target: str, design: Design, folder: Path) -> Figures:
    """The figures of the setup in `folder`, by compiling, linking and running it."""
    where = ROOT / "build" / f"setup-{target}"
    sample, unit = SAMPLE[design.wishes.type]
    options = [f"-D{define}" for define in text.defines(design)]
    compile_one(target, folder / "davar_setup.c", folder / "davar_setup.o", options)
    measured = [
        *options,
        f"-DSAMPLE={sample}",
        f"-DUNIT={unit}",
        f"-DWINDOW={design.window}U",
        f"-DSTRIDE={design.stride}U",
        *(["-DCURVE"] if design.cascade_taus else []),
        *([f"-DFLOOR={design.floor.summed * design.floor.block}U"] if design.floor else []),
    ]
    flash, ram = linked(target, folder, measured, where)
    main, image = folder / "measured.o", folder / "measured.elf"
    compile_one(
        target,
        ROOT / "tests/target/setup.c",
        main,
        [
            *measured,
            "-DMEASURED",
            f"-I{folder}",
            f"-I{ROOT / 'port/bare_metal'}",
            f"-DBOARD_CLOCK_PER_US={targets.MACHINES[target]['clock_mhz']}U",
        ],
    )
    objects = [main, folder / "davar_setup.o", *board(target, where)]
    link(target, [*objects, archive(target, options, where)], image)
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
        "worst_take_instructions": max(raw["worst_take"], raw["moving_take"]),
        "curve_instructions": raw.get("curve", 0),
    }


# --- the table ---

# (axes, cluster sizes, stride, window), small enough for the 16 kB of the Cortex-M0's board. As in
# plans, the window is nine times the largest cluster size.
FIXED = ((1, 5, 20, 160), (1, 8, 150, 1200), (2, 6, 40, 320), (2, 5, 75, 600), (3, 5, 40, 320),
         (1, 8, 258, 2064))  # fmt: skip
SMALL = tuple(point for point in FIXED if point[0] == 1) + ((1, 6, 40, 320),)
GLR = ((1, 4, 50, 800), (1, 6, 100, 500), (2, 4, 30, 200), (1, 4, 100, 500), (1, 6, 40, 400),
       (1, 5, 60, 500), (1, 4, 10, 300), (1, 5, 20, 400), (1, 6, 10, 300),
       (1, 5, 100, 870))  # fmt: skip
# (axes, cluster sizes of the window, stride, cluster sizes of the cascade)
CASCADE = ((1, 5, 40, 6), (1, 7, 75, 12), (2, 5, 20, 13))
CASCADE_ON_A_GRID = ((2, 5, 20, 13), (3, 4, 20, 6))


def design_of(core: str, type: str, law: str, engine: str, point: Sequence[int]) -> Design:
    axes, count, stride, window = point
    wishes = Wishes(
        rate_hz=1000.0, core=core, axes=axes, type=type, lsb=0.061, full_scale=2000.0,
        bandwidth="250:2", false_alarms_per_hour=0.01, motion="none",
    )  # fmt: skip
    if engine.startswith("small"):
        bandwidth = "none" if engine == "small white" else "250:2"
        engine, wishes = "small", replace(wishes, bandwidth=bandwidth, lost_percent=0.0)
    taus = tuple(1 << i for i in range(count))
    shortest = window if law == "fixed" else max(20, 10 * -(-2 * taus[-1] // 10))
    return Design(wishes, law, engine, "arw", window, shortest, stride, taus)


def measured(design: Design) -> Figures:
    with tempfile.TemporaryDirectory() as folder:
        write(design, Path(folder))
        return measure(design.wishes.core, design, Path(folder))


def solve(rows: Sequence[Sequence[float]], values: Sequence[float]) -> list[float]:
    """Least squares of relative errors. Directions without data stay 0."""
    size = len(rows[0])
    weights = [1 / max(abs(value), 1.0) for value in values]
    matrix = [
        [sum((w * row[i]) * (w * row[j]) for w, row in zip(weights, rows)) for j in range(size)]
        + [sum(w * w * row[i] * value for w, row, value in zip(weights, rows, values))]
        for i in range(size)
    ]
    largest = [matrix[i][i] or 1.0 for i in range(size)]
    free = []
    for i in range(size):
        if matrix[i][i] <= 1e-9 * largest[i]:
            continue
        free.append(i)
        for k in range(size):
            if k != i:
                factor = matrix[k][i] / matrix[i][i]
                matrix[k] = [a - factor * b for a, b in zip(matrix[k], matrix[i])]
    return [round(matrix[i][size] / matrix[i][i], 4) if i in free else 0.0 for i in range(size)]


def bound(rows: Sequence[Sequence[float]], values: Sequence[float]) -> list[float]:
    """No value is above the sum with these coefficients: least squares without negative terms,
    scaled.
    """
    kept = [list(row) for row in rows]
    found = solve(kept, values)
    while min(found) < 0:
        least = found.index(min(found))
        for row in kept:
            row[least] = 0.0
        found = solve(kept, values)
    stated = [sum(f * c for f, c in zip(row, found)) for row in rows]
    most = max(value / total for value, total in zip(values, stated))
    return [round(most * c, 4) for c in found]


def fitted(designs: Sequence[Design], found: Sequence[Figures], sizes: Any) -> dict[str, Any]:
    """A row of the table: the coefficients of every figure."""
    row: dict[str, Any] = {}
    for figure, features in costs.FEATURES.items():
        rows = [features(design) for design in designs]
        values = [
            f[figure] - costs.known(figure, design, sizes) for design, f in zip(designs, found)
        ]
        bounds = designs[0].law == "glr" and figure == "worst_push_instructions"
        row[figure] = (bound if bounds else solve)(rows, values)
    row["other_ram_bytes"] = other_ram_bytes(designs, found, sizes)
    return row


def other_ram_bytes(designs: Sequence[Design], found: Sequence[Figures], sizes: Any) -> int:
    """RAM that the C library adds. It is the same for all designs, because the rest is exact."""
    added = {
        int(f["ram_bytes"]) - costs.ram_bytes(design, sizes, 0) for f, design in zip(found, designs)
    }
    if len(added) != 1:
        raise SystemExit(f"{designs[0].law}: RAM is not that of davar/instance.h: {added}")
    return added.pop()


def slow_row(
    designs: Sequence[Design], found: Sequence[Figures], base: Any, sizes: Any
) -> dict[str, Any]:
    """What a cascade adds; stacks and the curve are absolute."""
    row: dict[str, Any] = {}
    for figure, features in costs.SLOW_FEATURES.items():
        rows = [features(design) for design in designs]
        values = [f[figure] for f in found]
        if figure not in costs.ABSOLUTE:
            less = [costs.of_row(figure, base, design, sizes) for design in designs]
            values = [value - k for value, k in zip(values, less)]
        row[figure] = solve(rows, values)
    row["other_ram_bytes"] = other_ram_bytes(designs, found, sizes)
    return row


def in_motion(design: Design, bandwidth: str) -> Design:
    return replace(design, wishes=replace(design.wishes, bandwidth=bandwidth, motion="slow"))


def flat_row(core: str) -> dict[str, Any]:
    """What slow motion adds. The noise of the measured program has no filter: it contradicts the
    designs' filter, which needs the most stack, and "none" needs the most instructions.
    """
    usual = [design_of(core, "int16", "fixed", "slide", point) for point in FIXED]
    all_terms = with_cascade(core, "int16", "slide", "terms", CASCADE[0])
    designs = [*usual, all_terms]
    still = [measured(design) for design in designs]
    moving = [measured(in_motion(design, "250:2")) for design in designs]
    longest = [measured(in_motion(design, "none"))["worst_take_instructions"] for design in usual]
    added = {
        "flash_bytes": [m["flash_bytes"] - s["flash_bytes"] for m, s in zip(moving, still)],
        "take_stack_bytes": [m["take_stack_bytes"] for m in moving[: len(usual)]],
        "worst_take_instructions": [
            most - s["worst_take_instructions"] for most, s in zip(longest, still)
        ],
    }
    row: dict[str, Any] = {}
    for figure, features in costs.FLAT_FEATURES.items():
        rows = [features(design) for design in designs[: len(added[figure])]]
        bounds = figure == "worst_take_instructions"
        row[figure] = (bound if bounds else solve)(rows, added[figure])
    return row


# (axes, sample rate)
FLOORS = ((1, 1000.0), (1, 400.0), (2, 1000.0), (1, 8000.0), (2, 2000.0), (2, 8000.0))


def of_samples(design: Design, rate: float, motion: str) -> Design:
    """The design without a filter, which leaves all frequencies to a floor."""
    wishes = replace(design.wishes, rate_hz=rate, bandwidth="none", motion=motion)
    return replace(design, wishes=wishes)


def floor_row(core: str) -> dict[str, Any]:
    """What the floors add."""
    all_terms = with_cascade(core, "int16", "slide", "terms", CASCADE[2])
    usual = [
        (design_of(core, "int16", "fixed", "slide", (axes, 5, 40, 320)), rate)
        for axes, rate in FLOORS
    ]
    designs, flying = (
        [of_samples(design, rate, motion) for design, rate in [*usual, (all_terms, 1000.0)]]
        for motion in ("none", "flight")
    )
    still, found = [measured(d) for d in designs], [measured(d) for d in flying]
    row: dict[str, Any] = {}
    for figure, features in costs.FLOOR_FEATURES.items():
        values = [f[figure] for f in found]
        if figure != "push_stack_bytes":
            values = [value - s[figure] for value, s in zip(values, still)]
        bounds = figure == "worst_push_instructions"
        row[figure] = (bound if bounds else solve)([features(d) for d in flying], values)
    return row


def with_cascade(core: str, type: str, engine: str, fit: str, point: Sequence[int]) -> Design:
    axes, count, stride, slow = point
    return replace(
        design_of(core, type, "fixed", engine, (axes, count, stride, 8 * stride)),
        fit=fit,
        cascade_shortest=2 << max(count - 1, 5),
        cascade_taus=slow,
    )


def worst_on_a_grid(core: str, type: str, table: Any, sizes: Any) -> float:
    """What a cascade adds to the worst push of an axis on a grid, if the most expensive samples of
    both are the same. The sliding engine seldom has its worst push there.
    """
    base = table["window"][f"{type} fixed grid"]
    added = []
    for point in CASCADE_ON_A_GRID:
        design = with_cascade(core, type, "grid", "curve", point)
        found = measured(design)["worst_push_instructions"]
        alone = costs.of_row("worst_push_instructions", base, design, sizes)
        added.append((found - alone) / design.wishes.axes)
    return round(max(added), 4)


SIZES = """
#include "davar/cascade.h"
#include "davar/davar.h"
#include "davar/average.h"
#include "davar/fit.h"
#include "davar/floor.h"
#include "davar/small.h"
char size_small[sizeof(davar_small_t)];
char size_small_plan[sizeof(davar_small_plan_t)];
char size_average[sizeof(davar_average_t)];
char size_floor[sizeof(davar_floor_t)];
char size_floor_result[sizeof(davar_floor_result_t)];
char size_instance[sizeof(davar_t)];
char size_cascade[sizeof(davar_cascade_t)];
char size_result[sizeof(davar_result_t)];
char size_plan[sizeof(davar_plan_t)];
char size_pointer[sizeof(void *)];
"""


def sizes_of(core: str) -> dict[str, Any]:
    """Bytes of the public types on a core, by DAVAR_TAUS_MAX."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder) / "sizes.c", Path(folder) / "sizes.o"
        source.write_text(SIZES, encoding="ascii")
        for most in range(1, TAUS_MOST + 1):
            compile_one(core, source, made, [f"-DDAVAR_TAUS_MAX={most}"])
            tool = targets.MACHINES[core]["toolchain"] + "nm"
            lines = targets.run([tool, "-S", made], "nm").splitlines()
            found[most] = {
                line.split()[3][5:]: int(line.split()[1], 16) for line in lines if "size_" in line
            }
    of_tau = found[2]["result"] - found[1]["result"]
    of_small = found[2]["small"] - found[1]["small"]
    return {
        "pointer": found[1]["pointer"],
        "instance": found[1]["instance"],
        "cascade": found[1]["cascade"],
        "average": found[1]["average"],
        "floor": found[1]["floor"],
        "floor_result": found[1]["floor_result"],
        "result": [found[1]["result"] - of_tau, of_tau],
        "plan": [found[most]["plan"] for most in found],
        "small": [found[1]["small"] - of_small, of_small],
        "small_plan": [found[most]["small_plan"] for most in found],
    }


def core_table(core: str) -> dict[str, Any]:
    """The costs on one core."""
    sizes = sizes_of(core)
    table: dict[str, Any] = {"sizes": sizes, "flat": flat_row(core), "floor": floor_row(core)}
    table |= {"window": {}, "cascade": {}}
    for type in TYPES:
        for law, engine, points in (
            ("fixed", "slide", FIXED),
            ("fixed", "grid", FIXED),
            ("glr", "grid", GLR),
        ):
            designs = [design_of(core, type, law, engine, point) for point in points]
            found = [measured(design) for design in designs]
            table["window"][f"{type} {law} {engine}"] = fitted(designs, found, sizes)
        if type == "int16":
            table["window"] |= small_rows(core, sizes)
        base = table["window"][f"{type} fixed slide"]
        on_a_grid = worst_on_a_grid(core, type, table, sizes)
        for fit in ("curve", "terms"):
            designs = [with_cascade(core, type, "slide", fit, point) for point in CASCADE]
            found = [measured(design) for design in designs]
            row = slow_row(designs, found, base, sizes)
            row["worst_push_instructions"][1] = on_a_grid
            table["cascade"][f"{type} {fit}"] = row
        print(f"{core}: {type} measured", file=sys.stderr, flush=True)
    return table


def small_rows(core: str, sizes: Any) -> dict[str, Any]:
    """The setups of davar/small.h."""
    rows = {}
    for engine in ("small", "small white"):
        designs = [design_of(core, "int16", "fixed", engine, point) for point in SMALL]
        found = [measured(design) for design in designs]
        rows[f"int16 fixed {engine}"] = fitted(designs, found, sizes)
    return rows


def is_bound(design: Design, figure: str) -> bool:
    """Is the planned figure one that few runs reach? Law glr reaches its worst after a rare
    sequence of blocks; on a grid, the most expensive push of a cascade meets that of the window
    only with some strides. A floor takes longest in noise that falls with frequency.
    """
    if design.floor and figure == "worst_push_instructions":
        return True
    if design.law == "glr":
        return figure in ("push_stack_bytes", "worst_push_instructions")
    meets = design.engine == "grid" and design.cascade_taus
    return bool(meets) and figure == "worst_push_instructions"


ROWS = {"sizes": sizes_of, "flat": flat_row, "floor": floor_row}


def renewed(core: str, rows: Sequence[str]) -> dict[str, Any]:
    """The table of a core with these rows measured again; none: all."""
    if not rows:
        return core_table(core)
    new = {row: ROWS[row](core) for row in rows if row != "small"}
    old = costs.table()[core]
    window, cascade = old.pop("window"), old.pop("cascade")
    if "small" in rows:
        window |= small_rows(core, new.get("sizes", old["sizes"]))
    return {**old, **new, "window": window, "cascade": cascade}


def main() -> int:
    rows = sys.argv[1:]
    try:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            made = pool.map(lambda core: renewed(core, rows), targets.BARE)
            tables = dict(zip(targets.BARE, made))
    except targets.TargetError as why:
        print(f"davar-bench: {why}", file=sys.stderr)
        return 2
    store(tables)
    return 0


def store(tables: dict[str, Any]) -> None:
    """Writes the table, each list on a line."""
    rows = json.dumps(tables, indent=1)
    rows = re.sub(r"\[\s+([^\[\]{}]*?)\s+\]", lambda m: "[" + " ".join(m[1].split()) + "]", rows)
    costs.TABLE_PATH.write_text(rows + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
