"""A model at its best on one recording, and before the judge."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .. import arrays
from ..arrays import Bools, Floats
from ..candidates import doubts, filters
from ..candidates import ranking as candidates
from ..candidates.candidate import Candidate
from ..data import counts, events, motion, observations, signals
from ..data import recording as recordings
from ..data.events import Shocks
from ..data.observations import Observation
from ..data.recording import Recording
from ..errors import BadInput, Moving
from ..inference import adequacy, changes, gaps, images, modulation, reading, refine
from ..inference.parts import Bench, Part, as_spectra, part_of, without
from ..inference.whittle import Data
from ..model import Model
from ..thresholds import CHANCE, SEARCH, START
from . import cells, judge
from .judge import Cell
from .state import Judged, Progress, State


def observed(
    recording: Recording, column: str, progress: Progress = lambda text: None
) -> Sequence[Observation]:
    """The observations on a recording, which are worked out once."""
    key = ("observations", column)
    if key not in recording.measured:
        recording.measured[key] = observations.find(
            recording, column, lambda: progress("reading the spectrum")
        )
    found: Sequence[Observation] = recording.measured[key]
    return found


def start(recording: Recording, model: Model, progress: Progress = lambda text: None) -> State:
    """The given model's terms refitted on the recording."""
    if recording.samples < START.least_s * recording.rate_hz:
        raise BadInput(
            f"{recording.name}: {recording.samples / recording.rate_hz:.3g} s are too short. At "
            f"least {START.least_s} s are needed to estimate slow noise"
        )
    seen = observed(recording, model.column, progress)
    progress("reading the spectrum")
    unused = [
        one
        for one in seen
        if one.kind != "outliers" or doubts.was_moved(seen) and "shocks" not in model.kinds
    ]
    known = observations.kept(recording, model.column, unused)
    y = recording.rate_dps(model.column)
    check_at_rest(recording, seen)
    check_alive(recording, model, y[known])
    if known.all():
        return fitted(recording, model, y, None, seen)
    recording = at_rest(recording, known, model.column)
    progress(f"simulating {np.count_nonzero(~known)} missing samples")
    lines = images.lines(y, known)
    y = y - lines
    drawn = gaps.conditional_draw(y, known, gaps.first_level(y, known), np.random.default_rng(0))
    first = fitted(recording, model, drawn, known, seen)
    # The ripple of the first level is chance and would confirm itself; so would a model that is far
    # from the record. Where hardly any sample is known, the ripple is larger than what it is of.
    few = known.mean() < START.few_known
    near = not few and spectrum_p(first) > START.far_p
    # Each with other numbers: the same ones would add up their own chance variance.
    seeds = range(3, 3 + START.few_draws) if few else range(1, 1 + near)
    for seed in seeds:
        drawn = drawn_by(first, seed)
        first = fitted(recording, model, drawn, known, seen)
    return fitted(recording, model, lines + drawn, known, seen) if lines.any() else first


def spectrum_p(state: State) -> float:
    c = state.bench.whitened(state.parts, state.fit)
    return adequacy.spectrum_score(c, len(state.fit.sizes) + len(state.fit.coefficients))


def at_rest(recording: Recording, known: Bools, gyro: str) -> Recording:
    """The recording with the other columns of the sensor interpolated over what is missing: a turn
    that was cut out weighs more than all the rest, and what is drawn there would confirm the
    coefficient that it was drawn with."""
    moved = [
        name for name in recording.columns if name.startswith(("gyro_", "accel_")) and name != gyro
    ]
    still = {name: recordings.filled(recording.columns[name][known], known) for name in moved}
    return replace(recording, columns=recording.columns | still, measured={})


def redrawn(state: State, model: Model) -> State:
    """The given model on the record whose missing samples are drawn anew: from the spectrum, and
    about the course, of this state."""
    return fitted(state.bench.recording, model, drawn_by(state, 1), state.known, state.seen)


