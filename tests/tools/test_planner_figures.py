"""Every figure of a plan against a source other than the planner: simulated noise through
davar-sim, chi-square, the compiler, measurements on emulated boards, and the planner's rules.
"""

import csv
import json
import math
import random
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import setup_cost
from planner import costs, programs, sensors, text
from planner.design import Design
from planner_case import (
    EXAMPLE,
    ROOT,
    SIM,
    after_two_poles,
    command,
    gcc,
    plan_of,
    planned,
    printed_by,
    write,
)
from planner_case import refused as refused_by
from scipy import signal, stats

COSTS = json.loads((ROOT / "python/planner/costs.json").read_text())
SUM_BITS = {"int16": 32, "int32": 80, "float": 66}  # W m^2 of exact sums, lib/DESIGN.md (2.4)


# --- what a setup promises ---


def filtered(bandwidth, rate, count, noise):
    """White noise of N = 1 per root sample after a filter, as samples."""
    white = noise.standard_normal(count)
    if bandwidth and bandwidth.startswith("average:"):
        length = int(bandwidth.partition(":")[2])
        return signal.lfilter(np.ones(length) / length, [1.0], white)
    cutoff, _, poles = (bandwidth or "").partition(":")
    if poles == "1":  # the sampled output is AR(1)
        pole = math.exp(-2 * math.pi * float(cutoff) / rate)
        return signal.lfilter([1 - pole], [1.0, -pole], white)
    if poles == "2":
        return after_two_poles(float(cutoff) / rate, count, noise)
    assert bandwidth in (None, "none"), bandwidth
    return white


def simulated(plan, counts, *options):
    """Rows of davar-sim for a recording of counts."""
    wishes, design = plan.design.wishes, plan.design
    unit = wishes.lsb or 1.0
    words = ["--rate", wishes.rate_hz, "--window-max", design.window, "--stride", design.stride]
    words += ["--window-min", design.shortest, "--mode", "trailing"]
    words += ["--taus", ",".join(map(str, design.taus)), "--details"]
    words += ["--lsb", unit] if wishes.lsb else ["--arith", "float"]
    words += ["--bandwidth", wishes.bandwidth] if wishes.bandwidth else []
    text = "gyro_z_dps\n" + "".join(f"{count * unit:.9g}\n" for count in counts)
    command = [SIM, "-", *map(str, words), *map(str, options)]
    done = subprocess.run(command, input=text, text=True, capture_output=True, check=True)
    return list(csv.DictReader(done.stdout.splitlines()))


WINDOWS = 120
FIXED = (
    "--rate 100 --lsb 0.05 --bandwidth none",
    "--rate 1000 --axes 2 --lsb 0.061 --bandwidth none --respond 0.6 --longest-tau 100",
    "--rate 100 --lsb 0.05 --bandwidth average:4 --respond 8",
    "--rate 200 --type int32 --lsb 0.002 --bandwidth average:8 --respond 4",
    "--rate 100 --lsb 0.05",
    "--rate 50 --type float --full-scale 500 --bandwidth none --respond 9",
    "--rate 100 --lsb 0.05 --bandwidth 5:1 --respond 20",
    "--rate 100 --lsb 0.05 --bandwidth none --noise 0.4 --respond 3",
    "--rate 100 --lsb 0.05 --bandwidth none --arw-percent 8",
    "--rate 1000 --lsb 0.061 --bandwidth 250:2 --respond 2",
)


@pytest.mark.parametrize("words", FIXED)
def test_the_interval_of_arw_is_as_wide_as_promised_and_holds_the_truth(words):
    plan = plan_of(f"{words} --core cortex-m4f")
    wishes, window = plan.design.wishes, plan.design.window
    sigma = 30.0  # counts of a sample before the filter
    if wishes.noise:
        sigma = wishes.noise / 60 * math.sqrt(wishes.rate_hz) / wishes.lsb
    noise = np.random.default_rng(len(words))
    samples = filtered(wishes.bandwidth, wishes.rate_hz, WINDOWS * window + 1000, noise)[1000:]
    counts = sigma * samples if wishes.type == "float" else np.rint(sigma * samples)
    rows = simulated(plan, counts, "--law", "fixed", "--stride", window)
    found = np.array(
        [
            [float(row[f"arw_{what}deg_per_sqrt_h"]) for what in ("", "low_", "high_")]
            for row in rows
            if row["arw_deg_per_sqrt_h"]
        ]
    )
    assert len(rows) == WINDOWS
    assert len(found) > 0.9 * WINDOWS
    value, low, high = found.T
    width = np.median(50 * (high - low) / value)
    assert plan.promise.arw_percent == pytest.approx(width, rel=0.08)
    truth = 60 * sigma * (wishes.lsb or 1.0) / math.sqrt(wishes.rate_hz)
    assert np.mean((low <= truth) & (truth <= high)) > 0.9


