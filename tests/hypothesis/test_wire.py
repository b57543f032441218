"""The receiver and SLCAN lines with any frames: no value is impossible, and the counters add up.

Correct frames, wrongly delivered: tests/wire/test_receiving.py.
"""

import itertools
import math
import re

from crccheck.crc import Crc8SaeJ1850
from davar.wire import frames as wire
from davar.wire import record, source
from hypothesis import given
from hypothesis import strategies as st
from lawful import examples


def sealed(identifier, data):
    """Checksum by the package crccheck, independent of davarlab."""
    return bytes([Crc8SaeJ1850.calc(identifier.to_bytes(2, "little") + data[1:])]) + data[1:]


@st.composite
def any_frame(draw):
    """A frame of any identifier: noise, or any content with the right checksum."""
    identifier = draw(st.integers(0x5D0, 0x5EF) | st.integers(0, 0x7FF))
    length = draw(st.sampled_from(((8, 8), (0, 8), (64, 64))))
    data = draw(st.binary(min_size=length[0], max_size=length[1]))
    return identifier, sealed(identifier, data) if data and draw(st.booleans()) else data


@given(frames=st.lists(any_frame(), max_size=60))
@examples(250)
def test_any_frames_add_up_and_no_value_is_impossible(frames):
    receiver, found = wire.Receiver(), []
    for identifier, data in frames:
        result = receiver.push(identifier, data)
        found += [result] if result else []
    found += receiver.finish()
    faults = vars(receiver.faults)
    kinds = ("good", "foreign", "corrupted", "repeated", "impossible")
    assert sum(faults[name] for name in kinds) == len(frames)
    assert all(value >= 0 for value in faults.values()), faults
    seen = [(one.channel, one.stretch, one.epoch) for one in found]
    assert len(seen) == len(set(seen))
    for result in found:
        for value in record.row(result, result.of).values():
            assert value is None or isinstance(value, int) or math.isfinite(value)


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


def independently(line):
    """The parts of a line `tIIIL` and bytes in hexadecimal, with or without a stamp of two bytes;
    None for other lines.
    """
    found = re.fullmatch(rb"t([0-9A-Fa-f]{3})([0-8])((?:[0-9A-Fa-f]{2})*)", line)
    if not found:
        return None
    identifier, length = int(found[1], 16), int(found[2])
    data = bytes.fromhex(found[3].decode())
    return (
        (identifier, data[:length])
        if identifier < 0x800 and len(data) in (length, length + 2)
        else None
    )


@given(
    lines=st.lists(LINE, max_size=8),
    pieces=st.lists(st.integers(1, 30), min_size=1),
    end=st.sampled_from((b"\r", b"\a")),
)
@examples(300)
def test_frames_do_not_depend_on_how_lines_are_split(lines, pieces, end):
    text = end.join([*lines, b""])
    there = [line for line in re.split(rb"[\r\a]", text)[:-1] if line]
    wanted = [frame for line in there if (frame := independently(line))]
    port = object.__new__(source.SerialPort)
    port.faults, port.text, port.too_long = wire.Faults(), b"", False
    found, at = [], 0
    for length in itertools.cycle(pieces):
        found += port.taken(text[at : at + length])
        at += length
        if at >= len(text):
            break
    assert (found, port.faults.noise) == (wanted, len(there) - len(wanted))
