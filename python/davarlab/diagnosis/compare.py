"""Model against measurement: Allan deviations over time and tau, one error, its floor, one p-value
(DESIGN 7, 8)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from ..arrays import Floats, Ints
from ..data import signals
from ..data.observations import Observation
from ..data.recording import Recording
from ..distributions import chi2_sf, norm_sf
from ..inference import changes, modulation
from ..inference.estimate import vector_likelihood
from ..inference.parts import Bench, Part, part_of
from ..inference.whittle import generalised_least_squares
from ..model import Model, Term, unit_said
from . import fitting, judge
from .judge import Cell, Judgement
from .state import Judged, Progress, State

Residual = tuple[Floats, Floats, Ints]  # f, measured over model, degrees of freedom
AnyState = TypeVar("AnyState", bound=State)


@dataclass
class Comparison:
    """samples: those that are there; missing: places of the even grid without one; duration_s: of
    the grid."""

    samples: int
    rate_hz: float
    effects: list[str]
    judgement: Judgement
    cells: Sequence[Cell]
    tests: dict[str, float]
    where: list[Cell]
    spectrum: Residual
    correlations: dict[str, tuple[float, float]]  # column -> (correlation, p)
    observations: Sequence[Observation]  # what is in the record and no error of the sensor
    missing: int
    duration_s: float
    unit: str = "deg/s"  # of the Allan deviations

    @property
    def error(self) -> float:
        return self.judgement.error

    @property
    def error_floor(self) -> float:
        return self.judgement.floor

    @property
    def p_value(self) -> float:
        return self.judgement.p_value

    @property
    def adequate(self) -> bool:
        return self.judgement.adequate


def residual_spectrum(state: State) -> Residual:
    data = state.bench.data
    c = state.bench.whitened(state.parts, state.fit)
    edges = np.unique(np.round(np.geomspace(1, len(c), 90)).astype(int)) - 1
    counts = np.diff(edges)
    return (
        np.add.reduceat(data.f, edges[:-1])[: len(counts)] / np.maximum(counts, 1),
        np.add.reduceat(c**2, edges[:-1], dtype=np.float64)[: len(counts)] / np.maximum(counts, 1),
        counts,
    )


def correlations(state: State, column: str, gyros: bool = False) -> dict[str, tuple[float, float]]:
    """Of the whitened residual with every other column that changes: column -> (correlation, p).
    gyros: with other gyros too."""
    bench, found = state.bench, {}
    w = bench.whitened(state.parts, state.fit)  # of ordinates, as of samples
    w = w.astype(np.float64, copy=False)
    level = np.sqrt(bench.data.at_ordinates(state.fit.level))
    for name, values in bench.recording.columns.items():
        other_gyro = name.startswith("gyro_") and not gyros
        if name in ("time_s", column) or other_gyro or np.ptp(values) == 0:
            continue
        x = signals.transform(values)[1:] / level
        r = float(w @ x / np.sqrt((w @ w) * (x @ x)))
        found[name] = (r, float(2 * norm_sf(abs(r) * np.sqrt(len(w) + 1))))
    return found


def as_given(state: AnyState, model: Model) -> AnyState:
    """The state with the parameters of the file instead of the fitted ones; the mean of the gyro
    stays free."""

    def of_file(part: Part, term: Term) -> Part:
        return replace(
            part,
            shape=part.shape
            | {name: value for name, value in term.parameters.items() if name in part.shape},
        )

    given = [
        part if part.form == "decoded" else of_file(part, term)
        for part, term in zip(state.parts, model.terms)
    ]
    bench = state.bench.resolving(given)
    found: list[float] = []
    coefficients: list[float] = []
    for part, term in zip(given, model.terms):
        size = part.effect.dps(term.parameters)
        if part.role == "spectrum":
            found.append(size**2 * whiter(model, part, state))
        elif part.role == "mean":
            coefficients += (
                line_as_given(bench, part, size)
                if part.turning
                else [size * bench.data.scale(bench.keys(part)[0])]
            )
    coefficients += list(
        generalised_least_squares(bench.data, bench.all_keys(given), state.fit.level)[0][
            len(coefficients) :
        ]
    )  # how filters settle
    behind = [
        term.parameters.get(part.behind, 0.0) ** 2
        for part, term in zip(given, model.terms)
        if part.behind
    ]
    sizes, courses = np.array((found or [1e-30]) + behind), np.array(coefficients)
    level = np.maximum(bench.rows(given).T @ sizes + bench.fixed(given), 1e-30)
    fit = type(state.fit)(
        sizes,
        courses,
        vector_likelihood(bench, given, sizes, courses),
        level,
        np.zeros((0, 0)),
    )
    return replace(state, bench=bench, parts=tuple(given), fit=fit)


def whiter(model: Model, part: Part, state: State) -> float:
    """Mean of what modulates the white noise, over its quiet level, as the file says."""
    if part.kind != "angle_random_walk":
        return 1.0
    blocks = changes.blocks_of(state.bench.y, state.bench.recording.rate_hz)
    growth = [part_of(term) for term in model.terms if term.kind == "temperature_noise"]
    factor = float(modulation.white_growth(growth, state.bench.recording, blocks).mean())
    white = next(
        part.effect.dps(t.parameters) for t in model.terms if t.kind == "angle_random_walk"
    )
    for term in model.terms:
        if term.kind == "noise_step":
            span = len(state.bench.y) / state.bench.recording.rate_hz
            inside = (
                min(term.parameters["stop_s"], span) - min(term.parameters["start_s"], span)
            ) / span
            factor += (term.parameters["ratio"] ** 2 - 1) * max(inside, 0)
        elif modulation.adds(part_of(term)) and white > 0:
            row = modulation.variance_shapes([part_of(term)], state.bench.recording, blocks)[1]
            size = part_of(term).effect.dps(term.parameters)
            factor += size**2 * row.mean() / (white**2 * state.bench.recording.rate_hz)
    return factor


def line_as_given(bench: Bench, part: Part, amplitude: float) -> list[float]:
    """The file has no phase: it is taken from the recording, the amplitude from the file."""
    keys = bench.keys(part)
    values = np.array(
        [bench.data.product("gyro", key).sum() / (bench.data.scale(key) or 1) for key in keys]
    )
    values *= amplitude / max(float(np.hypot(*values)), 1e-300)
    return [float(value * bench.data.scale(key)) for value, key in zip(values, keys)]


def of_state(state: Judged, column: str) -> Comparison:
    """The comparison that a judged state comes to."""
    where = sorted(
        (cell for cell, off in zip(state.cells, judge.proven(state.cells)) if off),
        key=lambda cell: -abs(cell.z),
    )
    recording = state.bench.recording
    return Comparison(
        recording.measured_samples,
        recording.rate_hz,
        state.model_kinds,
        state.judgement,
        state.cells,
        state.adequacy.tests,
        where[:40],
        residual_spectrum(state),
        correlations(state, column),
        state.seen,
        recording.samples - recording.measured_samples,
        recording.samples / recording.rate_hz,
        unit_said("deg/s", column),
    )


def loss_of(fitted: State, state: State) -> tuple[float, int]:
    """Twice the log-likelihood that the given parameters lose against the fitted ones, and how many
    they are."""
    return (
        2 * (fitted.fit.log_likelihood - state.fit.log_likelihood),
        len(fitted.fit.sizes) + len(fitted.fit.coefficients),
    )


def sizes_agree(fitted: State, state: State) -> bool:
    """Were the given parameters fitted on this recording."""
    loss, free = loss_of(fitted, state)
    return loss < 0.02 * free


def given_p_value(fitted: Judged, state: State) -> float:
    """p of the shape of the refitted model, and of the given parameters against the fitted ones
    (7.4)."""
    if sizes_agree(fitted, state):
        return fitted.adequacy.p_value
    loss, free = loss_of(fitted, state)
    p = min(fitted.adequacy.p_value, float(chi2_sf(loss, free)))
    return 1 - (1 - p) ** 2


def given(fitted: Judged, model: Model) -> Judged:
    """The state of the model with the parameters of the file, judged (7.4)."""
    state = replace(as_given(fitted, model), adequacy=fitted.adequacy)
    found, short = fitting.cells_of(state, fitting.relative_variance(state))
    judgement = judge.judged(
        found,
        short,
        given_p_value(fitted, state),
        state.spoiled_by,
        fitting.reading_of(state, found),
    )
    return replace(state, cells=tuple(found), judgement=judgement)


def compare(
    recording: Recording,
    model: Model,
    progress: Progress = lambda text: None,
    fitted: Judged | None = None,
) -> Comparison:
    """The model as given against the recording."""
    fitted = fitted or fitting.judged(fitting.start(recording, model, progress))
    progress("Allan deviations")
    return of_state(given(fitted, model), model.column)
