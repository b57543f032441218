"""What the page draws, as plain values: the numbers of the terminal, thinned for a screen."""

from collections.abc import Sequence

import numpy as np
import scipy

from ..arrays import Floats
from ..axes import SHOWN, for_analysis
from ..candidates import identifiable
from ..candidates.candidate import Candidate
from ..data.recording import Recording
from ..diagnosis import (
    cells,
    compare,
    contributions,
    evidence,
    fitting,
    search,
    unexplained,
)
from ..diagnosis.state import State
from ..distributions import chi2_isf, norm_sf
from ..effects import table
from ..effects.means import TURNING
from ..inference import allan
from ..inference.estimate import superfluous
from ..inference.parts import part_of, spectrum_of
from ..model import Model, Term, in_metres, is_accel
from ..report import curves, values, verdict, words
from ..report.values import Json
from ..thresholds import CHANCE
from .dataset import Dataset, Outcome

LINES = 400  # points of a spectrum
PIECES, ROWS = 64, 60  # of a spectrogram
HANN = 0.375  # mean square of its window
CLOUD = 800  # points of a column against another
THUMBNAIL = 60  # of one among all columns
# Kinds of the same physics, which stand on one card of the page.
FAMILY = {
    **dict.fromkeys(identifiable.HEAT, "heat"),
    **dict.fromkeys(("narrow_band", *TURNING), "line"),
    **dict.fromkeys(("gauss_markov", "telegraph_noise"), "slow noise"),
}
SHEET = ("angle_random_walk", "bias_instability", "rate_random_walk")  # what a data sheet gives


def deviation(outcome: Outcome) -> Json:
    """The curve over the whole record, and that of each effect."""
    return curves.deviation(outcome.state.cells, contributions.of_state(outcome.state))


def preview(state: State) -> Json:
    """The model's curve alone, as fast as a slider moves: no cells, no record."""
    bench = state.bench
    window = len(bench.y) // 2 * 2
    taus = allan.octaves(window)
    noise, _, _, steady = cells.Expectation(state).over(window, taus)
    course = bench.mean_course(state.parts, state.fit)
    known = allan.windows(course, window, taus)[0][0] ** 2 if np.any(course) else 0.0
    taus_s, model = [m / bench.data.rate_hz for m in taus], np.sqrt(noise + steady + known)
    return {
        "tau_s": taus_s,
        "model": model.tolist(),
        "curve": curves.curve(taus_s, model, contributions.of_state(state)),
    }


def spectrum(state: State) -> Json:
    """Density of the record beside the model's, deg/s/sqrt(Hz), and the largest ordinate of each
    group of frequencies, with its own frequency. Ratios of the residual, without the model's
    courses, to the model's noise: of each group, with the 95 % range of a true model, and of each
    largest ordinate, with the ratio that a true model exceeds anywhere in one record out of a
    hundred."""
    data, fit = state.bench.data, state.fit
    gyro = data.columns["gyro"][0]
    left = data.without(fit.coefficients, state.bench.all_keys(state.parts))
    energy, level = gyro**2, data.at_ordinates(fit.level)
    edges = np.unique(np.round(np.geomspace(1, len(energy), LINES)).astype(int)) - 1
    starts, counts = edges[:-1], np.diff(edges)
    rate = data.rate_hz

    def mean(x: Floats) -> Floats:
        means: Floats = np.add.reduceat(x[: edges[-1]], starts, dtype=np.float64) / counts
        return means

    over = left**2 / level
    peaks = np.array(
        [start + int(np.argmax(over[start:stop])) for start, stop in zip(starts, edges[1:])]
    )
    chance = chi2_isf(CHANCE.family_wise / len(energy), 1)
    return {
        **curves.residual(mean(data.f), mean(over), counts),
        "measured": np.sqrt(mean(energy) / rate).tolist(),
        "peak_hz": data.f[peaks].tolist(),
        "peak": np.sqrt(energy[peaks] / rate).tolist(),
        "model": np.sqrt(mean(level + (gyro - left) ** 2) / rate).tolist(),
        "peak_ratio": np.sqrt(over[peaks]).tolist(),
        "peak_chance": float(np.sqrt(chance)),
    }


