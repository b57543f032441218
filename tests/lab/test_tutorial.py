"""The tutorial of docs/WORKBENCH.md: its commands run as they stand, in order, and print what it
says they print.
"""

import re
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import tutorial

ROOT = Path(__file__).resolve().parents[2]

COMMANDS = 5
CLOSE = 0.02  # relative: digits may differ between machines, the story may not
PICTURE_BYTES_MAX = 150_000


def interval(text):
    """value, low, high of the first "VALUE ... (95 %: LOW to HIGH" or "VALUE 95 %: LOW .. HIGH"
    about bias instability.
    """
    found = re.search(r"([\d.]+)(?: deg/h)? *\(?\s*95 %: +([\d.]+)\s+(?:to|\.\.)\s+([\d.]+)", text)
    return [float(number) for number in found.groups()]


class Tutorial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.work = Path(folder.name)
        cls.said = {command[1]: tutorial.run(command, cls.work) for command in tutorial.commands()}
        cls.story = " ".join(tutorial.section().split())

    def assert_close(self, shown, printed):
        self.assertEqual(len(shown), len(printed))
        for a, b in zip(shown, printed):
            self.assertLessEqual(abs(a - b), CLOSE * abs(b), (shown, printed))

    def test_it_tells_the_whole_story_in_five_commands(self):
        self.assertEqual(list(self.said), ["simulate", "fit", "diagnose", "improve", "export"])
        self.assertEqual(len(tutorial.commands()), COMMANDS)

    def test_the_table_is_the_one_that_improve_prints(self):
        shown = tutorial.block("text").splitlines()
        printed = self.said["improve"].splitlines()[: len(shown)]
        number = re.compile(r"(?<![\w])\d[\d.]*(?:e-?\d+)?")
        for a, b in zip(shown, printed, strict=True):
            self.assertEqual(number.sub("", a).split(), number.sub("", b).split())
            self.assert_close(
                [float(n) for n in number.findall(a)], [float(n) for n in number.findall(b)]
            )

    def test_the_two_bias_instabilities_are_those_of_fit_and_improve(self):
        for name, sentence in (
            ("fit", r"Bias instability comes out as.*?\)"),
            ("improve", r"Bias instability is now.*?\)"),
        ):
            shown = re.search(sentence, self.story, re.DOTALL).group()
            printed = self.said[name].split("bias_instability\n")[1]
            self.assert_close(interval(shown), interval(printed))

    def test_the_table_for_the_firmware_compiles_and_the_report_is_there(self):
        done = subprocess.run(
            [
                "gcc",
                "-std=c11",
                "-Wall",
                "-Wextra",
                "-Werror",
                "-x",
                "c",
                "-fsyntax-only",
                "-Wno-unused",
                f"-I{ROOT / 'lib/include'}",
                self.work / "build/gyro_model.h",
            ],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn(
            "The model lacks sinusoid",
            (self.work / "build/missing.html").read_text(encoding="utf-8"),
        )

    def test_its_pictures_are_there_and_small(self):
        pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", self.story)
        self.assertEqual(len(pictures), 2)
        for picture in pictures:
            data = (ROOT / "docs" / picture).read_bytes()
            self.assertEqual(data[:4], b"\x89PNG")
            self.assertLess(len(data), PICTURE_BYTES_MAX, picture)

    def test_the_model_file_and_the_effect_of_the_pages_are_accepted(self):
        page = (ROOT / "docs/WORKBENCH.md").read_text(encoding="utf-8")
        model = re.search(r"^```toml\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)[1]
        (self.work / "model.toml").write_text(model, encoding="utf-8")
        tutorial.run(["tools/davarlab", "export", "model.toml", "-o", "table.csv"], self.work)
        design = (ROOT / "tools/lab/DESIGN.md").read_text(encoding="utf-8")
        effect = re.search(r"^    from davarlab\..*\n(?:    .*\n)+", design, re.MULTILINE)[0]
        (self.work / "own.py").write_text(textwrap.dedent(effect), encoding="utf-8")
        kinds = tutorial.run(["tools/davarlab", "effects", "--effects", "own.py"], self.work)
        self.assertRegex(kinds, r"(?m)^supply: (.*\n){3}  coefficient_dps_per_V ")


if __name__ == "__main__":
    unittest.main()
