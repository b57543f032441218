"""Rows of a serial port: sentences with a tag and a checksum, and lines of a serial monitor with
the time of day in front."""

import binascii
import functools
import operator
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from ..errors import BadInput, printable
from ..files import StrPath
from .dialect import recognised, split

SHOWN = 60  # characters of a line in a message
SENTENCE = re.compile(
    rb"(?P<time>[^$]*)\$(?P<text>(?P<tag>[A-Z]{2}[A-Z0-9]+),(?P<fields>[^*$]*))"
    rb"(\*(?P<sum>[0-9A-Fa-f]{4}|[0-9A-Fa-f]{2}))?\s*"
)
MONITORED = re.compile(
    rb"\s*(?P<open>\[)?(?P<hour>\d\d?):(?P<minute>[0-5]\d):(?P<second>[0-5]\d(\.\d{1,9})?)"
    rb"(?(open)\]|)\s*(?P<arrow>-?>)?\s*(?P<rest>.*?)\s*"
)
NUMERIC = b"0123456789.+-eE,; \t"  # of a row of numbers
DAY_S = 86400
AROUND = b"[](),;: \t"  # a time in front of a sentence
MAGNETIC = ["mag_x_gauss", "mag_y_gauss", "mag_z_gauss"]
FORCE = ["accel_x [m/s^2]", "accel_y [m/s^2]", "accel_z [m/s^2]"]
RATE = ["gyro_x [rad/s]", "gyro_y [rad/s]", "gyro_z [rad/s]"]
# tag -> names of its fields (VectorNav, VN-100 and VN-200 user manuals, "ASCII output messages")
FIELDS = {
    "VNIMU": [*MAGNETIC, *FORCE, *RATE, "temp_degC", "pressure_kPa"],
    "VNMAR": [*MAGNETIC, *FORCE, *RATE],
    "VNYMR": ["yaw_deg", "pitch_deg", "roll_deg", *MAGNETIC, *FORCE, *RATE],
    "VNGYR": RATE,
}


@dataclass
class Sentences:
    """tag: of the sentences that are the rows; timed: a time stands in front of each; summed: a
    checksum behind."""

    tag: bytes
    timed: bool
    summed: bool
    said = ""

    def named(self, given: Sequence[str] | None) -> Sequence[str] | None:
        """Names for the columns: those that are given, else those that the tag says."""
        found = FIELDS.get(self.tag.decode())
        return given or found and ["time"] * self.timed + found

    def rows(self, lines: Sequence[bytes], line: int, path: StrPath) -> list[bytes]:
        """A row for each line, the first of which is `line` of the file: empty for other sentences,
        and for one that is cut off at the beginning or at the end of the file."""
        last = line + len(lines) - 1
        return [
            self.row(one, f"{path}:{place}", place == 1 or place == last and b"\n" not in one)
            for place, one in enumerate(lines, line)
        ]

    def row(self, line: bytes, where: str, at_end: bool) -> bytes:
        found = SENTENCE.fullmatch(line)
        why = damage(found, self.summed) if found else "not a whole sentence" * (b"$" in line)
        if why and not at_end:
            raise BadInput(self.damaged(line, where, why))
        if not found or why or found["tag"] != self.tag:
            return b""
        return found["time"].strip(AROUND) + b"," * self.timed + found["fields"]

    def damaged(self, line: bytes, where: str, why: str) -> str:
        shown = printable(line.decode("utf-8", errors="replace").strip()[:SHOWN])
        shorter = "" if self.timed else "; without times, each such line is a lost sample"
        return f"{where}: a damaged sentence ({why}): {shown}. Delete the line{shorter}"

    def translated(self, blocks: Iterable[bytes], line: int, path: StrPath) -> Iterator[bytes]:
        """Blocks of lines as blocks of rows; line: the one above them."""
        for block in blocks:
            lines = block.splitlines(keepends=True)
            end = b"\n" if block.endswith(b"\n") else b""
            yield b"\n".join(self.rows(lines, line + 1, path)) + end
            line += len(lines)


