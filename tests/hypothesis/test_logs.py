"""Other people's logs, damaged: every one is read or refused in one line, and what is read is what was in it; a length that a file claims is not
believed."""

import contextlib
import csv
import functools
import io
import sqlite3
import tempfile
import unittest
from pathlib import Path

import asked
import numpy as np
import writing_logs as writing
from damage import damaged
from hypothesis import example, given, strategies as st
from profile import examples

TRUTH = writing.Truth(count=24)


def made(write, name):
    """The bytes of a small log."""
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder) / name) or Path(folder) / name
        return path.read_bytes()


LOGS = {  # name: its bytes
    "a.ulg": made(lambda path: writing.ulog(path, TRUTH, gyros=1), "a.ulg"),
    "a.bin": made(lambda path: writing.dataflash(path, TRUTH, instances=1), "a.bin"),
    "a.log": made(lambda path: writing.dataflash_text(path, TRUTH), "a.log"),
    "a.bag": made(lambda path: writing.ros1(path, TRUTH), "a.bag"),
    "a.db3": made(lambda path: writing.ros2(path, TRUTH, "db3"), "a"),
    "a.mcap": made(lambda path: writing.ros2(path, TRUTH, "mcap"), "a"),
    "a5.mat": made(lambda path: writing.matlab_5(path, TRUTH), "a.mat"),
    "a73.mat": made(lambda path: writing.matlab_73(path, TRUTH), "a.mat"),
    "a.npy": made(lambda path: writing.npy(path, TRUTH), "a.npy"),
    "a.npz": made(lambda path: writing.npz(path, TRUTH), "a.npz"),
    "a.parquet": made(lambda path: writing.table(path, TRUTH), "a.parquet"),
}


def setUpModule():
    asked.bounded()


class Logs(asked.Lawful):
    def imported(self, name, data):
        out = self.work / "out.csv"
        done = self.asked(out, "import", self.file(name, data), "-o", out)
        self.assertNotIn("memory", done.stderr)
        return done


def attack(name):
    @given(damaged(LOGS[name]))
    @examples(120)
    def test(self, data):
        self.imported(name, data)
    return test


for one in LOGS:
    setattr(Logs, f"test_damaged_{one.replace('.', '_')}", attack(one))


if __name__ == "__main__":
    unittest.main()
