"""tools/davar-plan from wishes: what it remarks, why a plan is impossible and what would help, and
bad input is one line.
"""

import json
import math
import re
import subprocess
from dataclasses import replace

import pytest
from planner import BadOption, choice, costs, plan, programs, report, sensors, wishes
from planner_case import (
    EXAMPLE,
    ROOT,
    USUAL,
    WISHES,
    command,
    plan_of,
    planned,
    refused,
    run,
    smallest,
)

SLOW_CORE = "--rate 8000 --axes 3 --lsb 0.06 --bandwidth 2000 --core cortex-m0"


# --- remarks: wishes with another effect than expected ---


@pytest.mark.parametrize("type, rate, most", (("int16", 1000, 65536), ("int32", 100, 2**24)))
def test_a_longer_response_than_any_window_gives_the_longest_window(type, rate, most):
    words = f"--rate {rate} --type {type} --lsb 0.06 --bandwidth none --respond 1e6"
    found = planned(f"{words} --core cortex-m4f")
    assert found["law"] == "fixed"
    assert most - 8 <= found["window_s"] * rate <= most
    assert f"the longest window of {type} has {most} samples" in found["remarks"][0]
    assert len(found["remarks"]) == 1


def test_a_response_whose_window_does_not_fit_gets_a_shorter_one():
    words = "--rate 1000 --lsb 0.06 --bandwidth 250 --respond 120 --core cortex-m4f --ram 4k"
    found = planned(words)
    assert found["law"] == "fixed"
    assert found["arw_percent"] <= 10
    assert "a longer window exceeds --ram or --flash" in found["remarks"][0]


SMALL = "--rate 1000 --lsb 0.061 --bandwidth 250 --respond 0.8 --axes 2 --longest-tau 50"


@pytest.mark.parametrize(
    "stated, limits",
    (
        (EXAMPLE.split(" --ram")[0], "--flash 24k"),
        (EXAMPLE.split(" --ram")[0], "--ram 14k --flash 24k"),
        (SMALL, "--ram 9k"),
    ),
)
def test_a_fit_that_the_limits_exclude_names_the_limits_that_it_needs(stated, limits):
    def not_fitted(found):
        return [one for one in found["remarks"] if "random walk are not fitted" in one]

    given = dict(re.findall(r"(--\w+) (\S+)", limits))
    found = planned(f"{stated} --core cortex-m4f {limits}")
    assert found["fit"] == "curve"
    (remark,) = not_fitted(found)
    needed = given | dict(re.findall(r"(--\w+) (\d\S+)", remark))
    again = " ".join(f"{option} {value}" for option, value in needed.items())
    found = planned(f"{stated} --core cortex-m4f {again}")
    assert (found["fit"], not_fitted(found)) == ("terms", [])


def test_an_averaging_time_of_the_window_adds_no_curve():
    words = "--rate 100 --lsb 0.05 --bandwidth none --core cortex-m0 --longest-tau 0.1"
    found = planned(words)
    assert "--longest-tau 0.1 adds nothing" in found["remarks"][0]
    assert max(found["taus_s"]) >= 0.1
    assert found["curve_instructions"] is None


def test_a_core_that_is_too_slow_for_single_samples_gets_the_size_of_a_block():
    free = planned(SLOW_CORE)
    assert "not every chip has" in free["remarks"][0]
    assert f" {free['worst_mhz']:.3g} MHz" in command(SLOW_CORE).out
    for clock in (1.1 * free["mean_mhz"], 0.95 * free["worst_mhz"]):
        found = planned(f"{SLOW_CORE} --clock {clock}")
        (remark,) = found["remarks"]
        block = int(re.search(r"at least (\d+) samples", remark)[1])
        mean, worst = found["mean_instructions"], found["worst_push_instructions"]
        budget = clock * 1e6 / 8000
        keeps_up = [worst + (n - 1) * mean < n * budget for n in (block - 1, block)]
        assert keeps_up == [False, True]
    text = command(f"{SLOW_CORE} --clock {1.1 * free['mean_mhz']}").out
    assert "pushes take 90.9 % of" in text
    assert planned(f"{SLOW_CORE} --clock {1.01 * free['worst_mhz']}")["remarks"] == []