def damage(found: "re.Match[bytes]", summed: bool) -> str:
    """What is wrong with the checksum of a sentence; "" where it is right, or not needed."""
    said = found["sum"]
    if not said:
        return "no checksum" * summed
    text: bytes = found["text"]
    right = (
        f"{functools.reduce(operator.xor, text):02X}"
        if len(said) == 2
        else f"{binascii.crc_hqx(text, 0):04X}"
    )
    return "" if said.decode().upper() == right else f"checksum {said.decode()} instead of {right}"


def sentences_in(lines: Sequence[bytes]) -> Sentences | None:
    """Of a file by its first lines: most of them are sentences. The rows are those whose fields
    have names here, else the most frequent ones."""
    found = [one for one in map(SENTENCE.fullmatch, lines) if one]
    if 2 * len(found) <= sum(map(bool, map(bytes.strip, lines))):
        return None
    tags = Counter(one["tag"] for one in found)
    tag = max(tags, key=lambda one: (one.decode() in FIELDS, tags[one]))
    own = [one for one in found if one["tag"] == tag]
    timed = sum(bool(one["time"].strip(AROUND)) for one in own)
    summed = sum(bool(one["sum"]) for one in own)
    return Sentences(tag, 2 * timed > len(own), 2 * summed > len(own))


def time_of(found: "re.Match[bytes]") -> float:
    """The time of day of a line, in seconds."""
    return int(found["hour"]) * 3600 + int(found["minute"]) * 60 + float(found["second"])


@dataclass
class Clock:
    """The time of day of lines, which continues after midnight."""

    day: int = 0
    last: float = 0.0

    def seconds(self, found: "re.Match[bytes]") -> float:
        time = time_of(found)
        self.day += time < self.last - DAY_S / 2
        self.last = time
        return time + self.day * DAY_S


@dataclass
class Monitor:
    """Lines of a serial monitor: a time of day in brackets or in front of an arrow, as the Arduino
    IDE writes it, which becomes a column time_s. separator: of the rest; count: of its fields."""

    separator: bytes
    count: int
    said = "a time of day before each row, read as time_s"

    def named(self, given: Sequence[str] | None) -> Sequence[str] | None:
        """Names for the columns, of which the time already has one."""
        return ["time_s", *given] if given and len(given) == self.count else given

    def rows(self, lines: Sequence[bytes], line: int, path: StrPath) -> list[bytes]:
        clock = Clock()
        return [self.row(one, clock) for one in lines]

    def fields(self, rest: bytes) -> list[str]:
        return split(rest.decode("utf-8", errors="replace"), self.separator.decode())

    def row(self, line: bytes, clock: Clock) -> bytes:
        found = monitored(line)
        if not found or not found["rest"]:
            return b"" if found else line.strip()
        words = bool(found["rest"].translate(None, NUMERIC)) and self.fields(found["rest"])
        named = words and recognised(words)
        time = b"time_s" if named else f"{clock.seconds(found):.9f}".encode()
        return time + self.separator + found["rest"]

    def translated(self, blocks: Iterable[bytes], line: int, path: StrPath) -> Iterator[bytes]:
        """Blocks of lines as blocks of rows."""
        clock = Clock()
        for block in blocks:
            rows = [self.row(one, clock) for one in block.splitlines()]
            yield b"\n".join(rows) + b"\n" * block.endswith(b"\n")


def monitored(line: bytes) -> "re.Match[bytes] | None":
    """A line with a time of day that is marked as one."""
    found = MONITORED.fullmatch(line)
    return found if found and (found["open"] or found["arrow"]) else None


def monitor_in(lines: Sequence[bytes]) -> Monitor | None:
    """Of a file by its first lines: most of them begin with a time of day."""
    found = [one["rest"] for one in map(monitored, lines) if one]
    if not found or 2 * len(found) <= sum(map(bool, map(bytes.strip, lines))):
        return None
    met = {one: sum(one in rest for rest in found) for one in (b";", b"\t", b",", b" ")}
    separator = max(met, key=lambda one: met[one]) if any(met.values()) else b","
    sizes = Counter(
        len(split(rest.decode("utf-8", errors="replace"), separator.decode())) for rest in found
    )
    return Monitor(separator, sizes.most_common(1)[0][0])
