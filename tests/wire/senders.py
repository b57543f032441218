"""Frames of the library's own encoder (wire_probe), and functions that deliver them wrongly."""

import functools
import os
import random
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROBE = os.environ.get("DAVAR_WIRE_PROBE", "wire_probe")
STATE, FD, END = 1, 8, 11


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
    done = subprocess.run(
        [PROBE, "run", *map(str, (seed, count, session, stride, content, first, channel))],
        text=True,
        stdout=subprocess.PIPE,
        check=True,
    )
    found = Run()
    for line in done.stdout.splitlines():
        word = line.split()
        if word[0] == "R":
            found.results.append([])
        else:
            found.results[-1].append((int(word[1], 16), bytes.fromhex(word[2])))
    return found


def frames(one):
    return [frame for result in one.results for frame in result]


def disturbed(one, source, rate):
    """Frames with repetitions, swaps and losses, single ones and long ones."""
    sent, out = frames(one), []
    at = 0
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


def seeded(*words):
    return random.Random(repr(words))
