"""What is in a record and is no error of the sensor, found before anything is fitted (DESIGN 13)."""

from dataclasses import dataclass

import numpy as np

from . import motion, plausible, repeats, signals

COARSE = 0.6  # of the noise per sample: counts from which their rounding is worth saying
COARSER = 1 / 0.6  # from which the rounding changes mean and variance of the noise
LEVELS = 8  # different values that a column needs before its extremes say anything
PILED = 8  # times the values next to it, that an extreme value is met by clipping
LISTED = 100  # stretches, the longest, that are named


@dataclass
class Observation:
    """stretches: [[start_s, stop_s]]; share: of the samples; detail: one sentence; mask: samples that the analysis cannot use, or None."""

    kind: str
    stretches: list
    share: float
    detail: str
    mask: object = None

    def plain(self):
        """As the contract has it."""
        return {
            "kind": self.kind,
            "stretches": self.stretches,
            "share": self.share,
            "detail": self.detail,
        }


def find(recording, column):
    """Every observation on one gyro column."""
    known = np.ones(recording.samples, bool) if recording.known is None else recording.known
    x = recording.column(column)
    found = [
        doubted(recording, column),
        lost(recording, known),
        stamps(recording),
        clipped(recording, x, known),
    ]
    for look in (
        moved,
        repeated,
        lambda recording, good: coarse(recording, x, good),
        lambda recording, good: outliers(recording, x, good),
    ):
        found = [entry for entry in found if entry]
        found.append(look(recording, kept(recording, column, found)))
    return sorted(
        (entry for entry in found if entry),
        key=lambda entry: (entry.kind != plausible.KIND, entry.kind != "motion"),
    )


def kept(recording, column, observations):
    """True where a sample may be used."""
    good = np.ones(recording.samples, bool) if recording.known is None else recording.known.copy()
    for entry in observations:
        if entry.mask is not None:
            good &= ~entry.mask
    return good


def in_seconds(recording, mask):
    """The stretches of a mask, the longest where there are very many."""
    runs = motion.stretches(mask)
    runs = sorted(sorted(runs, key=lambda run: run[0] - run[1])[:LISTED])
    time = recording.time_s if recording.clock and recording.clock.cut else None
    return [
        [
            float(a / recording.rate_hz if time is None else time[a]),
            float(b / recording.rate_hz if time is None else time[b - 1] + 1 / recording.rate_hz),
        ]
        for a, b in runs
    ]


def of_mask(kind, recording, mask, detail):
    return Observation(kind, in_seconds(recording, mask), float(mask.mean()), detail, mask)


def doubted(recording, column):
    """Rates, units and levels that no gyro has."""
    said = "; ".join(plausible.of(recording, [column]))
    return (
        Observation(
            plausible.KIND,
            [[0.0, float(recording.samples / recording.rate_hz)]],
            1.0,
            f"{said[0].upper()}{said[1:]}. If it is right: {plausible.CONFIRM}.",
        )
        if said
        else None
    )


def moved(recording, good):
    mask = motion.find(recording, good)
    if not mask.any():
        return None
    runs, seconds = motion.stretches(mask), mask.sum() / recording.rate_hz
    return of_mask(
        "motion",
        recording,
        mask,
        f"The sensor was turned, tilted or touched in {len(runs)} stretches, {seconds:.4g} s in all; "
        "they are left out: true rotation is no error of the sensor.",
    )


def lost(recording, known):
    if known.all() or recording.clock and recording.clock.kind == "uneven":
        return None
    mask, longest = ~known, max(end - first for first, end in motion.stretches(~known))
    detail = (
        f"{mask.sum()} samples of the even grid are missing, at most {longest} in a row; what they leave open is drawn from the "
        "model's own spectrum, and no Allan deviation spans them."
    )
    cut = recording.clock.cut if recording.clock else ()
    if cut:
        detail += f" {len(cut)} gaps of up to {max(seconds for _, seconds in cut) + longest / recording.rate_hz:.4g} s are cut to {longest} samples."
    return of_mask("lost_samples", recording, mask, detail)


