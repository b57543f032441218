"""Forward selection by likelihood, then only what lowers the error (DESIGN 4)."""

import numpy as np

from ..candidates import columns, doubts, filters, identifiable
from ..candidates import ranking as candidates
from ..candidates.candidate import Candidate
from ..effects import columns as columns_of
from ..effects import table
from ..inference import changes, modulation
from ..inference.parts import Part
from .state import errors_of, joined, judged, redrawn, with_parts

FAMILY_WISE = 0.01
STEPS_MAX = 24
SLACK = 0.02  # of the floor, by which a likelier term may leave the error higher
EARNING = {
    "noise_step",
    "bias_step",
}  # of free place in time: they fit whatever the model lacks somewhere, and must lower the error by as much
AT_ONCE = 0.01  # of the record
BANDS = 8  # from here on each one must lower the error, or it is the last
PUT_OFF = 0.5  # of the gain that is taken, below which what is costly to seek waits for its turn
HOPELESS = np.log(0.2)  # chance of a gain, from which a candidate is put off
CLOSE = 3.0  # log-likelihood units within which a recording cannot tell two effects
CERTAIN = 50.0  # log-likelihood units from which a part stays, whatever the filters do


def shock_candidate(state):
    if state.shocks.count == 0:
        return Candidate("shocks", Part("shocks"), 0.0, 0.0)
    return Candidate("shocks", Part("shocks"), state.shocks.gain, state.shocks.log_p)


def ranking(state, skip=(), only=None, progress=lambda kind, found: None):
    """Every effect that the model lacks, best first; `only`: of these kinds; `progress`: see ranked()."""
    skip = set(skip) | (set(table.TABLE) - set(only) if only else set())
    asked = set(columns_of.SOUGHT_TOGETHER) - skip
    more = (
        [
            one
            for one in columns.tried(state.bench, state.parts, state.fit, state.bench.gyro)
            if one.kind in asked
        ]
        if asked
        else []
    )
    found = candidates.ranked(state.bench, state.parts, state.fit, skip, more, progress)
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
            if found.part.form == "decoded" and not doubts.of_motion(state.seen, found.part):
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
    blocks = state.bench.blocks(state.parts, state.fit)
    with_it, without = (
        changes.fit(blocks, modulation.variance_shapes(parts, recording, blocks))[2]
        for parts in (state.parts, rest)
    )
    return with_it - without


