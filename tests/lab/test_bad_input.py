"""tools/davarlab on options, outputs and own effects that cannot be used: one line, exit status 2,
nothing left behind.
"""

import contextlib
import errno
import gzip
import io
import json
import math
import os
import pty
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
    "export {model} -o {out}.csv --tolerance 1.5": "--tolerance",
    "export {model} -o {out}.csv --tolerance nan": "--tolerance",
    "export {model} -o {out}.csv --window 3": "--window",
    "export {model} {model} --to plan -o {out}.h": "--to plan takes one model",
    "export {model} --to plan -o {out}.c": "the name must end in .h",
    "export {model} --recording {rec} -o {out}.h": "only --to plan uses it",
    "compare none.csv -m {model}": "none.csv",
    "effects --speed": "--speed",
    "add {model} magic -o {out}": "unknown kind",
    "add {model} sinusoid frequency_hz=40 -o {out}": "above half the sample rate of 50 Hz",
    "add {model} sinusoid amplitude_dps=inf -o {out}": "amplitude_dps must be a finite number",
    "effects --effects {model}": "a Python file (.py) expected",
    "live lin:0": "dronecan:IFACE or cyphal:IFACE[@SUBJECT] expected, found 'lin:0'",
    "live mavlink:lin:0": "expected, found 'mavlink:lin:0'",
    "live mavlink:udp:127.0.0.1": "mavlink:udp:127.0.0.1: HOST:PORT expected",
    "live mavlink:udp::0": "mavlink:udp::0: HOST:PORT expected",
    "live mavlink:udp:127.0.0.1:70000": "mavlink:udp:127.0.0.1:70000: ",
    "live mavlink:serial:/nonexistent": "No such file or directory",
    "live cyphal:nope": "cyphal:nope: ",
    "live cyphal:nope@8192": "subject 0 to 8191 expected, found '8192'",
    "live slcan:/nonexistent": "slcan:/nonexistent: No such file or directory",
    "live slcan:/dev/null": "slcan:/dev/null: not a serial line",
    "live can:nope": "can:nope: ",
    "live can:vcan0 --count 0": "--count: a whole number above 0 expected, found '0'",
    "live can:vcan0 --idle nan": "--idle: a number above 0 expected, found 'nan'",
    "live can:vcan0 --base 800": "--base: a hexadecimal identifier up to 7F6 expected, found '800'",
    "live": "source",
    "dbc --base x -o {out}": "--base: a hexadecimal identifier up to 7F6 expected, found 'x'",
    "dbc --base 7F0 --channel 1 -o {out}": "--channel: 1 does not fit into 11-bit identifiers from",
    "dbc --channel -1 -o {out}": "--channel: a channel from 0 on expected, found '-1'",
    "dbc -o /nonexistent/my.dbc": "/nonexistent/my.dbc: cannot be written",
}


def effect(kind, column="gyro_z_dps", **parameters):
    """A model with one effect."""
    lines = [f"{name} = {json.dumps(value)}\n" for name, value in parameters.items()]
    sensor = SENSOR.replace("gyro_z_dps", column)
    return f'{sensor}[[effect]]\nkind = "{kind}"\n{"".join(lines)}'


def drifting(course):
    return effect("drifting_line", amplitude_dps=0.05, course_hz=course)


LINE = {"kind": "intermittent_line", "frequency_hz": 7, "amplitude_dps": 0.05}
COURSE = "course_hz must be 4 or more frequencies"
MODELS = [  # a model, what is wrong
    ("[sensor\n", "not TOML"),
    ("a = " + "[" * 20000 + "]" * 20000, "bad.toml: nested too deep"),
    (SENSOR + BASE + "speed = 3\n", "no parameter speed"),
    (SENSOR + BASE.replace("0.3", "-1"), "outside"),
    (SENSOR.replace("gyro_z", "gyro_q") + BASE, "no column gyro_q_dps"),
    (effect("magic"), "unknown kind 'magic'"),
    (effect("temperature", coefficient_dps_per_degC=1), "temp_degC"),
    (
        effect("telegraph_noise", amplitude_dps=0.01, mean_dwell_s=2.0, levels=2.5),
        "levels = 2.5 must be a whole number",
    ),
    (effect(**LINE, start_s=100, stop_s=50), "line: stop_s = 50 is before start_s = 100"),
    *((drifting(course), COURSE) for course in ("9 9.2 9.9", "9 fast 9.9 9.7", "9 -9 9 9")),
    (drifting("9 nan 9 9"), COURSE),
    (drifting("9 9 9 26"), "course_hz = 26 is above half the sample rate of 50 Hz"),
]
EVEN = [f"{i / 50:.2f},{(i * 7919) % 101 * 0.01:.2f}" for i in range(1500)]
ROWS = {  # rows of a recording: what is wrong
    "not finite": ([*EVEN[:7], "0.14,1e400"], "r.csv:9: column gyro_z_dps"),
    "no time": ([*EVEN[:7], "nan,0.4"], "r.csv:9: column time_s: not a number: 'nan'"),
    "too many missing": (
        [*EVEN[:900], *(f"{i / 50:.2f},nan" for i in range(900, 1500))],
        "r.csv: 900 samples; at least 1000 are needed (600 of 1500 rows omitted: no value of",
    ),
    "text": ([*EVEN[:7], "0.14,x"], "r.csv:9: column gyro_z"),
    "too short": ([*EVEN[:7], "0.14", *EVEN[8:]], "r.csv:9: 1 fields"),
    "backwards": ([*EVEN[:700], "0.5,1", *EVEN[701:]], "r.csv:702: column time_s: time runs"),
    "none": ([], "no samples"),
    "still": (
        [f"{i / 50:.2f},{(i % 997 == 0) * 0.1}" for i in range(3000)],
        "column gyro_z_dps hardly changes",
    ),
}
OWN = [  # an effect, what is wrong with it
    ("'mean', '', regressor=lambda r, s: r.time_s[1:]", "regressor: 1499 instead of 1500 values"),
    ("'mean', '', regressor=lambda r, s: r.time_s / 0", "regressor: not finite at index 0"),
    ("'mean', '', regressor=lambda r, s: 1 / 0", "regressor: ZeroDivisionError"),
    ("'variance', '', regressor=lambda r, s: r.time_s - 1", "regressor: negative at index 0"),
    ("'spectrum', '', spectrum=lambda f, r, s: -f", "spectrum: negative"),
    ("'spectrum', '', spectrum=lambda f, r, s: f[1:]", "spectrum: "),
]