def card(outcome: Outcome, place: int) -> Json:
    """One effect of the model: its parameters with interval and limits. Where the recording
    permits no model, its numbers are withheld."""
    term, entry = outcome.model.terms[place], outcome.estimates[place]
    units = SHOWN if in_metres(outcome.model.column) else {}
    effect = table.find(term.kind)
    rows = [
        {
            "name": p.name,
            "unit": units.get(p.unit, (p.unit, 1.0))[0],
            "factor": units.get(p.unit, (p.unit, 1.0))[1],  # from the number of the table
            "low_limit": p.low,
            "high_limit": p.high,
            "size": p is effect.size and effect.sized,
            **values.estimates({p.name: entry[p.name]})[p.name],
        }
        for p in effect.parameters
        if p.name in entry
    ]
    return {
        "place": place,
        "kind": term.kind,
        "name": words.named(term.kind, outcome.model.column),
        "title": words.title(term.kind, term.parameters, outcome.model.column),
        "physics": effect.physics,
        "parameters": [
            one | {"value": "withheld", "low": None, "high": None, "size": False} for one in rows
        ]
        if outcome.state.judgement.spoiled_by
        else rows,
        "superfluous": outcome.state.judgement.adequate and superfluous(term.kind, entry),
    }


def without(outcome: Outcome, place: int) -> Json:
    """What the likelihood loses without an effect of the fit, and the error then. Empty: it cannot
    be left out alone."""
    part = outcome.fitted.parts[place]
    rest = [other for other in outcome.fitted.parts if other is not part]
    if part.role == "events" or all(other.role != "spectrum" for other in rest):
        return {}
    return {
        "loss": search.loss_without(outcome.fitted, rest, part),
        "error": fitting.errors_of(fitting.with_parts(outcome.fitted, rest))[0],
    }


def headline(outcome: Outcome, first: bool, known: bool = True) -> Json:
    """The verdict in one line, in three pieces, the second of which is stressed."""
    data = outcome.state.bench.recording
    judgement, duration_s = outcome.state.judgement, data.samples / data.rate_hz
    return {"headline": verdict.headline(judgement, duration_s, first, known)}


def model(outcome: Outcome, recording: Recording, first: bool = True) -> Json:
    """A step as the page shows it. first: does it have no step before it."""
    judgement, tested = outcome.state.judgement, [one.tau_s for one in outcome.state.cells]
    longest = max(tested, default=0.0)
    return {
        **headline(outcome, first),
        "untested": verdict.untested(judgement, longest),
        "shown_s": [
            judgement.shown_from_tau_s,
            judgement.shown_to_tau_s if judgement.adequate else longest,
        ],
        "against": verdict.against(judgement),
        "worst": judgement.largest or judgement.farthest,
        "cards": [card(outcome, place) for place in range(len(outcome.estimates))],
        "deviation": deviation(outcome),
        "map": curves.failure_map(outcome.state.cells),
        "spectrum": spectrum(outcome.state),
        **values.judgement(judgement),
        **{
            name: None if judgement.spoiled_by else getattr(judgement, name)
            for name in ("error", "floor", "p_value")
        },
        "said": verdict.adequacy(judgement),
        "observations": [
            one.plain() | {"said": verdict.observation(one)} for one in outcome.state.seen
        ],
        "notes": evidence.notes(recording, outcome.model),
        "not_noise": [
            words.title(term.kind, term.parameters)
            for term in outcome.model.terms
            if part_of(term).role != "spectrum"
        ],
    }


