"""What was done, as a tree of models: every step can be gone back to, and all of it is in a file
beside the recording."""

import json
import os
import re
import shlex
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NotRequired, TypedDict, cast
from urllib.parse import quote

from .. import files
from .. import model as models
from ..errors import BadInput
from . import schema

ENDING = ".davarlab.json"
VERSION = 1

Stretch = tuple[float, float]  # seconds


class Log(TypedDict):
    """How the columns of a log are to be read, as in a session file."""

    columns: list[dict[str, Any]]
    rate_hz: float | None
    sensor: str | None
    as_recorded: NotRequired[bool]
    names: NotRequired[list[str] | None]
    skip: NotRequired[int]


@dataclass
class Step:
    """A model that was reached. text: the model file; off: effects that are switched off, as in a
    model file; fitted: are the values those of a fit; did: what led here, in words; rejected: the
    recording permits no model; fits: its verdict with the candidates, None before they are
    known."""

    number: int
    parent: int | None
    did: str
    text: str
    fitted: bool = True
    off: list[dict[str, float | str]] = field(default_factory=list)
    error: float | None = None
    floor: float | None = None
    rejected: bool = False
    fits: bool | None = None


def fit_of(step: Step, steps: list[Step]) -> Step:
    """The step of the fit that a step came from; a model as given stands for its own fit."""
    while not step.fitted and step.parent is not None:
        step = steps[step.parent]
    return step


@dataclass(frozen=True)
class Selection:
    """What of a recording is looked at: one gyro column, the whole of it, one stretch alone, or all
    but what was cut out (seconds)."""

    column: str
    alone: tuple[()] | Stretch = ()
    cut: tuple[Stretch, ...] = ()

    @property
    def text(self) -> str:
        return json.dumps([self.column, self.alone, self.cut])

    @classmethod
    def of_text(cls, text: str) -> "Selection":
        """What `text` gave. Raises ValueError for anything else."""
        column, alone, cut = schema.selection(text)
        if not all(0 <= start < stop for start, stop in ([alone] if alone else []) + cut):
            raise ValueError("selection")
        return cls(column, alone, tuple(cut))


def checked_step(entry: schema.KeptStep, place: int) -> Step:
    """A Step of a schema.KeptStep, at its place in the list. Raises BadInput and ValueError."""
    if entry.number != place or entry.parent is not None and entry.parent >= place:
        raise ValueError(f"step {place}")
    models.of_text(entry.text, f"step {place}")
    for number, term in enumerate(entry.off):
        models.checked_term(term, f"step {place}: off {number}")
    return Step(**entry.model_dump())


class Tree(TypedDict):
    """The steps of one selection, and the number of the one where one stands."""

    steps: list[Step]
    current: int


