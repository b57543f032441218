"""The setup that tools/davar-plan writes: it compiles, its promises hold in simulations, and its
calls may come in any order.
"""

import json
import re
import subprocess

from planner_case import EXAMPLE, KEYS, ROOT, WISHES, Planned, command

FILES = {"davar_setup.h", "davar_setup.c", "davar_setup.args", "davar_setup.cmake"}
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
# wishes, FILTER of setup_promises.c, sigma after the filter
SIMULATED = (
    (
        "--rate 1000 --lsb 0.061 --bandwidth 250:2 --respond 2 --core cortex-m4f",
        "{DAVAR_LOW_PASS(250, 1000, 2)}",
        30,
    ),
    (
        "--rate 100 --lsb 0.05 --bandwidth 33:2 --core cortex-m0",
        "{DAVAR_LOW_PASS(33, 100, 2)}",
        20,
    ),
    (
        "--rate 100 --lsb 0.05 --bandwidth 5:1 --respond 20 --core cortex-m0",
        "{DAVAR_LOW_PASS(5, 100, 1)}",
        20,
    ),
    ("--rate 100 --lsb 0.05 --core cortex-m0", "{0}", 20),
    (
        "--rate 200 --type float --full-scale 500 --bandwidth none --respond 3 --core rv32imac",
        "{0}",
        1,
    ),
    (
        "--rate 100 --lsb 0.05 --bandwidth none --respond 1.1 --arw-percent 8 --core cortex-m4f",
        "{0}",
        20,
    ),
    (
        "--rate 1000 --lsb 0.061 --bandwidth 100:2 --false-alarms-per-hour 0.1 --core cortex-m4f",
        "{DAVAR_LOW_PASS(100, 1000, 2)}",
        30,
    ),
    (
        "--rate 200 --lsb 0.061 --bandwidth 74.6:2 --arw-percent 20 "
        "--false-alarms-per-hour 0.003 --core cortex-m0",
        "{DAVAR_LOW_PASS(74.6, 200, 2)}",
        30,
    ),
)
SEED, TRIALS = 20261, 300


class Files(Planned):
    def test_every_plan_compiles_without_a_warning_and_has_the_keys(self):
        for words in WISHES:
            with self.subTest(wishes=words):
                found = self.planned(words)
                self.assertEqual([], [key for key in KEYS if key not in found])
                folder = self.work / "setup"
                self.assertEqual(FILES, {path.name for path in folder.iterdir()})
                options = (folder / "davar_setup.args").read_text().split()
                self.assertEqual([f"-D{define}" for define in found["defines"]], options)
                done = self.gcc(*WARNINGS, *options, "-c", "setup/davar_setup.c", "-o", "a.o")
                self.assertEqual("", done.stderr)

    def test_the_header_refuses_other_options(self):
        self.planned(EXAMPLE)
        done = self.gcc("-c", "setup/davar_setup.c", "-o", "a.o")
        self.assertIn("davar_setup.args", done.stderr)
        self.assertNotEqual(0, done.returncode)

    def test_the_header_serves_c_plus_plus(self):
        self.planned(EXAMPLE)
        (self.work / "a.cpp").write_text('#include "setup/davar_setup.h"\nint main() {}\n')
        command = ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "@setup/davar_setup.args"]
        done = subprocess.run(
            [*command, "-I", ROOT / "lib/include", "-fsyntax-only", "a.cpp"],
            text=True,
            capture_output=True,
            check=False,
            cwd=self.work,
        )
        self.assertEqual("", done.stderr)

    def test_cmake_builds_it_with_the_options_of_the_plan(self):
        self.planned(EXAMPLE)
        (self.work / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.22)\nproject(app LANGUAGES C)\n"
            "include(setup/davar_setup.cmake)\n"
            f"add_subdirectory({ROOT} davar)\nadd_executable(app main.c setup/davar_setup.c)\n"
            "target_link_libraries(app PRIVATE davar::davar)\n"
        )
        (self.work / "main.c").write_text(
            '#include "setup/davar_setup.h"\n'
            "int main(void) { return (davar_setup_start() == DAVAR_OK) ? 0 : 1; }\n"
        )
        for words in (["-S", ".", "-B", "build"], ["--build", "build", "--target", "app"]):
            done = subprocess.run(
                ["cmake", *words], text=True, capture_output=True, check=False, cwd=self.work
            )
            self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        self.assertEqual(0, subprocess.run([self.work / "build/app"], check=False).returncode)

    def test_the_example_of_the_issue_fits(self):
        found = self.planned(EXAMPLE)
        self.assertLessEqual(found["flash_bytes"], 24 * 1024)
        self.assertLessEqual(found["ram_bytes"], 20 * 1024)
        self.assertLessEqual(found["respond_s"], 2)
        self.assertGreaterEqual(max(found["taus_s"]), 1000)

    def test_the_same_wishes_give_the_same_bytes(self):
        self.planned(EXAMPLE)
        first = {path.name: path.read_bytes() for path in (self.work / "setup").iterdir()}
        self.planned(EXAMPLE)
        again = {path.name: path.read_bytes() for path in (self.work / "setup").iterdir()}
        self.assertEqual(first, again)

    def test_the_printed_report_states_the_figures_of_the_json(self):
        found = self.planned(EXAMPLE)
        done = command(EXAMPLE.split())
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        for key in ("flash_bytes", "ram_bytes", "stack_bytes", "mean_instructions"):
            self.assertIn(str(found[key]), done.stdout)
        self.assertIn("a folder with -o", done.stdout)


