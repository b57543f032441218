"""A visit to the workbench: its parts, and the table of everything that a page may ask or do."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

from ... import axes
from ...report.values import Json
from .. import plans, typed
from . import welcome
from .closer import Closer
from .hold_out import HoldOut
from .intake import Intake
from .looks import Looks
from .own import Own
from .standing import Standing
from .stepping import Stepping
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


@dataclass(frozen=True)
class Call:
    """kind: QUESTION, LOOK, PLAN, ACTION or CODE; run: a function of plain values that returns
    plain values."""

    kind: str
    run: Callable[..., Any]


class Visit(Standing):
    """calls: name -> Call, of CALLS; their parts work on what Standing keeps."""

    def __init__(self, folder: str | Path, code: bool = False) -> None:
        super().__init__(folder, code)
        self.plans, self.looks, self.stepping = plans, Looks(self), Stepping(self)
        self.closer = Closer(self, self.stepping)
        self.hold, self.survey = HoldOut(self, self.stepping), Survey(self, self.stepping)
        self.own = Own(self, self.stepping, self.survey)
        self.intake = Intake(self, self.own, self.hold, self.stepping)
        self.calls = {
            name: Call(kind, attrgetter(path)(self)) for name, (kind, path) in CALLS.items()
        }

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
