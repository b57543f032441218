"""Samples in, epochs out: Stream, and a complete record in one call."""

import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from . import _samples, _taus
from ._library import Run, torn_of
from ._model import model_of
from ._samples import Clock, There
from ._types import Array, Floats, Pair, Path

P = ParamSpec("P")
R = TypeVar("R")
WHOLE = (
    "epoch",
    "window_samples",
    "cut_age_samples",
    "steady_samples",
    "gaps_in_window",
    "floor_why",
)
FLAGS = ("unstable", "alarm", "coarse", "filtered")
SCALES = (1e-40, 1e20)  # range of rates that the library accepts
FEW = 20  # chance withholds fewer than one result in so many; davar-sim has the same limit
PART = 1 << 14  # rows that are converted together
BITS = 24  # width of a count, unless bits is given


class Epochs(dict[str, Array]):
    """Results over epochs: arrays of one length, named like davar-sim's columns, as items and as
    attributes. NaN: the window cannot support the value. pandas.DataFrame(epochs) is a table.

    - `epoch`: index of a sample in x: the centre of the window, or its newest sample (trailing).
    - `time_s`, `window_samples`, `kurtosis`, `contribution`, `unstable` (bool).
    - `arw_deg_per_sqrt_h` with `arw_low_...` and `arw_high_...` (95 %), `bi_deg_per_h`,
      `rrw_deg_per_h_per_sqrt_h`, `rr_deg_per_h2`, `qn_deg`.
    - `filtered` (bool): the short cluster sizes read low, as after a low-pass, so the coefficients
      are withheld; give bandwidth.
    - `adev_M` (deg/s) for each cluster size M.
    - Law glr: `alarm` (bool), `cut_age_samples`, `dispersion`, `change_m`, `change_older`,
      `change_newer`, `change_gain`, `young`, and the level since the last alarm with an interval
      for every moment: `steady_samples`, `steady`, `steady_low`, `steady_high` (deg/s).
    - details=True: `adev_low_M`, `adev_high_M` (95 %), `differences_M`, `gaps_in_window`, `coarse`
      (bool: the noise is below half a count, so rounding hides the coefficients), `arw_upper_...`
      and similar columns (95 % upper bounds of absent coefficients).
    - floor=True: `floor_deg_per_sqrt_h` with `floor_low_...` and `floor_high_...` (95 %), and
      `floor_why`: 0, or why there is no value (docs/FLIGHT.md).
    - model_table: `model_health`, `model_deviation_M`.
    """

    rate_hz: float
    """Samples per second."""
    bandwidth: str | None = None
    """The filter that dynamic(bandwidth="auto") learned, as a value of bandwidth. None: unknown."""
    torn_reads: int = 0
    """The samples that dynamic(skip_torn_reads=True) skipped."""

    def __getattr__(self, name: str) -> Array:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no column {name} (the columns are: {', '.join(self)})") from None

    @property
    def clusters(self) -> Array:
        """Cluster sizes, samples (T)."""
        return np.array(
            [int(name[5:]) for name in self if name.startswith("adev_") and name[5:].isdigit()]
        )

    @property
    def taus_s(self) -> Floats:
        """Averaging times, seconds (T)."""
        return np.asarray(self.clusters / self.rate_hz, np.float64)

    @property
    def adev(self) -> Floats:
        """Allan deviations, deg/s (epochs, T)."""
        return np.column_stack([self[f"adev_{m}"] for m in self.clusters])


def kind_of(name: str) -> type:
    return np.int64 if name in WHOLE or name.startswith("differences_") else np.float64


# Options of dynamic() and Stream that are passed to davar-sim unchanged, by their common name.
OPTIONS = (
    "lsb",
    "bits",
    "arith",
    "full_scale",
    "bandwidth",
    "law",
    "mode",
    "window_max",
    "window_min",
    "segment",
    "kurtosis",
    "contribution",
    "unstable_rate",
    "grow",
    "shrink",
    "longest_tau_s",
    "stride",
    "engine",
    "fit_every",
    "false_alarms_per_hour",
    "cut_interval",
    "block",
    "shock_blocks",
)


def takes_old_names(call: Callable[P, R]) -> Callable[P, R]:
    """Takes `policy` for `law`. Names the replacement of an option that no longer exists."""

    @wraps(call)
    def checked(*arguments: P.args, **named: P.kwargs) -> R:
        if "long_cluster" in named:
            raise ValueError(
                "long_cluster: removed; use longest_tau_s to see slow changes of the noise"
            )
        if named.get("policy") is not None and named.get("law") is not None:
            raise ValueError("law or policy: give one; policy is the old name of law")
        if "policy" in named:
            named["law"] = named.pop("policy")
        return call(*arguments, **named)

    return checked


