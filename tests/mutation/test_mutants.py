"""The tests notice small faults: a sample of mutants of each part, the same every time. A survivor
must be listed with a reason. tools/soak draws a new sample every night.
"""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
@pytest.mark.parametrize(("part", "sample"), [("lib", 60)])
def test_no_mutant_survives_unlisted(part, sample):
    words = ["tools/davar-mutants", "--of", part, "--sample", str(sample), "--unlisted"]
    done = subprocess.run(words, cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
