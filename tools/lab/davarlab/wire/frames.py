"""Frames of davar (lib/WIRE.md) to results: checks every frame, counts what is wrong, joins frames to results.

Decoding is cantools with tools/davar.dbc; transports are in davarlab.source.
"""

import functools
import math
from collections import deque
from dataclasses import dataclass, field

import cantools

from .. import places
from .raw import Samples, written

DBC_PATH = places.shared("tools/davar.dbc")
BASE, STEP = 0x5D0, 16
CRC_POLYNOMIAL = 0x1D
LEAST, MOST = 1e-30, 1e30  # magnitude of a float but 0, as in davar/codec.h
HELD_MAX = 64  # results of a channel that wait for a frame with the session; a sender sends one with each
HISTORY = 8  # places of one identifier that are remembered: half of what Counter can tell apart


def _crc_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = ((byte << 1) ^ CRC_POLYNOMIAL) & 0xFF if byte & 0x80 else byte << 1
        table.append(byte)
    return table


CRC_TABLE = _crc_table()


def crc(identifier, data):
    """CRC-8/SAE-J1850 of identifier (low byte, high byte) and data from byte 1 on."""
    value = CRC_TABLE[CRC_TABLE[0xFF ^ identifier & 0xFF] ^ identifier >> 8]
    for byte in data[1:]:
        value = CRC_TABLE[value ^ byte]
    return value ^ 0xFF


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
    orphaned: int = 0  # good frames whose Result is not the present one: its State is lost or late, or Result is damaged
    noise: int = 0  # lines of the serial link that are no frames
    link_lost: int = 0  # times interface or serial line went away
    link_back: int = 0  # times it came back
    impossible: int = 0  # the Crc is right, and a value is none that a sender means: damage
    doubtful_results: int = 0  # not passed on: frames of another run of the sender, or of 16 results later, may be in them
    doubtful_samples: int = 0  # raw ones that were not passed on: of which run they are was not told in time
    restarts: int = 0  # of a sender; no fault

    def total(self):
        return (self.corrupted + self.repeated + self.swapped + self.missing + self.missing_results + self.orphaned
                + self.noise + self.impossible + self.doubtful_results + self.doubtful_samples)


class Sequence:
    """The frames of one identifier: says of each whether it is new, repeated, late, or came after a hole."""

    def __init__(self):
        self.last = None
        self.at = 0  # where the newest one stands, not modulo 16
        self.missing = 0
        self.came = None  # the one that came last: (counter, data)
        self.seen = {}  # where -> data, of the newest HISTORY places
        self.holes = {}  # counters that did not come yet -> how many frames ago they were due

    def again(self, counter, data):
        """Is this the frame that came last?"""
        return self.came == (counter, data)

    def late(self, counter):
        """How many frames ago this one was due, if its place is still empty; otherwise 0."""
        back = (self.last - counter) % 16 if self.last is not None else 0
        return back if counter in self.holes and back < 8 else 0

    def judge(self, counter, data):
        """Returns (kind, missing): kind is "good", "repeated" or "swapped"; missing is added to the count (-1: found)."""
        self.came = counter, data
        if self.last is None:
            return self._accept(counter, data, 0)
        if self.seen.get(self.at - (self.last - counter) % 16) == data:
            return "repeated", 0
        if self.late(counter):
            del self.holes[counter]
            self.seen[self.at - (self.last - counter) % 16] = data
            return "swapped", -1
        missing = (counter - self.last - 1) % 16  # the same counter with other data: 15 were lost
        return self._accept(counter, data, missing)

    def _accept(self, counter, data, missing):
        self.holes = {hole: age + 1 for hole, age in self.holes.items() if age < 7 and missing < 8}
        for back in range(1, missing + 1):
            self.holes[(counter - back) % 16] = back
        self.holes.pop(counter, None)
        self.last = counter
        self.at += missing + 1
        self.seen[self.at] = data
        self.seen = {where: one for where, one in self.seen.items() if where > self.at - HISTORY}
        return "good", missing


