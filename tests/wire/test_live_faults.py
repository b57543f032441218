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
import termios
from unittest import mock

import pytest
from davar.wire import frames as wire
from davar.wire import live, raw_record, record
from interposed import STOPS, default_signals, environment, every, interposer
from senders import counts, frames, run, seeded, slcan, stream

pytestmark = pytest.mark.slow

WATCHED = (live.__file__, wire.__file__, record.__file__, raw_record.__file__)
LINES_APART = 97
RESULTS = 20

# Runs davarlab live in a child process for every fault. argv: folder, frames as SLCAN text. It
# reads a line of faults on standard input and writes an answer on standard output.
DRIVER = """
import ctypes, os, pty, sys, tty
from davarlab import cli
from davar.wire import frames, live, source
source.POLL_S = 0.02
cli.arithmetic.prepared()
cli.arithmetic.prepared = lambda: None  # it reads files of the system
frames.messages_of(frames.DBC_PATH)  # cantools gives a failed allocation another name
arm = ctypes.CDLL(None).arm_fault
folder, text = sys.argv[1], bytes.fromhex(sys.argv[2])
board = f"{folder}/board"
words = ["live", f"slcan:{board}", "--record", f"{folder}/arw.csv", "--raw", f"{folder}/raw.csv"]
words += ["--idle", "0.1", "--json"]
for fault in sys.stdin:
    ours, its = pty.openpty()
    tty.setraw(its)
    if os.path.lexists(board):
        os.unlink(board)
    os.symlink(os.ttyname(its), board)
    os.write(ours, text)
    child = os.fork()
    if not child:
        for number, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(f"{folder}/{name}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        arm(fault.strip().encode())
        os._exit(cli.main(words))
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


class Place:
    """A folder with the two records of the command, and what a run without a fault writes there."""

    def __init__(self, folder):
        self.folder, self.record, self.raw = folder, folder / "arw.csv", folder / "raw.csv"
        self.sent = stream(counts(seeded("live faults"), 300, gaps=0), session=7)
        self.shown, _ = self.live(Sender(self.sent))
        self.rows, self.samples = self.recorded()
        self.size = max(path.stat().st_size for path in (self.record, self.raw))
        assert (len(self.rows) - 1, len(self.samples) - 3) == (len(self.shown), 300)
        self.fresh()

    def fresh(self):
        for path in self.folder.glob("*.csv"):
            path.unlink()

    def options(self, raw):
        words = {"source": "can:x", "base": wire.BASE, "record": str(self.record), "raw": raw}
        return argparse.Namespace(**words, count=None, idle=None, json=True)

    def live(self, sender):
        """Runs the command in this process; returns the lines that it shows, and its messages."""
        shown, said = io.StringIO(), io.StringIO()
        with (
            mock.patch.object(live, "Source", sender),
            contextlib.redirect_stdout(shown),
            contextlib.redirect_stderr(said),
        ):
            assert live.run(self.options(str(self.raw))) == 0
        return shown.getvalue().splitlines(), said.getvalue()

    def recorded(self):
        """(rows, samples) in the files, including the header. Each must be complete."""
        return [lines_of(self.record), lines_of(self.raw)]


def lines_of(path):
    text = path.read_text() if path.exists() else ""
    assert text.endswith("\n") or not text
    return text.splitlines()


@pytest.fixture
def place(tmp_path):
    with default_signals():
        yield Place(tmp_path)


def agrees(wanted, found):
    """Some values have no name, or no time, yet."""
    return all(wanted[name] == value for name, value in found.items() if name in wanted)


# --- signals


def test_a_signal_at_any_line_of_the_program(place):
    """Everything read from the source is shown and recorded, or certainly not: nothing is partial,
    nothing repeats.
    """
    line, left = 1, 0
    while left <= 0:
        left, number = line, STOPS[line // LINES_APART % 3]

        def trace(frame, event, value, number=number):
            nonlocal left
            if frame.f_code.co_filename not in WATCHED:
                return None
            left -= event == "line"
            if left == 0 and event == "line":
                signal.raise_signal(number)
            return trace

        for one in STOPS:
            signal.signal(one, lambda *_: None)  # before the first line of live.run
        before = sys.gettrace()
        sys.settrace(trace)
        try:
            shown, told = place.live(Sender(place.sent))
        finally:
            sys.settrace(before)
        rows, samples = place.recorded()
        found = [json.loads(text) for text in shown]
        assert all(map(agrees, map(json.loads, place.shown), found)), line
        assert [one["epoch"] for one in found] == [int(row.split(",")[2]) for row in rows[1:]]
        assert samples == place.samples[: len(samples)]
        assert (told.count("received: "), told.count("not recorded")) == (1, 0)
        place.fresh()
        line += LINES_APART
    assert line > 2000


def test_a_signal_while_the_reader_does_not_read(place):
    """One signal is enough, and what was received is recorded."""
    reader, writer = os.pipe()

    def stop_if_full(*_):
        waiting = bytearray(4)
        fcntl.ioctl(reader, termios.FIONREAD, waiting)
        if int.from_bytes(waiting, "little") > 60000:
            signal.raise_signal(signal.SIGTERM)

    child = os.fork()
    if not child:
        os.dup2(writer, 1)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        sys.stdout = os.fdopen(1, "w", encoding="ascii")
        os.close(writer)
        with mock.patch.object(live, "Source", Sender(frames(run(1, 900, session=7)))):
            signal.setitimer(signal.ITIMER_REAL, 0.2, 0.2)
            signal.signal(signal.SIGALRM, stop_if_full)
            os._exit(live.run(place.options(None)))
    os.close(writer)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    os.close(reader)
    assert len(place.recorded()[0]) > 100


# --- disk and death


def lost(told, what):
    found = re.search(rf": (\d+) {what} not recorded$", told, re.MULTILINE)
    return int(found[1]) if found else 0


def in_order(wanted, found):
    left = iter(wanted)
    return all(line in left for line in found)


def test_a_disk_that_is_full_after_some_byte_and_has_room_later(place):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def make_room(n):
        if n == len(place.sent) * 3 // 4:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    try:
        for limit in range(0, place.size + 1, 7):
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
            shown, told = place.live(Sender(place.sent, make_room))
            rows, samples = place.recorded()
            assert shown == place.shown, limit
            assert in_order(place.rows, rows)
            assert in_order(place.samples, samples)
            assert len(rows) + lost(told, "results") == len(place.rows)
            assert len(samples) + lost(told, "raw samples") == len(place.samples)
            place.fresh()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def rows_of(path):
    with open(path, encoding="ascii") as file:
        return list(csv.DictReader(file))


def test_killed_at_any_frame_and_started_again(place):
    """A killed receiver has written complete rows, and the next one appends to them. No row is
    wrong or repeated.
    """
    sent = frames(run(1, RESULTS, session=7))
    place.live(Sender(sent))
    truth = {row["epoch"]: row for row in rows_of(place.record)}
    assert len(truth) == RESULTS
    place.fresh()
    for cut in range(0, len(sent), 13):
        receiver, recorder = wire.Receiver(), record.Recorder(place.record)
        for frame in sent[:cut]:
            if result := receiver.push(*frame):
                recorder.add(result, result.of)
        recorder.output.file.close()  # killed: nothing is flushed or closed
        before = place.record.read_bytes()
        waited = len(recorder.waiting)  # 35 results at most
        place.live(Sender(sent[cut:]))
        assert place.record.read_bytes().startswith(before)
        # arw-2.csv: the columns had no names before the end
        rows = [row for path in place.folder.glob("arw*.csv") for row in rows_of(path)]
        assert len({row["epoch"] for row in rows}) == len(rows), cut
        # all but rows that waited for their names, and what was on its way
        assert len(rows) >= RESULTS - waited - 3
        for row in rows:
            known = {name: value for name, value in row.items() if value and name != "stretch"}
            assert agrees(truth[row["epoch"]], known)
        place.fresh()


# --- calls


@pytest.fixture
def faulty(tmp_path):
    """A function that runs the command with a fault: its status; None if there was no fault."""
    mark, path = tmp_path / "mark", tmp_path / "arw.csv"
    text = slcan(frames(run(1, 6, session=7, content=0)))
    assert len(text) < 4096
    driver = subprocess.Popen(
        [sys.executable, "-B", "-c", DRIVER, tmp_path, text.hex()],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environment(interposer(tmp_path, "-DALLOCATIONS"), mark) | {"PYTHONMALLOC": "malloc"},
    )

    def faulty_run(fault):
        for one in (path, tmp_path / "raw.csv", mark):
            one.unlink(missing_ok=True)
        print(fault, file=driver.stdin, flush=True)
        status = int(driver.stdout.readline())
        return status if mark.exists() or fault == ":" else None

    assert faulty_run(":") == 0
    faulty_run.rows, faulty_run.wanted = lambda: lines_of(path), lines_of(path)
    faulty_run.said = lambda: (tmp_path / "err").read_text()
    assert len(faulty_run.wanted) == 7
    yield faulty_run
    driver.stdin.close()
    driver.wait()
    driver.stdout.close()


def assert_clean(faulty, status):
    said, rows = faulty.said(), faulty.rows()
    if "SystemError" not in said:  # the interpreter loses an exception that it cannot allocate
        assert status in (0, 2), said
    assert "Traceback" not in said
    if status == 2:  # after a line that could not be ended, where that failed
        assert re.search(r"davarlab: [^\n]+\n\Z", said)
    assert [row for row in rows if row not in faulty.wanted] == []
    assert len(rows) == len(set(rows))
    if status == 0 and len(rows) < len(faulty.wanted):
        counted = re.search("received: (.*)", said)
        pairs = re.findall(r"(\d+) ([a-z ]+)", counted[1]) if counted else []
        names = ("missing", "doubtful results", "noise", "orphaned")
        assert sum(int(n) for n, name in pairs if name in names) + lost(said, "results") > 0, said


CALLS = [("write", errno.ENOSPC), ("open", errno.EMFILE)]
CALLS += [(name, errno.EIO) for name in ("read", "write", "fstat64")]
CALLS += [(name, errno.EIO) for name in ("tcgetattr", "tcsetattr")]


@pytest.mark.parametrize(("function", "cause"), CALLS)
def test_a_call_that_fails(faulty, function, cause):
    for _, status in every(faulty, f"{function}:{cause}"):
        assert_clean(faulty, status)


def test_an_allocation_that_fails(faulty):
    n = 1
    while (status := faulty(f"malloc:{errno.ENOMEM}:{n}")) is not None:
        assert_clean(faulty, status)
        n += 1 + n // 16
    assert n > 1000
