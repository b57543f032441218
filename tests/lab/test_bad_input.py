"""tools/davarlab on options, outputs and own effects that cannot be used: one line, exit status 2,
nothing left behind.
"""

import contextlib
import errno
import gzip
import io
import math
import os
import re
import subprocess
import sys
import textwrap
import unittest
from pathlib import Path
from unittest import mock

import asking
import numpy as np
import pytest
from asking import ROOT, run, said
from davarlab import cli, errors
from lab_bench import BASE, SENSOR

HEAD = (
    "from davarlab.effects.base import Effect, Parameter\n"
    "SIZE = (Parameter('a_dps', 'deg/s', 0, 1),)\n"
)
REFUSED = {
    "diagnose {rec} -m {model} --rate 100": "--rate: 100 Hz contradicts column time_s",
    "fit {rec} -m {model} --rate -5": "--rate: a number above 0 expected, found '-5'",
    "fit {rec} -m {model} --rate nan": "--rate: a number above 0 expected",
    "import {rec} -o {out} --rename gyro_z_dps=temp_degC": "has a column temp_degC already",
    "plot {rec} -m {model} -o nodir/x.png": "nodir/x.png: cannot be written",
    "plot {rec} -m {model} -o {out}.xyz": "the name must end in .png",
    "improve {rec} -m {model} -o nodir/x": "nodir/x: cannot be written",
    "fit {rec} -m {model} -o {rec}": "also reads or writes it",
    "benchmark --only nosuch": "--only: no scenario 'nosuch'",
    "benchmark --seeds 0": "--seeds: a whole number above 0",
    "nulls --recordings 0": "--recordings: a whole number above 0",
    "nulls --recordings 1 --seconds 5": "--seconds: 5; at least 20",
    "export {model} -o {out}.txt": "the name must end in .h or .csv",
    "add {model} sinusoid frequency_hz=40 -o {out}": "above half the sample rate of 50 Hz",
    "add {model} sinusoid amplitude_dps=inf -o {out}": "amplitude_dps must be a finite number",
    "effects --effects {model}": "a Python file (.py) expected",
}
OWN = {
    "Effect('own', '', SIZE, '', 'mean', '', regressor=lambda r, s: r.time_s[1:])": (
        "own: regressor: 1499 instead of 1500 values"
    ),
    "Effect('own', '', SIZE, '', 'mean', '', regressor=lambda r, s: r.time_s / 0)": (
        "own: regressor: not finite at index 0"
    ),
    "Effect('own', '', SIZE, '', 'mean', '', regressor=lambda r, s: 1 / 0)": (
        "own: regressor: ZeroDivisionError"
    ),
    "Effect('own', '', SIZE, '', 'spectrum', '', spectrum=lambda f, r, s: -f)": (
        "own: spectrum: negative"
    ),
    "Effect('own', '', SIZE, '', 'spectrum', '', spectrum=lambda f, r, s: f[1:])": (
        "own: spectrum: "
    ),
    "Effect('own')": "TypeError",
}


@pytest.fixture
def rec(lab):
    rows = "".join(f"{i / 50:.2f},{math.sin(i * i % 997):.4f},{i % 7}\n" for i in range(1500))
    return lab.file("r.csv", "time_s,gyro_z_dps,temp_degC\n" + rows)


@pytest.mark.parametrize("command", REFUSED)
def test_options_and_outputs(lab, rec, command):
    words = command.format(rec=rec, model=lab.model, out=lab.work / "out").split()
    lab.refused(REFUSED[command], *words, lines=None)


@pytest.mark.parametrize(
    "text",
    [
        b"time_s,gyro_z_dps\n" + b"1.000000000,1.000000000\n" * (3 << 20),
        b"# a: %s\n" % (b"b" * 250) * (300 << 10),
    ],
    ids=["rows", "comments"],
)
def test_a_gzip_file_that_would_fill_the_memory(lab, text):
    packed = lab.work / "packed.csv.gz"
    packed.write_bytes(gzip.compress(text, 9))
    assert packed.stat().st_size < 700_000
    why = "the gzip file expands to more than 64 MiB and 100 times its size"
    lab.refused(why, "fit", packed, "-m", lab.model)


