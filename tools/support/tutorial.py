"""The tutorial of README.md: its commands, what it shows of their output, and its two pictures.

    build/venv-lab/bin/python tools/support/tutorial.py    runs the commands, writes docs/lab_report.png and docs/lab_map.png
"""

import io
import re
import shlex
import subprocess
from pathlib import Path

from browser import Browser

ROOT = Path(__file__).resolve().parents[2]
HEADING = "## Which effect is missing"


def section():
    """The part of README.md that tells the story."""
    return (ROOT / "README.md").read_text(encoding="utf-8").split(f"\n{HEADING}\n")[1].split("\n## ")[0]


def block(language):
    """The text of its one fenced block of this language."""
    found = re.findall(rf"^```{language}\n(.*?)^```$", section(), re.DOTALL | re.MULTILINE)
    assert len(found) == 1, f"README.md, {HEADING}: {len(found)} blocks ```{language}"
    return found[0]


def commands():
    return [shlex.split(line) for line in block("sh").splitlines()]


def run(command, folder):
    """Runs a command of the tutorial in a folder where build/ may be written; returns what it printed."""
    (folder / "build").mkdir(exist_ok=True)
    words = [str(ROOT / word) if word.startswith(("tools/", "data/")) else word for word in command]
    done = subprocess.run(words, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, f"{shlex.join(command)}: exit status {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def packed(png):
    """The same picture in a palette: a third of the bytes."""
    from PIL import Image
    data = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(data, "PNG", optimize=True)
    return data.getvalue()


def main():
    for command in commands():
        run(command, ROOT)
    with Browser() as browser:
        page = browser.open(ROOT / "build/missing.html", width=1120)
        height = int(page.evaluate("document.getElementById('map').getBoundingClientRect().top + scrollY"))
        (ROOT / "docs/lab_report.png").write_bytes(packed(page.screenshot(height=height)))
        (ROOT / "docs/lab_map.png").write_bytes(page.screenshot(element="#map figure img"))


if __name__ == "__main__":
    main()
