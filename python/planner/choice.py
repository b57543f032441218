"""The choice: the first candidate that meets every wish, or which wish to relax."""

import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from . import costs, design, floors, promises
from .costs import Cost
from .design import Design
from .promises import Promise
from .wishes import Wishes, with_option

PERCENT_STILL_USEFUL = 40.0
FITS = ("arw", "terms", "curve")  # best first
NO_ROOM = "no room"  # for motion, which is not stated: as none
RAM_OVER_FLASH = 2  # a byte of RAM is scarcer
MORE = (1.0, 1.03, 1.1, 1.2)  # than a plan needs, so that the planner finds one
LENGTHEN = (1.25, 1.5, 2, 3, 4, 6, 10, 20, 50, 100)


@dataclass(frozen=True)
class Plan:
    """A design with what it gives and what it costs."""

    design: Design
    promise: Promise
    cost: Cost

    @property
    def mean_mhz(self) -> float:
        """Million instructions per second that pushes take."""
        return self.design.wishes.rate_hz * self.cost.mean_push_instructions / 1e6

    @property
    def worst_mhz(self) -> float:
        """The same if every push were the most expensive one."""
        return self.design.wishes.rate_hz * self.cost.worst_push_instructions / 1e6


@dataclass(frozen=True)
class Relaxed:
    """A wish that makes the others possible: its option and value."""

    option: str
    value: str


class Impossible(Exception):
    """No design meets the wishes. relaxed: each of them suffices; together: all are needed."""

    def __init__(
        self,
        reasons: Iterable[str],
        relaxed: Iterable[Relaxed] = (),
        *,
        hints: Iterable[str] = (),
        together: bool = False,
    ) -> None:
        self.reasons, self.hints, self.relaxed = list(reasons), list(hints), list(relaxed)
        self.together = together
        super().__init__("; ".join(self.reasons))


def kilobytes(size: int) -> str:
    """Rounded up to 0.1 k."""
    return f"{math.ceil(size / 102.4) / 10:g}k"