@pytest.fixture
def rec(lab):
    rows = "".join(f"{i / 50:.2f},{math.sin(i * i % 997):.4f},{i % 7}\n" for i in range(1500))
    return lab.file("r.csv", "time_s,gyro_z_dps,temp_degC\n" + rows)


@pytest.mark.parametrize("command", REFUSED)
def test_options_and_outputs(lab, rec, command):
    words = command.format(rec=rec, model=lab.model, out=lab.work / "out").split()
    lab.refused(REFUSED[command], *words)


@pytest.mark.slow
@pytest.mark.parametrize(
    "top, row, rows, why",
    [
        (
            b"time_s,gyro_z_dps\n",
            b"1.000000000,1.000000000\n",
            3 << 20,
            "the gzip file expands to more than 64 MiB and 100 times its size",
        ),
        (b"", b"# a: %s\n" % (b"b" * 250), 300 << 10, "the first 4097 lines are comments"),
    ],
    ids=["rows", "comments"],
)
def test_a_gzip_file_that_would_fill_the_memory(lab, top, row, rows, why):
    packed = lab.work / "packed.csv.gz"
    packed.write_bytes(gzip.compress(top + row * rows, 9))
    assert packed.stat().st_size < 700_000
    lab.refused(why, "fit", packed, "-m", lab.model)


def test_what_standard_output_cannot_take_is_told():
    command = [sys.executable, "-m", "davarlab", "effects"]
    with open("/dev/full", "wb") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
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


@pytest.mark.parametrize("text, why", MODELS)
def test_bad_models(lab, text, why):
    recording = lab.file("r.csv", "time_s,gyro_z_dps\n" + "\n".join(EVEN) + "\n")
    lab.refused(why, "compare", recording, "-m", lab.file("bad.toml", text))


@pytest.mark.parametrize("name", ROWS)
def test_bad_rows(lab, name):
    rows, why = ROWS[name]
    recording = lab.file("r.csv", "\n".join(["time_s,gyro_z_dps", *rows, ""]))
    # What hardly changes is found after the note "reading the spectrum".
    lab.refused(why, "compare", recording, "-m", lab.model, lines=2 if name == "still" else 1)


def test_a_recording_of_live_that_cannot_be_written(lab):
    ours, its = pty.openpty()
    why = "--record: /nonexistent/a.csv: No such file or directory"
    lab.refused(why, "live", f"slcan:{os.ttyname(its)}", "--record", "/nonexistent/a.csv")
    os.close(its)
    os.close(ours)


@pytest.mark.parametrize("text, why", OWN)
def test_own_effects(lab, rec, text, why):
    """One that can be read fails in the search, after the notes of its two steps."""
    own = lab.file("own.py", f"{HEAD}OWN = Effect('own', '', SIZE, '', {text})\n")
    words = ("diagnose", rec, "-m", lab.model, "--effects", own)
    lab.refused(f"own: {why}", *words, lines=3)
    lab.file("own.py", f"{HEAD}OWN = Effect('own')\n")
    lab.refused("TypeError", *words)


def test_a_scenario_is_a_model_and_what_is_assumed_is_said(lab, rec):
    scenario = lab.file("s.toml", f"{SENSOR}[simulate]\nduration_s = 30\n{BASE}")
    assert run("fit", rec, "-m", scenario).returncode == 0
    done = run("add", lab.model, "sinusoid", "-o", lab.work / "out")
    assert done.returncode == 0
    assert "amplitude_dps = 0.001, frequency_hz = 0.001" in done.stderr


@pytest.mark.slow
def test_the_spectrum_of_the_design_is_found(lab):
    text = (ROOT / "python/davarlab/DESIGN.md").read_text()
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


NIGHTS = """import numpy as np
from davarlab.effects.base import Effect, Parameter

def level(recording, shape):
    return np.abs(np.sin(np.pi * recording.time_s / shape["period_s"])) ** 3

NIGHTS = Effect("nights", "The noise comes and goes.",
                (Parameter("std_dps", "deg/s", 0, 1e3), Parameter("period_s", "s", 10, 1e4)),
                "Wait.", "variance", "slope -1/2", regressor=level,
                grid={"period_s": lambda recording: (150.0, 200.0, 300.0)})
"""


@pytest.mark.slow
def test_noise_of_a_level_of_ones_own_is_found(lab):
    own = lab.file("nights.py", NIGHTS)
    effect = '[[effect]]\nkind = "nights"\nstd_dps = 0.05\nperiod_s = 200.0\n'
    recording = lab.simulated(effect, seconds=1200, options=("--effects", own))
    found = lab.diagnosed(recording, "--effects", own)
    assert found["missing"] == ["nights"]
    value = found["fitted"][-1]["parameters"]
    assert value["std_dps"]["low"] < 0.05 < value["std_dps"]["high"]
    assert value["period_s"]["value"] == 200.0
    assert found["final"]["adequacy"] == "statistical"


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
