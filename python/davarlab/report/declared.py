"""The filter of a fitted model as the device declares it: davar_filter_t in C, and --bandwidth.

The export knows one low-pass of order 1 or 2, sampled with its images or bilinear, then filters as
--bandwidth has them, then equal moving averages. The file lists the cluster sizes at which white
noise after that filter has the Allan deviation of everything in the model but its drifts, and the
options with which davar-sim reads the same recording (DESIGN 11)."""

import math
import textwrap
from ctypes import c_double
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Floats
from ..data import counts
from ..data.recording import Recording
from ..effects import table
from ..effects.device import Filter, filter_of
from ..errors import BadInput
from ..inference import allan
from ..inference.estimate import Entry
from ..inference.parts import part_of, spectrum_of
from ..model import Model, Term, rate_of
from ..thresholds import CHANCE, DEVICE
from .export import noise_variance
from .words import in_c_comment

CUTOFFS = {"sampled": (0.002, 4.0), "bilinear": (0.002, 0.499)}  # over the sample rate
AVERAGES_MOST, SPAN_MOST, SIZES_MOST = 8, 1024, 32  # as davar/filter.h
WINDOW, WINDOW_MOST = 600, 2**16  # samples: the default of davar-sim, and what is worth proposing
WIDTH = 95  # of a line of the comment
ACCEPTED = ("low_pass", "moving_average")
LINES = ("sinusoid", "narrow_band")
# Parameter of the time, and the hump of the Allan deviation over it.
FLUCTUATIONS = {
    "gauss_markov": ("correlation_time_s", 1.9),
    "telegraph_noise": ("mean_dwell_s", 0.95),
}


@dataclass
class Declared:
    """hz, order, response: of the low-pass; 0: none. percent: one standard error of hz. others:
    what follows it, as --bandwidth has it. window: of the device, in samples. sizes: the cluster
    sizes that it can use, of `octaves`. lsb: one count of the recording, deg/s; 0: unknown.
    states_rate: davar-sim would read another rate. lost: samples are missing, which davar-sim with
    --rate does not look for without --gap."""

    rate_hz: float
    hz: float = 0.0
    order: int = 0
    response: str = "sampled"
    percent: float = 0.0
    others: tuple[str, ...] = ()
    window: int = WINDOW
    sizes: tuple[int, ...] = ()
    octaves: tuple[int, ...] = ()
    lsb: float = 0.0
    states_rate: bool = False
    lost: bool = False

    @property
    def bandwidth(self) -> str:
        """As davar-sim, davar-plan, davar-node and the Python package take it."""
        low = f"{self.hz:.6g}:{self.order}:{self.percent:.3g}" if self.order else ""
        if self.order and self.response == "bilinear":
            # ba: states an uncertainty of ARW. That of hz changes ARW by as much at most.
            edge = math.tan(math.pi * self.hz / self.rate_hz)
            b, a = edge / (1 + edge), (edge - 1) / (edge + 1)
            low = f"ba:{b:.9g},{b:.9g}:{a:.9g}:{self.percent:.3g}"
            low = f"biquad:{self.hz:.6g}:{self.percent:.3g}" if self.order == 2 else low
        return "+".join(filter(None, (low, *self.others))) or "none"

    @property
    def filter(self) -> Filter:
        return filter_of(self.bandwidth, self.rate_hz)

    @property
    def options(self) -> list[str]:
        """Of davar-sim, for the recording."""
        words = ["--bandwidth", self.bandwidth]
        if self.window != WINDOW:
            words += ["--window-max", str(self.window)]
        if self.sizes != self.octaves:
            words += ["--taus", ",".join(map(str, self.sizes))]
        if self.lsb:
            words += ["--lsb", f"{self.lsb:.9g}"]
        if self.states_rate:
            gap = ["--gap", f"{DEVICE.gap_periods:g}"]
            words += ["--rate", f"{self.rate_hz:.9g}"] + gap * self.lost
        return words

    @property
    def terms(self) -> list[Term]:
        low = Term("low_pass", {"cutoff_hz": self.rate_hz / 2, "response": self.bandwidth})
        return [] if self.bandwidth == "none" else [low]


