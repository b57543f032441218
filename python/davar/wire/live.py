"""Live view of a sensor on a wire: checks, prints and records the stream (addons/can/DESIGN.md,
docs/DIALECTS.md)."""

import argparse
import contextlib
import json
import select
import signal
import sys
from dataclasses import asdict
from types import FrameType
from typing import IO

from ..errors import forget_output, shown
from . import frames as wire
from .dialects import DialectReceiver, results
from .dialects import receiver as receiver_of
from .raw_record import RawRecorder
from .record import Recorder, Row, row
from .source import Source
from .withheld import Explained

AnyReceiver = wire.Receiver | DialectReceiver


def say(text: str) -> None:
    print(f"davarlab live: {text}", file=sys.stderr, flush=True)


def alarm(values: Row) -> str:
    """What law glr has to say, in words."""
    if not values.get("alarm"):
        return ""
    older, newer, m = (values.get(name) for name in ("change_older", "change_newer", "change_m"))
    levels = (
        ""
        if older is None or newer is None or m is None
        else f": {older:.4g} -> {newer:.4g} deg/s at {m} sample{'s' if m > 1 else ''}"
    )
    return f"  ALARM, the noise has changed{levels}"


def slow_terms(values: Row) -> str:
    """What long cluster sizes resolve."""
    terms = (("BI", "bi_deg_per_h", "deg/h"), ("RRW", "rrw_deg_per_h_per_sqrt_h", "deg/h/sqrt(h)"))
    return "".join(
        f"  {short} {values[name]:.4g} {unit}" for short, name, unit in terms if values.get(name)
    )


def floor(values: Row) -> str:
    """The noise between rotor lines and motion."""
    value, high = values.get("floor_deg_per_sqrt_h"), values.get("floor_high_deg_per_sqrt_h")
    if "floor_why" not in values:
        return ""
    if value is None:
        return "  floor absent" if high is None else f"  floor below {high:.4g} deg/sqrt(h)"
    return f"  floor {value:.4g} deg/sqrt(h)"


def line(values: Row) -> str:
    """One result for people."""
    arw, doubt = values.get("arw_deg_per_sqrt_h"), values.get("arw_relative_uncertainty")
    reason = values.get("arw_withheld")
    shown = (
        "      absent" + (f" ({reason})" if reason else "")
        if arw is None
        else f"{arw:12.6g}" + ("" if doubt is None else f" +-{100 * doubt:.0f} %")
    )
    window = f"window {values.get('window_samples', '?')}"
    return (
        f"channel {values['channel']}  epoch {values['epoch']:>9}  ARW {shown} deg/sqrt(h)  "
        f"{window}"
        + floor(values)
        + slow_terms(values)
        + (
            ""
            if values.get("model_health") is None
            else f"  model health {values['model_health']:.2f}"
        )
        + ("  UNSTABLE" if values.get("unstable") and "alarm" not in values else "")
        + alarm(values)
    )


def summary(receiver: AnyReceiver) -> str:
    """What the receiver met, then what each device says it met."""
    faults = ", ".join(
        f"{count} {name.replace('_', ' ')}" for name, count in asdict(receiver.faults).items()
    )
    lines = [f"received: {faults}"]
    for index, channel in sorted(receiver.channels.items()):
        told = ", ".join(f"{name} {count}" for name, count in channel.health.items() if count)
        lines.append(f"channel {index} reports: {told or 'nothing lost'}")
    return "\n".join(lines)


def is_writable(file: IO[str]) -> bool:
    """Would a line find room? True too of what is no file of the system."""
    try:
        return bool(select.select([], [file], [], 0)[1])
    except (OSError, ValueError):
        return True


