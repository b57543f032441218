"""Every format that davarlab reads, in one table: damaged, the file is read or rejected in one
line. A cut log is rejected, or all of it is read. Values that are read were in the log. A length
field in a file is not trusted.

Recordings in text: test_recordings.py.
"""

import csv
import functools
import gzip
import math
import tempfile
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
import writing_logs as writing
from davarlab.report import parameters
from davarlab.tables import table
from hypothesis import assume, example, given
from hypothesis import strategies as st
from lawful import bounded, damaged, examples

TRUTH = writing.Truth(count=24)
ROWS = "".join(
    f"{1700000000 + place / 50:.3f},{math.sin(place * place % 997):.6g},{place % 7 - 3}\n"
    for place in range(40)
)
TEXT = f"# sensor: a\n# unit: \u00b5\ntime_s,gyro_z_dps,temp_degC\n{ROWS}".encode()
MODEL = (
    '[sensor]\nrate_hz = 50.0\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    'coefficient_deg_per_sqrt_h = 0.3\n[[effect]]\nkind = "sinusoid"\nfrequency_hz = 0.7\n'
    'amplitude_dps = 0.02\n[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.02\n'
    '[[effect]]\nkind = "low_pass"\ncutoff_hz = 9.0\norder = 2\n'
)
SCENARIO = MODEL + "[simulate]\nduration_s = 30.0\nseed = 3\n"
KALIBR = (
    "imu0:\n  gyroscope_noise_density: 1.5e-4\n  gyroscope_random_walk: 2.0e-06\n  rate_hz: 200\n"
)


LOGS = {  # how each is written, in a folder
    "a.ulg": lambda folder: writing.ulog(folder / "a.ulg", TRUTH, gyros=1),
    "a.bin": lambda folder: writing.dataflash(folder / "a.bin", TRUTH, instances=1),
    "a.log": lambda folder: writing.dataflash_text(folder / "a.log", TRUTH),
    "a.bag": lambda folder: writing.ros1(folder / "a.bag", TRUTH),
    "a.db3": lambda folder: writing.ros2(folder / "a", TRUTH, "db3"),
    "a.mcap": lambda folder: writing.ros2(folder / "a", TRUTH, "mcap"),
    "a5.mat": lambda folder: writing.matlab_5(folder / "a5.mat", TRUTH),
    "a73.mat": lambda folder: writing.matlab_73(folder / "a73.mat", TRUTH),
    "a.npy": lambda folder: writing.npy(folder / "a.npy", TRUTH),
    "a.npz": lambda folder: writing.npz(folder / "a.npz", TRUTH),
    "a.parquet": lambda folder: writing.table(folder / "a.parquet", TRUTH),
}
IMPORT = ("import", "IN", "-o", "OUT")
# name: (valid bytes, unless it is a log, commands that read it, examples)
FORMATS = {
    **{name: (None, [IMPORT], 40) for name in LOGS},
    "a.csv": (TEXT, [IMPORT], 120),
    "a.csv.gz": (gzip.compress(TEXT, mtime=0), [IMPORT], 60),
    "model.toml": (
        MODEL.encode(),
        [
            ("export", "IN", "-o", "OUT"),
            ("add", "IN", "warm_up", "-o", "OUT"),
            *(
                ("export", "IN", "--to", form, "-o", "OUT")
                for form in (*sorted(parameters.FORMATS), "plan")
            ),
        ],
        120,
    ),
    "scenario.toml": (SCENARIO.encode(), [("simulate", "IN", "-o", "OUT")], 40),
    "imu.yaml": (KALIBR.encode(), [("sheet", "--kalibr", "IN", "-o", "OUT")], 80),
}
DEEP = {  # nesting, lengths and aliases
    "model.toml": (
        b"[" * 20000,
        b"a = " + b"[" * 20000 + b"]" * 20000,
        b"a = " + b"{a=" * 20000,
        b"a." * 1000 + b"a = 1",
        b"a = " + b"9" * 10000,
    ),
    "imu.yaml": (
        b"imu0: " + b"[" * 20000,
        b"a: &a [x, x]\nb: &b [*a, *a, *a, *a, *a, *a]\nc: &c [*b, *b, *b, *b]\n"
        b"gyroscope_noise_density: *c",
        b"gyroscope_noise_density: 2024-99-99\n",
        b"gyroscope_noise_density: !!int x\n",
    ),
    "a.csv": (
        b"a,b\n" + b"," * 1_000_000,
        b"a," * 1_000_000,
        b"a,b\n1,2\n" + b'","' * 300_000,
        b"," * 300_000 + b"\n1\n",
    ),
}