@dataclass
class Result:
    """One epoch of one channel, as far as its frames came. Absent values are NaN."""

    channel: int
    tag: int
    epoch: int
    values: dict = field(default_factory=dict)  # column -> number
    adev: dict = field(default_factory=dict)  # TauIndex -> deg/s
    deviation: dict = field(default_factory=dict)  # TauIndex -> standard deviations from the error model
    stretch: int = 1  # of its channel: the runs of the sender that were seen. (channel, stretch, epoch) comes once.
    of: object = None  # the Channel as it was in that stretch
    joined: dict = field(default_factory=dict)  # (field, key) -> number, of frames that none with the session has followed
    frames: int = 0  # of joined

    def join(self, found):
        """Takes the values of a frame; False: there is another value for one of them already."""
        if any(repr(known) != repr(value) for at, value in found for known in self._known(at)):
            return False
        self.joined.update(found)
        self.frames += 1
        return True

    def vouch(self):
        """What was joined is of this run of the sender."""
        for (name, key), value in self.joined.items():
            getattr(self, name)[key] = value
        self.joined, self.frames = {}, 0

    def _known(self, at):
        name, key = at
        return [one[where] for one, where in ((self.joined, at), (getattr(self, name), key)) if where in one]


class Channel:
    """What is known about one channel in one run of its sender: the result being joined, its setup, its health."""

    def __init__(self, stretch=1):
        self.stretch = stretch
        self.session = None
        self.result = None
        self.held = []  # results that are over and wait for a frame with the session
        self.epoch = None
        self.tag = None  # of the newest State
        self.step = None  # between epochs: Stride, or the smallest seen
        self.setup = {}  # "rate_hz", "stride", "unit_per_count"
        self.samples = Samples()
        self.clusters = {}  # TauIndex -> samples
        self.health = {}  # name -> count


COLUMNS = {
    "ArwDegPerSqrtH": "arw_deg_per_sqrt_h", "ArwRelativeUncertainty": "arw_relative_uncertainty",
    "WindowSamples": "window_samples", "Unstable": "unstable", "Kurtosis": "kurtosis", "Contribution": "contribution",
    "QuantizationDeg": "qn_deg", "BiasInstabilityDegPerH": "bi_deg_per_h",
    "RateRandomWalkDegPerHPerSqrtH": "rrw_deg_per_h_per_sqrt_h", "RateRampDegPerH2": "rr_deg_per_h2",
    "ModelHealth": "model_health",
    "Alarm": "alarm", "Young": "young", "CutAge": "cut_age_samples", "Dispersion": "dispersion", "ChangeClusterSamples": "change_m",
    "ChangeOlderDps": "change_older", "ChangeNewerDps": "change_newer", "ChangeGain": "change_gain",
    "ArwLowDegPerSqrtH": "arw_low_deg_per_sqrt_h", "ArwHighDegPerSqrtH": "arw_high_deg_per_sqrt_h",
}

ABOVE_ZERO = ("WindowSamples", "RateHz", "Stride", "ClusterSamples", "UnitPerCount")
SIGNED = ("ModelDeviation", "RateDps")


@functools.cache
def messages_of(dbc):
    """Identifier above BASE -> message of a DBC."""
    return {message.frame_id - BASE: message for message in cantools.database.load_file(dbc).messages}


def number(value):
    """A signal as a number: the named values of the DBC, "absent" and "beyond", become NaN and infinity."""
    return {"absent": math.nan, "beyond": math.inf}.get(str(value), value)


def parts(signals):
    """The values of a frame: [((field of Result, key), number)]."""
    found = [(("values", COLUMNS[name]), number(value)) for name, value in signals.items() if name in COLUMNS]
    if signals.get("ChangeClusterSamples") == 0:  # no change was told yet
        found.remove((("values", "change_m"), 0))
    if "AdevDps" in signals:
        found.append((("adev", signals["TauIndex"]), signals["AdevDps"]))
    if "ModelDeviation" in signals:
        found.append((("deviation", signals["MonitorIndex"]), signals["ModelDeviation"]))
    if "Adev0Dps" in signals:
        found += [(("adev", index), signals[f"Adev{index}Dps"]) for index in range(8)]
    return found


def possible(name, value):
    """May a sender mean this value of a signal? As davar_decode says."""
    if name in ABOVE_ZERO and not value > 0:
        return False
    if not isinstance(value, float) or value == 0 or value != value:
        return True
    return LEAST <= (abs(value) if name in SIGNED else value) <= MOST or value == math.inf and "High" in name