def test_undeclared_filters_those_to_set_and_coarse_counts_are_remarks():
    words = "--rate 100 --lsb 0.05 --core cortex-m0"
    assert "low-pass is not declared" in planned(words)["remarks"][0]
    assert planned(f"{words} --bandwidth none")["remarks"] == []
    words = "--sensor icm42688@1000 --core cortex-m4f"
    assert "set the gyro to the low-pass of this plan" in planned(words)["remarks"][0]
    for filter in ("none", "cic2:64"):
        assert planned(f"{words} --bandwidth {filter}")["remarks"] == []
    words = "--rate 100 --lsb 0.5 --bandwidth none --core cortex-m0 --arw-percent 12 --noise"
    counts = 2.4 / 60 * math.sqrt(100) / 0.5
    assert f"{counts:g} counts before the filter" in planned(f"{words} 2.4")["remarks"][0]
    assert planned(f"{words} 3.1")["remarks"] == []


# --- impossible wishes ---

SLOW_ALARM = (
    "--sensor bmi160@200 --respond 0.5 --arw-percent 20 --false-alarms-per-hour 0.003 "
    "--flash 20k --core cortex-m0"
)
IMPOSSIBLE = (
    EXAMPLE.replace("20k", "12k"),
    EXAMPLE.replace("24k", "16k"),
    EXAMPLE.replace("20k", "4k").replace("24k", "8k"),
    "--rate 100 --lsb 0.05 --bandwidth 33 --respond 0.01 --core cortex-m0",
    "--rate 100 --lsb 0.05 --bandwidth 33 --respond 3 --arw-percent 2 --ram 6k --core cortex-m0",
    "--rate 1000 --lsb 0.05 --bandwidth 250 --longest-tau 1e9 --core cortex-m0",
    "--rate 32000 --lsb 0.06 --respond 10 --longest-tau 1e6 --core cortex-m4f",
    "--rate 1000 --lsb 0.06 --arw-percent 0.1 --core cortex-m4f",
    "--rate 1000 --lsb 0.06 --arw-percent 0.5 --bandwidth none --core cortex-m4f",
    "--rate 100 --lsb 0.06 --respond 20 --arw-percent 1 --bandwidth none --core cortex-m4f",
    EXAMPLE.replace("20k", "1k").replace("24k", "4k"),
    "--rate 100 --lsb 0.05 --bandwidth 33 --arw-percent 0.5 --core cortex-m4f",
    "--sensor mpu6050@800 --arw-percent 0.5 --ram 3k --flash 18k --core cortex-m3",
    f"{SLOW_CORE} --clock 1.5",
    f"{SLOW_CORE} --clock 6",
    "--rate 1000 --lsb 0.06 --bandwidth 250 --respond 120 --ram 2k --core cortex-m4f",
    pytest.param(SLOW_ALARM, marks=pytest.mark.slow),
)
GLR = (
    "--rate 200 --lsb 0.06 --bandwidth none --false-alarms-per-hour 1 --core cortex-m4f "
    "--arw-percent 0.5"
)


@pytest.mark.parametrize("words", IMPOSSIBLE)
def test_the_reason_has_numbers_and_what_it_suggests_is_possible(words, tmp_path):
    done = run([*words.split(), "-o", str(tmp_path / "none")])
    assert (done.status, done.out) == (1, "")
    assert re.match(r"davar-plan: impossible: .*[0-9]", done.err)
    assert not (tmp_path / "none").exists()
    found = refused(words)
    relaxed = {one["option"]: one["value"] for one in found["relax"]}
    assert relaxed
    for option, value in relaxed.items():
        assert f"  {option} {value}\n" in done.err
    given = dict(zip(words.split()[::2], words.split()[1::2]))
    ways = [relaxed] if found["together"] else [{o: v} for o, v in relaxed.items()]
    for way in ways:
        again = command(" ".join(word for pair in (given | way).items() for word in pair))
        assert (again.status, again.err) == (0, ""), way


@pytest.mark.parametrize(
    "words, options, reason",
    (
        (IMPOSSIBLE[1], ["--flash"], "flash 16k: 3 axes, a response within 2 s and averaging"),
        (IMPOSSIBLE[6], ["--longest-tau"], "1000000: 3.2e+10 samples at 32000 Hz"),
        (IMPOSSIBLE[7], ["--arw-percent"], "ARW to 0.1 %: the longest window gives"),
        (IMPOSSIBLE[8], ["--arw-percent"], "ARW to 0.5 %: the longest window gives"),
        (IMPOSSIBLE[10], ["--ram", "--flash"], "RAM 1k: 3 axes"),
        (GLR, ["--arw-percent"], "ARW to 0.5 %: the longest window of law glr gives"),
    ),
)
def test_the_reason_is_the_option_that_is_out_of_reach(words, options, reason):
    found = refused(words)
    assert reason in found["impossible"]
    assert [one["option"] for one in found["relax"]] == options
    assert found["together"] == (len(options) > 1)


