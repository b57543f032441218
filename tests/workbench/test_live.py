"""A sensor on a serial line: what davar-sim sends over a pty is what it prints without one, as the
server has it, in the file beside it and on the page; stopping, ending and frozen samples.
"""

import csv
import io
import json
import os
import random
import signal
import subprocess
import time

import pytest
import senders
from davarlab.workbench import listening
from playwright.sync_api import expect
from recordings_made import FIRST, model_file, smoothed
from visiting import ROOT, run

SIM = os.environ["DAVAR_SIM"]
DEMO = (SIM, ROOT / "data/demo_disturbance.csv.gz", "--lsb", "0.001", "--stride", "100")
LIMIT_S = 600  # a busy machine is not a fault


def rows_of(text):
    return list(csv.DictReader(line for line in io.StringIO(text) if not line.startswith("#")))


def printed(*words):
    """The rows that davar-sim prints."""
    return rows_of(subprocess.run(words, text=True, capture_output=True, check=True).stdout)


def awaited(bench, wanted):
    """What the server has of its source, once `wanted` of it is true."""
    end = time.monotonic() + LIMIT_S
    while not wanted(found := bench.ask("live")):
        assert time.monotonic() < end
        time.sleep(0.05)
    return found


def heard(bench, source):
    """Everything that the server has of a source, once it has ended."""
    bench.done("listen", source=source)
    return awaited(bench, lambda live: live["ended"])


def kept(folder):
    """The rows of the results that were received, wherever below the folder they are."""
    (path,) = folder.rglob("davarlab-files/live.csv")
    return rows_of(path.read_text())


def close(value, relative):
    return pytest.approx(float(value), rel=relative)


def listens(page, source):
    page.fill("#source", source)
    page.click("#listen")
    return page


def test_what_is_sent_is_shown_and_kept(folder, opened, sender):
    bench = opened()
    process, source = sender(*DEMO, "--law", "glr")
    truth = {int(row["epoch"]): row for row in printed(*DEMO, "--law", "glr")}
    shown = heard(bench, source)["rows"]
    assert process.wait() == 0
    assert [row["epoch"] for row in shown] == sorted(truth)[-len(shown) :]
    for row in shown:
        wanted = truth[row["epoch"]]
        for name in ("window_samples", "arw_deg_per_sqrt_h", "adev_16"):
            assert row[name] == close(wanted[name], 1e-5), (name, row["epoch"])
        high, low = "arw_high_deg_per_sqrt_h", "arw_low_deg_per_sqrt_h"
        width = float(wanted[high]) - float(wanted[low])
        assert row[high] - row[low] == close(width, 2e-3), row["epoch"]
    assert [int(row["epoch"]) for row in kept(folder)] == sorted(truth)
    alarms = [row for row in shown if row["alarm"]]
    wanted = [row for row in truth.values() if row["alarm"] == "1"]
    assert len(wanted) > 1
    assert [row["epoch"] for row in alarms] == [int(row["epoch"]) for row in wanted]
    for row, want in zip(alarms, wanted, strict=True):
        for name in ("change_m", "cut_age_samples", "young"):
            assert row[name] == int(want[name])
        for name in ("change_older", "change_newer", "change_gain"):
            assert row[name] == close(want[name], 1e-5), (name, row["epoch"])
        assert row["dispersion"] == pytest.approx(float(want["dispersion"]), abs=0.006)
    # results, which no command takes for samples
    model = model_file(folder, FIRST.format(rate=10.0, column="gyro_x_dps"))
    done = run("compare", folder / "davarlab-files/live.csv", "-m", model)
    assert done.returncode == 2
    assert "live.csv:1: results of davar-sim or davarlab live" in done.stderr
    status, answer = bench.drop("live.csv", b"time_s,gyro_z_dps\n")
    assert status == 400, answer  # it would replace the file


class Sent:
    """A source that ends after 20 results."""

    def __init__(self, name, faults, say):
        self.name, self.may_come = name, True

    def frames(self, idle_s):
        self.may_come = False
        yield from senders.frames(senders.run(1, 20, session=7))

    def close(self):
        pass


