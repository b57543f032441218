"""Reports of tools/davarlab: they need nothing but themselves and say what the JSON says."""

import base64
import hashlib
import json
import math
import random
import re
from decimal import Decimal
from html.parser import HTMLParser

import numpy as np
import pytest
from asking import ROOT, run, said
from lab_bench import Lab, of_gyro, write_csv

TEMPERATURE = '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.02\n'
TINY = 1e-12  # smaller p-values are shown as "below" it
FETCHING = {"src", "href", "srcset", "action", "data", "poster", "background", "xlink:href"}
PAGES = ("clean", "warm", "compare", "improve")
ALWAYS = (
    "error p_value samples rate_hz fitted.0.parameters.coefficient_deg_per_sqrt_h.low "
    "tests.spectrum correlations.temp_degC.value"
)
TRIED = (
    "where.0.ratio where.0.z candidates.0.gain candidates.0.p_value candidates.0.error_after "
    "steps.0.error steps.1.error steps.1.error_floor steps.1.p_value p_value_after "
    "fitted.2.parameters.coefficient_dps_per_degC.high"
)
WANTED = {
    "clean": "error_floor",
    "compare": "error_floor where.0.ratio",
    "warm": TRIED,
    "improve": f"{TRIED} steps.1.error_held_out",
}


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


def looked_up(data, key):
    """The value of a dotted key: names and indices."""
    for name in key.split("."):
        data = data[int(name)] if isinstance(data, list) else data[name]
    return data


def shown_number(text):
    """A number as the page writes it (1,234; -5; 1.2 times ten to the -7) as a Decimal."""
    plain = text.replace(",", "").replace("−", "-")
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    return Decimal(re.sub(r"·10", "e", plain.translate(digits)))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """name -> (JSON, page, its text) of every command; the fit."""
    lab, recordings = Lab(tmp_path_factory.mktemp("report")), {}
    for name, effect, seed in (("clean", "", 3), ("warm", TEMPERATURE, 3), ("out", TEMPERATURE, 9)):
        recordings[name] = lab.work / f"{name}.csv"
        lab.simulated(effect, seed=seed, seconds=1800).rename(recordings[name])
    found = {"fit": said("fit", recordings["warm"], "-m", lab.model)["effects"]}
    for name, command in {
        "clean": ("diagnose", recordings["clean"]),
        "warm": ("diagnose", recordings["warm"]),
        "compare": ("compare", recordings["warm"]),
        "improve": ("improve", recordings["warm"], "--held-out", recordings["out"]),
    }.items():
        page = lab.work / f"{name}.html"
        words = (*command, "-m", lab.model, "--report", page)
        data = said(*words, statuses=(int(name == "compare"),))
        text = page.read_text(encoding="utf-8")
        found[name] = (data, Reader(text), text)
    return found


@pytest.mark.parametrize("command", ["diagnose", "improve"])
def test_a_page_without_a_model_file(lab, command):
    """It names the recording alone, and the next command needs no model file either."""
    recording, page = lab.simulated(TEMPERATURE, seconds=600), lab.work / "r.html"
    assert run(command, recording, "--report", page).returncode in (0, 1)
    text = page.read_text(encoding="utf-8")
    found = set(re.findall(r"tools/davarlab [^<]*", text))
    assert found == {
        f"tools/davarlab {command} {recording} --report {page}",
        f"tools/davarlab improve {recording} -o BETTER.toml",
    }


@pytest.mark.parametrize("name", PAGES)
def test_a_page_fetches_nothing(made, name):
    """Its one script is the one that its policy names, and the policy permits nothing else."""
    _, page, text = made[name]
    code = re.search(r"<script>(.*?)</script>", text, re.DOTALL).group(1)
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    assert f"default-src 'none'; script-src 'sha256-{digest}'; style-src" in text
    assert not re.search(r"fetch\(|XMLHttpRequest|(import|export)\b|WebSocket|innerHTML", code)
    without = text.replace(code, "")
    assert not re.search(r"https?:|//\w|@import|url\(|<link|<iframe|<object|<img", without)
    kinds = [a.get("type") for tag, a in page.tags if tag == "script"]
    assert kinds == ["application/json", None]
    for tag, attributes in page.tags:
        assert not FETCHING.intersection(attributes), tag
        assert not [a for a in attributes if a.startswith("on")], tag


@pytest.mark.parametrize("name", PAGES)
def test_what_is_drawn_is_what_was_found(made, name):
    found, page, _ = made[name]
    drawn = json.loads(page.data)
    place = ("tau_s", "start_s", "stop_s", "ratio", "z")
    cells = [[cell[key] for key in place] for cell in drawn["maps"]["initial"]]
    for cell in found.get("where", []):
        assert [cell[key] for key in place] in cells
    errors = [step["error"] for step in found.get("steps", [])]
    assert [step["error"] for step in drawn["steps"]] == errors


