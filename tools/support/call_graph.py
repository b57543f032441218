"""The calls in an image of a board, read from its disassembly: what a function reaches, whether it
divides, how deep its stack gets. Standard library only.
"""

import functools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import targets


def sources(target: str, where: Path) -> dict[str, str]:
    """Symbol -> source file of lib/ or addons/ that defines it."""
    places = {}
    for folder in ("lib", "addons"):
        built = where / "davar" / folder / "CMakeFiles"
        objects = sorted(built.glob("davar_*.dir/**/*.obj"))
        for line in targets.tool(target, "nm", "-A", "--defined-only", *objects).splitlines():
            *_, kind, name = line.split()
            if kind in "tTrRwW":  # CMakeFiles/TARGET/FILE.c.obj
                file = Path(line.split(":", 1)[0]).relative_to(built).parts[1:]
                places[name] = Path(folder, *file).as_posix()[:-4]
    return places


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


def expanded(names: str) -> list[str]:
    """The registers of a list such as "r4, r6-r8, lr"."""
    found = []
    for name in re.split(r", *", names):
        first, _, last = name.strip().partition("-")
        numbers = range(int(first[1:]), int(last[1:]) + 1) if last else ()
        found += [f"{first[0]}{number}" for number in numbers] or [first]
    return found


class Registers:
    """Which registers hold a word loaded from a known offset of an object: how a function of a
    table is called.
    """

    def __init__(self) -> None:
        self.offset: dict[str, int | None] = {}
        self.at: dict[str, dict[str, int | None]] = {}  # where a branch goes -> what it takes along
        self.ended = False  # by a jump: the next instruction is reached by a branch

    def arrive(self, address: str) -> None:
        if self.ended and address in self.at:
            self.offset = dict(self.at[address])
        self.ended = False

    def follow(self, operation: str, operands: str) -> None:
        """One instruction, in the order of the code."""
        self.ended = bool(
            re.match(r"(b(\.[nw])?|bx|j|c\.jr?|ret)$", operation) or "pc}" in operands
        )
        if branch := re.search(r"([0-9a-f]+) <[^>]+\+0x[0-9a-f]+>$", operands):
            self.at.setdefault(branch.group(1), dict(self.offset))
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
            listed = operands.partition("{")[2].rstrip("}")  # ldrd has two instead
            for name in expanded(listed) if listed else (first, *others[:1]):
                self.offset[name] = None
        elif not WRITES_NOTHING.match(operation):
            self.offset[first] = None

    def goal(self, operands: str) -> str | int:
        """What a call or jump to the register goes to: the function at an offset of a table, or an
        unknown one.
        """
        offset = self.offset.get(operands.strip())
        return "a pointer" if offset is None else offset


class Function(NamedTuple):
    operations: set[str]
    goals: set[str | int]  # what it goes to: names, and offsets of pointers in a table
    frame: int  # bytes of stack at most: every decrement of the pointer, also of other branches.
    # Static functions of one name are taken together: the larger frame, all goals.


PUSHED = re.compile(r"(?:v?push|stmdb(?:\.w)?|vstmdb)\s+(?:sp!, ?)?{(.+)}")
TAKEN = re.compile(
    r"(?:sub\w*(?:\.w)?\s+sp, (?:sp, )?#|str\S*\s+.*\[sp, #-"
    r"|(?:c\.)?addi?(?:16sp)?\s+sp,(?:sp,)?-)(\d+)"
)
BY_REGISTER = re.compile(r"add(?:\.w)?\s+sp, (r\d+)")  # a large frame of a Cortex-M0
# A frame that is not known when the code is read.
OPEN_FRAME = re.compile(r"(?:c\.)?sub\S*\s+sp, ?(?:sp, ?)?(?!sp)[a-z]|(?:c\.)?add\s+sp,sp,[a-z]")
UNBOUNDED = 1 << 30
LITERAL = re.compile(r"ldr\S*\s+(r\d+), \[pc.*@ \(([0-9a-f]+) ")


def registers_of(names: str) -> int:
    """Bytes of a list of registers."""
    return len(expanded(names)) * (8 if names.strip().startswith("d") else 4)


def taken(line: str, literals: Mapping[str, int]) -> int:
    """Bytes by which an instruction lowers the stack pointer."""
    if OPEN_FRAME.match(line):
        return UNBOUNDED
    pushed, constant, by = PUSHED.match(line), TAKEN.match(line), BY_REGISTER.match(line)
    if pushed:
        return registers_of(pushed.group(1))
    if by and literals.get(by.group(1), 0) >> 31:
        return (1 << 32) - literals[by.group(1)]
    return int(constant.group(1)) if constant else 0


