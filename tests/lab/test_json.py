"""docs/JSON.md lists every key of the output of --json, and no other."""

import json
import re

import asking
import numpy as np
from asking import ROOT

PAGE = (ROOT / "docs/JSON.md").read_text()
COMMANDS = "fit", "compare", "diagnose", "improve"


def table(title):
    """The rows of a table, as cells."""
    section = PAGE.split(f"## {title}\n")[1].split("\n## ")[0]
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
    rate, samples = 50.0, 20_000
    values = 0.02 * np.random.default_rng(3).normal(size=samples)
    recording, model = lab.work / "rec.csv", lab.work / "model.toml"
    rows = "".join(f"{n / rate:.2f},{x:.9f}\n" for n, x in enumerate(values))
    recording.write_text("time_s,gyro_z_dps\n" + rows)
    asking.run("fit", recording, "-o", model)
    for command in COMMANDS:
        done = asking.run(command, recording, "-m", model, "--json")
        assert set(json.loads(done.stdout)) == listed(command), command


def test_every_answer_and_every_observation_is_listed(lab):
    sources = ROOT / "tools/lab/davarlab"
    verdict = (sources / "report/verdict.py").read_text()
    answer = verdict.split("def answer(")[1].split("\ndef ")[0].split('"""')[2]
    assert {row[0].strip("`") for row in table("Answers")} == set(re.findall('"([a-z]+)"', answer))
    text = "".join(path.read_text() for path in sources.rglob("*.py"))
    made = set(re.findall(r'(?:Observation|of_mask)\(\s*"([a-z_]+)"', text)) | {"implausible"}
    assert {row[0].strip("`") for row in table("Observations")} == made
