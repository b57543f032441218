"""Shows a run of davar-sim for tools/demo: a summary for the terminal and a plot."""

import csv
import gzip
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TextIO

LINES = 25
RESULTS = 10_000


def open_text(path: str) -> TextIO:
    with open(path, "rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    return gzip.open(path, "rt", errors="replace") if packed else open(path, errors="replace")


def read_notes(path: str) -> dict[str, str]:
    """The `# key: value` lines at the start of a recording."""
    notes = {}
    with open_text(path) as file:
        for line in file:
            if not line.startswith("#"):
                break
            key, _, value = line[1:].partition(":")
            notes[key.strip()] = value.strip()
    return notes


def stride_for(path: str) -> int:
    """The stride: every sample of a short recording, about RESULTS of a long one. If a file cannot
    be read, davar-sim reports it.
    """
    try:
        with open_text(path) as file:
            return max(1, sum(1 for _ in file) // RESULTS)
    except (OSError, EOFError):
        return 1


def number(text: str) -> float:
    return float(text) if text else float("nan")


def read_results(path: str) -> list[dict[str, str]]:
    """The rows of davar-sim as dictionaries; only the first of several channels."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    if rows and "channel" in rows[0]:
        rows = [row for row in rows if row["channel"] == rows[0]["channel"]]
    return rows


def digest_line(row: dict[str, str]) -> str:
    arw = "          -                  "
    if row["arw_deg_per_sqrt_h"]:
        value, low, high = (
            number(row[f"arw_{part}deg_per_sqrt_h"]) for part in ("", "low_", "high_")
        )
        arw = f"{value:10.4g}  {low:8.4g} .. {high:<8.4g}"
    mark = "unstable" if row["unstable"] == "1" else ""
    return (
        f"{number(row['time_s']):10.1f} {row['window_samples']:>7} "
        f"{number(row['kurtosis']):9.2f} {arw} {mark}"
    ).rstrip()


def print_digest(rows: Sequence[dict[str, str]], notes: Mapping[str, str], recording: str) -> None:
    what = f"{Path(recording).name}: {notes.get('description', 'recording')}"
    print(f"{what}\n{len(rows)} results, {min(LINES, len(rows))} of them here:\n")
    print("    time s  window  kurtosis  ARW deg/sqrt(h)   95 % interval")
    step = max(1, len(rows) // LINES)
    for row in rows[step // 2 :: step]:
        print(digest_line(row))
    unstable = sum(row["unstable"] == "1" for row in rows)
    print(f"\nunstable: {100 * unstable / len(rows):.0f} % of the epochs")


def read_truth(notes: Mapping[str, str]) -> list[tuple[float, float]]:
    """Steps (start_s, ARW) of a simulated recording, or an empty list."""
    text = notes.get("truth_arw_deg_per_sqrt_h", "")
    steps = (step.split(":") for step in text.split(",") if step)
    return [(float(start), float(value)) for start, value in steps]


def read_rate(path: str, channel: str) -> tuple[list[tuple[float, float]], str]:
    """Time and rate of a recording, and the name of its column."""
    with open_text(path) as file:
        header = (
            next(line for line in file if not line.startswith("#"))
            .strip()
            .lstrip("\ufeff")
            .split(",")
        )
        names = [name.strip() for name in header]
        column = (
            names.index(channel)
            if channel in names
            else next(
                (i for i, name in enumerate(names) if name.startswith("gyro_")), len(names) - 1
            )
        )
        clock = names.index("time_s") if "time_s" in names else None
        fields = (line.split(",") for line in file if line.strip())
        points = [
            (float(row[clock]) if clock is not None else i, float(row[column]))
            for i, row in enumerate(fields)
        ]
    return points, names[column]


def main() -> None:
    if sys.argv[1] == "stride":
        print(stride_for(sys.argv[2]))
        return
    recording, results, picture, *laws = sys.argv[2:]
    notes, rows = read_notes(recording), read_results(results)
    if not rows:
        sys.exit(f"demo: {recording}: too short for one result")
    print_digest(rows, notes, recording)
    import demo_picture  # heavy; not needed for the stride

    points, column = read_rate(recording, rows[0].get("channel", ""))
    demo_picture.draw(
        picture,
        Path(recording).name,
        notes,
        points,
        column,
        rows,
        read_truth(notes),
        [read_results(law) for law in laws],
    )
    print(f"stream:  {results}\nplot:    {picture}")


if __name__ == "__main__":
    main()
