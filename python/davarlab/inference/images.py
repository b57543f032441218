"""Images of a line: what a regular pattern of missing samples shows of it at other frequencies
(DESIGN 12.5). Frequencies are in cycles per sample of the grid."""

from collections.abc import Sequence

import numpy as np
import scipy
from scipy import fft, ndimage

from ..arrays import Bools, Floats
from ..thresholds import CHANCE, IMAGE


def shifts(known: Bools | None) -> Floats:
    """By how much each image is off its line: the peaks of the spectral window of the known
    samples, lowest first. Empty without regular gaps."""
    if known is None or known.all():
        return np.zeros(0)
    power = np.abs(fft.rfft(known.astype(float))) ** 2 / np.count_nonzero(known) ** 2
    power[: IMAGE.recurrent] = 0
    near = ndimage.maximum_filter1d(power, 2 * IMAGE.recurrent + 1)
    found: Floats = np.flatnonzero((power > IMAGE.power) & (power == near)) / len(known)
    return found


def of_line(f: float, shifted: Floats) -> Floats:
    """The frequencies of the images of a line at f."""
    both = np.abs(np.concatenate([f + shifted, f - shifted]))
    found: Floats = np.unique(np.minimum(both, 1 - both))
    return found


def without_slow(y: Floats, known: Bools, shifted: Floats) -> Floats:
    """y without what lasts for many gaps, which has images too; 0 where it is not known."""
    window = int(IMAGE.slow_gaps / shifted[0])
    values = np.where(known, y - y[known].mean(), 0.0)
    level, share = (
        ndimage.uniform_filter1d(x, window, mode="constant") for x in (values, known.astype(float))
    )
    return np.where(known, values - level / np.maximum(share, 1e-9), 0.0)


def powers(values: Floats) -> tuple[Floats, Floats]:
    """Of the known samples at each frequency k / 2n: (power, that of the noise about it, at least
    what is usual). Their ratio is the log-likelihood that a line gains."""
    power = np.abs(fft.rfft(values, 2 * len(values))) ** 2
    length = min(IMAGE.background, len(power))
    usual = np.median(power[: len(power) // length * length].reshape(-1, length), axis=1)
    usual = np.maximum(usual, np.median(usual))
    places = (np.arange(len(usual)) + 0.5) * length
    level = np.interp(np.arange(len(power)), places, usual) / np.log(2)
    power[: IMAGE.recurrent] = 0
    power[-IMAGE.recurrent :] = 0
    return power, np.maximum(level, 1e-300)


def strongest(values: Floats, known: Bools, near: Sequence[float]) -> float:
    """The frequency, near one of these, at which a line takes most of the known samples: of a line
    and its images the line. The noise about it counts some of its power, so it is not compared."""
    places, step = np.flatnonzero(known), 0.5 / len(values)
    part = values[places]

    def lacking(g: float) -> float:
        return -float(np.abs(part @ np.exp(-2j * np.pi * g * places)))

    tried = [
        scipy.optimize.minimize_scalar(
            lacking, bounds=(f - step, f + step), method="bounded", options={"xatol": step / 100}
        )
        for f in near
    ]
    return float(min(tried, key=lambda one: one.fun).x)


def turning(f: float, count: int) -> list[Floats]:
    """Cosine and sine of a frequency."""
    turns = 2 * np.pi * f * np.arange(count)
    return [np.cos(turns), np.sin(turns)]


def lines(y: Floats, known: Bools) -> Floats:
    """The course of the lines that the known samples show, the strongest one first, which explains
    its images. 0 without regular gaps: there are no images then."""
    shifted = shifts(known)
    course = np.zeros(len(y))
    if not len(shifted):
        return course
    values = without_slow(y, known, shifted)
    rest, found = values, list[float]()
    rows = list[Floats]()  # cosine and sine of each line at the known samples, as the values are
    for _ in range(IMAGE.lines_most):
        power, level = powers(rest)
        best = int(np.argmax(power / level))
        if power[best] < level[best] * np.log(len(power) / IMAGE.chance):
            break
        f = best / (2 * len(y))
        found.append(strongest(rest, known, [f, *of_line(f, shifted)]))
        rows += [without_slow(x, known, shifted)[known] for x in turning(found[-1], len(y))]
        columns = np.column_stack(rows)
        sizes = np.linalg.solve(columns.T @ columns, columns.T @ values[known])
        rest = values.copy()
        rest[known] -= columns @ sizes
    for place, f in enumerate(found):
        for size, x in zip(sizes[2 * place :], turning(f, len(y))):
            course += size * x
    return course


def likelier(values: Floats, f: float, half_width: float, shifted: Floats) -> float | None:
    """The image of a line at f that the known samples show as well or better; None without one."""
    power, level = powers(values)
    reach = max(2, round(2 * len(values) * half_width))
    noise = level[min(round(2 * len(values) * f), len(level) - 1)]

    def about(g: float) -> float:
        place = round(2 * len(values) * g)
        return float(power[max(0, place - reach) : place + reach + 1].sum() / noise) / 2

    images = of_line(f, shifted)
    images = images[np.abs(images - f) > reach / len(values)]
    best = max(images, key=about, default=f)
    return float(best) if best != f and about(best) > about(f) - CHANCE.tell_apart else None