@pytest.mark.parametrize(
    "words",
    (
        "--rate 1000 --lsb 0.061 --bandwidth none --false-alarms-per-hour 0.1",
        "--rate 200 --lsb 0.061 --bandwidth 30:1 --arw-percent 20 --false-alarms-per-hour 0.003",
        "--rate 100 --type int32 --lsb 0.05 --bandwidth none --respond 1.1 --arw-percent 8",
    ),
)
def test_an_alarm_comes_as_soon_as_promised_and_the_window_is_as_long(words):
    plan = plan_of(f"{words} --core cortex-m4f")
    wishes, stride = plan.design.wishes, plan.design.stride
    promised = plan.promise.respond_s * wishes.rate_hz
    quiet, loud, changes = 1500, 1500, 30
    noise, late, windows = np.random.default_rng(8), [], []
    for _ in range(changes):
        start = quiet + noise.integers(stride)
        scale = np.repeat([1.0, 2.0], [start, loud])
        samples = filtered(wishes.bandwidth, wishes.rate_hz, len(scale), noise)
        rows = simulated(
            plan,
            np.rint(40 * samples * scale),
            *("--law", "glr", "--false-alarms-per-hour", wishes.false_alarms_per_hour),
        )
        alarms = [int(row["epoch"]) for row in rows if row["alarm"] == "1"]
        late.append(next((at - start + 1 for at in alarms if at >= start), math.inf))
        windows += [
            int(row["window_samples"])
            for row in rows
            if plan.design.window < int(row["epoch"]) < start
        ]
    late = np.array(late)
    assert np.mean(late <= promised) >= 0.8, late
    assert promised < 2 * np.quantile(late, 0.9)
    assert np.mean(windows) / plan.design.window == pytest.approx(2 / 3, rel=0.2)
    assert plan.promise.false_alarms_per_hour == wishes.false_alarms_per_hour


def freedom_of_walk(clusters, m=16):
    """Degrees of freedom of the overlapped Allan variance of a random walk, of its covariance."""
    walk = np.cumsum(np.repeat([-1.0, 1.0], m))
    covariance = np.correlate(walk, walk, "full")
    count = clusters * m + 1 - 2 * m
    lags = np.arange(len(covariance)) - (len(walk) - 1)
    pairs = np.maximum(0, count - np.abs(lags))
    return count**2 / np.sum(pairs * (covariance / covariance.max()) ** 2)


def test_the_curve_has_the_interval_of_its_clusters_and_the_floor_of_the_noise():
    words = "--sensor bmi088@400 --core cortex-m4f"
    found = planned(f"{words} --longest-tau 4000")
    longest = max(found["taus_s"])
    assert longest >= 4000
    assert found["curve_first_s"] == 2 * longest
    assert found["curve_settled_s"] == 34 * longest
    freedom = freedom_of_walk(34)
    low, high = (math.sqrt(freedom / stats.chi2.ppf(p, freedom)) for p in (0.975, 0.025))
    assert found["curve_percent"] == pytest.approx(50 * (high - low), rel=0.01)
    # white noise of N deg/s/sqrt(Hz) has the deviation N / sqrt(tau)
    one_sided = sensors.PARTS["bmi088"]["noise_dps_per_root_hz"]
    deviation = 3600 * one_sided / math.sqrt(2) / math.sqrt(longest)
    floor = math.sqrt(2 * math.log(2) / math.pi)
    assert found["bias_instability_deg_per_h"] == pytest.approx(deviation / floor, rel=1e-3)
    without = planned(words)
    for key in ("curve_first_s", "curve_settled_s", "curve_percent", "bias_instability_deg_per_h"):
        assert without[key] is None


# --- what the planner chooses ---


