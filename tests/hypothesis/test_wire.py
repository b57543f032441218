"""The receiver, the recorder of raw samples and SLCAN lines with any frames: received values were
sent, and the counters add up.
"""

import itertools
import math
import re
import string
import struct
import unittest
from profile import examples

import asked  # noqa: F401  (it finds davarlab)
from crccheck.crc import Crc8SaeJ1850
from davarlab.wire import frames as wire
from davarlab.wire import record, source
from hypothesis import given
from hypothesis import strategies as st

FRAMES_MOST = 60
STRIDE = 100


def sealed(identifier, data):
    """Checksum by the package crccheck, independent of davarlab."""
    return bytes([Crc8SaeJ1850.calc(identifier.to_bytes(2, "little") + data[1:])]) + data[1:]


def fnv_1a(identifier, data):
    """32 bits, over the bytes that the checksum covers, independent of davarlab."""
    value = 0x811C9DC5
    for byte in identifier.to_bytes(2, "little") + data[1:]:
        value = (value ^ byte) * 0x01000193 % 2**32
    return value


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


def sent(run, results, session):
    """[frame] of a sender: each result with its State, ARW, two Allan deviations, a Health with the
    session and an End. Every value identifies its run and result: 1000 run + n, an eighth more for
    each cluster size.
    """
    counters, out = {}, []

    def add(identifier, n, rest, own=0):
        counter = counters[identifier] = (counters.get(identifier, -1) + 1) % 16
        out.append((identifier, sealed(identifier, bytes([0, counter | own]) + rest)))

    for n in range(1, results + 1):
        value, tag = 1000.0 * run + n, (n - 1) % 16 << 4
        add(0x5D1, n, struct.pack("<HI", 600 >> 4, STRIDE * n), (600 & 15) << 4)
        add(0x5D0, n, struct.pack("<Hf", 100, value), tag)
        for tau in range(2):
            add(0x5D3, n, struct.pack("<Hf", tau, value + tau / 8), tag)
        add(0x5D5, n, struct.pack("<BBI", 0, session, 0), tag)
        mine = out[-5:-1]  # Health belongs to no result
        add(
            0x5DB,
            n,
            struct.pack("<BBI", len(mine), session, sum(fnv_1a(*frame) for frame in mine) % 2**32),
            tag,
        )
    return out


@st.composite
def delivered(draw, frames):
    """The fate of frames: [frame], and how many were lost, repeated and in the wrong order."""
    out, count, at = [], {"lost": 0, "twice": 0, "swapped": 0}, 0
    ways = draw(
        st.lists(
            st.sampled_from(("", "", "", "", "lost", "twice", "swapped")),
            min_size=len(frames),
            max_size=len(frames),
        )
    )
    for at, way in enumerate(ways):
        if way == "lost":
            count["lost"] += 1
            continue
        out += [frames[at]] * (2 if way == "twice" else 1)
        count["twice"] += way == "twice"
        if way == "swapped" and len(out) > 1 and out[-2] != out[-1]:
            out[-2:] = out[:-3:-1]
            count["swapped"] += 1
    return out, count


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

    @given(st.data(), st.lists(st.integers(1, 12), min_size=1, max_size=3))
    @examples(300)
    def test_received_values_were_sent(self, data, lengths):
        ways = [
            data.draw(delivered(sent(run, results, 7 + run))) for run, results in enumerate(lengths)
        ]
        frames = [frame for out, _ in ways for frame in out]
        found, receiver = self.fed(frames)
        self.adds_up(receiver, len(frames))
        seen = [(one.stretch, one.epoch) for one in found]
        self.assertEqual(len(seen), len(set(seen)))
        for result in found:
            n, rest = divmod(result.epoch, STRIDE)
            self.assertEqual(rest, 0)
            wanted = {1000.0 * run + n for run in range(len(lengths))}
            said = [value - tau / 8 for tau, value in result.adev.items()] + [
                value for name, value in result.values.items() if name == "arw_deg_per_sqrt_h"
            ]
            self.assertLessEqual(set(said), wanted, result)
            self.assertLessEqual(len(set(said)), 1, result)
        if not any(count["lost"] or count["swapped"] for _, count in ways) and len(lengths) == 1:
            self.assertEqual(
                [one.epoch for one in found], [STRIDE * n for n in range(1, lengths[0] + 1)]
            )
            self.assertEqual(receiver.faults.repeated, ways[0][1]["twice"])
            self.assertEqual(receiver.faults.total(), receiver.faults.repeated)


LINE = st.one_of(
    st.binary(max_size=12),
    st.binary(min_size=60, max_size=140),
    any_frame().map(
        lambda frame: b"t%03X%d%s" % (frame[0], len(frame[1]), frame[1].hex().encode())
    ),
    st.sampled_from(
        (b"", b"t5D0", b"T000005D08", b"t8008", b"t5D09" + b"00" * 9, b"t5D0800112233445566", b"z")
    ),
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
