"""davar-sim rejects a setting exactly if davar_init rejects it. The message has the library's text
and the name of the option. The simulator adds three rules, those of centred windows.
"""

import os
import random
import re
import subprocess

import pytest
from sim_case import assert_refused, recording, sim

PROBE = os.environ.get("DAVAR_SETTINGS_PROBE", "settings_probe")
LAWS = ("fixed", "kurtosis", "or", "and", "glr")
BY_CODE = {"--law": LAWS, "--engine": ("auto", "grid")}
TAUS = ("1", "1,2", "2,1", "1,1", "0,1", "1,4294967295")
# In the order of settings_probe: the usual value, and values near the limits. W is the longest
# window and B the block; davar-sim would choose nearly all of them differently.
OPTIONS = {
    "--law": ("or", LAWS),
    "--window-max": (600, (2, 4, 5, 60, 79, 80, 81, 100, 599, 600, 601, 6000, 7680, 7690)),
    "--window-min": (400, (0, 1, 2, 20, "W//3*2", "W//2*2", "W-1", "W", "W+1")),
    "--segment": (100, (0, 1, 10, "W//6", "W-1", "W", "W+1")),
    "--grow": (0, (0, 1, 2, 3)),
    "--shrink": (2, (0, 1, 2, 3, 64, 2**31 - 1, 2**31)),
    "--stride": (1, (0, 1, 7, 10, 2**24, 2**24 + 1, "W-1", "W", "W+1")),
    "--block": (10, (4, 5, 10, 64, 65)),
    "--shock-blocks": (2, (0, 2, 3)),
    "--kurtosis": ("2.5:3.3", ("0:0", "2.5:3.3", "1:1e300", "1:2e300")),
    "--contribution": ("0:0.07", ("0:0.07", "0:2e300")),
    "--taus": ("1,2", (*TAUS, "1,{max(2,W//2)}", "1,{W//2+1}")),
    "--engine": ("auto", ("auto", "grid")),
    "--false-alarms-per-hour": ("0.01", ("0.01", "1e-10", "1e10")),
    "--cut-interval": ("300", ("300", "1e-10", "1e10")),
    "--rate": ("100", ("100", "1e-51", "1e51")),
    "--lsb": ("0.01", ("0.01", "1e-51", "1e51")),
}


def refused_centred(options):
    """The words of davar-sim about a setting that the library accepts; None: centred windows accept
    it too.
    """
    if options["--law"] == "glr":
        return "not for --law glr"
    if int(options["--window-max"]) % 2 or int(options["--window-min"]) % 2:
        return "odd in centred mode"
    steps = {options["--grow"], options["--shrink"]}
    return None if steps <= {"0", "2"} else "would move a window edge backwards"


def settings(source):
    odd = source.sample(sorted(OPTIONS), source.choice((1, 2, 3, len(OPTIONS))))
    chosen = {
        name: source.choice(near) if name in odd else usual
        for name, (usual, near) in OPTIONS.items()
    }
    if "--law" not in odd:
        chosen["--law"] = source.choice(LAWS[:3])
    known = {"W": chosen["--window-max"], "B": chosen["--block"], "max": max}
    for name, value in chosen.items():
        if isinstance(value, str) and re.search("[WB]", value):
            expression = f'f"{value}"' if name == "--taus" else value
            chosen[name] = eval(expression, known)
    return {name: str(value) for name, value in chosen.items()}


@pytest.mark.parametrize("trials", [150, pytest.param(400, marks=pytest.mark.slow)])
def test_davar_sim_and_init_reject_the_same(tmp_path, trials):
    source, path, refusals = random.Random(32), recording(tmp_path, 20), set()
    for _ in range(trials):
        options = settings(source)
        words = [
            str(BY_CODE[name].index(value)) if name in BY_CODE else value
            for name, value in options.items()
        ]
        answer = subprocess.run([PROBE, *words], text=True, stdout=subprocess.PIPE, check=True)
        answer = answer.stdout.strip()
        mode = source.choice(("centred", "trailing"))
        done = sim(path, "--mode", mode, *(word for pair in options.items() for word in pair))
        if answer == "ok" and mode == "centred":
            answer = refused_centred(options) or "ok"
        if answer == "ok":  # only the recording is too short for it
            assert re.search("samples|windows|epoch|values", done.stderr), options
            assert not done.stderr.startswith("davar-sim: --"), options
        else:
            refusals.add(answer)
            assert_refused(done, answer)
            assert re.match("davar-sim: --[a-z]", done.stderr), options
    assert len(refusals) > 12, sorted(refusals)
