"""Results from the messages of autopilots: MAVLink, DroneCAN and Cyphal (docs/DIALECTS.md). Other
people's libraries decode them; each is imported when its dialect is used."""

import importlib
import itertools
import math
import shutil
import sys
import tempfile
from collections import deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from .. import places
from ..errors import BadInput, of_extra
from .frames import BASE, Channel, Faults, Receiver, Result
from .raw import Sample
from .record import FLOOR
from .withheld import REASONS

# What every dialect lists, in this order. An empty name: not shown.
QUANTITIES = (
    "arw_deg_per_sqrt_h",
    "arw_low_deg_per_sqrt_h",
    "arw_high_deg_per_sqrt_h",
    "bi_deg_per_h",
    "",
    "",
    "rrw_deg_per_h_per_sqrt_h",
    "",
    "",
    "rr_deg_per_h2",
    "qn_deg",
    "kurtosis",
    "rate_hz",
)
NOISE = ("unknown", "white", *REASONS)  # davar_noise_t
AXES = "XYZ3456789"
KEYS = ("AR", "AL", "AH", "BI", "BL", "BH")  # of DroneCAN, for the first quantities
KEY_VALUE, KEY_VALUE_BYTES = 16370, 8
NOISE_BYTES = 62
SUBJECT, SUBJECT_LAST = 3700, 8191  # of Cyphal


@dataclass
class Message:
    """One result as a message has it. epoch: modulo `modulus`; None: the message has none."""

    sender: Hashable
    channel: int
    quantities: tuple[float, ...]
    values: dict[str, Any] = field(default_factory=dict)
    epoch: int | None = None
    modulus: int = 2**32


def flags(state: int) -> dict[str, Any]:
    """The bits of `state`."""
    noise = NOISE[state & 7] if state & 7 < len(NOISE) else "unknown"
    found: dict[str, Any] = {"unstable": state >> 3 & 1, "noise": noise}
    return (
        found | ({"young": 1} if state >> 4 & 1 else {}) | ({"alarm": 1} if state >> 5 & 1 else {})
    )


def floor(data: Sequence[float]) -> dict[str, Any]:
    """The floor, its limits and why it is absent; all 0: not sent."""
    found: dict[str, Any] = dict(zip(FLOOR, data)) if any(data) else {}
    return found | ({"floor_why": int(found["floor_why"])} if found else {})


class Numbers:
    """Counts the packets that never came, by the number that each sender counts up."""

    def __init__(self, modulus: int, faults: Faults) -> None:
        self.modulus, self.faults = modulus, faults
        self.last: dict[Hashable, int] = {}

    def take(self, sender: Hashable, number: int) -> None:
        if sender in self.last:
            self.faults.missing += (number - self.last[sender] - 1) % self.modulus
        self.last[sender] = number
        self.faults.good += 1


class Decoder(Protocol):
    """Finds results in what a source yields."""

    def messages(self, identifier: int, data: bytes) -> Iterator[Message]: ...


class Mavlink:
    """DEBUG_FLOAT_ARRAY `davar`; NAMED_VALUE_FLOAT repeats two of its values."""

    def __init__(self, faults: Faults) -> None:
        from pymavlink.dialects.v20 import common

        self.parser, self.faults = common.MAVLink(None), faults
        self.parser.robust_parsing = True
        self.numbers = Numbers(256, faults)

    def messages(self, identifier: int, data: bytes) -> Iterator[Message]:
        for one in self.parser.parse_buffer(data) or []:
            if one.get_type() == "BAD_DATA":
                self.faults.corrupted += 1
                continue
            sender = one.get_srcSystem(), one.get_srcComponent()
            self.numbers.take(sender, one.get_seq())
            if one.get_type() != "DEBUG_FLOAT_ARRAY" or one.name != "davar":
                continue
            if not all(
                0 <= number < 2**32 and number % 1 == 0
                for number in (*one.data[13:16], one.data[19])
            ):
                self.faults.impossible += 1
                continue
            samples, state, epoch = map(int, one.data[13:16])
            values = {"window_samples": samples, **flags(state), **floor(one.data[16:20])}
            yield Message(sender, one.array_id, tuple(one.data[:13]), values, epoch, modulus=2**24)


