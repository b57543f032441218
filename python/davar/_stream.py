"""Samples in, epochs out: Stream, and a whole record through one."""

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _samples
from ._library import Run
from ._samples import Clock, There
from ._types import Array, Floats, Pair, Taus

WHOLE = ("epoch", "window_samples", "cut_age_samples", "gaps_in_window")
FLAGS = ("unstable", "alarm")
SCALES = (1e-40, 1e20)  # of rates that the library takes
BITS = 24  # of a count, unless bits says otherwise


class Epochs(dict[str, Array]):
    """Results over epochs: arrays of one length, by the names of davar-sim's columns, as items and as attributes.

    epoch (index of a sample in x: the centre of the window, or its newest sample when trailing), time_s, window_samples, kurtosis,
    contribution, unstable (bool), arw_deg_per_sqrt_h with arw_low_... and arw_high_... (95 %), bi_deg_per_h,
    rrw_deg_per_h_per_sqrt_h, rr_deg_per_h2, qn_deg; adev_M (deg/s) for each cluster size M. Policy glr: alarm (bool), cut_age_samples,
    dispersion. details=True: adev_low_M, adev_high_M (95 %), differences_M, gaps_in_window, arw_upper_... and companions (95 % upper
    bounds of what is absent). NaN: a value that the window cannot support. pandas.DataFrame(epochs) is a table.
    """

    def __getattr__(self, name: str) -> Array:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no column {name} (there are: {', '.join(self)})") from None

    @property
    def taus(self) -> Array:
        """Cluster sizes, samples (T)."""
        return np.array([int(name[5:]) for name in self if name.startswith("adev_") and name[5:].isdigit()])

    @property
    def adev(self) -> Floats:
        """Allan deviations, deg/s (epochs, T)."""
        return np.column_stack([self[f"adev_{m}"] for m in self.taus])


def kind_of(name: str) -> type:
    if name in FLAGS:
        return bool
    return np.int64 if name in WHOLE or name.startswith("differences_") else np.float64


def options_of(given: dict[str, Any]) -> dict[str, str]:
    """Options as davar-sim takes them; None stands for its default."""
    return {name: _samples.text(name, value) for name, value in given.items() if value is not None}


class Feed:
    """A run that is started, what it has been given, and the rows that wait."""

    def __init__(self, run: Run, rate_hz: float, stride: int) -> None:
        self.run, self.rate_hz, self.stride = run, rate_hz, stride
        self.given = 0  # samples, NaN included
        self.taken = 0  # samples that went in
        self.ahead = 0  # missing in front of the next one
        self.places: list[tuple[int, int]] = [(0, 0)]  # from this sample that went in on, its index is so much larger
        self.tables: list[Floats] = []

    def push(self, admitted: Floats, there: There, count: int) -> None:
        """The values that are there, as push takes them, among `count` that were given."""
        if not there.size:
            self.ahead += count
        else:
            first_missing = self.ahead + (0 if there.missing is None else int(there.missing[0]))
            self.ahead = count - 1 - there.place(there.size - 1)
            starts = there.starts()
            for first, last in zip(starts, [*starts[1:], there.size]):
                missing = first_missing if first == 0 or there.missing is None else int(there.missing[first])
                self._push_run(admitted[first:last], missing, self.given + there.place(first))
        self.given += count

    def _push_run(self, values: Floats, missing: int, index: int) -> None:
        if missing and self.taken:
            self.run.gap(missing)
        if index - self.taken != self.places[-1][1]:
            self.places.append((self.taken, index - self.taken))
        self.tables += self.run.push(values, self.stride)
        self.taken += len(values)

    @property
    def waiting(self) -> int:
        """Rows."""
        return sum(table.shape[1] for table in self.tables)

    def finish(self) -> None:
        self.tables += self.run.flush()

    def epochs(self, time_s: Floats | None = None) -> Epochs:
        """The rows that wait, which are then gone."""
        tables = self.tables or [np.empty((len(self.run.columns), 0))]
        self.tables = []
        found = Epochs((name, np.concatenate([table[i] for table in tables]).astype(kind_of(name), copy=False))
                       for i, name in enumerate(self.run.columns))
        starts, further = np.array(self.places).T
        found["epoch"] += further[np.searchsorted(starts, found["epoch"], side="right") - 1]
        found["time_s"] = found["epoch"] / self.rate_hz if time_s is None else time_s[found["epoch"]]
        return found


