"""davarlab live uses no more memory or open files the longer it runs. tests/kernel/test_day.py runs
it for a day of clock time.
"""

import argparse
import contextlib
import csv
import gc
import os
import sys
from array import array
from unittest import mock

import pytest
from davarlab.wire import frames as wire
from davarlab.wire import live, record
from senders import END, counts, joined, receive, run, seeded, stream

SETUP, HEALTH = 6, 5
BLOCKS = 60  # additional memory blocks that Python may hold; one per restart is more


class Sender:
    """A source of frames that replaces an interface. After each part it stores the number of
    memory blocks that Python holds, and of open files.
    """

    def __init__(self, parts, number):
        self.parts = parts
        self.blocks, self.files = (array("q", bytes(8 * number)) for _ in range(2))

    def __call__(self, name, faults, say):
        return self

    def frames(self, idle_s, stopped):
        for n, part in enumerate(self.parts):
            yield from part
            gc.collect()
            self.blocks[n] = sys.getallocatedblocks()
            self.files[n] = len(os.listdir("/proc/self/fd"))

    def close(self):
        pass


@pytest.mark.slow
def test_hundreds_of_restarts(tmp_path):
    warm, restarts = 40, 240
    samples = counts(seeded("growth"), 300, gaps=0)
    runs = [stream(samples, session=session) for session in (7, 9)]
    sender = Sender((runs[n % 2] for n in range(restarts)), restarts)
    options = {"source": "can:x", "base": wire.BASE, "count": None, "idle": None, "json": True}
    files = {"record": str(tmp_path / "arw.csv"), "raw": str(tmp_path / "raw.csv")}
    with (
        mock.patch.object(live, "Source", sender),
        open(tmp_path / "said", "w+", encoding="utf-8") as said,
        open(os.devnull, "w", encoding="ascii") as shown,
    ):
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(shown):
            assert live.run(argparse.Namespace(**options, **files)) == 0
        said.seek(0)
        assert f" 0 doubtful samples, {restarts - 1} restarts\n" in said.read()
    assert set(sender.files[warm:]) == {sender.files[warm]}
    half = restarts // 2
    assert max(sender.blocks[half:]) - max(sender.blocks[warm:half]) < BLOCKS
    raw = list(tmp_path.glob("raw*.csv"))
    assert [path.read_bytes().count(b"\n") for path in raw] == [len(samples) + 3] * restarts
    with open(tmp_path / "arw.csv", encoding="ascii") as file:
        keys = [(int(row["stretch"]), int(row["epoch"])) for row in csv.DictReader(file)]
    wanted = [(stretch, epoch) for stretch in range(1, restarts + 1) for epoch in (99, 199, 299)]
    assert [key for key in keys if key[1] < 300] == wanted


def test_rows_that_wait_for_their_names_in_hundreds_of_stretches(tmp_path):
    recorder, stretches = record.Recorder(tmp_path / "x.csv"), range(1, 500)
    for stretch in stretches:
        one = wire.Result(0, 0, 99, {}, {0: 1.0}, stretch=stretch)
        recorder.add(one, wire.Channel(stretch))
    assert len(recorder.patient) <= record.WAITING_MAX + 1
    recorder.close()
    with open(tmp_path / "x.csv", encoding="ascii") as file:
        assert [int(row["stretch"]) for row in csv.DictReader(file)] == list(stretches)


def test_without_health_and_setup():
    """A filter on the way removes all other frames: only DAVAR_End shows which frames are one
    result, and of which run.
    """
    sent = joined(run(1, 900, session=7).results)
    receiver, found = receive([frame for frame in sent if frame[0] & 15 not in (SETUP, HEALTH)])
    assert [result.epoch for result in found] == list(range(99, 90000, 100))
    assert (receiver.faults.total(), receiver.channels[0].session) == (0, 7)


def test_without_the_end_of_any_result():
    """No result is complete, none is stored indefinitely, and each is counted."""
    receiver = wire.Receiver()
    for frame in joined(run(1, 900, session=7).results):
        if frame[0] & 15 != END:
            assert receiver.push(*frame) is None
            assert len(receiver.channels[0].bursts) <= wire.REACH + 1
    assert receiver.finish() == []
    assert (receiver.faults.incomplete_results, receiver.faults.total()) == (900, 900)