def percent_of(entry: Entry | None, where: str) -> float:
    """One standard error of the cutoff. entry: its estimate; None without a recording."""
    if entry is None:
        return DEVICE.sheet_percent
    cutoff = entry["cutoff_hz"]
    if cutoff.low is None or cutoff.high is None:
        percent = math.inf
    else:
        percent = 50 * (cutoff.high - cutoff.low) / CHANCE.normal_95 / cutoff.number
    if not percent <= DEVICE.most_percent:
        raise BadInput(
            f"{where}: the recording does not determine the cutoff within "
            f"{DEVICE.most_percent:g} %. Use "
            "a longer recording, or one at a higher rate"
        )
    return float(f"{max(percent, DEVICE.least_percent):.3g}")


def filtered(model: Model) -> list[Term]:
    """Its filters."""
    return [term for term in model.terms if part_of(term).effect.role == "filter"]


def structure(model: Model, where: str) -> tuple[Term | None, list[str]]:
    """(low-pass, the other filters as --bandwidth has them) of a model; raises BadInput where the
    device has no such filter."""
    filters = filtered(model)
    other = next((term.kind for term in filters if term.kind not in ACCEPTED), None)
    if other:
        raise BadInput(
            f"{where}: {other}: the device knows {' and '.join(ACCEPTED)} only. "
            f"{table.find(other).confirm}"
        )
    others = list(filter(None, (part_of(term).any_response for term in filters)))
    low = [term for term in filters if term.kind == "low_pass" and not part_of(term).any_response]
    if len(low) > 1:
        raise BadInput(
            f"{where}: two low_pass: the device knows one, of order 1 or 2. Fit a model with one "
            "of order 2, and check it with compare"
        )
    means = [term for term in filters if term.kind == "moving_average"]
    return (low[0] if low else None), [*others, *averages(means, where)]


def averages(means: list[Term], where: str) -> list[str]:
    lengths = {round(float(term.parameters["samples"])) for term in means}
    if len(lengths) > 1:
        raise BadInput(
            f"{where}: moving_average: {len(lengths)} lengths; the device knows one. Fit a model "
            "with one length, and check it with compare"
        )
    length = next(iter(lengths), 1)
    if len(means) > AVERAGES_MOST or len(means) * length > SPAN_MOST:
        raise BadInput(
            f"{where}: moving_average: {len(means)} of {length} samples; the device knows up to "
            f"{AVERAGES_MOST}, together up to {SPAN_MOST} samples. Average blocks of samples first"
        )
    count = "" if len(means) == 1 else str(len(means))
    return [f"average{count}:{length}"] if length > 1 else []


# What the device reads ----------------------------------------------------------------------------


def steady(model: Model, longest_s: float) -> list[tuple[str, Term]]:
    """The terms that the device has no coefficient for, as (their kind, noise or a line that is
    always there): lines, and a fluctuation whose hump lies within the cluster times."""
    found: list[tuple[str, Term]] = []
    for term in model.terms:
        values = term.parameters
        if term.kind == "intermittent_line":
            frequencies = [float(values["frequency_hz"])]
        elif term.kind == "drifting_line":
            frequencies = [float(word) for word in str(values["course_hz"]).split()]
        else:
            time, hump = FLUCTUATIONS.get(term.kind, ("", 0.0))
            own = bool(time) and hump * float(values[time]) < longest_s
            found += [(term.kind, term)] * (own or term.kind in LINES)
            continue
        # The mean over its course: the power is shared among the frequencies.
        size = float(values["amplitude_dps"]) / math.sqrt(len(frequencies))
        found += [
            (term.kind, Term("sinusoid", {"amplitude_dps": size, "frequency_hz": f}))
            for f in frequencies
        ]
    return found


