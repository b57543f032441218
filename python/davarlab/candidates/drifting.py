"""One line whose frequency drifts, instead of many lines with a width (DESIGN 15.3)."""

from collections.abc import Sequence

import numpy as np
import scipy
from scipy import fft, ndimage

from ..arrays import Complexes, Floats
from ..data import signals
from ..effects.means import turns_of
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit
from ..thresholds import DRIFT
from .candidate import Candidate

KIND = "drifting_line"


def beside_zero(w: Floats, low: float, high: float) -> tuple[Complexes, Floats]:
    """(the part of w between two frequencies in cycles per sample as complex numbers about the
    middle one, at a lower rate; unit variance where w has it; times in samples)."""
    spectrum = fft.rfft(w)
    signals.forget_plans(len(w))
    first, last = int(low * len(w)), int(high * len(w))
    return slower(w, spectrum[first:last])


def about_turns(w: Floats, turns: Floats) -> tuple[Complexes, Floats]:
    """The same about a line of that phase, which it has then at frequency 0."""
    spectrum = fft.fft(w * np.exp(-2j * np.pi * turns))
    signals.forget_plans(len(w))
    reach = int(DRIFT.reach * len(w))
    return slower(w, np.concatenate([spectrum[-reach:], spectrum[:reach]]))


def slower(w: Floats, about: Complexes) -> tuple[Complexes, Floats]:
    """(ordinates of w as its course at a lower rate, times in samples)."""
    part = fft.ifftshift(about)
    z = fft.ifft(part) * np.sqrt(len(part) / len(w))
    return z, np.arange(len(part)) * len(w) / len(part)