class Dronecan:
    """KeyValue: six frames are a result. They have no epoch, so results are numbered."""

    def __init__(self, faults: Faults) -> None:
        from dronecan.transport import Frame, Transfer

        self.frame, self.transfer, self.faults = Frame, Transfer, faults
        self.numbers = Numbers(32, faults)
        self.parts: dict[tuple[int, str], dict[str, float]] = {}

    def messages(self, identifier: int, data: bytes) -> Iterator[Message]:
        if (identifier >> 8 & 0xFFFF, identifier >> 7 & 1) != (KEY_VALUE, 0):
            self.faults.foreign += 1
        elif len(data) == KEY_VALUE_BYTES and data[-1] & 0xE0 == 0xC0:  # one frame, as we send it
            transfer = self.transfer()
            transfer.from_frames([self.frame(identifier, data)])
            self.numbers.take(transfer.source_node_id, transfer.transfer_id)
            key = bytes(transfer.payload.key).decode("latin-1")
            yield from self._join(transfer.source_node_id, key, float(transfer.payload.value))

    def _join(self, node: int, key: str, value: float) -> Iterator[Message]:
        name, axis = key[:2], key[2:]
        if name not in KEYS or len(axis) != 1 or axis not in AXES:
            return
        place = node, axis
        if name == KEYS[0]:
            self.faults.incomplete_results += place in self.parts
            self.parts[place] = {}
        if place not in self.parts:
            return
        self.parts[place][name] = value
        if name == KEYS[-1]:
            found = self.parts.pop(place)
            if len(found) == len(KEYS):
                yield Message(node, AXES.index(axis), tuple(found[one] for one in KEYS))
            else:
                self.faults.incomplete_results += 1


class Cyphal:
    """davar.Noise.1.0. A message does not name its type, so only its subject tells what it is."""

    def __init__(self, faults: Faults, subject: int = SUBJECT) -> None:
        import pycyphal.dsdl
        from pycyphal.transport import MessageDataSpecifier, can

        self.can, self.dsdl, self.faults = can, pycyphal.dsdl, faults
        self.tracer = can.CANTransport.make_tracer()
        self.numbers = Numbers(32, faults)
        self.noise, self.subject = self._generated(), MessageDataSpecifier(subject)

    def _generated(self) -> Any:
        """The class that nunavut generates from our definition. The namespace has another name
        here, because `davar` is a Python package."""
        with tempfile.TemporaryDirectory() as folder:
            namespace = Path(folder, "dsdl", "davar_dsdl")
            namespace.mkdir(parents=True)
            shutil.copy(places.shared("tools/dialects/davar/Noise.1.0.dsdl"), namespace)
            self.dsdl.compile(namespace, output_directory=folder)
            sys.path.append(folder)
            try:
                return importlib.import_module("davar_dsdl").Noise_1_0
            finally:
                sys.path.remove(folder)

    def messages(self, identifier: int, data: bytes) -> Iterator[Message]:
        from pycyphal.transport import Timestamp, TransferTrace

        media = self.can.media
        frame = media.DataFrame(media.FrameFormat.EXTENDED, identifier, bytearray(data))
        trace = self.tracer.update(self.can.CANCapture(Timestamp.now(), frame, own=False))
        if not isinstance(trace, TransferTrace):
            self.faults.foreign += 1
            return
        metadata = trace.transfer.metadata
        session, payload = metadata.session_specifier, trace.transfer.fragmented_payload
        one = self.dsdl.deserialize(self.noise, payload)
        is_short = sum(map(len, payload)) < NOISE_BYTES  # what is missing would read as 0
        if session.data_specifier != self.subject or one is None or is_short:
            self.faults.foreign += 1
            return
        self.numbers.take(session.source_node_id, metadata.transfer_id)
        yield self._message(session.source_node_id, one)

    @staticmethod
    def _message(sender: Hashable, one: Any) -> Message:
        kinds = ("angle_random_walk", "bias_instability", "rate_random_walk")
        names = [kind + limit for kind in kinds for limit in ("", "_low", "_high")]
        names += ["rate_ramp", "quantization", "kurtosis", "rate_hz"]
        state = one.noise + 8 * one.unstable + 16 * one.young + 32 * one.alarm
        values = {"window_samples": one.window_samples, **flags(state)}
        quantities = tuple(float(getattr(one, name)) for name in names)
        return Message(sender, one.channel, quantities, values, one.epoch)


