"""The results of pip for the repository: sdist, wheel, types, and the program davarlab with and
without the extra.
"""

import csv
import importlib.metadata
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import davarlab
import pytest
import together
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from together import davar

VERSION = ".".join(
    re.findall(
        r"#define DAVAR_VERSION_\w+ (\d+)\n",
        (together.ROOT / "lib/include/davar/version.h").read_text(),
    )
)
USE = """import davar
import numpy as np
found = davar.adev(np.zeros(10), 1.0)
reveal_type(found.n)
reveal_type(davar.Stream(1.0, lsb=1.0).push([1]))
davar.dynamic([1.0], window_max='6')
"""
MODEL = """[sensor]
rate_hz = 50.0
column = "%s"

[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 0.3
"""
ABSENT = """import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in %r:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Absent())
"""
IN_WHEEL = (
    "davar/py.typed",
    "davar/libdavar_python.so",
    "davar/shared/libdavar_lab.so",
    "davar/shared/davar.dbc",
    "davar/shared/davar-plan",
    "davar/shared/davar-promise",
    "planner/costs.json",
    "davarlab/report/page.html",
    "davarfleet/page.html",
    f"davar-{VERSION}.dist-info/licenses/LICENSE",
)


def run(command, folder, *paths):
    """A command in an environment that has only these folders before its own packages."""
    variables = {"PATH": os.environ["PATH"], "HOME": str(folder), "MPLCONFIGDIR": str(folder)}
    variables |= {"PYTHONPATH": ":".join(map(str, paths)), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, *map(str, command)]
    return subprocess.run(command, cwd=folder, env=variables, text=True, capture_output=True)


def test_one_wheel_for_every_python_contains_only_the_packages(wheel):
    made, source = sorted(path.name for path in wheel.dist.iterdir())
    assert re.fullmatch(rf"davar-{re.escape(VERSION)}-py3-none-linux_\w+\.whl", made)
    assert source == f"davar-{VERSION}.tar.gz"
    with zipfile.ZipFile(wheel.dist / made) as archive:
        names = archive.namelist()
    info = f"davar-{VERSION}.dist-info"
    assert {name.split("/")[0] for name in names} == {
        "davar",
        "davarlab",
        "davarfleet",
        "planner",
        info,
    }
    assert set(IN_WHEEL) <= set(names)
    build = (".c", ".a", ".pyc", ".txt")
    assert [name for name in names if name.endswith(build)] == [f"{info}/entry_points.txt"]


def test_the_sdist_has_no_tests_and_no_build(wheel):
    with tarfile.open(wheel.dist / f"davar-{VERSION}.tar.gz") as archive:
        folders = {name.split("/")[1] for name in archive.getnames() if "/" in name}
    assert {"lib", "host_sim", "python", "tools", "pyproject.toml", "LICENSE"} <= folders
    assert not {"tests", "build", ".git"} & folders


def test_the_extras_are_ranges_that_contain_what_the_tests_run_with():
    pins = (together.ROOT / "tools/requirements-lab.txt").read_text().split()
    pinned = {
        canonicalize_name(name): version for name, version in (one.split("==") for one in pins)
    }
    wanted = [Requirement(one) for one in importlib.metadata.requires("davar")]
    assert [one.name for one in wanted if not one.marker] == ["numpy"]
    for one in wanted:
        if one.name != "davar":
            assert one.specifier.contains(pinned[canonicalize_name(one.name)]), str(one)
            assert "==" not in str(one.specifier), str(one)
    assert importlib.metadata.version("davar") == VERSION


def extra_of(name):
    """Packages of an extra, that no other of `lab` has."""
    wanted = map(Requirement, importlib.metadata.requires("davar"))
    named = [one for one in wanted if one.marker and one.name != "davar"]
    of = {one.name for one in named if one.marker.evaluate({"extra": name})}
    return of - {one.name for one in named if one.marker.evaluate({"extra": "lab"})}