@functools.cache
def log(name):
    """The bytes of a small log."""
    with tempfile.TemporaryDirectory() as folder:
        path = LOGS[name](Path(folder)) or Path(folder, name)
        return path.read_bytes()


@pytest.fixture(autouse=True)
def bounded_memory():
    with bounded():
        yield


def read_by(work, name, data, command):
    """Runs a command on a file with these bytes, by the rule of lawful.py."""
    path, output = work.file(name, data), "out.h" if name == "model.toml" else "out"
    return work.lawful(output, *(path if word == "IN" else word for word in command))


def imported(work, name, data):
    done = read_by(work, name, data, IMPORT)
    if name in ("a.bag", "a.mcap"):  # the readers of other logs look for it, and are rejected
        assert "memory" not in done.err
    return done


@pytest.mark.parametrize("name", FORMATS)
def test_a_damaged_file_is_read_or_rejected(work, name):
    valid, commands, count = FORMATS[name]
    valid = valid or log(name)

    @given(damaged(valid), st.sampled_from(commands))
    @examples(count)
    def check(data, command):
        if name == "scenario.toml":  # otherwise it may be a long one
            assume(b"duration_s = 30.0\n" in data and b"rate_hz = 50.0\n" in data)
        read_by(work, name, data, command)

    assert read_by(work, name, valid, commands[0]).status == 0
    check()


