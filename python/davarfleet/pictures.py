"""The pictures of a population, each one SVG file in text."""

import base64
import io
from collections.abc import Sequence
from datetime import UTC, datetime

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from davarlab.effects import table
from davarlab.report import words
from matplotlib.figure import Figure

from . import population
from .limits import Limit
from .store import Found, Row

matplotlib.use("Agg")

WIDTH = 5.9  # inches; at the 96 pixels of a browser's inch half of a page
SETTINGS = {
    "svg.fonttype": "path",
    "svg.hashsalt": "davarlab",
    "font.size": 9.5,
    "axes.titlesize": 9.5,
}
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999")
BATCHES_MAX = len(COLOURS)
KINDS_MAX = 12


def svg(figure: Figure) -> str:
    """A data URI; no metadata, so that nothing in it points outside."""
    text = io.BytesIO()
    figure.savefig(
        text, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None}
    )
    plt.close(figure)
    return "data:image/svg+xml;base64," + base64.b64encode(text.getvalue()).decode()


def coefficient(name: str) -> str:
    """kind.parameter as people read it: a size of a gyro's effect by its unit."""
    kind, _, parameter = name.partition(".")
    size = table.TABLE[kind].size if kind in table.TABLE else None
    return (
        f"{words.name(kind)} [{size.unit}]"
        if size and size.name == parameter
        else f"{words.name(kind)} {parameter.replace('_', ' ')}"
    )


def framed(rows: int, height: float) -> tuple[Figure, npt.NDArray[np.object_]]:
    return plt.subplots(
        rows, 1, figsize=(WIDTH, height * rows + 0.5), layout="constrained", squeeze=False
    )


def batches_of(rows: Sequence[Row]) -> list[tuple[str, list[Row], str]]:
    """(name, rows, colour), the last of many together."""
    found = list(population.groups(rows, "batch").items())
    shown, rest = (
        found[: BATCHES_MAX - 1] if len(found) > BATCHES_MAX else found,
        found[BATCHES_MAX - 1 :] if len(found) > BATCHES_MAX else [],
    )
    together = [("others", [row for _, part in rest for row in part])] if rest else []
    return [
        (name or "units", part, COLOURS[place])
        for place, (name, part) in enumerate(shown + together)
    ]


def distributions(rows: Sequence[Row], names: Sequence[str], limits: Sequence[Limit]) -> str:
    """A histogram of each coefficient, the batches above each other."""
    with plt.rc_context(SETTINGS):
        figure, axes = framed(len(names), 2.0)
        for one, name in zip(axes[:, 0], names):
            everything = population.estimates(rows, name)[1]
            if not len(everything):
                continue
            centre, low, high = (
                np.median(everything[:, 0]),
                *np.quantile(everything[:, 0], [0.005, 0.995]),
            )
            marks = [limit.value for limit in limits if limit.coefficient == name]
            low, high = min([low, *marks]), max([high, *marks])
            reach = max(high - low, 1e-3 * abs(centre), 1e-12)
            edges = np.linspace(low - 0.03 * reach, high + 0.03 * reach, 41)
            for batch, part, colour in batches_of(rows):
                own = np.clip(population.estimates(part, name)[1][:, 0], edges[0], edges[-1])
                one.hist(
                    own,
                    edges,
                    histtype="stepfilled",
                    alpha=0.35,
                    color=colour,
                    label=f"{batch} ({len(own)})",
                )
                one.hist(own, edges, histtype="step", color=colour, linewidth=1.2)
            for mark in marks:
                one.axvline(mark, color="k", linestyle="--", linewidth=1)
            one.set(xlabel=coefficient(name), ylabel="units")
            one.grid(axis="y", alpha=0.3)
        axes[0, 0].legend(fontsize="small")
        return svg(figure)


def gains(hidden: Sequence[Found]) -> str:
    """What candidates gain in each batch beyond chance, in standard deviations of chance."""
    kinds = list(dict.fromkeys(one["kind"] for one in hidden))[:KINDS_MAX]
    batches = sorted({(one["axis"], one["batch"]) for one in hidden})[:BATCHES_MAX]
    many = len({axis for axis, _ in batches}) > 1
    with plt.rc_context(SETTINGS):
        figure, axes = framed(1, 0.28 * len(kinds) + 0.9)
        one, thick = axes[0, 0], 0.8 / max(len(batches), 1)
        for place, (axis, batch) in enumerate(batches):
            found = {
                entry["kind"]: entry
                for entry in hidden
                if (entry["axis"], entry["batch"]) == (axis, batch)
            }
            height = np.arange(len(kinds)) + (place - (len(batches) - 1) / 2) * thick
            values = [found[kind]["deviations"] if kind in found else 0.0 for kind in kinds]
            name = f"{batch or 'all'} {axis}" if many else batch or "all units"
            one.barh(height, values, thick, color=COLOURS[place], label=name)
            for at, kind, value in zip(height, kinds, values):
                if kind in found and found[kind]["found"]:
                    one.annotate(
                        "significant",
                        (value, at),
                        (3, 0),
                        textcoords="offset points",
                        va="center",
                        fontsize="x-small",
                    )
        one.set_yticks(np.arange(len(kinds)), [kind.replace("_", " ") for kind in kinds])
        one.invert_yaxis()
        one.set(xlabel="sum of the gains above simulation [standard deviations]")
        left, right = one.get_xlim()
        one.set_xlim(left, right + 0.2 * (right - left))
        one.grid(axis="x", alpha=0.3)
        one.legend(fontsize="small", loc="lower right")
        return svg(figure)


def over(rows: Sequence[Row], names: Sequence[str], key: str) -> str | None:
    """Each coefficient over date or temperature, a dot a unit; None where nothing is known."""
    rows = [row for row in rows if row.get(key) is not None]
    if len(rows) < 2 or np.ptp([row[key] for row in rows]) == 0:
        return None
    with plt.rc_context(SETTINGS):
        figure, axes = framed(len(names), 1.9)
        for one, name in zip(axes[:, 0], names):
            for batch, part, colour in batches_of(rows):
                have, values = population.estimates(part, name)
                x = (
                    [datetime.fromtimestamp(row[key], UTC) for row in have]
                    if key == "start_s"
                    else [row[key] for row in have]
                )
                one.plot(x, values[:, 0], ".", markersize=4, alpha=0.6, color=colour, label=batch)
            one.set_ylabel(coefficient(name).replace(" [", "\n["), fontsize="small")
            one.grid(alpha=0.3)
        axes[-1, 0].set_xlabel(
            "date of the recording" if key == "start_s" else "mean temperature [degC]"
        )
        axes[0, 0].legend(fontsize="small")
        figure.autofmt_xdate() if key == "start_s" else None
        return svg(figure)