def test_nobody_sees_that_a_source_has_ended_before_its_last_rows(folder, monkeypatch):
    seen = []

    class Asked(listening.Listening):
        def standing(self):
            found = super().standing()
            seen.append((found["ended"], sum(map(len, self.results.values()))))
            return found

    monkeypatch.setattr(listening, "Source", Sent)
    Asked("can:x", folder / "arw.csv", folder / "raw.csv", lambda **news: None).thread.join()
    assert (True, 20) in seen
    assert {rows for ended, rows in seen if ended} == {20}


def test_why_there_is_no_angle_random_walk(folder, opened, sender):
    recording = smoothed(folder / "smooth.csv")
    _, source = sender(SIM, recording, "--rate", "100", "--stride", "100")
    found = heard(opened(), source)
    assert {row["arw_withheld"] for row in kept(folder)} == {"filtered"}
    assert {row["arw_deg_per_sqrt_h"] for row in found["rows"]} == {None}


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ending_the_server_while_it_listens_keeps_what_came(folder, started, sender, number):
    _, source = sender(*DEMO, "--pace", "20")
    bench = started()
    bench.done("listen", source=source)
    awaited(bench, lambda live: live["rows"])
    status, said = bench.stop(number)
    lines = [line for line in said.splitlines() if "the workbench is open" not in line]
    assert (status, lines) == (0, [])
    rows = kept(started.state)
    assert len(rows) > 0
    assert len({len(row) for row in rows}) == 1
    assert None not in rows[-1].values()  # the last line is complete


@pytest.mark.slow
def test_raw_samples_are_frozen_while_more_come(folder, opened, sender):
    recording = folder / "sensor.csv"
    done = run("simulate", ROOT / "data/tutorial_sensor.toml", "-o", recording)
    assert done.returncode == 0, done.stderr
    words = (SIM, recording, "--lsb", "0.00001", "--stride", "600", "--raw", "--pace", "1000")
    _, source = sender(*words)
    bench = opened()
    bench.done("listen", source=source)
    awaited(bench, lambda live: live["rows"] and live["rows"][-1]["epoch"] >= 20000)
    assert bench.act("freeze", channel=5)[0] == 400
    bench.done("freeze", channel=0)
    assert bench.ask("step")["cards"]
    truth = [float(row["gyro_z_dps"]) for row in rows_of(recording.read_text())]
    rows = rows_of((folder / "davarlab-files/frozen.csv").read_text())
    assert len(rows) > 19000
    times = [n / 50 for n in range(len(rows))]
    assert [float(row["time_s"]) for row in rows] == pytest.approx(times, abs=1e-6)
    found = [float(row["gyro_x_dps"]) for row in rows]
    assert found == pytest.approx(truth[: len(rows)], abs=0.6e-5)
    assert bench.act("listen", source="elsewhere")[0] == 400  # the present source goes on
    assert not bench.ask("live")["ended"]


@pytest.mark.slow
def test_the_allan_curve_grows_to_a_day(folder, opened, sender):
    """Two days and a half: white noise, from five minutes on a walk."""
    recording, source, walk = folder / "days.csv", random.Random(1), 0.0
    lines = ["gyro_z_dps"]
    for _ in range(400_000):
        walk += source.gauss(0, 1.5e-4)
        lines.append(f"{walk + source.gauss(0, 0.05):.5f}")
    recording.write_text("\n".join(lines) + "\n")
    words = (
        *(SIM, recording, "--rate", "2", "--lsb", "0.0005", "--stride", "600"),
        *("--bandwidth", "none", "--longest-tau", "86400"),
    )
    truth = printed(*words, "--details")
    bench = opened()
    found = heard(bench, sender(*words, "--can-content", "intervals")[1])["curves"]["0"]
    sizes = [2**t for t in range(18)]  # to 18 h
    assert (found["m"], found["tau_s"]) == (sizes, [m / 2 for m in sizes])
    for t, m in enumerate(sizes):
        for name, column in (("adev", "adev"), ("low", "adev_low"), ("high", "adev_high")):
            if name != "adev" and m <= 64:  # of the window, by batches, which frames do not have
                assert found["low"][t] < found["adev"][t] < found["high"][t]
            elif found[name][t] is None:  # the last ones have too few differences for a limit
                assert m > 2**15
            else:
                assert found[name][t] == close(truth[-1][f"{column}_{m}"], 2e-3), (name, m)
    for row, wanted in zip(kept(folder), truth, strict=True):
        for m in sizes:
            assert bool(row[f"adev_{m}"]) == bool(wanted[f"adev_{m}"])
            if row[f"adev_{m}"]:
                assert float(row[f"adev_{m}"]) == close(wanted[f"adev_{m}"], 1e-6)


