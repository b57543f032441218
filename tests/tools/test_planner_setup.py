"""The setup that tools/davar-plan writes: it compiles, passes the planned numbers and every sample
to the library, and its calls may come in any order. test_planner_figures.py tests its promises.
"""

import json
import math
import shutil
import subprocess

import c_library
import numpy as np
import pytest
from planner_case import EXAMPLE, ROOT, USUAL, WISHES, gcc, plan_of, planned, printed_by, run, write

FILES = {"davar_setup.h", "davar_setup.c", "davar_setup.args", "davar_setup.cmake"}
HERE = ROOT / "tests/tools"
SAMPLE = {"int16": "int16_t", "int32": "int32_t", "float": "float"}
SEED = 20261


def library_and(program, folder, *options):
    """The program of this folder, compiled with the setup in `folder` and the whole library."""
    options = ("-O1", "@davar_setup.args", *options)
    sources = [HERE / program, "davar_setup.c", *c_library.SOURCES]
    done = gcc(folder, *options, *sources, "-lm", "-o", "run")
    assert done == ""
    return folder / "run"


# --- the files ---


def called(words, folder, count=37, block=37):
    """What the files of a plan pass to the library: [(function, axis, values)]."""
    write(words, folder)
    wishes = plan_of(words).design.wishes
    options = [f"-DSAMPLE={SAMPLE[wishes.type]}", *(["-DFLOAT"] if wishes.type == "float" else [])]
    options += ["-DCASCADE"] if plan_of(words).design.cascade_taus else []
    done = gcc(folder, "@davar_setup.args", *options, HERE / "setup_facts.c", "-lm", "-o", "facts")
    assert done == ""
    lines = printed_by([folder / "facts", str(count), str(block)]).splitlines()
    words = [line.split() for line in lines]
    return [(name, int(axis), [float(value) for value in more]) for name, axis, *more in words]


@pytest.mark.parametrize("words", WISHES)
def test_the_library_is_started_as_planned(words, tmp_path):
    design = plan_of(words).design
    wishes, calls = design.wishes, called(words, tmp_path)
    scale = [wishes.lsb or 0, wishes.full_scale or 0]
    engine = 1 if (design.law, design.engine) == ("fixed", "grid") else 0
    started = {axis: more for name, axis, more in calls if name == "init"}
    assert list(started) == list(range(wishes.axes))
    for is_own, bytes, *config in started.values():
        assert is_own
        assert bytes % 8 == 0
        law = [wishes.false_alarms_per_hour or 0.01, 10] if design.law == "glr" else [0, 0]
        window = [design.window, design.shortest, 4]
        sizes = [design.taus[-1], len(design.taus)]
        assert config == [wishes.rate_hz, *scale, design.stride, engine, *window, *law, *sizes]
    slow = [more for name, _, more in calls if name == "slow_init"]
    assert len(slow) == (wishes.axes if design.cascade_taus else 0)
    for is_own, _, *config in slow:
        assert is_own
        shape = [design.cascade_shortest, design.cascade_taus, 32]
        assert config == [wishes.rate_hz, *scale, *shape]


@pytest.mark.parametrize("block", (1, 16, 17, 40, 150))
@pytest.mark.parametrize("words", (WISHES[0], WISHES[6], WISHES[7]))
def test_every_sample_of_every_axis_arrives_once_in_order(words, block, tmp_path):
    axes, count = plan_of(words).design.wishes.axes, 90
    calls = called(words, tmp_path, count, block)
    for name in ("push", *(["slow_push"] if "longest-tau" in words else [])):
        for a in range(axes):
            values = [
                value for one, axis, more in calls if (one, axis) == (name, a) for value in more
            ]
            assert values == [100 * a + i for i in range(count)]
    for name in ("gap", *(["slow_gap"] if "longest-tau" in words else [])):
        assert [(axis, more) for one, axis, more in calls if one == name] == [
            (a, [7]) for a in range(axes)
        ]


@pytest.mark.parametrize("words", WISHES)
def test_a_result_is_of_its_axis_and_fitted_with_the_plan_of_the_files(words, tmp_path):
    design = plan_of(words).design
    axes, rate = design.wishes.axes, design.wishes.rate_hz
    calls = called(words, tmp_path)
    white = "fit_white" if design.fit == "terms" else "fit_white_ready"
    fits = [(axis, more) for name, axis, more in calls if name == white]
    assert fits == [(a, [1, rate]) for a in range(axes - 1)]  # the last one has no new result
    assert [more[0] for name, _, more in calls if name == "taken"] == [1] * (axes - 1) + [0, 0]
    curves = [more[0] for name, _, more in calls if name == "curve"]
    assert curves == ([1] * axes + [0] if design.cascade_taus else [])
    appended = [more[0] for name, _, more in calls if name == "append"]
    sizes = [0] * axes  # of the window: those of the newest result, or of none
    if design.fit == "terms":
        sizes[-1] = len(design.taus)
        assert [more for name, _, more in calls if name == "fit"] == [[1, rate]] * axes
    assert appended[-1:] == sizes[-1:] if design.cascade_taus else appended == []


