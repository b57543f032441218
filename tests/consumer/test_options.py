"""A disabled feature (davar/options.h) is rejected with its own error, and all other results have
the same bits. A wrong combination does not compile.
"""

import functools
import subprocess
import tempfile
import unittest
from pathlib import Path

from compiling import objects, run

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted((ROOT / "lib/src").rglob("*.c"))
FLAGS = [
    "-std=c11",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-O2",
    "-ffp-contract=off",
    "-I",
    ROOT / "lib/include",
    "-I",
    ROOT / "lib/src",
]


def features(way):
    """Bits of the digit: adaptive 1, centred 2, stride 4. 8 and 9 are policy glr, 9 with a stride;
    a: engine auto; c: a cascade, which needs its number type alone.
    """
    return 0 if way[1] == "c" else int(way[1])


# Features that a configuration of options.c needs.
NEEDS = {
    "LAWS": lambda way: features(way) & 9,
    "CENTRED": lambda way: features(way) & 2,
    "GRID": lambda way: (features(way) & 4 or way[1] == "9") and not way.endswith("a"),
    "Q15": lambda way: way[0] == "q",
    "Q31": lambda way: way[0] in "wf",
}
LEAN = ("GRID", "LAWS", "CENTRED", "Q31")


@functools.cache
def ways(*options):
    """{configuration: (status of init, checksum of the results)}."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "options"
        run(
            "gcc",
            *objects(folder, [*FLAGS, *options], [ROOT / "tests/consumer/options.c", *SOURCES]),
            "-o",
            program,
            "-lm",
        )
        lines = run(program).splitlines()
    return {
        line.split()[0]: (line.split(" ", 1)[1].rsplit(" ", 1)[0], line.split()[-1])
        for line in lines
    }


class Options(unittest.TestCase):
    def test_disabled_features_are_rejected_and_others_have_the_same_bits(self):
        whole = ways()
        self.assertEqual({status for status, _ in whole.values()}, {"ok"})
        self.assertGreater(len({total for _, total in whole.values()}), 15)
        for way in [way for way in whole if way.endswith("a")]:
            self.assertEqual(whole[way[:-1]], whole[way], "auto and grid differ")
        for left_out in (("GRID",), ("LAWS",), ("CENTRED",), ("Q15",), ("Q31",), LEAN):
            found = ways(*(f"-DDAVAR_{name}=0" for name in left_out))
            for way, (status, total) in found.items():
                with self.subTest(left_out=left_out, way=way):
                    refused = any(NEEDS[name](way) for name in left_out)
                    self.assertEqual(
                        ("disabled in this build", "0" * 16) if refused else whole[way],
                        (status, total),
                    )

    def test_the_portable_build_without_asserts_has_the_same_bits(self):
        self.assertEqual(
            ways(),
            ways("-DDAVAR_PORTABLE", "-DDAVAR_ASSERT(condition)=((void)0)", "-DDAVAR_TAUS_MAX=4"),
        )

    def test_the_sizes_that_the_pages_state(self):
        readme, costs = (
            (ROOT / page).read_text(encoding="utf-8") for page in ("README.md", "docs/COST.md")
        )
        sizes = {}
        for taus in (8, 32):
            with tempfile.TemporaryDirectory() as folder:
                source = Path(folder) / "sizes.c"
                source.write_text(
                    '#include "davar/davar.h"\n#include <stdio.h>\n'
                    'int main(void) { printf("%zu %zu", sizeof(davar_result_t), '
                    "sizeof(davar_plan_t)); return 0; }\n"
                )
                subprocess.run(
                    [
                        "gcc",
                        *FLAGS,
                        f"-DDAVAR_TAUS_MAX={taus}",
                        source,
                        "-o",
                        source.with_suffix(""),
                    ],
                    check=True,
                )
                sizes[taus] = tuple(
                    map(
                        int,
                        subprocess.run(
                            [source.with_suffix("")], text=True, stdout=subprocess.PIPE, check=True
                        ).stdout.split(),
                    )
                )
        for taus, (result, plan) in sizes.items():
            self.assertRegex(costs, rf"(?m)^\| {taus}( \(default\))? \| {result} \| {plan} \|$")
            pairs = taus * (taus + 1) // 2
            self.assertEqual((result, plan), (48 * taus + 288, 100 * taus + 4 * pairs + 264))
        readme, costs = (" ".join(page.split()) for page in (readme, costs))
        self.assertIn("288 bytes plus 48 bytes per tau", costs)
        self.assertIn("264 bytes plus 100 bytes per tau plus 4 bytes per pair of taus", costs)
        self.assertIn(f"({sum(sizes[8])} bytes with `-DDAVAR_TAUS_MAX=8`)", readme)

    def test_a_wrong_combination_does_not_compile(self):
        for options, why in (
            (("-DDAVAR_Q15=0", "-DDAVAR_Q31=0"), "one number type must be there"),
            (("-DDAVAR_TAUS_MAX=0",), "DAVAR_TAUS_MAX: 1 to 32"),
            (("-DDAVAR_TAUS_MAX=33",), "DAVAR_TAUS_MAX: 1 to 32"),
            (("-ffast-math",), "without -ffast-math"),
        ):
            done = subprocess.run(
                [
                    "gcc",
                    *FLAGS,
                    *options,
                    "-fsyntax-only",
                    ROOT / "tests/consumer/options.c",
                    *SOURCES,
                ],
                text=True,
                stderr=subprocess.PIPE,
            )
            self.assertNotEqual(0, done.returncode)
            self.assertIn(why, done.stderr)


if __name__ == "__main__":
    unittest.main()
