"""A call fails or a signal arrives, at every call and at every row. The program prints one line and
exits with status 2, or dies of that signal. The output ends with a complete line, and no temporary
file remains.
"""

import errno
import fcntl
import io
import os
import signal
import subprocess
import termios
from functools import partial
from pathlib import Path

import pytest
from device_answer import HEALTH, head, result
from interposed import STOPS, default_signals, environment, interposer
from sim_case import PROGRAM, SMALL_WINDOW, recording, sim, write

pytestmark = pytest.mark.slow

LSB = ("--lsb", "0.01", *SMALL_WINDOW)
PACED = ("--pace", "1000000")  # every row is written immediately
TAUS = ("--taus", ",".join(map(str, range(1, 31))))
WIDE = ("--details", "--out", "jsonl", *TAUS)  # lines of more than PIPE_BUF


@pytest.fixture(scope="module")
def sanitized():
    """The sanitizers have an allocator of their own, and a run takes ten times as long."""
    return b"__asan_init" in Path(PROGRAM).read_bytes()


@pytest.fixture(scope="module")
def preloaded(tmp_path_factory, sanitized):
    return interposer(tmp_path_factory.mktemp("faults"), *([] if sanitized else ["-DALLOCATIONS"]))


class Faulty:
    """Runs of davar-sim with a fault, on a recording of 300 samples."""

    def __init__(self, folder, preloaded):
        self.folder, self.preloaded = folder, preloaded
        self.scratch, self.mark = folder / "scratch", folder / "mark"
        self.scratch.mkdir()
        self.path = recording(folder)

    def run(self, fault, *options, output=None, **keywords):
        """A run with a fault; None if it ended without it."""
        keywords["env"] = environment(self.preloaded, self.mark, fault)
        keywords["env"]["TMPDIR"] = str(self.scratch)
        keywords["env"]["ASAN_OPTIONS"] = "verify_asan_link_order=0:detect_leaks=0"
        if output is None:
            done = sim(self.path, *options, **keywords)
        else:
            command = [PROGRAM, self.path, *map(str, options)]
            with open(output, "wb") as file:
                done = subprocess.run(command, stdout=file, stderr=subprocess.PIPE, **keywords)
            done.stdout, done.stderr = output.read_text(), done.stderr.decode()
        assert list(self.scratch.iterdir()) == []
        return done if self.mark.exists() else None

    def every(self, function, kind, *options):
        """Yields (n, run) until the program makes fewer than n calls."""
        n = 1
        while (done := self.run(f"{function}:{kind}:{n}", *options)) is not None:
            yield n, done
            n += 1
        assert n > 1, function

    def fails_cleanly(self, function, cause, *options):
        whole = sim(self.path, *options).stdout
        for n, done in self.every(function, cause, *options):
            assert_lines(whole, done.stdout)
            if done.returncode == 0:
                assert done.stdout == whole, n
            else:
                assert (done.returncode, done.stderr.count("\n")) == (2, 1), (n, done.stderr)
                assert done.stderr.startswith("davar-sim: ")

    def stops(self, function, steps, options, output=None):
        """A signal at every `steps`-th call. Returns how many arrived during the output."""
        whole, middle, n = sim(self.path, *options).stdout, 0, 1
        while True:
            number = STOPS[n % len(STOPS)]
            done = self.run(f"{function}:signal{number}:{n}", *options, output=output)
            if done is None:
                return middle
            assert (done.returncode, done.stderr) == (-number, ""), n
            assert_lines(whole, done.stdout)
            middle += 0 < len(done.stdout) < len(whole)
            n += steps


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
    device = f"sh -c 'cp {folder}/answer $2' device"
    return {
        "plain": LSB,
        "gzip": LSB,
        "paced": (*LSB, *PACED),
        "jsonl": (*LSB, "--stride", "7", "--out", "jsonl"),
        "table": (*LSB, "--model-table", table),
        "device": (*LSB, "--taus", "1", "--device", device),
    }[kind]


