"""What is opened: a log is looked at, its columns named, its plausibility checked; then
it is a recording."""

from collections.abc import Sequence
from pathlib import Path

from ... import axes
from ... import model as models
from ...data import plausible
from ...data.recording import Recording
from ...errors import BadInput
from ...report.values import Json
from ...tables import dialect
from .. import dataset as datasets
from ..schema import Confirmed, FilePath, Names, Place, Positive, Stretch, Text
from ..steps import Selection, Steps
from .hold_out import HoldOut
from .own import Own
from .standing import Standing, Waiting, as_named, named
from .stepping import Stepping


class Intake:
    """Opens recordings for a session."""

    def __init__(self, session: Standing, own: Own, hold: HoldOut, stepping: Stepping) -> None:
        self.session, self.own, self.hold, self.stepping = session, own, hold, stepping

    def open(
        self,
        path: FilePath,
        model: FilePath | None = None,
        sensor: Text | None = None,
        names: Names | None = None,
        skip: Place = 0,
    ) -> Json:
        """A recording by its path. Which sensor is meant, and columns that are not called as
        davarlab calls them, are asked about first."""
        with self.own.loaded(path):
            return self.opened(path, model, sensor, names, skip)

    def opened(
        self, path: str, model: str | None, sensor: str | None, names: list[str] | None, skip: int
    ) -> Json:
        steps = Steps.beside(path, sensor)
        if steps.log is None and not sensor:
            gyros = datasets.gyros_in(path)
            if gyros:
                return self.ask_about(
                    Waiting(
                        Path(path),
                        {
                            "path": str(path),
                            "sensors": [{"name": one.name, "said": one.said} for one in gyros],
                        },
                        model=model,
                    )
                )
        recording = None
        if steps.log is None and not model:
            log = datasets.looked_at(path, sensor, names, skip)
            guesses, shown = datasets.preview(path, log, skip=skip)
            if (
                any(one.column != one.name or one.factor != 1 for one in guesses)
                or {"time"} == {one.quantity for one in guesses} & {"time", "gyro", "accel"}
                or all(one.quantity != "time" for one in guesses)
                or skip
                or shown["rows"] < shown["least"]
            ):
                return self.ask_about(
                    Waiting(Path(path), shown, guesses, sensor, names=names, skip=skip)
                )
            recording = datasets.as_it_is(path, log)
        if steps.log is None and (sensor or names or skip):
            steps.log = {
                "columns": [],
                "rate_hz": None,
                "sensor": sensor,
                "names": names,
                "skip": skip,
            }
        return self.begin(path, steps, recording or as_named(path, steps), model)

    def ask_about(self, waiting: Waiting) -> Json:
        self.session.dataset, self.session.steps, self.session.log = None, None, waiting
        self.session.datasets.clear()
        return self.session.changed()

    def waits(self) -> Waiting:
        if not self.session.log:
            raise BadInput("no log waits to be read")
        return self.session.log

    def sensor(self, name: Text) -> Json:
        """One of the sensors of the log that waits."""
        waiting = self.waits()
        return self.open(str(waiting.path), waiting.model, name)

    def names(self, names: Names) -> Json:
        """Names for the columns that the page shows of a text without names, "" for none."""
        waiting = self.waits()
        shown = [one.name for one in waiting.guesses]
        if waiting.shown.get("named", True) or len(names) != len(shown):
            raise BadInput(f"{waiting.path}: {len(names)} names for {len(shown)} columns")
        whole = [dialect.SKIP] * waiting.shown["count"]
        for called, name in zip(shown, names):  # column_2 stands in the second place
            whole[int(called.partition("_")[2]) - 1] = name.strip() or called
        return self.open(str(waiting.path), waiting.model, waiting.sensor, whole, waiting.skip)

    def skip(self, lines: Place) -> Json:
        """The text that waits, without its first lines."""
        waiting = self.waits()
        return self.open(str(waiting.path), waiting.model, waiting.sensor, skip=lines)

    def begin(
        self, path: str | Path, steps: Steps, recording: Recording, model: str | None = None
    ) -> Json:
        """Opens a recording and goes on where the last session with it ended; `model`: a
        model file to look at."""
        columns = axes.of_page(recording)
        if not columns:
            raise BadInput(
                f"{path}: no column is a gyro in deg/s or rad/s, or an accelerometer in g or m/s^2"
            )
        doubts = plausible.of_recording(recording)
        if doubts:
            return self.ask_about(self.doubted(path, steps, doubts, model))
        given = models.read(model) if model else None
        if given and model:
            there, asked = axes.for_analysis(recording, given)
            models.check_fits(asked, there, model)
            models.check_noise(given, model)
        selection = (
            Selection(given.column)
            if given
            else steps.selection or Selection((recording.gyros or columns)[-1])
        )
        held, self.session.not_held = None, ""
        if steps.held_out:
            try:
                held = self.hold.beside(steps.held_out, steps, selection.column)
            except BadInput as why:
                steps.held_out, self.session.not_held = None, f"not held out any more: {why}"
        self.look_at(recording, steps, selection, given)
        self.session.held = held
        return self.session.changed()

    @staticmethod
    def doubted(
        path: str | Path, steps: Steps, doubts: Sequence[str], model: str | None
    ) -> Waiting:
        """A recording whose rate, units or levels are implausible waits until somebody corrects or
        confirms them."""
        sensor, names = (steps.log["sensor"], steps.log.get("names")) if steps.log else (None, None)
        skip = steps.log.get("skip", 0) if steps.log else 0
        log = datasets.looked_at(path, sensor, names, skip)
        guesses, shown = datasets.preview(path, log, named(steps.log), skip)
        return Waiting(Path(path), shown | {"doubts": doubts}, guesses, sensor, model, names, skip)

    def look_at(
        self,
        recording: Recording,
        steps: Steps,
        selection: Selection,
        given: models.Model | None = None,
    ) -> None:
        """A selection of the recording, with a first step where there is none. It
        is open when all of it is there."""
        dataset, before = self.session.dataset_at(recording, selection), steps.selection
        steps.selection = selection
        try:
            if given or not steps.steps:
                outcome = (
                    dataset.outcome_of(dataset.text(given), False, self.session.progress)
                    if given
                    else dataset.first(self.session.progress)
                )
                took = (
                    "the model as given"
                    if given
                    else "a first model: white noise and bias instability"
                )
                self.stepping.grown(steps, dataset, took, outcome, fitted=given is None, root=True)
            else:
                steps.save()
        except BaseException:
            steps.selection = before
            raise
        self.session.dataset, self.session.steps, self.session.log = dataset, steps, None

    def selection(
        self,
        column: Text | None = None,
        alone: tuple[()] | Stretch = (),
        cut: tuple[Stretch, ...] = (),
    ) -> Json:
        """Another selection of the same recording: a gyro column, a stretch alone, all but what was
        cut out; each has steps of its own."""
        self.stepping.here()
        span, column = (
            self.session.open_dataset.whole.samples / self.session.open_dataset.whole.rate_hz,
            column or self.session.open_dataset.selection.column,
        )
        if column not in self.session.open_dataset.axes:
            raise BadInput(f"{column}: not a gyro or accelerometer of this recording")
        edges: list[Stretch] = [
            (pair[0], pair[1]) for pair in ([alone] if alone else []) + list(cut)
        ]
        for pair in edges:
            if not 0 <= pair[0] < pair[1] <= span * 1.001:
                raise BadInput(
                    f"{pair[0]:g} to {pair[1]:g} s is not a part of this recording: the start must "
                    f"be before the end, and both from 0 to {span:g} s"
                )
        self.look_at(
            self.session.open_dataset.whole,
            self.session.open_steps,
            Selection(column, edges[0] if alone else (), () if alone else tuple(sorted(edges))),
        )
        return self.session.changed()

    def read(
        self, columns: list[Confirmed], rate_hz: Positive | None = None, as_recorded: bool = False
    ) -> Json:
        """The log as its columns were named by whoever looked at them; as_recorded: what was
        doubted is right."""
        waiting = self.waits()
        path, guesses = waiting.path, waiting.guesses
        if [one.name for one in columns] != [one.name for one in guesses]:
            raise BadInput(
                f"{path}: each of its {len(guesses)} columns must be named, in their order"
            )
        for one, was in zip(columns, guesses):
            one.doubt = was.doubt if one.unit == was.unit and not one.sure else ""
        steps = Steps.beside(path, waiting.sensor)
        steps.log = {
            "columns": [one.model_dump(exclude={"sure"}) for one in columns],
            "rate_hz": rate_hz,
            "sensor": waiting.sensor,
            "as_recorded": as_recorded,
            "names": waiting.names,
            "skip": waiting.skip,
        }
        return self.begin(path, steps, as_named(path, steps), waiting.model)

    def tutorial(self, exercise: Text | None = None) -> Json:
        """The bundled sensor, opened like any recording."""
        return self.open(str(self.session.arrivals.simulated(exercise, self.session.progress)))

    def freeze(self, channel: Place) -> Json:
        """The raw samples of a channel that have come so far, opened as a recording; more may come
        meanwhile."""
        return self.open(str(self.session.listener.freeze(channel)))
