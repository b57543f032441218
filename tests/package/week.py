"""The curve of a simulated week on an emulated Cortex-M0, from 10 ms to a day, beside AllanTools:
the table and the picture of docs/FIRMWARE.md. 60 million samples take minutes and 4 GB.

    python tests/package/week.py docs/week.png

Needs numpy, scipy, matplotlib and AllanTools.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from curve import RATE_HZ, B, K, N, compare, counts_of, on_board

DAY_S = 86_400
SEED = 20261125


def draw(lines: list[dict[str, float]], path: Path) -> None:
    tau, ours, theirs = (
        np.array([line[name] for line in lines]) for name in ("tau_s", "davar", "allantools")
    )
    low, high = (np.array([line[name] for line in lines]) for name in ("low", "high"))
    figure, axes = plt.subplots(figsize=(7.5, 4.5), constrained_layout=True)
    axes.fill_between(tau, 3600 * low, 3600 * high, alpha=0.3, label="davar, 95 % interval")
    axes.plot(tau, 3600 * ours, "o-", markersize=4, label="davar on a Cortex-M0")
    axes.plot(tau, 3600 * theirs, "kx", label="AllanTools, the whole week")
    parts = {
        f"N {N:g} deg/sqrt(h)": 60 * N / np.sqrt(tau),
        f"B {B:g} deg/h": np.full_like(tau, B * np.sqrt(2 * np.log(2) / np.pi)),
        f"K {K:g} deg/h/sqrt(h)": K / 60 * np.sqrt(tau / 3),
    }
    for name, line in parts.items():
        axes.plot(tau, line, "--", linewidth=0.8, label=name)
    axes.set(
        xscale="log", yscale="log", xlabel="averaging time, s", ylabel="Allan deviation, deg/h"
    )
    axes.set_ylim(1, 300)
    axes.grid(visible=True, which="both", linewidth=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=110)


def main() -> int:
    chunks = list(counts_of(int(7 * DAY_S * RATE_HZ), SEED))
    row = on_board(chunks, "cortex-m0", DAY_S)
    lines = compare(row, np.concatenate(chunks))
    print("| tau, s | davar, deg/h | 95 % interval | AllanTools | difference / half width |")
    print("|---|---|---|---|---|")
    for line in lines:
        ours, low, high, theirs = (
            3600 * line[name] for name in ("davar", "low", "high", "allantools")
        )
        print(
            f"| {line['tau_s']:.6g} | {ours:.4g} | {low:.4g} to {high:.4g} | {theirs:.4g} "
            f"| {line['off']:+.2f} |"
        )
    for name in (
        "arw_deg_per_sqrt_h",
        "arw_low_deg_per_sqrt_h",
        "arw_high_deg_per_sqrt_h",
        "bi_deg_per_h",
        "rrw_deg_per_h_per_sqrt_h",
        "rrw_upper_deg_per_h_per_sqrt_h",
    ):
        print(name, row[name])
    draw(lines, Path(sys.argv[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
