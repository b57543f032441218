"""The tutorial of docs/WORKBENCH.md: runs its commands, checks the output shown there, and makes
the figures of its report and of the workbench.

build/venv-test/bin/python tools/support/tutorial.py
    runs it, writes docs/lab_report.png, docs/lab_map.png and docs/workbench.png
"""

import io
import re
import shlex
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEADING = "## Tutorial in five commands"


def section() -> str:
    """The part of the page with the tutorial."""
    return (
        (ROOT / "docs/WORKBENCH.md")
        .read_text(encoding="utf-8")
        .split(f"\n{HEADING}\n")[1]
        .split("\n## ")[0]
    )


def block(language: str) -> str:
    """The text of the only fenced block in this language."""
    found = re.findall(rf"^```{language}\n(.*?)^```$", section(), re.DOTALL | re.MULTILINE)
    assert len(found) == 1, f"docs/WORKBENCH.md, {HEADING}: {len(found)} blocks ```{language}"
    return str(found[0])


def commands() -> list[list[str]]:
    return [shlex.split(line) for line in block("sh").splitlines()]


def run(command: Sequence[str], folder: Path) -> str:
    """Runs a command of the tutorial in a folder where build/ may be written; returns what it
    printed.
    """
    (folder / "build").mkdir(exist_ok=True)
    words = [str(ROOT / word) if word.startswith(("tools/", "data/")) else word for word in command]
    done = subprocess.run(words, cwd=folder, text=True, capture_output=True)
    assert done.returncode == 0, (
        f"{shlex.join(command)}: exit status {done.returncode}\n{done.stdout}{done.stderr}"
    )
    return done.stdout


def packed(png: bytes) -> bytes:
    """Reduces an image to a palette, which saves two thirds of the bytes."""
    from PIL import Image

    data = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(
        data, "PNG", optimize=True
    )
    return data.getvalue()


def main() -> None:
    from playwright.sync_api import sync_playwright

    for command in commands():
        run(command, ROOT)
    with sync_playwright() as driver, tempfile.TemporaryDirectory() as folder:
        browser = driver.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1120, "height": 900})
        page.goto((ROOT / "build/missing.html").as_uri())
        height = int(
            page.evaluate("document.getElementById('map').getBoundingClientRect().top + scrollY")
        )
        (ROOT / "docs/lab_report.png").write_bytes(
            packed(
                page.screenshot(
                    full_page=True, clip={"x": 0, "y": 0, "width": 1120, "height": height}
                )
            )
        )
        (ROOT / "docs/lab_map.png").write_bytes(packed(page.locator("#map").screenshot()))
        server = subprocess.Popen(
            [ROOT / "tools/davarlab", "open", "--no-browser"],
            cwd=folder,
            text=True,
            stdout=subprocess.PIPE,
        )
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.set_default_timeout(120_000)
        assert server.stdout
        page.goto(server.stdout.readline().strip())
        page.click("#tutorial")
        page.wait_for_selector(".card:nth-of-type(3) .to:has-text('→')")  # the last error foreseen
        page.mouse.move(0, 0)
        (ROOT / "docs/workbench.png").write_bytes(packed(page.screenshot()))
        browser.close()
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main()