def run_of(given: dict[str, Any], rate_hz: float) -> Run:
    """A run with the options among these arguments; None means davar-sim's default. Raises
    ValueError.
    """
    options = {
        name: _samples.text(name, given[name]) for name in OPTIONS if given[name] is not None
    }
    what = _taus.wanted(rate_hz, given["taus"], given["clusters"], given["taus_s"])
    run = Run(
        {
            **options,
            "taus": _taus.option(what),
            **{name: "" for name in ("details", "floor", "skip_torn_reads") if given.get(name)},
        },
        what.name,
    )
    if given["model_table"] is not None:
        run.model(*model_of(given["model_table"], rate_hz))
    return run


def column_of(name: str, values: Floats) -> Array:
    """A column of a table, in its own memory where its entries have the same size."""
    if name in FLAGS:
        return np.asarray(values > 0)
    if kind_of(name) is np.float64:
        return values
    whole = values.view(np.int64)
    for first in range(0, len(values), PART):
        whole[first : first + PART] = values[first : first + PART].astype(np.int64)
    return whole


class Feed:
    """A started run, the number of its samples, and the waiting rows."""

    def __init__(self, run: Run, rate_hz: float, stride: int) -> None:
        self.run, self.rate_hz, self.stride = run, rate_hz, stride
        self.given = 0  # samples, NaN included
        self.taken = 0  # samples pushed
        self.ahead = 0  # samples missing before the next one
        self.places: list[tuple[int, int]] = [
            (0, 0)
        ]  # (index of a pushed sample, offset of the record's index from there onward)
        self.bandwidth: str | None = None  # learned
        self.torn_reads = 0  # skipped

    def push(self, admitted: Floats, there: There, count: int) -> None:
        """The present values among `count` samples, as input of push."""
        if not there.size:
            self.ahead += count
        else:
            first_missing = self.ahead + (0 if there.missing is None else int(there.missing[0]))
            self.ahead = count - 1 - there.place(there.size - 1)
            starts = there.starts()
            for first, last in zip(starts, [*starts[1:], there.size]):
                missing = (
                    first_missing
                    if first == 0 or there.missing is None
                    else int(there.missing[first])
                )
                self._push_run(admitted[first:last], missing, self.given + there.place(first))
        self.given += count

    def whole(self, admitted: Floats, there: There, count: int) -> None:
        """The same for a complete record, with its end."""
        if self.stride == 1 and self.run.slide(admitted, there.ends()):
            self.places = there.offsets()
        else:
            self.push(admitted, there, count)
            self.run.flush()

    def _push_run(self, values: Floats, missing: int, index: int) -> None:
        if missing and self.taken:
            self.run.gap(missing)
        if index - self.taken != self.places[-1][1]:
            self.places.append((self.taken, index - self.taken))
        self.run.push(values, self.stride)
        self.taken += len(values)

    @property
    def waiting(self) -> int:
        """Rows."""
        return self.run.waiting

    def finish(self) -> None:
        self.run.flush()

    def epochs(self, time_s: Floats | None = None) -> Epochs:
        """Returns and clears the waiting rows."""
        tables = self.run.rows()
        table = tables[0] if len(tables) == 1 else np.concatenate(tables, axis=1)
        found = Epochs((name, column_of(name, table[i])) for i, name in enumerate(self.run.columns))
        found.rate_hz, found.bandwidth = self.rate_hz, self.bandwidth
        found.torn_reads = self.torn_reads
        starts, further = np.array(self.places).T
        first = np.searchsorted(found["epoch"], starts[1:])  # of the epochs from each place on
        found["epoch"] += np.repeat(further, np.diff(first, prepend=0, append=len(found["epoch"])))
        if time_s is None:
            np.divide(found["epoch"], self.rate_hz, out=found["time_s"])
        else:
            np.take(time_s, found["epoch"], out=found["time_s"])
        return found


def admitted(run: Run, values: Floats, there: There, counted: bool) -> Floats:
    """The present values, as input of push. Raises ValueError with the sample's index."""
    # x itself is copied; counts are not x, but its conversion.
    found = there.of(values) if counted or there.places is not None else values.copy()
    bad = run.admit(found, counted)
    if bad is not None:
        raise ValueError(
            f"x: {run.reason()} at sample {there.place(bad)}, found {values[there.place(bad)]:.15g}"
        )
    return found


