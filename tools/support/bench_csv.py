"""A long CSV file: davar-sim compared with `wc -l` and pandas, in processor time and memory.

bench.py uses it. tools/davar-bench --csv calls it alone. It needs the standard library; pandas is
optional.
"""

import argparse
import json
import random
import resource
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "build/bench"
SIMULATOR = ROOT / "build/tools/host_sim/davar-sim"
ROWS = 2_000_000
ROWS_LEAST = 10_000
LSB_DPS = 0.01
REPEATS = 3  # of a file with ROWS rows; a longer one is read once
POLL_S = 0.001
PANDAS = """
import sys, time, pandas
start = time.process_time()
pandas.read_csv(sys.argv[1])
print(time.process_time() - start)
"""

Figures = dict[str, dict[str, float | None]]  # a figure per program; None: not installed


def recording(rows: int) -> Path:
    """White noise of 0.2 deg/s on a bias, at 100 Hz. The file is written once."""
    path = WORK / f"white-{rows}.csv"
    if not path.exists():
        WORK.mkdir(parents=True, exist_ok=True)
        noise = random.Random(1)
        partial = path.with_suffix(".partial")
        with partial.open("w") as file:
            file.write("time_s,gyro_z_dps\n")
            file.writelines(
                f"{i / 100:.2f},{round(noise.gauss(37, 20)) * LSB_DPS:.2f}\n" for i in range(rows)
            )
        partial.rename(path)
    return path


def simulation(path: Path, stride: int) -> list[str | Path]:
    lsb, every = str(LSB_DPS), str(stride)
    return [SIMULATOR, path, "--lsb", lsb, "--stride", every, "--progress", "never"]


def processor_s(command: list[str | Path], repeats: int) -> float:
    """The least processor time of a program that prints to nowhere."""
    spent = []
    for _ in range(repeats):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(spent)


def memory_mb(command: list[str | Path]) -> float:
    """The largest memory of a program, polled. Its rusage would include that of this process."""
    largest = 0
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        while process.poll() is None:
            status = Path(f"/proc/{process.pid}/status").read_text(encoding="utf-8")
            for line in status.splitlines():
                largest = max(largest, int(line.split()[1]) if line.startswith("VmHWM") else 0)
            time.sleep(POLL_S)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return largest / 1024


def pandas_s(command: list[str | Path], repeats: int) -> float | None:
    """The least processor time of read_csv, without the import. None: not installed."""
    spent = []
    for _ in range(repeats):
        done = subprocess.run(command, text=True, capture_output=True)
        if "No module named 'pandas'" in done.stderr:
            return None
        done.check_returncode()
        spent.append(float(done.stdout))
    return min(spent)


def measure(rows: int = ROWS) -> Figures:
    """Nanoseconds per row and megabytes."""
    path, repeats = recording(rows), (REPEATS if rows <= ROWS else 1)
    reader: list[str | Path] = [sys.executable, "-c", PANDAS, path]
    of_pandas = pandas_s(reader, repeats)
    some, every = simulation(path, 100), simulation(path, 1)
    return {
        f"CSV of {rows} rows, ns per row": {
            "davar-sim, a result every 100 rows": 1e9 * processor_s(some, repeats) / rows,
            "davar-sim, a result at every row": 1e9 * processor_s(every, repeats) / rows,
            "pandas.read_csv": of_pandas and 1e9 * of_pandas / rows,
            "wc -l": 1e9 * processor_s(["wc", "-l", path], repeats) / rows,
        },
        f"CSV of {rows} rows, memory in MB": {
            "davar-sim, a result every 100 rows": memory_mb(some),
            "pandas.read_csv": of_pandas and memory_mb(reader),
        },
    }


def show(figures: Figures) -> None:
    for name, found in figures.items():
        print(name)
        for who, value in found.items():
            print(f"  {who:<36}" + ("not installed" if value is None else f"{value:>14,.2f}"))


def rows_of(text: str) -> int:
    if not text.isdecimal() or int(text) < ROWS_LEAST:
        raise argparse.ArgumentTypeError(
            f"a whole number of at least {ROWS_LEAST} expected, found {text!r}"
        )
    return int(text)


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools/davar-bench --csv", add_help=False)
    parser.add_argument("rows", metavar="ROWS", nargs="?", type=rows_of, default=ROWS)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        figures = measure(options.rows)
    except (OSError, subprocess.SubprocessError) as why:
        print(f"davar-bench: {why}", file=sys.stderr)
        return 2
    if options.json:
        print(json.dumps(figures, indent=2))
    else:
        show(figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
