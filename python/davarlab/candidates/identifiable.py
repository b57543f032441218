"""What a recording can tell of heat, and what it cannot: lag, square, hysteresis, slope, a random
walk, a ramp explain much of each other. All are fitted on one footing, beside the temperature felt
at once; the likeliest is named, those as likely are said (DESIGN 4)."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data.recording import Recording
from ..effects import table
from ..inference import changes, modulation, refine
from ..inference.parts import Bench, Part, without
from ..inference.whittle import Fit
from ..thresholds import CHANCE, COLUMN, TRIES
from . import columns
from . import ranking as candidates
from .candidate import Candidate, log_tail

NOISE = ("rate_random_walk", "gauss_markov")
COURSES = ("rate_ramp", "warm_up")
HEAT = ("temperature", "temperature_squared", "temperature_hysteresis", "temperature_rate")
TRIALS = {
    "temperature": TRIES.of_column["temperature beside"],
    "temperature_squared": TRIES.of_column["temperature_squared"],
    "temperature_hysteresis": TRIES.of_column["temperature_hysteresis"],
    "temperature_rate": TRIES.of_kind["temperature_rate"],
}
NAMES = {
    "temperature": "temperature lag",
    "temperature_squared": "square of the temperature",
    "temperature_hysteresis": "temperature hysteresis",
    "temperature_rate": "slope of the temperature",
    "rate_random_walk": "random walk",
    "gauss_markov": "Gauss-Markov noise",
    "rate_ramp": "ramp",
    "warm_up": "warm-up",
}
AGAIN = (
    "run the temperature through two full cycles, or repeat one temperature step: "
    "a thermal effect is the same each time, {other} is not"
)
DECIDES = {
    frozenset(
        ("temperature", "temperature_rate")
    ): "change the temperature in one step and hold it: a lag fades with its own time constant, "
    "the effect of the slope ends with the slope",
    frozenset(
        ("temperature", "temperature_hysteresis")
    ): "heat and cool twice, once quickly and once slowly: the gap between heating and cooling "
    "shrinks for a lag and stays for hysteresis",
    frozenset(
        ("temperature", "temperature_squared")
    ): "heat and cool slowly over the whole range: a square follows one curve, a lag two",
    frozenset(
        ("temperature_squared", "temperature_hysteresis")
    ): "heat and cool slowly over the whole range: a square follows one curve, hysteresis two",
    frozenset(
        ("temperature_hysteresis", "temperature_rate")
    ): "heat and cool, then hold the temperature: hysteresis stays, the effect of the slope ends",
    frozenset(
        ("temperature_squared", "temperature_rate")
    ): "hold the temperature at both ends of its range: a square stays, the effect of the slope "
    "ends",
}


@dataclass
class Alternative:
    """A kind that this recording cannot distinguish from the reported one, and the measurement that
    would. named: the reported kind."""

    kind: str
    confirm: str
    named: str


@dataclass
class Rival:
    """An explanation: its gain over the temperature without lag, the candidate to add first for it,
    and whether it needs no second one."""

    kind: str
    gain: float
    first: Candidate | None
    whole: bool = True

    @property
    def score(self) -> float:
        """A second term must gain as much as distinguishes two effects."""
        return self.gain - (0.0 if self.whole else CHANCE.tell_apart)


Settled = tuple[list[Candidate], list[Alternative] | None]


def alternative(named: str, other: str) -> Alternative:
    apart = other if named in HEAT else named
    how = DECIDES.get(frozenset((named, other))) or AGAIN.format(
        other="a " + NAMES[apart] if apart != "gauss_markov" else NAMES[apart]
    )
    return undecided(named, other, f"{how}.")


def undecided(named: str, other: str, how: str) -> Alternative:
    """The alternative with the sentences for people. how: the measurement that decides."""
    names = [NAMES.get(kind, kind.replace("_", " ")) for kind in (named, other)]
    return Alternative(
        other, f"Undecided: {names[0]} or {names[1]}. To decide, {how[0].lower()}{how[1:]}", named
    )


def best_beside(bench: Bench, parts: Sequence[Part], fit: Fit, kind: str) -> Candidate | None:
    """The best candidate of a kind next to the parts: thermal kinds by columns.py, other kinds by
    their grid."""
    if kind in ("temperature_squared", "temperature_hysteresis"):
        return columns.thermal(bench, parts, fit, kind)
    return candidates.stationary(bench, parts, fit, table.find(kind))


class Bed:
    """Parts, the parts with the temperature without lag, and the candidates that were found."""

    def __init__(self, found: Sequence[Candidate], bench: Bench, parts: Sequence[Part]) -> None:
        self.found, self.bench, self.parts = (
            {candidate.kind: candidate for candidate in reversed(found)},
            bench,
            parts,
        )
        self.fit = bench.fit(parts)
        self.refine_lag()
        self.in_model = any(part.kind == "temperature" for part in parts)
        at_once = Part("temperature", {"lag_s": 0.0})
        self.base = parts if self.in_model else [*parts, at_once]
        self.base_fit = bench.fit(self.base)
        self.step = self.base_fit.log_likelihood - self.fit.log_likelihood
        self.plain = (
            None
            if self.in_model
            else Candidate(
                "temperature",
                at_once,
                self.step,
                log_tail(self.step, TRIES.of_column["temperature"]),
            )
        )

    def refine_lag(self) -> None:
        """The lag at the maximum of the likelihood, in the candidate itself: a few units decide."""
        late = self.found.get("temperature")
        if late and late.part.shape["lag_s"]:
            rest = without(self.parts, late.replaces)
            late.part = refine.refined(self.bench, [*rest, late.part], only=("temperature",))[-1]
            late.gain = self.bench.fit([*rest, late.part]).log_likelihood - self.fit.log_likelihood

    def over_base(self, candidate: Candidate) -> float:
        return candidate.gain - self.step

    def alone(self, kind: str) -> Rival | None:
        """The candidate as it was found: without the temperature felt at once, or in its place."""
        found = self.found.get(kind)
        return Rival(kind, self.over_base(found), found) if found else None

    def beside(self, kind: str) -> Rival | None:
        """Beside the temperature felt at once; of the two, what gains more joins first."""
        best = (
            self.found.get(kind)
            if self.in_model
            else best_beside(self.bench, self.base, self.base_fit, kind)
        )
        if best is None:
            return None
        first = (
            self.found.get(kind)
            if self.in_model
            else max((c for c in (self.plain, self.found.get(kind)) if c), key=lambda c: c.gain)
        )
        return Rival(kind, best.gain, first, self.in_model)

    def rivals(self) -> Iterator[Rival]:
        """One per kind, the simpler one unless the other gains CHANCE.tell_apart more."""
        kinds = [part.kind for part in self.parts]
        for kind in HEAT + NOISE + COURSES:
            if kind in kinds and not (kind == "temperature" and kind in self.found):
                continue
            simple = self.alone(kind)
            if kind == "temperature":
                if simple and simple.first and simple.first.part.shape["lag_s"] > 0:
                    yield simple
                continue
            full = self.beside(kind)
            if full and (not simple or full.gain > simple.gain + CHANCE.tell_apart):
                yield full
            elif simple:
                yield simple


def moving(recording: Recording) -> bool:
    columns = recording.columns
    return "temp_degC" in columns and bool(np.ptp(columns["temp_degC"]) > 0)


def likeliest_heat(rivals: Iterable[Rival]) -> Rival | None:
    """Where one of the ways to feel heat is beyond chance, the likeliest; of those that the
    recording cannot tell from it a lag, or else what needs no second term."""
    heat = [rival for rival in rivals if rival.kind in HEAT]
    best = max((rival.score for rival in heat if beyond_chance(rival)), default=np.inf)
    near = [rival for rival in heat if rival.score > best - CHANCE.tell_apart]
    return max(
        near, key=lambda rival: (rival.kind == "temperature", rival.whole, rival.gain), default=None
    )


def beyond_chance(rival: Rival) -> bool:
    return log_tail(rival.gain, TRIALS[rival.kind]) < float(np.log(CHANCE.family_wise))


def at_stake(found: Sequence[Candidate], bed: Bed) -> bool:
    """Is any way to feel heat beyond doubt by itself, or in the model already."""
    ways = [candidate.log_p for candidate in found if candidate.kind in HEAT] + (
        [bed.plain.log_p] if bed.plain else []
    )
    return bed.in_model or min(ways, default=0.0) + np.log(len(found)) < np.log(CHANCE.family_wise)


def at_once(found: Sequence[Candidate], bed: Bed) -> list[Candidate]:
    """The candidates with a temperature that is felt at once, not late by chance; in their
    order."""
    changed = [
        replace(bed.plain) if candidate.kind == "temperature" and bed.plain else candidate
        for candidate in found
    ]
    late = [
        candidate for candidate in changed if candidate.kind == "temperature" and candidate.replaces
    ]
    return (
        sorted([c for c in changed if c not in late], key=lambda c: c.log_p - 1e-9 * c.gain) + late
    )


def first(found: list[Candidate], candidate: Candidate | None) -> list[Candidate]:
    """The candidates with this one before the others, as unlikely by chance as any."""
    if candidate is None:
        return found
    rest = [
        other
        for other in found
        if other is not candidate and not (other.kind == candidate.kind and other.kind != "follows")
    ]
    return [
        replace(candidate, log_p=min([candidate.log_p] + [other.log_p for other in rest])),
        *rest,
    ]


def settled(found: list[Candidate], bench: Bench, parts: Sequence[Part]) -> Settled:
    """(candidates, alternatives): the one that is to be named and join first; what cannot be told
    from it. (found, None) where heat is not the question."""
    if found and found[0].kind == "noise_step":
        return noise_of_column(found, bench, parts)
    if not found or found[0].kind not in HEAT + NOISE + COURSES or not moving(bench.recording):
        return found, None
    bed = Bed(found, bench, parts)
    if not at_stake(found, bed):
        return found, None
    rivals = sorted(bed.rivals(), key=lambda rival: -rival.score)
    heat = likeliest_heat(rivals)
    other = max(
        (rival for rival in rivals if rival.kind in NOISE + COURSES),
        key=lambda rival: rival.score,
        default=None,
    )
    if heat is None or other and other.score > heat.score:
        found, named = outdone(found, bed)
        if named is None and heat and other and other.score <= heat.score + CHANCE.tell_apart:
            named = [alternative(other.kind, heat.kind)]
        return found, named
    near = [
        rival.kind
        for rival in rivals
        if rival is not heat and abs(rival.gain - heat.gain) < CHANCE.tell_apart and rival.gain > 0
    ]
    if heat.gain < COLUMN.lag_least and not set(near) & set(NOISE):
        near.append("rate_random_walk")
    return first(found, heat.first), [alternative(heat.kind, kind) for kind in near]


def noise_of_column(found: list[Candidate], bench: Bench, parts: Sequence[Part]) -> Settled:
    """A noise step may be the best interval of noise that goes with a column: that one comes first
    when it explains more. Its gain in the ranking was divided by what stays restless, that of the
    step was not."""
    most = np.log(CHANCE.family_wise / len(found))
    kinds = ("temperature_noise", "noise_follows")
    moving = next((c for c in found if c.kind in kinds and c.log_p < most), None)
    if moving is None:
        return found, None
    blocks = bench.blocks(parts, bench.fit(parts))
    whole, without = (
        changes.fit(blocks, modulation.variance_shapes(each, bench.recording, blocks))[2]
        for each in ([*parts, moving.part], parts)
    )
    if whole - without > found[0].gain + CHANCE.tell_apart:
        return first(found, moving), []
    return found, None


def outdone(found: list[Candidate], bed: Bed) -> Settled:
    """Nothing is beyond the temperature felt at once, or noise or a course explains more: the
    temperature, if it is worth anything, is felt at once. It comes before what does not gain
    distinguishably more: it has one free number, and no freedom in time."""
    found = at_once(found, bed)
    best = next(
        (c for c in found if c.kind not in HEAT or c.kind == "temperature" and not c.replaces),
        None,
    )
    plain = bed.plain
    rivals = [c for c in found if c.kind in (*HEAT, *NOISE, *COURSES) and c.kind != "temperature"]
    if best in rivals and plain and best.gain - plain.gain < CHANCE.tell_apart:
        near = [c.kind for c in rivals if c.gain > plain.gain - CHANCE.tell_apart]
        return first(found, plain), [alternative(plain.kind, kind) for kind in near]
    return first(found, best), None
