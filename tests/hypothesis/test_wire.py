"""The receiver and SLCAN lines with any frames: no value is impossible, and the counters add up.

Correct frames, wrongly delivered: tests/wire/test_binding.py and test_restart.py.
"""

import itertools
import math
import re
import string
import unittest
from profile import examples

import asked  # noqa: F401  (it finds davarlab)
from crccheck.crc import Crc8SaeJ1850
from davarlab.wire import frames as wire
from davarlab.wire import record, source
from hypothesis import given
from hypothesis import strategies as st

FRAMES_MOST = 60


def sealed(identifier, data):
    """Checksum by the package crccheck, independent of davarlab."""
    return bytes([Crc8SaeJ1850.calc(identifier.to_bytes(2, "little") + data[1:])]) + data[1:]


@st.composite
def any_frame(draw):
    """A frame of any identifier: noise, or any content with the right checksum."""
    identifier = draw(st.one_of(st.integers(0x5D0, 0x5EF), st.integers(0, 0x7FF)))
    data = draw(
        st.one_of(
            st.binary(min_size=8, max_size=8),
            st.binary(max_size=8),
            st.binary(min_size=64, max_size=64),
        )
    )
    return identifier, sealed(identifier, data) if data and draw(st.booleans()) else data


class Frames(unittest.TestCase):
    def fed(self, frames):
        """(results, the receiver) after these frames."""
        receiver, found = wire.Receiver(), []
        for identifier, data in frames:
            result = receiver.push(identifier, data)
            found += [result] if result else []
        return found + receiver.finish(), receiver

    def adds_up(self, receiver, count):
        faults = receiver.faults
        self.assertEqual(
            faults.good + faults.foreign + faults.corrupted + faults.repeated + faults.impossible,
            count,
        )
        self.assertTrue(all(value >= 0 for value in vars(faults).values()), faults)

    @given(st.lists(any_frame(), max_size=FRAMES_MOST))
    @examples(300)
    def test_any_frames_add_up_and_no_value_is_impossible(self, frames):
        found, receiver = self.fed(frames)
        self.adds_up(receiver, len(frames))
        seen = [(one.channel, one.stretch, one.epoch) for one in found]
        self.assertEqual(len(seen), len(set(seen)))
        for result in found:
            values = record.row(result, result.of)
            self.assertTrue(
                all(
                    value is None or isinstance(value, int) or math.isfinite(value)
                    for value in values.values()
                )
            )


def text_of(frame):
    return b"t%03X%d%s" % (frame[0], len(frame[1]), frame[1].hex().encode())


LINE = st.one_of(
    st.binary(max_size=12),
    st.binary(min_size=60, max_size=140),
    st.binary(min_size=300, max_size=310),
    any_frame().map(text_of),
    any_frame().map(lambda frame: text_of(frame) + b"12Ff"),
    st.sampled_from(
        (b"", b"t5D0", b"T000005D08", b"t8008", b"t5D09" + b"00" * 9, b"t5D0800112233445566", b"z")
    ),
    st.sampled_from((b"t7FF0", b"t5d02ab01", b"t5D02AB011234", b"tFFF0", b"t8008" + b"00" * 8)),
    st.sampled_from((b"t5D02AB01123G", b"t5D02AB011", b"t5D02AB01 123", b"t5D02AB01\n")),
    st.sampled_from((b"t5D02ABzz", b"T000005D00", b"r5D00", b"t5d", b"t-5D0", b"t80001")),
)


class Lines(unittest.TestCase):
    """SLCAN text, split in any way."""

    def port(self):
        made = object.__new__(source.SerialPort)
        made.faults, made.text, made.too_long = wire.Faults(), b"", False
        return made

    @given(
        st.lists(LINE, max_size=8),
        st.lists(st.integers(1, 30), min_size=1),
        st.sampled_from((b"\r", b"\a")),
    )
    @examples(300)
    def test_frames_do_not_depend_on_how_lines_are_split(self, lines, pieces, end):
        text, wanted, noise = end.join([*lines, b""]), [], 0
        for line in re.split(rb"[\r\a]", text)[:-1]:
            frame = self.independently(line)
            wanted += [frame] if frame else []
            noise += bool(line) and not frame
        port, found, at = self.port(), [], 0
        for length in itertools.cycle(pieces):
            found += port.taken(text[at : at + length])
            at += length
            if at >= len(text):
                break
        self.assertEqual((found, port.faults.noise), (wanted, noise))

    def independently(self, line):
        """The parts of a line `tIIIL` and bytes in hexadecimal, with or without a stamp of two
        bytes.
        """
        try:
            word = line.decode("ascii")
            kind, identifier, length, rest = word[0], word[1:4], word[4], word[5:]
            if (
                kind != "t"
                or not all(one in string.hexdigits for one in identifier + rest)
                or not length.isdigit()
                or int(length) > 8
            ):
                return None
            data = bytes.fromhex(rest)
            return (
                (int(identifier, 16), data[: int(length)])
                if int(identifier, 16) < 0x800 and len(data) in (int(length), int(length) + 2)
                else None
            )
        except (ValueError, IndexError):
            return None


if __name__ == "__main__":
    unittest.main()
