"""davarlab's commands on recordings with known truth."""

import csv
import subprocess

import pytest
from asking import ROOT, run, said
from lab_bench import BASE, SENSOR


@pytest.mark.slow
def test_true_models_are_rejected_as_often_as_stated():
    """In full: tools/davarlab nulls."""
    words = ["--recordings", "120", "--seconds", "1200", "--first-seed", "5000", "--adequacy-only"]
    found = said("nulls", *words)
    shares = dict(zip(found["levels"], found["rejected"]["whole model"]))
    # binomial, 120 recordings: a miss at either end by chance is below 2 % for other seeds;
    # these are fixed
    assert 2 / 120 <= shares[0.05] <= 13 / 120, shares
    assert 24 / 120 <= shares[0.3] <= 50 / 120, shares


@pytest.mark.slow
def test_what_chance_gives_is_measured_for_every_candidate():
    found = said("nulls", "--recordings", 2, "--seconds", 600, "--jobs", 1)["candidates"]
    wanted = {"gauss_markov", "sinusoid", "noise_step", "temperature", "warm_up"}
    assert wanted <= set(found)


def test_export_says_what_it_leaves_out(lab):
    hot = '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.01\n'
    model, table = lab.file("hot.toml", SENSOR + BASE + hot), lab.work / "table.csv"
    assert run("export", model, "-o", table, "--tolerance", "0.1").returncode == 0
    assert "only stationary noise, ramp and lines: temperature" in table.read_text()
    assert table.read_text().endswith(",0.1\n")


def healths(lab, recording, model):
    """The health of the monitor of davar-sim with the exported table, window by window."""
    table = lab.work / f"{model.stem}.csv"
    assert run("export", model, "-o", table, "--window", "6000").returncode == 0
    words = "--column gyro_z_dps --window-max 6000 --law fixed --mode trailing --stride 6000"
    command = [ROOT / "tools/davar-sim", recording, *words.split(), "--model-table", table]
    done = subprocess.run(command, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(done.stdout.splitlines()))
    assert len(rows) == 30
    return [float(row["model_health"]) for row in rows], rows


@pytest.mark.slow
def test_a_hidden_effect_is_seen_on_the_device_and_gone_once_it_is_added(lab):
    effect = '[[effect]]\nkind = "gauss_markov"\nstd_dps = 0.008\ncorrelation_time_s = 6.0\n'
    recording, better = lab.simulated(effect), lab.work / "better.toml"
    before, rows = healths(lab, recording, lab.model)
    assert sum(number > 1 for number in before) > 0.9 * len(before)
    assert float(rows[-1]["model_deviation_512"]) > 2
    assert run("improve", recording, "-m", lab.model, "-o", better).returncode == 0
    assert "gauss_markov" in better.read_text()
    after, _ = healths(lab, recording, better)
    assert sum(number > 1 for number in after) <= 1
    assert after[-1] < 0.7


@pytest.mark.parametrize(
    "command", ["compare", "fit", "diagnose --report r.html", "improve", "plot -o p.png"]
)
def test_the_least_accepted_length_works_in_every_command(lab, monkeypatch, command):
    recording = lab.simulated(seconds=20)
    monkeypatch.chdir(lab.work)
    name, *more = command.split()
    done = run(name, recording, "-m", lab.model, *more)
    assert done.returncode in ((0, 1) if name in ("compare", "improve") else (0,)), done.stderr
    assert "Error" not in done.stderr
    if name == "plot":
        assert (lab.work / "p.png").read_bytes()[:4] == b"\x89PNG"
