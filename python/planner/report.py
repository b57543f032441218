"""A plan as a person reads it, and as JSON."""

import math
import re
from dataclasses import asdict
from typing import Any

from . import text
from .choice import NO_ROOM, Impossible, Plan, for_all_terms, for_motion, number
from .design import WINDOW_MOST, WINDOWS, noise_counts
from .simulate import MOVING, Simulated
from .simulate import WINDOWS as SIMULATED_WINDOWS

CLOCK_OF_EVERY_CHIP_MHZ = 16
ALIASED_LEAST = 0.02  # of ARW, that is worth a remark
FIT = {
    "arw": "ARW",
    "curve": "ARW, and the Allan curve with intervals",
    "terms": "ARW; on request all five terms from the whole curve",
}
MOTION = {
    None: "",
    NO_ROOM: "",
    "none": "",
    "slow": "; in slow motion ARW from the flat part",
    "flight": "; in flight the floor",
}


def duration(value: float) -> str:
    """In the unit that a person would use."""
    for unit, size in (("years", 31557600.0), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if value >= 2 * size:
            return f"{number(value / size)} {unit}"
    return f"{number(value)} s"


def frequency(mhz: float) -> str:
    return f"{number(1000 * mhz)} kHz" if mhz < 1 else f"{number(mhz)} MHz"


def instructions(value: float) -> str:
    if value >= 1e6:
        return f"{number(value / 1e6)} million"
    return f"{value:.0f}"


def subject(plan: Plan) -> str:
    """What the plan is for, in a line."""
    wishes = plan.design.wishes
    axes = "1 axis" if wishes.axes == 1 else f"{wishes.axes} axes"
    sensor = f" ({wishes.sensor})" if wishes.sensor else ""
    return f"{axes} of {wishes.type} at {wishes.rate_hz:.12g} Hz{sensor} on a {wishes.core}"


def gives(plan: Plan) -> list[str]:
    """What the setup promises."""
    wishes, promise, design = plan.design.wishes, plan.promise, plan.design
    rate = wishes.rate_hz
    lines = [
        f"ARW to +-{number(promise.arw_percent)} % (95 %) after {duration(design.window / rate)}, "
        f"then a result every {duration(design.stride / rate)}"
    ]
    if promise.false_alarms_per_hour is None:
        lines.append(f"results follow a change of the noise within {duration(promise.respond_s)}")
    else:
        lines.append(
            f"an alarm within {duration(promise.respond_s)} after the noise has doubled (9 in 10), "
            f"and one false alarm in {duration(3600 / promise.false_alarms_per_hour)}"
        )
    if promise.curve_first_s and promise.curve_settled_s:
        lines.append(
            f"the Allan curve to {duration(promise.longest_tau_s)}: first values there after "
            f"{duration(promise.curve_first_s)}, to +-{number(promise.curve_percent or 0)} % after "
            f"{duration(promise.curve_settled_s)}"
        )
    if promise.bias_instability_deg_per_h:
        what = "bias instability and random walk" if design.fit == "terms" else "bias instability"
        lines.append(
            f"{what} from that curve, if above {number(promise.bias_instability_deg_per_h)} deg/h"
        )
    if design.floor:
        lines.append(
            f"in flight, the floor every {duration(design.floor.every_s)} from a window of "
            f"{duration(design.floor.window_s)}: the noise of the sensor is below its upper limit"
        )
    return lines


def _of(size: int, limit: int | None) -> str:
    return f"{size} bytes" if limit is None else f"{size} of {limit} bytes"


def _clock(plan: Plan) -> str:
    """How fast the core must be, at one instruction a cycle."""
    clock = plan.design.wishes.clock_mhz
    if clock is None:
        return (
            f"every push ends before the next sample from {frequency(plan.worst_mhz)} on (one "
            "instruction a cycle)"
        )
    return (
        f"pushes take {number(100 * plan.mean_mhz / clock)} % of {frequency(clock)}, the most "
        f"expensive one {number(100 * plan.worst_mhz / clock)} % of a sample period (one "
        "instruction a cycle)"
    )


def takes(plan: Plan) -> list[str]:
    """What the setup costs."""
    wishes, cost = plan.design.wishes, plan.cost
    axes = "" if wishes.axes == 1 else f" of {wishes.axes} axes"
    lines = [
        f"flash {_of(cost.flash_bytes, wishes.flash_bytes)}, "
        f"RAM {_of(cost.ram_bytes, wishes.ram_bytes)}",
        f"stack {cost.stack_bytes} bytes: start {cost.start_stack_bytes}, "
        f"push {cost.push_stack_bytes}, take {cost.take_stack_bytes}",
        f"push of a sample{axes}: {instructions(cost.mean_push_instructions)} instructions, "
        f"at most about {instructions(cost.worst_push_instructions)}; "
        f"{instructions(1e6 * plan.mean_mhz)} a second",
        _clock(plan),
        f"take of an axis: {instructions(cost.mean_take_instructions)} instructions, "
        f"at most about {instructions(cost.worst_take_instructions)}",
    ]
    if cost.curve_instructions:
        lines.append(
            f"curve of an axis: about {instructions(cost.curve_instructions)} instructions"
        )
    return lines


def how(plan: Plan) -> list[str]:
    """Which means the planner chose."""
    design = plan.design
    law = "a fixed window" if design.law == "fixed" else "law glr, windows up to"
    named = design.law == "fixed" and design.engine != "slide"
    engine = f", engine {design.engine}" if named else ""
    summed = design.floor.summed if design.floor else 1
    sums = f" of sums of {summed} samples" if summed > 1 else ""
    slow = f" and {design.cascade_taus} of a cascade" if design.cascade_taus else ""
    return [
        f"{law} of {design.window} samples, stride {design.stride}{engine}"
        if design.law == "fixed"
        else f"{law} {design.window} samples, stride {design.stride}",
        f"{len(design.taus)} cluster sizes{slow}; "
        f"fit: {FIT[design.fit]}{MOTION[design.wishes.motion]}{sums}",
    ]


def _of_wishes(plan: Plan) -> list[str]:
    """Wishes that have another effect than the user may expect."""
    wishes, design, found = plan.design.wishes, plan.design, []
    if wishes.respond_s and design.law == "fixed" and 2 * design.respond_s < wishes.respond_s:
        most = WINDOW_MOST[wishes.type]
        longest = design.window > most - WINDOWS[0]
        found.append(
            f"results follow a change sooner than --respond {number(wishes.respond_s)}: "
            + (
                f"the longest window of {wishes.type} has {most} samples"
                if longest
                else "a longer window exceeds --ram or --flash"
            )
        )
    if wishes.longest_tau_s and not design.cascade_taus:
        found.append(
            f"--longest-tau {number(wishes.longest_tau_s)} adds nothing: the results of "
            f"davar_setup_take reach {duration(design.taus_s[-1])}, so there is no "
            "davar_setup_curve"
        )
    motion = for_motion(plan)
    if motion:
        options = " ".join(f"{one.option} {one.value}" for one in motion)
        found.append(
            f"in motion, ARW is an upper limit: a value needs {options} (or state --motion none)"
        )
    terms = for_all_terms(plan)
    if terms:
        options = " ".join(f"{one.option} {one.value}" for one in terms)
        found.append(
            "bias instability and random walk are not fitted: for all five terms, "
            f"davar_setup_curve needs {options}"
        )
    return found


def _of_clock(plan: Plan) -> list[str]:
    """Whether the core keeps up with the samples."""
    clock = plan.design.wishes.clock_mhz
    if clock is None and plan.worst_mhz > CLOCK_OF_EVERY_CHIP_MHZ:
        return [
            f"not every chip has {frequency(plan.worst_mhz)}: state the clock of yours with "
            "--clock MHZ, and the planner compares them"
        ]
    if clock is not None and plan.worst_mhz > clock:
        periods = (plan.worst_mhz - plan.mean_mhz) / (clock - plan.mean_mhz)
        return [
            f"the most expensive push takes {number(plan.worst_mhz / clock)} sample periods: "
            f"collect at least {math.floor(periods) + 1} samples, by DMA or in the gyro, and push "
            "them as a block"
        ]
    return []


def aliased(bandwidth: str | None, rate_hz: float) -> float:
    """By how much an analogue low-pass, sampled, raises ARW over that of the gyro: a share."""
    words = bandwidth or ""
    number_of = r"[0-9.]+(?:e[+-]?[0-9]+)?"
    found = re.match(rf"({number_of})(?::([12])(?::{number_of})?)?(?:\+|$)", words, re.IGNORECASE)
    if not found:
        return 0.0
    division = math.prod(int(n) for n in re.findall(r"(?:cic|sum)[0-9]*:([0-9]+)", words))
    share, order = float(found[1]) / (rate_hz * division), int(found[2] or 2)
    images = sum(2 / (1 + (k / share) ** (2 * order)) for k in range(1, 1000))
    return math.sqrt(1 + images) - 1


def remarks(plan: Plan) -> list[str]:
    """What the user should check."""
    wishes, found = plan.design.wishes, [*_of_wishes(plan), *_of_clock(plan)]
    if wishes.bandwidth is None:
        found.append(
            "the gyro's low-pass is not declared: results that a filter could falsify are "
            "withheld. State it with --bandwidth, or --bandwidth none"
        )
    elif wishes.bandwidth == wishes.sensor_bandwidth:
        found.append(
            f"set the gyro to the low-pass of this plan, {wishes.bandwidth} (Hz:order), "
            "or state yours with --bandwidth"
        )
    more = aliased(wishes.bandwidth, wishes.rate_hz)
    if more > ALIASED_LEAST:
        found.append(
            "noise above half the rate is aliased: the ARW of the samples is "
            f"{number(100 * more)} % above that of the gyro"
        )
    counts = noise_counts(wishes)
    if 0 < counts < 1:
        found.append(
            f"the typical noise is {number(counts)} counts before the filter, so ARW can be "
            "absent: a smaller range of the gyro is better"
        )
    return found


def lines(plan: Plan) -> list[str]:
    """The whole report."""
    parts = (("gives", gives), ("costs", takes), ("how", how), ("check", remarks))
    found = [subject(plan)]
    for name, part in parts:
        for i, line in enumerate(part(plan)):
            found.append(f"  {name if i == 0 else '':6} {line}")
    return found


def _build(plan: Plan, self_contained: bool) -> list[str]:
    """How to compile it."""
    if self_contained:
        return [
            "Compile davar.c and davar_setup.c of this folder with your program. They need C11 and",
            "libm, and no options: davar.h has those of this setup.",
        ]
    options = " ".join(f"-D{define}" for define in text.defines(plan.design))
    return [
        "Compile this file, davar and everything that includes its headers with",
        "",
        f"    {options}",
        "",
        "which davar_setup.args has for gcc and clang (@davar_setup.args), and davar_setup.cmake",
        "for CMake (include it before add_subdirectory of davar).",
    ]


def printable(text: str) -> str:
    """In one line: other characters, and bytes that are no UTF-8, as Python writes them."""
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in text)


