"""The wishes of a command line: what the user has and wants, in physical units."""

import difflib
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from . import sensors

TYPES = ("int16", "int32", "float")
MOTIONS = ("none", "slow", "flight")
ENGINES = ("slide", "grid", "small")
AXES_MOST = 16
FLAGS = ("--json", "--self-contained", "--simulate")
OF_THE_PROGRAM = {  # options of the program in C
    **dict.fromkeys(
        ("--taus", "--long", "--window", "--stride"), "the plan of a fit: --taus must be"
    ),
    "--name": "the plan of a fit or a floor: --taus or --floor must be",
    **dict.fromkeys(("--floor", "--rail"), "the plan of a floor: --floor must be"),
}


class BadOption(Exception):
    """An option that cannot be used. The text names it."""


@dataclass(frozen=True)
class Wishes:
    """None: not stated. The planner then chooses, or does not limit."""

    rate_hz: float
    core: str
    axes: int = 1
    type: str = "int16"
    lsb: float | None = None  # deg/s per count
    full_scale: float | None = None  # deg/s; of floats
    bandwidth: str | None = None  # as davar-plan --bandwidth
    noise: float | None = None  # typical angle random walk, deg/sqrt(h)
    lost_percent: float = 1.0  # of the samples
    motion: str | None = None
    engine: str | None = None
    respond_s: float | None = None
    arw_percent: float | None = None
    longest_tau_s: float | None = None
    false_alarms_per_hour: float | None = None
    ram_bytes: int | None = None
    flash_bytes: int | None = None
    clock_mhz: float | None = None
    sensor: str | None = None
    sensor_bandwidth: str | None = None  # its usual filter


def _number(least: float, most: float, words: str) -> Callable[[str], float]:
    """Reads a number in a range. words: of both for a person, with the unit."""

    def read(text: str) -> float:
        form = r"([0-9]+(\.[0-9]*)?|\.[0-9]+)(e[+-]?[0-9]+)?"
        value = float(text) if re.fullmatch(form, text, re.IGNORECASE) else math.nan
        if not least <= value <= most:
            raise ValueError(words)
        return value

    return read


def _above_0(unit: str) -> Callable[[str], float]:
    return _number(1e-12, 1e12, f"a number of {unit} above 0")


def _axes(text: str) -> int:
    if not re.fullmatch(r"[0-9]{1,3}", text) or not 1 <= int(text) <= AXES_MOST:
        raise ValueError(f"a whole number from 1 to {AXES_MOST}")
    return int(text)


def _bytes(text: str) -> int:
    found = re.fullmatch(r"([0-9]+(?:\.[0-9]+)?)([kK]?)", text)
    size = float(found[1]) * (1024 if found[2] else 1) if found else 0.0
    if not 1 <= size <= 2**40:
        raise ValueError("a number of bytes, such as 20480 or 20k")
    return int(size)


def _text(text: str) -> str:
    if not text.strip():
        raise ValueError("a text")
    return text


def _one_of(choices: Sequence[str]) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in choices:
            raise ValueError(f"one of {', '.join(choices)}")
        return text

    return read


# Names that people type, as sensors.plain() -> the core with these instructions.
CORES = {"cortexm0+": "cortex-m0", "cortexm0plus": "cortex-m0", "cortexm4": "cortex-m4f"}


def _core(cores: Sequence[str]) -> Callable[[str], str]:
    def read(text: str) -> str:
        known = {sensors.plain(core): core for core in cores} | CORES
        return _one_of(cores)(known.get(sensors.plain(text), text))

    return read


def _readers(cores: Sequence[str]) -> dict[str, tuple[str, Callable[[str], object]]]:
    """Option -> (field of Wishes, how its value is read)."""
    return {
        "--rate": ("rate_hz", _above_0("Hz")),
        "--axes": ("axes", _axes),
        "--type": ("type", _one_of(TYPES)),
        "--lsb": ("lsb", _above_0("deg/s")),
        "--full-scale": ("full_scale", _above_0("deg/s")),
        "--bandwidth": ("bandwidth", _text),
        "--noise": ("noise", _above_0("deg/sqrt(h)")),
        "--lost": ("lost_percent", _number(0, 20, "a number from 0 to 20")),
        "--motion": ("motion", _one_of(MOTIONS)),
        "--engine": ("engine", _one_of(ENGINES)),
        "--respond": ("respond_s", _above_0("seconds")),
        "--arw-percent": ("arw_percent", _number(0.1, 50, "a number from 0.1 to 50")),
        "--longest-tau": ("longest_tau_s", _above_0("seconds")),
        "--false-alarms-per-hour": (
            "false_alarms_per_hour",
            _number(1e-9, 1e9, "a number from 1e-9 to 1e9"),
        ),
        "--ram": ("ram_bytes", _bytes),
        "--flash": ("flash_bytes", _bytes),
        "--clock": ("clock_mhz", _above_0("MHz")),
        "--core": ("core", _core(cores)),
    }


def with_option(wishes: Wishes, option: str, text: str) -> Wishes:
    """The wishes with another value of an option."""
    field, reader = _readers(())[option]
    changes: dict[str, Any] = {field: reader(text)}
    return replace(wishes, **changes)