def ranking(outcome: Outcome, recording: Recording, ranked: Sequence[Candidate]) -> Json:
    """The candidates beside a fit, and the kinds that speak against one that fits. When none is
    significant: the sentences, the plain values of what is left unexplained, and the headline of a
    model that does not fit."""
    found = {"candidates": candidates(ranked), "nothing": [], "unknown": None, "against": []}
    contradicting = evidence.contradicting(ranked)
    sound = [one for one in ranked if not one.doubt]
    if outcome.state.judgement.adequate and contradicting:
        return found | {
            "lacks": verdict.lacks(contradicting),
            "against": [one.kind for one in contradicting],
            "said": verdict.contradicted(contradicting),
        }
    if search.significant(sound):
        return found
    left = unexplained.unexplained_by(
        compare.of_state(outcome.fitted, outcome.model.column),
        recording,
        unexplained.Tried(sound, doubtful={one.kind: one.doubt for one in ranked if one.doubt}),
    )
    fits = outcome.state.judgement.adequate
    return {
        **({} if fits else headline(outcome, False, known=False)),
        **found,
        "nothing": verdict.no_candidate(outcome.fitted.judgement, left),
        "unknown": values.unexplained(left),
    }


def candidates(ranked: Sequence[Candidate]) -> list[Json]:
    """The ranking as a list to choose from; `note`: how to confirm the first one, or how to tell
    another one from it; `leader`: the place of the best one that this recording hardly tells from
    it, or that is of the same physics; `doubt`: why it is not what it seems."""
    sound = [one for one in ranked if not one.doubt]
    alike = {one.kind: one.confirm for one in search.close_ones(sound)}
    notes = {}
    if search.significant(sound):
        first = sound[0].kind
        notes = {**alike, first: f"To confirm: {table.find(first).confirm}"}
    leaders: dict[str, int] = {}
    return [
        {
            "place": place,
            "kind": c.kind,
            "name": words.name(c.kind),
            "title": words.title(c.kind, c.part.shape),
            "leader": leaders.setdefault(FAMILY.get(c.kind, c.kind), place),
            "gain": c.gain,
            "log_p": c.log_p,
            "p": words.p_is(verdict.p_of(c)),
            "beyond_chance": bool(c.log_p + np.log(len(table.TABLE)) < np.log(CHANCE.family_wise)),
            "alike": c.kind in alike,
            "note": notes.get(c.kind),
            "why": evidence.why(c, None),
            "doubt": c.doubt,
            "physics": c.part.effect.physics,
            "confirm": table.find(c.kind).confirm,
        }
        for place, c in enumerate(ranked)
    ]


def densities(
    pieces: Floats, rate_hz: float, lowest: int, groups: int
) -> tuple[list[float], Floats]:
    """(frequencies, densities in deg/s/sqrt(Hz), a row per piece) of pieces of a record, two-sided
    as the spectrum of the whole; the trend of each is taken off, the first `lowest` ordinates are
    left out, the others in groups of equal ratios."""
    length = pieces.shape[1]
    energy = np.abs(np.fft.rfft(scipy.signal.detrend(pieces) * np.hanning(length))) ** 2 / (
        rate_hz * HANN * length
    )
    f = np.fft.rfftfreq(length, 1 / rate_hz)
    edges = np.unique(np.round(np.geomspace(lowest, len(f) - 1, groups)).astype(int))
    return f[edges[:-1]].tolist(), np.sqrt(
        np.add.reduceat(energy[:, : edges[-1]], edges[:-1], axis=1) / np.diff(edges)
    )


def stretch(dataset: Dataset, start_s: float, stop_s: float, every: bool = False) -> Json:
    """What is in a stretch of the record: the gyro, the temperature or every column, the
    spectrum."""
    rate, gyro = dataset.recording.rate_hz, dataset.recording.rate_dps(dataset.column)
    f, density = densities(gyro[None, int(start_s * rate) : int(stop_s * rate)], rate, 1, LINES)
    others = [name for name in dataset.recording.columns if name not in ("time_s", dataset.column)]
    shown = others if every else [name for name in others if name == "temp_degC"]
    columns = [dataset.column, *shown]
    return {
        "start_s": start_s,
        "stop_s": stop_s,
        "envelopes": [
            curves.envelope(name, dataset.recording.column(name), rate, (start_s, stop_s))
            for name in columns
        ],
        "f_hz": f,
        "density": density[0].tolist(),
    }


