"""davar-sim --model-table: compares every result with the table of an error model."""

import json
import math
import os
import threading

from sim_case import SMALL_WINDOW, SimCase, as_text, noise_rows

HEAD = "m,tau_s,adev_dps,relative_tolerance"
WHITE = 0.3  # deg/s, of sim_case.noise_rows


def table(scale=1.0, tolerance=0.0, sizes=(1, 2, 4), rate_hz=100.0):
    rows = [f"{m},{m / rate_hz},{scale * WHITE / math.sqrt(m):.9g},{tolerance}" for m in sizes]
    return "\n".join(["# angle_random_walk: of the test", HEAD, *rows]) + "\n"


class ModelTable(SimCase):
    def healths(self, text, *options, **details):
        rows = self.results(
            self.recording(3000, **details),
            *SMALL_WINDOW,
            "--stride",
            "60",
            "--policy",
            "fixed",
            "--model-table",
            self.write("model.csv", text),
            *options,
        )
        return [float(row["model_health"]) for row in rows], rows

    def test_a_true_model_is_healthy_and_a_false_one_is_not(self):
        healthy, rows = self.healths(table())
        self.assertLess(sum(number > 1 for number in healthy), 0.06 * len(healthy))
        self.assertTrue(all(abs(float(row["model_deviation_1"])) < 5 for row in rows))
        self.assertGreater(min(self.healths(table(0.4))[0]), 1)
        self.assertGreater(self.healths(table(0.85))[0][-1], 1)

    def test_columns_follow_the_allan_deviations(self):
        _, rows = self.healths(table(sizes=(4, 1)), "--details")
        names = list(rows[0])
        at = names.index("adev_4") + 1
        self.assertEqual(
            ["model_health", "model_deviation_1", "model_deviation_2", "model_deviation_4"],
            names[at : at + 4],
        )
        self.assertEqual("", rows[0]["model_deviation_2"])
        self.assertNotEqual("", rows[-1]["model_mean_deviation_4"])

    def test_a_deviation_is_that_of_the_design(self):
        _, rows = self.healths(table(1.1, 0.05), "--details")
        for row in rows:
            adev, high = float(row["adev_1"]), float(row["adev_high_1"])
            # of the cube root of chi-square over edf, whose 2.5 % limit is adev^2 / high^2
            root = (math.sqrt(1.96**2 + 4 * (1 - (adev / high) ** (2 / 3))) - 1.96) / 2
            scatter = root**2
            z = ((adev / (1.1 * WHITE)) ** (2 / 3) - 1 + scatter) / math.sqrt(
                scatter + (0.1 / 3) ** 2
            )
            self.assertAlmostEqual(z, float(row["model_deviation_1"]), delta=0.02 + 0.02 * abs(z))

    def test_json_lines_have_the_same(self):
        rec, model = self.recording(), self.write("model.csv", table())
        done = self.sim(
            rec, *SMALL_WINDOW, "--stride", "60", "--out", "jsonl", "--model-table", model
        )
        row = json.loads(done.stdout.splitlines()[0])
        self.assertIn("model_health", row)
        self.assertIsInstance(row["model_deviation_1"], float)

    def test_two_channels_have_a_memory_each(self):
        quiet, loud = noise_rows(3000), noise_rows(3000, seed=2)
        rows = [[a[0], a[1], f"{2 * float(b[1]):.2f}"] for a, b in zip(quiet, loud)]
        rec = self.write("two.csv", as_text("time_s,gyro_x_dps,gyro_y_dps", rows))
        found = self.results(
            rec,
            "--column",
            "gyro_x_dps,gyro_y_dps",
            *SMALL_WINDOW,
            "--policy",
            "fixed",
            "--stride",
            "60",
            "--model-table",
            self.write("model.csv", table()),
        )
        last = {row["channel"]: float(row["model_health"]) for row in found}
        self.assertLess(last["gyro_x_dps"], 1.3)
        self.assertGreater(last["gyro_y_dps"], 2)

    def test_frames_carry_deviations_and_health(self):
        primary, secondary = os.openpty()
        got = []

        def drain():
            try:
                while chunk := os.read(primary, 4096):
                    got.append(chunk)
            except OSError:
                return

        reader = threading.Thread(target=drain, daemon=True)
        reader.start()
        rec, model = self.recording(), self.write("model.csv", table())
        done = self.sim(
            rec,
            *SMALL_WINDOW,
            "--stride",
            "60",
            "--out",
            f"slcan:{os.ttyname(secondary)}",
            "--model-table",
            model,
        )
        self.assertEqual(0, done.returncode, done.stderr)
        os.close(secondary)
        reader.join(5)
        frames = [line for line in b"".join(got).decode().split("\r") if line.startswith("t5D7")]
        self.assertEqual(
            5 * 4, len(frames)
        )  # a result for every 60 of 300 samples, three taus and health
        self.assertEqual(["00", "01", "02", "20"], [frame[9:11] for frame in frames[:4]])


class Refused(SimCase):
    def refuse(self, text, *words):
        path = self.write("model.csv", text)
        self.assert_refused(
            self.sim(self.recording(), *SMALL_WINDOW, "--model-table", path), *words
        )

    def test_bad_tables_are_reported_with_line_and_column(self):
        good = table().splitlines()
        for line, words in (
            ("8,0.08,0,0", ("adev_dps", "above 0")),
            ("8,0.08,-1,0", ("adev_dps",)),
            ("8,0.08,0.1,-0.1", ("relative_tolerance",)),
            ("8,0.08,x,0", ("adev_dps", "not a number")),
            ("8,0.08,nan,0", ("adev_dps", "finite")),
            ("1.5,0.015,0.1,0", ("column m", "1.5")),
            ("0,0,0.1,0", ("column m",)),
            ("-1,0,0.1,0", ("column m",)),
            ("1e10,1e8,0.1,0", ("column m",)),
            ("1,0.01,0.1,0", ("column m", "repeated")),
            ("8,0.08,0.1", ("row too short",)),
            ("8,0.16,0.1,0", ("tau_s", "sample rate")),
        ):
            self.refuse("\n".join([*good, line]) + "\n", "model.csv:6", *words)

    def test_other_files_are_rejected(self):
        self.refuse("m,adev\n1,2\n", "no column adev_dps", "davarlab export")
        self.refuse(HEAD + "\n", "no cluster size")
        self.refuse("", "model.csv")
        self.refuse("\n".join([HEAD, *(f"{m},{m / 100},0.1,0" for m in range(1, 66))]), "too many")
        self.refuse(table(sizes=(3, 5)), "--model-table", "--taus")
        self.assert_refused(
            self.sim(self.recording(), "--model-table", self.folder / "none.csv"), "none.csv"
        )
        self.assert_refused(self.sim(self.recording(), "--model-table", ""), "--model-table")

    def test_a_table_without_tau_s_is_accepted(self):
        path = self.write("model.csv", "m,adev_dps,relative_tolerance\n\n1,0.3,0.1\n")
        self.assertIn(
            "model_health", self.results(self.recording(), *SMALL_WINDOW, "--model-table", path)[0]
        )
