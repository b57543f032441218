"""The Allan deviation of a whole record."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _samples
from ._library import TAUS_MAX, adev_of, taus_of
from ._types import Array, Floats, Taus

SHORTEST, LONGEST = 2, 1 << 31  # samples
COUNT_BITS = 32  # of a sample in whole steps, where the sums have room for them
SUM_BITS = 128


class Adev(NamedTuple):
    """Arrays of one length (T), one entry per cluster size. NaN: the record cannot support it."""
    taus_s: Floats  #: averaging times, seconds
    adev: Floats  #: overlapping Allan deviation, unit of x
    low: Floats  #: 95 % interval, from the degrees of freedom of the noise mix that was found
    high: Floats
    n: Array  #: differences that the estimate rests on


def adev(x: npt.ArrayLike, rate_hz: float | None = None, taus: Taus = "octave", gaps: npt.ArrayLike | None = None, *,
         time_s: npt.ArrayLike | None = None, gap: float = _samples.GAP_FACTOR, lsb: float | None = None) -> Adev:
    """The overlapping Allan deviation of a record, with 95 % intervals.

    x: samples (N): rates or fractional frequencies in any unit, as floats, or counts as integers (then lsb is needed). NaN: a sample that is
        missing. Not phase: its differences are what goes in here.
    rate_hz: samples per second; may be left out when time_s is given: then the median time step decides.
    taus: "octave" (1, 2, 4 ... up to a ninth of the record), "geometric:K" (K sizes, evenly on a log scale), or cluster sizes in samples
        (tau_s * rate_hz), ascending, at most 32 and up to N / 2.
    gaps: indices of x, each the first sample behind a gap. time_s: time stamps of x, seconds (N), ascending; a step above `gap` periods is a
        gap. No difference spans a gap.
    lsb: unit of x per count.

    Returns (taus_s, adev, low, high, n). The sums are exact in integers: floats are first rounded to 2^-31 or less of the largest distance from
    their mean (where N m^2 is above 2^64 for the largest size m, as from 10^7 samples on with "octave", to as many bits as 128 of the sum
    leave). Raises ValueError that names the argument.
    """
    values, counted = _samples.samples(x, lsb)
    clock = _samples.clock(len(values), rate_hz, time_s, gaps, gap)
    there = _samples.there(values, clock.missing)
    if not SHORTEST <= there.size <= LONGEST:
        raise ValueError(f"x: {SHORTEST} to {LONGEST} samples expected, found {there.size}")
    sizes = cluster_sizes(taus, there.size)
    values = there.of(values)
    with np.errstate(over="ignore"):
        mean = float(values.mean())
    centre, unit = (mean, 1.0) if lsb is None else (0.0, _samples.positive("lsb", lsb))
    largest, most = max(values.max() - centre, centre - values.min()), room(there.size, int(sizes[-1]))
    if not np.isfinite(largest) or 0 < largest < 1e-290:
        raise ValueError("x: too large or too small for a double's range; take another unit")
    step = finest(largest, min(2.0 ** (COUNT_BITS - 1), most)) if lsb is None else 1.0 if counted else unit
    if largest / step > most:
        raise ValueError("x: counts too large for exact sums; make x float and leave lsb out")
    ends = np.array([*there.starts()[1:], there.size], np.uintp)
    rows = adev_of(values, centre, step, ends, sizes, clock.rate_hz)
    rows[:3] *= unit if counted else 1.0
    return Adev(sizes / clock.rate_hz, rows[0], rows[1], rows[2], rows[3].astype(np.int64))


def room(count: int, m: int) -> float:
    """Below which the magnitude of a sample in steps keeps every sum of squares exact: count (2 m)^2 magnitude^2 <= 2^128."""
    return 2.0 ** ((SUM_BITS - int(np.ceil(np.log2(count * 4.0 * m * m)))) // 2)


def finest(largest: float, most: float) -> float:
    """The finest power of two of which no magnitude up to `largest` holds more than `most`, a power of two too."""
    return float(2.0 ** (np.frexp(largest)[1] - np.log2(most))) if largest > 0 else 1.0


def cluster_sizes(taus: Taus, count: int) -> npt.NDArray[np.uint32]:
    """As the library counts them. Raises ValueError."""
    if isinstance(taus, str):
        word, _, number = taus.partition(":")
        wanted = {"octave": "0", "geometric": number or "12"}.get(word, "")
        is_number = wanted.isascii() and wanted.isdigit()
        if not is_number or int(wanted) > TAUS_MAX or (word == "octave" and number) or (word == "geometric" and int(wanted) < 1):
            raise ValueError(f"taus: 'octave', 'geometric:K' with K from 1 to {TAUS_MAX}, or cluster sizes expected, found {taus!r}")
        return taus_of(count, int(wanted))
    found = [_samples.whole("taus", one) for one in np.atleast_1d(np.asarray(taus)).ravel().tolist()]
    if not 1 <= len(found) <= TAUS_MAX:
        raise ValueError(f"taus: 1 to {TAUS_MAX} cluster sizes expected, found {len(found)}")
    if any(b <= a for a, b in zip(found, found[1:])):
        raise ValueError("taus: cluster sizes must ascend")
    if not 1 <= found[0] <= found[-1] <= count // 2:
        raise ValueError(f"taus: cluster sizes from 1 to {count // 2} samples (half of x) expected, found {found[0]} to {found[-1]}")
    return np.array(found, np.uint32)
