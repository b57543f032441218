"""The firmware examples of the README and of docs/FIRMWARE.md compile as they stand, without a warning; the first is short enough to be read."""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
LINES_MAX = 30


def examples():
    """The texts of the ```c blocks; each goes on where the one before ended."""
    text = README.read_text(encoding="utf-8") + (ROOT / "docs/FIRMWARE.md").read_text(encoding="utf-8")
    return re.findall(r"^```c\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


class ReadmeExample(unittest.TestCase):
    def setUp(self):
        self.assertTrue(README.exists(), "there is no README.md")
        self.assertTrue(examples(), "README.md has no ```c block")

    def test_the_example_is_short(self):
        self.assertLessEqual(len(examples()[0].splitlines()), LINES_MAX)

    def test_the_examples_compile_without_a_warning(self):
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / "example.c"
            source.write_text("\n".join(examples()), encoding="utf-8")
            done = subprocess.run(["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-I", ROOT / "lib/include", "-c",
                                   source, "-o", Path(folder) / "example.o"],
                                  text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
