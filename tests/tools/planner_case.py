"""Plans of tools/davar-plan in this process."""

import io
import json
import math
import os
import shlex
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import c_library
import numpy as np
from scipy import signal

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "python"))
from planner import __main__ as command_line  # noqa: E402
from planner import choice, costs, programs, wishes  # noqa: E402

SIM = os.environ.get("DAVAR_SIM", str(ROOT / "build/tools/host_sim/davar-sim"))
# The example of issue 34: it once took a dozen builds to fit it.
EXAMPLE = (
    "--rate 1000 --axes 3 --type int16 --lsb 0.061 --bandwidth 250:2 --respond 2 "
    "--longest-tau 1000 --ram 20k --flash 24k --core cortex-m4f"
)
USUAL = "--rate 100 --lsb 0.05 --bandwidth 33:2 --core cortex-m0"


class Done(NamedTuple):
    status: int
    out: str
    err: str


@cache
def built():
    """Builds davar-plan and davar-promise if they do not exist."""
    if not programs.PROMISE.exists():
        subprocess.run([ROOT / "tools/davar-plan", "--help"], check=True, capture_output=True)


def run(words):
    """A command line, as the list of its words."""
    built()
    out, err = io.StringIO(), io.StringIO()
    with (
        redirect_stdout(out),
        redirect_stderr(err),
        mock.patch.object(sys, "argv", ["davar-plan", *words]),
    ):
        status = command_line.main()
    return Done(status, out.getvalue(), err.getvalue())


@cache
def command(text):
    """The same, as one text. It writes nothing."""
    return run(shlex.split(text))


def planned(text):
    """The plan as JSON."""
    done = command(f"{text} --json")
    assert (done.status, done.err) == (0, ""), done
    return json.loads(done.out)


def refused(text):
    """The object of --json for wishes that are impossible."""
    done = command(f"{text} --json")
    assert (done.status, done.err) == (1, ""), done
    return json.loads(done.out)


@cache
def smallest(text, option, figure):
    """The smallest figure of any plan for the wishes. Below it there is none."""
    least = planned(text)[figure]
    while (done := command(f"{text} {option} {least - 1} --json")).status == 0:
        assert json.loads(done.out)[figure] < least
        least = json.loads(done.out)[figure]
    return least


@cache
def plan_of(text):
    """The plan as an object."""
    built()
    return choice.plan(wishes.read(shlex.split(text), costs.cores()).wishes)


def write(text, folder):
    """Writes the files of a plan."""
    for name, content in command_line.files(plan_of(text), f"tools/davar-plan {text}").items():
        (folder / name).write_text(content, encoding="utf-8")


def gcc(folder, *options, compiler="gcc"):
    """Runs the compiler in a folder. Returns its complaints."""
    language = "-std=c++17" if compiler == "g++" else "-std=c11"
    places = [*c_library.FLAGS, f"-I{ROOT / 'tests/support'}"]
    words = [compiler, language, *places, f"-I{folder}", *map(str, options)]
    done = subprocess.run(words, text=True, capture_output=True, check=False, cwd=folder)
    assert bool(done.returncode) == ("error" in done.stderr), done.stderr
    return done.stderr


def printed_by(program):
    return subprocess.run(program, text=True, capture_output=True, check=True).stdout


def after_two_poles(cutoff, count, noise):
    """White noise of N = 1 per root sample after a Butterworth low-pass of two poles with its -3 dB
    frequency at `cutoff` of the sample rate: ARMA(2, 1) with the autocovariance of the sampled
    output, exp(-a k) (cos a k + sin a k).
    """
    a = 2 * math.pi * cutoff / math.sqrt(2)
    lags = np.arange(1000)
    half = np.exp(-a * lags) * (np.cos(a * lags) + np.sin(a * lags))
    covariance = np.concatenate([half[:0:-1], half])
    taps = np.array([1, -2 * math.exp(-a) * math.cos(a), math.exp(-2 * a)])
    moving = np.convolve(np.convolve(covariance, taps), taps[::-1])
    centre = len(moving) // 2
    ratio = moving[centre + 1] / moving[centre]
    theta = (1 - math.sqrt(1 - 4 * ratio**2)) / (2 * ratio)
    size = math.sqrt(moving[centre] / (1 + theta**2) / covariance.sum())
    shocks = noise.normal(0, size, count + 1000)
    return signal.lfilter([1, theta], taps, shocks)[1000:]


# A line per result of the first axis: present, value, low, high, noise, unstable.
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
        int16_t counts[DAVAR_SETUP_AXES];
        for (int axis = 0; axis < DAVAR_SETUP_AXES; axis++) {
            counts[axis] = (int16_t)atoi(line);
        }
        if (line[0] == 'g') {
            davar_setup_gap(1);
            continue;
        }
        davar_setup_push(counts, 1);
        const davar_result_t *result = davar_setup_take(0);
        if (result != NULL) {
            const davar_coefficient_t *arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printf("%d %g %g %g %d %d\\n", arw->present, arw->value, arw->low, arw->high,
                   (int)result->noise, result->unstable);
        }
    }
    return 0;
}
"""


def compiled(folder, words):
    """A program with the setup for these words, in a new folder."""
    done = run([*words.split(), "-o", str(folder), "--self-contained"])
    assert (done.status, done.err) == (0, "")
    (folder / "program.c").write_text(PROGRAM)
    files = ("davar.c", "davar_setup.c", "program.c")
    command = ["gcc", "-std=c11", "-O2", *files, "-lm", "-o", "program"]
    made = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    assert made.returncode == 0, made.stderr
    return folder / "program"


def fed(program, counts, lost=None):
    """The lines that it prints. lost: per sample, reported as a gap."""
    gone = np.zeros(len(counts), bool) if lost is None else lost
    lines = ("g" if missing else str(count) for count, missing in zip(counts, gone, strict=True))
    done = subprocess.run([program], input="\n".join(lines), capture_output=True, text=True)
    return np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
