"""Mistakes of units, rates and levels: each is understood, refused, or doubted aloud before
anything is fitted, and never comes out as adequate; recordings of real sensors' sizes are not
doubted.
"""

import json
import math
import re
from dataclasses import dataclass, field

import numpy as np
import pytest
from asking import MODEL, ROOT, run
from lab_bench import write_csv

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
    """rename: column -> the name that it bears in the file; factor: column -> what its numbers are
    multiplied with; options: of every command; said: words of the doubt or the error; cure: options
    that give the truth.
    """

    rename: dict = field(default_factory=dict)
    factor: dict = field(default_factory=dict)
    options: str = ""
    said: str = ""
    cure: str | None = None
    add: dict = field(default_factory=dict)
    whole: tuple = ()
    lsb: float = 0.0
    rate: float = RATE


UNDERSTOOD = {
    name: Mistake({"time_s": name}, {"time_s": factor}, whole=("time_s",))
    for name, factor in (
        ("usec", 1e6),
        ("time_us", 1e6),
        ("timestamp_us", 1e6),
        ("timestamp_ns", 1e9),
        ("time_ms", 1e3),
        ("msec", 1e3),
        ("nsec", 1e9),
        ("micros", 1e6),
        ("millis", 1e3),
        ("TimeUS", 1e6),
        ("t [us]", 1e6),
        ("timestamp", 1e6),
        ("microseconds", 1e6),
    )
}
REFUSED = {
    "usec renamed to seconds": Mistake(
        {"time_s": "usec"},
        {"time_s": 1e6},
        "--rename usec=time_s",
        "column usec: its name has unit us",
    ),
    "ms renamed to seconds": Mistake(
        {"time_s": "time_ms"}, {"time_s": 1e3}, "--rename time_ms=time_s", "--scale time_s=0.001"
    ),
    "rad/s renamed to deg/s": Mistake(
        {"gyro_z_dps": "wz_rad_s"},
        {"gyro_z_dps": math.pi / 180},
        "--rename wz_rad_s=gyro_z_dps",
        "its name has unit rad/s",
    ),
    "mdps renamed to deg/s": Mistake(
        {"gyro_z_dps": "gz_mdps"},
        {"gyro_z_dps": 1e3},
        "--rename gz_mdps=gyro_z_dps",
        "--scale gyro_z_dps=0.001",
    ),
}
NOTED = {
    "ms called seconds": Mistake(
        factor={"time_s": 1e3}, whole=("time_s",), said="--unit time=ms", cure="--unit time=ms"
    ),
    "ms of a 1 kHz sensor, whole": Mistake(
        factor={"time_s": 1e3},
        said="whole numbers, 1 apart",
        cure="--unit time=ms",
        whole=("time_s",),
        rate=1000.0,
    ),
}
DOUBTED = {
    "us called seconds": Mistake(
        factor={"time_s": 1e6}, said="--unit time=us", cure="--unit time=us"
    ),
    "ns called seconds": Mistake(
        factor={"time_s": 1e9}, said="--unit time=ns", cure="--unit time=ns"
    ),
    "mdeg/s called deg/s": Mistake(
        factor={"gyro_z_dps": 1e3}, said="implausible noise", cure="--unit gyro_z_dps=mdeg/s"
    ),
    "counts called deg/s": Mistake(
        factor={"gyro_z_dps": 131.0},
        whole=("gyro_z_dps",),
        said="whole numbers, as counts are",
        cure=f"--unit gyro_z_dps={1 / 131!r}",
    ),
    "microdegrees": Mistake(factor={"gyro_z_dps": 1e-6}, said="implausible noise"),
    "beyond every range": Mistake(add={"gyro_z_dps": 3000.0}, said="implausible level"),
    "rad/s called deg/s, counts of 8.75 mdps": Mistake(
        factor={"gyro_z_dps": math.pi / 180, "gyro_x_dps": math.pi / 180},
        lsb=0.00875,
        said="--unit gyro=rad/s",
        cure="--unit gyro=rad/s",
    ),
    "deg/s called rad/s, counts of 8.75 mdps": Mistake(
        {"gyro_z_dps": "gyro_z_rad_s"}, lsb=0.00875, said="--unit gyro=deg/s"
    ),
    "kelvin": Mistake(add={"temp_degC": 273.15}, said="implausible temperature"),
    "temperature in counts": Mistake(factor={"temp_degC": 340.0}, said="temp_degC"),
    "m/s^2 called g": Mistake(
        factor=dict.fromkeys(("accel_x_g", "accel_y_g", "accel_z_g"), 9.80665),
        said="--unit accel=m/s^2",
        cure="--unit accel=m/s^2",
    ),
    "mg called g": Mistake(
        factor=dict.fromkeys(("accel_x_g", "accel_y_g", "accel_z_g"), 1000.0),
        said="--unit accel=mg",
        cure="--unit accel=mg",
    ),
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
    model = lab.file(
        "m.toml",
        MODEL.format(column=mistake.rename.get("gyro_z_dps", "gyro_z_dps"), n=0.3, b=0.001),
    )
    return path, model


def asked(lab, command, path, model, *options):
    done = run(command, path, "-m", model, *options, "--json")
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout), done