@pytest.mark.parametrize("words", (WISHES[3], WISHES[7]))
def test_restart_health_and_instance_are_those_of_the_axis(words, tmp_path):
    axes, calls = plan_of(words).design.wishes.axes, called(words, tmp_path)
    for name in ("reset", *(["slow_reset"] if "longest-tau" in words else [])):
        assert [axis for one, axis, _ in calls if one == name] == list(range(axes))
    instances = [more for name, _, more in calls if name == "instance"]
    assert instances == [[a] for a in range(axes)] + [[-1]]  # null for an axis that is not there
    assert [more for name, _, more in calls if name == "health"] == [
        [a] for a in [*range(1, axes + 1), 0]
    ]
    assert [more for name, _, more in calls if name == "config"] == [[1]]


# Pushes white noise of sigma 20 counts; prints each result, and the health of axis 0 at the end.
ALONE = """#include "davar_setup.h"
#include <stdio.h>
static uint64_t state = 1;
static int16_t noise(void)
{
    double sum = -6.0;
    for (int k = 0; k < 12; k++) {
        state = (state * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
        sum += (double)(state >> 11U) / 9007199254740992.0;
    }
    return (int16_t)((20.0 * sum) + 1000.5);
}
int main(void)
{
    if (davar_setup_start() != DAVAR_OK) {
        return 1;
    }
    for (int i = 0; i < 40000; i++) {
        int16_t samples[DAVAR_SETUP_AXES];
        for (int a = 0; a < DAVAR_SETUP_AXES; a++) {
            samples[a] = noise();
        }
        davar_setup_push(samples, 1);
        const davar_result_t *const result = davar_setup_take(0);
        if (result != NULL) {
            const davar_coefficient_t *const arw =
                &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printf("%d %g %g %g\\n", arw->present, arw->value, arw->low, arw->high);
        }
    }
    davar_setup_gap(7);
    return (davar_setup_health(0).missing == 7) ? 0 : 2;
}
"""
STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
M0 = ("arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb", "--specs=nosys.specs")


def compiled_alone(folder, *compiler):
    """A self-contained setup with a program, without any include path or option of davar."""
    sources = ("davar.c", "davar_setup.c", "program.c")
    words = [*compiler, *STRICT, "-O0", *sources, "-lm", "-o", "program"]
    done = subprocess.run(words, text=True, capture_output=True, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")


SLOW = [
    pytest.param(more, marks=pytest.mark.slow)
    for more in (" --longest-tau 100", " --false-alarms-per-hour 0.1")
]


@pytest.mark.parametrize("more", ["", *SLOW])
def test_a_self_contained_setup_compiles_alone_and_measures_noise(more, tmp_path):
    words = f"--rate 100 --lsb 0.05 --bandwidth none --core cortex-m0{more}"
    folder = tmp_path / "setup"
    done = run([*words.split(), "-o", str(folder), "--self-contained"])
    assert (done.status, done.err) == (0, "")
    names = {"davar.h", "davar.c", "davar_setup.h", "davar_setup.c"}
    assert {path.name for path in folder.iterdir()} == names
    (folder / "program.c").write_text(ALONE)
    compiled_alone(folder, "gcc")
    lines = printed_by([folder / "program"]).splitlines()
    present, value, low, high = np.array([list(map(float, line.split())) for line in lines]).T
    truth = 60 * 20 * 0.05 / math.sqrt(100)  # 6 deg/sqrt(h)
    assert len(lines) > 40
    assert np.mean(present) > 0.9
    there = present == 1
    assert np.mean((low[there] <= truth) & (truth <= high[there])) > 0.85
    assert np.median(value[there]) == pytest.approx(truth, rel=0.05)
    if shutil.which(M0[0]):
        compiled_alone(folder, *M0)


def test_a_self_contained_setup_refuses_contradicting_options_and_needs_a_folder(tmp_path):
    words = USUAL.split()
    assert run([*words, "-o", str(tmp_path), "--self-contained"]).status == 0
    assert "redefined" in gcc(tmp_path, "-DDAVAR_TAUS_MAX=3", "-fsyntax-only", "davar_setup.c")
    done = run([*words, "--self-contained"])
    assert (done.status, done.out) == (2, "")
    assert done.err == (
        "davar-plan: --self-contained: needs -o FOLDER, where the files are written\n"
    )


def test_the_header_refuses_other_options_and_serves_c_plus_plus(tmp_path):
    write(EXAMPLE, tmp_path)
    assert "davar_setup.args" in gcc(tmp_path, "-c", "davar_setup.c", "-o", "a.o")
    (tmp_path / "a.cpp").write_text('#include "davar_setup.h"\nint main() {}\n')
    options = ("-Wall", "-Wextra", "-Werror", "@davar_setup.args", "-fsyntax-only", "a.cpp")
    assert gcc(tmp_path, *options, compiler="g++") == ""


def test_the_same_wishes_write_the_same_four_files(tmp_path):
    contents = []
    for name in ("one", "other"):
        done = run([*EXAMPLE.split(), "-o", str(tmp_path / "setup")])
        assert (done.status, done.err) == (0, "")
        assert done.out.endswith(f" in {tmp_path / 'setup'}\n")
        (tmp_path / "setup").rename(tmp_path / name)
        contents.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0].keys() == FILES
    assert contents[0] == contents[1]