@dataclass
class Reading:
    """sizes: the cluster sizes of a window. off: relative difference of the Allan deviation there
    from that of the device's white noise; `filters`: the part of it that the filters have.
    covariance: of the Allan deviations of a window, relative."""

    sizes: list[int]
    off: Floats
    filters: Floats
    covariance: Floats

    def weights(self, first: int) -> tuple[Floats, float]:
        """Generalised least squares from the sizes from `first` on, as the device's fit (5.7): the
        weight of each in ARW, and the relative standard error of ARW."""
        row = np.linalg.inv(self.covariance[first:, first:]).sum(axis=0)
        return row / row.sum(), float(1 / np.sqrt(row.sum()))

    @property
    def undeclared(self) -> tuple[float, float]:
        """(how far off ARW is, its standard error), relative, of the fit without a filter. If the
        long sizes read low, and white noise does not explain the window, that fit adds quantization
        (5.17)."""
        inverse = np.linalg.inv(self.covariance)
        weights, error = self.weights(0)
        bias = float(weights @ self.off)
        rest = self.off - bias
        if bias < 0 or rest @ inverse @ rest < DEVICE.detected:
            return bias, error
        terms = np.array([np.ones(len(self.sizes)), 1 / np.array(self.sizes)])
        solved = np.linalg.inv(terms @ inverse @ terms.T)
        return float((solved @ terms @ inverse @ self.off)[0]), float(np.sqrt(solved[0, 0]))

    def usable(self, first: int) -> bool:
        """Is ARW from these sizes off by few standard errors (bias_most), even if all differences
        add up?"""
        weights, error = self.weights(first)
        return bool(np.abs(weights) @ np.abs(self.off[first:]) <= DEVICE.bias_most * error)

    @property
    def first(self) -> int:
        """Index of the first size that the device can use, or the number of sizes."""
        return next(filter(self.usable, range(len(self.sizes))), len(self.sizes))

    @property
    def left(self) -> int:
        return len(self.sizes) - self.first


def covariance_of(device: Model, rate_hz: float, sizes: list[int], window: int) -> Floats:
    """Relative covariance of the Allan deviations of Gaussian noise in a window (5.16)."""
    _, width = allan.grid()
    spectrum = spectrum_of([part_of(term) for term in device.terms], [1.0], rate_hz)
    power = allan.on_grid(spectrum, rate_hz)
    rows = np.array([power * allan.response(m) for m in sizes]).reshape(len(sizes), -1)
    rows /= rows.sum(axis=1)[:, None]
    found: Floats = (rows / width) @ rows.T / (4 * window)
    return found + DEVICE.grid_accuracy**2 * np.eye(len(sizes))


def white_of(model: Model) -> Term | None:
    """Its angle random walk, unless that is 0."""
    return next(
        (
            t
            for t in model.terms
            if t.kind == "angle_random_walk" and part_of(t).effect.dps(t.parameters)
        ),
        None,
    )


def doubt_of(found: Declared, white: Term, sizes: list[int]) -> Floats:
    """Relative covariance of the Allan deviations of the device by the doubt about its cutoff, and
    about the angle random walk after a filter that was learned."""
    doubt: Floats = np.zeros(len(sizes))
    if found.filter.uncertainty:
        above, below = (
            deviations(found.rate_hz, [white, *replace(found, hz=found.hz * step).terms], sizes)
            for step in (1 + DEVICE.cutoff_step, 1 - DEVICE.cutoff_step)
        )
        doubt = found.percent / 100 * (above - below) / (above + below) / DEVICE.cutoff_step
    covariance: Floats = np.outer(doubt, doubt) + found.filter.level**2
    return covariance


def deviations(rate_hz: float, terms: list[Term], sizes: list[int]) -> Floats:
    found: Floats = np.sqrt(noise_variance(Model(rate_hz, "", terms), sizes, rate_hz))
    return found


