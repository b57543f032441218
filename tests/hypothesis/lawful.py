"""What the properties share: the number of examples, damage to files, and the rule for every
command of davarlab: done, or rejected in one line that names the file; never a partial result.

In CI there are few examples, always the same. DAVAR_HYPOTHESIS=N gives N times as many, drawn at
random.
"""

import contextlib
import io
import os
import resource
import struct
from pathlib import Path
from types import SimpleNamespace

from davarlab import cli
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.configuration import set_hypothesis_home_dir

ROOT = Path(__file__).resolve().parents[2]
set_hypothesis_home_dir(ROOT / "build/cache/hypothesis")
TIMES = int(os.environ.get("DAVAR_HYPOTHESIS", "1"))
ROOM_BYTES = 1 << 30  # additional memory that a small file may need
PREFIX = "davarlab: "
EXTREMES = [
    struct.pack(form, value)
    for form, values in (
        ("<H", (0, 0x7FFF, 0xFFFF)),
        ("<I", (0, 1, 0x7FFFFFFF, 0xFFFFFFFF)),
        (">I", (0x7FFFFFFF, 0xFFFFFFFF)),
        ("<Q", (0, 1 << 31, 1 << 32, 1 << 40, (1 << 63) - 1, (1 << 64) - 1)),
    )
    for value in values
]


def examples(count):
    """Settings of a property with this number of examples in CI."""
    return settings(
        max_examples=count * TIMES,
        derandomize=TIMES == 1,
        database=None,
        deadline=None,
        print_blob=False,
        suppress_health_check=list(HealthCheck),
    )


@st.composite
def damaged(draw, data, most=4):
    """The bytes of `data` after some damage: bits flip, pieces are lost, repeated or overwritten,
    ends are cut, and numbers of the size of a length field become extreme.
    """
    data = bytearray(data)
    for _ in range(draw(st.integers(1, most))):
        if not data:
            break
        place = draw(st.integers(0, len(data) - 1))
        how = draw(st.sampled_from(("flip", "set", "cut", "drop", "twice", "put", "length")))
        if how == "flip":
            data[place] ^= 1 << draw(st.integers(0, 7))
        elif how == "set":
            data[place] = draw(st.integers(0, 255))
        elif how == "cut":
            del data[place:]
        elif how == "drop":
            del data[place : place + draw(st.integers(1, 40))]
        elif how == "twice":
            data[place:place] = data[place : place + draw(st.integers(1, 40))]
        elif how == "put":
            data[place:place] = draw(st.binary(min_size=1, max_size=8))
        else:
            extreme = draw(st.sampled_from(EXTREMES))
            data[place : place + len(extreme)] = extreme
    return bytes(data)


@contextlib.contextmanager
def bounded():
    """This process may use ROOM_BYTES more address space, so that a length field in a file cannot
    allocate more.
    """
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    limit = pages * resource.getpagesize() + ROOM_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def run(*words):
    """A command of davarlab in this process: its status, out and err."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = cli.main([*map(str, words)])
    return SimpleNamespace(status=status, out=out.getvalue(), err=err.getvalue())


def check_law(done, named, statuses=(0,)):
    """named: the file that an error must name."""
    assert done.status in (*statuses, 2), done.err
    said = done.err.split("\n")
    assert said.pop() == ""
    for line in said:
        assert line.startswith(PREFIX) and line.isprintable(), repr(line)
    if done.status == 2:
        assert done.out == ""
        assert Path(named).name in said[-1]
        assert len(said[-1]) < 2000


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


class Work:
    """A folder, and commands that read files in it."""

    def __init__(self, folder):
        self.folder = folder

    def __truediv__(self, name):
        return self.folder / name

    def file(self, name, data):
        data = data if isinstance(data, bytes) else data.encode("utf-8", "surrogatepass")
        (self.folder / name).write_bytes(data)
        return self.folder / name

    def lawful(self, output, command, path, *more, statuses=(0,)):
        """Runs a command on the file at `path` that writes the file `output`; checks that it writes
        that alone, and nothing if it rejects the file. A word OUT stands for the output.
        """
        output = self.folder / output
        output.unlink(missing_ok=True)
        before = contents(self.folder)
        done = run(command, *(output if word == "OUT" else word for word in (path, *more)))
        after = contents(self.folder)
        named = path if isinstance(path, Path) else more[0]
        check_law(done, named, statuses)
        written = {output.name} if done.status in statuses else set()
        assert after.keys() - before.keys() == written, done.err
        assert {name: after[name] for name in before} == before
        return done
