"""A call fails or a signal arrives, at every call and at every row. The program prints one line and
exits with status 2, or dies of that signal. The output ends with a complete line, and no temporary
file remains.
"""

import errno
import fcntl
import io
import os
import resource
import signal
import subprocess
import termios
import unittest
from functools import partial
from pathlib import Path

from sim_case import PROGRAM, SMALL_WINDOW, SimCase
from test_device import HEALTH, head, result

FAULTS = Path(__file__).parent / "faults.c"
SANITIZED = b"__asan_init" in Path(PROGRAM).read_bytes()
STRIDE = 5 if SANITIZED else 1  # fewer faults where a run takes ten times as long
STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
LSB = ("--lsb", "0.01", *SMALL_WINDOW)
PACED = ("--pace", "1000000")  # every row is written immediately
WIDE = (
    "--details",
    "--out",
    "jsonl",
    "--taus",
    ",".join(map(str, range(1, 31))),
)  # lines of more than PIPE_BUF


def fill_up(ignored, limit):
    """Limits the size of files of this process; at the limit comes SIGXFSZ, or an error."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN if ignored else signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))


class FaultCase(SimCase):
    def setUp(self):
        super().setUp()
        # the process that started the tests may ignore some, and programs inherit that
        for number in STOPS:
            self.addCleanup(signal.signal, number, signal.signal(number, signal.SIG_DFL))
        self.interposer = self.folder / "faults.so"
        flags = [] if SANITIZED else ["-DALLOCATIONS"]
        subprocess.run(
            ["cc", "-shared", "-fPIC", "-O1", *flags, "-o", self.interposer, FAULTS, "-ldl"],
            check=True,
        )
        self.scratch = self.folder / "scratch"
        self.scratch.mkdir()
        self.mark = self.folder / "mark"
        self.path = self.recording()

    def faulty(self, fault, *arguments, output=None, **keywords):
        """Runs with a fault. Returns None if the run ended without it."""
        self.mark.unlink(missing_ok=True)
        environment = dict(
            os.environ,
            LD_PRELOAD=str(self.interposer),
            FAULT=fault,
            FAULT_MARK=str(self.mark),
            TMPDIR=str(self.scratch),
            ASAN_OPTIONS="verify_asan_link_order=0:detect_leaks=0",
        )
        if output is None:
            done = self.sim(*arguments, env=environment, **keywords)
        else:
            with open(output, "wb") as file:
                done = subprocess.run(
                    [PROGRAM, *map(str, arguments)],
                    stdout=file,
                    stderr=subprocess.PIPE,
                    env=environment,
                )
            done.stdout, done.stderr = output.read_text(), done.stderr.decode()
        self.assertEqual([], list(self.scratch.iterdir()))
        return done if self.mark.exists() else None

    def whole_lines(self, whole, text):
        self.assertTrue(whole.startswith(text))
        self.assertTrue(text.endswith("\n") or not text, text[-200:])


class Calls(FaultCase):
    """The n-th call fails, for every n."""

    def every(self, function, kind, *arguments):
        """Yields (n, run) until the program makes fewer than n calls."""
        n = 1
        while (done := self.faulty(f"{function}:{kind}:{n}", *arguments)) is not None:
            yield n, done
            n += 1
        self.assertGreater(n, 1, function)

    def fails_cleanly(self, function, cause, *options):
        whole = self.sim(self.path, *options).stdout
        for n, done in self.every(function, cause, self.path, *options):
            with self.subTest(function=function, n=n):
                self.whole_lines(whole, done.stdout)
                if done.returncode == 0:
                    self.assertEqual(whole, done.stdout)
                else:
                    self.assertEqual(
                        (2, 1), (done.returncode, done.stderr.count("\n")), done.stderr
                    )
                    self.assertTrue(done.stderr.startswith("davar-sim: "))

    def test_a_call_that_fails(self):
        for options in (LSB, (*LSB, *PACED), (*LSB, "--stride", "7", "--out", "jsonl")):
            for function, cause in (
                ("read", errno.EIO),
                ("write", errno.ENOSPC),
                ("pread", errno.EIO),
                ("open", errno.EMFILE),
                ("mkstemp", errno.ENOSPC),
            ):
                self.fails_cleanly(function, cause, *options)

    @unittest.skipIf(SANITIZED, "the sanitizers have an allocator of their own")
    def test_an_allocation_that_fails(self):
        packed = self.write("rec.csv.gz", self.path.read_bytes())
        for path in (self.path, packed):
            self.path = path
            self.fails_cleanly("malloc", errno.ENOMEM, *LSB)
        self.fails_cleanly("malloc", errno.ENOMEM, *self.with_table())
        self.fails_cleanly("malloc", errno.ENOMEM, *self.with_device())

    def with_table(self):
        table = self.write("table.csv", "m,adev_dps,relative_tolerance\n1,20,0.5\n2,15,0.5\n")
        return *LSB, "--model-table", table

    def with_device(self):
        """A device that writes one result and zero counters."""
        answer = self.folder / "answer"
        answer.write_bytes(result() + head(HEALTH))
        return *LSB, "--taus", "1", "--device", f"sh -c 'cp {answer} $2' device"

    def test_a_table_a_device_and_a_gzip_file(self):
        self.assertIn("model", self.sim(self.path, *self.with_table()).stdout.partition("\n")[0])
        for function in ("read", "open", "fstat64"):
            self.fails_cleanly(function, errno.EIO, *self.with_table())
        for function in (
            "read",
            "write",
            "pread",
            "open",
            "mkstemp",
            "fstat64",
            "fopen64",
            "fread",
            "fclose",
            "mkdtemp",
            "system",
        ):
            self.fails_cleanly(function, errno.EIO, *self.with_device())
        self.path = self.write("rec.csv.gz", self.path.read_bytes())
        for function in ("read", "open", "fstat64"):
            self.fails_cleanly(function, errno.EIO, *LSB)

    def test_an_interrupted_or_short_call_is_continued(self):
        for options in (LSB, (*LSB, *PACED)):
            whole = self.sim(self.path, *options).stdout
            for function in ("read", "write", "pread"):
                for kind in (errno.EINTR, "short"):
                    for n, done in self.every(function, kind, self.path, *options):
                        with self.subTest(function=function, kind=kind, n=n):
                            self.assertEqual((0, ""), (done.returncode, done.stderr))
                            self.assertEqual(whole, done.stdout)


class Signals(FaultCase):
    def stops(self, function, steps, options, output=None):
        """A signal at every `steps`-th call. Returns how many arrived during the output."""
        whole = self.sim(self.path, *options).stdout
        middle = 0
        n = 1
        while True:
            number = STOPS[n % len(STOPS)]
            done = self.faulty(f"{function}:signal{number}:{n}", self.path, *options, output=output)
            if done is None:
                return middle
            with self.subTest(function=function, n=n):
                self.assertEqual((-number, ""), (done.returncode, done.stderr))
                self.whole_lines(whole, done.stdout)
                middle += 0 < len(done.stdout) < len(whole)
            n += steps * STRIDE

    def test_at_every_row(self):
        for output in (None, self.folder / "out.csv"):
            self.assertGreater(self.stops("write", 5, (*LSB, *PACED), output), 40 // STRIDE)
            self.assertGreater(self.stops("strlen", 15, (*LSB, *PACED), output), 40 // STRIDE)

    def test_in_a_row_without_a_reader(self):
        self.path = self.recording(count=2000)
        for output in (None, self.folder / "out.csv"):
            self.assertGreater(self.stops("write", 1, LSB, output), 5 // STRIDE)
            self.assertGreater(self.stops("strlen", 223, LSB, output), 5 // STRIDE)

    def test_in_work_that_never_ends_and_in_a_wait_that_never_ends(self):
        whole = self.sim(self.path, *LSB, *PACED).stdout
        for fault, number in (
            ("strlen:spin{}:200", signal.SIGINT),
            ("strlen:spin{}:200", signal.SIGTERM),
            ("write:pause{}:20", signal.SIGTERM),
        ):
            done = self.faulty(fault.format(int(number)), self.path, *LSB, *PACED)
            with self.subTest(fault=fault):
                self.assertEqual((-number, ""), (done.returncode, done.stderr))
                self.whole_lines(whole, done.stdout)
                self.assertGreater(len(done.stdout), 0)

    def test_in_a_line_that_a_pipe_takes_in_pieces(self):
        self.path = self.recording(count=80)
        self.assertGreater(self.stops("write", 3, (*LSB, *WIDE)), 5 // STRIDE)

    def test_while_the_temporary_file_has_a_name(self):
        for function in ("mkstemp", "unlink"):
            done = self.faulty(f"{function}:signal{signal.SIGTERM}:1", self.path, *LSB)
            self.assertEqual((-signal.SIGTERM, ""), (done.returncode, done.stdout))

    def test_while_a_device_has_its_files(self):
        n = 1
        while done := self.faulty(
            f"snprintf:signal{signal.SIGTERM}:{n}", self.path, *LSB, "--device", "false"
        ):
            self.assertEqual(("", -signal.SIGTERM), (done.stdout, done.returncode))
            n += 1
        self.assertGreater(n, 3)

    def test_a_signal_that_is_ignored_stays_so(self):
        done = self.faulty(
            f"write:signal{signal.SIGHUP}:1",
            self.path,
            *LSB,
            preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
        )
        self.assertEqual((0, ""), (done.returncode, done.stderr))

    def test_in_work_that_never_ends_where_the_limit_was_ignored(self):
        for fault, limit in (
            (f"strlen:spin{int(signal.SIGINT)}:200", signal.SIGPROF),
            (f"write:pause{int(signal.SIGTERM)}:20", signal.SIGALRM),
        ):
            done = self.faulty(
                fault,
                self.path,
                *LSB,
                *PACED,
                preexec_fn=partial(signal.signal, limit, signal.SIG_IGN),
            )
            with self.subTest(fault=fault):
                self.assertIn(done.returncode, (-signal.SIGINT, -signal.SIGTERM))

    # --- a reader that does not read

    def blocked(self, *options):
        """A run that waits for its reader."""
        reader, writer = os.pipe()
        fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
        process = subprocess.Popen(
            [PROGRAM, self.path, *options], stdout=writer, stderr=subprocess.PIPE
        )
        os.close(writer)
        process.stdout = io.FileIO(reader)
        waiting = bytearray(4)
        while process.poll() is None:
            fcntl.ioctl(process.stdout, termios.FIONREAD, waiting)
            state = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
            if int.from_bytes(waiting, "little") > 0 and state == "S":
                break
        return process

    def test_while_the_reader_does_not_read(self):
        self.path = self.recording(count=2000)
        for number in STOPS:
            for options, pace in (
                (LSB, ()),
                (LSB, PACED),
                ((*LSB, *WIDE), ()),
                (LSB, ("--pace", "realtime")),
            ):
                with self.subTest(number=number, options=options, pace=pace):
                    whole = self.sim(self.path, *options).stdout
                    process = self.blocked(*options, *pace)
                    process.send_signal(number)
                    output, errors = process.communicate()
                    self.assertEqual((-number, b""), (process.returncode, errors))
                    self.whole_lines(whole, output.decode())

    def test_a_second_signal_of_another_kind_changes_nothing(self):
        self.path = self.recording(count=2000)
        whole = self.sim(self.path, *LSB, *WIDE).stdout
        process = self.blocked(*LSB, *WIDE)
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGHUP)
        output, errors = process.communicate()
        self.assertIn(process.returncode, (-signal.SIGINT, -signal.SIGHUP))  # either may be first
        self.assertEqual(b"", errors)
        self.whole_lines(whole, output.decode())

    # --- a disk that fills up

    def test_a_disk_that_is_full_after_any_byte(self):
        whole = self.sim(self.path, *LSB).stdout
        for ignored in (False, True):
            # at first the temporary file has no room
            for limit in (*range(0, 8000, 23 * STRIDE), *range(8000, 8400, STRIDE)):
                output = self.folder / "out.csv"
                with open(output, "wb") as file:
                    done = subprocess.run(
                        [PROGRAM, self.path, *LSB],
                        stdout=file,
                        stderr=subprocess.PIPE,
                        preexec_fn=partial(fill_up, ignored, limit),
                    )
                with self.subTest(limit=limit, ignored=ignored):
                    self.assertEqual(2 if ignored else -signal.SIGXFSZ, done.returncode)
                    self.whole_lines(whole, output.read_text())
                    self.assertTrue(
                        not output.read_text()
                        and limit < 8000
                        or len(output.read_text()) > limit - 400
                    )


if __name__ == "__main__":
    unittest.main()
