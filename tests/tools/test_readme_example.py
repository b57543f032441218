"""The firmware examples of the README and of docs/FIRMWARE.md compile unchanged, without a warning.
The first is short.
"""

import random
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
LINES_MAX = 15


def examples():
    """The texts of the ```c blocks; each continues the one before."""
    text = README.read_text(encoding="utf-8") + (ROOT / "docs/FIRMWARE.md").read_text(
        encoding="utf-8"
    )
    return re.findall(r"^```c\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


class ReadmeExample(unittest.TestCase):
    def setUp(self):
        self.assertTrue(README.exists(), "there is no README.md")
        self.assertTrue(examples(), "README.md has no ```c block")

    def test_the_example_is_short(self):
        self.assertLessEqual(len(examples()[0].splitlines()), LINES_MAX)

    def test_the_first_example_measures_its_input(self):
        noise = random.Random(1)
        counts = ", ".join(
            str(round(noise.gauss(0, 20))) for _ in range(6000)
        )  # 1 deg/s: 6 deg/sqrt(h) at 100 Hz
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
        self.assertAlmostEqual(widths[len(widths) // 2], 0.07, delta=0.01)  # as in the README

    def test_the_examples_compile_without_a_warning(self):
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / "example.c"
            source.write_text("\n".join(examples()), encoding="utf-8")
            done = subprocess.run(
                [
                    "gcc",
                    "-std=c11",
                    "-Wall",
                    "-Wextra",
                    "-Werror",
                    "-I",
                    ROOT / "lib/include",
                    "-c",
                    source,
                    "-o",
                    Path(folder) / "example.o",
                ],
                text=True,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            )
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
