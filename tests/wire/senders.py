"""Senders of frames: the library's own encoder (wire_probe) and the two programs on a serial line.
Also functions that deliver frames wrongly, and a receiver of them.
"""

import functools
import os
import pty
import random
import re
import subprocess
import threading
import time
import tty
from dataclasses import dataclass, field
from pathlib import Path

import cantools
from davar.wire import frames as wire

ROOT = Path(__file__).resolve().parents[2]
PROBE = os.environ.get("DAVAR_WIRE_PROBE", "wire_probe")
NODE, SIM = os.environ.get("DAVAR_NODE", "davar-node"), os.environ.get("DAVAR_SIM", "davar-sim")
STATE, FD, END, SEND_RAW = 1, 8, 11, 32
REASONS = ("mixed", "constant", "coarse", "filtered")  # why ARW is absent


@functools.cache
def dbc():
    return cantools.database.load_file(ROOT / "tools/davar.dbc", strict=True)


def seeded(*words):
    return random.Random(repr(words))


def probe(*words, stdin=None):
    command = [PROBE, *map(str, words)]
    done = subprocess.run(command, input=stdin, text=True, stdout=subprocess.PIPE, check=True)
    return done.stdout.splitlines()


def frame_of(line):
    word = line.split()
    return int(word[1], 16), bytes.fromhex(word[2])


# --- the library's encoder


@dataclass(eq=False)
class Run:
    """One run of a sender: its results in the order of time, each a list of frames (identifier,
    data).
    """

    results: list = field(default_factory=list)


@functools.cache
def run(seed, count, session, stride=100, content=3, first=0, channel=0):
    """A run whose epochs are first + stride - 1, first + 2 stride - 1, ... Its last result holds
    the final counters.
    """
    found = Run()
    for line in probe("run", seed, count, session, stride, content, first, channel):
        if line[0] == "R":
            found.results.append([])
        else:
            found.results[-1].append(frame_of(line))
    return found


def joined(results):
    return [frame for result in results for frame in result]


def frames(one):
    return joined(one.results)


def encoded(samples, channel=0, what="raw"):
    """The library's frames of samples (index, value)."""
    text = "".join(f"{index} {value!r}\n" for index, value in samples)
    return [frame_of(line) for line in probe(what, channel, stdin=text)]


def counts(source, number, first=0, width=16, gaps=0.02):
    """Samples (index, count) of a sensor that loses some."""
    found, index = [], first
    for _ in range(number):
        index += source.choice((1, 3, 700)) if source.random() < gaps else 0
        found.append((index, source.randrange(-1 << width - 1, 1 << width - 1)))
        index += 1
    return found


def held_by(frame):
    """The number of samples in a frame."""
    return 2 if frame[1][1] >> 4 & 3 == 0 else 1


def stream(samples, session=7, stride=100, channel=0, what="raw", first=0):
    """Frames in the order of a sender: a result follows its newest sample. Epochs count the
    received samples from `first`; sample indices also count the lost ones.
    """
    raw, sent, gone = encoded(samples, channel, what), [], 0
    number = len(samples) // stride + 1
    one = run(5, number, session, stride, content=3 | SEND_RAW, first=first, channel=channel)
    for n, burst in enumerate(one.results):
        while (raw and gone < min(stride * (n + 1), len(samples) - 1)) or (raw and n == number):
            gone += held_by(raw[0])
            sent.append(raw.pop(0))
        sent += burst
    return sent


def sealed(identifier, payload, head=0):
    """A frame with its Crc: byte 1 is `head`, the rest is the payload."""
    data = bytes([0, head]) + payload
    return identifier, bytes([wire.crc(identifier, data)]) + data[1:]


# --- wrong delivery


def disturbed(sent, source, rate):
    """Frames with repetitions, swaps and losses, single ones and long ones."""
    out, at = [], 0
    while at < len(sent):
        kind = source.random() if source.random() < rate else 1
        if kind < 0.3:
            out += [sent[at]] * 2
        elif kind < 0.6 and at + 1 < len(sent):
            out += [sent[at + 1], sent[at]]
            at += 1
        elif kind < 1:
            at += source.choice((0, 0, 0, 2, 16, 60, 290))
        else:
            out.append(sent[at])
        at += 1
    return out


def receive(sent):
    """(receiver, the results it found)."""
    receiver, found = wire.Receiver(), []
    for identifier, data in sent:
        result = receiver.push(identifier, data)
        found += [result] if result else []
    return receiver, found + receiver.finish()


