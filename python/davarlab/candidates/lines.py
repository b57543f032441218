"""Lines, sharp, with a width and with a logged column: where the whitened residual stands above its
surroundings (DESIGN 4)."""

from collections.abc import Callable, Sequence

import numpy as np
import scipy
from scipy import fft

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording
from ..effects import columns
from ..inference import modulation, refine
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit
from ..thresholds import DRIFT, LINE, SEARCH
from . import drifting
from .candidate import Candidate, log_tail_of_line, log_tail_of_multiple


def sharp(bench: Bench, parts: Sequence[Part], fit: Fit) -> Candidate:
    """The line, fast or slow, that chance explains least. Slow ones cost 27 fits: they wait for a
    fast one that is beyond doubt."""
    first = fast(bench, parts, fit)
    if first.log_p < -SEARCH.certain:
        return first
    second = slow(bench, parts, fit)
    return min([first, *([second] if second else [])], key=lambda one: (one.log_p, -one.gain))


def slow(bench: Bench, parts: Sequence[Part], fit: Fit) -> Candidate | None:
    """The cycle of a few turns in the record that gains most. Slow noise takes it up, so the noise
    is fitted beside each. None beside one that the model has."""
    rate = bench.data.rate_hz / bench.data.samples
    known = [part.shape["frequency_hz"] for part in parts if part.kind == "sinusoid"]
    if any(f_hz < LINE.slow_turns * rate for f_hz in known):
        return None
    best = None
    for turns in np.arange(1.25, LINE.slow_turns, 0.25):
        part = Part("sinusoid", {"frequency_hz": float(turns * rate)})
        gain = bench.fit([*parts, part], near=fit.level).log_likelihood - fit.log_likelihood
        bench.forget(part)
        if best is None or gain > best.gain:
            best = Candidate(part.kind, part, gain, log_tail_of_line(part, gain, bench.data))
    return best


def fast(bench: Bench, parts: Sequence[Part], fit: Fit) -> Candidate:
    """The strongest line of the whitened residual, twice oversampled. Not beside one that the model
    has: what is left there is that line, drifting."""
    w = bench.residual(parts, fit)
    power = np.abs(fft.rfft(w.astype(np.float32, copy=False), 2 * len(w)))
    signals.forget_plans(len(w))
    np.square(power, out=power)
    power /= len(w)
    power[:6] = 0
    power[-4:] = 0
    spacing = bench.recording.rate_hz / (2 * len(w))
    for known in [part.shape["frequency_hz"] for part in parts if part.kind == "sinusoid"]:
        reach = LINE.apart * known + LINE.apart_bins * spacing
        power[
            max(0, int(np.ceil((known - reach) / spacing))) : int((known + reach) / spacing) + 1
        ] = 0
    part, peak = (
        Part("sinusoid", {"frequency_hz": float(np.argmax(power) * spacing)}),
        float(power.max()),
    )
    if peak < np.log(len(w)):  # chance, as nearly every time
        return Candidate("sinusoid", part, peak, log_tail_of_line(part, peak, bench.data))
    part = (
        refine.on_peak(bench, part, w)
        if refine.turns(bench, part) > LINE.white_turns
        else refine.refined(bench, [*parts, part], only_last=True)[-1]
    )
    gain = bench.fit([*parts, part]).log_likelihood - fit.log_likelihood
    bench.forget(part)
    return Candidate("sinusoid", part, gain, log_tail_of_line(part, gain, bench.data))


def gain_of(width: int, ratio: float) -> float:
    """Of a level of its own for so many ordinates with that mean energy; 0 where it is below a
    model's own (1)."""
    return float(0.5 * width * (ratio - 1 - np.log(ratio))) if ratio > 1 else 0.0


