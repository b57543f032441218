"""Frames of davar (addons/can/DESIGN.md) to results: checks every frame, counts what is wrong, and
joins frames to results.

Decoding is cantools with tools/davar.dbc; transports are in source.py.
"""

import functools
import math
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict, cast

import cantools
from cantools.database.can import Database, Message
from cantools.database.errors import Error

from .. import places
from .raw import Sample, Samples, written
from .withheld import REASONS

DBC_PATH = places.shared("tools/davar.dbc")
BASE, STEP = 0x5D0, 16
CRC_POLYNOMIAL = 0x1D
LEAST, MOST = 1e-30, 1e30  # magnitude of a float but 0, as in davar/can.h
# Results of a channel that are joined at a time: one that is not complete when so many have begun
# after it is dropped.
REACH = 4
HISTORY = 8  # places of one identifier that are remembered: half of what Counter can tell apart


PLACES = (
    "TauIndex",
    "Kind",
    "MonitorIndex",
    "ChangeItem",
    "FloorKind",
)  # which of the frames of a message in one result
DIGEST_START, DIGEST_FACTOR = 0x811C9DC5, 0x01000193  # FNV-1a


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = ((byte << 1) ^ CRC_POLYNOMIAL) & 0xFF if byte & 0x80 else byte << 1
        table.append(byte)
    return table


CRC_TABLE = _crc_table()


def crc(identifier: int, data: bytes) -> int:
    """CRC-8/SAE-J1850 of identifier (low byte, high byte) and data from byte 1 on."""
    value = CRC_TABLE[CRC_TABLE[0xFF ^ identifier & 0xFF] ^ identifier >> 8]
    for byte in data[1:]:
        value = CRC_TABLE[value ^ byte]
    return value ^ 0xFF


def digest(identifier: int, data: bytes) -> int:
    """FNV-1a of the bytes that Crc covers."""
    value = DIGEST_START
    for byte in (identifier & 0xFF, identifier >> 8, *data[1:]):
        value = (value ^ byte) * DIGEST_FACTOR % 2**32
    return value


@dataclass
class Faults:
    """What a receiver met. Only `good` frames are passed on."""

    good: int = 0
    foreign: int = 0  # not of davar; no fault
    corrupted: int = 0  # length or Crc is wrong, or a value that the DBC does not know
    repeated: int = 0  # the same frame again
    swapped: int = 0  # came after its successor (good, and passed on)
    missing: int = 0  # never came, by Counter
    missing_results: int = 0  # whole multiples of 16 results that Counter cannot see, by Epoch
    # Good frames whose result has no State (lost or too late, or Result is damaged), or another
    # frame for their place.
    orphaned: int = 0
    noise: int = 0  # lines of the serial link that are no frames
    link_lost: int = 0  # times interface or serial line went away
    link_restored: int = 0  # times it came back
    impossible: int = 0  # the Crc is right, and a value is none that a sender means: damage
    incomplete_results: int = 0  # not passed on: a frame is lost, too late, or another result's
    late_results: int = 0  # not passed on: complete after a newer one of the same run had been
    doubtful_samples: int = (
        0  # raw ones that were not passed on: of which run they are was not told in time
    )
    restarts: int = 0  # of a sender; no fault

    def total(self) -> int:
        return (
            self.corrupted
            + self.repeated
            + self.swapped
            + self.missing
            + self.missing_results
            + self.orphaned
            + self.noise
            + self.impossible
            + self.incomplete_results
            + self.late_results
            + self.doubtful_samples
        )


