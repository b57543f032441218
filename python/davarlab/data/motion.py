"""Motion: true rotation in a record of a sensor that should be at rest (DESIGN 13). No error of the
sensor may be called so."""

from collections.abc import Sequence
from typing import cast

import numpy as np
from scipy import ndimage

from ..arrays import Bools, Floats, Ints
from ..distributions import chi2_isf
from ..tables.constants import TO_DPS
from ..thresholds import MOTION, SIGNALS
from . import events, signals
from . import recording as recordings
from .recording import Recording

# Spread of rates averaged over a quarter of a second, and of samples about their mean, at rest.
Level = tuple[float, float]


def moving(recording: Recording, sensor: str) -> dict[str, float]:
    """Every column of gyro or accelerometer that moves at all -> its factor to deg/s, or to the
    unit that it has."""
    units = TO_DPS | {"counts": MOTION.count_dps} if sensor == "gyro" else {"": 1.0}
    return {
        name: factor
        for name in recording.columns
        for unit, factor in units.items()
        if name.startswith(f"{sensor}_")
        and name.endswith(unit and "_" + unit)
        and np.ptp(recording.columns[name]) > 0
    }


def stretches(mask: Bools) -> list[tuple[int, int]]:
    """(first, end) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return list(zip(edges[::2], edges[1::2]))


def widened(mask: Bools, samples: float) -> Bools:
    found: Bools = ndimage.maximum_filter1d(mask.astype(np.int8), 2 * int(samples) + 1) > 0
    return found


def holes_kept(mask: Bools, samples: float) -> Bools:
    """A mask without its runs that are shorter than so many samples."""
    kept = np.zeros(len(mask), bool)
    for first, end in stretches(mask):
        kept[first:end] = end - first >= samples or first == 0 or end == len(mask)
    return kept


def averaged(x: Floats, length: int) -> Floats:
    blocks = len(x) // length
    found: Floats = x[: blocks * length].reshape(blocks, length).mean(axis=1)
    return found


def spread(x: Floats, span: int) -> Floats:
    """Standard deviation over `span` values around each."""
    mean = ndimage.uniform_filter1d(x, span)
    found: Floats = np.sqrt(np.maximum(ndimage.uniform_filter1d(x**2, span) - mean**2, 0))
    return found


def slow_and_fast(y: Floats, good: Bools, rate_hz: float) -> tuple[Floats, Floats, Bools]:
    """Spread of rates averaged over a quarter of a second, size of the differences of samples, and
    whether all of it was measured; per block of a quarter of a second, from two seconds around
    it."""
    length, span = (
        max(1, int(MOTION.smooth_s * rate_hz)),
        max(8, int(MOTION.span_s / MOTION.smooth_s)),
    )
    y = recordings.filled(y[good], good) - np.median(y[good])
    count = averaged(good.astype(float), length)
    mean = averaged(np.where(good, y, 0), length) / np.maximum(count, 1e-9)
    there = count > min(0.5, count.max() / 2)
    slow = spread(recordings.filled(mean[there], there), span)
    steps: Floats = np.diff(y, append=y[-1])
    fast = np.sqrt(np.maximum(ndimage.uniform_filter1d(averaged(steps**2, length), span), 0))
    whole = ndimage.uniform_filter1d(averaged(good.astype(float), length), span) > 0.9
    return slow, fast, whole


def white_in_means(y: Floats, good: Bools, length: int) -> float:
    """Standard deviation that the white noise of y gives a mean of so many samples: from third
    differences, which hold little of a motion."""
    steps = np.diff(y, 3)[good[3:] & good[2:-1] & good[1:-2] & good[:-3]]
    return float(np.sqrt(np.mean(steps**2) / 20 / length)) if len(steps) else 0.0


def slow_level(slow: Floats, whole: Bools, share: float, white: float) -> float:
    """The quantile of the slow spread; no more than a sensor at rest has, where all of it moves."""
    return min(low_level(slow, whole, share), max(MOTION.rest_dps, MOTION.rest_white * white))


def low_level(x: Floats, whole: Bools, share: float) -> float:
    """The quantile of what was measured and moves at all."""
    x = x[whole & (x > 0)]
    return float(np.quantile(x, share)) if len(x) else np.inf


def turning(y: Floats, good: Bools, rate_hz: float) -> Bools:
    """Where rates averaged over a quarter of a second have grown by far more than differences of
    single samples have."""
    slow, fast, whole = slow_and_fast(y, good, rate_hz)
    white = white_in_means(y, good, max(1, int(MOTION.smooth_s * rate_hz)))
    grown = slow / slow_level(slow, whole, 0.1, white)
    noise = fast / low_level(fast, whole, 0.1)
    return expanded(
        (grown > MOTION.turn) & ((grown > MOTION.slow_growth * noise) | (grown > MOTION.violent)),
        max(1, int(MOTION.smooth_s * rate_hz)),
        len(y),
    )


def expanded(mask: Bools, length: int, count: int) -> Bools:
    """A mask of blocks as one of samples."""
    mask = np.repeat(mask, length)
    return np.concatenate([mask, np.full(count - len(mask), mask[-1] if len(mask) else False)])


def whitened(x: Floats, good: Bools) -> Floats:
    """x whitened by the record's own spectrum, of variance about one; 0 where nothing was
    measured."""
    return np.where(good, events.self_whitened(recordings.filled(x[good], good)), 0.0)


def wilder(w: Floats, good: Bools) -> Bools:
    """Measured samples that no noise of the size around them has in a record this long."""
    found, part = np.zeros(len(w), bool), w[good]
    scale = np.maximum(events.local_scale(part, min(len(part) // 2, 200)), 1e-30)
    found[good] = np.abs(part) > np.sqrt(2 * np.log(len(part) / 1e-3)) * scale
    return found


def lone(w: Floats, good: Bools) -> tuple[Bools, Bools]:
    """Wild samples by themselves."""
    wild = wilder(w, good)
    found = np.zeros(len(w), bool)
    for first, end in stretches(widened(wild, 1)):
        found[first:end] = end - first <= 5
    return wild & found, widened(wild & found, 2)


def loud(energy: Floats, good: Bools, length: int) -> Bools:
    """Blocks whose energy stands out of the running median."""
    count = averaged(good.astype(float), length)
    mean = averaged(energy, length) / np.maximum(count, 1e-9)
    mean = np.where(count > 0.5, mean, np.nan)
    mean = (
        np.interp(np.arange(len(mean)), np.flatnonzero(count > 0.5), mean[count > 0.5])
        if np.any(count > 0.5)
        else np.ones_like(mean)
    )
    usual = np.maximum(ndimage.median_filter(mean, MOTION.median_blocks, mode="nearest"), 1e-12)
    ratio = mean / usual
    normal = np.cbrt(ratio)
    sd = 1.4826 * np.median(np.abs(normal - np.median(normal)))
    found: Bools = (
        (normal - np.median(normal) > MOTION.loud_score * max(sd, 1e-9))
        & (ratio > MOTION.loud_ratio)
        & (count > 0.5)
    )
    return found


def block_lengths(rate_hz: float) -> list[int]:
    """energy_blocks, and longer ones until one lasts energy_block_s."""
    lengths = list(MOTION.energy_blocks)
    while lengths[-1] < MOTION.energy_block_s * rate_hz:
        lengths.append(4 * lengths[-1])
    return lengths


def loud_anywhere(energy: Floats, good: Bools, rate_hz: float) -> Bools:
    """From short blocks to long ones, which are asked about what is left."""
    found = np.zeros(len(energy), bool)
    for length in block_lengths(rate_hz):
        if len(energy) >= 2 * MOTION.median_blocks * length:
            seen = good & ~widened(found, 16)
            found |= expanded(loud(np.where(seen, energy, 0), seen, length), length, len(energy))
    return found


def steady(w: Floats, first: int, end: int) -> bool:
    """Is a loud stretch of whitened rate noise that has grown: as much in every band, and all
    along."""
    part = w[first:end]
    power = signals.transform(part)[1:] ** 2
    bands = np.array([band.mean() for band in np.array_split(power, 4)])
    doubt = 5 * np.sqrt(2 * 4 / len(power))
    blocks = averaged(part**2, 64)
    # It may grow and fade slowly; what is not white need not grow with it.
    even = np.all(blocks < ndimage.uniform_filter1d(blocks, 9) * (1 + 7 * np.sqrt(2 / 64)))
    return bool(even and np.ptp(np.log(np.maximum(bands, 1e-12))) < max(doubt, 0.5))


def beside(good: Bools, first: int, end: int) -> tuple[Ints, Ints]:
    """The nearest good samples before and after a stretch, on each side as many as it has."""
    reach = max(256, end - first)
    return np.flatnonzero(good[:first])[-reach:], end + np.flatnonzero(good[end:])[:reach]


def passing(energy: Floats, seen: Bools, quiet: Bools, first: int, end: int) -> bool:
    """Is a loud stretch louder than the quiet before and after: not the beginning of vibration or
    of noise that stays."""
    sides = [energy[places] for places in beside(quiet, first, end)]
    inside = energy[first:end][seen[first:end]]
    return not len(inside) or all(
        inside.mean() > MOTION.loud_ratio * side.mean() for side in sides if len(side) >= 64
    )


def courses(accels: Sequence[Floats], first: int, end: int, rate_hz: float) -> list[Floats]:
    """What a gyro may follow without being turned: a level, a slope, acceleration, its local
    square."""
    count = end - first
    rows = [np.ones(count), np.linspace(-1, 1, count)]
    for a in accels:
        part = a[first:end] - a[first:end].mean()
        rows += [part, ndimage.uniform_filter1d(part**2, max(3, int(rate_hz)))]
    return rows


def without_courses(y: Floats, rows: Sequence[Floats]) -> Floats:
    """y less its best fit by the rows and by one step."""
    basis = np.linalg.qr(np.column_stack(rows))[0]
    rest = y - basis @ (basis.T @ y)
    places = np.unique(np.linspace(1, len(y) - 1, 200).astype(int))
    best, gain = rest, 0.0
    for place in places:
        step = (np.arange(len(y)) >= place).astype(float)
        step -= basis @ (basis.T @ step)
        size = step @ rest / max(step @ step, 1e-12)
        if size**2 * (step @ step) > gain:
            best, gain = rest - size * step, size**2 * (step @ step)
    found: Floats = best
    return found


def without_lines(y: Floats) -> Floats:
    """y less its strongest lines, when these are most of it."""
    c = np.fft.rfft(y * 1.0)
    power = np.abs(c) ** 2
    for _ in range(3):
        peak = 10 + int(np.argmax(power[10:])) if len(power) > 20 else 0
        if power[peak] < 30 * np.median(power):
            break
        near = slice(max(0, peak - 3), peak + 4)
        c[near], power[near] = 0, 0
    return np.fft.irfft(c, len(y))


def levels_at_rest(y: Floats, good: Bools, rate_hz: float) -> Level:
    """(slow, fast): spread of rates averaged over a quarter of a second, and of samples about their
    mean over a second, at rest."""
    slow, _, whole = slow_and_fast(y, good, rate_hz)
    y = recordings.filled(y[good], good)
    fast = averaged(spread(y, max(4, int(rate_hz))), max(1, int(MOTION.smooth_s * rate_hz)))
    white = white_in_means(y, np.ones(len(y), bool), max(1, int(MOTION.smooth_s * rate_hz)))
    return slow_level(slow, whole, 0.3, white), low_level(fast, whole, 0.3)


def explained(
    y: Floats, levels: Level, accels: Sequence[Floats], first: int, end: int, rate_hz: float
) -> bool:
    """Does a level, a step, a line, or what the gyro feels of acceleration leave nothing loud of a
    stretch."""
    length, second = max(1, int(MOTION.smooth_s * rate_hz)), max(4, int(rate_hz))
    margin = max(64, (end - first) // 2)
    low, high = max(0, first - margin), min(len(y), end + margin)
    less = without_courses(y[low:high], courses(accels, low, high, rate_hz))
    for rest in (less, without_lines(less)):
        slow = spread(averaged(rest, length), max(8, int(MOTION.span_s / MOTION.smooth_s))).max(
            initial=0
        )
        fast = np.sqrt(np.mean(spread(rest, second)[first - low : end - low] ** 2))
        if (
            slow < 0.75 * MOTION.turn * levels[0]
            and fast < (1.12 + 3 / np.sqrt(2 * (end - first))) * levels[1]
        ):
            return True
    return False


def turns(
    rates: Sequence[Floats],
    levels: Sequence[Level],
    accels: Sequence[Floats],
    good: Bools,
    rate_hz: float,
) -> Bools:
    """Where the sensor was turned: the rate says so by itself."""
    found = np.zeros(len(good), bool)
    for y, level in zip(rates, levels):
        for first, end in stretches(
            widened(turning(y, good, rate_hz), MOTION.ring_s * rate_hz / 2)
        ):
            if end - first > MOTION.short_s * rate_hz and not explained(
                y, level, accels, first, end, rate_hz
            ):
                found[first:end] = True
    return widened(found, MOTION.ring_s * rate_hz / 2)


def touches(
    rates: Sequence[Floats],
    levels: Sequence[Level],
    accels: Sequence[Floats],
    good: Bools,
    rate_hz: float,
) -> Bools:
    """Where the sensor was touched: rates are louder for a while, and the accelerometer felt it
    too."""
    ws = [whitened(y, good) for y in rates]
    alone = [lone(w, good) for w in ws]
    energies = [np.where(near, 0, w**2) for w, (_, near) in zip(ws, alone)]
    seen = good & ~np.any([near for _, near in alone], axis=0)
    energy = cast(Floats, sum(energies))
    heard = loud_anywhere(energy, seen, rate_hz)
    wild: Bools = np.logical_or.reduce([at for at, _ in alone])
    if not heard.any() and not (wild.any() and accels):
        return heard
    witness = witnesses(accels, energies, good)
    found = widened(wild, 2) & witness[1]
    # What these leave in the whitened record is tested when they, and how they fade, are out.
    if found.any():
        return widened(found, MOTION.smooth_s * rate_hz)
    near = widened(heard, rate_hz / 2)
    for first, end in stretches(near):
        if not any(
            borne_out(felt, good, good & ~near, first, end) for felt in witness[0]
        ) or not passing(energy, seen, seen & ~near, first, end):
            continue
        if end - first > MOTION.steady_s * rate_hz and all(steady(w, first, end) for w in ws):
            continue
        if not all(
            explained(y, level, accels, first, end, rate_hz) for y, level in zip(rates, levels)
        ):
            found[first:end] = True
    return found


def witnesses(
    accels: Sequence[Floats], energies: Sequence[Floats], good: Bools
) -> tuple[list[Floats], Bools]:
    """Energies that bear the gyro out, and where one is wild: of the accelerometer; without one, of
    the second loudest axis of the gyro."""
    if accels:
        ws = [whitened(a, good) for a in accels]
        felt = cast(Floats, sum(w**2 for w in ws))
        return [felt], widened(np.logical_or.reduce([wilder(w, good) for w in ws]), 2)
    return ([np.sort(energies, axis=0)[-2]] if len(energies) > 1 else []), np.zeros(len(good), bool)


def borne_out(energy: Floats, good: Bools, quiet: Bools, first: int, end: int) -> bool:
    """Is an energy larger in a stretch than in the quiet beside it, all along or in its loudest 16
    samples."""
    places = np.concatenate(beside(quiet, first, end))
    inside = np.where(good[first:end], energy[first:end], 0)
    if len(places) < 64 or not len(inside):
        return False
    usual, peak = (
        energy[places].mean(),
        ndimage.uniform_filter1d(inside, 16, mode="constant").max(),
    )
    found: bool = (
        inside.mean() > (1 + MOTION.witness / np.sqrt(len(inside))) * usual
        or peak > (1 + MOTION.witness / 4) * usual
    )
    return found


def find(recording: Recording, good: Bools) -> Bools:
    """True where the recording holds motion. A long recording is processed in pieces."""
    sensors = [moving(recording, sensor) for sensor in ("gyro", "accel")]
    marks = np.linspace(0, len(good), max(1, len(good) // MOTION.piece_samples) + 1).astype(int)

    def piece(first: int, end: int) -> Bools:
        rates, accels = (
            [
                recording.columns[name][first:end].astype(np.float64) * factor
                for name, factor in columns.items()
            ]
            for columns in sensors
        )
        return between(rates, accels, good[first:end], recording.rate_hz)

    return np.concatenate([piece(first, end) for first, end in zip(marks, marks[1:])])


def between(
    rates: Sequence[Floats], accels: Sequence[Floats], good: Bools, rate_hz: float
) -> Bools:
    moved: Bools = np.zeros(len(good), bool)
    if good.sum() < MOTION.rest_samples or not rates or len(good) < MOTION.span_s * rate_hz:
        return moved
    levels = [levels_at_rest(y, good, rate_hz) for y in rates]
    moved = turns(rates, levels, accels, good, rate_hz)
    for _ in range(MOTION.touch_rounds):
        still = good & ~moved
        if still.sum() < MOTION.rest_samples:
            break
        more = touches(rates, levels, accels, still, rate_hz) & ~moved
        if not more.any():
            break
        moved |= more
    moved = ~holes_kept(~moved, MOTION.pause_s * rate_hz)
    moved = ~holes_kept(~grown_to(rates, accels, moved, good, rate_hz), MOTION.pause_s * rate_hz)
    return moved | tilts(rates, accels, good & ~moved, rate_hz)


def grown_to(
    rates: Sequence[Floats], accels: Sequence[Floats], moved: Bools, good: Bools, rate_hz: float
) -> Bools:
    """The motion with the loud blocks beside it, one after the other: how a touch begins and
    fades. Noise that stays grown is not part of it."""
    still, length = good & ~moved, int(MOTION.grow_s * rate_hz)
    if length < SIGNALS.scatter_least or not moved.any() or still.sum() < MOTION.rest_samples:
        return moved
    count = averaged(still.astype(float), length)
    known = count > 0.5
    found = moved.copy()
    if np.count_nonzero(known) < MOTION.median_blocks:
        return moved
    near = widened(moved, length)  # a block with the edge of the motion in it may lie between
    for x in (*rates, *accels):
        w = whitened(x, still)
        scale = np.cbrt(averaged(w**2, length) / np.maximum(count, 1e-9))
        usual = np.median(scale[known])
        sd = 1.4826 * np.median(np.abs(scale[known] - usual))
        louder = expanded(known & (scale > usual + MOTION.grow * sd), length, len(good)) & still
        for first, end in stretches(louder):
            lasting = end - first > max(64, MOTION.steady_s * rate_hz) and steady(w, first, end)
            found[first:end] |= near[first:end].any() and not lasting
    return found


def tilts(rates: Sequence[Floats], accels: Sequence[Floats], good: Bools, rate_hz: float) -> Bools:
    """Where gravity's direction changed and the gyro turned meanwhile, quickly or slowly; all of a
    stretch between two tilts that undo each other."""
    found = np.zeros(len(good), bool)
    length = int(MOTION.tilt_s * rate_hz)
    if not accels or not rates or length < 16 or len(good) < 30 * length:
        return found
    count = averaged(good.astype(float), length)
    whole = count > 0.5
    gravity, shaken = levels(accels, good, count, length)
    rate, noisy = levels(rates, good, count, length)
    moved = gravity[:, 2:] - gravity[:, :-2]
    scores = np.sqrt(np.sum(moved**2 / (robust(moved) ** 2 + 2 * shaken), axis=0))
    apart = scores * (
        ndimage.uniform_filter1d(whole.astype(float), 7)[1:-1] > 0.99
    )  # not beside what was cut
    edges = [
        i
        for i in np.flatnonzero(apart > MOTION.tilt)
        if apart[i] == apart[max(0, i - 3) : i + 4].max()
    ]
    back = rate[:, 1:-1] - (rate[:, 2:] + rate[:, :-2]) / 2
    limit = chi2_isf(0.5e-3 / max(len(edges), 1), len(rates))
    size, steady = (
        np.sqrt(robust(back) ** 2 + 1.5 * noisy),
        np.sqrt(robust(back) ** 2 / 1.5 + noisy.max(axis=1, keepdims=True)),
    )
    seen = [
        np.arange(i, i + 3)
        if len(rates) > 1 and turned(back, size, moved, i, length / rate_hz, limit)
        else followed(rate / steady, gravity, whole, i + 1, steady * length / rate_hz, limit)
        for i in edges
    ]
    for number, i in enumerate(edges):
        for block in seen[number]:
            found[block * length : (block + 1) * length] = True
        for other in range(number):
            j, undone = edges[other], np.linalg.norm(moved[:, i] + moved[:, edges[other]])
            small = min(np.linalg.norm(moved[:, i]), np.linalg.norm(moved[:, j]))
            if (
                (len(seen[number]) or len(seen[other]))
                and undone < 0.5 * small
                and (i - j) * length < len(good) / 10
            ):
                found[j * length : (i + 3) * length] = True
    return found


def robust(x: Floats) -> Floats:
    found: Floats = np.maximum(
        1.4826 * np.median(np.abs(x - np.median(x, axis=1, keepdims=True)), axis=1, keepdims=True),
        1e-12,
    )
    return found


def levels(
    signals_of: Sequence[Floats], good: Bools, count: Floats, length: int
) -> tuple[Floats, Floats]:
    """Means of blocks per axis, and, of three neighbouring blocks, the largest variance that their
    samples would give such a mean."""
    about: list[Floats] = [np.where(good, x - x[good].mean(), 0) for x in signals_of]
    mean = np.array([averaged(x, length) for x in about]) / np.maximum(count, 1e-9)
    square = np.array([averaged(x**2, length) for x in about]) / np.maximum(count, 1e-9)
    variance = ndimage.maximum_filter1d(np.maximum(square - mean**2, 0) / length, 3, axis=1)[
        :, 1:-1
    ]
    there = count > 0.5
    if not there.any():  # nowhere is enough of a block at rest
        return np.zeros_like(mean), variance
    return np.array([recordings.filled(row[there], there) for row in mean]), variance


def followed(
    rate: Floats, gravity: Floats, whole: Bools, centre: int, unit: Floats, limit: float
) -> Ints:
    """The blocks of a tilt whose rate the gyro followed, by chance no more often than the limit
    says and by an angle worth the tilt; none where it did not. What the gyro feels of gravity
    itself, its level and its slope are no turn. `rate` in units of its scatter, `unit` in
    degrees."""
    near = np.arange(
        max(1, centre - MOTION.tilt_blocks), min(len(whole) - 1, centre + MOTION.tilt_blocks + 1)
    )
    near = near[whole[near - 1] & whole[near] & whole[near + 1]]
    way = gravity[:, centre + 1] - gravity[:, centre - 1]
    course = np.degrees(way @ gravity / np.linalg.norm(way))
    turn = (course[near + 1] - course[near - 1]) / 2  # in a block
    rows = np.column_stack(
        [np.ones(len(near)), near - centre, course[near] - course[near].mean(), turn]
    )
    if len(near) < 2 * rows.shape[1]:
        found: Ints = near[:0]
        return found
    q, r = np.linalg.qr(rows)
    score = rate[:, near] @ q[:, -1]
    share = np.linalg.norm(score * unit[:, 0]) / max(abs(r[-1, -1]), 1e-12)
    found = (
        near[np.abs(turn) > 0.05 * np.abs(turn).max()]
        if np.sum(score**2) > limit and share > 0.3
        else near[:0]
    )
    return found


def turned(back: Floats, size: Floats, moved: Floats, i: int, seconds: float, limit: float) -> bool:
    """Did the gyro leave its level for the time of a quick tilt, by chance no more often than the
    limit says, and by an angle worth the tilt. Of two axes or more: one may be the vertical one."""
    near = slice(max(0, i - 1), i + 2)
    place = near.start + np.argmax(np.sum((back[:, near] / size[:, near]) ** 2, axis=0))
    angle, tilt = np.linalg.norm(back[:, place]) * seconds, np.degrees(np.linalg.norm(moved[:, i]))
    found: bool = np.sum((back[:, place] / size[:, place]) ** 2) > limit and angle > 0.3 * tilt
    return found