def drawn_by(state: State, seed: int) -> Floats:
    """The record with its missing samples drawn from the spectrum, and about the course, of the
    state."""
    assert state.known is not None  # samples are missing
    course, level = (
        state.bench.mean_course(state.parts, state.fit),
        state.bench.data.at_ordinates(state.fit.level),
    )
    course = course + images.lines(state.shocks.raw - course, state.known)
    return course + gaps.conditional_draw(
        state.shocks.raw - course, state.known, level, np.random.default_rng(seed)
    )


def check_at_rest(recording: Recording, seen: Sequence[Observation]) -> None:
    """Refuses a record that moves most of the time: what is left would pass for rest."""
    moved = next((one.mask for one in seen if one.kind == "motion" and one.mask is not None), None)
    if moved is None:
        return
    measured = np.ones(len(moved), bool) if recording.known is None else recording.known
    share = np.count_nonzero(moved & measured) / np.count_nonzero(measured)
    if share <= START.moved_most:
        return
    rests = motion.stretches(measured & ~moved)
    first, end = max(rests, key=lambda one: one[1] - one[0], default=(0, 0))
    rest = (
        f"the longest rest is from {first / recording.rate_hz:.4g} to "
        f"{end / recording.rate_hz:.4g} s"
        if rests
        else "it never rests"
    )
    raise Moving(
        f"{recording.name}: the sensor moves in {100 * share:.0f} % of the recording, so this is "
        f"not a recording at rest ({rest}). Put the sensor on a solid base, do not touch it, and "
        "record again, or cut the file to a part at rest"
    )


def check_alive(recording: Recording, model: Model, y: Floats) -> None:
    where = f"{recording.name}: column {recordings.as_logged(model.column)}"
    if recordings.counted(len(y), recording.missing_samples) < recordings.MINIMUM_SAMPLES:
        raise BadInput(
            f"{where}: {len(y)} samples remain without motion, "
            f"torn, repeated and clipped samples; at least {recordings.MINIMUM_SAMPLES} are needed"
        )
    if np.mean(np.diff(y) != 0) < START.moving_share:
        raise BadInput(f"{where} hardly changes, so there is no noise to compare a model with")
    if signals.foretold(y):
        raise BadInput(
            f"{where}: every sample is predictable from the "
            "earlier ones, so there is no noise to compare a model with"
        )


def fitted(
    recording: Recording, model: Model, y: Floats, known: Bools | None, seen: Sequence[Observation]
) -> State:
    """The model's terms at their best on a record without holes."""
    bench, shocks = benched(recording, model.column, y, known)
    parts = [part_of(term) for term in model.terms]
    bench = bench.resolving(parts)
    parts = filters.responding(bench, with_forms(bench, parts))
    parts = refine.refined(bench, parts, sweeps=2)
    parts = with_decoded_states(bench, parts)
    parts = modulation.regrown(bench, parts, bench.fit(parts))
    state = State(bench, tuple(parts), bench.fit(parts), shocks, known=known, seen=tuple(seen))
    return cleaned_again(state) if any(part.role == "mean" for part in parts) else state


def benched(
    recording: Recording, column: str, y: Floats, known: Bools | None
) -> tuple[Bench, Shocks]:
    """(bench, shocks) of a record without holes. Where none of it was drawn, counts, shocks and
    ordinates are worked out once for all models."""
    memory = recording.measured if known is None else {}
    key = ("bench", column)
    if key not in memory:
        logged = y if known is None else recording.rate_dps(column)
        found = counts.found(logged if known is None else logged[known], recording.rate_hz)
        shocks = events.find(y, recording.rate_hz, found.reach_dps if found else 0.0)
        data = Data(shocks.clean, recording.rate_hz)
        memory[key] = Bench(recording, shocks.clean, found, data, column, logged), shocks
    bench, shocks = memory[key]
    data = bench.data.again()
    return Bench(recording, bench.y, bench.counts, data, column, bench.logged), shocks


