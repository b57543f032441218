"""What davar costs on each emulated bare board: instructions, flash, RAM, stack; and what its code is made of.

    python3 tools/support/target_cost.py [--write]     measures all bare boards; --write renews docs/cost.json and the README

Called by tools/davar-bench. Standard library only.
"""

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import targets

RECORD = targets.ROOT / "docs/cost.json"
README = targets.ROOT / "README.md"
MARKS = ("<!-- cost table: made by tools/davar-bench --targets --write -->", "<!-- end of the cost table -->")
COSTS = targets.ROOT / "docs/COST.md"
ENGINE_MARKS = ("<!-- table of the engines: made likewise -->", "<!-- end of the table of the engines -->")
LEAN = ("-DDAVAR_GRID=0", "-DDAVAR_LAWS=0", "-DDAVAR_CENTRED=0", "-DDAVAR_Q31=0", "-DDAVAR_TAUS_MAX=4")
LINKED = {"adev": (1, LEAN), "adev_arw": (2, LEAN), "adev_arw_planned": (3, LEAN),
          "everything": (4, ("-DDAVAR_Q31=0", "-DDAVAR_TAUS_MAX=8"))}  # tests/target/linked.c
STRIDE = 60


def tool(target, name, *arguments):
    return targets.run([targets.MACHINES[target]["toolchain"] + name, *map(str, arguments)], f"{name} for {target}")


def symbols(target, path):
    """Name -> bytes of the code and constants in an image or an object; of several names for one place, the first."""
    found, places = {}, set()
    for line in tool(target, "nm", "-S", "--defined-only", path).splitlines():
        fields = line.split()
        if len(fields) == 4 and fields[2] in "tTrRwW":
            place = (fields[0], fields[1]) if path.suffix == ".elf" else line
            found[fields[3]] = found.get(fields[3], 0) + (0 if place in places else int(fields[1], 16))
            places.add(place)
    return found


def sources(target, where):
    """Symbol -> source file of lib/ that it comes from."""
    rooms = where / "davar/lib/CMakeFiles"
    lines = tool(target, "nm", "-A", "--defined-only", *sorted(rooms.glob("davar_*.dir/src/**/*.obj"))).splitlines()
    places = {line.split()[-1]: line.split(":", 1)[0] for line in lines if line.split()[-2] in "tTrRwW"}
    return {name: Path(*Path(path).relative_to(rooms).parts[2:]).as_posix()[:-4] for name, path in places.items()}


def compiled(target, where, flags, files):
    """Objects of these sources in a folder of these flags."""
    folder = where / "linked" / hashlib.sha256(" ".join(map(str, flags)).encode()).hexdigest()[:12]
    folder.mkdir(parents=True, exist_ok=True)
    launcher = os.environ.get("CMAKE_C_COMPILER_LAUNCHER", "").split()
    objects = []
    for file in files:
        objects.append(folder / f"{'-'.join(file.parts[-3:])}.o")
        targets.run([*launcher, targets.MACHINES[target]["toolchain"] + "gcc", *map(str, flags), "-c", str(file), "-o", str(objects[-1])],
                    f"compiling {file.name} for {target}")
    return objects


def linked_bytes(target, where, what, options):
    """Text and data of a program of tests/target/linked.c at -Os, with all that the compiler adds."""
    lib, plan = targets.ROOT / "lib", where / "linked_plan.c"
    made = next(line for line in (where / "davar/lib/CMakeFiles/davar.dir/flags.make").read_text().splitlines() if line.startswith("C_FLAGS"))
    cpu = [*targets.MACHINES[target]["cpu"].split(), *(word for word in made.split() if word.startswith(("-mthumb", "--specs")))]
    flags = [*cpu, "-std=c11", "-Os", "-DNDEBUG", "-ffunction-sections", "-fdata-sections", "-ffreestanding", *options,
             f"-I{lib / 'include'}", f"-I{lib / 'src'}"]
    targets.run(["sh", "-c", '"$0" --taus 1,2,4,8 --name plan > "$1"', targets.ROOT / "tools/davar-plan", plan], "davar-plan")
    objects = [*compiled(target, where, [*flags, f"-DWHAT={what}"], [targets.ROOT / "tests/target/linked.c"]),
               *compiled(target, where, flags, [plan, *sorted((lib / "src").rglob("*.c"))])]
    image = where / f"linked-{what}.elf"
    tool(target, "gcc", *cpu, *objects, "-nostartfiles", "-Wl,--gc-sections", "-o", image, "-lm")
    text, data = tool(target, "size", image).splitlines()[1].split()[:2]
    return int(text) + int(data)


def linked(target, where):
    """What each use of the library links, a program that does nothing taken off."""
    nothing = linked_bytes(target, where, 0, LEAN)
    return {f"linked_{name}_bytes": linked_bytes(target, where, *how) - nothing for name, how in LINKED.items()}


