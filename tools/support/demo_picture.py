"""The plot of tools/demo: rate, window length, ARW with its interval and the true value, results
for a control loop, DAVAR surface.
"""

from collections.abc import Mapping, Sequence

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

Floats = npt.NDArray[np.float64]
Rows = Sequence[Mapping[str, str]]
Steps = Sequence[tuple[float, float]]  # time and value


def column_of(rows: Rows, name: str) -> Floats:
    return np.array([float(row[name]) if row.get(name) else np.nan for row in rows])


def extremes(time: Floats, rate: Floats, stretches: int) -> tuple[Floats, Floats]:
    """The smallest and the largest sample of each section of a recording, in the order of time."""
    length = len(rate) // stretches
    rows = rate[: stretches * length].reshape(stretches, length)
    starts = np.arange(stretches) * length
    kept = np.sort(np.concatenate([starts + rows.argmin(axis=1), starts + rows.argmax(axis=1)]))
    return time[kept], rate[kept]


def draw_rate(axes: Axes, points: Steps, column: str) -> None:
    """Plots dots, or the band between the extremes of a long recording, so no shock is lost."""
    time, rate = np.array(points).T
    if len(rate) > 50_000:
        axes.plot(*extremes(time, rate, 5000), color="0.25", linewidth=0.5, rasterized=True)
    else:
        axes.plot(
            time,
            rate,
            ".",
            color="0.25",
            markersize=2,
            alpha=0.5,
            markeredgewidth=0,
            rasterized=True,
        )
    axes.set_ylabel(f"{column.rsplit('_', 1)[0]}\n[deg/s]" if column.endswith("_dps") else column)


def draw_window(axes: Axes, time: Floats, rows: Rows) -> None:
    window = column_of(rows, "window_samples")
    axes.plot(time, window, color="tab:blue", linewidth=1)
    unstable = column_of(rows, "unstable") > 0
    unstable[1:] |= unstable[:-1]  # an epoch lasts until the next one
    axes.fill_between(
        time,
        0,
        1,
        where=list(map(bool, unstable)),
        color="tab:red",
        alpha=0.2,
        transform=axes.get_xaxis_transform(),
        linewidth=0.3,
        label="unstable",
    )
    axes.set_ylim(0, 1.1 * np.nanmax(window))
    axes.set_ylabel("window\n[samples]")
    axes.legend(loc="lower right", frameon=True)


def draw_truth(axes: Axes, stop: float, truth: Steps) -> None:
    if truth:
        starts, values = zip(*truth)
        axes.step(
            [*starts, stop],
            [*values, values[-1]],
            where="post",
            color="black",
            linestyle="--",
            linewidth=1,
            label="truth (simulated)",
        )


def top_of(high: Floats, truth: Steps) -> float:
    top = np.nanpercentile(high, 99.5) if np.isfinite(high).any() else 1
    return float(1.35 * max([top, *(value for _, value in truth)]))


def draw_arw(axes: Axes, time: Floats, rows: Rows, truth: Steps) -> None:
    low, high = (
        column_of(rows, "arw_low_deg_per_sqrt_h"),
        column_of(rows, "arw_high_deg_per_sqrt_h"),
    )
    axes.fill_between(
        time, low, high, color="tab:blue", alpha=0.3, linewidth=0, label="95 % interval"
    )
    axes.plot(
        time, column_of(rows, "arw_deg_per_sqrt_h"), color="tab:blue", linewidth=1, label="ARW"
    )
    draw_truth(axes, time[-1], truth)
    axes.set_ylim(0, top_of(high, truth))
    axes.set_ylabel("ARW\n[deg/$\\sqrt{h}$]")
    axes.legend(loc="upper right", ncols=3, frameon=True)


