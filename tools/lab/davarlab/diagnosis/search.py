"""Forward selection by likelihood, then only what lowers the error (DESIGN 4)."""

import numpy as np

from ..effects import table
from ..inference import changes, modulation
from ..inference.parts import Part
from . import candidates, cells, filters
from .candidate import Candidate
from .state import joined, judged, with_parts

FAMILY_WISE = 0.01
STEPS_MAX = 24
SLACK = 0.02  # of the floor, by which a likelier term may leave the error higher
HOPELESS = np.log(0.2)  # chance of a gain, from which a candidate is put off
CLOSE = 3.0  # log-likelihood units within which a recording cannot tell two effects
CERTAIN = 50.0  # log-likelihood units from which a part stays, whatever the filters do


def shock_candidate(state):
    if state.shocks.count == 0:
        return Candidate("shocks", Part("shocks"), 0.0, 0.0)
    return Candidate("shocks", Part("shocks"), state.shocks.gain, state.shocks.log_p)


def ranking(state, skip=(), only=None):
    """Every effect that the model lacks, best first; `only`: of these kinds."""
    skip = set(skip) | (set(table.TABLE) - set(only) if only else set())
    found = candidates.ranked(state.bench, state.parts, state.fit, skip)
    if "shocks" not in state.model_kinds and "shocks" not in skip:
        found.append(shock_candidate(state))
    return sorted(found, key=lambda c: c.log_p)


def significant(found):
    """Is the best of the candidates more than chance, as many as are tried."""
    return bool(found) and found[0].log_p + np.log(len(table.TABLE)) < np.log(FAMILY_WISE)


def retold(state, given):
    """Gauss-Markov that was taken while another course hid its levels: now that the course is known, is it telegraph noise?"""
    fresh = state.parts[-1]
    for part in state.parts[given:-1]:
        if part.kind == "gauss_markov" and fresh.role == "mean":
            rest = [other for other in state.parts if other is not part]
            start = Part("telegraph_noise", {"mean_dwell_s": 2 * part.shape["correlation_time_s"]})
            found = Candidate(start.kind, start, 0.0, -1e9)
            candidates.decode_states(state.bench, rest, found)
            if found.part.form == "decoded":
                parts = rest[:-1] + [found.part, fresh]
                return with_parts(state, parts)
    return state


def pruned(state, given):
    """Terms that a later one has made needless go (a random walk that was a ramp); those of the given model stay."""
    for part in state.parts[given:-1]:
        rest = [other for other in state.parts if other is not part]
        loss = CERTAIN if part.role == "events" else loss_without(state, rest, part)
        if loss < CERTAIN and part.role == "spectrum":
            rest = filters.responding(state.bench, rest)
            loss = loss_without(state, rest, part)
        if loss < CLOSE:
            return pruned(with_parts(state, rest), given)
    return state


def loss_without(state, rest, part):
    """Log-likelihood that the model loses with this part."""
    if part.role != "variance":
        return state.fit.log_likelihood - state.bench.fit(rest).log_likelihood
    recording = state.bench.recording
    blocks = changes.blocks_of(state.bench.residual(state.parts, state.fit), recording.rate_hz)
    with_it, without = (changes.fit(blocks, modulation.variance_shapes(parts, recording, blocks))[2]
                        for parts in (state.parts, rest))
    return with_it - without


def forward(state, given, progress):
    """(the state in which nothing more is likelier than chance, the ranking beside the first state and beside the last). What chance explains
    beside one state is not tried beside the next ones, until nothing else is left; lines are taken one after the other."""
    hopeless, only, first = set(), None, None
    for _ in range(STEPS_MAX):
        progress(f"looking for lines beside {len(state.parts)} effects" if only else
                 f"trying {len(table.TABLE) - len(set(state.model_kinds))} effects beside {', '.join(state.model_kinds)}")
        found = ranking(state, hopeless, only)
        first = first or found
        if significant(found):
            state = pruned(retold(joined(state, found[0].part), given), given)
            hopeless |= {candidate.kind for candidate in found if candidate.log_p > HOPELESS}
            only = {found[0].kind} if found[0].kind in candidates.REPEATED else None
        elif only:
            only = None
        elif hopeless:
            hopeless = set()
        else:
            break
    return state, first, found


def error_of(state):
    return cells.error_of(cells.cells_of(state, state.record))


def useful(state, given):
    """The state without the added parts that leave the error where it is or raise it, and those parts."""
    floor, useless = cells.floor_of(cells.cells_of(state, state.record)), []
    for part in reversed(state.parts[given:]):
        rest = with_parts(state, [other for other in state.parts if other is not part])
        if part.role != "events" and error_of(state) > error_of(rest) + SLACK * floor:
            state, useless = rest, [part, *useless]
    return state, useless


def path(state, given):
    """The states from the given effects to the last one, a part at a time, in the order found if the error falls all the way, else in the
    order in which it falls most."""
    added = state.parts[given:]
    states = [with_parts(state, state.parts[:given + count]) for count in range(len(added) + 1)]
    errors = [error_of(one) for one in states]
    if all(after <= before for before, after in zip(errors, errors[1:])):
        return states
    states, rest = states[:1], list(added)
    while rest:
        trials = [with_parts(state, states[-1].parts + [part]) for part in rest]
        best = int(np.argmin([error_of(trial) for trial in trials]))
        states.append(trials[best])
        rest.pop(best)
    return states


def search(state, given, progress):
    """(judged states from the given effects to the last, ranking beside the first, useless parts, ranking beside the last)."""
    last, first, found = forward(state, given, progress)
    progress("asking what lowers the error")
    last, useless = useful(last, given)
    states = path(last, given)
    return [judged(one, 0 < place < len(states) - 1) for place, one in enumerate(states)], first, useless, found