def flash(target, where):
    """Bytes that a q15 application links: the path of a sample, the evaluation of a result, the compiler's soft float."""
    home = sources(target, where)
    own = {name for path in where.glob("CMakeFiles/*.dir/**/*.obj") if "davar/lib" not in str(path)
           for name in symbols(target, path)}
    sizes = {"flash_push_bytes": 0, "flash_take_bytes": 0, "flash_compiler_bytes": 0}
    for name, size in symbols(target, where / "cost.elf").items():
        if name in home:
            sizes["flash_take_bytes" if home[name].startswith("fit/") else "flash_push_bytes"] += size
        elif name not in own:
            sizes["flash_compiler_bytes"] += size
    return sizes


def measure(target):
    """All figures of one target."""
    where = targets.build(target)
    status, output = targets.execute(target, where / "cost.elf", shift=targets.counting_shift(target))
    raw = {name: int(value) for name, value in re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)}
    if status or "result_bytes" not in raw:
        raise targets.TargetError(f"{target}: the cost image failed (status {status}):\n{output}")
    state = raw["davar_t_bytes"]
    figures = {
        "every_sample_instructions_per_sample": raw["every_sample_push_x100"] / 100,
        "every_sample_instructions_per_sample_per_tau": round(raw["every_sample_push_x100"] / 800, 2),
        "grid_push_instructions_per_sample": raw["grid_push_x100"] / 100,
        "grid_take_instructions_per_result": raw["grid_take"],
        "grid_take_adev_instructions_per_result": raw["grid_take_adev"],
        "grid_arw_instructions_per_sample": raw["grid_arw_x100"] / 100,
        "adaptive_white_instructions_per_sample": raw["adaptive_white"],
        "take_white_mean_instructions": raw["take_white_mean"],
        "pipeline_grid_instructions_per_sample": round(raw["grid_push_x100"] / 100 + raw["grid_take"] / STRIDE, 2),
        "grid_single_push_instructions_per_sample": raw["grid_single_push_x100"] / 100,
        "fir64_q15_instructions_per_sample": raw["fir64_q15_x100"] / 100,
        "fixed_worst_push_instructions": raw["every_sample_worst_push"],
        "block64_instructions_per_sample_per_tau": round(raw["block64_x100"] / 800, 2),
        "glr_instructions_per_sample": raw["glr_x100"] / 100,
        "glr_of_25_instructions_per_sample": raw["glr_of_25_x100"] / 100,
        "glr_worst_push_instructions": raw["glr_worst_push"],
        "ram_glr_bytes": raw["ram_glr_bytes"],
        "default_instructions_per_sample": raw["default_push_x100"] / 100,
        "worst_push_instructions": raw["default_worst_push"],
        "grid_worst_push_instructions": raw["grid_worst_push"],
        "worst_take_instructions": raw["worst_take"],
        "ram_bytes": raw["ram_bytes"], "ram_grid_bytes": raw["ram_grid_bytes"], "state_bytes": state,
        "plan_bytes": raw["plan_bytes"], "result_bytes": raw["result_bytes"],
        "stack_bytes": raw["stack_push_bytes"], "stack_take_bytes": raw["stack_take_bytes"],
    }
    for engine in ("grid10", "edges10", "grid60", "edges60"):
        figures |= {f"{engine}_instructions_per_sample": raw[f"{engine}_x100"] / 100,
                    f"{engine}_blocks_instructions_per_sample": raw[f"{engine}_blocks_x100"] / 100,
                    f"{engine}_worst_push_instructions": raw[f"{engine}_worst"], f"{engine}_ram_bytes": raw[f"{engine}_ram"]}
    figures.update(flash(target, where) | linked(target, where))
    figures["flash_bytes"] = figures["flash_push_bytes"] + figures["flash_take_bytes"]
    return figures


def measure_all():
    return {target: measure(target) for target in targets.BARE}


# --- what the path of a sample is made of ------------------------------------------------------------------------------

# Moving a double through a floating-point register is no arithmetic: a compiler for a Cortex-M7 likes to, a call on RV64 passes
# it there. Nor are the integer vectors of a Cortex-M55.
FORBIDDEN = re.compile(r"^(udiv|sdiv|(div|rem)u?w?|v(?!mov)\S*\.[fF](16|32|64)\S*|f(add|sub|mul|div|sqrt|cvt|n?madd|n?msub)\S*)$")


def disassembly(target, image):
    """Function -> (instructions, functions it goes to)."""
    code, name, popped = {}, None, None
    for line in tool(target, "objdump", "-d", "--no-show-raw-insn", image).splitlines():
        head = re.match(r"^[0-9a-f]+ <(.+)>:$", line)
        if head:
            name = head.group(1)
            code.setdefault(name, (set(), set()))
            continue
        body = re.match(r"^\s*[0-9a-f]+:\t(\S+)\s*(.*)$", line)
        if body and name:
            operation, operands = body.groups()
            if not operation.startswith(("j", "c.j")):
                operands = operands.split(" # ")[0]  # a RISC-V's constant that happens to be an address
            code[name][0].add(operation.split(".")[0] if not operation.startswith("v") else operation)
            alone = re.fullmatch(r"{(r\d+)}", operands.strip())
            popped = alone.group(1) if operation == "pop" and alone else popped  # how a Cortex-M0 returns
            returns = operands.strip() in ("lr", "ra", popped)
            to_register = not re.search(r"<.+>", operands) and not returns
            if operation in ("bx", "blx", "jr", "c.jr", "jalr", "c.jalr") and to_register:
                code[name][1].add("a pointer")
            for goal in re.findall(r"<([A-Za-z_][\w.$]*)>", operands):
                code[name][1].add(goal)
    return code


