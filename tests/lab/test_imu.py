"""The numbers for a filter: against AllanTools on recordings of sensors, against what a simulation
was made with, and against the formulas of the other programs."""

import json
import math
import os
import re
from pathlib import Path

import allantools
import lab_bench
import numpy as np
import pytest
import yaml
from asking import run
from davarlab.data import recording as recordings
from davarlab.report import parameters

ROOT = Path(__file__).resolve().parents[2]
REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real"))
FLIGHTS = REAL.parent / "flight"
PX4_SHORT = REAL.parent / "logs/px4_cubeorange_at_rest_6s.ulg"  # three gyros have 6 samples
RATE, RAD = 100.0, math.pi / 180
N, B = {"x": 0.2, "y": 0.3, "z": 0.4}, 5.0
VRW = 0.06  # m/s/sqrt(h)


@pytest.fixture(scope="module")
def imu(tmp_path_factory):
    """Ten minutes of three gyros and three accelerometers at rest."""
    rng = np.random.default_rng(11)
    count = int(600 * RATE)
    columns = {"time_s": np.arange(count) / RATE}
    columns |= {
        f"gyro_{axis}_dps": lab_bench.noise(count, RATE, rng, n, B) for axis, n in N.items()
    }
    force = VRW / 60 * np.sqrt(RATE) / 9.80665 * rng.standard_normal((3, count))
    columns |= {f"accel_{axis}_g": one for axis, one in zip("xyz", force + [[0], [0], [1]])}
    return lab_bench.write_csv(tmp_path_factory.mktemp("imu") / "imu.csv", columns)


def found(*words, statuses=(0,)):
    done = run("imu", *words, "--json")
    assert done.returncode in statuses, done.stderr
    return json.loads(done.stdout)


def test_every_axis_and_all_together_have_what_they_were_made_with(imu):
    told = found(imu)["axes"]
    inside = 0
    for axis, true in N.items():
        arw = told[f"gyro_{axis}_dps"]["ARW [deg/sqrt(h)]"]
        inside += arw["low"] < true < arw["high"]
        assert arw["high"] / arw["low"] < 1.03
        assert arw["value"] == pytest.approx(true, rel=0.03)
        density = told[f"gyro_{axis}_dps"]["gyroscope_noise_density [rad/s/sqrt(Hz)]"]
        assert density["value"] == pytest.approx(arw["value"] / 60 * RAD)
        vrw = told[f"accel_{axis}_g"]["VRW [m/s/sqrt(h)]"]
        inside += vrw["low"] < VRW < vrw["high"]
    assert inside >= 4  # of 6 at 95 %: fewer has a chance of 0.2 %
    mean = told["gyro pooled"]["ARW [deg/sqrt(h)]"]
    assert mean["low"] < np.sqrt(np.mean(np.square(list(N.values())))) < mean["high"]


def test_a_file_has_the_numbers_of_the_table(imu, lab):
    told = found(imu)["axes"]
    out = lab.work / "imu.yaml"
    done = run("imu", imu, "--to", "kalibr", "-o", out)
    assert done.returncode == 0
    assert str(out) in done.stdout
    made = yaml.safe_load(out.read_text())
    name = "gyroscope_noise_density"
    most = max(told[f"gyro_{axis}_dps"][f"{name} [rad/s/sqrt(Hz)]"]["value"] for axis in "xyz")
    assert made[name] == pytest.approx(most, rel=1e-5)
    assert made["update_rate"] == RATE


@pytest.mark.parametrize("target", [*parameters.FORMATS, "json"])
def test_every_target_has_its_units_and_its_file(imu, lab, target):
    out = lab.work / "out"
    done = run("imu", imu, "--to", target, "-o", out)
    assert done.returncode == 0, done.stderr
    form = parameters.FORMATS.get(target, parameters.FORMATS["kalibr"])
    for one in form.parameters:
        assert one.name in done.stdout
        assert one.unit in done.stdout
    assert out.stat().st_size > 200
    if target == "openvins":
        assert set(yaml.safe_load(out.read_text())["imu0"]) > {"gyroscope_noise_density"}


