"""The noise of the axes of a log as imu prints it: one table in the units of a program, and why a
value at rest may fail in use."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import axes
from .. import model as models
from ..data import signals
from ..data.floors import Floor
from ..data.recording import Recording
from ..diagnosis.improve import Estimates
from ..effects import table
from ..inference.estimate import Estimate
from ..model import Model
from ..tables.constants import DEG_PER_RAD, UG_PER_MPS2
from ..thresholds import DEVICE
from . import parameters
from .parameters import Noise, Parameter

DEFAULT = "kalibr"  # whose names the table has unless another program is named
WALK = "rate_random_walk"
# floor_why -> why a flight has no value, and what to do. {}: the upper limit.
WITHOUT = (
    "",
    "the gaps leave too little of it. {}Give a recording without gaps",
    "the filter leaves too few frequencies, or is known too little. {}Log before the filter",
    "the counts are at the end of the range. {}Set a larger range",
    "rounding to counts hides it. {}Log finer counts",
    "it changes within a window. {}Give a steadier part",
    "the value does not change. {}Check the sensor",
)
FAMILIAR = {
    "gyro": (
        Parameter("ARW", "gyro", "deg/sqrt(h)", "", lambda noise: 60 * DEG_PER_RAD * noise.white),
        Parameter(
            "bias instability",
            "gyro",
            "deg/h",
            "",
            lambda noise: 3600 * DEG_PER_RAD * noise.flicker,
        ),
    ),
    "accel": (
        Parameter("VRW", "accel", "m/s/sqrt(h)", "", lambda noise: 60 * noise.white),
        Parameter("bias instability", "accel", "ug", "", lambda noise: UG_PER_MPS2 * noise.flicker),
    ),
}
Value = tuple[float, float | None, float | None]  # with its 95 % interval, where it has one


@dataclass
class Axis:
    """One axis. model, estimates: of the analysis at rest, None where it moves; fits: the verdict
    on the model; said: its sentence; reading: the angle random walk that the record has without the
    model, deg/sqrt(h), with its ends; floor: of a gyro in motion; moved: the
    share of the record that was left out."""

    column: str
    model: Model | None = None
    estimates: Sequence[Estimates] = ()
    fits: bool = False
    said: str = ""
    reading: Value | None = None
    floor: Floor | None = None
    moved: float = 0.0

    @property
    def flies(self) -> bool:
        """It moves, and has the noise between rotor lines and motion."""
        return self.floor is not None and bool(self.floor.values)

    @property
    def quantity(self) -> str:
        return self.column.split("_")[0]


def at_end(axis: Axis, end: str) -> Model:
    """The model of an axis with the sizes of its effects at an end of their intervals. Those of a
    model that fails do not hold: its white noise is that of the reading."""
    assert axis.model is not None
    terms = []
    for term, entry in zip(axis.model.terms, axis.estimates):
        effect = table.find(term.kind)
        one = entry.get(effect.size.name)
        if effect.role != "filter" and one is not None:
            value = getattr(one if axis.fits else read_off(axis, term.kind, one), end)
            held = one.number if value is None else value
            term = replace(term, parameters={**term.parameters, effect.size.name: held})
        terms.append(term)
    return replace(axis.model, terms=terms, column=axis.column)


def read_off(axis: Axis, kind: str, one: Estimate) -> Estimate:
    """A size of a model that fails."""
    if kind != "angle_random_walk" or axis.reading is None:
        return Estimate(one.value)
    value, low, high = axis.reading
    assert low is not None and high is not None
    holds = one.number > 0 and low <= one.number <= high
    return Estimate(one.number if holds else value, low, high)


def noises(axis: Axis, bias_time_s: float) -> tuple[Noise, Noise, Noise]:
    """(at the lower ends, estimated, at the upper ends). The random walk is that of one effect at
    all three."""
    middle = parameters.noise_of(at_end(axis, "value"), axis.column, bias_time_s)
    low, high = (without_walk(at_end(axis, end), middle) for end in ("low", "high"))
    return (
        replaced(parameters.noise_of(low, axis.column, bias_time_s), middle),
        middle,
        replaced(parameters.noise_of(high, axis.column, bias_time_s), middle),
    )


def without_walk(model: Model, middle: Noise) -> Model:
    """A model whose random walk comes from another effect, as that of the estimate does."""
    kept = [term for term in model.terms if term.kind != WALK or middle.walk_from == WALK]
    return replace(model, terms=kept)


def replaced(end: Noise, middle: Noise) -> Noise:
    """An end at which the effect of the random walk is 0."""
    return end if end.walk_from == middle.walk_from else replace(end, walk=0.0)


def value_of(parameter: Parameter, axis: Axis, bias_time_s: float) -> Value:
    ends = noises(axis, bias_time_s)
    low, value, high = (parameter.value(one) for one in ends)
    return (
        (value, low, high)
        if low < high and not converted(parameter, ends[1])
        else (value, None, None)
    )


def converted(parameter: Parameter, noise: Noise) -> bool:
    """Is a number a random walk that the record does not show, but another effect was converted
    to."""
    walks = parameter.value(replace(noise, walk=2 * noise.walk + 1)) != parameter.value(noise)
    return walks and noise.walk_from != WALK


def pooled(values: Sequence[Value]) -> Value:
    """The root mean square of the axes, and its interval."""
    middle = np.array([value for value, _, _ in values])
    mean = float(np.sqrt(np.mean(middle**2)))
    if not mean or any(low is None or high is None for _, low, high in values):
        return mean, None, None
    below, above = (
        float(np.sqrt(np.sum((middle * np.abs(ends - middle)) ** 2))) / (len(values) * mean)
        for ends in (np.array([float(one[end] or 0.0) for one in values]) for end in (1, 2))
    )
    return mean, max(mean - below, 0.0), mean + above


def shown(value: Value) -> str:
    middle, low, high = value
    between = "" if low is None or high is None else f" ({low:.3g} .. {high:.3g})"
    return f"{middle:.4g}{between}"


def columns(quantity: str, target: str) -> list[Parameter]:
    """What the table has of a sensor: the usual numbers, then those of the target in its units."""
    form = parameters.FORMATS.get(target, parameters.FORMATS[DEFAULT])
    return [
        *FAMILIAR[quantity],
        *(one for one in form.parameters if one.quantity == quantity),
    ]


def conversions(found: Sequence[Axis], target: str, bias_time_s: float) -> list[str]:
    """The names of the parameters whose values are converted, for any axis."""
    return [
        parameter.name
        for quantity in FAMILIAR
        for parameter in columns(quantity, target)
        if any(
            one.quantity == quantity
            and one.model is not None
            and converted(parameter, noises(one, bias_time_s)[1])
            for one in found
        )
    ]


def rows(
    found: Sequence[Axis], quantity: str, target: str, bias_time_s: float
) -> tuple[list[Parameter], dict[str, list[Value]]]:
    """(parameters, axis -> their values), with all axes pooled."""
    own = [one for one in found if one.quantity == quantity and one.model is not None]
    head = columns(quantity, target)
    out = {one.column: [value_of(each, one, bias_time_s) for each in head] for one in own}
    if len(own) > 1:
        out["pooled"] = [pooled([out[one.column][i] for one in own]) for i in range(len(head))]
    return head, out


def text(found: Sequence[Axis], recording: Recording, target: str, bias_time_s: float) -> str:
    """The tables of gyros and accelerometers, what each axis without a full answer lacks, and what
    the numbers cannot say."""
    lines: list[str] = []
    for quantity in FAMILIAR:
        lines += aligned(*rows(found, quantity, target, bias_time_s))
    lines += remarks(found, recording)
    return "\n".join([*lines, "", *limits(found, recording, target, bias_time_s)])


def aligned(head: Sequence[Parameter], values: Mapping[str, Sequence[Value]]) -> list[str]:
    if not values:
        return []
    cells = [
        ["", *(one.name for one in head)],
        ["95 %", *(one.unit for one in head)],
        *([name, *map(shown, own)] for name, own in values.items()),
    ]
    wide = [max(map(len, column)) + 2 for column in zip(*cells)]
    return [
        *("".join(cell.ljust(width) for cell, width in zip(row, wide)).rstrip() for row in cells),
        "",
    ]


def counts(recording: Recording) -> list[str]:
    """The gyros that nobody has given a unit."""
    return [
        name for name in recording.columns if name.startswith("gyro_") and name.endswith("_counts")
    ]


def remarks(found: Sequence[Axis], recording: Recording) -> list[str]:
    """What an axis lacks, a line each, and the floor of one in motion."""
    lines = []
    for one in found:
        if not one.fits:
            lines.append(f"{one.column}: {one.said}")
        if one.floor:
            lines += in_motion(one.floor)
    return lines + [
        f"{name}: counts without a unit. Type --unit gyro=FACTOR, the deg/s of a count"
        for name in counts(recording)
    ]


def in_motion(floor: Floor) -> list[str]:
    """The floor of one axis, and what most windows without one lack."""
    lines = []
    if floor.values:
        low, middle, high = np.quantile(floor.values, (0.1, 0.5, 0.9))
        lines.append(
            f"  noise between rotor lines and motion: {middle:.3g} deg/sqrt(h) (80 % of "
            f"{len(floor.values)} windows: {low:.3g} to {high:.3g})"
        )
    if 2 * len(floor.values) < floor.windows:
        below = f"It is below {floor.most:.3g} deg/sqrt(h). " if floor.most else ""
        lines.append(
            f"  noise between rotor lines and motion: no value in "
            f"{floor.windows - len(floor.values)} of {floor.windows} windows: "
            + WITHOUT[floor.why].format(below)
        )
    return lines


def limits(
    found: Sequence[Axis], recording: Recording, target: str, bias_time_s: float
) -> list[str]:
    """What the numbers cannot say, a sentence each."""
    names = conversions(found, target, bias_time_s)
    walk = (
        f"{' and '.join(names)} without interval: the recording does not show a random walk of the "
        "bias. The value is converted from bias instability or Gauss-Markov noise. The true one "
        "may be several times larger. Record for an hour or more to measure it."
    )
    return [walk] * bool(names) + before_filter(found) + in_use(found, recording)


def before_filter(found: Sequence[Axis]) -> list[str]:
    """What the noise in motion assumes."""
    if not any(one.floor and one.floor.filter is None for one in found):
        return []
    return [
        "Filter: the noise in motion assumes that no filter stands between the gyro and the log. "
        "After a filter, it is too low. State the filter with --bandwidth (biquad:90, pt1:100, "
        "...), or none: --bandwidth none."
    ]


def in_use(found: Sequence[Axis], recording: Recording) -> list[str]:
    """Why a value at rest may fail in use: a sentence each on motion, vibration, temperature and
    the filter."""
    still = [one for one in found if one.model is not None]
    if not still:
        return []
    moved = max(one.moved for one in still)
    out = f"{100 * moved:.2g} % of the recording moves and is excluded. " if moved else ""
    rate = (
        [
            f"Rate: at {recording.rate_hz:.3g} Hz, noise above half of the rate is folded into the "
            "band unless the sensor averages. The values are then upper limits."
        ]
        if recording.rate_hz < DEVICE.picked_hz
        else []
    )
    return rate + [
        f"Motion: {out}The numbers hold at rest. Scale and alignment errors, which grow with the "
        "rate, are not in them.",
        vibration(recording),
        temperature(still, recording),
        filtered(still),
    ]


def vibration(recording: Recording) -> str:
    forces = [name for name in recording.columns if models.is_accel(name) and axes.unit_of(name)]
    if not forces:
        return "Vibration: no accelerometer was recorded. Measure on the running vehicle too."
    window = max(3, int(recording.rate_hz))
    rms = [
        float(np.std(signals.high_passed(recording.column(name), window)))
        * axes.TO_MPS2[axes.unit_of(name) or "g"]
        for name in forces
    ]
    return (
        f"Vibration: {max(rms) / axes.TO_MPS2['g']:.2g} g rms in this recording, noise of the "
        "accelerometer included. On a running vehicle it is 0.1 to several g, and the noise of a "
        "MEMS gyro grows with it: give imu a recording of one."
    )


def temperature(still: Sequence[Axis], recording: Recording) -> str:
    column = next((name for name in recording.columns if name.startswith("temp")), None)
    if column is None:
        return "Temperature: not recorded. The bias of a MEMS gyro changes with it."
    values = recording.column(column)
    moved = f"from {values.min():.3g} to {values.max():.3g} degC"
    follows = sorted(
        {
            f"{one.column} ({term.kind.replace('_', ' ')})"
            for one in still
            if one.model
            for term in one.model.terms
            if "temperature" in term.kind or term.kind == "warm_up"
        }
    )
    return f"Temperature: {moved}. " + (
        f"It moves {', '.join(follows)}; the numbers are without that."
        if follows
        else "What the bias follows of it is in bias instability and random walk. To separate it, "
        "run diagnose."
    )


def filtered(still: Sequence[Axis]) -> str:
    own = sorted(
        {
            term.kind.replace("_", " ")
            for one in still
            if one.model
            for term in one.model.terms
            if table.find(term.kind).role == "filter"
        }
    )
    if not own:
        return (
            "Filter: none was found below half the sample rate. Vibration above half the sample "
            "rate is folded into the band."
        )
    return (
        f"Filter: {' and '.join(own)} found. The densities hold before it; a sample has "
        "less noise than density times the root of the rate."
    )


def plain(
    found: Sequence[Axis], recording: Recording, target: str, bias_time_s: float
) -> dict[str, Any]:
    """The same for --json."""
    out: dict[str, Any] = {}
    for quantity in FAMILIAR:
        head, values = rows(found, quantity, target, bias_time_s)
        for name, own in values.items():
            key = f"{quantity} pooled" if name == "pooled" else name
            out[key] = {
                f"{parameter.name} [{parameter.unit}]": dict(zip(("value", "low", "high"), value))
                for parameter, value in zip(head, own)
            }
    return {
        "axes": out,
        "fits": {one.column: one.fits for one in found if one.model is not None},
        "said": {one.column: one.said for one in found},
        "floor_deg_per_sqrt_h": {one.column: one.floor.values for one in found if one.floor},
        "limits": limits(found, recording, target, bias_time_s),
    }
