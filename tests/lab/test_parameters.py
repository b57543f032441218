"""davarlab export --to FORMAT: numbers that were worked out by hand, read back as the other program
reads them. What export and sheet refuse.
"""

import math
import re

import pytest
import yaml
from asking import run

N, K = math.radians(0.3 / 60), math.radians(20 / 216000)  # of gyro x; y and z have less
ACCEL_N = 0.06 / 60
RATE = 200.0


def models(lab, *columns):
    made = []
    for place, column in enumerate(columns):
        share, gyro = 1 / (1 + place % 3), column.startswith("gyro")
        unit, white = ("deg", "angle_random_walk") if gyro else ("m_per_s", "velocity_random_walk")
        text = (
            f'[sensor]\nrate_hz = {RATE}\ncolumn = "{column}"\n[[effect]]\nkind = "{white}"\n'
            f"coefficient_{unit}_per_sqrt_h = {(0.3 if gyro else 0.06) * share}\n"
            '[[effect]]\nkind = "rate_random_walk"\n'
            f"coefficient_{unit}_per_h_per_sqrt_h = {20 * share}\n"
        )
        made.append(lab.file(f"{column}.toml", text))
    return made


AXES = [f"gyro_{axis}_dps" for axis in "xyz"] + [f"accel_{axis}_g" for axis in "xyz"]


def exported(lab, form, *given, options=()):
    """The text of an export of these models, or of those of all axes."""
    out = lab.work / f"out.{form}"
    done = run("export", *(given or models(lab, *AXES)), "--to", form, "-o", out, *options)
    assert done.returncode == 0, done.stderr
    return out.read_text()


def numbers(text, name):
    lines = (line for line in text.splitlines() if not line.startswith(("#", "//", "%")))
    line = next(line for line in lines if name in line).split(name, 1)[1]
    found = re.findall(r"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?", line)
    return [float(one) for one in found]


def test_kalibr_is_yaml_with_the_worst_axis_in_continuous_time(lab):
    found = yaml.safe_load(exported(lab, "kalibr"))
    exact = {
        "gyroscope_noise_density": N,
        "gyroscope_random_walk": K,
        "accelerometer_noise_density": ACCEL_N,
        "update_rate": RATE,
    }
    assert {name: found[name] for name in exact} == pytest.approx(exact, rel=5e-6)


PER_AXIS, WORST = [N, N / 2, N / 3], slice(1)
FORMS = [  # format, name, values, which of its numbers
    # what is added in its own steps is what the density says
    ("px4", "EKF2_GYR_NOISE", [N / math.sqrt(0.010)], WORST),
    ("px4", "EKF2_GYR_B_NOISE", [K / math.sqrt(0.010)], WORST),
    ("ardupilot", "EK3_GYRO_P_NSE", [N / math.sqrt(0.012)], WORST),
    ("ardupilot", "EK3_GBIAS_P_NSE", [K / math.sqrt(0.012)], WORST),
    ("ros", "angular_velocity_covariance", [n**2 * RATE for n in PER_AXIS], slice(0, 9, 4)),
    ("gtsam", "setGyroscopeCovariance", [n**2 for n in PER_AXIS], slice(3)),
    ("basalt", '"gyro_noise_std"', PER_AXIS, slice(3)),
    ("matlab", "'NoiseDensity'", PER_AXIS, slice(3)),
    ("vins", "gyr_n", [N * math.sqrt(RATE)], WORST),
]


@pytest.mark.parametrize("form, name, values, places", FORMS)
def test_a_format_has_the_numbers_of_its_program(lab, form, name, values, places):
    assert numbers(exported(lab, form), name)[places] == pytest.approx(values, rel=2.5e-5)


def test_inflation_is_said_and_squared_where_the_value_is_a_variance(lab):
    ten = exported(lab, "gtsam", options=("--inflate", "10"))
    found = numbers(ten, "setGyroscopeCovariance")[:3]
    assert found == pytest.approx([100 * n**2 for n in PER_AXIS], rel=5e-5)
    assert "10 times the measured ones" in ten


def test_a_walk_of_the_bias_from_flicker_has_its_allan_deviation_at_the_time_that_is_named(lab):
    model = lab.file(
        "f.toml",
        f'[sensor]\nrate_hz = {RATE}\ncolumn = "gyro_x_dps"\n[[effect]]\n'
        'kind = "angle_random_walk"\ncoefficient_deg_per_sqrt_h = 0.3\n'
        '[[effect]]\nkind = "bias_instability"\ncoefficient_deg_per_h = 10.0\n',
    )
    text = exported(lab, "kalibr", model, options=("--bias-time", "100"))
    walk = yaml.safe_load(text)["gyroscope_random_walk"]
    assert abs(walk * math.sqrt(100 / 3) / math.radians(0.664 * 10 / 3600) - 1) < 5e-4
    assert "bias_instability: 0.664 B" in text


def test_what_cannot_be_exported(lab):
    (model,) = models(lab, "gyro_x_dps")
    text, flicker = model.read_text(), ("bias_instability", "coefficient_deg_per_h")
    quiet = text.replace("angle_random_walk", flicker[0])
    quiet = quiet.replace("coefficient_deg_per_sqrt_h", flicker[1])
    for given, why in (
        ([lab.file("odd.toml", text.replace("gyro_x_dps", "my_dps"))], "not an axis of a gyro"),
        ([lab.file("bare.toml", text.replace(f"rate_hz = {RATE}", ""))], "no rate_hz"),
        ([lab.file("quiet.toml", quiet)], "no angle_random_walk"),
        ([model, model], "two models of gyro x"),
    ):
        lab.refused(why, "export", *given, "--to", "px4", "-o", lab.work / "no.txt", lines=None)
    for words in (("5",), ("5furlongs",), ("1deg/h", "2deg/h"), ("-1deg/h",), ()):
        assert run("sheet", *words, "-o", lab.work / "no.txt").returncode == 2
