"""davarlab export --to plan: the filter that a fit finds, in the firmware and in davar-sim. The
recording is made here: noise of 16 times the sample rate behind a filter of scipy.
"""

import csv
import gzip
import json
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from asking import ROOT, run
from scipy import signal

RATE, LSB, WINDOW, OVER = 100.0, 0.001, 600, 16
ARW, NAME = 0.3, "arw_deg_per_sqrt_h"
REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real"))
# Of rimu_lsm_40deg_steps, in s.
TURNS = (
    *((31, 37), (72, 79), (111, 117), (151, 157), (192, 198), (231, 239)),
    *((280, 287), (320, 326), (360, 366)),
)
WHITE = (
    '[sensor]\nrate_hz = 100.0\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    f"coefficient_deg_per_sqrt_h = {ARW}\n"
)
LOW = '[[effect]]\nkind = "low_pass"\ncutoff_hz = {}\nresponse = "{}"\norder = {}\n'
MEAN = '[[effect]]\nkind = "moving_average"\nsamples = {}\n'
FIRMWARE = """
#include "davar/davar.h"
#include "filter.h"
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
    davar_plan_init_filtered(&plan, davar_gyro_taus, DAVAR_GYRO_TAU_COUNT, &davar_gyro_filter);
    if (davar_init_q31(&gyro, &config, memory, sizeof memory) != DAVAR_OK) {
        return 1;
    }
    while (scanf("%d", &count) == 1) {
        const int32_t one = count;
        davar_push_q31(&gyro, &one, 1);
        if (davar_take(&gyro, &result)) {
            davar_fit(&plan, config.rate_hz, &result);
            const davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printf("%d %.9g %.9g %.9g\\n", (int)arw->present, arw->value, arw->low, arw->high);
        }
    }
    return 0;
}
"""


def exported(lab, model, *options):
    """The text and the JSON of an export, with each command on one line."""
    output = lab.work / "filter.h"
    done = run(
        "export", lab.file("m.toml", model), "--to", "plan", "-o", output, "--json", *options
    )
    assert done.returncode == 0, done.stderr
    text = output.read_text()
    assert max(map(len, text.splitlines())) <= 100
    return re.sub(r" \\\n \* +", " ", text), json.loads(done.stdout)


