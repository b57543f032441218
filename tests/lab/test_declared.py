"""davarlab export --to plan: the filter that a fit finds, in the firmware and in davar-sim. The
recording is made here: noise of 16 times the sample rate behind a filter of scipy.
"""

import csv
import os
import re
import subprocess
from pathlib import Path
from types import SimpleNamespace

import c_library
import numpy as np
import pytest
from asking import ROOT, run, said
from davarlab.effects.filters import half_power_hz
from davarlab.report import declared
from lab_bench import write_csv
from scipy import signal

RATE, LSB, WINDOW, OVER = 100.0, 0.001, 600, 16
ARW, NAME = 0.3, "arw_deg_per_sqrt_h"
WHITE = (
    '[sensor]\nrate_hz = 100.0\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    f"coefficient_deg_per_sqrt_h = {ARW}\n"
)
LOW = '[[effect]]\nkind = "low_pass"\ncutoff_hz = {}\nresponse = "{}"\norder = {}\n'
RESPONSE = '[[effect]]\nkind = "low_pass"\ncutoff_hz = {}\nresponse = "{}"\n'
MEAN = '[[effect]]\nkind = "moving_average"\nsamples = {}\n'
FIRMWARE = """
#include "davar/davar.h"
#include "davar/fit.h"
#include "f.h"
#include <stdio.h>
static const davar_config_t config = {
    .rate_hz = 100.0, .unit_per_count = 0.001, .stride = 600, DAVAR_FIXED(600),
    .moments = {.segment = 100}, /* as davar-sim: its kurtosis widens the intervals */
    .taus = davar_gyro_taus, .tau_count = DAVAR_GYRO_TAU_COUNT};
int main(void)
{
    static davar_t gyro;
    static uint64_t memory[1 << 14];
    static davar_plan_t plan;
    static davar_result_t result;
    int count;
    const davar_filter_t filter = davar_gyro_filter();
    davar_plan_init_filtered(&plan, davar_gyro_taus, DAVAR_GYRO_TAU_COUNT, &filter);
    if (davar_init_q31(&gyro, &config, memory, sizeof memory) != DAVAR_OK) {
        return 1;
    }
    while (scanf("%d", &count) == 1) {
        const int32_t one = count;
        davar_push_q31(&gyro, &one, 1);
        if (davar_take(&gyro, &result)) {
            davar_fit(&plan, config.rate_hz, &result);
            davar_fit_flat(&plan, config.rate_hz, &result);
            const davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printf("%d %.9g %.9g %.9g\\n", (int)arw->present, arw->value, arw->low, arw->high);
        }
    }
    return 0;
}
"""


NASTY = ("a*/b", "/*", "x */ int y; /*", "ä ö", "1x", "a-b.c", "a'b", "a\\", 'a"b', "n" * 200)
NASTY += ("two\nlines", "*\\\n/", "??/", "\udcff", "\u202e", "%s{}")


def any_filter(text):
    return RESPONSE.format(half_power_hz(text, RATE), text)


def export(lab, model, *options):
    """The words of an export."""
    return ("export", lab.file("m.toml", model), "--to", "plan", "-o", lab.work / "f.h", *options)


def exported(lab, model, *options):
    """The text and the JSON of an export, with each command on one line."""
    found = said(*export(lab, model, *options))
    text = (lab.work / "f.h").read_text()
    assert max(map(len, text.splitlines())) <= 100
    return re.sub(r" \\\n \* +", " ", text), found


