"""Time stamps: the rate of the clock behind them, and the place of every sample on its even
grid."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ..arrays import Floats, Ints
from ..errors import BadInput
from ..files import StrPath
from ..thresholds import STAMPS


@dataclass
class Clock:
    """places: index on the grid of each sample, None when they follow each other. kind: even, late
    (stamps jitter about an even clock), uneven. rows: of the file that have a place, None: all.
    cut: (index on the grid, seconds left out before it) of gaps too long to be filled. jitter_s:
    rms of the stamps about the grid."""

    rate_hz: float
    places: Ints | None = None
    kind: str = "even"
    cut: tuple[tuple[int, float], ...] = ()
    jitter_s: float = 0.0
    rows: Ints | None = None


def agreed(rate_hz: float | None, stamped_hz: float, path: StrPath) -> float:
    """The rate that was given, if any; time stamps that contradict it win, so it is refused."""
    if rate_hz and abs(stamped_hz / rate_hz - 1) > STAMPS.doubtful_rate:
        raise BadInput(
            f"--rate: {rate_hz:g} Hz contradicts column time_s of {path}, which gives "
            f"{stamped_hz:.6g} Hz. Remove --rate, or fix time_s"
        )
    return float(rate_hz or stamped_hz)


def check_order(steps: Floats, path: StrPath, line: int | None) -> None:
    back = np.flatnonzero(steps < 0)
    if len(back):
        where = f"{path}: sample {back[0] + 2}" if line is None else f"{path}:{line + back[0] + 2}"
        raise BadInput(f"{where}: column time_s: time runs backwards")
    if not steps.sum() > 0:
        raise BadInput(f"{path}: column time_s: the time does not advance")


def gathered(steps: Floats) -> float:
    """Variance that the stamps gather over many steps, over what independent steps would: 0 for
    stamps about an even clock, 1 for a loop that waits anew each time."""
    count = len(steps)
    line = np.cumsum(steps - steps.mean())
    span = max(2, count // 30)
    moved = line[span:] - line[:-span]
    return float(np.mean(moved**2) / (span * steps.var())) if steps.var() > 0 else 0.0


def period_of(steps: Floats) -> float | None:
    """The period, when most steps are near a whole number of them; else None. Where half the
    samples are lost the median step may be two periods; stamps in coarse units alternate too, but
    gather nothing."""
    for share in (50, 25, 10):
        period = float(np.percentile(steps, share))
        if period > 0 and (share == 50 or gathered(steps) > STAMPS.memoryless):
            # None, where a percentile lies between two far ones.
            near = steps[np.abs(steps - period) < 0.5 * period]
            period = float(near.mean()) if len(near) else period
            whole = np.round(steps / period)
            if (
                len(near)
                and np.mean((np.abs(steps / period - whole) < STAMPS.step_near) & (whole > 0))
                >= STAMPS.step_whole
            ):
                return period
    return None


def phase(turns: Floats) -> float:
    found: float = np.angle(np.mean(np.exp(2j * np.pi * turns))) / (2 * np.pi)
    return found


def one_phase(stamps: Floats, period: float) -> Floats:
    """Stamps in periods, moved by less than half of one after each long gap, so that the phase of
    the clock goes on."""
    steps = np.diff(stamps) / period
    turns = np.concatenate([[0.0], np.cumsum(steps)])
    starts = np.flatnonzero(steps > STAMPS.long_gap) + 1
    for run, before in zip(
        np.split(turns, starts)[1:], np.split(turns, starts)
    ):  # views: each is moved in its place
        apart = phase(run[: STAMPS.phase_samples]) - phase(before[-STAMPS.phase_samples :])
        run -= apart - np.round(apart)
    found: Floats = turns
    return found


def lost_before(stamps: Floats, period: float) -> Ints:
    """Samples lost before each sample: whole periods at the phase of the clock around it, that
    later stamps do not take back."""
    turns = one_phase(stamps, period)
    around = np.exp(2j * np.pi * (turns % 1))
    width = min(STAMPS.phase_samples, len(turns))
    mean = ndimage.uniform_filter1d(around.real, width) + 1j * ndimage.uniform_filter1d(
        around.imag, width
    )
    excess = np.round(turns - np.unwrap(np.angle(mean)) / (2 * np.pi)).astype(np.int64) - np.arange(
        len(turns)
    )
    excess -= excess[0]
    if not np.any(excess):
        return excess
    ahead = ndimage.minimum_filter1d(
        excess,
        min(STAMPS.late, len(excess)),
        mode="nearest",
        origin=-(min(STAMPS.late, len(excess)) // 2),
    )
    return np.maximum.accumulate(np.maximum(ahead, 0))


def straightened(steps: Floats, period: float, lost: Ints) -> float:
    """The period, once more, from all steps with the samples lost in them; gaps are left out
    (rounded anyway)."""
    periods = 1 + np.diff(lost)
    short = periods < STAMPS.late
    return float(steps[short].sum() / periods[short].sum())


def held(lost: int, count: int) -> bool:
    """May a grid have so many missing samples beside those that were measured."""
    return lost <= STAMPS.recurrent_most * count or count + lost <= STAMPS.small_grid


def longest_kept(gaps: Ints, count: int) -> int:
    """The length to which the gaps between `count` samples are cut: few and long ones, so that all
    together hold no more than `lost_most` times as many."""
    rising = np.sort(gaps)
    if rising.sum() <= STAMPS.lost_most * count:
        return int(rising[-1])
    short = np.concatenate([[0], np.cumsum(rising)[:-1]])
    left = (STAMPS.lost_most * count - short) / np.arange(len(rising), 0, -1)
    longest = max(int(left[np.argmax(rising > left)]), 1)
    if np.count_nonzero(rising > longest) > STAMPS.cut_most:  # they recur
        longest = int(rising[-1 if held(int(rising.sum()), count) else -STAMPS.cut_most - 1])
    return longest


def analysed(clock: Clock, path: StrPath) -> Clock:
    """The clock. Raises BadInput where gaps that recur and hold nearly all of the time leave no
    record to analyse."""
    if clock.places is None:
        return clock
    kept, count = np.diff(clock.places) - 1, len(clock.places)
    lost = int(kept.sum())
    if held(lost, count):
        return clock
    raise BadInput(
        f"{path}: column time_s: {np.count_nonzero(kept)} gaps of up to "
        f"{kept.max() / clock.rate_hz:.4g} s leave {100 * count / (count + lost):.2g} % of the "
        f"samples; at least {100 / (STAMPS.recurrent_most + 1):.2g} % are needed for an analysis. "
        "Record with shorter pauses (ArduPilot: fewer sensors in INS_LOG_BAT_MASK)"
    )


def found(stamps: Floats, rate_hz: float | None, path: StrPath, line: int | None) -> Clock:
    """The clock behind a column of time stamps (seconds). Raises BadInput where time runs backwards
    or stands still."""
    if len(stamps) < 2:
        raise BadInput(f"{path}: one sample has no rate")
    steps = np.diff(stamps)
    check_order(steps, path, line)
    mean = (stamps[-1] - stamps[0]) / len(steps)
    if steps.min() > (1 - STAMPS.step_near) * mean and steps.max() < (1 + STAMPS.step_near) * mean:
        jitter = float(steps.std() / np.sqrt(2))
        return (
            without_places(stamps, rate_hz, path)
            if jitter > STAMPS.jitter * mean
            else Clock(agreed(rate_hz, 1.0 / mean, path), jitter_s=jitter)
        )
    period = period_of(steps)
    if period is None:
        return without_places(stamps, rate_hz, path)
    lost = lost_before(stamps, period)
    if wandering(steps, np.diff(lost), period):
        return without_places(stamps, rate_hz, path)
    period = straightened(steps, period, lost)
    return with_places(steps, period, lost, agreed(rate_hz, 1.0 / period, path))


def wandering(steps: Floats, gaps: Ints, period: float) -> bool:
    """Do the steps, less the whole periods in them, stray and gather what they stray: no even clock
    is behind them. A long gap is no part of a clock."""
    off = (steps - (1 + gaps) * period)[gaps < STAMPS.late]
    return (
        bool(np.all(gaps < STAMPS.late))
        and off.std() > STAMPS.jitter * period
        and gathered(off) > STAMPS.memoryless
    )


def without_places(stamps: Floats, rate_hz: float | None, path: StrPath) -> Clock:
    """About an even clock the index decides, the stamps only tell how many samples there are a
    second. Samples of an uneven clock are where their stamps say: at the nearest place of the grid,
    the first one where two meet there."""
    steps = np.diff(stamps)
    late = np.cumsum(steps - steps.mean())
    rate = agreed(rate_hz, 1.0 / steps.mean(), path)
    if gathered(steps) < STAMPS.memoryless:
        return Clock(rate, None, "late", (), float(late.std()))
    places, rows = np.unique(
        np.round((stamps - stamps[0]) * rate).astype(np.int64), return_index=True
    )
    if len(rows) < STAMPS.crowded * len(stamps):
        return Clock(rate, None, "uneven", (), float(late.std()))
    return Clock(rate, places, "uneven", (), float(late.std()), rows)


def with_places(steps: Floats, period: float, lost: Ints, rate: float) -> Clock:
    gaps = np.diff(lost)
    longest = longest_kept(gaps, len(lost))
    kept = np.minimum(gaps, longest)
    places = np.concatenate([[0], np.cumsum(1 + kept)])
    cut = tuple(
        (int(places[i + 1]), float((gaps[i] - longest) * period))
        for i in np.flatnonzero(gaps > longest)
    )
    off = steps - (1 + gaps) * period
    jitter = float(np.std(off[gaps < STAMPS.late]) / np.sqrt(2)) if len(off) else 0.0
    return Clock(
        rate,
        places if np.any(gaps) else None,
        "late" if jitter > STAMPS.jitter * period else "even",
        cut,
        jitter,
    )


def behind_repeats(time: Floats, rate_hz: float, share: float, path: StrPath) -> Clock | None:
    """The even clock of a sensor whose fresh samples were read at these times; None where there is
    none: the reading failed at random, or for once."""
    steps = np.diff(time)
    if gathered(steps) < STAMPS.memoryless:
        own = len(steps) / float(time[-1] - time[0])
        return Clock(own) if own < (1 - share / 2) * rate_hz else None
    clock = analysed(found(time, None, path, 1), path)
    return clock if clock.rate_hz < STAMPS.slower * rate_hz and clock.kind == "even" else None
