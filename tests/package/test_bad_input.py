"""A wrong argument is a ValueError that begins with its name. A wrong file gives file, line and
column.
"""

import gzip
import os
import re
import subprocess
import sys
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from together import davar

X = np.random.default_rng(1).normal(0, 1, 2000)
BOTH = ("adev", "dynamic")
TIME_S = np.arange(2000.0)
MODEL = "m,adev_dps,relative_tolerance,tau_s\n1,0.5,0.02,1\n2,0.4,0.02,2\n"


def refused(begins, call, *arguments, **named):
    with pytest.raises(ValueError) as caught:
        call(*arguments, **named)
    assert re.fullmatch(rf"(\w+ or )?{begins}( or \w+)?: [^\n]+", str(caught.value))
    return str(caught.value)


def masked(x, hidden):
    return np.ma.masked_equal(x, hidden)


SAMPLES = (  # others: test_arrays.py
    *(["a", "b"], [], [1.0], [*X, None], [[1.0], [1.0, 2.0]], iter(X), {1.0, 2.0}, None),
    *(np.where(X > 3, np.inf, X), np.full(2000, np.nan), np.ma.masked_all(2000)),
)
NUMBERS = ([], [0, 1], [2, 1], [-1], [1, 1001], [[1, 2]], [np.nan], [np.inf], [True])
NUMBERS += (masked([1, 2], 2),)
WRONG = {
    "rate_hz": (0, -1, np.nan, np.inf, "fast", None),
    "gaps": ([0], [2000], [-1], [1.5], [[1]], "often", masked([5, 6], 6)),
    "taus": ("decades", "geometric:0", "geometric:99", "octave:3", "geometric:\u00b2", ""),
    "clusters": (*NUMBERS, [1, 1], [0.5], "octave", ["1"], [1j]),
    "taus_s": (*NUMBERS, [0.4], "all"),
    "time_s": (
        *(TIME_S[:-1], TIME_S[::-1], np.zeros(2000), "now", TIME_S.reshape(2, -1), TIME_S > 3),
        *(np.where(TIME_S == 5, np.nan, TIME_S), masked(TIME_S, 7)),
    ),
}
# of davar.dynamic only; the first argument is the wrong one
WINDOWS = (
    *({"window_max": value} for value in (3, 601, 600.5, -600)),
    *({"stride": value} for value in (0, "many")),
    *({"kurtosis": value} for value in ((3, 2), 3)),
    *({"unstable_rate": 0.5}, {"unstable_rate": 0.01, "law": "glr"}),
    *({"window_min": 700}, {"segment": 500}, {"grow": 3}, {"contribution": ("a", "b")}),
    *({"law": "magic"}, {"mode": "left"}, {"arith": "double"}, {"bits": 12}, {"block": -1}),
    *({"full_scale": -1, "arith": "float"}, {"false_alarms_per_hour": 0}, {"cut_interval": -1}),
    *({"engine": "steam"}, {"long_cluster": 80}, {"model_table": 5}),
    *({"bandwidth": text} for text in ("", "wide", "20Hz", "20:3", "average:0")),
    *({"bandwidth": value} for value in (-1, 0, np.nan, 0.001, 900)),
    *({"longest_tau_s": value} for value in (0, -1, np.nan, np.inf, "day", 100, 1e9, 10**400)),
    *({"taus": value} for value in ("all", "decade")),
    *({name: range(1, 34)} for name in ("clusters", "taus_s")),
    *({"skip_torn_reads": True, "arith": "float", **more} for more in ({}, {"lsb": 0.01})),
    *({"skip_torn_reads": True}, {"floor": True}),
    {"floor": True, "bandwidth": "none", "arith": "float"},
)


@pytest.mark.parametrize("call", BOTH)
@pytest.mark.parametrize("x", SAMPLES)
def test_samples(call, x):
    refused("x", getattr(davar, call), x, 1.0)


@pytest.mark.parametrize("call", BOTH)
@pytest.mark.parametrize("name, value", [(name, one) for name, all in WRONG.items() for one in all])
def test_common_arguments(call, name, value):
    rate = {} if name == "time_s" else {"rate_hz": 1.0}
    refused(name, getattr(davar, call), X, **rate | {name: value})


