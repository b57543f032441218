"""Shared by the tests of the installed package. They run in the Python with the installation, in a
folder outside the checkout.
"""

import contextlib
import csv
import io
import os
import subprocess
import tempfile
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
)


@contextlib.contextmanager
def elsewhere():
    """A new folder, as the current one."""
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield Path(folder)
        finally:
            os.chdir(before)


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


def recording(columns):
    """CSV, every number with all its digits."""
    return (
        "\n".join(
            [",".join(columns)]
            + [",".join(repr(float(value)) for value in row) for row in zip(*columns.values())]
        )
        + "\n"
    )


def thousand_points():
    """The 1000 points of NIST SP 1065, 12.4: a prime modulus generator."""
    found = [1234567890]
    while len(found) < 1000:
        found.append(16807 * found[-1] % 2147483647)
    return np.array(found) / 2147483647
