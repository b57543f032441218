"""A visit to the workbench: what lies on the desk, and the table of everything that a page may ask
or do."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

from ... import axes
from ...data.recording import Recording
from ...report.values import Json
from .. import plans, typed
from ..arrivals import Arrivals
from ..desk import Desk
from ..ears import Ears, Tell
from ..steps import Sight, Steps
from . import welcome
from .closer import Closer
from .hold_out import HoldOut
from .intake import Intake, Waiting
from .looks import Looks
from .own import Own
from .stepping import Stale, Stepping
from .survey import Survey

# Questions need the bench of a fit, looks only what is there, plans nothing of it; actions change
# something; code is an action that runs what somebody wrote.
QUESTION, LOOK, PLAN, ACTION, CODE = "question", "look", "plan", "action", "code"
CALLS = {
    "step": (QUESTION, "stepping.step"),
    "candidates": (QUESTION, "stepping.candidates"),
    "axis": (QUESTION, "survey.axis"),
    "sensors": (QUESTION, "survey.sensors"),
    "sensor_axes": (QUESTION, "survey.sensor_axes"),
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
    "skip": (ACTION, "intake.skip"),
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
    "own": (LOOK, "own.start"),
    "check_own": (CODE, "own.check"),
    "add_own": (CODE, "own.add"),
}


Wish = tuple[str, dict[str, Any]]  # what somebody waits for: a call and what it is given


def nobody(but: Wish | None = None) -> bool:
    return False


@dataclass(frozen=True)
class Call:
    """kind: QUESTION, LOOK, PLAN, ACTION or CODE; run: a function of plain values that returns
    plain values."""

    kind: str
    run: Callable[..., Any]


class Visit:
    """calls: name -> Call, of CALLS. What lies on the desk is kept here; the parts of the visit
    work on it. code: may a page run effects that somebody writes in it."""

    def __init__(self, folder: str | Path, code: bool = False) -> None:
        self.code, self.port = code, 0
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
        # Does somebody wait for something else than `but`.
        self.hurried: Callable[[Wish | None], bool] = nobody
        self.intake, self.hold, self.stepping = Intake(self), HoldOut(self), Stepping(self)
        self.looks, self.closer, self.plans = Looks(self), Closer(self), plans
        self.own, self.survey = Own(self), Survey(self)
        self.calls = {
            name: Call(kind, attrgetter(path)(self)) for name, (kind, path) in CALLS.items()
        }

    @property
    def open_desk(self) -> Desk:
        """The desk with its recording. Raises Stale while there is none."""
        if not self.desk:
            raise Stale("no recording is open")
        return self.desk

    @property
    def open_steps(self) -> Steps:
        """The steps of the recording on the desk. Raises Stale while there is none."""
        if not self.steps:
            raise Stale("no recording is open")
        return self.steps

    def spoken(self, found: Json) -> Json:
        """What a page shows, in the language of a gyro or an accelerometer."""
        said: Json = axes.spoken(found, self.open_desk.sight.column)
        return said

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
                "again": typed.again(None, self.port),
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
            "again": typed.again(steps, self.port),
            "path": os.path.abspath(steps.recording),
            "sensor": steps.log.get("sensor") if steps.log else None,
            "duration_s": recording.samples / recording.rate_hz,
            "column": desk.sight.column,
            "unit": axes.rate_unit(desk.sight.column),
            "columns": [name for name in recording.columns if name not in ("time_s", desk.column)],
            "gyros": desk.axes,
            "alone": desk.sight.alone,
            "cut": desk.sight.cut,
            "sights": [vars(one) | {"here": one == desk.sight} for one in steps.sights],
            "held_out": held and str(held.name),
            "not_held": self.not_held,
            "current": steps.current,
            "session": str(steps.path),
            "code": self.code,
            "own": self.own.kinds(),
            "commands": typed.commands(steps, desk.sight),
            "steps": [
                {
                    "number": s.number,
                    "parent": s.parent,
                    "did": s.did,
                    "fitted": s.fitted,
                    "error": None if s.rejected else s.error,
                    "floor": None if s.rejected else s.floor,
                }
                for s in steps.steps
            ],
        }

    def close(self) -> Json:
        """Back to the first page; the session stays beside its recording."""
        self.desk, self.steps, self.log, self.held, self.not_held = None, None, None, None, ""
        self.desks.clear()
        self.survey.beside = None
        self.own.go("")
        return self.changed()

    def listen(self, source: str) -> Json:
        """Shows and records what a sensor sends, from a source of `davarlab live`."""
        self.ears.listen(source)
        return self.changed()

    def deafen(self) -> Json:
        """Nothing is listened to any more; what came is in the file."""
        self.ears.quiet()
        return self.changed()