def assert_true(lab, path, model, *options, rate=RATE):
    """The recording is as the sensor was: not doubted, its white noise and its rate as they
    are.
    """
    found, done = asked(lab, "fit", path, model, *options)
    assert "doubtful" not in done.stderr
    assert [one for one in found["observations"] if one["kind"] == "implausible"] == []
    assert found["adequate"], found["said"]
    low, high = (
        found["effects"][0]["parameters"]["coefficient_deg_per_sqrt_h"][end]
        for end in ("low", "high")
    )
    truth = 60 * SIGMA / math.sqrt(rate)
    assert 0.97 * low < truth < 1.03 * high, (low, truth, high)


@pytest.mark.parametrize("name", UNDERSTOOD)
def test_a_unit_that_the_name_says_is_understood(lab, name):
    mistake = UNDERSTOOD[name]
    assert_true(lab, *written(lab, mistake))


@pytest.mark.parametrize("name", REFUSED)
def test_a_name_that_is_contradicted_is_refused(lab, name):
    mistake = REFUSED[name]
    path, _ = written(lab, mistake)
    before = sorted(lab.work.iterdir())
    done = run("import", path, "-o", lab.work / "out.csv", *mistake.options.split())
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (2, "", 1), done.stderr
    assert mistake.said in done.stderr
    assert sorted(lab.work.iterdir()) == before
    scale = re.search(r"--scale (\S+),", done.stderr)[1]  # what it says to type
    done = run(
        "import",
        path,
        "-o",
        lab.work / "out.csv",
        *mistake.options.split(),
        "--scale",
        scale,
    )
    assert done.returncode == 0, done.stderr
    (lab.work / "out.csv").unlink()


@pytest.mark.parametrize("name", DOUBTED)
def test_what_is_implausible_is_doubted_first_and_never_adequate(lab, name):
    mistake = DOUBTED[name]
    path, model = written(lab, mistake)
    found, done = asked(lab, "fit", path, model, *mistake.options.split())
    said = [one["detail"] for one in found["observations"] if one["kind"] == "implausible"]
    assert any(mistake.said in one for one in said), said
    assert (found["adequacy"], found["adequate"]) == ("no", False)
    assert "The recording is implausible" in found["said"]
    lines = done.stderr.splitlines()
    doubt = next(place for place, line in enumerate(lines) if "doubtful" in line)
    assert mistake.said in lines[doubt]
    assert doubt < next(
        place for place, line in enumerate(lines) if "spectrum" in line
    )  # before anything is fitted
    if mistake.cure is not None:
        assert_true(lab, path, model, *mistake.cure.split(), rate=mistake.rate)


@pytest.mark.parametrize("name", NOTED)
def test_whole_stamps_that_may_be_milliseconds_get_a_note(lab, name):
    mistake = NOTED[name]
    path, model = written(lab, mistake)
    found, done = asked(lab, "fit", path, model)
    assert [one for one in found["observations"] if one["kind"] == "implausible"] == []
    lines = done.stderr.splitlines()
    note = next(
        place
        for place, line in enumerate(lines)
        if "note: the time stamps are whole numbers" in line
    )
    assert mistake.said in lines[note]
    assert note < next(
        place for place, line in enumerate(lines) if "spectrum" in line
    )  # before anything is fitted
    assert "note: the time" not in run("fit", path, "-m", model, "--as-recorded").stderr
    assert_true(lab, path, model, *mistake.cure.split(), rate=mistake.rate)


