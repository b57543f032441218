"""The sensor's filter: which one, in which response, and is there noise behind it (DESIGN 4)."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Floats, Ints
from ..effects.device import BINS_MOST, learned
from ..effects.filters import half_power_hz
from ..inference import adequacy, refine
from ..inference.parts import Bench, Part, unit_spectrum, without
from ..inference.whittle import Fit, generalised_least_squares
from ..thresholds import CHANCE, SEARCH
from .candidate import Candidate, log_chance

MEMORY = {"low_pass", "moving_average"}
IMITATE = {"low_pass", "moving_average", "narrow_band", "gauss_markov"}


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
        if part.role == "filter" and not part.any_response:
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


def starts_of(bench: Bench) -> Ints:
    """Of groups of neighbouring bins, BINS_MOST at most."""
    bins = len(bench.data.counts)
    return np.arange(0, bins, -(-bins // BINS_MOST))


def merged(bench: Bench, per_bin: Floats | float) -> Floats:
    """Means over each group."""
    counts, starts = bench.data.counts, starts_of(bench)
    found: Floats = np.add.reduceat(counts * per_bin, starts) / np.add.reduceat(counts, starts)
    return found


def shape_of(bench: Bench, parts: Sequence[Part], filtered: Part | None) -> tuple[Part | None, int]:
    """The low-pass of any shape that the spectrum shows behind these parts, and how many numbers it
    has; `filtered`: the best so far. Bins with more than that are lines, which are not the
    filter's."""
    data = bench.data
    fit = bench.fit([*parts, filtered] if filtered else parts)
    energy = generalised_least_squares(data, bench.all_keys(parts), fit.level)[2]
    power = merged(bench, energy / data.counts)
    counts = np.add.reduceat(data.counts, starts_of(bench))
    fixed = merged(bench, bench.fixed(parts))
    front = None
    if filtered:
        front = merged(bench, (fit.level - bench.fixed(parts)) / bench.gain([filtered]))
    f = merged(bench, data.f_bin)
    angle = 2 * np.pi * f / data.rate_hz
    used = np.ones(len(f), bool)
    for _ in range(SEARCH.filter_rounds):
        text, numbers = learned(
            angle[used],
            power[used],
            counts[used] / 2,
            float(fixed[-1]),
            front[used] if front is not None else None,
        )
        if not text:
            return None, 0
        found = low_pass_of(text, data.rate_hz)
        passed = unit_spectrum(found, f, data.rate_hz) * (1.0 if front is None else front)
        level = np.median((power - fixed)[used] / passed[used])
        most = SEARCH.line_excess * (level * passed + fixed)
        lines = used & (power > most * (1 + SEARCH.line_sigmas * np.sqrt(2 / counts)))
        if not lines.any():
            break
        used &= ~lines
    return found, numbers


def low_pass_of(text: str, rate_hz: float) -> Part:
    return Part("low_pass", {"cutoff_hz": half_power_hz(text, rate_hz), "response": text})


def numbers_of(part: Part) -> int:
    """How many it has, its size included."""
    size = 0 if part.role == "filter" and not part.behind else 1
    return size + len(refine.numeric_shapes(part))


def is_wide(part: Part) -> bool:
    """A band as wide as the edge of a filter."""
    shape = part.shape
    return (
        part.kind == "narrow_band"
        and 2 * shape["half_width_hz"] > SEARCH.wide_band * shape["frequency_hz"]
    )


def of_any_shape(bench: Bench, parts: Sequence[Part], fit: Fit) -> Candidate | None:
    """A low-pass of any shape, in the place of a filter of the list with a wide band beside it, and
    of what else imitates the rest of it: slow noise or another filter. Sharp bands go with them, or
    stay as bands, whichever is likelier."""
    old = [part for part in parts if part.kind in IMITATE]
    if not {part.kind for part in old} & MEMORY or not any(map(is_wide, old)):
        return None
    wide = [part for part in old if part.kind != "narrow_band" or is_wide(part)]
    found = [in_place_of(bench, parts, fit, one) for one in ([old] if wide == old else [old, wide])]
    return max(filter(None, found), key=lambda one: one.gain, default=None)


def in_place_of(
    bench: Bench, parts: Sequence[Part], fit: Fit, old: Sequence[Part]
) -> Candidate | None:
    """A low-pass of any shape in the place of these parts."""
    others, part, best = without(parts, old), None, -np.inf
    for _ in range(SEARCH.filter_rounds):
        trial, numbers = shape_of(bench, others, part)
        if trial is None:
            break
        more = numbers - sum(map(numbers_of, old))
        gain = bench.fit([*others, trial]).log_likelihood - fit.log_likelihood
        gain -= 0.5 * np.log(bench.data.samples) * more
        if part and gain < best - 1:
            break
        part, best = trial, gain
    least, most = SEARCH.learned_least * bench.data.rate_hz, bench.data.rate_hz / 2
    if not part or not least <= part.shape["cutoff_hz"] < most:
        return None
    whole = [*others, part]
    left = bench.whitened(whole, bench.fit(whole))
    explains = best > 0 and adequacy.spectrum_score(left, len(whole)) > CHANCE.family_wise
    chance = SEARCH.first_log_p if explains else log_chance("low_pass", best)
    return Candidate("low_pass", part, best, chance, tuple(old))


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
