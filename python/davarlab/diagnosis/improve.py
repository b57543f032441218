"""Fit, and the loop: compare, diagnose, add, refit, with the history of the error (DESIGN 9)."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..candidates.candidate import Candidate as Lacking
from ..data import signals
from ..data.recording import Recording
from ..inference import estimate, refine
from ..inference.parts import Part, as_spectra
from ..model import Model, Term
from ..thresholds import CHANCE, SEARCH
from . import compare, diagnose, evidence, fitting
from .diagnose import Diagnosis
from .judge import Judgement
from .state import Judged, Progress, State
from .unexplained import Tried, Unexplained, unexplained_by

Estimates = dict[str, estimate.Estimate]  # of the parameters of an effect, by name


@dataclass
class Step:
    """The model after `added` joined (None: the model as given, or refitted; several kinds with
    commas: they lower the error together); errors beside those that a true model would have."""

    added: str | None
    effects: list[str]
    error: float
    error_floor: float
    error_held_out: float | None
    p_value: float
    error_floor_held_out: float | None = None
    adequacy: str = "no"


@dataclass
class Candidate:
    """A candidate as people read it."""

    kind: str
    gain: float
    p_value: float
    error_after: float
    error_held_out_after: float | None
    parameters: Estimates
    why: str


@dataclass
class Improvement:
    """`added`: the kinds that the final model has more than the given one; `judgement`: of the
    final model; `comparisons`: of the given model, and of the final one when it is another;
    `refitted`: the given effects with their sizes fitted, None: those of the file are as good;
    `against`: what speaks against a final model that fits."""

    comparison: compare.Comparison
    diagnosis: diagnose.Diagnosis
    steps: list[Step]
    verdict: str
    added: list[str]
    judgement: Judgement
    model: Model
    estimates: list[Estimates]
    candidates: list[Candidate] = field(default_factory=list)
    comparisons: list[compare.Comparison] = field(default_factory=list)
    refitted: Step | None = None
    notes: list[str] = field(default_factory=list)  # what is unusual about the recording, in words
    state: State | None = None  # the final model on the recording
    # Where the final model fails, and what was excluded; None: it is adequate or cannot be tested.
    unexplained: Unexplained | None = None
    against: list[Lacking] = field(default_factory=list)

    @property
    def base(self) -> Step:
        """The given effects at their best."""
        return self.refitted or self.steps[0]

    @property
    def last(self) -> Step:
        """The final model."""
        return self.steps[-1] if len(self.steps) > 1 else self.base


def estimates_of(state: State) -> list[Estimates]:
    """(state refitted for estimation, list of name -> Estimate per part)."""
    fit = state.bench.fit(state.parts, restricted=True)
    blocks = state.blocks
    found, noise = (
        estimate.all_estimates(state.bench, state.parts, fit, blocks, state.shocks),
        as_spectra(state.parts),
    )
    if noise:  # a decoded course takes some of the slow noise with it
        other = estimate.all_estimates(
            state.bench, noise, state.bench.fit(noise, restricted=True), blocks, state.shocks
        )
        found = [
            one if part.form == "decoded" else estimate.wider(one, two)
            for part, one, two in zip(state.parts, found, other)
        ]
    share = 1.0 if state.known is None else float(state.known.mean())
    return [{name: estimate.of_share(one, share) for name, one in entry.items()} for entry in found]


def fitted_model(state: State, model: Model) -> tuple[Model, list[Estimates]]:
    """The model file of a fitted state, and its estimates."""
    found = estimates_of(state)
    terms = []
    for part, entry in zip(state.parts, found):
        names = [parameter.name for parameter in part.effect.parameters]
        terms.append(Term(part.kind, {name: entry[name].value for name in names if name in entry}))
    return Model(state.bench.recording.rate_hz, model.column, terms), found


def fit(
    recording: Recording, model: Model, progress: Progress = lambda text: None
) -> tuple[Judged, Model, list[Estimates]]:
    """(judged state, fitted model, its estimates) of the model's own effects on this recording."""
    state = fitting.start(recording, model, progress)
    progress("comparing model and recording")
    state = fitting.judged(state)
    progress("computing the intervals")
    return state, *fitted_model(state, model)