class DialectReceiver:
    """A frames.Receiver of a dialect: the same methods and fields."""

    def __init__(self, dialect: str, **options: Any) -> None:
        self.faults = Faults()
        self.decoder: Decoder = DIALECTS[dialect](self.faults, **options)
        self.channels: dict[int, Channel] = {}
        self.senders: dict[int, Hashable] = {}  # of a channel: the first that sent it
        self.ready: deque[Result] = deque()
        self.count = itertools.count()
        self.wants_raw = True  # none ever comes
        self.samples: list[tuple[int, Channel, list[Sample]]] = []

    def push(self, identifier: int, data: bytes) -> Result | None:
        """Takes what a source yields; MAVLink: any piece of the stream."""
        for message in self.decoder.messages(identifier, data):
            if (result := self._result(message)) is not None:
                self.ready.append(result)
        return self.ready.popleft() if self.ready else None

    def finish(self) -> list[Result]:
        left, self.ready = list(self.ready), deque()
        return left

    def _result(self, message: Message) -> Result | None:
        if message.channel >= len(AXES):
            self.faults.impossible += 1
            return None
        if message.sender != self.senders.setdefault(message.channel, message.sender):
            self.faults.foreign += 1
            return None
        channel = self._channel(message)
        if channel is None:
            return None
        values = {name: one for name, one in zip(QUANTITIES, message.quantities) if name}
        rate_hz = values.pop("rate_hz", math.nan)
        if 0 < rate_hz < math.inf:
            channel.setup["rate_hz"] = rate_hz
        noise = message.values.pop("noise", None)
        arw, low, high = message.quantities[:3]
        if math.isnan(arw) and noise in REASONS:
            values["arw_withheld"] = noise
        if arw > 0:
            values["arw_relative_uncertainty"] = (high - low) / (2 * arw)
        assert channel.epoch is not None  # _channel has set it
        return Result(
            message.channel,
            0,
            channel.epoch,
            values | message.values,
            stretch=channel.stretch,
            of=channel,
        )

    def _channel(self, message: Message) -> Channel | None:
        """The channel with the message's epoch; None: it came before. One that falls back is of a
        sender that was restarted."""
        channel = self.channels.setdefault(message.channel, Channel())
        if message.epoch is None:
            channel.epoch = next(self.count)
            return channel
        ahead = 0 if channel.epoch is None else (message.epoch - channel.epoch) % message.modulus
        if channel.epoch is not None and ahead == 0:
            self.faults.repeated += 1
            return None
        if ahead >= message.modulus // 2:
            self.faults.restarts += 1
            channel = self.channels[message.channel] = Channel(channel.stretch + 1)
        channel.epoch = message.epoch if channel.epoch is None else channel.epoch + ahead
        return channel


DIALECTS: dict[str, Callable[..., Decoder]] = {
    "mavlink": Mavlink,
    "dronecan": Dronecan,
    "cyphal": Cyphal,
}


def results(receiver: Receiver | DialectReceiver, identifier: int, data: bytes) -> list[Result]:
    """All results that are complete with what a source yields: a piece of a stream may end
    several."""
    found = [receiver.push(identifier, data), *receiver.ready]
    receiver.ready.clear()
    return [result for result in found if result]


def receiver(source: str, base: int = BASE) -> Receiver | DialectReceiver:
    """The receiver for a source: of a dialect, or of davar's own frames."""
    kind = source.partition(":")[0]
    if kind not in DIALECTS:
        return Receiver(base)
    _, at, digits = source.partition("@") if kind == "cyphal" else ("", "", "")
    if at and not (digits.isdecimal() and int(digits) <= SUBJECT_LAST):
        raise BadInput(f"{source}: subject 0 to {SUBJECT_LAST} expected, found '{digits}'")
    with of_extra("wire"):
        return DialectReceiver(kind, **({"subject": int(digits)} if at else {}))
