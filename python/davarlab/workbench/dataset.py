"""One open recording: models fitted on it and candidates beside them, by the same functions
as the command line."""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .. import axes
from .. import model as models
from ..arrays import Bools, Floats, Ints
from ..candidates import lines
from ..candidates.candidate import Candidate
from ..candidates.ranking import Trying
from ..data import clock, plausible
from ..data import recording as recordings
from ..diagnosis import compare, fitting, improve, search
from ..diagnosis.improve import Estimates
from ..diagnosis.state import Judged, Progress, State
from ..effects import columns as columns_of
from ..errors import BadInput
from ..inference.parts import Part
from ..logs import formats
from ..logs import text as texts
from ..logs.named import with_known
from ..logs.options import Options
from ..logs.sensor import Samples, Sensor
from ..report.values import Json
from ..tables import guess, meaning
from ..tables import table as tables
from .steps import Selection

KEPT = 12  # outcomes in memory, of all axes together
SET = "as set"  # of an outcome whose values stand as somebody set them
HELD = ("spectrum", "mean", "filter")  # what can be held while the rest is fitted
ROWS = 5  # of a log, to look at
PICTURE = 500  # points of a column of it

Errors = tuple[float, float] | tuple[None, None]  # an error and its floor, where there is one


@dataclass
class Outcome:
    """A model on the recording. state: judged; fitted: at its best, from which further steps go;
    estimates: of its parameters; ranked: the candidates beside it, once they were asked for."""

    model: models.Model
    state: Judged
    fitted: Judged
    estimates: list[Estimates]
    ranked: list[Candidate] | None = None


def gyros_in(path: str | Path) -> list[Sensor]:
    """The gyros of a log that leaves open which one is meant; none where there is nothing to
    choose."""
    if formats.format_of(path)[1] is texts.log:
        return []
    found = [one for one in formats.listed(path) if "gyro" in one.gives]
    first = [one for one in found if one.rank == min(gyro.rank for gyro in found)]
    return found if len(first) > 1 else []


def preview(
    path: str | Path,
    log: tables.Table | Samples,
    said: list[guess.Guess] | None = None,
    skip: int = 0,
) -> tuple[list[guess.Guess], Json]:
    """What looked_at() found, before it is a recording: (guesses for its columns, or what was said
    of them, what a page shows of it). skip: lines of a text that were skipped."""
    columns = log.columns
    text = log if isinstance(log, tables.Table) else None
    rates, known = (text.rates, texts.known_of(text)) if text else ([], {})
    found = said or meaning.guesses(columns, rates, lambda ones: with_known(ones, known))
    count = len(next(iter(columns.values())))
    ticks = clock_of(columns, found, path, log.line)
    places = ticks.places if ticks else log.places
    missing = 0 if places is None else int(places[-1]) + 1 - count
    return found, {
        "path": str(path),
        "columns": [
            vars(one) | {"would": guess.units_of(one.name, columns[one.name])} for one in found
        ],
        "named": isinstance(log, Samples) or log.named,
        "count": len(columns) if isinstance(log, Samples) else log.count,
        "said": ", ".join(log.said),
        "rows": recordings.counted(count, missing),
        "least": recordings.MINIMUM_SAMPLES,
        "skip": None if isinstance(log, Samples) else skip,
        "doubts": doubts_of(columns, found, ticks),
        "rate_hz": ticks.rate_hz if ticks else None,
        "missing": missing,
        "head": [
            [float(column[row]) for column in columns.values()] for row in range(min(ROWS, count))
        ],
        "units": guess.UNITS,
        "plot": [picture(column) for column in columns.values()],
    }


def doubts_of(
    columns: Mapping[str, Floats], found: Sequence[guess.Guess], ticks: clock.Clock | None
) -> list[str]:
    """What is implausible about a log, with the units that are guessed."""
    if not ticks:
        return []
    named = {one.column: columns[one.name] * one.factor for one in found if one.quantity != "other"}
    gyros = [one.column for one in found if one.quantity == "gyro"]
    doubted = dict.fromkeys(one.doubt for one in found if one.doubt)
    return [*doubted, *plausible.doubts(named, ticks.rate_hz, None, gyros)]


def picture(column: Floats) -> Json:
    """A column as it is logged, thinned so that no extreme is lost, and the standard deviation of
    its white noise, from differences of neighbours."""
    edges = np.linspace(0, len(column), min(PICTURE, len(column)), endpoint=False).astype(int)
    steps = np.diff(column)
    return {
        "low": np.minimum.reduceat(column, edges).tolist(),
        "high": np.maximum.reduceat(column, edges).tolist(),
        "noise": float(np.sqrt(np.mean(steps**2) / 2)) if len(steps) else 0.0,
    }