class Stop:
    """SIGINT, SIGTERM and SIGHUP: noted, so that nothing stays half done; only who waits for a
    reader is interrupted."""

    def __init__(self) -> None:
        self.came = self.at_once = False
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self.note)

    def note(self, number: int, frame: FrameType | None) -> None:
        self.came = True
        if self.at_once and not is_writable(sys.stdout):
            raise KeyboardInterrupt

    def show(self, text: str) -> None:
        """Prints a line; a reader who has not taken it when a signal comes gets no more."""
        try:
            self.at_once = True
            shown(text)
            self.at_once = False
        except KeyboardInterrupt:
            self.at_once = False
            forget_output()


class Viewer:
    """Shows results, and records them, and raw samples, if asked."""

    def __init__(
        self,
        receiver: AnyReceiver,
        recorder: Recorder | None,
        raw: RawRecorder | None,
        as_json: bool,
        stop: Stop,
    ) -> None:
        self.receiver, self.recorder, self.raw, self.as_json, self.stop, self.shown = (
            receiver,
            recorder,
            raw,
            as_json,
            stop,
            0,
        )
        self.stretches: dict[int, int] = {}  # channel -> the newest stretch that was said
        self.explained: dict[int, Explained] = {}  # channel -> of its newest stretch

    def show(self, result: wire.Result) -> None:
        if result.stretch > self.stretches.setdefault(result.channel, 1):
            self.stretches[result.channel] = result.stretch
            self.explained.pop(result.channel, None)
            say(
                f"channel {result.channel}: the sender has been restarted: a new section begins "
                f"with epoch {result.epoch}"
            )
        values = row(result, result.sender)
        explained = self.explained.setdefault(result.channel, Explained())
        if why := explained.add(values.get("arw_withheld")):
            say(f"channel {result.channel}: {why}")
        if self.recorder:
            self.recorder.add(result, result.sender)
        self.stop.show(json.dumps(values) if self.as_json else line(values))
        self.shown += 1

    def keep(self) -> None:
        """Raw samples that came."""
        found, self.receiver.samples = self.receiver.samples, []
        if self.raw:
            for samples in found:
                self.raw.add(*samples)


def follow(
    source: Source, receiver: AnyReceiver, viewer: Viewer, options: argparse.Namespace
) -> None:
    """Shows the stream to its end, to --count or to a signal; the last result is complete when
    nothing more comes."""
    for identifier, data in source.frames(options.idle, lambda: viewer.stop.came):
        found = results(receiver, identifier, data)
        viewer.keep()
        for result in found:
            viewer.show(result)
            if viewer.shown == options.count:
                return
    for result in receiver.finish():
        viewer.show(result)
    viewer.keep()


def run(options: argparse.Namespace) -> int:
    """The command: until --count, --idle, the end of a pty, SIGINT, SIGTERM or SIGHUP. Returns the
    exit status."""
    stop = Stop()
    receiver = receiver_of(options.source, options.base)
    receiver.wants_raw = bool(options.raw)
    with (
        contextlib.closing(Source(options.source, receiver.faults, say)) as source,
        contextlib.ExitStack() as stack,
    ):
        recorder = (
            stack.enter_context(contextlib.closing(Recorder(options.record, say)))
            if options.record
            else None
        )
        raw = (
            stack.enter_context(contextlib.closing(RawRecorder(options.raw, say)))
            if options.raw
            else None
        )
        follow(source, receiver, Viewer(receiver, recorder, raw, options.json, stop), options)
    print(summary(receiver), file=sys.stderr)
    if recorder and recorder.left_out:
        say(
            f"{recorder.path}: {recorder.left_out} values not recorded: they had no column when "
            "the header was written"
        )
    if recorder and recorder.unrecorded:
        say(f"{recorder.path}: {recorder.unrecorded} results not recorded")
    if raw and not raw.outputs:
        say(
            f"{raw.given}: no raw samples received (davar-sim and davar-node send them with --raw "
            "on can: and slcan:)"
        )
    if raw and raw.unrecorded:
        say(f"{raw.given}: {raw.unrecorded} raw samples not recorded")
    return 0