class Search:
    """The way forward: the state reached, how many of its first parts are the given ones, and what was learned on the way."""

    def __init__(self, state, given, draft=False):
        self.begin, self.state, self.given, self.draft = state, state, given, draft
        self.first, self.last, self.alternatives, self.doubtful = None, [], [], {}
        self.hopeless, self.only, self.bands, self.undecided, self.set_aside = (
            set(),
            None,
            BANDS,
            [],
            set(),
        )
        self.question, self.skipped, self.answer = (None, None), set(), []
        self.waves = []  # Hz, of courses that repeat and are no sine wave
        self.idle = {}  # kinds that left the error where it was: the states and parts

    def ranked(self):
        """Candidates beside the state as they are to be taken; those that are not what they seem are left out."""
        found = self.answered()
        if not self.only:
            found, self.undecided = identifiable.settled(found, self.state.bench, self.state.parts)
        first, found = (
            found[:1],
            [
                one
                for one in found
                if source(one.part) not in self.set_aside
                and not any(
                    doubts.times_of(self.state.bench, wave, one.part) for wave in self.waves
                )
            ],
        )
        if first != found[:1]:  # what the one set aside could not be told from
            self.undecided = None
        if self.undecided is None and self.state is self.begin and not self.only:
            self.undecided = close_ones(found)
        self.first, self.last = self.first or found, found
        return found

    def answered(self):
        """All candidates; those beside the same state are not asked for twice because some of them are put aside."""
        skip = (
            self.hopeless
            | {kind for kind, column in self.set_aside if column is None}
            | self.aside()
        )
        question = (self.state, self.only)
        if (
            question[0] is not self.question[0]
            or question[1] != self.question[1]
            or not self.skipped <= skip
        ):
            self.question, self.skipped, self.answer = (
                question,
                skip,
                ranking(self.state, skip, self.only),
            )
        return [one for one in self.answer if one.kind not in skip]

    def aside(self):
        """Kinds that left the error where it was, twice; further bands, which would only follow what the model lacks elsewhere."""
        spent = {
            kind
            for kind, tries in self.idle.items()
            if len(tries) > 1 or tries[-1][0] is self.state
        }
        return spent | (
            {"narrow_band"} if self.state.model_kinds.count("narrow_band") >= self.bands else set()
        )

    def questioned(self, candidate):
        """Is the candidate what it seems; if not, it is put aside and why is kept."""
        part = candidate.part
        why = doubts.doubt(self.state.bench, self.state.seen, self.state.parts, candidate)
        if why:
            wave = doubts.wave_of(self.state.bench, [*self.state.parts, part])
            if wave and doubts.times_of(self.state.bench, wave, part):
                self.waves.append(wave)
                self.state = without_wave(self.state, self.given, wave)
            else:
                self.set_aside.add(source(part))
            self.doubtful[part.kind] = "; ".join(
                filter(None, [self.doubtful.get(part.kind), about(part) + why])
            )
        return not why

    def take(self, candidate):
        given = self.given - any(
            part is candidate.replaces for part in self.state.parts[: self.given]
        )
        after = pruned(retold(joined(self.state, candidate.part, candidate.replaces), given), given)
        if earning(candidate.part, self.state) and not self.lower(after):
            self.idle.setdefault(candidate.kind, []).append((self.state, candidate.part))
            self.hopeless, self.only = self.hopeless | {candidate.kind}, None
            return
        if after.model_kinds.count("narrow_band") > BANDS - 1 and candidate.kind == "narrow_band":
            self.bands = after.model_kinds.count("narrow_band") + self.lower(after)
        known = [one.kind for one in self.alternatives]
        self.alternatives += [one for one in self.undecided or [] if one.kind not in known]
        self.hopeless |= {
            one.kind for one in self.last if one.log_p > HOPELESS or waits(one, candidate)
        }
        self.only = self.beside(candidate)
        self.state, self.given = after, given

    def lower(self, after):
        """Does the error fall by more than the slack."""
        error, floor = errors_of(after)
        return error < errors_of(self.state)[0] - SLACK * floor

    def beside(self, taken):
        """What is asked next: lines one after the other. Bands imitate the slope of a filter, so it is asked among them while it gains as much."""
        kind, near = (
            taken.kind,
            {one.kind for one in self.last if not self.only or one.gain > PUT_OFF * taken.gain},
        )
        if kind == "narrow_band":
            return {kind} | (
                filters.MEMORY & near if not filters.MEMORY & set(self.state.model_kinds) else set()
            )
        if kind in filters.MEMORY and self.only:
            return self.only - filters.MEMORY
        return {kind} if kind in candidates.REPEATED else None

    def step(self):
        """One candidate further, or one way to look less; False: nothing is left."""
        found = self.ranked()
        if significant(found):
            if self.questioned(found[0]):
                self.take(found[0])
            return True
        if (
            self.only or self.hopeless and not self.draft
        ):  # what seemed to be chance beside fewer terms is asked once more
            self.hopeless = self.hopeless if self.only else set()
            self.only = None
            return True
        return False


def without_wave(state, given, base_hz):
    """The state without the added lines that are harmonics of one wave."""
    wave = [part for part in state.parts[given:] if doubts.times_of(state.bench, base_hz, part)]
    return with_parts(state, [part for part in state.parts if part not in wave]) if wave else state


def source(part):
    """What a coefficient is asked of: each column by itself where any may be followed."""
    return part.kind, part.shape["column"] if part.kind == "follows" else None


