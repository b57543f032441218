"""The library's detector decides like the reference in doubles, on many kinds of signal."""

import math
import os
import random
import subprocess
import unittest

from reference import Detector

PROBE = os.environ.get("DAVAR_TRACK_PROBE", "davar-track-probe")
BLOCKS = 1500


def levels(name, rng):
    """sigma of each block."""
    for n in range(BLOCKS):
        yield {
            "white": 20,
            "half a count": 0.5,
            "full scale": 60000,
            "heavy": 20,
            "gaps": 20,
            "step x1.25": 20 * 1.25 ** (n // 300),
            "step x2": 20 * 2 ** (n // 300),
            "step x3 and back": 20 * 3 ** (n // 200 % 2),
            "step to a tenth": 200 * 0.1 ** (n // 500),
            "ramp": 20 * math.exp(0.01 * (n % 300)),
            "sine": 20 * (1 + 0.7 * math.sin(n / 40)),
            "bursts": 60 if n % 97 < 5 else 20,
            "zeros": 0,
            "shocks": 20,
            "long shocks": 20,
            "stuck": 0 if 300 < n % 700 < 400 else 20,
            "jumps": 20 * math.exp(2 * rng.gauss(0, 1)) if n % 50 == 0 else 20,
        }[name]


KINDS = (
    "white",
    "half a count",
    "full scale",
    "heavy",
    "gaps",
    "step x1.25",
    "step x2",
    "step x3 and back",
    "step to a tenth",
    "ramp",
    "sine",
    "bursts",
    "zeros",
    "shocks",
    "long shocks",
    "stuck",
    "jumps",
)


def blocks(name, size, seed):
    """Samples block by block; None is a gap."""
    rng = random.Random(f"{name} {seed}")
    for n, sigma in enumerate(levels(name, rng)):
        tail = [math.sqrt(rng.expovariate(1)) if name == "heavy" else 1 for _ in range(size)]
        samples = [round(max(-32768, min(32767, 7 + t * sigma * rng.gauss(0, 1)))) for t in tail]
        if (name == "shocks" and n % 61 == 60) or (name == "long shocks" and n % 83 > 81 - n % 3):
            samples[size // 2] = 900
        yield None if name == "gaps" and rng.random() < 0.05 else samples


def probe(size, shock, per_hour, stream):
    text = [f"{size} {shock} {per_hour}"] + [
        "gap" if s is None else f"{sum(s)} {sum(x * x for x in s)}" for s in stream
    ]
    done = subprocess.run(
        [PROBE], input="\n".join(text), text=True, capture_output=True, check=True
    )
    first, *rest = done.stdout.splitlines()
    return [float(x) for x in first.split()], [[int(x) for x in line.split()] for line in rest]


class Reference(unittest.TestCase):
    def decide(self, name, size, shock, seed):
        """Blocks up to the first decision that rounding may change, or all; number of alarms."""
        stream = list(blocks(name, size, seed))
        thresholds, answers = probe(size, shock, 0.1, stream)
        reference, alarms = Detector(size, shock, 0.1), 0
        self.assertAlmostEqual(thresholds[0], reference.h_alarm, places=3)
        self.assertAlmostEqual(thresholds[1], reference.h_cut, places=3)
        for n, (samples, answer) in enumerate(zip(stream, answers)):
            if samples is None:
                reference.skip()
            else:
                reference.push(
                    12 * (size * sum(x * x for x in samples) - sum(samples) ** 2) + reference.floor
                )
            centred = reference.centred()
            expected = [
                reference.dropped,
                int(reference.is_alarm),
                len(reference.b),
                reference.cut.at,
                reference.alarm.at,
                reference.trailing(),
                *(centred or ()),
            ]
            _, dropped, _, alarm, now, cut, last, f, _, begin, _, is_there, left, right = answer
            got = [dropped, alarm, now, cut, last, begin, *((left, right) if is_there else ())]
            if got != expected and reference.margin < 1:
                return n, alarms
            self.assertEqual(
                got,
                expected,
                f"{name}, K {size}, seed {seed}, block {n}, margin {reference.margin}",
            )
            self.assertLess(abs(f / 4096 - reference.dispersion()), 0.01)
            alarms += alarm
        return BLOCKS, alarms

    def test_every_kind_of_signal(self):
        total = runs = alarms = 0
        for name in KINDS:
            for size, shock, seed in ((10, 2, 1), (10, 0, 2), (25, 2, 3), (10, 1, 4)):
                done, seen = self.decide(name, size, shock, seed)
                total, runs, alarms = total + done, runs + 1, alarms + seen
        print(
            f"{total} of {runs * BLOCKS} blocks before a decision that rounding may "
            f"turn; {alarms} alarms"
        )
        self.assertGreater(total, 0.8 * runs * BLOCKS)
        self.assertGreater(alarms, 100)


if __name__ == "__main__":
    unittest.main()
