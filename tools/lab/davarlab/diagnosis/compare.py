"""Model against measurement: Allan deviations over time and tau, one error, its floor, one p-value (DESIGN 7, 8)."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy import special, stats

from ..data import signals
from ..effects.changes import vibration_square
from ..inference import adequacy, allan, changes, parts as parts_of
from ..inference.estimate import vector_likelihood
from . import diagnose

WINDOWS = (1, 4, 16)
SIGNIFICANT = 4.0


@dataclass
class Cell:
    """One window and one tau: measured and model Allan deviation, and how far apart they are."""
    tau_s: float
    start_s: float
    stop_s: float
    measured_dps: float
    model_dps: float
    ratio: float
    z: float
    freedom: float


@dataclass
class Comparison:
    samples: int
    rate_hz: float
    effects: list
    error: float
    error_floor: float
    p_value: float
    adequate: bool
    cells: list
    tests: dict
    where: list = field(default_factory=list)
    spectrum: tuple = ()  # f, measured over model, degrees of freedom
    correlations: dict = field(default_factory=dict)  # column -> (correlation, p)


def model_series(state, sizes=None):
    """What a fitted state expects: spectrum of an ordinate, deterministic course, variance factor per sample or None."""
    bench, active = state.bench, state.parts
    sizes = state.fit.sizes if sizes is None else sizes
    noise = [part for part in active if part.role == "spectrum"] or [parts_of.Part("angle_random_walk")]
    filters = [part for part in active if part.role == "filter"]
    known = bench.counts.level if np.any(bench.fixed(active)) else np.zeros_like

    def spectrum(f):
        gain = np.ones_like(f)
        for part in filters:
            gain = gain * part.effect.spectrum(f, bench.data.rate_hz, part.shape)
        return sum(size * bench.spectrum(part, f)
                   * (gain if part.kind == "angle_random_walk" else 1) for part, size in zip(noise, sizes)) + known(f)

    return spectrum, bench.mean_course(active, state.fit), diagnose.relative_variance(state)[0]


def cells_of(state, y):
    """Cells of the whole record and of its quarters and sixteenths."""
    bench = state.bench
    spectrum, course, variance = model_series(state)
    variance = np.ones(len(y)) if variance is None else variance
    found = []
    for count in WINDOWS:
        window = len(y) // count // 2 * 2
        taus = allan.octaves(window)
        noise = allan.expected(spectrum, taus, bench.data.rate_hz)
        slopes = np.gradient(np.log(noise), np.log(taus)) if len(taus) > 1 else np.array([-1.0])
        measured = remembered(bench.recording.measured, y, window, taus) ** 2
        known = allan.windows(course, window, taus) ** 2 if np.any(course) else np.zeros_like(measured)
        for row in range(len(measured)):
            part = variance[row * window:(row + 1) * window]
            local = noise * np.where(slopes < -0.5, part.mean(), 1.0)
            found += row_cells(row, window, taus, slopes, measured[row], local, known[row], bench.data.rate_hz)
    return found


def remembered(known, y, window, taus):
    """Allan deviations of y in windows, measured once however many models are compared with them."""
    key = (hash(y.tobytes()), window)
    if key not in known:
        known[key] = allan.windows(y, window, taus)
    return known[key]


def row_cells(row, window, taus, slopes, measured, noise, known, rate_hz):
    found = []
    for i, m in enumerate(taus):
        model = noise[i] + known[i]
        share = noise[i] / model
        freedom = allan.freedom(slopes[i], m, window) / max(share ** 2 + 2 * share * (1 - share), 1e-3)
        ratio = measured[i] / model
        z = adequacy.normal_score(ratio, freedom)
        found.append(Cell(m / rate_hz, row * window / rate_hz, (row + 1) * window / rate_hz, float(np.sqrt(measured[i])),
                          float(np.sqrt(model)), float(np.sqrt(ratio)), float(z), float(freedom)))
    return found


def error_of(cells):
    return float(np.sqrt(np.mean([np.log10(max(cell.ratio, 1e-9)) ** 2 for cell in cells])))


def floor_of(cells):
    half = np.array([cell.freedom for cell in cells]) / 2
    square = special.polygamma(1, half) + (special.digamma(half) - np.log(half)) ** 2
    return float(np.sqrt(np.mean(square) / 4) / np.log(10))


def residual_spectrum(state):
    data = state.bench.data
    c = data.whitened(state.fit.level, state.fit.coefficients, state.bench.all_keys(state.parts))
    edges = np.unique(np.round(np.geomspace(1, len(c), 90)).astype(int)) - 1
    counts = np.diff(edges)
    return (np.add.reduceat(data.f, edges[:-1])[:len(counts)] / np.maximum(counts, 1),
            np.add.reduceat(c ** 2, edges[:-1])[:len(counts)] / np.maximum(counts, 1), counts)


def correlations(state, column):
    """Of the whitened residual with every other column, slow part (below rate / 100) and whole."""
    bench, found = state.bench, {}
    w = state.bench.residual(state.parts, state.fit)
    level = np.sqrt(np.interp(np.log(bench.data.f), np.log(bench.data.f_bin), state.fit.level))
    for name, values in bench.recording.columns.items():
        if name in ("time_s", column) or name.startswith("gyro_") or np.ptp(values) == 0:
            continue
        x = signals.inverse(np.concatenate([[0.0], signals.transform(values)[1:] / level]))
        r = float(np.sum(w * x) / np.sqrt(np.sum(w ** 2) * np.sum(x ** 2)))
        found[name] = (r, float(2 * stats.norm.sf(abs(r) * np.sqrt(len(w)))))
    return found


def as_given(state, model):
    """The state with the parameters of the file instead of the fitted ones; the mean of the gyro stays free."""
    bench = state.bench
    given = [part if part.form == "decoded" else replace(part, shape=part.shape | {name: value for name, value in term.parameters.items() if name in part.shape})
             for part, term in zip(state.parts, model.terms)]
    sizes, coefficients = [], []
    for part, term in zip(given, model.terms):
        size = part.effect.dps(term.parameters)
        if part.role == "spectrum":
            sizes.append(size ** 2 * whiter(model, part, state))
        elif part.role == "mean":
            coefficients += line_as_given(bench, part, size) if part.turning else [
                size * bench.data.scale(bench.keys(part)[0])]
    sizes, coefficients = np.array(sizes or [1e-30]), np.array(coefficients)
    level = np.maximum(bench.rows(given).T @ sizes + bench.fixed(given), 1e-30)
    fit = type(state.fit)(sizes, coefficients, vector_likelihood(bench, given, sizes, coefficients), level, np.zeros((0, 0)))
    return diagnose.State(bench, given, fit, state.shocks)


def whiter(model, part, state):
    """Mean of what modulates the white noise, over its quiet level, as the file says."""
    if part.kind != "angle_random_walk":
        return 1.0
    blocks = changes.blocks_of(state.bench.y, state.bench.recording.rate_hz)
    factor = 1.0
    white = next(part.effect.dps(t.parameters) for t in model.terms if t.kind == "angle_random_walk")
    for term in model.terms:
        if term.kind == "noise_step":
            span = len(state.bench.y) / state.bench.recording.rate_hz
            inside = (min(term.parameters["stop_s"], span) - min(term.parameters["start_s"], span)) / span
            factor += (term.parameters["ratio"] ** 2 - 1) * max(inside, 0)
        if term.kind == "vibration_noise" and white > 0:
            square = vibration_square(state.bench.recording, term.parameters["axis"], blocks).mean()
            factor += term.parameters["coefficient_dps_per_g"] ** 2 * square / (
                white ** 2 * state.bench.recording.rate_hz)
    return factor


def line_as_given(bench, part, amplitude):
    """The file has no phase: it is taken from the recording, the amplitude from the file."""
    keys = bench.keys(part)
    values = np.array([bench.data.columns["gyro"][0] @ bench.data.columns[key][0] / (bench.data.scale(key) or 1)
                       for key in keys])
    values *= amplitude / max(float(np.hypot(*values)), 1e-300)
    return [float(value * bench.data.scale(key)) for value, key in zip(values, keys)]


def strip_shocks(state, recording, model):
    return state.shocks.clean if "shocks" in state.model_kinds else recording.rate_dps(model.column)


def compare_state(state, recording, model, p_value):
    cells = cells_of(state, strip_shocks(state, recording, model))
    where = sorted((cell for cell in cells if abs(cell.z) > SIGNIFICANT), key=lambda cell: -abs(cell.z))
    return Comparison(recording.samples, recording.rate_hz, state.model_kinds, error_of(cells), floor_of(cells),
                      p_value, p_value >= diagnose.ADEQUATE, cells, state.adequacy.tests, where[:40],
                      residual_spectrum(state), correlations(state, model.column))


def cells_as_given(recording, model, fitted):
    """The cells alone, of the model as given; `fitted`: its effects refitted on the recording."""
    return cells_of(as_given(fitted, model), strip_shocks(fitted, recording, model))


def error_as_given(recording, model, fitted):
    return error_of(cells_as_given(recording, model, fitted))


def loss_of(fitted, given):
    """Twice the log-likelihood that the given parameters lose against the fitted ones, and how many they are."""
    return (2 * (fitted.fit.log_likelihood - given.fit.log_likelihood), len(fitted.fit.sizes) + len(fitted.fit.coefficients))


def sizes_agree(fitted, given):
    """Were the given parameters fitted on this recording."""
    loss, free = loss_of(fitted, given)
    return loss < 0.02 * free


def given_p_value(fitted, given):
    """p of the shape of the refitted model, and of the given parameters against the fitted ones (7.2)."""
    if sizes_agree(fitted, given):
        return fitted.adequacy.p_value
    loss, free = loss_of(fitted, given)
    p = min(fitted.adequacy.p_value, float(stats.chi2.sf(loss, free)))
    return 1 - (1 - p) ** 2


def compare(recording, model, progress=lambda text: None, fitted=None):
    """The model as given against the recording."""
    fitted = fitted or diagnose.judged(diagnose.start(recording, model, progress))
    progress("Allan deviations")
    given = as_given(fitted, model)
    given.adequacy = fitted.adequacy
    return compare_state(given, recording, model, given_p_value(fitted, given))
