"""Mistakes of units, rates and levels: each is understood, refused, or doubted aloud before
anything is fitted, and never comes out as adequate; recordings of real sensors' sizes are not
doubted.
"""

import json
import math
import re
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from asking import MODEL, ROOT, run
from davarlab.data import plausible, recording
from lab_bench import write_csv
from pyarrow import parquet

RATE, SIGMA, COUNT = 100.0, 0.05, 6000
ARW = 60 * SIGMA / math.sqrt(RATE)


def sensor(seed=1, rate=RATE, sigma=SIGMA, count=COUNT, lsb=0.0):
    """What a sensor at rest measures, in s, deg/s, g and degC."""
    rng = np.random.default_rng(seed)
    gyro = sigma * rng.standard_normal((2, count)) + 0.1 * sigma
    gyro = np.round(gyro / lsb) * lsb if lsb else gyro
    return {
        "time_s": 0.25 + np.arange(count) / rate,
        "gyro_x_dps": gyro[0],
        "gyro_z_dps": gyro[1],
        "temp_degC": 25 + 0.01 * rng.standard_normal(count),
        **{f"accel_{axis}_g": (axis == "z") + 0.002 * rng.standard_normal(count) for axis in "xyz"},
    }


@dataclass
class Mistake:
    """factor: column -> what its numbers are multiplied with; add: what is added; whole: columns
    that are rounded; rename: column -> its name in the file; said: words of the doubt; cure:
    options that give the truth.
    """

    said: str = ""
    factor: dict = field(default_factory=dict)
    add: dict = field(default_factory=dict)
    whole: tuple = ()
    rename: dict = field(default_factory=dict)
    cure: str = ""
    lsb: float = 0.0
    rate: float = RATE


ACCELS = [f"accel_{axis}_g" for axis in "xyz"]
RADIANS = dict.fromkeys(("gyro_x_dps", "gyro_z_dps"), math.pi / 180)
UNDERSTOOD = {"usec": 1e6, "timestamp": 1e6, "timestamp_ns": 1e9, "millis": 1e3}  # a second
RENAMED = {  # column, its name in the file, its unit in that of the column, words of the error
    "usec to seconds": ("time_s", "usec", 1e-6, "column usec: its name has unit us"),
    "ms to seconds": ("time_s", "time_ms", 1e-3, "--scale time_s=0.001"),
    "rad/s to deg/s": ("gyro_z_dps", "wz_rad_s", 180 / math.pi, "its name has unit rad/s"),
    "mdps to deg/s": ("gyro_z_dps", "gz_mdps", 1e-3, "--scale gyro_z_dps=0.001"),
}
MILLIS = Mistake("--unit time=ms", {"time_s": 1e3}, whole=("time_s",), cure="--unit time=ms")
NOTED = {
    "ms called seconds": MILLIS,
    "ms of a 1 kHz sensor": replace(MILLIS, said="whole numbers, 1 apart", rate=1000.0),
}
DOUBTED = {
    "us called seconds": Mistake("--unit time=us", {"time_s": 1e6}, cure="--unit time=us"),
    "ns called seconds": Mistake("--unit time=ns", {"time_s": 1e9}, cure="--unit time=ns"),
    "mdeg/s called deg/s": Mistake(
        "implausible noise", {"gyro_z_dps": 1e3}, cure="--unit gyro_z_dps=mdeg/s"
    ),
    "counts called deg/s": Mistake(
        "whole numbers, as counts are",
        {"gyro_z_dps": 131.0},
        whole=("gyro_z_dps",),
        cure=f"--unit gyro_z_dps={1 / 131!r}",
    ),
    "microdegrees": Mistake("implausible noise", {"gyro_z_dps": 1e-6}),
    "beyond every range": Mistake("implausible level", add={"gyro_z_dps": 3000.0}),
    "rad/s called deg/s, counts of 8.75 mdps": Mistake(
        "--unit gyro=rad/s", RADIANS, lsb=0.00875, cure="--unit gyro=rad/s"
    ),
    "deg/s called rad/s, counts of 8.75 mdps": Mistake(
        "--unit gyro=deg/s", rename={"gyro_z_dps": "gyro_z_rad_s"}, lsb=0.00875
    ),
    "kelvin": Mistake("implausible temperature", add={"temp_degC": 273.15}),
    "temperature in counts": Mistake("temp_degC", {"temp_degC": 340.0}),
    **{
        f"{unit} called g": Mistake(
            f"--unit accel={unit}", dict.fromkeys(ACCELS, size), cure=f"--unit accel={unit}"
        )
        for unit, size in (("m/s^2", 9.80665), ("mg", 1000.0))
    },
}


