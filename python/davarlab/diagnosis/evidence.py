"""The evidence for a candidate, and the notes on a recording, in one line each."""

from collections.abc import Iterable, Iterator
from typing import Protocol

import numpy as np

from ..candidates import common_cause
from ..candidates.candidate import Candidate
from ..data.recording import Recording
from ..effects import table
from ..model import Model
from ..thresholds import CHANCE

WANDER = {"rate_random_walk", "gauss_markov", "rate_ramp", "warm_up"}


class Errors(Protocol):
    """The error of a step, and the error that a true model would have."""

    error: float
    error_floor: float


def share(after: float, base: Errors) -> float | None:
    """Percent of the avoidable error of the refitted model `base` that an effect removes alone.
    None when `after` was not computed (NaN), or when `base` has no avoidable error."""
    if after != after or base.error < CHANCE.above_floor * base.error_floor:
        return None
    return 100 * min(1.0, max(0.0, (base.error - after) / (base.error - base.error_floor)))


def why(candidate: Candidate, taken: float | None) -> str:
    """The evidence for a candidate in one line. taken: its share() or None."""
    gain = (
        f"likelihood gain {candidate.gain:.1f}" if candidate.gain >= 0.05 else "no likelihood gain"
    )
    power = -candidate.log_p / np.log(10)
    odds = (
        " (not significant)"
        if power < 1
        else f" (p = {10**-power:.2g})"
        if power <= 300
        else " (p < 1e-300)"
    )
    part = "" if taken is None else f", removes {taken:.0f} % of the avoidable error"
    return f"{gain}{odds if candidate.gain >= 0.05 else ''}{part}. {candidate.part.effect.physics}"


def contradicting(found: Iterable[Candidate]) -> list[Candidate]:
    """What speaks against a model that fits: candidates beyond chance, as many as are tried, the
    likeliest of each kind first."""
    most = np.log(CHANCE.family_wise / len(table.TABLE))
    sure = sorted((one for one in found if one.log_p < most), key=lambda one: one.log_p)
    best: dict[str, Candidate] = {}
    for one in sure:
        best.setdefault(one.kind, one)
    return list(best.values())


def notes(
    recording: Recording, model: Model, added: Iterable[str] = (), ended: str = ""
) -> list[str]:
    """Notes that apply to every verdict and are not observations. added: the kinds that the model
    lacked; ended: the bound that ended the search."""
    shared = common_cause.several_axes(recording, model.column) if WANDER & set(added) else ""
    said = [f"Shared drift: {shared}."] if shared else []
    if ended:
        said.append(
            f"The search ended after {ended}, its limit. It had not tried everything, so further "
            "effects may be missing. To continue, save the model with improve and diagnose it."
        )
    return [*still_notes(recording, model), *said]


def still_notes(recording: Recording, model: Model) -> Iterator[str]:
    """Effects that could not be tested because the column that drives them is constant."""
    for need in dict.fromkeys(need for effect in table.TABLE.values() for need in effect.needs):
        columns = [name for name in recording.columns if name.startswith(need)]
        if columns and all(np.ptp(recording.columns[column]) == 0 for column in columns):
            kinds = [
                kind
                for kind, effect in table.TABLE.items()
                if need in effect.needs and kind not in model.kinds
            ]
            if kinds:
                yield f"Not tested, because {', '.join(columns)} is constant: {', '.join(kinds)}."
