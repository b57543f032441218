"""The likelihood of a recording in the cosine domain, and its maximum (DESIGN 1 to 3)."""

import copy
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
import scipy
from scipy import linalg
from scipy.linalg import lapack

from .. import arrays
from ..arrays import Bools, Floats, Ints
from ..data import signals
from ..thresholds import FIT

Bands = tuple[tuple[float, float], ...]  # (frequency, half width in Hz) of each


@dataclass
class Fit:
    """Sizes (>= 0) of the spectra, coefficients of the columns, log-likelihood, level per bin;
    `measured`: Allan variances of the columns' course."""

    sizes: Floats
    coefficients: Floats
    log_likelihood: float
    level: Floats
    covariance: Floats
    measured: dict[tuple[int, int, bool], Any] = field(default_factory=dict)


@dataclass
class Work:
    """What an analysis has cost: fits of sizes, and transforms of columns. The same on every
    machine, so a search can be bounded by it."""

    fits: int = 0
    transforms: int = 0


class Data:
    """A recording in the cosine domain: the gyro and, on demand, columns; all products summed per
    bin and remembered. `work`: shared with what is derived from it."""

    def __init__(self, y: Floats, rate_hz: float, edges: Ints | None = None) -> None:
        self.rate_hz, self.samples, self.work = rate_hz, len(y), Work()
        self.columns: dict[str, tuple[Floats, float]] = {}
        self.bands: Bands = ()
        self.cut(signals.bin_edges(len(y) - 1))
        self.add("gyro", y)

    def cut(self, edges: Ints) -> None:
        """Takes these bins: what was summed per bin is forgotten."""
        self.edges, self.starts = edges, edges[:-1]
        self.counts: Floats = np.diff(edges).astype(float)
        self.f_bin: Floats = (edges[:-1] + edges[1:] + 1) * self.rate_hz / (4 * self.samples)
        self.products: dict[tuple[str, str], Floats] = {}
        self.spectra: dict[Hashable, Floats] = {}
        # By the keys of the parts, and whether the fit is restricted.
        self.fits: dict[tuple[tuple[Hashable, ...], bool], Fit] = {}

    @property
    def f(self) -> Floats:
        """The frequencies of the ordinates, worked out each time."""
        return signals.frequencies(self.samples, self.rate_hz)

    def again(self) -> "Data":
        """The same gyro and nothing else, for another analysis."""
        other = copy.copy(self)
        other.work, other.bands, other.columns = Work(), (), {"gyro": self.columns["gyro"]}
        other.cut(signals.bin_edges(self.samples - 1))
        return other

    def with_gyro(self, y: Floats) -> "Data":
        """The same columns and bins with another gyro record."""
        other = copy.copy(self)
        other.columns = dict(self.columns)
        other.products, other.fits = (
            {pair: value for pair, value in self.products.items() if "gyro" not in pair},
            {},
        )
        other.add("gyro", y)
        return other

    def resolves(self, bands: Bands) -> bool:
        return set(bands) <= set(self.bands)

    def resolving(self, bands: Bands) -> "Data":
        """The same columns with bins that are narrow about each band (frequency, half width in Hz)
        (1.3)."""
        other, scale = copy.copy(self), 2 * self.samples / self.rate_hz
        other.bands = bands
        other.cut(
            signals.bin_edges(self.samples - 1, [(f * scale, width * scale) for f, width in bands])
        )
        return other

    def add(self, key: str, x: Floats, together: int = 1) -> None:
        """Columns are scaled to unit norm inside; `scale` undoes it. A constant column has scale 0.
        Of a slow one, means of `together` samples say all: the ordinates behind theirs are 0 and
        not kept (1.4)."""
        self.work.transforms += 1
        count = len(x) // together
        x = x[: count * together].reshape(count, together).mean(axis=1) if together > 1 else x
        off = x - x.mean()
        norm = 1.0 if key == "gyro" else float(np.sqrt(together * (off @ off)))
        ok = key == "gyro" or norm > 1e-9 * max(1e-30, float(x.max()), -float(x.min()))
        off *= np.sqrt(together) / norm if ok else 0.0
        narrow = self.samples >= arrays.NARROW_FROM
        if narrow and key != "gyro":
            off = off.astype(np.float32)
        c = signals.transform(off, spare=True)[1:]
        c = c.astype(np.float32, copy=False) if narrow else c
        self.columns[key] = c, norm if ok else 0.0

    def scale(self, key: str) -> float:
        return self.columns[key][1]

    def product(self, a: str, b: str) -> Floats:
        key = (a, b) if a <= b else (b, a)
        if key not in self.products:
            x, y = self.columns[a][0], self.columns[b][0]
            length = min(len(x), len(y))
            starts = self.starts[: np.searchsorted(self.starts, length)]
            self.products[key] = np.zeros(len(self.starts))
            self.products[key][: len(starts)] = np.add.reduceat(
                x[:length] * y[:length], starts, dtype=np.float64
            )
        return self.products[key]

    def without(self, coefficients: Floats, keys: Sequence[str]) -> Floats:
        """The gyro's ordinates less those of the columns, in the precision in which they are
        kept."""
        c = self.columns["gyro"][0].copy()
        for key, value in zip(keys, coefficients):
            column = self.columns[key][0]
            c[: len(column)] -= value * column
        return c

    def binned(self, key: Hashable, spectrum: Callable[[Floats], Floats]) -> Floats:
        """A spectrum at the bins (narrow enough that the value at the mean frequency is the mean
        within 2e-4)."""
        if key not in self.spectra:
            self.spectra[key] = spectrum(self.f_bin)
        return self.spectra[key]

    def whitened(self, level: Floats, coefficients: Floats, keys: Sequence[str]) -> Floats:
        """The residual with the model's spectrum divided out: unit white noise when the model is
        true."""
        found = self.without(coefficients, keys)
        for part, some in self.pieces(level):
            found[part] /= np.sqrt(some, out=some)
        return found

    def at_ordinates(self, level: Floats) -> Floats:
        """A level per bin at every ordinate."""
        found = np.empty(self.samples - 1)
        for part, some in self.pieces(level):
            found[part] = some
        return found

    def pieces(self, level: Floats) -> Iterator[tuple[slice, Floats]]:
        """The same, a piece at a time: (ordinates, their level)."""
        middle = np.log(self.f_bin)
        for first in range(0, self.samples - 1, signals.PIECE):
            end = min(first + signals.PIECE, self.samples - 1)
            f = signals.frequencies(self.samples, self.rate_hz, first, end)
            yield slice(first, end), np.interp(np.log(f, out=f), middle, level)


