"""What a page may do to a recording and its steps: files that are dropped, sessions, actions that
come too late. No browser: the quick gear runs all of it.
"""

import gzip
import json

import pytest
from recordings_made import MODEL, dead_zone, effect, model_file, noise, simulated
from visiting import files_in, run


def test_nothing_but_the_page_is_served(opened):
    bench = opened()
    for name in (
        *("../server.py", "..%2fserver.py", "%2e%2e/server.py", "/etc/passwd", ""),
        *("parts/../../server.py", "parts", "nothing.js"),
    ):
        assert bench.request(f"/page/{name}")[0] == 404, name
    assert bench.request("/etc/passwd")[0] == 404
    status, text = bench.request("/")
    assert (status, b'<script src="/page/main.js"' in text) == (200, True)


@pytest.mark.parametrize(
    "name", ["../away.csv", "/tmp/away.csv", "a/b.csv", "..", ".hidden", "", "new\nline.csv"]
)
def test_a_dropped_file_stays_in_its_folder(folder, opened, name):
    status, answer = opened().drop(name, b"a,b\n1,2\n")
    assert (status, "not a name for a recording" in answer["error"]) == (400, True), answer
    assert files_in(folder) == set()


def test_another_file_of_the_same_name_takes_nothing_from_the_first(folder, opened):
    first, second = (
        noise(folder / f"{loud}.csv", "time_s,gyro_z_dps", rows=3000, sigma=0.1 * loud, seed=loud)
        for loud in (1, 20)
    )
    bench, seen = opened(), []
    for path in (first, second, first):
        status, answer = bench.drop("rec.csv", path.read_bytes())
        assert status == 200, answer
        seen.append((answer["recording"].rsplit("/")[-1], answer["steps"][0]["error"]))
    assert [name for name, _ in seen] == ["rec.csv", "rec-2.csv", "rec.csv"]
    assert seen[0] == seen[2]
    recent = bench.done("close")["recent"]  # the newest first
    assert [one["name"] for one in recent] == ["rec.csv", "rec-2.csv"]
    assert recent[0]["error"] == pytest.approx(seen[0][1], rel=1e-9)
    kept = folder / "davarlab-files/rec.csv"
    kept.write_bytes(second.read_bytes())
    done = run("open", "--no-browser", kept)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "another recording" in done.stderr


@pytest.mark.parametrize(
    "words", [("nowhere.csv",), ("-m", "model.toml"), ("--port", "70000")], ids=" ".join
)
def test_the_command_refuses_what_is_not_there(words):
    done = run("open", "--no-browser", *words)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr


@pytest.mark.slow
def test_a_dropped_file_is_not_kept_where_the_workbench_was_opened(folder, started):
    started.state /= "data"
    path = noise(started.state.parent / "rec.csv", "time_s,gyro_z_dps", rows=3000)
    bench = started()
    status, answer = bench.drop("rec.csv", path.read_bytes())
    assert status == 200, answer
    assert files_in(folder) == set()
    kept = started.state / "davarlab" / folder.relative_to("/") / "davarlab-files"
    assert answer["path"] == str(kept / "rec.csv")
    assert [one["name"] for one in bench.done("close")["recent"]] == ["rec.csv"]


def test_what_is_not_there_or_no_recording_is_refused_in_one_line(opened):
    bench = opened()
    for wanted, what, given in (
        (409, "go", {"number": 3}),  # of a recording that is not open, or not any more
        (409, "refit", {}),
        (400, "open", {"path": "nowhere.csv"}),
        (400, "listen", {"source": "can:nosuch0"}),
        (400, "listen", {"source": "slcan:/etc/passwd"}),
    ):
        status, answer = bench.act(what, **given)
        assert (status, "\n" in answer["error"]) == (wanted, False), (what, answer)
    assert bench.tried("step")[0] == 409
    for name, data in (
        ("photo.png", b"\x89PNG\r\n\x1a\n\0\0\0"),
        ("empty.csv", b""),
        ("words.csv", b"time_s,gyro_z_dps\n0,fast\n"),
        ("bytes.bin", b"\0\1\2garbage"),
        ("cut.csv.gz", gzip.compress(b"a,b\n1,2\n" * 1000)[:40]),
    ):
        status, answer = bench.drop(name, data)
        said = answer["error"]
        assert (status, name in said, "\n" in said) == (400, True, False)
        assert "/" not in said and "b'" not in said, said  # no path of the server, no literal


def test_a_selection_keeps_its_steps_and_nonsense_is_refused(folder, opened):
    recording = simulated(folder)
    bench = opened(recording)
    before = bench.ask("step")["error"]
    bench.done("selection", alone=[100.0, 400.0])
    for wrong in (
        {"alone": [5.0, 4.0]},
        {"alone": [0.0, 5.0]},
        {"alone": [0.0, 1e9]},
        {"cut": [[-1.0, 5.0]]},
        {"column": "temp_degC"},
        {"cut": [[1.0]]},
        {"cut": [[0.0, 900.0]]},
    ):
        status, answer = bench.act("selection", **wrong)
        assert (status, "\n" in answer["error"]) == (400, False), (wrong, answer)
    empty = bench.act("selection", alone=[6.0, 6.0])[1]["error"]
    assert empty.startswith("6 to 6 s is not a part of this recording: the start must be before")
    selections = bench.ask("all")["selections"]
    assert [one["alone"] for one in selections if one["here"]] == [[100.0, 400.0]]
    assert bench.tried("report")[0] == 400  # no command of a terminal has a stretch alone
    elsewhere = opened(recording)
    elsewhere.done("selection")
    assert "another process" in bench.act("refit")[1]["error"]
    elsewhere.done("selection", alone=[100.0, 400.0])
    again = opened(recording)
    assert again.ask("all")["samples"] == 15000
    again.done("selection")
    assert again.ask("step")["error"] == before


