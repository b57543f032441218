"""Measures the cost of davar on each emulated bare board: instructions, flash, RAM, stack, and the
composition of its code.

    python3 tools/support/target_cost.py            measures all bare boards and prints the tables
    python3 tools/support/target_cost.py --write    also updates docs/cost.json and the tables
    python3 tools/support/target_cost.py --pages    updates the tables without measuring

--write and --pages write the tables of the pages from docs/cost.json. Called by tools/davar-bench.
Standard library only.
"""

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import c_library
import call_graph
import targets

Figures = dict[str, float]  # of one target, by name
Costs = dict[str, Figures]
RECORD = targets.ROOT / "docs/cost.json"
README = targets.ROOT / "README.md"
COSTS = targets.ROOT / "docs/COST.md"
LEAN = (
    "-DDAVAR_LAWS=0",
    "-DDAVAR_Q31=0",
    "-DDAVAR_TAUS_MAX=4",
)
LINKED = {
    "adev": (1, LEAN),
    "adev_arw": (2, LEAN),
    "adev_arw_planned": (3, LEAN),
    "everything": (4, ("-DDAVAR_Q31=0", "-DDAVAR_TAUS_MAX=8")),
    "everything_glr": (5, ("-DDAVAR_Q31=0", "-DDAVAR_TAUS_MAX=8")),
}  # tests/target/linked.c
PUSHES = ("davar_push_q15", "davar_push_q31", "davar_q15_gap", "davar_q31_gap")
# Figure, functions, window laws left out.
STACKS = (
    ("init", ("davar_init_q15", "davar_init_q31"), None),
    ("plan", ("davar_plan_init_8_taus", "davar_plan_init_filtered_8_taus"), None),
    ("push", PUSHES, "glr"),
    ("push_glr", PUSHES, None),
    ("take", ("davar_take_8_taus", "davar_fit_8_taus"), None),
)
STRIDE = 60
# Engine, stride.
ENGINES = (("auto", 2), ("auto", 10), ("auto", 60), ("grid", 10), ("grid", 60))


def symbols(target: str, path: Path) -> dict[str, int]:
    """Name -> bytes of the code and constants in an image or an object. If several names share an
    address, the first one.
    """
    found, places = dict[str, int](), set[tuple[str, str] | str]()
    for line in targets.tool(target, "nm", "-S", "--defined-only", path).splitlines():
        fields = line.split()
        if len(fields) == 4 and fields[2] in "tTrRwW":
            place = (fields[0], fields[1]) if path.suffix == ".elf" else line
            found[fields[3]] = found.get(fields[3], 0) + (
                0 if place in places else int(fields[1], 16)
            )
            places.add(place)
    return found


def compiled(target: str, where: Path, flags: Sequence[str], files: Iterable[Path]) -> list[Path]:
    """Objects of these sources in a folder for these flags."""
    folder = where / "linked" / hashlib.sha256(" ".join(map(str, flags)).encode()).hexdigest()[:12]
    folder.mkdir(parents=True, exist_ok=True)
    launcher = os.environ.get("CMAKE_C_COMPILER_LAUNCHER", "").split()
    objects = []
    for file in files:
        objects.append(folder / f"{'-'.join(file.parts[-3:])}.o")
        targets.run(
            [
                *launcher,
                targets.MACHINES[target]["toolchain"] + "gcc",
                *map(str, flags),
                "-c",
                str(file),
                "-o",
                str(objects[-1]),
            ],
            f"compiling {file.name} for {target}",
        )
    return objects


