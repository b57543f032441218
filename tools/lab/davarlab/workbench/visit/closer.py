"""Looking closer at a step, and what is taken home of it."""

from ... import kalibr
from ... import model as models
from ...diagnosis import fitting
from ...diagnosis.state import spoiler_of
from ...errors import BadInput
from ...model import is_accel
from ...report import declared, export, parameters, verdict
from ...report.values import Json
from .. import typed, views
from .standing import Standing
from .stepping import Stepping

WINDOW = 6000  # samples of the device's window, as davarlab export has it


class Closer:
    """Answers what needs a fit, and writes files, for a visit. What needs no fit is in looks.py."""

    def __init__(self, visit: Standing, stepping: Stepping) -> None:
        self.visit, self.stepping = visit, stepping

    def against(self, column: str, lag_s: float = 0.0) -> Json:
        """What the model's courses leave of the gyro, beside another column."""
        step = self.stepping.here()
        if column not in self.visit.open_desk.recording.columns:
            raise BadInput(f"no column {column}")
        if (
            not 0
            <= lag_s
            <= self.visit.open_desk.recording.samples / self.visit.open_desk.recording.rate_hz
        ):
            raise BadInput(f"a lag of {lag_s} s: from 0 to the length of the recording")
        return views.against(self.visit.open_desk, step.text, column, lag_s)

    def report(self, number: int | None = None, state: str | None = None) -> bytes:
        """The still page of a step: that of `davarlab compare --report`."""
        step = self.stepping.shown(number, state)
        if self.visit.open_desk.sight.alone or self.visit.open_desk.sight.cut:
            raise BadInput("a report is of a whole recording: look at all of it first")
        _, recording, rate = typed.in_terminal(self.visit.open_steps)
        return self.visit.open_desk.report(
            self.stepping.outcome(step),
            self.visit.open_steps.recording,
            (recording, typed.MODEL_NAME, rate),
            self.visit.open_steps.way(step),
            self.visit.progress,
        )

    def save(self, what: str, number: int | None = None, state: str | None = None) -> bytes:
        """The model to take home: toml, the table for the device (h), its filter (plan), or the
        parameters of another program."""
        step, desk = self.stepping.shown(number, state), self.visit.open_desk
        spoiler = spoiler_of(fitting.observed(desk.recording, desk.column))
        if spoiler:
            raise BadInput(f"no model is exported. {verdict.observation(spoiler)}")
        if what == "toml":
            return step.text.encode()
        model = models.of_text(step.text, "model")
        if what == "plan":
            found = declared.of(model, typed.MODEL_NAME, WINDOW)
            notes = declared.notes(found, model, typed.MODEL_NAME, None)
            return declared.text(found, notes).encode()
        if what == "h":
            return export.text(export.table_of(model, WINDOW, 0.02), "model.h").encode()
        return parameters.text(what, [(typed.MODEL_NAME, model)]).encode()

    def kalibr(self, text: str) -> Json:
        """The numbers of a kalibr file, as a data sheet's."""
        accel = self.visit.desk and is_accel(self.visit.desk.sight.column)
        kinds = kalibr.ACCEL_KINDS if accel else kalibr.KINDS
        return {"sheet": kalibr.sizes(text, "the kalibr file", kinds)}
