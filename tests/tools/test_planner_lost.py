"""A planned setup with lost samples: to report them never costs more than to hide them."""

import numpy as np
import pytest
from planner_case import compiled, fed
from scipy import signal

pytestmark = pytest.mark.slow
RATE, ARW, LSB, RESULTS = 1000.0, 0.3, 0.001, 300


@pytest.mark.parametrize("percent", (0.2, 1, 5))
def test_reported_losses_keep_the_results(tmp_path, percent):
    words = f"--rate {RATE:g} --lsb {LSB} --bandwidth biquad:100 --core cortex-m4f"
    program = compiled(tmp_path / "setup", f"{words} --lost {max(percent, 1)}")
    random = np.random.default_rng(int(10 * percent))
    size = ARW / 60 * np.sqrt(RATE) / LSB
    noise = random.normal(0, size, 556 * (RESULTS + 16))
    counts = np.rint(signal.lfilter(*signal.butter(2, 200 / RATE), noise)).astype(int)
    whole = fed(program, counts)
    found = fed(program, counts, random.random(len(counts)) < percent / 100)
    assert len(found) >= 0.985 * (1 - percent / 100) * len(whole)  # of the samples that arrive
    present, low, high = found[:, 0], found[:, 2], found[:, 3]
    assert np.mean(present) >= 0.95
    assert np.mean((low <= ARW) & (high >= ARW)) >= 0.91  # results overlap by seven eighths
