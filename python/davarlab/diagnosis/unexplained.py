"""What a model that fails leaves unexplained: where it fails, and what was excluded by which
evidence (DESIGN 7.5)."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..candidates.candidate import Candidate
from ..data.recording import Recording
from ..distributions import norm_sf
from ..effects import table
from ..inference import adequacy
from ..thresholds import CHANCE, PLACE
from .compare import Comparison
from .judge import Deviation

Evidence = Literal["chance", "no better fit", "doubtful", "worse", "untried"]
# What the place of a misfit suggests to measure next.
Hint = Literal["stretch", "line", "column", "slow", "fast", "quiet"]


@dataclass(frozen=True)
class Excluded:
    """A kind that does not explain the misfit. evidence: "chance" (p_value: of the gain, times the
    number of candidates), "no better fit" (significant, but the error does not fall), "doubtful"
    (for the reason `why`), "worse" (the error rises, here or on the held-out recording), "untried"
    (significant, but the search has ended)."""

    kind: str
    evidence: Evidence
    p_value: float | None = None
    why: str = ""


@dataclass(frozen=True)
class Unexplained:
    """deviation: where the Allan deviation is off most; duration_s: of the recording; frequency_hz,
    power: where the residual has significantly more or less power than the model, in ratios;
    column, correlation: the column that moves with the residual; excluded: each kind that was
    tried; untested: kind -> the columns that its test needs; hints: what to look at first; effects:
    the kinds of the model."""

    deviation: Deviation
    duration_s: float
    frequency_hz: float | None = None
    power: float | None = None
    column: str | None = None
    correlation: float | None = None
    excluded: Sequence[Excluded] = ()
    untested: Mapping[str, Sequence[str]] = field(default_factory=dict)
    hints: Sequence[Hint] = ()
    effects: Sequence[str] = ()


@dataclass(frozen=True)
class Tried:
    """What a search came to: candidates beside the last model, kinds that leave the error as it is,
    kind -> why it is doubtful, and kinds that raise the error."""

    ranking: Sequence[Candidate] = ()
    useless: Collection[str] = ()
    doubtful: Mapping[str, str] = field(default_factory=dict)
    worse: Collection[str] = ()


def unexplained_by(found: Comparison, recording: Recording, tried: Tried) -> Unexplained | None:
    """None where the model is adequate, or where it cannot be tested: the recording is implausible
    or has no cell of the Allan map."""
    judgement = found.judgement
    deviation = judgement.farthest
    if judgement.adequate or not judgement.testable or deviation is None:
        return None
    frequency, power = strongest(found)
    column, correlation = moving(found)
    return Unexplained(
        deviation,
        found.duration_s,
        frequency,
        power,
        column,
        correlation,
        excluded(tried),
        untested(recording, found.effects),
        hints(found, deviation, power, column),
        found.effects,
    )


def strongest(found: Comparison) -> tuple[float, float] | tuple[None, None]:
    """(Hz, power of the residual over the model's) of the least likely group of frequencies; None,
    None when none is significant."""
    f, ratio, counts = (np.asarray(one, float) for one in found.spectrum)
    there = counts > 0
    if not there.any():
        return None, None
    z = adequacy.normal_score(ratio[there], counts[there])
    worst = int(np.argmax(np.abs(z)))
    if 2 * norm_sf(abs(z[worst])) * len(z) >= CHANCE.family_wise:
        return None, None
    return float(f[there][worst]), float(ratio[there][worst])


def moving(found: Comparison) -> tuple[str, float] | tuple[None, None]:
    """The column that correlates with the residual, and the correlation; None, None when none is
    significant."""
    rows = [(p, name, r) for name, (r, p) in found.correlations.items()]
    p, name, r = min(rows, default=(1.0, "", 0.0))
    return (name, r) if p * len(rows) < CHANCE.family_wise and name else (None, None)


def excluded(tried: Tried) -> list[Excluded]:
    """Each kind once: the strongest evidence that its candidates had, the likeliest kind first."""
    rows = [Excluded(kind, "worse") for kind in tried.worse]
    rows += [Excluded(kind, "doubtful", why=why) for kind, why in tried.doubtful.items()]
    rows += [Excluded(kind, "no better fit") for kind in tried.useless]
    count = max(len(tried.ranking), len(table.TABLE))
    for candidate in sorted(tried.ranking, key=lambda one: one.log_p):
        p = min(1.0, count * float(np.exp(candidate.log_p)))
        significant = p < CHANCE.family_wise
        rows.append(Excluded(candidate.kind, "untried" if significant else "chance", p))
    return list({one.kind: one for one in reversed(rows)}.values())[::-1]


def untested(recording: Recording, kinds: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Kinds whose column was not logged, or does not change."""
    moves = [name for name, column in recording.columns.items() if np.ptp(column) > 0]
    return {
        kind: effect.needs
        for kind, effect in table.TABLE.items()
        if kind not in set(kinds)
        and any(not any(name.startswith(need) for name in moves) for need in effect.needs)
    }


def hints(
    found: Comparison, deviation: Deviation, power: float | None, column: str | None
) -> list[Hint]:
    span = deviation["stop_s"] - deviation["start_s"]
    samples = deviation["tau_s"] * found.rate_hz
    out: list[Hint] = []
    if span < PLACE.part_of_record * found.duration_s:
        out.append("stretch")
    if column:
        out.append("column")
    if power and power > 1:
        out.append("line")
    if deviation["ratio"] < 1:
        out.append("quiet")
    elif samples >= PLACE.slow_samples:
        out.append("slow")
    elif samples <= PLACE.fast_samples:
        out.append("fast")
    return out
