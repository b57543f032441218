"""Correct frames, wrongly delivered: senders restart at any frame, and frames are lost, repeated
and swapped. Each result from the receiver was sent, none repeats, and losses are counted.

DAVAR_WIRE_STREAMS: number of random streams (default 60).
"""

import os
import struct
import unittest

from davarlab.wire import frames as wire
from senders import END, FD, STATE, Run, disturbed, frames, run, seeded
from test_binding import receive, shown, truth

STREAMS = int(os.environ.get("DAVAR_WIRE_STREAMS", "60"))
CONTENTS = (0, 3, 7, 8)


class Restart(unittest.TestCase):
    def check(self, runs, found, told=None):
        """Each section is of one run, in the order of time, and no epoch repeats."""
        keys = [(result.channel, result.stretch, result.epoch) for result in found]
        self.assertEqual(sorted(set(keys)), keys, told)
        said, at = [truth(one) for one in runs], 0
        for stretch in sorted({result.stretch for result in found}):
            of = [result for result in found if result.stretch == stretch]
            fits = [
                n
                for n in range(at, len(runs))
                if all(said[n].get(result.epoch) == shown(result) for result in of)
            ]
            self.assertTrue(fits, (told, stretch, of[:3]))
            at = fits[0]

    def test_the_same_bytes_twice_are_two_stretches(self):
        one = run(1, 60, session=7)
        receiver, found = receive(frames(one) * 2)
        self.check([one, one], found)
        self.assertEqual(
            (120, 1, 0), (len(found), receiver.faults.restarts, receiver.faults.total())
        )

    def test_a_sender_without_session_is_identified_by_its_epoch(self):
        for first, second in ((60, 60), (3, 60), (1, 2), (17, 40)):
            runs = [run(1, first, session=0), run(2, second, session=0)]
            receiver, found = receive(frames(runs[0]) + frames(runs[1]))
            self.check(runs, found)
            self.assertEqual((first + second, 1), (len(found), receiver.faults.restarts))

    def test_a_sender_whose_epoch_continues_is_identified_by_its_session(self):
        """A restored state, or a restart after a long silence."""
        runs = [run(1, 20, session=7), run(2, 20, session=8, first=2000)]
        receiver, found = receive(frames(runs[0]) + frames(runs[1]))
        self.check(runs, found)
        self.assertEqual(
            (40, 1, 0), (len(found), receiver.faults.restarts, receiver.faults.incomplete_results)
        )

    def test_a_state_that_is_swapped_with_the_next(self):
        for content in (3, 8):
            one = run(3, 40, session=1, content=content)
            sent = frames(one)
            places = [
                at for at, (identifier, _) in enumerate(sent) if identifier & 15 in (STATE, FD)
            ]
            for n in range(5, 30):
                stream = list(sent)
                stream[places[n]], stream[places[n + 1]] = stream[places[n + 1]], stream[places[n]]
                receiver, found = receive(stream)
                self.check([one], found)
                self.assertEqual(
                    (40, 0, 1), (len(found), receiver.faults.restarts, receiver.faults.swapped)
                )

    def test_a_restart_at_every_frame(self):
        """Only results that were not sent are lost: each complete result arrives complete."""
        for sessions in ((7, 9), (0, 0)):
            for content in CONTENTS:
                runs = [
                    run(4, 3 if content else 18, sessions[0], content=content),
                    run(5, 3, sessions[1], content=content),
                ]
                for cut in range(len(frames(runs[0])) + 1):
                    receiver, found = receive(frames(runs[0])[:cut] + frames(runs[1]))
                    with self.subTest(sessions=sessions, content=content, cut=cut):
                        self.check(runs, found)
                        whole = self.whole(runs[0], cut)
                        self.assertGreaterEqual(len(found), whole + 3)
                        self.assertLessEqual(receiver.faults.restarts, 1)

    @staticmethod
    def whole(one, cut):
        """The number of results within the first frames of a run."""
        count = 0
        for result in one.results[:-1]:
            cut -= len(result)
            count += cut >= 0
        return count

    def test_random_streams(self):
        for seed in range(STREAMS):
            source = seeded(seed)
            content, runs, stream, rate = (
                source.choice(CONTENTS),
                [],
                [],
                source.choice((0, 0.02, 0.1)),
            )
            for session in source.sample(range(1, 256), source.randrange(1, 5)):
                one = run(
                    source.randrange(10**6),
                    source.randrange(4, 90),
                    session,
                    source.choice((1, 10, 100)),
                    content,
                    source.choice((0, 0, 5000)),
                )
                begin = sum(map(len, one.results[:3]))  # session and stride have been sent
                end = source.choice(
                    (len(frames(one)), source.randrange(begin, len(frames(one)) + 1))
                )
                runs.append(one)
                stream += frames(one)[:begin] + disturbed(
                    Run([frames(one)[begin:end]]), source, rate
                )
            receiver, found = receive(stream)
            with self.subTest(seed=seed):
                self.check(runs, found, seed)
                self.assertGreaterEqual(receiver.faults.restarts, len(runs) - 1)

    def test_losses_are_counted(self):
        """Up to 15 frames of an identifier in a row: counted exactly, results too."""
        for seed in range(STREAMS):
            source = seeded("losses", seed)
            one = run(source.randrange(10**6), 60, session=5, content=source.choice(CONTENTS))
            begin, end = sum(map(len, one.results[:2])), sum(map(len, one.results[:-2]))
            out, lost, states = frames(one)[:begin], 0, 0
            for frame in frames(one)[begin:end]:
                if source.random() < 0.05:
                    lost += 1
                    states += frame[0] & 15 in (STATE, FD)
                else:
                    out.append(frame)
            receiver, found = receive(out + frames(one)[end:])
            with self.subTest(seed=seed):
                self.check([one], found, seed)
                self.assertEqual((lost, 0), (receiver.faults.missing, receiver.faults.restarts))
                self.assertEqual(60, len(found) + states + receiver.faults.incomplete_results)

    def test_a_hole_of_sixteen_results_in_the_middle_of_two(self):
        one = run(6, 60, session=5)
        for lost in (16, 32):
            for inside in range(1, len(one.results[20]) - 1):
                stream = [frame for result in one.results[:20] for frame in result] + one.results[
                    20
                ][:inside]
                stream += one.results[20 + lost][inside:] + [
                    frame for result in one.results[21 + lost :] for frame in result
                ]
                receiver, found = receive(stream)
                self.check([one], found)
                cut = inside <= [identifier & 15 for identifier, _ in one.results[20]].index(END)
                self.assertEqual(
                    (cut, 60 - lost - cut), (receiver.faults.incomplete_results, len(found))
                )

    def test_two_channels_are_restarted_apart(self):
        one, two, other = run(1, 30, 7), run(2, 10, 8), run(3, 30, 9, channel=2)
        first = frames(one) + frames(two)
        mixed = [
            frame
            for pair in zip(first, frames(other) + [None] * len(first))
            for frame in pair
            if frame
        ]
        receiver, found = receive(mixed)
        self.check([one, two], [result for result in found if result.channel == 0])
        self.assertEqual({1}, {result.stretch for result in found if result.channel == 2})
        self.assertEqual(
            (1, 2, 1),
            (receiver.faults.restarts, receiver.channels[0].stretch, receiver.channels[2].stretch),
        )


