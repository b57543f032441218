"""Frames of results shuffled, lost, repeated, delayed and damaged, of several channels together.
Each row has all values of exactly one sent result. Every result without a row is counted.

DAVAR_WIRE_FAULTS: faults to inject into single frames of complete streams (default 10^6; here a
twentieth of them).
"""

import functools
import os
import unittest
from collections import Counter

import cantools
from davarlab.wire import frames as wire
from senders import FD, ROOT, STATE, frames, run, seeded

FAULTS = int(os.environ.get("DAVAR_WIRE_FAULTS", "1000000")) // 20
DBC = cantools.database.load_file(ROOT / "tools/davar.dbc", strict=True)
CONTENTS = (0, 3, 7, 8)
NEAR = 2  # results: within this distance the order does not matter


REASONS = ("mixed", "constant", "coarse", "filtered")  # why ARW is absent


def plain(value):
    named = {"absent": "nan", "beyond": "inf", **dict.fromkeys(REASONS, "nan")}
    return named.get(str(value), str(value))


@functools.cache
def truth(one):
    """{epoch: the values of a row, as the DBC reads them in the frames of one result}."""
    said = {}
    for result in one.results[:-1]:
        values, epoch = {}, None
        for identifier, data in result:
            signals = DBC.decode_message((identifier - 0x5D0) % 16 + 0x5D0, data)
            epoch = signals.get("Epoch", epoch)
            for name, value in signals.items():
                if name in wire.COLUMNS:
                    values[wire.COLUMNS[name]] = plain(value)
                    if str(value) in REASONS:
                        values["arw_withheld"] = str(value)
                elif name == "AdevDps":
                    values["adev", signals["TauIndex"]] = plain(value)
                elif name.startswith("Adev") and name.endswith("Dps"):
                    values["adev", int(name[4])] = plain(value)
        said[epoch] = values
    return said


def shown(result):
    """The values of a row, by the same rule."""
    return {
        **{
            name: value if name == "arw_withheld" else plain(value)
            for name, value in result.values.items()
        },
        **{("adev", index): plain(value) for index, value in result.adev.items()},
    }


def receive(stream):
    receiver, found = wire.Receiver(), []
    for identifier, data in stream:
        result = receiver.push(identifier, data)
        found += [result] if result else []
    return receiver, found + receiver.finish()


def shuffled(sent, source, span):
    """Any order within blocks of this many frames."""
    out = []
    for at in range(0, len(sent), span):
        block = sent[at : at + span]
        source.shuffle(block)
        out += block
    return out


def delayed(sent, source, rate, far):
    """Delays some frames by up to `far` frames."""
    return [
        frame
        for _, frame in sorted(
            (
                (at + source.uniform(0, far) * (source.random() < rate), frame)
                for at, frame in enumerate(sent)
            ),
            key=lambda one: one[0],
        )
    ]


def mixed(streams, source):
    """Frames of several channels, each in its order."""
    left = [list(reversed(one)) for one in streams]
    out = []
    while any(left):
        out.append(source.choice([one for one in left if one]).pop())
    return out


def damaged(frame, source):
    """One or two bits, or a burst of up to eight after Crc: Crc detects these in eight bytes."""
    identifier, data = frame
    bits = int.from_bytes(data, "big")
    size = 8 * len(data)
    flip = source.choice(
        (1 << source.randrange(size), source.randrange(1, 256) << source.randrange(size - 15))
    )
    return identifier, (bits ^ flip).to_bytes(len(data), "big")


