"""What a candidate or a recording has to say for itself, in one line each."""

import numpy as np

from ..effects import table

CLEARLY = 1.25  # times its floor, from which an error is more than a true model's
CLIPPED = 1e-3  # of the samples, that must lie on an extreme value
COARSE_VALUES = 32  # distinct values below which a recording is called coarse

def share(after, base):
    """Percent of the avoidable error that an effect alone takes from the refitted model `base`; None when `after` was not worked
    out (NaN), or when there is nothing to take: an error as of a true model."""
    if after != after or base.error < CLEARLY * base.error_floor:
        return None
    return 100 * min(1.0, max(0.0, (base.error - after) / (base.error - base.error_floor)))


def why(candidate, taken):
    """A candidate's evidence in one line. taken: its share() or None."""
    gain = f"likelihood gain {candidate.gain:.1f}" if candidate.gain >= 0.05 else "no gain in likelihood"
    power = -candidate.log_p / np.log(10)
    odds = " (no more than chance)" if power < 1 else f" (chance would do it once in {10 ** power:.2g})" if power <= 300 else \
        " (chance would do it once in more than 1e300)"
    part = "" if taken is None else f"; takes {taken:.0f} % of what the Allan deviation is off"
    return f"{gain}{odds if candidate.gain >= 0.05 else ''}{part}; {candidate.part.effect.physics}"


def notes(recording, model):
    """What is unusual about a recording and bears on every verdict."""
    return [note for note in (amplitude_note(recording.rate_dps(model.column)), *still_notes(recording, model)) if note]


def amplitude_note(values):
    """Samples on the rails, or few distinct values; None when neither is unusual."""
    levels, counts = np.unique(values, return_counts=True)
    if len(levels) < 2:
        return None
    rails = [count for count, inside in ((counts[0], counts[1]), (counts[-1], counts[-2]))
             if count > 2 * inside and count > CLIPPED * len(values)]
    if rails and len(levels) > 3:
        place = "the two extreme values" if len(rails) == 2 else "one extreme value"
        return f"{100 * sum(rails) / len(values):.2g} % of the samples lie on {place}: clipped?"
    if len(levels) < COARSE_VALUES:
        return f"The samples take only {len(levels)} distinct values: is the resolution too coarse for the noise?"
    return None


def still_notes(recording, model):
    """Effects that could not be tested because what drives them was recorded but did not move."""
    for need in dict.fromkeys(need for effect in table.TABLE.values() for need in effect.needs):
        columns = [name for name in recording.columns if name.startswith(need)]
        if columns and all(np.ptp(recording.columns[column]) == 0 for column in columns):
            kinds = [kind for kind, effect in table.TABLE.items() if need in effect.needs and kind not in model.kinds]
            if kinds:
                yield f"Could not be tested, as {', '.join(columns)} did not move: {', '.join(kinds)}."