def random_wishes(count):
    """Fixed windows without limits."""
    draw = random.Random(54)
    for _ in range(count):
        rate = draw.choice([5, 25, 100, 333, 1000, 4000])
        type = draw.choice(list(SUM_BITS))
        words = f"--rate {rate} --type {type} --axes {draw.randint(1, 4)} "
        words += "--full-scale 250 " if type == "float" else f"--lsb {draw.choice([0.1, 0.004])} "
        words += draw.choice(["", "--bandwidth none ", f"--bandwidth {0.08 * rate}:1 "])
        words += f"--respond {draw.uniform(700, 9000) / rate:.4g} "
        if draw.random() < 0.5:
            words += f"--longest-tau {draw.uniform(900, 2e6) / rate:.4g} "
        yield words + f"--core {draw.choice(list(COSTS))}"


# A cascade that begins at its least size, and sums whose width limits the cluster sizes.
BORDERS = (
    "--rate 100 --lsb 0.05 --bandwidth none --respond 2 --longest-tau 30 --core cortex-m4f",
    "--rate 1000 --lsb 0.05 --bandwidth 2:1 --respond 28 --core cortex-m4f",
)


@pytest.mark.parametrize("words", [*random_wishes(40), *BORDERS])
def test_window_stride_and_cluster_sizes_follow_the_rules(words):
    plan = plan_of(words)
    design, wishes = plan.design, plan.design.wishes
    window, stride, largest = design.window, design.stride, design.taus[-1]
    # eight results per window; the window and a stride fill the time of response
    assert (design.law, window) == ("fixed", 8 * stride)
    assert stride == int(wishes.respond_s * wishes.rate_hz / 9)
    assert plan.promise.respond_s == pytest.approx((window + stride) / wishes.rate_hz)
    assert plan.promise.respond_s <= wishes.respond_s
    assert plan.promise.arw_percent <= 40
    # octaves up to a ninth of the window and the exact sums; eight, or more after a filter
    assert design.taus == tuple(2**i for i in range(len(design.taus)))
    most = min(window / 9, math.sqrt(2 ** SUM_BITS[wishes.type] / window))
    assert largest <= most
    assert len(design.taus) >= 8 or 2 * largest > most
    assert len(design.taus) <= (8 if not wishes.bandwidth or wishes.bandwidth == "none" else 12)
    # the cascade begins above the window and ends with the first size that is long enough
    wanted = (wishes.longest_tau_s or 0) * wishes.rate_hz
    long_taus = design.long_taus
    assert bool(long_taus) == (wanted > largest)
    if long_taus:
        assert long_taus[0] == max(64, 2 * largest)
        assert long_taus == tuple(long_taus[0] << i for i in range(len(long_taus)))
        assert long_taus[-1] >= wanted * (1 - 1e-6)
        assert len(long_taus) == 1 or long_taus[-2] < wanted
    # the cheaper of the engines: RAM counts twice
    prices = {}
    for engine in ("slide", "grid"):
        other = Design(**(vars(design) | {"engine": engine}))
        cost = costs.cost(other, COSTS[wishes.core])
        prices[engine] = cost.flash_bytes + 2 * cost.ram_bytes
    assert design.engine == min(prices, key=prices.get)
    assert design.fit == ("terms" if long_taus else "arw")


@pytest.mark.parametrize(
    "words, stride, largest",
    (
        ("--rate 100 --false-alarms-per-hour 0.1 --bandwidth none", 60, 32),  # 5 s / 8
        ("--rate 20 --false-alarms-per-hour 0.1 --bandwidth none", 10, 8),
        ("--rate 1000 --false-alarms-per-hour 0.1 --bandwidth 160:1", 100, 32),
        ("--rate 100 --respond 1.1 --arw-percent 8 --bandwidth none", 10, 8),  # 13 is no block
    ),
)
def test_law_glr_has_whole_blocks_and_the_whitening_of_its_filter(words, stride, largest, tmp_path):
    words = f"{words} --lsb 0.05 --core cortex-m4f"
    plan = plan_of(words)
    design, wishes = plan.design, plan.design.wishes
    assert (design.law, design.engine, design.stride) == ("glr", "grid", stride)
    assert design.taus[-1] == largest
    assert design.shortest == max(20, 10 * math.ceil(2 * largest / 10))
    assert design.window % 10 == 0
    assert 160 <= design.window <= 7680
    assert plan.promise.arw_percent <= (wishes.arw_percent or 10)
    write(words, tmp_path)
    config = (tmp_path / "davar_setup.c").read_text().partition("davar_config_t config")[2]
    whiten = re.search(r"\.whiten_first = (\d+)", config)
    cutoff = float(wishes.bandwidth.partition(":")[0]) if ":" in wishes.bandwidth else None
    assert bool(whiten) == bool(cutoff)
    if cutoff:
        pole = math.exp(-2 * math.pi * cutoff / wishes.rate_hz)
        assert int(whiten[1]) / 2**14 == pytest.approx(pole, abs=0.01)