class Sequence:
    """The frames of one identifier: says of each whether it is new, repeated, late, or came after a
    hole."""

    def __init__(self) -> None:
        self.last: int | None = None
        self.at = 0  # where the newest one stands, not modulo 16
        self.missing = 0
        self.seen: dict[int, bytes] = {}  # where -> data, of the newest HISTORY places
        # Counters that did not come yet -> how many frames ago they were due.
        self.holes: dict[int, int] = {}

    def again(self, counter: int, data: bytes) -> bool:
        """Has this frame come a moment ago?"""
        return self.last is not None and self.seen.get(self.at - (self.last - counter) % 16) == data

    def late(self, counter: int) -> int:
        """How many frames ago this one was due, if its place is still empty; otherwise 0."""
        back = (self.last - counter) % 16 if self.last is not None else 0
        return back if counter in self.holes and back < 8 else 0

    def judge(self, counter: int, data: bytes) -> tuple[str, int]:
        """Returns (kind, missing): kind is "good", "repeated" or "swapped"; missing is added to the
        count (-1: found)."""
        if self.last is None:
            return self._accept(counter, data, 0)
        if self.again(counter, data):
            return "repeated", 0
        if self.late(counter):
            del self.holes[counter]
            self.seen[self.at - (self.last - counter) % 16] = data
            return "swapped", -1
        missing = (counter - self.last - 1) % 16  # the same counter with other data: 15 were lost
        return self._accept(counter, data, missing)

    def _accept(self, counter: int, data: bytes, missing: int) -> tuple[str, int]:
        self.holes = {hole: age + 1 for hole, age in self.holes.items() if age < 7 and missing < 8}
        for back in range(1, missing + 1):
            self.holes[(counter - back) % 16] = back
        self.holes.pop(counter, None)
        self.last = counter
        self.at += missing + 1
        self.seen[self.at] = data
        self.seen = {where: one for where, one in self.seen.items() if where > self.at - HISTORY}
        return "good", missing


Signals = dict[str, Any]  # of a frame, by the names of the DBC
Joined = tuple[str, int, bytes, Signals]  # a frame: message, identifier, data, signals


class Setup(TypedDict, total=False):
    """What DAVAR_Setup reports about a channel."""

    rate_hz: float
    stride: int
    unit_per_count: float


@dataclass
class Result:
    """One epoch of one channel: values of the frames of one result, all of them. Absent values are
    NaN."""

    channel: int
    tag: int
    epoch: int
    values: dict[str, Any] = field(default_factory=dict)  # column -> number
    adev: dict[int, float] = field(default_factory=dict)  # TauIndex -> deg/s
    # TauIndex -> half the 95 % interval over the deviation; infinite: more than can be sent.
    uncertainty: dict[int, float] = field(default_factory=dict)
    # TauIndex -> standard deviations from the error model.
    deviation: dict[int, float] = field(default_factory=dict)
    # Of its channel: the runs of the sender that were seen. (channel, stretch, epoch) comes once.
    stretch: int = 1
    of: "Channel | None" = None  # the Channel as it was in that stretch

    @property
    def sender(self) -> "Channel":
        """The Channel of a result that a Receiver passed on."""
        assert self.of is not None
        return self.of


class Burst:
    """Frames with one Result as they come in, in any order; the last frame for a place replaces an
    earlier one."""

    def __init__(self, tag: int, born: int, expected: bool) -> None:
        self.tag, self.born = tag, born  # born: how many bursts of the channel began before
        self.expected = expected  # a State came before, so this one should have its own
        self.counted = False  # is its State one that had not come before
        # (message, index) -> (data, signals, digest).
        self.places: dict[tuple[str, str | None], tuple[bytes, Signals, int]] = {}
        self.end: Signals | None = None  # of DAVAR_End
        self.epoch: int | None = None  # of State
        self.digest = 0  # sum over places

    def join(self, name: str, identifier: int, data: bytes, signals: Signals) -> str | None:
        """Takes a frame. Returns the name of the message whose frame it replaced, or None."""
        if name == "End":
            self.end = signals
            return None
        numbers = [str(signals[one]) for one in PLACES if one in signals]
        place = (name, numbers[0] if numbers else None)
        before = self.places.get(place)
        if before and before[0] == data:
            return None
        one = data, signals, digest(identifier, data)
        self.places[place] = one
        self.digest = (self.digest + one[2] - (before[2] if before else 0)) % 2**32
        return name if before else None

    def complete(self) -> bool:
        """Are these all the frames of one result, and no other's?"""
        return (
            self.end is not None
            and self.epoch is not None
            and len(self.places) == self.end["Frames"]
            and self.digest == self.end["Digest"]
        )

    def result(self, index: int, channel: "Channel") -> Result:
        assert self.epoch is not None  # complete() has checked it
        found = Result(index, self.tag, self.epoch, stretch=channel.stretch, of=channel)
        for _, signals, _ in self.places.values():
            for (name, key), value in parts(signals):
                getattr(found, name)[key] = value
        return found


