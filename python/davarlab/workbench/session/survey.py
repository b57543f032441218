"""All axes of the recording, and of the other sensors of its log: of each the verdict, the missing
effect and the parameters, as its own page shows them."""

from collections.abc import Sequence

from ... import axes
from ...candidates.candidate import Candidate
from ...data import plausible
from ...data.recording import MINIMUM_SAMPLES
from ...errors import BadInput
from ...report import words
from ...report.values import Json
from .. import dataset as datasets
from .. import views
from ..dataset import Dataset
from ..schema import Text
from ..steps import Log, Selection, Steps, fit_of
from .standing import Stale, Standing, as_named
from .stepping import Stepping, Superseded


class Beside:
    """Another sensor of the log that is open. of: path and sensor; steps: of its last
    session; datasets: of its axes."""

    def __init__(self, path: str, sensor: str) -> None:
        self.of, self.steps = (path, sensor), Steps.beside(path, sensor)
        self.steps.log = self.steps.log or Log(columns=[], rate_hz=None, sensor=sensor)
        self.recording = as_named(path, self.steps)
        if self.recording.samples < MINIMUM_SAMPLES:
            raise BadInput(
                f"{self.recording.samples} samples; at least {MINIMUM_SAMPLES} are needed"
            )
        self.axes = axes.of_page(self.recording)
        self.datasets: dict[Selection, Dataset] = {}
        if doubts := plausible.of_recording(self.recording):
            raise BadInput(doubts[0])

    def dataset(self, selection: Selection) -> Dataset:
        if selection not in self.datasets:
            self.datasets[selection] = Dataset(self.recording, selection)
        return self.datasets[selection]


class Survey:
    """Computes the rows of all axes for a session. beside: the sensor that was read last beside the
    open one."""

    def __init__(self, session: Standing, stepping: Stepping) -> None:
        self.session, self.stepping = session, stepping
        self.beside: Beside | None = None

    def sensors(self) -> Json:
        """The gyros of the log, where it has several."""
        found = datasets.gyros_in(self.session.open_steps.recording)
        return {"sensors": [one.name for one in found]}

    def sensor_axes(self, sensor: Text) -> Json:
        """The axes of a sensor of the log."""
        try:
            return {"axes": self.read(sensor).axes}
        except BadInput as why:  # of this sensor; the others have their axes
            return {"axes": [], "error": self.short(why)}

    def short(self, why: BadInput) -> str:
        """A message without the name of the log, which the page shows above the table."""
        return str(why).removeprefix(f"{self.session.open_steps.recording}: ")

    def read(self, sensor: str) -> Beside:
        path = self.session.open_steps.recording
        if not self.beside or self.beside.of != (path, sensor):
            self.beside = None  # only one is in memory
            self.beside = Beside(path, sensor)
        return self.beside

    def axis(self, column: Text, sensor: Text | None = None) -> Json:
        """The row of an axis at the step where its last session ended, of the open sensor in the
        dataset on which it is opened later; given up as a ranking is. sensor: another one of the
        log."""
        beside, selection = self.read(sensor) if sensor else None, Selection(column)
        if column not in (beside or self.session.open_dataset).axes:
            raise Stale(f"{column}: not a gyro or accelerometer of the open recording")
        session = beside.steps if beside else self.session.open_steps
        try:
            dataset = (
                beside.dataset(selection)
                if beside
                else self.session.dataset_at(self.session.open_dataset.whole, selection)
            )
            return {"column": column, **self.row(dataset, session, selection)}
        except Superseded:
            return {"column": column, "superseded": True}
        except BadInput as why:  # of this axis; the others have their rows
            return {"column": column, "error": self.short(why)}

    def row(self, dataset: Dataset, session: Steps, selection: Selection) -> Json:
        sensor = (session.log and session.log["sensor"]) or ""

        def trying(text: str) -> None:
            self.stepping.give_way()
            self.session.tell(axis=selection.column, of=sensor, trying=text)

        def partly(kind: str, found: Sequence[Candidate | None]) -> None:
            trying(f"trying {words.name(kind)}")

        tree = session.tree(selection)
        step = tree["steps"][tree["current"]] if tree else None
        outcome = (
            dataset.outcome_of(step.text, step.fitted, trying) if step else dataset.first(trying)
        )
        fit = fit_of(step, tree["steps"]).text if tree and step else dataset.text(outcome.model)
        ranked = dataset.ranked(fit, trying, partly, self.stepping.give_way)
        return {
            **views.headline(outcome, step is None or step.parent is None),
            "adequate": outcome.state.judgement.adequate,
            "adequacy": outcome.state.judgement.adequacy,
            "cards": [views.card(outcome, place) for place in range(len(outcome.estimates))],
            **views.ranking(dataset.outcome_of(fit, True, trying), dataset.recording, ranked),
        }