class Steps:
    """The trees of a recording, one for each selection of it, and where one stands. Each change is
    in the file before the page hears of it."""

    def __init__(self, recording_path: str | Path, sensor: str | None = None) -> None:
        self.path = Path(
            str(recording_path) + (f".{quote(sensor, safe=':')}" if sensor else "") + ENDING
        )
        self.recording = str(recording_path)
        # How the columns are to be read, and of which sensor; None: as they are called, of the only
        # one.
        self.log: Log | None = None
        self.held_out: str | None = (
            None  # path of a second recording, on which every step is judged
        )
        self.sha256 = files.sha256(recording_path)
        self.written: bytes | None = None  # what is in the file
        self.trees: dict[str, Tree] = {}  # by Selection.text
        self.selection: Selection | None = None  # the one looked at

    @classmethod
    def beside(cls, recording_path: str | Path, sensor: str | None = None) -> "Steps":
        """Those of an earlier session with this sensor of it; empty without one. Raises BadInput
        when the file is not what this program wrote."""
        found = cls(recording_path, sensor)
        found.written = found.there()
        if found.written is not None:
            try:
                data = schema.session(found.written)
                found.take(data)
            except (BadInput, ValueError) as why:
                own = re.search(r"unknown kind '(\w+)'", str(why))
                if own:
                    file = f"{recording_path}.{own[1]}.py"
                    again = ["tools/davarlab", "open", str(recording_path), "--effects", file]
                    raise BadInput(
                        f"{found.path}: a step has the effect {own[1]}, which is not loaded. "
                        f"{file} is a program that runs with your rights. Load it only if you know "
                        f"where it is from: {shlex.join(again)}"
                    ) from None
                raise BadInput(
                    f"{found.path}: not a session of davarlab ({why}). Move it away to start a "
                    "new one"
                ) from None
            if data.sha256 != found.sha256:
                raise BadInput(
                    f"{found.path}: the session of another recording with this name. Move it away "
                    "to start a new one"
                )
        return found

    def there(self) -> bytes | None:
        """The bytes of the session file; None: there is none. Raises BadInput for what is no file
        of this program, and for a symbolic link: what it leads to, perhaps nothing yet, is somebody
        else's."""
        if not os.path.lexists(self.path):
            return None
        if os.path.islink(self.path):
            raise BadInput(
                f"{self.path}: a symbolic link, not a session of davarlab. Move it away to start "
                "a new one"
            )
        return files.read_whole(self.path)

    def take(self, data: schema.SessionFile) -> None:
        """What save() wrote, as a schema.Session. Raises BadInput and ValueError for anything
        else."""
        self.log = cast(Log, data.log.model_dump()) if data.log else None
        self.selection, self.held_out = Selection.of_text(data.selection), data.held_out
        for selection, tree in data.trees.items():
            Selection.of_text(selection)
            steps = [checked_step(one, place) for place, one in enumerate(tree.steps)]
            if tree.current >= len(steps):
                raise ValueError("current")
            self.trees[selection] = {"steps": steps, "current": tree.current}
        if self.selection.text not in self.trees:
            raise ValueError("selection")

    def save(self, trees: dict[str, Tree] | None = None) -> None:
        """Writes the session with these trees, which are the session's from then on; raises
        BadInput and changes nothing where it cannot."""
        trees = self.trees if trees is None else trees
        kept = {
            selection: {
                "steps": [asdict(step) for step in tree["steps"]],
                "current": tree["current"],
            }
            for selection, tree in trees.items()
        }
        data = {
            "version": VERSION,
            "sha256": self.sha256,
            "log": self.log,
            "held_out": self.held_out,
            "selection": self.seen,
            "trees": kept,
        }
        text = (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()
        if self.there() != self.written:
            raise BadInput(
                f"{self.path}: another process has changed it (another davarlab open?). Close one "
                "of them and open the recording again"
            )
        files.write_whole(self.path, text, follow=False)
        self.trees, self.written = trees, text

    def tree(self, selection: Selection) -> Tree | None:
        """The steps of a selection; None: it has none yet."""
        return self.trees.get(selection.text)

    @property
    def steps(self) -> list[Step]:
        return (
            self.trees[self.selection.text]["steps"]
            if self.selection and self.selection.text in self.trees
            else []
        )

    @property
    def seen(self) -> str:
        """The text of the selection that is looked at."""
        assert self.selection is not None  # there are steps of it
        return self.selection.text

    @property
    def current(self) -> int | None:
        return self.trees[self.seen]["current"] if self.steps else None

    def grow(self, did: str, model: models.Model, root: bool = False, **more: Any) -> None:
        """A step behind the current one, or one that begins a tree of its own; it becomes the
        current one. The same step again is gone to, not made."""
        step = Step(
            len(self.steps), None if root else self.current, did, models.text_of(model), **more
        )
        here = None if root or self.current is None else self.here
        alike = [here] if here else []
        alike += [one for one in self.steps if one.parent == step.parent]
        same = next(
            (
                one
                for one in alike
                if (one.text, one.fitted, one.off) == (step.text, step.fitted, step.off)
            ),
            None,
        )
        steps = self.steps if same else [*self.steps, step]
        self.save({**self.trees, self.seen: {"steps": steps, "current": (same or step).number}})

    def hold_out(self, path: str | None) -> None:
        """Every step is judged on this recording too; None: on none."""
        before, self.held_out = self.held_out, path
        try:
            self.save()
        except BadInput:
            self.held_out = before
            raise

    def settle(self, number: int, fits: bool) -> None:
        """The verdict of a step stays with it."""
        if self.steps[number].fits != fits:
            self.steps[number].fits = fits
            self.save()

    def go(self, number: int) -> None:
        self.save({**self.trees, self.seen: {"steps": self.steps, "current": number}})

    @property
    def selections(self) -> list[Selection]:
        return [Selection.of_text(text) for text in self.trees]

    def way(self, step: Step) -> list[Step]:
        """The steps to a step, the first one first."""
        before = [] if step.parent is None else self.way(self.steps[step.parent])
        return [*before, step]

    @property
    def here(self) -> Step:
        assert self.current is not None  # there is a step
        return self.steps[self.current]