@pytest.mark.parametrize("call", BOTH)
def test_common_rules(call):
    call = getattr(davar, call)
    said = refused("x", call, X.reshape(2, -1), 1.0)
    assert "shape (2, 1000); give one axis at a time" in said
    refused("x", call, np.arange(2000) + 2**60, 1.0, lsb=1.0)
    for lsb in (None, 0, -1.0, np.nan, True):
        refused("lsb", call, np.arange(2000), 1.0, lsb=lsb)
    refused("gap", call, X, time_s=TIME_S, gap=1)
    for taus in ([1, 10, 100], (1,), np.array([1, 2]), 5, []):
        # seconds for AllanTools, samples for davar-sim
        said = refused("taus", call, X, 1.0, taus=taus)
        assert re.search(r"clusters=.*samples.*taus_s=.*seconds", said)
    assert "taus_s=" in refused("clusters", call, X, 100.0, clusters=[0.01, 0.1])
    pair = {"clusters": [1], "taus_s": [1]}
    for both in (pair, *({"taus": "octave", name: [1]} for name in pair)):
        refused(next(iter(both)), call, X, 1.0, **both)


@pytest.mark.parametrize("text", (None, "", MODEL.replace("0.5", "-1"), MODEL.replace("0.4", "x")))
def test_error_models(elsewhere, text):
    """Others: tests/cli/test_model_table.py."""
    if text is not None:
        Path("table.csv").write_text(text)
    refused("model_table", davar.dynamic, X, 1.0, model_table="table.csv")


@pytest.mark.parametrize("named", WINDOWS)
def test_options_of_the_window(named):
    refused(next(iter(named)), davar.dynamic, X, 1.0, **named)


def test_options_that_contradict_each_other():
    for data_type in ("rate", None, "PHASE", 1):
        refused("data_type", davar.adev, X, 1.0, data_type=data_type)
    for scale in (5e307, 1e-300, 5e-324):
        refused("x", davar.adev, X * scale, 1.0)
    refused("law glr", davar.dynamic, X, 1.0, law="glr", block=2)
    refused("law", davar.dynamic, X, 1.0, law="or", policy="glr")
    for x in (X[:100], X * 1e300, X * 1e20, X * 1e-300):
        refused("x", davar.dynamic, x, 1.0)
    refused("rate_hz", davar.dynamic, X, 1e60)
    with pytest.raises(AttributeError, match="no column bias .*arw_deg_per_sqrt_h"):
        _ = davar.dynamic(X, 1.0).bias


def test_streams():
    refused("lsb or full_scale", davar.Stream, 1.0)
    refused("lsb or full_scale", davar.Stream, 1.0, lsb=1.0, full_scale=2.0)
    refused("lsb", davar.Stream, 1.0, lsb=0)
    refused("rate_hz", davar.Stream, None, lsb=1.0)
    refused("bandwidth", davar.Stream, 1.0, lsb=1.0, bandwidth="auto")
    refused("window_min", davar.Stream, 1.0, lsb=1.0, window_min=601)
    for name in ("clusters", "taus_s"):
        refused(name, davar.Stream, 1.0, lsb=1.0, **{name: [1, 301]})
    stream = davar.Stream(1.0, full_scale=1.0)
    refused("lsb", stream.push, [1, 2])
    for missing in (0, -1, 1.5, True, "two", None):
        refused("missing", stream.gap, missing)
    refused("x", stream.push, X.reshape(2, -1))
    stream.finish()
    refused("x", stream.push, [1.0])