def number(value: float, digits: int = 3) -> str:
    """With that many digits, or all before the point."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    shown = f"{value:.{places}f}"
    return shown.rstrip("0").rstrip(".") if "." in shown else shown


def apart(one: float, other: float) -> tuple[str, str]:
    """Two numbers with enough digits to differ."""
    for digits in range(3, 16):
        texts = number(one, digits), number(other, digits)
        if texts[0] != texts[1]:
            break
    return texts


def sizes_apart(one: int, other: int) -> tuple[str, str]:
    """Two sizes in k, or in bytes if they would not differ."""
    texts = kilobytes(one), kilobytes(other)
    return texts if texts[0] != texts[1] else (f"{one} bytes", f"{other} bytes")


# --- candidates ---


def _reaching(
    make: Callable[[Wishes, int], list[Design]], wishes: Wishes, percent: float
) -> list[Design]:
    """The designs of the shortest window that gives the angle random walk to so many percent and
    shows a change, or those of the longest.
    """
    short = replace(wishes, longest_tau_s=None)
    window, shortest, longest = 400.0, 64.0, design.WINDOW_MOST[wishes.type] * 0.9
    reaching = longest
    for _ in range(12):
        found = promises.promise(make(short, int(window))[0])
        ratio = found.arw_percent / percent
        if math.isinf(found.respond_s):
            shortest = 1.3 * window
        elif ratio <= 1:  # a further cluster size narrows the interval in a step
            reaching = window
        if math.isfinite(found.respond_s) and (math.isinf(ratio) or 0.93 < ratio <= 1):
            break
        window *= min(max(ratio**2 * 1.04, 0.1), 10)
        window = min(max(window, shortest), longest)
    return make(wishes, int(reaching))


def candidates(wishes: Wishes) -> Iterator[tuple[float, list[Design]]]:
    """Groups of designs in the order of preference, each with the percentage that it must reach."""
    percent = wishes.arw_percent or design.ARW_PERCENT
    if wishes.false_alarms_per_hour is not None:
        yield percent, _reaching(design.glr, wishes, percent)
        return
    if wishes.respond_s is not None or wishes.arw_percent is None:
        yield percent, design.fixed(wishes)
    yield percent, _reaching(design.fixed_of_window, wishes, percent)
    if wishes.arw_percent is None:
        yield PERCENT_STILL_USEFUL, design.fixed(wishes)
    if wishes.respond_s is not None and wishes.engine != "slide":  # glr has a grid
        yield percent, _reaching(design.glr, wishes, percent)


# --- what a plan fails ---


def excess(plan: Plan, percent: float) -> dict[str, float]:
    """Option -> by which factor the plan misses it, above 1. A clock must leave time in addition
    to the pushes, so 1 misses it, too.
    """
    wishes, cost, promise = plan.design.wishes, plan.cost, plan.promise
    found = {
        "--ram": cost.ram_bytes / (wishes.ram_bytes or math.inf),
        "--flash": cost.flash_bytes / (wishes.flash_bytes or math.inf),
        "--respond": promise.respond_s / (wishes.respond_s or math.inf),
        "--arw-percent": promise.arw_percent / percent,
        "--clock": plan.mean_mhz / (wishes.clock_mhz or math.inf),
    }
    if math.isinf(promise.respond_s):
        found["--respond"] = math.inf
    return {
        option: factor
        for option, factor in found.items()
        if factor > 1 or (option == "--clock" and factor == 1)
    }


def _rank(plan: Plan) -> tuple[int, int, int]:
    cost = plan.cost
    fewer_results = design.WINDOWS[0] - plan.design.window // plan.design.stride
    price = cost.flash_bytes + RAM_OVER_FLASH * cost.ram_bytes
    return FITS.index(plan.design.fit), max(fewer_results, 0), price


def _plans(wishes: Wishes) -> Iterator[tuple[float, list[Plan]]]:
    of_core = costs.table()[wishes.core]
    for percent, designs in candidates(wishes):
        yield (
            percent,
            [Plan(d, promises.promise(d), costs.cost(d, of_core)) for d in designs],
        )


def find(wishes: Wishes) -> Plan | None:
    """The best plan that meets every wish. Motion that is not stated is slow if there is room."""
    found = [_in_motion(replace(wishes, motion=motion)) for motion in _motions(wishes)]
    fitting = [plan for plan in found if plan is not None]
    return min(fitting, key=lambda plan: FITS.index(plan.design.fit), default=None)


def _motions(wishes: Wishes) -> tuple[str, ...]:
    return ("slow", NO_ROOM) if wishes.motion is None else (wishes.motion,)


def _in_motion(wishes: Wishes) -> Plan | None:
    for percent, plans in _plans(wishes):
        fitting = [plan for plan in plans if not excess(plan, percent)]
        if fitting:
            return min(fitting, key=_rank)
    return None


# --- what a plan needs ---

# Option -> what a plan needs of it, and that as the option's value.
NEEDS: dict[str, tuple[Callable[[Plan], float], Callable[[float], str]]] = {
    "--ram": (lambda plan: plan.cost.ram_bytes, lambda size: kilobytes(int(size))),
    "--flash": (lambda plan: plan.cost.flash_bytes, lambda size: kilobytes(int(size))),
    "--arw-percent": (lambda plan: plan.promise.arw_percent, lambda p: f"{p * 1.01 + 0.05:.1f}"),
    "--respond": (lambda plan: plan.promise.respond_s, lambda s: number(s * 1.01)),
    "--clock": (lambda plan: plan.mean_mhz, lambda mhz: number(mhz * 1.01)),
}
LIMITS = {"--flash": "flash_bytes", "--ram": "ram_bytes"}


def for_motion(plan: Plan) -> list[Relaxed]:
    """Limits with which a setup without motion would have it. Empty: it needs none, or has it."""
    wishes = plan.design.wishes
    if wishes.motion != NO_ROOM or (wishes.flash_bytes is None and wishes.ram_bytes is None):
        return []
    return _with_limits(replace(wishes, motion="slow"), lambda found: True)


def _with_limits(wishes: Wishes, suits: Callable[[Plan], bool]) -> list[Relaxed]:
    """The fewest of --flash and --ram, with values with which there is a plan that suits."""
    for options in (["--flash"], ["--ram"], ["--flash", "--ram"]):
        unlimited: dict[str, Any] = {LIMITS[option]: None for option in options}
        found = find(replace(wishes, **unlimited))
        if found and suits(found):
            return [
                Relaxed(option, NEEDS[option][1](NEEDS[option][0](found))) for option in options
            ]
    return []


def for_all_terms(plan: Plan) -> list[Relaxed]:
    """Limits with which a setup with a curve would fit all five terms. Empty: it does, or it has
    no curve.
    """
    wishes = plan.design.wishes
    if plan.design.fit != "curve":
        return []
    return _with_limits(wishes, lambda found: found.design.fit == "terms")


# --- what to relax ---


def _described(wishes: Wishes) -> list[str]:
    """The wishes that cost memory."""
    words = [f"{wishes.axes} {'axis' if wishes.axes == 1 else 'axes'}"]
    if wishes.respond_s is not None:
        words.append(f"a response within {number(wishes.respond_s)} s")
    if wishes.arw_percent is not None:
        words.append(f"ARW to {wishes.arw_percent:g} %")
    if wishes.false_alarms_per_hour is not None:
        words.append("alarms")
    if wishes.longest_tau_s is not None:
        words.append(f"averaging times to at least {number(wishes.longest_tau_s)} s")
    if wishes.motion == "flight":
        words.append("a floor per axis")
    return words


def _need(wishes: Wishes) -> str:
    """Those wishes as the subject of a sentence, with its verb."""
    words = _described(wishes)
    if len(words) == 1:
        return f"{words[0]} {'needs' if wishes.axes == 1 else 'need'}"
    return f"{', '.join(words[:-1])} and {words[-1]} need"


def _enough(wishes: Wishes, needed: dict[str, float]) -> list[Relaxed]:
    """Values of these options with which there is a plan, or none."""
    for more in MORE:
        relaxed = [
            Relaxed(option, NEEDS[option][1](more * need)) for option, need in needed.items()
        ]
        other = wishes
        for one in relaxed:
            other = with_option(other, one.option, one.value)
        if find(other):
            return relaxed
    return []


def _only(option: str, plans: Iterable[tuple[float, list[Plan]]]) -> Iterator[Plan]:
    """Plans that miss this option alone."""
    for percent, group in plans:
        for plan in group:
            if set(excess(plan, percent)) == {option}:
                yield plan


def _useful(plan: Plan) -> bool:
    promise = plan.promise
    return promise.arw_percent <= PERCENT_STILL_USEFUL and math.isfinite(promise.respond_s)


def _relaxed_limits(wishes: Wishes, plans: list[tuple[float, list[Plan]]]) -> Iterator[Relaxed]:
    """Each limit as the cheapest plan that misses nothing else needs it."""
    for option, (measure, _) in NEEDS.items():
        needs = [measure(plan) for plan in _only(option, plans) if _useful(plan)]
        if needs:
            yield from _enough(wishes, {option: min(needs)})


def _shorter(wishes: Wishes) -> Iterator[Wishes]:
    """The wishes with halves of the longest averaging time."""
    if wishes.longest_tau_s is not None:
        for halvings in range(1, 64):
            shorter = float(number(wishes.longest_tau_s / 2**halvings))
            yield replace(wishes, longest_tau_s=shorter)
            if shorter * wishes.rate_hz < 2:
                break


def _relaxed_wishes(wishes: Wishes) -> Iterator[Relaxed]:
    """The nearest other values of the wishes that are no limits."""
    if wishes.respond_s is not None:
        for factor in LENGTHEN:
            other = replace(wishes, respond_s=float(number(wishes.respond_s * factor)))
            if find(other):
                yield Relaxed("--respond", number(wishes.respond_s * factor))
                break
    for other in _shorter(wishes):
        plan = find(other)
        if plan:
            if plan.design.cascade_taus:
                yield Relaxed("--longest-tau", number(other.longest_tau_s or 0))
            break
    if wishes.motion in ("slow", "flight") and find(replace(wishes, motion="none")):
        yield Relaxed("--motion", "none")
    if wishes.lost_percent > 0 and find(replace(wishes, lost_percent=0.0)):
        yield Relaxed("--lost", "0")
    for axes in range(wishes.axes - 1, 0, -1):
        if find(replace(wishes, axes=axes)):
            yield Relaxed("--axes", str(axes))
            break


def _relaxed(wishes: Wishes, plans: list[tuple[float, list[Plan]]]) -> list[Relaxed]:
    """One value for each option that alone makes a plan possible."""
    found: dict[str, Relaxed] = {}
    for relaxed in (*_relaxed_limits(wishes, plans), *_relaxed_wishes(wishes)):
        first = found.setdefault(relaxed.option, relaxed)
        if relaxed.option == "--respond" and float(relaxed.value) < float(first.value):
            found["--respond"] = relaxed
    return list(found.values())


def _nearest(plans: list[tuple[float, list[Plan]]]) -> tuple[float, Plan]:
    """The plan that misses its wishes by least, and its percentage."""
    pairs = [(percent, plan) for percent, group in plans for plan in group]
    useful = [pair for pair in pairs if _useful(pair[1])]
    return min(useful or pairs, key=lambda pair: math.prod(excess(pair[1], pair[0]).values()))


def _together(wishes: Wishes, percent: float, nearest: Plan) -> list[Relaxed]:
    """What to relax at once if no single option suffices."""
    if not _useful(nearest):
        return []
    needed = {option: NEEDS[option][0](nearest) for option in excess(nearest, percent)}
    return _enough(wishes, needed) or _later(wishes)


def _later(wishes: Wishes) -> list[Relaxed]:
    """The nearest later response that one limit makes possible, and this limit. Candidates depend
    on the response, so that the nearest plan need not be one for the response that it promises.
    """
    if wishes.respond_s is None:
        return []
    for factor in LENGTHEN:
        later = Relaxed("--respond", number(wishes.respond_s * factor))
        other = with_option(wishes, later.option, later.value)
        plans = [(percent, group) for percent, group in _plans(other) if group]
        for limit in _relaxed_limits(other, plans):
            return [later, limit]
    return []


def _too_long(wishes: Wishes) -> Impossible:
    """For averaging times that no cascade reaches, and what else is impossible."""
    longest = wishes.longest_tau_s or 0.0
    reason = (
        f"--longest-tau {number(longest)}: {longest * wishes.rate_hz:.3g} samples at "
        f"{wishes.rate_hz:g} Hz, more than a cascade of {wishes.type} can reach"
    )
    other = next(o for o in _shorter(wishes) if any(group for _, group in candidates(o)))
    relaxed = {"--longest-tau": Relaxed("--longest-tau", number(other.longest_tau_s or 0))}
    try:
        plan(other)
    except Impossible as why:
        more = why.relaxed if why.together else why.relaxed[:1]
        relaxed |= {one.option: one for one in more}
        return Impossible(
            [reason, *why.reasons],
            relaxed.values() if more else (),
            hints=why.hints,
            together=len(relaxed) > 1,
        )
    return Impossible([reason], relaxed.values())


def _of_window(plan: Plan) -> str:
    """The window of a plan as the subject of a sentence."""
    found = plan.design
    most = design.WINDOW_MOST[found.wishes.type]
    if found.law == "glr":
        most = design.BLOCK * design.BLOCKS_MOST
    if found.window > 0.8 * most:
        return "the longest window" + (" of law glr" if found.law == "glr" else "")
    return f"a window of {number(found.window / found.wishes.rate_hz)} s"


def _reason(option: str, wishes: Wishes, percent: float, nearest: Plan) -> str:
    """What the wishes need of an option and do not get, by the nearest plan."""
    cost, promise = nearest.cost, nearest.promise
    if option == "--ram":
        limit, size = sizes_apart(wishes.ram_bytes or 0, cost.ram_bytes)
        return f"RAM {limit}: {_need(wishes)} {size}"
    if option == "--flash":
        limit, size = sizes_apart(wishes.flash_bytes or 0, cost.flash_bytes)
        return f"flash {limit}: {_need(wishes)} {size}"
    if option == "--respond" and math.isinf(promise.respond_s):
        return "alarms: even the longest window misses more than one in ten doublings of the noise"
    if option == "--respond":
        wish, found = apart(wishes.respond_s or 0, promise.respond_s)
        seen = (
            "a doubling of the noise is seen"
            if promise.false_alarms_per_hour
            else "a change of the noise is followed"
        )
        return f"respond {wish} s: {seen} within {found} s"
    if option == "--clock":
        wish, found = apart(wishes.clock_mhz or 0, nearest.mean_mhz)
        return f"clock {wish} MHz: pushes take {found} million instructions per second"
    wish, found = apart(percent, promise.arw_percent)
    least = "" if wishes.arw_percent else " (the default)"
    return f"ARW to {wish} %{least}: {_of_window(nearest)} gives {found} %"


def _rarely(wishes: Wishes) -> Impossible:
    """For wishes of which no plan has ARW in nine of ten results."""
    if design.noise_counts(wishes) and find(replace(wishes, noise=None)):
        return Impossible(
            [
                f"--lsb {wishes.lsb:g}: the typical noise is {design.noise_counts(wishes):.2g} "
                "counts before the filter, and rounding hides it"
            ],
            hints=[
                "choose a smaller range of the gyro and state its --lsb, or sum samples "
                "(davar/average.h)"
            ],
        )
    return Impossible(
        [f"--bandwidth {wishes.bandwidth}: ARW is present in too few windows behind this filter"],
        hints=_summed(wishes),
    )


def _summed(wishes: Wishes) -> list[str]:
    """The least sum of samples that makes a plan possible, as options."""
    if wishes.lsb is None or wishes.bandwidth is None:
        return []
    for count in (2, 4, 8, 16):
        other = replace(
            wishes,
            rate_hz=wishes.rate_hz / count,
            lsb=wishes.lsb / count,
            bandwidth=f"{wishes.bandwidth}+sum:{count}",
        )
        if find(other):
            return [
                f"sum {count} samples first (davar/average.h), and state --rate {other.rate_hz:g} "
                f"--lsb {other.lsb:g} --bandwidth {other.bandwidth}"
            ]
    return []


def _more_certain(wishes: Wishes) -> str | None:
    """The low-pass as a floor needs it, with the largest uncertainty in percent; None: no such."""
    form = r"([0-9.eE-]+)(?::([12])(?::([0-9.]+))?)?(\+.*)?"
    found = re.fullmatch(form, wishes.bandwidth or "")
    if not found or found[1] == "none":
        return None
    hz, order, percent, after = found[1], found[2] or "2", found[3] or "10", found[4] or ""
    for less in range(math.ceil(float(percent)) - 1, 0, -1):
        bandwidth = f"{hz}:{order}:{less}{after}"
        floor = floors.floor(replace(wishes, bandwidth=bandwidth))
        if floor and floor.usable >= floors.NEEDED:
            return bandwidth
    return None


def _narrow(wishes: Wishes, usable: int) -> Impossible:
    """For a floor without a value behind the filter. usable: frequencies."""
    certain = _more_certain(wishes)
    still = find(replace(wishes, motion="none"))
    return Impossible(
        [
            f"--motion flight: --bandwidth {wishes.bandwidth} leaves {usable} usable frequencies, "
            f"and the floor needs {floors.NEEDED} for a value: it would "
            + ("only have an upper limit" if usable >= floors.LIMITED else "have no limit either")
        ],
        [Relaxed("--motion", "none")] if still else [],
        hints=[
            *(
                [f"if you know the cutoff that well, state --bandwidth {certain}"]
                if certain
                else []
            ),
            "give samples before this filter, or set the gyro to a wider low-pass",
        ],
    )


def _hints(wishes: Wishes, missed: Iterable[str], relaxed: Iterable[Relaxed]) -> Iterator[str]:
    """What else would help."""
    if wishes.bandwidth is None and "--arw-percent" in missed:
        yield "a declared --bandwidth narrows the interval of ARW"
    if "--clock" in missed:
        yield "sum samples first (davar/average.h), and state their lower rate"
    shorter = any(one.option == "--longest-tau" for one in relaxed)
    without = replace(wishes, longest_tau_s=None)
    if wishes.longest_tau_s and not shorter and find(without):
        yield "it is possible without --longest-tau"


def plan(wishes: Wishes) -> Plan:
    """The plan for the wishes. Raises Impossible, or BadOption for a filter."""
    floor = floors.floor(wishes)
    if floor and floor.usable < floors.NEEDED:
        raise _narrow(wishes, floor.usable)
    found = find(wishes)
    if found:
        return found
    wishes = replace(wishes, motion=_motions(wishes)[-1])
    plans = [(percent, group) for percent, group in _plans(wishes) if group]
    if plans and all(math.isinf(p.promise.arw_percent) for _, group in plans for p in group):
        raise _rarely(wishes)
    if not plans:
        raise _too_long(wishes)
    percent, nearest = _nearest(plans)
    missed = excess(nearest, percent)
    reasons = [_reason(option, wishes, percent, nearest) for option in missed]
    relaxed, together = _relaxed(wishes, plans), False
    if not relaxed:
        relaxed = _together(wishes, percent, nearest)
        together = len(relaxed) > 1
    hints = _hints(wishes, missed, relaxed)
    raise Impossible(reasons, relaxed, hints=hints, together=together)