def admitted(run: Run, values: Floats, there: There, counted: bool) -> Floats:
    """The values that are there, as push takes them. Raises ValueError that names the sample."""
    found = values.copy() if there.places is None else there.of(values)
    bad = run.admit(found, counted)
    if bad is not None:
        raise ValueError(f"x: {run.reason()} at sample {there.place(bad)}, found {values[there.place(bad)]:.15g}")
    return found


def dynamic(x: npt.ArrayLike, rate_hz: float | None = None, *, time_s: npt.ArrayLike | None = None, gaps: npt.ArrayLike | None = None,
            gap: float = _samples.GAP_FACTOR, lsb: float | None = None, bits: int | None = None, arith: str | None = None,
            full_scale: float | None = None, policy: str | None = None, mode: str | None = None, window_max: int | None = None,
            window_min: int | None = None, segment: int | None = None, kurtosis: Pair | None = None, contribution: Pair | None = None,
            grow: int | None = None, shrink: int | None = None, taus: Taus | None = None, stride: int | None = None,
            false_alarms_per_hour: float | None = None, cut_interval: float | None = None, block: int | None = None,
            shock_blocks: int | None = None, details: bool = False) -> Epochs:
    """The dynamic Allan variance of a record: davar-sim's numbers, bit for bit.

    x: samples (N): rates, deg/s, as floats, or counts as integers (then lsb is needed). NaN: a sample that is missing.
    rate_hz: samples per second; may be left out when time_s is given: then the median time step decides.
    time_s: time stamps of x, seconds (N), ascending; a step above `gap` periods is a gap. As davar-sim --gap.
    gaps: indices of x, each the first sample behind a gap. No difference spans a gap.
    lsb: deg/s per count. Counts: the exact arithmetic of the device. Floats with lsb are rounded to counts; without, to
        the finest power of two that holds the record in 32 bits.
    The rest are davar-sim's options with its defaults (davar-sim --help): windows, segment, steps, stride and taus in samples;
    details: more columns; kurtosis=(K1, K2); contribution=(S1, S2); policy "fixed", "kurtosis", "or", "and", "glr"; mode "centred", "trailing"; arith "fixed",
    "float"; taus "octave", "geometric:N" or cluster sizes (at most 32).

    Returns Epochs: one entry per epoch in every array. Raises ValueError that names the argument.
    """
    given = options_of({"lsb": lsb, "bits": bits, "arith": arith, "full_scale": full_scale, "policy": policy, "mode": mode,
                        "window_max": window_max, "window_min": window_min, "segment": segment, "kurtosis": kurtosis,
                        "contribution": contribution, "grow": grow, "shrink": shrink, "taus": taus, "stride": stride,
                        "false_alarms_per_hour": false_alarms_per_hour, "cut_interval": cut_interval, "block": block,
                        "shock_blocks": shock_blocks, "details": details or None})
    values, counted = _samples.samples(x, lsb)
    clock = _samples.clock(len(values), rate_hz, time_s, gaps, gap)
    return whole_record(values, counted, clock, given).epochs(clock.time_s)


def whole_record(values: Floats, counted: bool, clock: Clock, given: dict[str, str]) -> Feed:
    """All samples through a run of these options, to its end."""
    run = Run(given)
    there = _samples.there(values, clock.missing)
    if there.size < max(run.needed, 1):
        raise ValueError(f"x: too short: {there.size} samples, one epoch needs at least {run.needed}")
    taken = admitted(run, values, there, counted)
    low, high = float(taken.min()), float(taken.max())
    if "lsb" not in given and max(high, -low) and not SCALES[0] < max(high, -low) < SCALES[1]:
        raise ValueError(f"x: a largest value from {SCALES[0]:g} to {SCALES[1]:g} expected, found {low:g} to {high:g}")
    run.start(clock.rate_hz, low, high)
    feed = Feed(run, clock.rate_hz, int(given.get("stride", 1)))
    feed.push(taken, there, len(values))
    feed.finish()
    if not feed.waiting:
        raise ValueError(f"x: too short: {there.size} samples give no epoch")
    return feed