def linked_bytes(target: str, where: Path, what: int, options: Sequence[str]) -> int:
    """Text and data of a program of tests/target/linked.c at -Os, with everything that the compiler
    adds.
    """
    plan = where / "linked_plan.c"
    made = next(
        line
        for line in (where / "davar/lib/CMakeFiles/davar.dir/flags.make").read_text().splitlines()
        if line.startswith("C_FLAGS")
    )
    cpu = [
        *targets.MACHINES[target]["cpu"].split(),
        *(word for word in made.split() if word.startswith(("-mthumb", "--specs"))),
    ]
    flags = [
        *cpu,
        "-std=c11",
        "-Os",
        "-DNDEBUG",
        "-ffunction-sections",
        "-fdata-sections",
        "-ffreestanding",
        *options,
        *c_library.FLAGS,
    ]
    targets.run(
        [
            "sh",
            "-c",
            '"$0" --taus 1,2,4,8 --name plan > "$1"',
            targets.ROOT / "tools/davar-plan",
            plan,
        ],
        "davar-plan",
    )
    objects = [
        *compiled(
            target, where, [*flags, f"-DWHAT={what}"], [targets.ROOT / "tests/target/linked.c"]
        ),
        *compiled(target, where, flags, [plan, *c_library.SOURCES]),
    ]
    image = where / f"linked-{what}.elf"
    link = [
        "-nostartfiles",
        "-Wl,--gc-sections",
        "-Wl,--defsym=__flash_size=0x100000",  # the linker script of RISC-V has 64 kB
    ]
    targets.tool(target, "gcc", *cpu, *objects, *link, "-o", image, "-lm")
    text, data = targets.tool(target, "size", image).splitlines()[1].split()[:2]
    return int(text) + int(data)


def linked(target: str, where: Path) -> dict[str, int]:
    """The bytes that each use of the library links, without those of an empty program."""
    nothing = linked_bytes(target, where, 0, LEAN)
    return {
        f"linked_{name}_bytes": linked_bytes(target, where, *how) - nothing
        for name, how in LINKED.items()
    }


def flash(target: str, where: Path) -> dict[str, int]:
    """Bytes that a q15 application links: the path of a sample, the evaluation of a result, the
    compiler's soft float.
    """
    home = call_graph.sources(target, where)
    own = {
        name
        for path in where.glob("CMakeFiles/*.dir/**/*.obj")
        if not any(part in str(path) for part in ("davar/lib", "davar/addons"))
        for name in symbols(target, path)
    }
    sizes = {"flash_push_bytes": 0, "flash_take_bytes": 0, "flash_compiler_bytes": 0}
    for name, size in symbols(target, where / "cost.elf").items():
        if name in home:
            sizes[
                "flash_take_bytes" if home[name].startswith("lib/src/fit/") else "flash_push_bytes"
            ] += size
        elif name not in own:
            sizes["flash_compiler_bytes"] += size
    return sizes