@pytest.mark.slow
def test_cmake_builds_it_with_the_options_of_the_plan(tmp_path):
    write(EXAMPLE, tmp_path)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(app LANGUAGES C)\n"
        "include(davar_setup.cmake)\n"
        f"add_subdirectory({ROOT} davar)\nadd_executable(app main.c davar_setup.c)\n"
        "target_link_libraries(app PRIVATE davar::davar davar::cascade)\n"
    )
    (tmp_path / "main.c").write_text(
        '#include "davar_setup.h"\n'
        "int main(void) { return (davar_setup_start() == DAVAR_OK) ? 0 : 1; }\n"
    )
    for words in (["-S", ".", "-B", "build"], ["--build", "build", "--target", "app"]):
        done = subprocess.run(["cmake", *words], text=True, capture_output=True, cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
    assert subprocess.run([tmp_path / "build/app"]).returncode == 0


# --- take and curve in any order ---

SAMPLES, SIGMA, UNIT, RATE = 40000, 20, 0.05, 100
TWO_AXES = (
    f"--rate {RATE} --axes 2 --lsb {UNIT} --bandwidth none --respond 4 --longest-tau 40 "
    "--core cortex-m4f"
)


def returned(words, fit, folder):
    """The plan, and what each call of setup_calls.c returned after the first samples."""
    found = planned(words)
    assert found["fit"] == fit
    write(words, folder)
    program = library_and("setup_calls.c", folder, f"-DSTRIDE={round(found['stride_s'] * RATE)}U")
    lines = printed_by([program, str(SEED), str(SAMPLES)]).splitlines()
    calls = [json.loads(line) for line in lines]
    assert [call["has_result"] for call in calls[:4]] == [False] * 4
    return found, calls[4:]


def check_long(call, found):
    """The long sizes have values of white noise: within five standard errors."""
    taus = {m: [float.fromhex(x) for x in more] for m, _, *more in call["taus"]}
    assert max(taus) == round(max(found["taus_s"]) * RATE)
    for m, (adev, low, high) in taus.items():
        if m >= 64:
            truth = SIGMA * UNIT / math.sqrt(m)
            spread = 5 * math.sqrt(m / min(SAMPLES, 34 * m))
            assert abs(adev / truth - 1) < spread
            assert low < adev < high


def check_walk(call):
    walk = call["walk"]
    truth = 60 * SIGMA * UNIT / math.sqrt(RATE)
    assert walk["present"]
    assert abs(walk["value"] - truth) < walk["high"] - walk["low"] < truth


@pytest.mark.slow
def test_a_curve_without_a_fit_needs_no_result_and_takes_none(tmp_path):
    found, calls = returned(f"{TWO_AXES} --flash 24k", "curve", tmp_path)
    take, again, curve, same, other, of_other, late, after = calls
    for call in (take, of_other, after):
        check_walk(call)
    assert not again["has_result"]
    for call in (curve, same, other, late):
        check_long(call, found)
        assert not call["walk"]["present"]
    assert curve == same
    assert curve["taus"] != other["taus"]


@pytest.mark.slow
@pytest.mark.parametrize("more", ("", " --false-alarms-per-hour 0.1"))
def test_a_fit_of_all_terms_uses_the_window_if_there_is_a_new_result(more, tmp_path):
    found, calls = returned(TWO_AXES + more, "terms", tmp_path)
    take, again, curve, same, other, of_other, late, after = calls
    check_walk(take)
    for call in (curve, same, other, late):
        check_long(call, found)
        check_walk(call)
    for call in (again, of_other, after):
        assert not call["has_result"]
    assert curve == same
    sizes = [tau[0] for tau in take["taus"]]
    for call, has_window in ((curve, False), (other, True), (late, True)):
        of_window = call["taus"][: len(sizes)]
        assert [tau[0] for tau in of_window] == sizes
        assert [tau[1] > 0 for tau in of_window] == [has_window] * len(sizes)
        assert ["nan" not in tau for tau in of_window] == [has_window] * len(sizes)
