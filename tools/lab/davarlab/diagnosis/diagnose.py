"""Which physical effect is missing: forward selection, then the whole model before the judge."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..data import counts, events
from ..effects import table
from ..errors import BadInput
from ..inference import adequacy, changes, modulation, refine
from ..inference.parts import as_spectra, Bench, Part, part_of
from . import candidates

FAMILY_WISE = 0.01
ADEQUATE = 0.01
STEPS_MAX = 4
MOVING = 0.02  # of the samples, that must differ from the one before
COARSE = 1.5  # counts per standard deviation from which the amplitudes of single samples are not those of a Gaussian
CLOSE = 3.0  # log-likelihood units within which a recording cannot tell two effects


@dataclass
class State:
    """A model at its best on one recording."""
    bench: Bench
    parts: list
    fit: object
    shocks: object
    blocks: object = None
    adequacy: object = None


@dataclass
class Diagnosis:
    """verdict: a kind, "none" or "unknown"; ranking: candidates for the model as given (its shapes refitted), best first;
    added: the kinds that forward selection took, in order; states: the model before and after each of them; remaining:
    candidates beside the last model that was tried."""
    verdict: str
    ranking: list
    alternatives: list
    added: list = field(default_factory=list)
    states: list = field(default_factory=list)
    remaining: list = field(default_factory=list)


def start(recording, model, progress=lambda text: None):
    """The given model's terms refitted on the recording."""
    progress("reading the spectrum")
    y = recording.rate_dps(model.column)
    known = counts.of(y, recording.rate_hz)
    shocks = events.find(y, recording.rate_hz, known.reach_dps if known else 0.0)
    if np.mean(np.diff(shocks.clean) != 0) < MOVING:
        raise BadInput(f"{recording.name}: column {model.column} hardly ever changes: there is no noise to compare a model with")
    bench = Bench(recording, shocks.clean, known)
    bench.logged = y
    parts = [part_of(term) for term in model.terms]
    parts = refine.refined(bench, with_forms(bench, parts), sweeps=2)
    parts = with_decoded_states(bench, parts)
    state = State(bench, parts, bench.fit(parts), shocks)
    return cleaned_again(state) if any(part.role == "mean" for part in parts) else state


def with_forms(bench, parts):
    """Variants of regressors, and what a model file need not say of a shape: whichever the gyro follows."""
    for index, part in enumerate(parts):
        others = [replace(part, form=form) for form in part.effect.forms]
        others += [part.moved(p.name, value) for p in part.effect.parameters if p.default is not None
                   for value in part.effect.grid[p.name](bench.recording)]
        trials = [parts] + [parts[:index] + [other] + parts[index + 1:] for other in others if other != part]
        if len(trials) > 1:
            parts = max(trials, key=lambda trial: bench.fit(trial).log_likelihood)
    return parts


def responding(bench, parts):
    """Filters in whichever response the gyro follows best beside the parts that are known by now."""
    for index, part in enumerate(parts):
        if part.role == "filter":
            trials = [parts[:index] + [part.moved(p.name, value)] + parts[index + 1:] for p in part.effect.parameters
                      if p.default is not None for value in part.effect.grid[p.name](bench.recording)]
            trials = [refine.refined(bench, trial, only=(part.kind,)) for trial in trials]
            parts = max([parts] + trials, key=lambda trial: bench.fit(trial).log_likelihood)
    return parts


def with_decoded_states(bench, parts):
    """Telegraph noise of the given model as its decoded course, when its levels can be seen."""
    for index, part in enumerate(parts):
        if part.kind == "telegraph_noise":
            trial = parts[:index] + parts[index + 1:]
            found = candidates.Candidate(part.kind, part, 0.0, -1e9)
            candidates.decode_states(bench, trial, found)
            parts = parts[:index] + [found.part] + parts[index + 1:]
    return parts


