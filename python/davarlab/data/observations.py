"""Disturbances in a record that are not errors of the sensor, detected before the fit (DESIGN
13)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Bools, Floats
from ..thresholds import COUNTS, EVENTS, MOTION, OBSERVED
from . import counts as counted
from . import events, motion, plausible, repeats, signals
from .recording import Recording


@dataclass
class Observation:
    """stretches: [[start_s, stop_s]]. share: of the samples. detail: sentences. mask: samples that
    the analysis cannot use, or None. spoils: whether the samples are not what the sensor measures,
    so that no effect is sought and no model is adequate."""

    kind: str
    stretches: list[list[float]]
    share: float
    detail: str
    mask: Bools | None = None
    spoils: bool = False

    def plain(self) -> dict[str, Any]:
        """The JSON form."""
        return {
            "kind": self.kind,
            "stretches": self.stretches,
            "share": self.share,
            "detail": self.detail,
        }


def find(
    recording: Recording, column: str, between: Callable[[], None] = lambda: None
) -> list[Observation]:
    """Every observation on one gyro column. between: called before each look; may raise."""
    known = np.ones(recording.samples, bool) if recording.known is None else recording.known
    x = recording.column(column)
    found = [
        entry
        for entry in (
            implausible(recording, column),
            lost(recording, known),
            in_blocks(recording, known),
            stamps(recording),
        )
        if entry
    ]
    for look in (
        lambda recording, good: torn(recording, column, good),
        lambda recording, good: clipped(recording, x, good),
        lambda recording, good: dead(recording, x, good),
        lambda recording, good: stuck(recording, column, good),
        moved,
        repeated,
        lambda recording, good: coarse(recording, x, good),
        lambda recording, good: outliers(recording, x, good),
    ):
        between()
        entry = look(recording, kept(recording, column, found))
        found += [entry] if entry else []
        if entry and entry.spoils:
            break
    return sorted(found, key=lambda entry: (entry.kind != plausible.KIND, entry.kind != "motion"))


def kept(recording: Recording, column: str, observations: Iterable[Observation]) -> Bools:
    """True where a sample may be used."""
    good = np.ones(recording.samples, bool) if recording.known is None else recording.known.copy()
    for entry in observations:
        if entry.mask is not None:
            good &= ~entry.mask
    return good


def in_seconds(recording: Recording, mask: Bools) -> list[list[float]]:
    """The intervals of a mask, at most the `listed` longest."""
    runs = motion.stretches(mask)
    runs = sorted(sorted(runs, key=lambda run: run[0] - run[1])[: OBSERVED.listed])
    time = recording.time_s if recording.clock and recording.clock.cut else None
    return [
        [
            float(a / recording.rate_hz if time is None else time[a]),
            float(b / recording.rate_hz if time is None else time[b - 1] + 1 / recording.rate_hz),
        ]
        for a, b in runs
    ]


def of_mask(kind: str, recording: Recording, mask: Bools, detail: str) -> Observation:
    return Observation(kind, in_seconds(recording, mask), float(mask.mean()), detail, mask)


def implausible(recording: Recording, column: str) -> Observation | None:
    """Implausible rates, units and levels."""
    said = "; ".join(plausible.of_recording(recording, [column]))
    return (
        Observation(
            plausible.KIND,
            [[0.0, float(recording.samples / recording.rate_hz)]],
            1.0,
            f"{said[0].upper()}{said[1:]}. If the recording is correct, use {plausible.CONFIRM}.",
        )
        if said
        else None
    )


def torn(recording: Recording, column: str, good: Bools) -> Observation | None:
    """Samples that are half of an old value, on any axis of gyro and accelerometer."""
    names = [
        name for name in recording.columns if name == column or name.startswith(("gyro_", "accel_"))
    ]
    found = events.torn({name: recording.columns[name] for name in names}, good)
    if not found:
        return None
    mask = np.zeros(len(good), bool)
    where = []
    for power, hits in found.items():
        for one in hits:
            mask[one.at] = True
            where.append(f"{one.column} {len(one.at)} times by {2**power} counts")
    count = int(np.count_nonzero(mask))
    return of_mask(
        "torn_reads",
        recording,
        mask,
        f"{count} single sample{'s jump' if count != 1 else ' jumps'} by a power of two in counts "
        f"and back: {', '.join(where)}; at {times(recording, mask)} s. The bus or the driver read "
        "half of an old value, which is not an error of the sensor. Read the registers in one "
        "burst, or latch them (block data update). These samples are excluded.",
    )


def moved(recording: Recording, good: Bools) -> Observation | None:
    mask = motion.find(recording, good)
    if not mask.any():
        return None
    runs, seconds = motion.stretches(mask), mask.sum() / recording.rate_hz
    return of_mask(
        "motion",
        recording,
        mask,
        f"The sensor was turned, tilted or touched in {len(runs)} "
        f"interval{'s' * (len(runs) != 1)}, {seconds:.4g} s in total. These samples are excluded, "
        "because true rotation is not an error of the sensor.",
    )


def times(recording: Recording, mask: Bools) -> str:
    """The first times of a mask, for a sentence."""
    at = recording.time_s[mask]
    return ", ".join(f"{one:.6g}" for one in at[: OBSERVED.times]) + ", .." * (
        len(at) > OBSERVED.times
    )


def lost(recording: Recording, known: Bools) -> Observation | None:
    if known.all() or recording.clock and recording.clock.kind == "uneven":
        return None
    mask, longest = ~known, max(end - first for first, end in motion.stretches(~known))
    detail = (
        f"{mask.sum()} samples are missing, at most {longest} in a row. The analysis fills them "
        "with random noise from the model's spectrum. No Allan deviation spans them."
    )
    cut = recording.clock.cut if recording.clock else ()
    if cut:
        detail += (
            f" {len(cut)} gaps of up to "
            f"{max(seconds for _, seconds in cut) + longest / recording.rate_hz:.4g} s are "
            f"shortened to {longest} samples."
        )
    return of_mask("lost_samples", recording, mask, detail)


def in_blocks(recording: Recording, known: Bools) -> Observation | None:
    """Samples that come in blocks with regular gaps between."""
    runs = motion.stretches(known)
    apart = np.diff([first for first, _ in runs])
    if len(apart) < OBSERVED.bursts:
        return None
    low, usual, high = np.percentile(apart, (25, 50, 75))
    if low < (1 - OBSERVED.bursts_stray) * usual or high > (1 + OBSERVED.bursts_stray) * usual:
        return None
    length = int(np.median([end - first for first, end in runs]))
    return Observation(
        "bursts",
        [[0.0, float(recording.samples / recording.rate_hz)]],
        1.0,
        f"The samples come in blocks of {length}, every {usual / recording.rate_hz:.3g} s "
        f"({recording.rate_hz / usual:.3g} per second), with gaps between: the FIFO or the bus is "
        "not read fast enough, or it is switched off between the blocks. Frequencies are those of "
        "the real time, but a line has images at multiples of that rate. Read every sample of the "
        "FIFO, or lower the sensor's rate.",
    )


def stamps(recording: Recording) -> Observation | None:
    clock = recording.clock
    if not clock or clock.kind == "even":
        return None
    whole = [[0.0, float(recording.samples / recording.rate_hz)]]
    if clock.kind == "uneven":
        where = (
            "The samples are treated as evenly spaced"
            if clock.places is None or recording.known is None
            else "Each sample is moved to the nearest place of an even grid "
            f"({100 * np.mean(~recording.known):.2g} % of the places stay empty and count as "
            "missing)"
        )
        return Observation(
            "jitter",
            whole,
            1.0,
            "The sampling is uneven: the errors of the time stamps accumulate. "
            f"{where}, at {recording.rate_hz:.4g} Hz. This blurs high frequencies.",
        )
    return Observation(
        "jitter",
        whole,
        1.0,
        f"The time stamps have {clock.jitter_s:.2g} s rms jitter "
        f"({clock.jitter_s * recording.rate_hz:.2g} periods) around an even clock of "
        f"{recording.rate_hz:.5g} Hz. The samples are treated as evenly spaced.",
    )


def repeated(recording: Recording, known: Bools) -> Observation | None:
    """Samples that repeat the previous one: already removed by resampling to the sensor's own rate,
    or still in the record."""
    if recording.read_hz:
        share = 1 - recording.rate_hz / recording.read_hz
        return Observation(
            "repeated_samples",
            [[0.0, float(recording.samples / recording.rate_hz)]],
            share,
            f"{100 * share:.3g} % of the samples repeat the previous one, at even intervals: the "
            f"sensor outputs {recording.rate_hz:.5g} samples per second, but was read at "
            f"{recording.read_hz:.5g} Hz. The repeats are excluded, and the analysis uses "
            f"{recording.rate_hz:.5g} Hz.",
        )
    found = repeats.find(recording.columns, known)
    if not found:
        return None
    if not found.clear:
        return Observation(
            "repeated_samples",
            [[0.0, float(recording.samples / recording.rate_hz)]],
            found.share,
            f"{100 * found.share:.3g} % of the samples equal the previous one. Coarse counts "
            f"explain only {100 * found.chance:.2g} %, so the sensor was read more often than it "
            "measures. The counts hide which samples are repeats, so nothing is analysed. Read "
            "the sensor at its own rate, on its data-ready signal, or log all axes.",
            spoils=True,
        )
    real = (found.share - found.chance) / (1 - found.chance)
    return of_mask(
        "repeated_samples",
        recording,
        found.equal,
        f"{100 * found.share:.3g} % of the samples repeat the previous one{rhythm(found.equal)}. "
        f"Coarse counts explain only {100 * found.chance:.2g} %. The sensor outputs about "
        f"{recording.rate_hz * (1 - real):.4g} samples per second, but was read at "
        f"{recording.rate_hz:.4g} Hz. The repeats count as missing. Read the sensor at its own "
        "rate, on its data-ready signal.",
    )


def stuck(recording: Recording, column: str, known: Bools) -> Observation | None:
    """One axis keeps a value while the sensor measures."""
    if recording.read_hz:
        return None
    mask = repeats.held(recording.columns, column, known)
    if not mask.any():
        return None
    starts, lengths = repeats.runs_of(mask)
    often = f"{len(starts)} time{'s' * (len(starts) > 1)}"
    return of_mask(
        "stuck_axis",
        recording,
        mask,
        f"{often}, the axis keeps one value for up to {lengths.max() + 1} samples, at "
        f"{times(recording, mask)} s. Its counts do not explain that. These samples are excluded. "
        "Look for faults of the bus or the driver.",
    )


def rhythm(equal: Bools) -> str:
    """ ", every k-th"" if most repeats have the same distance, above 1."""
    apart = np.diff(np.flatnonzero(equal))
    if len(apart) < 5:
        return ""
    usual = int(np.median(apart))
    return f", every {usual}th" if usual > 1 and np.mean(apart == usual) > 0.6 else ""


