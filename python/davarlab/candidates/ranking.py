"""Every effect that a model lacks, tried: the gain in likelihood and what chance would give
(DESIGN 4)."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording
from ..effects import table
from ..effects.base import Effect, Values
from ..effects.columns import SOUGHT_TOGETHER
from ..inference import changes, modulation, refine, states
from ..inference.changes import Blocks
from ..inference.parts import Bench, Part, as_spectra
from ..inference.whittle import Fit, generalised_least_squares, score_of_column, score_of_row
from ..thresholds import CHANCE, FIT, LEVELS, SEARCH
from . import drifting, filters, intermittent, lines, steps
from .candidate import Candidate, log_chance

LORENTZIAN = ("telegraph_noise", "gauss_markov")
SLOW = (*LORENTZIAN, "rate_random_walk")  # noise that imitates levels
SEARCHES: dict[str, Callable[[Bench, Sequence[Part], Fit], tuple[Part, float, float] | None]] = {
    "bias_step": steps.search,
    "intermittent_line": intermittent.search,
}  # (part, gain, log p)
SIMPLER = (
    "rate_random_walk",
    "gauss_markov",
    "rate_ramp",
    "warm_up",
    "temperature",
    "telegraph_noise",
)  # than a step
BENDS = (
    ("rate_ramp", "warm_up"),
    ("rate_random_walk", "gauss_markov"),
    ("rate_random_walk", "telegraph_noise"),
    ("gauss_markov", "telegraph_noise"),
    ("sinusoid", "narrow_band"),
    ("warm_up", "high_pass"),
)

SWITCHED = (
    "the rate stays on levels or passes through them, but its switches are not random: their times "
    "are too even, or it moves from each level only to the next. Something on the same supply "
    "switches or charges. Log the supply voltage"
)

# Receives the kind that is tried next and what was found so far (None: nothing of a kind). It may
# raise.
Trying = Callable[[str, Sequence[Candidate | None]], None]


def shapes_of(effect: Effect, recording: Recording) -> list[Values]:
    """The product of an effect's grids; what a model file need not say of a filter is at its
    default: it is asked when the filter joins."""
    found: list[Values] = [{}]
    for name in effect.shape_names:
        parameter = next(p for p in effect.parameters if p.name == name)
        late = effect.role == "filter" and parameter.default is not None
        grid = effect.grid.get(name)
        values: list[Any] = [parameter.default] if late else list(grid(recording)) if grid else []
        found = [
            {**shape, name: value if isinstance(value, (str, int)) else float(value)}
            for shape in found
            for value in values
        ]
    return found


def available(effect: Effect, recording: Recording) -> bool:
    return all(any(name.startswith(need) for name in recording.columns) for need in effect.needs)


def robust_gain(bench: Bench, parts: Sequence[Part], part: Part) -> float:
    """The gain with the scatter of the products themselves: vibration must not pass for correlation
    with vibration."""
    full = bench.fit([*parts, part])
    white = np.sqrt(bench.data.at_ordinates(full.level))
    column = np.zeros(len(white) + 1)
    known = bench.data.columns[bench.keys(part)[0]][0]
    column[1 : len(known) + 1] = known / white[: len(known)]
    x = signals.inverse(column)
    spread = np.sum((x * bench.residual([*parts, part], full)) ** 2)
    return float(
        (bench.coefficients_of(bench.keys(part)[:1], [*parts, part], full)[0] * np.sum(x**2)) ** 2
        / max(spread, 1e-300)
        / 2
    )


def screened(bench: Bench, parts: Sequence[Part], fit: Fit, effect: Effect) -> list[Part]:
    """The shapes and forms of an effect that score best beside the model: those that are worth a
    fit."""
    forms = ("raw",) if effect.role == "filter" else effect.forms
    found = [
        Part(effect.kind, shape, form)
        for shape in shapes_of(effect, bench.recording)
        for form in forms
    ]
    if effect.role == "filter" or len(found) <= SEARCH.shapes_fitted:
        return found
    if effect.role == "mean":
        keys = bench.all_keys(parts)
        scores = [
            score_of_column(bench.data, keys, fit.level, bench.keys(part)[0]) for part in found
        ]
    else:
        gain, rows = bench.gain(parts), bench.rows(parts)
        residual = generalised_least_squares(bench.data, bench.all_keys(parts), fit.level)[2]
        scores = [
            score_of_row(bench.data, rows, residual, fit.level, bench.row(part, gain))
            for part in found
        ]
    best = np.argsort(scores)[::-1][: SEARCH.shapes_fitted]
    for index in (
        set(range(len(found))) - set(best) if effect.role == "mean" and not effect.slow else ()
    ):
        bench.forget(found[index])
    return [found[index] for index in sorted(best)]


def stationary(
    bench: Bench, parts: Sequence[Part], fit: Fit, effect: Effect, scatter: Floats | None = None
) -> Candidate | None:
    """Spectra, filters and regressors: the best of their shapes. `scatter`: of the energies where
    the white level changes."""
    robust = effect.role == "mean" and "accel" in effect.needs
    best = None
    for part in screened(bench, parts, fit, effect):
        full = bench.fit([*parts, part], near=fit.level)
        gain = full.log_likelihood - fit.log_likelihood
        if scatter is not None and part.role != "mean":
            gain = modulation.discounted(gain, fit.level, full.level, bench.data.counts, scatter)
        if robust and gain > max(SEARCH.robust_from, best.gain if best else 0.0):
            gain = min(gain, robust_gain(bench, parts, part))
        if best is None or gain > best.gain:
            best = Candidate(effect.kind, part, gain, 0.0)
    if (
        best and effect.kind not in table.BUILT_IN and best.gain > SEARCH.crude_gain
    ):  # of its grid nobody knows how fine it is
        best.part = refine.refined(bench, [*parts, best.part], only_last=True)[-1]
        best.gain = max(
            best.gain, bench.fit([*parts, best.part]).log_likelihood - fit.log_likelihood
        )
    if best:
        best.log_p = log_chance(effect.kind, best.gain)
    return filters.candidate(bench, parts, fit, best) if best and effect.role == "filter" else best


def beside_both(
    bench: Bench, parts: Sequence[Part], fit: Fit, effect: Effect, scatter: Floats | None
) -> Candidate | None:
    """A spectrum or filter beside decoded states, and beside the noise that they are: the smaller
    gain counts (6.5)."""
    found, noise = stationary(bench, parts, fit, effect, scatter), as_spectra(parts)
    if found and noise and found.log_p < 0 and found.part.role != "mean":
        other = stationary(bench, noise, bench.fit(noise), effect, scatter)
        found = min(found, other or found, key=lambda candidate: candidate.gain)
    return found


def modulated(
    bench: Bench, parts: Sequence[Part], blocks: Blocks, effect: Effect
) -> Candidate | None:
    """White noise that goes with the vibration, or as an effect of one's own says. A level that
    moves for other reasons too must not pass for it."""
    rows = modulation.variance_shapes(parts, bench.recording, blocks)
    before, best = changes.fit(blocks, rows)[1], None
    for part in [
        Part(effect.kind, shape, form)
        for shape in shapes_of(effect, bench.recording)
        for form in effect.forms
    ]:
        square = modulation.variance_shapes([part], bench.recording, blocks)[1]
        if square.max() <= 0:
            continue
        variance = changes.fit(blocks, np.vstack([rows, square]))[1]
        gain = changes.steady_gain(blocks, before, variance) / changes.restless(
            blocks.energy / variance, blocks.length
        )
        if best is None or gain > best.gain:
            best = Candidate(effect.kind, part, gain, log_chance(effect.kind, gain))
    return best


def noise_step(bench: Bench, parts: Sequence[Part], blocks: Blocks) -> Candidate:
    rows = modulation.variance_shapes(parts, bench.recording, blocks)
    sizes, variance, before = changes.fit(blocks, rows)
    low, high, _, _ = changes.best_interval(blocks, variance)
    part = Part("noise_step", {"start_s": low * blocks.period_s, "stop_s": high * blocks.period_s})
    gain = (
        changes.fit(blocks, modulation.variance_shapes([*parts, part], bench.recording, blocks))[2]
        - before
    )
    shaken = [part.kind for part in parts if part.role == "variance"]
    if "vibration_noise" in shaken:
        where = 1 + shaken.index("vibration_noise")
        gain /= float(
            np.mean(
                changes.excess_scatter(blocks, variance, sizes[where] * rows[where] / variance)[
                    low:high
                ]
            )
        )
    return Candidate("noise_step", part, gain, log_chance("noise_step", gain))


def with_states(bench: Bench, parts: Sequence[Part], fit: Fit, found: Sequence[Candidate]) -> None:
    """Tells telegraph noise from Gauss-Markov: moves the gain of two levels over a continuum to the
    one that has it."""
    telegraph = next((c for c in found if c.kind == "telegraph_noise"), None)
    best = max(
        (
            c.gain
            * (1.0 if c.part.role == "filter" or c.kind in SOUGHT_TOGETHER else LEVELS.looked_for)
            for c in found
            if c.kind not in LORENTZIAN
        ),
        default=0.0,
    )
    if telegraph is not None and telegraph.log_p < np.log(1e-4) and telegraph.gain > best:
        decode_states(bench, parts, telegraph)
        for one in found:
            one.doubt = telegraph.doubt if one.kind in LORENTZIAN else one.doubt


def decode_states(bench: Bench, parts: Sequence[Part], telegraph: Candidate) -> None:
    """A few levels against a continuum beside the other parts; decoded when the levels can be seen
    (6.2) (6.3)."""
    trial = refine.refined(bench, [*parts, telegraph.part], only=("telegraph_noise",))
    joint = bench.fit(trial)
    telegraph.part = trial[-1]
    rest = bench.y - bench.y.mean() - bench.mean_course(trial, joint)
    rate = bench.recording.rate_hz
    start, noise = beside_levels(bench, trial, joint)
    continuum = states.fit_continuum(rest, rate, noise, start)
    hopeless = continuum - LEVELS.seen
    best, levels = states.fit_levels(rest, rate, noise, start, 2, hopeless), 2
    for number in range(3, LEVELS.most + 1):
        if number > 3 and best[0] > continuum + LEVELS.seen:
            break
        found = states.fit_levels(rest, rate, noise, start, number, hopeless)
        if found[0] > best[0] + LEVELS.one_more:
            best, levels = found, number
    dwell_s, more = best[2], best[0] - continuum
    if more <= LEVELS.seen or not states.many_switches(dwell_s, rest, rate):
        more = min(more, 0.0)
    else:
        part, course = decoded_part(bench, rest, noise, best, levels)
        fit = bench.fit([*parts, part])
        beside = noise_beside(bench, fit.level, start[1])
        best, number = more_levels(rest, rate, beside, start, levels)
        if number > levels:
            levels = number
            part, course = decoded_part(bench, rest, beside, best, levels)
        if states.like_chance(course, levels):
            telegraph.part = part
        else:
            telegraph.doubt = SWITCHED
    telegraph.gain += more
    telegraph.log_p = min(0.0, telegraph.log_p - more)


def beside_levels(
    bench: Bench, parts: Sequence[Part], fit: Fit
) -> tuple[tuple[float, float], states.Noise]:
    """(standard deviation and dwell of two levels with that spectrum, noise of the other parts) of
    telegraph noise, the last of the parts, as noise."""
    index = [part.kind for part in parts if part.role == "spectrum"].index("telegraph_noise")
    levels = parts[-1].shape.get("levels", 2.0)
    dwell = 2 * parts[-1].shape["mean_dwell_s"] * (levels - 1) / levels
    std = float(np.sqrt(max(fit.sizes[index], 1e-30) * states.mean_square(levels)))
    left = fit.level - fit.sizes[index] * bench.rows(parts)[index]
    left = np.maximum(left, LEVELS.white_least * fit.level)
    return (std, dwell), noise_beside(bench, left, dwell)


def noise_beside(bench: Bench, level: Floats, dwell: float) -> states.Noise:
    """The noise of this level per bin, as levels of this dwell are seen beside it."""
    f, rate = bench.data.f_bin, bench.recording.rate_hz
    least = states.block_of(bench.y, rate, dwell, LEVELS.blocks_per_dwell) / rate
    seen = f < 1 / (2 * least)
    span = LEVELS.process_ratio * len(bench.y) / rate
    return states.noise_of(f[seen], level[seen] / rate, least, span)


def decoded_part(
    bench: Bench, rest: Floats, noise: states.Noise, found: states.Found, levels: int
) -> tuple[Part, Floats]:
    """(decoded part, its course)."""
    _, level, dwell = found
    shape = {"mean_dwell_s": dwell, "levels": float(levels)}
    part, rate = Part("telegraph_noise", shape, "decoded"), bench.recording.rate_hz
    bench.forget(part)
    course, square = states.decoded(rest, rate, noise, level, dwell, levels)
    bench.decoded[part.key], bench.squares[part.key] = course, square
    return part, course


def more_levels(
    rest: Floats, rate_hz: float, noise: states.Noise, start: tuple[float, float], levels: int
) -> tuple[states.Found, int]:
    """(fit, number) of as many levels as the record is likeliest with, from these on, beside the
    noise that is left beside them: with less, further levels would follow the flicker."""
    best = states.fit_levels(rest, rate_hz, noise, start, levels), levels
    for more in range(levels + 1, LEVELS.most + 1):
        found = states.fit_levels(rest, rate_hz, noise, start, more)
        if found[0] <= best[0][0] + LEVELS.one_more:
            break
        best = found, more
    return best


def simplest_first(found: Sequence[Candidate]) -> None:
    """A slow warm-up is a ramp that bends, noise with a long memory a random walk that turns: they
    are named only when the bend itself is significant (likelihood ratio at 1 %)."""
    by_kind = {candidate.kind: candidate for candidate in found}
    for straight, bent in BENDS:
        if (
            straight in by_kind
            and bent in by_kind
            and by_kind[bent].gain - by_kind[straight].gain < CHANCE.bend
        ):
            by_kind[bent].log_p = max(by_kind[bent].log_p, min(0.0, by_kind[straight].log_p + 1e-6))
    own = max(
        (c for c in found if c.kind not in table.BUILT_IN),
        key=lambda candidate: candidate.gain,
        default=None,
    )
    if (
        own
        and own.log_p < 0
        and own.gain > max(candidate.gain for candidate in found) - CHANCE.bend
    ):  # somebody knows his sensor
        own.log_p = min(own.log_p, min(candidate.log_p for candidate in found) - 1e-6)
    single = by_kind.get("bias_step")
    rival = max(
        (by_kind[kind] for kind in SIMPLER if kind in by_kind),
        key=lambda candidate: candidate.gain,
        default=None,
    )
    if single and rival and single.gain - rival.gain < CHANCE.bend:
        single.log_p = max(single.log_p, min(0.0, rival.log_p + 1e-6))


def second_warm_up(bench: Bench, parts: Sequence[Part], fit: Fit) -> Candidate | None:
    """A warm-up with another constant; the first was the mean of both while it was alone."""
    found = stationary(bench, parts, fit, table.find("warm_up"))
    if found is not None and found.gain > SEARCH.crude_gain:
        trial = refine.refined(bench, [*parts, found.part], FIT.rounds_of_two, only=("warm_up",))
        gain = bench.fit(trial).log_likelihood - fit.log_likelihood
        found = Candidate("warm_up", trial[-1], gain, log_chance("warm_up", gain))
    return found


def scatter_of(
    bench: Bench,
    parts: Sequence[Part],
    fit: Fit,
    blocks: Blocks,
    of: Callable[[Bench, Floats, Floats], Floats] = modulation.dispersion,
) -> Floats | None:
    """Of the energies per bin, when the model lets the white level change; None: chi-square. `of`:
    dispersion, or crowding."""
    rows = modulation.variance_shapes(parts, bench.recording, blocks)
    if modulation.constant(rows):
        return None
    return of(bench, modulation.white_share(bench, parts, fit), changes.fit(blocks, rows)[1])


def ranked(
    bench: Bench,
    parts: Sequence[Part],
    fit: Fit,
    skip: Iterable[str] = (),
    more: Iterable[Candidate] = (),
    progress: Trying = lambda kind, found: None,
) -> list[Candidate]:
    """All candidates, least likely by chance first; `more`: those that were found elsewhere
    (columns.py); `progress` hears which effect is next and what was found so far, and may raise."""
    blocks = bench.blocks(parts, fit)
    kinds = [part.kind for part in parts]
    most = {**SEARCH.most_of, "warm_up": SEARCH.warm_ups_most}
    have = {kind for kind in kinds if kinds.count(kind) >= most.get(kind, 1)} | set(skip)
    tried: list[Candidate | None] = []
    scatter = scatter_of(bench, parts, fit, blocks)
    have |= {"vibration_noise", "noise_step"} if bench.counts and bench.counts.unsteady else set()
    for effect in table.TABLE.values():
        if (
            effect.kind in have
            or effect.kind in ("shocks", *SOUGHT_TOGETHER)
            or not available(effect, bench.recording)
        ):
            continue
        progress(effect.kind, [*tried, *more])
        if effect.kind == "sinusoid":
            tried.append(lines.sharp(bench, parts, fit))
        elif effect.kind == "narrow_band":
            tried.append(
                lines.wide(
                    bench,
                    parts,
                    fit,
                    lambda fine, full: scatter_of(fine, parts, full, blocks, modulation.crowding),
                )
            )
        elif effect.kind == drifting.KIND:
            band = next((one for one in tried if one and one.kind == "narrow_band"), None)
            tried.append(drifting.search(bench, parts, fit, band))
        elif effect.kind == "line_follows":
            tried.append(lines.with_a_column(bench, parts, fit))
        elif effect.kind in SEARCHES:
            one = SEARCHES[effect.kind](bench, parts, fit)
            tried.append(Candidate(effect.kind, *one) if one else None)
        elif effect.kind == "warm_up" and "warm_up" in kinds:
            tried.append(second_warm_up(bench, parts, fit))
        elif effect.kind == "noise_step":
            tried.append(noise_step(bench, parts, blocks))
        elif effect.role == "variance" and effect.regressor or effect.kind == "vibration_noise":
            tried.append(modulated(bench, parts, blocks, effect))
        else:
            tried.append(beside_both(bench, parts, fit, effect, scatter))
    tried.append(filters.of_any_shape(bench, parts, fit))
    found = [candidate for candidate in [*tried, *more] if candidate]
    with_states(bench, parts, fit, found)
    simplest_first(found)
    filters.simpler_memory(bench, parts, found)
    return sorted(found, key=lambda candidate: candidate.log_p - 1e-9 * candidate.gain)
