"""tools/davar-plan from wishes: what it prints and writes, what would make a plan possible. Bad
input is one line.
"""

import math
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from planner import BadOption, choice, costs, plan, programs, report, sensors, wishes
from planner_case import (
    EXAMPLE,
    ROOT,
    USUAL,
    command,
    command_line,
    plan_of,
    planned,
    refused,
    run,
    smallest,
)
from recorded import assert_recorded, cases
from scipy import signal

PLANS = Path(__file__).with_name("recorded_plans.txt")
SLOW_CORE = "--rate 8000 --axes 3 --lsb 0.06 --bandwidth 2000 --core cortex-m0"


@pytest.mark.parametrize("words", cases(PLANS))
def test_report_figures_and_files_are_as_recorded(words):
    done, data = command(words), command(f"{words} --json").out
    written = done.status == 0 and words != "--help"
    files = command_line.files(plan_of(words), "davar-plan") if written else {}
    rounded = re.sub(r"\d+\.\d{7,}", lambda one: f"{float(one[0]):.6g}", data)
    assert_recorded(PLANS, words, str(done.status), done.out, done.err, rounded, *files.values())


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


@pytest.mark.parametrize("more", ("", " --respond 2 --axes 3", " --arw-percent 5"))
def test_an_engine_that_is_stated_is_taken(more):
    words = f"--rate 1000 --lsb 0.05 --bandwidth none --core cortex-m4f{more}"
    slide, grid = (planned(f"{words} --engine {engine}") for engine in ("slide", "grid"))
    assert [one["engine"] for one in (slide, grid)] == ["slide", "grid"]
    assert slide["worst_push_instructions"] < grid["worst_push_instructions"]
    assert slide["mean_instructions"] < grid["mean_instructions"]
    assert slide["ram_bytes"] > grid["ram_bytes"]
    assert planned(words)["engine"] in ("slide", "grid")


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
    "--rate 8000 --lsb 0.061 --bandwidth 100:2 --motion flight --core cortex-m4f",
    "--rate 1000 --axes 3 --lsb 0.061 --bandwidth 250:2:5 --motion flight --flash 15k "
    "--core cortex-m4f",
    pytest.param(SLOW_ALARM, marks=pytest.mark.slow),
)


@pytest.mark.parametrize("noise", ("", " --noise 6"))
def test_behind_a_filter_too_long_for_the_rate_it_states_the_sum_that_is_possible(noise):
    words = f"--rate 8000 --lsb 0.05 --bandwidth biquad:30 --core cortex-m4f{noise}"
    found = refused(words)
    assert found["impossible"].startswith("--bandwidth biquad:30: ARW is present in too few")
    (hint,) = found["hints"]
    rate, count, filter = re.search(r"--rate (\S+) --lsb (\S+) --bandwidth (\S+)", hint).groups()
    typed = words.replace("8000", rate).replace("0.05", count).replace("biquad:30", filter)
    assert command(typed).status == 0


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


# --- bad input ---

PLAIN = "--rate 100 --lsb 0.05 --core cortex-m0"
# Words, and the option that is named.
BAD = [
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
    *((f"--sensor {part} --core cortex-m0", "--sensor")
      for part in ("nothing@100", "icm42688", "icm42688@1", "icm42688@x")),
    (f"{PLAIN} words", "words"),
    (f"{PLAIN} --type float --full-scale 500", "--lsb"),
    (f"{PLAIN} --bandwidth --taus", "--bandwidth"),
]  # fmt: skip
# Values of an option, which is named.
BAD_VALUES = {
    "--rate": "50",
    "--axes": "0 17 1.5 -1",
    "--ram": "1g 0 -5k k 0.9",
    "--bandwidth": "20:3 9000 auto . - 1.2.3 20:2:60",
    "--respond": "0 nan inf 1s 1.2.3 .",
    "--false-alarms-per-hour": "1e10 1e-11",
    "--arw-percent": "90 0.09 50.1",
    "--longest-tau": "0.001 0.009",
    "--type": "int8",
    "--clock": "0 48MHz",
    "--unknown": "1",
    "--name": "a",
    "--taus": "1,2",
    "--rail": "9",
    "--motion": "fast flight",
    "--full-scale": "500",
    "--engine": "auto slide",
}
PLAIN_OF = {"--engine": f"{PLAIN} --false-alarms-per-hour 1"}
BAD += [
    (f"{PLAIN_OF.get(option, PLAIN)} {option} {one}", option)
    for option, of in BAD_VALUES.items()
    for one in of.split()
]
BAD += [(f"{PLAIN} {word}", word.partition("=")[0]) for word in ("--json=1", "--taus=1,2", "--ram")]


