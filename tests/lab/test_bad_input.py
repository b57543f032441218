"""tools/davarlab on options, outputs and own effects that cannot be used: one line, exit status 2,
nothing left behind.
"""

import contextlib
import errno
import gzip
import io
import math
import os
import re
import subprocess
import textwrap
import unittest
from pathlib import Path
from unittest import mock

import asking  # before numpy: it sets the number of threads
import numpy as np
from davarlab import cli, errors
from test_lab import BASE, ROOT, SENSOR, Folder, run

HEAD = (
    "from davarlab.effects.base import Effect, Parameter\n"
    "SIZE = (Parameter('a_dps', 'deg/s', 0, 1),)\n"
)
REFUSED = {
    "diagnose {rec} -m {model} --rate 100": "--rate: 100 Hz contradicts column time_s",
    "fit {rec} -m {model} --rate -5": "--rate: a number above 0 expected, found '-5'",
    "fit {rec} -m {model} --rate nan": "--rate: a number above 0 expected",
    "import {rec} -o {out} --rename gyro_z_dps=temp_degC": "has a column temp_degC already",
    "plot {rec} -m {model} -o nodir/x.png": "nodir/x.png: cannot be written",
    "plot {rec} -m {model} -o {out}.xyz": "the name must end in .png",
    "improve {rec} -m {model} -o nodir/x": "nodir/x: cannot be written",
    "fit {rec} -m {model} -o {rec}": "also reads or writes it",
    "benchmark --only nosuch": "--only: no scenario 'nosuch'",
    "benchmark --seeds 0": "--seeds: a whole number above 0",
    "nulls --recordings 0": "--recordings: a whole number above 0",
    "nulls --recordings 1 --seconds 5": "--seconds: 5; at least 20",
    "export {model} -o {out}.txt": "the name must end in .h or .csv",
    "add {model} sinusoid frequency_hz=40 -o {out}": "above half the sample rate of 50 Hz",
    "add {model} sinusoid amplitude_dps=inf -o {out}": "amplitude_dps must be a finite number",
    "effects --effects {model}": "a Python file (.py) expected",
}
OWN = {
    "Effect('own', '', SIZE, '', 'mean', '', regressor=lambda r, s: r.time_s[1:])": (
        "own: regressor: 1499 instead of 1500 values"
    ),
    "Effect('own', '', SIZE, '', 'mean', '', regressor=lambda r, s: r.time_s / 0)": (
        "own: regressor: not finite at index 0"
    ),
    "Effect('own', '', SIZE, '', 'mean', '', regressor=lambda r, s: 1 / 0)": (
        "own: regressor: ZeroDivisionError"
    ),
    "Effect('own', '', SIZE, '', 'spectrum', '', spectrum=lambda f, r, s: -f)": (
        "own: spectrum: negative"
    ),
    "Effect('own', '', SIZE, '', 'spectrum', '', spectrum=lambda f, r, s: f[1:])": (
        "own: spectrum: "
    ),
    "Effect('own')": "TypeError",
}


