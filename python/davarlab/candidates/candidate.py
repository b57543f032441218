"""A candidate: an effect beside the model, its gain in likelihood and what chance would give
(DESIGN 4)."""

from dataclasses import dataclass

import numpy as np

from ..distributions import norm_logsf
from ..inference.parts import Part
from ..inference.whittle import Data
from ..thresholds import LINE, TRIES


@dataclass
class Candidate:
    """`gain` in log-likelihood, `log_p` of that gain by chance, the part as it would join."""

    kind: str
    part: Part
    gain: float
    log_p: float
    replaces: tuple[Part, ...] = ()  # the parts of the model in whose place it joins
    doubt: str = ""  # why it is not what it seems, where the search for it found out


def log_tail(gain: float, trials: float) -> float:
    return min(0.0, float(np.log(2 * trials) + norm_logsf(np.sqrt(max(2 * gain, 0.0)))))


def log_chance(kind: str, gain: float) -> float:
    """Of a gain by an effect with its own count of tries."""
    return log_tail(gain, TRIES.of_kind.get(kind, TRIES.of_own_effect))


def log_tail_of_line(part: Part, gain: float, data: Data) -> float:
    """Of a line among all that the record could have. Of a sharp one, half of the chance is shared
    by the slow ones, the fewer cycles in the record the more for each (4.1)."""
    if part.kind != "sinusoid":
        tries = TRIES.of_band * (data.samples / TRIES.band_samples) ** TRIES.band_growth
        return min(0.0, float(np.log(tries) - max(gain, 0.0)))
    slow = part.shape["frequency_hz"] * data.samples / data.rate_hz * np.log(data.samples)
    tries = 2 * TRIES.of_kind[part.kind] * min(slow, data.samples)
    return min(0.0, float(np.log(tries) - max(gain, 0.0)))


def log_tail_of_multiple(part: Part, gain: float, data: Data, columns: int) -> float:
    """Of a line at a multiple of one of so many columns, with a price for each knot of what is left
    beside it (4)."""
    knots = len(part.shape["apart_hz"].split())
    tries = np.log(TRIES.of_multiple * LINE.multiple_highest * data.samples * columns)
    return min(0.0, float(tries + knots * np.log(data.samples) - max(gain, 0.0)))
