"""A session of the workbench: its parts, and the table of everything that a page may ask or do."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

from ...model import unit_said
from ...report.values import Json
from .. import arrivals, plans, typed
from ..schema import Text
from . import welcome
from .details import Details
from .hold_out import HoldOut
from .inspection import Inspection
from .intake import Intake
from .own import Own
from .standing import Standing
from .stepping import Stepping
from .survey import Survey

# Questions need the bench of a fit, an inspection only what is there, plans nothing of it; actions
# change something; code is an action that runs what somebody wrote.
QUESTION, INSPECTION, PLAN, ACTION, CODE = "question", "inspection", "plan", "action", "code"
CALLS = {
    "step": (QUESTION, "stepping.step"),
    "candidates": (QUESTION, "stepping.candidates"),
    "axis": (QUESTION, "survey.axis"),
    "sensors": (QUESTION, "survey.sensors"),
    "sensor_axes": (QUESTION, "survey.sensor_axes"),
    "candidate_preview": (QUESTION, "stepping.candidate_preview"),
    "without": (QUESTION, "stepping.without"),
    "preview": (QUESTION, "stepping.preview"),
    "held_out": (QUESTION, "hold.held_out"),
    "against": (QUESTION, "details.against"),
    "moves": (QUESTION, "details.moves"),
    "report": (QUESTION, "details.report"),
    "curve": (QUESTION, "details.curve"),
    "all": (INSPECTION, "everything"),
    "live": (INSPECTION, "listener.so_far"),
    "save": (INSPECTION, "details.save"),
    "archive": (INSPECTION, "details.archive"),
    "stretch": (INSPECTION, "inspection.stretch"),
    "spectrogram": (INSPECTION, "inspection.spectrogram"),
    "axes": (INSPECTION, "inspection.axes"),
    "sheet": (INSPECTION, "inspection.sheet"),
    "planner": (PLAN, "plans.planner"),
    "plan": (PLAN, "plans.plan"),
    "setup": (PLAN, "plans.setup"),
    "open": (ACTION, "intake.open"),
    "tutorial": (ACTION, "intake.tutorial"),
    "sensor": (ACTION, "intake.sensor"),
    "names": (ACTION, "intake.names"),
    "skip": (ACTION, "intake.skip"),
    "read": (ACTION, "intake.read"),
    "selection": (ACTION, "intake.selection"),
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
    "stop_listening": (ACTION, "stop_listening"),
    "kalibr": (ACTION, "details.kalibr"),
    "close": (ACTION, "close"),
    "own": (INSPECTION, "own.start"),
    "check_own": (CODE, "own.check"),
    "add_own": (CODE, "own.add"),
}


@dataclass(frozen=True)
class Call:
    """kind: QUESTION, INSPECTION, PLAN, ACTION or CODE; run: a function of plain values that
    returns plain values."""

    kind: str
    run: Callable[..., Any]


class Session(Standing):
    """calls: name -> Call, of CALLS; their parts work on what Standing keeps."""

    def __init__(
        self, folder: str | Path, code: bool = False, kept: str | Path | None = None
    ) -> None:
        super().__init__(folder, code, kept)
        self.plans, self.inspection, self.stepping = plans, Inspection(self), Stepping(self)
        self.details = Details(self, self.stepping)
        self.hold, self.survey = HoldOut(self, self.stepping), Survey(self, self.stepping)
        self.own = Own(self, self.stepping, self.survey)
        self.intake = Intake(self, self.own, self.hold, self.stepping)
        self.calls = {
            name: Call(kind, attrgetter(path)(self)) for name, (kind, path) in CALLS.items()
        }

    def everything(self) -> Json:
        """Where the session stands; `step` gives what is shown of a step."""
        dataset, steps, log, held, live = (
            self.dataset,
            self.steps,
            self.log,
            self.held,
            self.listener.where(),
        )
        if not dataset or not steps:
            return {
                "again": typed.again(None, self.port),
                "revision": self.revision,
                "recording": None,
                "live": live,
                "log": log and log.shown,
                "folder": str(self.arrivals.folder),
                "recent": welcome.recent([self.arrivals.folder, self.folder]),
                "sources": welcome.sources(),
                "exercises": arrivals.exercises(),
            }
        recording = dataset.recording
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
            "column": dataset.selection.column,
            "unit": unit_said("deg/s", dataset.selection.column),
            "columns": [
                name for name in recording.columns if name not in ("time_s", dataset.column)
            ],
            "gyros": dataset.axes,
            "alone": dataset.selection.alone,
            "cut": dataset.selection.cut,
            "selections": [
                vars(one) | {"here": one == dataset.selection} for one in steps.selections
            ],
            "held_out": held and str(held.name),
            "not_held": self.not_held,
            "current": steps.current,
            "session": str(steps.path),
            "code": self.code,
            "own": self.own.kinds(),
            "commands": typed.commands(steps, dataset.selection),
            "steps": [
                {
                    "number": s.number,
                    "parent": s.parent,
                    "did": s.did,
                    "fitted": s.fitted,
                    "error": None if s.rejected else s.error,
                    "floor": None if s.rejected else s.floor,
                    "fits": s.fits,
                }
                for s in steps.steps
            ],
        }

    def close(self) -> Json:
        """Back to the first page; the session stays beside its recording."""
        self.dataset, self.steps, self.log, self.held, self.not_held = None, None, None, None, ""
        self.datasets.clear()
        self.survey.beside = None
        self.own.go("")
        return self.changed()

    def listen(self, source: Text) -> Json:
        """Shows and records what a sensor sends, from a source of `davarlab live`."""
        self.listener.listen(source)
        return self.changed()

    def stop_listening(self) -> Json:
        """Nothing is listened to any more; what came is in the file."""
        self.listener.quiet()
        return self.changed()