class BadInput(Folder):
    def setUp(self):
        super().setUp()
        rows = "".join(f"{i / 50:.2f},{math.sin(i * i % 997):.4f},{i % 7}\n" for i in range(1500))
        self.recording, self.out = (
            self.file("r.csv", "time_s,gyro_z_dps,temp_degC\n" + rows),
            self.work / "out",
        )

    def refused(self, words, *arguments):
        before = {path: path.read_bytes() for path in self.work.iterdir()}
        done = run(*arguments)
        self.assertEqual((2, ""), (done.returncode, done.stdout), done.stderr)
        said = done.stderr.splitlines()
        self.assertIn(words, said[-1])
        self.assertTrue(all(line.startswith("davarlab: ") for line in said), done.stderr)
        self.assertEqual(before, {path: path.read_bytes() for path in self.work.iterdir()})

    def test_options_and_outputs(self):
        for command, words in REFUSED.items():
            with self.subTest(command):
                self.refused(
                    words,
                    *command.format(rec=self.recording, model=self.model, out=self.out).split(),
                )

    def test_a_gzip_file_that_would_fill_the_memory(self):
        """In its rows, and in front of them."""
        packed = self.work / "packed.csv.gz"
        for text in (
            b"time_s,gyro_z_dps\n" + b"1.000000000,1.000000000\n" * (3 << 20),
            b"# a: %s\n" % (b"b" * 250) * (300 << 10),
        ):
            packed.write_bytes(gzip.compress(text, 9))
            self.assertLess(packed.stat().st_size, 700_000)
            self.refused(
                "the gzip file expands to more than 64 MiB and 100 times its size",
                "fit",
                packed,
                "-m",
                self.model,
            )

    def test_what_standard_output_cannot_take_is_told(self):
        with open("/dev/full", "wb") as full:
            done = subprocess.run(
                [ROOT / "tools/davarlab", "effects"], stdout=full, stderr=subprocess.PIPE, text=True
            )
        self.assertEqual(
            (2, "davarlab: standard output: no space left on device\n"),
            (done.returncode, done.stderr),
        )

    def test_results_are_no_recording(self):
        results = self.work / "results.csv"
        with open(results, "w") as file:
            subprocess.run(
                [ROOT / "tools/davar-sim", self.recording],
                stdout=file,
                stderr=subprocess.PIPE,
                check=True,
            )
        for command in ("compare", "diagnose"):
            self.refused(
                f"{results}:1: results of davar-sim or davarlab live",
                command,
                results,
                "-m",
                self.model,
            )
        self.refused("results of davar-sim", "import", results, "-o", self.out)

    def test_a_model_that_is_nested_too_deep(self):
        model = self.file("deep.toml", "a = " + "[" * 20000 + "]" * 20000)
        self.refused(f"{model}: nested too deep", "compare", self.recording, "-m", model)

    def test_own_effects(self):
        for number, (text, words) in enumerate(OWN.items()):
            with self.subTest(text):
                own = self.file(f"own{number}.py", f"{HEAD}OWN = {text}\n")
                self.refused(words, "diagnose", self.recording, "-m", self.model, "--effects", own)

    def test_a_scenario_is_a_model_and_what_is_assumed_is_said(self):
        scenario = self.file("s.toml", f"{SENSOR}[simulate]\nduration_s = 30\n{BASE}")
        self.assertEqual(0, run("fit", self.recording, "-m", scenario).returncode)
        done = run("add", self.model, "sinusoid", "-o", self.out)
        self.assertEqual(0, done.returncode)
        self.assertIn("amplitude_dps = 0.001, frequency_hz = 0.001", done.stderr)

    def test_the_spectrum_of_the_design_is_found(self):
        text = (ROOT / "tools/lab/DESIGN.md").read_text()
        block = re.search(r"    # resonance\.py\n(?:(?:    .*)?\n)+", text)[0]
        own = self.file("resonance.py", textwrap.dedent(block))
        effect = '[[effect]]\nkind = "resonance"\nstd_dps = 0.03\nfrequency_hz = 7.0\n'
        recording = self.simulated(effect, seconds=1200, options=("--effects", own))
        found = self.diagnosed(recording, "--effects", own)
        self.assertEqual(["resonance"], found["missing"])
        value = found["candidates"][0]["parameters"]
        self.assertAlmostEqual(7.0, value["frequency_hz"]["value"], delta=0.1)
        self.assertAlmostEqual(0.03, value["std_dps"]["value"], delta=0.003)
        model = self.file("full.toml", SENSOR + BASE + effect)
        self.assertEqual(
            0, run("fit", recording, "-m", model, "--effects", own, "--json").returncode
        )


class Errors(unittest.TestCase):
    def test_what_nobody_foresaw_is_one_line_and_status_3(self):
        fault = (lambda options: [][1], *cli.COMMANDS["effects"][1:])
        with mock.patch.dict(cli.COMMANDS, effects=fault):
            done = asking.run("effects")
        self.assertEqual((3, "", 1), (done.returncode, done.stdout, len(done.stderr.splitlines())))
        self.assertIn("internal error: IndexError", done.stderr)

    def test_only_a_file_of_the_user_is_bad_input(self):
        """A file of this package or of Python that is missing is a fault; but a full disk is the
        machine's wherever it is met.
        """
        places = [errors.__file__, unittest.__file__, np.__file__]
        for path, code, status in (
            [(Path(path).parent / "gone", errno.ENOENT, 3) for path in places]
            + [("gone.csv", errno.ENOENT, 2), (b"gone.csv", errno.EACCES, 2)]
            + [(path, errno.ENOSPC, 2) for path in places]
        ):
            with self.subTest(path), contextlib.redirect_stderr(io.StringIO()) as said:
                try:
                    raise OSError(code, os.strerror(code), path)
                except OSError as why:
                    self.assertEqual(errors.outside_error(why), status, said.getvalue())


if __name__ == "__main__":
    unittest.main()
