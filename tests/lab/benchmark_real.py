"""What davarlab says of every axis of every recording in $DAVAR_REAL_DATA (default:
shared/data/real beside the repository), from N and B read off the Allan deviation. A table in
Markdown, and how many axes reach the goals (tools/davarlab effects makes the environment):

    build/venv-lab/bin/python tests/lab/benchmark_real.py [--axis "ADIS16405 run 1 z" ...]
        [--jobs N] [--out TABLE.md]
"""

import argparse
import gzip
import multiprocessing
import os
import tempfile
import time
from collections import Counter
from pathlib import Path

import asking
import numpy as np
from real_recordings import RECORDINGS, judgement
from scipy import signal, stats

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real"))
HALF_DECADE = np.sqrt(10)
BASE = {"angle_random_walk", "bias_instability"}


def rows_of(real):
    """(header, lines) of the stretch, without the comment lines: davarlab gets only the numbers."""
    with gzip.open(FOLDER / real.file, "rt") as file:
        header, *lines = (line for line in file if not line.startswith("#"))
    if real.first_s is not None:
        lines = [line for line in lines if float(line.split(",", 1)[0]) < real.first_s]
    return header, lines


def segments(real, t, gyro):
    """Ranges of samples without a gap and at rest. Turns as an expert cuts them: the rate of any
    axis, averaged over 0.25 s, more than 0.25 deg/s from its median, and 1.2 s on either side.
    """
    cut = np.zeros(len(t), bool)
    for start, stop in real.events:
        cut |= (t >= start) & (t < stop)
    if real.turns:
        rate = 1 / np.median(np.diff(t))
        quarter = np.ones(int(rate / 4)) / int(rate / 4)
        mean = [np.convolve(axis - np.median(axis), quarter, "same") for axis in gyro]
        moving = (np.abs(mean) > 0.25).any(axis=0)
        cut = np.convolve(moving, np.ones(2 * int(1.2 * rate) + 1), "same") > 0.5
    broken = np.flatnonzero(np.diff(t) > real.apart_s) + 1 if real.apart_s else np.array([], int)
    marks = np.unique(np.concatenate([[0, len(t)], broken, np.flatnonzero(np.diff(cut)) + 1]))
    return [(a, b) for a, b in zip(marks[:-1], marks[1:]) if not cut[a] and b - a >= 30]