def test_the_extra_lab_alone_runs_davarlab_and_the_others_are_named(wheel, tmp_path):
    """Every module of the other extras is as if it were not installed."""
    absent = {extra: extra_of(extra) for extra in ("logs", "wire", "fleet", "plots")}
    hidden = tmp_path / "sitecustomize.py"
    hidden.write_text(ABSENT % set().union(*absent.values()))

    def lab(*words, status=0):
        done = run([wheel.site / "bin/davarlab", *words], tmp_path, tmp_path, wheel.site)
        assert done.returncode == status, done.stderr
        return done.stdout + done.stderr

    scenario = (together.ROOT / "data/tutorial_sensor.toml").read_text().replace("7200", "300")
    (tmp_path / "s.toml").write_text(scenario)
    lab("simulate", "s.toml", "-o", "rec.csv")
    assert "angle_random_walk" in lab("fit", "rec.csv", "-o", "m.toml")
    lab("compare", "rec.csv", "-m", "m.toml", "--report", "r.html")
    (tmp_path / "log.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(40))
    for extra, words in {
        "logs": ("fit", "log.bag"),
        "plots": ("plot", "rec.csv", "-m", "m.toml", "-o", "p.png"),
        "wire": ("live", "cyphal:vcan0"),
        "fleet": ("fleet", "rec.csv", "-m", "m.toml", "-o", "out"),
    }.items():
        assert absent[extra], extra
        if extra == "fleet":  # the others are there
            hidden.write_text(ABSENT % (absent["fleet"] - absent["plots"]))
        assert re.search(rf'not installed; pip install "davar\[{extra}\]"', lab(*words, status=2))


def test_the_tested_package_is_outside_of_the_checkout():
    assert not Path(davar.__file__).resolve().is_relative_to(together.ROOT)
    assert Path(davarlab.__file__).resolve().is_relative_to(together.ROOT)


def test_types_are_complete(wheel, tmp_path):
    """Runs mypy as a user's project would."""
    (tmp_path / "use.py").write_text(USE)
    for name in ("davar", "davarlab"):
        (tmp_path / name).symlink_to(wheel.site / name)
    said = run(["-m", "mypy", "--strict", "use.py"], tmp_path).stdout
    assert re.search(r'use.py:4: note: Revealed type is "numpy.ndarray', said), said
    assert 'use.py:5: note: Revealed type is "int"' in said.replace("builtins.int", "int")
    assert 'use.py:6: error: Argument "window_max"' in said
    untyped = [  # of other packages
        "--untyped-calls-exclude=numpy.ma",
        "--disable-error-code=import-untyped",
        "--follow-imports=silent",
    ]
    done = run(["-m", "mypy", "--strict", *untyped, "-p", "davar"], tmp_path)
    assert done.returncode == 0, done.stdout


def test_without_the_extra_the_library_works_and_davarlab_reports_it(wheel, tmp_path):
    paths = wheel.davar, wheel.numpy
    code = "import davar; print(davar.adev([1.0, 2.0, 4.0], 1.0, clusters=[1]).adev[0] ** 2)"
    assert float(run(["-S", "-c", code], tmp_path, *paths).stdout) == pytest.approx((1 + 4) / 4)
    done = run(["-S", wheel.site / "bin/davarlab", "--help"], tmp_path, *paths)
    assert (done.returncode, done.stdout) == (2, "")
    wanted = r'davarlab: not installed: .*; pip install "davar\[lab\]"\n'
    assert re.fullmatch(wanted, done.stderr)


def test_importing_the_library_loads_nothing_of_davarlab(wheel, tmp_path):
    code = "import davar, sys; print(*sys.modules)"
    loaded = run(["-S", "-c", code], tmp_path, wheel.davar, wheel.numpy).stdout.split()
    assert {"davarlab", "davar.wire", "importlib.metadata"} & set(loaded) == set()
    assert "davar._stream" in loaded


def test_davarlab_runs_with_its_own_library(wheel, tmp_path):
    def lab(*words, status=(0,)):
        done = run([wheel.site / "bin/davarlab", *words], tmp_path, wheel.site)
        assert done.returncode in status, done.stderr
        return done.stdout

    scenario = (together.ROOT / "data/tutorial_sensor.toml").read_text().replace("7200", "600")
    (tmp_path / "s.toml").write_text(scenario)
    lab("simulate", "s.toml", "-o", "rec.csv")
    with (tmp_path / "rec.csv").open() as file:
        header = next(row for row in csv.reader(file) if not row[0].startswith("#"))
    column = next(name for name in header if name.startswith("gyro_"))
    (tmp_path / "m.toml").write_text(MODEL % column)
    assert '"p_value"' in lab("compare", "rec.csv", "-m", "m.toml", "--json", status=(0, 1))


def test_the_workbench_has_its_planner_and_another_log_is_read(wheel, tmp_path):
    code = """
import numpy as np, davar
from davarlab.workbench import plans
print(plans.planner()['missing'], plans.programs.__file__)
options = {'sensor': 'icm42688@1000', 'core': 'cortex-m4f'}
print(plans.plan(**options)['subject'], len(plans.setup(**options)) > 1000)
t = np.arange(3000) / 200
np.savez('log.npz', time_s=t, gyro_x=np.sin(t), gyro_y=np.cos(t), gyro_z=np.sin(2 * t))
made = davar.read('log.npz')
print(round(made.rate_hz, 6), sorted(made.columns), len(made.time_s))
open('log.npz', 'wb').write(b'PK\\x03\\x04broken')
try:
    davar.read('log.npz')
except ValueError as why:
    print(why)
"""
    done = run(["-c", code], tmp_path, wheel.site)
    assert done.returncode == 0, done.stderr
    programs, planned, log, damaged = done.stdout.splitlines()
    assert programs == f"None {wheel.site}/planner/programs.py"
    assert planned == "1 axis of int16 at 1000 Hz (icm42688@1000) on a cortex-m4f True"
    columns = r"\['gyro_x_(dps|rad_s)', 'gyro_y_\w+', 'gyro_z_\w+', 'time_s'\]"
    assert re.fullmatch(rf"200\.0 {columns} 3000", log)
    assert damaged.startswith("log.npz: damaged")
