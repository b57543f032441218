"""davarlab live uses no more memory or open files the longer it runs. tests/kernel/test_day.py runs
it for a day of clock time.
"""

import argparse
import contextlib
import csv
import gc
import os
import sys
import tempfile
import unittest
from array import array
from pathlib import Path
from unittest import mock

from davarlab.wire import frames as wire
from davarlab.wire import live, record
from senders import END, run, seeded
from test_raw import counts, stream

WARM, RESTARTS = 40, 240
SETUP, HEALTH = 6, 5
BLOCKS = 60  # additional memory blocks that Python may hold; one per restart is more


def held():
    """(blocks of memory that Python holds, open files)."""
    gc.collect()
    return sys.getallocatedblocks(), len(os.listdir("/proc/self/fd"))


class Sender:
    """A source of frames that replaces an interface."""

    def __init__(self, parts):
        self.parts, self.count = parts, 0
        self.blocks, self.files = (
            array("q", bytes(8 * RESTARTS)),
            array("q", bytes(8 * RESTARTS)),
        )  # stored after each part

    def __call__(self, name, faults, say):
        return self

    def frames(self, idle_s, stopped):
        for part in self.parts:
            yield from part
            self.blocks[self.count], self.files[self.count] = held()
            self.count += 1

    def close(self):
        pass


class Growth(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def live(self, parts, **options):
        """Runs the command in this process; returns the Sender and the messages."""
        sender = Sender(parts)
        with (
            mock.patch.object(live, "Source", sender),
            tempfile.TemporaryFile("w+", encoding="utf-8") as said,
            open(os.devnull, "w", encoding="ascii") as shown,
        ):
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(shown):
                status = live.run(
                    argparse.Namespace(
                        **{
                            "source": "can:x",
                            "base": wire.BASE,
                            "record": str(self.folder / "arw.csv"),
                            "raw": None,
                            "count": None,
                            "idle": None,
                            "json": True,
                            **options,
                        }
                    )
                )
            said.seek(0)
            self.assertEqual(0, status)
            return sender, said.read()

    def test_hundreds_of_restarts(self):
        samples = counts(seeded("growth"), 300, gaps=0)
        runs = [stream(samples, session=session) for session in (7, 9)]
        sender, said = self.live(
            (runs[n % 2] for n in range(RESTARTS)), raw=str(self.folder / "raw.csv")
        )
        self.assertEqual({sender.files[WARM]}, set(sender.files[WARM:]))
        self.assertLess(
            max(sender.blocks[RESTARTS // 2 :]) - max(sender.blocks[WARM : RESTARTS // 2]), BLOCKS
        )
        self.assertIn(f" 0 doubtful samples, {RESTARTS - 1} restarts\n", said)
        raw = list(self.folder.glob("raw*.csv"))
        self.assertEqual({len(samples) + 3}, {path.read_bytes().count(b"\n") for path in raw})
        self.assertEqual(RESTARTS, len(raw))
        with open(self.folder / "arw.csv", encoding="ascii") as file:
            keys = [(int(row["stretch"]), int(row["epoch"])) for row in csv.DictReader(file)]
        self.assertEqual(
            [(stretch, epoch) for stretch in range(1, RESTARTS + 1) for epoch in (99, 199, 299)],
            [key for key in keys if key[1] < 300],
        )

    def test_rows_that_wait_for_their_names_in_hundreds_of_stretches(self):
        recorder = record.Recorder(self.folder / "x.csv")
        for stretch in range(1, 3000):
            recorder.add(
                wire.Result(0, 0, 99, {}, {0: 1.0}, stretch=stretch), wire.Channel(stretch)
            )
        self.assertLessEqual(len(recorder.patient), record.WAITING_MAX + 1)
        recorder.close()
        with open(self.folder / "x.csv", encoding="ascii") as file:
            self.assertEqual(
                list(range(1, 3000)), [int(row["stretch"]) for row in csv.DictReader(file)]
            )

    def test_without_health_and_setup(self):
        """A filter on the way removes all other frames: only DAVAR_End shows which frames are one
        result, and of which run.
        """
        one = run(1, 900, session=7)
        receiver, found = wire.Receiver(), []
        for frame in (
            frame
            for result in one.results
            for frame in result
            if frame[0] & 15 not in (SETUP, HEALTH)
        ):
            result = receiver.push(*frame)
            found += [result.epoch] if result else []
        self.assertEqual(list(range(99, 90000, 100)), found)
        self.assertEqual((0, 7), (receiver.faults.total(), receiver.channels[0].session))

    def test_without_the_end_of_any_result(self):
        """No result is complete, none is stored indefinitely, and each is counted."""
        one, receiver = run(1, 900, session=7), wire.Receiver()
        for frame in (frame for result in one.results for frame in result if frame[0] & 15 != END):
            self.assertIsNone(receiver.push(*frame))
            self.assertLessEqual(len(receiver.channels[0].bursts), wire.REACH + 1)
        self.assertEqual([], receiver.finish())
        self.assertEqual((900, 900), (receiver.faults.incomplete_results, receiver.faults.total()))


if __name__ == "__main__":
    unittest.main()
