"""The setup that tools/davar-plan writes: it compiles, and passes every sample to the library.
test_planner_figures.py tests its promises.
"""

import math
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from planner_case import EXAMPLE, ROOT, USUAL, gcc, printed_by, run, write

NASTY = (  # names of folders
    *(
        "a*/b",
        "/*",
        "/*/",
        "a*//b",
        "x */ int y; /*",
        "ä ö",
        "1x",
        "a-b.c",
        "a'b",
        "*'/",
        "a\\",
        'a"b',
    ),
    *("n" * 200, "two\nlines", "*\\\n/", "??/", "$(id)", "\udcff", "\u202e", "%s{}", "//"),
)
FILES = {"davar_setup.h", "davar_setup.c", "davar_setup.args", "davar_setup.cmake"}
PROBE = (ROOT / "tests/tools/setup_probe.c").read_text()
STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-O0")
M0 = ["arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb", "--specs=nosys.specs"]
# Options besides rate, filter and core, and definitions of setup_probe.c.
COUNTS = "--lsb 0.05 -DSAMPLE=int16_t -DSUFFIX=q15 -DSIGMA=20"
PROBED = [
    f"--axes 3 {COUNTS}",
    *(
        pytest.param(words, marks=pytest.mark.slow)
        for words in (
            f"--axes 2 --longest-tau 40 --respond 4 --flash 24k {COUNTS} -DCASCADE",
            f"--axes 2 --longest-tau 40 --respond 4 {COUNTS} -DCASCADE -DWHOLE_CURVE",
            f"--longest-tau 40 --false-alarms-per-hour 0.1 {COUNTS} -DCASCADE -DWHOLE_CURVE",
            "--axes 2 --type int32 --lsb 1e-4 -DSAMPLE=int32_t -DSUFFIX=q31 -DSIGMA=10000",
            "--type float --full-scale 500 --longest-tau 40 -DSAMPLE=float -DSUFFIX=f32 "
            "-DSIGMA=1.0 -DCASCADE -DWHOLE_CURVE",
        )
    ),
]


@pytest.mark.parametrize("more", PROBED)
def test_a_self_contained_setup_compiles_alone_and_does_what_the_library_does(more, tmp_path):
    options = [word for word in more.split() if not word.startswith("-D")]
    defined = [word for word in more.split() if word.startswith("-D")]
    words = ["--rate", "100", "--bandwidth", "none", "--core", "cortex-m4f", *options]
    folder = tmp_path / "setup"
    done = run([*words, "-o", str(folder), "--self-contained"])
    assert (done.status, done.err) == (0, "")
    names = {"davar.h", "davar.c", "davar_setup.h", "davar_setup.c"}
    assert {path.name for path in folder.iterdir()} == names
    (folder / "program.c").write_text(PROBE)
    for compiler in [["gcc"], M0]:
        if shutil.which(compiler[0]):
            command = [*compiler, *STRICT, *defined, "davar.c", "program.c", "-lm", "-o", "program"]
            done = subprocess.run(command, text=True, capture_output=True, cwd=folder)
            assert (done.returncode, done.stderr) == (0, "")
            if compiler == ["gcc"]:
                lines = printed_by([folder / "program"]).splitlines()
    present, value, low, high = np.array([list(map(float, line.split())) for line in lines]).T
    assert len(lines) > 40
    assert np.mean(present) > 0.9
    there, truth = present == 1, 60 / math.sqrt(100)
    assert np.mean((low[there] <= truth) & (truth <= high[there])) > 0.85
    assert np.median(value[there]) == pytest.approx(truth, rel=0.05)


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


@pytest.mark.parametrize("name", NASTY)
def test_a_setup_in_a_folder_of_any_name_compiles(name, tmp_path, monkeypatch):
    """Its header has the command that made it, which makes it again."""
    monkeypatch.chdir(tmp_path)
    words = [*USUAL.split(), "-o", f"./{name}"]
    done = run(words)
    assert (done.status, done.err) == (0, "")
    done.out.encode()
    folder = Path(f"{tmp_path}/{name}")
    command = ("@davar_setup.args", *STRICT, "-fsyntax-only", "davar_setup.c")
    assert gcc(folder, *command) == ""
    made = re.search(r"tools/davar-plan (.*)", (folder / "davar_setup.h").read_text())[1]
    if name.isprintable():
        assert shlex.split(made) == words


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
