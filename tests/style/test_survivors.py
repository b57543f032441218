"""tests/mutation/survivors.txt names code that exists. The part mutants reports a name that no
longer does too, but only after its build.
"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def is_there(file, name, line):
    """The line is in the function, or initialises the variable, of this name."""
    text = (ROOT / file).read_text("utf-8")
    bodies = re.findall(
        rf"^\w[^\n;{{}}]*\b{name}\([^;]*?\)\n\{{\n.*?^\}}", text, re.MULTILINE | re.DOTALL
    )
    code = bodies if bodies else [text] if re.search(rf"\b{name}\b", line) else []
    return any(line in re.sub(r"\s+", " ", one) for one in code)


class Survivors(unittest.TestCase):
    def test_each_is_in_the_function_that_it_names(self):
        listed = (ROOT / "tests/mutation/survivors.txt").read_text("utf-8").splitlines()
        names = [line.split(" | ")[:3] for line in listed if line and not line.startswith("#")]
        self.assertGreater(len(names), 100)
        self.assertEqual([name for name in names if not is_there(*name)], [])


if __name__ == "__main__":
    unittest.main()
