"""A second recording of the sensor, on which every step of a session is judged and none is
fitted."""

from ... import axes
from ...data import plausible
from ...data.recording import Recording
from ...errors import BadInput
from ...model import Model
from ...report import verdict
from ...report.values import Json
from ..schema import Place
from ..steps import Steps
from .standing import Standing, as_named
from .stepping import Stepping


class HoldOut:
    """Keeps the recording that a session holds out."""

    def __init__(self, session: Standing, stepping: Stepping) -> None:
        self.session, self.stepping = session, stepping

    def hold_out(self, path: str) -> Json:
        """A second recording of the same sensor: every step is judged on it too, and fitted on the
        first one only."""
        self.stepping.here()
        held = self.beside(
            path, self.session.open_steps, self.session.open_dataset.selection.column
        )
        self.session.open_steps.hold_out(path)
        self.session.held, self.session.not_held = held, ""
        return self.session.changed()

    def beside(self, path: str, steps: Steps, column: str) -> Recording:
        """A recording to hold out. Raises BadInput where it has not the gyro column."""
        held = as_named(path, steps)
        there, model = axes.for_analysis(held, Model(None, column))
        there.rate_dps(model.column)
        doubts = plausible.of_recording(held, [column])
        if doubts:
            raise BadInput(f"{path}: doubtful: {'; '.join(doubts)}")
        return held

    def let_go(self) -> Json:
        """No recording is held out any more."""
        self.stepping.here()
        self.session.open_steps.hold_out(None)
        self.session.held, self.session.not_held = None, ""
        return self.session.changed()

    def held_out(self, number: Place | None = None) -> Json:
        """The error of a step on the recording that is held out, and its floor; None without
        one. fails: the model does not fit it."""
        step = self.stepping.here(number)
        error, floor = self.stepping.held_out(step)
        fails = verdict.fails_held_out(error, floor)
        return {"number": step.number, "error": error, "floor": floor, "fails": fails}
