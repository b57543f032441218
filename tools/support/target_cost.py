"""Measures the cost of davar on each emulated bare board: instructions, flash, RAM, stack, and the
composition of its code.

    python3 tools/support/target_cost.py            measures all bare boards and prints the tables
    python3 tools/support/target_cost.py --write    also updates docs/cost.json and the tables
    python3 tools/support/target_cost.py --pages    updates the tables without measuring

--write and --pages write the tables of the pages from docs/cost.json. Called by tools/davar-bench.
Standard library only.
"""

import argparse
import functools
import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import targets

Figures = dict[str, float]  # of one target, by name
Costs = dict[str, Figures]
RECORD = targets.ROOT / "docs/cost.json"
README = targets.ROOT / "README.md"
COSTS = targets.ROOT / "docs/COST.md"
LEAN = (
    "-DDAVAR_GRID=0",
    "-DDAVAR_LAWS=0",
    "-DDAVAR_CENTRED=0",
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
STRIDE = 60
# Engine, stride.
ENGINES = (("auto", 2), ("auto", 10), ("auto", 60), ("grid", 10), ("grid", 60))


def tool(target: str, name: str, *arguments: str | Path) -> str:
    return targets.run(
        [targets.MACHINES[target]["toolchain"] + name, *map(str, arguments)], f"{name} for {target}"
    )


def symbols(target: str, path: Path) -> dict[str, int]:
    """Name -> bytes of the code and constants in an image or an object. If several names share an
    address, the first one.
    """
    found, places = dict[str, int](), set[tuple[str, str] | str]()
    for line in tool(target, "nm", "-S", "--defined-only", path).splitlines():
        fields = line.split()
        if len(fields) == 4 and fields[2] in "tTrRwW":
            place = (fields[0], fields[1]) if path.suffix == ".elf" else line
            found[fields[3]] = found.get(fields[3], 0) + (
                0 if place in places else int(fields[1], 16)
            )
            places.add(place)
    return found


def sources(target: str, where: Path) -> dict[str, str]:
    """Symbol -> source file of lib/ that defines it."""
    rooms = where / "davar/lib/CMakeFiles"
    lines = tool(
        target, "nm", "-A", "--defined-only", *sorted(rooms.glob("davar_*.dir/src/**/*.obj"))
    ).splitlines()
    places = {
        line.split()[-1]: line.split(":", 1)[0] for line in lines if line.split()[-2] in "tTrRwW"
    }
    return {
        name: Path(*Path(path).relative_to(rooms).parts[2:]).as_posix()[:-4]
        for name, path in places.items()
    }


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
    lib, plan = targets.ROOT / "lib", where / "linked_plan.c"
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
        f"-I{lib / 'include'}",
        f"-I{lib / 'src'}",
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
        *compiled(target, where, flags, [plan, *sorted((lib / "src").rglob("*.c"))]),
    ]
    image = where / f"linked-{what}.elf"
    link = [
        "-nostartfiles",
        "-Wl,--gc-sections",
        "-Wl,--defsym=__flash_size=0x100000",  # the linker script of RISC-V has 64 kB
    ]
    tool(target, "gcc", *cpu, *objects, *link, "-o", image, "-lm")
    text, data = tool(target, "size", image).splitlines()[1].split()[:2]
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
    home = sources(target, where)
    own = {
        name
        for path in where.glob("CMakeFiles/*.dir/**/*.obj")
        if "davar/lib" not in str(path)
        for name in symbols(target, path)
    }
    sizes = {"flash_push_bytes": 0, "flash_take_bytes": 0, "flash_compiler_bytes": 0}
    for name, size in symbols(target, where / "cost.elf").items():
        if name in home:
            sizes["flash_take_bytes" if home[name].startswith("fit/") else "flash_push_bytes"] += (
                size
            )
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
        "stack_bytes": raw["stack_push_bytes"],
        "stack_take_bytes": raw["stack_take_bytes"],
    }
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


# --- instructions in the path of a sample ---