def test_a_random_walk_that_is_converted_has_no_interval(imu):
    """And one that an hour shows has, with the true value in most of them."""
    told = found(imu)["axes"]["gyro_z_dps"]["gyroscope_random_walk [rad/s^2/sqrt(Hz)]"]
    assert told["value"] > 0
    assert told["low"] is None
    said = run("imu", imu).stdout
    assert "gyroscope_random_walk and accelerometer_random_walk without interval" in said


def test_a_random_walk_that_shows_has_an_interval(lab):
    rng = np.random.default_rng(5)
    count, true = int(3600 * 20), 3e-4  # deg/s/sqrt(s)
    inside = 0
    columns = {"time_s": np.arange(count) / 20.0}
    for axis in "xyz":
        walk = true / np.sqrt(20.0) * np.cumsum(rng.standard_normal(count))
        columns[f"gyro_{axis}_dps"] = lab_bench.noise(count, 20.0, rng, 0.2, 0.1) + walk
    told = found(lab_bench.write_csv(lab.work / "walk.csv", columns))["axes"]
    for axis in "xyz":
        one = told[f"gyro_{axis}_dps"]["gyroscope_random_walk [rad/s^2/sqrt(Hz)]"]
        inside += one["low"] is not None and one["low"] < true * RAD < one["high"]
    assert inside >= 2


def test_picks_of_a_fast_sensor_are_upper_limits(lab):
    rng = np.random.default_rng(6)
    columns = {"time_s": np.arange(3000.0), "gyro_z_dps": 0.05 * rng.standard_normal(3000)}
    said = run("imu", lab_bench.write_csv(lab.work / "picks.csv", columns)).stdout
    assert "Rate: at 1 Hz" in said


def test_noise_that_no_sensor_at_rest_has_is_motion_and_needs_no_simulator(lab, monkeypatch):
    monkeypatch.setenv("DAVAR_SIM", "/nonexistent")  # a wheel has none
    rng = np.random.default_rng(7)
    columns = {"time_s": np.arange(12000) / 100.0}
    columns["gyro_z_dps"] = 30.0 / 60 * 10 * rng.standard_normal(12000)
    said = run("imu", lab_bench.write_csv(lab.work / "loud.csv", columns)).stdout
    assert "no value at rest: an angle random walk of " in said
    assert "noise between rotor lines and motion" in said


def test_a_doubtful_unit_gives_a_moving_gyro_no_floor(lab):
    rng, count = np.random.default_rng(8), 6000
    columns = {"t": np.arange(count) / 100.0}
    for axis in "xyz":
        turns = np.convolve(rng.standard_normal(count), np.hanning(80), "same")
        moves = turns * (columns["t"] > 20)
        columns[f"gyro_{axis}"] = 0.5 * moves + 0.01 * rng.standard_normal(count)
    done = run("imu", lab_bench.write_csv(lab.work / "moves.csv", columns))
    assert done.returncode == 1
    assert "noise between rotor lines" not in done.stdout
    assert "gyro_x_dps: no value: the unit of the gyro is not known" in done.stdout


def test_what_a_value_at_rest_does_not_say_is_said(imu):
    said = run("imu", imu).stdout
    for word in ("Motion: ", "Vibration: ", "Temperature: not recorded", "Filter: none"):
        assert word in said


def test_a_file_that_is_there_stays(imu, lab, monkeypatch):
    monkeypatch.chdir(lab.work)
    assert run("imu", imu, "--to", "px4").returncode == 0
    assert "param set EKF2_GYR_NOISE" in (lab.work / "imu_px4.params").read_text()
    lab.refused("imu_px4.params: exists already. Type -o FILE", "imu", imu, "--to", "px4")
    lab.refused("-o: type --to FORMAT too", "imu", imu, "-o", lab.work / "new.yaml")


