"""tools/davar-plan from wishes: what it remarks, why a plan is impossible and what would help, and
bad input is one line.
"""

import json
import re
import subprocess
import sys
import unittest
from dataclasses import replace

from planner_case import EXAMPLE, KEYS, ROOT, WISHES, Planned, command

sys.path.insert(0, str(ROOT / "tools/plan"))
from planner import BadOption, choice, costs, plan, report, sensors, wishes


class Remarks(Planned):
    """Wishes with another effect than expected are stated under "check"."""

    def not_fitted(self, found):
        return [one for one in found["remarks"] if "random walk are not fitted" in one]

    def limited(self, wishes, limits):
        return " ".join(
            [wishes, "--core cortex-m4f", *(w for pair in limits.items() for w in pair)]
        )

    def test_a_longer_response_than_any_window_gives_the_longest_window(self):
        for type, rate, most in (("int16", 1000, 65536), ("int32", 100, 2**24)):
            with self.subTest(type=type):
                words = f"--rate {rate} --type {type} --lsb 0.06 --bandwidth none --respond 1e6"
                found = self.planned(f"{words} --core cortex-m4f")
                self.assertEqual("fixed", found["law"])
                self.assertLessEqual(most - 8, found["window_s"] * rate)
                self.assertLessEqual(found["window_s"] * rate, most)
                (remark,) = found["remarks"]
                self.assertIn(f"the longest window of {type} has {most} samples", remark)

    def test_a_response_whose_window_does_not_fit_gets_a_shorter_one(self):
        words = "--rate 1000 --lsb 0.06 --bandwidth 250 --respond 120 --core cortex-m4f --ram 4k"
        found = self.planned(words)
        self.assertEqual("fixed", found["law"])
        self.assertLessEqual(found["arw_percent"], 10)
        self.assertIn("a longer window exceeds --ram or --flash", found["remarks"][0])

    def test_a_fit_that_the_limits_exclude_names_the_limits_that_it_needs(self):
        example = EXAMPLE.split(" --ram")[0]
        small = "--rate 1000 --lsb 0.061 --bandwidth 250 --respond 0.8 --axes 2 --longest-tau 50"
        for stated, limits in (
            (example, {"--flash": "24k"}),
            (example, {"--ram": "14k", "--flash": "24k"}),
            (small, {"--ram": "9k"}),
        ):
            with self.subTest(wishes=stated, limits=limits):
                found = self.planned(self.limited(stated, limits))
                self.assertEqual("curve", found["fit"])
                (remark,) = self.not_fitted(found)
                needed = dict(re.findall(r"(--\w+) (\S+)", remark))
                again = self.planned(self.limited(stated, limits | needed))
                self.assertEqual(("terms", []), (again["fit"], self.not_fitted(again)))

    def test_an_averaging_time_of_the_window_adds_no_curve(self):
        words = "--rate 100 --lsb 0.05 --bandwidth none --core cortex-m0 --longest-tau 0.1"
        found = self.planned(words)
        self.assertIn("--longest-tau 0.1 adds nothing", found["remarks"][0])
        self.assertGreaterEqual(max(found["taus_s"]), 0.1)
        self.assertNotIn("davar_setup_curve(", (self.work / "setup/davar_setup.h").read_text())

    def test_a_core_that_is_too_slow_for_single_samples_gets_the_size_of_a_block(self):
        words = "--rate 8000 --axes 3 --lsb 0.06 --bandwidth 2000 --core cortex-m0"
        free = self.planned(words)
        self.assertIn("not every chip has", free["remarks"][0])
        self.assertIn(f" {free['worst_mhz']:.3g} MHz", command(words.split()).stdout)
        for clock in (1.1 * free["mean_mhz"], 0.95 * free["worst_mhz"]):
            with self.subTest(clock=clock):
                found = self.planned(f"{words} --clock {clock}")
                (remark,) = found["remarks"]
                block = int(re.search(r"at least (\d+) samples", remark)[1])
                mean, worst = found["mean_instructions"], found["worst_push_instructions"]
                keeps_up = [
                    worst + (n - 1) * mean < n * clock * 1e6 / 8000 for n in (block - 1, block)
                ]
                self.assertEqual([False, True], keeps_up)
        self.assertEqual([], self.planned(f"{words} --clock {1.01 * free['worst_mhz']}")["remarks"])