@pytest.mark.parametrize("percent", (5.25, 8, 8.25, 8.5, 14.25))
def test_a_precision_that_no_window_meets_closely_has_a_longer_one(percent):
    """With one more cluster size the interval narrows in a step: the search once found no plan."""
    words = f"--rate 100 --lsb 0.05 --bandwidth none --arw-percent {percent} --core cortex-m4f"
    found = planned(words)
    assert 0.88 * percent < found["arw_percent"] <= percent
    assert found["law"] == "fixed"


# option, wishes that need more of it than a limit of 1 k or 1 %, that limit, its unit
LEAST = (
    ("--ram", EXAMPLE, "1k", 1024),
    ("--flash", EXAMPLE, "2k", 1024),
    ("--ram", "--rate 100 --lsb 0.05 --core cortex-m0", "1k", 1024),
    ("--arw-percent", "--rate 100 --lsb 0.05 --respond 4 --core cortex-m3", "1", 1),
    ("--clock", "--rate 8000 --axes 3 --lsb 0.06 --bandwidth 2000 --core cortex-m0", "1", 1),
)


@pytest.mark.parametrize("option, words, little, unit", LEAST)
def test_the_suggested_value_is_little_more_than_the_least_that_is_possible(
    option, words, little, unit
):
    words = re.sub(r" --(ram|flash) \S+", "", words)
    relaxed = refused_by(f"{words} {option} {little}")["relax"]
    suggested = next(one["value"] for one in relaxed if one["option"] == option)
    high = float(suggested.rstrip("k")) * unit
    assert command(f"{words} {option} {suggested}").status == 0
    low = high / 2
    while high - low > 0.01 * high:
        middle = (low + high) / 2
        value = round(middle) if unit > 1 else f"{middle:.5f}"
        possible = command(f"{words} {option} {value}").status == 0
        low, high = (low, middle) if possible else (middle, high)
    assert float(suggested.rstrip("k")) * unit <= 1.06 * high + 0.05 * unit


def test_the_counts_of_every_sensor_are_those_of_its_range():
    stated = {"lsm6dso": 0.07, "l3gd20h": 0.07, "adis16405": 0.05, "lsm6dsv16x": 0.07}
    stated |= {
        "lsm6dso32": 0.07,
        "adis16470": 0.1,
        "bno085": 0.1119058,
    }  # by the data sheet, in deg/s
    for name, part in sensors.PARTS.items():
        expected = stated.get(name, part["range_dps"] / 32768)
        assert part["lsb_dps"] == pytest.approx(expected, rel=0.002), name


# --- what a setup costs ---

# What tests/target/test_setups.py measured on the emulated boards: renew a row with its figures.
MEASURED = json.loads((ROOT / "tests/tools/measured_setups.json").read_text())


@pytest.mark.parametrize("core, words, figures", MEASURED)
def test_the_costs_are_those_measured_on_the_board(core, words, figures):
    found = planned(f"{words} --core {core}")
    assert found["ram_bytes"] == figures.pop("ram_bytes")
    deepest = max(found[f"{of}_stack_bytes"] for of in ("start", "push", "take"))
    assert found["stack_bytes"] == deepest
    design = plan_of(f"{words} --core {core}").design
    million = design.wishes.rate_hz / 1e6
    assert found["mean_mhz"] == pytest.approx(million * found["mean_instructions"], abs=1e-6)
    assert found["worst_mhz"] == pytest.approx(million * found["worst_push_instructions"], abs=1e-6)
    for name, value in figures.items():
        assert value <= 1.05 * found[name], name
        if not setup_cost.is_bound(design, name):
            assert value >= 0.95 * found[name], name


