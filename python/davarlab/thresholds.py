"""The numbers that decide, in one frozen table: one name, one meaning, a unit and a source each.

A source is a chapter or formula of DESIGN.md, or a measurement. "choice" marks a number that was
set by judgement. The benchmarks of docs/quality/lab_benchmark.md were measured with it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from .distributions import norm_ppf


def threshold(value: object, unit: str, source: str, meaning: str) -> Any:
    """A field of the table. `meaning` continues "value, unit". Mappings are read-only."""
    said = {"unit": unit, "source": source, "meaning": meaning}
    if isinstance(value, dict):
        value = MappingProxyType(value)
    return field(default_factory=lambda: value, metadata=said)


@dataclass(frozen=True)
class Chance:
    """Chance, and when two models are one: for search, judge, report and davarfleet."""

    family_wise: float = threshold(
        0.01,
        "chance",
        "DESIGN 4.1, 7.2",
        "that any of the tests of one decision is beyond its bound by chance",
    )
    adequate_p: float = threshold(
        0.01,
        "chance",
        "DESIGN 7",
        "p of the residual, from which a model is statistically adequate",
    )
    tell_apart: float = threshold(
        3.0, "log-likelihood", "DESIGN 4", "within which a recording cannot tell two models"
    )
    bend: float = threshold(
        3.3,
        "log-likelihood",
        "half of the 99 % point of one chi-square (DESIGN 4)",
        "that an effect gains over a simpler one nested in it",
    )
    apart_sigmas: float = threshold(
        2.33,
        "standard deviations",
        "Vuong's test at 1 % (DESIGN 4)",
        "of a gain over a rival, by which it is one",
    )
    above_floor: float = threshold(
        1.25,
        "times the floor",
        "99.5 % of true models are below (DESIGN 7)",
        "from which an error is more than a true model's",
    )
    held_out_above_floor: float = threshold(
        1.5,
        "times the floor",
        "choice",
        "the same for parameters that were fitted on another recording",
    )
    normal_95: float = threshold(
        float(norm_ppf(0.975)),
        "standard errors",
        "95 % of a normal distribution",
        "half width of every interval",
    )


@dataclass(frozen=True)
class Judge:
    """Is a model adequate (diagnosis/judge.py, cells.py, inference/adequacy.py)."""

    tolerance: float = threshold(
        1.05,
        "ratio of Allan deviations",
        "DESIGN 7",
        "that matters to nobody: practically adequate",
    )
    one_sided_95: float = threshold(
        1.645,
        "standard errors",
        "95 % of a normal distribution, one side (DESIGN 7.3)",
        "up to which the record shows the tolerance",
    )
    independent_tests: int = threshold(
        3,
        "tests",
        "measured: davarlab nulls --adequacy-only (DESIGN 7.1)",
        "that the list of tests of the residual amounts to",
    )
    octave_bands: int = threshold(
        14, "bands", "choice", "of the cells in time and frequency, at most"
    )
    time_stretches: int = threshold(
        24, "stretches", "DESIGN 7.1", "of the record, of the cells in time and frequency"
    )
    narrow_ordinates: int = threshold(401, "ordinates", "DESIGN 7.1", "of a narrow band")
    cell_windows: tuple[int, ...] = threshold(
        (1, 4, 16), "parts of the record", "DESIGN 8", "windows of the Allan map"
    )
    short_windows: int = threshold(
        64,
        "parts of the record",
        "DESIGN 7.2",
        "windows whose shortest averaging time alone is tested: noise that breathes "
        "faster than a sixteenth of the record",
    )
    means: int = threshold(
        16,
        "samples",
        "DESIGN 8.6",
        "in a block mean; clusters of lags_per_cluster such means and more begin at every mean",
    )
    means_from: int = threshold(
        2_000_000, "samples", "choice (DESIGN 8.6)", "of a record that is measured on means"
    )
    valid_share: float = threshold(
        0.1,
        "of the share of known samples",
        "choice",
        "that differences in known samples have, above which a window has an averaging time",
    )
    rows: int = threshold(
        16,
        "samples of the grid",
        "DESIGN 8.5",
        "in a cluster of rows by their stamps: long enough that one row more hardly matters",
    )
    rows_share: float = threshold(
        0.75, "share of the usual number", "choice", "of rows, above which a cluster has no hole"
    )
    course_turns: float = threshold(
        2.0,
        "turns",
        "DESIGN 8.4",
        "in a window, below which a line with a width is a course and no noise",
    )
    cluster_octaves: int = threshold(24, "octaves", "choice", "of cluster sizes, at most")
    parseval_clusters: int = threshold(
        64,
        "cluster sizes",
        "DESIGN 8.3",
        "in a window, from which its length does not bear on how differences go together",
    )
    lags_per_cluster: int = threshold(
        16, "lags", "DESIGN 8.3", "of a cluster size, in a shorter window"
    )


@dataclass(frozen=True)
class Reading:
    """The angle random walk that is read off the record (inference/reading.py, DESIGN 7.6)."""

    from_tau_s: float = threshold(
        0.45, "s", "choice: an octave about 1 s", "first Allan deviation that is read"
    )
    to_tau_s: float = threshold(4.5, "s", "choice: two octaves above 1 s", "last one")
    low_hz: float = threshold(0.1, "Hz", "choice: slower noise is seldom white", "first density")
    high_hz: float = threshold(1.0, "Hz", "choice: below the filters of sensors", "last density")
    points: int = threshold(
        7, "frequencies", "choice", "at which the spectrum of an effect is looked at"
    )
    flat: float = threshold(
        1.3, "ratio of densities", "choice", "below which an effect stands for white noise there"
    )
    line_widths: float = threshold(3.0, "half widths", "choice", "beside a line that are not read")
    bins_least: int = threshold(5, "bins", "choice", "of a density that is read")
    shared: float = threshold(
        1.4,
        "ratio",
        "choice: Allan deviations of neighbouring octaves share most of their frequencies",
        "by which the mean of several deviations scatters more",
    )
    none: float = threshold(
        1e-9, "deg/sqrt(h)", "choice", "below which a model has no angle random walk"
    )
    errors: float = threshold(
        float(norm_ppf(0.995)), "standard errors", "99 % of a normal distribution", "of a reading"
    )


@dataclass(frozen=True)
class Place:
    """What the place of a misfit suggests to measure next (diagnosis/unexplained.py)."""

    part_of_record: float = threshold(
        0.9, "of the record", "choice", "below which the section of a misfit is only a part"
    )
    slow_samples: int = threshold(
        256, "samples", "choice", "of averaging, from which a misfit is slow"
    )
    fast_samples: int = threshold(16, "samples", "choice", "of averaging, up to which it is fast")


@dataclass(frozen=True)
class Start:
    """May a recording be analysed at all (diagnosis/fitting.py)."""

    least_s: int = threshold(
        4, "s", "choice", "length of a recording: slow noise is told from what a second holds"
    )
    moving_share: float = threshold(
        0.02, "share of the samples", "choice", "that differs from the sample before"
    )
    few_known: float = threshold(
        0.4,
        "share of the samples",
        "choice (DESIGN 12.2)",
        "that is known, below which any model is a better guess of what is missing",
    )
    moved_most: float = threshold(
        0.5,
        "share of the samples",
        "choice (DESIGN 13.1)",
        "with motion, from which none is a rest",
    )
    few_draws: int = threshold(
        2, "draws", "choice (DESIGN 12.2)", "of the missing samples at first, where few are known"
    )
    far_p: float = threshold(
        1e-9,
        "chance",
        "choice (DESIGN 12.2)",
        "p of the spectrum, below which a model is no guess of what is missing",
    )


@dataclass(frozen=True)
class Search:
    """The way from the given model to the last (diagnosis/search.py)."""

    steps_most: int = threshold(24, "steps", "choice", "of a search")
    fits_most: int = threshold(
        20000,
        "fits of sizes",
        "choice: usual searches take 300 to 3000 (DESIGN 4)",
        "of a search; the step that reaches it is its last",
    )
    slack: float = threshold(
        0.02, "of the floor", "DESIGN 4", "by which a likelier term may leave the error higher"
    )
    over_at_once: float = threshold(
        0.01,
        "of the record",
        "DESIGN 4",
        "time constant of a warm-up below which it must lower the error",
    )
    put_off_chance: float = threshold(
        0.2, "chance", "choice", "of a gain, from which a candidate is put off"
    )
    noise_steps_most: int = threshold(
        12, "steps", "choice", "of a search that only asks for what the noise needs"
    )
    certain: float = threshold(
        50.0, "log-likelihood", "DESIGN 4", "from which a part stays, whatever the filters do"
    )
    most_of: Mapping[str, float] = threshold(
        {
            "sinusoid": 4,
            "narrow_band": 8,
            "intermittent_line": 4,
            "drifting_line": 4,
            "line_follows": 4,
            "bias_step": 4,
        },
        "effects",
        "DESIGN 4",
        "that a sensor may have of a kind, where more than one",
    )
    warm_ups_most: int = threshold(
        2, "effects", "choice", "warm-ups of a sensor: of the chip and of the case"
    )
    shapes_fitted: int = threshold(
        4, "shapes", "DESIGN 4", "of an effect that are fitted, the best by their score"
    )
    robust_from: float = threshold(
        3.0,
        "log-likelihood",
        "choice (DESIGN 4)",
        "from which the scatter of the products themselves is measured",
    )
    wide_band: float = threshold(
        0.1,
        "of the frequency",
        "choice",
        "width of a band from which on it may be the edge of a filter",
    )
    learned_least: float = threshold(
        0.01,
        "of the rate",
        "measured (lib/src/fit/DESIGN.md)",
        "cutoff of a filter of any shape, below which it is slow noise",
    )
    filter_rounds: int = threshold(
        4,
        "rounds",
        "choice",
        "of a filter of any shape and what is beside it, each after the other",
    )
    line_sigmas: float = threshold(
        5.0, "standard errors", "DESIGN 2", "above a filter of any shape and line_excess"
    )
    line_excess: float = threshold(
        1.5, "times", "choice", "what a filter of any shape leaves, from which a bin is a line"
    )
    first_log_p: float = threshold(
        -1e9,
        "logarithm",
        "choice (DESIGN 2)",
        "of the chance of a filter of any shape beside which nothing in the spectrum is left: "
        "before all others",
    )
    crude_gain: float = threshold(
        6.0,
        "log-likelihood",
        "choice",
        "of the best of a grid, from which a filter or a second warm-up is worth a closer look",
    )


@dataclass(frozen=True)
class Tries:
    """Independent tries that a free shape amounts to: C of DESIGN 4.1, by davarlab nulls."""

    of_kind: Mapping[str, float] = threshold(
        {
            "quantization": 0.66,
            "angle_random_walk": 0.5,
            "bias_instability": 1.0,
            "rate_random_walk": 0.35,
            "gauss_markov": 3.7,
            "telegraph_noise": 3.7,
            "low_pass": 1.0,
            "moving_average": 1.0,
            "high_pass": 3.0,
            "warm_up": 2.1,
            "rate_ramp": 0.83,
            "sinusoid": 3.1,
            "temperature_rate": 1.8,
            "g_sensitivity": 4.8,
            "vibration_rectification": 8.0,
            "vibration_noise": 2.8,
            "noise_step": 1.1e4,
        },
        "tries",
        "measured on 240 recordings of 2 h, rounded up in the second digit; raised when they "
        "gained variants: temperature_rate, vibration_noise, vibration_rectification; not "
        "measured: angle_random_walk and bias_instability (in every model there), filters (a "
        "bound). docs/quality/lab_benchmark.md has a later check on 100 recordings",
        "of a kind; of a line per sample",
    )
    of_own_effect: float = threshold(3.0, "tries", "choice", "of an effect of one's own")
    of_band: float = threshold(
        150.0,
        "tries",
        "measured as of_kind",
        "of a line with a width: tries (n / band_samples)^band_growth exp(-gain)",
    )
    band_samples: float = threshold(1e4, "samples", "measured as of_kind", "that of_band is for")
    band_growth: float = threshold(
        0.4,
        "exponent",
        "measured as of_kind",
        "with which the tries of a line with a width grow with the samples",
    )
    of_column: Mapping[str, float] = threshold(
        {
            "temperature": 3.2,
            "temperature beside": 5.1,
            "temperature_squared": 5.5,
            "temperature_hysteresis": 3.5,
            "temperature_noise": 1.4,
            "follows": 4.4,
            "noise_follows": 0.6,
        },
        "tries",
        "null recordings; follows, per column: 240 clean recordings of 20 minutes; noise_follows, "
        "per column: 400 of them with three columns (DESIGN 4)",
        "of an effect on a column: alone, or where the temperature is in the model already",
    )
    of_multiple: float = threshold(
        3.1,
        "tries per turn",
        "measured on 120 records of white noise with 20 000 and 120 000 samples (DESIGN 4)",
        "of a line at a multiple of a column, of multiple_highest turns per sample",
    )
    of_interval: float = threshold(
        4.0,
        "tries per sample",
        "measured on 150 records of 20 000 and 60 of 100 000 samples: 1.6 and 3.4 at "
        "the largest 5 % (DESIGN 15.2)",
        "of a line that comes and goes: tries n gain^2 exp(-gain), each end of the "
        "interval being a gain's worth of tries",
    )


@dataclass(frozen=True)
class Line:
    """Lines: candidates/lines.py, intermittent.py, doubts.py, inference/refine.py."""

    apart: float = threshold(
        0.1,
        "of its frequency",
        "DESIGN 4",
        "how far from a sharp line another one is a line of its own, with apart_bins",
    )
    apart_bins: int = threshold(20, "half bins", "choice", "added to apart")
    multiple_highest: int = threshold(
        2, "times the sample rate", "choice", "frequency of a line at a multiple of a column"
    )
    multiple_turns: int = threshold(
        10, "turns", "choice", "in the record, below which a multiple of a column is not tried"
    )
    multiple_apart: float = threshold(
        0.25,
        "of the range of its frequency",
        "choice",
        "by which such a line may move apart from the column",
    )
    multiple_moves: float = threshold(
        2.0,
        "turns",
        "choice",
        "between such a line and a steady one of the same mean, below which it is a steady one",
    )
    slow_turns: float = threshold(
        8.0, "turns in the record", "choice", "below which the noise is fitted beside each cycle"
    )
    lowest: int = threshold(
        30, "ordinates", "choice", "below which the record has no spectrum of a line's own"
    )
    widest: float = threshold(
        0.03, "of the sample rate", "choice", "half width above which it is no line"
    )
    narrowest: float = threshold(1.5, "ordinates", "choice", "half width below which it is sharp")
    turning: float = threshold(
        1 / 6,
        "of its frequency",
        "DESIGN 4",
        "half width at most: it turns about once before it forgets its phase",
    )
    hopeful: float = threshold(
        8.0, "log-likelihood", "choice", "of a crude box, from which a place is worth a closer look"
    )
    places_refined: int = threshold(2, "places", "choice", "the strongest, which are refined")
    white_turns: int = threshold(
        40,
        "turns in the record",
        "choice",
        "from which the noise is white across the lobe of a line",
    )
    pieces: int = threshold(
        1000, "pieces", "choice", "of the record, in which a line's phase is followed"
    )
    interval_windows: tuple[int, ...] = threshold(
        (4, 12, 36, 108, 324),
        "parts of the record",
        "DESIGN 15.2",
        "half overlapping windows of short-time spectra",
    )
    interval_least: int = threshold(128, "samples", "choice", "of a window, and of a visit")
    interval_marks: int = threshold(
        240, "marks", "DESIGN 15.2", "of the record, among which start and stop are sought first"
    )
    interval_turns: int = threshold(8, "periods", "choice", "that an interval must hold")
    interval_most: float = threshold(
        0.85, "of the record", "DESIGN 15.2", "from which a line is there all the time"
    )
    interval_rounds: int = threshold(3, "rounds", "DESIGN 15.2", "of ends and frequency in turn")
    within_band: float = threshold(
        3.0,
        "half widths",
        "choice",
        "of a line with a width, within which one that comes and goes is that band, wandering",
    )
    beside_course: float = threshold(
        0.005,
        "of the sample rate",
        "choice",
        "from the course of a drifting line, within which one that comes and goes is what is left "
        "of it",
    )
    wave_hz: float = threshold(
        0.1,
        "Hz",
        "DESIGN 4",
        "below which lines may be harmonics of one wave: those of anything slower are no lines",
    )
    wave_harmonics: int = threshold(3, "lines", "DESIGN 4", "from which on they are one wave")
    wave_wide: float = threshold(
        0.25, "of the slowest line", "choice", "by which a line with a width may miss a harmonic"
    )
    wave_near: float = threshold(
        0.1,
        "of the slowest line",
        "choice",
        "that a line must be surer of its place than to be its harmonic",
    )
    comb_lines: int = threshold(
        5,
        "lines",
        "choice",
        "of one comb, from which they are one signal and not those of a machine",
    )
    comb_teeth: int = threshold(32, "harmonics", "choice", "of a comb on which lines are sought")
    comb_orders: int = threshold(
        8, "harmonics", "choice", "that a line may be, to be the base of a comb"
    )
    comb_chance: float = threshold(
        1e-3, "chance", "choice (DESIGN 4)", "that lines anywhere lie on one comb as these do"
    )


@dataclass(frozen=True)
class Drift:
    """A line whose frequency drifts (candidates/drifting.py)."""

    least: float = threshold(
        50.0,
        "log-likelihood",
        "choice",
        "of a line with a width, from which it may be one that drifts; and what that gains more",
    )
    reach: float = threshold(
        0.04, "of the sample rate", "choice", "on each side of the line, in which it is followed"
    )
    widths: float = threshold(4.0, "half widths", "choice", "of the line, the same")
    share: float = threshold(
        0.7,
        "of the power above the model",
        "DESIGN 15.3",
        "within reach that must belong to one course",
    )
    samples_least: int = threshold(512, "samples", "choice", "of the band about the line")
    blocks: tuple[int, ...] = threshold(
        (32, 64, 128, 256, 512), "blocks", "DESIGN 15.3", "half overlapping, of the record"
    )
    block_least: int = threshold(16, "samples", "choice", "of a block of the band about the line")
    bins: int = threshold(3, "bins", "choice", "by which the line moves from one block to the next")
    blocks_per_knot: int = threshold(5, "blocks", "choice", "of the course that is tried first")
    knots: tuple[int, int] = threshold(
        (5, 256), "knots", "DESIGN 15.3", "of the course of the frequency: least and most"
    )
    turns_least: float = threshold(
        1.0, "turns", "DESIGN 15.3", "between the ends of its course, below which a line is steady"
    )
    per_knot: int = threshold(
        8, "pieces", "choice", "of the record, in which the phase is followed"
    )
    rounds: int = threshold(6, "rounds", "choice", "of the phase and the course in turn")


@dataclass(frozen=True)
class Image:
    """Images of lines by regular gaps: inference/images.py."""

    power: float = threshold(
        0.1,
        "of the line's power",
        "choice (DESIGN 12.5)",
        "from which an image counts: gaps that take a quarter of the time",
    )
    recurrent: int = threshold(
        30, "gaps", "choice", "that are regular, from which a line has images and no wide lobe"
    )
    slow_gaps: int = threshold(
        16, "gaps", "choice", "over which the level of the known samples is removed before"
    )
    background: int = threshold(
        256, "half ordinates", "choice", "of which the median is the level about a line"
    )
    chance: float = threshold(
        0.001, "chance", "choice", "that a record without a line shows one to be continued in gaps"
    )
    lines_most: int = threshold(8, "lines", "choice", "that are continued in the gaps")


@dataclass(frozen=True)
class Step:
    """Steps of the bias (candidates/steps.py)."""

    marks: int = threshold(
        1200, "marks", "DESIGN 15.1", "of the record, between which crossings are counted"
    )
    edge: int = threshold(
        16,
        "samples",
        "choice",
        "between two steps; these, and one mark's worth, are left out at the ends: a "
        "step there is a wild sample",
    )


@dataclass(frozen=True)
class Levels:
    """A few levels or a continuum (inference/states.py, candidates/ranking.py)."""

    seen: float = threshold(
        8.0, "log-likelihood", "DESIGN 6.2", "from which two levels count as seen"
    )
    looked_for: float = threshold(
        0.25,
        "of the gain of another effect",
        "DESIGN 6.2",
        "that two levels must explain to be looked for (of a filter or a logged column: as much)",
    )
    one_more: float = threshold(
        5.0,
        "log-likelihood",
        "DESIGN 6.4: half the logarithm of the number of blocks (BIC)",
        "that one more level must gain",
    )
    most: int = threshold(5, "levels", "DESIGN 6.4", "that are tried")
    process_ratio: float = threshold(
        4.0,
        "ratio",
        "choice: their sum follows flicker within 5 %",
        "of the correlation times of neighbouring processes that slow noise is made of",
    )
    processes_most: int = threshold(
        16,
        "processes",
        "choice: four more than a record of a day has",
        "of slow noise beside levels",
    )
    white_least: float = threshold(
        1e-3, "of the density", "choice", "white noise beside levels, where a fit leaves less"
    )
    middle: float = threshold(
        100.0, "of the mean square", "choice", "variance of the middle of levels beforehand"
    )
    blocks_most: int = threshold(40000, "blocks", "choice", "of a record")
    blocks_per_dwell: int = threshold(
        48, "blocks", "DESIGN 6.2: with 8 the dwell came out a fifth too long", "of a dwell"
    )
    first_sizes: tuple[float, ...] = threshold(
        (-0.6, -0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45, 0.6),
        "logarithm",
        "choice: few dwells leave the size of a spectrum in doubt by as much",
        "of amplitudes, over the one of the spectrum, that are tried first",
    )
    decoded_per_dwell: int = threshold(
        240, "blocks", "choice", "of a dwell of which the course is decoded"
    )
    blocks_least: int = threshold(
        8, "blocks", "choice", "however far a search for the dwell strays"
    )
    switches_least: int = threshold(5, "switches", "DESIGN 6.2", "of telegraph noise in a record")
    alike_dwells: float = threshold(
        1.15,
        "ratio",
        "5 % of exponential ones at most (DESIGN 6.2)",
        "within which dwells are alike",
    )
    joined: float = threshold(
        1.5,
        "shape of a gamma distribution",
        "choice: exponential dwells have 1, and more where short ones are not seen",
        "up to which dwells are as uneven as chance makes them",
    )
    passing: float = threshold(
        0.2,
        "of the mean dwell",
        "DESIGN 6.2",
        "below which a dwell is the path on its way between two levels",
    )
    uneven_chance: float = threshold(
        1e-4,
        "chance",
        "choice (DESIGN 6.2)",
        "of dwells so even, or of switches so one-sided, from which it is no telegraph noise",
    )
    simplex: Mapping[str, float] = threshold(
        {"maxfev": 120, "xatol": 1e-2, "fatol": 0.05},
        "options of Nelder-Mead",
        "choice",
        "where the search for the dwell ends",
    )


@dataclass(frozen=True)
class Column:
    """Effects on logged columns (candidates/columns.py, identifiable.py)."""

    powers: tuple[float, ...] = threshold(
        (1.0, 2.0, 3.0, 4.0),
        "exponents",
        "choice",
        "of a column, with which the variance of the white noise is tried to grow",
    )
    means_most: int = threshold(
        16384, "block means", "DESIGN 4", "of the recording that shapes are scanned on"
    )
    lag_least: float = threshold(
        8.0,
        "log-likelihood",
        "DESIGN 4 (measured on real recordings)",
        "of a lag over the temperature felt at once, below which a random walk does as well",
    )


@dataclass(frozen=True)
class Cause:
    """One coefficient, or a cause that was not logged (candidates/common_cause.py)."""

    edges_hz: tuple[float, ...] = threshold(
        (0.0, 0.002, 0.01, 0.05, 0.25, 0.5, 2.5),
        "Hz",
        "DESIGN 4",
        "of the bands; above, delays and filters differ, and a true coefficient need "
        "not be one number",
    )
    worked_out_hz: float = threshold(
        0.05,
        "Hz",
        "DESIGN 4",
        "up to here a course worked out of a column has no scatter of its own to speak of",
    )
    ordinates_least: int = threshold(
        8, "ordinates", "choice", "of a band; one with fewer goes with the next"
    )
    band_seen: float = threshold(
        3.0, "standard errors", "DESIGN 4", "from which a band shows a coefficient"
    )
    bands_apart: float = threshold(
        3.5, "standard errors", "DESIGN 4", "of a difference, from which two bands are apart"
    )
    bands_ratio: float = threshold(
        2.0, "ratio", "DESIGN 4", "of coefficients, from which two bands contradict each other"
    )
    turned_hz: float = threshold(
        0.05, "Hz", "DESIGN 4", "from where on another axis of the gyro may count as turned"
    )
    turned_share: float = threshold(
        0.75,
        "of its power",
        "DESIGN 4",
        "no noise of its own, from which another axis of the gyro counts as turned",
    )
    motion_least: float = threshold(
        0.1,
        "of an accelerometer's power",
        "choice",
        "real motion, below which its noise is not divided out further",
    )
    own_noise_most: float = threshold(
        1.2,
        "ratio of powers",
        "choice; the level of the noise is known to 2 %",
        "of a column to the noise of its own sensor, up to which it is no more than that",
    )
    slow_hz: float = threshold(0.01, "Hz", "DESIGN 4", "below which axes are compared")
    coherent: float = threshold(
        0.4, "|r|", "DESIGN 4", "from which axes move as one, with bands_apart standard errors"
    )
    axes_ratio: float = threshold(
        1.5, "ratio", "DESIGN 4", "within which the coefficients of three axes are the same"
    )
    quiet_share: float = threshold(
        0.05, "of the seconds", "choice", "whose noise is taken for the sensor's own"
    )


@dataclass(frozen=True)
class Doubt:
    """What a candidate may be instead (candidates/doubts.py)."""

    moved_share: float = threshold(
        0.01,
        "share of the samples",
        "DESIGN 4",
        "that true motion takes, from where on what is left of it passes for an effect",
    )
    leak_moved: float = threshold(
        0.1,
        "of another axis",
        "DESIGN 4; data sheets have 0.01 to 0.05",
        "coefficient above which it is a turn, where the recording moved",
    )
    leak_at_rest: float = threshold(0.3, "of another axis", "DESIGN 4", "the same at rest")
    turns_most: int = threshold(
        24, "turns", "choice", "of the sensor, after each of which the bias may have another level"
    )
    turns_leave: float = threshold(
        0.25, "of the gain", "choice", "of an effect, that it keeps beside these levels"
    )


@dataclass(frozen=True)
class Change:
    """White noise that changes (inference/changes.py, modulation.py)."""

    block_samples: int = threshold(
        32,
        "samples",
        "choice",
        "of a column per block, of which what it adds to the noise is a mean",
    )
    restless_stretches: int = threshold(
        24, "stretches", "DESIGN 4", "of the record, whose levels are compared"
    )
    touch_blocks: int = threshold(
        3, "blocks", "DESIGN 4", "that a touch takes: left out of the gain of vibration"
    )
    crowded_pieces: int = threshold(
        16, "pieces", "DESIGN 5.3", "of the record, in which noise is loud or not"
    )
    share_groups: int = threshold(8, "groups", "DESIGN 5.2", "of the share of white noise")
    growth_most: float = threshold(
        3.5,
        "logarithm",
        "choice",
        "of the largest ratio of white noise over the range of the temperature",
    )
    growth_simplex: tuple[tuple[float, float], ...] = threshold(
        ((0.0, 0.0), (0.3, 0.0), (0.0, 0.3)),
        "logarithm",
        "choice",
        "of white noise over the range of the temperature, linear and quadratic: first steps",
    )


@dataclass(frozen=True)
class Fit:
    """Fits: inference/whittle.py, parts.py, refine.py, estimate.py, gaps.py."""

    iterations: int = threshold(60, "iterations", "choice", "of a fit of sizes")
    halvings: int = threshold(12, "halvings", "choice", "of a step that does not gain")
    scored: int = threshold(
        2, "iterations", "DESIGN 3.1", "of Fisher scoring before those of Newton"
    )
    curvature_least: float = threshold(
        0.3, "of the expected curvature", "DESIGN 3.1", "of a bin in a step of Newton"
    )
    pivot_least: float = threshold(
        1e-5, "rows of unit norm", "choice", "pivot of a Cholesky factor that is well posed"
    )
    exchanges: int = threshold(
        20,
        "exchanges",
        "choice",
        "of sizes that are 0 in a step, before the general method decides",
    )
    slope_least: float = threshold(
        1e-10, "of the largest", "choice", "slope with which a size leaves 0, above rounding"
    )
    reach_end: float = threshold(
        0.95, "of the reach", "choice", "from which a filter's shape is searched for further on"
    )
    slow_s: float = threshold(0.5, "s", "DESIGN 1.4", "in which a slow course does not move")
    slow_means: int = threshold(
        10000, "means", "choice", "of a record, at least, that a slow course is transformed of"
    )
    slow_turn: float = threshold(
        0.01, "turns", "DESIGN 1.4", "in slow_s, below which a line is a slow course"
    )
    bias_tracked_s: float = threshold(
        6.28,
        "s",
        "choice: a time constant of 1 s. Faster software would take away the turns that the gyro "
        "is for",
        "corner period, at least, of software that subtracts its estimate of the bias",
    )
    rounds_of_two: int = threshold(8, "rounds", "choice", "of the shapes of two warm-ups")
    change_doubt: float = threshold(
        11.03,
        "noise over power, samples",
        "DESIGN 15: largest value of a two-sided random walk with drift, 95 %",
        "of the place of a change in white noise",
    )
    vague_factor: float = threshold(
        10.0,
        "ratio",
        "choice",
        "reach of a 95 % interval, from which the record does not determine a parameter",
    )
    settled: float = threshold(
        8.0,
        "times what ends of the record leave",
        "choice (DESIGN 2.3)",
        "at a zero of a filter: how it settled as the record began is as much again",
    )
    draw_iterations: int = threshold(
        120,
        "iterations",
        "choice (DESIGN 12.1: 3 to 40 are usual)",
        "of conjugate gradients for missing samples, at most",
    )
    draw_residual: float = threshold(
        3e-2, "of the first residual", "choice", "at which the missing samples are taken"
    )
    level_lags: int = threshold(
        8,
        "parts of the record",
        "DESIGN 12.2",
        "the longest lag whose products are looked at: one of these parts",
    )
    level_floor: float = threshold(
        0.05, "of the median level", "choice", "where products of few samples say less than nothing"
    )


@dataclass(frozen=True)
class Signals:
    """Operations on sampled signals that every room shares (data/signals.py)."""

    foretold_from: int = threshold(
        16, "samples", "DESIGN 13.3", "before one, from which that one is predicted"
    )
    foretold_samples: int = threshold(
        20_000, "samples", "choice", "of a record that are predicted, evenly spaced"
    )
    foretold_within: float = threshold(
        1e-6,
        "of the scatter of a record",
        "DESIGN 13.3",
        "error of the prediction, below which the record has no noise of a sensor, only digits",
    )
    scatter_least: int = threshold(
        4, "samples", "choice", "of a window or block, at least, whose scatter is measured"
    )
    sudden: float = threshold(
        2.0, "ratio", "choice", "by which the level of a square changes suddenly, within a second"
    )
    single_ordinates: int = threshold(
        80, "ordinates", "DESIGN 1.2", "the first ones, each of which has a bin of its own"
    )
    bin_ratio: float = threshold(1.04, "ratio", "DESIGN 1.2", "by which edges of bins grow")
    top_ratio: float = threshold(
        1.08,
        "ratio",
        "DESIGN 1.2",
        "by which the distance of an edge from half the sample rate shrinks: a digital filter may "
        "have a zero there",
    )
    top_nearest: int = threshold(
        512, "parts of the spectrum", "choice", "the edge nearest to its end: one of these parts"
    )
    edges_even: tuple[float, float, float] = threshold(
        (0.25, 4.0, 0.5),
        "half widths: first, end, step",
        "DESIGN 1.3",
        "of the edges close to a line",
    )
    edges_ratio: float = threshold(
        1.2, "ratio", "DESIGN 1.3", "of neighbouring edges, from the end of edges_even on"
    )
    edges_grown: int = threshold(20, "edges", "choice", "beyond edges_even, on each side of a line")
    copy: float = threshold(
        0.9,
        "|r|",
        "DESIGN 4",
        "of the changes from sample to sample, above which a column is a copy of another",
    )


@dataclass(frozen=True)
class Motion:
    """True rotation in a record of a sensor that should be at rest (data/motion.py)."""

    piece_samples: int = threshold(
        1_000_000,
        "samples",
        "choice",
        "in a piece of a long record: each piece has a level at rest of its own",
    )
    rest_samples: int = threshold(
        500, "samples", "choice", "below which neither motion nor outliers are sought"
    )
    smooth_s: float = threshold(0.25, "s", "DESIGN 13.1", "over which rates are averaged")
    span_s: float = threshold(
        2.0, "s", "DESIGN 13.1", "over which the spread of averaged rates is measured"
    )
    rest_dps: float = threshold(
        0.35, "deg/s", "DESIGN 13.1", "spread of averaged rates at rest, at most"
    )
    count_dps: float = threshold(
        1000 / 32768,
        "deg/s",
        "choice",
        "size of a count of a gyro in counts, whose unit nobody has stated: a usual range",
    )
    rest_white: float = threshold(
        3.0,
        "times the white noise",
        "DESIGN 13.1",
        "of averaged rates: their spread at rest, at most, where that is above rest_dps",
    )
    turn: float = threshold(
        6.0,
        "times the level at rest",
        "DESIGN 13.1",
        "of the spread of averaged rates, above which it may be a turn",
    )
    slow_growth: float = threshold(
        5.0,
        "times",
        "DESIGN 13.1",
        "that the spread of a turn must have grown more than the differences of single samples "
        "(at random, up to 3.5)",
    )
    violent: float = threshold(
        50.0,
        "times the level at rest",
        "DESIGN 13.1",
        "of the spread of averaged rates, which no noise of a sensor reaches",
    )
    ring_s: float = threshold(
        1.2, "s", "choice", "by which a turn is widened, half of it on each side"
    )
    short_s: float = threshold(
        0.5,
        "s",
        "DESIGN 13.1",
        "up to which a turn may be a shock of the sensor, unless the accelerometer registered it",
    )
    energy_blocks: tuple[int, ...] = threshold(
        (16, 64, 256, 1024), "samples", "DESIGN 13.1", "of a block whose energy is tested"
    )
    energy_block_s: float = threshold(
        8.0, "s", "DESIGN 13.1", "that the longest block lasts: longer ones are added until then"
    )
    median_blocks: int = threshold(
        9, "blocks", "DESIGN 13.1", "of the running median that the energy of a block is over"
    )
    loud_score: float = threshold(
        6.5,
        "robust standard deviations",
        "DESIGN 13.1",
        "of the cube root of a block's energy over the running median, above which it is loud",
    )
    loud_ratio: float = threshold(
        1.25,
        "ratio of energies",
        "DESIGN 13.1",
        "above which a block is louder than the running median, or a touch than its sides",
    )
    witness: float = threshold(
        12.0,
        "over the square root of the samples of a touch",
        "DESIGN 13.1",
        "by which the accelerometer must be louder than next to the touch, to confirm it",
    )
    touch_rounds: int = threshold(
        4, "rounds", "DESIGN 13.1", "of touches, each without the motion found before"
    )
    steady_s: float = threshold(
        5.0, "s", "DESIGN 13.1", "above which a loud section may be noise that has grown"
    )
    pause_s: float = threshold(
        3.0, "s", "DESIGN 13.1", "of rest between two motions, below which it is excluded too"
    )
    grow_s: float = threshold(
        0.5, "s", "DESIGN 13.1", "length of the blocks next to motion that may belong to it"
    )
    grow: float = threshold(
        4.0,
        "robust standard deviations",
        "DESIGN 13.1",
        "above rest, from which a block next to motion belongs to it",
    )
    tilt_s: float = threshold(10.0, "s", "DESIGN 13.2", "over which gravity is averaged")
    tilt: float = threshold(
        7.0, "robust standard deviations", "DESIGN 13.2", "of all axes, from which gravity moved"
    )
    tilt_blocks: int = threshold(
        9,
        "means of gravity",
        "DESIGN 13.2",
        "on each side of a slow tilt that the gyro must follow",
    )


@dataclass(frozen=True)
class Events:
    """Isolated outliers and torn register reads (data/events.py)."""

    wild: float = threshold(
        5.6, "standard deviations", "DESIGN 6.1", "above which a single sample is no noise"
    )
    replaced: int = threshold(
        4, "samples", "choice", "on each side of a shock that are replaced with it"
    )
    local_samples: int = threshold(
        201, "samples", "choice", "around a wild one, whose mean stands for the record without it"
    )
    power_least: int = threshold(
        4, "power of two, counts", "DESIGN 13.5", "the smallest jump of a torn read"
    )
    power_most: int = threshold(
        23, "power of two, counts", "DESIGN 13.5", "the largest jump of a torn read"
    )
    far: float = threshold(
        12.0,
        "times the noise of a jump",
        "DESIGN 13.5",
        "above which a power of two is tested; a jump begins at this over the square root of 2",
    )
    noise_block: int = threshold(
        200, "samples", "choice", "in which the noise beside a jump is measured"
    )
    rounded: float = threshold(0.5, "counts", "choice", "noise of a jump, at least")
    grid_counts: float = threshold(
        0.25, "counts", "choice", "by which the mean of many jumps may be off"
    )
    hit: float = threshold(
        4.0,
        "standard deviations",
        "DESIGN 13.5",
        "from a power of two, within which a jump is a torn read",
    )
    scattered: float = threshold(
        0.01, "chance", "DESIGN 13.5", "that the jumps of torn reads scatter more"
    )
    unrelated: float = threshold(
        100.0, "times", "DESIGN 13.5", "likelier that torn reads must be than unrelated shocks"
    )
    one_size: float = threshold(
        10.0, "times", "DESIGN 13.5", "likelier that torn reads must be than shocks of one size"
    )
    torn_shares: tuple[float, float, int] = threshold(
        (0.05, 0.95, 10),
        "shares: first, last, number",
        "DESIGN 13.5",
        "of the jumps that may be torn reads, over which the mean is taken",
    )


@dataclass(frozen=True)
class Counts:
    """The step in which a rate or an angle comes, and what its rounding adds (data/counts.py)."""

    step_samples: int = threshold(
        10**6, "samples", "choice", "of a record that the count is sought in, evenly spaced"
    )
    distinct: int = threshold(
        20, "samples per distinct value", "choice", "from which the values of a record repeat"
    )
    split: float = threshold(
        20.0,
        "ratio of neighbouring distances",
        "choice",
        "from which the smaller ones are the rounding of one and the same count",
    )
    sum_rounding: float = threshold(
        2e-6, "of the largest value", "choice", "by which sums of counts may differ"
    )
    uneven: float = threshold(
        0.12, "of a count", "choice", "rms from an even grid, from which the levels have none"
    )
    on_grid: float = threshold(
        0.95,
        "length of a mean direction",
        "choice",
        "of the values, one count a turn, above which they lie on the grid",
    )
    angle_up_to: float = threshold(
        3.0,
        "counts of noise",
        "DESIGN 14",
        "from which rate and angle cannot be told apart, and need not be",
    )
    fine: float = threshold(
        0.6,
        "counts of noise",
        "DESIGN 14.1",
        "from which the rounding of a rate is white noise of 1/12 count squared",
    )
    smeared: float = threshold(
        0.35,
        "counts of noise per sample",
        "DESIGN 14.3",
        "from which a counted angle has the usual spectrum",
    )
    suspended: float = threshold(
        0.25,
        "counts of noise per sample",
        "DESIGN 14.3",
        "below which the noise of a counted angle changes in ways that are not modelled",
    )
    phase_grid: tuple[float, float, int] = threshold(
        (-0.5, 0.5, 401),
        "counts: first, last, number",
        "choice",
        "of the bias beside a count, at which mean and variance of rounded noise are computed",
    )
    probit: int = threshold(
        200,
        "samples",
        "DESIGN 14.2",
        "in a block of the ordered probit, and in the mean that tells the bias",
    )
    probit_blocks: int = threshold(
        4000, "blocks", "choice", "of the ordered probit: of more, an even selection"
    )
    harmonics: int = threshold(
        60, "terms", "choice", "of the autocovariance of an angle's rounding error (14.3)"
    )
    angle_means: int = threshold(
        64, "means", "DESIGN 14.3", "of the angle's steps that its error is averaged over"
    )
    lags: int = threshold(4096, "samples", "choice", "up to which an angle's error remembers")
    angle_noise: float = threshold(
        0.05,
        "counts of noise per sample",
        "choice",
        "that an angle has at least: with less, its error has no end of memory",
    )
    count_bands: int = threshold(
        64, "bands", "DESIGN 14", "of the spectrum that decide whether rate or angle is counted"
    )
    telling: float = threshold(
        20.0,
        "twice the log-likelihood",
        "DESIGN 14",
        "by which a counted angle must fit better than a counted rate",
    )
    enough: float = threshold(
        1.4, "misfit per band", "choice", "up to which no response before the counting is tried"
    )
    simpler: float = threshold(
        9.0,
        "twice the log-likelihood",
        "choice",
        "by which a response before the counting must fit better than none",
    )
    as_known: tuple[float, float] = threshold(
        (0.6, 1.6),
        "times the known size",
        "choice",
        "least and most that the error of an angle may have, were it free",
    )
    angle_rounds: int = threshold(
        8, "rounds", "choice", "of an angle's error and of the steps beside it, in turn"
    )
    median_scatter: float = threshold(
        5.45,
        "over the number of chi-squares",
        "chi-square with one degree of freedom: 1 / (2 m f(m))^2 = 5.44 at its median m",
        "variance of the logarithm of their median",
    )


@dataclass(frozen=True)
class Observed:
    """What is reported of a record before anything is fitted (data/observations.py)."""

    coarse: float = threshold(
        0.6, "times the noise per sample", "DESIGN 13.3", "from which a count is reported"
    )
    clipped_values: int = threshold(
        8, "distinct values", "choice", "below which a column is not tested for clipping"
    )
    clipped_piled: int = threshold(
        8,
        "times as often as the three values next to it",
        "DESIGN 13.3",
        "above which an extreme value is clipped",
    )
    dead_beside: int = threshold(
        3, "values", "DESIGN 13.3", "on each side that the value of a dead zone is compared with"
    )
    dead_piled: int = threshold(
        4,
        "times as often as the values beside it",
        "DESIGN 13.3",
        "from which a value may be a dead zone",
    )
    dead_share: float = threshold(
        0.1, "of the samples", "DESIGN 13.3", "that have the value of a dead zone, at least"
    )
    dead_fine: int = threshold(
        3,
        "counts of noise per sample",
        "DESIGN 13.3",
        "from which neighbouring values are equally likely",
    )
    dead_falls: int = threshold(
        2,
        "times as often as those beyond",
        "choice",
        "above which the values next to the middle are rounded noise and no dead zone",
    )
    dead_falls_least: int = threshold(
        30, "samples", "choice", "next to the middle value that show how often these occur"
    )
    dead_around: int = threshold(
        10, "values", "choice", "on each side, of which the usual distance is taken"
    )
    dead_wide: int = threshold(
        3,
        "times the usual distance",
        "DESIGN 13.3",
        "above which the values next to it are apart from the value of a dead zone",
    )
    bursts: int = threshold(30, "gaps", "choice", "between blocks, from which these may be regular")
    bursts_stray: float = threshold(
        0.25,
        "of the usual distance",
        "choice",
        "within which the middle half of the distances of regular blocks lies",
    )
    listed: int = threshold(100, "intervals", "choice", "that are listed, the longest ones")
    times: int = threshold(
        8, "times", "choice", "at which something was seen, that a sentence lists"
    )


@dataclass(frozen=True)
class Repeats:
    """Samples that repeat the one before (data/repeats.py)."""

    false_repeats: float = threshold(
        1e-6,
        "chance",
        "DESIGN 13.3",
        "that a recording without repeats, or without a stuck axis, shows some",
    )
    clear: float = threshold(
        0.01,
        "chance of equal samples",
        "DESIGN 13.3",
        "up to which each sample that equals the one before is a repeat",
    )
    keep_apart: float = threshold(
        6.0,
        "standard deviations",
        "DESIGN 13.3",
        "by which equal samples exceed chance, and by which they keep apart",
    )
    phase_block: int = threshold(
        64, "samples", "DESIGN 13.3", "that have the same place of the bias in a count"
    )
    seldom: float = threshold(
        0.5,
        "of the samples",
        "DESIGN 13.3",
        "equal to the one before, from which an axis keeps its values for long anyway",
    )
    calm: float = threshold(
        0.8,
        "of the usual movement",
        "DESIGN 13.3",
        "around equal samples, below which they are no repeats",
    )
    hidden_least: float = threshold(
        0.02, "of the samples", "DESIGN 13.3", "that are repeats among those equal by chance"
    )
    finer: float = threshold(
        0.1,
        "differences of two counts per one of one",
        "choice",
        "below which the noise is too small to foretell equal samples exactly",
    )
    phase_matters: float = threshold(
        0.5,
        "differences of two counts per difference of one",
        "DESIGN 13.3",
        "up to which the place of the bias in a count matters to equal samples of several axes",
    )


@dataclass(frozen=True)
class Plausible:
    """Rates, units and levels that a gyro may have (data/plausible.py)."""

    rates_hz: tuple[float, float] = threshold(
        (0.02, 40e3),
        "Hz",
        "DESIGN 13.4",
        "that gyros are logged at: from a sample in 50 s to the fastest MEMS sensors, 32 kHz",
    )
    likely_hz: tuple[float, float] = threshold(
        (10.0, 20e3), "Hz", "choice", "within which another unit of the time is proposed"
    )
    whole_hz: float = threshold(
        1.0,
        "Hz",
        "DESIGN 13.4",
        "up to which whole seconds get a note: milliseconds look like them",
    )
    level_dps: float = threshold(
        2000.0, "deg/s rms", "DESIGN 13.4", "beyond the full scale of almost every gyro"
    )
    arw: tuple[float, float] = threshold(
        (1e-5, 100.0),
        "deg/sqrt(h)",
        "DESIGN 13.4",
        "of noise: from below the best optical gyros to above the worst MEMS sensors",
    )
    temperatures: tuple[float, float] = threshold(
        (-100.0, 200.0), "degC", "DESIGN 13.4", "median of a column of temperatures"
    )
    count_near: float = threshold(
        0.003, "relative", "choice", "within which a count is that of a known sensor"
    )
    noise_samples: int = threshold(
        512, "samples", "choice", "below which nothing is reported of the noise"
    )
    looked_at: int = threshold(
        1 << 20, "samples", "choice", "at the beginning that levels and units are judged by"
    )


@dataclass(frozen=True)
class Stamps:
    """Time stamps and the clock behind them (data/clock.py)."""

    doubtful_rate: float = threshold(
        0.01,
        "relative",
        "choice: as in davar-sim",
        "between --rate and the time stamps, above which they contradict each other",
    )
    step_near: float = threshold(
        0.25,
        "of a period",
        "DESIGN 12",
        "between a step and a whole number of periods, below which it is near",
    )
    step_whole: float = threshold(
        0.8,
        "of the steps",
        "DESIGN 12",
        "near a whole number of periods, from which stamps show what is lost",
    )
    memoryless: float = threshold(
        0.3,
        "of the variance that independent steps gather",
        "DESIGN 12",
        "up to which an even clock is behind the stamps",
    )
    jitter: float = threshold(
        0.05, "of a period, rms", "DESIGN 12", "above which stamps are late or uneven"
    )
    phase_samples: int = threshold(
        31,
        "samples",
        "DESIGN 12",
        "over which the phase of the clock is averaged: a period that is 1 % off turns it by a "
        "third meanwhile",
    )
    long_gap: int = threshold(
        32, "periods", "choice", "above which a gap need not keep the phase of the clock"
    )
    late: int = threshold(
        64,
        "samples",
        "DESIGN 12",
        "within which a late stamp is made good by later ones; a longer gap shows no clock",
    )
    crowded: float = threshold(
        0.75,
        "of the samples",
        "DESIGN 12",
        "of an uneven clock that must find a place of their own",
    )
    slower: float = threshold(
        0.75,
        "of the rate of the file",
        "choice",
        "below which a sensor has a clock of its own, seen through samples equal by chance",
    )
    lost_most: int = threshold(
        3,
        "missing samples per measured one",
        "DESIGN 12",
        "on a grid; longer gaps are shortened",
    )
    cut_most: int = threshold(
        8,
        "gaps",
        "DESIGN 12",
        "that may be shortened: where more recur, a frequency needs the real time between",
    )
    recurrent_most: int = threshold(
        63, "missing samples per measured one", "DESIGN 12", "that recurrent gaps may have"
    )
    small_grid: int = threshold(
        1_000_000, "places", "DESIGN 12", "of a grid that may have more gaps than recurrent_most"
    )


@dataclass(frozen=True)
class Record:
    """What a recording needs to be one (data/recording.py)."""

    minimum_samples: int = threshold(
        1000, "samples", "DESIGN 12", "of a recording that is analysed, at least"
    )
    known_least: float = threshold(
        2 / 3, "of the samples", "DESIGN 12", "from which those that are missing count as well"
    )
    spread_dps: tuple[float, float] = threshold(
        (1e-15, 1e15), "deg/s", "choice", "range of the values of a rate whose unit may be right"
    )
    sane_hz: tuple[float, float] = threshold(
        (1e-9, 1e9), "Hz", "choice", "outside of which a sample rate is refused"
    )


@dataclass(frozen=True)
class Guess:
    """What the columns of a table are, by their names and numbers (tables/)."""

    quiet_rad: float = threshold(
        0.006,
        "rad/s",
        "choice",
        "scatter from sample to sample, below which a rate without a unit is in rad/s: a bad "
        "gyro has 0.3 deg/s",
    )
    least_steps: tuple[tuple[str, float], ...] = threshold(
        (("ns", 1e5), ("us", 50.0), ("ms", 0.5), ("s", 0.0)),
        "of each unit",
        "choice",
        "least time from sample to sample, for rates up to 10 kHz",
    )
    usual_hz: tuple[float, float] = threshold(
        (4.0, 2000.0),
        "Hz",
        "choice",
        "rates of logs of an IMU, by which a unit of the time is doubted",
    )
    rate_near: float = threshold(
        0.1,
        "relative",
        "choice",
        "of a stated rate and that of the stamps, which are then the same",
    )
    slowest_mti_s: float = threshold(
        0.5,
        "s",
        "choice",
        "between samples, beyond which a SampleTimeFine is that of a Movella DOT",
    )
    scatter: tuple[float, float] = threshold(
        (1e-4, 0.05),
        "of the rate",
        "choice",
        "from sample to sample, outside of which it alone decides the unit where there is too "
        "little time",
    )
    usual_arw: tuple[float, float] = threshold(
        (0.03, 5.0), "deg/sqrt(h)", "choice", "of MEMS gyros at rest"
    )
    linear: float = threshold(
        0.5,
        "m/s^2 or g",
        "choice",
        "median norm of an accelerometer, below which gravity is not in it",
    )
    arw_least_s: float = threshold(
        20.0, "s", "choice", "that a record must exceed to show an angle random walk"
    )
    arw_taus_s: tuple[float, ...] = threshold(
        (1.0, 2.0, 4.0), "s", "choice", "averaging times at which white noise has one level"
    )
    arw_agrees: float = threshold(2.0, "factor", "choice", "within which those levels are the same")
    half_of_normal: float = threshold(
        0.6745, "standard deviations", "normal distribution", "the median of the magnitude"
    )
    gravity_s: float = threshold(
        0.25, "s", "choice", "of a mean in which gravity is followed as the sensor turns"
    )
    turned_rad: float = threshold(
        1.0, "rad", "choice", "turned in all, at least, for gravity to decide the unit of the gyro"
    )
    gravity_agrees: float = threshold(
        0.5,
        "squared correlation",
        "choice",
        "of the turns of gravity with those of the gyro, at least",
    )
    slower_column: float = threshold(
        1 / 3,
        "of the rows of the sensor",
        "choice",
        "from which a column without a value is slower, or on rows of its own",
    )
    labelled: float = threshold(
        0.5, "of the samples", "choice", "that have a label, at least, for it to be a column"
    )
    throttle_most: float = threshold(
        2500.0,
        "us",
        "choice",
        "of a throttle command, which ends at 2000: above it, a blackbox log is in tenths",
    )
    few_thousands: int = threshold(
        3, "fields", "choice", "that look like thousands, from which it is no chance"
    )


@dataclass(frozen=True)
class Shape:
    """The shapes of effects that are tried, and where they end (effects/)."""

    lags_s: tuple[float, ...] = threshold(
        (0.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0),
        "s",
        "choice",
        "lags of a column that are tried",
    )
    lag_share: float = threshold(
        0.25, "of the record", "choice", "the longest lag that it can show"
    )
    hysteresis_widths: tuple[float, ...] = threshold(
        (0.05, 0.1, 0.2, 0.4, 0.7),
        "of the range of the temperature",
        "choice",
        "widths of a hysteresis that are tried",
    )
    stopped: float = threshold(
        0.01, "of its largest magnitude", "choice", "below which a speed is none"
    )
    clocklike: float = threshold(
        1e-6,
        "of its range",
        "choice",
        "that a column may depart from a straight line to count as a time",
    )
    nearly_whole: float = threshold(
        0.05, "samples", "choice", "by which the length of an average may miss a whole number"
    )
    filter_images: int = threshold(
        8,
        "images on each side",
        "choice",
        "of a filter that is sampled; of order 2 they fall with the fourth power",
    )
    course_least: int = threshold(4, "knots", "choice", "of the frequency of a drifting line")
    memories: tuple[float, ...] = threshold(
        (0.0, 0.04, 0.1, 0.25, -0.04, -0.1, -0.25),
        "of a sample",
        "choice",
        "of rounding noise that are tried",
    )


@dataclass(frozen=True)
class Device:
    """What the export declares for a device, and when it matters (report/)."""

    sheet_percent: float = threshold(
        10.0, "percent", "choice", "error of a cutoff without a recording, as davar-sim has it"
    )
    least_percent: float = threshold(
        1.0, "percent", "choice", "of a cutoff that was fitted, at least"
    )
    most_percent: float = threshold(
        50.0, "percent", "choice", "of a cutoff that is declared at all"
    )
    bias_most: float = threshold(
        0.5,
        "standard errors",
        "choice",
        "by which the ARW of a window may be off: 92 % of the intervals of 95 % still hold",
    )
    sizes_least: int = threshold(3, "cluster sizes", "choice", "that a fit on the device needs")
    detected: float = threshold(
        25.0, "chi-square", "choice", "of a misfit that the device detects in every window"
    )
    rounding_share: float = threshold(
        0.01, "of the variance of white noise per sample", "choice", "from which --lsb matters"
    )
    gap_periods: float = threshold(
        1.5, "sample periods", "choice", "from which davar-sim without --rate counts lost samples"
    )
    rates_differ: float = threshold(
        0.01,
        "relative",
        "choice",
        "of the median step from the mean one, from which --rate matters",
    )
    cutoff_step: float = threshold(0.01, "of the cutoff", "choice", "in a difference quotient")
    grid_accuracy: float = threshold(
        1e-3, "relative", "choice", "of an Allan deviation on the grid of frequencies"
    )
    flight_stride_s: float = threshold(
        0.5, "s", "choice", "between two windows of a recording in motion"
    )
    flight_window: int = threshold(
        600,
        "samples",
        "choice",
        "least longest window of ARW, which nobody reads in motion, as davar.dynamic has it",
    )
    rare_floor: float = threshold(
        0.1,
        "of the windows in motion",
        "choice",
        "up to which a value is an exception, and the reason of the others counts",
    )
    picked_hz: float = threshold(10.0, "Hz", "choice", "below which a log usually holds picks")


CHANCE = Chance()
JUDGE = Judge()
READING = Reading()
PLACE = Place()
START = Start()
SEARCH = Search()
TRIES = Tries()
LINE = Line()
DRIFT = Drift()
IMAGE = Image()
STEP = Step()
LEVELS = Levels()
COLUMN = Column()
CAUSE = Cause()
DOUBT = Doubt()
CHANGE = Change()
FIT = Fit()
SIGNALS = Signals()
MOTION = Motion()
EVENTS = Events()
COUNTS = Counts()
OBSERVED = Observed()
REPEATS = Repeats()
PLAUSIBLE = Plausible()
STAMPS = Stamps()
RECORD = Record()
GUESS = Guess()
SHAPE = Shape()
DEVICE = Device()
TABLE = {
    "CHANCE": CHANCE,
    "JUDGE": JUDGE,
    "READING": READING,
    "PLACE": PLACE,
    "START": START,
    "SEARCH": SEARCH,
    "TRIES": TRIES,
    "LINE": LINE,
    "DRIFT": DRIFT,
    "IMAGE": IMAGE,
    "STEP": STEP,
    "LEVELS": LEVELS,
    "COLUMN": COLUMN,
    "CAUSE": CAUSE,
    "DOUBT": DOUBT,
    "CHANGE": CHANGE,
    "FIT": FIT,
    "SIGNALS": SIGNALS,
    "MOTION": MOTION,
    "EVENTS": EVENTS,
    "COUNTS": COUNTS,
    "OBSERVED": OBSERVED,
    "REPEATS": REPEATS,
    "PLAUSIBLE": PLAUSIBLE,
    "STAMPS": STAMPS,
    "RECORD": RECORD,
    "GUESS": GUESS,
    "SHAPE": SHAPE,
    "DEVICE": DEVICE,
}