def in_comment(command: str) -> str:
    """A command of shlex.join in a line of a C comment, which it neither ends nor opens. In the
    quotes around a *, the shell takes '' for nothing.
    """
    return printable(command).replace("*/", "*''/").replace("/*", "/''*")


def comment(plan: Plan, command: str, self_contained: bool = False) -> list[str]:
    """The comment at the top of davar_setup.h."""
    return [
        "",
        f"    {in_comment(command)}",
        "",
        *lines(plan),
        "",
        "Figures are for -Os and emulated cores (docs/PLANNER.md).",
        *_build(plan, self_contained),
    ]


def as_json(plan: Plan) -> dict[str, Any]:
    """What --json prints. Lengths in bytes, times in seconds."""
    design, cost, promise = plan.design, plan.cost, plan.promise
    rate = design.wishes.rate_hz
    return {
        "flash_bytes": cost.flash_bytes,
        "ram_bytes": cost.ram_bytes,
        "stack_bytes": cost.stack_bytes,
        "worst_push_instructions": cost.worst_push_instructions,
        "mean_instructions": cost.mean_push_instructions,
        "mean_mhz": round(plan.mean_mhz, 6),
        "worst_mhz": round(plan.worst_mhz, 6),
        "defines": text.defines(design),
        "arw_percent": round(promise.arw_percent, 2),
        "respond_s": promise.respond_s,
        "taus_s": design.taus_s,
        "push_stack_bytes": cost.push_stack_bytes,
        "take_stack_bytes": cost.take_stack_bytes,
        "start_stack_bytes": cost.start_stack_bytes,
        "mean_take_instructions": cost.mean_take_instructions,
        "worst_take_instructions": cost.worst_take_instructions,
        "curve_instructions": cost.curve_instructions,
        "false_alarms_per_hour": promise.false_alarms_per_hour,
        "window_s": design.window / rate,
        "stride_s": design.stride / rate,
        "curve_first_s": promise.curve_first_s,
        "curve_settled_s": promise.curve_settled_s,
        "curve_percent": promise.curve_percent,
        "bias_instability_deg_per_h": promise.bias_instability_deg_per_h,
        "floor_window_s": design.floor.window_s if design.floor else None,
        "floor_stride_s": design.floor.every_s if design.floor else None,
        "law": design.law,
        "engine": design.engine,
        "fit": design.fit,
        "motion": "none" if design.wishes.motion == NO_ROOM else design.wishes.motion,
        "remarks": remarks(plan),
    }


def percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def came_out(
    present: float, holds: float | None, arw_percent: float | None, what: str = "ARW"
) -> str:
    """How often there was a value, how wide its interval was, and how often that contained ARW."""
    wide = f", +-{number(arw_percent)} %" if arw_percent is not None else ""
    kept = f"; {percent(holds)} of the intervals contain it" if holds is not None else ""
    return f"{what} in {percent(present)} of results{wide}{kept}"


def simulated(found: Simulated | None, law: str) -> list[str]:
    """What came out, for each promise."""
    if found is None:
        return []
    seen = "change of the noise shows" if law == "glr" else "result is of the new noise alone"
    lines = [
        f"{SIMULATED_WINDOWS} windows of {number(found.noise)} deg/sqrt(h) at rest: "
        + came_out(found.present, found.holds, found.arw_percent),
        f"nine in ten times, a {seen} after {duration(found.respond_s)}",
    ]
    if found.moving_present is not None:
        lines.append(
            f"in motion of {MOVING}: "
            + came_out(found.moving_present, found.moving_holds, found.moving_arw_percent)
        )
    if found.floor_present is not None:
        lines.append(came_out(found.floor_present, found.floor_holds, None, "the floor"))
    return [f"  {'ran' if i == 0 else '':6} {line}" for i, line in enumerate(lines)]


def simulated_as_json(found: Simulated | None) -> dict[str, Any]:
    """Shares from 0 to 1."""
    return {} if found is None else {"simulated": asdict(found)}


def impossible(why: Impossible) -> list[str]:
    """The reasons, and what to relax."""
    found = [f"impossible: {why.reasons[0]}", *(f"  and {reason}" for reason in why.reasons[1:])]
    found += [f"  {hint}" for hint in why.hints]
    if why.relaxed:
        found.append(f"possible with {'all' if why.together else 'one'} of:")
        found += [f"  {relaxed.option} {relaxed.value}" for relaxed in why.relaxed]
    return found


def impossible_as_json(why: Impossible) -> dict[str, Any]:
    return {
        "impossible": str(why),
        "hints": why.hints,
        "relax": [{"option": r.option, "value": r.value} for r in why.relaxed],
        "together": why.together,
    }