def reading(model: Model, white: Term, found: Declared, window: int) -> Reading:
    """found: the filter that the device declares."""
    known = found.terms
    sizes, rate_hz = allan.octaves(window)[:SIZES_MOST], found.rate_hz
    filters = filtered(model)
    extra = [term for _, term in steady(model, sizes[-1] / rate_hz if sizes else 0.0)]
    angle = [term for term in model.terms if term.kind == "quantization"]
    device, passing, own = (
        deviations(rate_hz, [white, *terms], sizes)
        # Without a filter, the device estimates the quantization of the angle itself.
        for terms in (
            known or angle,
            [*filters, *angle],
            [*filters, *angle, *extra],
        )
    )
    passed = Model(rate_hz, model.column, [white, *known])
    covariance = covariance_of(passed, rate_hz, sizes, window) + doubt_of(found, white, sizes)
    return Reading(sizes, own / device - 1, passing / device - 1, covariance)


def with_sizes(found: Declared, model: Model, where: str) -> Declared:
    """With the cluster sizes from which on the device reads the ARW of the model."""
    white = white_of(model)
    if white is None:
        raise BadInput(f"{where}: the model has no angle_random_walk, which the device estimates")
    one = reading(model, white, found, found.window)
    if one.left < DEVICE.sizes_least:
        raise BadInput(
            f"{where}: {unusable(found, model, one)}. {way_on(found, model, white, one)}"
        )
    found.sizes, found.octaves = tuple(one.sizes[one.first :]), tuple(one.sizes)
    return found


def by_filter(one: Reading) -> bool:
    """Is it the filter, and not lines or a fluctuation, at the size where it has to end?"""
    last = max(-DEVICE.sizes_least, -len(one.sizes))
    return bool(abs(one.filters[last]) >= abs(one.off[last] - one.filters[last]))


def unusable(found: Declared, model: Model, one: Reading) -> str:
    """Why the device cannot give the model's ARW."""
    said = f"the device cannot give the model's ARW in windows of {found.window} samples: "
    if len(one.sizes) < DEVICE.sizes_least:
        return f"{said}they have fewer than {DEVICE.sizes_least} cluster sizes"
    last = -DEVICE.sizes_least
    at = f"the Allan deviation at {one.sizes[last]} samples"
    if by_filter(one):
        return (
            f"{said}{at} differs by {100 * abs(one.filters[last]):.2g} % from that after the "
            f"device's filter ({found.bandwidth}), because the model has noise_behind_dps, another "
            "response, or too narrow a filter"
        )
    kinds = sorted({kind for kind, _ in steady(model, one.sizes[-1] / found.rate_hz)})
    return (
        f"{said}{' and '.join(kinds)} {'changes' if len(kinds) == 1 else 'change'} {at} by "
        f"{100 * abs(one.off[last] - one.filters[last]):.0f} %, and the device cannot distinguish "
        "that from white noise"
    )


def way_on(found: Declared, model: Model, white: Term, one: Reading) -> str:
    larger = larger_window(model, white, found)
    if larger:
        return f"Give --window {larger}"
    if by_filter(one):
        return "Fit a model with response = sampled and without noise_behind_dps"
    return "Remove the cause of it, and record again"


def larger_window(model: Model, white: Term, found: Declared) -> int:
    """The least doubling of the window with enough usable sizes; 0: none up to WINDOW_MOST."""
    window = 2 * found.window
    while window <= WINDOW_MOST:
        one = reading(model, white, found, window)
        if one.left >= DEVICE.sizes_least:
            return window
        window *= 2
    return 0


