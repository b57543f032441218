"""What a design costs on a core, from the measured table costs.json."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import programs
from .design import BLOCK, NUMBER, Design

Features = Callable[[Design], list[float]]

COUNTER = 4  # bytes
TABLE_PATH = Path(__file__).parent / "costs.json"


@dataclass(frozen=True)
class Cost:
    """Bytes, and instructions: of a push of one sample of all axes, of a take of one axis."""

    flash_bytes: int
    ram_bytes: int
    push_stack_bytes: int
    take_stack_bytes: int
    start_stack_bytes: int
    mean_push_instructions: int
    worst_push_instructions: int
    mean_take_instructions: int
    worst_take_instructions: int
    curve_instructions: int | None

    @property
    def stack_bytes(self) -> int:
        """The deepest of the three functions."""
        return max(self.push_stack_bytes, self.take_stack_bytes, self.start_stack_bytes)


def table() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(TABLE_PATH.read_text(encoding="utf-8"))
    return found


def cores() -> list[str]:
    return list(table())


def round8(size: int) -> int:
    return (size + 7) // 8 * 8


def plan_bytes(design: Design, sizes: dict[str, Any]) -> int:
    if design.engine == "small":
        return int(sizes["small_plan"][design.taus_max - 1])
    return round8(int(sizes["plan"][design.taus_max - 1]))


def ram_bytes(design: Design, sizes: dict[str, Any], other: int) -> int:
    """Exact: the memory is that of the library's macros, the sizes of types are those of the core's
    compiler. other: what the C library adds."""
    axes, pointer, (base, of_tau) = design.wishes.axes, sizes["pointer"], sizes["result"]
    if design.engine == "small":
        state = sizes["small"][0] + sizes["small"][1] * design.taus_max
        result = round8(base + of_tau * design.taus_max)
        return int(round8(2 * (design.window + 1)) + state + result + other)
    instance = programs.memory(pointer, *design.memory) + design.gap_bytes
    total: int = axes * (round8(instance) + sizes["instance"])
    total += round8(base + of_tau * design.taus_max) + plan_bytes(design, sizes) + other
    if design.floor:
        sums = sizes["average"] + 1 if design.floor.summed > 1 else 0  # 1: a flag
        total += axes * round8(sums + sizes["floor"] + 2 * sizes["floor_result"] + 2 * COUNTER)
    if design.cascade_taus:
        name = f"CASCADE_{NUMBER[design.wishes.type]}"
        total += axes * (programs.memory(pointer, name, (design.cascade_taus,)) + sizes["cascade"])
    return total


# --- the model: each figure is a sum of features times the coefficients of its kind and core ---


def _several(design: Design) -> float:
    """A push of several axes copies the samples of each."""
    return float(design.wishes.axes > 1)


def _doublings(design: Design) -> float:
    """Of the window of law glr, which tries a split at each."""
    return math.log2(design.window / BLOCK)


def _push(design: Design) -> list[float]:
    axes, count, stride = design.wishes.axes, len(design.taus), design.stride
    if design.law == "glr":
        return [0.0, axes, axes * count, axes / stride, axes / stride * _doublings(design)]
    return [_several(design), axes, axes * count, axes / stride, axes * count / stride]


def _worst(design: Design) -> list[float]:
    """Of law glr, a bound: the worst push either tests all splits or passes samples on."""
    axes, count, span = design.wishes.axes, len(design.taus), 2 * design.taus[-1]
    if design.law == "glr":
        return [axes, axes * count, axes * _doublings(design)]
    return [_several(design), axes, axes * count, axes * count * float(span > design.stride)]


def _each(design: Design) -> list[float]:
    return [1.0, float(len(design.taus))]


def _start(design: Design) -> list[float]:
    return [1.0, _several(design), float(design.wishes.axes)]


def _linked(design: Design) -> list[float]:
    return [1.0, float(len(design.taus)), _several(design)]


FEATURES: dict[str, Features] = {
    "flash_bytes": _linked,
    "push_stack_bytes": _linked,
    "take_stack_bytes": _each,
    "start_stack_bytes": _start,
    "mean_push_instructions": _push,
    "worst_push_instructions": _worst,
    "mean_take_instructions": _each,
    "worst_take_instructions": _each,
}


def _slow_linked(design: Design) -> list[float]:
    return [1.0, float(design.cascade_taus)]


def _slow_push(design: Design) -> list[float]:
    axes = design.wishes.axes
    return [axes, 64 * axes / design.cascade_shortest]


SLOW_FEATURES: dict[str, Features] = {
    "flash_bytes": _slow_linked,
    "mean_push_instructions": _slow_push,
    "worst_push_instructions": lambda design: [
        design.wishes.axes * float(design.engine == engine) for engine in ("slide", "grid")
    ],
    "push_stack_bytes": lambda design: [1.0, _several(design)],
    "take_stack_bytes": _slow_linked,
    "start_stack_bytes": lambda design: [1.0, _several(design)],
    "curve_instructions": _slow_linked,
}
# What the fit of the flat part adds to a setup for slow motion; the stack is absolute.
FLAT_FEATURES: dict[str, Features] = {
    "flash_bytes": lambda design: [1.0, float(design.fit == "terms")],
    "take_stack_bytes": lambda design: [1.0, float(design.taus_max)],
    "worst_take_instructions": lambda design: [1.0, float(len(design.taus)) ** 2],
}


def _sums(design: Design) -> float:
    return float(bool(design.floor and design.floor.summed > 1))


def _floor_push(design: Design) -> list[float]:
    """Of the samples of a floor, its results, and the sums."""
    axes, floor = design.wishes.axes, design.floor
    assert floor
    each = axes / floor.summed
    return [each, each / floor.block, axes * _sums(design)]


# What the floors add to a setup for flight; the stack is absolute.
FLOOR_FEATURES: dict[str, Features] = {
    "flash_bytes": lambda design: [1.0, _sums(design), float(design.fit == "terms")],
    "mean_push_instructions": _floor_push,
    "worst_push_instructions": lambda design: [  # of one axis: they take turns
        1.0,
        float(design.wishes.axes),
        design.wishes.axes * _sums(design),
    ],
    "push_stack_bytes": lambda design: [
        1.0,
        _several(design),
        float(design.cascade_taus > 0),
    ],
}
ABSOLUTE = ("take_stack_bytes", "curve_instructions")  # of cascade and flat part


def known(figure: str, design: Design, sizes: dict[str, Any]) -> int:
    """The part of a figure that needs no measurement."""
    return plan_bytes(design, sizes) if figure == "flash_bytes" else 0


def _sum(features: list[float], coefficients: list[float]) -> float:
    return sum(f * c for f, c in zip(features, coefficients))


def of_row(figure: str, row: dict[str, Any], design: Design, sizes: dict[str, Any]) -> float:
    """A figure of a design without what its cascade adds."""
    return _sum(FEATURES[figure](design), row[figure]) + known(figure, design, sizes)


def cost(design: Design, of_core: dict[str, Any]) -> Cost:
    """What the design costs. of_core: the table of its core."""
    wishes, sizes = design.wishes, of_core["sizes"]
    row = of_core["window"][design.kind]
    found = {figure: of_row(figure, row, design, sizes) for figure in FEATURES}
    other, curve = row["other_ram_bytes"], None
    if design.cascade_taus:
        slow = of_core["cascade"][f"{wishes.type} {design.fit}"]
        other = slow["other_ram_bytes"]
        for figure, features in SLOW_FEATURES.items():
            added = _sum(features(design), slow[figure])
            if figure == "curve_instructions":
                curve = round(added)
            elif figure in ABSOLUTE:
                found[figure] = max(found[figure], added)
            else:
                found[figure] += added
    if wishes.motion == "slow":
        for figure, features in FLAT_FEATURES.items():
            added = _sum(features(design), of_core["flat"][figure])
            found[figure] = (
                max(found[figure], added) if figure in ABSOLUTE else found[figure] + added
            )
    if design.floor:
        for figure, features in FLOOR_FEATURES.items():
            added = _sum(features(design), of_core["floor"][figure])
            absolute = figure == "push_stack_bytes"
            found[figure] = max(found[figure], added) if absolute else found[figure] + added
    rounded = {figure: round(value) for figure, value in found.items()}
    return Cost(ram_bytes=ram_bytes(design, sizes, other), curve_instructions=curve, **rounded)
