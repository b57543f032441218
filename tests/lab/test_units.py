"""Units that nobody has written down: of a gyro and an accelerometer whose names say none."""

import numpy as np
import pytest
from asking import run
from davarlab.tables import guess, meaning
from lab_bench import write_csv
from scipy import io, signal

DEG, G = np.pi / 180, 9.80665
AXES = "xyz"


def at_rest(seed, arw, rate_hz, seconds=60.0, cutoff_hz=0.0):
    """Rates in deg/s of three axes, with the bias of a usual gyro."""
    rng = np.random.default_rng(seed)
    count = int(seconds * rate_hz)
    found = arw / 60 * np.sqrt(rate_hz) * rng.standard_normal((3, count))
    if cutoff_hz:
        found = signal.lfilter(*signal.butter(2, cutoff_hz, fs=rate_hz), found)
    return found + rng.normal(0, 0.5, (3, 1))


def turned(seed, rate_hz, seconds=40.0):
    """(rates in deg/s, gravity in g): by hand, a quarter turn and more about every axis."""
    rng = np.random.default_rng(seed)
    count = int(seconds * rate_hz)
    swing = np.sin(2 * np.pi * np.arange(count) / rate_hz / np.array([[17.0], [11.0], [7.0]]))
    rate = 60.0 * swing + 0.3 * rng.standard_normal((3, count))
    up, gravity = np.array([0.0, 0.0, 1.0]), np.empty((3, count))
    for place in range(count):
        up = up - np.cross(rate[:, place] * DEG / rate_hz, up)
        up /= np.linalg.norm(up)
        gravity[:, place] = up
    return rate, gravity + 0.003 * rng.standard_normal((3, count))


def told(*arguments):
    """What a command printed."""
    done = run(*arguments)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout + done.stderr


def guessed(rate_hz, gyro, accel=None):
    """(the unit of the gyro, its doubt, that of the accelerometer)."""
    columns = {"time_s": np.arange(gyro.shape[1]) / rate_hz}
    columns |= {f"gyro_{axis}": one for axis, one in zip(AXES, gyro)}
    if accel is not None:
        columns |= {f"acc_{axis}": one for axis, one in zip(AXES, accel)}
    found = {one.name: one for one in meaning.guesses(columns)}
    return found["gyro_y"], found.get("acc_y")


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("unit, factor", [("deg/s", 1.0), ("rad/s", DEG)])
def test_without_evidence_the_unit_of_a_gyro_is_right_or_in_doubt(seed, unit, factor):
    """Any noise, rate and filter of MEMS gyros; of a usual one it is no doubt."""
    rng = np.random.default_rng([seed, 7])
    arw, rate_hz = float(np.exp(rng.uniform(np.log(0.05), np.log(3)))), float(rng.choice([50, 400]))
    for cutoff_hz in (0.0, 5.0):
        found, _ = guessed(rate_hz, at_rest(seed, arw, rate_hz, cutoff_hz=cutoff_hz) * factor)
        assert found.doubt or found.unit == unit
        assert found.factor == guess.RATES[found.unit]
    for usual in (0.2, 0.6):
        found, _ = guessed(rate_hz, at_rest(seed, usual, rate_hz) * factor)
        assert (found.unit, found.doubt) == (unit, "")


@pytest.mark.parametrize("unit, factor", [("deg/s", 1.0), ("rad/s", DEG)])
@pytest.mark.parametrize("force, size", [("g", 1.0), ("m/s^2", G)])
def test_gravity_that_turns_decides(unit, factor, force, size):
    for seed in range(3):
        rate, gravity = turned(seed, 100.0)
        gyro, accel = guessed(100.0, rate * factor, gravity * size)
        assert (gyro.unit, gyro.doubt, accel.unit) == (unit, "", force)
        assert "gravity, which turns" in gyro.by


def test_beside_an_accelerometer_in_si_units_a_gyro_at_rest_is_too():
    still = np.array([[0.1], [-0.2], [9.8]]) + 0.02 * np.random.default_rng(1).normal(
        size=(3, 6000)
    )
    gyro, accel = guessed(100.0, at_rest(1, 2.2, 100.0) * DEG, still)
    assert (gyro.unit, accel.unit) == ("rad/s", "m/s^2")
    assert "m/s^2 beside it" in gyro.by