OF_FILES = {"read": errno.EIO, "open": errno.EMFILE, "fstat64": errno.EIO}
OF_RUN = {**OF_FILES, "write": errno.ENOSPC, "pread": errno.EIO, "mkstemp": errno.ENOSPC}
OF_DEVICE = dict.fromkeys(("fopen64", "fread", "fclose", "mkdtemp", "system"), errno.EIO)
KINDS = {
    **dict.fromkeys(("plain", "paced", "jsonl"), OF_RUN),
    **dict.fromkeys(("gzip", "table"), OF_FILES),
    "device": OF_RUN | OF_DEVICE,
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_call_that_fails(faulty, sanitized, kind):
    if kind == "gzip":
        faulty.path = write(faulty.folder / "rec.csv.gz", faulty.path.read_bytes())
    options = options_of(kind, faulty.folder)
    for function, cause in KINDS[kind].items():
        faulty.fails_cleanly(function, cause, *options)
    if not sanitized and kind not in ("paced", "jsonl"):
        faulty.fails_cleanly("malloc", errno.ENOMEM, *options)


@pytest.mark.parametrize("options", [LSB, (*LSB, *PACED)], ids=["plain", "paced"])
@pytest.mark.parametrize("function", ["read", "write", "pread"])
@pytest.mark.parametrize("kind", [errno.EINTR, "short"])
def test_an_interrupted_or_short_call_is_continued(faulty, options, function, kind):
    whole = sim(faulty.path, *options).stdout
    for n, done in faulty.every(function, kind, *options):
        assert (done.returncode, done.stderr, done.stdout) == (0, "", whole), n


# --- signals


@pytest.mark.parametrize("name", [None, "out.csv"])
@pytest.mark.parametrize(
    ("count", "function", "steps", "options", "least"),
    [
        (300, "write", 5, (*LSB, *PACED), 40),  # at every row
        (300, "strlen", 15, (*LSB, *PACED), 40),
        (2000, "write", 1, LSB, 5),  # in a row without a reader
        (2000, "strlen", 223, LSB, 5),
        (80, "write", 3, (*LSB, *WIDE), 5),  # in a line that a pipe takes in pieces
    ],
)
def test_a_signal_at_every_row(faulty, sanitized, name, count, function, steps, options, least):
    if name and count == 80:
        pytest.skip("a file takes a line at once")
    faulty.path = recording(faulty.folder, count=count)
    steps, least = (5 * steps, least // 5) if sanitized else (steps, least)
    output = faulty.folder / name if name else None
    assert faulty.stops(function, steps, options, output) > least


@pytest.mark.parametrize(
    ("function", "kind", "number", "limit"),
    [
        ("strlen", "spin", signal.SIGINT, signal.SIGPROF),
        ("write", "pause", signal.SIGTERM, signal.SIGALRM),
    ],
)
@pytest.mark.parametrize("ignored", [False, True])
def test_a_signal_in_work_or_a_wait_that_never_ends(faulty, function, kind, number, limit, ignored):
    """Also where the signal of the limit is ignored at the start."""
    before = partial(signal.signal, limit, signal.SIG_IGN) if ignored else None
    fault = f"{function}:{kind}{int(number)}:{200 if function == 'strlen' else 20}"
    done = faulty.run(fault, *LSB, *PACED, preexec_fn=before)
    assert (done.returncode, done.stderr) == (-number, "")
    assert_lines(sim(faulty.path, *LSB, *PACED).stdout, done.stdout)
    assert done.stdout


def test_a_signal_while_a_temporary_file_has_a_name(faulty):
    for function in ("mkstemp", "unlink"):
        done = faulty.run(f"{function}:signal{signal.SIGTERM}:1", *LSB)
        assert (done.returncode, done.stdout) == (-signal.SIGTERM, "")
    device = (*LSB, "--device", "false")
    for _, done in faulty.every("snprintf", f"signal{signal.SIGTERM}", *device):
        assert (done.stdout, done.returncode) == ("", -signal.SIGTERM)


def test_a_signal_that_is_ignored_stays_so(faulty):
    ignored = partial(signal.signal, signal.SIGHUP, signal.SIG_IGN)
    done = faulty.run(f"write:signal{signal.SIGHUP}:1", *LSB, preexec_fn=ignored)
    assert (done.returncode, done.stderr) == (0, "")


# --- a reader that does not read


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
    ("options", "pace"),
    [(LSB, ()), (LSB, PACED), ((*LSB, *WIDE), ()), (LSB, ("--pace", "realtime"))],
    ids=["plain", "paced", "wide", "realtime"],
)
def test_a_signal_while_the_reader_does_not_read(faulty, number, options, pace):
    """A second one of another kind changes nothing; either may be first."""
    path = recording(faulty.folder, count=2000)
    whole = sim(path, *options).stdout
    for numbers in ((number,), (number, signal.SIGHUP)):
        process = blocked(path, *options, *pace)
        for one in numbers:
            process.send_signal(one)
        output, errors = process.communicate()
        assert -process.returncode in numbers
        assert errors == b""
        assert_lines(whole, output.decode())


# --- a disk that fills up


@pytest.mark.parametrize("ignored", [False, True])
def test_a_disk_that_is_full_after_any_byte(faulty, sanitized, ignored):
    """At the limit comes SIGXFSZ or, if that is ignored, an error."""
    whole, stride = sim(faulty.path, *LSB).stdout, 5 if sanitized else 1
    output = faulty.folder / "out.csv"
    as_given = ("env", "--ignore-signal=XFSZ") if ignored else ()
    # at first the temporary file has no room
    for limit in (*range(0, 8000, 23 * stride), *range(8000, 8400, stride)):
        with open(output, "wb") as file:
            words = ["prlimit", f"--fsize={limit}", *as_given, PROGRAM, faulty.path, *LSB]
            done = subprocess.run(words, stdout=file, stderr=subprocess.PIPE)
        assert done.returncode == (2 if ignored else -signal.SIGXFSZ), limit
        text = output.read_text()
        assert_lines(whole, text)
        assert (not text and limit < 8000) or len(text) > limit - 400
