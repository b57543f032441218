"""What a design costs on a core, from the measured table costs.json."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .design import BLOCK, GAPS, Design

TABLE_PATH = Path(__file__).parent / "costs.json"


@dataclass(frozen=True)
class Cost:
    """Bytes, and instructions: of a push of one sample of all axes, of a take of one axis."""

    flash_bytes: int
    ram_bytes: int
    push_stack_bytes: int
    take_stack_bytes: int
    mean_push_instructions: int
    worst_push_instructions: int
    mean_take_instructions: int
    worst_take_instructions: int
    curve_instructions: int | None

    @property
    def stack_bytes(self) -> int:
        return max(self.push_stack_bytes, self.take_stack_bytes)


def table() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(TABLE_PATH.read_text(encoding="utf-8"))
    return found


def cores() -> list[str]:
    return list(table())


def round8(size: int) -> int:
    return (size + 7) // 8 * 8


def memory_bytes(design: Design, sizes: dict[str, Any]) -> int:
    """Of one instance: the macros of davar/instance.h."""
    narrow = design.wishes.type == "int16"
    sample, pointer = (2 if narrow else 4), sizes["pointer"]
    tau, record, powers = (16, 8, 32) if narrow else (32, 16, 64)
    count, largest = len(design.taus), design.taus[-1]
    stages = (96 if narrow else 168) + 6 * pointer
    common = stages + tau * count + round8(4 * GAPS)
    if design.engine == "slide":
        of_result = 8 + 2 * pointer + record * count if design.stride > 1 else 0
        return common + round8(sample * (design.window + 2 * largest + 1)) + of_result
    grid = common + round8(sample * (4 * largest + 127)) + 304 + 41 * pointer + 2 * round8(4 * count)
    if design.law == "glr":
        blocks = (design.window + design.stride) // BLOCK + 4
        law = (1256 if narrow else 1280) + 2 * pointer + round8(sample * 5 * BLOCK)
        return grid + blocks * record * count + law
    slots = design.window // design.stride + 2
    return grid + slots * (record * count + powers) + 2 * (record * count + powers) + 2 * powers


def plan_bytes(design: Design, sizes: dict[str, Any]) -> int:
    most = design.taus_max
    base, of_tau, of_pair = sizes["plan"]
    return round8(base + of_tau * most + of_pair * (most * (most + 1) // 2))


def ram_bytes(design: Design, sizes: dict[str, Any], other: int) -> int:
    """Exact. other: what the C library adds."""
    axes, narrow = design.wishes.axes, design.wishes.type == "int16"
    base, of_tau = sizes["result"]
    total = axes * (round8(memory_bytes(design, sizes)) + sizes["instance"])
    total += round8(base + of_tau * design.taus_max) + plan_bytes(design, sizes) + other
    if design.cascade_taus:
        stage = 192 if narrow else 224
        total += axes * ((design.cascade_taus + 1) // 2 * stage + sizes["cascade"])
    return total
