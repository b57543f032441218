"""The page of bench/run and its plot: one table a question."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import runners
import signals
from signals import Floats

if TYPE_CHECKING:
    from compare import Results

NAME, PLOT = "BENCHMARK.md", "benchmark.png"
ROOT = Path(__file__).resolve().parents[1]
COLUMNS_MAX = 7  # beside the name
ABLE = 0.5  # share of answers with a value, below which a method has no rank
WRONG = 0.7  # error of a method that does not rank, above which its values are wrong
MARKS = "os^Dv<>pPXhH*dos^Dv" * 2
FASTEST, WINDOWED = "davar glr", "davar fixed"
GIVEN = "adi_imu static"  # it is told the noise at the start, so it wins nothing
HEAD = """# davar compared with other methods

This page answers: how well does davar measure the noise of a gyro, compared with other methods that
a user would write or take? It is for firmware and navigation engineers who choose a method.

`bench/run` makes this page. It runs every method of `bench/methods` on simulated gyros whose noise
is known, and on the recordings in `data` that state it. Methods of other projects are written from
their descriptions, which each file names. [Where davar loses](#where-davar-loses) lists what other
methods do better.
"""
ERRORS = """
## How wrong is the noise?

The RMS of ln(value / truth) in percent over all answers, one every 10 samples from sample 1000 on.
Lower is better, and the lowest of a column is bold. Parentheses give the share of answers that have
a value, if it is below 99.5 %; "-" means none. The noise is the standard deviation of a sample of
white noise, before any filter. The result of each method is scaled so that it is right in white
noise. `adi_imu static` gets the true noise at the start, so it cannot be bold. Nor can a method
with a value in less than half of its answers.
"""
COVERAGE = """
## Do the intervals contain the truth?

The share of 95 % intervals that contain it, in percent. Only these methods state an interval.
"""
ALARMS = """
## How soon does a doubling show?

In *steps*, the noise doubles every two minutes. `davar glr` has its own alarm. For FusionBias
and VQF, the end of rest is the alarm. For every other method it is a value above 1.41 times its own
median in quiet. A doubling is missed if no alarm begins in the minute after it. False alarms are
those in *rest*.
"""
COST = """
## What does it cost?

On the machine that made this page (x86-64), in white noise, pushed sample by sample. Times are
relative to the 25 lines of C, in alternating runs: one push, and one push with an answer every 10
samples. The row of these lines, measured against themselves, shows how far a time is to be trusted.
Valgrind counts the instructions of a push. The bytes are for one axis, with the window.
For davar they include the configuration and a plan with room for 32 cluster sizes, which
[tools/davar-plan](../PLANNER.md) places in flash or makes smaller. [COST](../COST.md) has the
instructions and sizes of davar on microcontrollers; the other methods were not measured there.
davar takes less time per sample if it gets blocks, which this table does not show.
"""
ADD = """
## Add a method

A method is one file in `bench/methods`; `bench/run` and this page find it.

- **In C**: a type `NAME_t` with the state, the functions `NAME_start`, `NAME_push` and `NAME_take`,
  and two macros. [px4.c](../../bench/methods/px4.c) has 30 lines;
  [method.h](../../bench/method.h) describes what a method gets and returns.
- **In Python**: a dictionary `METHODS` of functions that map a record to an array of answers, such
  as [with_numba.py](../../bench/methods/with_numba.py).

Begin the file with a sentence that describes the method, and name its source. Write the code
from the description; do not copy it. `bench/run --quick -o FOLDER` shows within a minute whether it
runs. To add a recording, put a CSV file with the header line `truth_arw_deg_per_sqrt_h` of
`data/demo_disturbance.csv.gz` into `data`. To add a simulated signal, add one entry to
[signals.py](../../bench/signals.py).
"""


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    lines = [list(head), *map(list, rows)]
    lines.insert(1, ["---"] * len(lines[0]))
    return "\n" + "".join(f"| {' | '.join(line)} |\n" for line in lines)


def rms(errors: Floats) -> float:
    present = errors[~np.isnan(errors)]
    return float(np.sqrt(np.mean(present**2))) if present.size else np.nan


def share(errors: Floats) -> float:
    return float(np.mean(~np.isnan(errors)))


def percent(value: float) -> str:
    return f"{100 * value:.3g}" if 100 * value < 100 else f"{100 * value:.0f}"


def rate(per_hour: float) -> str:
    return f"{per_hour:.3g}" if per_hour < 1000 else f"{per_hour:.0f}"


def best(found: Results, signal: str, only: Callable[[str], bool]) -> tuple[float, str]:
    """The least error among methods that have a value often enough."""
    rows = {name: errors[signal] for name, errors in found.errors.items() if only(name)}
    able = [(rms(one), name) for name, one in rows.items() if share(one) >= ABLE and name != GIVEN]
    return min(able, default=(np.inf, "-"))


def error_cell(found: Results, name: str, signal: str) -> str:
    errors = found.errors[name][signal]
    if np.isnan(errors).all():
        return "-"
    text = percent(rms(errors))
    text = f"**{text}**" if best(found, signal, lambda _: True)[1] == name else text
    return text if share(errors) >= 0.995 else f"{text} ({100 * share(errors):.2g} %)"


def errors_section(found: Results, names: list[str]) -> str:
    columns = [*signals.SIGNALS, *signals.recordings()]
    text = ERRORS
    for first in range(0, len(columns), COLUMNS_MAX):
        part = columns[first : first + COLUMNS_MAX]
        head = ["", *(one.replace("_", " ") for one in part)]
        text += table(
            head,
            (
                [name, found.missing.get(name, "")] + [""] * (len(part) - 1)
                if name in found.missing
                else [name, *(error_cell(found, name, signal) for signal in part)]
                for name in names
            ),
        )
    return text + f"\n![The error of every method for every signal]({PLOT})\n"


def coverage_section(found: Results, names: list[str]) -> str:
    stating = [
        name
        for name in names
        if any((~np.isnan(one)).any() for one in found.covered[name].values())
    ]
    rows = []
    for signal in [*signals.SIGNALS, *signals.recordings()]:
        cells = [found.covered[name][signal] for name in stating]
        shares = ["-" if np.isnan(one).all() else percent(float(np.nanmean(one))) for one in cells]
        rows.append([signal.replace("_", " "), *shares])
    return COVERAGE + table(["", *stating], rows)


def alarm_row(found: Results, name: str) -> list[str]:
    if name in found.missing:
        return [name, found.missing[name], "", "", ""]
    delays = found.delays_s[name]
    seen = delays[~np.isnan(delays)]
    times = [f"{one:.2g}" for one in np.quantile(seen, (0.5, 0.95))] if seen.size else ["-", "-"]
    return [
        name,
        *times,
        percent(float(np.isnan(delays).mean())),
        rate(found.alarms_per_hour[name]),
    ]


def alarm_section(found: Results, names: list[str], seeds: int) -> str:
    count = max((one.size for one in found.delays_s.values()), default=0)
    head = ["", "median, s", "95 %, s", "missed, %", "false alarms per hour"]
    text = ALARMS + table(head, (alarm_row(found, name) for name in names))
    return text + f"\nDoublings: {count}; hours of rest: {seeds}.\n"


def cost_row(found: Results, method: runners.Method) -> list[str]:
    if method.name in found.missing:
        return [method.name, found.missing[method.name], "", "", ""]
    ratios = ["-" if one is None else f"{one:.2f}" for one in found.ratios[method.name]]
    instructions = found.instructions[method.name]
    return [
        method.name,
        "-" if method.bytes_of_state is None else str(method.bytes_of_state),
        *ratios,
        "-" if instructions is None else f"{instructions:.0f}",
    ]


def losses(found: Results) -> str:
    """Where another method is better than the best of davar."""
    lines = []
    for signal in [*signals.SIGNALS, *signals.recordings()]:
        ours = best(found, signal, lambda name: name.startswith("davar"))
        other = best(found, signal, lambda name: not name.startswith("davar"))
        if other[0] < ours[0]:
            mine = f"{percent(ours[0])} % ({ours[1]})" if np.isfinite(ours[0]) else "no value"
            named = signal.replace("_", " ")
            lines.append(
                f"*{named}*: {other[1]} has an error of {percent(other[0])} %, davar {mine}."
            )
        for name, errors in found.errors.items():
            wrong, often = rms(errors[signal]), share(errors[signal])
            if name.startswith("davar") and often < ABLE and wrong > WRONG:
                lines.append(
                    f"*{signal}*: {name} should have no value, but {100 * often:.2g} % of its "
                    f"answers have one, with an error of {percent(wrong)} %."
                )
    medians = {name: float(np.nanmedian(one)) for name, one in seen_delays(found).items()}
    for name, median in medians.items():
        if median < medians[FASTEST]:
            lines.append(
                f"A doubling shows after {median:.2g} s with {name} and after "
                f"{medians[FASTEST]:.2g} s with {FASTEST}. They have "
                f"{rate(found.alarms_per_hour[name])} and "
                f"{rate(found.alarms_per_hour[FASTEST])} false alarms per hour."
            )
    for place, what in enumerate(("a push", "a push with an answer every 10 samples")):
        ratios = {name: one[place] or np.inf for name, one in found.ratios.items()}
        faster = [name for name, ratio in ratios.items() if ratio < ratios[WINDOWED]]
        lines.append(f"Faster than {WINDOWED}, {what}: {', '.join(faster)}.")
    listed = (textwrap.fill(f"- {one}", 100, subsequent_indent="  ") for one in lines)
    return "\n## Where davar loses\n\n" + "\n".join(listed) + "\n"


def seen_delays(found: Results) -> dict[str, Floats]:
    return {name: one for name, one in found.delays_s.items() if not np.isnan(one).all()}


def plot(path: Path, found: Results, names: list[str]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    columns = [*signals.SIGNALS, *signals.recordings()][::-1]
    figure, axes = pyplot.subplots(figsize=(9, 6), layout="constrained")
    for place, name in enumerate(one for one in names if one in found.errors and one != GIVEN):
        rows = [found.errors[name][signal] for signal in columns]
        values = [100 * rms(one) if share(one) >= ABLE else np.nan for one in rows]
        if np.isnan(values).all():
            continue
        ours = name.startswith("davar")
        color, size = (f"C{place}", 8) if ours else ("0.6", 5)
        lines = axes.plot(values, range(len(columns)), MARKS[place], color=color, label=name)
        lines[0].set(markersize=size, zorder=2 + ours)
    axes.set(xscale="log", xlabel="RMS error of the noise, %", yticks=range(len(columns)))
    axes.set_yticklabels([one.replace("_", " ") for one in columns])
    axes.grid(axis="both", alpha=0.3)
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def lists(every: list[runners.Method], seeds: int) -> str:
    files = {one.file: one for one in every}
    rows = [
        [
            f"[{file.name}](../../bench/methods/{file.name})",
            ", ".join(one.name for one in every if one.file == file),
            first.about(),
        ]
        for file, first in files.items()
    ]
    text = "\n## The methods\n" + table(["file", "methods", "what it is"], rows)
    text += "\n## The signals\n\n"
    text += f"Records of each simulated signal: {seeds}. The seed of a record is [{signals.SEED}, "
    text += "place of the signal, number of\nthe record], chosen before the first run.\n"
    simulated = [
        [name, str(signal.seconds), signal.about] for name, signal in signals.SIGNALS.items()
    ]
    recorded = [
        [
            name.replace("_", " "),
            f"{one.counts.size / one.rate_hz:.0f}",
            f"`data/{name}.csv.gz`, 1 record",
        ]
        for name, one in signals.recordings().items()
    ]
    return text + table(["signal", "seconds", "what it is"], simulated + recorded)


def write(folder: Path, found: Results, every: list[runners.Method], seeds: int) -> None:
    names = [one.name for one in every]
    text = HEAD + errors_section(found, names) + coverage_section(found, names)
    text += alarm_section(found, names, seeds)
    head = ["", "bytes", "push", "push and answer", "instructions of a push"]
    text += COST + table(head, (cost_row(found, one) for one in every))
    text += losses(found) + lists(every, seeds) + ADD
    (folder / NAME).write_text(text)
    plot(folder / PLOT, found, names)
