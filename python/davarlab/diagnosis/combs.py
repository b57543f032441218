"""Lines on one comb: the harmonics of one signal that repeats and is no sine wave (DESIGN 4)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats, Ints
from ..candidates.doubts import LINES
from ..distributions import binom_logsf
from ..inference.parts import Bench, Part
from ..thresholds import LINE


@dataclass(frozen=True)
class Comb:
    """Teeth at multiples of base_hz, folded at half the sample rate, and beat_hz on both sides of
    them (0: none); number: of the tooth or sideband on which each of the lines lies, from 1; 0: on
    none."""

    base_hz: float
    beat_hz: float
    number: Ints

    @property
    def hits(self) -> int:
        return len(set(self.number) - {0})


def folded(f_hz: Floats, rate_hz: float) -> Floats:
    """Where frequencies appear at this sample rate."""
    found: Floats = np.abs(f_hz - rate_hz * np.round(f_hz / rate_hz))
    return found


def teeth(
    bench: Bench, lines: Sequence[Part], base_hz: float, base_doubt_hz: float, beat_hz: float = 0.0
) -> tuple[Ints, Floats]:
    """(number of the tooth or sideband of a comb on which each line lies, 0: on none; the chance
    that one anywhere lies on some of them). The teeth are at multiples of base_hz, folded at half
    the sample rate, and the sidebands beat_hz on both sides of them."""
    rate, ordinate = bench.recording.rate_hz, bench.recording.rate_hz / len(bench.y)
    times: Ints = np.arange(1, LINE.comb_teeth + 1)
    times = times[(1 + times) * ordinate / 4 < LINE.wave_near * base_hz]
    if not len(times):  # the record is too short to know any tooth
        return np.zeros(len(lines), int), np.zeros(len(lines))
    sides = (0.0, beat_hz, -beat_hz) if beat_hz else (0.0,)
    at = folded(np.concatenate([times * base_hz + side for side in sides]), rate)
    f = np.array([part.shape["frequency_hz"] for part in lines])
    # A signal that repeats with some jitter has harmonics with a width.
    width = np.array([part.shape.get("half_width_hz", 0.0) for part in lines])
    reach = ordinate / 4 + np.minimum(width, LINE.wave_wide * base_hz)[:, None]
    reach = reach + np.tile(times, len(sides)) * base_doubt_hz
    miss = np.where(np.abs(f[:, None] - at) < reach, np.abs(f[:, None] - at), np.inf)
    number: Ints = np.where(np.isfinite(miss).any(axis=1), 1 + np.argmin(miss, axis=1), 0)
    return number, np.minimum(1.0, 4 * reach.sum(axis=1) / rate)


def one_signal(bench: Bench, parts: Sequence[Part]) -> tuple[str, list[Part]] | None:
    """(what lines of a periodic signal that is no sine wave are, these lines); None without such a
    signal: three harmonics of something slow, or more lines on one comb than a machine shows."""
    lines = [part for part in parts if part.kind in LINES]
    lines.sort(key=lambda part: float(part.shape["frequency_hz"]))
    if len(lines) < LINE.wave_harmonics:
        return None
    doubt_hz = bench.recording.rate_hz / len(bench.y) / 4
    slowest = lines[0].shape["frequency_hz"]
    best = Comb(slowest, 0.0, teeth(bench, lines, slowest, doubt_hz)[0])
    if slowest >= LINE.wave_hz or best.hits < LINE.wave_harmonics:
        found = combs(bench, lines)
        if not found:
            return None
        best = max(found, key=lambda one: (one.hits, one.beat_hz == 0, one.base_hz))
    beside = f", and {best.beat_hz:.4g} Hz beside them," if best.beat_hz else ""
    return (
        f"lines at harmonics of {best.base_hz:.4g} Hz{beside} are one non-sinusoidal signal that "
        f"repeats every {1 / best.base_hz:.4g} s. Look for a device that switches, writes or moves "
        "with this period",
        [part for part, one in zip(lines, best.number) if one],
    )


def combs(bench: Bench, lines: Sequence[Part]) -> list[Comb]:
    """Each comb with enough of the lines, and more than lie on any comb by chance."""
    found: list[Comb] = []
    doubt_hz = bench.recording.rate_hz / len(bench.y) / 4

    def tried(base_hz: float, base_doubt_hz: float, beat_hz: float = 0.0) -> Ints:
        number, by_chance = teeth(bench, lines, base_hz, base_doubt_hz, beat_hz)
        comb = Comb(base_hz, beat_hz, number)
        if comb.hits < LINE.comb_lines:
            return number
        given = 2 if beat_hz else 1  # lines that gave the base and the beat
        log_p = binom_logsf(comb.hits - given - 1, len(lines) - given, by_chance.mean())
        tries = LINE.comb_orders * len(lines) ** given
        if log_p + np.log(tries) < np.log(LINE.comb_chance):
            found.append(comb)
        return number

    for part in lines:
        for order in range(1, LINE.comb_orders + 1):
            base_hz, base_doubt_hz = part.shape["frequency_hz"] / order, doubt_hz / order
            number = tried(base_hz, base_doubt_hz)
            near = folded(base_hz * np.arange(1, LINE.comb_orders + 1), bench.recording.rate_hz)
            for other in (one for one, at in zip(lines, number) if not at):
                beat_hz = float(np.min(np.abs(other.shape["frequency_hz"] - near)))
                if (
                    np.count_nonzero(number) > 1
                    and 4 * doubt_hz < beat_hz < LINE.wave_wide * base_hz
                ):
                    tried(base_hz, base_doubt_hz, beat_hz)
    return found
