"""The figures of a report, each as SVG text."""

import base64
import io
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import axes as axes_of
from ..arrays import Floats, Ints
from ..data.recording import Recording
from ..diagnosis.compare import Comparison
from ..diagnosis.contributions import Contribution
from ..diagnosis.improve import Estimates, Step
from ..effects import table
from . import plot, words
from .plot import plt

WIDTH = 5.9  # inches; at the 96 pixels of a browser's inch half of a page
STRETCHES = 500
COLUMN_PANELS = 3
SETTINGS = {
    "svg.fonttype": "path",
    "svg.hashsalt": "davarlab",
    "font.size": 9.5,
    "axes.titlesize": 9.5,
}


def svg(figure: Figure) -> str:
    """A data URI; no metadata, so that nothing in it points outside."""
    text = io.BytesIO()
    figure.savefig(
        text, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None}
    )
    plt.close(figure)
    return "data:image/svg+xml;base64," + base64.b64encode(text.getvalue()).decode()


def framed(height: float, rows: int = 1, **settings: Any) -> tuple[Figure, Any]:
    return plt.subplots(
        rows, 1, figsize=(WIDTH, height), layout="constrained", squeeze=False, **settings
    )


def deviation(given: Comparison, better: Comparison | None, effects: Sequence[Contribution]) -> str:
    with plt.rc_context(SETTINGS):
        figure, axes = framed(4.0)
        plot.draw_deviation(axes[0, 0], given, better, effects)
        return svg(figure)


def failure_map(given: Comparison, better: Comparison | None) -> str:
    with plt.rc_context(SETTINGS):
        maps = [("initial model", given)] + ([("with added effects", better)] if better else [])
        figure, axes = framed(2.6 * len(maps) + 0.4, len(maps), sharex=True)
        colours = plot.ratio_scale(*(comparison for _, comparison in maps))
        for (title, comparison), one in zip(maps, axes[:, 0]):
            plot.draw_map(one, comparison, colours)
            one.set_title(title)
        for one in axes[:-1, 0]:
            one.set_xlabel("")
        plot.draw_map_scale(figure, list(axes[:, 0]), colours)
        return svg(figure)


def spectrum(given: Comparison, better: Comparison | None) -> str:
    with plt.rc_context(SETTINGS):
        figure, axes = framed(3.6)
        plot.draw_spectrum(axes[0, 0], given, better)
        return svg(figure)