def test_numbers_of_a_recording_that_permits_no_model_are_withheld(folder, opened):
    bench = opened(dead_zone(folder / "dead.csv"))
    for what in ("toml", "h", "kalibr"):
        status, answer = bench.request(f"/api/save?what={what}")
        assert (status, b"dead zone" in answer) == (400, True), answer
    (recent,) = bench.done("close")["recent"]
    assert (recent["error"], recent["floor"]) == (None, None)


def test_a_doubtful_log_is_read_when_it_is_corrected_or_confirmed(folder, opened):
    path = noise(folder / "rec.csv", "time_s,gyro_z_dps", step=10000)
    bench = opened(path)
    waiting = bench.ask("all")
    assert waiting["recording"] is None
    assert "implausible sample rate 0.0001 Hz" in json.dumps(waiting["log"])
    assert "--unit time=us" in json.dumps(waiting["log"])
    columns = waiting["log"]["columns"]
    assert bench.done("read", columns=columns)["recording"] is None  # doubted again
    columns[0] |= {"unit": "us", "factor": 1e-6}
    bench.done("read", columns=columns)
    arw = bench.ask("step")["cards"][0]["parameters"][0]["value"]
    assert arw == pytest.approx(60 * 0.05 / 10, abs=0.02)
    again = opened(noise(folder / "other.csv", "time_s,gyro_z_dps", step=10000))
    again.done("read", columns=again.ask("all")["log"]["columns"], as_recorded=True)
    assert "--as-recorded" in again.ask("all")["commands"][0]
    assert opened("other.csv").ask("all")["samples"] == 6000  # the session has it


def test_a_guessed_tick_is_doubted_until_its_unit_is_another_or_confirmed(folder, opened):
    bench = opened(noise(folder / "rec.csv", "t,gyro_z_dps", step=100))
    columns = bench.ask("all")["log"]["columns"]
    for _ in range(2):
        assert "100 Hz in 0.1ms" in json.dumps(bench.ask("all")["log"]["doubts"])
        assert bench.done("read", columns=columns)["recording"] is None
    columns[0] |= {"unit": "0.1ms", "factor": 1e-4}
    bench.done("read", columns=columns)
    assert bench.ask("all")["rate_hz"] == pytest.approx(100)
    again = opened(noise(folder / "other.csv", "t,gyro_z_dps", rows=50_000, step=100))
    again.done("read", columns=again.ask("all")["log"]["columns"], as_recorded=True)
    assert opened("other.csv").ask("all")["rate_hz"] == pytest.approx(10_000)


def test_columns_that_the_name_of_the_file_calls_a_gyro(folder, opened):
    bench = opened(noise(folder / "gyro.csv", "time_ms,x,y,z", *[lambda i: 0.0] * 3, step=10))
    shown = bench.ask("all")["log"]
    assert "x, y, z: gyro by the file's name" in shown["said"]
    bench.done("read", columns=shown["columns"])
    assert bench.ask("all")["samples"] == 6000
    assert "--rename gyro_x=gyro_x_dps" in bench.ask("all")["commands"][0]


def test_columns_without_names_get_as_many_names_as_are_shown(folder, opened):
    """A blank name keeps the number of the column, and `_` skips it."""
    path = noise(folder / "rec.csv", "", *[lambda i: 0.0] * 3)
    path.write_text(path.read_text().lstrip("\n"))
    bench = opened(path)
    shown = [one["name"] for one in bench.ask("all")["log"]["columns"]]
    assert len(shown) == 4
    for wrong in (["time_s"], ["time_s", "gyro_z_dps", "_", "", "temp_degC"]):
        status, answer = bench.act("names", names=wrong)
        assert (status, answer["error"].count("\n")) == (400, 0)
        assert answer["error"].endswith(f": {len(wrong)} names for 4 columns")
    assert [one["name"] for one in bench.ask("all")["log"]["columns"]] == shown
    bench.done("names", names=["time_s", "gyro_z_dps", "_", " "])
    assert "--names time_s,gyro_z_dps,_,column_4" in bench.ask("all")["commands"][0]


def test_a_given_model_is_at_the_first_step(folder, opened):
    """Beside lines that are skipped."""
    path = folder / "rec.csv"
    noise(
        path, "# 100 Hz\na,b,c\ntime_s,gyro_z_dps,temp_degC", lambda i: 0, lambda i: 25, step=0.01
    )
    text = MODEL.replace("50.0", "100.0") + effect("rate_ramp", coefficient_deg_per_h2=40.0)
    bench = opened(path, model=str(model_file(folder, text)), skip=2)
    assert bench.ask("all")["samples"] == 6000
    kinds = [card["kind"] for card in bench.ask("step")["cards"]]
    assert kinds == ["angle_random_walk", "bias_instability", "rate_ramp"]
