"""The Allan deviation of a whole record: one window of the C core that holds all of it."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _samples
from ._stream import whole_record
from ._types import Array, Floats, Taus

SHORTEST, LONGEST = 4, 1 << 24  # samples of a window


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

    x: samples (N, 4 to 2^24): rates or fractional frequencies in any unit, as floats, or counts as integers (then lsb is needed). NaN: a sample
        that is missing. Not phase: its differences are what goes in here.
    rate_hz: samples per second; may be left out when time_s is given.
    taus: "octave" (1, 2, 4 ... up to a ninth of the record), "geometric:K" (K sizes, evenly on a log scale), or cluster sizes in samples
        (tau_s * rate_hz), ascending, at most 32 and N / 2.
    gaps, time_s, gap, lsb: as for dynamic(). No difference spans a gap.

    Returns (taus_s, adev, low, high, n). Sums are exact in integers: floats are first rounded to 2^-31 of the largest distance from their
    mean. Raises ValueError that names the argument.
    """
    values, counted = _samples.samples(x, lsb)
    stamps = None if time_s is None else _samples.stamps(time_s, len(values))
    there = int(np.count_nonzero(~np.isnan(values)))
    if not SHORTEST <= there <= LONGEST:
        raise ValueError(f"x: {SHORTEST} to {LONGEST} samples expected, found {there}")
    if lsb is None:
        values -= np.nanmean(values)
    scale = {} if lsb is None else {"lsb": lsb, "bits": 32}
    given = {name: _samples.text(name, value) for name, value in {
        **scale, "taus": taus, "policy": "fixed", "mode": "trailing", "window_max": there, "window_min": there, "segment": 0, "grow": 1, "stride": there}.items()}
    feed = whole_record(values, counted, rate_hz, stamps, gaps, gap, given)
    if feed.run.health()["restarts"]:
        raise ValueError("gaps: more than 65535")
    found = feed.epochs()
    sizes = found.taus

    def row(name: str) -> Array:
        return np.array([found[f"{name}_{m}"][0] for m in sizes])
    return Adev(sizes / feed.rate_hz, row("adev"), row("adev_low"), row("adev_high"), row("differences"))