def measure(target: str) -> Figures:
    """All figures of one target."""
    where = targets.build(target)
    status, output = targets.execute(
        target, where / "cost.elf", shift=targets.counting_shift(target)
    )
    raw = {name: int(value) for name, value in re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)}
    if status or "result_bytes" not in raw:
        raise targets.TargetError(f"{target}: the cost image failed (status {status}):\n{output}")
    state = raw["davar_t_bytes"]
    figures = {
        "every_sample_instructions_per_sample": raw["every_sample_push_x100"] / 100,
        "every_sample_instructions_per_sample_per_tau": round(
            raw["every_sample_push_x100"] / 800, 2
        ),
        "grid_push_instructions_per_sample": raw["grid_push_x100"] / 100,
        "grid_take_instructions_per_result": raw["grid_take"],
        "grid_take_adev_instructions_per_result": raw["grid_take_adev"],
        "grid_arw_instructions_per_sample": raw["grid_arw_x100"] / 100,
        "adaptive_white_instructions_per_sample": raw["adaptive_white"],
        "take_white_mean_instructions": raw["take_white_mean"],
        "pipeline_grid_instructions_per_sample": round(
            raw["grid_push_x100"] / 100 + raw["grid_take"] / STRIDE, 2
        ),
        "grid_single_push_instructions_per_sample": raw["grid_single_push_x100"] / 100,
        "fir64_q15_instructions_per_sample": raw["fir64_q15_x100"] / 100,
        "fixed_worst_push_instructions": raw["every_sample_worst_push"],
        "block64_instructions_per_sample_per_tau": round(raw["block64_x100"] / 800, 2),
        "glr_instructions_per_sample": raw["glr_x100"] / 100,
        "glr_of_25_instructions_per_sample": raw["glr_of_25_x100"] / 100,
        "glr_every_sample_instructions_per_sample": round(
            (raw["glr_every_sample_x100"] - raw["every_sample_push_x100"]) / 100, 2
        ),
        "glr_worst_push_instructions": raw["glr_worst_push"],
        "ram_glr_bytes": raw["ram_glr_bytes"],
        "default_instructions_per_sample": raw["default_push_x100"] / 100,
        "worst_push_instructions": raw["default_worst_push"],
        "grid_worst_push_instructions": raw["grid_worst_push"],
        "worst_take_instructions": raw["worst_take"],
        "ram_bytes": raw["ram_bytes"],
        "ram_grid_bytes": raw["ram_grid_bytes"],
        "state_bytes": state,
        "plan_bytes": raw["plan_bytes"],
        "result_bytes": raw["result_bytes"],
    }
    paths = where / "paths.elf"
    for name, roots, without in STACKS:
        figures[f"stack_{name}_bytes"] = call_graph.stack(target, paths, roots, without)
        if figures[f"stack_{name}_bytes"] < raw.get(f"stack_{name}_bytes", 0):
            raise targets.TargetError(f"{target}: more stack than the bound of {name}")
    for engine, stride in ENGINES:
        name = f"{engine}{stride}"
        figures |= {
            f"{name}_instructions_per_sample": raw[f"{name}_x100"] / 100,
            f"{name}_blocks_instructions_per_sample": raw[f"{name}_blocks_x100"] / 100,
            f"{name}_worst_push_instructions": raw[f"{name}_worst"],
            f"{name}_ram_bytes": raw[f"{name}_ram"],
        }
    figures.update(flash(target, where) | linked(target, where))
    figures["flash_bytes"] = figures["flash_push_bytes"] + figures["flash_take_bytes"]
    return figures


def measure_all() -> Costs:
    return {target: measure(target) for target in targets.BARE}


# --- the tables of the pages ---


class Table(NamedTuple):
    """One table of a page: one row per core, one column for each (title, figure)."""

    page: Path
    name: str  # in the markers around it on the page
    columns: tuple[tuple[str, str], ...]
    cores: tuple[str, ...] = ()  # all if empty

    def text(self, figures: Costs) -> str:
        rows = [
            (core, *(f"{figures[core][key]:.0f}" for _, key in self.columns))
            for core in self.cores or figures
        ]
        return markdown(("core", *(title for title, _ in self.columns)), rows)


ENGINE_COLUMNS = (
    ("one at a time", "instructions_per_sample"),
    ("in blocks of the stride", "blocks_instructions_per_sample"),
    ("worst push", "worst_push_instructions"),
    ("RAM (bytes)", "ram_bytes"),
)


class Engines(NamedTuple):
    """Strides and engines on one core: one row per pair."""

    page: Path
    name: str
    core: str

    def text(self, figures: Costs) -> str:
        values = figures[self.core]
        rows = [
            (
                str(stride),
                engine,
                *(f"{values[f'{engine}{stride}_{key}']:.0f}" for _, key in ENGINE_COLUMNS),
            )
            for engine, stride in ENGINES
        ]
        return markdown(("stride", "engine", *(title for title, _ in ENGINE_COLUMNS)), rows)