@dataclass
class Sums:
    """What a fit needs of the record and of some columns: energies of the gyro, its products with
    the columns (k rows), theirs with each other (a row per pair of `pairs`), all per bin."""

    energy: Floats
    cross: Floats
    gram: Floats
    pairs: tuple[Ints, Ints]

    def at(self, level: Floats) -> tuple[Floats, Floats, Floats]:
        """(coefficients of the columns at this level, their covariance, energy of the residual per
        bin)."""
        if not len(self.cross):
            return np.zeros(0), np.zeros((0, 0)), self.energy
        weight = 1 / level
        matrix = np.empty((len(self.cross), len(self.cross)))
        matrix[self.pairs] = matrix[self.pairs[::-1]] = self.gram @ weight
        inverse = inverse_of(matrix)
        beta = inverse @ (self.cross @ weight)
        residual = self.energy - 2 * beta @ self.cross + self.form(np.outer(beta, beta))
        return beta, inverse, np.maximum(residual, 0)

    def form(self, matrix: Floats) -> Floats:
        """The sum over both columns of a symmetric matrix times their products, per bin."""
        rows, columns = self.pairs
        found: Floats = (matrix[self.pairs] * np.where(rows == columns, 1, 2)) @ self.gram
        return found

    def leverage(self, inverse: Floats, level: Floats) -> Floats:
        """Of the columns, per bin; `inverse`: their covariance at this level."""
        return self.form(inverse) / level if len(self.cross) else np.zeros_like(level)


