"""fit, compare and improve on all axes of a recording in one go, accelerometers in their units."""

import re

import lab_bench
import numpy as np
import pytest
import writing_logs as writing
from asking import run, said
from davarlab import model as models
from davarlab.effects import table

RATE = 200
# deg/sqrt(h), m/s/sqrt(h): of the x axes; y has twice, z three times as much
N_DEG, N_M = 0.3, 0.12
MODEL = f"""[sensor]
rate_hz = {RATE}.0
column = "gyro_x_dps"
[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 1.0
"""
GYROS = [f"gyro_{axis}_dps" for axis in "xyz"]


@pytest.fixture
def log(lab):
    rng, truth = np.random.default_rng(5), writing.Truth(20000)
    for place in range(3):
        sizes = [(place + 1) * n / 60 * np.sqrt(RATE) for n in (N_DEG, N_M / writing.G)]
        truth.gyro[place] = rng.normal(0, sizes[0], truth.count)
        truth.accel[place] = (place == 2) + rng.normal(0, sizes[1], truth.count)
    writing.npz(lab.work / "log.npz", truth)
    return lab.work / "log.npz"


@pytest.fixture
def model(lab):
    return lab.file("model.toml", MODEL)


def number(path, name):
    return float(re.search(rf"^{name} = (\S+)", path.read_text(), re.MULTILINE)[1])


def test_fit_of_all_axes_finds_each_in_its_unit_and_writes_a_model_of_each(lab, log, model):
    done = run("fit", log, "-m", model, "--axes", "all", "-o", lab.work / "out.toml")
    assert done.returncode == 0, done.stderr
    head, *rows = done.stdout.splitlines()
    assert head.startswith("axis")
    assert sum("[deg/sqrt(h)]" in row for row in rows) == 3
    assert sum("velocity_random_walk [m/s/sqrt(h)]" in row for row in rows) == 3
    for place, axis in enumerate("xyz"):
        gyro, accel = (lab.work / f"out_{sensor}_{axis}.toml" for sensor in ("gyro", "accel"))
        n_deg = number(gyro, "coefficient_deg_per_sqrt_h")
        n_m = number(accel, "coefficient_m_per_s_per_sqrt_h")
        true = [(place + 1) * N_DEG, (place + 1) * N_M]
        assert [n_deg, n_m] == pytest.approx(true, rel=0.03)
        assert f'column = "accel_{axis}_g"' in accel.read_text()


def test_an_accelerometer_that_is_read_too_often_has_the_numbers_of_a_gyro(lab):
    """deg/s and m/s^2 of the same size differ in their units only, also in the rows of a log that
    are no samples of their own."""
    time, found = np.arange(13000) / 108.0, []
    rate = np.random.default_rng(8).normal(0, 0.1, 13000)[(time * 50).astype(int)]
    for column in ("gyro_x_dps", "accel_x_m_s2"):
        path = lab.work / f"{column}.csv"
        lab_bench.write_csv(path, {"time_s": time, column: rate}, "%.9f")
        one = said("diagnose", path, "--axes", column, statuses=(0, 1))["axes"][column]
        found.append([one[name] for name in ("error", "error_floor", "p_value")])
    assert found[0] == found[1]


def test_diagnose_of_several_names_what_each_lacks(lab, log, model):
    done = run("diagnose", log, "-m", model, "--axes", "gyro_x_dps,accel_z_g")
    assert done.returncode == 0, done.stderr
    rows = [row.split()[:2] for row in done.stdout.splitlines()]
    assert rows.count(["missing", "nothing"]) == 2
    one = said("diagnose", log, "-m", model, "--axes", "gyro_x_dps")["axes"]["gyro_x_dps"]
    alone = said("diagnose", log, "-m", model)
    assert (one["verdict"], one["candidates"]) == (alone["verdict"], alone["candidates"])


def test_compare_and_improve_of_several(lab, log, model):
    found = said("compare", log, "-m", model, "--axes", "gyro", statuses=(1,))["axes"]
    assert {name: one["adequate"] for name, one in found.items()} == dict.fromkeys(GYROS, False)
    out, better = lab.work / "better.toml", lab.work / "better_accel_z.toml"
    done = run("improve", log, "-m", model, "--axes", "gyro_y_dps,accel_z_g", "-o", out)
    assert done.returncode == 0, done.stderr
    assert "error 0.0" in done.stdout
    again = run("compare", log, "-m", better)
    assert again.returncode == 0, again.stderr
    fitted = run("fit", log, "-m", better, "--json").stdout
    for text, word in (
        (again.stdout, "velocity_random_walk"),
        (fitted, '"coefficient_m_per_s_per_sqrt_h"'),
    ):
        assert word in text
        assert "deg" not in text


def test_the_way_to_kalibr_and_back(lab, log, model):
    out, imu = lab.work / "out.toml", lab.work / "imu.yaml"
    assert run("fit", log, "-m", model, "--axes", "all", "-o", out).returncode == 0
    models = lab.work.glob("out_*.toml")
    assert run("export", *models, "--to", "kalibr", "-o", imu).returncode == 0
    for columns, status in (("gyro_z_dps,accel_z_g", 0), ("gyro_x_dps", 1)):  # of the worst axes
        assert run("compare", log, "-m", imu, "--axes", columns).returncode == status


@pytest.mark.parametrize("words", ["gyro_x", "temp_degC", ","])
def test_what_is_no_axis(lab, log, model, words):
    why = "no such axis (there are: gyro_x_dps"
    lab.refused(why, "fit", log, "-m", model, "--axes", words, lines=None)
    report = ("--axes", "all", "--report", lab.work / "r.html")
    lab.refused("--report", "compare", log, "-m", model, *report, lines=None)


def test_a_model_file_is_read_as_it_was_written():
    words = {"column": "x", **dict.fromkeys(("course_hz", "apart_hz"), "0.1 0.2 0.2 0.1")}
    for kind in table.TABLE:
        values = {
            p.name: p.values[0] if p.values else words[p.name] if p.form else max(p.low, 0.25)
            for p in table.find(kind).parameters
            if p.whole is False
        } | {p.name: 3.0 for p in table.find(kind).parameters if p.whole or p.name == "reference"}
        for column in ("accel_x_g", "gyro_x_dps"):
            model = models.Model(1.0, column, [models.Term(kind, values)])
            assert models.of_text(models.text_of(model), "text") == model
