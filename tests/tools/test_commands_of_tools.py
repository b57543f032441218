"""tools/davar-sim reads paths of the caller and passes on the output and the status.
tools/davar-bench prints what was measured. The bundled recording is that of data/make_demo.py.
"""

import gzip
import json
import runpy
import subprocess
from collections import defaultdict

import pytest
from planner_case import ROOT

import bench


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
