"""The filter of a fitted model as the device declares it: davar_filter_t in C, and --bandwidth.

The device has one low-pass of order 1 or 2, sampled with its images, then equal moving averages
(lib/include/davar/filter.h). The file lists the cluster sizes at which white noise after that
filter has the Allan deviation of the model's."""

import math
import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..effects import table
from ..errors import BadInput
from ..inference import allan
from ..inference.estimate import Entry
from ..inference.parts import part_of
from ..model import Model, Term
from ..thresholds import CHANCE
from .export import noise_variance

SHEET_PERCENT = 10.0  # of a cutoff without a recording, as DAVAR_LOW_PASS
LEAST_PERCENT = 1.0
MOST_PERCENT = 50.0
CUTOFFS = 0.002, 2.0  # over the sample rate
AVERAGES_MOST, LENGTH_MOST, SIZES_MOST = 8, 4096, 32
SAME = 0.02  # of Allan deviations; half of it is what LEAST_PERCENT covers
SIZES_LEAST = 3
WIDTH = 95  # of a line of the comment
ACCEPTED = ("low_pass", "moving_average")


@dataclass
class Declared:
    """hz, order: of the low-pass; 0: none. percent: one standard error of hz. sizes: the cluster
    sizes at which the device's filter is the model's, of `octaves`."""

    rate_hz: float
    hz: float = 0.0
    order: int = 0
    percent: float = 0.0
    averages: int = 0
    length: int = 1
    sizes: tuple[int, ...] = ()
    octaves: tuple[int, ...] = ()

    @property
    def bandwidth(self) -> str:
        """As davar-sim, davar-plan, davar-node and the Python package take it."""
        low = f"{self.hz:.6g}:{self.order}:{self.percent:.3g}" if self.order else ""
        count = "" if self.averages == 1 else str(self.averages)
        mean = f"average{count}:{self.length}" if self.averages else ""
        return "+".join(filter(None, (low, mean)))

    @property
    def terms(self) -> list[Term]:
        low = {"cutoff_hz": self.hz, "order": float(self.order), "response": "sampled"}
        return [Term("low_pass", low)] * bool(self.order) + [
            Term("moving_average", {"samples": float(self.length)})
        ] * self.averages


def percent_of(entry: Entry | None, where: str) -> float:
    """One standard error of the cutoff. entry: its estimate; None without a recording."""
    if entry is None:
        return SHEET_PERCENT
    cutoff = entry["cutoff_hz"]
    if cutoff.low is None or cutoff.high is None:
        percent = math.inf
    else:
        percent = 50 * (cutoff.high - cutoff.low) / CHANCE.normal_95 / cutoff.number
    if not percent <= MOST_PERCENT:
        raise BadInput(
            f"{where}: the recording does not determine the cutoff within {MOST_PERCENT:g} %. Use "
            "a longer recording, or one at a higher rate"
        )
    return float(f"{max(percent, LEAST_PERCENT):.3g}")


def structure(model: Model, where: str) -> tuple[Term | None, list[Term]]:
    """(low-pass, moving averages) of a model; raises BadInput where the device has no such
    filter."""
    filters = [term for term in model.terms if part_of(term).effect.role == "filter"]
    if not filters:
        raise BadInput(
            f"{where}: the model has no filter. If the model is adequate, its samples are white: "
            "declare --bandwidth none, or davar_plan_init_white"
        )
    other = next((term.kind for term in filters if term.kind not in ACCEPTED), None)
    if other:
        raise BadInput(
            f"{where}: {other}: the device knows low_pass and moving_average only. "
            f"{table.find(other).confirm}"
        )
    low = [term for term in filters if term.kind == "low_pass"]
    if len(low) > 1:
        raise BadInput(
            f"{where}: two low_pass: the device knows one, of order 1 or 2. Fit a model with one "
            "of order 2, and check it with compare"
        )
    means = [term for term in filters if term.kind == "moving_average"]
    return (low[0] if low else None), means


def with_sizes(found: Declared, model: Model, window: int, where: str) -> Declared:
    """With the cluster sizes from which on the device's filter is the model's."""
    white = next((term for term in model.terms if term.kind == "angle_random_walk"), None)
    if white is None or not table.find(white.kind).dps(white.parameters):
        raise BadInput(f"{where}: the model has no angle_random_walk, which the device estimates")
    octaves = allan.octaves(window)[:SIZES_MOST]
    filters = [term for term in model.terms if term.kind in ACCEPTED]
    known, own = (
        noise_variance(Model(found.rate_hz, model.column, [white, *terms]), octaves, found.rate_hz)
        for terms in (found.terms, filters)
    )
    wrong = np.flatnonzero(np.abs(np.sqrt(own / known) - 1) > SAME)
    sizes = octaves[int(wrong[-1]) + 1 if len(wrong) else 0 :]
    if len(sizes) < SIZES_LEAST:
        raise BadInput(
            f"{where}: the device's filter ({found.bandwidth}) differs from the model's by more "
            f"than {100 * SAME:g} % of the Allan deviation at {octaves[int(wrong[-1])]} samples: "
            "the model has noise_behind_dps, another response, or too narrow a filter for "
            "--window. Give a larger --window, or fit a model with response = sampled and without "
            "noise_behind_dps"
        )
    found.sizes, found.octaves = tuple(sizes), tuple(octaves)
    return found


