"""A planned setup with lost samples: to report them never costs more than to hide them."""

import subprocess

import numpy as np
import pytest
from planner_case import run
from scipy import signal

pytestmark = pytest.mark.slow
RATE, ARW, LSB, RESULTS = 1000.0, 0.3, 0.001, 300
PROGRAM = """
#include "davar_setup.h"
#include <stdio.h>
#include <stdlib.h>
int main(void)
{
    char line[32];
    if (davar_setup_start() != DAVAR_OK) {
        return 1;
    }
    while (fgets(line, sizeof line, stdin) != NULL) {
        const int16_t count = (int16_t)atoi(line);
        if (line[0] == 'g') {
            davar_setup_gap(1);
            continue;
        }
        davar_setup_push(&count, 1);
        const davar_result_t *result = davar_setup_take(0);
        if (result != NULL) {
            const davar_coefficient_t *arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printf("%d %g %g %g\\n", arw->present, arw->value, arw->low, arw->high);
        }
    }
    return 0;
}
"""


def compiled(folder, lost):
    words = f"--rate {RATE:g} --lsb {LSB} --bandwidth biquad:100 --core cortex-m4f --lost {lost}"
    done = run([*words.split(), "-o", str(folder), "--self-contained"])
    assert (done.status, done.err) == (0, "")
    (folder / "program.c").write_text(PROGRAM)
    files = ("davar.c", "davar_setup.c", "program.c")
    command = ["gcc", "-std=c11", "-O2", *files, "-lm", "-o", "program"]
    made = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    assert made.returncode == 0, made.stderr
    return folder / "program"


def results(program, counts, lost):
    """(present, value, low, high) of each result. lost: per sample, reported as a gap."""
    lines = ("g" if gone else str(count) for count, gone in zip(counts, lost, strict=True))
    done = subprocess.run([program], input="\n".join(lines), capture_output=True, text=True)
    return np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])


@pytest.mark.parametrize("percent", (0.2, 1, 5))
def test_reported_losses_keep_the_results(tmp_path, percent):
    program = compiled(tmp_path / "setup", max(percent, 1))
    random = np.random.default_rng(int(10 * percent))
    size = ARW / 60 * np.sqrt(RATE) / LSB
    noise = random.normal(0, size, 556 * (RESULTS + 16))
    counts = np.rint(signal.lfilter(*signal.butter(2, 200 / RATE), noise)).astype(int)
    whole = results(program, counts, np.zeros(len(counts), bool))
    found = results(program, counts, random.random(len(counts)) < percent / 100)
    assert len(found) >= 0.985 * (1 - percent / 100) * len(whole)  # of the samples that arrive
    present, _, low, high = found.T
    assert np.mean(present) >= 0.95
    assert np.mean((low <= ARW) & (high >= ARW)) >= 0.91  # results overlap by seven eighths
