"""The receiver with injected faults: each is detected and reported. Undetectable ones are listed.

DAVAR_WIRE_FAULTS: number of faults to inject (default 10^6).
"""

import itertools
import os
import random
import struct
import unittest
from pathlib import Path

from davarlab.wire import frames as wire

ROOT = Path(__file__).resolve().parents[2]

WIRE_MD = " ".join((ROOT / "lib/WIRE.md").read_text(encoding="utf-8").split())
FAULTS = int(os.environ.get("DAVAR_WIRE_FAULTS", "1000000"))
ARW, STATE, SETUP = 0x5D0, 0x5D1, 0x5D6


def sealed(identifier, counter, payload, result=0):
    data = bytes([0, counter % 16 | result % 16 << 4]) + payload
    return bytes([wire.crc(identifier, data)]) + data[1:]


def state(n, stride=100):
    return sealed(STATE, n, struct.pack("<HI", 600 >> 4, n * stride))


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

    def __init__(self, receiver):
        self.receiver, self.n = receiver, 0

    def next(self):
        self.n += 1
        return sealed(ARW, self.n, struct.pack("<HI", self.n & 0xFFFF, self.n & 0xFFFFFFFF), self.n)

    def good(self, count=1):
        for _ in range(count):
            assert self.receiver.check(ARW, self.next()) == "good"

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