class Impossible(Planned):
    CASES = (
        EXAMPLE.replace("20k", "12k"),
        EXAMPLE.replace("24k", "16k"),
        EXAMPLE.replace("20k", "4k").replace("24k", "8k"),
        "--rate 100 --lsb 0.05 --bandwidth 33 --respond 0.01 --core cortex-m0",
        "--rate 100 --lsb 0.05 --bandwidth 33 --respond 3 --arw-percent 2 --ram 6k "
        "--core cortex-m0",
        "--rate 1000 --lsb 0.05 --bandwidth 250 --longest-tau 1e9 --core cortex-m0",
        "--rate 32000 --lsb 0.06 --respond 10 --longest-tau 1e6 --core cortex-m4f",
        "--rate 1000 --lsb 0.06 --arw-percent 0.1 --core cortex-m4f",
        "--rate 1000 --lsb 0.06 --arw-percent 0.5 --bandwidth none --core cortex-m4f",
        "--rate 100 --lsb 0.06 --respond 20 --arw-percent 1 --bandwidth none --core cortex-m4f",
        EXAMPLE.replace("20k", "1k").replace("24k", "4k"),
        "--rate 100 --lsb 0.05 --bandwidth 33 --arw-percent 0.5 --core cortex-m4f",
        "--sensor mpu6050@800 --arw-percent 0.5 --ram 3k --flash 18k --core cortex-m3",
        "--sensor bmi160@200 --respond 0.5 --arw-percent 20 --false-alarms-per-hour 0.003 "
        "--flash 20k --core cortex-m0",
        "--rate 8000 --axes 3 --lsb 0.06 --bandwidth 2000 --core cortex-m0 --clock 1.5",
        "--rate 8000 --axes 3 --lsb 0.06 --bandwidth 2000 --core cortex-m0 --clock 6",
        "--rate 1000 --lsb 0.06 --bandwidth 250 --respond 120 --ram 2k --core cortex-m4f",
    )

    def refused(self, words):
        """The object of --json for wishes that are impossible."""
        done = command([*words.split(), "--json"])
        self.assertEqual((1, ""), (done.returncode, done.stderr))
        return json.loads(done.stdout)

    def test_the_reason_has_numbers_and_what_it_suggests_is_possible(self):
        for words in self.CASES:
            with self.subTest(wishes=words):
                done = command([*words.split(), "-o", str(self.work / "none")])
                self.assertEqual((1, ""), (done.returncode, done.stdout))
                self.assertRegex(done.stderr, r"^davar-plan: impossible: .*[0-9]")
                self.assertFalse((self.work / "none").exists())
                self.assertNotIn("--longest-tau 0:", done.stderr)
                found = self.refused(words)
                relaxed = {one["option"]: one["value"] for one in found["relax"]}
                self.assertTrue(relaxed)
                for option, value in relaxed.items():
                    self.assertIn(f"  {option} {value}\n", done.stderr)
                given = dict(zip(words.split()[::2], words.split()[1::2]))
                ways = [relaxed] if found["together"] else [{o: v} for o, v in relaxed.items()]
                for way in ways:
                    again = command([word for pair in (given | way).items() for word in pair])
                    self.assertEqual((0, ""), (again.returncode, again.stderr), way)

    def test_the_reason_is_the_option_that_is_out_of_reach(self):
        for words, option, reason in (
            (self.CASES[6], "--longest-tau", "--longest-tau 1000000: 3.2e+10 samples at 32000 Hz"),
            (self.CASES[7], "--arw-percent", "ARW to 0.1 %: the longest window gives"),
            (self.CASES[8], "--arw-percent", "ARW to 0.5 %: the longest window gives"),
        ):
            with self.subTest(wishes=words):
                found = self.refused(words)
                self.assertIn(reason, found["impossible"])
                self.assertEqual([option], [one["option"] for one in found["relax"]])

    def test_the_precision_that_it_suggests_is_the_best_of_all_laws(self):
        relaxed = {one["option"]: one["value"] for one in self.refused(self.CASES[9])["relax"]}
        best = float(relaxed["--arw-percent"])
        words = self.CASES[9].replace("--arw-percent 1", "--arw-percent {:.2f}")
        self.assertEqual(0, command(words.format(best).split()).returncode)
        self.assertEqual(1, command(words.format(0.95 * best).split()).returncode)

    def test_two_limits_that_are_both_too_small_are_two_reasons_and_two_values(self):
        found = self.refused(self.CASES[10])
        self.assertEqual(
            ["--ram", "--flash"], [one["option"] for one in found["relax"]], found["relax"]
        )
        self.assertTrue(found["together"])
        done = command(self.CASES[10].split())
        self.assertRegex(done.stderr, r"impossible: RAM 1k: .*\n  and flash 4k: ")
        self.assertIn("possible with all of:\n", done.stderr)

    def test_a_hint_is_not_a_reason(self):
        done = command(self.CASES[7].split())
        self.assertNotIn("\n  and ", done.stderr)
        self.assertIn("--bandwidth", self.refused(self.CASES[7])["hints"][0])
        self.assertEqual([], self.refused(self.CASES[8])["hints"])

    def test_a_core_that_cannot_keep_up_is_refused_with_both_figures(self):
        words = self.CASES[15]
        reason = self.refused(words)["impossible"]
        clock, needed = map(float, re.search(r"clock (\S+) MHz: \D+(\S+) million", reason).groups())
        free = json.loads(command([*words.split()[:-2], "--json"]).stdout)
        self.assertEqual(6, clock)
        self.assertLess(clock, needed)
        self.assertLessEqual(needed, 1.005 * 8000 * free["mean_instructions"] / 1e6)
        self.assertIn("davar/average.h", command(words.split()).stderr)

    def test_no_plan_fills_the_clock_with_pushes(self):
        words = "--rate 1000 --lsb 0.06 --bandwidth 250 --core cortex-m4f"
        read = wishes.read(words.split(), costs.cores()).wishes
        mean = choice.plan(read).mean_mhz
        other = choice.plan(replace(read, clock_mhz=mean))
        self.assertLess(other.mean_mhz, mean)
        self.assertGreater(len(report.remarks(other)), 0)

    def test_a_limit_just_below_the_need_is_shown_with_digits_that_differ(self):
        words = "--rate 1000 --lsb 0.06 --bandwidth 250 --core cortex-m4f"
        found = json.loads(command([*words.split(), "--arw-percent", "9.4", "--json"]).stdout)
        best = json.loads(command([*words.split(), "--arw-percent", "0.5", "--json"]).stdout)
        best = float(re.search(r"gives (\S+) %", best["impossible"])[1])
        for more in (
            f"--arw-percent {0.9999 * best}",
            f"--arw-percent 9.4 --ram {found['ram_bytes'] - 1}",
            f"--arw-percent 9.4 --flash {found['flash_bytes'] - 1}",
        ):
            with self.subTest(wishes=more):
                reason = self.refused(f"{words} {more}")["impossible"]
                wish, *_, need = map(float, re.findall(r"[0-9.]+", reason))
                self.assertLess(wish, need, reason)

    def test_two_numbers_have_as_many_digits_as_it_takes_to_differ(self):
        for one, other, texts in (
            (1.8, 1.81, ("1.8", "1.81")),
            (1.8, 1.80002, ("1.8", "1.80002")),
            (1000, 1000.4, ("1000", "1000.4")),
            (1e6, 2e6, ("1000000", "2000000")),
            (0.0012344, 0.0012341, ("0.0012344", "0.0012341")),
        ):
            self.assertEqual(texts, choice.apart(one, other))

    def test_an_averaging_time_that_adds_nothing_is_not_suggested(self):
        found = self.refused(self.CASES[1])
        self.assertEqual(["--flash"], [one["option"] for one in found["relax"]])
        self.assertEqual(["it is possible without --longest-tau"], found["hints"])

    def test_noise_below_a_count_is_no_plan(self):
        words = "--rate 100 --lsb 3 --noise 1 --core cortex-m0"
        done = command(words.split())
        self.assertEqual(1, done.returncode)
        self.assertIn("rounding hides it", done.stderr)
        self.assertIn("a smaller range of the gyro", done.stderr)


