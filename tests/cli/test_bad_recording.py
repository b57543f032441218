"""Bad recordings: exit status 2, one line with file, line and column, no standard output."""

import os
import subprocess

import pytest
from sim_case import (
    PROGRAM,
    SMALL_WINDOW,
    as_text,
    assert_refused,
    noise_rows,
    recording,
    results,
    sim,
    write,
)

HEADER = "time_s,gyro_x_dps,temp_degC"
ROWS = noise_rows(200, columns=2)
TEXT = as_text(HEADER, ROWS)
NUMBER, FINITE, LARGE = "not a number", "not a finite number", "number too large"
FIELDS = {
    **dict.fromkeys(("abc", "0x10", "1.2.3", "1e+", "--1", ".", "1 2", "1;2", "# 1"), NUMBER),
    **dict.fromkeys(('"1"', "1\v", "x" * 5000), NUMBER),
    **dict.fromkeys(("nan", "NaN", "-nan", "inf", "-Infinity", "+INF"), FINITE),
    **dict.fromkeys(("1e999", "-1e999", "1" * 400), LARGE),
    **dict.fromkeys(("", "  "), "empty field"),
}


def with_field(row, column, field):
    """The recording with another field; the first row is line 2."""
    rows = [list(one) for one in ROWS]
    rows[row][column] = field
    return as_text(HEADER, rows)


def with_line(number, line):
    lines = TEXT.split("\n")
    lines.insert(number - 1, line)
    return "\n".join(lines)


def shown(field):
    """A field as a message shows it: control characters replaced, long ones cut."""
    field = field.strip(" \t").replace("\v", "?")
    return f"found '{field[:40]}...'" if len(field) > 40 else f"found '{field}'"


COUNTS = as_text("time_s,gyro_x_counts", [[row[0], i] for i, row in enumerate(ROWS)])
BINARY = bytes(range(256)) * 64
SHORT_ROW = TEXT.replace(",".join(ROWS[50]), ",".join(ROWS[50][:2]))
CONSTANT = as_text(HEADER, [["7", *row[1:]] for row in ROWS])
RATE_ONLY = as_text("gyro_x_dps", [row[1:2] for row in ROWS])
MANY = ",".join(f"c{n}" for n in range(1025)) + "\n"
NO_TEXT = "not a text recording, found byte 0x"
TOO_LONG = ":52: column 4: row too long: 3 columns in the header, found"
UNKNOWN = ": no column 'gyro_q_dps' (--column); the columns are: time_s, gyro_x_dps, temp_degC"
NO_GYRO = ": no gyro_* column; choose with --column from: time_s, accel_x_dps, temp_degC"
MEDIAN = ": column time_s: the median time step is 0, so the sample rate is unknown; give --rate"
OUTSIDE = ":101: column gyro_x_dps: value outside the count range (--bits, --lsb), found"
FLOAT = (
    ":101: column gyro_x_dps: value outside the range of the arithmetic (--arith), found '1e+39'"
)
# One field of the table: (row, column, field, the line after the path). The first row is line 2.
ONE_FIELD = {
    "unselected column": (99, 2, "a", ":101: column temp_degC: not a number, found 'a'"),
    "time": (99, 0, "noon", ":101: column time_s: not a number, found 'noon'"),
    "last row": (199, 2, "x", ":201: column temp_degC: not a number, found 'x'"),
    "long row": (50, 2, "1,2,3", f"{TOO_LONG} 5"),
    "zero byte": (50, 2, "1\0x", f":52: {NO_TEXT}00"),
    "back": (60, 0, "0.58", ":62: column time_s: time runs backwards, found '0.58'"),
    "above 16 bits": (99, 1, "327.68", f"{OUTSIDE} '327.68'"),
    "below 16 bits": (99, 1, "-327.69", f"{OUTSIDE} '-327.69'"),
    "above 24 bits": (99, 1, "83886.08", f"{OUTSIDE} '83886.08'"),
    "above float32": (99, 1, "1e39", FLOAT),
}
# Name: (content, the line after the path).
CASES = {
    **{name: (with_field(*at), words) for name, (*at, words) in ONE_FIELD.items()},
    "comments": ("# a\n\n" + with_field(9, 0, "x"), ":13: column time_s: not a number, found 'x'"),
    "short row": (
        SHORT_ROW,
        ":52: column temp_degC: row too short: 3 columns in the header, found 2",
    ),
    "blank line": (with_line(52, ""), ":52: column time_s: empty row between rows, found ''"),
    "comment": (with_line(52, "# stop"), ":52: column time_s: not a number, found '# stop'"),
    "endless line": (
        "time_s,gyro_x_dps\n0,1\n" + "1" * 1000000,
        ":3: line longer than 262144 bytes; not a recording",
    ),
    "constant time": (CONSTANT, MEDIAN),
    "no time": (RATE_ONLY, ": no column time_s: the sample rate is unknown; give --rate"),
    "name twice": (
        TEXT.replace("temp_degC", "gyro_x_dps"),
        ":1: column 3: name used twice in the header row, found 'gyro_x_dps'",
    ),
    "empty name": (TEXT.replace("gyro_x_dps", ""), ":1: column 2: empty name in the header row"),
    "no header": ("0.0,20\n", ":1: column 1: no header row: a column name expected, found '0.0'"),
    "unknown column": (TEXT, UNKNOWN),
    "no gyro": (TEXT.replace("gyro_", "accel_"), NO_GYRO),
    "too many columns": (MANY, ":1: more than 1024 columns"),
    "counts": (COUNTS, ": column gyro_x_counts: counts need --lsb (deg/s per count)"),
    "part of a count": (
        COUNTS.replace(",77\n", ",12.5\n"),
        ":79: column gyro_x_counts: not a whole count, found '12.5'",
    ),
    "empty": ("", ":0: empty recording: no header row"),
    "header only": (HEADER, ":1: no rows after the header"),
    "binary": (BINARY, f":1: {NO_TEXT}00"),
    "one row": ("a,time_s\n0,1\n", ": too short: 1 samples, but one epoch needs at least 30"),
}
OPTIONS = {
    **dict.fromkeys(("above 16 bits", "below 16 bits"), ("--lsb", "0.01", "--bits", "16")),
    **dict.fromkeys(("above 24 bits", "part of a count"), ("--lsb", "0.01")),
    "unknown column": ("--column", "gyro_q_dps"),
    "above float32": ("--arith", "float"),
}


