"""Correct frames, wrongly delivered: senders restart at any frame, and frames are lost, repeated
and swapped. Each result from the receiver was sent, none repeats, and losses are counted.
"""

import itertools
import math
import struct

import pytest
from davarlab.wire import frames as wire
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
STREAMS = [(0, 8), pytest.param(8, 60, marks=pytest.mark.slow)]


def assert_sections(runs, sent):
    """Each section is of one run, in the order of time, and no epoch repeats. Returns the results
    and the faults.
    """
    receiver, found = receive(sent)
    mine = [result for result in found if result.channel == 0]
    keys = [(result.stretch, result.epoch) for result in mine]
    assert keys == sorted(set(keys))
    said, at = [truth(one) for one in runs], 0
    for stretch in sorted({result.stretch for result in mine}):
        of = [result for result in mine if result.stretch == stretch]
        fits = [
            n
            for n in range(at, len(runs))
            if all(said[n].get(result.epoch) == shown(result) for result in of)
        ]
        assert fits, (stretch, of[:3])
        at = fits[0]
    return found, receiver.faults


# (Results, session, first sample) of two runs: the same bytes twice; senders without session, which
# are identified by their epoch; a restored state, or a restart after a long silence.
TWICE = [((60, 7, 0), (60, 7, 0)), ((20, 7, 0), (20, 8, 2000))]
TWICE += [((n, 0, 0), (m, 0, 0)) for n, m in ((60, 60), (3, 60), (1, 2), (17, 40))]


@pytest.mark.parametrize(("first", "second"), TWICE)
def test_two_runs_are_two_sections(first, second):
    other = 1 if first == second and first[1] else 2  # the seed of its values
    runs = [run(1, *first[:2], first=first[2]), run(other, *second[:2], first=second[2])]
    found, faults = assert_sections(runs, frames(runs[0]) + frames(runs[1]))
    assert (len(found), faults.restarts) == (first[0] + second[0], 1)
    assert faults.incomplete_results == 0


def test_two_channels_are_restarted_apart():
    one, two, other = run(1, 30, 7), run(2, 10, 8), run(3, 30, 9, channel=2)
    pairs = itertools.zip_longest(frames(one) + frames(two), frames(other))
    sent = [frame for pair in pairs for frame in pair if frame]
    found, faults = assert_sections([one, two], sent)
    assert {result.stretch for result in found if result.channel == 2} == {1}
    assert {result.stretch for result in found if result.channel == 0} == {1, 2}
    assert faults.restarts == 1


@pytest.mark.parametrize("content", [3, 8])
def test_a_state_that_is_swapped_with_the_next(content):
    one = run(3, 40, session=1, content=content)
    sent = frames(one)
    places = [at for at, (name, _) in enumerate(sent) if name & 15 in (STATE, FD)]
    for a, b in zip(places[5:30], places[6:31]):
        swapped = list(sent)
        swapped[a], swapped[b] = sent[b], sent[a]
        found, faults = assert_sections([one], swapped)
        assert (len(found), faults.restarts, faults.swapped) == (40, 0, 1)


@pytest.mark.parametrize("sessions", [(7, 9), (0, 0)])
@pytest.mark.parametrize("content", CONTENTS)
def test_a_restart_at_every_frame(sessions, content):
    """Only results that were not sent are lost: each complete result arrives complete."""
    first = run(4, 3 if content else 18, sessions[0], content=content)
    runs = [first, run(5, 3, sessions[1], content=content)]
    ends = list(itertools.accumulate(map(len, first.results[:-1])))
    for cut in range(len(frames(first)) + 1):
        found, faults = assert_sections(runs, frames(first)[:cut] + frames(runs[1]))
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
        _, faults = assert_sections(runs, sent)
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
        states = sum(frame[0] & 15 in (STATE, FD) for frame in middle) - sum(
            frame[0] & 15 in (STATE, FD) for frame in kept
        )
        found, faults = assert_sections([one], head + kept + tail)
        assert (faults.missing, faults.restarts) == (len(middle) - len(kept), 0)
        assert len(found) + states + faults.incomplete_results == 60


@pytest.mark.parametrize("lost", [16, 32])
def test_a_hole_of_sixteen_results_in_the_middle_of_two(lost):
    one = run(6, 60, session=5)
    first, second = one.results[20], one.results[20 + lost]
    for inside in range(1, len(first) - 1):
        sent = joined(one.results[:20]) + first[:inside] + second[inside:]
        found, faults = assert_sections([one], sent + joined(one.results[21 + lost :]))
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
]


@pytest.mark.parametrize(("identifier", "index", "values"), IMPOSSIBLE)
def test_impossible_values_are_rejected_and_counted(identifier, index, values):
    for value in values:
        receiver = wire.Receiver()
        receiver.push(*sealed(identifier, bytes([index, 0]) + struct.pack("<f", value)))
        assert (receiver.faults.impossible, receiver.faults.good) == (1, 0), value
