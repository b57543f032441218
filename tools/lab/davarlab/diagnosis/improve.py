"""Fit, and the loop: compare, diagnose, add, refit, with the history of the error (DESIGN 9)."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..inference import estimate
from ..inference.parts import as_spectra
from ..model import Model, Term
from . import compare, diagnose, evidence


@dataclass
class Step:
    """The model after `added` joined (None: the model as given, or refitted); errors beside those that a true model would have."""
    added: str | None
    effects: list
    error: float
    error_floor: float
    error_held_out: float | None
    p_value: float
    error_floor_held_out: float | None = None


@dataclass
class Candidate:
    """A candidate as people read it."""
    kind: str
    gain: float
    p_value: float
    error_after: float
    error_held_out_after: float | None
    parameters: dict
    why: str


@dataclass
class Improvement:
    comparison: compare.Comparison
    diagnosis: diagnose.Diagnosis
    steps: list
    verdict: str
    model: Model
    estimates: list
    candidates: list = field(default_factory=list)
    comparisons: list = field(default_factory=list)  # one per step
    refitted: Step | None = None  # the given effects with their sizes fitted; None: those of the file are as good
    notes: list = field(default_factory=list)  # what is unusual about the recording, in words

    @property
    def base(self):
        """The given effects at their best."""
        return self.refitted or self.steps[0]

    @property
    def last(self):
        """The final model."""
        return self.steps[-1] if len(self.steps) > 1 else self.base


def estimates_of(state):
    """(state refitted for estimation, list of name -> Estimate per part)."""
    fit = state.bench.fit(state.parts, restricted=True)
    blocks = state.blocks
    found, noise = estimate.all_estimates(state.bench, state.parts, fit, blocks, state.shocks), as_spectra(state.parts)
    if noise:  # a decoded course takes some of the slow noise with it
        other = estimate.all_estimates(state.bench, noise, state.bench.fit(noise, restricted=True), blocks, state.shocks)
        found = [one if part.form == "decoded" else estimate.wider(one, two) for part, one, two in zip(state.parts, found, other)]
    return found


def fitted_model(state, model):
    """The model file of a fitted state, and its estimates."""
    found = estimates_of(state)
    terms = []
    for part, entry in zip(state.parts, found):
        names = [parameter.name for parameter in part.effect.parameters]
        terms.append(Term(part.kind, {name: entry[name].value for name in names if name in entry}))
    return Model(state.bench.recording.rate_hz, model.column, terms), found


def fit(recording, model, progress=lambda text: None):
    """Parameters of the model's own effects on this recording."""
    state = diagnose.judged(diagnose.start(recording, model, progress))
    progress("intervals")
    return fitted_model(state, model)


def held_out_errors(held_out, model):
    """(error, floor) on the held-out recording of the model as it is; None, None without one."""
    if held_out is None:
        return None, None
    cells = compare.cells_as_given(held_out, model, diagnose.start(held_out, model))
    return compare.error_of(cells), compare.floor_of(cells)


def step_of(added, result, model, held_out):
    """result: the comparison with the model."""
    error, floor = held_out_errors(held_out, model)
    return Step(added, result.effects, result.error, result.error_floor, error, result.p_value, floor)


def refitted(recording, model, state, held_out):
    """The step from the sizes of the file to the best ones; None when those of the file are as good (7.2)."""
    if compare.sizes_agree(state, compare.as_given(state, model)):
        return None
    better, _ = fitted_model(state, model)
    return replace(step_of(None, compare.compare(recording, better, fitted=state), better, held_out),
                   p_value=state.adequacy.p_value)


def with_candidate(found, candidate):
    """The model as given with one candidate: the second state of the search when it is the one that was taken first."""
    first, second = found.states[0], found.states[min(1, len(found.states) - 1)]
    taken = [part.kind for part in first.parts] + [candidate.kind] == second.model_kinds
    return second if taken else diagnose.joined(first, candidate.part, candidate.replaces)


def described(recording, model, found, base, held_out, detail):
    """The first `detail` candidates with their error after and parameters, the others with their gain. base: the step before them."""
    out = []
    for rank, candidate in enumerate(found.ranking):
        after, outside, parameters = float("nan"), None, {}
        if rank < detail:
            state = with_candidate(found, candidate)
            joined, entries = fitted_model(state, model)
            after = compare.error_as_given(recording, joined, state)
            outside = held_out_errors(held_out, joined)[0]
            parameters = entries[-1]
        out.append(Candidate(candidate.kind, candidate.gain, float(np.exp(candidate.log_p)), after, outside, parameters,
                             evidence.why(candidate, evidence.share(after, base))))
    return out


def improve(recording, model, held_out=None, progress=lambda text: None, detail=0):
    """Adds what is missing, step by step; the error is that of the model as given first, then of each refitted model."""
    found = diagnose.diagnose(recording, model, progress)
    return improved(recording, model, found, held_out, progress, detail)


def improved(recording, model, found, held_out=None, progress=lambda text: None, detail=0):
    """What a diagnosis comes to: errors, parameters, words."""
    comparison = compare.compare(recording, model, progress, found.states[0])
    steps = [step_of(None, comparison, model, held_out)]
    base = refitted(recording, model, found.states[0], held_out)
    comparisons = [comparison]
    final, entries = fitted_model(found.states[-1], model)
    for before, state in zip(found.states, found.states[1:]):
        progress(f"adding {state.parts[-1].kind}")
        better, _ = fitted_model(state, model)
        result = compare.compare(recording, better, fitted=state)
        comparisons.append(result)
        steps.append(replace(step_of(state.parts[-1].kind, result, better, held_out), p_value=state.adequacy.p_value))
    shown = described(recording, model, found, base or steps[0], held_out, detail)
    return Improvement(comparison, found, steps, found.verdict, final, entries, shown, comparisons, base,
                       evidence.notes(recording, model))