def clipped(recording: Recording, x: Floats, known: Bools) -> Observation | None:
    """Samples at an extreme value that occurs far more often than its neighbouring values."""
    values, counts = np.unique(x[known], return_counts=True)
    mask = np.zeros(len(x), bool)
    if len(values) >= OBSERVED.clipped_values:
        for extreme, next_ones in ((0, counts[1:4]), (-1, counts[-4:-1])):
            if counts[extreme] >= 5 and counts[extreme] > OBSERVED.clipped_piled * next_ones.mean():
                mask |= known & (x == values[extreme])
    if not mask.any():
        return None
    return of_mask(
        "clipped",
        recording,
        mask,
        f"{mask.sum()} samples are at an extreme value "
        f"({', '.join(f'{v:.6g}' for v in np.unique(x[mask]))}), because the rate exceeded the "
        "range. These samples are excluded.",
    )


def dead(recording: Recording, x: Floats, known: Bools) -> Observation | None:
    """A value in the middle that stands for all small rates."""
    values, counts = np.unique(x[known], return_counts=True)
    most = int(np.argmax(counts))
    beside = np.concatenate(
        [
            counts[max(0, most - OBSERVED.dead_beside) : most],
            counts[most + 1 :][: OBSERVED.dead_beside],
        ]
    )
    share = float(counts[most]) / max(np.count_nonzero(known), 1)
    if (
        not OBSERVED.dead_beside <= most < len(values) - OBSERVED.dead_beside
        or share < OBSERVED.dead_share
    ):
        return None
    step, noise = signals.count_of(x[known]), noise_per_sample(x, known)
    near, far = counts[most + np.array([-1, 1])], counts[most + np.array([-3, -2, 2, 3])]
    falls_off = (
        near.sum() >= OBSERVED.dead_falls_least and near.mean() > OBSERVED.dead_falls * far.mean()
    )
    in_counts = step and noise < OBSERVED.dead_fine * step
    around = np.diff(values[max(0, most - OBSERVED.dead_around) : most + OBSERVED.dead_around + 1])
    place = min(most, OBSERVED.dead_around)
    is_apart = around[place - 1 : place + 1].min() > OBSERVED.dead_wide * np.median(around)
    if (
        counts[most] < OBSERVED.dead_piled * beside.mean()
        or (in_counts or falls_off)
        and not is_apart
    ):
        return None
    return Observation(
        "dead_zone",
        [[0.0, float(recording.samples / recording.rate_hz)]],
        share,
        f"{100 * share:.2g} % of the samples are exactly {values[most]:.6g}, "
        f"{counts[most] / beside.mean():.2g} times as many as at the values next to it. The sensor "
        "or its driver reports this value instead of small rates (a dead zone), or instead of "
        "samples that it lost. Nothing is analysed. Switch the dead zone off, or read the raw "
        "registers.",
        spoils=True,
    )