def offences(target, image, roots, gaps=()):
    """What a sample's path contains and must not: divisions, floating point, functions that are not davar's. gaps: functions that deal
    with a gap, once for each, and are no part of it."""
    code, home = disassembly(target, image), sources(target, Path(image).parent)
    seen, found, wanted = set(gaps), [f"{target}: {name} is not there" for name in gaps if name not in code], list(roots)
    while wanted:
        name = wanted.pop()
        if name in seen:
            continue
        seen.add(name)
        if re.sub(r"\.(isra|part|constprop|cold)\.\d+|\.cold", "", name) not in home and name not in home:
            found.append(f"{target}: {name} is not davar's own")
            continue
        operations, goals = code[name]
        found += [f"{target}: {operation} in {name}" for operation in operations if FORBIDDEN.match(operation)]
        wanted += goals - {name}
    return found


# --- the table ---------------------------------------------------------------------------------------------------------

SHORT = (
    ("flash: ADEV", "linked_adev_bytes"), ("with ARW", "linked_adev_arw_bytes"), ("planned there", "linked_adev_arw_planned_bytes"), ("everything", "linked_everything_bytes"),
    ("RAM", "ram_bytes"), ("every sample", "every_sample_instructions_per_sample"), ("`or`", "adaptive_white_instructions_per_sample"),
    ("example", "grid_arw_instructions_per_sample"), ("64-tap FIR", "fir64_q15_instructions_per_sample"))
COLUMNS = (
    ("every sample", "every_sample_instructions_per_sample"), ("per tau", "every_sample_instructions_per_sample_per_tau"),
    ("adaptive", "default_instructions_per_sample"), ("grid push", "grid_push_instructions_per_sample"),
    ("with take and fit", "pipeline_grid_instructions_per_sample"), ("64-tap FIR", "fir64_q15_instructions_per_sample"),
    ("worst fixed push", "fixed_worst_push_instructions"), ("worst push", "worst_push_instructions"),
    ("worst grid push", "grid_worst_push_instructions"), ("take and fit", "grid_take_instructions_per_result"),
    ("ADEV alone", "grid_take_adev_instructions_per_result"), ("ADEV alone, adaptive", "take_white_mean_instructions"),
    ("worst take and fit", "worst_take_instructions"), ("block of 64, per tau", "block64_instructions_per_sample_per_tau"),
    ("glr adds", "glr_instructions_per_sample"), ("glr of 25 adds", "glr_of_25_instructions_per_sample"),
    ("worst glr push", "glr_worst_push_instructions"), ("RAM glr", "ram_glr_bytes"),
    ("flash push", "flash_push_bytes"), ("flash fit", "flash_take_bytes"), ("soft float", "flash_compiler_bytes"),
    ("RAM", "ram_bytes"), ("RAM grid", "ram_grid_bytes"), ("stack push", "stack_bytes"),
    ("stack take and fit", "stack_take_bytes"))


ENGINES = tuple((f"{name} of {stride}{what}", f"{name}{stride}_{key}") for stride in (10, 60) for name in ("grid", "edges") for what, key in (
    ("", "instructions_per_sample"), (", in blocks", "blocks_instructions_per_sample"), (", worst push", "worst_push_instructions"),
    (", RAM", "ram_bytes")))
TABLES = ((README, MARKS, SHORT), (COSTS, MARKS, COLUMNS), (COSTS, ENGINE_MARKS, ENGINES))


def table(figures, columns):
    rows = ["| target | " + " | ".join(title for title, _ in columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for target, values in figures.items():
        cells = [f"{values[key]:.0f}" for _, key in columns]
        rows.append(f"| {target} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def write(figures):
    RECORD.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    for page, marks, columns in TABLES:
        before, rest = page.read_text(encoding="utf-8").split(marks[0])
        after = rest.split(marks[1])[1]
        page.write_text(f"{before}{marks[0]}\n{table(figures, columns)}\n{marks[1]}{after}", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        figures = measure_all()
    except (targets.TargetError, OSError, subprocess.SubprocessError) as why:
        print(f"davar-bench: {why}", file=sys.stderr)
        return 2
    if options.write:
        write(figures)
    print(json.dumps(figures, indent=1) if options.json else "\n\n".join(table(figures, columns) for _, _, columns in TABLES))
    return 0


if __name__ == "__main__":
    sys.exit(main())