def stamps(recording):
    clock = recording.clock
    if not clock or clock.kind == "even":
        return None
    whole = [[0.0, float(recording.samples / recording.rate_hz)]]
    if clock.kind == "uneven":
        where = (
            "Samples are taken as even"
            if clock.places is None
            else "Each sample is put at the nearest place of an even grid "
            f"({np.mean(~recording.known):.2g} of its places stay empty and are drawn)"
        )
        return Observation(
            "jitter",
            whole,
            1.0,
            "The clock itself is uneven: its steps do not make each other good. "
            f"{where}, at {recording.rate_hz:.4g} Hz, which blurs high frequencies.",
        )
    return Observation(
        "jitter",
        whole,
        1.0,
        f"Time stamps stray by {clock.jitter_s:.2g} s rms ({clock.jitter_s * recording.rate_hz:.2g} periods) "
        f"about an even clock of {recording.rate_hz:.5g} Hz, which the number of samples follows; they are taken as even.",
    )


def repeated(recording, known):
    """Samples that repeat the one before: those that reading at the sensor's own rate has left out already, or those that stand in the record."""
    if recording.read_hz:
        share = 1 - recording.rate_hz / recording.read_hz
        return Observation(
            "repeated_samples",
            [[0.0, float(recording.samples / recording.rate_hz)]],
            share,
            f"{100 * share:.3g} % of the samples "
            f"repeat the one before, evenly: the sensor gives {recording.rate_hz:.5g} samples a second and was read at "
            f"{recording.read_hz:.5g}. The repeats are left out, all is analysed at {recording.rate_hz:.5g} Hz.",
        )
    found = repeats.find(recording.columns, known)
    if not found:
        return None
    real = (found.share - found.chance) / (1 - found.chance)
    return of_mask(
        "repeated_samples",
        recording,
        found.equal,
        f"{100 * found.share:.3g} % of the samples repeat the one before"
        f"{rhythm(found.equal)}; their counts explain {100 * found.chance:.2g} %. The sensor gives about "
        f"{recording.rate_hz * (1 - real):.4g} samples a second and is read at {recording.rate_hz:.4g}: the repeats are taken as missing. "
        "Read it at its own rate, on its data-ready signal.",
    )


def rhythm(equal):
    """ ", every k-th"" when most repeats follow each other at one distance above 1."""
    apart = np.diff(np.flatnonzero(equal))
    if len(apart) < 5:
        return ""
    usual = int(np.median(apart))
    return f", every {usual}th" if usual > 1 and np.mean(apart == usual) > 0.6 else ""


def clipped(recording, x, known):
    """Samples on an extreme value that is met far more often than the values next to it."""
    values, counts = np.unique(x[known], return_counts=True)
    mask = np.zeros(len(x), bool)
    if len(values) >= LEVELS:
        for extreme, next_ones in ((0, counts[1:4]), (-1, counts[-4:-1])):
            if counts[extreme] >= 5 and counts[extreme] > PILED * next_ones.mean():
                mask |= known & (x == values[extreme])
    if not mask.any():
        return None
    return of_mask(
        "clipped",
        recording,
        mask,
        f"{mask.sum()} samples stand on an extreme value ({', '.join(f'{v:.6g}' for v in np.unique(x[mask]))}): "
        "the range was exceeded; they are left out.",
    )


def noise_per_sample(x, good):
    """From differences of neighbours, in the quieter half of the blocks."""
    square = np.diff(x)[good[1:] & good[:-1]] ** 2 / 2
    return float(np.sqrt(np.median(motion.averaged(square, 256)))) if len(square) >= 512 else 0.0


def coarse(recording, x, good):
    step, noise = signals.count_of(x[good]), noise_per_sample(x, good)
    if not step or step < COARSE * noise:
        return None
    what = (
        "mean and variance of the noise change with the place of the bias between two counts"
        if step > COARSER * noise
        else "their rounding adds white noise of a twelfth of their square and nothing else"
    )
    return Observation(
        "coarse_counts",
        [[0.0, float(recording.samples / recording.rate_hz)]],
        1.0,
        f"Values come in counts of {step:.4g}, {step / max(noise, 1e-30):.2g} times the noise per sample: {what}.",
    )


def outliers(recording, x, good):
    if good.sum() < motion.MINIMUM:
        return None
    w = motion.whitened(x, good)
    mask, _ = motion.lone(w, good)
    if not mask.any():
        return None
    return of_mask(
        "outliers",
        recording,
        mask,
        f"{mask.sum()} lone samples are wild (up to {np.abs(w[mask]).max():.3g} times the noise) while nothing "
        "else moves; they are left out, and `shocks` is the effect that counts them.",
    )