@pytest.mark.parametrize("words, option", BAD)
def test_a_bad_option_is_one_line_and_nothing_is_written(words, option, tmp_path):
    done = run([*words.split(), "-o", str(tmp_path / "none")])
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


def test_the_report_of_the_readme_is_what_the_command_prints():
    """In a process of its own: the command passes on the output and the status."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    words = re.search(r"^tools/davar-plan (.*) -o \S+$", page, re.MULTILINE)[1].split()
    shown = re.search(r"```text\n(.*?)```", page, re.DOTALL)[1].splitlines()
    program = ROOT / "tools/davar-plan"
    done = subprocess.run([program, *words], text=True, capture_output=True, check=True)
    assert done.stdout.splitlines()[:-1] == shown[:-1]
    assert shown[-1][:9] == "  wrote  "
    for bad, status in ((["--taus", "0"], 2), (["--floor"], 2), ([*words, "--ram", "1k"], 1)):
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


def test_an_unknown_option_names_the_one_that_is_near():
    done = run([*PLAIN.split(), "--false-alarms", "0.1"])
    assert (done.status, done.out) == (2, "")
    assert "--false-alarms: unknown option; do you mean --false-alarms-per-hour?" in done.err


@pytest.mark.parametrize(
    "typed, sensor, core",
    [
        ("--sensor ICM-42688-P@1000 --core cortex-m4", "icm42688@1000", "cortex-m4f"),
        ("--sensor icm_20602@500 --core Cortex-M0+", "icm20602@500", "cortex-m0"),
        ("--sensor BMI088@400 --core cortex-m0plus", "bmi088@400", "cortex-m0"),
        ("--sensor mpu9250@200 --core CORTEX_M33", "mpu9250@200", "cortex-m33"),
    ],
)
def test_names_are_known_as_makers_and_compilers_write_them(typed, sensor, core):
    wishes = plan_of(typed).design.wishes
    assert (wishes.sensor, wishes.core) == (sensor, core)


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


@pytest.mark.parametrize(
    "after, division", (("", 1), (":10", 1), (":10+sum:8", 8), (":5+cic2:4", 4))
)
@pytest.mark.parametrize("order, share", ((1, 0.25), (1, 0.5), (2, 0.5), (2, 1.2)))
def test_aliased_noise_is_stated(order, share, after, division):
    """Of white noise after a low-pass at 64 times the rate, of which every 64th sample is kept."""
    response = signal.butter(order, share * 2 / 64, output="sos")
    frequencies = np.arange(1, 64) / 64
    _, gain = signal.sosfreqz(response, 2 * np.pi * frequencies)
    more = 100 * (np.sqrt(1 + np.sum(np.abs(gain) ** 2)) - 1)
    filter = f"{100 * division * share:g}:{order}{after}"
    words = f"--rate 100 --lsb 0.05 --bandwidth {filter} --core cortex-m4f"
    (said,) = [line for line in planned(words)["remarks"] if "aliased" in line]
    assert float(re.search(r"is ([\d.]+) %", said)[1]) == pytest.approx(more, rel=0.05)
