"""Frames of results shuffled, lost, repeated, delayed and damaged, of several channels together.
Each row has all values of exactly one sent result. Every result without a row is counted.
"""

import pytest
from davarlab.wire import frames as wire
from senders import FD, STATE, frames, joined, receive, run, seeded, shown, truth

CONTENTS = (0, 3, 7, 8)
NEAR = 2  # results: within this distance the order does not matter
OF_NO_RESULT = (5, 6)  # DAVAR_Health, DAVAR_Setup
EPOCH_20 = 20 * 100 + 99  # of results[20]


def shuffled(sent, source, span):
    """Any order within blocks of this many frames."""
    blocks = [sent[at : at + span] for at in range(0, len(sent), span)]
    for block in blocks:
        source.shuffle(block)
    return joined(blocks)


def delayed(sent, source, rate, far):
    """Delays some frames by up to `far` frames."""
    places = [at + source.uniform(0, far) * (source.random() < rate) for at in range(len(sent))]
    return [sent[at] for at in sorted(range(len(sent)), key=places.__getitem__)]


def mixed(streams, source):
    """Frames of several channels, each in its order."""
    left, out = [list(reversed(one)) for one in streams], []
    while any(left):
        out.append(source.choice([one for one in left if one]).pop())
    return out


def damaged(frame, source):
    """One or two bits, or a burst of up to eight after Crc: Crc detects these in eight bytes."""
    identifier, data = frame
    bits, size = int.from_bytes(data, "big"), 8 * len(data)
    burst = source.randrange(1, 256) << source.randrange(size - 15)
    flip = source.choice((1 << source.randrange(size), burst))
    return identifier, (bits ^ flip).to_bytes(len(data), "big")


def assert_bound(runs, sent):
    """Every row is one complete sent result. No row repeats, and rows are in order. Every frame is
    counted once, and every result whose State arrived is a row or counted. Returns the rows and the
    faults.
    """
    receiver, found = receive(sent)
    said = {channel: truth(one) for channel, one in runs.items()}
    for result in found:
        assert said[result.channel].get(result.epoch) == shown(result), result.epoch
    keys = [(result.channel, result.stretch, result.epoch) for result in found]
    assert len(keys) == len(set(keys))
    for channel in runs:
        mine = [key for key in keys if key[0] == channel]
        assert mine == sorted(mine)
    faults = receiver.faults
    kinds = (faults.good, faults.repeated, faults.corrupted, faults.impossible, faults.foreign)
    assert sum(kinds) == len(sent)
    states = {
        (identifier, data)
        for identifier, data in sent
        if (identifier - 0x5D0) % 16 in (STATE, FD) and data[0] == wire.crc(identifier, data)
    }
    assert len(states) == len(found) + faults.incomplete_results + faults.late_results
    return found, faults


@pytest.mark.parametrize("content", CONTENTS)
def test_any_order_within_two_results(content):
    for seed in range(6):
        source, one = seeded("near", content, seed), run(seed, 60, session=7, content=content)
        begin = len(one.results[0])  # Sequence must receive the first result
        sent = frames(one)
        rest = shuffled(sent[begin:], source, NEAR * len(one.results[1]))
        found, faults = assert_bound({0: one}, sent[:begin] + rest)
        assert (faults.incomplete_results, faults.restarts) == (0, 0)
        assert len(found) + faults.late_results == 60


@pytest.mark.parametrize("content", CONTENTS)
def test_every_frame_of_a_result_replaced_by_that_of_another_or_lost(content):
    """Sixteen results later Result is the same: one frame, or all but one."""
    one = run(5, 40, session=7, content=content)
    usual, later = one.results[20], one.results[36]
    values = {at for at, (name, _) in enumerate(usual) if name & 15 not in OF_NO_RESULT}
    for at in values:
        for swapped in ({at}, values - {at}):
            mixture = [later[n] if n in swapped else frame for n, frame in enumerate(usual)]
            sent = joined([*one.results[16:20], mixture, *one.results[21:30]])
            receiver, found = receive(sent)
            said = truth(one)
            assert all(said.get(result.epoch) == shown(result) for result in found)
            assert EPOCH_20 not in [result.epoch for result in found]
            assert receiver.faults.incomplete_results == 1
    for at, (name, _) in enumerate(usual):
        short = usual[:at] + usual[at + 1 :]
        sent = joined([*one.results[16:20], short, *one.results[21:30]])
        found, faults = assert_bound({0: one}, sent)
        of_result = name & 15 not in OF_NO_RESULT
        assert (len(found), faults.missing) == (14 - of_result, 1)
        assert faults.incomplete_results == (of_result and name & 15 not in (STATE, FD))


@pytest.mark.parametrize("content", [3, 8])
def test_damage_of_a_state_that_passes_crc(content):
    """Bursts across Crc and byte 1: only the digest detects them."""
    one = run(8, 30, session=7, content=content)
    identifier, data = one.results[20][0]
    size, passed = 8 * len(data), 0
    for flip in {burst << at for at in range(size - 15, size - 8) for burst in range(1, 256)}:
        other = (int.from_bytes(data, "big") ^ flip).to_bytes(len(data), "big")
        if other[0] == wire.crc(identifier, other):
            passed += 1
            changed = [(identifier, other), *one.results[20][1:]]
            receiver, found = receive(joined([*one.results[16:20], changed, *one.results[21:26]]))
            said = truth(one)
            assert all(said.get(result.epoch) == shown(result) for result in found)
            assert EPOCH_20 not in [result.epoch for result in found]
    assert passed > 2


@pytest.mark.parametrize("limit", [4000, pytest.param(50_000, marks=pytest.mark.slow)])
def test_lost_repeated_delayed_and_damaged_frames_of_three_channels(limit):
    done = rows = seed = 0
    while done < limit:
        source = seeded("all", seed)
        content = source.choice(CONTENTS)
        runs = {
            channel: run(seed % 40 + channel, 90, 7 + channel, content=content, channel=channel)
            for channel in (0, 1, 5)
        }
        streams = []
        for one in runs.values():
            begin, per = sum(map(len, one.results[:2])), len(one.results[1])
            sent, rest = frames(one), []
            for frame in sent[begin:]:
                kind = int(source.random() / 0.03)
                done += kind < 3
                rest += {0: [], 1: [frame] * 2}.get(
                    kind, [damaged(frame, source) if kind == 2 else frame]
                )
            far = source.choice((0, per // 2, NEAR * per))
            done += len(rest) // 5 if far else 0
            streams.append(sent[:begin] + delayed(rest, source, 0.2, far))
        rows += len(assert_bound(runs, mixed(streams, source))[0])
        seed += 1
    assert rows > 20 * seed
