"""The curve of a simulated week on an emulated Cortex-M0, from 10 ms to a day, beside AllanTools:
the table and the picture of docs/quality/WEEK.md. 60 million samples take minutes and 4 GB.

    python tests/package/week.py docs/week.png

Needs numpy, scipy, matplotlib and AllanTools. test_long_taus.py does the same with an hour.
"""

import csv
import io
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import allantools
import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

ROOT = Path(__file__).resolve().parents[2]
RATE_HZ = 100.0
LSB_DPS = 250 / 32768  # +-250 deg/s in 16 bits
N, B, K = 0.3, 5.0, 1.0  # deg/sqrt(h), deg/h, deg/h/sqrt(h)
CHUNK = 1 << 20
# Gauss-Markov processes of one variance, a factor of four apart in time, add up to flicker. The
# longest is 80 times as long as a day.
MARKOV_S = [0.1 * 4.0**k for k in range(14)]
DAY_S = 86_400
SEED = 20261125
WINDOW = 60_000  # samples of ten minutes, and from one result to the next


def counts_of(samples: int, seed: int) -> Iterator[npt.NDArray[np.int16]]:
    """White noise N, flicker B and a random walk K as counts, in chunks."""
    source = np.random.default_rng(seed)
    white = N / 60 * np.sqrt(RATE_HZ)
    step = K / 3600 / 60 / np.sqrt(RATE_HZ)
    sigma = B / 3600 * np.sqrt(2 * np.log(2) / np.pi)
    memory = np.exp(-1 / (RATE_HZ * np.array(MARKOV_S)))
    state = sigma * source.standard_normal(len(memory))
    walk = 0.0
    for done in range(0, samples, CHUNK):
        count = min(CHUNK, samples - done)
        drift = walk + step * np.cumsum(source.standard_normal(count))
        walk = drift[-1]
        rate = drift + white * source.standard_normal(count)
        for k, share in enumerate(memory):
            drive = sigma * np.sqrt(1 - share**2) * source.standard_normal(count)
            flicker, last = lfilter([1.0], [1.0, -share], drive, zi=[share * state[k]])
            state[k] = last[0] / share
            rate += flicker
        yield np.rint(rate / LSB_DPS).astype(np.int16)


def on_board(
    chunks: Sequence[npt.NDArray[np.int16]], target: str, longest_s: float
) -> dict[str, str]:
    """The newest row of tools/davar-mcu --longest-tau."""
    command = (
        [ROOT / "tools/davar-mcu", "--target", target, "-", "--rate", RATE_HZ, "--lsb", LSB_DPS]
        + ["--bits", 16, "--law", "fixed", "--segment", 0, "--mode", "trailing", "--details"]
        + ["--window-max", WINDOW, "--window-min", WINDOW, "--stride", WINDOW]
        + ["--engine", "grid"]
        + ["--taus", "1,2,4,8,16,32,64", "--bandwidth", "none", "--longest-tau", longest_s]
    )
    board = subprocess.Popen(
        [*map(str, command)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert board.stdin is not None
    board.stdin.write("gyro_z_counts\n")
    for chunk in chunks:
        board.stdin.write("\n".join(map(str, chunk.tolist())) + "\n")
    output, _ = board.communicate()
    assert board.returncode == 0
    return list(csv.DictReader(io.StringIO(output)))[-1]


def allan_deviation(counts: npt.NDArray[np.int16], sizes: Sequence[int]) -> list[float]:
    """AllanTools' overlapping Allan deviation, deg/s."""
    taus = [m / RATE_HZ for m in sizes]
    found, deviation, *_ = allantools.oadev(
        counts * LSB_DPS, rate=RATE_HZ, data_type="freq", taus=taus
    )
    assert np.allclose(found, taus)
    return list(deviation)


def compare(row: dict[str, str], counts: npt.NDArray[np.int16]) -> list[dict[str, float]]:
    """Each size of the row beside AllanTools. `off`: their difference over half the interval."""
    sizes = [int(name[5:]) for name in row if name.startswith("adev_") and name[5:].isdigit()]
    sizes = [m for m in sizes if row[f"adev_{m}"]]
    lines = []
    for m, theirs in zip(sizes, allan_deviation(counts, sizes), strict=True):
        ours, low, high = (float(row[f"adev_{part}{m}"]) for part in ("", "low_", "high_"))
        off = (ours - theirs) / ((high - low) / 2)
        lines.append(
            {"tau_s": m / RATE_HZ, "davar": ours, "low": low, "high": high}
            | {"allantools": theirs, "off": off}
        )
    return lines


def draw(lines: list[dict[str, float]], path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

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