class Stream:
    """The dynamic Allan variance of samples as they come, with the memory of its window only.

    rate_hz: samples per second. Either lsb (deg/s per count: exact, as on the device; bits 16, 24 or 32, default 24) or full_scale (deg/s:
    float samples, which saturate beyond it). The other options are those of dynamic(). Any division into pushes gives the same results.

        stream = davar.Stream(100.0, lsb=0.05, stride=100)
        for counts in blocks:
            stream.push(counts)
            print(stream.results().arw_deg_per_sqrt_h)
    """

    def __init__(self, rate_hz: float, *, lsb: float | None = None, full_scale: float | None = None, bits: int | None = None,
                 policy: str | None = None, mode: str | None = None, window_max: int | None = None, window_min: int | None = None,
                 segment: int | None = None, kurtosis: Pair | None = None, contribution: Pair | None = None, grow: int | None = None,
                 shrink: int | None = None, taus: Taus | None = None, stride: int | None = None,
                 false_alarms_per_hour: float | None = None, cut_interval: float | None = None, block: int | None = None,
                 shock_blocks: int | None = None, details: bool = False) -> None:
        if (lsb is None) == (full_scale is None):
            raise ValueError("lsb or full_scale: a stream needs one of them, for the range of what will come is not known")
        given = options_of({"lsb": lsb, "bits": bits, "full_scale": full_scale, "arith": "fixed" if full_scale is None else "float",
                            "policy": policy, "mode": mode, "window_max": window_max, "window_min": window_min, "segment": segment,
                            "kurtosis": kurtosis, "contribution": contribution, "grow": grow, "shrink": shrink, "taus": taus,
                            "stride": stride, "false_alarms_per_hour": false_alarms_per_hour, "cut_interval": cut_interval,
                            "block": block, "shock_blocks": shock_blocks, "details": details or None})
        hz, run = _samples.positive("rate_hz", rate_hz), Run(given)
        limit = 2.0 ** (int(given.get("bits", BITS)) - 1)
        run.start(hz, -limit, limit - 1)
        self._lsb, self._finished = lsb, False
        self._feed = Feed(run, hz, int(given.get("stride", 1)))

    def push(self, x: npt.ArrayLike) -> int:
        """Takes samples in: rates, deg/s, or counts (integers; with lsb), one or an array (n); NaN: a missing one. Returns how many epochs wait
        in results(). Raises ValueError, and nothing is taken in."""
        if self._finished:
            raise ValueError("x: the stream is finished")
        values, counted = _samples.samples(np.atleast_1d(np.asarray(x)), self._lsb)
        there = _samples.there(values, None)
        self._feed.push(admitted(self._feed.run, values, there, counted), there, len(values))
        return self._feed.waiting

    def gap(self, missing: int = 1) -> None:
        """Says that so many samples (>= 1) were lost in front of the next one; epoch does not count them."""
        if not isinstance(missing, (int, np.integer)) or missing < 1:
            raise ValueError(f"missing: a whole number from 1 on expected, found {missing!r}")
        self._feed.ahead += int(missing)

    def finish(self) -> int:
        """The record has ended: completes the epochs up to its mirrored end (mode "centred"). Returns how many epochs wait."""
        if not self._finished:
            self._finished = True
            self._feed.finish()
        return self._feed.waiting

    def results(self) -> Epochs:
        """The epochs completed since the last call, oldest first; they are then gone. epoch counts the samples pushed, from 0."""
        return self._feed.epochs()

    @property
    def health(self) -> dict[str, int]:
        """Counters so far: gaps, missing, saturated, restarts (windows thrown away) and others."""
        return self._feed.run.health()