def fit_around(state: State, model: Model, held: Collection[int]) -> tuple[Model, list[Estimates]]:
    """(model, estimates): the effects at the places `held` as they stand in the model, spectra,
    filters and courses, the others at their best beside them. state: the fit of the same
    effects."""
    given = compare.as_given(state, model)
    bench, sizes, coefficients = (
        given.bench,
        iter(given.fit.sizes),
        iter(given.fit.coefficients),
    )
    noise: list[tuple[Part, float]] = []
    keys: dict[str, float] = {}
    for place, part in enumerate(given.parts):
        if part.role == "spectrum":
            size = next(sizes)
            noise += [(part, size)] if place in held else []
        elif part.role == "mean":
            own = {key: next(coefficients) for key in bench.keys(part)}
            keys.update(own if place in held else {})
    course = signals.in_time(
        bench.data.columns["gyro"][0]
        - bench.data.without(np.array(list(keys.values())), list(keys))
    )
    around = bench.with_gyro(bench.y - course)
    around.held = noise
    free = [
        place
        for place, part in enumerate(given.parts)
        if place not in held or part.role == "filter"
    ]
    parts = [given.parts[place] for place in free]
    moved = {part.kind for place, part in zip(free, parts) if place not in held}
    parts = refine.refined(around, parts, sweeps=2, only=moved)
    fitted, entries = fitted_model(
        replace(
            state,
            bench=around.resolving(parts),
            parts=tuple(parts),
            fit=around.resolving(parts).fit(parts),
            blocks=None,
        ),
        model,
    )
    terms, found = list(model.terms), as_it_is(model)
    for place, term, entry in zip(free, fitted.terms, entries):
        if place not in held:
            terms[place], found[place] = term, entry
    return Model(fitted.rate_hz, model.column, terms), found


def held_out_errors(
    held_out: Recording | None, model: Model | None
) -> tuple[float, float] | tuple[None, None]:
    """(error, floor) on the held-out recording of the model as it is; None, None without one."""
    if held_out is None or model is None:
        return None, None
    found = compare.given(fitting.judged(fitting.start(held_out, model)), model).judgement
    return found.error, found.floor


def step_of(
    added: str | None, state: Judged, model: Model | None, held_out: Recording | None
) -> Step:
    """state: with the parameters of the model."""
    error, floor = held_out_errors(held_out, model)
    found = state.judgement
    return Step(
        added,
        state.model_kinds,
        found.error,
        found.floor,
        error,
        found.p_value,
        floor,
        found.adequacy,
    )


def refitted(model: Model, state: Judged, given: Judged, held_out: Recording | None) -> Step | None:
    """The step from the sizes of the file to the best ones; None when those of the file are as good
    (7.4)."""
    if compare.sizes_agree(state, given):
        return None
    return step_of(None, state, fitted_model(state, model)[0], held_out)


def with_candidate(found: Diagnosis, candidate: Lacking) -> State:
    """The model as given with one candidate: the second state of the search when it is the one that
    was taken first."""
    first, second = found.states[0], found.states[min(1, len(found.states) - 1)]
    taken = [part.kind for part in first.parts] + [candidate.kind] == second.model_kinds
    return second if taken else fitting.joined(first, candidate.part, candidate.replaces)


def described(
    model: Model, found: Diagnosis, base: Step, held_out: Recording | None, detail: int
) -> list[Candidate]:
    """The first `detail` candidates with their error after and parameters, the others with their
    gain. base: the step before them."""
    out = []
    for rank, candidate in enumerate(found.ranking):
        after, outside, parameters = float("nan"), None, {}
        if rank < detail:
            state = with_candidate(found, candidate)
            joined, entries = fitted_model(state, model)
            after = fitting.errors_of(state)[0]
            outside = held_out_errors(held_out, joined)[0]
            parameters = entries[-1]
        out.append(
            Candidate(
                candidate.kind,
                candidate.gain,
                float(np.exp(candidate.log_p)),
                after,
                outside,
                parameters,
                evidence.why(candidate, evidence.share(after, base)),
            )
        )
    return out


def improve(
    recording: Recording,
    model: Model,
    held_out: Recording | None = None,
    progress: Progress = lambda text: None,
    detail: int = 0,
) -> Improvement:
    """Adds what is missing, step by step; the error is that of the model as given first, then of
    each refitted model."""
    found = diagnose.diagnose(recording, model, progress)
    return improved(recording, model, found, held_out, progress, detail)


def as_it_is(model: Model) -> list[Estimates]:
    """The given model's parameters as estimates, which they are not."""
    return [
        {name: estimate.Estimate(value) for name, value in term.parameters.items()}
        for term in model.terms
    ]


def verdict_of(found: Diagnosis, added: Sequence[str], judgement: Judgement) -> str:
    if not judgement.adequate:
        return "unknown"
    return next(
        (candidate.kind for candidate in found.ranking if candidate.kind in added),
        added[0] if added else "none",
    )