def written(lab, mistake):
    columns = sensor(lsb=mistake.lsb, rate=mistake.rate)
    for name, factor in mistake.factor.items():
        columns[name] = columns[name] * factor
    for name, more in mistake.add.items():
        columns[name] = columns[name] + more
    for name in mistake.whole:
        columns[name] = np.round(columns[name])
    path = lab.work / "rec.csv"
    names = [mistake.rename.get(name, name) for name in columns]
    write_csv(path, dict(zip(names, columns.values())), "%.12g")
    return path, model_of(lab, mistake.rename.get("gyro_z_dps", "gyro_z_dps"))


def model_of(lab, column="gyro_z_dps"):
    return lab.file("m.toml", MODEL.format(column=column, n=0.3, b=0.001))


def asked(command, path, model, *options):
    """(JSON, details of what is implausible, the command)."""
    done = run(command, path, "-m", model, *options, "--json")
    assert done.returncode in (0, 1), done.stderr
    found = json.loads(done.stdout)
    seen = [one["detail"] for one in found["observations"] if one["kind"] == "implausible"]
    return found, seen, done


def assert_true(path, model, *options, rate=RATE):
    """The recording is as the sensor was: not doubted, its white noise and its rate as they
    are.
    """
    found, seen, done = asked("fit", path, model, *options)
    assert ("doubtful" in done.stderr, seen) == (False, [])
    assert found["adequate"], found["said"]
    arw = found["effects"][0]["parameters"]["coefficient_deg_per_sqrt_h"]
    assert 0.97 * arw["low"] < 60 * SIGMA / math.sqrt(rate) < 1.03 * arw["high"], arw


@pytest.mark.parametrize("name", UNDERSTOOD)
def test_a_unit_that_the_name_says_is_understood(lab, name):
    mistake = Mistake(
        factor={"time_s": UNDERSTOOD[name]}, rename={"time_s": name}, whole=("time_s",)
    )
    assert_true(*written(lab, mistake))


@pytest.mark.parametrize("name", RENAMED)
def test_a_name_that_is_contradicted_is_refused(lab, name):
    column, named, unit, why = RENAMED[name]
    path, _ = written(lab, Mistake(factor={column: 1 / unit}, rename={column: named}))
    words = ("import", path, "-o", lab.work / "out.csv", "--rename", f"{named}={column}")
    scale = re.search(r"--scale (\S+),", lab.refused(why, *words))[1]  # what it says to type
    assert run(*words, "--scale", scale).returncode == 0


def assert_said_first(done, mark, words):
    """Before anything is fitted."""
    lines = done.stderr.splitlines()
    place = next(place for place, line in enumerate(lines) if mark in line)
    assert words in lines[place]
    assert place < next(place for place, line in enumerate(lines) if "spectrum" in line)


@pytest.mark.parametrize("name", DOUBTED)
def test_what_is_implausible_is_doubted_first_and_never_adequate(lab, name):
    mistake = DOUBTED[name]
    path, model = written(lab, mistake)
    found, seen, done = asked("fit", path, model)
    assert any(mistake.said in one for one in seen), seen
    assert (found["adequacy"], found["adequate"]) == ("no", False)
    assert "The recording is implausible" in found["said"]
    assert_said_first(done, "doubtful", mistake.said)
    if mistake.cure:
        assert_true(path, model, *mistake.cure.split(), rate=mistake.rate)