def read(text, name="rec.csv"):
    Path(name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return davar.read(name)


def test_the_contents_of_a_file(elsewhere):
    text = "# sensor: it\n# serial: 7\ntime_s,gyro_z_dps\n"
    text += "".join(f"{i / 50:.2f},{i}\n" for i in range(10)) + "\n"
    for made in (
        read(text),
        read(gzip.compress(text.encode()), "rec.csv.gz"),
        read(text.replace("\n", "\r\n")),
    ):
        assert made.notes == {"sensor": "it", "serial": "7"}
        assert made.rate_hz == pytest.approx(50.0)
        assert made["gyro_z_dps"].tolist() == list(range(10))
    assert read("gyro_z_dps\n1\n2\n").rate_hz is None


@pytest.mark.parametrize(
    "text, begins",
    (
        ("", "rec.csv: no header"),
        ("a_dps\n", "rec.csv:1: no rows"),
        ("a,b\n1,2\n3\n", "rec.csv:3: 1 fields"),
        ("# k: v\na,b\n1,2\n3,x\n", "rec.csv:4: column b: not a finite number, found 'x'"),
        ("a,b\n1,nan\n", "rec.csv:2: column b"),
        ("a,a\n1,2\n", "rec.csv:1: column a appears twice"),
        ("a,\n1,2\n", "rec.csv:1: a column without"),
        ("a\n1\n\n2\n", "rec.csv:3: an empty row"),
        ("time_s,a\n1,2\n3,4\n2,5\n", "rec.csv:4: column time_s: time runs backwards"),
        (b"a\n\xff\xfe\n", "rec.csv: not a text"),
        (gzip.compress(b"a\n1\n" * 99)[:-9], "rec.csv: damaged gzip"),
    ),
)
def test_bad_values_in_a_file(elsewhere, text, begins):
    with pytest.raises(ValueError) as caught:
        read(text)
    assert str(caught.value).startswith(begins)


GOOD = ("1", "+1", "1.", ".5", "1e3", "1E-3", " 2\t", "00012", "1e-400", "1e0000001")
GOOD += ("0." + "1" * 300,)
BAD = ("1_0", "\uff10", "\u0663", "1e", "e3", "0x10", "0x1p3", "inf", "nan", "", "1e400", "1d3")
BAD += ("1f", '"1"', "--1", "1 2", "1#2", "1;", "\u22121", ".", "+", "9" * 400, "True", "1j")


@pytest.mark.parametrize("field", (*GOOD, *BAD))
def test_the_numbers_are_those_of_davar_sim(elsewhere, field):
    rows = [f"{i},{i * 7919 % 101}\n" for i in range(700)]
    rows[300] = f"300,{field}\n"
    text = "time_s,gyro_z_dps\n" + "".join(rows)
    command = [os.environ["DAVAR_SIM"], "-", "--stride", "100"]
    done = subprocess.run(command, input=text.encode(), capture_output=True)
    assert (done.returncode == 0) == (field in GOOD)
    if field in GOOD:
        assert read(text)["gyro_z_dps"][300] == float(field)
    else:
        with pytest.raises(ValueError, match="^rec.csv:302: column gyro_z_dps: "):
            read(text)


def test_nothing_but_a_regular_file_is_opened(elsewhere):
    with pytest.raises(FileNotFoundError):
        davar.read("nowhere.csv")
    os.mkfifo("pipe.csv")
    for name in ("pipe.csv", "/dev/null"):
        with pytest.raises(ValueError, match=f"^{name}: not a regular file$"):
            davar.read(name)


def test_a_file_of_proc_does_not_wait(elsewhere, wheel):
    os.symlink("/proc/kmsg", "kmsg.csv")
    code = (
        "import davar\nfor name in ('/proc/kmsg', 'kmsg.csv'):\n"
        "    try:\n        davar.read(name)\n    except ValueError as why:\n        print(why)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(wheel.davar)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    reason = "no header row and no samples"
    assert done.stdout == f"/proc/kmsg: {reason}\nkmsg.csv: {reason}\n", done.stderr


@pytest.mark.parametrize(
    "head", (b"ULog\x01\x12\x35", b"\x93NUMPY\x01\x00", b"PAR1", b"no text \x00\x01")
)
def test_another_log_without_the_extra(elsewhere, head):
    wanted = r"^rec.ulg: not CSV; .*rosbags; pip install \"davar\[lab\]\""
    absent = mock.patch("davar.errors.missing", lambda: ["rosbags"])
    with absent, pytest.raises(ImportError, match=wanted):
        read(head + bytes(40), "rec.ulg")