def plain(value):
    named = {"absent": "nan", "beyond": "inf", **dict.fromkeys(REASONS, "nan")}
    return named.get(str(value), str(value))


@functools.cache
def truth(one):
    """{epoch: the values of a row, as the DBC reads them in the frames of one result}."""
    said = {}
    for result in one.results[:-1]:
        values, epoch = {}, None
        for identifier, data in result:
            signals = dbc().decode_message((identifier - 0x5D0) % 16 + 0x5D0, data)
            epoch = signals.get("Epoch", epoch)
            for name, value in signals.items():
                if name in wire.COLUMNS:
                    values[wire.COLUMNS[name]] = plain(value)
                    if str(value) in REASONS:
                        values["arw_withheld"] = str(value)
                elif name == "AdevDps":
                    values["adev", signals["TauIndex"]] = plain(value)
                elif name.startswith("Adev") and name.endswith("Dps"):
                    values["adev", int(name[4])] = plain(value)
        said[epoch] = values
    return said


def shown(result):
    """The values of a row, by the same rule."""
    values = {
        name: value if name == "arw_withheld" else plain(value)
        for name, value in result.values.items()
    }
    return values | {("adev", index): plain(value) for index, value in result.adev.items()}


# --- the programs


def raw_pty():
    """(our end, the end of a program, its name)."""
    ours, its = pty.openpty()
    tty.setraw(its)
    return ours, its, os.ttyname(its)


class Line:
    """A serial line whose other end is a program; read() until the program has ended."""

    def __init__(self):
        self.ours, self.its, self.name = raw_pty()
        self.got, self.ended = [], threading.Event()
        self.reader = threading.Thread(target=self._read)
        os.set_blocking(self.ours, False)
        self.reader.start()

    def _read(self):
        while True:
            over = self.ended.is_set()
            try:
                self.got.append(os.read(self.ours, 65536))
            except BlockingIOError:
                if over:
                    return
                self.ended.wait(0.002)

    def close(self):
        """Everything that was sent."""
        self.ended.set()
        self.reader.join()
        os.close(self.its)
        os.close(self.ours)
        return b"".join(self.got)


def slcan(sent):
    """Frames as SLCAN text."""
    return b"".join(
        b"t%03X%d%s\r" % (one, len(data), data.hex().upper().encode()) for one, data in sent
    )


def frames_in(text):
    """Frames of SLCAN text."""
    return [
        (int(line[1:4], 16), bytes.fromhex(line[5:].decode()))
        for line in text.split(b"\r")
        if line[:1] == b"t"
    ]


def on_a_line(program, *words, text="", epochs=()):
    """(frames, standard error) of a program that succeeds. epochs: those of its results. It gets
    the samples of five of them at a time, because davar-node drops frames that the reader of a
    busy machine takes too late. With law glr, the last results wait for later samples.
    """
    line = Line()
    command = [program, *map(str, words), "--out", f"slcan:{line.name}"]
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    process, sent = subprocess.Popen(command, text=True, **pipes), 0
    for number in range(5, len(epochs), 5):
        lines = text.splitlines(keepends=True)
        places = [n for n, one in enumerate(lines) if one != "nan\n"]
        end = places[epochs[number - 1]] + 1
        process.stdin.write("".join(lines[sent:end]))
        process.stdin.flush()
        sent, until = end, time.monotonic() + 0.3
        while b"".join(line.got).count(b"\rt5DB") < number and time.monotonic() < until:
            time.sleep(0.002)
    told = process.communicate("".join(text.splitlines(keepends=True)[sent:]))
    found = frames_in(line.close())
    assert (process.returncode, told[0]) == (0, ""), told[1]
    return found, told[1]


def counters(told):
    """{name: count} of the last line of davar-node."""
    words = told.splitlines()[-1].removeprefix("davar-node: ").split(", ")
    return {name: int(count) for count, name in (word.split(" ", 1) for word in words)}


def health_of(sent):
    """{name: count} as the newest frames of DAVAR_Health have them, in the words of davar-node."""
    words = {"link back": "link restored", "shocks left out": "shocks excluded"}
    found = {}
    for identifier, data in sent:
        if identifier & 15 == 5:
            signals = dbc().decode_message(0x5D5, data)
            name = str(signals["HealthIndex"])
            said = (
                re.sub("([A-Z])", r" \1", name).strip().lower().replace("finite samples", "finite")
            )
            found[words.get(said, said)] = signals[name]
    return found
