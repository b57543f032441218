"""Reports of tools/davarlab: they need nothing but themselves and say what the JSON says."""

import base64
import hashlib
import json
import math
import random
import re
import tempfile
import unittest
from decimal import Decimal
from html.parser import HTMLParser
from pathlib import Path

from asking import typed as run

SENSOR = '[sensor]\nrate_hz = 50.0\ncolumn = "gyro_z_dps"\n'
MODEL = """[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 0.3
[[effect]]
kind = "bias_instability"
coefficient_deg_per_h = 5.0
"""
TEMPERATURE = '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.02\n'
TINY = 1e-12  # smaller p-values are shown as "below" it
FETCHING = {"src", "href", "srcset", "action", "data", "poster", "background", "xlink:href"}


def simulated(folder, name, effect="", seed=3):
    scenario, recording = folder / f"{name}.toml", folder / f"{name}.csv"
    scenario.write_text(f"{SENSOR}[simulate]\nseed = {seed}\nduration_s = 3600\n{MODEL}{effect}")
    done = run("simulate", scenario, "-o", recording)
    assert done.returncode == 0, done.stderr
    return recording


class Reader(HTMLParser):
    """Tags with their attributes, the text of the verdict, and every <data> with its key, value and
    text.
    """

    def __init__(self, text):
        super().__init__()
        self.tags, self.numbers, self.verdict, self.data, self.open = [], [], "", "", None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append((tag, attributes))
        if tag == "data":
            self.numbers.append([attributes["data-key"], attributes["value"], ""])
        if tag == "data" or attributes.get("id") in ("verdict", "drawn"):
            self.open = tag

    def handle_data(self, text):
        if self.open == "data":
            self.numbers[-1][2] += text
        elif self.open == "script":
            self.data += text
        elif self.open:
            self.verdict += text

    def handle_endtag(self, tag):
        self.open = None if tag == self.open else self.open

    @property
    def drawn(self):
        return json.loads(self.data)


def looked_up(data, key):
    """The value of a dotted key: names and indices."""
    for name in key.split("."):
        data = data[int(name)] if isinstance(data, list) else data[name]
    return data


def shown_number(text):
    """A number as the page writes it (1,234; -5; 1.2 times ten to the -7) as a Decimal."""
    text = (
        text.replace(",", "")
        .replace("−", "-")
        .translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    )
    return Decimal(re.sub(r"·10", "e", text))