def sums(data: Data, keys: Sequence[str]) -> Sums:
    bins, pairs = len(data.counts), np.triu_indices(len(keys))
    gram = [data.product(keys[i], keys[j]) for i, j in zip(*pairs)]
    return Sums(
        data.product("gyro", "gyro"),
        np.array([data.product(key, "gyro") for key in keys]).reshape(len(keys), bins),
        np.array(gram).reshape(len(gram), bins),
        pairs,
    )


def generalised_least_squares(
    data: Data, keys: Sequence[str], level: Floats
) -> tuple[Floats, Floats, Floats]:
    """Coefficients of the columns, their covariance, the energy of the residual per bin."""
    return sums(data, keys).at(level)


def log_likelihood(data: Data, energy: Floats, level: Floats) -> float:
    return -0.5 * float(np.sum(data.counts * np.log(level) + energy / level))


def non_negative_step(shapes: Floats, wanted: Floats, weight: Floats) -> Floats:
    """The sizes >= 0 with which the shapes come nearest to what is wanted per bin, by least
    squares."""
    weight = np.sqrt(weight)
    design = shapes * weight
    norm = np.sqrt(np.einsum("ij,ij->i", design, design))
    design, wanted = design / norm[:, None], wanted * weight
    right = design @ wanted
    matrix = design @ design.T
    factor = factored(matrix)
    if factor is None:
        free = scipy.optimize.nnls(design.T, wanted)[0]
    else:
        free = solved_by(factor, right)
        if free.min() < 0:
            free = supported(matrix, right, free > 0)
        if free is None:  # the same problem with as many rows as there are shapes
            inner = linalg.solve_triangular(factor, right, trans="T", check_finite=False)
            free = scipy.optimize.nnls(factor, inner)[0]
    found: Floats = free / norm
    return found


def supported(matrix: Floats, right: Floats, live: Bools) -> Floats | None:
    """The solution >= 0 of normal equations, from a first guess of which unknowns are above 0:
    those below leave, and the one that the rest asks for most joins. None where that goes in
    circles."""
    for _ in range(FIT.exchanges):
        free, at = np.zeros(len(right)), np.flatnonzero(live)
        if len(at):
            found = solved(matrix[np.ix_(at, at)], right[at])
            if found is None:
                return None
            free[at] = found
        if free.min() < 0:
            live = free > 0
            continue
        slope = np.where(live, 0.0, right - matrix @ free)
        wanted = int(np.argmax(slope))
        if slope[wanted] <= FIT.slope_least * np.abs(right).max():
            return free
        live = live.copy()
        live[wanted] = True
    return None


def factored(matrix: Floats) -> Floats | None:
    """The upper triangular R of well-posed normal equations, R'R; None: they are not."""
    factor, failed = lapack.dpotrf(matrix)
    return factor if not failed and factor.diagonal().min(initial=1.0) > FIT.pivot_least else None


def solved_by(factor: Floats, right: Floats) -> Floats:
    """The solution of normal equations from their R."""
    found: Floats = lapack.dpotrs(factor, right)[0]
    return found


def solved(matrix: Floats, right: Floats) -> Floats | None:
    """The solution of well-posed normal equations; None: they are not."""
    factor = factored(matrix)
    return None if factor is None else solved_by(factor, right)


def inverse_of(matrix: Floats) -> Floats:
    """Of a symmetric matrix; the pseudo-inverse where columns are too much alike."""
    size = np.diag(matrix)
    inverse: Floats
    if size.min() <= 0:
        inverse = linalg.pinvh(matrix)
        return inverse
    scale = 1 / np.sqrt(np.outer(size, size))
    found = solved(matrix * scale, np.eye(len(matrix)))
    inverse = linalg.pinvh(matrix) if found is None else found * scale
    return inverse