@takes_old_names
def dynamic(
    x: npt.ArrayLike,
    rate_hz: float | None = None,
    *,
    time_s: npt.ArrayLike | None = None,
    gaps: npt.ArrayLike | None = None,
    gap: float = _samples.GAP_FACTOR,
    skip_torn_reads: bool = False,
    lsb: float | None = None,
    bits: int | None = None,
    arith: str | None = None,
    full_scale: float | None = None,
    bandwidth: float | str | None = None,
    law: str | None = None,
    mode: str | None = None,
    window_max: int | None = None,
    window_min: int | None = None,
    segment: int | None = None,
    kurtosis: Pair | None = None,
    contribution: Pair | None = None,
    unstable_rate: float | None = None,
    grow: int | None = None,
    shrink: int | None = None,
    taus: str | None = None,
    clusters: npt.ArrayLike | None = None,
    taus_s: npt.ArrayLike | None = None,
    longest_tau_s: float | None = None,
    stride: int | None = None,
    engine: str | None = None,
    fit_every: int | None = None,
    false_alarms_per_hour: float | None = None,
    cut_interval: float | None = None,
    block: int | None = None,
    shock_blocks: int | None = None,
    model_table: Path | None = None,
    floor: bool = False,
    details: bool = False,
) -> Epochs:
    """The dynamic Allan variance of a record: davar-sim's numbers, bit for bit.

    The options and their defaults are those of davar-sim (davar-sim --help).

    Args:
        x: samples (N) of one axis: rates, deg/s, as floats, or integer counts (which need lsb). NaN
            and masked entries are missing samples.
        rate_hz: samples per second. Optional with time_s; the default is then the median time step.
        time_s: time stamps of x, seconds (N), ascending.
        gaps: indices of x: the first sample after each gap. No difference spans a gap.
        gap: with time_s, a step longer than this many periods is a gap.
        skip_torn_reads: skip torn register reads, single samples that jump by a power of two in
            counts and back. Each becomes a missing sample; the attribute torn_reads of the result
            is their number. Needs lsb.
        lsb: deg/s per count. Counts use the exact arithmetic of the device. Floats are rounded to
            counts of lsb, or by default of the smallest power of two with which the record fits 32
            bits.
        bits: width of a count: 16, 24 (default) or 32. A larger value is an error. Needs lsb.
        arith: "fixed" (default): integer counts. "float": float32 samples.
        full_scale: with arith="float": larger samples, deg/s, saturate. By default a power of two
            that covers the record.
        bandwidth: the filter between the gyro and x, as davar-sim takes it: "HZ:ORDER:PERCENT",
            an analogue low-pass (-3 dB in Hz as in the data sheet; 1 or 2 poles, default 2; known
            to 10 %); "biquad:HZ", "pt1:HZ", "notch:HZ:Q", digital ones at the sample rate;
            "average:N"; "cic:N", every N-th sample of it; "sum:N", sums of N counts;
            "ba:B0,B1,..:A1,A2,..", coefficients; several with "+" between them; or "none", white
            noise. "auto" learns it from the whole record, which needs 4352 samples at rest; the
            attribute bandwidth of the result is what was found. Default: unknown, and results that
            a filter could falsify are withheld (NaN, and True in the column `filtered`), with a
            warning if they are more than a few. Law glr whitens for it.
        law: rule for the length of the window: "fixed", "kurtosis", "or" (default), "and",
            "glr".
        mode: the epoch is the centre of the window ("centred", the default without glr) or its
            newest sample ("trailing", the default with glr, which has no other).
        window_max: longest window, samples. Default 600; glr: 600 blocks.
        window_min: shortest window, samples. Default 2/3 of the longest; glr: 2 blocks.
        segment: short segment of the contribution test, samples. Default 1/6 of the longest window;
            glr: 0.
        kurtosis: stable range (K1, K2) of the kurtosis. Default (2.5, 3.3).
        contribution: stable range (S1, S2) of the sliding contribution. Default (0, 0.07).
        unstable_rate: instead of both ranges: the share of windows of unchanged noise that may be
            unstable, 0.0001 to 0.1, for every length of the window and for the filter of bandwidth.
        grow: growth of the window, samples per sample. Default 2; trailing: 1.
        shrink: its shrinkage, samples per sample. Default 2; glr shrinks by at least 64.
        taus: cluster sizes as a word: "octave" (default) or "geometric:K". At most 32, up to half a
            window. Give one of taus, clusters and taus_s.
        clusters: cluster sizes in samples (tau_s * rate_hz), ascending, as in davar-sim --taus
            N,N,...
        taus_s: averaging times in seconds, ascending, each rounded to a whole number of sample
            periods.
        longest_tau_s: adds averaging times beyond the window, in octaves up to so many seconds,
            for minutes to days. The first is twice the largest cluster size of the window, or the
            next octave that is a multiple of 4 and at least 64 samples. All together at most 32.
            Each remembers its last 34 to 66 clusters, up to the newest sample pushed (also with
            mode="centred"). One fit to the whole curve gives the coefficients. It takes 6 to 30 us,
            so choose a stride.
        stride: one epoch every so many samples. Default 1.
        engine: "auto" (default) or "grid", for a stride above 1: equal results, different cost.
        fit_every: fit only every N-th epoch: a fit takes most of the time of an epoch. In the
            others the coefficients and intervals are NaN, and the flags `filtered` and `coarse` are
            False. 0: no fit, and none of these columns. Default 1.
        false_alarms_per_hour: glr: accepted false alarms per hour of unchanged noise. Default 0.01.
        cut_interval: glr: accepted mean time between false cuts, seconds. Default 300.
        block: glr: samples per block. Default 10.
        shock_blocks: glr: longest shock, blocks. Default 2.
        model_table: file of an error model (`davarlab export MODEL -o TABLE.csv`), to compare each
            result with.
        floor: adds the noise between rotor lines and motion, while the vehicle moves. It is that of
            the newest 1056 samples (below 800 Hz: 544) at the epoch. Needs bandwidth: the filter,
            or "none".
        details: adds columns.

    Returns:
        One entry per epoch in every array.

    Raises:
        ValueError: the message begins with the argument's name.
    """
    given = locals()
    values, counted = _samples.samples(x, lsb)
    clock = _samples.clock(len(values), rate_hz, time_s, gaps, gap)
    found = whole_record(values, counted, clock, given).epochs(clock.time_s)
    if fit_every == 0:
        return found
    withheld, fitted = int(found.filtered.sum()), -(-len(found.filtered) // int(fit_every or 1))
    if withheld * FEW > fitted:
        known = bandwidth is not None and (bandwidth != "auto" or found.bandwidth is not None)
        warnings.warn(
            f"{withheld} of {fitted} results withheld: the short cluster sizes "
            + ("contradict the filter. Check" if known else "read low, as after a low-pass. Give")
            + ' bandwidth (data sheet: LPF, -3 dB; or "auto" for a record at rest; or "none"). '
            "A vibration tone has the same effect",
            stacklevel=3,  # the caller of the wrapper
        )
    return found


def require(samples: int, needed: int) -> None:
    """Raises ValueError if the record is too short."""
    if samples < max(needed, 1):
        raise ValueError(f"x: too short: {samples} samples, but one epoch needs at least {needed}")


def whole_record(values: Floats, counted: bool, clock: Clock, given: dict[str, Any]) -> Feed:
    """Runs all samples with these options, to the end of the record."""
    run = run_of(given, clock.rate_hz)
    there = _samples.there(values, clock.missing)
    require(there.size, run.needed)
    taken = admitted(run, values, there, counted)
    low, high = float(taken.min()), float(taken.max())
    if given["lsb"] is None and max(high, -low) and not SCALES[0] < max(high, -low) < SCALES[1]:
        raise ValueError(
            f"x: a largest value from {SCALES[0]:g} to {SCALES[1]:g} expected, found "
            f"{low:g} to {high:g}"
        )
    feed = Feed(run, clock.rate_hz, int(given["stride"] or 1))
    if given["skip_torn_reads"]:
        torn = torn_of(taken, there.ends())
        feed.torn_reads = int(torn.sum())
        there, taken = there.without(torn), taken[~torn]
        require(there.size, run.needed)
    if given["bandwidth"] == "auto":
        feed.bandwidth = run.learn(taken, there.ends())
    run.start(clock.rate_hz, low, high)
    feed.whole(taken, there, len(values))
    if not feed.waiting:
        raise ValueError(f"x: too short: {there.size} samples give no epoch")
    return feed


class Stream:
    """The dynamic Allan variance of samples as they arrive. Only one window is in memory.

    Give either lsb (deg/s per count: exact, as on the device) or full_scale (deg/s: float samples,
    which saturate above it). The other options are those of dynamic(). Results do not depend on how
    samples are split into pushes. Threads may share a stream. Calls run one at a time, and a block
    is pushed in one call. RuntimeError: a call inside another call of the same thread (a signal
    handler).

    ```python
    stream = davar.Stream(100.0, lsb=0.05, stride=100)
    for counts in blocks:
        stream.push(counts)
        print(stream.results().arw_deg_per_sqrt_h)
    ```
    """

    @takes_old_names
    def __init__(
        self,
        rate_hz: float,
        *,
        lsb: float | None = None,
        full_scale: float | None = None,
        bandwidth: float | str | None = None,
        bits: int | None = None,
        law: str | None = None,
        mode: str | None = None,
        window_max: int | None = None,
        window_min: int | None = None,
        segment: int | None = None,
        kurtosis: Pair | None = None,
        contribution: Pair | None = None,
        unstable_rate: float | None = None,
        grow: int | None = None,
        shrink: int | None = None,
        taus: str | None = None,
        clusters: npt.ArrayLike | None = None,
        taus_s: npt.ArrayLike | None = None,
        longest_tau_s: float | None = None,
        stride: int | None = None,
        engine: str | None = None,
        fit_every: int | None = None,
        false_alarms_per_hour: float | None = None,
        cut_interval: float | None = None,
        block: int | None = None,
        shock_blocks: int | None = None,
        model_table: Path | None = None,
        floor: bool = False,
        details: bool = False,
    ) -> None:
        given = locals()
        if (lsb is None) == (full_scale is None):
            raise ValueError(
                "lsb or full_scale: a stream needs one of them, because the range of its samples "
                "is not known in advance"
            )
        if bandwidth == "auto":
            raise ValueError(
                "bandwidth: 'auto' learns from a complete record: use dynamic(), or give the filter"
            )
        hz = _samples.positive("rate_hz", rate_hz)
        run = run_of({**given, "arith": "fixed" if full_scale is None else "float"}, hz)
        limit = 2.0 ** (int(bits or BITS) - 1)
        run.start(hz, -limit, limit - 1)
        self._lsb, self._finished = lsb, False
        self._feed = Feed(run, hz, int(stride or 1))
        self._lock, self._inside = threading.RLock(), False

    def __reduce__(self) -> str:
        raise TypeError("davar: a Stream cannot be copied or pickled")

    @contextmanager
    def _alone(self) -> Iterator[Feed]:
        """Allows one call at a time, from one thread at a time."""
        with self._lock:
            if self._inside:
                raise RuntimeError(
                    "davar: a Stream was called from within a call of it in the same thread "
                    "(a signal handler?)"
                )
            self._inside = True
            try:
                yield self._feed
            finally:
                self._inside = False

    def push(self, x: npt.ArrayLike) -> int:
        """Pushes samples: rates, deg/s, or counts (integers; with lsb), one or an array (n). NaN or
        masked: a missing sample. Returns the number of epochs waiting in results(). On ValueError
        no sample is used.
        """
        values, counted = _samples.samples(x, self._lsb, one=True)
        there = _samples.there(values, None)
        with self._alone() as feed:
            if self._finished:
                raise ValueError("x: the stream is finished")
            feed.push(admitted(feed.run, values, there, counted), there, len(values))
            return feed.waiting

    def gap(self, missing: int = 1) -> None:
        """Reports `missing` lost samples (>= 1) before the next one. epoch does not count them."""
        if isinstance(missing, bool) or not isinstance(missing, (int, np.integer)) or missing < 1:
            raise ValueError(f"missing: a whole number of at least 1 expected, found {missing!r}")
        with self._alone() as feed:
            feed.ahead += int(missing)

    def finish(self) -> int:
        """Ends the record: completes the epochs up to its mirrored end (mode "centred"). Returns
        the number of waiting epochs.
        """
        with self._alone() as feed:
            if not self._finished:
                self._finished = True
                feed.finish()
            return feed.waiting

    def results(self) -> Epochs:
        """Returns and clears the epochs completed since the last call, oldest first. epoch counts
        the samples pushed, from 0.
        """
        with self._alone() as feed:
            return feed.epochs()

    @property
    def health(self) -> dict[str, int]:
        """Counters so far: gaps, missing, saturated, restarts (windows discarded) and others."""
        with self._alone() as feed:
            return feed.run.health()