# Moving a double through a floating-point register is not arithmetic: a compiler for a Cortex-M7
# often does it, and a call on RV64 passes it there. The integer vectors of a Cortex-M55 are not
# arithmetic of this kind either.
FORBIDDEN = re.compile(
    r"^(udiv|sdiv|(div|rem)u?w?|v(?!mov)\S*\.[fF](16|32|64)\S*|f(add|sub|mul|div|sqrt|cvt|n?madd|n?msub)\S*)$"
)


LOAD = re.compile(r"(?:c\.)?l(?:dr|w|d)(?:sp)?(?:\.[wn])?$")
ADDRESS = re.compile(r"(\w+), ?(?:\[\w+(?:, #(\d+))?\]|(\d+)\(\w+\))(?:\s*@.*)?$")
WRITES_NOTHING = re.compile(r"(?:c\.)?(?:cm[pn]|ts?t|teq|cb|b|st|s[bhwd](?:sp)?$|push|dmb|j)")
OUTLIVES_NO_CALL = re.compile(r"r[0-3]|r12|ip|lr|[at]\d+|ra")


class Registers:
    """Which registers hold a word loaded from a known offset of an object: how a function of a
    table is called.
    """

    def __init__(self) -> None:
        self.offset: dict[str, int | None] = {}

    def follow(self, operation: str, operands: str) -> None:
        """One instruction, in the order of the code."""
        loaded = ADDRESS.match(operands)
        first, *others = re.findall(r"[A-Za-z]\w*", operands.split("@")[0]) or [""]
        if LOAD.match(operation) and loaded:
            self.offset[first] = int(loaded.group(2) or loaded.group(3) or 0)
        elif re.match(r"(?:c\.)?mv$|movs?(?:\.[wn])?$", operation) and others:
            self.offset[first] = self.offset.get(others[0])
        elif re.match(r"bl|(?:c\.)?jal", operation):
            self.offset = {
                name: offset
                for name, offset in self.offset.items()
                if not OUTLIVES_NO_CALL.fullmatch(name)
            }
        elif re.match(r"ldm|ldrd|pop", operation):
            self.offset.clear()
        elif not WRITES_NOTHING.match(operation):
            self.offset[first] = None

    def goal(self, operands: str) -> str | int:
        """What a call or jump to the register goes to: the function at an offset of a table, or an
        unknown one.
        """
        offset = self.offset.get(operands.strip())
        return "a pointer" if offset is None else offset


def disassembly(target: str, image: Path) -> dict[str, tuple[set[str], set[str | int]]]:
    """Function -> (instructions, what it goes to: names, and offsets of pointers in a table)."""
    code: dict[str, tuple[set[str], set[str | int]]] = {}
    name, popped = None, None
    registers = Registers()
    for line in tool(target, "objdump", "-d", "--no-show-raw-insn", image).splitlines():
        head = re.match(r"^[0-9a-f]+ <(.+)>:$", line)
        if head:
            name = head.group(1)
            code.setdefault(name, (set(), set()))
            registers = Registers()
            continue
        body = re.match(r"^\s*[0-9a-f]+:\t(\S+)\s*(.*)$", line)
        if body and name:
            operation, operands = body.groups()
            if not operation.startswith(("j", "c.j")):
                operands = operands.split(" # ")[
                    0
                ]  # a constant of RISC-V that happens to be an address
            code[name][0].add(
                operation.split(".")[0] if not operation.startswith("v") else operation
            )
            alone = re.fullmatch(r"{(r\d+)}", operands.strip())
            popped = (
                alone.group(1) if operation == "pop" and alone else popped
            )  # a return of the Cortex-M0
            returns = operands.strip() in ("lr", "ra", popped)
            to_register = not re.search(r"<.+>", operands) and not returns
            if operation in ("bx", "blx", "jr", "c.jr", "jalr", "c.jalr") and to_register:
                code[name][1].add(registers.goal(operands))
            for goal in re.findall(r"<([A-Za-z_][\w.$]*)>", operands):
                code[name][1].add(goal)
            registers.follow(operation, operands)
    return code