@functools.cache
def disassembly(target: str, image: Path) -> dict[str, Function]:
    code: dict[str, Function] = {}
    name, popped, frame = None, None, 0
    registers = Registers()
    text = targets.tool(target, "objdump", "-d", "--no-show-raw-insn", image)
    words = dict(re.findall(r"^\s*([0-9a-f]+):\t\.word\s+0x([0-9a-f]+)", text, re.MULTILINE))
    # the name beside an address may be that of a constant of the linker script
    heads = dict(re.findall(r"^0*([0-9a-f]+) <(.+)>:$", text, re.MULTILINE))
    literals: dict[str, int] = {}  # register -> the last constant that it was loaded with
    for line in text.splitlines():
        head = re.match(r"^[0-9a-f]+ <(.+)>:$", line)
        if head:
            name = head.group(1)
            code.setdefault(name, Function(set(), set(), 0))
            registers, frame = Registers(), 0
            continue
        body = re.match(r"^\s*([0-9a-f]+):\t(\S+)\s*(.*)$", line)
        if body and name:
            address, operation, operands = body.groups()
            registers.arrive(address)
            instruction = f"{operation} {operands}"
            if loaded := LITERAL.match(instruction):
                literals[loaded.group(1)] = int(words.get(loaded.group(2), "0"), 16)
            frame += taken(instruction, literals)
            code[name] = code[name]._replace(frame=max(frame, code[name].frame))
            if not operation.startswith(("j", "c.j")):
                operands = operands.split(" # ")[
                    0
                ]  # a constant of RISC-V that happens to be an address
            code[name].operations.add(
                operation.split(".")[0] if not operation.startswith("v") else operation
            )
            alone = re.fullmatch(r"{(r\d+)}", operands.strip())
            popped = (
                alone.group(1) if operation == "pop" and alone else popped
            )  # a return of the Cortex-M0
            returns = operands.strip() in ("lr", "ra", popped)
            to_register = not re.search(r"<.+>", operands) and not returns
            if operation in ("bx", "blx", "jr", "c.jr", "jalr", "c.jalr") and to_register:
                code[name].goals.add(registers.goal(operands))
            for address in re.findall(r"([0-9a-f]+) <[A-Za-z_][\w.$]*>", operands):
                code[name].goals.update([heads[address]] if address in heads else [])
            registers.follow(operation, operands)
    return code


def tables(target: str, image: Path) -> dict[str, dict[int, str]]:
    """Name -> {offset: function} of each table: window laws, engines and number types."""
    found, functions, places = (
        dict[str, dict[int, str]](),
        dict[int, str](),
        dict[str, tuple[int, int]](),
    )
    thumb = 1 if targets.MACHINES[target]["core"] == "cortex_m" else 0  # bit 0 of a pointer
    for line in targets.tool(target, "nm", "-S", "--defined-only", image).splitlines():
        fields = line.split()
        if len(fields) == 4 and re.match(r"davar_(law|engine|number)_\w+$", fields[3]):
            places[fields[3]] = (int(fields[0], 16), int(fields[1], 16))
        elif len(fields) == 4 and fields[2] in "tT":
            functions[int(fields[0], 16) | thumb] = fields[3]
    pointer = len(fields[0]) // 2
    for name, (start, size) in places.items():
        dump = targets.tool(
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
    header = (targets.ROOT / "lib/include/davar/types.h").read_text(encoding="utf-8")
    return re.findall(r"^extern const davar_law_t (\w+);", header, re.MULTILINE)


@functools.cache
def called_tables(unit: str) -> frozenset[str]:
    """The kinds of tables, such as "law", that a source file and its .inc files call through.
    The calls of headers do not count.
    """
    text = (targets.ROOT / unit).read_text(encoding="utf-8")
    kinds = set(re.findall(r"(law|engine|number)->\w+\(", text))
    for part in re.findall(r'#include "(\S+\.inc)"', text):
        if (targets.ROOT / "lib/src" / part).exists():  # not a list of lib/include
            kinds |= called_tables(f"lib/src/{part}")
    return frozenset(kinds)


def reached(
    goals: Iterable[str | int], named: Mapping[str, Mapping[int, str]], unit: str
) -> Iterator[str]:
    """The functions of these goals. The pointer at an offset can be that of any table that the
    source file calls through. An image without tables of some kind never calls through one.
    """
    kinds = called_tables(unit)
    absent = kinds - {name.split("_")[1] for name in named}
    for goal in goals:
        if isinstance(goal, str):
            yield goal
        else:
            at = [
                functions[goal]
                for name, functions in named.items()
                if goal in functions and name.split("_")[1] in kinds
            ]
            yield from at or ([] if absent else [f"a pointer at offset {goal}"])


def unit_of(name: str, home: Mapping[str, str]) -> str | None:
    """The source file of a function of the library, also of the compiler's copies of it."""
    return home.get(name) or home.get(re.sub(r"\.(isra|part|constprop|cold)\.\d+|\.cold", "", name))


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
        unit = unit_of(name, home)
        if unit is None:
            found.append(f"{target}: {name} is not a function of davar")
            continue
        found += [
            f"{target}: {operation} in {name}"
            for operation in code[name].operations
            if FORBIDDEN.match(operation)
        ]
        wanted += set(reached(code[name].goals, named, unit)) - {name}
    return found


def stack(target: str, image: Path, roots: Iterable[str], without: str | None = None) -> int:
    """Bytes of stack that a call of any of these functions takes at most: the deepest chain of
    calls, with the compiler's own functions and every window law whose name lacks `without`.
    Raises TargetError for what has no bound: recursion, a call to an unknown place, a frame that is
    computed.
    """
    code, home = disassembly(target, image), sources(target, Path(image).parent)
    named = tables(target, image)
    kept, left_out = set[str](), set[str]()
    for name, found in named.items():
        (left_out if without and without in name else kept).update(found.values())
    left_out -= kept
    known: dict[str, int] = {}

    def depth(name: str, way: tuple[str, ...]) -> int:
        if name in way or name not in code or code[name].frame >= UNBOUNDED:
            chain = " > ".join((*way, name))
            raise targets.TargetError(f"{target}: no bound of the stack: {chain}")
        if name not in known:
            unit, goals = unit_of(name, home), code[name].goals
            names = {
                str(goal)
                # the compiler's arithmetic jumps by tables, within a function
                for goal in (reached(goals, named, unit) if unit else goals & code.keys())
                if goal != name and goal not in left_out
            }
            below = [depth(goal, (*way, name)) for goal in names]
            known[name] = code[name].frame + max(below, default=0)
        return known[name]

    return max(depth(root, ()) for root in roots)
