"""Clocks: phase and fractional frequency, against published Allan deviations and simulated noises,
and in the language of clocks."""

import gzip
import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from asking import run, said
from davarfleet import command
from davarlab import axes, cli
from davarlab import model as models
from davarlab.data.recording import Recording
from davarlab.effects import table
from davarlab.errors import BadInput
from davarlab.inference import allan
from davarlab.logs import formats
from davarlab.logs.options import Options

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real"))
OCXO = FOLDER / "ocxo_frequency_stable32.csv.gz"
# W. J. Riley, Handbook of Frequency Stability Analysis, NIST Special Publication 1065, tables 31
# and 32: NBS14 of NBS Monograph 140, and 1000 points of a generator.
NBS14 = (892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0)
NBS14_DEVIATIONS = {1: 91.22945, 2: 85.95287}  # overlapping
POINTS_DEVIATIONS = {1: 2.922319e-01, 10: 9.159953e-02, 100: 3.241343e-02}  # overlapping
GYRO_WORDS = re.compile(r"\bdeg\b|deg/|_deg|dps|gyro|angle random|bias instability|rate random")
SAMPLES = 16000
WPM_S, WFM, RWFM = 5e-11, 3e-11, 2e-13  # phase in s; Allan deviations at 1 s
NOISES = {
    "white_phase_noise": WPM_S,
    "white_frequency_noise": WFM,
    "random_walk_frequency_noise": RWFM,
}


def points():
    """The generator of the 1000 points."""
    found = [1234567890]
    while len(found) < 1000:
        found.append(16807 * found[-1] % 2147483647)
    return np.array(found) / 2147483647


def phase_of(y, tau_s=1.0):
    return np.concatenate([[0.0], np.cumsum(y)]) * tau_s


def analysed(name, values, rate_hz=1.0):
    """The fractional frequency that the analysis makes of a column."""
    recording = Recording({"time_s": np.arange(len(values)) / rate_hz, name: values}, rate_hz)
    found, model = axes.for_analysis(recording, models.Model(rate_hz, name))
    return found.rate_dps(model.column) * 1e-9, found


def deviations(y, taus):
    return allan.windows(y, len(y), list(taus))[0][0]