@dataclass(frozen=True)
class Command:
    """A command line."""

    wishes: Wishes
    folder: str | None
    json: bool
    self_contained: bool
    simulate: bool


def _values(words: Sequence[str], options: Sequence[str]) -> dict[str, str]:
    """Option -> its word; "" of a flag."""
    found: dict[str, str] = {}
    rest = list(words)
    while rest:
        option, *inside = rest.pop(0).split("=", 1)
        if option in OF_THE_PROGRAM:
            raise BadOption(f"{option}: only for {OF_THE_PROGRAM[option]} the first word")
        if option not in options or (option in FLAGS and inside):
            near = difflib.get_close_matches(option, options, 1)
            hint = f"; do you mean {near[0]}?" if near else ""
            raise BadOption(f"{option}: unknown option{hint} (see --help)")
        if option in found:
            raise BadOption(f"{option}: given twice")
        if option in FLAGS:
            found[option] = ""
            continue
        if not inside and (not rest or rest[0] in options):
            raise BadOption(f"{option}: its value is missing (see --help)")
        found[option] = inside[0] if inside else rest.pop(0)
    return found


def of_sensor(text: str) -> dict[str, object]:
    """The fields of Wishes that NAME@RATE states."""
    name, at, rate = text.lower().partition("@")
    try:
        if not at:
            raise ValueError("NAME@RATE, such as icm42688@1000")
        return sensors.look_up(name, _above_0("Hz")(rate))
    except ValueError as why:
        raise BadOption(f"--sensor: expected {why}, found '{text}'") from None


def suits_small(wishes: Wishes) -> bool:
    """Do these wishes need no more than davar/small.h?"""
    return (
        (wishes.axes, wishes.type, wishes.lost_percent) == (1, "int16", 0)
        and wishes.motion not in ("slow", "flight", None)
        and wishes.bandwidth is not None
        and wishes.false_alarms_per_hour is None
    )


def checked(wishes: Wishes) -> Wishes:
    """The wishes, if nothing is missing or contradicts."""
    if wishes.type == "float" and wishes.full_scale is None:
        raise BadOption("--full-scale: required with --type float: the largest rate in deg/s")
    if wishes.type != "float" and wishes.lsb is None:
        raise BadOption("--lsb: required: the size of a count in deg/s (or --sensor NAME@RATE)")
    if wishes.type != "float" and wishes.full_scale is not None:
        raise BadOption("--full-scale: only with --type float; --lsb gives the scale of counts")
    if wishes.type == "float" and wishes.lsb is not None:
        raise BadOption("--lsb: not with --type float, whose samples are in deg/s")
    if wishes.longest_tau_s is not None and wishes.longest_tau_s * wishes.rate_hz < 1:
        raise BadOption("--longest-tau: shorter than one sample; expected seconds")
    if wishes.engine == "slide" and wishes.false_alarms_per_hour is not None:
        raise BadOption(
            "--engine: slide has no alarms: leave out --false-alarms-per-hour, or use grid"
        )
    if wishes.engine == "small" and not suits_small(wishes):
        raise BadOption(
            "--engine: small is for one axis of int16 with --lost 0, --motion none and --bandwidth "
            "(or --bandwidth none), without alarms"
        )
    if wishes.motion == "flight" and wishes.type == "float":
        raise BadOption("--motion: flight needs counts: state --type int16 or int32, and --lsb")
    if wishes.motion == "flight" and wishes.bandwidth is None:
        raise BadOption(
            "--motion: flight needs the filter, and reads too low where it is unknown; give "
            "--bandwidth FILTER, or none for raw samples"
        )
    return wishes


def read(words: Sequence[str], cores: Sequence[str]) -> Command:
    """Reads a command line. Raises BadOption."""
    readers = _readers(cores)
    texts = _values(words, [*readers, "--sensor", "-o", *FLAGS])
    if "--sensor" in texts and "--rate" in texts:
        raise BadOption("--rate: not with --sensor NAME@RATE, which states it")
    stated: dict[str, object] = of_sensor(texts["--sensor"]) if "--sensor" in texts else {}
    if texts.get("--type") == "float":
        stated.pop("lsb", None)
    for option, (field, reader) in readers.items():
        if option in texts:
            try:
                stated[field] = reader(texts[option])
            except ValueError as why:
                raise BadOption(f"{option}: expected {why}, found '{texts[option]}'") from None
    for option, field in (("--rate", "rate_hz"), ("--core", "core")):
        if field not in stated:
            raise BadOption(f"{option}: required (see --help)")
    if not texts.get("-o", "."):
        raise BadOption("-o: expected a folder, found ''")
    wishes = replace(Wishes(rate_hz=0.0, core=""), **stated)  # type: ignore[arg-type]
    if "--self-contained" in texts and "-o" not in texts:
        raise BadOption("--self-contained: needs -o FOLDER, where the files are written")
    return Command(
        checked(wishes),
        texts.get("-o"),
        json="--json" in texts,
        self_contained="--self-contained" in texts,
        simulate="--simulate" in texts,
    )
