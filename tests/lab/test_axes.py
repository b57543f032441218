"""fit, compare and improve on all axes of a recording in one go, accelerometers in their units."""

import json
import unittest

import numpy as np
import writing_logs as writing
from asking import run
from test_lab import Folder

RATE = 200
N_DEG, N_M = (
    0.3,
    0.12,
)  # deg/sqrt(h), m/s/sqrt(h): what is simulated of the x axes; y has twice, z three times as much
MODEL = f"""[sensor]
rate_hz = {RATE}.0
column = "gyro_x_dps"
[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 1.0
"""


class Axes(Folder):
    def setUp(self):
        super().setUp()
        rng, truth = np.random.default_rng(5), writing.Truth(20000)
        for place in range(3):
            truth.gyro[place] = rng.normal(0, (place + 1) * N_DEG / 60 * np.sqrt(RATE), truth.count)
            truth.accel[place] = (place == 2) + rng.normal(
                0, (place + 1) * N_M / 60 * np.sqrt(RATE) / writing.G, truth.count
            )
        self.log, self.model = self.work / "log.npz", self.file("model.toml", MODEL)
        writing.npz(self.log, truth)

    def test_fit_of_all_axes_finds_each_in_its_unit_and_writes_a_model_of_each(self):
        out = self.work / "out.toml"
        done = run("fit", self.log, "-m", self.model, "--axes", "all", "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        head, *rows = done.stdout.splitlines()
        self.assertTrue(head.startswith("axis"))
        self.assertEqual(sum("[deg/sqrt(h)]" in row for row in rows), 3)
        self.assertEqual(sum("velocity_random_walk [m/s/sqrt(h)]" in row for row in rows), 3)
        for place, axis in enumerate("xyz"):
            gyro, accel = (self.work / f"out_{sensor}_{axis}.toml" for sensor in ("gyro", "accel"))
            self.assertAlmostEqual(
                self.number(gyro, "coefficient_deg_per_sqrt_h") / N_DEG / (place + 1), 1, delta=0.03
            )
            self.assertAlmostEqual(
                self.number(accel, "coefficient_m_per_s_per_sqrt_h") / N_M / (place + 1),
                1,
                delta=0.03,
            )
            self.assertIn(f'column = "accel_{axis}_g"', accel.read_text())

    def test_an_accelerometer_that_is_read_too_often_has_the_numbers_of_a_gyro(self):
        """deg/s and m/s^2 of the same size differ in their units only, also in the rows of a log
        that are no samples of their own."""
        time, found = np.arange(13000) / 108.0, []
        rate = np.random.default_rng(8).normal(0, 0.1, 13000)[(time * 50).astype(int)]
        for column in ("gyro_x_dps", "accel_x_m_s2"):
            log = self.work / f"{column}.csv"
            np.savetxt(
                log,
                np.column_stack([time, rate]),
                "%.9f",
                ",",
                header=f"time_s,{column}",
                comments="",
            )
            done = run("diagnose", log, "--axes", column, "--json")
            self.assertIn(done.returncode, (0, 1), done.stderr)
            found.append(json.loads(done.stdout)["axes"][column])
        for name in ("error", "error_floor", "p_value"):
            self.assertEqual(*(one[name] for one in found))

    def test_diagnose_of_several_names_what_each_lacks(self):
        done = run("diagnose", self.log, "-m", self.model, "--axes", "gyro_x_dps,accel_z_g")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(
            sum(row.split()[:2] == ["missing", "nothing"] for row in done.stdout.splitlines()), 2
        )
        said = json.loads(
            run("diagnose", self.log, "-m", self.model, "--axes", "gyro_x_dps", "--json").stdout
        )["axes"]["gyro_x_dps"]
        alone = json.loads(run("diagnose", self.log, "-m", self.model, "--json").stdout)
        self.assertEqual(
            (said["verdict"], said["candidates"]), (alone["verdict"], alone["candidates"])
        )

    def number(self, path, name):
        return float(
            next(
                line for line in path.read_text().splitlines() if line.startswith(name + " =")
            ).split("=")[1]
        )

    def test_compare_and_improve_of_several(self):
        done = run("compare", self.log, "-m", self.model, "--axes", "gyro", "--json")
        found = json.loads(done.stdout)["axes"]
        self.assertEqual(
            (done.returncode, list(found)), (1, ["gyro_x_dps", "gyro_y_dps", "gyro_z_dps"])
        )
        self.assertEqual([one["adequate"] for one in found.values()], [False] * 3)
        done = run(
            "improve",
            self.log,
            "-m",
            self.model,
            "--axes",
            "gyro_y_dps,accel_z_g",
            "-o",
            self.work / "better.toml",
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("error 0.0", done.stdout)
        again = run("compare", self.log, "-m", self.work / "better_accel_z.toml")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertNotIn("deg", again.stdout)
        self.assertIn("velocity_random_walk", again.stdout)
        said = run("fit", self.log, "-m", self.work / "better_accel_z.toml", "--json").stdout
        self.assertIn('"coefficient_m_per_s_per_sqrt_h"', said)
        self.assertNotIn("deg", said)

    def test_the_way_to_kalibr_and_back(self):
        self.assertEqual(
            run(
                "fit", self.log, "-m", self.model, "--axes", "all", "-o", self.work / "out.toml"
            ).returncode,
            0,
        )
        imu = self.work / "imu.yaml"
        self.assertEqual(
            run("export", *self.work.glob("out_*.toml"), "--to", "kalibr", "-o", imu).returncode, 0
        )
        self.assertEqual(
            run("compare", self.log, "-m", imu, "--axes", "gyro_z_dps,accel_z_g").returncode, 0
        )  # the worst axes are those of the file
        self.assertEqual(run("compare", self.log, "-m", imu, "--axes", "gyro_x_dps").returncode, 1)

    def test_what_is_no_axis(self):
        for words, said in (
            ("gyro_x", "no such axis (there are: gyro_x_dps"),
            ("temp_degC", "no such axis"),
            ("", "no such axis"),
        ):
            done = (
                run("fit", self.log, "-m", self.model, "--axes", words)
                if words
                else run("fit", self.log, "-m", self.model, "--axes", ",")
            )
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn(said, done.stderr)
        done = run(
            "compare", self.log, "-m", self.model, "--axes", "all", "--report", self.work / "r.html"
        )
        self.assertEqual((done.returncode, (self.work / "r.html").exists()), (2, False))


if __name__ == "__main__":
    unittest.main()
