"""Is a coefficient on a column a coefficient: one number at all frequencies; or do both follow a
cause that was not logged (DESIGN 4)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from ..arrays import Floats
from ..data import signals
from ..data.recording import Recording, as_logged
from ..effects import columns
from ..inference.parts import Bench, Part
from ..thresholds import CAUSE
from .columns import coarse

# Band: from Hz, to Hz, coefficient, standard error, share of real motion. Told: a band without the
# share. Seen: the coefficient of a band and its standard error.
Band = tuple[float, float, float, float, float]
Told = tuple[float, float, float, float]
Seen = tuple[float, float]


@dataclass
class CommonCause:
    """confirmed: two bands agree; disagrees: two bands contradict each other, or the axes of the
    accelerometer move as one. bands: (from Hz, to Hz, coefficient, standard error), in deg/s per
    unit of the column."""

    confirmed: bool
    disagrees: bool
    bands: list[Told] = field(default_factory=list)
    why: str = ""
    coefficient: float = 0.0  # over all bands


def column_of(part: Part) -> str | None:
    """The logged column that the part follows as it is; None for a course that is worked out of
    one."""
    if part.kind == "g_sensitivity":
        return f"accel_{part.shape['axis']}_g"
    return part.shape["column"] if part.kind == "follows" and not part.shape["lag_s"] else None


def on_column(part: Part) -> bool:
    """Is it a coefficient on a column, that this question can be asked of."""
    return part.role == "mean" and (part.kind == "follows" or bool(part.effect.needs))


def sensor_noise(x: Floats, rate_hz: float) -> float:
    """Density per ordinate of what the column's own sensor adds: white noise of the quietest
    seconds."""
    length = max(64, int(rate_hz))
    count = len(x) // length
    steps = np.diff(x[: count * length].reshape(count, length), axis=1)
    return float(np.quantile((steps**2).mean(axis=1), CAUSE.quiet_share)) / 2


def band_places(f: Floats) -> list[tuple[float, float, slice]]:
    """(from, to, slice of the ordinates) of every band with enough ordinates."""
    found, low, first = [], CAUSE.edges_hz[0], 0
    for high in CAUSE.edges_hz[1:]:
        last = int(np.searchsorted(f, high))
        if last - first >= CAUSE.ordinates_least and high <= f[-1] * 1.01:
            found.append((low, high, slice(first, last)))
            low, first = high, last
    return found


def in_bands(bench: Bench, parts: Sequence[Part], part: Part) -> list[Band]:
    """(from, to, coefficient, standard error, share of real motion) per band; the noise is
    whitened, and measured in the band itself."""
    fit, data = bench.fit([*parts, part]), bench.data
    name = column_of(part)
    x = bench.recording.column(name) if name else next(bench.courses(part))
    floor = sensor_noise(x, data.rate_hz) if name and name.startswith(("accel_", "gyro_")) else 0.0
    f = data.f
    f = f[: int(np.searchsorted(f, CAUSE.edges_hz[-1] if name else CAUSE.worked_out_hz))]
    keys = bench.all_keys(parts)
    c, rest = (
        signals.transform(x - x.mean())[1 : len(f) + 1],
        data.without(bench.coefficients_of(keys, [*parts, part], fit), keys)[: len(f)],
    )
    level, found = np.interp(np.log(f), np.log(data.f_bin), fit.level), []
    for low, high, place in band_places(f):
        power = float(np.sum(c[place] ** 2 / level[place]))
        if power <= 0:
            continue
        beta = float(np.sum(c[place] * rest[place] / level[place])) / power
        scatter = np.sum((rest[place] - beta * c[place]) ** 2 / level[place]) / (
            place.stop - place.start - 1
        )
        share = max(CAUSE.motion_least, 1 - floor / float(np.mean(c[place] ** 2)))
        found.append((low, high, beta, float(np.sqrt(scatter / power)), share))
    return found


def mean_of(found: Sequence[Band]) -> float:
    """Coefficient over the bands: those count most that know it best."""
    weights = [error**-2 for _, _, _, error, _ in found]
    return (
        sum(band[2] * weight for band, weight in zip(found, weights)) / sum(weights)
        if found
        else 0.0
    )


def contradict(one: Seen, other: Seen) -> bool:
    """Two bands (coefficient, error): is one seen, are they apart, and by more than chance and
    dilution explain."""
    (a, error_a), (b, error_b) = one, other
    if max(abs(a) / error_a, abs(b) / error_b) <= CAUSE.band_seen or abs(
        a - b
    ) <= CAUSE.bands_apart * np.hypot(error_a, error_b):
        return False
    return a * b <= 0 or max(abs(a), abs(b)) > CAUSE.bands_ratio * min(abs(a), abs(b))


def agree(one: Seen, other: Seen) -> bool:
    (a, error_a), (b, error_b) = one, other
    return (
        min(abs(a) / error_a, abs(b) / error_b) > CAUSE.band_seen
        and a * b > 0
        and not contradict(one, other)
    )


def judge(bench: Bench, parts: Sequence[Part], part: Part) -> CommonCause:
    """Before `part`, a coefficient on a column, is named beside `parts`."""
    rest = [other for other in parts if other is not part]
    found = in_bands(bench, rest, part)
    plain = [(beta, error) for _, _, beta, error, _ in found]
    true = [(beta / share, error / share) for _, _, beta, error, share in found]
    bands = [(low, high, *value) for (low, high, *_), value in zip(found, true)]
    turned, mean = [i for i, band in enumerate(found) if is_turned(part, band)], mean_of(found)
    together = [(true[i], true[j]) for i, j in combinations(turned, 2)]
    if any(agree(*pair) for pair in together) and not any(contradict(*pair) for pair in together):
        return CommonCause(True, False, bands, coefficient=mean)
    pairs = list(combinations(range(len(found)), 2))
    # An accelerometer that is shaken all the time has no quiet second; its noise is then taken too
    # large. So: with it and without it.
    apart = [
        pair
        for pair in pairs
        if all(contradict(values[pair[0]], values[pair[1]]) for values in (plain, true))
    ]
    confirmed = any(agree(true[i], true[j]) for i, j in pairs) and not apart
    if apart:
        return CommonCause(False, True, bands, contradiction(bands, apart), mean)
    why = unseen(part, found, confirmed) or as_one(bench, rest, part, confirmed)
    return CommonCause(confirmed and not why, bool(why), bands, why, mean)


def is_turned(part: Part, band: Band) -> bool:
    """Is the part on another axis of the gyro that is turned, in a band of in_bands()."""
    return (
        (column_of(part) or "").startswith("gyro_")
        and band[0] >= CAUSE.turned_hz
        and band[4] > CAUSE.turned_share
    )


def unseen(part: Part, found: Sequence[Band], confirmed: bool) -> str:
    """A column of a sensor must be significant in one band alone. Another axis of the gyro shares
    supply and electronics with this one, so it must be significant in two bands that agree, or in
    one in which it is turned."""
    name = column_of(part)
    if confirmed or not found or not name or not name.startswith(("accel_", "gyro_")):
        return ""
    seen = [
        band
        for band in found
        if abs(band[2]) > CAUSE.band_seen * band[3]
        and (is_turned(part, band) or not name.startswith("gyro_"))
    ]
    return (
        ""
        if seen
        else "no frequency band confirms the coefficient, which points to a common cause that was "
        "not logged"
    )


def contradiction(bands: Sequence[Told], pairs: Sequence[tuple[int, int]]) -> str:
    """A sentence on the pair of bands that differs most."""
    first, second = (
        bands[i]
        for i in max(
            pairs,
            key=lambda pair: (
                abs(bands[pair[0]][2] - bands[pair[1]][2])
                / np.hypot(bands[pair[0]][3], bands[pair[1]][3])
            ),
        )
    )
    said = [
        f"{beta:.2g} ± {error:.1g} between {low:g} and {high:g} Hz"
        for low, high, beta, error in (first, second)
    ]
    return (
        f"the coefficient is {said[0]} and {said[1]}. It is not constant, which points to a "
        "common cause that was not logged"
    )


def in_acceleration(part: Part) -> bool:
    return "accel" in part.effect.needs or part.shape.get("column", "").startswith("accel_")


def as_one(bench: Bench, parts: Sequence[Part], part: Part, confirmed: bool) -> str:
    """The third rule: the coefficient is the same on all axes of the accelerometer; or these drift
    together, where no second band confirms the coefficient."""
    names = sorted(name for name in bench.recording.columns if name.startswith("accel_"))
    if not in_acceleration(part) or len(names) < 3:
        return ""
    if same_on_all(bench, parts, part):
        return (
            "all axes of the accelerometer have the same coefficient, which points to a common "
            "cause that was not logged"
        )
    if not confirmed and all(together(bench.recording, a, b) for a, b in combinations(names, 2)):
        return (
            "the axes of the accelerometer drift together, which points to a common cause that "
            "was not logged"
        )
    return ""


def same_on_all(bench: Bench, parts: Sequence[Part], part: Part) -> bool:
    if part.kind != "g_sensitivity":
        return False
    best = [
        max(
            in_bands(bench, parts, part.moved("axis", axis)),
            key=lambda band: abs(band[2]) / band[3],
        )
        for axis in "xyz"
    ]
    sizes = [abs(beta) for _, _, beta, _, _ in best]
    return all(abs(beta) > CAUSE.band_seen * error for _, _, beta, error, _ in best) and max(
        sizes
    ) < CAUSE.axes_ratio * min(sizes)


def flattened(x: Floats, rate_hz: float) -> Floats | None:
    """The slow ordinates with a power law of frequency taken out."""
    c = signals.transform(x - x.mean())[1:]
    f = signals.frequencies(len(x), rate_hz)
    c, f = c[f < CAUSE.slow_hz], f[f < CAUSE.slow_hz]
    if len(c) < 20 or not np.any(c):
        return None
    slope, level = np.polyfit(np.log(f), np.log(np.maximum(c**2, 1e-300)), 1)
    flat: Floats = c / np.exp((slope * np.log(f) + level) / 2)
    return flat


def slow_coherence(recording: Recording, a: str, b: str) -> tuple[float, float]:
    """Correlation of two columns below CAUSE.slow_hz, each octave with its own weight; and its
    standard error."""
    small = coarse(recording, (a, b))
    one, other = (flattened(small.columns[name], small.rate_hz) for name in (a, b))
    if one is None or other is None:
        return 0.0, 1.0
    return float(one @ other / np.sqrt((one @ one) * (other @ other))), 1 / np.sqrt(len(one))


def together(recording: Recording, a: str, b: str) -> bool:
    r, error = slow_coherence(recording, a, b)
    return abs(r) > max(CAUSE.coherent, CAUSE.bands_apart * error)


def several_axes(recording: Recording, column: str) -> str:
    """A sentence if other gyro axes share the slow drift of this one; otherwise ""."""
    others = [
        name
        for name in recording.columns
        if name.startswith("gyro_")
        and name != column
        and np.ptp(recording.columns[name]) > 0
        and not columns.clocklike(recording.columns[name])
    ]
    shared = [
        (name, slow_coherence(recording, column, name)[0])
        for name in others
        if together(recording, column, name)
    ]
    if not shared:
        return ""
    said = " and ".join(f"{name} (r = {r:.2f})" for name, r in shared)
    return (
        f"{said} drift{'s' if len(shared) == 1 else ''} together with {as_logged(column)} below "
        f"{CAUSE.slow_hz:g} Hz, which points to a common cause that was not logged"
    )
