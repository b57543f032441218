"""Recordings in, results out: every row of davar-sim is compared with the oracle, whatever the
law, the mode, the stride, the unit, the arithmetic, the gaps and the form of the file.
"""

import gzip
import math
import random
import re
from dataclasses import replace

import numpy as np
import pytest
from davar_oracle import Setting, results
from sim_case import SMALL_WINDOW, as_text, noise_rows, parsed, sim, write
from sim_case import results as rows_of

RATE_HZ = 128.0  # a period that a double holds exactly
LSB = 0.0625
FIXED = ("--law", "fixed", *SMALL_WINDOW, "--lsb", "0.01")


def counts_of(number, seed=1):
    """White noise whose level changes, so that windows shrink and grow."""
    source = random.Random(seed)
    return [
        round(source.gauss(20, 40) * (3 if i // 70 % 3 == 2 else 1) + (i % 97 == 0) * 300)
        for i in range(number)
    ]


def stamps(number, steps=None):
    """Time stamps. steps: {sample: periods since the sample before it}."""
    ticks = np.cumsum([1.0 if i else 0.0 for i in range(number)])
    for at, periods in (steps or {}).items():
        ticks[at:] += periods - 1.0
    return [repr(float(tick)) for tick in 5.0 + ticks / RATE_HZ]


def text_of(counts, steps=None, scale=LSB, name="gyro_x_dps"):
    fields = (repr(count * scale) if scale != 1 else str(count) for count in counts)
    return as_text(f"time_s,{name}", zip(stamps(len(counts), steps), fields))


def close(text, value, relative=5.1e-9, absolute=0.0):
    return math.isclose(float(text or "nan"), value, rel_tol=relative, abs_tol=absolute) or (
        text == "" and math.isnan(value)
    )


def assert_rows(rows, counts, gaps, setting, times, unit=LSB, absolute=0.0, relative=5.1e-9):
    """Complete rows: every epoch, every column that does not come from the fit."""
    wanted = list(results(counts, gaps, setting))
    assert len(rows) == len(wanted)
    for row, one in zip(rows, wanted):
        place = one["epoch"]
        for name in ("epoch", "window_samples", "unstable", "gaps_in_window"):
            assert row[name] == str(one[name]), (name, place)
        assert float(row["time_s"]) == float(times[place])
        for name in ("kurtosis", "contribution"):
            assert close(row[name], one[name], 1e3 * relative, 1e-7), (name, place)
        for m, (deviation, number) in one["adev"].items():
            assert row[f"differences_{m}"] == str(number), (m, place)
            assert close(row[f"adev_{m}"], unit * deviation, relative, absolute), (m, place)


LAWS = [
    Setting(mode=mode, law=law, stride=stride)
    for mode in ("centred", "trailing")
    for law in ("fixed", "kurtosis", "or", "and")
    for stride in (1, 7)
]
OTHERS = [
    Setting(shrink=0, grow=2),
    Setting(mode="trailing", grow=0, shrink=5, longest=61, shortest=37, segment=1),
    Setting(kurtosis=(1.0, 9.0), contribution=(0.01, 0.05), taus=(1, 3, 20)),
    Setting(mode="trailing", stride=60, law="or", taus=(20,)),
    Setting(stride=60, longest=60, shortest=42, taus=(1, 2, 3, 5, 7, 11, 13)),
]
GAPS = {40: 5.0, 41: 2.0, 100: 1.75, 101: 1.5, 250: 2.7, 333: 61.4, 398: 3.5}  # 101: no gap


def prepared(setting):
    """The steps of trailing windows grow by one."""
    return replace(setting, grow=min(setting.grow, 1)) if setting.mode == "trailing" else setting


@pytest.mark.parametrize("setting", map(prepared, LAWS + OTHERS), ids=str)
@pytest.mark.parametrize("steps", [{}, GAPS], ids=["whole", "gaps"])
def test_every_row_is_that_of_the_definition(tmp_path, setting, steps):
    counts = counts_of(400)
    path = write(tmp_path / "rec.csv", text_of(counts, steps))
    gaps = [at for at in steps if steps[at] > 1.5]
    for engine in ("auto", "grid") if setting.stride > 1 else ("auto",):
        words = ("--lsb", LSB, "--details", "--engine", engine, *setting.words())
        assert_rows(rows_of(path, *words), counts, gaps, setting, stamps(400, steps))


def test_the_default_window_and_its_proportions(tmp_path):
    counts = counts_of(1000)
    path = write(tmp_path / "rec.csv", text_of(counts))
    octaves = {600: (1, 2, 4, 8, 16, 32, 64), 300: (1, 2, 4, 8, 16, 32), 100: (1, 2, 4, 8)}
    shortest = {600: 400, 300: 200, 100: 66}
    for longest, taus in octaves.items():
        setting = Setting(
            longest=longest, shortest=shortest[longest], segment=longest // 6, taus=taus, stride=10
        )
        words = () if longest == 600 else ("--window-max", longest)
        rows = rows_of(path, "--lsb", LSB, "--stride", 10, "--details", *words)
        assert_rows(rows, counts, [], setting, stamps(1000))
    names = list(rows_of(path, "--lsb", LSB, "--stride", 500, "--taus", "geometric:4")[0])
    assert names[-4:] == ["adev_1", "adev_4", "adev_16", "adev_66"]
    words = ("--lsb", LSB, "--stride", 500, "--taus")
    assert sim(path, *words, "geometric:12").stdout == sim(path, *words, "geometric").stdout


# --- units and arithmetic

RADIAN = math.pi / 180
UNITS = {
    "counts": ("gyro_x_counts", 1, ("--lsb", LSB)),
    "dps": ("gyro_x_dps", LSB, ("--lsb", LSB)),
    "rad": ("gyro_x_rad_s", LSB * RADIAN, ("--lsb", LSB)),
    "other": ("freq_hz", LSB, ("--lsb", LSB)),
    "16 bits": ("gyro_x_dps", LSB, ("--lsb", LSB, "--bits", 16)),
    "24 bits": ("gyro_x_dps", LSB, ("--lsb", LSB, "--bits", 24)),
    "32 bits": ("gyro_x_dps", LSB, ("--lsb", LSB, "--bits", 32)),
    "no lsb": ("gyro_x_dps", LSB, ()),
    "rad, no lsb": ("gyro_x_rad_s", LSB * RADIAN, ()),
    "float": ("gyro_x_dps", LSB, ("--arith", "float")),
    "float, counts": ("gyro_x_counts", 1, ("--arith", "float", "--lsb", LSB)),
    "float, rad": ("gyro_x_rad_s", LSB * RADIAN, ("--arith", "float")),
    "float, full scale": ("gyro_x_dps", LSB, ("--arith", "float", "--full-scale", 300)),
}


@pytest.mark.parametrize("name", UNITS)
def test_every_unit_and_arithmetic_gives_the_same_deviations(tmp_path, name):
    counts = counts_of(300)
    column, scale, words = UNITS[name]
    path = write(tmp_path / "rec.csv", text_of(counts, GAPS, scale, column))
    rows = rows_of(path, *words, "--details", *Setting().words())
    gaps = [at for at in GAPS if GAPS[at] > 1.5 and at < 300]
    exact = "rad" not in name or "--lsb" in words
    tolerance = 5.1e-9 if exact else 3e-7
    assert_rows(rows, counts, gaps, Setting(), stamps(300, GAPS), LSB, 1e-9, tolerance)


def counters(done):
    """(gaps, missing samples, saturated samples) as reported; nothing is reported of zeros."""
    form = r"^davar-sim: (\d+) gaps \((\d+) samples missing\), (\d+) samples saturated, "
    found = re.search(form + "0 windows restarted, 0 results missed$", done.stderr, re.MULTILINE)
    return tuple(map(int, found.groups())) if found else (0, 0, 0)


@pytest.mark.parametrize(
    ("bits", "value", "expected"),
    [
        (bits, sign * (2 ** (at - 1)) + off, int(at == bits))
        for bits in (16, 24, 32)
        for at in (16, 24, 32)
        for sign, off in ((1, -1), (-1, 0))
        if at <= bits
    ]
    + [(bits, sign * (2 ** (bits - 1) - 2), 0) for bits in (16, 24, 32) for sign in (1, -1)],
)
def test_only_the_full_scale_of_the_width_is_saturated(tmp_path, bits, value, expected):
    """A count of 32767 is the rail of 16 bits, and an ordinary count of 24."""
    counts = counts_of(100)
    counts[50] = value
    path = write(tmp_path / "rec.csv", text_of(counts, None, 1, "gyro_x_counts"))
    default = [()] if bits == 24 else []
    for words in (("--bits", bits), *default):
        done = sim(path, "--lsb", 1e-3, *words, *SMALL_WINDOW, "--details", "--law", "fixed")
        assert done.returncode == 0, done.stderr
        assert counters(done) == (0, 0, expected)
        setting = Setting(law="fixed", taus=(1, 2, 4))
        assert_rows(parsed(done.stdout), counts, [], setting, stamps(100), 1e-3, 0, 1e-8)


@pytest.mark.parametrize("words", ((), ("--arith", "float")))
@pytest.mark.parametrize("most", (0.5, 8.0, -8.0, 2.0**-70, 9.3))
def test_a_scale_that_nobody_gave_holds_the_largest_rate(tmp_path, words, most):
    """Also a power of two, which would be the rail of a full scale of that size."""
    counts = counts_of(100)
    rates = [0.99 * most * one / max(map(abs, counts)) for one in counts]
    rates[50] = most
    lines = [f"{i / 100},{rate!r}" for i, rate in enumerate(rates)]
    path = write(tmp_path / "rec.csv", "\n".join(["time_s,gyro_x_dps", *lines]) + "\n")
    done = sim(path, *words, *SMALL_WINDOW, "--law", "fixed")
    assert done.returncode == 0, done.stderr
    assert counters(done) == (0, 0, 0)


# --- gaps

STEPS = [*(round(1.3 + 0.3 * i, 1) for i in range(23)), 1.5, 1.5078125, 2.5, 3.5, 6.5, 7.4375]


def test_the_length_of_a_gap_is_rounded_to_whole_samples(tmp_path):
    """A step of 2.7 periods lacks two samples, one of 2.4 lacks one."""
    for periods in STEPS:
        steps = {60: periods, 90: periods, 140: periods}
        done = sim(
            write(tmp_path / "rec.csv", text_of(counts_of(200), steps)), "--lsb", LSB, *SMALL_WINDOW
        )
        missing = max(math.floor(periods + 0.5) - 1, 1) if periods > 1.5 else 0
        assert counters(done) == ((3, 3 * missing, 0) if missing else (0, 0, 0)), periods


@pytest.mark.parametrize(
    ("words", "periods", "missing"),
    [
        (("--gap", "6"), 5.0, 0),
        (("--gap", "1.3"), 1.4, 1),
        (("--rate", "128"), 5.0, 0),
        (("--rate", "128", "--gap", "1.5"), 5.0, 4),
        (("--rate", "64", "--gap", "1.5"), 5.0, 2),
    ],
)
def test_what_counts_as_a_gap(tmp_path, words, periods, missing):
    path = write(tmp_path / "rec.csv", text_of(counts_of(200), {100: periods}))
    done = sim(path, "--lsb", LSB, *SMALL_WINDOW, *words)
    assert done.returncode == 0
    assert counters(done) == (int(missing > 0), missing, 0)


# --- the rate


def arw(path, *options):
    words = ("--law", "fixed", *SMALL_WINDOW, "--lsb", LSB, "--bandwidth", "none")
    return float(rows_of(path, *words, *options)[100]["arw_deg_per_sqrt_h"])


def test_the_rate_is_the_median_step(tmp_path):
    """The mean of the middle two of an even number of steps."""
    steps = [0.25, 0.5, 0.125, 0.75] * 50
    times = np.concatenate([[0.0], np.cumsum(steps)])
    rows = [[repr(float(time)), row[1]] for time, row in zip(times, noise_rows(201))]
    path = write(tmp_path / "steps.csv", as_text("time_s,gyro_x_dps", rows))
    assert arw(path, "--gap", 9) == arw(path, "--rate", repr(1 / float(np.median(steps))))
    path = write(tmp_path / "rec.csv", text_of(counts_of(300), {150: 1.25, 200: 0.5}))
    assert arw(path) == pytest.approx(arw(path, "--rate", RATE_HZ), rel=1e-9)
    assert arw(path, "--rate", RATE_HZ) == pytest.approx(2 * arw(path, "--rate", 4 * RATE_HZ))


@pytest.mark.parametrize(
    ("steps", "words", "note"),
    [
        ({}, (), None),
        ({}, ("--rate", 150), None),
        ({}, ("--rate", 106), "using --rate 106, but the time stamps give 128 Hz"),
        ({}, ("--rate", 400), "using --rate 400, but the time stamps give 128 Hz"),
        (dict.fromkeys(range(30, 300, 30), 3.0), (), None),
        (dict.fromkeys(range(15, 300, 15), 2.0), (), "6.4 % of the steps"),
        (dict.fromkeys((50, 250), 70.0), (), "128 Hz from the median time step, 87.5"),
        ({at: 6.0 if at % 10 == 0 else 0.5 for at in range(300)}, (), "give --rate 123.9"),
    ],
)
def test_doubtful_rates_are_pointed_out(tmp_path, steps, words, note):
    """More than 20 % between the rates, or more than 5 % of the steps are gaps."""
    path = write(tmp_path / "rec.csv", text_of(counts_of(300), steps))
    done = sim(path, "--lsb", LSB, *SMALL_WINDOW, *words)
    assert done.returncode == 0
    assert (note in done.stderr) if note else (" Hz" not in done.stderr), done.stderr


def test_time_keeps_its_digits_late_in_a_long_run(tmp_path):
    rows = [[f"{1700000000 + i / 1000:.3f}", row[1]] for i, row in enumerate(noise_rows(6000))]
    path = write(tmp_path / "late.csv", as_text("time_s,gyro_x_dps", rows))
    found = rows_of(path, "--lsb", 0.01, *SMALL_WINDOW, "--rate", "1000")
    assert [row["time_s"] for row in found] == [row[0].rstrip("0").rstrip(".") for row in rows]
    bare = write(tmp_path / "bare.csv", as_text("gyro_x_dps", [[row[1]] for row in rows]))
    found = rows_of(bare, "--lsb", 0.01, *SMALL_WINDOW, "--rate", 125)
    assert [float(row["time_s"]) for row in found] == [i / 125 for i in range(6000)]


# --- forms of one text

TEXT = as_text("time_s,gyro_x_dps", noise_rows(200))
LINES = [line.split(",") for line in TEXT.splitlines()[1:]]
COUNTS = [[time, round(100 * float(rate))] for time, rate in LINES]
MIDDLE = TEXT.index("\n", 1000) + 5
FORMS = {
    "comments": "# sensor: none\n#\n\n" + TEXT,
    "byte order mark": "\ufeff" + TEXT,
    "mark and comment": "\ufeff# note: x\n" + TEXT,
    "windows": TEXT.replace("\n", "\r\n"),
    "no newline": TEXT.rstrip("\n"),
    "windows, no newline": TEXT.replace("\n", "\r\n").rstrip("\n"),
    "blank end": TEXT + "\n\n  \n\t\r\n",
    "spaces": "\n".join(" " + line.replace(",", " ,\t") + "  " for line in TEXT.splitlines()),
    "signs": as_text("time_s,gyro_x_dps", [["+" + time, f"{n}e-2"] for time, n in COUNTS]),
    "gzip": gzip.compress(TEXT.encode()),
    "members": gzip.compress(TEXT[:MIDDLE].encode()) + gzip.compress(TEXT[MIDDLE:].encode()),
    "other columns": as_text(
        "temp_degC,time_s,accel_x_g,gyro_x_dps,gyro_y_dps",
        [["20", time, "1", rate, "5"] for time, rate in LINES],
    ),
    "counts": as_text("time_s,gyro_x_counts", COUNTS),
    "long line": TEXT.replace(",0", "," + " " * 100000 + "0", 1),
}


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    done = sim(write(tmp_path_factory.mktemp("form") / "plain.csv", TEXT), *FIXED)
    assert (done.returncode, done.stderr, done.stdout.count("\n")) == (0, "", 201)
    return done.stdout


@pytest.mark.parametrize("name", FORMS)
def test_every_form_of_a_text_gives_the_same_bytes(tmp_path, expected, name):
    path = tmp_path / "form.csv"
    path.write_bytes(FORMS[name] if isinstance(FORMS[name], bytes) else FORMS[name].encode())
    done = sim(path, *FIXED)
    assert (done.stderr, done.stdout) == ("", expected)


def test_other_ways_into_the_program(tmp_path, expected):
    for data in (TEXT.encode(), FORMS["gzip"]):
        for name in ("-", "/dev/stdin"):
            assert sim(name, *FIXED, stdin=data).stdout == expected
    named = tmp_path / "named.csv.gz"  # not compressed
    named.write_text(TEXT)
    assert sim(named, *FIXED).stdout == expected
    bare = write(tmp_path / "bare.csv", as_text("gyro_x_dps", [[rate] for _, rate in LINES]))
    assert sim(bare, *FIXED, "--rate", "100").stdout == expected


# --- columns


def test_several_columns_come_epoch_by_epoch_in_the_given_order(tmp_path):
    header = "time_s,accel_x_g,gyro_x_dps,gyro_y_dps,gyro_z_dps"
    path = write(tmp_path / "axes.csv", as_text(header, noise_rows(200, columns=4)))
    wanted = ["gyro_z_dps", "gyro_x_dps", "gyro_y_dps"]
    alone = {name: rows_of(path, *FIXED, "--column", name) for name in wanted}
    assert rows_of(path, *FIXED) == alone["gyro_x_dps"]  # the first gyro_*
    for arguments in (
        (path, "--column", *wanted),
        (path, "--column", ",".join(wanted)),
        ("--column", wanted[0], path, "--column", ",".join(wanted[1:])),
        (path, *(word for name in wanted for word in ("--column", name))),
    ):
        rows = rows_of(*arguments, *FIXED)
        assert [row["channel"] for row in rows] == wanted * 200
        for n, name in enumerate(wanted):
            assert [{k: v for k, v in row.items() if k != "channel"} for row in rows[n::3]] == (
                alone[name]
            )


def test_two_rows_are_enough_to_know_the_rate(tmp_path):
    path = write(tmp_path / "two.csv", "time_s,gyro_x_dps\n0,1\n0.5,2\n")
    rows = rows_of(path, "--window-max", "4", "--taus", "1", "--lsb", "1")
    assert [row["time_s"] for row in rows] == ["0", "0.5"]