@pytest.mark.parametrize("name", CASES)
def test_the_place_is_reported(tmp_path, name):
    content, wanted = CASES[name]
    for suffix in ("", ".gz"):
        path = write(tmp_path / f"rec.csv{suffix}", content)
        done = sim(path, *SMALL_WINDOW, *OPTIONS.get(name, ()))
        assert_refused(done)
        assert done.stderr.removesuffix(" (see --window-max)\n").rstrip("\n") == (
            f"davar-sim: {path}{wanted}"
        )


@pytest.mark.parametrize("field", FIELDS)
def test_a_bad_field_is_described_and_shown(tmp_path, field):
    path = write(tmp_path / "rec.csv", with_field(99, 1, field))
    done = sim(path, *SMALL_WINDOW)
    assert_refused(done)
    wanted = f"{path}:101: column gyro_x_dps: {FIELDS[field]}, {shown(field)}"
    assert done.stderr == f"davar-sim: {wanted}\n"


@pytest.mark.parametrize(
    ("words", "needed"),
    [("", 30), ("--mode trailing", 40), ("--stride 35", 35), ("--mode trailing --stride 35", 70)],
)
def test_the_stated_number_of_samples_is_enough(tmp_path, words, needed):
    options = (*SMALL_WINDOW, *words.split())
    path = recording(tmp_path, count=needed - 1)
    wanted = f"{needed - 1} samples, but one epoch needs at least {needed} "
    assert_refused(sim(path, *options), path, "too short", wanted)
    assert results(recording(tmp_path, count=needed), *options)


# --- files and surroundings


def test_paths_that_are_no_recordings(tmp_path):
    """Pipes and standard input are read (test_recording.py); a device may have no end."""
    loop = tmp_path / "loop.csv"
    loop.symlink_to(loop)
    for path, words in (
        ("/dev/zero", "device"),
        ("/dev/null", "device"),
        ("/proc/kmsg", ""),
        (tmp_path, "directory"),
        (loop, "symbolic links"),
        (tmp_path / ("a" * 300), "too long"),
        (tmp_path / "new\nline.csv", "No such file"),
        (tmp_path / "nothing.csv", "No such file"),
    ):
        assert_refused(sim(path), str(path).split("\n")[0], words)


def test_no_room_for_the_temporary_file(tmp_path):
    environment = dict(os.environ, TMPDIR=str(tmp_path / "nowhere"))
    path = recording(tmp_path, count=60000)
    assert_refused(sim(path, env=environment), "nowhere", "TMPDIR", "No such file")


@pytest.mark.parametrize(
    ("shell", "why"),
    [
        ('exec "$0" "$1" --lsb 0.01 >/dev/full', "No space left on device"),
        ('exec "$0" "$1" --lsb 0.01 >&-', "Bad file descriptor"),
    ],
)
def test_an_output_that_cannot_be_written(tmp_path, shell, why):
    command = ["sh", "-c", shell, PROGRAM, recording(tmp_path)]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (2, f"davar-sim: standard output: {why}\n")


def test_standard_output_may_not_be_the_recording(tmp_path):
    path = recording(tmp_path)
    text = path.read_bytes()
    other = tmp_path / "other.csv"
    other.hardlink_to(path)
    for name, stdin in ((path, os.devnull), (other, os.devnull), ("-", path)):
        with open(path, "ab") as output, open(stdin, "rb") as source:
            done = subprocess.run(
                [PROGRAM, name, "--lsb", "0.01"],
                stdin=source,
                stdout=output,
                stderr=subprocess.PIPE,
                text=True,
            )
        assert (done.returncode, path.read_bytes()) == (2, text)
        why = "is also standard output: results would be read as data"
        assert done.stderr == f"davar-sim: {name}: {why}\n"


def test_a_disconnected_reader_ends_the_run_quietly(tmp_path):
    command = ["sh", "-c", '"$0" "$1" --lsb 0.01 | head -n 1', PROGRAM, recording(tmp_path, 20000)]
    done = subprocess.run(command, capture_output=True)
    assert done.stderr == b""
    assert done.stdout.startswith(b"epoch,time_s,")
