"""What a candidate or a recording has to say for itself, in one line each."""

import numpy as np

from ..candidates import common_cause
from ..effects import table
from ..thresholds import CHANCE

WANDER = {"rate_random_walk", "gauss_markov", "rate_ramp", "warm_up"}


def share(after, base):
    """Percent of the avoidable error that an effect alone takes from the refitted model `base`; None when `after` was not worked
    out (NaN), or when there is nothing to take: an error as of a true model."""
    if after != after or base.error < CHANCE.above_floor * base.error_floor:
        return None
    return 100 * min(1.0, max(0.0, (base.error - after) / (base.error - base.error_floor)))


def why(candidate, taken):
    """A candidate's evidence in one line. taken: its share() or None."""
    gain = (
        f"likelihood gain {candidate.gain:.1f}"
        if candidate.gain >= 0.05
        else "no gain in likelihood"
    )
    power = -candidate.log_p / np.log(10)
    odds = (
        " (no more than chance)"
        if power < 1
        else f" (chance would do it once in {10**power:.2g})"
        if power <= 300
        else " (chance would do it once in more than 1e300)"
    )
    part = "" if taken is None else f"; takes {taken:.0f} % of what the Allan deviation is off"
    return f"{gain}{odds if candidate.gain >= 0.05 else ''}{part}; {candidate.part.effect.physics}"


def notes(recording, model, added=()):
    """What bears on every verdict and is no observation. added: the kinds that the model lacked."""
    shared = common_cause.several_axes(recording, model.column) if WANDER & set(added) else ""
    return [*still_notes(recording, model), *([f"A shared drift: {shared}."] if shared else [])]


def still_notes(recording, model):
    """Effects that could not be tested because what drives them was recorded but did not move."""
    for need in dict.fromkeys(need for effect in table.TABLE.values() for need in effect.needs):
        columns = [name for name in recording.columns if name.startswith(need)]
        if columns and all(np.ptp(recording.columns[column]) == 0 for column in columns):
            kinds = [
                kind
                for kind, effect in table.TABLE.items()
                if need in effect.needs and kind not in model.kinds
            ]
            if kinds:
                yield f"Could not be tested, as {', '.join(columns)} did not move: {', '.join(kinds)}."
