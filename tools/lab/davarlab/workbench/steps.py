"""What was done, as a tree of models: every step can be gone back to, and all of it is in a file beside the recording."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

from .. import files, model as models
from ..errors import BadInput

ENDING = ".davarlab.json"
VERSION = 1


@dataclass
class Step:
    """A model that was reached. text: the model file; off: effects that are switched off, as in a model file; fitted: are the values those of
    a fit; did: what led here, in words; command: what would do the same in a terminal."""
    number: int
    parent: int | None
    did: str
    command: str
    text: str
    fitted: bool = True
    off: list = field(default_factory=list)
    error: float | None = None
    floor: float | None = None
    adequacy: str = ""


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
        column, alone, cut = json.loads(text)
        if not isinstance(column, str) or len(alone) not in (0, 2):
            raise ValueError("sight")
        return cls(column, tuple(float(edge) for edge in alone), tuple((float(start), float(stop)) for start, stop in cut))


class Steps:
    """The trees of a recording, one for each sight of it, and where one stands. Each change is in the file before the page hears of it."""

    def __init__(self, recording_path):
        self.path, self.recording = Path(str(recording_path) + ENDING), str(recording_path)
        self.log = None  # how the columns are to be read, None: as they are called
        self.trees, self.sight = {}, None  # Sight.text -> {"steps", "current"}; the one looked at

    @classmethod
    def beside(cls, recording_path):
        """Those of an earlier visit; empty without one. Raises BadInput when the file is not what this program wrote."""
        found = cls(recording_path)
        if found.path.exists():
            try:
                found.take(json.loads(found.path.read_text(encoding="utf-8")))
            except (OSError, KeyError, TypeError, ValueError, AttributeError, RecursionError) as why:
                raise BadInput(f"{found.path}: not a session of davarlab ({why}); move it away to begin anew") from None
        return found

    def take(self, data):
        """What save() wrote. Raises ValueError and the like for anything else."""
        if data["version"] != VERSION:
            raise ValueError(f"version {data['version']}, this program reads {VERSION}")
        self.log, self.sight = data["log"], Sight.of_text(data["sight"])
        for sight, tree in data["trees"].items():
            Sight.of_text(sight)
            steps = [Step(**one) for one in tree["steps"]]
            for place, step in enumerate(steps):
                if step.number != place or not (step.parent is None if place == 0 else 0 <= step.parent < place):
                    raise ValueError(f"step {place}")
                models.of_text(step.text, f"step {place}")
            if not 0 <= tree["current"] < len(steps):
                raise ValueError("current")
            self.trees[sight] = {"steps": steps, "current": tree["current"]}
        if self.sight.text not in self.trees:
            raise ValueError("sight")

    def save(self):
        trees = {sight: {"steps": [asdict(step) for step in tree["steps"]], "current": tree["current"]} for sight, tree in self.trees.items()}
        data = {"version": VERSION, "recording": self.recording, "log": self.log, "sight": self.sight.text, "trees": trees}
        files.write_whole(self.path, (json.dumps(data, indent=1, allow_nan=False) + "\n").encode())

    @property
    def steps(self):
        return self.trees[self.sight.text]["steps"] if self.sight and self.sight.text in self.trees else []

    @property
    def current(self):
        return self.trees[self.sight.text]["current"]

    def grow(self, did, command, model, **more):
        """A step behind the current one, which becomes the current one; the same step again is gone to, not made."""
        tree = self.trees.setdefault(self.sight.text, {"steps": [], "current": None})
        step = Step(len(tree["steps"]), tree["current"], did, command, models.text_of(model), **more)
        same = next((one for one in tree["steps"] if (one.parent, one.text, one.fitted, one.off) == (step.parent, step.text, step.fitted, step.off)), None)
        if not same:
            tree["steps"].append(step)
        tree["current"] = (same or step).number
        self.save()

    def go(self, number):
        self.trees[self.sight.text]["current"] = number
        self.save()

    @property
    def here(self):
        return self.steps[self.current]

    def way(self, number=None):
        """The steps from the first to this one."""
        step, found = self.steps[self.current if number is None else number], []
        while step:
            found.append(step)
            step = None if step.parent is None else self.steps[step.parent]
        return found[::-1]