class Pages(unittest.TestCase):
    """One page of every command, made once."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.work = work = Path(folder.name)
        cls.model = work / "model.toml"
        cls.model.write_text(SENSOR + MODEL)
        clean, warm = simulated(work, "clean"), simulated(work, "warm", TEMPERATURE)
        held_out = simulated(work, "held_out", TEMPERATURE, seed=9)
        cls.recording, cls.json, cls.pages = warm, {}, {}
        for name, command in {
            "clean": ("diagnose", clean),
            "warm": ("diagnose", warm),
            "compare": ("compare", warm),
            "improve": ("improve", warm, "--held-out", held_out),
        }.items():
            page = work / f"{name}.html"
            done = run(*command, "-m", cls.model, "--json", "--report", page)
            assert done.returncode == (name == "compare"), done.stderr
            cls.json[name], cls.pages[name] = (
                json.loads(done.stdout),
                Reader(page.read_text(encoding="utf-8")),
            )

    def test_a_page_fetches_nothing(self):
        """Its one script is the one that its policy names, and the policy permits nothing else."""
        for name, page in self.pages.items():
            text = (self.work / f"{name}.html").read_text(encoding="utf-8")
            code = re.search(r"<script>(.*?)</script>", text, re.DOTALL).group(1)
            digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
            self.assertIn(f"default-src 'none'; script-src 'sha256-{digest}'; style-src", text)
            self.assertNotRegex(code, r"fetch\(|XMLHttpRequest|import\b|WebSocket|innerHTML")
            without = text.replace(code, "")
            self.assertNotRegex(
                without, r"https?:|//\w|@import|url\(|<link|<iframe|<object|<img", name
            )
            kinds = [a.get("type") for tag, a in page.tags if tag == "script"]
            self.assertEqual(kinds, ["application/json", None], name)
            for tag, attributes in page.tags:
                self.assertFalse(FETCHING.intersection(attributes), (name, tag))
                self.assertFalse([a for a in attributes if a.startswith("on")], (name, tag))

    def test_what_is_drawn_is_what_was_found(self):
        for name, page in self.pages.items():
            drawn, found = page.drawn, self.json[name]
            place = ("tau_s", "start_s", "stop_s", "ratio", "z")
            cells = [[cell[key] for key in place] for cell in drawn["maps"]["initial"]]
            for cell in found.get("where", []):
                self.assertIn([cell[key] for key in place], cells, name)
            errors = [step["error"] for step in found.get("steps", [])]
            self.assertEqual([step["error"] for step in drawn["steps"]], errors, name)

    def test_every_number_is_that_of_the_json(self):
        fit = json.loads(run("fit", self.recording, "-m", self.model, "--json").stdout)
        for name, page in self.pages.items():
            data = {"fitted": fit["effects"], **self.json[name]}
            if name == "improve":
                # what is measured and tried does not depend on what is done with it
                data = {**self.json["warm"], **data, "candidates": self.json["warm"]["candidates"]}
            for key, value, _ in page.numbers:
                if name == "improve" and "held_out" in key and key.startswith("candidates"):
                    # improve --json has no candidates, and the diagnosis had no second recording
                    continue
                expected = looked_up(data, key)
                self.assertEqual(
                    value if isinstance(expected, str) else float(value), expected, (name, key)
                )

    def test_every_number_of_an_accelerometer_is_that_of_the_json(self):
        noise, path, model = random.Random(2), self.work / "accel.csv", self.work / "accel.toml"
        lines = [f"{i / 50:.2f},{noise.gauss(1, 0.002):.7f}" for i in range(6000)]
        path.write_text("\n".join(["time_s,accel_z_g", *lines]) + "\n")
        model.write_text(
            '[sensor]\ncolumn = "accel_z_g"\n[[effect]]\nkind = "velocity_random_walk"\n'
            "coefficient_m_per_s_per_sqrt_h = 0.2\n"
        )
        page = self.work / "accel.html"
        compared = run("compare", path, "-m", model, "--json", "--report", page)
        fitted = run("fit", path, "-m", model, "--json")
        data = {**json.loads(compared.stdout), "fitted": json.loads(fitted.stdout)["effects"]}
        numbers = Reader(page.read_text(encoding="utf-8")).numbers
        for key, value, _ in numbers:
            self.assertEqual(float(value), looked_up(data, key), key)
        walk = "fitted.0.parameters.coefficient_m_per_s_per_sqrt_h"
        found = {key: float(value) for key, value, _ in numbers}
        truth = 0.002 * 9.80665 / math.sqrt(50) * 60  # m/s/sqrt(h)
        self.assertLess(found[f"{walk}.low"], truth)
        self.assertLess(truth, found[f"{walk}.high"])

    def test_what_is_shown_is_the_number_rounded(self):
        for name, page in self.pages.items():
            for key, value, text in page.numbers:
                if text.startswith("below"):
                    self.assertLess(float(value), TINY, (name, key))
                elif value not in "xyz":
                    shown = shown_number(text)
                    half_digit = 0.5 * 10.0 ** shown.as_tuple().exponent
                    self.assertLessEqual(
                        abs(float(shown) - float(value)), half_digit * 1.0001, (name, key, text)
                    )

    def test_the_numbers_that_matter_are_there(self):
        always = {
            "error",
            "p_value",
            "samples",
            "rate_hz",
            "fitted.0.parameters.coefficient_deg_per_sqrt_h.low",
            "tests.spectrum",
            "correlations.temp_degC.value",
        }
        tried = {
            "where.0.ratio",
            "where.0.z",
            "candidates.0.gain",
            "candidates.0.p_value",
            "candidates.0.error_after",
            "steps.0.error",
            "steps.1.error",
            "steps.1.error_floor",
            "steps.1.p_value",
            "p_value_after",
            "fitted.2.parameters.coefficient_dps_per_degC.high",
        }
        wanted = {
            "clean": {"error_floor"},
            "compare": {"error_floor", "where.0.ratio"},
            "warm": tried,
            "improve": tried | {"steps.1.error_held_out"},
        }
        for name, page in self.pages.items():
            self.assertLessEqual(always | wanted[name], {key for key, _, _ in page.numbers}, name)

    def test_the_verdict_is_that_of_the_json(self):
        self.assertEqual(
            [self.json[name]["verdict"] for name in ("clean", "warm", "improve")],
            ["none", "temperature", "temperature"],
        )
        self.assertIn("Nothing is missing", self.pages["clean"].verdict)
        self.assertIn("does not fit", self.pages["compare"].verdict)
        estimate = self.json["warm"]["fitted"][2]["parameters"]["coefficient_dps_per_degC"]
        for name in ("warm", "improve"):
            self.assertIn("The model lacks temperature", self.pages[name].verdict)
            for bound in estimate.values():
                self.assertIn(f"{bound:.3g}", self.pages[name].verdict)


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)
        self.model = self.work / "model.toml"
        self.model.write_text(SENSOR + MODEL)

    def refused(self, words, *arguments):
        done = run(*arguments)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn(words, done.stderr)

    def test_a_path_that_cannot_be_written_is_refused_before_the_recording_is_read(self):
        (self.work / "folder.html").mkdir()
        for command in ("compare", "diagnose", "improve"):
            for path in (
                self.work / "none/report.html",
                self.work / "folder.html",
                self.model / "report.html",
            ):
                self.refused(
                    f"{path}: cannot be written",
                    command,
                    self.work / "none.csv",
                    "-m",
                    self.model,
                    "--report",
                    path,
                )

    def test_a_run_that_fails_leaves_the_old_report_and_nothing_else(self):
        old = self.work / "report.html"
        old.write_text("old")
        self.refused(
            "none.csv", "compare", self.work / "none.csv", "-m", self.model, "--report", old
        )
        self.assertEqual(old.read_text(), "old")
        self.assertEqual(
            sorted(path.name for path in self.work.iterdir()), ["model.toml", "report.html"]
        )


if __name__ == "__main__":
    unittest.main()
