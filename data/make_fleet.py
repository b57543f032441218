#!/usr/bin/env python3
"""Simulated gyros of two batches, for docs/FLEET.md and the tests: noise that differs from unit to
unit, and in batch B a coefficient of temperature so small that no recording of 30 minutes shows it
beyond doubt.

    build/venv-lab/bin/python data/make_fleet.py OUT/ [--units 500] [--effect 0.0005]
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
from davarlab import simulate
from davarlab.model import Term

ROOT = Path(__file__).resolve().parents[1]

RATE_HZ, SECONDS = 20.0, 1800.0
FIRST_S, SPACING_S = 1767600000, 9000  # 2026-01-05; a unit each two and a half hours
EFFECT_DPS_PER_DEGC = 0.0005


def unit(place, batch, effect, seconds=SECONDS):
    """Columns of one unit: Unix times, the gyro, its thermometer. Seeded by its place."""
    rng = np.random.default_rng([2026, place])
    terms = [
        Term(
            "angle_random_walk",
            {"coefficient_deg_per_sqrt_h": 0.3 * float(np.exp(rng.normal(0, 0.03)))},
        ),
        Term(
            "bias_instability", {"coefficient_deg_per_h": 5.0 * float(np.exp(rng.normal(0, 0.15)))}
        ),
    ]
    if batch == "B":
        terms.append(Term("temperature", {"coefficient_dps_per_degC": effect}))
    made = simulate.make(terms, RATE_HZ, seed=int(rng.integers(1 << 31)), duration_s=seconds)
    return {
        "time_s": FIRST_S + place * SPACING_S + made.columns["time_s"],
        "gyro_z_dps": made.columns["gyro_z_dps"],
        "temp_degC": made.columns["temp_degC"] + rng.normal(0, 2),
    }


def make(folder, units, effect=EFFECT_DPS_PER_DEGC, seconds=SECONDS):
    """Writes OUT/A_0000.parquet .., every other unit of batch B."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for place in range(units):
        batch = "AB"[place % 2]
        pq.write_table(
            pa.table(unit(place, batch, effect, seconds)), folder / f"{batch}_{place:04d}.parquet"
        )


if __name__ == "__main__":
    given = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    given.add_argument("folder")
    given.add_argument("--units", type=int, default=500)
    given.add_argument(
        "--effect", type=float, default=EFFECT_DPS_PER_DEGC, help="of batch B, deg/s per degC"
    )
    options = given.parse_args()
    make(options.folder, options.units, options.effect)