def of(model: Model, where: str, window: int, entries: list[Entry] | None) -> Declared:
    """The filter of a model. where: its file. window: of the device, in samples. entries: the
    estimates of the model's terms on a recording."""
    if not model.rate_hz:
        raise BadInput(f"{where}: the model has no rate_hz")
    low, means = structure(model, where)
    found = Declared(model.rate_hz)
    if low:
        share = float(low.parameters["cutoff_hz"]) / model.rate_hz
        if not CUTOFFS[0] <= share <= CUTOFFS[1]:
            raise BadInput(
                f"{where}: low_pass: cutoff_hz is {share:g} of the sample rate. The device knows "
                f"{CUTOFFS[0]:g} to {CUTOFFS[1]:g}. Average blocks of samples first, or leave out "
                "a wider filter"
            )
        entry = entries[model.terms.index(low)] if entries else None
        found.hz = float(f"{low.parameters['cutoff_hz']:.6g}")
        found.order = int(low.parameters.get("order", 1))
        found.percent = percent_of(entry, where)
    lengths = {round(float(term.parameters["samples"])) for term in means}
    if len(lengths) > 1 or len(means) > AVERAGES_MOST or max(lengths, default=1) > LENGTH_MOST:
        raise BadInput(
            f"{where}: moving_average: the device knows up to {AVERAGES_MOST} of the same length, "
            f"up to {LENGTH_MOST} samples. Fit a model with one length, and check it with compare"
        )
    found.averages, found.length = len(means), next(iter(lengths), 1)
    return with_sizes(found, model, window, where)


def notes(found: Declared, where: str, recording: str | None) -> list[str]:
    """What the numbers are, in sentences."""
    said = [f"The filter of {where}, by davarlab export --to plan."]
    if found.order:
        doubt = (
            "the accuracy of a data sheet. For that of the fit, give --recording"
            if recording is None
            else f"that of the fit to {recording}, at least {LEAST_PERCENT:g} %"
        )
        said += [
            f"Low-pass of order {found.order}, -3 dB at {found.hz:g} Hz. Its standard error of "
            f"{found.percent:g} % is {doubt}. Another unit of this gyro may differ by more."
        ]
    if found.averages:
        said += [f"Moving averages: {found.averages}, each of {found.length} samples."]
    missing = [m for m in found.octaves if m not in found.sizes]
    if missing:
        said += [
            f"Without the cluster sizes up to {missing[-1]}: there the model's filter differs from "
            f"the device's by more than {100 * SAME:g} % of the Allan deviation."
        ]
    return said


def fields(found: Declared) -> list[str]:
    """The members of davar_filter_t, computed as davar_bandwidth.h does from `bandwidth`."""
    low = [
        f".cutoff = {found.hz!r} / {found.rate_hz!r}, /* Hz over the sample rate */",
        f".uncertainty = 0.01 * {found.percent!r},",
        f".poles = {found.order}U,",
    ]
    mean = [f".averages = {found.averages}U,", f".length = {found.length}U,", ".decimation = 1U,"]
    return low * bool(found.order) + mean * bool(found.averages)


def comment(found: Declared, notes: list[str]) -> list[str]:
    """The head of the header: what it holds, and how to use it."""
    taus = f" --taus {','.join(map(str, found.sizes))}"
    bandwidth = f"--bandwidth {found.bandwidth}"
    cut = found.sizes != found.octaves
    said = [
        *(line for note in notes for line in textwrap.wrap(note.replace("*/", "* /"), WIDTH)),
        "",
        "    davar_plan_init_filtered(&plan, davar_gyro_taus, DAVAR_GYRO_TAU_COUNT,",
        "                             &davar_gyro_filter);",
        "",
        "The configuration needs the same cluster sizes. The plan can also be made at build time:",
        "",
        f"    tools/davar-plan{taus} {bandwidth} --rate {found.rate_hz:.9g}",
        "",
        f"On a recording: davar-sim REC {bandwidth}{taus if cut else ''}",
        f'In Python: bandwidth="{found.bandwidth}"'
        + (f", clusters={[*found.sizes]}" if cut else ""),
    ]
    return ["/* " + said[0], *(f" * {line}".rstrip() for line in said[1:]), " */"]


def text(found: Declared, notes: list[str]) -> str:
    """A C header for davar_plan_init_filtered."""
    body = [
        "#ifndef DAVAR_GYRO_FILTER_H",
        "#define DAVAR_GYRO_FILTER_H",
        "",
        '#include "davar/fit.h"',
        "",
        "static const davar_filter_t davar_gyro_filter = {",
        *(f"    {field}" for field in fields(found)),
        "};",
        "",
        f"#define DAVAR_GYRO_TAU_COUNT {len(found.sizes)}",
        "",
        "static const uint32_t davar_gyro_taus[DAVAR_GYRO_TAU_COUNT] = {",
        f"    {', '.join(f'{m}U' for m in found.sizes)},",
        "};",
        "",
        "#endif",
    ]
    return "\n".join([*comment(found, notes), *body]) + "\n"


def plain(found: Declared) -> dict[str, Any]:
    """For --json."""
    return {
        "bandwidth": found.bandwidth,
        "cutoff_hz": found.hz or None,
        "cutoff_percent": found.percent if found.order else None,
        "order": found.order,
        "averages": found.averages,
        "length": found.length if found.averages else None,
        "rate_hz": found.rate_hz,
        "taus": list(found.sizes),
    }
