"""Random results, the packets that telemetry_probe makes of them, and what a receiver must find.

The expected values are computed from the results with numpy, not with code of davar.
DAVAR_DIALECTS=N in the environment: N messages of each type, instead of 20 000, where the test is
marked slow.
"""

import math
import os
import struct
import subprocess

import numpy as np
import pytest

PROBE = os.environ.get("DAVAR_TELEMETRY_PROBE", "telemetry_probe")
RATE_HZ = 99.3
MANY = int(os.environ.get("DAVAR_DIALECTS", "20000"))
MESSAGES = [1000, pytest.param(MANY, marks=pytest.mark.slow)]  # of each type
BATCH = 10_000
RECORD = np.dtype(
    [
        ("coefficient", "f8", (5, 3)),  # QN, ARW, BI, RRW, RR: value, low, high
        ("kurtosis", "f8"),
        ("epoch", "u8"),
        ("time_us", "u8"),
        ("window_samples", "u4"),
        ("noise", "u1"),
        ("unstable", "u1"),
        ("young", "u1"),
        ("alarm", "u1"),
        ("floor", "f4", 3),  # value, low, high
        ("floor_why", "u4"),
    ]
)
QN, ARW, BI, RRW, RR = range(5)
# The quantities in the order that every dialect lists them: (coefficient, column).
LISTED = [(kind, column) for kind in (ARW, BI, RRW) for column in range(3)] + [(RR, 0), (QN, 0)]
NAMES = "XYZ3456789"
SPECIAL = (np.nan, -np.nan, np.inf, -np.inf, 0.0, -0.0, -1.0, 1e-30, 1e-31, 1e30, 1e31, 5e-324)


LEAST, MOST = float(np.float32(1e-30)), float(np.float32(1e30))


def results(seed, count):
    """`count` random results: any magnitude of a sensor, and one in ten numbers special."""
    source = np.random.default_rng(seed)
    made = np.zeros(count, RECORD)

    def numbers(shape):
        found = 10.0 ** source.uniform(-32, 32, shape)
        usual = source.random(shape) < 0.8
        found[usual] = 10.0 ** source.uniform(-7, 7, np.count_nonzero(usual))
        special = source.random(shape) < 0.1
        found[special] = source.choice(SPECIAL, np.count_nonzero(special))
        return found

    made["coefficient"], made["kurtosis"] = numbers((count, 5, 3)), numbers(count)
    for name, bits in (("epoch", 64), ("time_us", 64), ("window_samples", 32)):
        whole = source.integers(0, 2**bits, count, dtype=np.uint64)
        made[name] = whole >> source.integers(0, bits, count, dtype=np.uint64)
    with np.errstate(over="ignore"):
        made["floor"] = numbers((count, 3)).astype("f4")
    made["floor_why"] = source.integers(0, 7, count)
    made["noise"] = source.integers(0, 6, count)
    for name in ("unstable", "young", "alarm"):
        made[name] = source.integers(0, 2, count)
    return made


def batches(count):
    """(results, channel) that make `count` results at least, with every channel."""
    number = 10 * math.ceil(count / 10 / BATCH)
    for seed in range(number):
        yield results(seed, math.ceil(count / number)), seed % 10


def packets(dialect, made, channel=0, node=42, system=7, subject=3700, floor=0):
    """[(identifier, data)] of results."""
    output = subprocess.run(
        [PROBE, dialect, *map(str, (channel, node, system, subject, RATE_HZ, floor))],
        input=made.tobytes(),
        stdout=subprocess.PIPE,
        check=True,
    ).stdout
    found, at = [], 0
    while at < len(output):
        identifier, length = struct.unpack_from("<IB", output, at)
        found.append((identifier, output[at + 5 : at + 5 + length]))
        at += 5 + length
    return found


def sent(values, limit=False):
    """float32 of the values as davar/can.h states: what is no magnitude is NaN, below
    1e-30 is 0, above 1e30 is NaN or, for an upper limit, infinity.
    """
    with np.errstate(invalid="ignore", over="ignore", under="ignore"):
        found = np.where(values >= 0, values, np.nan)
        found = np.where(found > MOST, np.inf if limit else np.nan, found)
        return np.where(found < LEAST, 0.0, found).astype("f4")


def quantities(made):
    """The 13 quantities of each result, as float32."""
    rows = [sent(made["coefficient"][:, kind, column], column == 2) for kind, column in LISTED]
    rate = np.full(len(made), RATE_HZ, "f4")
    return np.stack([*rows, sent(made["kurtosis"]), rate], axis=1)


def state(made):
    return made["noise"] + 8 * made["unstable"] + 16 * made["young"] + 32 * made["alarm"]


def mismatches(wanted, found):
    """The number of mismatches between arrays of float32. NaN equals NaN, and -0 is not 0."""
    wanted, found = np.asarray(wanted, "f4"), np.asarray(found, "f8")
    assert wanted.shape == found.shape, (wanted.shape, found.shape)
    exact = found.astype("f4").astype("f8")
    equal = (wanted == found) & (np.signbit(wanted) == np.signbit(found)) & (exact == found)
    return int(np.count_nonzero(~(equal | (np.isnan(wanted) & np.isnan(found)))))
