"""Where a visit stands: what lies on the desk, for the parts of the visit to work on."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ... import axes
from ...data.recording import Recording
from ...errors import BadInput
from ...report.values import Json
from ...tables import guess
from .. import desk as desks
from ..arrivals import Arrivals, Tell
from ..ears import Ears
from ..steps import Log, Sight, Steps

Wish = tuple[str, dict[str, Any]]  # what somebody waits for: a call and what it is given


class Stale(BadInput):
    """An action on something that the page showed and that is not so any more."""


@dataclass
class Waiting:
    """A log that waits to be read. shown: what the page shows of it; guesses: for its columns, none
    while the sensor is to be chosen."""

    path: Path
    shown: Json
    guesses: list[guess.Guess] = field(default_factory=list)
    sensor: str | None = None
    model: str | None = None  # a model file to look at, once the sensor is known
    names: list[str] | None = None  # of the columns, over those of the file
    skip: int = 0  # lines of the file


def named(log: Log | None) -> list[guess.Guess]:
    """The columns of a log as the session has them; none where it is read as it is."""
    return [guess.Guess(**one) for one in log["columns"]] if log else []


def as_named(path: str | Path, steps: Steps) -> Recording:
    """A recording whose columns are those that the session's log was read with."""
    log = steps.log
    return desks.read(
        path,
        named(log),
        log["rate_hz"] if log else None,
        log["sensor"] if log else None,
        log.get("as_recorded", False) if log else False,
        log.get("names") if log else None,
        log.get("skip", 0) if log else 0,
    )


def nobody(but: Wish | None = None) -> bool:
    return False


class Standing:
    """Keeps what lies on the desk. code: may a page run effects that somebody writes in it."""

    def __init__(self, folder: str | Path, code: bool = False) -> None:
        self.code, self.port = code, 0
        self.arrivals = Arrivals(folder)
        self.desk: desks.Desk | None = None
        self.desks: dict[Sight, desks.Desk] = {}  # of the complete axes of the recording
        self.steps: Steps | None = None
        self.held: Recording | None = None  # the recording that is held out
        self.not_held = ""  # why what was held out in an earlier visit is not now
        self.revision = 0  # counts the changes
        self.log: Waiting | None = None  # one that waits to be read
        self.tell: Tell = lambda **event: None
        self.ears = Ears(self.arrivals, lambda **event: self.tell(**event))
        # Does somebody wait for something else than `but`.
        self.hurried: Callable[[Wish | None], bool] = nobody

    @property
    def open_desk(self) -> desks.Desk:
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

    def desk_at(self, recording: Recording, sight: Sight) -> desks.Desk:
        """The desk of a sight. Those of complete axes stay, with the newest of what was computed on
        them."""
        kept = self.desks
        if any(one.whole is not recording for one in kept.values()):
            kept.clear()
        if sight.alone or sight.cut:
            return desks.Desk(recording, sight)
        if sight not in kept:
            shared = next((one.outcomes for one in kept.values()), None)
            kept[sight] = desks.Desk(recording, sight, shared)
        return kept[sight]

    def changed(self) -> Json:
        self.revision += 1
        self.tell(changed=self.revision)
        return self.everything()

    def everything(self) -> Json:
        """Where the visit stands, as a page shows it."""
        raise NotImplementedError