def of_shapes():
    """Designs of each type, law and engine, with strides and cluster sizes that few wishes need."""
    for type in SUM_BITS:
        wishes = plan_of(f"--type {type} {SCALE[type]} --rate 100 --core rv64gc").design.wishes
        alarms = replace(wishes, false_alarms_per_hour=0.1)
        for stride in (1, 2, 3, 7, 60):
            for taus in ((1,), (1, 2, 4, 8, 16), (1, 3, 5, 6, 7, 20)):
                for engine in ("slide", "grid") if stride > 1 else ("slide",):
                    window = max(9 * taus[-1], 8 * stride)
                    yield Design(wishes, "fixed", engine, "arw", window, window, stride, taus)
        for stride in (10, 50):
            for taus in ((1, 2), (1, 2, 4, 8, 16)):
                yield Design(alarms, "glr", "grid", "arw", 490, 40, stride, taus)


SCALE = {
    "int16": "--lsb 0.05",
    "int32": "--lsb 0.002",
    "float": "--full-scale 500",
}


def allocated(nm, made):
    """The RAM of an object file. What is constant is in flash on a board."""
    symbols = [line.split() for line in printed_by([nm, "-S", made]).splitlines()]
    sizes = {one[3]: int(one[1], 16) for one in symbols if len(one) == 4 and one[2] in "bBdD"}
    return sum(8 * math.ceil(n / 8) for name, n in sizes.items() if name not in ("config", "slow"))


def test_the_memory_of_every_stride_law_and_list_of_sizes_is_what_the_library_needs(
    library, tmp_path
):
    """davar_memory_size_* of the settings in the written files, which davar_init_* requires. The
    macros may count more, which is the same for all of a type and law.
    """
    designs, blocks = list(of_shapes()), []
    for design in designs:
        source = text.files(design, "", [])["davar_setup.c"]
        settings = re.search(
            r"static const uint32_t taus.*?^};\n", source, re.DOTALL | re.MULTILINE
        )
        memory = re.search(r"memory\[DAVAR_SETUP_AXES\]\s+\[([^;]*) / 8U\];", source)
        size = f"davar_memory_size_{text.SUFFIX[design.wishes.type]}(&config)"
        print_both = f'(void)printf("%zu %zu\\n", (size_t)({memory[1]}), {size});'
        blocks.append(f"{{\n{settings[0]}{print_both}\n}}\n")
    program = (
        '#include "davar/davar.h"\n#include "davar/glr.h"\n#include <stdio.h>\n'
        f"int main(void) {{\n{''.join(blocks)}}}\n"
    )
    (tmp_path / "sizes.c").write_text(program)
    assert gcc(tmp_path, "-O0", "sizes.c", library, "-lm", "-o", "sizes") == ""
    lines = printed_by([tmp_path / "sizes"]).splitlines()
    found = [tuple(map(int, line.split())) for line in lines]
    planned_sizes = [programs.memory(8, *design.memory) + design.gap_bytes for design in designs]
    assert len(found) == len(designs) > 90
    more = {}
    for design, (written, needed), planned_size in zip(designs, found, planned_sizes):
        assert written == planned_size, design
        more.setdefault((design.wishes.type, design.law), set()).add(written - needed)
    assert len(more) == 6
    for kind, differences in more.items():
        assert len(differences) == 1, kind
        assert differences <= {0, 8, 16, 24}, kind


STRICT = ("-Os", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
CORES = {
    "rv64gc": ("gcc",),  # whose sizes are those of this machine
    "cortex-m0": ("arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb", "--specs=nano.specs"),
}


@pytest.mark.parametrize("core", CORES)
def test_ram_of_every_stride_law_and_list_of_sizes_is_what_the_compiler_allocates(core, tmp_path):
    """With the sizes of the types, for the pointers of the core."""
    compiler, *options = CORES[core]
    if not shutil.which(compiler):
        pytest.skip(f"no {compiler}")
    for design in list(of_shapes())[::7]:
        for name, content in text.files(design, "", []).items():
            (tmp_path / name).write_text(content)
        made = ("@davar_setup.args", *STRICT, "-c", "davar_setup.c", "-o", "setup.o")
        assert gcc(tmp_path, *options, *made, compiler=compiler) == ""
        of_type = COSTS[core]["sizes"]
        nm = compiler.replace("gcc", "nm")
        assert costs.ram_bytes(design, of_type, 0) == allocated(nm, tmp_path / "setup.o"), design