TABLES: tuple[Table | Engines, ...] = (
    Table(
        README,
        "summary",
        (
            ("flash (bytes)", "linked_adev_arw_bytes"),
            ("RAM (bytes)", "ram_bytes"),
            ("instructions per sample", "every_sample_instructions_per_sample"),
            ("the example", "grid_arw_instructions_per_sample"),
            ("64-tap FIR", "fir64_q15_instructions_per_sample"),
        ),
        ("cortex-m0", "cortex-m4f", "cortex-m7", "rv32imac"),
    ),
    Table(
        COSTS,
        "flash",
        (
            ("ADEV", "linked_adev_bytes"),
            ("with ARW", "linked_adev_arw_bytes"),
            ("planned on the device", "linked_adev_arw_planned_bytes"),
            ("everything", "linked_everything_bytes"),
            ("and law glr", "linked_everything_glr_bytes"),
        ),
    ),
    Table(
        COSTS,
        "flash by part",
        (
            ("push and take", "flash_push_bytes"),
            ("fit", "flash_take_bytes"),
            ("soft float", "flash_compiler_bytes"),
        ),
    ),
    Table(
        COSTS,
        "RAM",
        (
            ("fixed", "ram_bytes"),
            ("grid of 60", "ram_grid_bytes"),
            ("`glr`", "ram_glr_bytes"),
        ),
    ),
    Table(
        COSTS,
        "stack",
        (
            ("init", "stack_init_bytes"),
            ("plan", "stack_plan_bytes"),
            ("push", "stack_push_bytes"),
            ("push, `glr`", "stack_push_glr_bytes"),
            ("take and fit", "stack_take_bytes"),
        ),
    ),
    Table(
        COSTS,
        "every sample",
        (
            ("fixed", "every_sample_instructions_per_sample"),
            ("fixed, per tau", "every_sample_instructions_per_sample_per_tau"),
            ("`or`, white noise", "adaptive_white_instructions_per_sample"),
            ("`or`, steps and gaps", "default_instructions_per_sample"),
            ("64-tap FIR", "fir64_q15_instructions_per_sample"),
        ),
    ),
    Table(
        COSTS,
        "every block",
        (
            ("push, stride 60", "grid_push_instructions_per_sample"),
            ("and white fit", "grid_arw_instructions_per_sample"),
            ("and full fit", "pipeline_grid_instructions_per_sample"),
            ("fixed, blocks of 64, per tau", "block64_instructions_per_sample_per_tau"),
        ),
    ),
    Table(
        COSTS,
        "glr",
        (
            ("blocks of 10", "glr_instructions_per_sample"),
            ("blocks of 25", "glr_of_25_instructions_per_sample"),
            ("blocks of 10, every sample", "glr_every_sample_instructions_per_sample"),
        ),
    ),
    Table(
        COSTS,
        "worst push",
        (
            ("fixed", "fixed_worst_push_instructions"),
            ("`or`", "worst_push_instructions"),
            ("`or`, grid of 60", "grid_worst_push_instructions"),
            ("`glr`", "glr_worst_push_instructions"),
        ),
    ),
    Table(
        COSTS,
        "take and fit",
        (
            ("take, grid", "grid_take_adev_instructions_per_result"),
            ("take, `or` at every sample", "take_white_mean_instructions"),
            ("take and fit, white noise", "grid_take_instructions_per_result"),
            ("take and fit, worst", "worst_take_instructions"),
        ),
    ),
    Engines(COSTS, "engines", "cortex-m4f"),
)


def markdown(titles: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (titles, *rows)]
    return "\n".join([lines[0], "|---" * len(titles) + "|", *lines[1:]])


def enclosed(table: Table | Engines, figures: Costs) -> str:
    """The table between its markers, as on its page."""
    return (
        f"<!-- {table.name}: made by tools/davar-bench -->\n{table.text(figures)}\n"
        f"<!-- end of {table.name} -->"
    )


def render(figures: Costs) -> None:
    """Writes every table into its page."""
    for table in TABLES:
        new = enclosed(table, figures)
        first, *_, last = new.splitlines()
        before, rest = table.page.read_text(encoding="utf-8").split(first)
        table.page.write_text(before + new + rest.split(last)[1], encoding="utf-8")


def printed(figures: Costs) -> str:
    """All tables with their names, for a terminal."""
    return "\n\n".join(f"{table.name}\n{table.text(figures)}" for table in TABLES)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--pages", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if options.pages:
        render(json.loads(RECORD.read_text(encoding="utf-8")))
        return 0
    try:
        figures = measure_all()
    except (targets.TargetError, OSError, subprocess.SubprocessError) as why:
        print(f"davar-bench: {why}", file=sys.stderr)
        return 2
    if options.write:
        RECORD.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
        render(figures)
    print(json.dumps(figures, indent=1) if options.json else printed(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