def allan(parts, rate):
    """(taus, Allan deviations): overlapping, pooled over the parts, eight averages a decade and
    more, up to a ninth of what there is.
    """
    most = min(max(map(len, parts)) // 2 - 1, sum(map(len, parts)) // 9)
    taus, found = [], []
    angles = [np.concatenate([[0], np.cumsum(part - part.mean())]) for part in parts]
    for m in np.unique(np.round(2 ** np.arange(0, np.log2(most), 0.25)).astype(int)):
        squares, count = 0.0, 0
        for angle in angles:
            if len(angle) > 2 * m + 1:
                second = angle[2 * m :] - 2 * angle[m:-m] + angle[: -2 * m]
                squares, count = squares + np.dot(second, second), count + len(second)
        if count > 0:
            taus.append(m / rate)
            found.append(np.sqrt(squares / count / 2) / m)
    return np.array(taus), np.array(found)


def quiet_level(parts, rate, low, high):
    """Two-sided spectrum at the lower quartile of a band, as of white noise: three quarters of the
    frequencies have more, so lines and humps do not count.
    """
    length = int(32 * rate / high)
    total, pieces = 0.0, 0
    for part in parts:
        if len(part) >= length:
            f, power = signal.welch(part, rate, nperseg=length, noverlap=0, detrend="linear")
            total, pieces = total + power * (len(part) // length), pieces + len(part) // length
    if not pieces:
        return 0.0
    inside = (f >= low) & (f <= min(high, 0.45 * rate))
    return np.quantile(total[inside], 0.25) / 2 / (stats.chi2.ppf(0.25, 2 * pieces) / 2)


def white_reading(parts, rate, taus, adev):
    """N in deg/sqrt(h) where half a decade is white: slope within 0.05 of -1/2, the minimum of the
    Allan variance below a tenth (flicker), the level between the lines above nine tenths of what is
    read. None where there is no such half decade; of several the one nearest that level. It begins
    within a second or four samples: what is white only later is a plateau below a corner.
    """
    best = None
    for start in taus[(taus * HALF_DECADE <= taus[-1]) & (taus <= max(1.0, 4 * taus[0]))]:
        inside = (taus >= start * 0.999) & (taus <= start * HALF_DECADE * 1.03)
        if inside.sum() < 3:
            continue
        slope = np.polyfit(np.log(taus[inside]), np.log(adev[inside]), 1)[0]
        middle, density = (
            np.exp(np.mean(np.log(of)))
            for of in (adev[inside] ** 2, adev[inside] ** 2 * taus[inside])
        )
        if abs(slope + 0.5) < 0.05 and adev.min() ** 2 < 0.1 * middle:
            share = quiet_level(parts, rate, 0.25 / start / HALF_DECADE, 0.6 / start) / density
            if share > 0.9 and (best is None or abs(np.log(share)) < best[0]):
                best = (abs(np.log(share)), 60 * np.sqrt(density))
    return best and float(best[1])


def reading(real, axis, header, lines):
    """(N at 1 s or the shortest tau, B at the minimum over 0.664, N of the white part or None)."""
    table = dict(zip(header.strip().split(","), np.loadtxt(lines, delimiter=",").T))
    t, gyro = table["time_s"], np.stack([table[f"gyro_{a}_dps"] for a in "xyz"])
    rate = 1 / (np.mean if real.even else np.median)(np.diff(t))
    parts = [gyro["xyz".index(axis), a:b] for a, b in segments(real, t, gyro)]
    taus, adev = allan(parts, rate)
    at = max(1.0, taus[0])
    n = 60 * np.sqrt(at) * np.exp(np.interp(np.log(at), np.log(taus), np.log(adev)))
    return float(n), float(3600 * adev.min() / 0.664), white_reading(parts, rate, taus, adev)


def one(name):
    recording, axis = name.rsplit(" ", 1)
    real = RECORDINGS[recording]
    header, lines = rows_of(real)
    n, b, white = reading(real, axis, header, lines)
    with tempfile.TemporaryDirectory() as folder:
        record, model = Path(folder) / "rec.csv", Path(folder) / "model.toml"
        with open(record, "w") as file:
            file.writelines([header, *lines])
        model.write_text(asking.MODEL.format(column=f"gyro_{axis}_dps", n=n, b=b))
        begin = time.perf_counter()
        words = ["improve", record, "-m", model, "-o", Path(folder) / "out.toml"]
        found = asking.said(*words, statuses=(0, 1))
    first, last = found["steps"][0], found["steps"][-1]
    fitted = [one for one in found["fitted"] if one["kind"] not in BASE]
    noise = [one for one in found["fitted"] if one["kind"] == "angle_random_walk"]
    named, observed = ([one["kind"] for one in of] for of in (fitted, found["observations"]))
    agrees, wrong, why = judgement(real, axis, named, observed)
    return {
        "name": name,
        "seconds": time.perf_counter() - begin,
        "white": white,
        "sees": real.for_axis(real.sees, axis),
        "given": first["error"],
        "final": last["error"],
        "floor": last["error_floor"],
        "adequacy": last.get("adequacy") or found["adequacy"],
        "deviation": found.get("largest_deviation") or {},
        "named": named,
        "observed": sorted(set(observed)),
        "agrees": agrees,
        "wrong": wrong,
        "why": why,
        "fitted_n": noise[0]["parameters"]["coefficient_deg_per_sqrt_h"]["value"]
        if noise
        else None,
    }


HEAD = (
    *("axis", "error given", "final", "floor", "ratio", "adequacy", "added", "observed"),
    *("largest deviation", "an expert sees", "agrees", "ARW fitted / read", "s"),
)


def number(value, form):
    return "-" if value is None else format(value, form)


def cells(row):
    counts, off = Counter(row["named"]), row["deviation"]
    return [
        row["name"],
        f"{row['given']:.3f}",
        f"{row['final']:.4f}",
        f"{row['floor']:.4f}",
        f"{row['final'] / row['floor']:.2f}",
        row["adequacy"],
        ", ".join(f"{n} {kind}" if n > 1 else kind for kind, n in counts.items()) or "-",
        ", ".join(row["observed"]),
        f"{off['percent']:.1f} % at {off['tau_s']:.3g} s" if off.get("percent") else "",
        row["sees"],
        "; ".join([row["agrees"], *row["why"]]),
        f"{number(row['fitted_n'], '.3f')} / {number(row['white'], '.3f')}",
        f"{row['seconds']:.0f}",
    ]


def markdown(rows):
    yield "| " + " | ".join(HEAD) + " |"
    yield "|" + "---|" * len(HEAD)
    for row in rows:
        shown = [str(cell).replace("|", "/").replace("\n", " ") for cell in cells(row)]
        yield "| " + " | ".join(shown) + " |"


def totals(rows):
    """The goals, for all 30 axes."""
    white = [row for row in rows if row["white"] is not None]
    near = [r for r in white if r["fitted_n"] and abs(r["fitted_n"] / r["white"] - 1) <= 0.05]
    wrong, agrees = [r for r in rows if r["wrong"]], Counter(r["agrees"] for r in rows)
    within = [r for r in rows if r["final"] <= 1.25 * r["floor"]]
    adequate = [r for r in rows if r["adequacy"] != "no"]
    statistical = [r for r in rows if r["adequacy"] == "statistical"]
    rose = [r for r in rows if r["final"] > 1.0001 * r["given"]]
    yield f"error within 1.25 of the floor: {len(within)} of {len(rows)} (goal 26 of 30)"
    yield f"practically adequate: {len(adequate)} of {len(rows)} (goal 26 of 30)"
    yield f"statistically adequate: {len(statistical)} of {len(rows)} (goal 15 of 30)"
    yield f"ARW within 5 % of the reading: {len(near)} of {len(white)} (goal 19 of 20)"
    yield f"errors that rose: {len(rose)} (goal 0)"
    yield (
        f"axes with a wrong cause: {len(wrong)}, of them called adequate "
        f"{sum(r['adequacy'] != 'no' for r in wrong)} (goal 0)"
    )
    yield "the expert agrees: " + ", ".join(f"{w} {agrees[w]}" for w in ("yes", "partly", "no"))
    seconds = [row["seconds"] for row in rows]
    yield (f"seconds: median {np.median(seconds):.1f}, worst {max(seconds):.1f}")


def options():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    about = 'one axis, as "ADIS16405 run 1 z"; may be given more than once'
    parser.add_argument("--axis", action="append", metavar="NAME", help=about)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", metavar="TABLE.md")
    return parser.parse_args()


def wanted(chosen):
    for recording, real in RECORDINGS.items():
        if not (FOLDER / real.file).exists():
            print(f"absent: {FOLDER / real.file}", flush=True)
            continue
        yield from (
            f"{recording} {axis}" for axis in "xyz" if not chosen or f"{recording} {axis}" in chosen
        )


def main(chosen):
    rows = []
    with multiprocessing.Pool(chosen.jobs) as pool:
        for row in pool.imap(one, list(wanted(chosen.axis))):
            rows.append(row)
            print("; ".join(filter(None, map(str, cells(row)))), flush=True)
    if not rows:
        raise SystemExit("no recording there")
    table = "\n".join([*markdown(rows), "", *totals(rows)])
    print(table)
    if chosen.out:
        Path(chosen.out).write_text(table + "\n")


if __name__ == "__main__":
    main(options())