def looked_at(
    path: str | Path, sensor: str | None, names: Sequence[str] | None, skip: int
) -> tables.Table | Samples:
    """A text as it is, any other log in davarlab's names. names: for the columns of a text, over
    its own; skip: lines of it."""
    if formats.format_of(path)[1] is texts.log:
        return tables.read(path, names, skip=skip)
    return formats.samples(path, Options(sensor=sensor))


def clock_of(
    columns: Mapping[str, Floats], found: Sequence[guess.Guess], path: str | Path, line: int | None
) -> clock.Clock | None:
    """The clock that is guessed; None where no column is the time, or none that runs."""
    time = next((one for one in found if one.quantity == "time"), None)
    try:
        return clock.found(columns[time.name] * time.factor, None, path, line) if time else None
    except BadInput:
        return None


def pairs(guesses: Sequence[guess.Guess]) -> tuple[list[str], list[str]]:
    """The options of `davarlab import` that say the same: (--rename, --scale)."""
    renames = [f"{one.name}={one.column}" for one in guesses if one.column != one.name]
    return renames, [f"{one.column}={one.factor!r}" for one in guesses if one.factor != 1]


def read(
    path: str | Path,
    guesses: Sequence[guess.Guess] | None = None,
    rate_hz: float | None = None,
    sensor: str | None = None,
    as_recorded: bool = False,
    names: list[str] | None = None,
    skip: int = 0,
) -> recordings.Recording:
    """The recording; guesses: where its columns are not called as davarlab calls them; sensor: of a
    log with several; names: of the columns of a text, over its own; skip: lines of it; as_recorded:
    its rate, units and levels were confirmed."""
    renames, scales = pairs(guesses or [])
    options = Options(
        rate_hz, sensor, renames=renames, scales=scales, names=names, plain=True, skip_lines=skip
    )
    return replace(
        formats.recording_of(formats.samples(path, options), path, rate_hz),
        as_recorded=as_recorded,
        doubts={one.quantity: one.doubt for one in guesses or [] if one.doubt},
    )


def as_it_is(path: str | Path, log: tables.Table | Samples) -> recordings.Recording:
    """The recording in what looked_at() found, if its columns are called as davarlab calls them."""
    if isinstance(log, tables.Table):
        log = formats.checked(texts.Own(log, path).read(""), "", path, Options())
    return formats.recording_of(log, path, None)


def seen(recording: recordings.Recording, selection: "Selection") -> recordings.Recording:
    """What a selection shows of the recording: a stretch alone, or all with some of it taken for
    missing."""
    rate = recording.rate_hz
    if selection.alone:
        first, last = (min(int(edge * rate), recording.samples) for edge in selection.alone)
        if last - first < recordings.MINIMUM_SAMPLES:
            raise BadInput(
                f"a part with {last - first} samples; at least {recordings.MINIMUM_SAMPLES} are "
                "needed"
            )
        known = None if recording.known is None else recording.known[first:last]
        return recordings.Recording(
            {name: column[first:last] for name, column in recording.columns.items()},
            rate,
            recording.name,
            recording.notes,
            recordings.gaps_of(known),
            known=known,
            read_hz=recording.read_hz,
            as_recorded=recording.as_recorded,
        )
    if not selection.cut:
        return recording
    known = np.ones(recording.samples, bool) if recording.known is None else recording.known.copy()
    for start, stop in selection.cut:
        known[int(start * rate) : int(stop * rate)] = False
    if np.count_nonzero(known) < recordings.MINIMUM_SAMPLES:
        raise BadInput(
            f"{np.count_nonzero(known)} samples would remain; at least "
            f"{recordings.MINIMUM_SAMPLES} are needed"
        )
    return replace(recording, known=known, gaps=recordings.gaps_of(known), measured={})