def noise_per_sample(x: Floats, good: Bools) -> float:
    """From differences of neighbouring samples: the median over blocks."""
    square = np.diff(x)[good[1:] & good[:-1]] ** 2 / 2
    return float(np.sqrt(np.median(motion.averaged(square, 256)))) if len(square) >= 512 else 0.0


def coarse(recording: Recording, x: Floats, good: Bools) -> Observation | None:
    step, noise = signals.count_of(x[good]), noise_per_sample(x, good)
    if not step or step < OBSERVED.coarse * noise:
        return None
    what = (
        "Mean and variance of the noise depend on the position of the bias between two counts"
        if step > (1 / COUNTS.fine) * noise
        else "The rounding only adds white noise, with a variance of 1/12 count squared"
    )
    return Observation(
        "coarse_counts",
        [[0.0, float(recording.samples / recording.rate_hz)]],
        1.0,
        f"One count is {step:.4g}, which is {step / max(noise, 1e-30):.2g} times the noise per "
        f"sample. {what}.",
    )


def outliers(recording: Recording, x: Floats, good: Bools) -> Observation | None:
    if good.sum() < MOTION.rest_samples:
        return None
    w = motion.whitened(x, good)
    mask, _ = motion.lone(w, good)
    known = counted.found(x[good], recording.rate_hz) if mask.any() else None
    if known and known.reach_dps:  # a count more is no outlier where a count exceeds the noise
        mask &= np.abs(x - events.local_mean(x, good, EVENTS.local_samples)) > known.reach_dps
    if not mask.any():
        return None
    return of_mask(
        "outliers",
        recording,
        mask,
        f"{mask.sum()} single sample{'s are outliers' if mask.sum() != 1 else ' is an outlier'} "
        f"(up to {np.abs(w[mask]).max():.3g} times the noise) while no other column moves, at "
        f"{times(recording, mask)} s. The "
        "noise is fitted without them. Look for knocks, bit errors and interference there.",
    )
