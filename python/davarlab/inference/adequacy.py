"""What is left over, against chance: standardised residuals in frequency and in time, one honest
p-value (DESIGN 7)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import fft, ndimage

from ..arrays import Floats
from ..data import signals
from ..data.counts import Counts
from ..distributions import chi2_sf, norm_sf
from ..thresholds import JUDGE


@dataclass(frozen=True)
class Adequacy:
    """p of the whole, the p-values of the tests by name, and the cells (bands x times) as normal
    scores."""

    p_value: float
    tests: dict[str, float]
    cells: Floats


def normal_score(energy: Floats, freedom: Floats | float) -> Floats:
    """Wilson and Hilferty: a chi-square over its freedom as a normal score."""
    found: Floats = (np.cbrt(energy) - 1 + 2 / (9 * freedom)) / np.sqrt(2 / (9 * freedom))
    return found


def spectrum_score(c: Floats, free: int) -> float:
    edges = np.unique(np.round(np.geomspace(4, len(c), 70)).astype(int))
    counts = np.diff(edges)
    z = normal_score(
        np.add.reduceat(c[: edges[-1]] ** 2, edges[:-1], dtype=np.float64)[: len(counts)] / counts,
        counts,
    )
    return float(chi2_sf(np.sum(z**2), max(len(z) - free, 1)))


def cells_of(c: Floats, kurtosis: float = 0.0) -> Floats:
    """Energies of octave bands in equal stretches of time, as normal scores after each band's own
    mean is taken out. kurtosis: excess of the samples; energy in a share of the band scatters by
    that share of it more."""
    edges = np.unique(
        np.round(
            np.geomspace(len(c) / 2 ** (JUDGE.octave_bands - 1), len(c), JUDGE.octave_bands)
        ).astype(int)
    )
    edges = edges[edges > 12 * JUDGE.time_stretches]
    edges = np.concatenate([[min(12 * JUDGE.time_stretches, len(c) // 4)], edges])
    rows = []
    for low, high in zip(edges[:-1], edges[1:]):
        if high - low < 8 * JUDGE.time_stretches:
            continue
        # No more ordinates than the band needs: its course at a lower rate.
        long = high + 1 > signals.PIECE  # there, a length with large factors costs a lot
        part = np.zeros(fft.next_fast_len(high + 1, real=True) if long else high + 1, np.float32)
        part[low + 1 : high + 1] = c[low:high]
        x = signals.inverse(part, spare=True)
        signals.forget_plans(len(c), signals.transform)
        length = len(x) // JUDGE.time_stretches
        energy = (
            x[: length * JUDGE.time_stretches].reshape(JUDGE.time_stretches, length) ** 2
        ).sum(axis=1, dtype=np.float64)
        freedom = (high - low) / JUDGE.time_stretches / (1 + kurtosis / 2 * (high - low) / len(c))
        rows.append(normal_score(energy / energy.mean(), freedom))
    return np.array(rows).reshape(-1, JUDGE.time_stretches)


def narrow_p(c: Floats) -> float:
    """The strongest of the narrow bands, half overlapping."""
    mean = ndimage.uniform_filter1d(c**2, JUDGE.narrow_ordinates)[
        JUDGE.narrow_ordinates // 2 : -(JUDGE.narrow_ordinates // 2) : 100
    ]
    return (
        float(
            min(
                1.0,
                0.8
                * len(mean)
                * chi2_sf(JUDGE.narrow_ordinates * mean.max(), JUDGE.narrow_ordinates),
            )
        )
        if len(mean)
        else 1.0
    )


def judge(
    c: Floats,
    free: int,
    extra: Mapping[str, float] | None = None,
    quick: bool = False,
    counts: Counts | None = None,
) -> Adequacy:
    """c: whitened residual ordinates; free: fitted parameters; extra: further p-values by name;
    `quick`: without the cells in time; counts (data/counts.py): what they do to single samples is
    known, and some tests fail by it."""
    tests = {"spectrum": spectrum_score(c, free), "narrow band": narrow_p(c)}
    cells = (
        np.zeros((0, JUDGE.time_stretches))
        if quick
        else cells_of(c, counts.kurtosis if counts else 0.0)
    )
    if cells.size:  # a short record has none
        tests["time and frequency"] = float(
            chi2_sf(
                np.sum(cells**2) * JUDGE.time_stretches / (JUDGE.time_stretches - 1), cells.size
            )
        )
        tests["largest cell"] = float(min(1.0, cells.size * 2 * norm_sf(np.abs(cells).max())))
    tests.update(extra or {})
    tests = {name: p for name, p in tests.items() if counts is None or name not in counts.suspends}
    return Adequacy(float(1 - (1 - min(tests.values())) ** JUDGE.independent_tests), tests, cells)