def noises(seed):
    """Phase of white phase noise, white frequency noise and random walk of frequency."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(np.sqrt(3) * RWFM * rng.normal(size=SAMPLES))
    x = phase_of(WFM * rng.normal(size=SAMPLES) + walk)
    return x + WPM_S * rng.normal(size=len(x)) + 0.001


PUBLISHED = [  # column, its values, their scale, digits, deviations
    ("fractional_frequency", points(), 1.0, 2e-7, POINTS_DEVIATIONS),
    ("phase_s", phase_of(points()), 1.0, 2e-7, POINTS_DEVIATIONS),
    # 5 s have 16 digits
    ("maser_phase_s", 5.0 + phase_of(points() * 1e-12), 1e-12, 1e-3, POINTS_DEVIATIONS),
    ("fractional_frequency", np.array(NBS14), 1.0, 1e-7, NBS14_DEVIATIONS),
    ("phase_s", phase_of(np.array(NBS14)), 1.0, 1e-7, NBS14_DEVIATIONS),
]


@pytest.mark.parametrize("name, values, scale, digits, published", PUBLISHED)
def test_published_points_as_frequency_and_as_phase(name, values, scale, digits, published):
    y = analysed(name, values)[0] / scale
    if len(y) < 100:  # too few for a window
        x = phase_of(y)
        second = [x[2 * m :] - 2 * x[m:-m] + x[: -2 * m] for m in published]
        found = [np.sqrt(np.mean(one**2) / 2) / m for one, m in zip(second, published)]
    else:
        found = deviations(y, published)
    assert list(found) == pytest.approx(list(published.values()), rel=digits)


@pytest.mark.skipif(not OCXO.exists(), reason=f"{OCXO.name} is not there")
def test_an_oscillator_as_stable32_reads_it():
    with gzip.open(OCXO, "rt") as file:
        rows = [line.split(",") for line in file if line.startswith("# stable32_oadev: ")]
    published = {int(row[0].split(":")[1]): float(row[3]) for row in rows}
    recording = formats.read(OCXO, Options(clocks=["freq_hz=10e6"]))
    (name,) = recording.clocks
    found, model = axes.for_analysis(recording, models.Model(1.0, name))
    measured = deviations(found.rate_dps(model.column) * 1e-9, published)
    assert list(measured) == pytest.approx(list(published.values()), rel=6e-5)


def test_a_phase_that_was_lost_leaves_both_of_its_frequencies_out():
    values = np.arange(1200.0) * 1e-9
    known = np.ones(1200, bool)
    known[500:510] = False
    recording = Recording({"phase_s": values}, 1.0, known=known)
    found, model = axes.for_analysis(recording, models.Model(1.0, "phase_s"))
    assert found.samples == 1199
    assert np.flatnonzero(~found.known).tolist() == list(range(499, 510))
    np.testing.assert_allclose(found.rate_dps(model.column), 1.0)


def test_numbers_of_a_model_file_are_allan_deviations():
    """Each noise alone, from its spectrum: what the file says is what the curve shows."""
    rate = 10.0
    for spoken, name, size, tau_s, deviation in (
        ("white_frequency_noise", "deviation_at_1s", 1e-11, 1.0, 1e-11),
        ("flicker_frequency_noise", "floor", 1e-12, 100.0, 1e-12),
        ("random_walk_frequency_noise", "deviation_at_1s", 1e-13, 100.0, 1e-12),
        ("white_phase_noise", "std_s", 1e-10, 10.0, np.sqrt(3) * 1e-11),
    ):
        text = f'[sensor]\ncolumn = "phase_s"\n[[effect]]\nkind = "{spoken}"\n{name} = {size}\n'
        term = models.of_text(text, "text").terms[0]
        effect = table.find(term.kind)

        def spectrum(f, effect=effect, term=term):
            size = effect.dps(term.parameters) ** 2
            return size * effect.spectrum(f, rate, effect.shape_of(term.parameters))

        power = allan.on_grid(spectrum, rate)
        found = np.sqrt(allan.expected(power, [int(tau_s * rate)])[0]) * 1e-9
        assert abs(found / deviation - 1) <= 0.01, spoken
        assert models.text_of(models.of_text(text, "text")).count(name) == 1


def test_a_file_is_read_as_it_was_written():
    words = {"column": "x", **dict.fromkeys(("course_hz", "apart_hz"), "0.1 0.2 0.2 0.1")}
    for kind in table.TABLE:
        effect = table.find(kind)
        values = {
            p.name: p.values[0] if p.values else words[p.name] if p.form else max(p.low, 0.25)
            for p in effect.parameters
            if p.whole is False
        } | {p.name: 3.0 for p in effect.parameters if p.whole or p.name == "reference"}
        for column in ("phase_s", "accel_x_g", "gyro_x_dps"):
            model = models.Model(1.0, column, [models.Term(kind, values)])
            again = models.of_text(models.text_of(model), "text")
            assert again.kinds == [kind]
            for name, value in again.terms[0].parameters.items():
                if isinstance(value, str) or isinstance(values[name], str):
                    assert value == values[name]
                else:
                    assert abs(value - values[name]) < 5e-13


def test_single_precision_is_too_coarse():
    recording = Recording({"phase_s": np.zeros(1200, np.float32)}, 1.0, "long.csv")
    with pytest.raises(BadInput, match="long.csv: column phase_s: .* single precision"):
        axes.for_analysis(recording, models.Model(1.0, "phase_s"))


@pytest.mark.parametrize(
    "column, text, expected",
    [
        (
            "phase_s",
            "gyro: step_dps = 3 deg/s; fit gyro_dps.csv -m logs/gyro/rec_dps.toml. A gyro.",
            "clock: step_ppb = 3 ppb; fit gyro_dps.csv -m logs/gyro/rec_dps.toml. A clock.",
        ),
        (
            "accel_x_g",
            "angle_random_walk, 3 deg/sqrt(h); fit angle_random_walk.csv -m of/angle_random_walk/m",
            "velocity_random_walk, 3 m/s/sqrt(h); fit angle_random_walk.csv -m "
            "of/angle_random_walk/m",
        ),
    ],
)
def test_names_of_files_stay(column, text, expected):
    assert axes.in_units(text, column) == expected


def test_a_fleet_reads_clocks_and_confirmed_recordings():
    words = ["fleet", "a.csv", "-m", "m.toml", "-o", "out", "--clock", "x=phase"]
    options = cli.parser().parse_args([*words, "--as-recorded"])
    how = command.work_of(options, ["a.csv"], models.Model(1.0, "x_phase_s"))[0].how
    assert (how.clocks, how.as_recorded) == (["x=phase"], True)


def written(lab, name, header, *columns):
    path = lab.work / name
    rows = "\n".join(",".join(f"{value:.17g}" for value in row) for row in zip(*columns))
    path.write_text(f"{header}\n{rows}\n" if header else f"{rows}\n")
    return path


def test_phase_and_frequency_are_one_clock(lab):
    x, found = noises(4), []
    time = np.arange(len(x), dtype=float)
    for name, header, columns, options in (
        ("a.csv", "time_s,phase_s", (time, x), ()),
        ("b.csv", "time_s,x_ns", (time, x * 1e9), ("--clock", "x_ns=phase_ns")),
        ("c.csv", "time_s,y", (time[:-1], np.diff(x)), ("--clock", "y=frequency")),
        (
            "d.csv",
            "time_s,counter_hz",
            (time[:-1], 1e7 * (1 + np.diff(x))),
            ("--clock", "counter_hz=10e6"),
        ),
        ("e.txt", "", (x,), ("--names", "phase_s", "--rate", "1")),
    ):
        effects = said("fit", written(lab, name, header, *columns), *options)["effects"]
        values = [list(one["parameters"].values()) for one in effects]
        found.append([one["value"] for of_effect in values for one in of_effect])
    for other in found[1:]:
        assert other == pytest.approx(found[0], rel=1e-3, abs=1e-15)


@pytest.mark.slow
def test_the_noises_of_a_clock_in_its_language(lab):
    within, fits = [], 0
    for seed in (1, 2, 3):
        x = noises(seed)
        path = written(lab, "clock.csv", "time_s,phase_s", np.arange(len(x), dtype=float), x)
        start, better, page = (lab.work / name for name in ("a.toml", "b.toml", "page.html"))
        fit = run("fit", path, "-o", start)
        improved = run("improve", path, "-m", start, "-o", better, "--report", page)
        assert improved.returncode in (0, 1), improved.stderr
        fits += improved.returncode == 0
        told = run("diagnose", path, "-m", start, "--json").stdout
        visible = re.sub(r"<(style|script)>.*?</\1>", "", page.read_text(), flags=re.S)
        texts = [fit.stdout, fit.stderr, improved.stdout, improved.stderr, told, visible]
        for text in (*texts, start.read_text(), better.read_text()):
            assert GYRO_WORDS.search(text) is None, GYRO_WORDS.search(text)
        data = json.loads(told)
        assert "high_pass" not in data["missing"]
        sizes = {one["kind"]: next(iter(one["parameters"].values())) for one in data["fitted"]}
        for kind, size in NOISES.items():
            if kind in sizes:
                within.append(sizes[kind]["low"] <= size <= sizes[kind]["high"])
    assert fits == 3
    assert len(within) >= 8
    # of nine 95 % intervals, seven or more are right in 99 % of all cases
    assert sum(within) >= len(within) - 2


def test_what_is_no_clock_is_one_error(lab):
    x = noises(1)
    path = written(lab, "clock.csv", "time_s,x", np.arange(len(x), dtype=float), x)
    for pair, words in (
        ("y=phase", "has no column 'y' (there are: time_s, x)"),
        ("x=angle", "phase, phase_ms, phase_us, phase_ns, frequency, or the nominal"),
        ("x=-5", "phase, phase_ms"),
        ("x", "phase, phase_ms"),
    ):
        told = lab.refused(f"--clock {pair}", "fit", path, "--clock", pair)
        assert words in told
    lab.refused("Of a clock: --clock COLUMN=phase", "fit", path, lines=None)
