"""A call fails or a signal arrives, at every call and at every row. The program prints one line and
exits with status 2, or dies of that signal. The output ends with a complete line, and no temporary
file remains.
"""

import errno
import fcntl
import io
import itertools
import os
import signal
import subprocess
import termios
from functools import partial
from pathlib import Path

import pytest
from device_answer import HEALTH, head, result
from interposed import STOPS, default_signals, environment, every, interposer
from sim_case import PROGRAM, SMALL_WINDOW, recording, sim, write

pytestmark = pytest.mark.slow

LSB = ("--lsb", "0.01", *SMALL_WINDOW)
PACED = (*LSB, "--pace", "1000000")  # every row is written immediately
TAUS = ("--taus", ",".join(map(str, range(1, 31))))
WIDE = (*LSB, "--details", "--out", "jsonl", *TAUS)  # lines of more than PIPE_BUF


@pytest.fixture(scope="module")
def preloaded(tmp_path_factory):
    return interposer(tmp_path_factory.mktemp("faults"), "-DALLOCATIONS")


class Faulty:
    """Runs of davar-sim with a fault, on a recording of 300 samples."""

    def __init__(self, folder, preloaded):
        self.folder, self.preloaded = folder, preloaded
        self.scratch, self.mark = folder / "scratch", folder / "mark"
        self.scratch.mkdir()
        self.path, self.wholes = recording(folder), {}

    def whole(self, *options):
        """The output of a run without a fault."""
        if (self.path, options) not in self.wholes:
            self.wholes[self.path, options] = sim(self.path, *options).stdout
        return self.wholes[self.path, options]

    def run(self, fault, *options, output=None, **keywords):
        """A run with a fault; None if it ended without it."""
        keywords["env"] = environment(self.preloaded, self.mark, fault)
        keywords["env"]["TMPDIR"] = str(self.scratch)
        if output is None:
            done = sim(self.path, *options, **keywords)
        else:
            command = [PROGRAM, self.path, *map(str, options)]
            with open(output, "wb") as file:
                done = subprocess.run(command, stdout=file, stderr=subprocess.PIPE, **keywords)
            done.stdout, done.stderr = output.read_text(), done.stderr.decode()
        assert list(self.scratch.iterdir()) == []
        assert_lines(self.whole(*options), done.stdout)
        return done if self.mark.exists() else None

    def every(self, function, kind, *options):
        return every(lambda fault: self.run(fault, *options), f"{function}:{kind}")


def assert_lines(whole, text):
    assert whole.startswith(text)
    assert text.endswith("\n") or not text, text[-200:]


@pytest.fixture
def faulty(tmp_path, preloaded):
    with default_signals():
        yield Faulty(tmp_path, preloaded)


# --- calls


def options_of(kind, folder):
    """Options of a run with a model table, with a device that writes one result and zeros, ..."""
    table = write(folder / "table.csv", "m,adev_dps,relative_tolerance\n1,20,0.5\n2,15,0.5\n")
    (folder / "answer").write_bytes(result() + head(HEALTH))
    return {
        "paced": PACED,
        "jsonl": (*LSB, "--stride", "7", "--out", "jsonl"),
        "table": (*LSB, "--model-table", table),
        "device": (*LSB, "--taus", "1", "--device", f"sh -c 'cp {folder}/answer $2' device"),
    }.get(kind, LSB)