class Receiver:
    """Feed frames with push(); it returns a result that is complete, or None. finish() gives the rest.

    A result is passed on when its successor has begun and a frame that tells the session (DAVAR_Health, DAVAR_Setup) has
    followed its frames: otherwise they might be of a sender that has been restarted since, and whose State was lost."""

    def __init__(self, base=BASE, dbc=DBC_PATH):
        self.base = base
        self.messages = messages_of(dbc)
        self.faults = Faults()
        self.channels = {}
        self.sequences = {}
        self.ready = deque()
        self.wants_raw = True  # whoever does not is spared holding them
        self.samples = []  # raw ones that are beyond doubt: (channel's number, Channel, [(index, deg/s)]); whoever wants them takes them

    def check(self, identifier, data):
        """Judges a frame: "foreign", "corrupted", "repeated", "swapped" or "good"; counts it."""
        kind = self._sound(identifier, data)
        return self._count(kind) if kind else self._judge(identifier, data)

    def push(self, identifier, data):
        """Takes one frame (data: bytes)."""
        kind, signals = self._sound(identifier, data), None
        if not kind:
            kind, signals = self._decoded(identifier, data)
        if kind:
            self._count(kind)
        else:
            self._take(identifier, data, signals)
        return self.ready.popleft() if self.ready else None

    def finish(self):
        """The results that no later frame completed, as far as they are beyond doubt."""
        for index, channel in self.channels.items():
            self._close(channel)
            self._release(channel)
            if channel.samples.sure():
                self._release_samples(index, channel, last=True)
            self.faults.doubtful_samples += channel.samples.drop()
        left, self.ready = list(self.ready), deque()
        return left

    def _message(self, identifier):
        return self.messages.get((identifier - self.base) % STEP) if identifier >= self.base else None

    def _sound(self, identifier, data):
        """What is wrong with a frame as it stands, if anything."""
        message = self._message(identifier)
        if message is None:
            return "foreign"
        return "corrupted" if len(data) != message.length or data[0] != crc(identifier, data) else None

    def _decoded(self, identifier, data):
        """(what is wrong with its values, if anything; its signals)."""
        message = self._message(identifier)
        try:
            signals = message.decode(data)
        except cantools.database.Error:
            return "corrupted", None
        return None if all(possible(name, value) for name, value in signals.items()) else "impossible", signals

    def _count(self, kind):
        setattr(self.faults, kind, getattr(self.faults, kind) + 1)
        return kind

    def _judge(self, identifier, data):
        """A sound frame among those of its identifier."""
        sequence = self.sequences.setdefault(identifier, Sequence())
        kind, missing = sequence.judge(data[1] & 15, data)
        self.faults.missing += missing
        sequence.missing += missing
        self.faults.good += kind in ("good", "swapped")
        return kind if kind == "good" else self._count(kind)

    def _take(self, identifier, data, signals):
        index, offset = divmod(identifier - self.base, STEP)
        name = self.messages[offset].name.removeprefix("DAVAR_")
        channel = self.channels.setdefault(index, Channel())
        if name in ("State", "ResultFd"):
            self._take_state(channel, index, identifier, data, signals)
            return
        if name in ("Health", "Setup") and channel.session not in (None, signals["Session"]):
            channel = self._restart(index)
        if self._judge(identifier, data) == "repeated":
            return
        if name == "Raw" and not self.wants_raw:
            return
        if name == "Raw":
            self.faults.doubtful_samples += channel.samples.take(signals)
        elif name in ("Health", "Setup"):
            self._tell(channel, name, signals)
            self._release_samples(index, channel)
        elif channel.result and channel.result.tag == signals["Result"]:
            self.faults.orphaned += not channel.result.join(parts(signals))
        elif channel.result:
            self.faults.orphaned += 1

    def _tell(self, channel, name, signals):
        """Session, and what else Health and Setup say."""
        channel.session = signals["Session"]
        for result in [*channel.held, *([channel.result] if channel.result else [])]:
            result.vouch()
        self._release(channel)
        if name == "Health":
            item = str(signals["HealthIndex"])
            channel.health[item] = signals[item]
        else:
            self._set_up(channel, signals)

    def _take_state(self, channel, index, identifier, data, signals):
        modulus = 2 ** 32 if len(data) == 8 else 2 ** 24
        tag, low = signals["Counter"], signals["Epoch"]
        sequence = self.sequences.setdefault(identifier, Sequence())
        ahead = 0 if channel.epoch is None else (low - channel.epoch) % modulus
        back = (modulus - ahead) % modulus
        told = channel.result and channel.result.values  # what comes again behind a frame with the session is no repetition
        if sequence.again(tag, data) and not told:
            self._judge(identifier, data)
            self._begin_again(channel, tag, signals)
            return
        if channel.epoch is not None and (not ahead or back < ahead):
            late = sequence.late(tag)
            if late and (channel.step is None or back % channel.step == 0 and back >= late * channel.step):
                self._judge(identifier, data)
                return  # swapped with a newer one: its result is history
            channel = self._restart(index)
            ahead = 0
        self._judge(identifier, data)
        self._check_epoch(channel, ahead, tag)
        self._close(channel)
        channel.epoch = low if channel.epoch is None else channel.epoch + ahead
        channel.tag = tag
        channel.result = Result(index, tag, channel.epoch, stretch=channel.stretch, of=channel)
        channel.result.join(parts(signals))
        channel.samples.dated = True

    def _begin_again(self, channel, tag, signals):
        """The newest State once more: a repetition, or that of a sender that was restarted behind it. What was joined meanwhile
        may be of either."""
        result = channel.result
        if result and result.tag == tag:
            self.faults.orphaned += result.frames - 1
            result.joined, result.frames = dict(parts(signals)), 1

    def _restart(self, index):
        """The sender of a channel has been restarted: a new stretch, in which nothing is known."""
        old = self.channels[index]
        self._close(old)
        self._release(old)
        self.faults.restarts += 1
        for identifier in [one for one in self.sequences if (one - self.base) // STEP == index]:
            self.sequences[identifier] = Sequence()
        self.channels[index] = Channel(old.stretch + 1)
        given_up, self.channels[index].samples = old.samples.split()
        self.faults.doubtful_samples += given_up
        return self.channels[index]

    def _release_samples(self, index, channel, last=False):
        """Raw samples whose run, place and size are known now."""
        if channel.samples.dated and {"rate_hz", "unit_per_count"} <= set(channel.setup) and channel.samples.held:
            found, left_out = channel.samples.release(channel.epoch, written(channel.setup["unit_per_count"]), last)
            self.samples.append((index, channel, found))
            self.faults.doubtful_samples += left_out

    def _close(self, channel):
        """The result being joined is over."""
        if channel.result and not channel.result.joined:
            self.ready.append(channel.result)
        elif channel.result:
            channel.held.append(channel.result)
            self._release(channel, HELD_MAX)
        channel.result = None

    def _release(self, channel, newest=0):
        """No more can be known of what is held, but for so many: the part that is vouched for is passed on, a result without one is counted."""
        over = max(0, len(channel.held) - newest)
        for result in channel.held[:over]:
            if result.values:
                self.ready.append(result)
            else:
                self.faults.doubtful_results += 1
        del channel.held[:over]

    def _check_epoch(self, channel, ahead, tag):
        """A multiple of 16 results lost leaves no hole in Counter: Epoch shows it, once the step between results is known."""
        if channel.epoch is None:
            return
        if channel.step and channel.result and ahead >= 16 * channel.step:
            channel.result = None  # frames from behind the hole have its tag
            self.faults.doubtful_results += 1
        channel.step = channel.setup.get("stride") or min(channel.step or ahead, ahead)
        stride = channel.setup.get("stride")
        if stride:
            passed, rest = divmod(ahead, stride)
            by_counter = (tag - channel.tag - 1) % 16 + 1
            if rest == 0 and passed > by_counter and (passed - by_counter) % 16 == 0:
                self.faults.missing_results += passed - by_counter

    @staticmethod
    def _set_up(channel, signals):
        if "RateHz" in signals:
            channel.setup["rate_hz"] = signals["RateHz"]
        elif "Stride" in signals:
            channel.step = channel.setup["stride"] = signals["Stride"]
        elif "UnitPerCount" in signals:
            channel.setup["unit_per_count"] = signals["UnitPerCount"]
        else:
            channel.clusters[signals["Item"] - 32] = signals["ClusterSamples"]