def test_a_hint_is_not_a_reason():
    done = command(IMPOSSIBLE[7])
    assert "\n  and " not in done.err
    assert "--bandwidth" in refused(IMPOSSIBLE[7])["hints"][0]
    assert refused(IMPOSSIBLE[8])["hints"] == []
    assert refused(IMPOSSIBLE[1])["hints"] == ["it is possible without --longest-tau"]
    assert "  and flash 4k: " in command(IMPOSSIBLE[10]).err
    assert "possible with all of:\n" in command(IMPOSSIBLE[10]).err


def test_a_core_that_cannot_keep_up_is_refused_with_both_figures():
    words = f"{SLOW_CORE} --clock 6"
    reason = refused(words)["impossible"]
    clock, needed = map(float, re.search(r"clock (\S+) MHz: \D+(\S+) million", reason).groups())
    assert clock == 6
    assert clock < needed <= 1.005 * 8000 * planned(SLOW_CORE)["mean_instructions"] / 1e6
    assert "davar/average.h" in command(words).err


def test_no_plan_fills_the_clock_with_pushes():
    read = plan_of("--rate 1000 --lsb 0.06 --bandwidth 250 --core cortex-m4f")
    other = choice.plan(replace(read.design.wishes, clock_mhz=read.mean_mhz))
    assert other.mean_mhz < read.mean_mhz
    assert report.remarks(other)


def test_a_limit_just_below_the_need_is_shown_with_digits_that_differ():
    words = "--rate 1000 --lsb 0.06 --bandwidth 250 --core cortex-m4f"
    precise = f"{words} --arw-percent 9.4"
    best = float(
        re.search(r"gives (\S+) %", refused(f"{words} --arw-percent 0.5")["impossible"])[1]
    )
    for more in (
        f"--arw-percent {0.9999 * best}",
        f"--arw-percent 9.4 --ram {smallest(precise, '--ram', 'ram_bytes') - 1}",
        f"--arw-percent 9.4 --flash {smallest(precise, '--flash', 'flash_bytes') - 1}",
    ):
        wish, *_, need = map(
            float, re.findall(r"[0-9.]+", refused(f"{words} {more}")["impossible"])
        )
        assert wish < need


def test_noise_that_rounding_hides_has_no_plan():
    done = command("--rate 100 --lsb 3 --noise 1 --core cortex-m0")
    assert done.status == 1
    assert "before the filter, and rounding hides it" in done.err
    assert "a smaller range of the gyro" in done.err


def test_numbers_are_shown_so_that_they_suffice_and_differ():
    for size, text in ((1, "0.1k"), (20480, "20k"), (20481, "20.1k"), (20582, "20.1k")):
        assert choice.kilobytes(size) == text
    assert choice.kilobytes(20583) == "20.2k"
    for function, one, other, texts in (
        (choice.sizes_apart, 20480, 20481, ("20k", "20.1k")),
        (choice.sizes_apart, 20481, 20482, ("20481 bytes", "20482 bytes")),
        (choice.apart, 1.8, 1.80002, ("1.8", "1.80002")),
        (choice.apart, 1e6, 2e6, ("1000000", "2000000")),
    ):
        assert function(one, other) == texts
    for option, unit in (("--rate", "Hz"), ("--respond", "seconds"), ("--clock", "MHz")):
        done = command(f"{option} 1x --lsb 0.05 --core cortex-m0")
        assert f"{option}: expected a number of {unit} above 0, found '1x'" in done.err


# --- bad input ---

BAD = (
    ("", "--rate"),
    ("--rate 100", "--core"),
    ("--rate 100 --core cortex-m0", "--lsb"),
    ("--lsb 0.1 --core cortex-m0", "--rate"),
    ("--rate 100 --lsb 0.05 --core z80", "--core"),
    ("--rate 100 --lsb 0.05 --core", "--core"),
    ("--rate 100 --lsb 0.05 --type float --core cortex-m0", "--full-scale"),
    ("--rate 1.2.3 --lsb 0.05 --core cortex-m0", "--rate"),
    ("--sensor icm42688@1000 --rate 500 --core cortex-m0", "--rate"),
    ("--sensor icm42688@1000 --core cortex-m0 --type float --full-scale 9 --lsb 1", "--lsb"),
    ("--sensor nothing@100 --core cortex-m0", "--sensor"),
    ("--sensor icm42688 --core cortex-m0", "--sensor"),
    ("--sensor icm42688@1 --core cortex-m0", "--sensor"),
)
BAD_MORE = (
    "rate 50,axes 0,axes 17,axes 1.5,axes -1,ram,ram 1g,ram 0,ram -5k,flash k,bandwidth 20:3,"
    "bandwidth 9000,bandwidth auto,bandwidth .,bandwidth -,bandwidth 1.2.3,bandwidth 20:2:60,"
    "respond 0,respond nan,respond inf,respond 1s,respond 1.2.3,respond .,"
    "false-alarms-per-hour 1e10,false-alarms-per-hour 1e-11,arw-percent 90,"
    "arw-percent 0.09,arw-percent 50.1,longest-tau 0.001,type int8,sensor nothing@100,"
    "sensor icm42688,sensor icm42688@1,unknown 1,json=1,full-scale 500,"
    "type int32 --full-scale 500,clock 0,clock 48MHz,name a,taus 1;2,taus=1;2,bandwidth --taus"
)

