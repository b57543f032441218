"""Lines that are there for a while: a machine that is switched on and off (DESIGN 15)."""

from collections.abc import Sequence

import numpy as np
from scipy import fft

from ..arrays import Complexes, Floats
from ..data import signals
from ..effects import columns
from ..effects.means import course_hz
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit
from ..thresholds import LINE, TRIES


def strongest(
    w: Floats, bands: Sequence[tuple[float, float]] = ()
) -> tuple[float, float, int, int]:
    """(gain, frequency over rate, first, last) of the best window of any length, without those that
    hold most of the record, and outside the bands (low, high)."""
    best: tuple[float, float, int, int] = (-np.inf, 0.0, 0, 0)
    w = w.astype(np.float32, copy=False)
    for count in LINE.interval_windows:
        length = len(w) // count
        if length < LINE.interval_least:
            break
        points = fft.next_fast_len(2 * length, real=True)
        nu, starts = (
            np.arange(points // 2 + 1) / points,
            np.arange(0, len(w) - length + 1, max(1, length // 2)),
        )
        known = sum(((nu >= low) & (nu <= high) for low, high in bands), np.zeros(len(nu), bool))
        rows = np.lib.stride_tricks.sliding_window_view(w, length)
        for chunk in np.array_split(starts, max(1, len(starts) * length // 4_000_000)):
            power = np.abs(fft.rfft(rows[chunk], points, axis=1))
            np.square(power, out=power)
            power /= length
            power[:, : 2 * LINE.interval_turns] = power[:, -2:] = 0
            power[:, known] = 0
            row, column = np.unravel_index(np.argmax(power), power.shape)
            best = max(
                best,
                (
                    float(power[row, column]),
                    float(nu[column]),
                    int(chunk[row]),
                    int(chunk[row]) + length,
                ),
            )
        signals.forget_plans(len(w))
    return best


def best_interval(w: Floats, nu: float) -> tuple[float, int, int]:
    """(gain, first, last) of the likeliest interval of a line of that frequency."""
    turned = Turned(w, nu)
    edges, total = turned.edges, turned.total
    first, last = np.triu_indices(len(edges), 1)
    length = edges[last] - edges[first]
    gain = np.where(
        (length * nu >= LINE.interval_turns) & (length < LINE.interval_most * len(w)),
        np.abs(total[last] - total[first]) ** 2 / length,
        0,
    )
    best = int(np.argmax(gain))
    low, high = edges[first[best]], edges[last[best]]
    for _ in range(2):
        low, high = sharpened(turned, int(low), int(high), len(w) // LINE.interval_marks)
    inside = turned.until(high, high) - turned.until(low, low)
    return float(np.abs(inside[0]) ** 2 / (high - low)), low, high


class Turned:
    """The running sum of a record that is turned back by a frequency: at marks, and at every sample
    of a short stretch."""

    def __init__(self, w: Floats, nu: float) -> None:
        self.w, self.nu = w, nu
        self.edges = np.linspace(0, len(w), LINE.interval_marks + 1).astype(int)
        sums = signals.turned_back(w, nu, LINE.interval_marks)[0]
        self.total: Complexes = np.concatenate([[0], np.cumsum(sums)])

    def until(self, first: int, last: int) -> Complexes:
        """The sum of the samples before each of first .. last."""
        mark = int(np.searchsorted(self.edges, first, "right")) - 1
        start = int(self.edges[mark])
        turned = self.w[start:last] * np.exp(-2j * np.pi * self.nu * np.arange(start, last))
        run = np.concatenate([[0], np.cumsum(turned)])
        found: Complexes = self.total[mark] + run[first - start :]
        return found


def sharpened(turned: Turned, low: int, high: int, reach: int) -> tuple[int, int]:
    """Both ends, each moved by no more than `reach`."""
    first, last = max(0, low - reach), min(high - LINE.interval_least, low + reach)
    if first <= last:
        inside = turned.until(high, high) - turned.until(first, last)
        low = first + int(np.argmax(np.abs(inside) ** 2 / (high - np.arange(first, last + 1))))
    first, last = max(low + LINE.interval_least, high - reach), min(len(turned.w), high + reach)
    if first <= last:
        inside = turned.until(first, last) - turned.until(low, low)
        high = first + int(np.argmax(np.abs(inside) ** 2 / (np.arange(first, last + 1) - low)))
    return low, high


def best_frequency(w: Floats, nu: float, low: int, high: int) -> float:
    """Within a lobe of the interval."""
    turned, middle = signals.turned_back(w[low:high], nu, min(256, high - low))
    off = np.linspace(-1, 1, 161) / (high - low)
    return float(nu + off[np.argmax(np.abs(np.exp(-2j * np.pi * np.outer(off, middle)) @ turned))])


def search(bench: Bench, parts: Sequence[Part], fit: Fit) -> tuple[Part, float, float] | None:
    """(part, gain, log p) of the likeliest such line; the gain is held against the noise of its own
    interval."""
    w, rate = bench.residual(parts, fit), bench.recording.rate_hz
    bands = [part.shape for part in parts if part.kind == "narrow_band"]
    reach = [(band["frequency_hz"], LINE.within_band * band["half_width_hz"]) for band in bands]
    for part in parts:  # what is left of a line that moves, here and there
        if part.kind in ("drifting_line", "line_follows"):
            course = (
                course_hz(part.shape)
                if part.kind == "drifting_line"
                else columns.aliases_hz(bench.recording, part.shape)
            )
            off = np.ptp(course) / 2 + LINE.beside_course * rate
            reach.append((float(course.max() + course.min()) / 2, float(off)))
    gain, nu, low, high = strongest(w, [((f - off) / rate, (f + off) / rate) for f, off in reach])
    for _ in range(LINE.interval_rounds if gain > 0 else 0):
        gain, low, high = best_interval(w, nu)
        nu = best_frequency(w, nu, low, high)
    if gain <= 0 or not low < high:
        return None
    time = bench.recording.time_s
    part = Part(
        "intermittent_line",
        {
            "frequency_hz": nu * rate,
            "start_s": float(time[low]),
            "stop_s": float(time[high - 1] + 1 / rate),
        },
    )
    energy = float(np.sum(w[low:high] ** 2, dtype=np.float64))
    noise = max((energy - 2 * gain) / (high - low), 1.0)
    gain = (bench.fit([*parts, part]).log_likelihood - fit.log_likelihood) / noise
    bench.forget(part)
    return (
        part,
        gain,
        min(0.0, float(np.log(TRIES.of_interval * len(w) * max(gain, 1) ** 2) - max(gain, 0))),
    )
