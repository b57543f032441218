"""What was done, as a tree of models: every step can be gone back to, and all of it is in a file beside the recording."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from urllib.parse import quote

from .. import files, model as models
from ..errors import BadInput

ENDING = ".davarlab.json"
VERSION = 1


@dataclass
class Step:
    """A model that was reached. text: the model file; off: effects that are switched off, as in a model file; fitted: are the values those of
    a fit; did: what led here, in words."""
    number: int
    parent: int | None
    did: str
    text: str
    fitted: bool = True
    off: list = field(default_factory=list)
    error: float | None = None
    floor: float | None = None


@dataclass(frozen=True)
class Sight:
    """What of a recording is looked at: one gyro column, the whole of it, one stretch alone, or all but what was cut out (seconds)."""
    column: str
    alone: tuple = ()
    cut: tuple = ()

    @property
    def text(self):
        return json.dumps([self.column, self.alone, self.cut])

    @classmethod
    def of_text(cls, text):
        """What `text` gave. Raises ValueError and the like for anything else."""
        column, alone, cut = json.loads(text)
        pairs = ([alone] if alone else []) + cut
        if not isinstance(column, str) or not all(is_number(start) and is_number(stop) and 0 <= start < stop for start, stop in pairs):
            raise ValueError("sight")
        return cls(column, tuple(map(float, alone)), tuple((float(start), float(stop)) for start, stop in cut))


def is_number(value):
    """Is it a finite number that JSON gave."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < models.HUGE


def checked_log(log):
    """How the columns of a log are to be read, as save() wrote it. Raises ValueError and the like for anything else."""
    if log is None:
        return None
    words = {"name": str, "quantity": str, "axis": str, "unit": str}
    sound = set(log) <= {"columns", "rate_hz", "sensor", "as_recorded"} and isinstance(log["columns"], list) and all(
        set(one) == {*words, "factor"} and is_number(one["factor"]) and all(isinstance(one[name], kind) for name, kind in words.items()) for one in log["columns"])
    rate_hz, sensor = log["rate_hz"], log.get("sensor")
    if not sound or not (rate_hz is None or is_number(rate_hz) and rate_hz > 0) or not isinstance(sensor, (str, type(None))) or not isinstance(log.get("as_recorded", False), bool):
        raise ValueError("log")
    return log


def checked_step(entry, place):
    """A Step as save() wrote it, at its place in the list. Raises ValueError and the like for anything else."""
    step = Step(**entry)
    numbers = all(value is None or is_number(value) for value in (step.error, step.floor))
    parent = step.parent is None or type(step.parent) is int and 0 <= step.parent < place
    if type(step.number) is not int or step.number != place or not (parent and numbers and isinstance(step.did, str) and isinstance(step.fitted, bool)
                                                                    and isinstance(step.off, list)):
        raise ValueError(f"step {place}")
    models.of_text(step.text, f"step {place}")
    for number, term in enumerate(step.off):
        models.checked_term(term, f"step {place}: off {number}")
    return step


class Steps:
    """The trees of a recording, one for each sight of it, and where one stands. Each change is in the file before the page hears of it."""

    def __init__(self, recording_path, sensor=None):
        self.path = Path(str(recording_path) + (f".{quote(sensor, safe=':')}" if sensor else "") + ENDING)
        self.recording = str(recording_path)
        self.log = None  # how the columns are to be read, and of which sensor; None: as they are called, of the only one
        self.held_out = None  # path of a second recording, on which every step is judged
        self.sha256, self.written = files.sha256(recording_path), None
        self.trees, self.sight = {}, None  # Sight.text -> {"steps", "current"}; the one looked at

    @classmethod
    def beside(cls, recording_path, sensor=None):
        """Those of an earlier visit to this sensor of it; empty without one. Raises BadInput when the file is not what this program wrote."""
        found = cls(recording_path, sensor)
        if found.path.exists():
            try:
                found.written = found.path.read_bytes()
                data = json.loads(found.written)
                other = data["sha256"] != found.sha256
                found.take(data)
            except (BadInput, OSError, KeyError, TypeError, ValueError, AttributeError, RecursionError) as why:
                raise BadInput(f"{found.path}: not a session of davarlab ({why}); move it away to begin anew") from None
            if other:
                raise BadInput(f"{found.path}: the session of another recording of this name; move it away to begin anew")
        return found

    def take(self, data):
        """What save() wrote. Raises ValueError and the like for anything else."""
        if data["version"] != VERSION:
            raise ValueError(f"version {data['version']}, this program reads {VERSION}")
        self.log, self.sight, self.held_out = checked_log(data["log"]), Sight.of_text(data["sight"]), data.get("held_out")
        if not isinstance(self.held_out, (str, type(None))):
            raise ValueError("held_out")
        for sight, tree in data["trees"].items():
            Sight.of_text(sight)
            steps = [checked_step(one, place) for place, one in enumerate(tree["steps"])]
            if type(tree["current"]) is not int or not 0 <= tree["current"] < len(steps):
                raise ValueError("current")
            self.trees[sight] = {"steps": steps, "current": tree["current"]}
        if self.sight.text not in self.trees:
            raise ValueError("sight")

    def save(self, trees=None):
        """Writes the session with these trees, which are the session's from then on; raises BadInput and changes nothing where it cannot."""
        trees = self.trees if trees is None else trees
        kept = {sight: {"steps": [asdict(step) for step in tree["steps"]], "current": tree["current"]} for sight, tree in trees.items()}
        data = {"version": VERSION, "sha256": self.sha256, "log": self.log, "held_out": self.held_out, "sight": self.sight.text,
                "trees": kept}
        text = (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()
        if (self.path.read_bytes() if self.path.exists() else None) != self.written:
            raise BadInput(f"{self.path}: somebody else has written it (another davarlab open?); close one of them and open again")
        files.write_whole(self.path, text)
        self.trees, self.written = trees, text

    @property
    def steps(self):
        return self.trees[self.sight.text]["steps"] if self.sight and self.sight.text in self.trees else []

    @property
    def current(self):
        return self.trees[self.sight.text]["current"] if self.steps else None

    def grow(self, did, model, root=False, **more):
        """A step behind the current one, or one that begins a tree of its own; it becomes the current one. The same step again is gone to, not made."""
        step = Step(len(self.steps), None if root else self.current, did, models.text_of(model), **more)
        here = None if root or self.current is None else self.here
        alike = [here] if here else []
        alike += [one for one in self.steps if one.parent == step.parent]
        same = next((one for one in alike if (one.text, one.fitted, one.off) == (step.text, step.fitted, step.off)), None)
        steps = self.steps if same else [*self.steps, step]
        self.save({**self.trees, self.sight.text: {"steps": steps, "current": (same or step).number}})

    def hold_out(self, path):
        """Every step is judged on this recording too; None: on none."""
        before, self.held_out = self.held_out, path
        try:
            self.save()
        except BadInput:
            self.held_out = before
            raise

    def go(self, number):
        self.save({**self.trees, self.sight.text: {"steps": self.steps, "current": number}})

    @property
    def sights(self):
        return [Sight.of_text(text) for text in self.trees]

    @property
    def here(self):
        return self.steps[self.current]