def test_what_standard_output_cannot_take_is_told():
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "davarlab", "effects"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    said = "davarlab: standard output: no space left on device\n"
    assert (done.returncode, done.stderr) == (2, said)


def test_results_are_no_recording(lab, rec):
    done = subprocess.run([os.environ["DAVAR_SIM"], rec], capture_output=True, check=True)
    results = lab.work / "results.csv"
    results.write_bytes(done.stdout)
    for command in ("compare", "diagnose"):
        said = f"{results}:1: results of davar-sim or davarlab live"
        lab.refused(said, command, results, "-m", lab.model)
    lab.refused("results of davar-sim", "import", results, "-o", lab.work / "out")


def test_a_model_that_is_nested_too_deep(lab, rec):
    model = lab.file("deep.toml", "a = " + "[" * 20000 + "]" * 20000)
    lab.refused(f"{model}: nested too deep", "compare", rec, "-m", model)


@pytest.mark.parametrize("text", OWN)
def test_own_effects(lab, rec, text):
    own = lab.file("own.py", f"{HEAD}OWN = {text}\n")
    lab.refused(OWN[text], "diagnose", rec, "-m", lab.model, "--effects", own, lines=None)


def test_a_scenario_is_a_model_and_what_is_assumed_is_said(lab, rec):
    scenario = lab.file("s.toml", f"{SENSOR}[simulate]\nduration_s = 30\n{BASE}")
    assert run("fit", rec, "-m", scenario).returncode == 0
    done = run("add", lab.model, "sinusoid", "-o", lab.work / "out")
    assert done.returncode == 0
    assert "amplitude_dps = 0.001, frequency_hz = 0.001" in done.stderr


def test_the_spectrum_of_the_design_is_found(lab):
    text = (ROOT / "tools/lab/DESIGN.md").read_text()
    block = re.search(r"    # resonance\.py\n(?:(?:    .*)?\n)+", text)[0]
    own = lab.file("resonance.py", textwrap.dedent(block))
    effect = '[[effect]]\nkind = "resonance"\nstd_dps = 0.03\nfrequency_hz = 7.0\n'
    recording = lab.simulated(effect, seconds=1200, options=("--effects", own))
    found = lab.diagnosed(recording, "--effects", own)
    assert found["missing"] == ["resonance"]
    value = found["candidates"][0]["parameters"]
    assert value["frequency_hz"]["value"] == pytest.approx(7.0, abs=0.1)
    assert value["std_dps"]["value"] == pytest.approx(0.03, abs=0.003)
    model = lab.file("full.toml", SENSOR + BASE + effect)
    said("fit", recording, "-m", model, "--effects", own)


def test_what_nobody_foresaw_is_one_line_and_status_3():
    fault = (lambda options: [][1], *cli.COMMANDS["effects"][1:])
    with mock.patch.dict(cli.COMMANDS, effects=fault):
        done = asking.run("effects")
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (3, "", 1)
    assert "internal error: IndexError" in done.stderr


def test_only_a_file_of_the_user_is_bad_input():
    """A file of this package or of Python that is missing is a fault; but a full disk is the
    machine's wherever it is met.
    """
    places = [errors.__file__, unittest.__file__]
    if Path(np.__file__).is_relative_to(sys.prefix):
        places.append(np.__file__)
    for path, code, status in (
        [(Path(path).parent / "gone", errno.ENOENT, 3) for path in places]
        + [("gone.csv", errno.ENOENT, 2), (b"gone.csv", errno.EACCES, 2)]
        + [(path, errno.ENOSPC, 2) for path in places]
    ):
        with contextlib.redirect_stderr(io.StringIO()) as said:
            try:
                raise OSError(code, os.strerror(code), path)
            except OSError as why:
                assert errors.outside_error(why) == status, said.getvalue()
