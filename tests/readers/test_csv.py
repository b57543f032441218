"""The CSV files of davar-sim and davarlab import in pandas, and by PlotJuggler's rules: a column
has the type of its first value. PlotJuggler itself does not run here: `plotjuggler` follows
plotjuggler_plugins/DataLoadCSV of its repository (commit 0a7615bd).
"""

import contextlib
import csv
import io
import os
import re
import subprocess
from pathlib import Path

import asking
import numpy as np
import pandas
import pytest

DEMO = asking.ROOT / "data/demo_disturbance.csv.gz"
CONVERT = (
    'pandas.read_csv("arw.csv", comment="#").to_csv("plot.csv", index=False, float_format="%.12f")'
)
PAGE = "time_s,arw\n1700000000,3e-05\n1700000000.01,0.5\n"


def plotjuggler(text):
    """Name -> "number", "epoch" (decimals are lost) or "text", from the first value of each column
    that has one.
    """
    types = {}
    for row in csv.DictReader(io.StringIO(text)):
        for name, value in row.items():
            if value and name not in types:
                number = re.fullmatch(r"[-+]?[\d.,]+", value)
                whole = number and "." not in value and 1.4e9 < int(value) < 2e9
                types[name] = "text" if not number else "epoch" if whole else "number"
    return types


def read(text):
    return pandas.read_csv(io.StringIO(text), comment="#")


@pytest.fixture(scope="module")
def texts(tmp_path_factory):
    """Results of davar-sim, a recording of davarlab import, and the example of the page."""
    words = [os.environ["DAVAR_SIM"], DEMO, "--column", "gyro_z_dps", "--lsb", "0.001"]
    words += ["--stride", "100", "--details"]
    results = subprocess.run(words, stdout=subprocess.PIPE, check=True, text=True).stdout
    out = tmp_path_factory.mktemp("readers") / "out.csv"
    done = asking.run("import", DEMO, "-o", out)
    assert done.returncode == 0, done.stderr
    return {"results": results, "recording": out.read_text(), "page": PAGE}


@pytest.mark.parametrize("name", ["results", "recording"])
def test_pandas_reads_every_number_as_it_is_written(texts, name):
    """An empty field is NaN."""
    found = read(texts[name])
    lines = [line for line in texts[name].splitlines() if not line.startswith("#")]
    rows = [[float(value or "nan") for value in row] for row in csv.reader(lines[1:])]
    assert lines[0].split(",") == list(found.columns)
    assert all(kind.kind in "iufb" for kind in found.dtypes), found.dtypes
    np.testing.assert_allclose(found.to_numpy(float), np.array(rows), rtol=1e-15)


@pytest.mark.parametrize("name", ["results", "recording", "page"])
def test_plotjuggler_reads_what_the_command_of_the_page_writes(tmp_path, texts, name):
    assert CONVERT in (asking.ROOT / "docs/RECORDINGS.md").read_text()
    Path(tmp_path, "arw.csv").write_text(texts[name])
    with contextlib.chdir(tmp_path):
        eval(CONVERT)
    plot = Path(tmp_path, "plot.csv").read_text()
    assert set(plotjuggler(plot).values()) == {"number"}
    before, after = (read(one).to_numpy(float) for one in (texts[name], plot))
    np.testing.assert_allclose(after, before, rtol=1e-15, atol=6e-13)  # twelve decimals


def test_plotjuggler_needs_the_command():
    assert plotjuggler(PAGE) == {"time_s": "epoch", "arw": "text"}
