"""davarlab live when a call fails, a signal arrives or the disk is full, at each place in turn. It
ends with status 0, or with 2 and one line. The record has complete rows; each is correct and occurs
once, and missing ones are counted. Also when it is killed at every frame and started again.
"""

import argparse
import contextlib
import csv
import errno
import fcntl
import io
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import termios
import unittest
from pathlib import Path
from unittest import mock

from davarlab.wire import frames as wire
from davarlab.wire import live, raw_record, record
from senders import ROOT, frames, run, seeded
from test_raw import counts, stream

WATCHED = (live.__file__, wire.__file__, record.__file__, raw_record.__file__)
LINES_APART = 23
RESULTS = 20

# Runs davarlab live in a child process for every fault. argv: folder, frames as SLCAN text. It
# reads a line of faults on standard input and writes an answer on standard output.
DRIVER = """
import argparse, ctypes, json, os, pty, sys, tty
from davarlab import errors
from davarlab.wire import frames as wire, live, source
source.POLL_S = 0.02
wire.messages_of(wire.DBC_PATH)  # cantools gives a failed allocation another name
arm = ctypes.CDLL(None).arm_fault
folder, text = sys.argv[1], bytes.fromhex(sys.argv[2])

def command(options):
    try:
        return live.run(options)
    except errors.BadInput as why:
        print("davarlab:", why, file=sys.stderr)
        return 2
    except MemoryError:
        print("davarlab: not enough memory", file=sys.stderr)
        return 2
    except OSError as why:
        return errors.outside_error(why)
    except Exception as why:
        return errors.internal_error(why)

for fault in sys.stdin:
    ours, its = pty.openpty()
    tty.setraw(its)
    where = f"{folder}/board"
    if os.path.lexists(where):
        os.unlink(where)
    os.symlink(os.ttyname(its), where)
    os.write(ours, text)
    child = os.fork()
    if not child:
        for number, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(f"{folder}/{name}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        options = argparse.Namespace(
            source="slcan:" + where, base=wire.BASE, record=f"{folder}/arw.csv",
            raw=f"{folder}/raw.csv", count=None, idle=0.1, json=True)
        arm(fault.strip().encode())
        os._exit(command(options))
    _, status = os.waitpid(child, 0)
    os.close(ours)
    os.close(its)
    print(os.waitstatus_to_exitcode(status), flush=True)
"""


class Sender:
    """A source of frames that replaces an interface; at(n) is called before the n-th."""

    def __init__(self, sent, at=lambda n: None):
        self.sent, self.at = sent, at

    def __call__(self, name, faults, say):
        return self

    def frames(self, idle_s, stopped):
        for n, frame in enumerate(self.sent):
            self.at(n)
            if stopped():
                return
            yield frame

    def close(self):
        pass


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.record, self.raw = self.folder / "arw.csv", self.folder / "raw.csv"
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            self.addCleanup(signal.signal, number, signal.signal(number, signal.SIG_DFL))
        self.sent = stream(counts(seeded("live faults"), 300, gaps=0), session=7)
        self.shown, self.told = self.live(Sender(self.sent))
        self.rows, self.samples = (
            self.record.read_text().splitlines(),
            self.raw.read_text().splitlines(),
        )
        self.assertEqual(len(self.shown), len(self.rows) - 1)
        self.assertEqual(300, len(self.samples) - 3)
        self.fresh()

    def fresh(self):
        for path in self.folder.glob("*.csv"):
            path.unlink()

    def live(self, sender, status=0):
        """Runs the command in this process; returns the lines that it shows, and its messages."""
        out, said = io.StringIO(), io.StringIO()
        with (
            mock.patch.object(live, "Source", sender),
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(said),
        ):
            self.assertEqual(
                status,
                live.run(
                    argparse.Namespace(
                        source="can:x",
                        base=wire.BASE,
                        record=str(self.record),
                        raw=str(self.raw),
                        count=None,
                        idle=None,
                        json=True,
                    )
                ),
            )
        return out.getvalue().splitlines(), said.getvalue()

    def recorded(self):
        """(rows, samples) in the files, including the header. Each must be complete."""
        found = []
        for path in (self.record, self.raw):
            text = path.read_text() if path.exists() else ""
            self.assertTrue(text.endswith("\n") or not text)
            found.append(text.splitlines())
        return found


