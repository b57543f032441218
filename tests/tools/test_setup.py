"""tools/support/setup.sh makes a thing once for several tools that need it, and configures a build
folder again when the presets are newer.
"""

import os
import shutil
import subprocess

import pytest
from planner_case import ROOT

PRESETS = """{"version": 3, "configurePresets": [{"name": "p", "generator": "Unix Makefiles",
"binaryDir": "${sourceDir}/build/p", "cacheVariables": {"WHICH": "@"}}],
"buildPresets": [{"name": "p", "configurePreset": "p"}]}"""


@pytest.fixture
def start(tmp_path):
    (tmp_path / "tools/support").mkdir(parents=True)
    shutil.copy(ROOT / "tools/support/setup.sh", tmp_path / "tools/support")

    def started(words):
        command = ["bash", "-c", f". tools/support/setup.sh && {words}"]
        pipes = dict.fromkeys(("stdout", "stderr"), subprocess.PIPE)
        return subprocess.Popen(command, cwd=tmp_path, text=True, **pipes)

    return started


@pytest.mark.slow
def test_three_tools_that_need_the_same_python_make_it_once(tmp_path, start):
    (tmp_path / "pins.txt").write_text("# nothing\n")
    started = [start("python_environment venv pins.txt") for _ in range(3)]
    said = [process.communicate() for process in started]
    assert [process.returncode for process in started] == [0] * 3, said
    python = tmp_path.resolve() / "build/venv/bin/python"
    assert {out for out, _ in said} == {f"{python}\n"}
    assert "".join(error for _, error in said).count("making build/venv") == 1
    subprocess.run([python, "-c", "import pip"], check=True)


@pytest.mark.slow
def test_a_build_folder_is_configured_again_when_the_presets_are_newer(tmp_path, start):
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(one LANGUAGES NONE)\n"
        "add_custom_target(${WHICH})\n"
    )
    presets = tmp_path / "CMakePresets.json"
    for which in ("first", "second"):
        presets.write_text(PRESETS.replace("@", which))
        if which == "second":
            later = (tmp_path / "build/p/configured").stat().st_mtime + 2
            os.utime(presets, (later, later))
        done = start(f"build p {which}")
        assert (done.communicate()[1], done.returncode) == ("", 0)