FLAGS = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-ffp-contract=off"]
FLAGS += [f"-I{ROOT / 'lib/include'}", f"-I{ROOT / 'lib/src'}"]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The objects of the library."""
    folder = tmp_path_factory.mktemp("library")
    sources = (ROOT / "lib/src").rglob("*.c")
    subprocess.run(["gcc", *FLAGS, "-c", *sources], cwd=folder, check=True)
    return list(folder.glob("*.o"))


def compiled(lab, library, program):
    source, output = lab.file("use.c", program), lab.work / "use"
    command = ["gcc", *FLAGS, source, *library, "-o", output, "-lm"]
    done = subprocess.run(command, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    return output


def simulated(recording, *options):
    """The rows that davar-sim prints."""
    words = [os.environ["DAVAR_SIM"], recording, *options]
    done = subprocess.run(words, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    return list(csv.DictReader(done.stdout.splitlines()))


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

    done = subprocess.run(
        [compiled(lab, library, FIRMWARE)],
        input="\n".join(map(str, counts)),
        text=True,
        capture_output=True,
        check=True,
    )
    device = [line.split() for line in done.stdout.splitlines()]
    assert samples // WINDOW == len(device)
    present = [tuple(map(float, row[1:])) for row in device if row[0] == "1"]
    holds = [low <= ARW <= high for _, low, high in present]
    assert len(present) >= 0.98 * len(device)
    assert np.mean(holds) >= 0.93  # 600 windows: 95 % less two standard errors
    assert abs(np.mean([value for value, _, _ in present]) / ARW - 1) < 0.02

    options = f"--rate 100 --lsb {LSB} --bits 32 --policy fixed --mode trailing --stride 600"
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
        MEAN.format(2) * 3,
    ):
        text, found = exported(lab, WHITE + filters, "--window", "600")
        line = re.search(r"tools/davar-plan (.*)", text)[1]
        done = subprocess.run(
            [ROOT / "tools/davar-plan", *line.split(), "--name", "ready"],
            text=True,
            capture_output=True,
        )
        assert done.returncode == 0, done.stderr
        program = done.stdout + (
            '#include "filter.h"\n#include <string.h>\nint main(void)\n{\n'
            "    static davar_plan_t plan;\n    davar_plan_init_filtered(&plan, "
            "davar_gyro_taus, DAVAR_GYRO_TAU_COUNT, &davar_gyro_filter);\n"
            "    return memcmp(&plan, &ready, sizeof plan) != 0;\n}\n"
        )
        assert subprocess.run([compiled(lab, library, program)]).returncode == 0


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


def holding(rows, arw):
    """(windows, those with an interval, those whose interval holds arw)."""
    limits = [[row[f"arw_{k}_deg_per_sqrt_h"] for k in ("low", "high")] for row in rows]
    given = [(float(low), float(high)) for low, high in limits if low]
    return len(rows), len(given), sum(low <= arw <= high for low, high in given)


def in_windows(recording, options, column="gyro_z_dps", window=WINDOW):
    """The results of davar-sim in windows that do not overlap."""
    words = f"--policy fixed --mode trailing --stride {window} --window-max {window}".split()
    return simulated(recording, "--column", column, *words, *options)


# The printed options give the true ARW, where davar-sim without them is wrong or withholds.


def recorded(lab, rates, lsb):
    recording = lab.work / "rec.csv"
    lines = [f"{n / RATE:.2f},{round(rate / lsb) * lsb:.7f}" for n, rate in enumerate(rates)]
    recording.write_text("time_s,gyro_z_dps\n" + "\n".join(lines) + "\n")
    return recording


@pytest.mark.slow
def test_the_intervals_of_the_printed_options_hold_the_true_arw(lab):
    samples = 90_000
    sigma = ARW / 60 * np.sqrt(RATE)
    line = '[[effect]]\nkind = "narrow_band"\nstd_dps = {}\nfrequency_hz = {}\n'
    line += "half_width_hz = {}\n"
    for seed, (_, make, lsb, model) in enumerate(
        (
            (
                "low-pass and line",
                lambda random: (
                    passed(random, samples, 7.0, 1) + band(random, samples, 31.4, 0.14, 0.01)
                ),
                0.007,
                LOW.format(7, "sampled", 1) + line.format(0.04, 31.4, 0.14),
            ),
            (
                "line",
                lambda random: (
                    random.normal(0, sigma, samples)
                    + band(random, samples, 31.4, 0.16, 0.6 * sigma)
                ),
                0.005,
                line.format(0.6 * sigma, 31.4, 0.16),
            ),
            ("coarse counts", lambda random: random.normal(0, sigma, samples), 1.2 * sigma, ""),
            (
                "sum with the sample before",
                lambda random: signal.lfilter([0.85, 0.15], [1], random.normal(0, sigma, samples)),
                0.005,
                MEAN.format(1.18),
            ),
        ),
        40,
    ):
        recording = recorded(lab, make(np.random.default_rng(seed)), lsb)
        # The judge rejects some recordings of a line after a low-pass: no fit there.
        stated = () if "low_pass" in model else ("--recording", recording)
        _, found = exported(lab, WHITE + model, *stated, "--window", WINDOW)
        if stated:
            assert abs(found["lsb_dps"] / lsb - 1) < 1e-3
        windows, _, held = holding(in_windows(recording, found["options"]), ARW)
        assert held >= 0.9 * windows
        default = in_windows(recording, [])
        values = [float(row[NAME]) for row in default if row[NAME]]
        assert found["device_default"]
        assert holding(default, ARW)[2] < 0.8 * windows or abs(np.median(values) / ARW - 1) > 0.05


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


def test_a_count_is_in_degrees_per_second_whatever_the_unit(lab):
    counts = np.rint(np.random.default_rng(42).normal(0, 3, 6000))
    for unit, factor in (("dps", 1.0), ("rad_s", np.pi / 180)):
        rows = [f"{n / RATE:.2f},{one * 0.00875 * factor:.9g}" for n, one in enumerate(counts)]
        recording = lab.work / "rec.csv"
        recording.write_text(f"time_s,gyro_z_{unit}\n" + "\n".join(rows) + "\n")
        model = WHITE.replace("gyro_z_dps", f"gyro_z_{unit}")
        _, found = exported(lab, model, "--recording", recording, "--window", "8192")
        assert abs(found["lsb_dps"] / 0.00875 - 1) < 1e-4, unit


def test_white_noise_in_fine_counts_needs_no_option(lab):
    rates = np.random.default_rng(50).normal(0, ARW / 60 * np.sqrt(RATE), 90_000)
    recording = recorded(lab, rates, 0.001)
    _, found = exported(lab, WHITE, "--recording", recording, "--window", WINDOW)
    assert (found["bandwidth"], found["device_default"]) == ("none", None)
    windows, _, held = holding(in_windows(recording, []), ARW)
    assert held >= 0.9 * windows


def test_fit_warns_in_one_sentence_where_the_default_of_the_device_is_wrong(lab):
    random = np.random.default_rng(60)
    recording = recorded(lab, passed(random, 90_000, 20.0, 2), LSB)
    model = lab.file("m.toml", WHITE + LOW.format(20, "sampled", 2))
    lines = run("fit", recording, "-m", model).stdout.splitlines()
    said = [line for line in lines if line.startswith("Without --bandwidth, ")]
    assert len(said) == 1
    assert re.search(r"too low in windows of 600 samples; export --to plan", said[0])
    done = run("fit", recording, "-m", model, "--json")
    assert said[0] == json.loads(done.stdout)["device_default"]


def test_an_arw_that_the_device_cannot_separate_from_a_line_is_refused(lab):
    line = '[[effect]]\nkind = "{}"\n{} = {}\nfrequency_hz = {}\n'
    wide = "half_width_hz = 20\n"
    for model, why in (
        # Lorentzian: its tail is as high as the white noise down to frequency 0.
        (line.format("narrow_band", "std_dps", 0.1, 20) + wide, "again"),
        # A period of 91 samples: the line is in every long cluster size of 600 samples.
        (line.format("sinusoid", "amplitude_dps", 0.02, 1.1), "Give --window"),
    ):
        output = lab.work / "none.h"
        model = lab.file("m.toml", WHITE + model)
        words = ("export", model, "--to", "plan", "--window", "600", "-o", output)
        done = run(*words)
        assert (done.returncode, done.stdout) == (2, "")
        assert re.search(r"\Adavarlab: [^\n]+\n\Z", done.stderr)
        assert "the device cannot give the model's ARW" in done.stderr
        assert why in done.stderr
        assert not output.exists()
    larger = re.search(r"--window (\d+)", done.stderr)[1]
    exported(lab, model.read_text(), "--window", larger)


# Of real sensors at rest: the printed options hold the ARW that the lab fits.


@pytest.mark.slow
def test_the_intervals_hold_the_arw_of_the_lab(lab):
    line = '[[effect]]\nkind = "narrow_band"\nstd_dps = {}\nfrequency_hz = {}\n'
    line += "half_width_hz = {}\n"
    flicker = '[[effect]]\nkind = "bias_instability"\ncoefficient_deg_per_h = 20\n'
    ramp = '[[effect]]\nkind = "warm_up"\namplitude_dps = 0.1\ntime_constant_s = 300\n'
    behind = "noise_behind_dps = 0.02\n"
    for name, axis, rate, model in (
        ("rimu_lsm_40deg_steps", "x", None, LOW.format(8, "analogue", 1) + behind),
        (
            "rimu_lsm_40deg_steps",
            "z",
            None,
            LOW.format(6, "sampled", 1) + behind + line.format(0.15, 33.2, 2.8),
        ),
        ("mpu6050_static_11min_jitter", "z", 99.3, line.format(0.06, 31.38, 0.16)),
        ("mpu6050_temp_ramp_gaps", "z", None, ramp),
        ("adis16405_run1_static", "x", None, MEAN.format(1.17)),
    ):
        path = REAL / f"{name}.csv.gz"
        if not path.is_file():
            pytest.skip(f"needs the recording {path.name}")
        check(
            lab,
            path,
            f"gyro_{axis}_dps",
            rate,
            WHITE.replace("_z_", f"_{axis}_").replace("rate_hz = 100.0\n", ""),
            flicker + model,
        )


def check(lab, path, column, rate, white, model):
    start, fitted = lab.file("start.toml", white + model), lab.work / "fitted.toml"
    stated = ["--rate", rate] * bool(rate)
    with gzip.open(path, "rt") as file:
        rows = [line for line in file if not line.startswith("#")][:100_001]
    recording = lab.file("rec.csv", "".join(rows))
    done = run("fit", recording, "-m", start, "-o", fitted, "--json", *stated)
    assert done.returncode == 0, done.stderr
    text = fitted.read_text()
    arw = float(re.search(r"coefficient_deg_per_sqrt_h = (\S+)", text)[1])
    if "half_width_hz = 2.8" in model:  # its tail is 5 % of the Allan deviation everywhere
        output = lab.work / "filter.h"
        words = ("--to", "plan", "-o", output, "--window", "600", "--recording", recording)
        done = run("export", fitted, *words)
        assert done.returncode == 2
        assert "narrow_band changes the Allan deviation at 16 samples" in done.stderr
        return
    _, found = exported(lab, text, "--recording", recording, "--window", WINDOW, *stated)
    at_rest = [
        row
        for row in in_windows(recording, found["options"], column)
        if "rimu" not in path.name
        or all(
            not first - 1 < float(row["time_s"]) < last + 3 + WINDOW / RATE for first, last in TURNS
        )
    ]
    windows, given, held = holding(at_rest, arw)
    assert given >= 0.9 * windows
    assert held >= 0.9 * given


def test_the_filters_of_a_model_are_those_of_the_option(lab):
    for filters, bandwidth in (
        (LOW.format(20, "sampled", 1), "20:1:10"),
        (LOW.format(33.25, "sampled", 2), "33.25:2:10"),
        ("", "none"),
        (MEAN.format(1.2), "none"),
        (MEAN.format(4), "average:4"),
        (MEAN.format(3.99), "average:4"),
        (MEAN.format(2) * 2, "average2:2"),
        (LOW.format(20, "sampled", 2) + MEAN.format(8), "20:2:10+average:8"),
    ):
        assert bandwidth == exported(lab, WHITE + filters)[1]["bandwidth"]


def test_a_filter_of_a_data_sheet_is_added_and_exported(lab):
    model = lab.work / "sheet.toml"
    words = ("low_pass", "cutoff_hz=33", "order=2")
    done = run("add", lab.file("white.toml", WHITE), *words, "-o", model)
    assert done.returncode == 0, done.stderr
    assert exported(lab, model.read_text())[1]["bandwidth"] == "33:2:10"


def test_cluster_sizes_where_the_filters_differ_are_left_out(lab):
    for filters, first in (
        (LOW.format(20, "sampled", 1), 1),
        (LOW.format(20, "bilinear", 1), 4),
        (LOW.format(5, "analogue", 2), 1),
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
        (WHITE.replace(f"{ARW}\n", "0\n") + low, "no angle_random_walk"),
        (WHITE.replace("rate_hz = 100.0\n", "") + low, "no rate_hz"),
    ):
        output = lab.work / "none.h"
        done = run("export", lab.file("m.toml", model), "--to", "plan", "-o", output)
        assert (done.returncode, done.stdout) == (2, "")
        assert re.search(r"\Adavarlab: [^\n]+\n\Z", done.stderr)
        assert why in done.stderr
        assert not output.exists()


def test_a_model_that_does_not_fit_the_recording_is_rejected(lab):
    recording = lab.work / "rec.csv"
    values = np.random.default_rng(3).normal(0, 0.05, 20000)
    values[10000:] *= 3
    lines = [f"{n / RATE:.2f},{value:.6f}" for n, value in enumerate(values)]
    recording.write_text("time_s,gyro_z_dps\n" + "\n".join(lines) + "\n")
    model, output = lab.file("m.toml", WHITE + MEAN.format(2)), lab.work / "f.h"
    done = run("export", model, "--to", "plan", "--recording", recording, "-o", output)
    assert done.returncode == 2, done.stderr
    assert "the model does not fit" in done.stderr
    assert not output.exists()