FLAGS = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-ffp-contract=off"]
FLAGS += c_library.FLAGS


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The objects of the library."""
    folder = tmp_path_factory.mktemp("library")
    subprocess.run(["gcc", *FLAGS, "-c", *c_library.SOURCES], cwd=folder, check=True)
    return list(folder.glob("*.o"))


def done(*words, **more):
    """The output of a program that succeeds."""
    found = subprocess.run(words, text=True, capture_output=True, **more)
    assert found.returncode == 0, found.stderr
    return found.stdout


def compiled(lab, library, program):
    output = lab.work / "use"
    done("gcc", *FLAGS, lab.file("use.c", program), *library, "-o", output, "-lm")
    return output


def simulated(recording, *options):
    """The rows that davar-sim prints."""
    return list(csv.DictReader(done(os.environ["DAVAR_SIM"], recording, *options).splitlines()))


def band(random, samples, hz, half_width_hz, std):
    """A line with a width: a carrier whose complex amplitude is a Gauss-Markov process."""
    memory = np.exp(-2 * np.pi * half_width_hz / RATE)
    steps = random.normal(0, std * np.sqrt(1 - memory**2), (2, samples + 2000))
    slow = signal.lfilter([1], [1, -memory], steps)[:, 2000:]
    turn = 2 * np.pi * hz / RATE * np.arange(samples)
    return slow[0] * np.cos(turn) - slow[1] * np.sin(turn)


def passed(random, samples, cutoff, order):
    """White noise after an analogue low-pass, sampled."""
    noise = random.normal(0, ARW / 60 * np.sqrt(OVER * RATE), (samples + 100) * OVER)
    sections = signal.butter(order, cutoff, fs=OVER * RATE, output="sos")
    return signal.sosfilt(sections, noise)[100 * OVER :: OVER]


def holding(rows):
    """(windows, those whose interval holds ARW)."""
    limits = [[row[f"arw_{k}_deg_per_sqrt_h"] for k in ("low", "high")] for row in rows]
    return len(rows), sum(float(low) <= ARW <= float(high) for low, high in limits if low)


def width(rows):
    """The median of how far the intervals reach above ARW, over ARW."""
    return np.median([float(row["arw_high_deg_per_sqrt_h"]) for row in rows if row[NAME]]) / ARW - 1


def in_windows(recording, options):
    """The results of davar-sim in windows that do not overlap."""
    words = f"--column gyro_z_dps --law fixed --mode trailing --stride {WINDOW}".split()
    return simulated(recording, *words, "--window-max", f"{WINDOW}", *options)


@pytest.mark.slow
def test_the_fitted_filter_gives_the_true_arw_on_the_device_and_in_davar_sim(lab, library):
    cutoff, samples, random = 20.0, 360_000, np.random.default_rng(20)
    rates = passed(random, samples, cutoff, 2)
    counts = np.rint(rates / LSB).astype(int)
    recording = recorded(lab, counts * LSB, LSB)
    model = WHITE + LOW.format(18, "sampled", 2)
    text, found = exported(lab, model, "--recording", recording, "--window", WINDOW)
    assert abs(found["cutoff_hz"] / cutoff - 1) < 0.02
    assert (found["order"], found["cutoff_percent"]) == (2, 1.0)
    assert found["taus"] == [1, 2, 4, 8, 16, 32, 64]
    assert ["--bandwidth", found["bandwidth"], "--lsb", f"{LSB}"] == found["options"]
    assert f"davar-sim REC {' '.join(found['options'])}\n" in text

    printed = done(compiled(lab, library, FIRMWARE), input="\n".join(map(str, counts)))
    device = [line.split() for line in printed.splitlines()]
    assert samples // WINDOW == len(device)
    present = [tuple(map(float, row[1:])) for row in device if row[0] == "1"]
    holds = [low <= ARW <= high for _, low, high in present]
    assert len(present) >= 0.98 * len(device)
    assert np.mean(holds) >= 0.93  # 600 windows: 95 % less two standard errors
    assert abs(np.mean([value for value, _, _ in present]) / ARW - 1) < 0.02

    options = f"--rate 100 --lsb {LSB} --bits 32 --law fixed --mode trailing --stride 600"
    options += f" --window-max 600 --bandwidth {found['bandwidth']}"
    names = [f"arw_{part}deg_per_sqrt_h" for part in ("", "low_", "high_")]
    rows = [[row[name] for name in names] for row in simulated(recording, *options.split())]
    assert [row[1:] if row[0] == "1" else ["", "", ""] for row in device] == rows


@pytest.mark.slow
def test_davar_plan_makes_the_plan_of_the_header(lab, library):
    for filters in (
        "",
        LOW.format(20, "sampled", 1),
        LOW.format(7.3, "sampled", 2) + MEAN.format(4),
        LOW.format(12, "bilinear", 2),
        MEAN.format(2) * 3,
        any_filter("20:2+notch:30:5"),
        any_filter("ba:0.3,0.2,0.1:-0.5,0.1:1.5") + MEAN.format(3),
        LOW.format(20, "sampled", 1) + any_filter("biquad:15"),
    ):
        text, found = exported(lab, WHITE + filters, "--window", "600")
        line = re.search(r"tools/davar-plan (.*)", text)[1]
        plan = done(ROOT / "tools/davar-plan", *line.split(), "--name", "ready")
        program = plan + (
            '#include "f.h"\n#include <string.h>\nint main(void)\n{\n'
            "    static davar_plan_t plan;\n    const davar_filter_t filter = "
            "davar_gyro_filter();\n    davar_plan_init_filtered(&plan, davar_gyro_taus, "
            "DAVAR_GYRO_TAU_COUNT, &filter);\n"
            "    return memcmp(&plan, &ready, sizeof plan) != 0;\n}\n"
        )
        done(compiled(lab, library, program))


def recorded(lab, rates, lsb):
    counted = {"time_s": np.arange(len(rates)) / RATE, "gyro_z_dps": np.round(rates / lsb) * lsb}
    return write_csv(lab.work / "rec.csv", counted, ["%.2f", "%.7f"])


def line(std, hz, half_width_hz):
    return (
        f'[[effect]]\nkind = "narrow_band"\nstd_dps = {std}\nfrequency_hz = {hz}\n'
        f"half_width_hz = {half_width_hz}\n"
    )


SIGMA = ARW / 60 * np.sqrt(RATE)
SENSORS = {  # name: (how it is made of so many samples, its counts, its model beside white noise)
    "low-pass and line": (
        lambda random, n: passed(random, n, 7.0, 1) + band(random, n, 31.4, 0.14, 0.01),
        0.007,
        LOW.format(7, "sampled", 1) + line(0.04, 31.4, 0.14),
    ),
    "line": (
        lambda random, n: random.normal(0, SIGMA, n) + band(random, n, 31.4, 0.16, 0.6 * SIGMA),
        0.005,
        line(0.6 * SIGMA, 31.4, 0.16),
    ),
    "fine counts": (lambda random, n: random.normal(0, SIGMA, n), 0.001, ""),
    "coarse counts": (lambda random, n: random.normal(0, SIGMA, n), 1.2 * SIGMA, ""),
    "sum with the sample before": (
        lambda random, n: signal.lfilter([0.85, 0.15], [1], random.normal(0, SIGMA, n)),
        0.005,
        MEAN.format(1.18),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("seed, name", enumerate(SENSORS, 40), ids=SENSORS)
def test_the_printed_options_give_the_true_arw_where_the_default_does_not(lab, seed, name):
    make, lsb, model = SENSORS[name]
    recording = recorded(lab, make(np.random.default_rng(seed), 90_000), lsb)
    # The judge rejects some recordings of a line after a low-pass: no fit there.
    stated = () if "low_pass" in model else ("--recording", recording)
    _, found = exported(lab, WHITE + model, *stated, "--window", WINDOW)
    if stated and name != "fine counts":
        assert abs(found["lsb_dps"] / lsb - 1) < 1e-3
    windows, held = holding(in_windows(recording, found["options"]))
    assert held >= 0.9 * windows
    default = in_windows(recording, [])
    if name == "fine counts":
        assert (found["bandwidth"], found["device_default"]) == ("none", None)
        assert holding(default)[1] >= 0.9 * windows
    else:
        values = [float(row[NAME]) for row in default if row[NAME]]
        wider = width(default) / width(in_windows(recording, found["options"]))
        assert found["device_default"]
        wrong = holding(default)[1] < 0.8 * windows or abs(np.median(values) / ARW - 1) > 0.05
        assert wrong or wider > 1.5


def test_a_rate_that_is_stated_comes_with_the_gaps_of_the_recording(lab):
    """Times in whole milliseconds: the median step is 3 ms, the mean 3.08."""
    rate, rng = 325.0, np.random.default_rng(41)
    rows = [
        f"{round(n / rate, 3):.3f},{round(x, 4):.4f}"
        for n, x in enumerate(rng.normal(0, ARW / 60 * np.sqrt(rate), 60_000))
    ]
    recording = lab.work / "rec.csv"
    for lost in (False, True):
        kept = rows[:20_000] + rows[23_000:] if lost else rows
        recording.write_text("time_s,gyro_z_dps\n" + "\n".join(kept) + "\n")
        model = WHITE.replace("100.0", f"{rate}")
        _, found = exported(lab, model, "--recording", recording, "--window", WINDOW)
        assert "--rate" in found["options"]
        assert ("--gap" in found["options"]) == lost
        ends = np.array([float(row["time_s"]) for row in in_windows(recording, found["options"])])
        within = (ends > 20_000 / rate) & (ends < 23_000 / rate)
        assert int(within.sum()) == (0 if lost else 5)


@pytest.mark.parametrize("unit, factor", [("dps", 1.0), ("rad_s", np.pi / 180)])
def test_a_count_is_in_degrees_per_second_whatever_the_unit(lab, unit, factor):
    rates = np.rint(np.random.default_rng(42).normal(0, 3, 6000)) * 0.00875 * factor
    columns = {"time_s": np.arange(6000) / RATE, f"gyro_z_{unit}": rates}
    recording = write_csv(lab.work / "rec.csv", columns)
    model = WHITE.replace("gyro_z_dps", f"gyro_z_{unit}")
    _, found = exported(lab, model, "--recording", recording, "--window", "8192")
    assert abs(found["lsb_dps"] / 0.00875 - 1) < 1e-4


def test_fit_warns_in_one_sentence_where_the_default_of_the_device_is_wrong(lab):
    random = np.random.default_rng(60)
    recording = recorded(lab, passed(random, 90_000, 20.0, 2), LSB)
    model = lab.file("m.toml", WHITE + LOW.format(20, "sampled", 2))
    lines = run("fit", recording, "-m", model).stdout.splitlines()
    (told,) = [line for line in lines if line.startswith("Without --bandwidth, ")]
    assert "wider interval, or withholds it, in windows of 600 samples; export --to plan" in told
    assert told == said("fit", recording, "-m", model)["device_default"]


def test_an_arw_that_the_device_cannot_separate_from_a_line_is_refused(lab):
    sine = '[[effect]]\nkind = "sinusoid"\namplitude_dps = 0.02\nfrequency_hz = 1.1\n'
    for model, why in (
        # Lorentzian: its tail is as high as the white noise down to frequency 0.
        (line(0.1, 20, 20), "again"),
        # A period of 91 samples: the line is in every long cluster size of 600 samples.
        (sine, "Give --window"),
    ):
        told = lab.refused(why, *export(lab, WHITE + model, "--window", 600))
        assert "the device cannot give the model's ARW" in told
    exported(lab, WHITE + sine, "--window", re.search(r"--window (\d+)", told)[1])


@pytest.mark.parametrize("name", NASTY)
def test_a_header_of_a_model_of_any_name_compiles(lab, name):
    model, out = Path(f"{lab.work}/{name}.toml"), lab.work / "f.h"
    model.parent.mkdir(parents=True, exist_ok=True)
    model.write_text(WHITE)
    assert run("export", model, "--to", "plan", "-o", out).returncode == 0
    done("gcc", *FLAGS, "-fsyntax-only", "-x", "c", out)


@pytest.mark.parametrize("column", ["a*/b", "/*", "x */ int y; /*"])
def test_a_header_of_a_model_with_any_column_compiles(lab, column):
    follows = f'[[effect]]\nkind = "follows"\ncoefficient = 0.1\ncolumn = "{column}"\n'
    model, out = lab.file("m.toml", WHITE + follows), lab.work / "f.h"
    assert run("export", model, "-o", out).returncode == 0
    done("gcc", *FLAGS, "-fsyntax-only", "-x", "c", out)


@pytest.mark.parametrize("percent", (3.0, 12.0))
def test_the_stated_doubt_is_one_standard_error(percent):
    reach = 1.959964 * percent / 100 * 50  # of a 95 % interval
    cutoff = SimpleNamespace(number=50.0, low=50 - reach, high=50 + reach)
    assert declared.percent_of({"cutoff_hz": cutoff}, "m.toml") == percent


def test_the_filters_of_a_model_are_those_of_the_option(lab):
    for filters, bandwidth in (
        (LOW.format(20, "sampled", 1), "20:1:10"),
        (LOW.format(33.25, "sampled", 2), "33.25:2:10"),
        (LOW.format(20, "bilinear", 2), "biquad:20:10"),
        (LOW.format(12.5, "bilinear", 1), "ba:0.292893219,0.292893219:-0.414213562:10"),
        ("", "none"),
        (MEAN.format(1.2), "none"),
        (MEAN.format(4), "average:4"),
        (MEAN.format(3.99), "average:4"),
        (MEAN.format(2) * 2, "average2:2"),
        (LOW.format(20, "sampled", 2) + MEAN.format(8), "20:2:10+average:8"),
        (any_filter("biquad:20+notch:30:5"), "biquad:20+notch:30:5"),
        (LOW.format(20, "sampled", 2) + any_filter("pt1:9"), "20:2:10+pt1:9"),
    ):
        assert bandwidth == exported(lab, WHITE + filters)[1]["bandwidth"]
    sheet, words = lab.work / "sheet.toml", ("low_pass", "cutoff_hz=33", "order=2")
    added = run("add", lab.file("white.toml", WHITE), *words, "-o", sheet)
    assert added.returncode == 0, added.stderr
    assert exported(lab, sheet.read_text())[1]["bandwidth"] == "33:2:10"


def test_cluster_sizes_where_the_filters_differ_are_left_out(lab):
    for filters, first in (
        (LOW.format(20, "sampled", 1), 1),
        (LOW.format(20, "bilinear", 1), 1),
        (any_filter("biquad:5+notch:20:2"), 1),
        (any_filter("ba:0.3,0.2,0.1:-0.5,0.1:1"), 1),
        (MEAN.format(1.2), 16),
    ):
        text, found = exported(lab, WHITE + filters)
        assert [first * 2**n for n in range(len(found["taus"]))] == found["taus"]
        assert (first > 1) == ("Without the cluster sizes up to" in text)


def test_a_filter_that_the_device_does_not_know_is_rejected(lab):
    low = LOW.format(20, "sampled", 2)
    behind = low + "noise_behind_dps = 0.03\n"
    high = '[[effect]]\nkind = "high_pass"\ncorner_period_s = 100\n'
    for model, why in (
        (WHITE + low + low, "two low_pass: the device knows one"),
        (WHITE + low + high, "high_pass: the device knows low_pass and moving_average only"),
        (WHITE + MEAN.format(2) + MEAN.format(4), "2 lengths; the device knows one"),
        (WHITE + MEAN.format(2) * 9, "9 of 2 samples; the device knows up to 8"),
        (WHITE + MEAN.format(1025), "1 of 1025 samples; the device knows up to 8, together"),
        (WHITE + LOW.format(0.1, "sampled", 2), "cutoff_hz is 0.001 of the sample rate"),
        (WHITE + LOW.format(900, "sampled", 2), "cutoff_hz is 9 of the sample rate"),
        (WHITE + behind, "noise_behind_dps"),
        (WHITE + RESPONSE.format(9, "biquad:60"), "found biquad:60"),
        (WHITE + RESPONSE.format(9, "biquad:20:x"), "response: "),
        (WHITE + RESPONSE.format(9, "biquad:20"), "give cutoff_hz = 20"),
        (WHITE.replace(f"{ARW}\n", "0\n") + low, "no angle_random_walk"),
        (WHITE.replace("rate_hz = 100.0\n", "") + low, "no rate_hz"),
    ):
        lab.refused(why, *export(lab, model))


def test_a_model_that_does_not_fit_the_recording_is_rejected(lab):
    values = np.random.default_rng(3).normal(0, 0.05, 20000)
    values[10000:] *= 3
    words = export(lab, WHITE + MEAN.format(2), "--recording", recorded(lab, values, 1e-6))
    lab.refused("the model does not fit", *words, lines=None)
