"""davar-node when a call fails, is interrupted or receives a signal, each in turn. It reports in
one line why it does not start, or it continues. Every lost result is counted by the sender or the
receiver. All others equal those of a run without a fault.
"""

import contextlib
import errno
import re
import signal
import subprocess
import time

import pytest
from davar.wire import frames as wire
from davar.wire import source
from interposed import STOPS, default_signals, environment, every, interposer
from senders import NODE, Line, counters, seeded

pytestmark = pytest.mark.slow

SAMPLES, PAUSE_S = 300, 0.15
A_RESULT, AT_THE_END = 6, 19  # frames of content summary
OPTIONS = (
    *("--rate", "100", "--lsb", "0.05", "--window-max", "60", "--window-min", "40"),
    *("--segment", "10", "--stride", "60", "--content", "summary"),
)
FAILS = [
    *(("write", cause) for cause in (errno.EIO, errno.ENOSPC, "torn")),
    *((name, errno.EIO) for name in ("read", "fstat", "tcgetattr", "tcsetattr")),
    *((name, errno.EMFILE) for name in ("open", "dup")),
    *((name, errno.ENOMEM) for name in ("poll", "malloc")),
]
GOES_ON = [
    *((name, kind) for name in ("read", "write") for kind in (errno.EINTR, errno.EAGAIN, "short")),
    ("poll", errno.EINTR),
]
OF_PTY = [
    *(("posix_openpt", errno.EMFILE), ("grantpt", errno.EACCES), ("unlockpt", errno.EIO)),
    *(("open", errno.EMFILE), ("malloc", errno.ENOMEM), ("tcsetattr", errno.EIO)),
]


@pytest.fixture(scope="module")
def preloaded(tmp_path_factory):
    return interposer(tmp_path_factory.mktemp("node"), "-DALLOCATIONS")


class Faulty:
    def __init__(self, folder, preloaded):
        self.preloaded, self.mark = preloaded, folder / "mark"
        noise = seeded("node faults")
        self.lines = [f"{noise.randrange(-99, 100)}\n" for _ in range(SAMPLES)]
        told, receiver, found = heard(self.node(""))
        assert (receiver.faults.total(), told["samples"]) == (0, SAMPLES)
        self.truth = {result.epoch: result.values for result in found}
        assert len(self.truth) == told["results"]
        assert receiver.faults.good == frames_of(told)

    def node(self, fault, pause_s=0):
        """Runs it on a serial line that the test reads: (exit status, messages, the bytes on the
        line). None: it ended without the fault. pause_s: length of a pause in the middle of its
        input; a lost link is retried after 0.1 s.
        """
        line = Line()
        process = subprocess.Popen(
            [NODE, "--source", "-", "--out", f"slcan:{line.name}", *OPTIONS],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment(self.preloaded, self.mark, fault),
        )
        with contextlib.suppress(BrokenPipeError):
            process.stdin.write("".join(self.lines[: SAMPLES // 2]))
            process.stdin.flush()
            time.sleep(pause_s)
            process.stdin.write("".join(self.lines[SAMPLES // 2 :]))
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        said = process.stderr.read()
        process.wait()
        process.stderr.close()
        sent = line.close()
        return (process.returncode, said, sent) if not fault or self.mark.exists() else None

    def every(self, function, kind, pause_s=0):
        return every(lambda fault: self.node(fault, pause_s), f"{function}:{kind}")

    def adds_up(self, done):
        """It ran to its end: every received result is correct, and every missing frame is counted.
        Returns its counters.
        """
        assert done[0] == 0, done[1]
        told, receiver, found = heard(done)
        dropped, faults = told.get("frames dropped", 0), receiver.faults
        assert told["samples"] == SAMPLES
        # 1: after the last sample
        assert told.get("source faults", 0) - told.get("missing samples", 0) in (0, 1)
        assert frames_of(told) == faults.good + dropped, (told, faults)
        assert faults.corrupted + faults.repeated + faults.swapped == 0
        assert faults.missing <= dropped
        if not dropped:
            assert (faults.total(), len(found)) == (0, told["results"])
        if not told.get("missing samples"):
            for result in found:
                true = {*map(repr, self.truth[result.epoch].items())}
                assert {*map(repr, result.values.items())} <= true
        return told


def frames_of(told):
    """The number of frames that a run sends to its link."""
    return A_RESULT * told["results"] + AT_THE_END


def heard(done):
    """The counters of a finished run, the receiver of its frames, and the results."""
    _, said, sent = done
    port, receiver, found = source.SerialPort.__new__(source.SerialPort), wire.Receiver(), []
    port.faults, port.text, port.too_long = receiver.faults, b"", False
    for frame in port.taken(sent):
        result = receiver.push(*frame)
        found += [result] if result else []
    return counters(said), receiver, found + receiver.finish()


def is_refusal(status, said, sent=b""):
    """Exit status 2, one line with the cause, and no frame."""
    if status != 2:
        return False
    assert re.fullmatch(r"davar-node: [^\n]*[a-z]{4}[^\n]*\n", said)
    assert b"t" not in sent
    return True


@pytest.fixture
def faulty(tmp_path, preloaded):
    with default_signals():
        yield Faulty(tmp_path, preloaded)


@pytest.mark.parametrize(("function", "cause"), FAILS)
def test_a_call_that_fails(faulty, function, cause):
    pause_s = PAUSE_S if function in ("read", "write", "open") else 0
    for _, done in faulty.every(function, cause, pause_s):
        if not is_refusal(*done):
            faulty.adds_up(done)


@pytest.mark.parametrize(("function", "kind"), GOES_ON)
def test_an_interrupted_or_short_call_is_continued(faulty, function, kind):
    for _, done in faulty.every(function, kind):
        told = faulty.adds_up(done)
        assert set(told) - {"send retries", "alarms"} == {"samples", "results"}


@pytest.mark.parametrize(("function", "cause"), OF_PTY)
def test_a_pty_that_cannot_be_made(faulty, function, cause):
    def started(fault):
        done = subprocess.run(
            [NODE, "--source", "-", "--out", "slcan:pty", *OPTIONS],
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env=environment(faulty.preloaded, faulty.mark, fault),
        )
        return done if faulty.mark.exists() and done.returncode else None

    for _, done in every(started, f"{function}:{cause}"):
        assert is_refusal(done.returncode, done.stderr), done


def test_a_signal_at_every_frame(faulty):
    """SIGINT and SIGTERM: all counters once more, and status 0. SIGHUP ends it immediately. Lines
    are complete.
    """
    n = 1
    while (done := faulty.node(f"write:signal{STOPS[n % 3]}:{n}")) is not None:
        status, said, sent = done
        number = STOPS[n % 3]
        wanted = (-number, "") if number == signal.SIGHUP else (0, said)
        assert (status, said) == wanted, n
        assert sent.endswith(b"\r") or not sent
        told, receiver, found = heard((0, said or "0 samples", sent))
        assert receiver.faults.total() == receiver.faults.incomplete_results
        for result in found:
            assert repr(result.values) == repr(faulty.truth[result.epoch])
        assert number == signal.SIGHUP or len(found) == told["results"]
        n += 1
    assert n > 30
