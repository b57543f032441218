"""Adds a board step by step after CONTRIBUTING.md, in a copy of the tree: no other file must
change.
"""

import re
import shutil
import subprocess
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.soak

TABLE = "port/bare_metal/boards.json"


def steps():
    """The blocks of the section, in order: (language, text)."""
    section = (
        (ROOT / "CONTRIBUTING.md")
        .read_text(encoding="utf-8")
        .split("## Add a board")[1]
        .split("\n## ")[0]
    )
    return [
        (language, textwrap.dedent(text))
        for language, text in re.findall(
            r"^ *```(\w+)\n(.*?)^ *```$", section, re.DOTALL | re.MULTILINE
        )
    ]


def copy_of_the_tree(tree):
    """The files that git has or would add, without build output."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "-co", "--exclude-standard"],
        cwd=ROOT,
        text=True,
        stdout=subprocess.PIPE,
        check=True,
    ).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():  # deleted, and not yet committed
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, tree / name)


def test_the_steps_of_the_page_add_a_board(tmp_path):
    copy_of_the_tree(tmp_path)
    assert [language for language, _ in steps()] == ["sh", "json", "sh"]
    table = tmp_path / TABLE
    for language, text in steps():
        if language == "json":
            rows = table.read_text().rstrip().removesuffix("}").rstrip()
            table.write_text(f"{rows},\n{text}}}\n")
        else:
            shell = ["bash", "-euo", "pipefail", "-c", text]
            done = subprocess.run(shell, cwd=tmp_path, text=True, capture_output=True)
            assert done.returncode == 0, f"{text}\n{done.stdout}{done.stderr}"
    assert len((tmp_path / "device.csv").read_text().splitlines()) > 50
    help = ["tools/davar-mcu", "--help"]
    done = subprocess.run(help, cwd=tmp_path, text=True, capture_output=True, check=True)
    assert "my-board" in done.stdout