class Channel:
    """What is known about one channel in one run of its sender: the results being joined, its
    setup, its health."""

    def __init__(self, stretch: int = 1) -> None:
        self.stretch = stretch
        self.session: int | None = None
        self.bursts: list[Burst] = []  # results being joined, in the order of their Result
        self.begun = 0  # how many there have been
        # (epoch, digest) of the results that were passed on last.
        self.passed: deque[tuple[int, int]] = deque(maxlen=16)
        self.epoch: int | None = None  # of the newest State
        self.tag: int | None = None
        self.setup: Setup = {}
        self.samples = Samples()
        self.clusters: dict[int, int] = {}  # TauIndex -> samples
        self.health: dict[str, int] = {}  # name -> count

    def burst(self, tag: int) -> Burst | None:
        """The one with this Result, if it is open."""
        for one in self.bursts:  # a generator would report a MemoryError by itself
            if one.tag == tag:
                return one
        return None

    def begin(self, tag: int) -> Burst:
        """A new burst, before those whose Result follows."""
        one = Burst(tag, self.begun, self.tag is not None)
        at = len(self.bursts)
        while at and 0 < (self.bursts[at - 1].tag - tag) % 16 < 8:
            at -= 1
        self.bursts.insert(at, one)
        self.begun += 1
        return one


COLUMNS = {
    "ArwDegPerSqrtH": "arw_deg_per_sqrt_h",
    "ArwRelativeUncertainty": "arw_relative_uncertainty",
    "WindowSamples": "window_samples",
    "Unstable": "unstable",
    "Kurtosis": "kurtosis",
    "Contribution": "contribution",
    "QuantizationDeg": "qn_deg",
    "BiasInstabilityDegPerH": "bi_deg_per_h",
    "RateRandomWalkDegPerHPerSqrtH": "rrw_deg_per_h_per_sqrt_h",
    "RateRampDegPerH2": "rr_deg_per_h2",
    "ModelHealth": "model_health",
    "Alarm": "alarm",
    "Young": "young",
    "CutAge": "cut_age_samples",
    "Dispersion": "dispersion",
    "ChangeClusterSamples": "change_m",
    "ChangeOlderDps": "change_older",
    "ChangeNewerDps": "change_newer",
    "ChangeGain": "change_gain",
    "ArwLowDegPerSqrtH": "arw_low_deg_per_sqrt_h",
    "ArwHighDegPerSqrtH": "arw_high_deg_per_sqrt_h",
    "FloorDegPerSqrtH": "floor_deg_per_sqrt_h",
    "FloorLowDegPerSqrtH": "floor_low_deg_per_sqrt_h",
    "FloorHighDegPerSqrtH": "floor_high_deg_per_sqrt_h",
}

# The names of values in the DBC; the uncertainty of an absent ARW names the reason.
NAMED = {"absent": math.nan, "beyond": math.inf, **dict.fromkeys(REASONS, math.nan)}

ABOVE_ZERO = ("WindowSamples", "RateHz", "Stride", "ClusterSamples", "UnitPerCount")
SIGNED = ("ModelDeviation", "RateDps")


def database_of(dbc: Path) -> Database:
    found = cantools.database.load_file(dbc)
    assert isinstance(found, Database)  # of CAN, as every DBC
    return found


@functools.cache
def messages_of(dbc: Path) -> dict[int, Message]:
    """Identifier above BASE -> message of a DBC."""
    return {message.frame_id - BASE: message for message in database_of(dbc).messages}


def number(value: Any) -> Any:
    """A signal as a number: of the named values of the DBC, "beyond" becomes infinity, the others
    NaN."""
    return NAMED.get(str(value), value)


