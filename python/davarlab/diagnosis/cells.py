"""Measured and expected Allan deviations of the whole record, its quarters and sixteenths
(DESIGN 8)."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import Bools, Floats
from ..inference import adequacy, allan
from ..inference.parts import Part, spectrum_of
from ..thresholds import JUDGE, START
from .judge import Cell
from .state import State

Chosen = Callable[[Part], bool]


def narrow(part: Part, window_s: float) -> bool:
    return (
        part.kind == "narrow_band" and part.shape["half_width_hz"] * window_s < JUDGE.course_turns
    )


class Expectation:
    """What the fitted noise gives: Allan variance, degrees of freedom, the share of the sensor's
    white noise, and the Allan variance of lines that keep their phase in a window; one value per
    tau."""

    def __init__(self, state: State) -> None:
        self.bench, self.parts, self.sizes = state.bench, state.parts, state.fit.sizes
        # None: a model without noise has one row all the same.
        self.noise: Sequence[Part | None] = [
            part for part in self.parts if part.role == "spectrum"
        ] or [None]
        self.cached: dict[Hashable, Floats] = {}

    def spectrum(self, chosen: Chosen, rest: bool) -> Callable[[Floats], Floats]:
        """Of the chosen parts; `rest`: with what is behind the filters and in the counts."""
        kept = [part is None or chosen(part) for part in self.noise]
        sizes = self.sizes * np.append(kept, np.full(len(self.sizes) - len(kept), float(rest)))
        return spectrum_of(
            self.parts, sizes, self.bench.data.rate_hz, self.bench.counts if rest else None
        )

    def on_grid(self, name: Hashable, chosen: Chosen, rest: bool) -> Floats:
        if name not in self.cached:
            self.cached[name] = allan.on_grid(self.spectrum(chosen, rest), self.bench.data.rate_hz)
        return self.cached[name]

    def over(self, window: int, taus: Sequence[int]) -> tuple[Floats, Floats, Floats, Floats]:
        rate = self.bench.data.rate_hz
        steady = tuple(
            part for part in self.noise if part is not None and narrow(part, window / rate)
        )

        def loud(part: Part) -> bool:
            return part not in steady

        power = self.on_grid(("noise", len(steady)), loud, True)
        variance = allan.expected(power, taus)
        spectrum = self.spectrum(loud, True)
        freedom = np.array([allan.freedom(spectrum, power, int(m), window, rate) for m in taus])
        white = self.on_grid("white", lambda part: part.kind == "angle_random_walk", False)
        lines = (
            self.on_grid(("steady", len(steady)), lambda part: part in steady, False)
            if steady
            else None
        )
        return (
            variance,
            freedom,
            allan.expected(white, taus) / np.maximum(variance, 1e-300),
            np.zeros(len(taus)) if lines is None else allan.expected(lines, taus),
        )


def cells_of(state: State, y: Floats, relative: Floats | None = None) -> list[Cell]:
    """Cells of the record and of its quarters and sixteenths; `relative`: the white level per
    sample over its mean, None: constant."""
    return cells_in(state, y, relative, JUDGE.cell_windows, None)


def short_cells(state: State, y: Floats, relative: Floats | None = None) -> list[Cell]:
    counts = state.bench.counts
    if counts and (counts.unsteady or counts.sparse):
        return []
    return cells_in(state, y, relative, (JUDGE.short_windows,), 1)


def cells_in(
    state: State, y: Floats, relative: Floats | None, windows: Sequence[int], most: int | None
) -> list[Cell]:
    """Cells of so many windows, of the `most` shortest averaging times."""
    bench = state.bench
    expectation, found = Expectation(state), []
    for count in windows:
        window = allan.window_of(len(y), count)
        taus = allan.octaves(window)[:most]
        if not taus:
            continue
        noise, freedom, share, steady = expectation.over(window, taus)
        if bench.counts:  # of samples with excess kurtosis, squares scatter more
            freedom = freedom / (1 + bench.counts.kurtosis / 2 * freedom / window)
        memory = bench.recording.measured
        measured, valid = remembered(memory, y, window, taus, state.known)
        course = course_variances(state, window, taus, state.known)
        if state.known is not None:
            as_drawn = lost_between(state.known, valid)
            if as_drawn.any():
                whole = remembered(memory, y, window, taus, None)[0]
                measured = np.where(as_drawn, whole, measured)
                course = np.where(as_drawn, course_variances(state, window, taus, None), course)
                valid = np.where(as_drawn, state.known.mean(), valid)
        measured = measured**2
        for row in range(len(measured)):
            level, scatter = levels(relative, row * window, window, taus, share)
            rows = row_cells(
                row,
                window,
                taus,
                measured[row],
                noise * level,
                course[row] + steady,
                freedom * valid[row] / scatter,
                bench.data.rate_hz,
            )
            found += [
                cell
                for cell, has_enough in zip(rows, enough(valid[row], state.known))
                if has_enough and (state.known is None or cell.freedom > 1)
            ]
    return found


def levels(
    relative: Floats | None, start: int, window: int, taus: Sequence[int], share: Floats
) -> tuple[Floats, Floats]:
    """(variance of the noise in a window over its mean in the record, how much more the Allan
    variance scatters than with a constant level) per tau. The differences of an averaging time see
    the middle of the window more than its ends, and where it is loud, few of them decide."""
    if relative is None:
        return np.ones(len(taus)), np.ones(len(taus))
    total = np.concatenate([[0.0], np.cumsum(relative[start : start + window])])
    found = np.empty((2, len(taus)))
    for place, (m, part) in enumerate(zip(taus, share)):
        local = 1 + part * ((total[2 * m :] - total[: -2 * m]) / (2 * m) - 1)
        found[:, place] = local.mean(), np.mean(local**2) / local.mean() ** 2
    return found[0], found[1]


def lost_between(known: Bools, valid: Floats) -> Bools:
    """The averaging times that take the record as it was drawn, for as much as it knows: all, where
    no two neighbours were measured; those that no window has, where hardly any sample is known."""
    if not valid.any():
        return np.ones(valid.shape[1], bool)
    few = known.mean() < START.few_known
    found: Bools = few & ~np.any(enough(valid, known), axis=0)
    return found


def enough(valid: Floats, known: Bools | None) -> Bools:
    """Do so many of the differences of a window decide an averaging time? Where hardly any sample
    is known, no averaging time has more of its differences."""
    found: Bools = valid > JUDGE.valid_share * (1.0 if known is None else known.mean())
    return found


def row_cell(state: State) -> list[Cell]:
    """The Allan deviation of 16 samples of the rows as they were read, by their stamps, where the
    record was put on another grid (8.5): it does not depend on how that was done.
    """
    bench = state.bench
    recording, rate = bench.recording, bench.recording.rate_hz
    if recording.rows is None or bench.gyro is None or recording.samples < 9 * JUDGE.rows:
        return []
    time, rows = recording.rows
    places = np.minimum(np.round((time - time[0]) * rate).astype(int), recording.samples - 1)
    used = (state.record == state.shocks.raw)[places]  # the model has shocks elsewhere
    if state.known is not None:
        used &= state.known[places]
    measured, share = by_time(
        time, replace(recording, columns=rows).rate_dps(bench.gyro), used, JUDGE.rows / rate
    )
    if share < JUDGE.valid_share:
        return []
    noise, freedom, _, steady = Expectation(state).over(recording.samples, [JUDGE.rows])
    course = bench.mean_course(state.parts, state.fit)
    moved = allan.windows(course, recording.samples, [JUDGE.rows], state.known)[0][0] ** 2
    return row_cells(
        0,
        recording.samples,
        [JUDGE.rows],
        np.array([measured]),
        noise,
        moved + steady,
        freedom * share,
        rate,
    )


def by_time(time: Floats, y: Floats, used: Bools, tau_s: float) -> tuple[float, float]:
    """(Allan variance of clusters of so many seconds, the share of their differences without a hole
    and an unused row)."""
    usual = len(time) * tau_s / (time[-1] - time[0])  # rows in a cluster
    squares, tried = [np.zeros(0)], 0
    for start in time[0] + tau_s * np.arange(4) / 4:
        cluster = np.floor((time - start) / tau_s).astype(int)
        inside = cluster >= 0
        count, total, unused = (
            np.bincount(cluster[inside], weights[inside])[:-1]  # the last one is not full
            for weights in (np.ones(len(y)), y, ~used)
        )
        whole = (count > JUDGE.rows_share * usual) & (unused == 0)
        pairs = whole[1:] & whole[:-1]
        means = total / np.maximum(count, 1)
        squares.append(np.diff(means)[pairs] ** 2 / 2)
        tried += len(pairs)
    found = np.concatenate(squares)
    return (float(found.mean()), len(found) / tried) if len(found) else (0.0, 0.0)


def course_variances(state: State, window: int, taus: Sequence[int], known: Bools | None) -> Floats:
    """Allan variances of the course of the fit in windows, measured once."""
    memory, key = state.fit.measured, (window, len(taus), known is None)
    if key not in memory:
        course = state.bench.mean_course(state.parts, state.fit)
        memory[key] = (
            allan.windows(course, window, taus, known)[0] ** 2
            if np.any(course)
            else np.zeros((len(course) // window, len(taus)))
        )
    found: Floats = memory[key]
    return found


def remembered(
    memory: dict[Any, Any], y: Floats, window: int, taus: Sequence[int], known: Bools | None
) -> tuple[Floats, Floats]:
    """Allan deviations of y in windows and the share of valid differences, measured once however
    many models are compared with them."""
    key = (float(y.sum()), float(y @ y), None if known is None else hash(known.tobytes()), window)
    if key not in memory:
        memory[key] = allan.windows(y, window, taus, known)
    found: tuple[Floats, Floats] = memory[key]
    return found


def row_cells(
    row: int,
    window: int,
    taus: Sequence[int],
    measured: Floats,
    noise: Floats,
    known: Floats,
    freedom: Floats,
    rate_hz: float,
) -> list[Cell]:
    """`known`: variance of what is no noise, which makes the sum scatter less (8.2)."""
    model = noise + known
    share = noise / model
    freedom = np.maximum(freedom, 1e-3) / np.maximum(share**2 + 2 * share * (1 - share), 1e-3)
    ratio = measured / model
    z = adequacy.normal_score(ratio, freedom)
    return [
        Cell(
            m / rate_hz,
            row * window / rate_hz,
            (row + 1) * window / rate_hz,
            float(np.sqrt(measured[i])),
            float(np.sqrt(model[i])),
            float(np.sqrt(ratio[i])),
            float(z[i]),
            float(freedom[i]),
        )
        for i, m in enumerate(taus)
    ]
