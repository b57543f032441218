"""Runs the code of docs/PYTHON.md from top to bottom, as in a notebook, and the examples of the
docstrings.
"""

import re
import textwrap

import numpy as np
import pytest
import together
from together import davar

PAGE = together.ROOT / "docs/PYTHON.md"


def test_every_block_runs_with_the_documented_output(elsewhere, capsys):
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    assert len(blocks) > 4
    x = np.random.default_rng(3).normal(0, 0.2, 3000)
    (elsewhere / "flight.csv").write_text(
        together.recording({"time_s": np.arange(3000) / 50, "gyro_z_dps": x})
    )
    there = {}
    for number, block in enumerate(blocks, 1):
        exec(compile(block, f"{PAGE.name}, block {number}", "exec"), there)
    said = capsys.readouterr().out
    assert re.match(r"    0\.01 s  0\.(199|200)\d+ deg/s  \[0\.19\d+, 0\.20\d+\]\n", said)
    before = re.search(r"^([\d.]+) deg/sqrt\(h\) before$", said, re.MULTILINE)
    assert float(before[1]) == pytest.approx(0.2 / 10 * 60, abs=0.06)
    assert "[1.00000e-02 2.62144e+03] s" in said
    walk = re.search(r"^([\d.]+) deg/h/sqrt\(h\) walk$", said, re.MULTILINE)
    assert float(walk[1]) == pytest.approx(1e-5 * 10 * 3600 * 60, rel=0.5)
    assert "0 gaps" in said


def test_the_example_of_the_docstrings_runs(capsys):
    texts = [str(getattr(davar, name).__doc__) for name in davar.__all__]
    (example,) = re.findall(r"^ *```python\n(.*?)^ *```$", "\n".join(texts), re.DOTALL | re.M)
    blocks = np.random.default_rng(4).integers(-50, 50, (4, 1000))
    exec(textwrap.dedent(example), {"davar": davar, "blocks": blocks})
    arw = re.findall(r"\d+\.?\d*", capsys.readouterr().out)
    assert len(arw) == (4000 - 300) // 100  # the last half window needs finish()