class BadInput(Planned):
    def test_a_bad_option_is_one_line_and_nothing_is_written(self):
        good = "--rate 100 --lsb 0.05 --core cortex-m0"
        for words in (
            "",
            "--rate 100",
            "--rate 100 --core cortex-m0",
            "--lsb 0.1 --core cortex-m0",
            "--rate 100 --lsb 0.05 --core z80",
            "--rate 100 --lsb 0.05 --core",
            "--rate 100 --lsb 0.05 --type float --core cortex-m0",
            "--rate 1.2.3 --lsb 0.05 --core cortex-m0",
            "--sensor icm42688@1000 --rate 500 --core cortex-m0",
            *(
                f"{good} {words}"
                for words in (
                    "--rate 50",
                    "--axes 0",
                    "--axes 17",
                    "--axes 1.5",
                    "--axes -1",
                    "--ram",
                    "--ram 1g",
                    "--ram 0",
                    "--ram -5k",
                    "--flash k",
                    "--bandwidth 20:3",
                    "--bandwidth 9000",
                    "--bandwidth auto",
                    "--bandwidth .",
                    "--bandwidth -",
                    "--bandwidth 1.2.3",
                    "--bandwidth 20:2:60",
                    "--respond 0",
                    "--respond nan",
                    "--respond inf",
                    "--respond 1s",
                    "--respond 1.2.3",
                    "--respond .",
                    "--false-alarms-per-hour 1e10",
                    "--false-alarms-per-hour 1e-11",
                    "--bandwidth --taus",
                    "--taus 1,2",
                    "--taus=1,2",
                    "--name a",
                    "--arw-percent 90",
                    "--longest-tau 0.001",
                    "--type int8",
                    "--sensor nothing@100",
                    "--sensor icm42688",
                    "--sensor icm42688@1",
                    "--unknown 1",
                    "words",
                    "--json=1",
                    "--full-scale 500",
                    "--type int32 --full-scale 500",
                    "--type float --full-scale 500",
                    "--clock 0",
                    "--clock 48MHz",
                )
            ),
        ):
            with self.subTest(words=words):
                done = command([*words.split(), "-o", str(self.work / "none")])
                self.assertEqual(
                    (2, "", 1), (done.returncode, done.stdout, done.stderr.count("\n")), done.stderr
                )
                self.assertRegex(done.stderr, r"^davar-plan: \S+: ")
                self.assertNotIn("could not convert", done.stderr)
                self.assertFalse((self.work / "none").exists())

    def test_an_empty_folder_is_one_line(self):
        for words in (["-o", ""], ["-o="]):
            done = subprocess.run(
                [ROOT / "tools/davar-plan", *WISHES[3].split(), *words],
                text=True,
                capture_output=True,
                check=False,
                cwd=self.work,
            )
            self.assertEqual((2, ""), (done.returncode, done.stdout))
            self.assertEqual("davar-plan: -o: expected a folder, found ''\n", done.stderr)
            self.assertEqual([], list(self.work.iterdir()))

    def test_a_number_that_is_refused_states_its_unit(self):
        for option, unit in (("--rate", "Hz"), ("--respond", "seconds"), ("--clock", "MHz")):
            done = command([option, "1x", "--lsb", "0.05", "--core", "cortex-m0"])
            self.assertIn(f"{option}: expected a number of {unit} above 0, found '1x'", done.stderr)

    def test_a_folder_that_cannot_be_written_is_one_line(self):
        (self.work / "file").write_text("")
        done = command([*WISHES[3].split(), "-o", str(self.work / "file")])
        self.assertEqual((2, 1), (done.returncode, done.stderr.count("\n")))
        self.assertIn("-o", done.stderr)

    def test_help_names_every_option_core_and_sensor(self):
        done = command(["--help"])
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        source = (ROOT / "tools/plan/planner/wishes.py").read_text()
        for word in (*re.findall(r'"(--[a-z-]+)":', source), *costs.cores(), *sensors.PARTS):
            self.assertIn(word, done.stdout)

    def test_help_and_page_state_how_a_noise_density_becomes_the_option_noise(self):
        # one-sided density S: the variance of the angle after t is S^2 t / 2
        factor = 60 / 2**0.5
        for text in (command(["--help"]).stdout, (ROOT / "docs/PLANNER.md").read_text()):
            self.assertIn(f"N = 60 D / sqrt(2) = {factor:.1f} D", text)
        part = sensors.PARTS["icm42688"]
        found = sensors.look_up("icm42688", 1000.0)
        self.assertAlmostEqual(factor * part["noise_dps_per_root_hz"], found["noise"])


