"""davarlab export --to FORMAT: numbers that were worked out by hand, read back as the other program
reads them. What export and sheet refuse.
"""

import math
import re

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
        made.append(
            lab.file(
                f"{column}.toml",
                f'[sensor]\nrate_hz = {RATE}\ncolumn = "{column}"\n[[effect]]\n'
                f'kind = "{white}"\ncoefficient_{unit}_per_sqrt_h = '
                f'{(0.3 if gyro else 0.06) * share}\n[[effect]]\nkind = "rate_random_walk"\n'
                f"coefficient_{unit}_per_h_per_sqrt_h = {20 * share}\n",
            )
        )
    return made


AXES = [f"gyro_{axis}_dps" for axis in "xyz"] + [f"accel_{axis}_g" for axis in "xyz"]


def exported(lab, form, *given, options=()):
    """The text of an export of these models, or of those of all axes."""
    out = lab.work / f"out.{form}"
    done = run("export", *(given or models(lab, *AXES)), "--to", form, "-o", out, *options)
    assert done.returncode == 0, done.stderr
    return out.read_text()


def numbers(text, name):
    line = next(
        line for line in text.splitlines() if name in line and not line.startswith(("#", "//", "%"))
    )
    return [
        float(one)
        for one in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?", line.split(name, 1)[1])
    ]


def test_kalibr_is_yaml_with_the_worst_axis_in_continuous_time(lab):
    found = yaml.safe_load(exported(lab, "kalibr"))
    assert abs(found["gyroscope_noise_density"] / N - 1) < 5e-6
    assert abs(found["gyroscope_random_walk"] / K - 1) < 5e-6
    assert abs(found["accelerometer_noise_density"] / ACCEL_N - 1) < 5e-6
    assert found["update_rate"] == RATE


def test_px4_and_ardupilot_add_in_their_own_steps_what_the_density_says(lab):
    for form, name, bias, step in (
        ("px4", "EKF2_GYR_NOISE", "EKF2_GYR_B_NOISE", 0.010),
        ("ardupilot", "EK3_GYRO_P_NSE", "EK3_GBIAS_P_NSE", 0.012),
    ):
        text = exported(lab, form)
        for parameter, density in ((name, N), (bias, K)):
            (value,) = numbers(text, parameter)
            steps = 1000
            assert abs(steps * (step * value) ** 2 / (density**2 * steps * step) - 1) < 5e-5


def test_per_axis_values(lab):
    axes = [N, N / 2, N / 3]
    checks = (
        (
            "ros",
            "angular_velocity_covariance",
            [value**2 * RATE for value in axes],
            slice(0, 9, 4),
        ),
        ("gtsam", "setGyroscopeCovariance", [value**2 for value in axes], slice(3)),
        ("basalt", '"gyro_noise_std"', axes, slice(3)),
        ("matlab", "'NoiseDensity'", axes, slice(3)),
        ("vins", "gyr_n", [N * math.sqrt(RATE)], slice(1)),
    )
    for form, name, values, places in checks:
        for found, value in zip(numbers(exported(lab, form), name)[places], values, strict=True):
            assert abs(found / value - 1) < 5e-5


def test_inflation_is_said_and_squared_where_the_value_is_a_variance(lab):
    plain, ten = exported(lab, "gtsam"), exported(lab, "gtsam", options=("--inflate", "10"))
    assert (
        abs(
            (
                numbers(ten, "setGyroscopeCovariance")[0]
                / numbers(plain, "setGyroscopeCovariance")[0]
            )
            - 100
        )
        < 5e-4
    )
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