def test_an_accelerometer_without_gravity_is_not_used(lab):
    """Its gyro is, and its user can say the unit."""
    rate_hz = 100.0
    gyro = at_rest(2, 0.3, rate_hz) * DEG
    linear = 0.01 * np.random.default_rng(3).normal(size=(3, gyro.shape[1]))
    columns = {"time_s": np.arange(gyro.shape[1]) / rate_hz}
    columns |= {f"gyro_{axis}": one for axis, one in zip(AXES, gyro)}
    columns |= {f"acc_{axis}": one for axis, one in zip(AXES, linear)}
    path = write_csv(lab.work / "phone.csv", columns)
    said = told("import", path, "-o", lab.work / "out.csv")
    assert "acc_x: linear acceleration: gravity is missing in it" in said
    text = (lab.work / "out.csv").read_text()
    assert "acc_x" in text
    assert "accel_x_g" not in text
    told("import", path, "-o", lab.work / "out.csv", "--unit", "accel=m/s^2")
    assert "accel_x_g" in (lab.work / "out.csv").read_text()


def test_a_unit_of_the_gyro_says_nothing_of_what_is_beside_it(lab):
    """In a log whose accelerometer is an array of its own."""
    path = lab.work / "noise.mat"
    made = {"Gyr_noise": at_rest(5, 0.3, 100.0).T * DEG, "Acc_noise": np.zeros((6000, 3))}
    made["Acc_noise"] += 0.01 * np.random.default_rng(6).normal(size=(6000, 3))
    io.savemat(path, made)
    words = ("diagnose", path, "--rate", "100", "--axes", "all")
    said = told(*words, "--unit", "gyro=rad/s")
    assert "gyro_x_dps" in said
    assert "gravity is missing" in said
    lab.refused("--unit mag=uT: ", *words, "--unit", "mag=uT")


def test_a_unit_in_doubt_is_no_verdict_and_no_recording(lab):
    rate_hz = 100.0
    gyro = at_rest(4, 2.2, rate_hz) * DEG
    columns = {"time_s": np.arange(gyro.shape[1]) / rate_hz}
    columns |= {f"gyro_{axis}": one for axis, one in zip(AXES, gyro)}
    path = write_csv(lab.work / "ahrs.csv", columns)
    why = (
        "doubtful: the unit of the gyro is not known (in deg/s, its angle random walk would be 0.0"
    )
    lab.refused(why, "import", path, "-o", lab.work / "out.csv")
    said = told("fit", path)
    assert "implausible" in said
    assert "--unit gyro=rad/s" in said
    assert "implausible" not in told("fit", path, "--unit", "gyro=rad/s")


CALM = {  # what gives no evidence, or two kinds that contradict each other
    "an accelerometer in m/s^2 beside a quiet gyro in deg/s": (1.0, {"metric": True}),
    "a sway in rad/s": (DEG, {"sway_dps": 1.2}),
    "a sway in deg/s": (1.0, {"sway_dps": 60.0}),
    "a noise that both units allow, one axis dead": (DEG, {"dead": True, "arw": 2.2}),
}


@pytest.mark.parametrize("name", CALM)
def test_what_is_no_evidence_leaves_a_doubt(name):
    """Or the right unit: never the other one."""
    factor, how = CALM[name]
    for seed in range(3):
        gyro = at_rest(seed, how.get("arw", 0.42), 100.0)
        time = np.arange(gyro.shape[1]) / 100.0
        gyro = gyro + how.get("sway_dps", 0.0) * np.sin(2 * np.pi * 0.1 * time)
        if how.get("dead"):
            gyro[2] = 0.0
        still = np.array([[0.1], [-0.2], [9.8]]) + 0.02 * np.random.default_rng(seed).normal(
            size=gyro.shape
        )
        found, _ = guessed(100.0, gyro * factor, still if how.get("metric") else None)
        assert found.doubt or found.unit == ("deg/s" if factor == 1.0 else "rad/s"), found
