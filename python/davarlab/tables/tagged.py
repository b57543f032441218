"""Rows of several sensors in one table, of which a word in each row names its sensor:

IMU,0.005,0.12,-0.03,0.00,0.1,0.0,9.8
GPS,0.010,48.1,11.6,512.0"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from ..files import StrPath
from . import guess
from .dialect import COMMENTS, is_number, split

PLAIN = re.compile(r"[^\W\d][\w .:/+-]*")  # a word, in the field of a row
TAGS_MOST = 12  # sensors whose rows are in one table
DEVICE = re.compile(r"(raw)?imus?\d*|mpu|inertial|ins", re.IGNORECASE)  # that has a gyro


@dataclass
class Tagged:
    """tag: of the rows that are read; place: of the field in which it stands; others: the tags of
    the other rows, as far as they were met; headed: the names of the fields stand behind the
    tag."""

    separator: str
    place: int
    tag: str
    others: list[str]
    headed: bool

    @property
    def said(self) -> str:
        skipped = f", those of {', '.join(self.others)} skipped" * bool(self.others)
        return f"only rows tagged {self.tag} are read{skipped}"

    def named(self, given: Sequence[str] | None) -> Sequence[str] | None:
        return given

    def comments(self, found: list[tuple[int, str]]) -> list[tuple[int, str]]:
        """The comment that names the fields of the rows that are read, where each tag has one."""
        own = [
            (line, text)
            for line, text in found
            if word_at(split(text.lstrip("#%/ "), self.separator), self.place) == self.tag
        ]
        return own or found

    def rows(self, lines: Sequence[bytes], line: int, path: StrPath) -> list[bytes]:
        """The lines; empty for those of other sensors."""
        return [b"" if self.is_other(split(text_of(one), self.separator)) else one for one in lines]

    def is_other(self, fields: Sequence[str]) -> bool:
        """Is a row one of another sensor, with numbers or with their names."""
        tag = word_at(fields, self.place)
        if tag in ("", self.tag):
            return False
        if tag not in self.others and not self.headed and not are_numbers(fields):
            return False
        if tag not in self.others and len(self.others) < TAGS_MOST:
            self.others.append(tag)
        return True

    def translated(self, blocks: Iterable[bytes], line: int, path: StrPath) -> Iterator[bytes]:
        """Blocks of lines as blocks of rows."""
        for block in blocks:
            yield b"\n".join(self.rows(block.split(b"\n"), line, path))


def text_of(line: bytes) -> str:
    return line.decode("utf-8", errors="replace").strip()


def word_at(fields: Sequence[str], place: int) -> str:
    """The word in a field; "" where the row has none there."""
    return fields[place] if place < len(fields) and PLAIN.fullmatch(fields[place]) else ""


def tagged_in(lines: Sequence[bytes]) -> Tagged | None:
    """Of a file by its first lines: rows of numbers with a word at the same place in each, of which
    one names a gyro or an IMU."""
    texts = [text for text in map(text_of, lines) if text and not text.startswith(COMMENTS)]
    for separator in ",;\t |":
        rows = [split(text, separator) for text in texts]
        numbers = [row for row in rows if are_numbers(row)]
        for place in range(min(map(len, numbers), default=0)):
            met = Counter(word_at(row, place) for row in numbers)
            tag = max(filter(has_gyro, met), key=lambda one: met[one], default="")
            several = len(met) > 1 or not place  # the first other row may come late
            if tag and several and not met[""] and len(met) <= TAGS_MOST and met[tag] > 1:
                headed = any(word_at(row, place) == tag and not are_numbers(row) for row in rows)
                return Tagged(separator, place, tag, [one for one in met if one != tag], headed)
    return None


def are_numbers(fields: Sequence[str]) -> bool:
    """Is a row one of numbers beside words, and none of names."""
    return any(is_number(one, ".") or is_number(one, ",") for one in fields)


def has_gyro(tag: str) -> bool:
    return guess.in_file(tag) == "gyro" or any(map(DEVICE.fullmatch, guess.tokens(tag)))