def parts(signals: Signals) -> list[tuple[tuple[str, Any], Any]]:
    """The values of a frame: [((field of Result, key), number)]."""
    found: list[tuple[tuple[str, Any], Any]] = [
        (("values", COLUMNS[name]), number(value))
        for name, value in signals.items()
        if name in COLUMNS
    ]
    if signals.get("ChangeClusterSamples") == 0:  # no change was told yet
        found.remove((("values", "change_m"), 0))
    if (reason := str(signals.get("ArwRelativeUncertainty"))) in REASONS:
        found.append((("values", "arw_withheld"), reason))
    if "FloorWhy" in signals:
        found.append((("values", "floor_why"), signals["FloorWhy"].value))
    if "AdevDps" in signals:
        index = signals["TauIndex"]
        found.append((("adev", index), signals["AdevDps"]))
        found.append((("uncertainty", index), number(signals["AdevRelativeUncertainty"])))
    if "ModelDeviation" in signals:
        found.append((("deviation", signals["MonitorIndex"]), signals["ModelDeviation"]))
    if "Adev0Dps" in signals:
        found += [(("adev", index), signals[f"Adev{index}Dps"]) for index in range(8)]
    return found


def possible(name: str, value: Any) -> bool:
    """May a sender mean this value of a signal? As davar_decode says."""
    if name in ABOVE_ZERO and not value > 0:
        return False
    if name == "FloorWhy":
        return not isinstance(value, int)  # the DBC names every reason
    if not isinstance(value, float) or value == 0 or value != value:
        return True
    return (
        LEAST <= (abs(value) if name in SIGNED else value) <= MOST
        or value == math.inf
        and "High" in name
    )