def default_said(model: Model, lsb: float, window: int = WINDOW) -> str:
    """What the device gives without the options of an export, where that is wrong; "" where it is
    not. lsb: one count of the recording, deg/s; 0: unknown."""
    white = white_of(model)
    if white is None or not model.rate_hz or not allan.octaves(window):
        return ""
    one = reading(model, white, Declared(model.rate_hz), window)
    power = part_of(white).effect.dps(white.parameters) ** 2 * model.rate_hz
    added = np.sqrt(1 + lsb**2 / 12 / power) - 1
    bias, error = one.undeclared
    if abs(bias) <= DEVICE.bias_most * error:
        if added < DEVICE.rounding_share / 2:
            return ""
        return (
            "Without --lsb, the device's ARW includes the rounding to counts and is about "
            f"{100 * added:.2g} % too high; export --to plan --recording prints the options."
        )
    if filtered(model):
        told = "Without --bandwidth, the device takes the ARW from the long cluster sizes, with a "
        told += "wider interval, or withholds it"
    else:
        told = "Without --taus, the device withholds the ARW or reports one about "
        told += f"{100 * abs(bias):.2g} % too {'high' if bias > 0 else 'low'}"
    return f"{told}, in windows of {window} samples; export --to plan prints the options."


def count_of(recording: Recording, column: str) -> float:
    """One count of a gyro's column, deg/s; 0: it is not on a grid."""
    known = slice(None) if recording.known is None else recording.known
    return counts.step(recording.rate_dps(column)[known])


def states_rate(recording: Recording) -> bool:
    """Would davar-sim take another rate from the median step of the time stamps?"""
    stamps = recording.columns.get("time_s")
    if stamps is None or len(stamps) < 2:
        return True
    step = float(np.median(np.diff(stamps)))
    return not abs(step * recording.rate_hz - 1) < DEVICE.rates_differ


def declare(
    model: Model,
    where: str,
    window: int,
    entries: list[Entry] | None = None,
    recording: Recording | None = None,
) -> Declared:
    """The filter of a model. where: its file. window: of the device, in samples. entries: the
    estimates of the model's terms on the recording."""
    rate_hz = rate_of(model, where)
    if recording and model.column not in recording.gyros:
        raise BadInput(f"{where}: {model.column} is not the column of a gyro, as --to plan needs")
    low, others = structure(model, where)
    found = Declared(rate_hz, others=tuple(others), window=window)
    if recording:
        found.lsb = count_of(recording, model.column)
        found.states_rate = states_rate(recording)
        found.lost = recording.measured_samples < recording.samples
    if low:
        share = float(low.parameters["cutoff_hz"]) / rate_hz
        found.response = str(low.parameters.get("response", "sampled"))
        found.response = "bilinear" if found.response == "bilinear" else "sampled"
        least, most = CUTOFFS[found.response]
        if not least <= share <= most:
            raise BadInput(
                f"{where}: low_pass: cutoff_hz is {share:g} of the sample rate. The device knows "
                f"{least:g} to {most:g}. Average blocks of samples first, or leave out "
                "a wider filter"
            )
        entry = entries[model.terms.index(low)] if entries else None
        found.hz = float(f"{low.parameters['cutoff_hz']:.6g}")
        found.order = int(low.parameters.get("order", 1))
        found.percent = percent_of(entry, where)
    try:
        _ = found.filter
    except BadInput as why:
        raise BadInput(f"{where}: {why}") from None
    return with_sizes(found, model, where)


