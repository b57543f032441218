"""The Allan deviation of a complete record."""

from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _samples, _taus
from ._library import adev_of, limits_of
from ._samples import Clock
from ._types import Array, Floats

SHORTEST, LONGEST = 2, 1 << 31  # samples
COUNT_BITS = 32  # of a sample in whole steps, if the sums have room for them
SUM_BITS = 128


class Adev(NamedTuple):
    """Arrays of one length (T), one entry per cluster size. NaN: the record is too short for the
    value.
    """

    taus_s: Floats
    """Averaging times, seconds."""
    adev: Floats
    """Overlapping Allan deviations, unit of x."""
    low: Floats
    """Lower limits of the 95 % intervals, also next to lines and in motion."""
    high: Floats
    """Upper limits."""
    n: Array
    """Numbers of differences in the estimates."""


def adev(
    x: npt.ArrayLike,
    rate_hz: float | None = None,
    taus: str | None = None,
    *,
    taus_s: npt.ArrayLike | None = None,
    clusters: npt.ArrayLike | None = None,
    data_type: Literal["freq", "phase"] = "freq",
    gaps: npt.ArrayLike | None = None,
    time_s: npt.ArrayLike | None = None,
    gap: float = _samples.GAP_FACTOR,
    lsb: float | None = None,
) -> Adev:
    """The overlapping Allan deviation of a record, with 95 % intervals.

    The sums are exact in integers. Floats are first rounded to 2^-31 or less of the largest
    distance from their mean. If N m^2 is above 2^64 for the largest size m (from 10^7 samples with
    "octave"), they are rounded to the bits that a sum of 128 bits leaves. Cost: O(N) per averaging
    time.

    Args:
        x: samples (N) of one axis, as floats, or as integer counts (which need lsb). NaN and masked
            entries are missing samples.
        rate_hz: samples per second. Optional with time_s; the default is then the median time step.
        taus: averaging times as a word: "octave" (1, 2, 4 ... samples, the default), "decade" (1,
            2, 4, 10, 20, 40 ...), "all" (every size), "geometric:K" (K sizes, evenly on a log
            scale). All end at a ninth of the record. Give one of taus, taus_s and clusters.
        taus_s: averaging times in seconds, ascending, up to half of the record, as in AllanTools.
            Each is rounded to a whole number of sample periods.
        clusters: averaging times in samples (tau_s * rate_hz), ascending, up to half of the record.
        data_type: "freq": x has rates or fractional frequencies, in any unit. "phase": x has their
            integral, in that unit times seconds. An angle in degrees gives deviations in deg/s, a
            time error in seconds gives fractional frequencies. Its N - 1 differences times rate_hz
            equal the input for "freq".
        gaps: indices of x: the first sample after each gap. No difference spans a gap.
        time_s: time stamps of x, seconds (N), ascending.
        gap: with time_s, a step longer than this many periods is a gap.
        lsb: unit of x per count. The deviations include the rounding to counts. If the noise is
            below half a count, the intervals are 0 to infinity.

    Returns:
        (taus_s, adev, low, high, n).

    Raises:
        ValueError: the message begins with the argument's name.
    """
    values, counted = _samples.samples(x, lsb)
    clock = _samples.clock(len(values), rate_hz, time_s, gaps, gap)
    unit = 1.0 if lsb is None else _samples.positive("lsb", lsb)
    if data_type == "phase":
        values, clock = differences(values, clock, 1.0 if counted else clock.rate_hz)
        unit *= clock.rate_hz
    elif data_type != "freq":
        raise ValueError(f"data_type: 'freq' or 'phase' expected, found {data_type!r}")
    there = _samples.there(values, clock.missing)
    if not SHORTEST <= there.size <= LONGEST:
        what = "samples" if data_type == "freq" else "differences of phase"
        raise ValueError(f"x: {SHORTEST} to {LONGEST} {what} expected, found {there.size}")
    sizes = _taus.of_record(_taus.wanted(clock.rate_hz, taus, clusters, taus_s), there.size)
    values = there.of(values)
    with np.errstate(over="ignore"):
        mean = float(values.mean())
    centre = mean if lsb is None else 0.0
    largest, most = (
        max(values.max() - centre, centre - values.min()),
        room(there.size, int(sizes[-1])),
    )
    if not np.isfinite(largest) or 0 < largest < 1e-290:
        raise ValueError("x: too large or too small for a double's range; use another unit")
    step = (
        finest(largest, min(2.0 ** (COUNT_BITS - 1), most))
        if lsb is None
        else 1.0
        if counted
        else unit
    )
    if largest / step > most:
        raise ValueError("x: counts too large for exact sums; make x float and omit lsb")
    ends = np.array([*there.starts()[1:], there.size], np.uintp)
    rows = adev_of(values, centre, step, ends, sizes)
    rows[0] *= unit if counted else 1.0
    low, high = limits_of(
        sizes,
        rows,
        there.size,
        clock.rate_hz,
        unit if lsb is not None and data_type == "freq" else 0.0,
    )
    times: Floats = np.divide(sizes, clock.rate_hz)
    return Adev(times, rows[0], low, high, rows[1].astype(np.int64))


def differences(phase: Floats, clock: Clock, factor: float) -> tuple[Floats, Clock]:
    """Differences of neighbouring samples times a factor, with their clock. A difference across a
    gap is missing.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        found: Floats = np.multiply(np.diff(phase), factor)
    if clock.missing is not None:
        found[clock.missing[1:] > 0] = np.nan
    if np.isinf(found).any():
        raise ValueError("x: too large or too small for a double's range; use another unit")
    return found, Clock(clock.rate_hz, None, None)


def room(count: int, m: int) -> float:
    """The limit of a sample's magnitude in steps below which all sums of squares are exact: count
    (2 m)^2 magnitude^2 <= 2^128.
    """
    return 2.0 ** ((SUM_BITS - int(np.ceil(np.log2(count * 4.0 * m * m)))) // 2)


def finest(largest: float, most: float) -> float:
    """The smallest power of two that divides magnitudes up to `largest` into at most `most` steps
    (`most` is also a power of two).
    """
    return float(2.0 ** (np.frexp(largest)[1] - np.log2(most))) if largest > 0 else 1.0
