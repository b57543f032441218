"""What to type for the columns of a file without names: names that its numbers show, or an example
whose words must be replaced."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from ..tables import dialect, guess
from ..thresholds import GUESS

LEAST = 100  # rows, below which numbers show nothing
RUNNING = 0.5  # of the steps of a time that are above 0, at least
UNITS = {"g": (0.9, 1.1), "m_s2": (9.3, 10.3), "mg": (950.0, 1050.0)}  # norms of gravity
COUNTED = 200.0  # norm in counts, from which gravity is distinguished
AT_REST = 0.05  # scatter of a norm, relative, up to which it is constant
ALIKE = 4.0  # ratio of the noises of the axes of a sensor, at most
# Norms of the earth's field in gauss, uT, mG and nT: no gyro is proposed for a constant one.
FIELDS = ((0.2, 0.7), (20.0, 70.0), (200.0, 700.0), (2e4, 7e4))
QUATERNION = 2e-4  # of 1, how far the norm of four columns is from it
DEGREES = (10.0, 60.0)  # of a temperature
VARIES = 0.1  # of it, its standard deviation at most
SLOW = 0.2  # noise over scatter, below which a column is no noise of a sensor at rest


@dataclass(eq=False)
class Part:
    """A column: its place, its numbers, the standard deviation of its noise from sample to sample,
    and that of all of it."""

    place: int
    values: Floats
    noise: float
    scatter: float

    @property
    def slow(self) -> bool:
        return self.noise <= SLOW * self.scatter or not self.scatter


def said(columns: Mapping[str, Floats], count: int, rates: Sequence[float]) -> str:
    """What to type for the `count` columns of a file, of which those with numbers are called
    column_1 .. here. rates: in Hz, as the file states them."""
    found = names_of({int(name.partition("_")[2]) - 1: one for name, one in columns.items()}, rates)
    if not found:
        return f"Type {dialect.example(count)}"
    names = [found.get(place, dialect.SKIP) for place in range(count)]
    rate = "" if any(name.startswith("time") for name in names) else " --rate HZ"
    typed = f"type --names {','.join(names)}{rate}"
    if not any(name.startswith("accel") for name in names):
        first = names.index("gyro_x") + 1
        return (
            f"If columns {first} to {first + 2} are a gyro ({dialect.SKIP} skips a column; a "
            f"linear acceleration looks the same), {typed}"
        )
    return f"If its numbers show what the columns are ({dialect.SKIP} skips one), {typed}"


def names_of(columns: Mapping[int, Floats], rates: Sequence[float]) -> dict[int, str]:
    """place -> name of the columns whose numbers show what they are: at least one gyro; empty where
    something else could be it."""
    if len(next(iter(columns.values()))) < LEAST:
        return {}
    parts = [part_of(place, values) for place, values in columns.items()]
    running = [one for one in parts if is_running(one.values)]
    found = time_of(running, rates)
    if found is None:
        return {}
    rest = without_quaternion([one for one in parts if one not in running])
    able = [group for group in neighbours(rest, 3) if is_noise(group)]
    noisy = [one for one in rest if not one.slow and not is_temperature(one)]
    for name, axes in sensors_in(able, noisy):
        found |= {one.place: name.format(axis) for axis, one in zip("xyz", axes, strict=True)}
    if not any(name.startswith("gyro") for name in found.values()):
        return {}
    beside = {one.place for group in able for one in group} | set(found)
    warm = [one for one in parts if is_temperature(one) and one.place not in beside]
    return found | ({warm[0].place: "temp_degC"} if len(warm) == 1 else {})


def part_of(place: int, values: Floats) -> Part:
    values = np.asarray(values, float)
    return Part(place, values, float(np.std(np.diff(values)) / np.sqrt(2)), float(np.std(values)))


def is_running(values: Floats) -> bool:
    """Does a column never go back, and on in most rows."""
    steps = np.diff(values)
    return bool(np.all(steps >= 0) and np.mean(steps > 0) >= RUNNING)


def time_of(running: Sequence[Part], rates: Sequence[float]) -> dict[int, str] | None:
    """{place: name} of the first column that runs and counts no rows, empty without one; None where
    its unit is not clear."""
    for one in running:
        steps = np.diff(one.values)
        if np.all(steps == 1) or is_temperature(one):
            continue
        if guess.whole(one.values):
            made = guess.of_time("", one.values, rates)
            return None if made.doubt else {one.place: f"time_{made.unit}"}
        low, high = GUESS.usual_hz
        unit = next(
            (
                unit
                for unit in ("s", "ms", "us")
                if low <= 1 / (float(np.median(steps)) * guess.SECONDS[unit]) <= high
            ),
            None,
        )
        return {one.place: f"time_{unit}"} if unit else None
    return {}


def without_quaternion(parts: Sequence[Part]) -> list[Part]:
    """Columns but four neighbours whose norm is always 1."""
    for four in neighbours(parts, 4):
        if np.all(np.abs(norm_of(four) - 1) < QUATERNION):
            return [one for one in parts if one not in four]
    return list(parts)


def neighbours(parts: Sequence[Part], count: int) -> Iterator[Sequence[Part]]:
    for first in range(len(parts) - count + 1):
        group = parts[first : first + count]
        if group[-1].place - group[0].place == count - 1:
            yield group


def norm_of(parts: Sequence[Part]) -> Floats:
    norm: Floats = np.sqrt(np.sum([one.values**2 for one in parts], axis=0))
    return norm


def is_noise(group: Sequence[Part]) -> bool:
    """Are columns the noise of one sensor: fast, and of like size."""
    noises = [one.noise for one in group]
    return not any(one.slow for one in group) and max(noises) < ALIKE * min(noises)


def sensors_in(
    able: Sequence[Sequence[Part]], noisy: Sequence[Part]
) -> list[tuple[str, Sequence[Part]]]:
    """(name for {} axes, x, y, z) of a gyro, and of an accelerometer beside it; empty where the
    columns may be shared out in several ways. able: three neighbours each; noisy: all columns that
    may be of a sensor."""
    ways = [
        (gyro, accel)
        for gyro in filter(may_turn, able)
        for accel in able
        if gravity_in(accel) and apart(gyro, accel)
    ]
    if len(ways) == 1:
        gyro, accel = ways[0]
        return [("gyro_{}", gyro), (f"accel_{{}}_{gravity_in(accel)}", accel)]
    alone = [group for group in filter(may_turn, able) if list(group) == list(noisy)]
    return [("gyro_{}", alone[0])] if not ways and alone else []


def apart(one: Sequence[Part], other: Sequence[Part]) -> bool:
    return not {part.place for part in one} & {part.place for part in other}


def is_constant(norm: Floats) -> bool:
    return bool(np.std(norm) < AT_REST * np.mean(norm))


def gravity_in(group: Sequence[Part]) -> str:
    """The unit of an accelerometer at rest, by the norm of its axes; "" where it is none."""
    norm = norm_of(group)
    mean = float(np.mean(norm))
    unit = next((unit for unit, (low, high) in UNITS.items() if low < mean < high), "")
    counts = mean > COUNTED and all(guess.whole(one.values) for one in group)
    return (unit or ("counts" if counts else "")) if is_constant(norm) else ""


def may_turn(group: Sequence[Part]) -> bool:
    """May three columns be a gyro: they are not gravity, nor the field of the earth."""
    norm = norm_of(group)
    mean = float(np.mean(norm))
    field = any(low < mean < high for low, high in FIELDS)
    return not gravity_in(group) and not (is_constant(norm) and field)


def is_temperature(part: Part) -> bool:
    """Does a column change, little, within what a sensor at rest has in degC."""
    low, high = float(np.min(part.values)), float(np.max(part.values))
    return DEGREES[0] <= low < high <= DEGREES[1] and part.scatter < VARIES * high