def test_the_screen_shows_what_the_server_has(opened, sender, tabs):
    _, source = sender(*DEMO, "--law", "glr", "--longest-tau", "110")
    bench = opened()
    page = listens(tabs.open(bench), source)
    expect(page.locator("#live-state")).to_contain_text("ended")
    found = bench.ask("live")
    rows, curve = found["rows"], found["curves"]["0"]
    last, alarms = rows[-1], [row for row in rows if row["alarm"]]
    expect(page.locator("#live-epoch")).to_have_text(str(last["epoch"]))
    arw = float(page.inner_text("#live-arw").split()[1])
    assert arw == close(last["arw_deg_per_sqrt_h"], 1e-3)
    drawn = json.loads(page.get_attribute("#live-chart", "data-arw"))
    assert drawn == [row["arw_deg_per_sqrt_h"] for row in rows]
    assert int(page.get_attribute("#live-chart", "data-alarms")) == len(alarms)
    expect(page.locator("#live-changed")).to_contain_text(
        f"noise changed at epoch {alarms[-1]['epoch']}"
    )
    expect(page.locator("#live-surface image")).to_have_count(1)
    values = [value for value in curve["adev"] if value is not None]
    points = page.locator("#live-curve circle")
    expect(points).to_have_count(len(values))
    height = [float(points.nth(at).get_attribute("cy")) for at in range(len(values))]
    downwards = [at for _, at in sorted(zip(values, height), reverse=True)]
    assert downwards == sorted(downwards)  # two close values may share a height
    durations = {2e-6: "2 µs", 0.01: "10 ms", 0.9999: "1 s", 59.4: "59.4 s", 60: "1 min"}
    durations |= {5400: "1.5 h", 86400: "1 d", 2**31 / 100: "249 d"}
    said = "(s) => import('/page/words.js').then((m) => m.duration(s))"
    for seconds, words in durations.items():
        assert page.evaluate(said, seconds) == words
    page.reload()
    expect(page.locator("#live-epoch")).to_have_text(str(last["epoch"]))
    page.click("#stop_listening")
    expect(page.locator("#live")).to_be_hidden()


def test_the_screen_says_why_there_is_no_number(folder, opened, sender, tabs):
    recording = smoothed(folder / "smooth.csv")
    _, source = sender(SIM, recording, "--rate", "100", "--stride", "100")
    page = listens(tabs.open(opened()), source)
    expect(page.locator("#live-arw")).to_have_text("ARW absent")
    expect(page.locator("#live-why")).to_contain_text("(filtered): the short cluster sizes")
    expect(page.locator("#live-why")).to_contain_text("--bandwidth HZ[:ORDER]")


def test_a_sender_that_goes_on_is_frozen_and_stopped(opened, sender, tabs):
    page = listens(tabs.open(opened()), sender(*DEMO, "--pace", "5")[1])
    expect(page.locator("#live-epoch")).to_be_visible()
    page.click("#freeze")
    expect(page.locator("#freeze")).to_have_text("Resume")
    frozen = page.inner_text("#live-epoch")
    for _ in range(2):  # more came to this page
        before = page.get_attribute("#live", "data-count")
        expect(page.locator("#live")).not_to_have_attribute("data-count", before)
    assert page.inner_text("#live-epoch") == frozen
    page.click("#freeze")
    expect(page.locator("#live-epoch")).not_to_have_text(frozen)
    page.click("#tutorial")  # a recording beside it
    expect(page.locator("#headline h1")).to_be_visible()
    page.click("#tab-live")
    expect(page.locator("#live")).to_be_visible()
    page.click("#stop_listening")
    expect(page.locator("#live")).to_be_hidden()
