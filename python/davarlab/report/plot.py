"""The figure of `davarlab plot`, for where there is no browser."""

import io
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from ..arrays import Floats
from ..diagnosis.compare import Comparison
from ..diagnosis.judge import Cell

matplotlib.use("Agg")
import matplotlib.pyplot
import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.colors import LogNorm
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

from .. import files
from . import curves

plt = matplotlib.pyplot
MODEL = "#0072b2"
FADED, FULL, MARKED = (
    2.0,
    4.0,
    4.0,
)  # |z| above which a cell of the map has some colour, full colour, a dot


def plain_number(value: float, _: int | None = None) -> str:
    return f"{value:g}"


def draw_deviation(axes: Axes, comparison: Comparison) -> None:
    """Measured and model Allan deviation over the whole record, with the band that holds 95 % of
    recordings of a true model."""
    drawn = curves.deviation(comparison.cells, [])
    tau = drawn["tau_s"]
    axes.fill_between(
        tau,
        drawn["low"],
        drawn["high"],
        color=MODEL,
        alpha=0.2,
        linewidth=0,
        label="95 % of recordings, if true",
    )
    axes.plot(tau, drawn["model"], color=MODEL, label="model")
    axes.plot(tau, drawn["measured"], "k.", label="measured")
    values = drawn["measured"] + drawn["model"]
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="averaging time tau [s]",
        ylabel=f"Allan deviation [{comparison.unit}]",
        ylim=(min(values) / 3, max(values) * 2),
    )
    axes.grid(which="major", alpha=0.3)
    axes.legend(fontsize="small")


def finest(comparison: Comparison) -> dict[float, list[Cell]]:
    """tau -> the cells of the shortest windows that have this tau."""
    rows: dict[float, list[Cell]] = {}
    for cell in comparison.cells:
        rows.setdefault(cell.tau_s, []).append(cell)
    return {
        tau: [
            cell
            for cell in cells
            if cell.stop_s - cell.start_s < 1.01 * min(c.stop_s - c.start_s for c in cells)
        ]
        for tau, cells in sorted(rows.items())
    }


def ratio_scale(comparison: Comparison) -> ScalarMappable:
    """Colours of measured / model. White is 1."""
    worst = max(
        (
            max(cell.ratio, 1 / max(cell.ratio, 1e-9))
            for cell in comparison.cells
            if abs(cell.z) > FADED
        ),
        default=2.0,
    )
    reach = min(max(worst, 2.0), 10.0)
    return plt.cm.ScalarMappable(LogNorm(1 / reach, reach), "RdBu_r")


def cell_colour(cell: Cell, colours: ScalarMappable) -> Floats:
    """The colour of the cell's ratio, faded to white if it is consistent with noise."""
    sure = 0.08 + 0.92 * np.clip((abs(cell.z) - FADED) / (FULL - FADED), 0, 1)
    faded: Floats = 1 - sure * (1 - np.array(colours.to_rgba(np.array(cell.ratio))[:3]))
    return faded


def draw_map(axes: Axes, comparison: Comparison, colours: ScalarMappable) -> None:
    """Measured / model in every window and at every tau. Cells consistent with noise are pale."""
    rows = finest(comparison)
    cells, taus = [cell for row in rows.values() for cell in row], list(rows)
    boxes = [
        Rectangle(
            (cell.start_s, cell.tau_s / 2**0.5), cell.stop_s - cell.start_s, cell.tau_s / 2**0.5
        )
        for cell in cells
    ]
    axes.add_collection(
        PatchCollection(
            boxes,
            facecolors=[cell_colour(cell, colours) for cell in cells],
            edgecolors="0.8",
            linewidths=0.3,
        )
    )
    sure = [
        ((cell.start_s + cell.stop_s) / 2, cell.tau_s) for cell in cells if abs(cell.z) > MARKED
    ]
    axes.plot(*np.array(sure or [(np.nan, np.nan)]).T, "k.", markersize=2.5)
    axes.set(
        yscale="log",
        xlabel="time [s]",
        ylabel="averaging time tau [s]",
        ylim=(taus[0] / 2**0.5, taus[-1] * 2**0.5),
        xlim=(0, max(cell.stop_s for cell in cells)),
    )


def draw_map_scale(figure: Figure, axes: Axes, colours: ScalarMappable) -> None:
    bar = figure.colorbar(colours, ax=axes, label="measured / model")
    bar.ax.yaxis.set_major_locator(MaxNLocator(1))
    low, high = colours.norm.vmin, colours.norm.vmax
    assert low is not None and high is not None  # ratio_scale() has set them
    ticks = [
        value
        for value in (0.1, 0.2, 0.5, 0.7, 1, 1.4, 2, 5, 10)
        if low * 0.99 <= value <= high * 1.01
    ]
    bar.set_ticks(ticks, labels=[f"{value:g}" for value in ticks])
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    bar.ax.minorticks_off()


def draw_spectrum(axes: Axes, comparison: Comparison) -> None:
    """Spectrum of the residual over that of the model. A true model gives 1."""
    drawn = curves.residual(*comparison.spectrum)
    f, least = drawn["f_hz"], max(min(*drawn["ratio"], 0.5), 0.2)
    axes.fill_between(
        f, drawn["low"], drawn["high"], color="0.85", linewidth=0, label="95 % range of noise"
    )
    axes.axhline(1, color="0.6", linewidth=0.8)
    axes.plot(f, np.maximum(drawn["ratio"], least), ".", color=MODEL, label="model")
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="frequency [Hz]",
        ylabel="residual / model",
        ylim=(least / 1.2, max(1.5 * max(drawn["ratio"]), 2)),
    )
    axes.yaxis.set_major_formatter(FuncFormatter(plain_number))
    axes.grid(which="major", alpha=0.3)
    axes.legend(fontsize="small")


def draw(comparison: Comparison, path: str | Path) -> None:
    """Allan deviation, failure map and residual spectrum in one figure: PNG, PDF or SVG by the
    name."""
    figure, axes = plt.subplots(3, 1, figsize=(9, 12), layout="constrained")
    draw_deviation(axes[0], comparison)
    colours = ratio_scale(comparison)
    draw_map(axes[1], comparison, colours)
    draw_map_scale(figure, axes[1], colours)
    draw_spectrum(axes[2], comparison)
    axes[0].set_title(
        f"{', '.join(comparison.effects)}: error {comparison.error:.3f}, floor "
        f"{comparison.error_floor:.3f}, p = {comparison.p_value:.2g}"
    )
    axes[1].set_title("pale: consistent with noise; dot: more than 4 standard deviations")
    data = io.BytesIO()
    figure.savefig(data, dpi=100, format=Path(path).suffix[1:].lower())
    plt.close(figure)
    files.write_whole(path, data.getvalue())
