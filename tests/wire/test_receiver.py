"""The receiver with injected faults: each is detected and counted. Undetectable ones are listed."""

import itertools
import random
import struct

import pytest
from davar.wire import frames as wire
from senders import ROOT
from senders import sealed as frame_with

ARW, STATE, SETUP = 0x5D0, 0x5D1, 0x5D6


@pytest.fixture(scope="module")
def wire_md():
    return " ".join((ROOT / "addons/can/DESIGN.md").read_text(encoding="utf-8").split())


def sealed(identifier, counter, payload, result=0):
    return frame_with(identifier, payload, counter % 16 | result % 16 << 4)[1]


def state(n, stride=100):
    return sealed(STATE, n, struct.pack("<HI", 600 >> 4, n * stride))


def stride_of(counter, result=0):
    return sealed(SETUP, counter, bytes([1, 0]) + struct.pack("<I", 100), result)


def passes(pattern):
    """True if a frame with these bits flipped passes the Crc. The Crc is linear, so one frame
    represents all. Bit 63 is the first of the data on the wire; the identifier is above it.
    """
    identifier, data = pattern >> 64, (pattern % 2**64).to_bytes(8, "big")
    return data[0] == wire.crc(identifier, data) ^ wire.crc(0, bytes(8))


# Bursts of up to eight bits that include bits of Crc and of the bytes after it.
ASTRIDE = sorted(
    {pattern << at for at in range(49, 56) for pattern in range(1, 256) if pattern << at >= 2**56}
)


class Stream:
    """Frames of DAVAR_Arw with a running number inside, so that close frames differ."""

    def __init__(self):
        self.receiver, self.n = wire.Receiver(), 0

    def now(self):
        return sealed(ARW, self.n, struct.pack("<HI", self.n & 0xFFFF, self.n & 0xFFFFFFFF), self.n)

    def next(self):
        self.n += 1
        return self.now()

    def check(self, data):
        return self.receiver.check(ARW, data)

    def good(self, count=1):
        for _ in range(count):
            assert self.check(self.next()) == "good"

    def corrupted(self, source):
        """One or two bits anywhere, or a burst within eight bits after the Crc: faults that it
        always detects. Bits are in the order of the wire: byte 0 first, most significant bit first.
        """
        frame = int.from_bytes(self.next(), "big")
        if source.random() < 0.5:
            frame ^= 1 << source.randrange(64)
            frame ^= 1 << source.randrange(64) if source.random() < 0.5 else 0
        else:
            frame ^= source.randrange(1, 256) << source.randrange(49)
        return frame.to_bytes(8, "big")


@pytest.mark.parametrize("faults", [20_000, pytest.param(10**6, marks=pytest.mark.soak)])
def test_every_injected_fault_is_detected_and_reported(faults):
    source, stream, wanted = random.Random(1), Stream(), wire.Faults()
    stream.good(20)
    for _ in range(faults):
        kind = source.randrange(4)
        if kind == 0:
            damaged = stream.corrupted(source)
            fault = damaged != stream.now()  # the same bit twice is none
            stream.check(damaged)
            wanted.corrupted += fault
            wanted.missing += fault
        elif kind == 1:
            frame = stream.next()
            for repetition in range(source.randrange(2, 4)):
                stream.check(frame)
                wanted.repeated += repetition > 0
        elif kind == 2:
            first, second = stream.next(), stream.next()
            stream.check(second)
            stream.check(first)
            wanted.swapped += 1
        else:
            lost = source.randrange(1, 8)
            stream.n += lost
            wanted.missing += lost
        stream.good(2)
    wanted.good = stream.receiver.faults.good
    assert stream.receiver.faults == wanted


def test_no_one_or_two_bit_error_and_no_burst_of_eight_bits_passes_the_crc():
    ones = [1 << bit for bit in range(64 + 11)]
    pairs = [a | b for a, b in itertools.combinations(ones, 2)]
    bursts = [pattern << at for at in range(49) for pattern in range(1, 256)]
    assert not any(map(passes, [*ones, *pairs, *bursts]))


def test_faults_that_pass_the_crc_are_as_documented(wire_md):
    found = [one for one in ASTRIDE if passes(one)]
    assert (len(found), len([one for one in found if one >> 48 & 0x0F])) == (5, 3)
    assert f"{len(found)} of the {len(ASTRIDE)} bursts across Crc and byte 1 pass" in wire_md
    three = list(itertools.combinations((1 << bit for bit in range(64)), 3))
    passed = sum(passes(a | b | c) for a, b, c in three)
    assert f"{passed} of {len(three)} errors of three bits" in wire_md
    alone = []
    for bit in range(512):  # of a frame of 64 bytes
        data = bytearray(64)
        data[bit // 8] ^= 0x80 >> bit % 8
        alone.append(data[0] ^ wire.crc(0, data) ^ wire.crc(0, bytes(64)))
    assert 0 not in alone
    pairs = list(itertools.combinations(alone, 2))
    assert f"{sum(a == b for a, b in pairs)} of {len(pairs)} errors of two bits" in wire_md


def test_a_burst_that_passes_the_crc_is_detected_by_counter_or_result():
    for pattern in filter(passes, ASTRIDE):
        receiver = wire.Receiver()
        for n in range(20):
            receiver.push(STATE, state(n))
            frame = int.from_bytes(sealed(ARW, n, struct.pack("<Hf", 7, n), n), "big")
            receiver.push(ARW, (frame ^ (pattern if n == 10 else 0)).to_bytes(8, "big"))
        assert receiver.faults.total() > 0, hex(pattern)


def test_a_frame_of_no_result_is_counted():
    receiver = wire.Receiver()
    receiver.push(ARW, sealed(ARW, 0, bytes(6), 3))  # from before the receiver started
    receiver.push(STATE, state(0))
    receiver.push(ARW, sealed(ARW, 1, bytes(6), 1))
    receiver.finish()
    faults = receiver.faults
    assert (faults.orphaned, faults.incomplete_results, faults.total()) == (1, 1, 2)


def test_lost_results_beyond_sixteen_add_up():
    """Sixteen lost results leave no hole in the counter and one in the epoch."""
    for lost in (*range(1, 60), 160):
        receiver = wire.Receiver()
        receiver.push(SETUP, stride_of(0))
        for n in range(20):
            receiver.push(STATE, state(n))
            if lost % 16 == 0:
                receiver.push(SETUP, stride_of(n + 1, n))
        receiver.push(STATE, state(20 + lost))
        faults = receiver.faults
        assert faults.missing + faults.missing_results == lost
        assert lost % 16 or faults.missing == 0


def test_frames_of_others_and_of_another_length():
    receiver = wire.Receiver()
    for identifier in (0x123, 0x5CF, 0x5DD, 0x5DF):
        receiver.push(identifier, bytes(8))
    assert (receiver.faults.foreign, receiver.faults.total()) == (4, 0)
    receiver.push(ARW, b"")
    receiver.push(ARW, bytes(7))
    assert receiver.faults.corrupted == 2