def about(part):
    return f"{part.shape['column']}: " if part.kind == "follows" else ""


def earning(part, rest):
    """Must the part lower the error: also a line that comes and goes beside bands, which is what wanders in them; a warm-up that is over at once."""
    span_s = len(rest.bench.y) / rest.bench.recording.rate_hz
    return (
        part.kind in EARNING
        or part.kind == "intermittent_line"
        and "narrow_band" in rest.model_kinds
        or part.kind == "warm_up"
        and part.shape["time_constant_s"] < AT_ONCE * span_s
    )


def waits(one, taken):
    return one.kind == "intermittent_line" and one.gain < PUT_OFF * taken.gain


def close_ones(found):
    """Kinds that this recording cannot tell from the first, and how to tell them."""
    if not found:
        return []
    return [
        identifiable.Alternative(c.kind, table.find(c.kind).confirm)
        for c in found[1:]
        if c.kind != found[0].kind and c.log_p - found[0].log_p < CLOSE and c.gain > 0
    ]


def forward(state, given, progress, draft=False):
    """Candidates beyond chance one after the other, the likeliest first. What chance explains beside one state is not tried beside the
    next ones, until nothing else is left (a draft of the spectrum does not ask again); lines are taken one after the other."""
    way = Search(state, given, draft)
    for _ in range(STEPS_MAX):
        progress(
            f"looking for lines in addition to {len(way.state.parts)} effects"
            if way.only
            else f"trying {len(table.TABLE) - len(set(way.state.model_kinds))} effects in addition to {', '.join(way.state.model_kinds)}"
        )
        if not way.step():
            break
    return way


def useful(state, given):
    """The state without the added parts that leave the error where it is or raise it; those that stay, what matters most first; those that
    do not."""
    (error, floor), useless, kept = errors_of(state), [], []
    for part in reversed(state.parts[given:]):
        rest = with_parts(state, [other for other in state.parts if other is not part])
        without = errors_of(rest)[0]
        if (
            part.role != "events"
            and error > without + (-SLACK if earning(part, rest) else SLACK) * floor
            and not certain(state, part, rest, error, floor)
        ):
            state, useless, error = rest, [part, *useless], without
        else:
            kept = [(without - error, part), *kept]
    return state, [part for _, part in sorted(kept, key=lambda pair: -pair[0])], useless


def certain(state, part, rest, error, floor):
    """Does the record contradict the model without the part, `rest`, while the error is no larger than a true model's: a line that hardly any
    averaging time shows."""
    return (
        error <= floor
        and not earning(part, rest)
        and loss_without(state, rest.parts, part) > CERTAIN
    )


def path(state, given, by_weight):
    """The states from the given effects to the last one, a part at a time: in the order found if the error falls all the way, else what
    matters most first."""
    for added in (state.parts[given:], by_weight):
        states = [
            with_parts(state, state.parts[:given] + added[:count])
            for count in range(len(added) + 1)
        ]
        errors = [errors_of(one)[0] for one in states]
        if all(after <= before for before, after in zip(errors, errors[1:])):
            break
    return states


def search(state, model, progress):
    """(judged states from the given effects to the last, the search, useless parts). Missing samples are drawn anew from what was found,
    and the search begins again."""
    given = len(model.terms)
    way = forward(state, given, progress, draft=state.known is not None)
    if state.known is not None:
        progress("simulating the missing samples with the effects found")
        state = redrawn(way.state, model)
        way = forward(state, given, progress)
    progress("testing which effects reduce the error")
    last, by_weight, useless = useful(way.state, way.given)
    useless += [tries[-1][1] for kind, tries in way.idle.items() if kind not in last.model_kinds]
    states = (
        [state, *path(last, way.given, by_weight)[1:]] if len(last.parts) > way.given else [state]
    )
    return (
        [judged(one, 0 < place < len(states) - 1) for place, one in enumerate(states)],
        way,
        useless,
    )