class Readme(unittest.TestCase):
    def test_the_report_of_the_readme_is_what_its_command_prints(self):
        page = (ROOT / "README.md").read_text(encoding="utf-8")
        words = re.search(r"^tools/davar-plan (.*) -o \S+$", page, re.MULTILINE)[1].split()
        shown = re.search(r"```text\n(.*?)```", page, re.DOTALL)[1].splitlines()
        printed = command(words).stdout.splitlines()
        self.assertEqual(printed[:-1], shown[:-1])
        self.assertEqual("  wrote  ", shown[-1][:9])


class Engine(unittest.TestCase):
    def test_one_function_gives_the_plan(self):
        found = plan(rate_hz=100.0, core="cortex-m0", lsb=0.05, bandwidth="33:2")
        self.assertEqual([], [key for key in KEYS if key not in found])
        with self.assertRaises(BadOption):
            plan(rate_hz=100.0, core="cortex-m0")

    def test_a_number_has_all_its_forms(self):
        taus = [
            plan(rate_hz=1000.0, core="cortex-m0", lsb=0.05, bandwidth=hz)["taus_s"]
            for hz in ("200:2", "2E2:2", "200.:2", "2e+2")
        ]
        self.assertEqual([taus[0]] * 4, taus)

    def test_a_rejected_filter_names_its_option(self):
        with self.assertRaisesRegex(BadOption, "--bandwidth: expected"):
            plan(rate_hz=100.0, core="cortex-m0", lsb=0.05, bandwidth="1.2.3")


