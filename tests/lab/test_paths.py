"""Every command that takes a path, with what is no file there: exit status 2 and a message that
names it, within a time limit. Nothing but a regular file is opened: a FIFO would wait for ever, a
device may act.
"""

import contextlib
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from asking import run, said, undone
from davarlab import cli
from davarlab.errors import BadInput, printable

MODEL = (
    '[sensor]\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    "coefficient_deg_per_sqrt_h = 0.3\n"
)
LIMIT_S = 1800  # after which a command hangs, on a machine as busy as can be
# {} is the odd path; r.csv and m.toml are sound. A command that takes a path and is not here fails
# the test.
READERS = {
    "simulate": ["simulate {} -o out"],
    "fit": ["fit {} -m m.toml", "fit r.csv -m {}"],
    "imu": ["imu {}"],
    "compare": ["compare {} -m m.toml", "compare r.csv -m {}", "compare r.csv -m {}.yaml"],
    **{
        name: [
            f"{name} {{}} -m m.toml",
            f"{name} r.csv -m {{}}",
            f"{name} r.csv -m m.toml --held-out {{}}",
        ]
        for name in ("diagnose", "improve")
    },
    "add": ["add {} sinusoid -o out"],
    "open": ["open {} --no-browser", "open r.csv --no-browser -m {}"],
    "effects": ["effects --effects {}", "effects --effects {}.py"],
    "plot": ["plot {} -m m.toml -o out.png", "plot r.csv -m {} -o out.png"],
    "export": ["export {} -o out.h", "export m.toml --to plan --recording {} -o out.h"],
    "sheet": ["sheet --kalibr {} -o out"],
    "import": ["import {} -o out", "import {} --list"],
    "fleet": ["fleet r.csv -m {} -o out", "fleet r.csv -m m.toml -o out2 --limits {}"],
}
WRITERS = {
    "simulate": "simulate s.toml -o {}",
    "fit": "fit r.csv -m m.toml -o {}",
    "imu": "imu r.csv --to json -o {}",
    "compare": "compare r.csv -m m.toml --report {}",
    "diagnose": None,
    "improve": None,
    "add": "add m.toml sinusoid -o {}",
    "plot": "plot r.csv -m m.toml -o {}",
    "export": "export m.toml -o {} --to kalibr",
    "sheet": "sheet 10deg/h -o {}",
    "import": "import r.csv -o {}",
    "dbc": "dbc -o {}",
    "live": None,
    "fleet": "fleet r.csv -m m.toml -o {}",
}
NO_PATH = {"benchmark", "nulls", "dbc", "live"}  # that read one
ODD = [
    *("folder", "fifo", "socket", "loop", "dangling", "kmsg", "/dev/zero", "/proc/kmsg"),
    *("a" * 300, "r.csv/below", "new\nline", "fifo/.."),
]
WRONG_TO_WRITE = ("folder", "fifo", "socket", "loop", "/dev/zero", "a" * 300)


def late(*_):
    raise AssertionError(f"not within {LIMIT_S} s")  # no OSError: multiprocessing would catch it


@contextlib.contextmanager
def limited():
    with undone(signal.SIGALRM):
        signal.signal(signal.SIGALRM, late)
        signal.alarm(LIMIT_S)
        try:
            yield
        finally:
            signal.alarm(0)


@pytest.fixture(autouse=True)
def there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = (f"{i / 50:.2f},{(i * i % 997) / 1e4 - 0.05:.4f}\n" for i in range(1500))
    Path("r.csv").write_text("time_s,gyro_z_dps\n" + "".join(rows))
    Path("m.toml").write_text(MODEL)
    rated = MODEL.replace("column", "rate_hz = 50.0\ncolumn")
    Path("s.toml").write_text(rated + "[simulate]\nseed = 1\nduration_s = 60\n")
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("socket")
    for ending in ("", ".yaml", ".py"):
        os.mkdir(f"folder{ending}")
        os.mkfifo(f"fifo{ending}")
        os.symlink("socket", f"socket{ending}") if ending else None
        os.symlink(f"loop{ending}", f"loop{ending}")
        os.symlink("nowhere", f"dangling{ending}")
        os.symlink("/proc/kmsg", f"kmsg{ending}")
    os.mkfifo("new\nline")


def refused(words, odd):
    with limited():
        done = run(*(word.replace("{}", odd) for word in words.split(" ")))
    assert (done.returncode, done.stdout) == (2, ""), (words, odd, done.stderr)
    last = done.stderr.splitlines()[-1]
    assert last.startswith("davarlab: "), last
    assert printable(odd) in last, (words, odd)


def test_every_command_that_takes_a_path_is_here():
    assert set(READERS) | NO_PATH == set(cli.COMMANDS)
    takes = {
        name
        for name, (_, _, arguments) in cli.COMMANDS.items()
        if any({"-o", "--report", "--record"} & set(names) for names, _ in arguments)
    }
    assert takes <= set(WRITERS)


@pytest.mark.parametrize("words", [words for forms in READERS.values() for words in forms])
def test_what_is_no_file_is_not_read(words):
    for odd in ODD:
        ending = "{}.yaml" in words or "{}.py" in words
        if not (ending and odd.startswith(("/", "a", "r", "new", "fifo/"))):
            refused(words, odd)


def test_message_types_of_a_bag():
    from davarlab.logs import ros

    for odd in ODD:
        if "kmsg" not in odd:  # it is taken for an empty file, and a message may be empty
            with pytest.raises(BadInput) as caught, limited():
                ros.typestore([odd])
            assert odd in str(caught.value)


@pytest.mark.parametrize("words", [words for words in WRITERS.values() if words])
def test_what_is_no_file_is_not_written(words):
    for odd in WRONG_TO_WRITE:
        if not (words.startswith(("plot", "fleet")) and odd == "folder"):
            refused(words, odd)
    assert all(Path(name).is_fifo() for name in ("fifo", "fifo.py"))
    assert os.path.islink("loop")


@pytest.mark.parametrize("words", ["fit secret -m m.toml", "fit r.csv -m secret"])
def test_an_unreadable_file(words):
    Path("secret").write_text(MODEL)
    os.chmod("secret", 0)
    command = ["setpriv", "--bounding-set=-all"] if os.geteuid() == 0 else []
    command += [sys.executable, "-m", "davarlab", *words.split()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert done.stderr.splitlines()[-1] == "davarlab: secret: Permission denied"


@pytest.mark.slow
def test_a_fleet_goes_on_without_what_is_no_file():
    os.mkfifo("bad.fifo.csv")
    os.mkdir("bad.folder.csv")
    os.symlink("bad.loop.csv", "bad.loop.csv")
    os.symlink("r.csv", "good.csv")
    named = ["r.csv", "good.csv", "bad.fifo.csv", "bad.loop.csv", "bad.folder.csv"]
    for place, names in enumerate((["*.csv"], named)):
        words = f"-m m.toml -o out{place} --chance 0 --workers 1".split()
        with limited():
            found = said("fleet", *names, *words, statuses=(1,))
        assert {Path(one["file"]).name for one in found["failed"]} == set(named[2:])
        assert found["rows"] == 2
