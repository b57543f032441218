"""What the commands of tools/ share: support/setup.sh makes a thing once for two tools, and reads
newer presets again; tools/davar-sim passes on output, status and folder; tools/davar-bench prints
what was measured; the bundled recording is that of its script.
"""

import gzip
import json
import os
import runpy
import shutil
import subprocess
from collections import defaultdict

import bench
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


def test_davar_sim_reads_a_path_of_the_caller_and_passes_on_its_status(tmp_path):
    rows = "".join(f"{i / 100:.2f},{(i * 7919) % 101 * 0.01:.2f}\n" for i in range(700))
    (tmp_path / "rec.csv").write_text("time_s,gyro_z_dps\n" + rows)
    options = ["--lsb", "0.01", "--stride", "100", "--bandwidth", "none"]
    for name, status in (("rec.csv", 0), ("no such file.csv", 2)):
        command = [ROOT / "tools/davar-sim", name, *options]
        done = subprocess.run(command, cwd=tmp_path, text=True, capture_output=True)
        assert (done.returncode, done.stdout == "") == (status, status == 2)
        assert done.stderr == "" if status == 0 else name in done.stderr


@pytest.mark.parametrize(
    "absent", ["", "numba_ns_per_sample", "allantools_per_window_ns_per_sample", "python"]
)
def test_the_benchmark_prints_all_figures_and_what_is_not_installed(absent, capsys):
    targets = json.loads((ROOT / "docs/cost.json").read_text(encoding="utf-8"))
    csv = {"rows, ns": {"davar-sim": 70.0, "wc -l": 1.4}}
    numba = None if absent == "python" else 3.0
    python = {"record, ms": {"davar": 1.0, "numba": numba, "AllanTools": 4.0}}
    figures = defaultdict(lambda: 2.0, {absent: None})
    bench.show_all(figures, csv, python, targets)
    printed = capsys.readouterr().out
    for target, values in targets.items():
        instructions = values["every_sample_instructions_per_sample"]
        assert f"| {target} | {instructions:.0f} |" in printed
    assert printed.count("not installed") == bool(absent)
    bench.show_all(figures, csv, None, targets)
    assert "The Python package" not in capsys.readouterr().out


def test_the_bundled_recording_is_that_of_its_script_and_states_that_it_is_simulated():
    bundled = ROOT / "data/demo_disturbance.csv.gz"
    text = gzip.decompress(bundled.read_bytes())
    # The text must agree; how well zlib packs it may differ between versions.
    made = runpy.run_path(str(ROOT / "data/make_demo.py"))["content"]()
    assert text == gzip.decompress(made)
    assert bundled.stat().st_size < 300_000
    assert b"SIMULATED" in text.splitlines()[0]