def against(dataset: Dataset, text: str, column: str, lag_s: float) -> Json:
    x, left, rising = dataset.against(text, column, lag_s, CLOUD)
    return {
        "column": column,
        "lag_s": lag_s,
        "x": x.tolist(),
        "left": left.tolist(),
        "rising": [bool(up) for up in rising],
    }


def moves(dataset: Dataset, text: str) -> list[Json]:
    """Of each logged column, the likeliest first: the means of equal stretches, beside the bias and
    the noise there. The chance of a bias is that of the whitened residual, in which slow noise does
    not pass for a correlation."""
    bias, noise, columns = dataset.moving(text, THUMBNAIL)
    state = dataset.outcome_of(text, True).fitted
    known = compare.correlations(state, dataset.column, gyros=True)
    found = []
    for name, x in columns.items():
        of_bias, of_noise = (correlation(x, y) for y in (bias, noise))
        odds = 2 * norm_sf(abs(np.arctanh(of_noise)) * np.sqrt(len(x) - 3))
        found.append(
            {
                "column": name,
                "x": x.tolist(),
                "bias": tied(bias, of_bias, known.get(name, (0.0, 1.0))[1] * 2 * len(columns)),
                "noise": tied(noise, of_noise, odds * 2 * len(columns)),
            }
        )
    return sorted(found, key=lambda one: min(one["bias"]["chance"], one["noise"]["chance"]))


def correlation(x: Floats, y: Floats) -> float:
    """0 of what is constant."""
    if np.ptp(x) == 0 or np.ptp(y) == 0:
        return 0.0
    return float(np.clip(np.corrcoef(x, y)[0, 1], -1 + 1e-12, 1 - 1e-12))


def tied(y: Floats, correlation: float, p: float) -> Json:
    """What may move with a column. p: counts all columns, for bias and noise."""
    chance = min(1.0, float(p))
    return {
        "y": y.tolist(),
        "correlation": correlation,
        "chance": chance,
        "p": words.p_is(chance),
        "significant": chance < CHANCE.family_wise,
    }


def measured(recording: Recording, column: str) -> Json:
    """The Allan deviation of an axis of a recording, as it was read."""
    window = recording.samples // 2 * 2
    taus = allan.octaves(window)
    whole, model = for_analysis(recording, Model(None, column))
    found = allan.windows(whole.rate_dps(model.column), window, taus, whole.known)[0][0]
    return {
        "column": column,
        "tau_s": [m / recording.rate_hz for m in taus],
        "measured": found.tolist(),
    }


def axes(dataset: Dataset) -> list[Json]:
    """The Allan deviation of every gyro, or accelerometer, of the recording."""
    alike = [name for name in dataset.axes if is_accel(name) == is_accel(dataset.selection.column)]
    return [measured(dataset.whole, name) for name in alike]


def sheet(terms: Sequence[Term], rate_hz: float, samples: int) -> Json:
    """The Allan deviation that a data sheet's numbers give."""
    parts = [part_of(term) for term in terms]
    sizes = [part.effect.dps(term.parameters) ** 2 for part, term in zip(parts, terms)]
    taus = allan.octaves(samples // 2 * 2)
    variance = allan.expected(allan.on_grid(spectrum_of(parts, sizes, rate_hz), rate_hz), taus)
    return {"tau_s": [m / rate_hz for m in taus], "deviation": np.sqrt(variance).tolist()}


def spectrogram(dataset: Dataset, column: str) -> Json:
    """Densities of the gyro over time or over the value of another column: of sixty-fourths of the
    record, in the order of the column."""
    rate, gyro = dataset.recording.rate_hz, dataset.recording.rate_dps(dataset.column)
    length = len(gyro) // PIECES
    f, density = densities(gyro[: length * PIECES].reshape(PIECES, length), rate, 2, ROWS)
    place = (np.arange(PIECES) + 0.5) * length / rate
    if column != "time_s":
        place = (
            dataset.recording.column(column)[: length * PIECES].reshape(PIECES, length).mean(axis=1)
        )
    order = np.argsort(place, kind="stable")
    return {
        "column": column,
        "x": place[order].tolist(),
        "f_hz": f,
        "density": density[order].T.tolist(),
    }
