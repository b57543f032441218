"""What a worker does: one recording, a row for each axis."""

import hashlib
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from davarlab import arithmetic, axes, files, simulate
from davarlab import model as models
from davarlab.candidates.candidate import Candidate
from davarlab.data.recording import Recording, rate_unit
from davarlab.diagnosis import diagnose, fitting, improve, search
from davarlab.diagnosis.improve import Estimates
from davarlab.diagnosis.state import Judged, State
from davarlab.effects import own, table
from davarlab.errors import BadInput
from davarlab.logs import formats
from davarlab.logs.options import Options
from davarlab.model import Model

from . import sources, store
from .sources import Identity
from .store import Done, Row

DATED_S = 946684800  # Unix time of the year 2000: stamps before it count from somewhere else


@dataclass(frozen=True)
class Job:
    """One recording. model: the text of a model file; axes: as --axes takes them, None: the column
    of the model; effects: files of own effects; chance: also draw a recording of the fitted model,
    and ask what it would seem to lack.
    """

    address: str
    model: str
    axes: str | None = None
    how: Options = field(default_factory=Options)
    effects: tuple[str, ...] = ()
    chance: bool = False


def marker(identity: Identity | None, job: Job, version: str) -> str | None:
    """Equal for a job that would come to the same; None where a change of the file could not be
    told.
    """
    how = [job.how.rate_hz, job.how.sensor, job.how.units, job.how.types, job.how.names]
    own = [files.sha256(path) for path in job.effects]
    return (
        None
        if identity is None
        else store.digest(
            [job.address, identity, job.model, job.axes, how, own, version, store.TABLE_VERSION]
        )
    )


def known_effects(paths: Iterable[str]) -> None:
    """Own effects, once a process."""
    for path in paths:
        try:
            own.load(path)
        except BadInput as why:
            if "is taken" not in str(why):
                raise


def measured(job: Job) -> Done:
    """The rows of a recording. Raises nothing that a file could be the cause of."""
    arithmetic.prepared()
    begin, spent, again = time.perf_counter(), time.process_time(), False
    try:
        known_effects(job.effects)
        with sources.fetched(job.address) as path:
            try:
                rows = rows_of(path, job)
            except BadInput as why:
                raise BadInput(
                    str(why).replace(f"{path}: ", "", 1).replace(str(path), job.address)
                ) from None
    except BadInput as why:
        rows = [{"failed": str(why)}]
    except OSError as why:
        rows, again = [{"failed": sources.said(why)}], True
    except MemoryError:
        rows, again = [{"failed": "not enough memory"}], True
    except Exception as why:  # one strange file must not end a night's work
        rows = [{"failed": f"internal error: {type(why).__name__}: {sources.said(why)}"}]
    return {
        "rows": rows,
        "seconds": time.perf_counter() - begin,
        "cpu_s": time.process_time() - spent,
        "again": again,
    }


def rows_of(path: str, job: Job) -> list[Row]:
    recording, given = formats.read(path, job.how), models.of_text(job.model, "model")
    columns = axes.columns_of(recording, job.axes) if job.axes else [given.column]
    return [row_of(recording, replace(given, column=column), job) for column in columns]


def row_of(recording: Recording, given: Model, job: Job) -> Row:
    """One axis as plain values: coefficients with intervals, verdict, gains of what the model
    lacks.
    """
    seen, model = axes.for_analysis(recording, given)
    models.check_fits(model, seen, "model")
    state, ranking, verdict, alternatives = asked(seen, model)
    fitted, entries = improve.fitted_model(state, model)
    found = state.judgement
    row = {
        "axis": given.column,
        "verdict": verdict,
        "alternatives": alternatives,
        "adequacy": found.adequacy,
        "error": found.error,
        "error_floor": found.floor,
        "p_value": found.p_value,
        "samples": recording.measured_samples,
        "rate_hz": recording.rate_hz,
        "temperature_degC": temperature(recording),
        "start_s": start(recording),
        "observations": [one.kind for one in state.seen],
        "coefficients": coefficients(fitted, entries, given.column),
        "gains": gains(ranking),
    }
    if job.chance:
        row["chance"] = gains(search.ranking(fitting.start(drawn(seen, fitted, state), model)))
    return row