READINGS = [  # a recording, its axes, and the axes whose Allan deviation at 1 s is white noise
    ("mpu6050_static_11min_jitter.csv.gz", "xyz"),
    pytest.param("adis16405_run1_static.csv.gz", "xyz", marks=pytest.mark.soak),  # 6 million
    ("mpu6050_temp_ramp_gaps.csv.gz", "y"),
]


@pytest.mark.slow
@pytest.mark.parametrize("name, axes", READINGS)
def test_sensors_read_as_allantools_reads_them(name, axes):
    """60 times the Allan deviation at 1 s, within 5 %."""
    path = REAL / name
    if not path.exists():
        pytest.skip(f"{name} is not there")
    recording = recordings.read(path)
    told = found(path, statuses=(0, 1))["axes"]
    for axis in axes:
        y = recording.columns[f"gyro_{axis}_dps"]
        if recording.known is not None:  # the longest stretch without a gap
            edges = np.flatnonzero(np.diff(np.r_[0, recording.known.astype(int), 0]))
            first, last = max(zip(edges[::2], edges[1::2]), key=lambda one: one[1] - one[0])
            y = y[first:last]
        taus = np.array([1.0]) if len(y) > 50 * recording.rate_hz else np.array([0.1])
        _, deviation, _, _ = allantools.oadev(y, recording.rate_hz, "freq", taus)
        reading = 60 * float(deviation[0]) * np.sqrt(taus[0])
        value = told[f"gyro_{axis}_dps"]["ARW [deg/sqrt(h)]"]["value"]
        assert value == pytest.approx(reading, rel=0.05), axis


@pytest.mark.slow
def test_each_gyro_of_a_log_has_a_table_and_a_file_is_of_one(tmp_path):
    rng = np.random.default_rng(7)
    columns = {"time_s": np.arange(6000) / RATE}
    columns |= {
        f"gyro{which}.{axis}_dps": lab_bench.noise(6000, RATE, rng, n, 0.0)
        for which, n in enumerate((0.2, 0.6))
        for axis in "xyz"
    }
    log = lab_bench.write_csv(tmp_path / "two.csv", columns)
    lines = run("imu", log).stdout.splitlines()
    starts = [lines.index(f"--sensor gyro{which}._dps") for which in (0, 1)]
    for start, n in zip(starts, (0.2, 0.6)):
        pooled = next(line for line in lines[start:] if line.startswith("pooled"))
        assert float(pooled.split()[1]) == pytest.approx(n, rel=0.1)
    for typed in (["--to", "kalibr"], ["--json"]):
        done = run("imu", log, *typed)
        assert (done.returncode, done.stdout) == (2, "") and "--sensor NAME" in done.stderr


def test_a_gyro_that_is_too_short_is_not_in_the_way():
    log = PX4_SHORT
    if not log.exists():
        pytest.skip(f"no {log.name}")
    told = found(log, statuses=(1,))
    assert told["axes"]["gyro_x_dps"]["ARW [deg/sqrt(h)]"]["value"] > 0


def test_a_flight_has_its_floor():
    path = FLIGHTS / "betaflight_hover_17s_1khz.csv.gz"
    if not path.exists():
        pytest.skip(f"{path.name} is not there")
    done = run("imu", path, "--as-recorded")
    assert done.returncode == 0, done.stderr
    floors = re.findall(
        r"noise between rotor lines and motion: ([\d.]+) deg/sqrt\(h\)", done.stdout
    )
    assert len(floors) == 3
    assert all(0.5 < float(one) < 3 for one in floors)
    assert "at rest" in done.stdout


def moving(rate, seconds, white, rng, count=0.0):
    """Noise of a gyro that turns, deg/s, in counts of that size."""
    size = int(rate * seconds)
    motion = np.convolve(rng.standard_normal(size), np.hanning(int(rate)), "same")
    rates = white / 60 * np.sqrt(rate) * rng.standard_normal(size) + 30 * motion / np.std(motion)
    return np.round(rates / count) * count if count else rates


