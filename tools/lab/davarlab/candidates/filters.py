"""The sensor's filter: which one, in which response, and is there noise behind it (DESIGN 4)."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Floats
from ..inference import refine
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit, generalised_least_squares
from ..thresholds import CHANCE, SEARCH
from .candidate import Candidate, log_chance

MEMORY = {"low_pass", "moving_average"}


def worth(bench: Bench, parts: Sequence[Part]) -> float:
    """Log-likelihood less the price of noise behind a filter, a size of its own (half the logarithm
    of the samples)."""
    price: float = 0.5 * np.log(bench.data.samples) * sum(bool(part.behind) for part in parts)
    return bench.fit(parts).log_likelihood - price


def unsaid(part: Part) -> list[Part]:
    """The part with every combination of what has a default in its shape and is not a number."""
    found = [part]
    for parameter in part.effect.parameters:
        if parameter.values and parameter.default is not None:
            found = [
                one.moved(parameter.name, value) for one in found for value in parameter.values
            ]
    return found


def responding(bench: Bench, parts: Sequence[Part]) -> list[Part]:
    """Filters in whichever response the gyro follows best beside the parts that are known by
    now."""
    best = list(parts)
    for index, part in enumerate(parts):
        if part.role == "filter":
            others = [replace(one, form=form) for one in unsaid(part) for form in part.effect.forms]
            trials = [
                refine.refined(bench, [*best[:index], other, *best[index + 1 :]], only=(part.kind,))
                for other in others
            ]
            best = max([best, *trials], key=lambda trial: worth(bench, trial))
    return best


def candidate(bench: Bench, parts: Sequence[Part], fit: Fit, crude: Candidate) -> Candidate:
    """A filter that gained on its grid, in its best response and at its best shape."""
    if crude.gain < SEARCH.crude_gain:
        return crude
    part = responding(bench, [*parts, crude.part])[-1]
    gain = worth(bench, [*parts, part]) - fit.log_likelihood
    return Candidate(part.kind, part, gain, log_chance(part.kind, gain))


def terms_per_bin(bench: Bench, parts: Sequence[Part]) -> Floats:
    """What each bin adds to the log-likelihood."""
    fit = bench.fit(parts)
    energy = generalised_least_squares(bench.data, bench.all_keys(parts), fit.level)[2]
    terms: Floats = -0.5 * (bench.data.counts * np.log(fit.level) + energy / fit.level)
    return terms


def simpler_memory(bench: Bench, parts: Sequence[Part], found: Iterable[Candidate]) -> None:
    """A low pass with noise behind it bends to whatever the model still lacks. It comes before a
    moving average, which has one number less, only where it is likelier by more than the bins
    scatter about their difference (Vuong 1989: both models may be wrong)."""
    by_kind = {candidate.kind: candidate for candidate in found}
    mean, low = by_kind.get("moving_average"), by_kind.get("low_pass")
    if (
        mean is None
        or low is None
        or not low.part.behind
        or min(mean.gain, low.gain - mean.gain) < 0
    ):
        return
    gains = terms_per_bin(bench, [*parts, low.part]) - terms_per_bin(bench, [*parts, mean.part])
    if gains.sum() < CHANCE.apart_sigmas * np.sqrt(gains @ gains):
        low.log_p = max(low.log_p, min(0.0, mean.log_p + 1e-6))
