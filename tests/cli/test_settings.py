"""davar-sim rejects a setting exactly if davar_init rejects it. The message has the library's text
and the name of the option. The simulator adds no rule.
"""

import os
import random
import subprocess
import unittest

from sim_case import SimCase

PROBE = os.environ.get("DAVAR_SETTINGS_PROBE", "settings_probe")
POLICIES = ("fixed", "kurtosis", "or", "and", "glr")
TRIALS = 400
BY_CODE = {"--policy": POLICIES, "--mode": ("trailing", "centred"), "--engine": ("auto", "grid")}


def settings(source):
    """Options near the limits of each; davar-sim would choose nearly all of them differently."""
    window = source.choice((2, 4, 5, 60, 79, 80, 81, 100, 599, 600, 601, 6000, 7680, 7690))
    block = source.choice((4, 5, 10, 64, 65))
    near = [window - 1, window, window + 1]
    found = {
        "--policy": source.choice(POLICIES),
        "--mode": source.choice(("centred", "trailing")),
        "--engine": source.choice(("auto", "grid")),
        "--window-max": window,
        "--window-min": max(
            0, source.choice((0, 1, 2, 20, window // 3 * 2, window // 2 * 2, *near))
        ),
        "--segment": max(0, source.choice((0, 1, 10, window // 6, *near))),
        "--grow": source.choice((0, 1, 2, 3)),
        "--shrink": source.choice((0, 1, 2, 3, 64, 2**31 - 1, 2**31)),
        "--stride": max(0, source.choice((0, 1, 7, 10, 2**24, 2**24 + 1, *near))),
        "--block": block,
        "--shock-blocks": source.choice((0, 2, 3)),
        "--long-cluster": source.choice((0, 1, 4 * block, 512, 516)),
        "--kurtosis": source.choice(("0:0", "2.5:3.3", "1:1e300", "1:2e300")),
        "--contribution": source.choice(("0:0.07", "0:2e300")),
        "--taus": source.choice(
            (
                "1",
                "1,2",
                "2,1",
                "1,1",
                "0,1",
                f"1,{max(2, window // 2)}",
                f"1,{window // 2 + 1}",
                "1,4294967295",
            )
        ),
        "--false-alarms-per-hour": source.choice(("0.01", "1e-10", "1e10")),
        "--cut-interval": source.choice(("300", "1e-10", "1e10")),
        "--rate": source.choice(("100", "100", "1e-51", "1e51")),
        "--lsb": source.choice(("0.01", "0.01", "1e-51", "1e51")),
    }
    usual = {
        "--policy": source.choice(POLICIES[:3]),
        "--window-max": 600,
        "--window-min": 400,
        "--segment": 100,
        "--grow": 0,
        "--shrink": 2,
        "--stride": 1,
        "--block": 10,
        "--shock-blocks": 2,
        "--long-cluster": 0,
        "--kurtosis": "2.5:3.3",
        "--contribution": "0:0.07",
        "--taus": "1,2",
        "--engine": "auto",
        "--mode": "centred",
        "--false-alarms-per-hour": "0.01",
        "--cut-interval": "300",
        "--rate": "100",
        "--lsb": "0.01",
    }
    odd = source.sample(sorted(found), source.choice((1, 2, 3, len(found))))
    return {name: found[name] if name in odd else usual[name] for name in usual}


class Settings(SimCase):
    def test_davar_sim_and_init_reject_the_same(self):
        source, recording, refusals = random.Random(31), self.recording(20), set()
        for trial in range(TRIALS):
            options = settings(source)
            words = [
                str(BY_CODE[name].index(value)) if name in BY_CODE else str(value)
                for name, value in options.items()
            ]
            answer = subprocess.run(
                [PROBE, *words], text=True, stdout=subprocess.PIPE, check=True
            ).stdout.strip()
            done = self.sim(
                recording, *(word for pair in options.items() for word in map(str, pair))
            )
            with self.subTest(trial=trial, options=options, init=answer):
                if answer == "ok":
                    self.assertRegex(
                        done.stderr, "samples|windows|epoch|values"
                    )  # only the recording is too short for it
                    self.assertNotRegex(done.stderr, "^davar-sim: --")
                else:
                    refusals.add(answer)
                    self.assert_refused(done, answer)
                    self.assertRegex(done.stderr, "^davar-sim: --[a-z]")
        self.assertGreater(len(refusals), 12, sorted(refusals))


if __name__ == "__main__":
    unittest.main()
