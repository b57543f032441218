"""Runs the code of docs/PYTHON.md from top to bottom, as in a notebook, and the examples of the
docstrings.
"""

import contextlib
import io
import re
import textwrap
import unittest
from pathlib import Path

import davar
import numpy as np
import together

PAGE = together.ROOT / "docs/PYTHON.md"


class Page(unittest.TestCase):
    def test_every_block_runs_with_the_documented_output(self):
        blocks = re.findall(
            r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
        )
        self.assertGreater(len(blocks), 4)
        there, said = {}, io.StringIO()
        with together.elsewhere(), contextlib.redirect_stdout(said):
            x = np.random.default_rng(3).normal(0, 0.2, 3000)
            Path("flight.csv").write_text(
                together.recording({"time_s": np.arange(3000) / 50, "gyro_z_dps": x})
            )
            for number, block in enumerate(blocks, 1):
                exec(compile(block, f"{PAGE.name}, block {number}", "exec"), there)
        self.assertRegex(
            said.getvalue(), r"^    0\.01 s  0\.(199|200)\d+ deg/s  \[0\.19\d+, 0\.20\d+\]\n"
        )
        before = float(
            re.search(r"^([\d.]+) deg/sqrt\(h\) before$", said.getvalue(), re.MULTILINE)[1]
        )
        self.assertAlmostEqual(before, 0.2 / 10 * 60, delta=0.06)
        self.assertIn("[1.00000e-02 2.62144e+03] s", said.getvalue())
        walk = re.search(r"^([\d.]+) deg/h/sqrt\(h\) walk$", said.getvalue(), re.MULTILINE)
        self.assertAlmostEqual(float(walk[1]) / (1e-5 * 10 * 3600 * 60), 1, delta=0.5)
        self.assertIn("0 gaps", said.getvalue())

    def test_the_examples_of_the_docstrings_run(self):
        texts = [str(getattr(davar, name).__doc__) for name in davar.__all__]
        examples = re.findall(r"^ *```python\n(.*?)^ *```$", "\n".join(texts), re.DOTALL | re.M)
        self.assertEqual(1, len(examples))
        blocks = np.random.default_rng(4).integers(-50, 50, (4, 1000))
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(textwrap.dedent(examples[0]), {"davar": davar, "blocks": blocks})
        arw = re.findall(r"\d+\.?\d*", said.getvalue())
        self.assertEqual((4000 - 300) // 100, len(arw))  # the last half window needs finish()


if __name__ == "__main__":
    unittest.main()