class Signals(Case):
    def test_at_every_line_of_the_program(self):
        """Everything read from the source is shown and recorded, or certainly not: nothing is
        partial, nothing repeats.
        """
        line = ended = 1
        while ended:
            left = line

            def trace(frame, event, value, line=line):
                nonlocal left
                if frame.f_code.co_filename not in WATCHED:
                    return None
                left -= event == "line"
                if left == 0 and event == "line":
                    signal.raise_signal(
                        (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)[line // LINES_APART % 3]
                    )
                return trace

            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, lambda *_: None)  # before the first line of live.run
            before = sys.gettrace()
            sys.settrace(trace)
            try:
                shown, told = self.live(Sender(self.sent))
            finally:
                sys.settrace(before)
            rows, samples = self.recorded()
            with self.subTest(line=line):
                for wanted, found in zip(
                    map(json.loads, self.shown), map(json.loads, shown)
                ):  # some without a name or a time yet
                    self.assertEqual(wanted["epoch"], found["epoch"])
                    self.assertEqual(
                        {},
                        {
                            name: value
                            for name, value in found.items()
                            if name in wanted and value != wanted[name]
                        },
                    )
                self.assertEqual(
                    [json.loads(line)["epoch"] for line in shown],
                    [int(row.split(",")[2]) for row in rows[1:]],
                )
                self.assertEqual(self.samples[: len(samples)], samples)
                self.assertEqual(1, told.count("received: "))
                self.assertNotIn("not recorded", told)
            self.fresh()
            ended = left <= 0
            line += LINES_APART
        self.assertGreater(line, 2000)

    def test_while_the_reader_does_not_read(self):
        """One signal is enough, and what was received is recorded."""
        reader, writer = os.pipe()
        self.addCleanup(os.close, reader)
        child = os.fork()
        if not child:
            os.dup2(writer, 1)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            sys.stdout = os.fdopen(1, "w", encoding="ascii")
            os.close(writer)
            sent = frames(run(1, 900, session=7))
            with mock.patch.object(live, "Source", Sender(sent)):
                signal.setitimer(signal.ITIMER_REAL, 0.2, 0.2)
                signal.signal(
                    signal.SIGALRM,
                    lambda *_: (
                        signal.raise_signal(signal.SIGTERM) if self.is_full(reader) else None
                    ),
                )
                os._exit(
                    live.run(
                        argparse.Namespace(
                            source="can:x",
                            base=wire.BASE,
                            record=str(self.record),
                            raw=None,
                            count=None,
                            idle=None,
                            json=True,
                        )
                    )
                )
        os.close(writer)
        self.assertEqual(0, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        rows, _ = self.recorded()
        self.assertGreater(len(rows), 100)

    @staticmethod
    def is_full(reader):
        waiting = bytearray(4)
        fcntl.ioctl(reader, termios.FIONREAD, waiting)
        return int.from_bytes(waiting, "little") > 60000


class Disk(Case):
    def test_a_disk_that_is_full_after_any_byte_and_has_room_later(self):
        size, (soft, hard) = self.size(), resource.getrlimit(resource.RLIMIT_FSIZE)
        self.addCleanup(resource.setrlimit, resource.RLIMIT_FSIZE, (soft, hard))
        later = len(self.sent) * 3 // 4
        for limit in range(size + 1):
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
            shown, told = self.live(
                Sender(
                    self.sent,
                    lambda n: (
                        n == later and resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
                    ),
                )
            )
            rows, samples = self.recorded()
            with self.subTest(limit=limit):
                self.assertEqual(self.shown, shown)
                self.in_order(self.rows, rows)
                self.in_order(self.samples, samples)
                self.assertEqual(len(self.rows), len(rows) + self.lost(told, "results"))
                self.assertEqual(len(self.samples), len(samples) + self.lost(told, "raw samples"))
            self.fresh()

    def size(self):
        self.live(Sender(self.sent))
        size = max(path.stat().st_size for path in (self.record, self.raw))
        self.fresh()
        return size

    @staticmethod
    def lost(told, what):
        found = re.search(rf": (\d+) {what} not recorded$", told, re.MULTILINE)
        return int(found[1]) if found else 0

    def in_order(self, wanted, found):
        left = iter(wanted)
        self.assertTrue(all(line in left for line in found), found)


class Killed(Case):
    def test_at_every_frame_and_started_again(self):
        """A killed receiver has written complete rows, and the next one appends to them. No row is
        wrong or repeated.
        """
        sent = frames(run(1, RESULTS, session=7))
        self.live(Sender(sent))
        truth = {row["epoch"]: row for row in self.rows_of(self.record)}
        self.assertEqual(RESULTS, len(truth))
        self.fresh()
        for cut in range(0, len(sent), 3):
            receiver, recorder = wire.Receiver(), record.Recorder(self.record)
            for frame in sent[:cut]:
                result = receiver.push(*frame)
                if result:
                    recorder.add(result, result.of)
            recorder.output.file.close()  # killed: nothing is flushed or closed
            before = self.record.read_bytes()
            waited = len(recorder.waiting)  # 35 results at most
            self.live(Sender(sent[cut:]))
            self.assertTrue(self.record.read_bytes().startswith(before))
            rows = [
                row for path in self.folder.glob("arw*.csv") for row in self.rows_of(path)
            ]  # arw-2.csv: the columns had no names before the end
            with self.subTest(cut=cut):
                self.assertEqual(
                    len({row["epoch"] for row in rows}),
                    len(rows),
                    "the sender went on: each of its results once",
                )
                self.assertGreaterEqual(
                    len(rows),
                    RESULTS - waited - 3,
                    "all but rows that waited for their names, and what was on its way",
                )
                for row in rows:
                    true = truth[row["epoch"]]
                    self.assertEqual(
                        {},
                        {
                            name: value
                            for name, value in row.items()
                            if value and name in true and name != "stretch" and true[name] != value
                        },
                    )
            self.fresh()

    @staticmethod
    def rows_of(path):
        with open(path, encoding="ascii") as file:
            return list(csv.DictReader(file))


class Calls(Case):
    def setUp(self):
        super().setUp()
        interposer, self.mark = self.folder / "faults.so", self.folder / "mark"
        subprocess.run(
            [
                "cc",
                "-shared",
                "-fPIC",
                "-O1",
                "-DALLOCATIONS",
                "-o",
                interposer,
                ROOT / "tests/cli/faults.c",
                "-ldl",
            ],
            check=True,
        )
        self.small = frames(run(1, 6, session=7, content=0))
        text = b"".join(
            b"t%03X%d%s\r" % (one, len(data), data.hex().upper().encode())
            for one, data in self.small
        )
        self.assertLess(len(text), 4096)
        self.driver = subprocess.Popen(
            [sys.executable, "-B", "-c", DRIVER, self.folder, text.hex()],
            cwd=ROOT / "tools/lab",
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=dict(
                os.environ,
                LD_PRELOAD=str(interposer),
                FAULT="",
                FAULT_MARK=str(self.mark),
                PYTHONMALLOC="malloc",
            ),
        )
        self.addCleanup(self.driver.wait)
        self.addCleanup(self.driver.stdin.close)
        self.addCleanup(self.driver.stdout.close)
        self.assertEqual(0, self.faulty(":"))
        self.wanted, _ = self.recorded()
        self.assertEqual(7, len(self.wanted))

    def faulty(self, fault):
        for path in (self.record, self.raw, self.mark):
            path.unlink(missing_ok=True)
        print(fault, file=self.driver.stdin, flush=True)
        return int(self.driver.stdout.readline())

    def check(self, status):
        said, (rows, _) = (self.folder / "err").read_text(), self.recorded()
        if (
            "SystemError" not in said
        ):  # of the interpreter, which loses an exception that it could not allocate
            self.assertIn(status, (0, 2), said)
        self.assertNotIn("Traceback", said)
        if status == 2:
            self.assertRegex(
                said, r"davarlab: [^\n]+\n\Z"
            )  # after a line that could not be ended, where that failed
        self.assertEqual([], [row for row in rows if row not in self.wanted])
        self.assertEqual(len(rows), len(set(rows)))
        if status == 0 and len(rows) < len(self.wanted):
            counted = re.search("received: (.*)", said)
            faults = (
                sum(
                    int(count)
                    for count, name in re.findall(r"(\d+) ([a-z ]+)", counted[1])
                    if name in ("missing", "doubtful results", "noise", "orphaned")
                )
                if counted
                else 0
            )
            self.assertGreater(faults + Disk.lost(said, "results"), 0, said)

    def test_a_call_that_fails(self):
        for function, cause in (
            ("read", errno.EIO),
            ("write", errno.EIO),
            ("write", errno.ENOSPC),
            ("open", errno.EMFILE),
            ("fstat64", errno.EIO),
            ("tcgetattr", errno.EIO),
            ("tcsetattr", errno.EIO),
            ("lseek64", errno.EIO),
            ("ftruncate64", errno.EIO),
        ):
            n, ends = 1, {0: 0, 2: 0}
            while (
                status := self.faulty(f"{function}:{cause}:{n}")
            ) is not None and self.mark.exists():
                with self.subTest(function=function, cause=cause, n=n):
                    self.check(status)
                    ends[status] += 1
                n += 1
            print(f"{function}: {ends}", flush=True)

    def test_an_allocation_that_fails(self):
        n, ends = 1, {}
        while (
            status := self.faulty(f"malloc:{errno.ENOMEM}:{n}")
        ) is not None and self.mark.exists():
            with self.subTest(n=n):
                self.check(status)
            ends[status] = ends.get(status, 0) + 1
            n += 1 + n // 16
        print(f"malloc: {ends} up to the {n}th", flush=True)
        self.assertGreater(n, 1000)


if __name__ == "__main__":
    unittest.main()
