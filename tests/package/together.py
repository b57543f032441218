"""Shared by the tests of the installed package."""

import csv
import importlib
import io
import os
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
WHOLE = (
    "epoch",
    "window_samples",
    "unstable",
    "alarm",
    "cut_age_samples",
    "steady_samples",
    "gaps_in_window",
    "coarse",
    "filtered",
    "floor_why",
)


class Installed:
    """The package that conftest.py installs, imported at its first use: a test module is collected
    before it is there.
    """

    def __getattr__(self, name):
        return getattr(importlib.import_module("davar"), name)


davar = Installed()


def simulator(text, *options):
    """Rows of davar-sim, as text by column, for a recording given as text."""
    done = subprocess.run(
        [os.environ["DAVAR_SIM"], "-", *map(str, options), "--progress", "never"],
        input=text,
        text=True,
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    return {name: [row[name] for row in rows] for name in rows[0]}


def as_text(name, column):
    """A column of davar.Epochs in the format of davar-sim."""
    if name in WHOLE or name.startswith("differences_"):
        return [str(int(value)) for value in column]
    digits = 15 if name == "time_s" else 9
    return ["" if np.isnan(value) else f"{value:.{digits}g}" for value in column]


def expect_printed(epochs, printed):
    """Every column and digit of davar-sim's output."""
    assert list(epochs) == list(printed)
    for name, column in epochs.items():
        assert as_text(name, column) == printed[name], name


def expect_equal(found, wanted):
    """Every column, bit by bit."""
    for name, column in wanted.items():
        np.testing.assert_array_equal(found[name], column, name)


def recording(columns):
    """CSV, every number with all its digits."""
    rows = (",".join(repr(float(value)) for value in row) for row in zip(*columns.values()))
    return "\n".join([",".join(columns), *rows]) + "\n"


def by_definition(x, m, gaps=()):
    """(deviation, differences) of x, sample by sample. No difference may contain NaN or span a
    gap.
    """
    squares = []
    for i in range(len(x) - 2 * m + 1):
        part = x[i : i + 2 * m]
        if not np.isnan(part).any() and not any(i < gap < i + 2 * m for gap in gaps):
            squares.append((part[m:].mean() - part[:m].mean()) ** 2)
    return (np.sqrt(np.mean(squares) / 2) if squares else np.nan), len(squares)
