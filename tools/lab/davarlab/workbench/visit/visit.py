"""A visit to the workbench: what lies on the desk, and the table of everything that a page may ask
or do."""

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

from ...data.recording import Recording
from ...errors import BadInput
from ...report.values import Json
from .. import plans, typed
from ..arrivals import Arrivals
from ..desk import Desk
from ..ears import Ears
from ..listening import Tell
from ..steps import Sight, Steps
from . import welcome
from .closer import Closer
from .hold_out import HoldOut
from .intake import Intake, Waiting
from .looks import Looks
from .stepping import Stepping
from .survey import Survey

# Questions need the bench of a fit, looks only what is there, plans nothing of it; actions change
# something.
QUESTION, LOOK, PLAN, ACTION = "question", "look", "plan", "action"
CALLS = {
    "step": (QUESTION, "stepping.step"),
    "candidates": (QUESTION, "stepping.candidates"),
    "axis": (QUESTION, "survey.axis"),
    "ghost": (QUESTION, "stepping.ghost"),
    "preview": (QUESTION, "stepping.preview"),
    "held_out": (QUESTION, "hold.held_out"),
    "against": (QUESTION, "closer.against"),
    "report": (QUESTION, "closer.report"),
    "all": (LOOK, "everything"),
    "live": (LOOK, "ears.so_far"),
    "save": (LOOK, "closer.save"),
    "stretch": (LOOK, "looks.stretch"),
    "spectrogram": (LOOK, "looks.spectrogram"),
    "axes": (LOOK, "looks.axes"),
    "sheet": (LOOK, "looks.sheet"),
    "planner": (PLAN, "plans.planner"),
    "plan": (PLAN, "plans.plan"),
    "setup": (PLAN, "plans.setup"),
    "open": (ACTION, "intake.open"),
    "tutorial": (ACTION, "intake.tutorial"),
    "sensor": (ACTION, "intake.sensor"),
    "names": (ACTION, "intake.names"),
    "read": (ACTION, "intake.read"),
    "sight": (ACTION, "intake.sight"),
    "freeze": (ACTION, "intake.freeze"),
    "add": (ACTION, "stepping.add"),
    "line": (ACTION, "stepping.line"),
    "set": (ACTION, "stepping.set"),
    "refit": (ACTION, "stepping.refit"),
    "remove": (ACTION, "stepping.remove"),
    "restore": (ACTION, "stepping.restore"),
    "go": (ACTION, "stepping.go"),
    "let_go": (ACTION, "hold.let_go"),
    "listen": (ACTION, "listen"),
    "deafen": (ACTION, "deafen"),
    "kalibr": (ACTION, "closer.kalibr"),
    "close": (ACTION, "close"),
}


@dataclass(frozen=True)
class Call:
    """kind: QUESTION, LOOK, PLAN or ACTION; run: a function of plain values that returns plain
    values."""

    kind: str
    run: Callable[..., Any]


class Visit:
    """calls: name -> Call, of CALLS. What lies on the desk is kept here; the parts of the visit
    work on it."""

    def __init__(self, folder: str | Path) -> None:
        self.arrivals = Arrivals(folder)
        self.desk: Desk | None = None
        self.desks: dict[Sight, Desk] = {}  # of the complete axes of the recording
        self.steps: Steps | None = None
        self.held: Recording | None = None  # the recording that is held out
        self.not_held = ""  # why what was held out in an earlier visit is not now
        self.revision = 0  # counts the changes
        self.log: Waiting | None = None  # one that waits to be read
        self.tell: Tell = lambda **event: None
        self.ears = Ears(self.arrivals, lambda **event: self.tell(**event))
        self.hurried: Callable[[], bool] = lambda: (
            False
        )  # is somebody waiting for what is being computed
        self.intake, self.hold, self.stepping = Intake(self), HoldOut(self), Stepping(self)
        self.looks, self.closer, self.plans = Looks(self), Closer(self), plans
        self.survey = Survey(self)
        self.calls = {
            name: Call(kind, attrgetter(path)(self)) for name, (kind, path) in CALLS.items()
        }

    @property
    def open_desk(self) -> Desk:
        """The desk with its recording. Raises BadInput while there is none."""
        if not self.desk:
            raise BadInput("no recording is open")
        return self.desk

    @property
    def open_steps(self) -> Steps:
        """The steps of the recording on the desk. Raises BadInput while there is none."""
        if not self.steps:
            raise BadInput("no recording is open")
        return self.steps

    def progress(self, text: str) -> None:
        self.tell(progress=text)

    def changed(self) -> Json:
        self.revision += 1
        self.tell(changed=self.revision)
        return self.everything()

    def everything(self) -> Json:
        """Where the visit stands; `step` gives what a step looks like."""
        desk, steps, log, held, live = self.desk, self.steps, self.log, self.held, self.ears.where()
        if not desk or not steps:
            return {
                "again": "tools/davarlab open",
                "revision": self.revision,
                "recording": None,
                "live": live,
                "log": log and log.shown,
                "folder": str(self.arrivals.folder),
                "recent": welcome.recent([self.arrivals.folder, self.arrivals.folder.parent]),
                "sources": welcome.sources(),
            }
        recording = desk.recording
        return {
            "revision": self.revision,
            "recording": str(recording.name),
            "live": live,
            "samples": recording.measured_samples,
            "missing": recording.samples - recording.measured_samples,
            "rate_hz": recording.rate_hz,
            "gaps": len(recording.gaps),
            "state": self.stepping.state(),
            "again": typed.again(steps),
            "duration_s": recording.samples / recording.rate_hz,
            "column": desk.column,
            "columns": [name for name in recording.columns if name not in ("time_s", desk.column)],
            "gyros": desk.gyros,
            "alone": desk.sight.alone,
            "cut": desk.sight.cut,
            "sights": [vars(one) | {"here": one == desk.sight} for one in steps.sights],
            "held_out": held and str(held.name),
            "not_held": self.not_held,
            "current": steps.current,
            "session": str(steps.path),
            "commands": typed.commands(steps, desk.sight),
            "steps": [
                {
                    "number": s.number,
                    "parent": s.parent,
                    "did": s.did,
                    "fitted": s.fitted,
                    "error": s.error,
                    "floor": s.floor,
                }
                for s in steps.steps
            ],
        }

    def close(self) -> Json:
        """Back to the first page; the session stays beside its recording."""
        self.desk, self.steps, self.log, self.held, self.not_held = None, None, None, None, ""
        self.desks.clear()
        return self.changed()

    def listen(self, source: str) -> Json:
        """Shows and records what a sensor sends: can:IFACE or slcan:PATH."""
        self.ears.listen(source)
        return self.changed()

    def deafen(self) -> Json:
        """Nothing is listened to any more; what came is in the file."""
        self.ears.quiet()
        return self.changed()