def asked(recording: Recording, model: Model) -> tuple[Judged, list[Candidate], str, list[str]]:
    """(judged state of the model, candidates beside it, verdict, kinds that cannot be told from
    it): what diagnose says, without asking twice where no candidate is beyond chance.
    """
    state = fitting.judged(fitting.start(recording, model))
    ranking = search.ranking(state)
    if state.known is None and not search.significant(ranking):
        return state, ranking, "none" if state.judgement.adequate else "unknown", []
    found = diagnose.diagnose(recording, model)
    return state, ranking, found.verdict, [one.kind for one in found.alternatives]


def gains(ranking: Iterable[Candidate]) -> dict[str, float]:
    """kind -> log-likelihood units, none below 0."""
    best: dict[str, float] = {}
    for candidate in ranking:
        best[candidate.kind] = max(best.get(candidate.kind, 0.0), float(candidate.gain))
    return best


def coefficients(
    fitted: Model, entries: Iterable[Estimates], column: str
) -> dict[str, list[float | None]]:
    """ "kind.parameter" as a model file of the column calls it -> [value, low, high]; low and high
    None where the record says next to nothing.
    """
    found = {}
    for term, entry in zip(fitted.terms, entries):
        kind = models.kind_said(term.kind, column)
        for parameter in table.find(term.kind).parameters:
            one = entry.get(parameter.name)
            if one is None or isinstance(one.value, str):
                continue
            name = f"{kind}.{models.name_said(parameter.name, column)}"
            while name in found:
                name += "'"
            found[name] = [one.number, one.low, one.high]
    return found


def temperature(recording: Recording) -> float | None:
    name = next((name for name in recording.columns if name.startswith("temp")), None)
    return float(np.mean(recording.columns[name])) if name else None


def start(recording: Recording) -> float | None:
    """Unix time of the first sample, None where the stamps count from somewhere else."""
    if "time_s" not in recording.columns:
        return None
    begin = recording.origin_ns / 1e9 + float(recording.columns["time_s"][0])
    return begin if begin > DATED_S else None


def seed_of(recording: Recording, column: str) -> int:
    """Of what was measured, so that a recording is drawn alike wherever it lies, under whatever
    name.
    """
    return int.from_bytes(
        hashlib.sha256(np.ascontiguousarray(recording.columns[column], float).tobytes()).digest()[
            :8
        ],
        "big",
    )


def drawn(recording: Recording, fitted: Model, state: State) -> Recording:
    """The recording with its gyro drawn from the fitted model: what there is when nothing is
    missing.
    """
    rng, terms = (
        np.random.default_rng(seed_of(recording, fitted.column)),
        [term for term in fitted.terms if not np.isnan(table.find(term.kind).dps(term.parameters))],
    )
    still = replace(recording, measured={})
    gyro = white = simulate.white_noise(terms, still, rng)
    others = [
        term
        for term in terms
        if term.kind != "angle_random_walk" and table.find(term.kind).role != "filter"
    ]
    for term in filter(simulate.in_front, others):
        gyro = gyro + simulate.contribution(term, still, rng, white)
    gyro = simulate.behind_filters(terms, gyro, still, rng)
    for term in [term for term in others if not simulate.in_front(term)]:
        gyro = gyro + simulate.contribution(term, still, rng, white)
    gyro = gyro + np.mean(recording.rate_dps(fitted.column))
    known = state.bench.counts
    if known and known.of == "rate":
        gyro = np.round(gyro / known.q) * known.q
    factor, _ = rate_unit(fitted.column)
    return replace(still, columns={**recording.columns, fitted.column: gyro / (factor or 1.0)})