def beside_the_file(
    last: Judged, given: Judged, model: Model, added: int
) -> tuple[Judged, Model, list[Estimates]] | None:
    """(state, model, estimates) of so many effects added beside the sizes of the file, where these
    do better than the likeliest ones; None where the error rises even so, or the model is not
    adequate."""
    fitted, entries = fitted_model(last, model)
    count = len(model.terms)
    if (
        len(fitted.terms) != count + added or added == 0 or fitted.kinds[:count] != model.kinds
    ):  # one of them took the place of a given one
        return None
    whole = Model(fitted.rate_hz, fitted.column, model.terms + fitted.terms[count:])
    state = compare.given(last, whole)
    better = state.judgement.adequate and state.judgement.error <= given.judgement.error
    return (state, whole, as_it_is(model) + entries[count:]) if better else None


def rise_is_chance(last: Judgement, given: Judgement, certain: bool) -> bool:
    """Has the error risen by no more than chance: while the record contradicts the given model and
    not the last one; or below the floor, if no chance explains what the last one has more
    (certain)."""
    if last.adequacy == "statistical" != given.adequacy:
        least = given.error + SEARCH.slack * last.floor
        return last.error <= max(least, CHANCE.above_floor * last.floor)
    return certain and last.adequate and last.error <= last.floor


def final_of(
    last: Judged, given: Judged, model: Model, added: int, certain: bool
) -> tuple[Judged | None, Model, list[Estimates]]:
    """(state, model, estimates) of the last model, or of what is left of it where its error has
    risen; the state is None where nothing is. certain: see rise_is_chance."""
    if not last.judgement.error > given.judgement.error:
        return last, *fitted_model(last, model)
    beside = beside_the_file(last, given, model, added)
    if beside is None and rise_is_chance(last.judgement, given.judgement, certain):
        return last, *fitted_model(last, model)
    return beside or (None, model, as_it_is(model))


def worse_held_out(before: Step, after: Step) -> bool:
    """Whether the error on the held-out recording has risen and is above a true model's."""
    error, floor = after.error_held_out, after.error_floor_held_out
    if before.error_held_out is None or error is None or floor is None:
        return False
    return error > before.error_held_out and error > CHANCE.above_floor * floor


def left(final: Judged, model: Model, recording: Recording, tried: Tried) -> Unexplained | None:
    """Where the final model fails, and what was excluded."""
    return unexplained_by(compare.of_state(final, model.column), recording, tried)


def number_added(found: Diagnosis, state: Judged) -> int:
    """How many of the effects that the search added a state of its path has."""
    given = len(found.states[-1].parts) - len(found.added)
    return 0 if state is found.states[0] else len(state.parts) - given


def against_final(found: Diagnosis, added: Sequence[str]) -> list[Lacking]:
    """What speaks against a final model with these of the effects that the search added."""
    dropped = set(found.added[len(added) :])
    return found.against + evidence.contradicting(
        one for one in found.ranking if one.kind in dropped
    )


def improved(
    recording: Recording,
    model: Model,
    found: Diagnosis,
    held_out: Recording | None = None,
    progress: Progress = lambda text: None,
    detail: int = 0,
) -> Improvement:
    """What a diagnosis comes to: errors, parameters, words. The final model is the last whose error
    has not risen."""
    given = compare.given(found.states[0], model)
    steps = [step_of(None, given, model, held_out)]
    base = refitted(model, found.states[0], given, held_out)
    for before, state in zip(found.states, found.states[1:]):
        joined = ", ".join(found.added[number_added(found, before) : number_added(found, state)])
        progress(f"adding {joined}")
        step = step_of(
            joined,
            state,
            fitted_model(state, model)[0] if held_out else None,
            held_out,
        )
        if worse_held_out(steps[-1], step):
            break
        steps.append(step)
    reached = found.states[len(steps) - 1]
    count = number_added(found, reached)
    certain = any(
        one.kind in found.added[:count] and one.gain > SEARCH.certain for one in found.ranking
    )
    last, final, entries = final_of(reached, given, model, 0 if held_out else count, certain)
    if last is not reached:  # the file's sizes do better than the likeliest ones: they stay
        steps = (
            [*steps[:-1], step_of(steps[-1].added, last, final, held_out)] if last else steps[:1]
        )
    added = found.added[: count if len(steps) > 1 else 0]
    judgement = last.judgement if last else given.judgement
    comparisons = [compare.of_state(given, model.column)] + (
        [compare.of_state(last, model.column)] if last and added else []
    )
    shown = described(model, found, base or steps[0], held_out, detail)
    tried = Tried(
        found.remaining,
        [part.kind for part in found.useless],
        found.doubtful,
        [kind for kind in found.added if kind not in added],
    )
    return Improvement(
        comparisons[0],
        found,
        steps,
        verdict_of(found, added, judgement),
        added,
        judgement,
        final,
        entries,
        shown,
        comparisons,
        base,
        evidence.notes(recording, model, added, found.ended),
        last or given,
        None if judgement.adequate else left(last or given, model, recording, tried),
        against_final(found, added) if judgement.adequate else [],
    )
