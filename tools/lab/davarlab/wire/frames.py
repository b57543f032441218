"""Frames of davar (lib/WIRE.md) to results: checks every frame, counts what is wrong, joins frames to results.

Decoding is cantools with tools/davar.dbc; transports are in davarlab.source.
"""

import math
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

import cantools

DBC_PATH = Path(__file__).resolve().parents[3] / "davar.dbc"
BASE, STEP = 0x5D0, 16
CRC_POLYNOMIAL = 0x1D
HISTORY = 15  # frames of one identifier that are remembered: one less than Counter can tell apart


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

    def total(self):
        return (self.corrupted + self.repeated + self.swapped + self.missing + self.missing_results + self.orphaned
                + self.noise)


class Sequence:
    """The frames of one identifier: says of each whether it is new, repeated, late, or came after a hole."""

    def __init__(self):
        self.last = None
        self.missing = 0
        self.seen = deque(maxlen=HISTORY)  # (counter, data), newest last
        self.holes = {}  # counters that did not come yet -> how many frames ago they were due

    def judge(self, counter, data):
        """Returns (kind, missing): kind is "good", "repeated" or "swapped"; missing is added to the count (-1: found)."""
        if self.last is None:
            return self._accept(counter, data, 0)
        if (counter, data) in self.seen:
            return "repeated", 0
        step = (counter - self.last) % 16
        if counter in self.holes and step > 8:
            del self.holes[counter]
            self.seen.append((counter, data))
            return "swapped", -1
        missing = (step - 1) % 16  # a step of 0 with other data: 15 were lost
        return self._accept(counter, data, missing)

    def _accept(self, counter, data, missing):
        self.holes = {hole: age + 1 for hole, age in self.holes.items() if age < 7 and missing < 8}
        for back in range(1, missing + 1):
            self.holes[(counter - back) % 16] = back
        self.holes.pop(counter, None)
        self.last = counter
        self.seen.append((counter, data))
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


class Channel:
    """What is known about one channel: the result being joined, its setup, its health."""

    def __init__(self):
        self.result = None
        self.epoch = None
        self.setup = {}  # "rate_hz", "stride"
        self.clusters = {}  # TauIndex -> samples
        self.health = {}  # name -> count


COLUMNS = {
    "ArwDegPerSqrtH": "arw_deg_per_sqrt_h", "ArwRelativeUncertainty": "arw_relative_uncertainty",
    "WindowSamples": "window_samples", "Unstable": "unstable", "Kurtosis": "kurtosis", "Contribution": "contribution",
    "QuantizationDeg": "qn_deg", "BiasInstabilityDegPerH": "bi_deg_per_h",
    "RateRandomWalkDegPerHPerSqrtH": "rrw_deg_per_h_per_sqrt_h", "RateRampDegPerH2": "rr_deg_per_h2",
    "ModelHealth": "model_health",
    "ArwLowDegPerSqrtH": "arw_low_deg_per_sqrt_h", "ArwHighDegPerSqrtH": "arw_high_deg_per_sqrt_h",
}


def number(value):
    """A signal as a number: the named values of the DBC, "absent" and "beyond", become NaN and infinity."""
    return {"absent": math.nan, "beyond": math.inf}.get(str(value), value)


class Receiver:
    """Feed frames with push(); it returns the result that this frame completed, or None. finish() gives the rest."""

    def __init__(self, base=BASE, dbc=DBC_PATH):
        self.base = base
        self.messages = {message.frame_id - BASE: message for message in cantools.database.load_file(dbc).messages}
        self.faults = Faults()
        self.channels = {}
        self.sequences = {}

    def check(self, identifier, data):
        """Judges a frame: "foreign", "corrupted", "repeated", "swapped" or "good"; counts it."""
        message = self.messages.get((identifier - self.base) % STEP) if identifier >= self.base else None
        if message is None:
            kind = "foreign"
        elif len(data) != message.length or data[0] != crc(identifier, data):
            kind = "corrupted"
        else:
            kind, missing = self.sequences.setdefault(identifier, Sequence()).judge(data[1] & 15, data)
            self.faults.missing += missing
            self.sequences[identifier].missing += missing
            self.faults.good += kind in ("good", "swapped")
        if kind != "good":
            setattr(self.faults, kind, getattr(self.faults, kind) + 1)
        return kind

    def push(self, identifier, data):
        """Takes one frame (data: bytes)."""
        if self.check(identifier, data) not in ("good", "swapped"):
            return None
        offset = identifier - self.base
        message = self.messages[offset % STEP]
        try:
            signals = message.decode(data)
        except cantools.database.Error:
            self.faults.good -= 1
            self.faults.corrupted += 1
            return None
        return self._take(offset // STEP, message.name.removeprefix("DAVAR_"), signals)

    def finish(self):
        """The results that no later frame completed."""
        left = [channel.result for channel in self.channels.values() if channel.result]
        for channel in self.channels.values():
            channel.result = None
        return left

    def _take(self, index, name, signals):
        channel = self.channels.setdefault(index, Channel())
        if name in ("State", "ResultFd"):
            done = channel.result
            self._begin(channel, index, signals, 2 ** 32 if name == "State" else 2 ** 24)
            return done
        if name == "Health":
            item = str(signals["HealthIndex"])
            channel.health[item] = signals[item]
        elif name == "Setup":
            self._set_up(channel, signals)
        elif channel.result and channel.result.tag == signals["Result"]:
            self._add(channel.result, signals)
        elif channel.result:
            self.faults.orphaned += 1
        return None

    def _begin(self, channel, index, signals, modulus):
        tag, low = signals["Counter"], signals["Epoch"]
        step = 0 if channel.epoch is None else (low - channel.epoch) % modulus
        if step > modulus // 2:
            return  # a late State, swapped with a newer one: its result is history
        epoch = low if channel.epoch is None else channel.epoch + step
        self._check_epoch(channel, epoch, tag)
        channel.epoch = epoch
        channel.result = Result(index, tag, epoch)
        self._add(channel.result, signals)

    def _check_epoch(self, channel, epoch, tag):
        """A multiple of 16 results lost leaves no hole in Counter: Epoch shows it, once the stride is known."""
        stride = channel.setup.get("stride")
        if stride and channel.result:
            passed, rest = divmod(epoch - channel.epoch, stride)
            by_counter = (tag - channel.result.tag - 1) % 16 + 1
            if rest == 0 and passed > by_counter and (passed - by_counter) % 16 == 0:
                self.faults.missing_results += passed - by_counter

    @staticmethod
    def _set_up(channel, signals):
        if "RateHz" in signals:
            channel.setup["rate_hz"] = signals["RateHz"]
        elif "Stride" in signals:
            channel.setup["stride"] = signals["Stride"]
        else:
            channel.clusters[signals["Item"] - 32] = signals["ClusterSamples"]

    @staticmethod
    def _add(result, signals):
        if "AdevDps" in signals:
            result.adev[signals["TauIndex"]] = signals["AdevDps"]
        if "ModelDeviation" in signals:
            result.deviation[signals["MonitorIndex"]] = signals["ModelDeviation"]
        if "Adev0Dps" in signals:
            result.adev.update({t: signals[f"Adev{t}Dps"] for t in range(8)})
        for name, column in COLUMNS.items():
            if name in signals:
                result.values[column] = number(signals[name])