def relative_variance(state):
    """White level per sample over its mean, when the model lets it change; and the blocks it comes from."""
    blocks = state.bench.blocks(state.parts, state.fit)
    rows = modulation.variance_shapes(state.parts, state.bench.recording, blocks)
    if len(rows) == 1 and blocks.known is None:
        return None, blocks
    variance = changes.fit(blocks, rows)[1] * (1.0 if blocks.known is None else blocks.known)
    samples = np.minimum(np.arange(len(state.bench.y)) // blocks.length, len(variance) - 1)
    return variance[samples] / variance.mean(), blocks


def judged(state):
    variance, state.blocks = relative_variance(state)
    data = state.bench.data
    c = data.whitened(state.fit.level, state.fit.coefficients, state.bench.all_keys(state.parts))
    free = len(state.fit.sizes) + len(state.fit.coefficients)
    extra = {}
    if "shocks" not in state.model_kinds:
        extra["shocks"] = float(np.exp(state.shocks.log_p))
    level = np.interp(np.log(data.f), np.log(data.f_bin), state.fit.level)
    if variance is not None:
        share = modulation.white_share(state.bench, state.parts, state.fit)
        c = modulation.levelled(c, variance, np.interp(np.log(data.f), np.log(data.f_bin), share))
    noise = as_spectra(state.parts)
    if noise:
        fit = state.bench.fit(noise)
        other = data.whitened(fit.level, fit.coefficients, state.bench.all_keys(noise))
        extra["spectrum"] = max(adequacy.spectrum_score(c, free), adequacy.spectrum_score(other, free))
    known = state.bench.counts
    state.adequacy = adequacy.judge(c, level, free, state.bench.recording.rate_hz, extra, counted(state), *(known.suspends, known.kurtosis) if known else ())
    return state


def counted(state):
    """Does the gyro, or its angle (quantization), come in counts that its noise does not cover."""
    known = state.bench.counts
    return "quantization" in state.model_kinds or known is not None and known.q > COARSE * np.std(np.diff(state.bench.y)) / np.sqrt(2)


State.model_kinds = property(lambda self: [part.kind for part in self.parts])


def shock_candidate(state):
    if state.shocks.count == 0:
        return candidates.Candidate("shocks", Part("shocks"), 0.0, 0.0)
    return candidates.Candidate("shocks", Part("shocks"), state.shocks.gain, state.shocks.log_p)


def ranking(state):
    """Every effect that the model lacks, best first."""
    found = candidates.ranked(state.bench, state.parts, state.fit)
    if "shocks" not in state.model_kinds:
        found.append(shock_candidate(state))
    return sorted(found, key=lambda c: c.log_p)


def joined(state, part):
    """The model with one more part, shapes refitted."""
    parts = responding(state.bench, state.parts + [part])
    parts = refine.refined(state.bench, parts, only=() if part.kind == "telegraph_noise" else None)
    state = State(state.bench, parts, state.bench.fit(parts), state.shocks)
    return cleaned_again(state) if part.role == "mean" else state


def cleaned_again(state):
    """A course that is known now neither hides shocks nor passes for them: they are sought again beside it (6.1)."""
    course = state.bench.mean_course(state.parts, state.fit)
    known = state.bench.counts
    shocks = events.find(state.shocks.raw - course, state.bench.recording.rate_hz, known.reach_dps if known else 0.0)
    shocks.clean, shocks.raw = shocks.clean + course, state.shocks.raw
    if np.array_equal(shocks.clean, state.shocks.clean):
        return state
    bench = state.bench.with_gyro(shocks.clean)
    return State(bench, state.parts, bench.fit(state.parts), shocks)


def significant(candidate, count):
    return candidate.log_p + np.log(count) < np.log(FAMILY_WISE)


def close_ones(found):
    """Kinds that this recording cannot tell from the first."""
    return [c.kind for c in found[1:] if found[0].log_p > c.log_p - 1e9 and c.log_p - found[0].log_p < CLOSE
            and c.gain > 0]


def retold(state, given):
    """Gauss-Markov that was taken while another course hid its levels: now that the course is known, is it telegraph noise?"""
    fresh = state.parts[-1]
    for part in state.parts[given:-1]:
        if part.kind == "gauss_markov" and fresh.role == "mean":
            rest = [other for other in state.parts if other is not part]
            start = Part("telegraph_noise", {"mean_dwell_s": 2 * part.shape["correlation_time_s"]})
            found = candidates.Candidate(start.kind, start, 0.0, -1e9)
            candidates.decode_states(state.bench, rest, found)
            if found.part.form == "decoded":
                parts = rest[:-1] + [found.part, fresh]
                return State(state.bench, parts, state.bench.fit(parts), state.shocks)
    return state


def pruned(state, given):
    """Terms that a later one has made needless go (a random walk that was a ramp); those of the given model stay."""
    for part in state.parts[given:-1]:
        rest = [other for other in state.parts if other is not part]
        rest = responding(state.bench, rest) if part.role == "spectrum" else rest
        if part.role != "events" and loss_without(state, rest, part) < CLOSE:
            return pruned(State(state.bench, rest, state.bench.fit(rest), state.shocks), given)
    return state


def loss_without(state, rest, part):
    """Log-likelihood that the model loses with this part."""
    if part.role != "variance":
        return state.fit.log_likelihood - state.bench.fit(rest).log_likelihood
    recording = state.bench.recording
    blocks = state.bench.blocks(state.parts, state.fit)
    with_it, without = (changes.fit(blocks, modulation.variance_shapes(parts, recording, blocks))[2]
                        for parts in (state.parts, rest))
    return with_it - without


def diagnose(recording, model, progress=lambda text: None):
    """Forward selection from the given model. Cost: one to three seconds at 360 000 samples."""
    state = judged(start(recording, model, progress))
    states, added, first, close = [state], [], [], []
    for step in range(STEPS_MAX):
        progress(f"trying {len(table.TABLE) - len(state.parts)} effects (step {step + 1})")
        found = ranking(state)
        if step == 0:
            first = found
            close = close_ones(found) if significant(found[0], len(found)) else []
        if not found or not significant(found[0], len(found)):
            break
        state = judged(pruned(retold(joined(state, found[0].part), len(model.terms)), len(model.terms)))
        states.append(state)
        added.append(found[0].kind)
    added = [part.kind for part in states[-1].parts[len(model.terms):]]
    final = states[-1].adequacy
    adequate = final.p_value >= ADEQUATE
    verdict = "unknown" if not adequate else next((c.kind for c in first if c.kind in added), "none")
    return Diagnosis(verdict, first, close, added, states, found)