def tidied(state: State) -> None:
    """Frees what was worked out for candidates of a long record, as long as the record each."""
    recording, data = state.bench.recording, state.bench.data
    if recording.samples < arrays.NARROW_FROM:
        return
    for key in set(data.columns) - {"gyro", *state.bench.all_keys(state.parts)}:
        del data.columns[key]
    for key in [one for one in recording.measured if one[0] in ("still", "turns")]:
        del recording.measured[key]
    state.bench.latest.clear()
    signals.forget_plans(recording.samples)
    signals.forget_plans(recording.samples, signals.transform)


def with_forms(bench: Bench, parts: list[Part]) -> list[Part]:
    """Variants of regressors, and what a model file need not say of a shape: whichever the gyro
    follows. Filters have to move to their own best shape first (filters.responding)."""
    for index, part in enumerate(parts):
        if part.role == "filter":
            continue
        others = [
            replace(one, form=form) for one in filters.unsaid(part) for form in part.effect.forms
        ]
        trials = [parts] + [
            [*parts[:index], other, *parts[index + 1 :]] for other in others if other != part
        ]
        if len(trials) > 1:
            parts = max(trials, key=lambda trial: filters.worth(bench, trial))
    return parts


def with_decoded_states(bench: Bench, parts: list[Part]) -> list[Part]:
    """Telegraph noise of the given model as its decoded course, when its levels can be seen."""
    for index, part in enumerate(parts):
        if part.kind == "telegraph_noise":
            trial = [*parts[:index], *parts[index + 1 :]]
            found = Candidate(part.kind, part, 0.0, -1e9)
            candidates.decode_states(bench, trial, found)
            parts = [*parts[:index], found.part, *parts[index + 1 :]]
    return parts


