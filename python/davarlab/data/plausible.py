"""Rates, units and levels that no gyro has: found before anything is fitted, each with what it
may be instead (DESIGN 13)."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ..arrays import Bools, Floats
from ..tables import guess
from ..tables.constants import LSB_DPS
from ..thresholds import PLAUSIBLE
from . import motion, signals
from .recording import Recording

KIND = "implausible"  # of the observation
CONFIRM = "--as-recorded"  # with which a user says that all of it is right


def doubts(
    columns: Mapping[str, Floats],
    rate_hz: float,
    known: Bools | None,
    gyros: Iterable[str],
    whole: bool = False,
) -> list[str]:
    """What is implausible about a recording, a sentence each with the next step. columns: name ->
    numbers in the unit of the name; known: True where a sample is there, None: everywhere; gyros:
    the names of the gyro columns to look at; whole: their log rounds to whole units. Cost: a few
    passes over the first `looked_at` samples."""
    there = slice(None) if known is None else known[: PLAUSIBLE.looked_at]
    columns = {name: column[: PLAUSIBLE.looked_at][there] for name, column in columns.items()}
    gyros = list(gyros)
    found = [rate(rate_hz)]
    if not all(map(len, columns.values())):  # nothing is left there
        return [said for said in found if said]
    counts = [
        name
        for name in (() if whole else gyros)
        if counted(columns[name]) and not level(name, columns[name])
    ]
    for name in gyros:
        x = columns[name]
        tests = level(name, x), noise(name, x, rate_hz), radians(name, x)
        found += [said for said in tests if said and name not in counts][:1]
    found.append(of_counts(counts))
    return [said for said in (*found, temperature(columns), gravity(columns)) if said]


def of_recording(recording: Recording, columns: Iterable[str] | None = None) -> list[str]:
    """The doubts about a recording and some of its gyro columns, all without any; none where its
    user has said that it is right."""
    if recording.as_recorded:
        return []
    gyros = [name for name in columns or recording.columns if name.endswith(("_dps", "_rad_s"))]
    unsure = [one for of, one in recording.doubts.items() if of != "gyro" or gyros]
    rate_hz = recording.read_hz or recording.rate_hz
    whole = bool(guess.BLACKBOX.search(recording.notes.get("source", "")))
    return [*unsure, *doubts(recording.columns, rate_hz, recording.known, gyros, whole)]


def note(columns: Mapping[str, Floats], rate_hz: float) -> str | None:
    """A note on a possible mistake, or None. It changes no verdict, because a log with one sample
    per 10 s has the same stamps."""
    said = stamps(columns.get("time_s"), rate_hz)
    return said and f"note: {said}"


def unit_of_time(rate_hz: float) -> str | None:
    """The unit that gives a likely rate for stamps that were read as seconds; None without one."""
    return next(
        (
            unit
            for unit in ("ms", "us", "ns")
            if PLAUSIBLE.likely_hz[0] <= rate_hz / guess.SECONDS[unit] <= PLAUSIBLE.likely_hz[1]
        ),
        None,
    )


def rate(rate_hz: float) -> str | None:
    if PLAUSIBLE.rates_hz[0] <= rate_hz <= PLAUSIBLE.rates_hz[1]:
        return None
    unit = unit_of_time(rate_hz)
    instead = (
        f"If the time is in {unit}, the rate is {rate_hz / guess.SECONDS[unit]:.5g} Hz: use --unit "
        f"time={unit}"
        if unit
        else "Check the unit of the time (--unit time=UNIT) or --rate"
    )
    return (
        f"implausible sample rate {rate_hz:.4g} Hz (gyros: {PLAUSIBLE.rates_hz[0]:g} Hz to "
        f"{PLAUSIBLE.rates_hz[1] / 1e3:g} kHz). {instead}"
    )


def stamps(time: Floats | None, rate_hz: float) -> str | None:
    """Whole numbers spaced as milliseconds would be."""
    if time is None or not PLAUSIBLE.rates_hz[0] <= rate_hz <= PLAUSIBLE.whole_hz * 1.001:
        return None
    unit = unit_of_time(rate_hz)
    if not unit or np.any(time != np.round(time)):
        return None
    return (
        f"the time stamps are whole numbers, {1 / rate_hz:.4g} apart. If they are in {unit}, the "
        f"rate is {rate_hz / guess.SECONDS[unit]:.5g} Hz and not {rate_hz:.4g} Hz: use --unit "
        f"time={unit}"
    )


def in_dps(name: str) -> float:
    return guess.RATES["rad/s"] if name.endswith("_rad_s") else 1.0


def level(name: str, x: Floats) -> str | None:
    rms = float(np.sqrt(np.mean(np.square(x, dtype=np.float64)))) * in_dps(name)
    return (
        f"column {name}: implausible level {rms:.4g} deg/s rms (gyros: up to "
        f"{PLAUSIBLE.level_dps:g}). Use --unit gyro=UNIT. For counts, UNIT is the deg/s per count"
        if rms > PLAUSIBLE.level_dps
        else None
    )


def counted(x: Floats) -> bool:
    return bool(np.ptp(x) > 2 and np.all(x == np.round(x)))


def of_counts(names: Sequence[str]) -> str | None:
    return (
        f"column{'s' * (len(names) > 1)} {', '.join(names)}: all values are whole numbers, as "
        "counts are. Use --unit gyro=FACTOR, with the deg/s per count of the data sheet"
        if names
        else None
    )


def noise(name: str, x: Floats, rate_hz: float) -> str | None:
    """The scatter of neighbouring samples, as if all of it were white noise."""
    if len(x) < PLAUSIBLE.noise_samples:
        return None
    x = np.asarray(x, np.float64)
    per_sample = float(np.sqrt(np.median(motion.averaged(np.diff(x) ** 2 / 2, 256)))) * in_dps(name)
    arw = 60 * per_sample / np.sqrt(rate_hz)
    if not per_sample or PLAUSIBLE.arw[0] <= arw <= PLAUSIBLE.arw[1]:
        return None
    return (
        f"column {name}: implausible noise {arw:.3g} deg/sqrt(h) (gyros: {PLAUSIBLE.arw[0]:g} to "
        f"{PLAUSIBLE.arw[1]:g}). Check its unit (--unit gyro=UNIT) and the sample rate"
    )


def near(step: float, known: Iterable[float]) -> bool:
    return any(abs(step / one - 1) < PLAUSIBLE.count_near for one in known)


def radians(name: str, x: Floats) -> str | None:
    """Counts whose size matches a known sensor in the other unit, but none in the unit of the
    name."""
    step = signals.count_of(np.asarray(x, np.float64))
    deg = guess.RATES["rad/s"]
    if not step:
        return None
    if name.endswith("_rad_s"):
        other, own, unit = near(step, LSB_DPS), near(step * deg, LSB_DPS), "deg/s"
    else:
        other, own, unit = near(step * deg, LSB_DPS), near(step, LSB_DPS), "rad/s"
    return (
        f"column {name}: its counts of {step:.4g} match a known sensor in {unit}. If the unit is "
        f"{unit}, use --unit gyro={unit}"
        if other and not own
        else None
    )


def temperature(columns: Mapping[str, Floats]) -> str | None:
    for name, values in columns.items():
        if (
            name.startswith("temp")
            and name.endswith("_degC")
            and not PLAUSIBLE.temperatures[0]
            <= float(np.median(values))
            <= PLAUSIBLE.temperatures[1]
        ):
            return (
                f"column {name}: implausible temperature {float(np.median(values)):.4g} degC "
                f"({PLAUSIBLE.temperatures[0]:g} to {PLAUSIBLE.temperatures[1]:g}). Use --unit "
                "temp=UNIT. For counts, UNIT is the degC per count"
            )
    return None


def gravity(columns: Mapping[str, Floats]) -> str | None:
    """Three axes at rest measure 1 g; other units are near 9.8 or far above any range."""
    axes = [columns[name] for name in ("accel_x_g", "accel_y_g", "accel_z_g") if name in columns]
    if len(axes) < 3:
        return None
    norm = float(np.median(np.sqrt(sum(np.square(one, dtype=np.float64) for one in axes))))
    unit = "m/s^2" if 8.8 < norm < 10.8 else "mg" if 880 < norm < 1080 else ""
    if not unit and norm < 100:
        return None
    return (
        f"columns accel_x_g, accel_y_g, accel_z_g: their norm is {norm:.4g} g, but at rest it must "
        f"be 1 g. Use --unit accel={unit or 'FACTOR'}"
    )
