"""Forward selection by likelihood, then only what lowers the error (DESIGN 4)."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ..candidates import columns, doubts, filters, identifiable, lines
from ..candidates import ranking as candidates
from ..candidates.candidate import (
    Candidate,
    log_chance,
    log_tail_of_line,
    log_tail_of_multiple,
)
from ..candidates.identifiable import Alternative
from ..candidates.ranking import Trying
from ..effects import columns as columns_of
from ..effects import table
from ..inference import changes, modulation
from ..inference.parts import Part, without
from ..model import Model
from ..thresholds import CHANCE, SEARCH
from . import combs
from .fitting import errors_of, joined, judged, redrawn, with_parts
from .state import Judged, Progress, State

# Of free place in time: they fit whatever the model lacks somewhere, and must lower the error by as
# much.
EARNING = {"noise_step", "bias_step"}

# What stands beside white and slow noise in a spectrum, and the drifts that pass for slow noise.
OF_NOISE = frozenset(
    ("low_pass", "moving_average", "high_pass", "narrow_band", "sinusoid", "quantization")
    + ("rate_random_walk", "gauss_markov", "rate_ramp", "warm_up", "temperature")
)

Source = tuple[str, str | None]  # kind, and the column where any may be followed


def shock_candidate(state: State) -> Candidate:
    if state.shocks.count == 0:
        return Candidate("shocks", Part("shocks"), 0.0, 0.0)
    return Candidate("shocks", Part("shocks"), state.shocks.gain, state.shocks.log_p)


def ranking(
    state: State,
    skip: Iterable[str] = (),
    only: Collection[str] | None = None,
    progress: Trying = lambda kind, found: None,
) -> list[Candidate]:
    """Every effect that the model lacks, best first; none for a spoiled recording. `only`: of these
    kinds; `progress`: see ranked()."""
    if state.spoiled:
        return []
    skip = set(skip)
    skip |= set(table.TABLE) - set(only) if only else set()
    sought = set(columns_of.SOUGHT_TOGETHER) - skip
    more = (
        [
            one
            for one in columns.tried(state.bench, state.parts, state.fit, state.bench.gyro)
            if one.kind in sought
        ]
        if sought
        else []
    )
    found = candidates.ranked(state.bench, state.parts, state.fit, skip, more, progress)
    if "shocks" not in state.model_kinds and "shocks" not in skip:
        found.append(shock_candidate(state))
    return sorted(found, key=lambda c: c.log_p)


def significant(found: Sequence[Candidate]) -> bool:
    """Is the best of the candidates more than chance, as many as are tried."""
    return bool(found) and found[0].log_p + np.log(len(table.TABLE)) < np.log(CHANCE.family_wise)


def doubt(state: State, candidate: Candidate) -> str:
    """Why a candidate is not what it seems; "": it is."""
    return (
        candidate.doubt
        or doubts.doubt(state.bench, state.seen, state.parts, candidate)
        or doubts.of_image(state.bench, state.known, state.parts, candidate.part)
    )


def retold(state: State, given: int) -> State:
    """Gauss-Markov that was taken while another course hid its levels: now that the course is
    known, is it telegraph noise? Once per kind of course: each test costs as much as a step."""
    fresh = state.parts[-1]
    if any(part.kind == fresh.kind for part in state.parts[given:-1]):
        return state
    for part in state.parts[given:-1]:
        if part.kind == "gauss_markov" and fresh.role == "mean":
            rest = [other for other in state.parts if other is not part]
            start = Part("telegraph_noise", {"mean_dwell_s": 2 * part.shape["correlation_time_s"]})
            found = Candidate(start.kind, start, 0.0, -1e9)
            candidates.decode_states(state.bench, rest, found)
            if found.part.form == "decoded" and not doubts.of_motion(state.seen, found.part):
                parts = [*rest[:-1], found.part, fresh]
                return with_parts(state, parts)
    return state


def pruned(state: State, given: int) -> State:
    """Terms that a later one has made needless go (a random walk that was a ramp); those of the
    given model stay."""
    for part in state.parts[given:-1]:
        rest = [other for other in state.parts if other is not part]
        loss = SEARCH.certain if part.role == "events" else loss_without(state, rest, part)
        # a line narrower than the edge of a filter is none of its responses
        broad = part.kind != "narrow_band" or filters.is_wide(part)
        if loss < SEARCH.certain and part.role == "spectrum" and broad:
            rest = filters.responding(state.bench, rest)
            loss = loss_without(state, rest, part)
        if loss < CHANCE.tell_apart:
            return pruned(with_parts(state, rest), given)
    return state


def loss_without(state: State, rest: Sequence[Part], part: Part) -> float:
    """Log-likelihood that the model loses with this part."""
    if part.role != "variance":
        left = state.bench.fit(rest, near=state.fit.level)
        return state.fit.log_likelihood - left.log_likelihood
    recording = state.bench.recording
    blocks = state.bench.blocks(state.parts, state.fit)
    with_it, without = (
        changes.fit(blocks, modulation.variance_shapes(parts, recording, blocks))[2]
        for parts in (state.parts, rest)
    )
    return with_it - without


def nothing() -> Any:
    """An empty mapping, for a field."""
    return field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, eq=False)
class Tried:
    """The candidates that were tried beside a state, without the skipped kinds."""

    state: State
    skipped: frozenset[str]
    found: tuple[Candidate, ...]

    def covers(self, state: State, skip: frozenset[str]) -> bool:
        return self.state is state and self.skipped <= skip


@dataclass(frozen=True, eq=False)
class Search:
    """The way forward: the state reached, how many of its first parts are the given ones, and what
    was learned on the way. Each step returns another one."""

    begin: State
    state: State
    given: int
    draft: bool = False
    first: tuple[Candidate, ...] = ()  # candidates beside the first state
    last: tuple[Candidate, ...] = ()  # and beside this one
    alternatives: tuple[Alternative, ...] = ()
    doubtful: Mapping[str, str] = nothing()  # kind -> why it is not what it seems
    hopeless: frozenset[str] = frozenset()  # kinds that seemed to be chance
    undecided: tuple[Alternative, ...] | None = ()
    set_aside: frozenset[Source] = frozenset()  # source() of what is not what it seems
    outdone: frozenset[str] = frozenset()  # kinds that left again beside a later effect
    tried: Tried | None = None
    ended: str = ""  # the bound that ended it, in words; empty: nothing was left to take

    def ranked(self) -> tuple["Search", list[Candidate]]:
        """(the search, candidates beside its state as they are to be taken); those that are not
        what they seem are left out."""
        tried = self.candidates_here()
        found = self.allowed(tried)
        found, undecided = identifiable.settled(found, self.state.bench, self.state.parts)
        first, found = found[:1], [one for one in found if source(one.part) not in self.set_aside]
        if first != found[:1]:  # what the one set aside could not be told from
            undecided = None
        if undecided is None and self.state is self.begin:
            undecided = close_ones(found)
        return replace(
            self,
            tried=tried,
            undecided=None if undecided is None else tuple(undecided),
            first=self.first or tuple(found),
            last=tuple(found),
        ), found

    def skip(self) -> frozenset[str]:
        """Kinds that are not tried."""
        columnless = {kind for kind, column in self.set_aside if column is None}
        return self.hopeless | columnless

    def candidates_here(self) -> Tried:
        """All candidates; those beside the same state are not tried twice because some of them
        are put aside."""
        skip = self.skip()
        if self.tried and self.tried.covers(self.state, skip):
            return self.tried
        return Tried(self.state, skip, tuple(ranking(self.state, skip)))

    def allowed(self, tried: Tried) -> list[Candidate]:
        """Without the kinds that are not tried. One in the place of several parts is another
        question than one beside them."""
        skip = self.skip()
        return [one for one in tried.found if one.kind not in skip or len(one.replaces) > 1]

    def checked(self, candidate: Candidate) -> tuple["Search", bool]:
        """(the search, is the candidate what it seems); if not, it is put aside and why is kept."""
        part = candidate.part
        why = doubt(self.state, candidate)
        if not why:
            return self, True
        # levels that are seen contradict a continuum, whatever they come from
        aside: tuple[str, ...] = candidates.LORENTZIAN if candidate.doubt else ()
        aside = candidates.SLOW if part.form == "decoded" else aside
        way = replace(
            self, set_aside=self.set_aside | {source(part), *((kind, None) for kind in aside)}
        )
        return way.doubting(part.kind, about(part) + why), False

    def doubting(self, kind: str, why: str) -> "Search":
        """The search that keeps why a kind is not what it seems."""
        said = "; ".join(filter(None, [self.doubtful.get(kind), why]))
        return replace(self, doubtful=MappingProxyType({**self.doubtful, kind: said}))

    def without_comb(self) -> "Search":
        """The search without the added lines of one periodic signal: as long as it looked for other
        effects they were in the model, so that nothing else follows them."""
        comb = combs.one_signal(self.state.bench, self.state.parts)
        if comb is None:
            return self
        why, lines = comb
        added = [part for part in self.state.parts[self.given :] if part in lines]
        if not added:
            return self
        kept = [part for part in self.state.parts if part not in added]
        way = replace(self, state=with_parts(self.state, kept))
        for kind in dict.fromkeys(part.kind for part in added):
            way = way.doubting(kind, why)
        return way

    def take(self, candidate: Candidate) -> "Search":
        """The search with the candidate in its model."""
        given = len(without(self.state.parts[: self.given], candidate.replaces))
        whole = joined(self.state, candidate.part, candidate.replaces)
        if not self.draft:  # levels and a continuum have the same spectrum
            whole = retold(whole, given)
        after = pruned(whole, given)
        known = [one.kind for one in self.alternatives]
        put_off = {one.kind for one in self.last if one.log_p > np.log(SEARCH.put_off_chance)}
        return replace(
            self,
            alternatives=(
                *self.alternatives,
                *(one for one in self.undecided or () if one.kind not in known),
            ),
            hopeless=self.hopeless | put_off,
            outdone=self.outdone | set(Counter(whole.model_kinds) - Counter(after.model_kinds)),
            state=after,
            given=given,
        )

    def step(self) -> tuple["Search", bool]:
        """(the search one candidate further, is anything left)."""
        way, found = self.ranked()
        if significant(found):
            way, sound = way.checked(found[0])
            return (way.take(found[0]) if sound else way), True
        if way.hopeless and not way.draft:
            # kinds that seemed to be chance beside fewer terms are tried once more
            return replace(way, hopeless=frozenset()), True
        return way, False


def source(part: Part) -> Source:
    """What a coefficient is asked of: each column by itself where any may be followed."""
    return part.kind, part.shape["column"] if part.kind == "follows" else None


def about(part: Part) -> str:
    return f"{part.shape['column']}: " if part.kind == "follows" else ""


def earning(part: Part, rest: State) -> bool:
    """Must the part lower the error: also a line that comes and goes beside bands, which is what
    wanders in them; a warm-up that is over at once."""
    span_s = len(rest.bench.y) / rest.bench.recording.rate_hz
    return (
        part.kind in EARNING
        or part.kind == "intermittent_line"
        and "narrow_band" in rest.model_kinds
        or part.kind == "warm_up"
        and part.shape["time_constant_s"] < SEARCH.over_at_once * span_s
    )


def close_ones(found: Sequence[Candidate]) -> list[Alternative]:
    """Kinds that this recording cannot tell from the first, and how to tell them."""
    if not found:
        return []
    return [
        identifiable.undecided(found[0].kind, c.kind, table.find(c.kind).confirm)
        for c in found[1:]
        if c.kind != found[0].kind and c.log_p - found[0].log_p < CHANCE.tell_apart and c.gain > 0
    ]


def forward(state: State, given: int, progress: Progress, draft: bool = False) -> Search:
    """Candidates beyond chance one after the other, the likeliest first. What chance explains
    beside one state is not tried beside the next ones, until nothing else is left (a draft of the
    spectrum does not ask again). It ends after SEARCH.steps_most steps, or with the step that
    reaches SEARCH.fits_most fits."""
    way = Search(state, state, given, draft)
    work = state.bench.data.work
    most = work.fits + SEARCH.fits_most
    for _ in range(SEARCH.steps_most):
        if work.fits >= most:
            return replace(way, ended=f"{SEARCH.fits_most} fits")
        progress(
            f"trying {len(table.TABLE) - len(set(way.state.model_kinds))} effects in addition "
            f"to {way.state.kinds_said}"
        )
        way, more = way.step()
        if not more:
            return way
    return replace(way, ended=f"{SEARCH.steps_most} steps")


def by_chance(state: State, part: Part, rest: State) -> bool:
    """Would the part, which was beyond chance when it joined, not join beside the later ones."""
    if part.role not in ("spectrum", "mean") or part.form == "decoded":
        return False
    loss, kind = loss_without(state, rest.parts, part), part.kind
    log_p = log_chance(kind, loss)
    if kind in doubts.LINES:
        log_p = log_tail_of_line(part, loss, state.bench.data)
    elif kind == "line_follows":
        speeds = len(lines.speeds(state.bench.recording))
        log_p = log_tail_of_multiple(part, loss, state.bench.data, speeds)
    return bool(log_p + np.log(len(table.TABLE)) > np.log(CHANCE.family_wise))


def useful(state: State, given: int) -> tuple[State, list[Part], list[Part], list[Part]]:
    """The state without the added parts that leave the error where it is or raise it, and without
    those that later ones made useless; those that stay, what matters most first; those that do not,
    of either kind."""
    error, floor = errors_of(state)
    useless: list[Part] = []
    outdone: list[Part] = []
    kept: list[tuple[float, Part]] = []
    for part in reversed(state.parts[given:]):
        rest = with_parts(state, [other for other in state.parts if other is not part])
        without = errors_of(rest)[0]
        if (
            part.role != "events"
            and error > without + (-SEARCH.slack if earning(part, rest) else SEARCH.slack) * floor
            and not certain(state, part, rest, error, floor)
            and not (error <= without + SEARCH.slack * floor and settles(part, state, rest))
        ):
            state, useless, error = rest, [part, *useless], without
        elif (
            part is not state.parts[-1]
            and without <= error + SEARCH.slack * floor
            and by_chance(state, part, rest)
        ):
            state, outdone, error = rest, [part, *outdone], without
        else:
            kept = [(without - error, part), *kept]
    by_weight = [part for _, part in sorted(kept, key=lambda pair: -pair[0])]
    return state, by_weight, useless, outdone


def settles(part: Part, state: State, rest: State) -> bool:
    """Is a step of the noise all that the model without it, `rest`, lacks: noise that changes by
    little hardly moves an Allan deviation, but fails the tests in time."""
    return (
        part.kind == "noise_step"
        and loss_without(state, rest.parts, part) > SEARCH.certain
        and judged(rest).judgement.adequacy != "statistical"
        and judged(state).judgement.adequacy == "statistical"
    )


def certain(state: State, part: Part, rest: State, error: float, floor: float) -> bool:
    """Does the record contradict the model without the part, `rest`, while the error is no larger
    than a true model's: a line that hardly any averaging time shows."""
    return (
        error <= floor
        and not earning(part, rest)
        and loss_without(state, rest.parts, part) > SEARCH.certain
    )


