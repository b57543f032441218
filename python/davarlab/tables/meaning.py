"""What the columns of a log are together: their names and numbers, gravity, and the noise of a gyro
(docs/LOGS.md)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Floats
from ..thresholds import GUESS
from .constants import DEG_PER_RAD
from .guess import FORCES, RATES, Guess, of_column, scatter_of, whole


def guesses(
    columns: Mapping[str, npt.NDArray[Any]],
    rates: Sequence[float] = (),
    settle: Callable[[list[Guess]], object] = lambda found: None,
) -> list[Guess]:
    """Guesses for the columns of a file (name -> numbers), in their order: one time, one
    temperature, one of each axis; the norm of the accelerometer says its unit where its name does
    not. rates: in Hz, as the file states them; settle: sets the units that are known, before the
    others are found by them."""
    found, taken = {}, set()
    guesses = [
        of_column(name, np.asarray(values, float), rates) for name, values in columns.items()
    ]
    for guess in sorted(
        guesses, key=lambda guess: guess.column != guess.name
    ):  # who bears a name already keeps it
        if guess.quantity != "other" and guess.column in taken:
            guess = Guess(guess.name, "other")
        taken.add(guess.column)
        found[guess.name] = guess
    ordered = [found[name] for name in columns]
    settle(ordered)
    weighed(ordered, columns)
    unit_by_evidence(ordered, columns)
    return ordered


def weighed(found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """Gravity is 1 g: whatever the accelerometer's numbers are, its norm tells the unit. Without
    gravity nothing tells it, and the columns keep their names."""
    unsaid = [guess for guess in found if guess.quantity == "accel" and not guess.sure]
    if len(unsaid) != 3:
        return
    axes = np.array([columns[guess.name] for guess in unsaid], float)
    norm = float(np.median(np.linalg.norm(axes, axis=0)))
    unit = next((unit for unit, one in FORCES.items() if 0.8 < norm * one < 1.25), "counts")
    linear = unit == "counts" and norm < GUESS.linear and not all(map(whole, axes))
    for guess in unsaid:
        guess.unit, guess.factor = unit, FORCES.get(unit, 1 / norm if norm else 1.0)
        if linear:
            guess.unit, guess.factor = "", 1.0
            guess.unused = (
                f"linear acceleration: gravity is missing in it (its norm is {norm:.2g}), so its "
                "unit is not known and it is not used (--unit accel=m/s^2 or g uses it)"
            )


def unit_by_evidence(found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """The unit of a gyro whose name says none: gravity that turns as it says, the unit of the
    accelerometer beside it, or its noise, if a gyro can have that in one unit only."""
    unsaid = [
        guess
        for guess in found
        if guess.quantity == "gyro" and not guess.sure and guess.unit in ("deg/s", "rad/s")
    ]
    if not unsaid:
        return
    live = [one for one in unsaid if scatter_of(columns[one.name]) > 0] or unsaid
    unit, how = by_gravity(unsaid, found, columns)
    arw = arw_of(live, found, columns)
    able = [
        one
        for one in ("deg/s", "rad/s")
        if arw and GUESS.usual_arw[0] < arw * RATES[one] < GUESS.usual_arw[1]
    ]
    metric = any(one.quantity == "accel" and one.unit == "m/s^2" for one in found)
    if not unit and metric and (arw is None or "rad/s" in able):
        unit, how = "rad/s", "the accelerometer in m/s^2 beside it"
    elif not unit and not metric and len(able) == 1:
        unit, how = able[0], f"its noise of {(arw or 0) * RATES[able[0]]:.2g} deg/sqrt(h)"
    quiet = min(live, key=lambda one: scatter_of(columns[one.name]))
    scatter = scatter_of(columns[quiet.name])
    if not unit and arw is None and not GUESS.scatter[0] < scatter < GUESS.scatter[1]:
        unit = quiet.unit
    for one in unsaid:
        one.unit, one.by = unit or quiet.unit, f"by {how}" * bool(how)
        one.factor = RATES[one.unit]
        if not unit:
            said = (
                f"in deg/s, its angle random walk would be {arw:.2g} deg/sqrt(h), in rad/s "
                f"{arw * RATES['rad/s']:.2g}"
                if arw
                else "the record has no evidence for one"
            )
            one.doubt = (
                f"the unit of the gyro is not known ({said}). Use --unit gyro=rad/s or --unit "
                "gyro=deg/s"
            )


def arw_of(
    gyros: list[Guess], found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]
) -> float | None:
    """The quietest axis's angle random walk in deg/sqrt(h) if it is in deg/s, from the usual
    difference of neighbouring means over 1 s, which no filter of the sensor takes away. None
    without a time, or below 20 s; 0 where means over 2 and 4 s do not agree: it is no white noise,
    but motion."""
    time = next((one for one in found if one.quantity == "time"), None)
    if time is None:
        return None
    seconds = np.asarray(columns[time.name], float) * time.factor
    span = float(seconds[-1] - seconds[0])
    if not span > GUESS.arw_least_s:
        return None
    usual = [
        min(usual_step(np.asarray(columns[one.name], float), span, tau_s) for one in gyros)
        for tau_s in GUESS.arw_taus_s
    ]
    return usual[0] if max(usual) < GUESS.arw_agrees * min(usual) else 0.0


def usual_step(x: Floats, span_s: float, tau_s: float) -> float:
    """60 sqrt(tau) times the Allan deviation, from the median of the differences of means."""
    together = max(1, round(len(x) * tau_s / span_s))
    count = len(x) // together
    means = x[: count * together].reshape(count, together).mean(axis=1)
    usual = float(np.median(np.abs(np.diff(means)))) / GUESS.half_of_normal
    return 60 * usual / float(np.sqrt(2)) * float(np.sqrt(span_s / count))


def by_gravity(
    gyros: list[Guess], found: list[Guess], columns: Mapping[str, npt.NDArray[Any]]
) -> tuple[str, str]:
    """(unit, what says it): the direction u of gravity in the sensor turns by -w x u a second, w in
    rad/s. ("", "") where it does not turn enough, or not as the gyro says."""
    time = next((one for one in found if one.quantity == "time"), None)
    force = {one.axis: one for one in found if one.quantity == "accel"}
    rate = {one.axis: one for one in gyros}
    if time is None or set(force) != set("xyz") or set(rate) != set("xyz"):
        return "", ""
    seconds = np.asarray(columns[time.name], float) * time.factor
    w, a = (
        np.array([columns[of[axis].name] * of[axis].factor for axis in "xyz"], float)
        for of in ({axis: replace(one, factor=1.0) for axis, one in rate.items()}, force)
    )
    step = float(np.median(np.diff(seconds))) if len(seconds) > 1 else 0.0
    together = int(GUESS.gravity_s / step) if step > 0 else 0
    if not 1 <= together <= a.shape[1] // 4:
        return "", ""
    count = a.shape[1] // together
    a, w = (x[:, : count * together].reshape(3, count, together).mean(axis=2) for x in (a, w))
    u = a / np.maximum(np.linalg.norm(a, axis=0), 1e-12)
    middle, between = (u[:, 1:] + u[:, :-1]) / 2, (w[:, 1:] + w[:, :-1]) / 2
    said = -np.cross(between, middle, axis=0) * together * step
    turned = np.diff(u, axis=1)
    if np.linalg.norm(turned, axis=0).sum() < GUESS.turned_rad:
        return "", ""
    both = float(np.sum(said * turned))
    sizes = float(np.sum(said**2)), float(np.sum(turned**2))
    if both**2 < GUESS.gravity_agrees * sizes[0] * sizes[1]:
        return "", ""
    slope = abs(both) / sizes[0]
    for unit, factor in (("rad/s", 1.0), ("deg/s", 1 / DEG_PER_RAD)):
        if 0.5 < slope / factor < 2:
            return unit, f"gravity, which turns as it says (slope {slope / factor:.2f})"
    return "", ""