@pytest.mark.parametrize("name", DEEP)
def test_any_bytes_are_read_or_rejected(work, name):
    _, commands, count = FORMATS[name]
    alphabet = 'time_s,gyro_z_dps\n\r\t;#: "0123456789.eE+-[]={}&*\ufeff\x00\x1b'

    @given(
        st.one_of(
            st.binary(max_size=200),
            st.text(max_size=80).map(lambda text: text.encode("utf-8", "surrogatepass")),
            st.text(st.sampled_from(alphabet), max_size=200).map(str.encode),
        ),
        st.sampled_from(commands),
    )
    @examples(count // 2)
    def check(data, command):
        read_by(work, name, data, command)

    for data in DEEP[name]:
        read_by(work, name, data, commands[0])
    check()


def message_ends(name):
    """The message ends of logs that are a sequence of messages: nothing in them shows that another
    message followed. By the layouts in writing_logs.
    """
    data = log(name)
    if name == "a.bin":
        return set(range(2 * 89, len(data), 40))
    if name == "a.ulg":
        found = [16]
        while found[-1] < len(data):
            found.append(found[-1] + 3 + int.from_bytes(data[found[-1] : found[-1] + 2], "little"))
        return set(found)
    return set(range(len(data))) if name == "a.log" else set()


def rows_of(work):
    """The rows of the import."""
    lines = (work / "out").read_text(encoding="utf-8").splitlines(keepends=True)
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


@pytest.mark.parametrize("name", LOGS)
def test_a_cut_log_is_rejected_or_read_whole(work, name):
    """After a complete message, the content before it is read."""
    ends, data = message_ends(name), log(name)
    lengths = st.integers(0, len(data) - 1) | st.sampled_from(sorted(ends)[:-1] or [0])

    @given(lengths)
    @example(len(data))
    @examples(20)
    def check(length):
        if imported(work, name, data[:length]).status != 0:
            assert length < len(data)
            return
        rows = rows_of(work)
        if length not in ends:
            assert len(rows) == TRUTH.count
        # nothing shows that a number in text was cut
        rows = rows[:-1] if name == "a.log" and length < len(data) else rows
        for axis, letter in enumerate("xyz"):
            found = [float(row[f"gyro_{letter}_dps"]) for row in rows]
            wanted = TRUTH.gyro[axis][: len(rows)]
            np.testing.assert_allclose(found, wanted, rtol=2e-7, atol=1e-8)

    check()


def test_a_type_that_kills_scipy(work):
    data = log("a5.mat").replace(b"\x09\0\0\0\xc0\0\0\0", b"\0\0\0\0\xc0\0\0\0", 1)
    assert data != log("a5.mat")
    assert imported(work, "a5.mat", data).status == 2


def test_a_database_whose_last_sample_was_zeros(work):
    data = log("a.db3")
    for cut in (1, 303, 4096, len(data) // 2):
        done = imported(work, "a.db3", data[:-cut])
        assert (done.status, "cut short" in done.err) == (2, True), done.err


# Arrays with names, of any names and values.
NAMES = st.one_of(
    st.text(st.characters(blacklist_categories=("Cs",)), min_size=1, max_size=6),
    st.sampled_from(("a,b", "a\nb", '"a"', " a", "#a", "time", "temp", "accel_x", "epoch")),
    st.sampled_from(("\x1b[2J", "a\u2028b")),
)
STAMPS = st.one_of(
    st.integers(0, 2**62 // 1000),
    st.integers(-(2**63), 2**63 - 1),
    st.integers(1_700_000_000_000_000, 1_700_000_001_000_000),
)
VALUES = st.one_of(
    st.floats(-1e6, 1e6),
    st.floats(-1e6, 1e6),
    st.floats(),
    st.sampled_from((5e-324, 1e29, 1e30, 1e300, -0.0)),
)


@given(names=st.lists(NAMES, max_size=3, unique=True))
@examples(100)
def test_columns_of_any_name(work, names):
    columns = {"time_s": np.arange(TRUTH.count) / 50}
    columns |= {f"gyro_{axis}_dps": TRUTH.gyro[at].astype(float) for at, axis in enumerate("xyz")}
    columns |= {name: np.full(TRUTH.count, 1.0 + at) for at, name in enumerate(names)}
    path = work / "a.parquet"
    writing.parquet.write_table(writing.pyarrow.table(columns), path)
    if imported(work, path.name, path.read_bytes()).status == 0:
        found = table.read(work / "out").columns
        assert len(found) == len(columns)
        assert list(found)[:4] == list(columns)[:4]
        for column in list(found.values())[4:]:
            assert len(set(column.tolist())) == 1


@given(
    rows=st.lists(st.tuples(STAMPS, VALUES, VALUES, VALUES), min_size=4, max_size=7),
    kind=st.sampled_from((np.float64, np.float32)),
    clock=st.sampled_from((np.int64, np.uint64, np.float64)),
    ordered=st.booleans(),
    tick=st.sampled_from((("ns", 1), ("us", 1000), ("ms", 10**6))),
)
@examples(150)
def test_arrays_of_any_values(work, rows, kind, clock, ordered, tick):
    rows = sorted(rows) if ordered else rows
    assume(clock != np.uint64 or all(row[0] >= 0 for row in rows))
    stamps = np.array([row[0] for row in rows], clock)
    with np.errstate(over="ignore"):
        gyro = np.array([row[1:] for row in rows]).astype(kind)
    path = work / "a.npz"
    np.savez(path, **{f"timestamp_{tick[0]}": stamps, "gyro_dps": gyro})
    if imported(work, path.name, path.read_bytes()).status != 0:
        return
    found = rows_of(work)
    assert list(found[0]) == ["time_s", "gyro_x_dps", "gyro_y_dps", "gyro_z_dps"]
    for row, values, stamp in zip(found, gyro.tolist(), stamps.tolist(), strict=True):
        text, *read = row.values()
        assert [float(one) for one in read] == [float(f"{one:.9g}") for one in values]
        exact = Decimal(stamp) * tick[1] / 10**9
        # a nanosecond, as far as the 53 bits of a double reach: 97 days
        assert abs(Decimal(text) - exact) <= max(Decimal("1.1e-9"), abs(exact) * Decimal("3e-16"))
