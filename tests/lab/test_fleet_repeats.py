"""A fleet says the same whatever the machine is busy with: workers, order, folder, load, threads,
hash seed; and to nine digits on other processors.
"""

import contextlib
import json
import multiprocessing
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import lab_bench
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from asking import ROOT

pytestmark = pytest.mark.slow

UNITS, SECONDS, EFFECT = 16, 100.0, 0.04
FEATURES = {  # from the widest vectors to the narrowest
    "SkylakeX": {"avx512f", "avx512vl"},
    "Haswell": {"avx2", "fma"},
    "Zen": {"avx2", "fma"},
    "Sandybridge": {"avx"},
    "Prescott": {"pni"},
}


def load(seed):
    rng = random.Random(seed)
    while True:
        sum(range(10**6))
        time.sleep(rng.uniform(0, 0.05))


@contextlib.contextmanager
def busy():
    """Twice as many processes as processors that count and sleep in irregular turns."""
    others = [
        multiprocessing.get_context("fork").Process(target=load, args=(seed,), daemon=True)
        for seed in range(2 * os.cpu_count())
    ]
    for one in others:
        one.start()
    try:
        yield
    finally:
        for one in others:
            one.kill()
            one.join()


def cores():
    """Those of OpenBLAS's kernels that this processor has; none where its linear algebra is
    another.
    """
    if "openblas" not in np.show_config(mode="dicts")["Build Dependencies"]["blas"]["name"]:
        return []
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    flags = set(next((line for line in lines if line.startswith("flags")), "").split())
    return [core for core, needed in FEATURES.items() if needed <= flags]


class Fleet:
    def __init__(self, top):
        sys.path.insert(0, str(ROOT / "data"))
        import make_fleet

        self.top = top
        (top / "model.toml").write_text(lab_bench.FLEET)
        make_fleet.make(top / "first", UNITS, EFFECT, SECONDS)
        # units that show what they lack by themselves, two of them of a kind that is hard to tell
        for place in range(4):
            rng, count = np.random.default_rng(place), 3000
            hum = 0.01 * np.sin(2 * np.pi * 1.3 * np.arange(count) / 20)
            walk = np.cumsum(rng.normal(0, 0.001, count))
            columns = {
                "time_s": 1e6 + np.arange(count) / 20,
                "gyro_z_dps": rng.normal(0, 0.02, count) + (hum if place % 2 else walk),
                "temp_degC": 25 + np.cumsum(rng.normal(0, 0.02, count)),
            }
            pq.write_table(pa.table(columns), top / f"first/{'AB'[place % 2]}_9{place:03d}.parquet")
        self.names = sorted(path.name for path in (top / "first").iterdir())
        self.first = self.run("first", self.names, 2)

    def run(self, folder, names, workers, **more):
        """(rows by file without what was spent on them, what --json says of the population)."""
        out = Path(tempfile.mkdtemp(dir=self.top))
        files = [self.top / folder / name for name in names]
        words = ["-m", self.top / "model.toml", "-o", out, "--batch", r"([AB])_\d+"]
        command = [sys.executable, "-B", "-m", "davarlab", "fleet", *files, *words]
        command += ["--workers", str(workers), "--json"]
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "tools/lab"), **more}
        done = subprocess.run(command, env=environment, text=True, capture_output=True)
        assert done.returncode == 1, done.stderr
        said = json.loads(done.stdout.replace(f"{self.top / folder}/", ""))
        rows = [
            {**row, "file": Path(row["file"]).name, "seconds": None}
            for row in pq.read_table(out / "fleet.parquet").to_pylist()
        ]
        return sorted(rows, key=lambda row: row["file"]), {**said, "done_now": None}


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    return Fleet(tmp_path_factory.mktemp("fleet"))


def assert_same(found, expected):
    """To the last digit; NaN is itself."""
    assert repr([sorted(row.items()) for row in found[0]]) == repr(
        [sorted(row.items()) for row in expected[0]]
    )
    assert json.dumps(found[1], sort_keys=True) == json.dumps(expected[1], sort_keys=True)


def test_the_fleet_is_worth_repeating(fleet):
    rows, said = fleet.first
    named = [one for one in said["hidden"] if one["named"]]
    assert "B" in [one["batch"] for one in named]
    assert any(one["alternatives"] for one in named)
    assert len(said["verdicts"]) > 2
    assert any(row["alternatives"] for row in rows)


def test_the_same_with_other_workers_order_threads_folder_and_load(fleet):
    names = list(fleet.names)
    random.Random(5).shuffle(names)
    threads = {f"{name}_NUM_THREADS": "4" for name in ("OPENBLAS", "OMP", "MKL")}
    shutil.copytree(fleet.top / "first", fleet.top / "elsewhere/second")
    with busy():
        found = fleet.run("elsewhere/second", names, 5, PYTHONHASHSEED="77", **threads)
    assert_same(found, fleet.first)


@pytest.mark.soak
def test_other_processors_say_the_same_in_nine_digits(fleet):
    """Their last digits are not the same: a product and a sum in one step round once. A
    log-likelihood of some 10 000 units has nine digits to 1e-5. What is decided is the same.
    """
    others = cores()
    if len(others) < 2:
        pytest.skip("this processor, or its linear algebra, has one kernel of OpenBLAS")
    rows, said = fleet.run("first", fleet.names, 2, OPENBLAS_CORETYPE=others[-1])
    for one, other in zip(fleet.first[0], rows, strict=True):
        assert_close(one, other, one["file"])
    assert decided(said) == decided(fleet.first[1])


def decided(said):
    names = ("batch", "kind", "found", "named", "alternatives")
    hidden = [{name: one[name] for name in names} for one in said["hidden"]]
    hidden.sort(key=lambda one: (one["batch"], one["kind"]))
    return hidden, said["verdicts"], said["adequacy"]


def assert_close(one, other, where):
    assert one.keys() == other.keys()
    for name, value in one.items():
        if isinstance(value, float):
            loose = name.startswith(("gain.", "chance."))
            off = 1e-5 if loose else 1e-9 * abs(value) + 1e-15
            assert abs(value - other[name]) <= off or value != value, (where, name)
        else:
            assert value == other[name], (where, name)