def relative_variance(state: State) -> Floats | None:
    """White level per sample over its mean, when the model or the counts let it change."""
    if not modulation.changing(state.parts) and state.bench.counts is None:
        return None
    blocks = state.bench.blocks(state.parts, state.fit)
    rows = modulation.variance_shapes(state.parts, state.bench.recording, blocks)
    if modulation.constant(rows) and blocks.known is None:
        return None
    variance = changes.fit(blocks, rows)[1] * (1.0 if blocks.known is None else blocks.known)
    samples = np.minimum(np.arange(len(state.bench.y)) // blocks.length, len(variance) - 1)
    relative: Floats = variance[samples] / variance.mean()
    return relative


def judged(state: State, quick: bool = False) -> Judged:
    """The state with its adequacy, cells and judgement; `quick`: without the tests in time, for a
    step on the way."""
    variance, data = relative_variance(state), state.bench.data
    blocks = state.bench.blocks(state.parts, state.fit)
    c = state.bench.whitened(state.parts, state.fit)
    free = len(state.fit.sizes) + len(state.fit.coefficients)
    extra = {}
    if "shocks" not in state.model_kinds:
        extra["shocks"] = float(np.exp(state.shocks.log_p))
    if variance is not None:
        share = modulation.white_share(state.bench, state.parts, state.fit)
        c = modulation.levelled(c, variance, data.at_ordinates(share))
    noise = as_spectra(state.parts)
    if noise:
        fit = state.bench.fit(noise)
        other = state.bench.whitened(noise, fit)
        extra["spectrum"] = max(
            adequacy.spectrum_score(c, free), adequacy.spectrum_score(other, free)
        )
    left = adequacy.judge(c, free, extra, quick, state.bench.counts)
    found, short = cells_of(state, variance)
    judgement = judge.judged(found, short, left.p_value, state.spoiled_by, reading_of(state, found))
    return Judged(
        state.bench,
        state.parts,
        state.fit,
        state.shocks,
        blocks=blocks,
        adequacy=left,
        cells=tuple(found),
        judgement=judgement,
        known=state.known,
        seen=state.seen,
    )


def reading_of(state: State, found: Sequence[Cell]) -> reading.Reading | None:
    return reading.read_off(state.bench, state.parts, state.fit, judge.over_all(found))


def cells_of(state: State, variance: Floats | None) -> tuple[list[Cell], list[Cell]]:
    """(cells, short cells). Decoded levels are a course, which misses short visits, or the noise
    that they are, of which few switches scatter more than the cells' degrees of freedom say:
    whichever is nearer to its floor (6.5)."""
    view, found = nearest_view(state, variance)
    short = cells.short_cells(view, state.record, variance)
    return found, short + cells.row_cell(view)


def nearest_view(state: State, variance: Floats | None) -> tuple[State, list[Cell]]:
    """(decoded levels as a course or as noise, cells)."""
    noise = as_spectra(state.parts)
    views = [state] if noise is None else [state, with_parts(state, noise)]
    found = [(view, cells.cells_of(view, state.record, variance)) for view in views]
    return min(found, key=lambda one: judge.error_of(one[1]) / judge.floor_of(one[1]))


def errors_of(state: State) -> tuple[float, float]:
    """(error, its floor)."""
    found = nearest_view(state, relative_variance(state))[1]
    return judge.error_of(found), judge.floor_of(found)


def cleaned_again(state: State) -> State:
    """A course that is known now neither hides shocks nor passes for them: they are sought again
    beside it (6.1)."""
    course = state.bench.mean_course(state.parts, state.fit)
    reach = state.bench.counts.reach_dps if state.bench.counts else 0.0
    shocks = events.find(state.shocks.raw - course, state.bench.recording.rate_hz, reach)
    shocks = replace(shocks, clean=shocks.clean + course, raw=state.shocks.raw)
    if np.array_equal(shocks.clean, state.shocks.clean):
        return state
    bench = state.bench.with_gyro(shocks.clean)
    return replace(state, bench=bench, fit=bench.fit(state.parts), shocks=shocks)


def joined(state: State, part: Part, replaces: Sequence[Part] = ()) -> State:
    """The model with one more part, or with one in the place of others, its shape at its best;
    unless it is a line also those of the others."""
    parts = [*without(state.parts, replaces), part]
    bench = state.bench.resolving(parts)
    if part.kind not in SEARCH.most_of:
        parts = filters.responding(bench, parts)
    if part.kind != "telegraph_noise":
        alone = part.kind in SEARCH.most_of
        parts = refine.refined(
            bench,
            parts,
            refine.sweeps_for(parts, part.kind),
            {one.kind for one in parts} - set(SEARCH.most_of) | {part.kind},
            only_last=alone,
        )
        parts = with_one_line(bench, parts)
    parts = modulation.regrown(bench, parts, bench.fit(parts))
    bench = bench.resolving(parts)
    state = replace(state, bench=bench, parts=tuple(parts), fit=bench.fit(parts))
    if part.role != "mean":
        return state
    return cleaned_again(
        state if state.known is None or part.kind in SEARCH.most_of else refilled(state)
    )


def with_one_line(bench: Bench, parts: list[Part]) -> list[Part]:
    """Filters and the first line with a width at their best together, where one of them joined
    last: a cutoff alone is drawn to the line, and a line alone is widened by the cutoff. Only if
    they then come near the spectrum: else the filter would follow what is still missing."""
    kinds = {part.kind for part in parts if part.role == "filter"} | {"narrow_band"}
    lines = [part.kind for part in parts].count("narrow_band")
    if lines != 1 or len(kinds) == 1 or parts[-1].kind not in kinds:
        return parts
    moved = refine.refined(bench, parts, 2, only=kinds)
    if bench.fit(moved).log_likelihood - bench.fit(parts).log_likelihood < CHANCE.tell_apart:
        return parts
    moved = filters.responding(bench, moved)
    moved = refine.refined(bench.resolving(moved), moved, 2, only=kinds)
    fine = bench.resolving(moved)
    left = fine.whitened(moved, fine.fit(moved))
    return moved if adequacy.spectrum_score(left, len(moved)) > START.far_p else parts


def refilled(state: State) -> State:
    """A course that is known now goes on through the missing samples; drawn without it they would
    pass for a noise of their own."""
    return replace(state, shocks=replace(state.shocks, raw=drawn_by(state, 2)))


def with_parts(state: State, parts: Sequence[Part]) -> State:
    """Other parts on the same bench."""
    fit = state.bench.fit(parts, near=state.fit.level)
    return replace(state, parts=tuple(parts), fit=fit)