@pytest.mark.parametrize(
    "rate", [50, 200, 1000, 1969.43, 2000, pytest.param(8000, marks=pytest.mark.slow)]
)
def test_a_flight_of_any_rate_has_its_floor(lab, rate):
    """White noise of 0.6 deg/sqrt(h) below motion and, above 200 Hz, the lines of four rotors."""
    rng = np.random.default_rng(int(rate))
    rates = moving(rate, max(20, 8000 / rate), 0.6, rng)
    time = np.arange(len(rates)) / rate
    for turn in (61.0, 63.5, 66.2, 67.9) if rate > 200 else ():
        turns = turn * time + 0.2 * np.cumsum(rng.standard_normal(len(time))) / rate
        rates += 5 * np.sin(2 * np.pi * turns)
    columns = {"time_s": time, "gyro_z_dps": rates}
    done = run("imu", lab_bench.write_csv(lab.work / "flight.csv", columns))
    assert "assumes that no filter stands between the gyro and the log" in done.stdout
    (value,) = re.findall(r"rotor lines and motion: ([\d.]+) deg/sqrt\(h\)", done.stdout)
    assert float(value) == pytest.approx(0.6, rel=0.15)


@pytest.mark.parametrize("count, hidden", [(0.061, False), (0.3, True)])
def test_rounding_is_no_noise_of_a_gyro_in_motion(lab, count, hidden):
    """0.1 deg/sqrt(h) at 2 kHz is 0.075 deg/s per sample."""
    rates = moving(2000, 30, 0.1, np.random.default_rng(9), count)
    columns = {"time_s": np.arange(len(rates)) / 2000, "gyro_z_dps": rates}
    done = run("imu", lab_bench.write_csv(lab.work / "turns.csv", columns), "--bandwidth", "none")
    assert done.returncode == hidden, done.stderr
    assert ("rounding to counts hides it. It is below 0." in done.stdout) == hidden
    found = re.findall(r"rotor lines and motion: ([\d.]+) deg", done.stdout)
    assert [float(one) == pytest.approx(0.1, rel=0.15) for one in found] == [True] * (not hidden)
    assert "assumes that no filter stands" not in done.stdout


@pytest.mark.slow
def test_the_output_in_the_documentation_is_the_one_of_the_command(lab, monkeypatch):
    monkeypatch.chdir(lab.work)
    (lab.work / "build").mkdir()
    scenario = ROOT / "data/tutorial_sensor.toml"
    assert run("simulate", scenario, "-o", "build/rec.csv").returncode == 0
    text = (ROOT / "docs/IMU.md").read_text()
    commands, shown = re.findall(r"```(?:sh|text)\n(.*?)\n```", text, re.DOTALL)
    done = run(*commands.splitlines()[-1].removeprefix("tools/davarlab ").split())
    assert done.stdout.rstrip("\n") == shown


def test_an_axis_that_permits_no_value_says_why(lab):
    """Whole numbers without a unit, and an axis that is dead; the others have their values."""
    rng = np.random.default_rng(12)
    count = int(120 * RATE)
    columns = {"time_s": np.arange(count) / RATE}
    columns["gyro_x_dps"] = lab_bench.noise(count, RATE, rng, 0.3, B)
    columns["gyro_y_dps"] = np.round(lab_bench.noise(count, RATE, rng, 300.0, B))
    columns["gyro_z_dps"] = np.zeros(count)
    done = run("imu", lab_bench.write_csv(lab.work / "odd.csv", columns))
    assert done.returncode == 1, done.stderr
    assert re.search(r"gyro_x_dps +0\.(29|30)", done.stdout)
    assert "gyro_y_dps: The recording is implausible" in done.stdout
    assert "gyro_z_dps" in done.stdout
    assert "hardly changes" in done.stdout