def notes(found: Declared, model: Model, where: str, recording: str | None) -> list[str]:
    """What the numbers are, in sentences."""
    said = [f"The filter of {where}, by davarlab export --to plan."]
    if found.order:
        doubt = (
            "the accuracy of a data sheet. For that of the fit, give --recording"
            if recording is None
            else f"that of the fit to {recording}, at least {DEVICE.least_percent:g} %"
        )
        said += [
            f"Low-pass of order {found.order}, {found.response}, -3 dB at {found.hz:g} Hz. Its "
            f"standard error of {found.percent:g} % is {doubt}. Another unit of this gyro may "
            "differ by more."
        ]
    if found.others:
        lists = sum(one.startswith("ba:") for one in found.others)
        named = [one for one in found.others if not one.startswith("ba:")]
        known = ["coefficients that were learned"] * lists + named
        said += [f"Filter: {', then '.join(known)}."]
    if found.bandwidth == "none":
        said += ["No filter: the noise is white from the smallest cluster size listed here on."]
    for term in model.terms:
        if term.kind == "line_follows":
            said += [
                f"Without the line that follows {term.parameters['column']}: its frequency is not "
                "known here."
            ]
    missing = [m for m in found.octaves if m not in found.sizes]
    if missing:
        said += [
            f"Without the cluster sizes up to {missing[-1]}: there the Allan deviation of the "
            "model's filter, lines and noise after the filter differs from that of white noise "
            "after the device's filter, so that the ARW would be off by more than "
            f"{DEVICE.bias_most:g} standard errors in a window of {found.window} samples."
        ]
    changing = sorted({t.kind for t in model.terms if part_of(t).effect.role == "variance"})
    if changing:
        said += [
            f"The noise of the model changes ({', '.join(changing)}): a window gives the ARW of "
            "its own time, which differs from the model's angle_random_walk."
        ]
    if found.lsb:
        said += [f"One count of {recording} is {found.lsb:.6g} deg/s (unit_per_count, --lsb)."]
    default = default_said(model, found.lsb, found.window)
    return said + [default] * bool(default)


def fields(found: Filter) -> list[str]:
    """Those of davar_filter_t that are not 0, in lines."""
    lines = []
    for name, of_c in Filter._fields_:
        value = getattr(found, name)
        if not isinstance(value, (int, float)):
            numbers = np.trim_zeros(list(value), "b")
            value = f"{{{', '.join(f'{one:.17g}' for one in numbers)}}}" if len(numbers) else ""
        elif of_c is c_double:
            value = f"{value:.17g}" if value else ""
        if value:
            lines += textwrap.wrap(f".{name} = {value},", WIDTH - 8, subsequent_indent="    ")
    return lines or [".b = {0.0},"]


def command(text: str) -> list[str]:
    """A command for a shell, in lines of a comment."""
    lines = textwrap.wrap(text, WIDTH - 6, break_on_hyphens=False, break_long_words=False)
    return [f"    {line} \\" for line in lines[:-1]] + [f"    {lines[-1]}"]


def comment(found: Declared, notes: list[str]) -> list[str]:
    """The head of the header: what it holds, and how to use it."""
    taus = f" --taus {','.join(map(str, found.sizes))}"
    bandwidth = f"--bandwidth {found.bandwidth}"
    cut = found.sizes != found.octaves
    said = [
        *(line for note in notes for line in textwrap.wrap(in_c_comment(note), WIDTH)),
        "",
        "    const davar_filter_t filter = davar_gyro_filter();",
        "    davar_plan_init_filtered(&plan, davar_gyro_taus, DAVAR_GYRO_TAU_COUNT, &filter);",
        "",
        "The configuration needs the same cluster sizes. The plan can also be made at build time:",
        "",
        *command(f"tools/davar-plan{taus} {bandwidth} --rate {found.rate_hz:.9g}"),
        "",
        "On a recording:",
        "",
        *command(f"davar-sim REC {' '.join(found.options)}"),
        "",
        "In Python:",
        "",
        f'    bandwidth="{found.bandwidth}"' + (f", clusters={[*found.sizes]}" if cut else ""),
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
        "static inline davar_filter_t davar_gyro_filter(void)",
        "{",
        "    return (davar_filter_t){",
        *(f"        {line}" for line in fields(found.filter)),
        "    };",
        "}",
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
        "rate_hz": found.rate_hz,
        "window": found.window,
        "lsb_dps": found.lsb or None,
        "options": found.options,
        "taus": list(found.sizes),
    }