class Dataset:
    """whole: the recording as it was read; recording: what is looked at of it, and column: the gyro
    or accelerometer there, as the analysis takes them (axes.py). The models in outcomes are of that
    column, those in texts of the column as it is called. outcomes: what was computed last, which
    the datasets of several axes share."""

    def __init__(
        self,
        whole: recordings.Recording,
        selection: "Selection",
        outcomes: OrderedDict[Hashable, Outcome] | None = None,
    ) -> None:
        self.whole, self.selection = whole, selection
        self.axes = axes.of_page(whole)
        model = models.Model(None, selection.column)
        self.recording, model = axes.for_analysis(seen(whole, selection), model)
        self.column = model.column
        self.recording.rate_dps(self.column)
        self.outcomes = OrderedDict() if outcomes is None else outcomes
        # (model file, name of a recording) -> its error there, and the floor
        self.judged_elsewhere: dict[tuple[str, str | None], Errors] = {}

    def forget(self, fits: bool) -> None:
        """Forgets the rankings, which were of another table of effects; the fits too where one of
        them may have an effect that has changed."""
        for outcome in self.outcomes.values():
            outcome.ranked = None
        if fits:
            self.outcomes.clear()

    def first(self, progress: Progress) -> Outcome:
        """The outcome of the first model."""
        model = models.first(self.recording.rate_hz, self.column)
        return self.keep(self.outcome_of(self.text(model), True, progress))

    def inside(self, model: models.Model) -> models.Model:
        """A model for the analysis."""
        return replace(model, column=self.column)

    def text(self, model: models.Model) -> str:
        """The model file, of the column as it is called."""
        return models.text_of(self.called(model))

    def called(self, model: models.Model) -> models.Model:
        return replace(model, column=self.selection.column)

    def remembered(self, key: Hashable, make: Callable[[], Outcome]) -> Outcome:
        """The outcome of a key, computed where it is not in memory. A key has the axis in a model
        file."""
        if key not in self.outcomes:
            self.outcomes[key] = make()
            while len(self.outcomes) > KEPT:
                self.outcomes.popitem(last=False)
        self.outcomes.move_to_end(key)
        return self.outcomes[key]

    def outcome_of(
        self, text: str, fitted: bool, progress: Progress = lambda text: None
    ) -> Outcome:
        """The outcome of a model file: at its best, as `davarlab fit` finds it, or with the values
        as they stand."""
        model = self.inside(models.of_text(text, "model"))
        if not model.terms:
            raise BadInput("a model needs an effect")
        if not fitted and (text, SET) in self.outcomes:
            return self.outcomes[text, SET]
        best = self.remembered(text, lambda: self.fit(model, progress))
        return best if fitted else self.as_set(best, model)

    def fit(self, model: models.Model, progress: Progress) -> Outcome:
        state, fitted, entries = improve.fit(self.recording, model, progress)
        return Outcome(fitted, state, state, entries)

    def keep(self, outcome: Outcome) -> Outcome:
        """Remembers an outcome that was reached by another way than a fit from its file."""
        return self.remembered(self.text(outcome.model), lambda: outcome)

    def same_effects(self, best: Outcome, model: models.Model) -> None:
        if [part.kind for part in best.fitted.parts] != model.kinds:
            raise BadInput("these values cannot be compared: the effects of the fit are others")
        models.check_noise(model, "these values")

    def given(self, best: Outcome, model: models.Model) -> Judged:
        """The fit's state with the values of a model of the same effects."""
        self.same_effects(best, model)
        return compare.as_given(best.fitted, self.inside(model))

    def as_set(self, best: Outcome, model: models.Model) -> Outcome:
        """The values as they stand, judged as `davarlab compare` judges them."""
        self.same_effects(best, model)
        model = self.inside(model)
        return self.remembered(
            (self.text(model), SET),
            lambda: Outcome(
                model, compare.given(best.fitted, model), best.fitted, improve.as_it_is(model)
            ),
        )

    def around(self, best: Outcome, model: models.Model, held: Sequence[int]) -> Outcome:
        """The effects at the places `held` as they stand, the others at their best beside them;
        judged as it then stands."""
        self.same_effects(best, model)
        model = self.inside(model)
        roles = [part.role if part.form != "decoded" else "states" for part in best.fitted.parts]
        for place in held:
            if roles[place] not in HELD:
                raise BadInput(
                    f"{model.kinds[place]} cannot be kept fixed, because the other effects "
                    "determine it"
                )
        if all(place in held for place, role in enumerate(roles) if role == "spectrum"):
            raise BadInput("at least one noise must be fitted")
        whole, entries = improve.fit_around(best.fitted, model, held)
        outcome = Outcome(whole, compare.given(best.fitted, whole), best.fitted, entries)
        return self.remembered((self.text(whole), SET), lambda: outcome)

    def ranked(
        self,
        text: str,
        progress: Progress,
        partly: Trying = lambda kind, found: None,
        between: Callable[[], None] = lambda: None,
    ) -> list[Candidate]:
        """Candidates beside the fitted model, best first, as `davarlab diagnose` ranks and doubts
        them; `partly` is called with what was found so far, `between` before each fit; both may
        raise."""
        outcome = self.outcome_of(text, True, progress)
        if outcome.ranked is None:
            fitted = outcome.fitted
            asking = replace(fitted, bench=fitted.bench.asking(between))
            found = search.ranking(asking, progress=partly)
            fitting.tidied(fitted)
            for one in found:
                if search.significant([one]):
                    one.doubt = search.doubt(asking, one)
            fitting.tidied(fitted)
            outcome.ranked = found
        return outcome.ranked

    def line_at(self, text: str, f_hz: float, wide: bool) -> Candidate:
        """A candidate of one's own: a line at a frequency, sharp or with a width."""
        if not 0 < f_hz < self.recording.rate_hz / 2:
            raise BadInput(
                f"{f_hz:g} Hz: a line must be above 0 and below half the sample rate, "
                f"{self.recording.rate_hz / 2:g} Hz"
            )
        state = self.outcome_of(text, True).fitted
        part = (
            lines.wide_at(state.bench, state.parts, state.fit, f_hz)
            if wide
            else Part("sinusoid", {"frequency_hz": f_hz})
        )
        return Candidate(part.kind, part, 0.0, 0.0)

    def with_candidates(
        self,
        text: str,
        candidates: Sequence[Candidate],
        progress: Progress,
        between: Callable[[], None],
    ) -> Outcome:
        """The model with candidates that join one after the other, all refitted; `between` is
        called before each fit, and may raise."""
        fitted = self.outcome_of(text, True, progress).fitted
        state: State = replace(fitted, bench=fitted.bench.asking(between))
        for candidate in candidates:
            state = fitting.joined(state, candidate.part, candidate.replaces)
        between()
        state = fitting.judged(replace(state, bench=state.bench.asking(lambda: None)))
        model, entries = improve.fitted_model(
            state, models.Model(self.recording.rate_hz, self.column)
        )
        return Outcome(model, state, state, entries)

    def held_out(self, text: str, model: models.Model, held: recordings.Recording | None) -> Errors:
        """(error, floor) of a model on another recording of the sensor, as `--held-out` says them;
        (None, None) without one."""
        if held:
            held, model = axes.for_analysis(held, self.called(model))
            models.check_fits(model, held, "the model")
        key = text, held.name if held else None
        if key not in self.judged_elsewhere:
            self.judged_elsewhere[key] = improve.held_out_errors(held, model)
        return self.judged_elsewhere[key]

    def report(
        self,
        outcome: Outcome,
        first: Outcome,
        ranked: Sequence[Candidate],
        path: str,
        typed: tuple[str, str, list[str]],
        way: Sequence[Json],
        progress: Progress,
    ) -> bytes:
        """The page that `davarlab compare --report` writes of a model. first: the model of the
        first step; ranked: the candidates beside the model; typed: what a terminal calls recording
        and model, and further options; way: the steps to it."""
        from ..report import contents, page

        found = compare.compare(self.recording, outcome.model, progress, outcome.fitted)
        recording, model, options = typed
        grown = set(first.model.kinds) < set(outcome.model.kinds)
        before = (
            compare.compare(self.recording, first.model, progress, first.fitted) if grown else None
        )
        run = contents.Run(
            ["open", Path(path).name],
            self.recording,
            first.model if grown else outcome.model,
            {"recording": path},
            options,
            called=(recording, model),
        )
        found_contents = contents.of_comparison(run, found, outcome.fitted, way, before, ranked)
        for file in found_contents["run"]["files"]:
            file["path"] = file["name"]  # the reader has another machine
        return page.html(found_contents, self.selection.column).encode()

    def residual(self, text: str) -> Floats:
        """What the courses of a fitted model leave of the gyro, without its mean."""
        state = self.outcome_of(text, True).fitted
        y = state.bench.y
        left: Floats = y - y.mean() - state.bench.mean_course(state.parts, state.fit)
        return left

    def against(
        self, text: str, column: str, lag_s: float, points: int
    ) -> tuple[Floats, Floats, Bools]:
        """The residual beside a column that is felt so late, in means of equal stretches: (column,
        residual, does the column rise)."""
        left = self.residual(text)
        x = columns_of.lagged(self.recording.column(column), self.recording.rate_hz, lag_s)
        x, left = (means(one, points) for one in (x, left))
        return x, left, np.gradient(x) > 0

    def moving(self, text: str, points: int) -> tuple[Floats, Floats, dict[str, Floats]]:
        """In equal stretches: (the mean of the residual, its noise, of differences of neighbours,
        the mean of each logged column)."""
        left = self.residual(text)
        steps = np.diff(left, append=left[-1])
        columns = {
            name: means(values, points)
            for name, values in self.recording.columns.items()
            if name not in ("time_s", self.column)
        }
        return means(left, points), np.sqrt(means(steps**2, points) / 2), columns


def means(values: Floats | Ints, points: int) -> Floats:
    """The means of so many equal stretches."""
    starts = np.linspace(0, len(values), min(points, len(values) // 2), endpoint=False).astype(int)
    found: Floats = np.add.reduceat(values, starts) / np.diff(np.append(starts, len(values)))
    return found
