"""Runs davarlab in this process and checks the rule for every command: done, or rejected in one
line that names the file; never a partial result.
"""

import resource
import sys
import tempfile
import unittest
import warnings
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests/lab"))
from asking import run  # it also finds davarlab

ROOT = Path(__file__).resolve().parents[2]

ROOM_BYTES = 1 << 30  # additional memory that a small file may need
PREFIX = "davarlab: "


def bounded():
    """From now on this process gets ROOM_BYTES more address space and no more, so that a length
    field in a file cannot allocate more.
    """
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + ROOM_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))


class Lawful(unittest.TestCase):
    """self.work: a folder for each test; each example empties it."""

    def setUp(self):
        warnings.simplefilter(
            "ignore",
            ResourceWarning,
            # as outside unittest: a library that rejects a damaged file leaves its handle to the
            # garbage collector
        )
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def file(self, name, data):
        path = self.work / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode("utf-8", "surrogatepass"))
        return path

    def asked(self, output, *arguments, statuses=(0,)):
        """Runs a command that reads files in self.work and writes `output` (a path, or None).
        Returns its messages. If it rejects a file, it must be the first argument after the
        command's name.
        """
        if output is not None:
            output.unlink(missing_ok=True)
        before = {path.name: path.read_bytes() for path in self.work.iterdir() if path.is_file()}
        done = run(*arguments)
        after = {path.name: path.read_bytes() for path in self.work.iterdir() if path.is_file()}
        self.keeps_the_law(done, arguments[1], statuses)
        written = set(after) - set(before)
        self.assertEqual(
            written,
            {output.name} if output is not None and done.returncode in statuses else set(),
            done.stderr,
        )
        self.assertEqual({name: after[name] for name in before}, before)
        return done

    def keeps_the_law(self, done, named, statuses=(0,)):
        self.assertIn(done.returncode, (*statuses, 2), done.stderr)
        said = done.stderr.split("\n")
        self.assertEqual(said.pop(), "")
        for line in said:
            self.assertTrue(line.startswith(PREFIX) and line.isprintable(), repr(line))
        if done.returncode == 2:
            self.assertEqual(done.stdout, "")
            self.assertIn(Path(named).name, said[-1])
            self.assertLess(len(said[-1]), 2000)
