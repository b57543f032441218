"""tools/davar-plan: its plan equals that of davar_plan_init, gives the same results, and does not
link davar_plan_init.
"""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LISTS = (
    "1",
    "7",
    "1,2,4,8",
    "1,2,4,8,16,32,64",
    "1,2,3,5,9,15,24,40",
    ",".join(str(3 + 2 * i) for i in range(32)),
)
# The options of a filter, and how a program makes the same plan.
FILTERS = {
    (): "davar_plan_init(&made, taus, COUNT)",
    ("--bandwidth", "none"): "davar_plan_init_filtered(&made, taus, COUNT, &(davar_filter_t){0})",
    ("--bandwidth", "40", "--rate", "1000"): "davar_plan_init_filtered(&made, taus, COUNT, "
    "&(davar_filter_t){DAVAR_LOW_PASS(40, 1000, 2)})",
    ("--bandwidth", "50:1:5", "--rate", "200"): "davar_plan_init_filtered(&made, taus, COUNT, "
    "&(davar_filter_t){.cutoff = 0.25, .uncertainty = 0.01 * 5.0, .poles = 1U})",
    ("--bandwidth", "cic:8"): "davar_plan_init_filtered(&made, taus, COUNT, "
    "&(davar_filter_t){.averages = 1U, .length = 8U, .decimation = 8U})",
    ("--bandwidth", "250+sum:8", "--rate", "1000"): "davar_plan_init_filtered(&made, taus, COUNT, "
    "&(davar_filter_t){DAVAR_LOW_PASS(250, 1000, 2), DAVAR_SUM(8)})",
    ("--bandwidth", "average2:4"): "davar_plan_init_filtered(&made, taus, COUNT, "
    "&(davar_filter_t){.averages = 2U, .length = 4U, .decimation = 1U})",
    ("--bandwidth", "cic3:64"): "davar_plan_init_filtered(&made, taus, COUNT, "
    "&(davar_filter_t){.averages = 3U, .length = 64U, .decimation = 64U})",
}
PROGRAM = """
#include "davar/davar.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
extern davar_plan_t ready;
static const uint32_t taus[] = {TAUS};
#define COUNT (sizeof taus / sizeof taus[0])
int main(void)
{
    static davar_plan_t made;
    static davar_result_t a, b;
    uint32_t seed = 1U, same = 0U, white = 0U;
    MAKE;
    if (memcmp(&made, &ready, sizeof made) != 0) {
        return puts("another plan");
    }
    for (int i = 0; i < 2000; i++) {
        memset(&a, 0, sizeof a);
        a.tau_count = COUNT;
        a.window_samples = 200U + 10U * (i % 7);
        for (size_t t = 0; t < COUNT; t++) {
            seed = seed * 1664525U + 1013904223U;
            a.tau[t].m = taus[t];
            a.tau[t].differences = a.window_samples + 1U - 2U * taus[t];
            a.tau[t].adev = (1.0 + 0.1 * (seed >> 8) / 16777216.0) / sqrt(taus[t]);
        }
        memcpy(&b, &a, sizeof a);
        if (i % 50 == 49) { /* a window that lacks the longest */
            b.tau[COUNT - 1U].differences = 0U;
            (void)davar_fit_white_ready(&ready, 100.0, &b);
            if ((b.noise != DAVAR_NOISE_UNKNOWN) || !isnan(b.tau[0].low)
                || b.coefficient[DAVAR_ANGLE_RANDOM_WALK].present) {
                return puts("something out of nothing");
            }
            continue;
        }
        (void)davar_fit_white(&made, 100.0, &a);
        (void)davar_fit_white_ready(&ready, 100.0, &b);
        same += (memcmp(&a, &b, sizeof a) == 0) ? 1U : 0U;
        white += (a.noise == DAVAR_NOISE_WHITE) ? 1U : 0U;
    }
    return printf("%u %s", same, (white > 0U) ? "some" : "none") < 0;
}
"""
LEAN = """
#include "davar/fit.h"
extern davar_plan_t ready;
extern davar_result_t result;
davar_result_t result;
int main(void) { davar_fit_white_ready(&ready, 100.0, &result); return (int)result.noise; }
"""


def plan(*words):
    return subprocess.run(
        [ROOT / "tools/davar-plan", *words],
        text=True,
        capture_output=True,
        check=False,
    )


