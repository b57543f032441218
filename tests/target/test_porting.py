"""Adds a board step by step after CONTRIBUTING.md, in a copy of the tree: no other file must
change.
"""

import re
import shutil
import subprocess
import tempfile
import textwrap
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
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


class Porting(unittest.TestCase):
    def test_the_steps_of_the_page_add_a_board(self):
        with tempfile.TemporaryDirectory() as folder:
            tree = Path(folder) / "davar"
            copy_of_the_tree(tree)
            self.assertEqual(["sh", "json", "sh"], [language for language, _ in steps()])
            for language, text in steps():
                if language == "json":
                    table = (tree / TABLE).read_text()
                    (tree / TABLE).write_text(
                        f"{table.rstrip().removesuffix('}').rstrip()},\n{text}}}\n"
                    )
                else:
                    done = subprocess.run(
                        ["bash", "-euo", "pipefail", "-c", text],
                        cwd=tree,
                        text=True,
                        stdout=subprocess.PIPE,
                        stderr=subprocess.STDOUT,
                        check=False,
                    )
                    self.assertEqual(0, done.returncode, f"{text}\n{done.stdout}")
            self.assertGreater(len((tree / "device.csv").read_text().splitlines()), 50)
            help_text = subprocess.run(
                ["tools/davar-mcu", "--help"],
                cwd=tree,
                text=True,
                stdout=subprocess.PIPE,
                check=True,
            ).stdout
            self.assertIn("my-board", help_text)


if __name__ == "__main__":
    unittest.main()