class Damage(unittest.TestCase):
    def test_impossible_values_are_rejected_and_counted(self):
        def sealed(identifier, payload):
            return bytes([wire.crc(identifier, b"\0" + payload)]) + payload

        for identifier, index, values in (
            (0x5D0, 0, (-9.7e-32, -1.0, 9.7e-32, 2e30, float("inf"))),
            (0x5D3, 0, (-9.7e-32, float("-inf"))),
            (0x5D4, 9, (float("inf"), -2.0)),
            (0x5D4, 10, (float("-inf"),)),
            (0x5D6, 0, (0.0, -1.0, float("nan"), 1e-31)),
            (0x5D6, 1, (0.0,)),
            (0x5D6, 33, (0.0,)),
            (0x5D7, 0, (float("inf"),)),
            (0x5D7, 32, (-1.0,)),
            (0x5D1, 0, (1.0,)),
        ):
            for value in values:
                receiver = wire.Receiver()
                receiver.push(
                    identifier, sealed(identifier, bytes([0, index, 0]) + struct.pack("<f", value))
                )
                self.assertEqual(
                    (1, 0),
                    (receiver.faults.impossible, receiver.faults.good),
                    (hex(identifier), value),
                )

    def test_values_of_three_to_six_bit_errors_that_pass_the_crc_are_in_range(self):
        """Python's receiver and the device's decoder reject the same frames, and no impossible
        number passes.
        """
        source, one = seeded("bits"), run(8, 20, session=3)
        receiver, passed = wire.Receiver(), 0
        for _ in range(100):
            for identifier, data in frames(one):
                bits = int.from_bytes(data, "little")
                for bit in source.sample(range(64), source.randrange(3, 7)):
                    bits ^= 1 << bit
                damaged = bits.to_bytes(8, "little")
                passed += damaged[0] == wire.crc(identifier, damaged)
                receiver.push(identifier, damaged)
        self.assertGreater(passed, 100)
        self.assertGreater(receiver.faults.impossible, 5)

    def test_a_stream_with_bit_errors_shows_no_impossible_value(self):
        source, one = seeded("more bits"), run(9, 400, session=3)
        stream = []
        for identifier, data in frames(one):
            bits = int.from_bytes(data, "little")
            for bit in (
                source.sample(range(64), source.randrange(3, 7)) if source.random() < 0.3 else ()
            ):
                bits ^= 1 << bit
            stream.append((identifier, bits.to_bytes(8, "little")))
        receiver, found = receive(stream)
        self.assertGreater(receiver.faults.corrupted + receiver.faults.impossible, 500)
        for result in found:
            for value in [
                *result.adev.values(),
                *(v for k, v in result.values.items() if k.startswith("arw_deg")),
            ]:
                self.assertTrue(value != value or value == 0 or 1e-30 <= value <= 1e30, result)


if __name__ == "__main__":
    unittest.main()
