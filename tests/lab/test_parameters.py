"""davarlab export --to FORMAT: numbers that were worked out by hand, read back as the other program
reads them. What export and sheet refuse.
"""

import math
import re
import tomllib

import pytest
import yaml
from asking import run

# What data sheets print for one size: N = 0.6 deg/sqrt(h), B = 9 deg/h, K = 30 deg/h/sqrt(h), and
# N = 0.0588399 m/s/sqrt(h), B = 1.41215760 m/s/h of an accelerometer.
SAME = {
    ("gyro_z_dps", "angle_random_walk", 0.6): (
        *("0.6deg/sqrt(h)", "0.6deg/sqrt(hr)", "0.6 °/√h", "0.6°/√hr", "0.6 deg/√hour"),
        *(
            "0.6 deg/rt-hr",
            "0.6 deg/rthr",
            "0.6deg/rt hr",
            "0.6º/√h",
            "0.6 ˚/√hr, 1σ",
            ".6deg/√(hr)",
        ),
        *(
            "0.6 degrees per root hour",
            "0.6 deg/h^0.5",
            "0.6 deg/hr^(1/2)",
            "0.6 °/h½",
            "6e-1deg/√ h",
        ),
        *("0.6 DEG/SQRT(HR)", "0.6 Deg/√Hour", "0.6 deg/square root hour", "600 mdeg/√h"),
        *("0.01 dps/sqrt(Hz)", "0.01dps/√Hz", "0.01 DPS/RTHZ", "10mdps/√Hz", "10 mdps/rtHz"),
        *("10 mdps/√Hz rms", "0.01(°/s)/√Hz", "0.01 °/sec/√Hz rms", "0.01°/s/√Hz (rms)"),
        *("0.01 deg/sec-rms/√hz", "10 m°/s/√Hz", "1e4 udps/√Hz", "1e4 µdps/√Hz", "1e4 μ°/s/√Hz"),
        *("0.01 deg·s⁻¹·Hz^-½", "0.01 deg s^-1 Hz^-0.5", "0.01 deg/(s·√Hz)", "36 deg/h/√Hz"),
        *("36 (°/hr)/√Hz", "36 degrees/hour/root-Hz", "36 °/hour/rt-hertz", "10 MDPS/√HZ"),
    ),
    ("gyro_z_dps", "bias_instability", 9.0): (
        *(
            "9deg/h",
            "9 °/hr",
            "9 deg/hour",
            "9°/h rms",
            "9 degrees per hour",
            "9 DEG/HR",
            "9 °/h typ.",
        ),
        *(
            "0.0025 dps",
            "0.0025°/s",
            "2.5 mdps",
            "0.0025 deg/second",
            "9 deg·h⁻¹",
            "9 °/hr (1 sigma)",
        ),
    ),
    ("gyro_z_dps", "rate_random_walk", 30.0): (
        *("30deg/h/sqrt(h)", "30 °/hr/√hr", "30 (deg/hr)/rt-hr", "30 deg/h^1.5", "30 °/hr^3/2"),
        *("30 deg/hour/√hour", "0.5 deg/h/√s"),
    ),
    ("accel_x_g", "velocity_random_walk", 0.0588399): (
        *(
            "100ug/sqrt(Hz)",
            "100 µg/√Hz",
            "100 μg/rtHz",
            "100 µg/√Hz rms",
            "0.1mg/√Hz",
            "0.1 mg/rt-Hz",
        ),
        *(
            "1e-4 g/√Hz",
            "100 uG/√Hz",
            "0.0588399 m/s/√h",
            "0.0588399 m/s/√hr",
            "0.0588399 (m/s)/rt-hr",
        ),
        *("9.80665e-4 m/s²/√Hz", "9.80665e-4 m/s^2/sqrt(Hz)", "9.80665e-4 (m/s2)/√Hz"),
    ),
    ("accel_x_g", "bias_instability", 1.4121576): ("40ug", "40 µg", "0.04 mg", "3.92266e-4 m/s^2"),
}
NO_UNIT = {
    "5": "a number with its unit expected. Examples: 0.3deg/sqrt(h)",
    "5furlongs": "unknown unit 'furlongs'",
    "5 deg": "'deg' is not a unit of a random walk or a bias instability",
    "5 deg/√hr/√Hz": "is not a unit of",
    "5 dps·√Hz": "is not a unit of",
    "5 deg/s·√Hz": "'*√Hz' follows a complete unit",
    "5 Mdps/√Hz": "the M of Mdps is mega. Type mdps",
    "5 ms/√Hz": "unknown unit 'ms'",
    "5 (deg/s/√Hz": "a ) is missing",
    "5 deg/": "a unit expected, found ''",
    "5 µg/√Hz": "a unit of an accelerometer, but the column is gyro_z_dps. Type --column accel_z_g",
    "-1deg/h": "-1deg/h",
    "1.2.3deg/h": "a number expected, found '1.2.3'",
}

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
    for words in (("1deg/h", "2deg/h"), ()):
        assert run("sheet", *words, "-o", lab.work / "no.txt").returncode == 2


@pytest.mark.parametrize("column, kind, size", SAME)
def test_units_as_data_sheets_print_them(lab, column, kind, size):
    for spelled in SAME[column, kind, size]:
        for words in ([spelled], spelled.split(" ")):
            done = run(
                "sheet", *words, "--column", column, "--rate", "100", "-o", lab.work / "s.toml"
            )
            assert (done.returncode, done.stderr) == (0, ""), (spelled, done.stderr)
            (found,) = tomllib.loads((lab.work / "s.toml").read_text())["effect"]
            assert found.pop("kind") == kind, spelled
            assert [*found.values()] == pytest.approx([size], rel=1e-12), spelled


@pytest.mark.parametrize("spelled", NO_UNIT)
def test_what_is_no_unit_of_a_data_sheet(lab, spelled):
    lab.refused(NO_UNIT[spelled], "sheet", spelled, "-o", lab.work / "no.txt", lines=None)


@pytest.mark.parametrize("words", ["--to kalibr", "--to plan", ""])
def test_a_data_sheet_without_a_rate_names_it(lab, words):
    sheet, out = lab.work / "s.toml", lab.work / "out.h"
    numbers = ("sheet", "0.6deg/√h", "9deg/h", "-o", sheet)
    wants = f"davarlab: {sheet}: no sample rate, which export needs. Give it with --rate HZ\n"
    assert run(*numbers).stderr == wants
    lab.refused("or give --rate HZ to davarlab sheet", "export", sheet, *words.split(), "-o", out)
    assert run(*numbers, "--rate", "100").stderr == ""
    assert run("export", sheet, *words.split(), "-o", out).returncode == 0
