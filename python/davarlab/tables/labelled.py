"""Lines of a serial port in which a label stands before each number: `gx:0.12 gy:-0.03`,
`Gyro: 0.1, 0.2, 0.3`, `{"t": 12, "gx": 0.1}`. The values of a sample may take several lines, as the
examples of Adafruit print them:

    Rotation X: 0.02, Y: -0.01, Z: 0.00 rad/s
    Temperature: 34.88 degC"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from ..files import StrPath
from ..thresholds import GUESS
from . import guess
from .dialect import recognised
from .sentences import Clock, monitored

VALUE = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)"
UNIT = r"m/s(?:\^?2|\u00b2)|m?g|rad/s|m?(?:deg|\u00b0)/s|m?dps|[mun]?s|(?:deg|\u00b0)? ?C"
PAIR = re.compile(
    r"(?P<label>[^\W\d][^:=;,|\t\"]*?)\"?\s*[:=]\s*"
    rf"(?P<values>(?:{VALUE})(?:[,\s]+(?:{VALUE})(?![\w.:=]))*)(?![\w.:])"
    rf"\s*(?P<unit>(?:{UNIT})(?![^\s,;|}}]))?",
    re.IGNORECASE,
)
BETWEEN = ' ,;|>{}()[]"\t\r\n'  # pairs


def pairs(line: bytes) -> dict[str, tuple[str, str]]:
    """name -> (number, unit) of a line; empty for a line that is something else, too. A label that
    is only an axis continues the one before it."""
    text, before = line.decode("utf-8", errors="replace"), ""
    found: dict[str, tuple[str, str]] = {}
    if PAIR.sub("", text).strip(BETWEEN):
        return {}
    for one in PAIR.finditer(text):
        name = one["label"].strip()
        head, _, last = before.rpartition(" ")
        if head and name.lower() in ("x", "y", "z") and last.lower() in ("x", "y", "z"):
            name = f"{head} {name}"
        before, values = name, re.split(r"[,\s]+", one["values"])
        names = [f"{name} {axis}" for axis in "xyz"] if len(values) == 3 else [name]
        found |= {name: (value, one["unit"] or "") for name, value in zip(names, values)}
    return found


@dataclass
class Labelled:
    """columns: label -> name; timed: a time of day stands before each line; whole: all values of a
    sample stand in one line. values: of the sample whose lines are being read."""

    columns: dict[str, str]
    timed: bool
    whole: bool
    values: dict[str, str] = field(default_factory=dict)
    said = "a label before each number"

    def named(self, given: Sequence[str] | None) -> Sequence[str]:
        return given or ["time_s"] * self.timed + list(self.columns.values())

    def rows(self, lines: Sequence[bytes], line: int, path: StrPath) -> list[bytes]:
        clock = Clock()
        return [self.row(one, clock) for one in lines]

    def row(self, line: bytes, clock: Clock) -> bytes:
        """The sample that ends in a line; empty where none does. One ends with its last label, and
        before its first one comes again."""
        timed = monitored(line) if self.timed else None
        new = {
            label: value
            for label, (value, _) in pairs(timed["rest"] if timed else line).items()
            if label in self.columns
        }
        labels, out = list(self.columns), b""
        if labels[0] in new and self.values:
            out = self.ended()
        if timed and new and not self.values:
            self.values["time"] = f"{clock.seconds(timed):.9f}"
        self.values |= new
        if labels[-1] in new or self.whole and new:
            out = self.ended()
        return out

    def ended(self) -> bytes:
        labels = ["time"] * self.timed + list(self.columns)
        row = ",".join(self.values.get(label, "") for label in labels)
        self.values = {}
        return row.encode()

    def translated(self, blocks: Iterable[bytes], line: int, path: StrPath) -> Iterator[bytes]:
        """Blocks of lines as blocks of rows."""
        clock = Clock()
        self.values = {}
        for block in blocks:
            rows = [self.row(one, clock) for one in block.splitlines()]
            yield b"\n".join(rows) + b"\n" * block.endswith(b"\n")


def labelled_in(lines: Sequence[bytes]) -> Labelled | None:
    """Of a file by its first lines: a third of them or more are labels with numbers, and one is a
    gyro, an accelerometer or a temperature."""
    times = [monitored(one) for one in lines]
    found = [pairs(time["rest"] if time else one) for time, one in zip(times, lines)]
    full = [one for one in found if one]
    if 3 * len(full) <= sum(map(bool, map(bytes.strip, lines))):
        return None
    met = Counter(label for one in full for label in one)
    labels = [label for label, count in met.items() if count >= GUESS.labelled * max(met.values())]
    if min(met[label] for label in labels) < 2 or not recognised(labels):
        return None
    units = units_of(full)
    columns = {
        label: f"{label} [{units[label]}]" if units.get(label) else label for label in labels
    }
    timed = 2 * sum(bool(time) for time, one in zip(times, found) if one) > len(full)
    return Labelled(columns, timed, any(set(labels) <= set(one) for one in full))


def units_of(lines: Iterable[dict[str, tuple[str, str]]]) -> dict[str, str]:
    """label -> unit: the one behind its number, or behind that of the last axis of its sensor."""
    found: dict[str, str] = {}
    for line in lines:
        unit, sensor = "", ""
        for label in reversed(line):
            own = line[label][1]
            stem = label.rpartition(" ")[0] if guess.axis_of(label) else label
            unit = own or unit * (bool(stem) and stem == sensor)
            sensor = stem
            found.setdefault(label, unit)
    return found
