"""Frames shuffled, lost, repeated, delayed, swapped and damaged, of several channels and of senders
that restart at any frame. Each row has all values of exactly one sent result, none repeats, and
every result without a row is counted.
"""

import itertools
import math
import struct

import pytest
from davar.wire import frames as wire
from senders import (
    END,
    FD,
    STATE,
    disturbed,
    frames,
    joined,
    receive,
    run,
    sealed,
    seeded,
    shown,
    truth,
)

CONTENTS = (0, 3, 7, 8)
NEAR = 2  # results: within this distance the order does not matter
OF_NO_RESULT = (5, 6)  # DAVAR_Health, DAVAR_Setup
EPOCH_20 = 20 * 100 + 99  # of results[20]
STREAMS = [(0, 8), pytest.param(8, 60, marks=pytest.mark.slow)]


def is_state(frame):
    return frame[0] & 15 in (STATE, FD)


def assert_sound(runs, sent):
    """runs: {channel: its runs in the order of time}. Each section is of one of them and each row a
    complete result; no epoch repeats; every frame is counted once. Returns the rows and the faults.
    """
    receiver, found = receive(sent)
    for channel, of_channel in runs.items():
        mine = [result for result in found if result.channel == channel]
        keys = [(result.stretch, result.epoch) for result in mine]
        assert keys == sorted(set(keys))
        said = [truth(one) for one in of_channel]
        for _, section in itertools.groupby(mine, key=lambda result: result.stretch):
            rows = {result.epoch: shown(result) for result in section}
            while said and not rows.items() <= said[0].items():
                said.pop(0)
            assert said, (channel, list(rows)[:3])
    assert {result.channel for result in found} <= set(runs)
    faults = receiver.faults
    kinds = (faults.good, faults.repeated, faults.corrupted, faults.impossible, faults.foreign)
    assert sum(kinds) == len(sent)
    return found, faults


def assert_bound(runs, sent):
    """Also: every result of one run in a channel whose State arrived is a row or counted."""
    found, faults = assert_sound({channel: [one] for channel, one in runs.items()}, sent)
    states = {one for one in sent if is_state(one) and one[1][0] == wire.crc(*one)}
    assert len(states) == len(found) + faults.incomplete_results + faults.late_results
    return found, faults


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
            found, faults = assert_sound({0: [one]}, sent)
            assert EPOCH_20 not in [result.epoch for result in found]
            assert faults.incomplete_results == 1
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
            sent = joined([*one.results[16:20], changed, *one.results[21:26]])
            found, _ = assert_sound({0: [one]}, sent)
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


# --- restarts

# (Results, session, first sample) of two runs: the same bytes twice; senders without session, which
# are identified by their epoch; a restored state, or a restart after a long silence.
TWICE = [((60, 7, 0), (60, 7, 0)), ((20, 7, 0), (20, 8, 2000))]
TWICE += [((n, 0, 0), (m, 0, 0)) for n, m in ((60, 60), (3, 60), (1, 2), (17, 40))]


@pytest.mark.parametrize(("first", "second"), TWICE)
def test_two_runs_are_two_sections(first, second):
    other = 1 if first == second and first[1] else 2  # the seed of its values
    runs = [run(1, *first[:2], first=first[2]), run(other, *second[:2], first=second[2])]
    found, faults = assert_sound({0: runs}, frames(runs[0]) + frames(runs[1]))
    assert (len(found), faults.restarts) == (first[0] + second[0], 1)
    assert faults.incomplete_results == 0


def test_two_channels_are_restarted_apart():
    one, two, other = run(1, 30, 7), run(2, 10, 8), run(3, 30, 9, channel=2)
    pairs = itertools.zip_longest(frames(one) + frames(two), frames(other))
    sent = [frame for pair in pairs for frame in pair if frame]
    found, faults = assert_sound({0: [one, two], 2: [other]}, sent)
    assert {result.stretch for result in found if result.channel == 2} == {1}
    assert {result.stretch for result in found if result.channel == 0} == {1, 2}
    assert faults.restarts == 1


@pytest.mark.parametrize("content", [3, 8])
def test_a_state_that_is_swapped_with_the_next(content):
    one = run(3, 40, session=1, content=content)
    sent = frames(one)
    places = [at for at, frame in enumerate(sent) if is_state(frame)]
    for a, b in zip(places[5:30], places[6:31]):
        swapped = list(sent)
        swapped[a], swapped[b] = sent[b], sent[a]
        found, faults = assert_sound({0: [one]}, swapped)
        assert (len(found), faults.restarts, faults.swapped) == (40, 0, 1)


