"""Every pair of options of the commands that read a recording or a model, on the shortest
recording: done, not adequate, or refused in one line. Never an error of the program itself.
"""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from asking import run
from davarlab import cli
from davarlab.commands.shared import LOG
from davarlab.data.recording import MINIMUM_SAMPLES
from davarlab.report import plot
from lab_bench import BASE, SENSOR, write_csv

COMMANDS = {  # the words that each needs
    "simulate": "s.toml -o out.csv",
    "fit": "r.csv",
    "compare": "r.csv -m m.toml",
    "diagnose": "r.csv",
    "improve": "r.csv",
    "add": "m.toml sinusoid -o out.toml",
    "effects": "",
    "plot": "r.csv -m m.toml -o out.png",
    "export": "m.toml -o out.h",
    "sheet": "-o out.toml",
    "import": "r.csv -o out.csv",
    "dbc": "-o out.dbc",
}
SLOW = ("diagnose", "improve")
OTHERS = {
    "open",
    "live",
    "fleet",
    "imu",
    "benchmark",
    "nulls",
}  # servers, sources and pools of processes
# Option or further arguments: values. The first one meets every other option.
VALUES = {
    "--model": ("m.toml", "imu.yaml"),
    "--output": ("out.h", "out.toml", "out.csv", "out.svg"),
    "--held-out": ("other.csv", "short.csv"),
    "--report": ("r.html",),
    "--axes": ("gyro", "accel", "gyro_x_dps,temp_degC"),
    "--rate": ("50",),
    "--sensor": ("recording", "imu0"),
    "--unit": ("gyro=mdeg/s", "accel=0.001"),
    "--as-recorded": ("",),
    "--types": (".",),
    "--names": ("time_s,gyro_x_dps,gyro_z_dps,accel_z_g,temp_degC", "a,b,c,d,e"),
    "--skip-lines": ("1",),
    "--list": ("",),
    "--rename": ("temp_degC=pressure",),
    "--scale": ("gyro_x_dps=2",),
    "--json": ("",),
    "--effects": ("own.py",),
    "--to": ("kalibr", "plan"),
    "--recording": ("r.csv",),
    "--inflate": ("3",),
    "--bias-time": ("100",),
    "--window": ("600",),
    "--tolerance": ("0.1",),
    "--kalibr": ("imu.yaml",),
    "--column": ("accel_z_g", "gyro_x_dps"),
    "--base": ("600",),
    "--channel": ("1",),
    "numbers": ("0.3deg/√hr", "100ug/√Hz"),
    "parameters": ("frequency_hz=3",),
}
OWN = (
    "from davarlab.effects.base import Effect, Parameter\n"
    "SIZE = Parameter('size_dps', 'deg/s', -1, 1)\n"
    "MINE = Effect('mine', 'a ramp', (SIZE,), 'look', 'mean', 'none',\n"
    "              regressor=lambda recording, shape: recording.time_s)\n"
)


@pytest.fixture(autouse=True)
def there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(1)
    for name, count in (("r.csv", MINIMUM_SAMPLES), ("other.csv", 1200), ("short.csv", 900)):
        noise = 0.035 * rng.standard_normal((4, count))
        names = ("gyro_x_dps", "gyro_z_dps", "accel_z_g", "temp_degC")
        columns = {"time_s": np.arange(count) / 50, **dict(zip(names, noise))}
        columns["accel_z_g"] += 1
        columns["temp_degC"] += 25
        write_csv(name, columns, "%.5f")
    Path("m.toml").write_text(SENSOR + BASE)
    Path("imu.yaml").write_text(
        "gyroscope_noise_density: 1e-4\naccelerometer_noise_density: 1e-3\n"
    )
    Path("s.toml").write_text(SENSOR + "[simulate]\nseed = 1\nduration_s = 60\n" + BASE)
    Path("own.py").write_text(OWN)


def options_of(command):
    """Options by their longest names, and optional arguments by their own."""
    (commands,) = (one for one in cli.parser()._actions if one.dest == "command")
    return [
        max(one.option_strings, key=len, default=one.dest)
        for one in commands.choices[command]._actions
        if one.dest != "help" and (one.option_strings or one.nargs == "*")
    ]


def words_of(option, value):
    return [option] * option.startswith("-") + [value] * bool(value)


def sets_of_words(command):
    """Every pair of options with their first values, and every other value alone. The SLOW
    commands read a recording as fit does, whatever two options say of it."""
    options = options_of(command)
    reading = {name for names, _ in LOG for name in names} if command in SLOW else set()
    for one, other in itertools.combinations(options, 2):
        if {one, other} <= reading:
            continue
        yield words_of(one, VALUES[one][0]) + words_of(other, VALUES[other][0])
    for one in options:
        yield from (words_of(one, value) for value in VALUES[one][1:])


def test_every_command_is_here():
    assert COMMANDS.keys() | OTHERS == cli.COMMANDS.keys()


@pytest.mark.parametrize(
    "command",
    [pytest.param(one, marks=[pytest.mark.slow] * (one in SLOW)) for one in COMMANDS],
)
def test_no_pair_of_options_is_an_internal_error(command, monkeypatch):
    monkeypatch.setattr(plot, "draw", lambda found, path: None)  # a second each, of no option
    for words in sets_of_words(command):
        done = run(command, *COMMANDS[command].split(), *words)
        assert done.returncode in (0, 1, 2), (words, done.stderr)
        assert "Traceback" not in done.stderr, (words, done.stderr)
        if done.returncode == 2:
            assert (done.stdout, done.stderr[:10]) == ("", "davarlab: "), (words, done.stderr)
        elif "--json" in words:
            json.loads(done.stdout)
