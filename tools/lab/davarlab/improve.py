"""Fit, and the loop: compare, diagnose, add, refit, with the history of the error (DESIGN 9)."""

from dataclasses import dataclass, field

import numpy as np

from . import compare, diagnose, estimate
from .model import Model, Term
from .parts import as_spectra


@dataclass
class Step:
    """The model after `added` joined (None: the model as given)."""
    added: str | None
    effects: list
    error: float
    error_floor: float
    error_held_out: float | None
    p_value: float


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


def held_out_error(held_out, model):
    return compare.error_as_given(held_out, model, diagnose.start(held_out, model)) if held_out is not None else None


def words(candidate, before, after, floor):
    """Evidence in the words of an engineer."""
    share = 100 * max(0.0, min(1.0, (before - after) / max(before - floor, 1e-9)))
    odds = f"chance would do it once in {10 ** min(300, -candidate.log_p / np.log(10)):.2g}" if candidate.log_p < -2.3 else \
        "no more than chance"
    return (f"likelihood gain {candidate.gain:.1f} ({odds}); takes {share:.0f} % of what the Allan deviation is off; "
            f"{candidate.part.effect.physics}")


def misfit_words(comparison):
    """The worst stretch of taus of the whole record, in one sentence."""
    whole = [cell for cell in comparison.cells if cell.start_s == 0 and cell.stop_s >= comparison.samples /
             comparison.rate_hz * 0.99]
    off = [cell for cell in whole if abs(cell.z) > 3]
    if not off:
        return "over the whole record the Allan deviation agrees with the model at every tau"
    worst = max(off, key=lambda cell: abs(cell.z))
    return (f"measured ADEV is {worst.ratio:.2g} times the model at {worst.tau_s:g} s "
            f"(off between {off[0].tau_s:g} and {off[-1].tau_s:g} s)")


def with_candidate(found, candidate):
    """The model as given with one candidate: the second state of the search when it is the one that was taken first."""
    first, second = found.states[0], found.states[min(1, len(found.states) - 1)]
    taken = [part.kind for part in first.parts] + [candidate.kind] == second.model_kinds
    return second if taken else diagnose.joined(first, candidate.part)


def described(recording, model, found, comparison, held_out, detail):
    """The first `detail` candidates with their error after and parameters, the others with their gain."""
    out = []
    for rank, candidate in enumerate(found.ranking):
        after, outside, parameters = float("nan"), None, {}
        if rank < detail:
            state = with_candidate(found, candidate)
            joined, entries = fitted_model(state, model)
            after = compare.error_as_given(recording, joined, state)
            outside = held_out_error(held_out, joined)
            parameters = entries[-1]
        out.append(Candidate(candidate.kind, candidate.gain, float(np.exp(candidate.log_p)), after, outside, parameters,
                             words(candidate, comparison.error, after if after == after else comparison.error,
                                   comparison.error_floor)))
    return out


def improve(recording, model, held_out=None, progress=lambda text: None, detail=0):
    """Adds what is missing, step by step; the error is that of the model as given first, then of each refitted model."""
    found = diagnose.diagnose(recording, model, progress)
    return improved(recording, model, found, held_out, progress, detail)


def improved(recording, model, found, held_out=None, progress=lambda text: None, detail=0):
    """What a diagnosis comes to: errors, parameters, words."""
    comparison = compare.compare(recording, model, progress, found.states[0])
    steps = [Step(None, model.kinds, comparison.error, comparison.error_floor, held_out_error(held_out, model),
                  comparison.p_value)]
    comparisons = [comparison]
    final, entries = fitted_model(found.states[-1], model)
    for before, state in zip(found.states, found.states[1:]):
        progress(f"adding {state.parts[-1].kind}")
        better, _ = fitted_model(state, model)
        result = compare.compare(recording, better, fitted=state)
        comparisons.append(result)
        steps.append(Step(state.parts[-1].kind, state.model_kinds, result.error, result.error_floor,
                          held_out_error(held_out, better), state.adequacy.p_value))
    shown = described(recording, model, found, comparison, held_out, detail)
    return Improvement(comparison, found, steps, found.verdict, final, entries, shown, comparisons)