def places(energy: Floats) -> list[tuple[float, float, float]]:
    """(centre, half width, gain) in ordinates of the strongest boxes, best first, none within
    another."""
    found: list[tuple[float, float, float]] = []
    total = np.concatenate([[0.0], np.cumsum(energy, dtype=np.float64)])
    width = 4
    while width <= 4 * LINE.widest * len(energy):
        step = max(1, width // 4)
        boxes = total[width:-1:step] - total[: -1 - width : step]
        best = int(np.argmax(boxes)) if len(boxes) else 0
        if len(boxes) and (gain := gain_of(width, boxes[best] / width)) > 0:
            found.append((step * best + width / 2, width / 4, gain))
        width = int(1.5 * width)
    found.sort(key=lambda place: -place[2])
    kept: list[tuple[float, float, float]] = []
    for place in found:
        if all(abs(place[0] - other[0]) > 2 * (place[1] + other[1]) for other in kept):
            kept.append(place)
    return kept[: LINE.places_refined]


def wide_at(bench: Bench, parts: Sequence[Part], fit: Fit, f_hz: float) -> Part:
    """A line with a width where somebody saw one, from that of the box about it which stands out
    most."""
    energy, scale = bench.whitened(parts, fit) ** 2, bench.recording.rate_hz / (2 * len(bench.y))
    centre = f_hz / scale
    widths = np.unique(
        np.geomspace(4, max(4, min(centre, 4 * LINE.widest * len(energy))), 40).astype(int)
    )
    gains = [
        gain_of(width, energy[max(0, int(centre - width / 2)) : int(centre + width / 2) + 1].mean())
        for width in widths
    ]
    part = Part(
        "narrow_band",
        {"frequency_hz": f_hz, "half_width_hz": float(widths[int(np.argmax(gains))] / 4 * scale)},
    )
    return refine.refined(bench.resolving([*parts, part]), [*parts, part], only_last=True)[-1]


def wide(
    bench: Bench, parts: Sequence[Part], fit: Fit, scatter_of: Callable[[Bench, Fit], Floats | None]
) -> Candidate | None:
    """The line with a width that gains most; None where nothing stands out. scatter_of: (bench,
    fit) -> of neighbouring ordinates, where the white level changes."""
    energy = bench.whitened(parts, fit) ** 2
    energy[: LINE.lowest] = 1.0
    scale, best = bench.recording.rate_hz / (2 * len(bench.y)), None
    for centre, half_width, crude in places(energy):
        width = min(
            max(half_width, LINE.narrowest), LINE.widest * 2 * len(bench.y), LINE.turning * centre
        )
        part = Part(
            "narrow_band",
            {"frequency_hz": float(centre * scale), "half_width_hz": float(width * scale)},
        )
        if crude < LINE.hopeful:
            best = best or Candidate(
                "narrow_band", part, crude, log_tail_of_line(part, crude, bench.data)
            )
            continue
        fine = bench.resolving([*parts, part])
        part = refine.refined(fine, [*parts, part], only_last=True)[-1]
        before, after = fine.fit(parts), fine.fit([*parts, part])
        gain, scatter = after.log_likelihood - before.log_likelihood, scatter_of(fine, before)
        if scatter is not None:
            gain = modulation.discounted(gain, before.level, after.level, fine.data.counts, scatter)
        if best is None or gain > best.gain:
            best = Candidate("narrow_band", part, gain, log_tail_of_line(part, gain, bench.data))
    return best


def speeds(recording: Recording) -> list[str]:
    """The columns that may be the speed of a machine: of one sign, and not of a gyro."""
    found = []
    for name in columns.may_follow(recording):
        low, high = recording.columns[name].min(), recording.columns[name].max()
        if not name.startswith("gyro_") and (low >= 0 or high <= 0):
            found.append(name)
    return found


def with_a_column(bench: Bench, parts: Sequence[Part], fit: Fit) -> Candidate | None:
    """The line at a multiple of a logged column that gains most, also of one above half the sample
    rate; None where nothing stands out."""
    names = speeds(bench.recording)
    if not names:
        return None
    w = bench.residual(parts, fit)
    places = [one for name in names if (one := multiple_of(bench, parts, w, name))]
    if not places:
        return None
    _, name, multiple = max(places)
    plain = Part("line_follows", {"column": name, "multiple": multiple, "apart_hz": ""})
    tried = [plain]
    z, time = drifting.about_turns(w, multiple * columns.turns(bench.recording, name))
    followed = drifting.followed(z, time, len(w) - 1.0)
    if followed is not None:
        apart = followed[1] * bench.recording.rate_hz
        moves = multiple * np.ptp(columns.still(bench.recording, name))
        if np.ptp(apart) < LINE.multiple_apart * moves:  # otherwise it drifts on its own
            tried.append(plain.moved("apart_hz", drifting.as_words(apart)))
    found = []
    for part in tried:
        gain = bench.fit([*parts, part], near=fit.level).log_likelihood - fit.log_likelihood
        bench.forget(part)
        chance = log_tail_of_multiple(part, gain, bench.data, len(names))
        found.append(Candidate(part.kind, part, gain, chance))
    return min(found, key=lambda one: one.log_p)


def multiple_of(
    bench: Bench, parts: Sequence[Part], w: Floats, name: str
) -> tuple[float, str, float] | None:
    """(power, column, multiple) of the strongest line at a multiple of one column, where the column
    moves enough that the line is no steady one. The transform over the turns of the column: each
    sample is spread over the two places of an even grid that it lies between."""
    turns = columns.turns(bench.recording, name)
    # Without its own noise, a column may pass 0 by a little.
    turns = np.clip(np.sign(turns[-1]) * turns, 0, abs(turns[-1]))
    if turns[-1] <= 0:
        return None
    highest = LINE.multiple_highest * len(w)  # turns in the record
    points = fft.next_fast_len(8 * highest, real=True)
    place = turns * (points / (2 * turns[-1]))
    first, most = place.astype(int), points // 2 + 2  # the record fills half of the grid
    grid = np.bincount(first, w * (first + 1 - place), most).astype(np.float32)
    grid += np.bincount(first + 1, w * (place - first), most)
    power = np.abs(fft.rfft(grid, points)[: 2 * highest])
    signals.forget_plans(points)
    np.square(power, out=power)
    power /= len(w)
    steady = np.linspace(0.0, turns[-1], len(turns))
    moved = float(np.ptp(turns - steady)) / turns[-1]  # of the turns in the record
    power[: max(2 * LINE.multiple_turns, int(2 * LINE.multiple_moves / max(moved, 1e-12)))] = 0
    for known in [one for one in parts if one.kind == "line_follows"]:
        if known.shape["column"] == name:
            at, reach = 2 * known.shape["multiple"] * turns[-1], int(2 * DRIFT.reach * len(w))
            power[max(0, int(at) - reach) : int(at) + reach + 1] = 0
    peak = int(np.argmax(power))
    if power[peak] < np.log(len(w)):  # chance, as nearly every time
        return None
    phase = turns / (2 * turns[-1])

    def loss(half_turns: float) -> float:
        return -float(np.abs(w @ np.exp(-2j * np.pi * half_turns * phase)) ** 2) / len(w)

    best = scipy.optimize.minimize_scalar(
        loss, bounds=(peak - 1, peak + 1), method="bounded", options={"xatol": 1e-3}
    )
    return -float(best.fun), name, float(best.x) / (2 * turns[-1])
