"""The README's firmware example compiles as it stands, without a warning, and is short enough to be read."""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
LINES_MAX = 30


def first_example():
    """The text of the first ```c block."""
    block = re.search(r"^```c\n(.*?)^```$", README.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return block.group(1) if block else None


class ReadmeExample(unittest.TestCase):
    def setUp(self):
        self.assertTrue(README.exists(), "there is no README.md")
        self.example = first_example()
        self.assertIsNotNone(self.example, "README.md has no ```c block")

    def test_the_example_is_short(self):
        self.assertLessEqual(len(self.example.splitlines()), LINES_MAX)

    def test_the_example_compiles_without_a_warning(self):
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / "example.c"
            source.write_text(self.example, encoding="utf-8")
            done = subprocess.run(["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-I", ROOT / "lib/include", "-c",
                                   source, "-o", Path(folder) / "example.o"],
                                  text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