def path(state: State, given: int, by_weight: Sequence[Part]) -> list[State]:
    """The states from the given effects to the last one, in the order found or what matters most
    first, whichever has more steps. The error never rises: where a part alone would raise it,
    several join at once."""
    best: list[State] = []
    for added in (state.parts[given:], by_weight):
        states = [
            with_parts(state, [*state.parts[:given], *added[:count]])
            for count in range(len(added) + 1)
        ]
        errors = [errors_of(one)[0] for one in states]
        kept = [0]
        for place in range(1, len(states)):
            if errors[place] <= errors[kept[-1]] or place == len(states) - 1:
                kept.append(place)
        if len(kept) > len(best):
            best = [states[place] for place in kept]
        if len(best) == len(states):
            break
    return best


def search(
    state: State, model: Model, progress: Progress
) -> tuple[list[Judged], Search, list[Part]]:
    """(judged states from the given effects to the last, the search, useless parts). Missing
    samples are drawn anew from what was found, and the search begins again."""
    given = len(model.terms)
    if state.spoiled:
        return [judged(state)], Search(state, state, given), []
    way = forward(state, given, progress, draft=state.known is not None)
    if state.known is not None:
        progress("simulating the missing samples with the effects found")
        state = redrawn(way.state, model)
        way = forward(state, given, progress)
    progress("testing which effects reduce the error")
    last, by_weight, useless, outdone = useful(way.state, way.given)
    way = replace(way, state=last, outdone=way.outdone | {part.kind for part in outdone})
    way = way.without_comb()
    last = way.state
    by_weight = [part for part in by_weight if part in last.parts]
    states = (
        [state, *path(last, way.given, by_weight)[1:]] if len(last.parts) > way.given else [state]
    )
    found = [judged(one, 0 < place < len(states) - 1) for place, one in enumerate(states)]
    reached = best(found)
    return reached, way, useless + [one.parts[-1] for one in found[len(reached) :]]


def of_noise(state: State, model: Model, progress: Progress) -> Judged:
    """The model with what its noise needs to fit, and no more: the sizes of white and slow noise
    are then right, and nothing else is tried."""
    given = len(model.terms)
    rounds = 1 if state.known is None else 2
    for place in range(rounds):
        if place and not judged(state, True).judgement.adequate:
            break
        state = redrawn(state, model) if place else state
        way = Search(state, state, given, True, hopeless=frozenset(table.TABLE) - OF_NOISE)
        found, more = judged(state), True
        for _ in range(SEARCH.noise_steps_most):
            if found.judgement.adequate or not more or state.spoiled:
                break
            progress(f"adding to {way.state.kinds_said}")
            before, (way, more) = way.state, way.step()
            if way.state is not before:
                found = judged(way.state)
        state = found
    return found


def best(found: list[Judged]) -> list[Judged]:
    """The states up to the last adequate one; all of them if none is adequate."""
    for count in range(len(found), 0, -1):
        last = found[count - 1]
        if last.judgement.adequate and 1 < count < len(found):
            last = judged(last)  # with the tests in time
        if last.judgement.adequate:
            return [*found[: count - 1], last]
    return found
