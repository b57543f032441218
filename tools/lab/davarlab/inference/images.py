"""Images of a line: what a regular pattern of missing samples shows of it at other frequencies
(DESIGN 12.5). Frequencies are in cycles per sample of the grid."""

import numpy as np
from scipy import fft, ndimage, optimize

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
        ndimage.uniform_filter1d(x, window, mode="nearest") for x in (values, known.astype(float))
    )
    return np.where(known, values - level / np.maximum(share, 1e-9), 0.0)


def gains(values: Floats) -> Floats:
    """Log-likelihood that a line gains at each frequency k / 2n, from the known samples alone; at
    most, where the noise about it is below what is usual."""
    power = np.abs(fft.rfft(values, 2 * len(values))) ** 2
    length = min(IMAGE.background, len(power))
    usual = np.median(power[: len(power) // length * length].reshape(-1, length), axis=1)
    usual = np.maximum(usual, np.median(usual))
    places = (np.arange(len(usual)) + 0.5) * length
    level = np.interp(np.arange(len(power)), places, usual) / np.log(2)
    found: Floats = power / np.maximum(level, 1e-300)
    found[: IMAGE.recurrent] = 0
    found[-IMAGE.recurrent :] = 0
    return found


def refined(values: Floats, known: Bools, f: float) -> float:
    """The frequency near f at which a line takes most of the known samples."""
    places, step = np.flatnonzero(known), 0.5 / len(values)
    part = values[places]

    def lacking(g: float) -> float:
        return -float(np.abs(part @ np.exp(-2j * np.pi * g * places)))

    return float(
        optimize.minimize_scalar(
            lacking, bounds=(f - step, f + step), method="bounded", options={"xatol": step / 100}
        ).x
    )


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
        gain = gains(rest)
        best = int(np.argmax(gain))
        if gain[best] < np.log(len(gain) / IMAGE.chance):
            break
        found.append(refined(rest, known, best / (2 * len(y))))
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
    gain, reach = gains(values), max(2, round(2 * len(values) * half_width))

    def about(g: float) -> float:
        place = round(2 * len(values) * g)
        return float(gain[max(0, place - reach) : place + reach + 1].sum()) / 2

    images = of_line(f, shifted)
    images = images[np.abs(images - f) > reach / len(values)]
    best = max(images, key=about, default=f)
    return float(best) if best != f and about(best) > about(f) - CHANCE.tell_apart else None
