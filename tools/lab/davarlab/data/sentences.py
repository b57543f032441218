"""NMEA-like sentences (`$VNIMU,-00.0350,..,+084.322*66`), one per line, as rows of a table.

A line is `$TAG,number,..*CHECKSUM`; what stands in front of the $ is a time. The checksum is that
of NMEA 0183 (two digits, exclusive or) or VectorNav's 16 bits (four digits, CRC-16-CCITT)."""

import binascii
import functools
import operator
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from ..errors import BadInput, printable
from ..files import StrPath

SENTENCE = re.compile(
    rb"(?P<time>[^$]*)\$(?P<text>(?P<tag>[A-Z]{2}[A-Z0-9]+),(?P<fields>[^*$]*))"
    rb"(\*(?P<sum>[0-9A-Fa-f]{4}|[0-9A-Fa-f]{2}))?\s*"
)
AROUND = b"[](),;: \t"  # a time in front of a sentence
SHOWN = 60  # bytes of a line in a message
MAGNETIC = ["mag_x_gauss", "mag_y_gauss", "mag_z_gauss"]
FORCE = ["accel_x [m/s^2]", "accel_y [m/s^2]", "accel_z [m/s^2]"]
RATE = ["gyro_x [rad/s]", "gyro_y [rad/s]", "gyro_z [rad/s]"]
# tag -> names of its fields (VectorNav, VN-100 and VN-200 user manuals, "ASCII output messages")
NAMES = {
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

    @property
    def names(self) -> list[str] | None:
        """Of the columns, where the tag says them."""
        found = NAMES.get(self.tag.decode())
        return found and ["time"] * self.timed + found

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


def in_lines(lines: Sequence[bytes]) -> Sentences | None:
    """Of a file by its first lines: most of them are sentences. The rows are those whose fields
    have names here, else the most frequent ones."""
    found = [one for one in map(SENTENCE.fullmatch, lines) if one]
    if 2 * len(found) <= sum(map(bool, map(bytes.strip, lines))):
        return None
    tags = Counter(one["tag"] for one in found)
    tag = max(tags, key=lambda one: (one.decode() in NAMES, tags[one]))
    own = [one for one in found if one["tag"] == tag]
    timed = sum(bool(one["time"].strip(AROUND)) for one in own)
    summed = sum(bool(one["sum"]) for one in own)
    return Sentences(tag, 2 * timed > len(own), 2 * summed > len(own))