def tables(target: str, image: Path) -> dict[str, dict[int, str]]:
    """Name -> {offset: function} of each table: the window laws and the number types."""
    found, functions, places = (
        dict[str, dict[int, str]](),
        dict[int, str](),
        dict[str, tuple[int, int]](),
    )
    thumb = 1 if targets.MACHINES[target]["core"] == "cortex_m" else 0  # bit 0 of a pointer
    for line in tool(target, "nm", "-S", "--defined-only", image).splitlines():
        fields = line.split()
        if len(fields) == 4 and re.match(r"davar_(law|number)_\w+$", fields[3]):
            places[fields[3]] = (int(fields[0], 16), int(fields[1], 16))
        elif len(fields) == 4 and fields[2] in "tT":
            functions[int(fields[0], 16) | thumb] = fields[3]
    pointer = len(fields[0]) // 2
    for name, (start, size) in places.items():
        dump = tool(
            target,
            "objdump",
            "-s",
            f"--start-address={start}",
            f"--stop-address={start + size}",
            image,
        )
        words = "".join(
            "".join(line[: line.index("  ")].split()[1:])
            for line in dump.splitlines()
            if re.match(r"^ [0-9a-f]+ ", line)
        )
        content = bytes.fromhex(words)
        found[name] = {
            offset: functions[address]
            for offset in range(0, size, pointer)
            if (address := int.from_bytes(content[offset : offset + pointer], "little"))
            in functions
        }
    return found


def laws() -> list[str]:
    """The names of the window laws that davar has."""
    header = (targets.ROOT / "lib/include/davar/law.h").read_text(encoding="utf-8")
    return re.findall(r"^extern const davar_law_t (\w+);", header, re.MULTILINE)


@functools.cache
def called_tables(unit: str) -> frozenset[str]:
    """The kinds of tables, "law" or "number", that a source file and its .inc files call through.
    The calls of headers do not count.
    """
    text = (targets.ROOT / "lib/src" / unit).read_text(encoding="utf-8")
    kinds = set(re.findall(r"(law|number)->\w+\(", text))
    for part in re.findall(r'#include "(\S+\.inc)"', text):
        kinds |= called_tables(part)
    return frozenset(kinds)


def reached(
    goals: Iterable[str | int], named: Mapping[str, Mapping[int, str]], unit: str
) -> Iterator[str]:
    """The functions of these goals. The pointer at an offset can be that of any table that the
    source file calls through.
    """
    for goal in goals:
        if isinstance(goal, str):
            yield goal
        else:
            at = [
                functions[goal]
                for name, functions in named.items()
                if goal in functions and name.split("_")[1] in called_tables(unit)
            ]
            yield from at or [f"a pointer at offset {goal}"]


def offences(target: str, image: Path, roots: Iterable[str], gaps: Sequence[str] = ()) -> list[str]:
    """Faults in the path of a sample: divisions, floating point, functions that are not davar's.
    Follows the functions of every window law. gaps: functions that handle a gap, once for each
    gap; they are not part of the path.
    """
    code, home = disassembly(target, image), sources(target, Path(image).parent)
    named = tables(target, image)
    seen, found, wanted = (
        set(gaps),
        [f"{target}: {name} does not exist" for name in gaps if name not in code]
        + [f"{target}: {name} does not exist" for name in laws() if name not in named],
        list(roots),
    )
    while wanted:
        name = wanted.pop()
        if name in seen:
            continue
        seen.add(name)
        unit = home.get(name) or home.get(
            re.sub(r"\.(isra|part|constprop|cold)\.\d+|\.cold", "", name)
        )
        if unit is None:
            found.append(f"{target}: {name} is not a function of davar")
            continue
        operations, goals = code[name]
        found += [
            f"{target}: {operation} in {name}"
            for operation in operations
            if FORBIDDEN.match(operation)
        ]
        wanted += set(reached(goals, named, unit)) - {name}
    return found


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
        "RAM and stack",
        (
            ("fixed", "ram_bytes"),
            ("grid of 60", "ram_grid_bytes"),
            ("`glr`", "ram_glr_bytes"),
            ("stack of push", "stack_bytes"),
            ("stack of take and fit", "stack_take_bytes"),
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