def ridge(z: Complexes, length: int) -> Floats:
    """Frequency in cycles per sample of z at each of half overlapping blocks: the strongest path
    through their spectra that moves by few bins from one to the next."""
    starts = np.arange(0, len(z) - length + 1, length // 2)
    taper = np.hanning(length + 2)[1:-1]
    taper /= np.sqrt(np.mean(taper**2))
    rows = z[starts[:, None] + np.arange(length)] * taper
    points = 2 * length
    power = fft.fftshift(np.abs(fft.fft(rows, points, axis=1)) ** 2 / length, axes=1)
    total = power[0]
    came = np.zeros(power.shape, int)
    bins = np.arange(points)
    for block in range(1, len(power)):
        reach = [np.roll(total, move) for move in range(-DRIFT.bins, DRIFT.bins + 1)]
        best = np.argmax(reach, axis=0)
        came[block] = np.clip(bins - (best - DRIFT.bins), 0, points - 1)
        total = np.take_along_axis(np.array(reach), best[None], 0)[0] + power[block]
    path = np.zeros(len(power), int)
    path[-1] = np.argmax(total)
    for block in range(len(power) - 1, 0, -1):
        path[block - 1] = came[block, path[block]]
    found: Floats = (path - length) / points
    return found


def smooth(time: Floats, values: Floats, knots: Floats, weight: Floats) -> Floats:
    """A cubic spline through knots, at the knots, by least squares."""
    basis = scipy.interpolate.CubicSpline(knots, np.eye(len(knots)))(time)
    rows = np.vstack([basis * weight[:, None], 1e-3 * np.diff(np.eye(len(knots)), 2, axis=0)])
    right = np.concatenate([values * weight, np.zeros(len(knots) - 2)])
    found: Floats = np.linalg.lstsq(rows, right, rcond=None)[0]
    return found


def gathered(z: Complexes, time: Floats, last: float, course: Floats) -> tuple[float, Complexes]:
    """(log-likelihood that the line of that course explains, z turned back by it)."""
    turned = z * np.exp(-2j * np.pi * turns_of(course, time, last))
    return float(np.abs(turned.sum()) ** 2 / len(z)), turned


def locked(z: Complexes, time: Floats, last: float, course: Floats) -> tuple[float, Floats]:
    """(log-likelihood, course) whose phase follows the line. course: cycles per unit of time at
    even knots, near enough that the phase can be followed."""
    knots = np.linspace(time[0], last, len(course))
    best = gathered(z, time, last, course)[0], course
    for turn in range(DRIFT.rounds):
        turned = gathered(z, time, last, course)[1]
        pieces = min(len(z) // 2, DRIFT.per_knot * len(course) // 2 ** max(0, 2 - turn))
        starts = np.linspace(0, len(z), pieces, endpoint=False).astype(int)
        sums = np.add.reduceat(turned, starts)
        sums = ndimage.uniform_filter1d(sums, 3, mode="nearest")
        middle = np.add.reduceat(time, starts) / np.diff(np.append(starts, len(z)))
        phase = np.unwrap(np.angle(sums)) / (2 * np.pi)
        more = scipy.interpolate.CubicSpline(knots, smooth(middle, phase, knots, np.abs(sums)))
        course = course + more(knots, 1)
        now = gathered(z, time, last, course)[0]
        if now <= best[0]:
            break
        best = now, course
    return best


def followed(z: Complexes, time: Floats, last: float) -> tuple[float, Floats] | None:
    """(log-likelihood less its price, course at knots) of the likeliest line; None where the record
    is too short for one."""
    step, price = time[1] - time[0], float(np.log(len(z)))
    best: tuple[float, Floats] | None = None

    def tried(course: Floats) -> None:
        nonlocal best
        gain, course = locked(z, time, last, course)
        if best is None or gain - price * len(course) > best[0]:
            best = gain - price * len(course), course

    for blocks in DRIFT.blocks:
        length = 2 * len(z) // (blocks + 1)
        if length < DRIFT.block_least:
            break
        path = ridge(z, length) / step
        middle = (np.arange(len(path)) + 1) * (length // 2) * step
        knots = np.linspace(time[0], last, len(path) // DRIFT.blocks_per_knot)
        tried(smooth(middle, path, knots, np.ones(len(path))))
    for factor in (0.5, 2.0):  # fewer knots, or more, as long as they are worth it
        before = None
        while best and best is not before:
            before, count = best, int(factor * len(best[1]))
            if DRIFT.knots[0] <= count <= min(DRIFT.knots[1], len(z) // DRIFT.per_knot):
                knots = np.linspace(time[0], last, len(best[1]))
                more = np.linspace(time[0], last, count)
                tried(scipy.interpolate.CubicSpline(knots, best[1])(more))
    return best


def as_words(course: Floats) -> str:
    """The knots of a course as a model file has them."""
    return " ".join(f"{one:.9g}" for one in course)


def search(
    bench: Bench, parts: Sequence[Part], fit: Fit, band: Candidate | None
) -> Candidate | None:
    """The line that drifts about the line with a width that gains most; None where it is none: most
    of the power there must belong to one course."""
    if band is None or band.gain < DRIFT.least:
        return None
    w, rate = bench.residual(parts, fit), bench.recording.rate_hz
    centre = band.part.shape["frequency_hz"] / rate
    reach = max(DRIFT.reach, DRIFT.widths * band.part.shape["half_width_hz"] / rate)
    low, high = max(centre - reach, centre / 2), min(centre + reach, 0.499)
    z, time = beside_zero(w, low, high)
    if len(z) < DRIFT.samples_least:
        return None
    found = followed(z, time, len(w) - 1.0)
    if found is None:
        return None
    course = (int(low * len(w)) + len(z) // 2) / len(w) + found[1]
    if not (course > 0).all() or np.ptp(course) * len(w) < DRIFT.turns_least:
        return None
    part = Part(KIND, {"course_hz": as_words(course * rate)})
    full = bench.fit([*parts, part])
    gain = full.log_likelihood - fit.log_likelihood
    price = np.log(len(w)) * (len(course) + 2)
    explained = gain / max(float(np.sum(np.abs(z) ** 2) - len(z)), 1e-300)
    bench.forget(part)
    if gain - price < band.gain + DRIFT.least or explained < DRIFT.share:
        return None
    return Candidate(KIND, part, gain, min(0.0, float(price - gain)))