class Plan(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def compiled(self, program, taus, options=()):
        done = plan("--taus", taus, "--name", "ready", *options)
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        (self.work / "plan.c").write_text(done.stdout)
        (self.work / "program.c").write_text(program)
        command = [
            "gcc",
            "-std=c11",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            "-O1",
            "-ffp-contract=off",
            "-ffunction-sections",
            "-fdata-sections",
            "-Wl,--gc-sections",
            f"-DTAUS={taus}",
            f"-DMAKE={FILTERS[options]}",
            "-I",
            ROOT / "lib/include",
            "-I",
            ROOT / "lib/src",
            self.work / "program.c",
            self.work / "plan.c",
            *(ROOT / "lib/src/filter").glob("*.c"),
            *(ROOT / "lib/src/fit").glob("*.c"),
            *(ROOT / "lib/src/number").glob("*.c"),
            "-o",
            self.work / "program",
            "-lm",
        ]
        done = subprocess.run(
            command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
        )
        self.assertEqual(0, done.returncode, done.stdout)
        return self.work / "program"

    def test_it_equals_the_plan_of_the_library_and_gives_the_same_results(self):
        for taus, options in [*((taus, ()) for taus in LISTS), *((LISTS[3], o) for o in FILTERS)]:
            with self.subTest(taus=taus, options=options):
                program = self.compiled(PROGRAM, taus, options)
                done = subprocess.run([program], text=True, stdout=subprocess.PIPE, check=False)
                self.assertEqual((0, "1960"), (done.returncode, done.stdout.split()[0]))
                if not options:
                    self.assertEqual("1960 some", done.stdout)

    def test_a_filter_prints_the_detector_s_whitening(self):
        words = ("--taus", "1,2", "--rate", "100")
        self.assertNotIn("whiten", plan(*words).stdout)
        # one pole: the only coefficient is exp(-2 pi 0.05), but for the rounding that it allows for
        printed = plan(*words, "--bandwidth", "5:1").stdout
        found = re.search(
            r"whiten_first = (\d+), .whiten_second = (\d+),\n \* .whiten_level = ([\d.]+)", printed
        )
        self.assertAlmostEqual(0.7304, int(found[1]) / 2**14, delta=0.005)
        self.assertAlmostEqual(0, int(found[2]) / 2**14, delta=0.005)
        self.assertAlmostEqual(3.709, float(found[3]), delta=0.005)

    def test_the_code_that_makes_a_plan_is_not_linked(self):
        def linked(program):
            names = subprocess.run(
                ["nm", self.compiled(program, "1,2,4")],
                text=True,
                stdout=subprocess.PIPE,
                check=True,
            ).stdout
            return "davar_plan_init" in names

        self.assertTrue(linked(PROGRAM))
        self.assertFalse(linked(LEAN))

    def test_a_bad_option_is_one_line(self):
        for words in (
            (),
            ("--taus",),
            ("--taus", ""),
            ("--taus", "0,1"),
            ("--taus", "2,2"),
            ("--taus", "1,,2"),
            ("--taus", "1,"),
            ("--taus", "1 2"),
            ("--taus", "1e3"),
            ("--taus", "8388609"),
            ("--taus", ",".join(map(str, range(1, 34)))),
            ("--taus", "-1"),
            ("--taus", "1", "--name", "4x"),
            ("--taus", "1", "--name", "a b"),
            ("--tau", "1"),
            ("plan.c",),
            *(
                ("--taus", "1,2", "--rate", "100", "--bandwidth", filter)
                for filter in (
                    "",
                    "20:3",
                    "20:0",
                    "20:2:60",
                    "-5",
                    "nan",
                    "0.1",
                    "900",
                    "20:",
                    "20+",
                    "20+30",
                    "average",
                    "average:0",
                    "average9:2",
                    "averages:2",
                    "average:1025",
                    "average2:513",
                    "cic0:4",
                    "cic9:4",
                    "cic3",
                    "cic3:4+20",
                    "sum3:4",
                    "sum:0",
                    "sum:4+cic:4",
                    "none+20",
                    "auto",
                )
            ),
            ("--taus", "1,2", "--bandwidth", "20"),
            ("--taus", "1,2", "--bandwidth", "20", "--rate", "0"),
            ("--taus", "1,2", "--bandwidth", "20", "--rate", "x"),
        ):
            with self.subTest(words=words):
                done = plan(*words)
                self.assertEqual(
                    (2, "", 1), (done.returncode, done.stdout, done.stderr.count("\n")), done.stderr
                )
                self.assertRegex(done.stderr, r"^davar-plan: ")

    def test_help(self):
        for words in (("--help",), ("--taus", "1,2", "--help"), ("--taus", "--help")):
            done = plan(*words)
            self.assertEqual((0, ""), (done.returncode, done.stderr))
            self.assertIn("--taus", done.stdout)

    def test_both_spellings_of_a_value(self):
        apart = plan("--taus", "1,2,4", "--bandwidth", "20", "--rate", "100", "--name", "a")
        joined = plan("--taus=1,2,4", "--bandwidth=20", "--rate=100", "--name=a")
        self.assertEqual((0, ""), (joined.returncode, joined.stderr))
        self.assertEqual(apart.stdout, joined.stdout)


if __name__ == "__main__":
    unittest.main()