@pytest.mark.parametrize("sessions", [(7, 9), (0, 0)])
@pytest.mark.parametrize("content", CONTENTS)
def test_a_restart_at_every_frame(sessions, content):
    """Only results that were not sent are lost: each complete result arrives complete."""
    first = run(4, 3 if content else 18, sessions[0], content=content)
    runs = [first, run(5, 3, sessions[1], content=content)]
    ends = list(itertools.accumulate(map(len, first.results[:-1])))
    for cut in range(len(frames(first)) + 1):
        found, faults = assert_sound({0: runs}, frames(first)[:cut] + frames(runs[1]))
        assert len(found) >= sum(end <= cut for end in ends) + 3, cut
        assert faults.restarts <= 1


@pytest.mark.parametrize(("begin", "end"), STREAMS)
def test_random_streams(begin, end):
    for seed in range(begin, end):
        source = seeded(seed)
        content, rate = source.choice(CONTENTS), source.choice((0, 0.02, 0.1))
        runs, sent = [], []
        for session in source.sample(range(1, 256), source.randrange(1, 5)):
            words = (source.randrange(10**6), source.randrange(4, 90), session)
            words = (*words, source.choice((1, 10, 100)), content, source.choice((0, 0, 5000)))
            runs.append(run(*words))
            all_of, known = frames(runs[-1]), sum(map(len, runs[-1].results[:3]))
            last = source.choice((len(all_of), source.randrange(known, len(all_of) + 1)))
            sent += all_of[:known] + disturbed(all_of[known:last], source, rate)
        _, faults = assert_sound({0: runs}, sent)
        assert faults.restarts >= len(runs) - 1, seed


@pytest.mark.parametrize(("begin", "end"), STREAMS)
def test_losses_are_counted(begin, end):
    """Up to 15 frames of an identifier in a row: counted exactly, results too."""
    for seed in range(begin, end):
        source = seeded("losses", seed)
        one = run(source.randrange(10**6), 60, session=5, content=source.choice(CONTENTS))
        head, tail = joined(one.results[:2]), joined(one.results[-2:])
        middle = joined(one.results[2:-2])
        kept = [frame for frame in middle if source.random() >= 0.05]
        states = sum(map(is_state, middle)) - sum(map(is_state, kept))
        found, faults = assert_sound({0: [one]}, head + kept + tail)
        assert (faults.missing, faults.restarts) == (len(middle) - len(kept), 0)
        assert len(found) + states + faults.incomplete_results == 60


@pytest.mark.parametrize("lost", [16, 32])
def test_a_hole_of_sixteen_results_in_the_middle_of_two(lost):
    one = run(6, 60, session=5)
    first, second = one.results[20], one.results[20 + lost]
    for inside in range(1, len(first) - 1):
        sent = joined(one.results[:20]) + first[:inside] + second[inside:]
        found, faults = assert_sound({0: [one]}, sent + joined(one.results[21 + lost :]))
        cut = inside <= [name & 15 for name, _ in first].index(END)
        assert (faults.incomplete_results, len(found)) == (cut, 60 - lost - cut)


def test_without_health_and_setup():
    """A filter on the way removes all other frames: only DAVAR_End shows which frames are one
    result, and of which run.
    """
    sent = frames(run(1, 900, session=7))
    receiver, found = receive([frame for frame in sent if frame[0] & 15 not in (5, 6)])
    assert [result.epoch for result in found] == list(range(99, 90000, 100))
    assert (receiver.faults.total(), receiver.channels[0].session) == (0, 7)


def test_without_the_end_of_any_result():
    """No result is complete, none is stored indefinitely, and each is counted."""
    receiver = wire.Receiver()
    for frame in frames(run(1, 900, session=7)):
        if frame[0] & 15 != END:
            assert receiver.push(*frame) is None
            assert len(receiver.channels[0].bursts) <= wire.REACH + 1
    assert receiver.finish() == []
    assert (receiver.faults.incomplete_results, receiver.faults.total()) == (900, 900)


# --- damage

IMPOSSIBLE = [
    (0x5D0, 0, (-9.7e-32, -1.0, 9.7e-32, 2e30, math.inf)),
    (0x5D3, 0, (-9.7e-32, -math.inf)),
    (0x5D4, 9, (math.inf, -2.0)),
    (0x5D4, 10, (-math.inf,)),
    (0x5D6, 0, (0.0, -1.0, math.nan, 1e-31)),
    *((0x5D6, index, (0.0,)) for index in (1, 33)),
    (0x5D7, 0, (math.inf,)),
    (0x5D7, 32, (-1.0,)),
    (0x5D1, 0, (1.0,)),
    (0x5DC, 0, (math.inf, -1.0)),
    (0x5DC, 2, (-math.inf,)),
    (0x5DC, 7 << 2, (1.0,)),  # no reason
]


@pytest.mark.parametrize(("identifier", "index", "values"), IMPOSSIBLE)
def test_impossible_values_are_rejected_and_counted(identifier, index, values):
    for value in values:
        receiver = wire.Receiver()
        receiver.push(*sealed(identifier, bytes([index, 0]) + struct.pack("<f", value)))
        assert (receiver.faults.impossible, receiver.faults.good) == (1, 0), value