class Faults(unittest.TestCase):
    def test_every_injected_fault_is_detected_and_reported(self):
        source, receiver = random.Random(1), wire.Receiver()
        stream = Stream(receiver)
        stream.good(20)
        wanted = wire.Faults()
        for _ in range(FAULTS):
            kind = source.randrange(4)
            if kind == 0:
                before = stream.n
                damaged = stream.corrupted(source)
                intact = sealed(
                    ARW,
                    stream.n,
                    struct.pack("<HI", stream.n & 0xFFFF, stream.n & 0xFFFFFFFF),
                    stream.n,
                )
                if damaged == intact:  # the same bit twice: not a fault
                    stream.n = before
                    stream.good()
                else:
                    receiver.check(ARW, damaged)
                    wanted.corrupted += 1
                    wanted.missing += 1
            elif kind == 1:
                frame = stream.next()
                receiver.check(ARW, frame)
                for _ in range(source.randrange(1, 3)):
                    receiver.check(ARW, frame)
                    wanted.repeated += 1
            elif kind == 2:
                first, second = stream.next(), stream.next()
                receiver.check(ARW, second)
                receiver.check(ARW, first)
                wanted.swapped += 1
            else:
                lost = source.randrange(1, 8)
                stream.n += lost
                wanted.missing += lost
            stream.good(2)
        wanted.good = receiver.faults.good
        self.assertEqual(wanted, receiver.faults)

    def test_runs_of_up_to_fifteen_lost_frames_are_counted_exactly(self):
        source, receiver = random.Random(2), wire.Receiver()
        stream, lost = Stream(receiver), 0
        stream.good(20)
        for _ in range(2000):
            run = source.randrange(1, 16)
            stream.n += run
            lost += run
            stream.good(20)
        self.assertEqual(lost, receiver.faults.missing)
        self.assertEqual(lost, receiver.faults.total())

    def test_no_one_or_two_bit_error_and_no_burst_of_eight_bits_passes_the_crc(self):
        bits = range(64 + 11)
        self.assertEqual([], [a for a in bits if passes(1 << a)])
        self.assertEqual(
            [], [(a, b) for a in bits for b in bits if a < b and passes(1 << a | 1 << b)]
        )
        behind_crc = [pattern << at for at in range(49) for pattern in range(1, 256)]
        self.assertEqual([], [hex(one) for one in behind_crc if passes(one)])

    def test_faults_that_pass_the_crc_are_as_documented(self):
        found = [one for one in ASTRIDE if passes(one)]
        of_counter = [one for one in found if one >> 48 & 0x0F]
        three = list(itertools.combinations(range(64), 3))
        passed = sum(passes(1 << a | 1 << b | 1 << c) for a, b, c in three)
        self.assertIn(
            f"{len(found)} of the {len(ASTRIDE)} bursts across Crc and byte 1 pass", WIRE_MD
        )
        self.assertEqual((5, 3), (len(found), len(of_counter)))
        self.assertIn(f"{passed} of {len(three)} errors of three bits", WIRE_MD)

    def test_undetected_faults_in_a_frame_of_64_bytes_are_as_documented(self):
        alone = []
        for bit in range(512):
            data = bytearray(64)
            data[bit // 8] ^= 0x80 >> bit % 8
            alone.append(data[0] ^ wire.crc(0, data) ^ wire.crc(0, bytes(64)))
        self.assertNotIn(0, alone)
        pairs = list(itertools.combinations(alone, 2))
        passed = sum(a == b for a, b in pairs)
        self.assertIn(f"{passed} of {len(pairs)} errors of two bits", WIRE_MD)

    def test_a_burst_that_passes_the_crc_is_detected_by_counter_or_result(self):
        for pattern in filter(passes, ASTRIDE):
            receiver = wire.Receiver()
            for n in range(20):
                receiver.push(STATE, state(n))
                frame = int.from_bytes(sealed(ARW, n, struct.pack("<Hf", 7, n), n), "big") ^ (
                    pattern if n == 10 else 0
                )
                receiver.push(ARW, frame.to_bytes(8, "big"))
            self.assertGreater(receiver.faults.total(), 0, hex(pattern))

    def test_a_frame_of_no_result_is_counted(self):
        receiver = wire.Receiver()
        receiver.push(ARW, sealed(ARW, 0, bytes(6), 3))  # from before the receiver started
        receiver.push(STATE, state(0))
        receiver.push(ARW, sealed(ARW, 1, bytes(6), 1))
        receiver.finish()
        self.assertEqual(
            (1, 1, 2),
            (receiver.faults.orphaned, receiver.faults.incomplete_results, receiver.faults.total()),
        )

    def test_of_frames_of_random_bytes_one_in_256_passes_the_crc(self):
        source, passed = random.Random(3), 0
        for _ in range(100000):
            data = source.randbytes(8)
            passed += data[0] == wire.crc(ARW, data)
        self.assertAlmostEqual(100000 / 256, passed, delta=5 * (100000 / 256) ** 0.5)

    def test_sixteen_lost_results_leave_no_hole_in_the_counter_and_one_in_the_epoch(self):
        for lost in (16, 32, 160):
            receiver = wire.Receiver()
            receiver.push(SETUP, sealed(SETUP, 0, bytes([1, 0]) + struct.pack("<I", 100)))
            for n in range(20):
                receiver.push(STATE, state(n))
                receiver.push(
                    SETUP, sealed(SETUP, n + 1, bytes([1, 0]) + struct.pack("<I", 100), n)
                )
            receiver.push(STATE, state(19 + lost + 1))
            self.assertEqual((0, lost), (receiver.faults.missing, receiver.faults.missing_results))

    def test_lost_results_beyond_sixteen_add_up(self):
        for lost in range(1, 60):
            receiver = wire.Receiver()
            receiver.push(SETUP, sealed(SETUP, 0, bytes([1, 0]) + struct.pack("<I", 100)))
            for n in (*range(20), 20 + lost):
                receiver.push(STATE, state(n))
            self.assertEqual(lost, receiver.faults.missing + receiver.faults.missing_results)

    def test_frames_of_others_are_no_fault(self):
        receiver = wire.Receiver()
        for identifier in (0x123, 0x5CF, 0x5DC, 0x5DF):
            receiver.push(identifier, bytes(8))
        self.assertEqual((4, 0), (receiver.faults.foreign, receiver.faults.total()))

    def test_a_frame_of_another_length_is_corrupted(self):
        receiver = wire.Receiver()
        receiver.push(ARW, b"")
        receiver.push(ARW, bytes(7))
        self.assertEqual(2, receiver.faults.corrupted)


if __name__ == "__main__":
    unittest.main()