class Sensors(unittest.TestCase):
    def test_a_name_has_no_case_and_floats_have_no_counts(self):
        words = "--core cortex-m4f --type float --full-scale 2000 --sensor"
        first, second = (
            command([*words.split(), f"{name}@1000"]) for name in ("icm42688", "ICM42688")
        )
        self.assertEqual((0, ""), (first.returncode, first.stderr))
        self.assertEqual(first.stdout, second.stdout)

    def test_the_low_pass_of_the_gyro_is_to_be_set_unless_another_filter_is_declared(self):
        words = "--sensor icm42688@1000 --core cortex-m4f"
        self.assertIn("set the gyro to the low-pass", command(words.split()).stdout)
        for filter in ("none", "cic2:64"):
            done = command([*words.split(), "--bandwidth", filter])
            self.assertEqual((0, ""), (done.returncode, done.stderr))
            self.assertNotIn("set the gyro", done.stdout)

    def test_every_part_has_a_plan_at_its_rates(self):
        for name, part in sensors.PARTS.items():
            for rate in part.get("bandwidth_at_rate", {part["rate_most_hz"]: 0}):
                with self.subTest(part=name, rate=rate):
                    done = command(["--sensor", f"{name}@{rate}", "--core", "cortex-m4f"])
                    self.assertIn(done.returncode, (0, 1), done.stderr)
                    self.assertNotIn("Traceback", done.stderr)

    def test_the_state_of_law_glr_has_the_size_of_the_header(self):
        header = (ROOT / "lib/include/davar/instance.h").read_text(encoding="utf-8")
        sizes = re.findall(r"DAVAR_GLR_BYTES_Q(?:15|31) \(\(size_t\)(\d+)U", header)
        planned = (ROOT / "tools/plan/planner/costs.py").read_text(encoding="utf-8")
        self.assertIn(f"({sizes[0]} if narrow else {sizes[1]})", planned)

    def test_the_table_of_the_pages_is_that_of_the_planner(self):
        page = (ROOT / "docs/FIRMWARE.md").read_text(encoding="utf-8")
        for row in sensors.ROWS:
            self.assertIn(f"| {row['gyro']} | {row['declare']} | {row['where']} |", page)
        rows = page.count("\n", *re.search(r"\| gyro \| declare \|.*?\n\n", page, re.DOTALL).span())
        self.assertEqual(len(sensors.ROWS), rows - 3)


if __name__ == "__main__":
    unittest.main()