class Promises(Planned):
    def simulated(self, words, filter, sigma):
        """The plan, and what its setup delivers on this machine."""
        found = self.planned(words)
        text = (self.work / "setup/davar_setup.c").read_text()
        rate = float(re.search(r"rate_hz = ([^,]+),", text)[1])
        unit = re.search(r"unit_per_count = ([^,]+),", text)
        stride = round(found["stride_s"] * rate)
        lines = self.run_setup(
            "setup_promises.c",
            (SEED, TRIALS, sigma),
            "-I",
            ROOT / "tests/support",
            f"-DFILTER={filter}",
            f"-DSAMPLE={'int16_t' if unit else 'float'}",
            f"-DUNIT={unit[1] if unit else 1.0}",
            f"-DRATE={rate}",
            f"-DQUIET={round(found['window_s'] * rate) + 10 * stride + 200}U",
            f"-DSTRIDE={stride}U",
            f"-DALARMS={int(found['law'] == 'glr')}",
        )
        measured = {name: float(value) for name, value in map(str.split, lines)}
        return found, measured | {"late_s": measured["late"] / rate}

    def test_intervals_are_as_narrow_and_changes_are_seen_as_soon_as_promised(self):
        for words, filter, sigma in SIMULATED:
            with self.subTest(wishes=words):
                found, measured = self.simulated(words, filter, sigma)
                self.assertAlmostEqual(1, measured["width"] / found["arw_percent"], delta=0.15)
                self.assertGreater(measured["shown"], 0.9)
                self.assertGreater(measured["held"], 0.92)
                self.assertLessEqual(measured["late_s"], found["respond_s"])


class Calls(Planned):
    """Take and curve in any order."""

    SAMPLES, SIGMA, UNIT, RATE = 40000, 20, 0.05, 100
    WISHES = (
        f"--rate {RATE} --axes 2 --lsb {UNIT} --bandwidth none --respond 4 --longest-tau 40 "
        "--core cortex-m4f"
    )

    def called(self, more):
        """The plan, and what each call of setup_calls.c returned."""
        found = self.planned(f"{self.WISHES} {more}")
        stride = round(found["stride_s"] * self.RATE)
        words = (SEED, self.SAMPLES)
        lines = self.run_setup("setup_calls.c", words, *WARNINGS, f"-DSTRIDE={stride}U")
        return found, [json.loads(line) for line in lines]

    def check_long(self, call, found):
        """The long sizes have values of white noise: within five standard errors."""
        taus = {m: [float.fromhex(x) for x in more] for m, _, *more in call["taus"]}
        longest = round(max(found["taus_s"]) * self.RATE)
        self.assertEqual(max(taus), longest)
        for m, (adev, low, high) in taus.items():
            if m >= 64:
                truth = self.SIGMA * self.UNIT / m**0.5
                spread = 5 * (m / min(self.SAMPLES, 34 * m)) ** 0.5
                self.assertLess(abs(adev / truth - 1), spread)
                self.assertLess(low, adev)
                self.assertLess(adev, high)

    def check_walk(self, call):
        walk = call["walk"]
        truth = 60 * self.SIGMA * self.UNIT / self.RATE**0.5
        self.assertTrue(walk["present"])
        width = walk["high"] - walk["low"]
        self.assertLess(abs(walk["value"] - truth), width)
        self.assertLess(width, truth)

    def returned(self, more, fit):
        found, calls = self.called(more)
        self.assertEqual(fit, found["fit"])
        self.assertEqual([False] * 4, [call["has_result"] for call in calls[:4]])
        return found, calls[4:]

    def test_a_curve_without_a_fit_needs_no_result_and_takes_none(self):
        found, calls = self.returned("--flash 24k", "curve")
        take, again, curve, same, other, of_other, late, after = calls
        for call in (take, of_other, after):
            self.check_walk(call)
        self.assertFalse(again["has_result"])
        for call in (curve, same, other, late):
            self.check_long(call, found)
            self.assertFalse(call["walk"]["present"])
        self.assertEqual(curve, same)
        self.assertNotEqual(curve["taus"], other["taus"])

    def test_a_fit_of_all_terms_uses_the_window_if_there_is_a_new_result(self):
        for more in ("", "--false-alarms-per-hour 0.1"):
            with self.subTest(wishes=more):
                found, calls = self.returned(more, "terms")
                take, again, curve, same, other, of_other, late, after = calls
                self.check_walk(take)
                for call in (curve, same, other, late):
                    self.check_long(call, found)
                    self.check_walk(call)
                for call in (again, of_other, after):
                    self.assertFalse(call["has_result"])
                self.assertEqual(curve, same)
                sizes = [tau[0] for tau in take["taus"]]
                for call, has_window in ((curve, False), (other, True), (late, True)):
                    of_window = call["taus"][: len(sizes)]
                    self.assertEqual(sizes, [tau[0] for tau in of_window])
                    self.assertEqual([has_window] * len(sizes), [tau[1] > 0 for tau in of_window])
                    self.assertEqual(
                        [has_window] * len(sizes), ["nan" not in tau for tau in of_window]
                    )
