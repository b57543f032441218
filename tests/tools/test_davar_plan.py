"""davar-plan: its plan equals that of davar_plan_init and gives the same results, and that of a
floor equals that of davar_floor_plan.
"""

import re
import subprocess

import pytest
from planner_case import ROOT, built, gcc, printed_by
from planner_case import programs as planner_programs

LISTS = (
    "1",
    "7",
    "1,2,4,8",
    "1,2,4,8,16,32,64",
    "1,2,3,5,9,15,24,40",
    ",".join(str(3 + 2 * i) for i in range(32)),
)
OCTAVES = LISTS[3]
# Cluster sizes, the options of a filter, and the calls of the library for the same filter.
PLANS = [
    *((taus, "", None) for taus in LISTS),
    (OCTAVES, "--bandwidth none", ""),
    (OCTAVES, "--bandwidth 40 --rate 1000", "low_pass(&f, 40.0 / 1000.0, 2, 0.01 * 10.0)"),
    (OCTAVES, "--bandwidth 50:1:5 --rate 200", "low_pass(&f, 0.25, 1, 0.01 * 5.0)"),
    (OCTAVES, "--bandwidth biquad:20 --rate 200", "biquad(&f, 0.1)"),
    (
        OCTAVES,
        "--bandwidth pt1:20+notch:30:3.5+biquad:60 --rate 200",
        "pt1(&f, 0.1); davar_filter_notch(&f, 0.15, 3.5); davar_filter_biquad(&f, 0.3)",
    ),
    (OCTAVES, "--bandwidth cic:8", "cic(&f, 1, 8)"),
    (
        OCTAVES,
        "--bandwidth 250+sum:8 --rate 1000",
        "low_pass(&f, 250.0 / 8000.0, 2, 0.01 * 10.0); davar_filter_sum(&f, 8)",
    ),
    (OCTAVES, "--bandwidth average2:4", "average(&f, 2, 4)"),
    (OCTAVES, "--bandwidth cic3:64", "cic(&f, 3, 64)"),
    (
        OCTAVES,
        "--bandwidth ba:0.2,1e-1:-0.5,+0.25:2",
        "ba(&f, (double[]){0.2, 0.1}, 2, (double[]){1.0, -0.5, 0.25}, 3); f.level = 0.01 * 2.0",
    ),
]

# Options of the plan of a floor, its filter as calls of the library, block and usable frequencies.
FLOORS = [
    ("--rate 1000 --lsb 0.061 --bandwidth none", "", 256, 31),
    ("--rate 799.9 --lsb 1e-4 --rail 8388607 --bandwidth none", "", 128, 31),
    (
        "--rate 1000 --lsb 0.007625 --rail 262136 --bandwidth 258:2:5+sum:8",
        "low_pass(&f, 258.0 / 8000.0, 2, 0.01 * 5.0); davar_filter_sum(&f, 8)",
        256,
        25,
    ),
    (
        "--rate 1000 --lsb 0.061 --bandwidth 250",
        "low_pass(&f, 0.25, 2, 0.01 * 10.0)",
        256,
        21,
    ),
    ("--rate 500 --lsb 0.061 --bandwidth biquad:200", "biquad(&f, 0.4)", 128, 29),
    ("--rate 500 --lsb 0.061 --bandwidth biquad:40", "biquad(&f, 0.08)", 128, 13),
    ("--rate 2000 --lsb 0.061 --bandwidth average:4", "average(&f, 1, 4)", 256, 26),
]


def plan(*words):
    built()
    return subprocess.run(
        [planner_programs.PROGRAM, *words], text=True, capture_output=True, check=False
    )


def compiled(folder, library, taus, options, *more):
    done = plan("--taus", taus, "--name", "ready", *options.split())
    assert (done.returncode, done.stderr) == (0, "")
    (folder / "plan.c").write_text(done.stdout)
    strict = ("-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-ffp-contract=off")
    program = ROOT / "tests/tools/ready_plan.c"
    assert gcc(folder, *strict, *more, program, "plan.c", library, "-lm", "-o", "run") == ""
    return folder / "run"


@pytest.mark.slow
@pytest.mark.parametrize("taus, options, filter", PLANS)
def test_it_equals_the_plan_of_the_library_and_gives_the_same_results(
    taus, options, filter, library, tmp_path
):
    make = "davar_plan_init(&made, taus, COUNT)"
    if filter is not None:
        calls = f"davar_filter_{filter};" if filter else ""
        make = (
            f"{{ davar_filter_t f = {{0}}; {calls} "
            "davar_plan_init_filtered(&made, taus, COUNT, &f); }"
        )
    program = compiled(tmp_path, library, taus, options, f"-DTAUS={taus}", f"-DMAKE={make}")
    same, white = printed_by([program]).split()
    assert same == "1960"
    assert filter is not None or white == "some"