def test_axes_of_counts_share_a_sentence():
    names = [f"gyro_{axis}_dps" for axis in "xyz"]
    counts = np.random.default_rng(5).integers(-3, 4, (3, 1000)).astype(float)
    (said,) = plausible.doubts(dict(zip(names, counts)), 100.0, None, names)
    assert said.startswith(f"columns {', '.join(names)}: all values are whole numbers")


@pytest.mark.parametrize("name", NOTED)
def test_whole_stamps_that_may_be_milliseconds_get_a_note(lab, name):
    mistake, note = NOTED[name], "note: the time stamps are whole numbers"
    path, model = written(lab, mistake)
    _, seen, done = asked("fit", path, model)
    assert seen == []
    assert_said_first(done, note, mistake.said)
    assert note not in run("fit", path, "-m", model, "--as-recorded").stderr
    assert_true(path, model, *mistake.cure.split(), rate=mistake.rate)


@pytest.mark.slow
def test_every_command_doubts_and_believes_who_confirms(lab):
    path, model = written(lab, DOUBTED["us called seconds"])
    for command in ("compare", "diagnose", "improve"):
        found, seen, done = asked(command, path, model)
        last, status = found.get("final", found), 0 if command == "diagnose" else 1
        assert (last["adequacy"], done.returncode, bool(seen)) == ("no", status, True), command
        assert found.get("verdict", "unknown") == "unknown"
        text = run(command, path, "-m", model).stdout
        assert "The recording is implausible" in text
        assert "that this tool does not know" not in text
    found, _, done = asked("fit", path, model, "--as-recorded")
    assert (found["adequate"], found["observations"]) == (True, [])
    assert "doubtful" not in done.stderr
    done = run("import", path, "-o", lab.work / "out.csv")
    assert "doubtful" in done.stderr
    out = lab.work / "fleet"
    done = run("fleet", path, "-m", model, "-o", out, "--chance", 0, "--workers", 1)
    assert done.returncode == 0, done.stderr
    (row,) = parquet.read_table(out / "fleet.parquet").to_pylist()
    assert (row["adequacy"], row["verdict"]) == ("no", "unknown")


def test_a_rate_that_was_given_is_doubted_too(lab):
    path = write_csv(lab.work / "rec.csv", {"gyro_z_dps": sensor()["gyro_z_dps"]})
    for rate, adequate in (("0.01", False), ("100", True)):
        assert asked("fit", path, model_of(lab), "--rate", rate)[0]["adequate"] == adequate
    path, model = written(lab, Mistake())  # before the record is found too short
    done = run("fit", path, "-m", model, "--unit", "time_s=us")
    assert (done.returncode, done.stdout) == (2, "")
    assert "doubtful: implausible sample rate 1e+08 Hz (gyros: 0.02 Hz to 40 kHz). " in done.stderr


def test_sensors_as_there_are_are_not_doubted():
    gyros = ["gyro_x_dps", "gyro_z_dps"]
    for rate in (0.02, 0.1, 0.5, 1.6, 10, 50, 100, 1000, 8000, 32000):
        for arw in (1e-4, 0.003, 0.1, 0.3, 1.6, 15.0):
            sigma = arw * math.sqrt(rate) / 60
            for lsb in (0.0, 0.061, 0.00875, 1 / 131, 1 / 16.4, 1e-4):
                if lsb < 10 * sigma:
                    columns = sensor(rate=rate, sigma=sigma, lsb=lsb, count=2000)
                    assert plausible.doubts(columns, rate, None, gyros) == [], (rate, arw, lsb)


def test_the_bundled_recordings_are_not_doubted():
    there = sorted((ROOT / "data").rglob("*.csv*"))
    found = [path for path in there if path.suffix == ".gz" or b"gyro" in path.read_bytes()[:2000]]
    assert found
    for path in found:
        assert plausible.of_recording(recording.read(path)) == [], path
