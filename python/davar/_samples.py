"""Checks samples, time stamps and gaps of the user, and splits them into runs without a gap."""

from typing import Any, NamedTuple

import numpy as np

# imported eagerly: a signal handler that needs it must not interrupt its lazy import
import numpy.ma as ma
import numpy.typing as npt

from ._types import Array, Floats

GAP_FACTOR = 1.5  # sample periods: a longer time step is a gap
WHOLE = (
    "window_max",
    "window_min",
    "segment",
    "grow",
    "shrink",
    "stride",
    "fit_every",
    "block",
    "shock_blocks",
    "bits",
)  # options
EXACT = 2**52  # up to here a double represents every whole number, and the difference of two


def array_of(name: str, value: npt.ArrayLike) -> Array:
    """The numbers of an argument, of any shape and with their mask. Raises ValueError with its
    name.
    """
    try:
        found = np.asanyarray(value)
    except (TypeError, ValueError, OverflowError) as why:
        raise ValueError(f"{name}: an array of numbers expected ({why})") from None
    if found.dtype.kind not in "iuf":
        raise ValueError(
            f"{name}: numbers expected, found {found.dtype if found.ndim else type(value).__name__}"
        )
    return found


def unmasked(name: str, value: npt.ArrayLike) -> Array:
    """Like array_of, for an argument that cannot have missing entries."""
    found = array_of(name, value)
    if ma.is_masked(found):
        raise ValueError(
            f"{name}: masked at {int(np.flatnonzero(ma.getmaskarray(found))[0])}; only x may "
            "have missing samples"
        )
    return np.asarray(found)


def samples(x: npt.ArrayLike, lsb: float | None, one: bool = False) -> tuple[Floats, bool]:
    """(x as float64, possibly x itself, NaN where it is masked; True if it has counts). one: a
    single sample is accepted too.
    """
    given = array_of("x", x)
    given = given.reshape(1) if one and given.ndim == 0 else given
    if given.ndim != 1:
        raise ValueError(
            f"x: one dimension expected, found shape {given.shape}"
            + ("; give one axis at a time, x[:, 0] or x[0]" if given.ndim else "")
        )
    counted = given.dtype.kind in "iu"
    if counted and lsb is None:
        raise ValueError(
            "lsb: needed for whole numbers, which are counts (deg/s per count); for "
            "rates, make x float"
        )
    masked = ma.getmaskarray(given) if ma.is_masked(given) else None
    values = np.ascontiguousarray(np.asarray(given), np.float64)
    if masked is not None:
        values = np.where(masked, np.nan, values)
    if given.dtype.kind in "iu" and given.dtype.itemsize > 4 and np.any(np.abs(values) > EXACT):
        raise ValueError("x: counts above 2^52 are not exact as doubles; subtract an offset first")
    if not counted and not finite(values) and np.isinf(values).any():
        raise ValueError(f"x: infinite at sample {int(np.flatnonzero(np.isinf(values))[0])}")
    return values, counted


def finite(values: Floats) -> bool:
    """True only if all are finite. It checks just the sum, which may overflow; then the result is
    False.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(values.sum()))


def stamps(time_s: npt.ArrayLike, count: int) -> Floats:
    found = unmasked("time_s", time_s)
    if found.shape != (count,):
        raise ValueError(
            f"time_s: {count} numbers expected, as many as x, found shape {found.shape}"
        )
    found = found.astype(np.float64)
    if not np.isfinite(found).all():
        raise ValueError(
            f"time_s: not a finite number at sample {int(np.flatnonzero(~np.isfinite(found))[0])}"
        )
    back = np.flatnonzero(np.diff(found) < 0)
    if len(back):
        raise ValueError(f"time_s: time runs backwards at sample {int(back[0]) + 1}")
    return found


def median_step(time_s: Floats) -> float:
    """The sample period, with davar-sim's rule. Raises ValueError."""
    steps = np.diff(time_s)
    if not len(steps):
        raise ValueError("time_s: only one sample: too short to determine the rate; give rate_hz")
    middle = (len(steps) - 1) // 2
    order = np.partition(steps, [middle, min(middle + 1, len(steps) - 1)])
    lower = order[middle]
    step = lower if len(steps) % 2 else lower + 0.5 * (order[middle + 1] - lower)
    if not step > 0:
        raise ValueError("time_s: the median time step is 0; give rate_hz")
    return float(step)


def lost(time_s: Floats, period_s: float, factor: float) -> Array:
    """The number of samples missing before each sample, from its time stamp."""
    steps = np.diff(time_s, prepend=time_s[:1])
    missing = np.maximum(np.floor(steps / period_s + 0.5) - 1, 1)
    return np.where(steps > factor * period_s, missing, 0).astype(np.int64)