def draw_laws(axes: Axes, laws: Sequence[Rows], truth: Steps) -> None:
    """Plots trailing windows, which use past samples only. laws: the results of the paper's law and
    of the likelihood ratio.
    """
    paper, glr = laws
    for rows, name, colour in ((paper, "paper's law", "tab:gray"), (glr, "glr", "tab:orange")):
        axes.plot(
            column_of(rows, "time_s"),
            column_of(rows, "arw_deg_per_sqrt_h"),
            color=colour,
            linewidth=1,
            label=name,
        )
    alarms = column_of(glr, "time_s")[column_of(glr, "alarm") > 0]
    axes.plot(
        alarms, np.zeros(len(alarms)), "^", color="tab:red", clip_on=False, label="alarm of glr"
    )
    draw_truth(axes, column_of(glr, "time_s")[-1], truth)
    axes.set_ylim(0, top_of(column_of(glr, "arw_deg_per_sqrt_h"), truth))
    axes.set_ylabel("ARW, trailing\n[deg/$\\sqrt{h}$]")
    axes.legend(loc="upper right", ncols=4, frameon=True)


def edges(values: Floats) -> Floats:
    middle = np.sqrt(values[1:] * values[:-1]) if len(values) > 1 else values * 1.4
    return np.concatenate([[values[0] ** 2 / middle[0]], middle, [values[-1] ** 2 / middle[-1]]])


def draw_surface(
    figure: Figure, axes: Axes, colour_axes: Axes, time: Floats, rows: Rows, period_s: float
) -> None:
    sizes = [int(name[5:]) for name in rows[0] if name.startswith("adev_") and name[5:].isdigit()]
    surface = np.array([column_of(rows, f"adev_{m}") for m in sizes])
    surface[surface <= 0] = np.nan
    taus = np.multiply(sizes, period_s)
    clock = np.append(time, time[-1] + (time[-1] - time[-2] if len(time) > 1 else 1))
    colours = (
        LogNorm(*np.nanpercentile(surface, [0.1, 99.9])) if np.isfinite(surface).any() else None
    )
    mesh = axes.pcolormesh(
        clock, edges(taus), surface, norm=colours, cmap="viridis", rasterized=True
    )
    axes.set_yscale("log")
    axes.set_yticks(taus, [f"{tau:.3g}" for tau in taus])
    axes.minorticks_off()
    axes.set_ylabel("cluster time tau [s]")
    bar = figure.colorbar(mesh, cax=colour_axes, label="Allan deviation [deg/s]", extend="both")
    bar.ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    bar.ax.yaxis.set_major_formatter("{x:g}")
    bar.ax.minorticks_off()


def draw(
    path: str,
    name: str,
    notes: Mapping[str, str],
    points: Steps,
    column: str,
    rows: Rows,
    truth: Steps,
    laws: Sequence[Rows],
) -> None:
    time = column_of(rows, "time_s")
    epochs = column_of(rows, "epoch")
    period_s = np.median(np.diff(time) / np.diff(epochs)) if len(rows) > 1 else 1.0
    heights = [1, 0.7, 1.3, *([1.3] if len(laws) == 2 and all(laws) else []), 1.3]
    figure, axes = plt.subplots(
        len(heights),
        2,
        figsize=(10, 1.9 * sum(heights)),
        sharex="col",
        constrained_layout=True,
        gridspec_kw={"width_ratios": [1, 0.02], "height_ratios": heights},
    )
    for spare in axes[:-1, 1]:
        spare.set_axis_off()
    left = axes[:, 0]
    draw_rate(left[0], points, column)
    draw_window(left[1], time, rows)
    draw_arw(left[2], time, rows, truth)
    if len(heights) > 4:
        draw_laws(left[3], laws, truth)
    draw_surface(figure, left[-1], axes[-1, 1], time, rows, period_s)
    left[-1].set_xlabel("time [s]")
    left[0].set_xlim(time[0], time[-1])
    simulated = "SIMULATED" in notes.get("description", "")
    left[0].set_title(
        f"{name}{' (simulated)' if simulated else ''}: dynamic Allan variance by davar"
    )
    figure.savefig(path, dpi=95)
