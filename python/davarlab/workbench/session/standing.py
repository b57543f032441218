"""Where a session stands: what is open, for the parts of the session to work on."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...data.recording import Recording
from ...errors import BadInput
from ...report.values import Json
from ...tables import guess
from .. import dataset as datasets
from ..arrivals import Arrivals, Tell
from ..listener import Listener
from ..steps import Log, Selection, Steps

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
    return datasets.read(
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
    """Keeps what is open. folder: where the workbench was opened; kept: where it keeps files that
    come by the page; code: may a page run effects that somebody writes in it."""

    def __init__(
        self, folder: str | Path, code: bool = False, kept: str | Path | None = None
    ) -> None:
        self.code, self.port, self.folder = code, 0, Path(folder)
        self.arrivals = Arrivals(kept or folder)
        self.dataset: datasets.Dataset | None = None
        self.datasets: dict[
            Selection, datasets.Dataset
        ] = {}  # of the complete axes of the recording
        self.steps: Steps | None = None
        self.held: Recording | None = None  # the recording that is held out
        self.not_held = ""  # why what was held out in an earlier session is not now
        self.revision = 0  # counts the changes
        self.log: Waiting | None = None  # one that waits to be read
        self.tell: Tell = lambda **event: None
        self.listener = Listener(self.arrivals, lambda **event: self.tell(**event))
        # Does somebody wait for something else than `but`.
        self.superseded: Callable[[Wish | None], bool] = nobody

    @property
    def open_dataset(self) -> datasets.Dataset:
        """The dataset with its recording. Raises Stale while there is none."""
        if not self.dataset:
            raise Stale("no recording is open")
        return self.dataset

    @property
    def open_steps(self) -> Steps:
        """The steps of the recording that is open. Raises Stale while there is none."""
        if not self.steps:
            raise Stale("no recording is open")
        return self.steps

    def progress(self, text: str) -> None:
        self.tell(progress=text)

    def dataset_at(self, recording: Recording, selection: Selection) -> datasets.Dataset:
        """The dataset of a selection. Those of complete axes stay, with the newest of what was
        computed on them."""
        kept = self.datasets
        if any(one.whole is not recording for one in kept.values()):
            kept.clear()
        if selection.alone or selection.cut:
            return datasets.Dataset(recording, selection)
        if selection not in kept:
            shared = next((one.outcomes for one in kept.values()), None)
            kept[selection] = datasets.Dataset(recording, selection, shared)
        return kept[selection]

    def changed(self) -> Json:
        self.revision += 1
        self.tell(changed=self.revision)
        return self.everything()

    def everything(self) -> Json:
        """Where the session stands, as a page shows it."""
        raise NotImplementedError
