"""A visit to the workbench: what lies on the desk, and the table of everything that a page may ask
or do."""

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter

from .. import typed
from ..arrivals import Arrivals
from ..ears import Ears
from .closer import Closer
from .hold_out import HoldOut
from .intake import Intake
from .looks import Looks
from .stepping import Stepping

# Questions need the bench of a fit, looks only what is there; actions change something.
QUESTION, LOOK, ACTION = "question", "look", "action"
CALLS = {
    "step": (QUESTION, "stepping.step"),
    "candidates": (QUESTION, "stepping.candidates"),
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
    "open": (ACTION, "intake.open"),
    "tutorial": (ACTION, "intake.tutorial"),
    "sensor": (ACTION, "intake.sensor"),
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
    """kind: QUESTION, LOOK or ACTION; run: a function of plain values that returns plain values."""

    kind: str
    run: Callable


class Visit:
    """calls: name -> Call, of CALLS. What lies on the desk is kept here; the parts of the visit
    work on it."""

    def __init__(self, folder):
        self.arrivals, self.desk, self.steps = Arrivals(folder), None, None
        self.held = None  # the recording that is held out
        self.not_held = ""  # why what was held out in an earlier visit is not now
        self.revision = 0  # counts the changes
        self.log = None  # one that is Waiting
        self.tell = lambda **event: None
        self.ears = Ears(self.arrivals, lambda **event: self.tell(**event))
        self.hurried = lambda: False  # is somebody waiting for what is being computed
        self.intake, self.hold, self.stepping = Intake(self), HoldOut(self), Stepping(self)
        self.looks, self.closer = Looks(self), Closer(self)
        self.calls = {
            name: Call(kind, attrgetter(path)(self)) for name, (kind, path) in CALLS.items()
        }

    def progress(self, text):
        self.tell(progress=text)

    def changed(self):
        self.revision += 1
        self.tell(changed=self.revision)
        return self.everything()

    def everything(self):
        """Where the visit stands; `step` gives what a step looks like."""
        desk, steps, log, held, live = self.desk, self.steps, self.log, self.held, self.ears.where()
        if not desk:
            return {
                "again": "tools/davarlab open",
                "revision": self.revision,
                "recording": None,
                "live": live,
                "log": log and log.shown,
                "folder": str(self.arrivals.folder),
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
            "again": typed.again(self.steps),
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
                    "error": s.error,
                    "floor": s.floor,
                }
                for s in steps.steps
            ],
        }

    def close(self):
        """Back to the first page; the session stays beside its recording."""
        self.desk, self.steps, self.log, self.held, self.not_held = None, None, None, None, ""
        return self.changed()

    def listen(self, source):
        """Shows and records what a sensor sends: can:IFACE or slcan:PATH."""
        self.ears.listen(source)
        return self.changed()

    def deafen(self):
        """Nothing is listened to any more; what came is in the file."""
        self.ears.quiet()
        return self.changed()
