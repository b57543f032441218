#!/usr/bin/env python3
"""Makes demo_disturbance.csv.gz, the bundled recording: simulated, seeded, the same bytes every
time.

White noise with two disturbances on a slow random walk of the bias, on the raster of a sensor.
Standard library only.
"""

import gzip
import io
import math
import random
from pathlib import Path

RATE_HZ = 10
LSB_DPS = 0.001
SAMPLES = 6000
QUIET_ARW = 0.3  # deg/sqrt(h)
RATE_RANDOM_WALK = 2.0  # deg/h/sqrt(h)
# Start (s) and factor of the white noise from there on.
NOISE = ((0, 1.0), (150, 3.0), (250, 1.0), (400, 2.0), (500, 1.0))
TARGET = Path(__file__).with_name("demo_disturbance.csv.gz")


def truth():
    return ", ".join(f"{start}:{QUIET_ARW * factor:g}" for start, factor in NOISE)


HEADER = f"""# description: SIMULATED gyro at rest, made by data/make_demo.py; not a measurement
# seed: 952
# lsb_dps: {LSB_DPS}
# truth_arw_deg_per_sqrt_h: {truth()}
# truth_rrw_deg_per_h_per_sqrt_h: {RATE_RANDOM_WALK}
time_s,gyro_z_dps
"""


def factor_at(time_s):
    return [factor for start, factor in NOISE if start <= time_s][-1]


def rows():
    source = random.Random(952)
    white_dps = QUIET_ARW / 60 * math.sqrt(RATE_HZ)
    walk_dps = RATE_RANDOM_WALK / 216000 / math.sqrt(RATE_HZ)
    bias_dps = 0.12
    for i in range(SAMPLES):
        bias_dps += source.gauss(0, walk_dps)
        rate_dps = bias_dps + factor_at(i / RATE_HZ) * source.gauss(0, white_dps)
        yield f"{i / RATE_HZ:.1f},{LSB_DPS * round(rate_dps / LSB_DPS):.3f}\n"


def content():
    """The file's bytes: gzip without a time or a name."""
    buffer = io.BytesIO()
    with gzip.GzipFile(filename="", mode="wb", fileobj=buffer, mtime=0) as file:
        file.write((HEADER + "".join(rows())).encode())
    return buffer.getvalue()


if __name__ == "__main__":
    TARGET.write_bytes(content())