OPTION_NAMED = {"bandwidth --taus": "--bandwidth"} | dict.fromkeys(
    ("sensor nothing@100", "sensor icm42688", "sensor icm42688@1"), "--rate"
)


@pytest.mark.parametrize(
    "words, option",
    [
        *BAD,
        ("--rate 100 --lsb 0.05 --core cortex-m0 words", "words"),
        ("--rate 100 --lsb 0.05 --core cortex-m0 --type float --full-scale 500", "--lsb"),
        *(
            (f"--rate 100 --lsb 0.05 --core cortex-m0 --{more}", OPTION_NAMED.get(more, ""))
            for more in re.split(",", BAD_MORE)
        ),
    ],
)
def test_a_bad_option_is_one_line_and_nothing_is_written(words, option, tmp_path):
    option = option or re.findall(r"--[a-z-]+", words)[-1].replace("--taus=1", "--taus")
    done = run([*words.replace(";", ",").split(), "-o", str(tmp_path / "none")])
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1), done.err
    assert done.err.startswith(f"davar-plan: {option}: "), done.err
    assert "could not convert" not in done.err
    assert not (tmp_path / "none").exists()


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path):
    for words in (["-o", ""], ["-o="]):
        done = run([*USUAL.split(), *words])
        assert done == (2, "", "davar-plan: -o: expected a folder, found ''\n")
    (tmp_path / "file").write_text("")
    done = run([*USUAL.split(), "-o", str(tmp_path / "file")])
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert "-o" in done.err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


# --- help, pages, sensors ---


def test_help_names_every_option_core_and_sensor():
    done = command("--help")
    assert (done.status, done.err) == (0, "")
    options = [*wishes._readers(()), "-o", "--json"]
    for word in (*options, *costs.cores(), *sensors.PARTS):
        assert word in done.out


def test_help_and_page_state_how_a_noise_density_becomes_the_option_noise():
    factor = 60 / 2**0.5  # one-sided density S: the variance of the angle after t is S^2 t / 2
    for text in (command("--help").out, (ROOT / "docs/PLANNER.md").read_text()):
        assert f"N = 60 D / sqrt(2) = {factor:.1f} D" in text
    part = sensors.PARTS["icm42688"]
    found = sensors.look_up("icm42688", 1000.0)
    assert found["noise"] == pytest.approx(factor * part["noise_dps_per_root_hz"])


