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
from .. import desk as desks
from .. import views
from ..desk import Desk
from ..steps import Log, Sight, Steps, fit_of
from .standing import Stale, Standing, as_named
from .stepping import Stepping, Superseded


class Beside:
    """Another sensor of the log that is open. of: path and sensor; session: the steps of its last
    visit; desks: of its axes."""

    def __init__(self, path: str, sensor: str) -> None:
        self.of, self.session = (path, sensor), Steps.beside(path, sensor)
        self.session.log = self.session.log or Log(columns=[], rate_hz=None, sensor=sensor)
        self.recording = as_named(path, self.session)
        if self.recording.samples < MINIMUM_SAMPLES:
            raise BadInput(
                f"{self.recording.samples} samples; at least {MINIMUM_SAMPLES} are needed"
            )
        self.axes = axes.of_page(self.recording)
        self.desks: dict[Sight, Desk] = {}
        if doubts := plausible.of(self.recording):
            raise BadInput(doubts[0])

    def desk(self, sight: Sight) -> Desk:
        if sight not in self.desks:
            self.desks[sight] = Desk(self.recording, sight)
        return self.desks[sight]


class Survey:
    """Computes the rows of all axes for a visit. beside: the sensor that was read last beside the
    open one."""

    def __init__(self, visit: Standing, stepping: Stepping) -> None:
        self.visit, self.stepping = visit, stepping
        self.beside: Beside | None = None

    def sensors(self) -> Json:
        """The gyros of the log, where it has several."""
        found = desks.gyros_in(self.visit.open_steps.recording)
        return {"sensors": [one.name for one in found]}

    def sensor_axes(self, sensor: str) -> Json:
        """The axes of a sensor of the log."""
        try:
            return {"axes": self.read(sensor).axes}
        except BadInput as why:  # of this sensor; the others have their axes
            return {"axes": [], "error": self.short(why)}

    def short(self, why: BadInput) -> str:
        """A message without the name of the log, which the page shows above the table."""
        return str(why).removeprefix(f"{self.visit.open_steps.recording}: ")

    def read(self, sensor: str) -> Beside:
        path = self.visit.open_steps.recording
        if not self.beside or self.beside.of != (path, sensor):
            self.beside = None  # only one is in memory
            self.beside = Beside(path, sensor)
        return self.beside

    def axis(self, column: str, sensor: str | None = None) -> Json:
        """The row of an axis at the step where its last visit ended, of the open sensor on the desk
        on which it is opened later; given up as a ranking is. sensor: another one of the log."""
        beside, sight = self.read(sensor) if sensor else None, Sight(column)
        if column not in (beside or self.visit.open_desk).axes:
            raise Stale(f"{column}: not a gyro or accelerometer of the open recording")
        session = beside.session if beside else self.visit.open_steps
        try:
            desk = (
                beside.desk(sight)
                if beside
                else self.visit.desk_at(self.visit.open_desk.whole, sight)
            )
            row: Json = axes.spoken(self.row(desk, session, sight), column)
            return {"column": column, **row}
        except Superseded:
            return {"column": column, "superseded": True}
        except BadInput as why:  # of this axis; the others have their rows
            return {"column": column, "error": axes.in_units(self.short(why), column)}

    def row(self, desk: Desk, session: Steps, sight: Sight) -> Json:
        sensor = (session.log and session.log["sensor"]) or ""

        def trying(text: str) -> None:
            self.stepping.give_way()
            self.visit.tell(axis=sight.column, of=sensor, trying=text)

        def partly(kind: str, found: Sequence[Candidate | None]) -> None:
            trying(f"trying {words.name(kind)}")

        tree = session.tree(sight)
        step = tree["steps"][tree["current"]] if tree else None
        outcome = desk.of(step.text, step.fitted, trying) if step else desk.first(trying)
        fit = fit_of(step, tree["steps"]).text if tree and step else desk.text(outcome.model)
        ranked = desk.ranked(fit, trying, partly, self.stepping.give_way)
        return {
            **views.headline(outcome, step is None or step.parent is None),
            "adequate": outcome.state.judgement.adequate,
            "adequacy": outcome.state.judgement.adequacy,
            "cards": [views.card(outcome, place, None) for place in range(len(outcome.estimates))],
            **views.ranking(desk.of(fit, True, trying), desk.recording, ranked),
        }
