"""davarlab live on a serial line; the test is the other end. Senders restart, and runs follow each
other. tests/kernel/test_live.py tests interfaces and lines that disappear and return.
"""

import csv
import json
import os
import re
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest
from davar.wire import frames as wire
from davar.wire import live, withheld
from senders import ROOT, frames, joined, raw_pty, run, sealed, slcan

MARK = 9  # the channel of the last frames: if it is shown, everything before them has been read


def without_arw(result, reason):
    """The frames of a result, its ARW absent for a reason of davar_noise_t; 0: none is sent."""
    arw, end = (next(one for one in result if one[0] & 15 == kind) for kind in (0, 11))
    body = (65535 - reason).to_bytes(2, "little") + bytes.fromhex("0000C07F")
    new = sealed(arw[0], body, arw[1][1])
    total = int.from_bytes(end[1][4:], "little") - wire.digest(*arw) + wire.digest(*new)
    last = sealed(end[0], end[1][2:4] + (total % 2**32).to_bytes(4, "little"), end[1][1])
    changed = {arw: new, end: last}
    return [changed.get(frame, frame) for frame in result]


def play(ours, sent):
    heard = b""
    while b"O\r" not in heard:
        heard += os.read(ours, 100)
    data = memoryview(slcan(sent))
    while data:
        data = data[os.write(ours, data[:1000]) :]


@pytest.fixture
def listen(tmp_path):
    def run_live(sent, record=tmp_path / "arw.csv"):
        """Sends frames to davarlab live, then disconnects: the lines shown, what it told, and the
        number of lines with those of channel MARK.
        """
        ours, its, name = raw_pty()
        words = ["live", f"slcan:{name}", "--record", str(record), "--json"]
        process = subprocess.Popen(
            [sys.executable, "-B", "-m", "davarlab", *words],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        told, shown = [], []
        sent = [*sent, *frames(run(99, 2, session=1, channel=MARK))]
        teller = threading.Thread(target=lambda: told.extend(process.stderr))
        writer = threading.Thread(target=play, args=(ours, sent))
        teller.start()
        writer.start()
        for line in process.stdout:
            shown.append(json.loads(line))
            if shown[-1]["channel"] == MARK and its is not None:
                writer.join()
                os.close(its)
                os.close(ours)
                its = None
        teller.join()
        assert process.wait() == 0, told
        process.stdout.close()
        process.stderr.close()
        mine = [one for one in shown if one["channel"] != MARK]
        return SimpleNamespace(shown=mine, told="".join(told), all_shown=len(shown))

    def rows(name="arw.csv"):
        with open(tmp_path / name, encoding="utf-8") as file:
            return [row for row in csv.DictReader(file) if row["channel"] != str(MARK)]

    run_live.rows, run_live.record = rows, tmp_path / "arw.csv"
    run_live.keys = lambda name="arw.csv": [
        (int(row["stretch"]), int(row["epoch"])) for row in rows(name)
    ]
    return run_live


def epochs(sections, number):
    return [(stretch, 100 * n + 99) for stretch in sections for n in range(number)]


def test_a_restart_is_reported_and_begins_a_new_section(listen):
    done = listen(frames(run(1, 60, session=7)) + frames(run(2, 60, session=7)))
    new = "channel 0: the sender has been restarted: a new section begins with epoch 99\n"
    assert done.told.count(f"davarlab live: {new}") == 1
    assert " 0 orphaned," in done.told
    assert " 1 restarts" in done.told
    assert listen.keys() == epochs((1, 2), 60)
    assert [(one["stretch"], one["epoch"]) for one in done.shown] == listen.keys()
    assert "" not in [row["time_s"] for row in listen.rows()]
    assert [*listen.rows()[0]][-4:] == ["adev_1", "adev_2", "adev_4", "adev_8"]


@pytest.mark.slow
def test_a_later_run_continues_and_a_row_broken_by_a_power_cut_is_removed(listen):
    one = frames(run(1, 20, session=7))
    for _ in range(2):
        listen(one)
    assert listen.keys() == epochs((1, 2), 20)
    assert listen.record.read_text().count("epoch") == 1
    whole = listen.record.read_bytes()
    for cut in (len(whole) - 1, len(whole) - 30):
        listen.record.write_bytes(whole[:cut])
        before = len(whole[:cut].splitlines()) - 2  # without the header and the broken row
        done = listen(one)
        assert len(listen.record.read_text().splitlines()) - 1 == before + done.all_shown
        assert len(listen.keys()) == len(set(listen.keys()))
        assert listen.record.read_bytes().startswith(whole[: whole.rindex(b"\n", 0, -1) + 1])


def test_a_file_with_other_columns_stays_unchanged(listen):
    for there in (b"time_s,gyro_z_dps\n0,1\n0.1,2", b"\x00" * 100):
        listen.record.write_bytes(there)
        done = listen(frames(run(1, 20, session=7)))
        assert (len(done.shown), listen.record.read_bytes()) == (20, there)
        assert "arw.csv: exists with other columns. Recording to " in done.told
    assert len(set(listen.keys("arw-2.csv"))) == 40


def test_a_device_that_is_always_full(listen):
    done = listen(frames(run(1, 20, session=7)), "/dev/full")
    assert len(done.shown) == 20
    why = "/dev/full: No space left on device: results are shown, but not recorded\n"
    assert why in done.told
    assert f"/dev/full: {done.all_shown} results not recorded\n" in done.told


CODES = {code: [code] * 60 for code in range(6)}  # of each result
CODES["chance"] = [2 if n in (25, 59) else 0 for n in range(60)]
QUICK = (3, "chance")


@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=[] if kind in QUICK else [pytest.mark.slow]) for kind in CODES],
)
def test_why_arw_is_absent_is_shown_recorded_and_explained_once(listen, kind):
    """What chance withholds is only shown. A rate of zero is rejected and counted."""
    zero = sealed(0x5D6, bytes([0, 7, 0, 0, 0, 0]))
    sent = joined(map(without_arw, run(1, 60, session=7).results[:-1], CODES[kind]))
    done = listen([*sent[:100], zero, *sent[100:]])
    reasons = [("", "", "mixed", "constant", "coarse", "filtered")[code] for code in CODES[kind]]
    assert [row["arw_withheld"] for row in listen.rows()] == reasons
    assert [line.get("arw_withheld", "") for line in done.shown] == reasons
    assert {row["arw_relative_uncertainty"] for row in listen.rows()} == {""}
    told = re.findall(r"channel 0: no angle random walk \((.*)\): ", done.told)
    assert told == ([reasons[0]] if reasons[0] else [])
    assert " 1 impossible," in done.told