@pytest.mark.parametrize("options, filter, block, usable", FLOORS)
def test_the_plan_of_a_floor_equals_that_of_the_library(
    options, filter, block, usable, library, tmp_path
):
    done = plan("--floor", *options.split(), "--name", "ready")
    note = f"leaves {usable} usable frequencies of 31, and a value needs 23\n"
    assert (done.returncode, done.stderr.endswith(note)) == (0, usable < 23)
    assert usable < 23 or done.stderr == ""
    (tmp_path / "plan.c").write_text(done.stdout)
    given = dict(zip(options.split()[::2], options.split()[1::2]))
    defined = {
        "FILTER": f"davar_filter_{filter}" if filter else "",
        "RATE": given["--rate"],
        "LSB": given["--lsb"],
        "RAIL": given.get("--rail", 32767),
        "BLOCK": block,
    }
    strict = ("-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-ffp-contract=off")
    program = ROOT / "tests/tools/ready_floor.c"
    options = [f"-D{name}={value}" for name, value in defined.items()]
    files = (program, "plan.c", library)
    assert gcc(tmp_path, *strict, *options, *files, "-lm", "-o", "run") == ""
    assert printed_by([tmp_path / "run"]) == f"{usable}\n"


def test_a_filter_prints_the_detector_s_whitening():
    words = ("--taus", "1,2", "--rate", "100")
    assert "whiten" not in plan(*words).stdout
    # one pole: the only coefficient is exp(-2 pi 0.05), but for the rounding that it allows for
    printed = plan(*words, "--bandwidth", "5:1").stdout
    found = re.search(
        r"whiten_first = (\d+), .whiten_second = (\d+),\n \* .whiten_level = ([\d.]+)", printed
    )
    assert int(found[1]) / 2**14 == pytest.approx(0.7304, abs=0.005)
    assert int(found[2]) / 2**14 == pytest.approx(0, abs=0.005)
    assert float(found[3]) == pytest.approx(3.709, abs=0.005)


def test_sizes_of_a_cascade_are_solved_for_the_window_alone():
    done = plan("--taus", "1,2,4,8", "--long", "64,128", "--name", "a").stdout
    assert re.search(r"\.count = (\d+),\n\s+\.sizes = (\d+),", done).groups() == ("4", "6")


FILTERS = (
    " 20:3 20:0 20:2:60 -5 nan 0.1 900 20: 20+ 20+30 average average:0 average9:2 averages:2 "
    "average:1025 average2:513 cic0:4 cic9:4 cic3 cic3:4+20 sum3:4 sum:0 sum:4+cic:4 none+20 auto "
    "biquad:50 biquad pt1:0 pt1:401 notch:20 notch:50:3 notch:20:0.05 notch:20:200 biquad:20:51 "
    "ba: ba:1,-1 ba:1:-1.1 ba:1:0.5:60 ba:1,:0.5 ba:nan ba:1:-0.9999 sum:4+biquad:20 "
    "biquad:5+biquad:6+biquad:7+biquad:8+pt1:9"
)
BAD_TAUS = ("", "0,1", "2,2", "1,,2", "1,", "1 2", "1e3", "8388609", "-1")
BAD = [
    (),
    ("--taus",),
    *(("--taus", taus) for taus in BAD_TAUS),
    ("--taus", ",".join(map(str, range(1, 34)))),
    ("--taus", "1", "--name", "4x"),
    ("--taus", "1", "--name", "a b"),
    ("--taus", "1,4", "--long", "4"),
    ("--taus", "1,4", "--long", "8,2147483649"),
    ("--tau", "1"),
    ("plan.c",),
    *(
        ("--taus", "1,2", "--rate", "100", "--bandwidth", filter)
        for filter in re.split(" ", FILTERS)
    ),
    ("--taus", "1,2", "--bandwidth", "20"),
    ("--taus", "1,2", "--bandwidth", "20", "--rate", "0"),
    ("--taus", "1,2", "--bandwidth", "20", "--rate", "x"),
    *(
        tuple(words.split())
        for words in (
            "--floor",
            "--floor --lsb 1 --bandwidth none",
            "--floor --rate 1000 --bandwidth none",
            "--floor --rate 1000 --lsb 1",
            "--floor --rate 1000 --lsb 1e13 --bandwidth none",
            "--floor --rate 1000 --lsb 1 --bandwidth none --rail 0",
            "--floor --rate 1000 --lsb 1 --bandwidth none --rail 2147483648",
            "--floor --rate 1000 --lsb 1 --bandwidth none --rail -1",
            "--floor --rate 1000 --lsb 1 --bandwidth none --taus 1,2",
            "--floor --rate 1000 --lsb 1 --bandwidth none --long 1,2",
            "--floor --rate 1000 --lsb 1 --bandwidth 20:3",
            "--floor=1",
            "--taus 1,2 --lsb 1",
            "--taus 1,2 --rail 1",
        )
    ),
]


def test_a_bad_option_is_one_line():
    for words in BAD:
        done = plan(*words)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), words
        assert done.stderr.startswith("davar-plan: ")


def test_help_and_both_spellings_of_a_value():
    for words in (("--help",), ("--taus", "1,2", "--help"), ("--taus", "--help")):
        done = plan(*words)
        assert (done.returncode, done.stderr) == (0, "")
        assert "--taus" in done.stdout
    apart = plan("--taus", "1,2,4", "--bandwidth", "20", "--rate", "100", "--name", "a")
    joined = plan("--taus=1,2,4", "--bandwidth=20", "--rate=100", "--name=a")
    assert (joined.returncode, joined.stderr) == (0, "")
    assert joined.stdout == apart.stdout