@pytest.mark.slow
def test_every_command_doubts_and_believes_who_confirms(lab):
    path, model = written(lab, DOUBTED["us called seconds"])
    for command in ("compare", "diagnose", "improve"):
        found, done = asked(lab, command, path, model)
        last = found.get("final", found)
        assert (last["adequacy"], done.returncode) == ("no", 0 if command == "diagnose" else 1), (
            command
        )
        assert "implausible" in [one["kind"] for one in found["observations"]]
        if "verdict" in found:
            assert found["verdict"] == "unknown"
        text = run(command, path, "-m", model).stdout
        assert "The recording is implausible" in text
        assert "that this tool does not know" not in text
    found, done = asked(lab, "fit", path, model, "--as-recorded")
    assert (found["adequate"], found["observations"]) == (True, [])
    assert "doubtful" not in done.stderr
    done = run("import", path, "-o", lab.work / "out.csv")
    assert "doubtful" in done.stderr
    assert (
        run(
            "fleet",
            path,
            "-m",
            model,
            "-o",
            lab.work / "fleet",
            "--chance",
            "0",
            "--workers",
            "1",
            "--json",
        ).returncode
        == 0
    )
    (row,) = rows(lab, lab.work / "fleet")
    assert (row["adequacy"], row["verdict"]) == ("no", "unknown")


def rows(lab, folder):
    import pyarrow.parquet

    return pyarrow.parquet.read_table(folder / "fleet.parquet").to_pylist()


def test_a_rate_that_was_given_is_doubted_too(lab):
    columns = sensor()
    path = lab.work / "rec.csv"
    path.write_text(
        "gyro_z_dps\n" + "\n".join(f"{value:.9g}" for value in columns["gyro_z_dps"]) + "\n"
    )
    model = lab.file("m.toml", MODEL.format(column="gyro_z_dps", n=0.3, b=0.001))
    assert asked(lab, "fit", path, model, "--rate", "0.01")[0]["adequacy"] == "no"
    assert asked(lab, "fit", path, model, "--rate", "100")[0]["adequate"]


def test_a_rate_far_too_high_is_doubted_before_the_record_is_found_too_short(lab):
    path, model = written(lab, Mistake())
    done = run("fit", path, "-m", model, "--unit", "time_s=us")
    assert (done.returncode, done.stdout) == (2, "")
    assert "doubtful: implausible sample rate 1e+08 Hz (gyros: 0.02 Hz to 40 kHz). " in done.stderr


def test_a_channel_that_stands_still_is_refused(lab):
    columns = sensor()
    path = lab.work / "rec.csv"
    path.write_text(
        "time_s,gyro_z_dps\n" + "".join(f"{time:.2f},0.5\n" for time in columns["time_s"])
    )
    done = run(
        "fit",
        path,
        "-m",
        lab.file("m.toml", MODEL.format(column="gyro_z_dps", n=0.3, b=0.001)),
    )
    assert done.returncode == 2
    assert "hardly changes" in done.stderr


def test_sensors_as_there_are_are_not_doubted():
    from davarlab.data import plausible

    for rate in (0.02, 0.1, 0.5, 1.6, 10, 50, 100, 1000, 8000, 32000):
        for arw in (1e-4, 0.003, 0.1, 0.3, 1.6, 15.0):
            sigma = arw * math.sqrt(rate) / 60
            for lsb in (
                0.0,
                *(one for one in (0.061, 0.00875, 1 / 131, 1 / 16.4, 1e-4) if one < 10 * sigma),
            ):
                columns = sensor(rate=rate, sigma=sigma, lsb=lsb, count=2000)
                assert plausible.doubts(columns, rate, None, ["gyro_x_dps", "gyro_z_dps"]) == [], (
                    rate,
                    arw,
                    lsb,
                )


def test_the_bundled_recordings_are_not_doubted():
    from davarlab.data import plausible, recording

    found = [
        path
        for path in sorted((ROOT / "data").rglob("*.csv*"))
        if "gyro" in path.read_bytes()[:2000].decode("latin-1") or path.suffix == ".gz"
    ]
    assert found
    for path in found:
        assert plausible.of(recording.read(path)) == [], path