@pytest.mark.parametrize("name", PAGES)
def test_every_number_is_that_of_the_json_rounded(made, name):
    found, page, _ = made[name]
    data = {"fitted": made["fit"], **found}
    if name == "improve":
        # what is measured and tried does not depend on what is done with it
        warm = made["warm"][0]
        data = {**warm, **data, "candidates": warm["candidates"]}
    assert set(f"{ALWAYS} {WANTED[name]}".split()) <= {key for key, _, _ in page.numbers}
    for key, value, text in page.numbers:
        # improve --json has no candidates, and the diagnosis had no second recording
        if not (name == "improve" and "held_out" in key and key.startswith("candidates")):
            expected = looked_up(data, key)
            assert (value if isinstance(expected, str) else float(value)) == expected, key
        if text.startswith("below"):
            assert float(value) < TINY, key
        elif value not in "xyz":
            shown = shown_number(text)
            half_digit = 0.5 * 10.0 ** shown.as_tuple().exponent
            assert abs(float(shown) - float(value)) <= half_digit * 1.0001, (key, text)


def test_every_number_of_an_accelerometer_is_that_of_the_json_and_its_files_keep_their_names(lab):
    noise = random.Random(2)
    lines = [f"{i / 50:.2f},{noise.gauss(1, 0.002):.7f}" for i in range(6000)]
    path = lab.file("angle_random_walk.csv", "\n".join(["time_s,accel_z_g", *lines]) + "\n")
    model = lab.file(
        "accel.toml",
        '[sensor]\ncolumn = "accel_z_g"\n[[effect]]\nkind = "velocity_random_walk"\n'
        "coefficient_m_per_s_per_sqrt_h = 0.2\n",
    )
    page = lab.work / "accel.html"
    data = said("compare", path, "-m", model, "--report", page, statuses=(0, 1))
    data["fitted"] = said("fit", path, "-m", model)["effects"]
    found = {key: float(value) for key, value, _ in Reader(page.read_text("utf-8")).numbers}
    assert found == {key: looked_up(data, key) for key in found}
    shown = re.sub(r"<(script|style).*?</\1>", "", page.read_text("utf-8"), flags=re.DOTALL)
    assert str(path) in shown
    assert not re.search(r"velocity_random_walk\.csv|deg/|deg |force_accel|angle random", shown)
    walk = "fitted.0.parameters.coefficient_m_per_s_per_sqrt_h"
    truth = 0.002 * 9.80665 / math.sqrt(50) * 60  # m/s/sqrt(h)
    assert found[f"{walk}.low"] < truth < found[f"{walk}.high"]


def test_the_verdict_is_that_of_the_json(made):
    verdicts = [made[name][0]["verdict"] for name in ("clean", "warm", "improve")]
    assert verdicts == ["none", "temperature", "temperature"]
    assert "Nothing is missing" in made["clean"][1].verdict
    assert "does not fit" in made["compare"][1].verdict
    estimate = made["warm"][0]["fitted"][2]["parameters"]["coefficient_dps_per_degC"]
    for name in ("warm", "improve"):
        assert "The model lacks temperature" in made[name][1].verdict
        for bound in estimate.values():
            assert f"{bound:.3g}" in made[name][1].verdict


# docs/JSON.md lists every key of the output of --json, and no other.


JSON = (ROOT / "docs/JSON.md").read_text()
COMMANDS = "fit", "compare", "diagnose", "improve"


def table(title):
    """The rows of a table, as cells."""
    section = JSON.split(f"## {title}\n")[1].split("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]


def listed(command):
    """The keys of a command."""
    return {
        key
        for keys, commands, *_ in table("Keys")
        for key in re.findall("`([a-z_]+)`", keys)
        if commands == "all four" or command in commands.split(", ")
    }


def test_every_key_is_listed_and_every_listed_key_is_there(lab):
    model, y = lab.work / "m.toml", 0.02 * np.random.default_rng(3).normal(size=20_000)
    recording = write_csv(lab.work / "rec.csv", of_gyro(y).columns)
    said("fit", recording, "-o", model)
    for command in COMMANDS:
        found = said(command, recording, "-m", model, statuses=(0, 1))
        assert set(found) == listed(command), command


def test_every_answer_and_every_observation_is_listed(lab):
    sources = ROOT / "python/davarlab"
    verdict = (sources / "report/verdict.py").read_text()
    answer = verdict.split("def answer(")[1].split("\ndef ")[0].split('"""')[2]
    assert {row[0].strip("`") for row in table("Answers")} == set(re.findall('"([a-z]+)"', answer))
    text = "".join(path.read_text() for path in sources.rglob("*.py"))
    made = set(re.findall(r'(?:Observation|of_mask)\(\s*"([a-z_]+)"', text)) | {"implausible"}
    assert {row[0].strip("`") for row in table("Observations")} == made
