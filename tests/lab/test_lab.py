"""tools/davarlab on recordings with known truth, and on bad input. The statistics in full:
tools/davarlab benchmark.
"""

import csv
import json
import subprocess
import tempfile
import unittest
from pathlib import Path

from asking import ROOT
from asking import typed as run

BASE = """[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 0.3
[[effect]]
kind = "bias_instability"
coefficient_deg_per_h = 5.0
"""
SENSOR = '[sensor]\nrate_hz = 50.0\ncolumn = "gyro_z_dps"\n'
OWN = """from davarlab.effects.base import Effect, Parameter
EFFECT = Effect("square_of_temperature", "The bias bends with temperature.",
                (Parameter("coefficient_dps_per_degC2", "deg/s/degC^2", -1e9, 1e9),),
                "Heat it.", "mean", "slow",
                regressor=lambda recording, shape: (recording.column("temp_degC") - 25) ** 2,
                needs=("temp_degC",))
"""


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)
        self.model = self.file("model.toml", SENSOR + BASE)

    def file(self, name, text):
        (self.work / name).write_text(text)
        return self.work / name

    def simulated(self, effect="", seed=3, seconds=3600, options=()):
        scenario = self.file(
            "scenario.toml",
            f"{SENSOR}[simulate]\nseed = {seed}\nduration_s = {seconds}\n{BASE}{effect}",
        )
        recording = self.work / "rec.csv"
        done = run("simulate", scenario, "-o", recording, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return recording

    def diagnosed(self, recording, *options):
        done = run("diagnose", recording, "-m", self.model, "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)


class Verdict(Folder):
    def test_a_clean_recording_lacks_nothing(self):
        found = self.diagnosed(self.simulated())
        self.assertEqual((found["verdict"], found["missing"]), ("none", []))

    def test_temperature_is_named_and_its_coefficient_covered(self):
        effect = '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.02\n'
        found = self.diagnosed(self.simulated(effect))
        self.assertEqual((found["verdict"], found["missing"]), ("temperature", ["temperature"]))
        estimate = found["candidates"][0]["parameters"]["coefficient_dps_per_degC"]
        self.assertLess(estimate["low"], 0.02)
        self.assertGreater(estimate["high"], 0.02)

    def test_improve_lowers_the_error_and_writes_a_model_that_fits(self):
        effect = '[[effect]]\nkind = "sinusoid"\nfrequency_hz = 0.7\namplitude_dps = 0.02\n'
        recording, better = self.simulated(effect), self.work / "better.toml"
        done = run("improve", recording, "-m", self.model, "-o", better, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        steps = json.loads(done.stdout)["steps"]
        self.assertEqual([step["added"] for step in steps], [None, "sinusoid"])
        self.assertLess(steps[1]["error"], steps[0]["error"])
        self.assertEqual(run("compare", recording, "-m", self.model).returncode, 1)
        self.assertEqual(run("compare", recording, "-m", better).returncode, 0)

    def test_strong_vibration_noise_is_all_that_is_found(self):
        effect = '[[effect]]\nkind = "vibration_noise"\ncoefficient_dps_per_g = 2.0\naxis = "x"\n'
        found = self.diagnosed(self.simulated(effect, seed=6, seconds=7200))
        self.assertEqual(
            (found["verdict"], found["missing"]), ("vibration_noise", ["vibration_noise"])
        )

    def test_noise_with_memory_beside_vibration_noise_is_no_misfit(self):
        effects = (
            '[[effect]]\nkind = "vibration_noise"\ncoefficient_dps_per_g = 0.8\naxis = "y"\n'
            '[[effect]]\nkind = "gauss_markov"\nstd_dps = 0.006\ncorrelation_time_s = 8.0\n'
        )
        found = self.diagnosed(self.simulated(effects, seed=11, seconds=7200))
        self.assertEqual(sorted(found["missing"]), ["gauss_markov", "vibration_noise"])
        self.assertNotEqual(found["verdict"], "unknown")

    def test_levels_beside_flicker_are_telegraph_noise_and_a_continuum_is_not(self):
        levels = (
            '[[effect]]\nkind = "telegraph_noise"\namplitude_dps = 0.0075\nmean_dwell_s = 75.0\n'
        )
        continuum = (
            '[[effect]]\nkind = "gauss_markov"\nstd_dps = 0.0075\ncorrelation_time_s = 37.5\n'
        )
        self.assertEqual(
            self.diagnosed(self.simulated(levels, seconds=7200))["missing"], ["telegraph_noise"]
        )
        self.assertEqual(
            self.diagnosed(self.simulated(continuum, seconds=7200))["missing"], ["gauss_markov"]
        )

    def test_shocks_are_named_though_the_error_stays_where_it_was(self):
        found = self.diagnosed(
            self.simulated(
                '[[effect]]\nkind = "shocks"\nrate_per_hour = 20.0\namplitude_dps = 0.5\n', seed=2
            )
        )
        self.assertEqual((found["verdict"], found["missing"]), ("shocks", ["shocks"]))

    def test_shocks_are_sought_again_beside_a_strong_sensitivity_to_vibration(self):
        effects = (
            '[[effect]]\nkind = "g_sensitivity"\ncoefficient_dps_per_g = 0.9\naxis = "x"\n'
            '[[effect]]\nkind = "shocks"\nrate_per_hour = 30.0\namplitude_dps = 0.6\n'
        )
        found = self.diagnosed(self.simulated(effects, seconds=7200))
        self.assertEqual(sorted(found["missing"]), ["g_sensitivity", "shocks"])

    def test_an_effect_of_ones_own_is_a_full_citizen(self):
        own = self.file("own.py", OWN)
        effect = '[[effect]]\nkind = "square_of_temperature"\ncoefficient_dps_per_degC2 = 0.02\n'
        recording = self.simulated(effect, options=("--effects", own))
        found = self.diagnosed(recording, "--effects", own)
        self.assertEqual(found["verdict"], "square_of_temperature")


class Statistics(Folder):
    """In full: tools/davarlab nulls."""

    def test_true_models_are_rejected_as_often_as_stated(self):
        done = run(
            "nulls",
            "--recordings",
            "120",
            "--seconds",
            "1200",
            "--first-seed",
            "5000",
            "--adequacy-only",
            "--json",
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)
        shares = dict(zip(found["levels"], found["rejected"]["whole model"]))
        print(f"true models rejected: {shares}")
        # binomial, 120 recordings: a miss at either end by chance is below 2 % for other seeds;
        # these are fixed
        self.assertTrue(2 / 120 <= shares[0.05] <= 13 / 120, shares)
        self.assertTrue(24 / 120 <= shares[0.3] <= 50 / 120, shares)

    def test_what_chance_gives_is_measured_for_every_candidate(self):
        done = run("nulls", "--recordings", "2", "--seconds", "600", "--jobs", "1", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)["candidates"]
        self.assertLessEqual(
            {"gauss_markov", "sinusoid", "noise_step", "temperature", "warm_up"}, set(found)
        )


class Files(Folder):
    def test_effects_lists_every_kind_of_the_contract(self):
        kinds = {
            effect["kind"] for effect in json.loads(run("effects", "--json").stdout)["effects"]
        }
        self.assertEqual(
            kinds,
            {
                "quantization",
                "angle_random_walk",
                "bias_instability",
                "rate_random_walk",
                "rate_ramp",
                "gauss_markov",
                "sinusoid",
                "low_pass",
                "temperature",
                "temperature_rate",
                "g_sensitivity",
                "vibration_noise",
                "vibration_rectification",
                "warm_up",
                "telegraph_noise",
                "noise_step",
                "shocks",
                "narrow_band",
                "high_pass",
                "temperature_squared",
                "temperature_hysteresis",
                "temperature_noise",
                "follows",
                "moving_average",
                "intermittent_line",
                "drifting_line",
                "bias_step",
            },
        )

    def test_export_compiles_and_holds_white_noise(self):
        model = self.file("white.toml", SENSOR + BASE.split('[[effect]]\nkind = "bias')[0])
        table = self.work / "table.h"
        self.assertEqual(run("export", model, "-o", table).returncode, 0)
        source = self.file(
            "use.c", '#include "table.h"\nint main(void) { return davar_model_table[0].m != 1; }\n'
        )
        subprocess.run(
            [
                "gcc",
                "-Wall",
                "-Werror",
                f"-I{ROOT / 'lib/include'}",
                source,
                "-o",
                self.work / "use",
            ],
            check=True,
        )
        subprocess.run([self.work / "use"], check=True)
        first = float(table.read_text().split("{ 1U, ")[1].split(",")[0])
        self.assertAlmostEqual(first, 0.3 / 60 * 50**0.5, delta=2e-4 * first)

    def test_export_says_what_it_leaves_out_and_refuses_what_cannot_be(self):
        model = self.file(
            "hot.toml",
            SENSOR + BASE + '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.01\n',
        )
        table = self.work / "table.csv"
        self.assertEqual(run("export", model, "-o", table, "--tolerance", "0.1").returncode, 0)
        self.assertIn("only stationary noise, ramp and lines: temperature", table.read_text())
        self.assertTrue(table.read_text().endswith(",0.1\n"))
        for wrong in (("--tolerance", "1.5"), ("--tolerance", "nan"), ("--window", "3")):
            done = run("export", model, "-o", self.work / "no.csv", *wrong)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn(wrong[0], done.stderr)
            self.assertFalse((self.work / "no.csv").exists())

    def test_plot_and_import_leave_their_files(self):
        recording = self.simulated(seconds=400)
        picture, other = self.work / "p.png", self.work / "o.csv"
        self.assertEqual(run("plot", recording, "-m", self.model, "-o", picture).returncode, 0)
        self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
        log = self.file(
            "log.csv", "t;g\n" + "".join(f"{i * 0.01:.2f};{i % 7}\n" for i in range(1200))
        )
        done = run(
            "import",
            log,
            "-o",
            other,
            "--rename",
            "t=time_s",
            "--rename",
            "g=gyro_x_dps",
            "--scale",
            "gyro_x_dps=0.5",
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(other.read_text().splitlines()[2], "0.01,0.5")


class Monitor(Folder):
    """Back to the device: the misfit that davarlab found is seen by the device's arithmetic, and
    gone with the better model.
    """

    def healths(self, recording, model):
        table = self.work / f"{model.stem}.csv"
        self.assertEqual(run("export", model, "-o", table, "--window", "6000").returncode, 0)
        done = subprocess.run(
            [
                ROOT / "tools/davar-sim",
                recording,
                "--column",
                "gyro_z_dps",
                "--window-max",
                "6000",
                "--policy",
                "fixed",
                "--mode",
                "trailing",
                "--stride",
                "6000",
                "--model-table",
                table,
            ],
            text=True,
            capture_output=True,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.DictReader(done.stdout.splitlines()))
        self.assertEqual(len(rows), 30)
        return [float(row["model_health"]) for row in rows], rows

    def test_a_hidden_effect_is_seen_on_the_device_and_gone_once_it_is_added(self):
        effect = '[[effect]]\nkind = "gauss_markov"\nstd_dps = 0.008\ncorrelation_time_s = 6.0\n'
        recording, better = self.simulated(effect), self.work / "better.toml"
        before, rows = self.healths(recording, self.model)
        self.assertGreater(sum(number > 1 for number in before), 0.9 * len(before))
        self.assertGreater(float(rows[-1]["model_deviation_512"]), 2)
        self.assertEqual(run("improve", recording, "-m", self.model, "-o", better).returncode, 0)
        self.assertIn("gauss_markov", better.read_text())
        after, _ = self.healths(recording, better)
        self.assertLessEqual(sum(number > 1 for number in after), 1)
        self.assertLess(after[-1], 0.7)


class Shortest(Folder):
    def test_the_least_accepted_length_works_in_every_command(self):
        recording, report = self.simulated(seconds=20), self.work / "r.html"
        self.assertEqual(len(recording.read_text().splitlines()) - 1 >= 1000, True)
        for command in (
            ("compare",),
            ("fit",),
            ("diagnose", "--report", report),
            ("improve",),
            ("plot", "-o", self.work / "p.png"),
        ):
            done = run(command[0], recording, "-m", self.model, *command[1:])
            self.assertIn(
                done.returncode,
                (0, 1) if command[0] in ("compare", "improve") else (0,),
                done.stderr,
            )
            self.assertNotIn("Error", done.stderr)


class BadInput(Folder):
    def refused(self, words, *arguments):
        done = run(*arguments)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn(words, done.stderr)

    def recording(self, change):
        rows = [f"{i / 50:.2f},{(i * 7919) % 101 * 0.01:.2f}" for i in range(1500)]
        change(rows)
        return self.file("r.csv", "time_s,gyro_z_dps\n" + "\n".join(rows) + "\n")

    def test_models(self):
        recording = self.recording(lambda rows: None)
        for text, words in (
            ("[sensor\n", "not TOML"),
            (SENSOR + '[[effect]]\nkind = "magic"\n', "unknown kind 'magic'"),
            (SENSOR + BASE + "speed = 3\n", "no parameter speed"),
            (SENSOR + BASE.replace("0.3", "-1"), "outside"),
            (SENSOR.replace("gyro_z", "gyro_q") + BASE, "no column gyro_q_dps"),
            (
                SENSOR + BASE + '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 1\n',
                "temp_degC",
            ),
        ):
            self.refused(words, "compare", recording, "-m", self.file("bad.toml", text))

    def test_recordings(self):
        def put(row, text):
            return lambda rows: rows.__setitem__(row, text)

        for change, words in (
            (put(7, "0.14,nan"), "r.csv:9: column gyro_z_dps"),
            (put(7, "0.14,x"), "r.csv:9: column gyro_z"),
            (put(7, "0.14"), "r.csv:9: 1 fields"),
            (put(700, "0.5,1"), "r.csv:702: column time_s: time runs"),
        ):
            self.refused(words, "compare", self.recording(change), "-m", self.model)
        still = self.file(
            "still.csv",
            "time_s,gyro_z_dps\n"
            + "".join(f"{i / 50:.2f},{(i % 997 == 0) * 0.1}\n" for i in range(3000)),
        )
        done = run("diagnose", still, "-m", self.model)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("still.csv: column gyro_z_dps hardly changes", done.stderr)
        self.refused(
            "no samples", "compare", self.file("e.csv", "time_s,gyro_z_dps\n"), "-m", self.model
        )
        self.refused("none.csv", "compare", self.work / "none.csv", "-m", self.model)

    def test_options(self):
        self.refused("--speed", "effects", "--speed")
        self.refused("unknown kind", "add", self.model, "magic", "-o", self.work / "x.toml")


if __name__ == "__main__":
    unittest.main()