def listed(gaps: npt.ArrayLike, count: int) -> Array:
    """The index list of gaps: the first sample after each gap."""
    found = unmasked("gaps", gaps)
    if found.shape == (0,):
        return np.zeros(0, np.int64)
    if found.ndim != 1 or found.dtype.kind not in "iu":
        raise ValueError(
            f"gaps: a list of sample indices expected, found shape {found.shape} of {found.dtype}"
        )
    wrong = found[(found < 1) | (found >= count)]
    if len(wrong):
        raise ValueError(
            f"gaps: an index from 1 to {count - 1} expected (the first sample after the gap), "
            f"found {int(wrong[0])}"
        )
    return found.astype(np.int64)


class Clock(NamedTuple):
    """Times of the samples. missing: samples lost before each (N); None: no losses."""

    rate_hz: float
    time_s: Floats | None
    missing: Array | None


def clock(
    count: int,
    rate_hz: float | None,
    time_s: npt.ArrayLike | None,
    gaps: npt.ArrayLike | None,
    factor: float,
) -> Clock:
    """The Clock for these arguments. Raises ValueError."""
    found = None if time_s is None else stamps(time_s, count)
    missing = None if gaps is None and found is None else np.zeros(count, np.int64)
    if gaps is not None and missing is not None:
        missing[listed(gaps, count)] = 1
    if found is None or missing is None:
        if rate_hz is None:
            raise ValueError("rate_hz: needed without time_s")
        return Clock(positive("rate_hz", rate_hz), None, missing)
    if not positive("gap", factor) > 1:
        raise ValueError(f"gap: a number above 1 expected, found {factor!r}")
    period_s = median_step(found) if rate_hz is None else 1 / positive("rate_hz", rate_hz)
    hz = 1 / period_s if rate_hz is None else float(rate_hz)
    return Clock(hz, found, np.maximum(missing, lost(found, period_s, float(factor))))


class There(NamedTuple):
    """The present samples. size: their number. places: their indices; None: all are present.
    missing: samples lost before each, NaN included; None: no losses.
    """

    size: int
    places: Array | None
    missing: Array | None

    def of(self, values: Floats) -> Floats:
        """Their values; for a complete record the original array."""
        return values if self.places is None else values[self.places]

    def place(self, i: int) -> int:
        return i if self.places is None else int(self.places[i])

    def starts(self) -> list[int]:
        """Start indices, among the present samples, of the runs without a gap. The first is 0."""
        if self.missing is None:
            return [0]
        return [0, *map(int, np.flatnonzero(self.missing[1:]) + 1)]

    def ends(self) -> npt.NDArray[np.uintp]:
        """Their ends."""
        return np.array([*self.starts()[1:], self.size], np.uintp)

    def offsets(self) -> list[tuple[int, int]]:
        """Where the offset of a place from its index changes: (index, offset). The first is 0."""
        if self.places is None:
            return [(0, 0)]
        starts = np.array(self.starts())
        return list(zip(starts.tolist(), (self.places[starts] - starts).tolist()))

    def without(self, torn: npt.NDArray[np.bool_]) -> "There":
        """The samples that stay. Both neighbours of a torn one do."""
        if not torn.any():
            return self
        kept = ~torn
        places = (np.arange(self.size) if self.places is None else self.places)[kept]
        missing = np.zeros(self.size, np.int64) if self.missing is None else self.missing.copy()
        missing[1:] += torn[:-1]
        return There(len(places), places, missing[kept])


def there(values: Floats, missing: Array | None) -> There:
    """missing: samples lost before each value. NaN values count as missing samples too."""
    absent = None if finite(values) else np.isnan(values)
    if absent is None or not absent.any():
        return There(len(values), None, missing)
    places = np.flatnonzero(~absent)
    if not len(places):
        return There(0, places, None)
    run = np.diff(places, prepend=-1) - 1
    return There(
        len(places),
        places,
        run
        if missing is None
        else np.maximum(run, np.maximum.reduceat(missing, np.append(0, places[:-1] + 1))),
    )


def text(name: str, value: Any) -> str:
    """An option's value as text for davar-sim. Raises ValueError."""
    if isinstance(value, str) or value is True:
        return str(value)
    try:
        if name in ("kurtosis", "contribution"):
            low, high = value
            return f"{float(low)!r}:{float(high)!r}"
        return str(whole(name, value)) if name in WHOLE else repr(float(value))
    except (TypeError, ValueError, OverflowError) as why:
        said = str(why)
        raise ValueError(
            said
            if said.startswith(f"{name}: ")
            else f"{name}: not an accepted value, found {value!r}"
        ) from None


def whole(name: str, value: Any) -> int:
    """A whole number of any type. Raises ValueError."""
    try:
        good = not isinstance(value, bool) and float(value) == int(value)
    except (TypeError, ValueError, OverflowError):
        good = False
    if not good:
        raise ValueError(f"{name}: a whole number expected, found {value!r}")
    return int(value)


def positive(name: str, value: Any) -> float:
    """A number above 0. Raises ValueError."""
    try:
        found = np.nan if isinstance(value, (bool, np.bool_)) else float(value)
    except (TypeError, ValueError, OverflowError):
        found = np.nan
    if not 0 < found < np.inf:
        raise ValueError(f"{name}: a finite number above 0 expected, found {value!r}")
    return found
