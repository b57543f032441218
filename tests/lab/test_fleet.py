"""davarlab fleet from outside: the table against fit and diagnose, a second run, a killed one, HTTP
and S3, limits, and what a population shows: the same whatever the machine is busy with, and to nine
digits on other processors.
"""

import contextlib
import json
import multiprocessing
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from asking import ROOT, run, said
from lab_bench import FLEET
from serving import serving

N = "angle_random_walk.coefficient_deg_per_sqrt_h"
# of the small fleet: shorter recordings, so a larger effect is as hard to see in one
SECONDS, UNITS, EFFECT = 600.0, 48, 0.0015
INTERRUPTED = 8  # recordings of a run that is ended behind the second
ENVIRONMENT = {
    "PYTHONPATH": str(ROOT / "python"),
    "AWS_ACCESS_KEY_ID": "a",
    "AWS_SECRET_ACCESS_KEY": "b",
    "AWS_DEFAULT_REGION": "us-east-1",
}
ALONE = ("--chance", 0, "--workers", 1)


def fleet(*arguments, **more):
    """A run in this process, its workers in others: libraries are loaded once."""
    with mock.patch.dict(os.environ, {**ENVIRONMENT, **more}):
        return run("fleet", *arguments)


def table(folder):
    return pq.read_table(Path(folder) / "fleet.parquet").to_pylist()


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small fleet, made once, and its model."""
    sys.path.insert(0, str(ROOT / "data"))
    import make_fleet

    top = tmp_path_factory.mktemp("fleet")
    (top / "model.toml").write_text(FLEET)
    make_fleet.make(top / "units", UNITS, EFFECT, SECONDS)
    return SimpleNamespace(top=top, model=top / "model.toml")


@pytest.fixture
def some(made, tmp_path):
    """A folder of its own with the first so many recordings."""

    def copied(count):
        folder = tmp_path / f"some{count}"
        folder.mkdir()
        for path in sorted((made.top / "units").glob("A_*"))[:count]:
            shutil.copy(path, folder)
        return folder

    return copied


@pytest.fixture(scope="module")
def population(made):
    units = made.top / "units"
    (units / "A_9998.parquet").write_bytes(b"PAR1 and no more")
    (units / "B_9999.csv").write_text("time_s,gyro_z_dps\n0,1\n")
    limits, out = made.top / "limits.toml", made.top / "out"
    limits.write_text(f'[[limit]]\ncoefficient = "{N}"\nmax = 0.33\nmin = 0.1\n')
    words = ["-m", made.model, "--batch", r"([AB])_\d+", "--limits", limits, "--json"]
    done = fleet(units / "*", *words, "-o", out)
    return SimpleNamespace(
        **{"units": units, "out": out, "words": words, "done": done, "model": made.model},
        said=json.loads(done.stdout),
    )


# One run of the population takes 20 s of work.


@pytest.mark.slow
def test_the_hidden_effect_is_found_and_named_in_its_batch_only(population):
    hidden = population.said["hidden"]
    assert [(one["batch"], one["kind"]) for one in hidden if one["named"]] == [("B", "temperature")]
    assert {one["batch"] for one in hidden if one["found"]} == {"B"}
    alone = population.said["named_alone"]["B"].get("temperature", 0)
    assert alone < UNITS / 2 / 4, "a single recording shows it: nothing is hidden"
    assert population.done.returncode == 1
    page = (population.out / "fleet.html").read_text()
    assert "Batch B as a whole has an effect that the model lacks: temperature." in page
    assert "A_<wbr>9998.parquet" in page
    assert "<script" not in page
    assert re.findall(r'(?:src|href)="(?!data:)[^"]*', page) == []
    assert json.loads((population.out / "fleet.json").read_text())["rows"] == UNITS


@pytest.mark.slow
@pytest.mark.parametrize("name", ["A_0000", "B_0001"])
def test_a_row_says_what_fit_and_diagnose_say(population, name):
    path = str(population.units / f"{name}.parquet")
    row = next(row for row in table(population.out) if row["file"] == path)
    fitted = said("fit", path, "-m", population.model)
    for effect in fitted["effects"]:
        for parameter, one in effect["parameters"].items():
            column = f"{effect['kind']}.{parameter}"
            numbers = [row[column], row[column + ".low"], row[column + ".high"]]
            assert numbers == [one["value"], one["low"], one["high"]]
    assert row["adequacy"] == fitted["adequacy"]
    told = said("diagnose", path, "-m", population.model)
    assert row["verdict"] == told["verdict"]
    temperature = next(one for one in told["candidates"] if one["kind"] == "temperature")
    assert row["gain.temperature"] == pytest.approx(max(temperature["gain"], 0), abs=5e-7)
    columns = pq.read_table(path).to_pydict()
    assert row["temperature_degC"] == pytest.approx(np.mean(columns["temp_degC"]), abs=5e-7)
    assert row["start"].timestamp() == pytest.approx(columns["time_s"][0], abs=5e-4)
    assert (row["batch"], row["samples"]) == (name[0], 12000)
    assert row["rate_hz"] == pytest.approx(20.0, abs=5e-7)
    assert re.fullmatch(r"\d+\.\d+\.\d+", row["davar"])
    assert row["table_version"] == 2


@pytest.mark.slow
def test_a_file_that_cannot_be_used_is_a_row_with_its_reason(population):
    rows = [row for row in table(population.out) if row["failed"]]
    assert [Path(row["file"]).name for row in rows] == ["A_9998.parquet", "B_9999.csv"]
    assert "damaged, or not Parquet" in rows[0]["failed"]
    assert {row["verdict"] for row in rows} == {None}


@pytest.mark.slow
def test_the_limits_say_pass_and_fail_as_the_intervals_do(population):
    for row in (row for row in table(population.out) if not row["failed"]):
        fails = row[N + ".low"] > 0.33 or row[N + ".high"] < 0.1
        assert row["limits"] == ("fail" if fails else "pass")
    judged = population.said["limits"]
    assert judged["pass"] + judged["fail"] == UNITS
    assert [one["limit"] for one in judged["stated"]] == [f"{N} >= 0.1", f"{N} <= 0.33"]


def load(seed):
    rng = random.Random(seed)
    while True:
        sum(range(10**6))
        time.sleep(rng.uniform(0, 0.05))


@contextlib.contextmanager
def busy():
    """Twice as many processes as processors that count and sleep in irregular turns."""
    fork = multiprocessing.get_context("fork").Process
    others = [fork(target=load, args=(k,), daemon=True) for k in range(2 * os.cpu_count())]
    for one in others:
        one.start()
    try:
        yield
    finally:
        for one in others:
            one.kill()
            one.join()


def repeated(population, out, files, *more, **environment):
    """(rows, what --json says) of a run of its own; and of the population, without places and what
    was spent."""
    words = [*files, *population.words, "-o", out, *more]
    command = [sys.executable, "-B", "-m", "davarlab", "fleet", *map(str, words)]
    done = subprocess.run(
        command, env={**os.environ, **ENVIRONMENT, **environment}, text=True, capture_output=True
    )
    assert done.returncode == 1, done.stderr

    def plain(folder, said, out):
        rows = [
            {**row, "file": Path(row["file"]).name, "seconds": None, "failed": bool(row["failed"])}
            for row in table(out)
        ]
        said = json.loads(said.replace(f"{folder}/", ""))
        return sorted(rows, key=lambda row: row["file"]), {**said, "done_now": None}

    return (
        plain(files[0].parent, done.stdout, out),
        plain(population.units, population.done.stdout, population.out),
    )


@pytest.mark.slow
def test_the_same_with_other_workers_order_threads_folder_and_load(population, tmp_path):
    shutil.copytree(population.units, tmp_path / "second")
    files = sorted((tmp_path / "second").iterdir())
    random.Random(5).shuffle(files)
    threads = {f"{name}_NUM_THREADS": "4" for name in ("OPENBLAS", "OMP", "MKL")}
    with busy():
        found, first = repeated(
            population, tmp_path / "out", files, "--workers", 5, PYTHONHASHSEED="77", **threads
        )
    for one, other in zip(found, first):  # to the last digit; NaN is itself
        assert json.dumps(one, sort_keys=True, default=str) == json.dumps(
            other, sort_keys=True, default=str
        )


@pytest.mark.soak
def test_other_processors_say_the_same_in_nine_digits(population, tmp_path):
    """Their last digits are not the same: a product and a sum in one step round once. A
    log-likelihood of some 10 000 units has nine digits to 1e-5. What is decided is the same.
    """
    if "openblas" not in np.show_config(mode="dicts")["Build Dependencies"]["blas"]["name"]:
        pytest.skip("its linear algebra has no kernels to choose from")
    files = sorted(population.units.iterdir())
    found, first = repeated(population, tmp_path / "out", files, OPENBLAS_CORETYPE="Prescott")
    for one, other in zip(found[0], first[0], strict=True):
        assert one.keys() == other.keys()
        for name, value in one.items():
            if isinstance(value, float):
                loose = name.startswith(("gain.", "chance."))
                off = 1e-5 if loose else 1e-9 * abs(value) + 1e-15
                assert abs(value - other[name]) <= off or value != value, (one["file"], name)
            else:
                assert value == other[name], (one["file"], name)
    names = ("batch", "kind", "found", "named", "alternatives")
    decided = [
        sorted([str(one[name]) for name in names] for one in said["hidden"])
        + [said["verdicts"], said["adequacy"]]
        for _, said in (found, first)
    ]
    assert decided[0] == decided[1]


@pytest.mark.slow
def test_a_second_run_does_nothing_and_a_changed_file_is_done_again(made, some):
    folder = some(3)
    words = (folder / "*.parquet", "-m", made.model, "-o", folder / "out", *ALONE)
    assert "0 finished, 3 remaining" in fleet(*words).stderr
    before = (folder / "out/fleet.parquet").read_bytes()
    assert "3 recordings: 3 finished, 0 remaining" in fleet(*words).stderr
    assert (folder / "out/fleet.parquet").read_bytes() == before
    os.utime(folder / "A_0000.parquet")
    assert "2 finished, 1 remaining" in fleet(*words).stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "number, status",
    [
        (signal.SIGINT, 130),
        pytest.param(signal.SIGKILL, -signal.SIGKILL, marks=pytest.mark.soak),
    ],
)
def test_a_run_that_was_ended_goes_on(made, some, number, status):
    folder = some(INTERRUPTED)
    out = folder.with_name("out")
    words = [folder / "*", "-m", made.model, "-o", out, *ALONE]
    started = subprocess.Popen(
        [sys.executable, "-B", "-m", "davarlab", "fleet", *map(str, words)],
        env={**os.environ, **ENVIRONMENT},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        while len(list((out / "units").glob("*.json") if out.exists() else [])) < 2:
            assert started.poll() is None, "it ended by itself"
            time.sleep(0.01)
        end = os.kill if number == signal.SIGKILL else os.killpg
        end(started.pid, number)
        told = started.communicate()[1]
    finally:
        with contextlib.suppress(ProcessLookupError):  # nothing of a run is left
            os.killpg(started.pid, signal.SIGKILL)
    assert started.returncode == status, told
    assert "Traceback" not in told
    there = [json.loads(path.read_text()) for path in (out / "units").glob("*.json")]
    assert len(there) < INTERRUPTED
    assert not (out / "fleet.parquet").exists()
    again = fleet(*words)
    assert again.returncode == 0, again.stderr
    assert f"{len(there)} finished, {INTERRUPTED - len(there)} remaining" in again.stderr
    assert len(table(out)) == INTERRUPTED


@pytest.mark.slow
def test_http_and_s3_with_a_glob(made, some):
    folder = some(3)
    (folder / "other.txt").write_text("no recording")
    out = folder.with_name("out")
    with serving(folder.parent) as server:
        site = f"http://127.0.0.1:{server.server_port}"
        words = [f"{site}/{folder.name}/A_*.parquet", "-m", made.model, "-o", out, *ALONE]
        done = fleet(f"{site}/gone.parquet", *words)
        failed = [bool(row["failed"]) for row in table(out)]
        assert (done.returncode, failed) == (1, [True, False, False, False]), done.stderr
        server.fetched.clear()
        again = fleet(*words)
        assert "3 recordings: 3 finished, 0 remaining" in again.stderr
        assert again.returncode == 0
        assert not [name for name in server.fetched if name.startswith("A_")]
        words[0], words[4] = f"s3://{folder.name}/A_*.parquet", folder.with_name("out of s3")
        done = fleet(*words, AWS_ENDPOINT_URL=site)
        assert (done.returncode, len(table(words[4]))) == (0, 3), done.stderr
        assert table(words[4])[0]["file"].startswith("s3://")


@pytest.mark.slow
def test_the_workers_of_a_scheduler_that_is_there(made, some):
    from dask import distributed

    how = {"dashboard_address": "127.0.0.1:0", "host": "127.0.0.1", "protocol": "tcp"}
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, **how
    ) as cluster:
        folder = some(2)
        words = (folder / "*.parquet", "-m", made.model, "-o", folder / "out", "--chance", 0)
        done = fleet(*words, "--scheduler", cluster.scheduler_address)
        assert (done.returncode, len(table(folder / "out"))) == (0, 2), done.stderr


@pytest.mark.slow
def test_all_axes_of_a_log(made, tmp_path):
    rng = np.random.default_rng(4)
    columns = {
        "time_s": np.arange(12000) / 20.0,
        "gyro_x_dps": rng.normal(0, 0.02, 12000),
        "gyro_y_dps": rng.normal(0, 0.04, 12000),
        "accel_x_g": rng.normal(0, 0.001, 12000),
    }
    log, out = tmp_path / "log.parquet", tmp_path / "out"
    pq.write_table(pa.table(columns), log)
    done = fleet(log, "-m", made.model, "-o", out, "--axes", "all", *ALONE)
    rows = table(out)
    axes = ["gyro_x_dps", "gyro_y_dps", "accel_x_g"]
    assert [row["axis"] for row in rows] == axes, done.stderr
    in_file = 60 / 20**0.5
    assert [row[N] for row in rows[:2]] == pytest.approx([0.02 * in_file, 0.04 * in_file], rel=0.05)
    velocity = rows[2]["velocity_random_walk.coefficient_m_per_s_per_sqrt_h"]
    assert velocity == pytest.approx(9.80665e-3 * in_file, rel=0.05)
    assert rows[2][N] is None


WRONG = [
    (["nothing_*.csv"], "", "nothing_*.csv: no such file"),
    (["--batch", "("], "", "--batch ("),
    (["--limits", "W"], "[[limit]]\nmax = 1\n", "limit 1: a limit needs coefficient"),
    (["--limits", "W"], '[[limit]]\ncoefficient = "x.y"\n', "limit 1: a limit needs min or max"),
    (["--limits", "W"], "at_limit = 0.7\n", "at_limit = 0.7 is outside"),
    (["--limits", "W"], "", "no [[limit]]"),
    (["--limits", "W"], '[[limit]]\ncoefficient = "x.y"\nmax = 1\n', "x.y: no unit has it"),
    (["gopher://x/y*"], "", "gopher"),
    (["--workers", "0"], "", "--workers"),
]


@pytest.mark.slow
def test_every_mistake_is_one_line_and_status_2(made, some):
    folder = some(1)
    wrong, out = folder.with_name("wrong.toml"), folder.with_name("out")
    words = (folder / "*", "-m", made.model, "-o", out)
    fleet(*words, *ALONE)
    for more, text, why in WRONG:
        wrong.write_text(text)
        given = [wrong if one == "W" else one for one in more]
        done = run("fleet", words[0], *given, *words[1:], "--chance", 0)
        assert done.returncode == 2, done.stderr
        assert why in done.stderr.splitlines()[-1]
    wrong.write_text("")
    assert run("fleet", *words[:-1], wrong).returncode == 2