def test_a_line_names_the_reason_and_the_slow_terms():
    values = {"channel": 0, "epoch": 9, "arw_deg_per_sqrt_h": None, "window_samples": 600}
    assert "ARW       absent deg" in live.line(values)
    for reason in withheld.REASONS:
        assert f"ARW       absent ({reason}) deg" in live.line(values | {"arw_withheld": reason})
    values |= {"arw_deg_per_sqrt_h": 0.3}
    plain = live.line(values | {"bi_deg_per_h": None})
    assert plain.endswith("window 600")
    said = live.line(values | {"bi_deg_per_h": 5.125, "rrw_deg_per_h_per_sqrt_h": 12.0})
    assert said == plain + "  BI 5.125 deg/h  RRW 12 deg/h/sqrt(h)"


def test_davar_sim_gives_the_same_reasons_with_the_same_limit():
    source = re.sub(r'"\s*"', "", (ROOT / "host_sim/output/report.c").read_text())
    hidden = (
        "the noise, or its step from sample to sample, is below half a count, so rounding hides"
    )
    low = "the short cluster sizes read low, as after a low-pass"
    for reason, text in (("filtered", low), ("coarse", hidden)):
        assert text in source
        assert withheld.REASONS[reason].startswith(text)
    assert f"#define FEW {withheld.FEW}U" in source


def test_the_program_of_the_page_prints_every_result():
    page = (ROOT / "docs/STREAMS.md").read_text()
    (program,) = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    ours, its, name = raw_pty()
    program = program.replace("can:vcan0", f"slcan:{name}").replace("idle_s=60", "idle_s=1")
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    play(ours, frames(run(99, 20, session=1, channel=3)))
    out, _ = process.communicate()
    for end in (ours, its):
        os.close(end)
    rows = [line.split() for line in out.splitlines()[:-1]]
    assert [row[:2] for row in rows] == [["3", f"{100 * n + 99}"] for n in range(20)]
    assert "corrupted=0" in out.splitlines()[-1]
