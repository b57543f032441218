"""Setups of the engine small: when the planner chooses it, and that its noise and angle random walk
are those of the complete library, bit for bit.
"""

import re
import subprocess

import c_library
import pytest
from planner import programs, text
from planner_case import ROOT, built, gcc, plan_of, planned, printed_by, refused, run, write

SMALL = "--rate 100 --lsb 0.05 --bandwidth none --lost 0 --motion none --core cortex-m4f"
PROBE = ROOT / "tests/support/small_probe.c"
OPTIMISED = ("-O2", "-ffp-contract=off")


def window_flags(design):
    return (f"-DWINDOW={design.window}U", f"-DSTRIDE={design.stride}U")


def complete(design, folder):
    """What the complete library returns for the same samples."""
    wishes, taus = design.wishes, ",".join(map(str, design.taus))
    plan = programs.fit_plan(wishes, design.taus).text.replace("davar_setup_plan", "own_plan")
    source = f'#include "davar/fit.h"\n#include "davar/version.h"\n{plan}'
    (folder / "own_plan.c").write_text(source)
    flags = (f"-DRATE={wishes.rate_hz!r}", f"-DUNIT={wishes.lsb!r}", f"-DTAUS={taus}")
    sources = (PROBE, "own_plan.c", *c_library.SOURCES)
    gcc(folder, *OPTIMISED, *flags, *window_flags(design), *sources, "-lm", "-o", "complete")
    return printed_by([folder / "complete"])


@pytest.mark.parametrize(
    "wishes",
    (
        SMALL,
        pytest.param(SMALL.replace("none", "33:2", 1), marks=pytest.mark.slow),
        pytest.param(
            SMALL.replace("none", "average:4", 1).replace("100", "50"), marks=pytest.mark.slow
        ),
    ),
)
def test_its_results_are_those_of_the_complete_library(wishes, tmp_path):
    design = plan_of(wishes).design
    assert design.engine == "small"
    write(wishes, tmp_path)
    flags = ("@davar_setup.args", "-DSMALL", *window_flags(design))
    sources = (PROBE, "davar_setup.c", *c_library.SOURCES)
    assert gcc(tmp_path, *OPTIMISED, *flags, *sources, "-lm", "-o", "small") == ""
    found = printed_by([tmp_path / "small"])
    assert found == complete(design, tmp_path)
    counts = dict(re.findall(r"^(white|mixed|constant|coarse) (\d+)$", found, re.MULTILINE))
    assert len(counts) == 4
    assert min(map(int, counts.values())) > 50


def test_the_planner_chooses_it_for_the_fewest_bytes():
    plan, usual = planned(SMALL), planned(f"{SMALL} --engine slide")
    assert (plan["engine"], usual["engine"]) == ("small", "slide")
    assert plan["flash_bytes"] < 0.4 * usual["flash_bytes"]
    assert plan["ram_bytes"] < 0.6 * usual["ram_bytes"]
    assert plan["arw_percent"] == usual["arw_percent"]
    assert planned(f"{SMALL} --ram 1.5k --flash 5k")["engine"] == "small"


@pytest.mark.parametrize(
    "more",
    (
        "--axes 2",
        "--lost 0.1",
        "--motion slow",
        "--motion flight",
        "--type int32",
        "--longest-tau 100",
        "--false-alarms-per-hour 1",
    ),
)
def test_other_wishes_need_more(more):
    option, value = more.split()
    words = re.sub(rf"{option} \S+ ?", "", SMALL)
    assert planned(f"{words} {option} {value}")["engine"] != "small"
    if option != "--longest-tau":
        done = run([*words.split(), option, value, "--engine", "small"])
        assert (done.status, done.out) == (2, "")
        assert "--engine: small" in done.err


def test_without_a_declared_filter_it_is_not_chosen():
    assert planned(SMALL.replace("--bandwidth none ", ""))["engine"] != "small"


def test_a_limit_of_flash_names_lost_samples_as_what_to_relax():
    found = refused(f"{SMALL.replace('--lost 0', '')} --flash 6k")
    assert {"option": "--lost", "value": "0"} in found["relax"]


def test_its_setup_compiles_alone(tmp_path):
    done = run([*SMALL.split(), "-o", str(tmp_path / "setup"), "--self-contained"])
    assert (done.status, done.err) == (0, "")
    main = '#include "davar_setup.h"\nint main(void) { return (int)davar_setup_start(); }\n'
    (tmp_path / "setup/main.c").write_text(main)
    flags = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
    sources = ("davar.c", "davar_setup.c", "main.c")
    made = subprocess.run(
        ["gcc", *flags, *sources, "-lm", "-o", "main"],
        text=True,
        capture_output=True,
        cwd=tmp_path / "setup",
    )
    assert (made.returncode, made.stderr) == (0, "")
    assert subprocess.run([tmp_path / "setup/main"]).returncode == 0


@pytest.mark.parametrize(
    "words",
    (
        "--taus 1,2,4 --window 40 --stride 20",  # without rate, lsb and filter
        "--taus 1,2,4 --window 40 --stride 3 --rate 100 --lsb 1 --bandwidth none",
        "--taus 1,2,4 --window 40 --stride 40 --rate 100 --lsb 1 --bandwidth none",
        "--taus 1,2,4 --window 40 --stride 1 --rate 100 --lsb 1 --bandwidth none",
        "--taus 1,2,4,8 --window 40 --stride 20 --rate 100 --lsb 1 --bandwidth none",
        "--taus 1,2,3 --window 40 --stride 20 --rate 100 --lsb 1 --bandwidth none",
        "--taus 1,2,4 --window 0 --stride 20 --rate 100 --lsb 1 --bandwidth none",
        "--taus 1,2,4 --window 65537 --stride 65537 --rate 100 --lsb 1 --bandwidth none",
    ),
)
def test_the_program_refuses_windows_that_small_cannot_have(words):
    built()
    done = subprocess.run([programs.PROGRAM, *words.split()], text=True, capture_output=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("davar-plan: --window: ")


def test_the_options_of_the_build_follow_the_filter():
    assert "DAVAR_FILTERS=0" in text.defines(plan_of(SMALL).design)
    assert "DAVAR_FILTERS=1" in text.defines(plan_of(SMALL.replace("none", "33:2", 1)).design)
