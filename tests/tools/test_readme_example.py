"""The firmware examples of all pages and header comments compile unchanged, without a warning. The
README's is short and measures the noise with the setup that its command writes.
"""

import math
import random
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
FIRMWARE = ROOT / "docs/FIRMWARE.md"  # each block continues the one before
ALONE = [ROOT / "docs/DIALECTS.md", ROOT / "docs/GYROS.md", ROOT / "packaging/common/README.md"]
HEADERS = sorted([*ROOT.glob("lib/include/**/*.h"), *ROOT.glob("port/**/*.h")])
LINES_MAX = 15


def blocks(path):
    """The texts of the ```c blocks of a page, or of the comments of a header."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".h":
        text = re.sub(r"^ \* ?", "", text, flags=re.MULTILINE)
    return re.findall(r"^```c\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def examples():
    """The texts of the ```c blocks of FIRMWARE."""
    return blocks(FIRMWARE)


def planned(folder):
    """Runs the command of the README that writes a setup, with another folder."""
    words = re.search(r"^tools/davar-plan (.*) -o \S+$", README.read_text(), re.MULTILINE)[1]
    command = [ROOT / "tools/davar-plan", *words.split(), "-o", folder]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def compiled(text, *flags):
    """The compiler's output for a C text."""
    done = subprocess.run(
        ["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", *flags]
        + ["-I", ROOT / "lib/include", "-fsyntax-only", "-x", "c", "-"],
        input=text,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert bool(done.returncode) == bool(done.stdout), done.stdout
    return done.stdout


def behind_two_poles(cutoff, count, noise):
    """White noise of N = 1 per root sample, in front of a Butterworth low-pass of two poles with
    its -3 dB frequency at `cutoff` of the sample rate: ARMA(2, 1) with the autocovariance of the
    sampled output, exp(-a k) (cos a k + sin a k).
    """
    a = 2 * math.pi * cutoff / math.sqrt(2)

    def covariance(lag):
        return math.exp(-a * abs(lag)) * (math.cos(a * lag) + math.sin(a * abs(lag)))

    one, two = 2 * math.exp(-a) * math.cos(a), -math.exp(-2 * a)
    taps = (1, -one, -two)

    def of_moving_average(lag):
        return sum(
            p * q * covariance(lag + i - j) for i, p in enumerate(taps) for j, q in enumerate(taps)
        )

    ratio = of_moving_average(1) / of_moving_average(0)
    theta = (1 - math.sqrt(1 - 4 * ratio**2)) / (2 * ratio)
    size = math.sqrt(
        of_moving_average(0) / (1 + theta**2) / sum(covariance(k) for k in range(-999, 1000))
    )
    shock, first, second, found = 0.0, 0.0, 0.0, []
    for _ in range(count + 1000):  # the first ones for the filter to settle
        before, shock = shock, noise.gauss(0, size)
        first, second = one * first + two * second + shock + theta * before, first
        found.append(first)
    return found[1000:]


class ReadmeExample(unittest.TestCase):
    def setUp(self):
        self.assertTrue(README.exists(), "there is no README.md")
        self.assertEqual(1, len(blocks(README)), "README.md has one ```c block")
        self.assertTrue(examples(), "docs/FIRMWARE.md has no ```c block")

    def test_the_example_is_short(self):
        self.assertLessEqual(len(blocks(README)[0].splitlines()), LINES_MAX)
        self.assertLessEqual(len(examples()[0].splitlines()), LINES_MAX)

    def test_the_example_of_the_readme_measures_its_input(self):
        noise = random.Random(2)
        # 30 counts of 1/16.4 deg/s after the low-pass of 250 Hz at 1 kHz
        axes = [behind_two_poles(0.25, 12000, noise) for _ in range(3)]
        counts = ", ".join(
            f"{{{', '.join(str(round(16.4 * rate)) for rate in xyz)}}}" for xyz in zip(*axes)
        )
        program = f"""#include "davar_setup.h"
#include <stdio.h>
#include <stdlib.h>
static const int16_t counts[][3] = {{{counts}}};
void gyro_interrupt(const int16_t xyz[3]);
int main_loop(void (*report)(int axis, double arw, double low, double high));
const davar_result_t *take_after_a_sample(uint8_t axis);
const davar_result_t *take_after_a_sample(uint8_t axis)
{{
    static size_t next;
    if (next == 12000) {{
        exit(0);
    }}
    if (axis == 0) {{
        gyro_interrupt(counts[next++]);
    }}
    return davar_setup_take(axis);
}}
static void report(int axis, double arw, double low, double high)
{{
    printf("%d %g %g %g\\n", axis, arw, low, high);
}}
int main(void)
{{
    return main_loop(report);
}}
"""
        with tempfile.TemporaryDirectory() as folder:
            work = Path(folder)
            planned(work)
            (work / "program.c").write_text(program, encoding="utf-8")
            (work / "example.c").write_text(blocks(README)[0], encoding="utf-8")
            options = (work / "davar_setup.args").read_text().split()
            strict = ["gcc", "-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", *options]
            strict += ["-I", ROOT / "lib/include", "-I", ROOT / "lib/src", "-I", work]
            example = [*strict, "-Ddavar_setup_take=take_after_a_sample", "-c", work / "example.c"]
            subprocess.run([*example, "-o", work / "example.o"], check=True)
            sources = [work / "davar_setup.c", *sorted((ROOT / "lib/src").rglob("*.c"))]
            everything = [work / "program.c", work / "example.o", *sources, "-lm"]
            subprocess.run([*strict, *everything, "-o", work / "program"], check=True)
            lines = subprocess.run(
                [work / "program"], check=True, text=True, stdout=subprocess.PIPE
            ).stdout.splitlines()
        found = [tuple(map(float, line.split())) for line in lines]
        self.assertEqual({0, 1, 2}, {axis for axis, *_ in found})
        truth = 60 / math.sqrt(1000)  # N of 1 per root sample
        held = sum(low <= truth <= high for _, _, low, high in found)
        self.assertGreater(held, 0.85 * len(found))

    def test_the_example_by_hand_measures_its_input(self):
        noise = random.Random(1)
        # 20 counts are 1 deg/s: 6 deg/sqrt(h) at 100 Hz, in front of a low-pass at 33 Hz
        rates = behind_two_poles(0.33, 6000, noise)
        counts = ", ".join(str(round(20 * rate)) for rate in rates)
        program = f"""{examples()[0]}
#include <stdio.h>
int main(void)
{{
    static const int16_t counts[] = {{{counts}}};
    static davar_result_t result;
    if (gyro_start() != DAVAR_OK) {{
        return 1;
    }}
    for (int i = 0; i < 6000; i++) {{
        gyro_interrupt(counts[i]);
        if (gyro_noise(&result)) {{
            const davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printf("%g %g %g\\n", arw->value, arw->low, arw->high);
        }}
    }}
    return 0;
}}
"""
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / "example.c"
            source.write_text(program, encoding="utf-8")
            subprocess.run(
                [
                    "gcc",
                    "-std=c11",
                    "-O2",
                    "-I",
                    ROOT / "lib/include",
                    "-I",
                    ROOT / "lib/src",
                    source,
                    *sorted((ROOT / "lib/src").rglob("*.c")),
                    "-o",
                    Path(folder) / "example",
                    "-lm",
                ],
                check=True,
            )
            found = [
                tuple(map(float, line.split()))
                for line in subprocess.run(
                    [Path(folder) / "example"], check=True, text=True, stdout=subprocess.PIPE
                ).stdout.splitlines()
            ]
        self.assertGreater(len(found), 80)
        self.assertGreater(sum(low <= 6 <= high for _, low, high in found), 0.85 * len(found))
        widths = sorted((high - low) / 2 / value for value, low, high in found)
        self.assertAlmostEqual(widths[len(widths) // 2], 0.08, delta=0.01)  # as in the README

    def test_the_examples_compile_without_a_warning(self):
        self.assertEqual("", compiled("\n".join(examples())))

    def test_those_that_stand_alone_compile_too(self):
        for path in ALONE + HEADERS:
            for block in blocks(path):
                with self.subTest(path=path.name, block=block):
                    text = f'#include "davar/davar.h"\n{block}'
                    self.assertEqual("", compiled(text, "-Wno-unused-variable"))

    def test_no_example_is_elsewhere(self):
        self.assertEqual(["instance.h", "types.h"], [path.name for path in HEADERS if blocks(path)])
        pages = [
            path
            for path in ROOT.rglob("*.md")
            if path.relative_to(ROOT).parts[0] != "build" and blocks(path)
        ]
        self.assertEqual(sorted([README, FIRMWARE, *ALONE]), sorted(pages))

    def test_an_example_that_does_not_compile_is_reported(self):
        self.assertIn("no_such_field", compiled(examples()[0].replace(".stride", ".no_such_field")))


if __name__ == "__main__":
    unittest.main()
