"""Makes the figure of docs/FLIGHT.md: picture.py FLIGHT.csv FIGURE.png. Needs matplotlib."""

import csv
import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt

COLOURS = {"bench": "tab:red", "worst": "tab:gray", "fed": "tab:blue", "true": "black"}
WORDS = {"bench": "as on the bench", "worst": "as at worst", "fed": "fed by davar", "true": "truth"}
PANELS = (
    ("arw_deg_per_sqrt_h", "ARW assumed\n[deg/$\\sqrt{h}$]"),
    ("rms_deg", "rms error\n[deg]"),
    ("nees_over_3", "NEES / 3\n(1: consistent)"),
)

with open(sys.argv[1], newline="", encoding="ascii") as file:
    rows = list(csv.DictReader(file))
figure, axes = plt.subplots(len(PANELS), 1, figsize=(9, 6.5), sharex=True, constrained_layout=True)
for panel, (column, label) in zip(axes, PANELS):
    for belief, colour in COLOURS.items():
        own = [row for row in rows if row["belief"] == belief]
        dashes = (
            {"linestyle": "--", "linewidth": 0.9}
            if belief == "true"
            else {
                "linewidth": 3.0 if belief == "fed" else 1.2,
                "alpha": 0.6 if belief == "fed" else 1.0,
            }
        )
        panel.plot(
            [float(row["time_s"]) for row in own],
            [float(row[column]) for row in own],
            color=colour,
            label=WORDS[belief],
            **dashes,
        )
    panel.set_ylabel(label)
    panel.grid(alpha=0.3)
axes[1].set_ylim(0, 0.045)
axes[2].set_yscale("log")
axes[2].set_ylim(0.4, 10)
axes[0].legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.28), frameon=False)
axes[-1].set_xlabel("time [s]")
axes[-1].set_xlim(0, float(rows[-1]["time_s"]))
figure.savefig(sys.argv[2], dpi=95)