class Binding(unittest.TestCase):
    def check(self, runs, found, told=None):
        """Every row is one complete sent result. No row repeats, and rows are in order."""
        said = {channel: truth(one) for channel, one in runs.items()}
        for result in found:
            self.assertEqual(
                said[result.channel].get(result.epoch),
                shown(result),
                (told, result.channel, result.epoch),
            )
        keys = [(result.channel, result.stretch, result.epoch) for result in found]
        self.assertEqual([], [key for key, count in Counter(keys).items() if count > 1], told)
        for channel in runs:
            mine = [key[1:] for key in keys if key[0] == channel]
            self.assertEqual(sorted(mine), mine, told)

    def add_up(self, stream, receiver, found, told=None):
        """Every frame is counted once, and every result whose State arrived is a row or counted."""
        faults = receiver.faults
        self.assertEqual(
            len(stream),
            faults.good + faults.repeated + faults.corrupted + faults.impossible + faults.foreign,
            (told, faults),
        )
        states = {
            (identifier, data)
            for identifier, data in stream
            if (identifier - 0x5D0) % 16 in (STATE, FD) and data[0] == wire.crc(identifier, data)
        }
        self.assertEqual(
            len(states),
            len(found) + faults.incomplete_results + faults.late_results,
            (told, faults),
        )

    def test_any_order_within_two_results(self):
        for content in CONTENTS:
            for seed in range(6):
                source, one = (
                    seeded("near", content, seed),
                    run(seed, 60, session=7, content=content),
                )
                begin = len(one.results[0])  # Sequence must receive the first result
                sent = frames(one)
                stream = sent[:begin] + shuffled(sent[begin:], source, NEAR * len(one.results[1]))
                receiver, found = receive(stream)
                with self.subTest(content=content, seed=seed):
                    self.check({0: one}, found)
                    self.add_up(stream, receiver, found)
                    self.assertEqual(
                        (0, 0), (receiver.faults.incomplete_results, receiver.faults.restarts)
                    )
                    self.assertEqual(60, len(found) + receiver.faults.late_results)

    def test_any_order_within_any_number_of_results(self):
        rows = 0
        for content in CONTENTS:
            for span in (3, 5, 8, 13, 16, 17, 32, 33, 60):
                source, one = (
                    seeded("far", content, span),
                    run(span, 60, session=7, content=content),
                )
                receiver, found = receive(shuffled(frames(one), source, span * len(one.results[1])))
                with self.subTest(content=content, span=span):
                    self.check({0: one}, found)
                    self.assertLessEqual(len(found), 60)
                rows += len(found)
        self.assertGreater(rows, 500)

    def test_every_frame_of_a_result_replaced_by_that_of_another(self):
        """Sixteen results later Result is the same: one frame, or all but one."""
        for content in CONTENTS:
            one = run(5, 40, session=7, content=content)
            values = [
                at
                for at, (identifier, _) in enumerate(one.results[20])
                if identifier & 15 not in (5, 6)
            ]
            for at in values:
                for swapped in ({at}, set(values) - {at}):
                    mixture = [
                        one.results[36][n] if n in swapped else frame
                        for n, frame in enumerate(one.results[20])
                    ]
                    stream = [
                        frame
                        for result in [*one.results[:20], mixture, *one.results[21:36]]
                        for frame in result
                    ]
                    receiver, found = receive(stream)
                    with self.subTest(content=content, at=at, swapped=len(swapped)):
                        self.check({0: one}, found)
                        self.assertNotIn(20 * 100 + 99, [result.epoch for result in found])
                        self.assertEqual(1, receiver.faults.incomplete_results)

    def test_damage_of_a_state_that_passes_crc(self):
        """Bursts across Crc and byte 1: only the digest detects them."""
        for content in (3, 8):
            one = run(8, 30, session=7, content=content)
            identifier, data = one.results[20][0]
            size, passed = 8 * len(data), 0
            for flip in {
                burst << at for at in range(size - 15, size - 8) for burst in range(1, 256)
            }:
                other = (int.from_bytes(data, "big") ^ flip).to_bytes(len(data), "big")
                if other[0] == wire.crc(identifier, other):
                    passed += 1
                    stream = [
                        (identifier, other) if frame is one.results[20][0] else frame
                        for frame in frames(one)
                    ]
                    _, found = receive(stream)
                    self.check({0: one}, found)
                    self.assertNotIn(20 * 100 + 99, [result.epoch for result in found])
            self.assertGreater(passed, 2)

    def test_every_frame_of_a_result_lost(self):
        for content in CONTENTS:
            one = run(6, 30, session=7, content=content)
            for lost, (identifier, _) in enumerate(one.results[20]):
                kind = identifier & 15
                stream = [
                    frame
                    for n, result in enumerate(one.results)
                    for at, frame in enumerate(result)
                    if (n, at) != (20, lost)
                ]
                receiver, found = receive(stream)
                with self.subTest(content=content, lost=kind):
                    self.check({0: one}, found)
                    self.assertEqual(30 - (kind not in (5, 6)), len(found))
                    self.assertEqual(
                        kind not in (5, 6, STATE, FD), receiver.faults.incomplete_results
                    )
                    self.assertEqual(1, receiver.faults.missing)

    def test_lost_repeated_delayed_and_damaged_frames_of_three_channels(self):
        done = rows = 0
        seed = 0
        while done < FAULTS:
            source = seeded("all", seed)
            content = source.choice(CONTENTS)
            runs = {
                channel: run(
                    seed % 40 + channel, 90, session=7 + channel, content=content, channel=channel
                )
                for channel in (0, 1, 5)
            }
            streams = []
            for one in runs.values():
                begin, per = sum(map(len, one.results[:2])), len(one.results[1])
                stream = []
                for frame in frames(one)[begin:]:
                    kind = source.random()
                    done += kind < 0.09
                    stream += (
                        []
                        if kind < 0.03
                        else [frame] * 2
                        if kind < 0.06
                        else [damaged(frame, source)]
                        if kind < 0.09
                        else [frame]
                    )
                far = source.choice((0, per // 2, NEAR * per))
                done += len(stream) // 5 if far else 0
                streams.append(frames(one)[:begin] + delayed(stream, source, 0.2, far))
            stream = mixed(streams, source)
            receiver, found = receive(stream)
            with self.subTest(seed=seed):
                self.check(runs, found, seed)
                self.add_up(stream, receiver, found, seed)
            rows += len(found)
            seed += 1
        self.assertGreater(rows, 20 * seed)


if __name__ == "__main__":
    unittest.main()