OF_FILES = {"read": errno.EIO, "open": errno.EMFILE, "fstat64": errno.EIO}
OF_RUN = {**OF_FILES, "write": errno.ENOSPC, "pread": errno.EIO, "mkstemp": errno.ENOSPC}
OF_DEVICE = dict.fromkeys(("fopen64", "fread", "fclose", "mkdtemp", "system"), errno.EIO)
MEMORY = {"malloc": errno.ENOMEM}
KINDS = {
    "plain": OF_RUN | MEMORY,
    **dict.fromkeys(("paced", "jsonl"), OF_RUN),
    **dict.fromkeys(("gzip", "table"), OF_FILES | MEMORY),
    "device": OF_RUN | OF_DEVICE | MEMORY,
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_call_that_fails(faulty, kind):
    if kind == "gzip":
        faulty.path = write(faulty.folder / "rec.csv.gz", faulty.path.read_bytes())
    options = options_of(kind, faulty.folder)
    whole = faulty.whole(*options)
    for function, cause in KINDS[kind].items():
        for n, done in faulty.every(function, cause, *options):
            if done.returncode == 0:
                assert done.stdout == whole, n
            else:
                assert (done.returncode, done.stderr.count("\n")) == (2, 1), (n, done.stderr)
                assert done.stderr.startswith("davar-sim: ")


@pytest.mark.parametrize("options", [LSB, PACED], ids=["plain", "paced"])
@pytest.mark.parametrize("function", ["read", "write", "pread"])
@pytest.mark.parametrize("kind", [errno.EINTR, "short"])
def test_an_interrupted_or_short_call_is_continued(faulty, options, function, kind):
    whole = faulty.whole(*options)
    for n, done in faulty.every(function, kind, *options):
        assert (done.returncode, done.stderr, done.stdout) == (0, "", whole), n


# --- signals


@pytest.mark.parametrize(
    ("count", "function", "steps", "options", "least", "name"),
    [
        *((300, "write", 5, PACED, 40, name) for name in (None, "out.csv")),  # at every row
        *((300, "strlen", 15, PACED, 40, name) for name in (None, "out.csv")),
        *((2000, "write", 1, LSB, 5, name) for name in (None, "out.csv")),  # in a row that waits
        *((2000, "strlen", 223, LSB, 5, name) for name in (None, "out.csv")),
        (80, "write", 3, WIDE, 5, None),  # in a line that a pipe takes in pieces
    ],
)
def test_a_signal_at_every_row(faulty, count, function, steps, options, least, name):
    faulty.path = recording(faulty.folder, count=count)
    output = faulty.folder / name if name else None
    middle = 0
    for n in itertools.count(1, steps):
        number = STOPS[n % len(STOPS)]
        done = faulty.run(f"{function}:signal{number}:{n}", *options, output=output)
        if done is None:
            break
        assert (done.returncode, done.stderr) == (-number, ""), n
        middle += 0 < len(done.stdout) < len(faulty.whole(*options))
    assert middle > least


@pytest.mark.parametrize(
    ("fault", "number", "limit"),
    [
        (f"strlen:spin{int(signal.SIGINT)}:200", signal.SIGINT, signal.SIGPROF),
        (f"write:pause{int(signal.SIGTERM)}:20", signal.SIGTERM, signal.SIGALRM),
    ],
)
@pytest.mark.parametrize("ignored", [False, True])
def test_a_signal_in_work_or_a_wait_that_never_ends(faulty, fault, number, limit, ignored):
    """Also where the signal of the limit is ignored at the start."""
    before = partial(signal.signal, limit, signal.SIG_IGN) if ignored else None
    done = faulty.run(fault, *PACED, preexec_fn=before)
    assert (done.returncode, done.stderr, bool(done.stdout)) == (-number, "", True)


def test_a_signal_while_a_temporary_file_has_a_name(faulty):
    runs = [faulty.run(f"{name}:signal{signal.SIGTERM}:1", *LSB) for name in ("mkstemp", "unlink")]
    device = (*LSB, "--device", "false")
    runs += [done for _, done in faulty.every("snprintf", f"signal{signal.SIGTERM}", *device)]
    assert {(done.returncode, done.stdout) for done in runs} == {(-signal.SIGTERM, "")}


def test_a_signal_that_is_ignored_stays_so(faulty):
    ignored = partial(signal.signal, signal.SIGHUP, signal.SIG_IGN)
    done = faulty.run(f"write:signal{signal.SIGHUP}:1", *LSB, preexec_fn=ignored)
    assert (done.returncode, done.stderr) == (0, "")


def blocked(path, *options):
    """A run that waits for its reader."""
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
    process = subprocess.Popen([PROGRAM, path, *options], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    process.stdout = io.FileIO(reader)
    waiting = bytearray(4)
    while process.poll() is None:
        fcntl.ioctl(process.stdout, termios.FIONREAD, waiting)
        state = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        if int.from_bytes(waiting, "little") > 0 and state == "S":
            break
    return process


@pytest.mark.parametrize("number", STOPS)
@pytest.mark.parametrize(
    "options",
    [LSB, PACED, WIDE, (*LSB, "--pace", "realtime")],
    ids=["plain", "paced", "wide", "realtime"],
)
def test_a_signal_while_the_reader_does_not_read(faulty, number, options):
    """A second one of another kind changes nothing; either may be first."""
    path = recording(faulty.folder, count=2000)
    whole = sim(path, *(options if options is WIDE else LSB)).stdout
    for numbers in ((number,), (number, signal.SIGHUP)):
        process = blocked(path, *options)
        for one in numbers:
            process.send_signal(one)
        output, errors = process.communicate()
        assert -process.returncode in numbers
        assert errors == b""
        assert_lines(whole, output.decode())


@pytest.mark.parametrize("ignored", [False, True])
def test_a_disk_that_is_full_after_any_byte(faulty, ignored):
    """At the limit comes SIGXFSZ or, if that is ignored, an error."""
    output = faulty.folder / "out.csv"
    as_given = ("env", "--ignore-signal=XFSZ") if ignored else ()
    # at first the temporary file has no room
    for limit in (*range(0, 8000, 23), *range(8000, 8400)):
        with open(output, "wb") as file:
            words = ["prlimit", f"--fsize={limit}", *as_given, PROGRAM, faulty.path, *LSB]
            done = subprocess.run(words, stdout=file, stderr=subprocess.PIPE)
        assert done.returncode == (2 if ignored else -signal.SIGXFSZ), limit
        text = output.read_text()
        assert_lines(faulty.whole(*LSB), text)
        assert (not text and limit < 8000) or len(text) > limit - 400