class Receiver:
    """Feed frames with push(); it returns a result that is complete, or None. finish() gives the
    rest.

    A result is passed on when all its frames have come, and only then: DAVAR_End has their number
    and a digest over them. It waits for an older one that is not complete until REACH results have
    begun after that one."""

    def __init__(self, base: int = BASE, dbc: Path = DBC_PATH) -> None:
        self.base = base
        self.messages = messages_of(dbc)
        self.faults = Faults()
        self.channels: dict[int, Channel] = {}
        self.sequences: dict[int, Sequence] = {}
        self.ready: deque[Result] = deque()
        self.wants_raw = True  # whoever does not is spared holding them
        # Raw ones that are beyond doubt: (channel's number, Channel, [(index, deg/s)]); whoever
        # wants them takes them.
        self.samples: list[tuple[int, Channel, list[Sample]]] = []

    def check(self, identifier: int, data: bytes) -> str:
        """Judges a frame: "foreign", "corrupted", "repeated", "swapped" or "good"; counts it."""
        kind = self._sound(identifier, data)
        return self._count(kind) if kind else self._judge(identifier, data)

    def push(self, identifier: int, data: bytes) -> Result | None:
        """Takes one frame (data: bytes)."""
        kind = self._sound(identifier, data)
        signals: Signals = {}
        if not kind:
            kind, signals = self._decoded(identifier, data)
        if kind:
            self._count(kind)
        else:
            self._take(identifier, data, signals)
        return self.ready.popleft() if self.ready else None

    def finish(self) -> list[Result]:
        """The complete results that waited for older ones."""
        for index in list(self.channels):
            self._settle(index, reach=0)
            channel = self.channels[index]
            if channel.samples.sure():
                self._release_samples(index, channel, last=True)
            self.faults.doubtful_samples += channel.samples.drop()
        left, self.ready = list(self.ready), deque()
        return left

    def _message(self, identifier: int) -> Message | None:
        return (
            self.messages.get((identifier - self.base) % STEP) if identifier >= self.base else None
        )

    def _sound(self, identifier: int, data: bytes) -> str | None:
        """What is wrong with a frame as it stands, if anything."""
        message = self._message(identifier)
        if message is None:
            return "foreign"
        return (
            "corrupted" if len(data) != message.length or data[0] != crc(identifier, data) else None
        )

    def _decoded(self, identifier: int, data: bytes) -> tuple[str | None, Signals]:
        """(what is wrong with its values, if anything; its signals)."""
        message = self._message(identifier)
        assert message is not None  # _sound() has found it
        try:
            signals = cast(Signals, message.decode(data))
        except Error:
            return "corrupted", {}
        return None if all(
            possible(name, value) for name, value in signals.items()
        ) else "impossible", signals

    def _count(self, kind: str) -> str:
        setattr(self.faults, kind, getattr(self.faults, kind) + 1)
        return kind

    def _judge(self, identifier: int, data: bytes) -> str:
        """A sound frame among those of its identifier."""
        sequence = self.sequences.setdefault(identifier, Sequence())
        kind, missing = sequence.judge(data[1] & 15, data)
        self.faults.missing += missing
        sequence.missing += missing
        self.faults.good += kind in ("good", "swapped")
        return kind if kind == "good" else self._count(kind)

    def _take(self, identifier: int, data: bytes, signals: Signals) -> None:
        index, offset = divmod(identifier - self.base, STEP)
        name = self.messages[offset].name.removeprefix("DAVAR_")
        channel = self.channels.setdefault(index, Channel())
        if "Session" in signals and channel.session not in (None, signals["Session"]):
            channel = self._restart(index, signals["Session"])
        if name in ("State", "ResultFd"):
            epoch = self._epoch(index, identifier, data, signals)
            channel = self.channels[index]
        repeated = self._judge(identifier, data) == "repeated"
        if "Session" in signals:
            channel.session = signals["Session"]
        if name == "Raw":
            if not repeated and self.wants_raw:
                self.faults.doubtful_samples += channel.samples.take(signals)
        elif name in ("Health", "Setup"):
            if not repeated:
                self._tell(index, channel, name, signals)
        elif name in ("State", "ResultFd"):
            self._begin(channel, epoch, repeated, (name, identifier, data, signals))
        else:
            self._join(channel, signals["Result"], repeated, (name, identifier, data, signals))
        self._settle(index)

    def _tell(self, index: int, channel: Channel, name: str, signals: Signals) -> None:
        """What Health and Setup say."""
        if name == "Health":
            item = str(signals["HealthIndex"])
            channel.health[item] = signals[item]
        else:
            self._set_up(channel, signals)
        self._release_samples(index, channel)

    def _join(self, channel: Channel, tag: int, repeated: bool, frame: Joined) -> None:
        """A frame of a result. One that came before begins no result."""
        burst = channel.burst(tag) or (None if repeated else channel.begin(tag))
        if burst and burst.join(*frame):
            self.faults.orphaned += 1  # the one that was there

    def _begin(self, channel: Channel, epoch: int, repeated: bool, frame: Joined) -> None:
        """A State: it begins a result, unless frames of it came first."""
        tag = frame[-1]["Counter"]
        burst = channel.burst(tag) or channel.begin(tag)
        if burst.join(*frame):
            self.faults.incomplete_results += burst.counted
            burst.born, channel.begun = channel.begun, channel.begun + 1
        burst.epoch, burst.counted = epoch, burst.counted or not repeated
        channel.samples.dated = True

    def _epoch(self, index: int, identifier: int, data: bytes, signals: Signals) -> int:
        """The whole Epoch of a State. One that falls back, and is not late, is of a sender that was
        restarted."""
        modulus = 2**32 if len(data) == 8 else 2**24
        tag, low = signals["Counter"], signals["Epoch"]
        channel, sequence = self.channels[index], self.sequences.setdefault(identifier, Sequence())
        ahead = 0 if channel.epoch is None else (low - channel.epoch) % modulus
        back = (modulus - ahead) % modulus
        if channel.epoch is not None and (not ahead or back < ahead):
            late = sequence.late(tag)
            stride = channel.setup.get("stride")
            if (
                sequence.again(tag, data)
                or late
                and (not stride or back % stride == 0 and back >= late * stride)
            ):
                return channel.epoch - back
            channel = self._restart(index)
            ahead = 0
        self._check_epoch(channel, ahead, tag)
        channel.epoch = low if channel.epoch is None else channel.epoch + ahead
        channel.tag = tag
        return channel.epoch

    def _restart(self, index: int, session: int | None = None) -> Channel:
        """The sender of a channel has been restarted: a new stretch, in which nothing is known.
        What is not complete may be of either run: frames that no session and no State has told to
        be old are kept."""
        old = self.channels[index]
        kept = [
            one
            for one in old.bursts
            if not one.complete() and not one.end and (session is not None or one.epoch is None)
        ]
        old.bursts = [one for one in old.bursts if one not in kept]
        self._settle(index, reach=0)
        self.faults.restarts += 1
        for identifier in [one for one in self.sequences if (one - self.base) // STEP == index]:
            self.sequences[identifier] = Sequence()
        self.channels[index] = channel = Channel(old.stretch + 1)
        channel.bursts, channel.begun = kept, old.begun
        for one in sorted((one for one in kept if one.epoch is not None), key=lambda one: one.born):
            channel.epoch, channel.tag = one.epoch, one.tag
        given_up, channel.samples = old.samples.split()
        self.faults.doubtful_samples += given_up
        return channel

    def _settle(self, index: int, reach: int = REACH) -> None:
        """Passes on complete results in their order, and drops what is not complete and too old."""
        channel = self.channels[index]
        while channel.bursts:
            first = channel.bursts[0]
            if not first.complete() and channel.begun - first.born <= reach and reach:
                return
            del channel.bursts[0]
            if first.complete():
                channel = self._pass_on(index, channel, first)
            elif first.counted:
                self.faults.incomplete_results += 1
            elif first.epoch is None and first.expected:
                self.faults.orphaned += len(first.places) + bool(first.end)

    def _pass_on(self, index: int, channel: Channel, burst: Burst) -> Channel:
        """A complete result: new, there already, too late, or of a sender that was restarted behind
        a State that looked the same."""
        assert burst.epoch is not None and burst.end is not None  # it is complete
        epochs = dict(channel.passed)
        if epochs and burst.epoch <= max(epochs):
            if epochs.get(burst.epoch) == burst.digest:
                return channel
            if burst.epoch not in epochs:
                self.faults.late_results += 1
                return channel
            rest, channel.bursts = channel.bursts, []
            channel = self._restart(index, channel.session)
            channel.session, channel.epoch, channel.tag, channel.bursts = (
                burst.end["Session"],
                burst.epoch,
                burst.tag,
                rest,
            )
        channel.passed.append((burst.epoch, burst.digest))
        self.ready.append(burst.result(index, channel))
        return channel

    def _release_samples(self, index: int, channel: Channel, last: bool = False) -> None:
        """Raw samples whose run, place and size are known now."""
        if (
            channel.samples.dated
            and channel.epoch is not None
            and {"rate_hz", "unit_per_count"} <= set(channel.setup)
            and channel.samples.held
        ):
            found, left_out = channel.samples.release(
                channel.epoch, written(channel.setup["unit_per_count"]), last
            )
            self.samples.append((index, channel, found))
            self.faults.doubtful_samples += left_out

    def _check_epoch(self, channel: Channel, ahead: int, tag: int) -> None:
        """A multiple of 16 results lost leaves no hole in Counter: Epoch shows it, once the step
        between results is known."""
        if channel.epoch is None or channel.tag is None:
            return
        stride = channel.setup.get("stride")
        if stride:
            passed, rest = divmod(ahead, stride)
            by_counter = (tag - channel.tag - 1) % 16 + 1
            if rest == 0 and passed > by_counter and (passed - by_counter) % 16 == 0:
                self.faults.missing_results += passed - by_counter

    @staticmethod
    def _set_up(channel: Channel, signals: Signals) -> None:
        if "RateHz" in signals:
            channel.setup["rate_hz"] = signals["RateHz"]
        elif "Stride" in signals:
            channel.setup["stride"] = signals["Stride"]
        elif "UnitPerCount" in signals:
            channel.setup["unit_per_count"] = signals["UnitPerCount"]
        else:
            channel.clusters[signals["Item"] - 32] = signals["ClusterSamples"]
