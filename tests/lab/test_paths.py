"""Every command that takes a path, with what is no file there: exit status 2 and a message that
names it, within a time limit. Nothing but a regular file is opened: a FIFO would wait for ever, a
device may act.
"""

import contextlib
import json
import os
import signal
import socket
import subprocess
import tempfile
import unittest
from pathlib import Path

from asking import ROOT, run, typed
from davarlab import cli
from davarlab.errors import printable

MODEL = (
    '[sensor]\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    "coefficient_deg_per_sqrt_h = 0.3\n"
)
LIMIT_S = 1800  # after which a command hangs, on a machine as busy as can be
# {} is the odd path; r.csv and m.toml are sound. A command that takes a path and is not here fails
# the test.
READERS = {
    "simulate": ["simulate {} -o out"],
    "fit": ["fit {} -m m.toml", "fit r.csv -m {}", "fit r.csv -m m.toml --types {}"],
    "compare": ["compare {} -m m.toml", "compare r.csv -m {}", "compare r.csv -m {}.yaml"],
    "diagnose": [
        "diagnose {} -m m.toml",
        "diagnose r.csv -m {}",
        "diagnose r.csv -m m.toml --held-out {}",
    ],
    "improve": [
        "improve {} -m m.toml",
        "improve r.csv -m {}",
        "improve r.csv -m m.toml --held-out {}",
    ],
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
WRONG_TO_WRITE = ("folder", "fifo", "socket", "loop", "/dev/zero", "long")


def late(*_):
    raise AssertionError(f"not within {LIMIT_S} s")  # no OSError: multiprocessing would catch it


@contextlib.contextmanager
def limited():
    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(LIMIT_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


class Paths(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(kept.name)
        Path("r.csv").write_text(
            "time_s,gyro_z_dps\n"
            + "".join(f"{i / 50:.2f},{(i * i % 997) / 1e4 - 0.05:.4f}\n" for i in range(1500))
        )
        Path("m.toml").write_text(MODEL)
        Path("s.toml").write_text(
            MODEL.replace("column", "rate_hz = 50.0\ncolumn")
            + "[simulate]\nseed = 1\nduration_s = 60\n"
        )
        with socket.socket(socket.AF_UNIX) as there:
            there.bind("socket")
        for ending in ("", ".yaml", ".py"):
            os.mkdir(f"folder{ending}")
            os.mkfifo(f"fifo{ending}")
            os.symlink("socket", f"socket{ending}") if ending else None
            os.symlink(f"loop{ending}", f"loop{ending}")
            os.symlink("nowhere", f"dangling{ending}")
            os.symlink("/proc/kmsg", f"kmsg{ending}")
        os.mkfifo("new\nline")
        self.odd = [
            "folder",
            "fifo",
            "socket",
            "loop",
            "dangling",
            "kmsg",
            "/dev/zero",
            "/proc/kmsg",
            "a" * 300,
            "r.csv/below",
            "new\nline",
            "fifo/..",
        ]

    def refused(self, words, odd, command=run):
        arguments = [word.replace("{}", odd) for word in words.split(" ")]
        with self.subTest(words, odd=odd[:20]), limited():
            done = command(*arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
            last = done.stderr.splitlines()[-1]
            self.assertTrue(last.startswith("davarlab: "), last)
            self.assertIn(printable(odd), last)

    def test_every_command_that_takes_a_path_is_here(self):
        self.assertEqual(set(READERS) | NO_PATH, set(cli.COMMANDS))
        takes = {
            name
            for name, (_, _, arguments) in cli.COMMANDS.items()
            if any(
                "-o" in names or "--report" in names or "--record" in names
                for names, _ in arguments
            )
        }
        self.assertEqual(takes, set(WRITERS) & takes, "a command that writes")

    def test_what_is_no_file_is_not_read(self):
        for forms in READERS.values():
            for words in forms:
                for odd in self.odd:
                    if ("{}.yaml" in words or "{}.py" in words) and odd.startswith(
                        ("/", "a", "r", "new", "fifo/")
                    ):
                        continue
                    if words == "fit r.csv -m m.toml --types {}":
                        continue  # of a CSV nobody reads them; test_message_types
                    self.refused(words, odd)

    def test_message_types_of_a_bag(self):
        from davarlab.errors import BadInput
        from davarlab.logs import ros

        for odd in self.odd:
            if "kmsg" not in odd:  # it is taken for an empty file, and a message may be empty
                with self.subTest(odd):
                    with self.assertRaises(BadInput) as caught, limited():
                        ros.typestore([odd])
                    self.assertIn(odd, str(caught.exception))

    def test_what_is_no_file_is_not_written(self):
        for words in filter(None, WRITERS.values()):
            for odd in WRONG_TO_WRITE:
                if not (words.startswith(("plot", "fleet")) and odd == "folder"):
                    self.refused(words, "a" * 300 if odd == "long" else odd)
        self.assertTrue(
            all(Path(name).is_fifo() for name in ("fifo", "fifo.py")) and os.path.islink("loop")
        )

    def test_an_unreadable_file(self):
        Path("secret").write_text(MODEL)
        os.chmod("secret", 0)
        words = ["setpriv", "--bounding-set=-all"] if os.geteuid() == 0 else []
        for forms in ("fit secret -m m.toml", "fit r.csv -m secret"):
            done = subprocess.run(
                [*words, ROOT / "tools/davarlab", *forms.split()],
                capture_output=True,
                text=True,
                timeout=LIMIT_S,
            )
            self.assertEqual(
                (done.returncode, done.stdout, done.stderr.splitlines()[-1]),
                (2, "", "davarlab: secret: Permission denied"),
            )

    def test_a_fleet_goes_on_without_what_is_no_file(self):
        for name in ("bad.fifo", "bad.loop", "bad.folder"):
            {"fifo": os.mkfifo, "folder": os.mkdir, "loop": lambda path: os.symlink(path, path)}[
                name.split(".")[1]
            ](f"{name}.csv")
        os.symlink("r.csv", "good.csv")
        for files in (
            ["*.csv"],
            ["r.csv", "good.csv", "bad.fifo.csv", "bad.loop.csv", "bad.folder.csv"],
        ):
            with limited():
                done = typed(
                    "fleet",
                    *files,
                    "-m",
                    "m.toml",
                    "-o",
                    f"out{len(files)}",
                    "--chance",
                    "0",
                    "--workers",
                    "1",
                    "--json",
                )
            self.assertEqual(done.returncode, 1, done.stderr)
            found = json.loads(done.stdout)
            self.assertEqual(
                ({Path(one["file"]).name for one in found["failed"]}, found["rows"]),
                ({"bad.fifo.csv", "bad.loop.csv", "bad.folder.csv"}, 2),
            )


if __name__ == "__main__":
    unittest.main()