def steps(found: Sequence[Step]) -> str:
    """The error after each step, in sample and held out, and the floor."""
    with plt.rc_context(SETTINGS):
        figure, axes = framed(3.2)
        one, place = axes[0, 0], np.arange(len(found))
        one.plot(
            place, [step.error for step in found], "o-", color=plot.BETTER, label="this recording"
        )
        outside = [step.error_held_out for step in found]
        if None not in outside:
            one.plot(place, outside, "s--", color=plot.GIVEN, label="held-out recording")
        one.plot(
            place,
            [step.error_floor for step in found],
            "--",
            color="0.4",
            label="floor: a true model",
        )
        names = ["initial"] + [f"+\u00a0{words.name(str(step.added))}" for step in found[1:]]
        one.set_xticks(
            place, [textwrap.fill(name, 72 // len(found), break_on_hyphens=False) for name in names]
        )
        top = max(max(step.error, step.error_held_out or 0) for step in found)
        one.set(
            ylabel="error [decades of Allan deviation]",
            ylim=(0, 1.15 * top),
            xlim=(-0.4, len(found) - 0.6),
        )
        one.grid(axis="y", alpha=0.3)
        one.legend(fontsize="small")
        return svg(figure)


def stretches(values: Floats) -> Floats:
    """Rows of equal length. A shorter rest at the end is omitted."""
    count = min(STRETCHES, len(values))
    length = len(values) // count
    return values[: count * length].reshape(count, length)


def column_groups(recording: Recording, kinds: Sequence[str]) -> dict[str, list[str]]:
    """The columns of each panel: title -> names. Accelerometer axes share a panel. Columns that the
    model's effects need come first."""
    groups: dict[str, list[str]] = {}
    needs = tuple(need for kind in kinds for need in table.find(kind).needs)
    for name in recording.columns:
        if name == "time_s" or name.startswith("gyro_") or np.ptp(recording.columns[name]) == 0:
            continue
        quantity, _, unit = name.rpartition("_")
        title = (
            f"vibration [{unit} rms]"
            if quantity.startswith("accel")
            else f"{quantity.replace('_', ' ')} [{unit}]"
            if quantity
            else name
        )
        groups.setdefault(title, []).append(name)
    ordered = sorted(
        groups.items(), key=lambda group: not (needs and group[1][0].startswith(needs))
    )
    return dict(ordered[:COLUMN_PANELS])


def draw_columns(
    axes: Axes, title: str, names: Sequence[str], recording: Recording, time: Floats
) -> None:
    for name in names:
        rows = stretches(recording.columns[name])
        values = rows.std(axis=1) if title.startswith("vibration") else rows.mean(axis=1)
        axes.plot(time, values, linewidth=1, label=name.split("_")[1] if len(names) > 1 else None)
    axes.set_ylabel(title)
    if len(names) > 1:
        legend_on_top(axes)


def legend_on_top(axes: Axes) -> None:
    """A legend in one row, with space above the curves."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.3 * (high - low))
    axes.legend(fontsize="small", ncols=4, loc="upper left")


def mark(axes: Axes, estimates: Iterable[tuple[str, Estimates]], shock_times: Floats) -> None:
    """Times and intervals of the model's effects."""
    for kind, entry in estimates:
        if kind == "noise_step":
            axes.axvspan(
                float(entry["start_s"].value),
                float(entry["stop_s"].value),
                color=plot.GIVEN,
                alpha=0.15,
                label="noise step",
            )
        if kind == "shocks":
            top = axes.get_ylim()[1]
            axes.plot(
                shock_times,
                np.full(len(shock_times), top),
                "v",
                color=plot.GIVEN,
                markersize=5,
                clip_on=False,
                label="shocks",
            )


def recorded(
    recording: Recording,
    gyro: str,
    estimates: Iterable[tuple[str, Estimates]] = (),
    shocks: Sequence[int] | Ints = (),
) -> str:
    """The gyro column (extremes and mean of short intervals) and the other logged columns. Time is
    counted in samples. shocks: sample indices."""
    with plt.rc_context(SETTINGS):
        estimates = list(estimates)
        groups = column_groups(recording, [kind for kind, _ in estimates])
        figure, axes = plt.subplots(
            1 + len(groups),
            1,
            figsize=(WIDTH, 2.4 + 1.4 * len(groups)),
            layout="constrained",
            squeeze=False,
            sharex=True,
            height_ratios=[1.8] + [1] * len(groups),
        )
        rows = stretches(recording.rate_dps(gyro))
        time = (np.arange(len(rows)) + 0.5) * rows.shape[1] / recording.rate_hz
        first = axes[0, 0]
        first.fill_between(
            time, rows.min(axis=1), rows.max(axis=1), color="0.75", linewidth=0, label="extremes"
        )
        first.plot(
            time,
            rows.mean(axis=1),
            color="k",
            linewidth=1,
            label=f"mean over {rows.shape[1] / recording.rate_hz:.3g} s",
        )
        name = gyro.rsplit("_", 1)[0].replace("_", " ")
        first.set_ylabel(f"{name} [{axes_of.rate_unit(gyro)}]")
        mark(first, estimates, np.asarray(shocks) / recording.rate_hz)
        legend_on_top(first)
        for one, (title, names) in zip(axes[1:, 0], groups.items()):
            draw_columns(one, title, names, recording, time)
        axes[-1, 0].set(xlabel="time [s]", xlim=(time[0], time[-1]))
        return svg(figure)
