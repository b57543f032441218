"""Which source is listened to: one at a time, its results and raw samples kept in files."""

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import BadInput
from ..report.values import Json
from .arrivals import FROZEN_NAME, LIVE_NAME, RAW_NAME, Arrivals, Tell

if TYPE_CHECKING:
    from .listening import Listening


class Listener:
    """tell: as of Listening."""

    def __init__(self, arrivals: Arrivals, tell: Tell) -> None:
        self.arrivals, self.tell = arrivals, tell
        self.live: Listening | None = None
        self.heard = 0  # counts what was listened to

    def where(self) -> Json | None:
        """What a page must know to show it; None: nothing is listened to."""
        live = self.live
        return {"source": live.source.name, "number": self.heard} if live else None

    def listen(self, source: str) -> None:
        """Another source of `davarlab live`. What was listened to goes on until this one is
        open."""
        from .listening import Listening  # python-can and cantools are needed here only

        source = str(source).strip()
        if self.live and self.live.source.name == source:
            self.quiet()
        folder = self.arrivals.made()
        other = Listening(source, folder / LIVE_NAME, folder / RAW_NAME, self.tell)
        self.quiet()
        self.live, self.heard = other, self.heard + 1

    def quiet(self) -> None:
        live, self.live = self.live, None
        if live:
            live.stop()

    def now(self) -> "Listening":
        live = self.live
        if not live:
            raise BadInput("no live source is open")
        return live

    def so_far(self) -> Json:
        return self.now().so_far()

    def freeze(self, channel: int) -> Path:
        """The path of a recording of the raw samples of a channel so far."""
        with self.arrivals.receive(FROZEN_NAME) as drop:
            self.now().copy_raw(channel, drop.file)
        assert drop.path is not None  # it came whole
        return drop.path
