"""The tutorial of docs/WORKBENCH.md: its commands run as they stand, in order, and print what it
says they print.
"""

import re
import subprocess
import textwrap

import pytest
import tutorial
from asking import ROOT

CLOSE = 0.02  # relative: digits may differ between machines, the story may not
PICTURE_BYTES_MAX = 150_000
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    return tmp_path_factory.mktemp("tutorial")


def story():
    return " ".join(tutorial.section().split())


def size(text):
    """[value] of bias instability in a sentence or a table, or [value, low, high] where
    "(95 %: LOW to HIGH" or "95 %: LOW .. HIGH" follows.
    """
    limits = r"(?:\s*\(?\s*95 %: +([\d.]+)\s+(?:to|\.\.)\s+([\d.]+))?"
    found = re.search(rf"(?:is now |out as |_deg_per_h +)([\d.]+)(?:\s+deg/h)?{limits}", text)
    return [float(number) for number in found.groups() if number]


def test_the_whole_story(work):
    """One run of its five commands; what the page shows is what they print."""
    said = {command[1]: tutorial.run(command, work) for command in tutorial.commands()}
    assert list(said) == ["simulate", "fit", "diagnose", "improve", "export"]
    shown = tutorial.block("text").splitlines()
    number = re.compile(r"(?<![\w])\d[\d.]*(?:e-?\d+)?")
    for a, b in zip(shown, said["improve"].splitlines()[: len(shown)], strict=True):
        assert number.sub("", a).split() == number.sub("", b).split()
        numbers = [[float(n) for n in number.findall(line)] for line in (a, b)]
        assert numbers[0] == pytest.approx(numbers[1], rel=CLOSE)
    # a model that does not fit has no interval
    for name, sentence, numbers in (
        ("fit", "Bias instability comes out as.*", 1),
        ("improve", "Bias instability is now.*", 3),
    ):
        told = size(re.search(sentence, story()).group())
        assert len(told) == numbers
        assert told == pytest.approx(size(said[name].split("bias_instability\n")[1]), rel=CLOSE)
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-xc", "-fsyntax-only", "-Wno-unused"]
    places = [f"-I{ROOT / place}" for place in ("lib/include", "addons/monitor/include")]
    subprocess.run(["gcc", *flags, *places, work / "build/gyro_model.h"], check=True)
    missing = (work / "build/missing.html").read_text(encoding="utf-8")
    assert "The model lacks sinusoid" in missing
    improved = next(command for command in tutorial.commands() if command[1] == "improve")
    better = (work / improved[improved.index("-o") + 1]).read_text()
    assert better.startswith("# Added to the given model: sinusoid and temperature. With the ")


def test_its_pictures_are_there_and_small():
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", story())
    assert len(pictures) == 2
    for picture in pictures:
        data = (ROOT / "docs" / picture).read_bytes()
        assert data[:4] == b"\x89PNG"
        assert len(data) < PICTURE_BYTES_MAX, picture


def test_the_model_file_and_the_effect_of_the_pages_are_accepted(work):
    page = (ROOT / "docs/WORKBENCH.md").read_text(encoding="utf-8")
    model = re.search(r"^```toml\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)[1]
    (work / "model.toml").write_text(model, encoding="utf-8")
    tutorial.run(["tools/davarlab", "export", "model.toml", "-o", "table.csv"], work)
    design = (ROOT / "python/davarlab/DESIGN.md").read_text(encoding="utf-8")
    effect = re.search(r"^    from davarlab\..*\n(?:    .*\n)+", design, re.MULTILINE)[0]
    (work / "own.py").write_text(textwrap.dedent(effect), encoding="utf-8")
    kinds = tutorial.run(["tools/davarlab", "effects", "--effects", "own.py"], work)
    assert re.search(r"(?m)^supply: (.*\n){3}  coefficient_dps_per_V ", kinds)