def score_of_row(data: Data, shapes: Floats, residual: Floats, level: Floats, row: Floats) -> float:
    """What a further spectrum would gain, to second order: its score beside the others over its
    information, squared (4.2)."""
    weight = data.counts / (2 * level**2)
    others = shapes * weight
    slope = row @ (weight * (residual / data.counts - level))
    information = row**2 @ weight
    if len(shapes):
        cross = others @ row
        information -= cross @ inverse_of(others @ shapes.T) @ cross
    return 0.5 * max(slope, 0.0) ** 2 / information if information > 0 else 0.0


def score_of_column(data: Data, keys: Sequence[str], level: Floats, key: str) -> float:
    """What a further column would gain at this level, exactly (4.2)."""
    others = (
        np.array([data.product(a, key) for a in keys]) / level
        if keys
        else np.zeros((0, len(level)))
    )
    beta, inverse, _ = generalised_least_squares(data, keys, level)
    slope, information = (
        (data.product(key, "gyro") / level).sum(),
        (data.product(key, key) / level).sum(),
    )
    cross = others.sum(axis=1)
    slope, information = slope - cross @ beta, information - cross @ inverse @ cross
    return 0.5 * slope**2 / information if information > 1e-9 else 0.0


def maximise(
    data: Data,
    shapes: Floats,
    keys: Sequence[str],
    near: Floats | None = None,
    restricted: bool = False,
    fixed: Floats | float = 0.0,
) -> Fit:
    """Fits sizes of `shapes` (rows) and coefficients of the columns `keys`; `near`: a level to
    start from; `fixed`: variance that is there besides. With `restricted`, leverages of the columns
    are taken off the degrees of freedom (REML, DESIGN 3)."""
    counts, known = data.counts, sums(data, keys)
    least = 1e-12 * known.energy.sum() / counts.sum()
    level = near if near is not None else np.maximum(known.energy / counts, 1e-30)
    if near is None and keys:
        level = np.maximum(
            shapes.T @ non_negative_step(shapes, known.energy / counts, counts) + fixed,
            1e-12 * level.max(),
        )
    sizes, before = cast(Floats, None), -np.inf  # there are none before the first step
    for turn in range(FIT.iterations):
        beta, covariance, residual = known.at(level)
        free = counts
        if restricted:
            free = np.maximum(counts - known.leverage(covariance, level), 1e-3 * counts)
        seen, weight = residual / free, counts / (2 * level**2)
        if turn < FIT.scored:
            step = non_negative_step(shapes, seen - fixed, weight)
        else:  # (3.1)
            curved = np.maximum(2 * seen / level - 1, FIT.curvature_least)
            step = non_negative_step(
                shapes, shapes.T @ sizes + (seen - level) / curved, weight * curved
            )
        before_step = log_likelihood(data, seen * counts, level) if turn else -np.inf
        for _ in range(
            FIT.halvings
        ):  # where one ordinate holds nearly all the energy, whole steps go to and fro
            level = np.maximum(shapes.T @ step + fixed, least)
            if log_likelihood(data, seen * counts, level) >= before_step - 1e-9 * abs(before_step):
                break
            step = 0.5 * (sizes + step)
        sizes, now = step, log_likelihood(data, residual, level)
        if abs(now - before) < 1e-6 * (1 + abs(now) * 1e-6):
            break
        before = now
    beta, covariance, residual = known.at(level)
    return Fit(sizes, beta, log_likelihood(data, residual, level), level, covariance)


def size_covariance(data: Data, shapes: Floats, level: Floats) -> Floats:
    """Of the sizes, from the Fisher information."""
    design = shapes * np.sqrt(data.counts / 2) / level
    found: Floats = linalg.pinvh(design @ design.T)
    return found
