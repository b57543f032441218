"""A sensor on the wire while somebody watches: what `davarlab live` shows and records, kept for a
page."""

import threading
import time
from collections import deque
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import BinaryIO

from davar.wire import dialects, record
from davar.wire.frames import Result
from davar.wire.raw_record import RawRecorder
from davar.wire.source import Source
from davar.wire.withheld import REASONS

from .. import files
from ..errors import BadInput, internal_error
from ..report.values import Json
from .arrivals import Tell
from .curve import curve

BLOCK = 1 << 20
KEPT = 1200  # results of a channel
TOLD_S = 0.25  # between two tellings
IDLE_S = 0.25  # of silence, after which it is asked whether anybody still watches


def shown(result: Result) -> record.Row:
    """A result as a row, with the interval that its relative uncertainty, half of it over the
    value, stands for."""
    row = record.row(result, result.sender)
    arw, doubt = row.get("arw_deg_per_sqrt_h"), row.get("arw_relative_uncertainty")
    if arw is not None and doubt is not None:
        row |= {
            "arw_low_deg_per_sqrt_h": arw * (1 - doubt),
            "arw_high_deg_per_sqrt_h": arw * (1 + doubt),
        }
    return row


class Listening:
    """Listens in a thread until stop(), or until a pty is closed. tell: hears what is new, {"rows",
    "count", ...}: `count` with the last of these."""

    def __init__(self, source: str, path: Path, raw_path: Path, tell: Tell) -> None:
        self.receiver, self.tell, self.said = dialects.receiver(source), tell, ""
        self.source = Source(source, self.receiver.faults, self.say)
        try:
            self.recorder, self.raw = (
                record.Recorder(path, self.say),
                RawRecorder(raw_path, self.say),
            )
        except BadInput:
            self.source.close()
            raise
        self.lock = threading.Lock()
        self.results: dict[int, deque[Result]] = {}  # channel -> its last results
        self.fresh: list[Result] = []  # those that were not told
        self.count = 0  # of all results that were told
        self.told_at, self.stopped, self.ended = 0.0, False, False
        self.stood: Json | None = None  # what was told last of how it stands
        self.thread = threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def say(self, text: str) -> None:
        self.said = text.removeprefix("--record: ").removeprefix("--raw: ")

    def listen(self) -> None:
        try:
            with closing(self.source), closing(self.recorder), closing(self.raw):
                while not self.stopped and self.source.may_come:
                    for identifier, data in self.source.frames(IDLE_S):
                        for result in dialects.results(self.receiver, identifier, data):
                            self.take(result)
                        self.keep()
                        if self.stopped:
                            break
                        self.tell_news()
                    self.tell_news()
                for result in self.receiver.finish():
                    self.take(result)
                self.keep()
        except Exception as why:
            internal_error(why)
            self.say(f"an internal error: {type(why).__name__}: {why}")
        finally:
            self.tell_news(last=True)

    def take(self, result: Result) -> None:
        """Keeps a result; it is told when DAVAR_Setup has named what it holds."""
        self.recorder.add(result, result.sender)
        self.fresh.append(result)

    def keep(self) -> None:
        """Raw samples that came."""
        found, self.receiver.samples = self.receiver.samples, []
        for samples in found:
            with self.lock:
                self.raw.add(*samples)

    def copy_raw(self, number: int, file: BinaryIO) -> None:
        """Copies the recording of the raw samples of a channel so far; more may come."""
        with self.lock:
            path = self.raw.path(number)
            if not path:
                raise BadInput(
                    f"channel {number}: no raw samples received. Start the sender with --raw"
                )
            left = path.stat().st_size  # whole rows
        with files.reading(path) as recording:
            while left and (block := recording.read(min(left, BLOCK))):
                file.write(block)
                left -= len(block)

    def tell_news(self, last: bool = False) -> None:
        """last: at once, and the source has ended: nobody sees that before the last rows."""
        if not last and time.monotonic() - self.told_at < TOLD_S:
            return
        self.told_at = time.monotonic()
        named = [record.is_named(result, result.sender) for result in self.fresh]
        if last or named.count(False) >= record.WAITING_MAX:
            named = [True] * len(named)
        told = [result for result, now in zip(self.fresh, named) if now]
        self.fresh = [result for result, now in zip(self.fresh, named) if not now]
        with self.lock:
            for result in told:
                self.results.setdefault(result.channel, deque(maxlen=KEPT)).append(result)
            self.count += len(told)
            self.ended = last
            before, self.stood = self.stood, self.standing()
        if told or self.stood != before:
            self.tell(
                live={
                    **self.stood,
                    "rows": [shown(result) for result in told],
                    "count": self.count,
                    "curves": self.curves(),
                }
            )

    def standing(self) -> Json:
        """What the receiver met and what each device says it met, what is not 0; and the last thing
        that was said."""
        channels = list(self.receiver.channels.items())
        return {
            "source": self.source.name,
            "path": str(self.recorder.path),
            "raw": sorted(self.raw.outputs),
            "said": self.said,
            "ended": self.ended,
            "faults": {
                name: count for name, count in asdict(self.receiver.faults).items() if count
            },
            "health": {
                index: {name: count for name, count in dict(channel.health).items() if count}
                for index, channel in channels
            },
        }

    def curves(self) -> Json:
        """Channel -> the Allan curve of its newest result."""
        return {str(index): curve(results[-1]) for index, results in self.results.items()}

    def so_far(self) -> Json:
        with self.lock:
            return {
                **self.standing(),
                "rows": [shown(result) for results in self.results.values() for result in results],
                "count": self.count,
                "curves": self.curves(),
                "kept": KEPT,
                "reasons": REASONS,
            }

    def stop(self) -> None:
        self.stopped = True
        self.thread.join()
