"""tools/davar-mcu: the same bytes as davar-sim, on every target; equal errors for bad options."""

import functools
import random
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import result_cache
import targets

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = 100_000
TAUS = ("--taus", "1,2,4,8,16,32,64,128")
JOBS = {
    "the paper's window law": (*TAUS, "--stride", "50"),
    "trailing, both criteria": (*TAUS, "--stride", "500", "--mode", "trailing", "--policy", "and"),
    "fixed window, no moments": ("--policy", "fixed", "--segment", "0", "--stride", "97"),
    "policy glr": (
        "--taus",
        "1,2,4,8,16,32,64",
        "--policy",
        "glr",
        "--window-max",
        "320",
        "--stride",
        "50",
        "--long-cluster",
        "80",
    ),
    "a stride on a grid": (*TAUS, "--stride", "20", "--engine", "grid"),
    "gaps restart the window": ("--stride", "60", "--window-max", "300"),
    "a cascade": ("--policy", "fixed", "--stride", "600", "--longest-tau", "300"),
    "a cascade after a filter": (
        "--policy",
        "fixed",
        "--mode",
        "trailing",
        "--stride",
        "600",
        "--longest-tau",
        "20",
        "--bandwidth",
        "30",
    ),
}
RANDOM_JOBS = 5
EVERY_SAMPLE = (*TAUS, "--lsb", "0.01")


PASSED = result_cache.ResultCache(ROOT / "build/cache/emulated")


def tearDownModule():
    print(f"cached: {PASSED.hits}")


def write_recording(path, samples):
    """Noise that changes its size, with gaps: two near each other, one of them long."""
    noise, time_s = random.Random(3), 0.0
    with path.open("w") as file:
        file.write("time_s,gyro_z_dps\n")
        for i in range(samples):
            time_s += 0.06 if i in (5000, 40000, 40010, 40020, 40030, 40040) else 0.01
            file.write(
                f"{time_s:.2f},{noise.gauss(0.5, 0.2 if (i // 20000) % 2 == 0 else 0.8):.2f}\n"
            )


def random_job(source):
    """Options for which every target has enough memory."""
    longest = 2 * source.randrange(20, 100)
    shortest = 2 * source.randrange(10, longest // 2 + 1)
    taus = sorted(
        source.sample(range(1, shortest // 2 + 1), min(source.randrange(1, 9), shortest // 2))
    )
    options = [
        "--window-max",
        longest,
        "--window-min",
        shortest,
        "--segment",
        source.randrange(1, shortest),
        "--taus",
        ",".join(map(str, taus)),
        "--stride",
        source.choice((1, 11, 20, 40)),
        "--policy",
        source.choice(("fixed", "kurtosis", "or", "and")),
        "--mode",
        source.choice(("centred", "trailing")),
        "--lsb",
        source.choice(("0.01", "0.002")),
    ]
    if source.random() < 0.3:
        options += ["--shrink", 0]
    return tuple(map(str, options))


class Mcu(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.long, cls.short = Path(cls.folder.name, "long.csv"), Path(cls.folder.name, "short.csv")
        write_recording(cls.long, SAMPLES)
        write_recording(cls.short, 3000)

    @staticmethod
    def command(name, *arguments):
        done = subprocess.run(
            [ROOT / "tools" / name, *map(str, arguments)],
            text=True,
            capture_output=True,
            check=False,
        )
        return done.returncode, done.stdout, done.stderr

    @classmethod
    @functools.cache
    def simulated(cls, recording, options):
        """davar-sim's output, for all targets."""
        return cls.command("davar-sim", recording, *options)

    def same(self, target, recording, options):
        expected = self.simulated(recording, options)
        self.assertEqual(0, expected[0], expected[2])
        self.assertGreater(len(expected[1].splitlines()), 50)

        def passes():
            actual = self.command("davar-mcu", "--target", target, recording, *options)
            self.assertEqual(0, actual[0], actual[2])
            self.assertTrue(expected[1] == actual[1], f"{target}: other bytes than davar-sim's")
            self.assertEqual(expected[2], actual[2], f"{target}: other counters than davar-sim's")
            return True

        PASSED.check(
            result_cache.content_key(
                *self.between(target, "--longest-tau" in options),
                recording.read_bytes(),
                *options,
                *expected,
            ),
            passes,
        )

    @classmethod
    @functools.cache
    def between(cls, target, has_cascade):
        """Everything between a recording and its results: the image, its emulator, davar-sim, which
        feeds it, and the scripts.
        """
        kind = targets.job_kind(target, has_cascade)
        targets.build(target, kind, "replay")
        return [
            *targets.identity(target, targets.folder(target, kind) / "replay.elf"),
            ROOT / "build/tools/host_sim/davar-sim",
            ROOT / "tools/davar-mcu",
            Path(targets.__file__),
        ]

    def test_the_same_bytes_on_every_target(self):
        for target in targets.MACHINES:
            for name, options in JOBS.items():
                with self.subTest(target=target, job=name):
                    self.same(target, self.long, ("--lsb", "0.01", *options))

    def test_the_same_bytes_at_every_sample(self):
        for target in targets.MACHINES:
            with self.subTest(target=target):
                self.same(target, self.short, EVERY_SAMPLE)

    def test_the_same_bytes_for_random_jobs(self):
        """The property test compares davar-sim's results with brute force; here every target is
        compared with davar-sim.
        """
        source = random.Random(20261121)
        for target in targets.MACHINES:
            for _ in range(RANDOM_JOBS):
                options = random_job(source)
                with self.subTest(target=target, options=" ".join(options)):
                    self.same(target, self.short, options)

    def test_bad_options_are_davar_sim_s(self):
        for options in (("--window-max", "0"), ("--policy", "guess"), ("--lsb", "-1")):
            with self.subTest(options=options):
                expected = self.command("davar-sim", self.short, *options)
                actual = self.command("davar-mcu", "--target", "cortex-m3", self.short, *options)
                self.assertEqual((2, "", expected[2]), actual)

    def test_an_unknown_target_is_reported(self):
        status, output, error = self.command("davar-mcu", "--target", "z80", self.short)
        self.assertEqual((2, ""), (status, output))
        self.assertIn("found 'z80'", error)

    def test_a_job_too_large_for_the_device_is_reported(self):
        status, output, error = self.command(
            "davar-mcu",
            "--target",
            "cortex-m0",
            self.short,
            "--lsb",
            "0.01",
            "--window-max",
            "6000",
            "--taus",
            "1,2,4",
        )
        self.assertEqual((2, ""), (status, output))
        self.assertIn("too little memory", error)

    def test_a_cascade_that_does_not_fit_the_device_is_reported(self):
        for options, words in (
            (("--stride", "1"), "the cascade of --longest-tau: shorten --window-max"),
            (("--taus", "1,2,3,4,5,6,7,8,9,10"), "shorten --taus or --longest-tau"),
        ):
            with self.subTest(options=options):
                status, output, error = self.command(
                    "davar-mcu",
                    "--target",
                    "cortex-m0",
                    self.short,
                    *("--lsb", "0.01", "--window-max", "1200", "--policy", "fixed"),
                    *("--stride", "600", "--longest-tau", "40000", *options),
                )
                self.assertEqual((2, ""), (status, output))
                self.assertIn(words, error)


if __name__ == "__main__":
    unittest.main()
