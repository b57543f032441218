"""davarlab export --to FORMAT: numbers that were worked out by hand, read back as the other program
reads them; davarlab sheet: the way back.
"""

import math
import re
import unittest

import yaml
from asking import run
from test_lab import Folder

FORMATS = (
    "kalibr",
    "allan_variance_ros",
    "px4",
    "ardupilot",
    "ros",
    "gtsam",
    "basalt",
    "vins",
    "matlab",
)
N, K = math.radians(0.3 / 60), math.radians(20 / 216000)  # of gyro x; y and z have less
ACCEL_N = 0.06 / 60
RATE = 200.0


class Parameters(Folder):
    def models(self, *columns):
        made = []
        for place, column in enumerate(columns):
            share, gyro = 1 / (1 + place % 3), column.startswith("gyro")
            unit, white = (
                ("deg", "angle_random_walk") if gyro else ("m_per_s", "velocity_random_walk")
            )
            made.append(
                self.file(
                    f"{column}.toml",
                    f'[sensor]\nrate_hz = {RATE}\ncolumn = "{column}"\n[[effect]]\n'
                    f'kind = "{white}"\ncoefficient_{unit}_per_sqrt_h = '
                    f'{(0.3 if gyro else 0.06) * share}\n[[effect]]\nkind = "rate_random_walk"\n'
                    f"coefficient_{unit}_per_h_per_sqrt_h = {20 * share}\n",
                )
            )
        return made

    def exported(self, form, *models, options=()):
        out = self.work / f"out.{form}"
        done = run(
            "export",
            *(
                models
                or self.models(
                    "gyro_x_dps", "gyro_y_dps", "gyro_z_dps", "accel_x_g", "accel_y_g", "accel_z_g"
                )
            ),
            "--to",
            form,
            "-o",
            out,
            *options,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return out.read_text()

    def numbers(self, text, name):
        line = next(
            line
            for line in text.splitlines()
            if name in line and not line.startswith(("#", "//", "%"))
        )
        return [
            float(one)
            for one in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?", line.split(name, 1)[1])
        ]

    def test_kalibr_is_yaml_with_the_worst_axis_in_continuous_time(self):
        found = yaml.safe_load(self.exported("kalibr"))
        self.assertAlmostEqual(found["gyroscope_noise_density"] / N, 1, places=5)
        self.assertAlmostEqual(found["gyroscope_random_walk"] / K, 1, places=5)
        self.assertAlmostEqual(found["accelerometer_noise_density"] / ACCEL_N, 1, places=5)
        self.assertEqual(found["update_rate"], RATE)

    def test_px4_and_ardupilot_add_in_their_own_steps_what_the_density_says(self):
        for form, name, bias, step in (
            ("px4", "EKF2_GYR_NOISE", "EKF2_GYR_B_NOISE", 0.010),
            ("ardupilot", "EK3_GYRO_P_NSE", "EK3_GBIAS_P_NSE", 0.012),
        ):
            with self.subTest(form=form):
                text = self.exported(form)
                for parameter, density in ((name, N), (bias, K)):
                    (value,) = self.numbers(text, parameter)
                    steps = 1000
                    self.assertAlmostEqual(
                        steps * (step * value) ** 2 / (density**2 * steps * step), 1, places=4
                    )

    def test_per_axis_values(self):
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
            with self.subTest(form=form):
                for found, value in zip(
                    self.numbers(self.exported(form), name)[places], values, strict=True
                ):
                    self.assertAlmostEqual(found / value, 1, places=4)

    def test_each_file_says_unit_formula_source_and_why_it_is_not_inflated(self):
        for form in FORMATS:
            with self.subTest(form=form):
                comments = " ".join(
                    line.lstrip("#/% ")
                    for line in self.exported(form).splitlines()
                    if line.startswith(("#", "//", "%"))
                )
                for words in (
                    "Source of the formulas",
                    "as measured",
                    "] = ",
                    "K from rate_random_walk",
                ):
                    self.assertIn(words, comments)

    def test_inflation_is_said_and_squared_where_the_value_is_a_variance(self):
        plain, ten = self.exported("gtsam"), self.exported("gtsam", options=("--inflate", "10"))
        self.assertAlmostEqual(
            self.numbers(ten, "setGyroscopeCovariance")[0]
            / self.numbers(plain, "setGyroscopeCovariance")[0],
            100,
            places=3,
        )
        self.assertIn("10 times the measured ones", ten)

    def test_a_walk_of_the_bias_from_flicker_has_its_allan_deviation_at_the_time_that_is_named(
        self,
    ):
        model = self.file(
            "f.toml",
            f'[sensor]\nrate_hz = {RATE}\ncolumn = "gyro_x_dps"\n[[effect]]\n'
            'kind = "angle_random_walk"\ncoefficient_deg_per_sqrt_h = 0.3\n'
            '[[effect]]\nkind = "bias_instability"\ncoefficient_deg_per_h = 10.0\n',
        )
        text = self.exported("kalibr", model, options=("--bias-time", "100"))
        walk = yaml.safe_load(text)["gyroscope_random_walk"]
        self.assertAlmostEqual(
            walk * math.sqrt(100 / 3) / math.radians(0.664 * 10 / 3600), 1, places=3
        )
        self.assertIn("bias_instability: 0.664 B", text)

    def test_back_from_kalibr_and_from_a_data_sheet(self):
        self.exported("kalibr")
        out = self.work / "back.toml"
        self.assertEqual(
            run(
                "sheet", "--kalibr", self.work / "out.kalibr", "-o", out, "--column", "gyro_x_dps"
            ).returncode,
            0,
        )
        self.assertAlmostEqual(
            float(re.search(r"coefficient_deg_per_sqrt_h = (\S+)", out.read_text())[1]),
            0.3,
            places=5,
        )
        self.assertEqual(
            run("sheet", "0.005deg/s/sqrt(Hz)", "10deg/h", "-o", out, "--rate", "100").returncode, 0
        )
        self.assertAlmostEqual(
            float(re.search(r"coefficient_deg_per_sqrt_h = (\S+)", out.read_text())[1]),
            0.3,
            places=9,
        )
        self.assertIn("coefficient_deg_per_h = 10.0", out.read_text())

    def test_what_cannot_be_exported(self):
        (model,) = self.models("gyro_x_dps")
        odd, bare = (
            self.file("odd.toml", model.read_text().replace("gyro_x_dps", "my_dps")),
            self.file("bare.toml", model.read_text().replace(f"rate_hz = {RATE}", "")),
        )
        quiet = self.file(
            "quiet.toml",
            model.read_text()
            .replace("angle_random_walk", "bias_instability")
            .replace("coefficient_deg_per_sqrt_h", "coefficient_deg_per_h"),
        )
        for arguments, said in (
            ((odd,), "not an axis of a gyro"),
            ((bare,), "no rate_hz"),
            ((quiet,), "no angle_random_walk"),
            ((model, model), "two models of gyro x"),
        ):
            with self.subTest(said=said):
                done = run("export", *arguments, "--to", "px4", "-o", self.work / "no.txt")
                self.assertEqual(
                    (done.returncode, done.stdout, (self.work / "no.txt").exists()), (2, "", False)
                )
                self.assertIn(said, done.stderr)
        for numbers in (("5",), ("5furlongs",), ("1deg/h", "2deg/h"), ("-1deg/h",), ()):
            self.assertEqual(run("sheet", *numbers, "-o", self.work / "no.txt").returncode, 2)


if __name__ == "__main__":
    unittest.main()
