"""davar-node when a call fails, is interrupted or receives a signal, each in turn. It reports in
one line why it does not start, or it continues. Every lost result is counted by the sender or the
receiver. All others equal those of a run without a fault.
"""

import contextlib
import errno
import os
import pty
import signal
import subprocess
import tempfile
import threading
import time
import tty
import unittest
from pathlib import Path

from davarlab.wire import frames as wire
from davarlab.wire import source
from senders import ROOT, seeded

NODE = os.environ.get("DAVAR_NODE", "davar-node")
SAMPLES, PAUSE_S = 300, 0.15
A_RESULT, AT_THE_END = 6, 19  # frames of content summary
OPTIONS = (
    "--rate",
    "100",
    "--lsb",
    "0.05",
    "--window-max",
    "60",
    "--window-min",
    "40",
    "--segment",
    "10",
    "--stride",
    "60",
    "--content",
    "summary",
)
FAILS = (
    ("read", errno.EIO),
    ("write", errno.EIO),
    ("write", errno.ENOSPC),
    ("write", "torn"),
    ("open", errno.EMFILE),
    ("dup", errno.EMFILE),
    ("fstat", errno.EIO),
    ("tcgetattr", errno.EIO),
    ("tcsetattr", errno.EIO),
    ("poll", errno.ENOMEM),
    ("malloc", errno.ENOMEM),
)
GOES_ON = (
    ("read", errno.EINTR),
    ("read", errno.EAGAIN),
    ("read", "short"),
    ("write", errno.EINTR),
    ("write", errno.EAGAIN),
    ("write", "short"),
    ("poll", errno.EINTR),
)
OF_PTY = (
    ("posix_openpt", errno.EMFILE),
    ("grantpt", errno.EACCES),
    ("unlockpt", errno.EIO),
    ("open", errno.EMFILE),
    ("malloc", errno.ENOMEM),
    ("tcsetattr", errno.EIO),
)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.interposer, self.mark = self.folder / "faults.so", self.folder / "mark"
        subprocess.run(
            [
                "cc",
                "-shared",
                "-fPIC",
                "-O1",
                "-DALLOCATIONS",
                "-o",
                self.interposer,
                ROOT / "tests/cli/faults.c",
                "-ldl",
            ],
            check=True,
        )
        for number in (
            signal.SIGINT,
            signal.SIGTERM,
            signal.SIGHUP,
        ):  # the process that started the tests may ignore some
            self.addCleanup(signal.signal, number, signal.signal(number, signal.SIG_DFL))
        noise = seeded("node faults")
        self.lines = [f"{noise.randrange(-99, 100)}\n" for _ in range(SAMPLES)]
        told, receiver, found = self.heard(self.node(None))
        self.assertEqual((0, SAMPLES), (receiver.faults.total(), told["samples"]))
        self.truth = {result.epoch: result.values for result in found}
        self.assertEqual(told["results"], len(self.truth))
        self.assertEqual(self.frames(told), receiver.faults.good)

    @staticmethod
    def frames(told):
        """The number of frames that a run sends to its link."""
        return A_RESULT * told["results"] + AT_THE_END

    def environment(self, fault):
        self.mark.unlink(missing_ok=True)
        return dict(
            os.environ,
            LD_PRELOAD=str(self.interposer),
            FAULT=fault or "",
            FAULT_MARK=str(self.mark),
        )

    def node(self, fault, pause_s=0):
        """Runs it on a serial line that the test reads: (exit status, messages, the bytes on the
        line). None: it ended without the fault. pause_s: length of a pause in the middle of its
        input; a lost link is retried after 0.1 s.
        """
        ours, its = pty.openpty()
        tty.setraw(its)
        process = subprocess.Popen(
            [NODE, "--source", "-", "--out", f"slcan:{os.ttyname(its)}", *OPTIONS],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=self.environment(fault),
        )
        sent, ended = [], threading.Event()

        def read():
            os.set_blocking(ours, False)
            while True:
                over = ended.is_set()
                try:
                    sent.append(os.read(ours, 65536))
                except BlockingIOError:
                    if over:
                        return
                    ended.wait(0.002)

        reader = threading.Thread(target=read)
        reader.start()
        try:
            process.stdin.write("".join(self.lines[: SAMPLES // 2]))
            process.stdin.flush()
            time.sleep(pause_s)
            process.stdin.write("".join(self.lines[SAMPLES // 2 :]))
            process.stdin.close()
        except BrokenPipeError:
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
        said = process.stderr.read()
        process.wait()
        process.stderr.close()
        ended.set()
        reader.join()
        os.close(its)
        os.close(ours)
        return (
            (process.returncode, said, b"".join(sent)) if not fault or self.mark.exists() else None
        )

    @staticmethod
    def heard(done):
        """The counters in the last line of a finished run, the receiver of its frames, and the
        results.
        """
        _, said, sent = done
        told = {
            word.split(" ", 1)[1]: int(word.split(" ", 1)[0])
            for word in said.splitlines()[-1].removeprefix("davar-node: ").split(", ")
        }
        port, receiver, found = source.SerialPort.__new__(source.SerialPort), wire.Receiver(), []
        port.faults, port.text, port.too_long = receiver.faults, b"", False
        for frame in port.taken(sent):
            result = receiver.push(*frame)
            found += [result] if result else []
        return told, receiver, found + receiver.finish()

    def every(self, function, kind, pause_s=0):
        n = 1
        while (done := self.node(f"{function}:{kind}:{n}", pause_s)) is not None:
            yield n, done
            n += 1
        self.assertGreater(n, 1, (function, kind))

    def is_refusal(self, done):
        """Exit status 2, one line with the cause, and no frame."""
        status, said, sent = done
        if status != 2:
            return False
        self.assertRegex(said, r"\Adavar-node: [^\n]*[a-z]{4}[^\n]*\n\Z")
        self.assertNotIn(b"t", sent)
        return True

    def adds_up(self, done):
        """It ran to its end: every received result is correct, and every missing frame is counted.
        Returns its counters.
        """
        self.assertEqual(0, done[0], done[1])
        told, receiver, found = self.heard(done)
        self.assertEqual(SAMPLES, told["samples"])
        self.assertIn(
            told.get("source faults", 0) - told.get("missing samples", 0),
            (0, 1),
            "1: behind the last sample",
        )
        self.assertEqual(
            self.frames(told),
            receiver.faults.good + told.get("frames dropped", 0),
            (told, receiver.faults),
        )
        self.assertEqual(
            0, receiver.faults.corrupted + receiver.faults.repeated + receiver.faults.swapped
        )
        self.assertLessEqual(receiver.faults.missing, told.get("frames dropped", 0))
        if not told.get("frames dropped"):
            self.assertEqual((0, told["results"]), (receiver.faults.total(), len(found)))
        if not told.get("missing samples"):
            for result in found:
                self.assertEqual(
                    set(),
                    {*map(repr, result.values.items())}
                    - {*map(repr, self.truth[result.epoch].items())},
                )
        return told


class Calls(Case):
    def test_a_call_that_fails(self):
        for function, cause in FAILS:
            refused = gone_on = back = 0
            for n, done in self.every(
                function, cause, PAUSE_S if function in ("read", "write", "open") else 0
            ):
                with self.subTest(function=function, cause=cause, n=n):
                    if self.is_refusal(done):
                        refused += 1
                    else:
                        gone_on += 1
                        back += self.adds_up(done).get("link restored", 0)
            print(
                f"{function}: {refused} refused, {gone_on} gone on with, {back} times "
                "the link came back",
                flush=True,
            )
            self.assertGreater(refused + gone_on, 0)

    def test_an_interrupted_or_short_call_is_continued(self):
        for function, kind in GOES_ON:
            for n, done in self.every(function, kind):
                with self.subTest(function=function, kind=kind, n=n):
                    self.assertEqual(
                        {"samples", "results"}, set(self.adds_up(done)) - {"send retries", "alarms"}
                    )

    def test_a_pty_that_cannot_be_made(self):
        for function, cause in OF_PTY:
            n = 1
            while True:
                process = subprocess.Popen(
                    [NODE, "--source", "-", "--out", "slcan:pty", *OPTIONS],
                    stdin=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    text=True,
                    env=self.environment(f"{function}:{cause}:{n}"),
                )
                _, said = process.communicate()
                if not self.mark.exists() or process.returncode == 0:
                    break
                with self.subTest(function=function, n=n):
                    self.assertTrue(
                        self.is_refusal((process.returncode, said, b"")), (process.returncode, said)
                    )
                n += 1
            self.assertGreater(n, 1, function)


class Signals(Case):
    def test_at_every_frame(self):
        """SIGINT and SIGTERM: all counters once more, and status 0. SIGHUP ends it immediately.
        Lines are complete.
        """
        n = 1
        while True:
            number = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)[n % 3]
            done = self.node(f"write:signal{number}:{n}")
            if done is None:
                break
            with self.subTest(number=number, n=n):
                self.assertEqual(
                    (-number, "") if number == signal.SIGHUP else (0, done[1]), done[:2]
                )
                self.assertTrue(done[2].endswith(b"\r") or not done[2])
                told, receiver, found = self.heard((0, done[1] or "0 samples", done[2]))
                self.assertEqual(0, receiver.faults.total() - receiver.faults.incomplete_results)
                for result in found:
                    self.assertEqual(repr(self.truth[result.epoch]), repr(result.values))
                if number != signal.SIGHUP:
                    self.assertEqual(told["results"], len(found))
            n += 1
        self.assertGreater(n, 30)


if __name__ == "__main__":
    unittest.main()