def test_the_report_of_the_readme_is_what_the_command_prints():
    """In a process of its own: the command passes on the output and the status."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    words = re.search(r"^tools/davar-plan (.*) -o \S+$", page, re.MULTILINE)[1].split()
    shown = re.search(r"```text\n(.*?)```", page, re.DOTALL)[1].splitlines()
    program = ROOT / "tools/davar-plan"
    done = subprocess.run([program, *words], text=True, capture_output=True, check=True)
    assert done.stdout.splitlines()[:-1] == shown[:-1]
    assert shown[-1][:9] == "  wrote  "
    for bad, status in ((["--taus", "0"], 2), ([*words, "--ram", "1k"], 1)):
        done = subprocess.run([program, *bad], text=True, capture_output=True, check=False)
        assert (done.returncode, done.stdout) == (status, "")


def test_one_function_gives_the_plan():
    found = plan(rate_hz=100.0, core="cortex-m0", lsb=0.05, bandwidth="33:2")
    assert found == planned(USUAL)
    with pytest.raises(BadOption, match="--lsb"):
        plan(rate_hz=100.0, core="cortex-m0")
    with pytest.raises(BadOption, match="--bandwidth: expected"):
        plan(rate_hz=100.0, core="cortex-m0", lsb=0.05, bandwidth="1.2.3")


def test_a_number_and_a_name_have_all_their_forms():
    first, *others = (
        planned(f"--rate 1000 --core cortex-m0 --lsb 0.05 --bandwidth {hz}")
        for hz in ("200:2", "2E2:2", "200.:2", "2e+2")
    )
    assert others == [first] * 3
    words = "--core cortex-m4f --type float --full-scale 2000 --sensor"
    assert command(f"{words} icm42688@1000") == command(f"{words} ICM42688@1000")


@pytest.mark.parametrize("name, part", sensors.PARTS.items())
def test_every_part_has_a_plan_at_its_rates(name, part):
    for rate in part.get("bandwidth_at_rate", {part["rate_most_hz"]: 0}):
        done = command(f"--sensor {name}@{rate} --core cortex-m4f")
        assert done.status in (0, 1), done.err


def test_the_table_of_the_pages_is_that_of_the_planner():
    page = (ROOT / "docs/FIRMWARE.md").read_text(encoding="utf-8")
    for row in sensors.ROWS:
        assert f"| {row['gyro']} | {row['declare']} | {row['where']} |" in page
    rows = page.count("\n", *re.search(r"\| gyro \| declare \|.*?\n\n", page, re.DOTALL).span())
    assert len(sensors.ROWS) == rows - 3


@pytest.mark.parametrize("words", WISHES)
def test_the_printed_report_states_the_figures_of_the_json(words):
    found, text = planned(words), command(words).out
    assert (
        f"ARW to +-{choice.number(found['arw_percent'])} % (95 %)" in text or found["law"] == "glr"
    )
    assert f"flash {found['flash_bytes']} " in text
    assert f"RAM {found['ram_bytes']} " in text
    stack = [f"{of} {found[f'{of}_stack_bytes']}" for of in ("start", "push", "take")]
    assert f"stack {found['stack_bytes']} bytes: {', '.join(stack)}" in text
    pushes = found["mean_instructions"], found["worst_push_instructions"]
    assert "{} instructions, at most about {};".format(*pushes) in text
    assert "a folder with -o" in text
    if found["fit"] == "terms":  # where bias instability equals white noise: (1.2)
        noise = plan_of(words).design.wishes.noise
        edge = noise and noise / (0.664 * math.sqrt(max(found["taus_s"]) / 3600))
        assert found["bias_instability_deg_per_h"] == pytest.approx(edge)
        assert ("bias instability and random walk from that curve" in text) == bool(edge)
    alarms = {None: "", 0.01: "one false alarm in 4.17 days", 1.0: "one false alarm in 60 min"}
    assert alarms[found["false_alarms_per_hour"]] in text
    for remark in found["remarks"]:
        assert remark in text
    assert json.loads(json.dumps(found)) == found


@pytest.mark.parametrize(
    "text, size", (("1", 1), ("1.9", 1), ("1k", 1024), ("1.5K", 1536), ("0", None), ("0.9", None))
)
def test_a_limit_is_a_number_of_bytes(text, size):
    words = f"{USUAL} --ram {text}".split()
    if size is None:
        said = "davar-plan: --ram: expected a number of bytes, such as 20480 or 20k, found"
        assert run(words) == (2, "", f"{said} '{text}'\n")
    else:
        assert wishes.read(words, costs.cores()).wishes.ram_bytes == size


@pytest.mark.parametrize("text", ("none", "250", "50:2", "20:1", "cic2:64"))
def test_at_least_four_sizes_are_longer_than_the_filter_passes_on(text):
    words = f"--rate 1000 --lsb 0.06 --bandwidth {text} --core cortex-m4f"
    passed = programs.passed_samples(text, 1000)
    first = 2 ** math.ceil(math.log2(2 * passed)) if text != "none" else 1
    sizes = [round(1000 * tau) for tau in planned(words)["taus_s"]]
    assert sizes == [2**i for i in range(max(8, round(math.log2(first)) + 3))]


@pytest.mark.parametrize("words", (IMPOSSIBLE[0], IMPOSSIBLE[3], SLOW_CORE + " --clock 1.5"))
def test_what_it_suggests_to_relax_is_the_nearest_that_helps(words):
    """One axis more, or less than half of that response, is impossible."""
    given = dict(zip(words.split()[::2], words.split()[1::2]))
    for one in refused(words)["relax"]:
        if one["option"] == "--axes":
            nearer = {"--axes": str(int(one["value"]) + 1)}
        elif one["option"] == "--respond":
            nearer = {"--respond": str(float(one["value"]) * 0.49)}
        else:
            continue
        again = " ".join(word for pair in (given | nearer).items() for word in pair)
        assert command(again).status == 1, one
