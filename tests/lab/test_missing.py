"""Missing values of text files are gaps, and a time that cannot be used can be done without."""

import numpy as np
import pytest
from asking import run
from reading_logs import COUNT, FORCE, GYRO, NAMES, OWN, TEMP, TIME, US, plain, rows

HOLES = [*range(40), 300, 301, 700, COUNT - 1]  # before a recording, in it and at its end
WHOLE = np.setdiff1d(np.arange(COUNT), HOLES)


def holed(values, mark="", places=HOLES):
    """Numbers as text, with a mark where they are missing."""
    gone = set(places)
    return [mark if place in gone else f"{one:.10g}" for place, one in enumerate(values)]


def every(step, values, first=0):
    """Numbers as text in every step-th row."""
    return holed(values, places=set(range(COUNT)) - set(range(first, COUNT, step)))


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize(
    "mark",
    [
        "nan",
        "NaN",
        "-nan",
        "NA",
        "N/A",
        "null",
        "None",
        "-",
        "--",
        "inf",
        "-1.#IND",
        "nan(ind)",
        "",
    ],
)
def test_a_row_without_a_value_is_a_gap(logs, mark, separator):
    mark = mark or '""' if separator == " " else mark
    text = rows(TIME, *(holed(axis, mark) for axis in GYRO.T), separator=separator)
    log = logs.file("log.csv", NAMES.replace(",", separator) + text)
    said = f"{len(HOLES)} of {COUNT} rows omitted: no value of gx_dps, gy_dps, gz_dps"
    assert said in logs.said(log)
    columns = logs.imported(log)[1]
    np.testing.assert_allclose(np.float64(columns["time_s"]), TIME[WHOLE], atol=1e-9)
    for axis, name in enumerate("xyz"):
        np.testing.assert_array_equal(np.float64(columns[f"gyro_{name}_dps"]), GYRO[WHOLE, axis])


NOTHING = [""] * COUNT
LACKING = {  # header, columns, rows that are left, what is said
    "one axis": (
        f"time_s,{OWN}",
        (TIME, GYRO[:, 0], holed(GYRO[:, 1]), GYRO[:, 2]),
        WHOLE,
        OWN[11:21],
    ),
    "the accelerometer": (
        f"time_s,{OWN},accel_x_g",
        (TIME, *GYRO.T, holed(FORCE[:, 0], "NA")),
        WHOLE,
        "no value of accel_x_g",
    ),
    "a temperature": (
        f"time_s,{OWN},temp_degC",
        (TIME, *GYRO.T, every(100, TEMP)),
        range(COUNT),
        "interpolated: temp_degC (1188 missing values)",
    ),
    "an accelerometer at half the rate": (
        f"time_s,{OWN},accel_x_g",
        (TIME, *GYRO.T, every(2, FORCE[:, 0])),
        range(COUNT),
        "interpolated: accel_x_g (600 missing values)",
    ),
    "a gyro at half the rate": (
        f"time_s,{OWN},temp_degC",
        (TIME, *(every(2, axis) for axis in GYRO.T), TEMP),
        range(0, COUNT, 2),
        "600 of 1200 rows omitted",
    ),
    "rows of its own for each sensor": (
        f"time_s,{OWN},accel_x_g",
        (TIME, *(every(2, axis) for axis in GYRO.T), every(2, FORCE[:, 0], 1)),
        range(0, COUNT, 2),
        "interpolated: accel_x_g (600 missing values)",
    ),
    "a second gyro that is empty": (
        f"time_s,{OWN},WatchGyroX",
        (TIME, *GYRO.T, NOTHING),
        range(COUNT),
        "skipped: WatchGyroX (empty)",
    ),
    "an axis that is empty": (
        f"time_s,{OWN},gyro_q_dps",
        (TIME, *GYRO.T, ["null"] * COUNT),
        range(COUNT),
        "skipped: gyro_q_dps (empty)",
    ),
    "a column of words for nothing": (
        f"time_s,{OWN},mag",
        (TIME, *GYRO.T, ["NA"] * COUNT),
        range(COUNT),
        "skipped: mag (empty)",
    ),
}


@pytest.mark.parametrize("name", LACKING)
def test_missing_values_of_other_columns(logs, name):
    header, columns, left, words = LACKING[name]
    log = logs.file("log.csv", f"{header}\n{rows(*columns)}")
    assert words in logs.said(log)
    found, left = logs.imported(log)[1], list(left)
    np.testing.assert_allclose(np.float64(found["time_s"]), TIME[left], atol=1e-9)
    np.testing.assert_array_equal(np.float64(found["gyro_z_dps"]), GYRO[left, 2])
    if "temp_degC" in found:
        np.testing.assert_allclose(np.float64(found["temp_degC"])[:1100], TEMP[left][:1100])


def test_rows_without_a_time_keep_their_places(logs):
    log = logs.file("log.txt", "\n".join(holed(GYRO[:, 0], "nan")) + "\n")
    columns = logs.imported(log, "--names", "gyro_x_dps", "--rate", "100")[1]
    # the first rows, without a number, are above the table
    np.testing.assert_allclose(np.float64(columns["time_s"]), TIME[WHOLE] - TIME[40], atol=1e-9)
    np.testing.assert_array_equal(np.float64(columns["gyro_x_dps"]), GYRO[WHOLE, 0])


ENDS = {  # texts of TIME and GYRO
    "names above columns that are absent": NAMES.replace("\n", ",note,mag\n") + plain(),
    "the same with commas": NAMES.replace("\n", ",note,mag\n") + plain(end=",,"),
    "more commas than names": NAMES.replace("\n", ",note,mag\n") + plain(end=",,,,"),
    "commas behind the names": NAMES.replace("\n", ",,\n") + plain(),
    "names of a second gyro": NAMES.replace("\n", ",WatchGyroX,WatchGyroY\n") + plain(),
    "semicolons behind the rows": NAMES + plain(end=";"),
    "semicolons behind all rows": NAMES.replace("\n", ";\n") + plain(end=" ;"),
    "semicolons behind tabs": NAMES.replace(",", "\t") + plain("\t", end=";"),
    "semicolons and spaces": NAMES.replace(",", " ") + plain(" ", end=";").replace("\n", "\r\n"),
}


@pytest.mark.parametrize("name", ENDS)
def test_what_stands_behind_the_numbers(logs, name):
    logs.check_gyro(logs.imported(logs.file("log.csv", ENDS[name]))[1])


def test_columns_that_leave_no_row_are_named(logs):
    x, y, z = (every(3, axis, first) for first, axis in enumerate(GYRO.T))
    for columns, names, left in (
        ((x, y, z), "gyro_y_dps, gyro_z_dps", "time_s,gyro_x_dps,_,_"),
        ((*GYRO.T[:2], every(2, GYRO[:, 2])), "gyro_z_dps", "time_s,gyro_x_dps,gyro_y_dps,_"),
    ):
        log = logs.file("log.csv", f"time_s,{OWN}\n{rows(TIME, *columns)}")
        logs.rejected(log, "log.csv: column gyro_", f"To do without {names}, type --names {left}")
        assert "gyro_z_dps" not in logs.imported(log, "--names", logs.proposed(log))[1]
    log = logs.file("log.csv", f"time_s,{OWN}\n{rows(TIME, *[NOTHING] * 3)}")
    logs.rejected(log, "log.csv: column gyro_x_dps: no row has a value")


def test_a_fit_takes_missing_values_for_lost_samples(logs):
    gone = np.random.default_rng(21).random(COUNT) < 0.05
    gyro = [holed(axis, "nan", np.flatnonzero(gone)) for axis in GYRO.T]
    log = logs.file("log.csv", f"time_s,{OWN}\n{rows(TIME, *gyro)}")
    shorter = logs.file("lost.csv", f"time_s,{OWN}\n{rows(TIME[~gone], *GYRO[~gone].T)}")
    found = [run("fit", one, "--json") for one in (log, shorter)]
    assert f"{np.count_nonzero(gone)} missing samples" in found[0].stderr
    assert found[0].stdout.replace("log.csv", "lost.csv") == found[1].stdout


# A time that cannot be used.


def stepped(stamps, back, places):
    """Stamps that step back at these places."""
    out = stamps.copy()
    for place in places:
        out[place:] -= back
    return out


NS = 1_742_324_422_300_000_000 + US * 1000
NO_TIME = {  # name of the column, stamps as text, the line that is named, what is said, --rate
    "a jump": ("timestamp_us", stepped(US, 50_000, [500]), 502, "runs backwards", "100"),
    "jumps there and back": (
        "us",
        stepped(US, 70_000, [50, 300, 900]),
        52,
        "runs backwards",
        "100",
    ),
    "a restart": ("time_s", np.r_[TIME[:600] + 7, TIME[600:] - 6], 602, "runs backwards", "100"),
    "Unix time": (
        "time_s",
        [f"{one:.6f}" for one in stepped(1.7e9 + TIME, 0.4, [800])],
        802,
        "runs backwards",
        "100",
    ),
    "a date": (
        "time",
        [f"2024-01-02 03:04:{one:09.6f}" for one in stepped(TIME + 10, 0.2, [7])],
        9,
        "runs backwards",
        "100",
    ),
    "seven digits": (
        "timestamp",
        [f"{one:.6e}" for one in NS],
        0,
        "have 7 digits and do not",
        "HZ",
    ),
    "seven digits of seconds": ("t", [f"{one / 1e9:.6e}" for one in NS], 0, "have 7 digits", "HZ"),
    "single precision": (
        "time_s",
        [str(np.float32(one / 1e9)) for one in NS],
        0,
        "do not tell neighbouring rows apart",
        "HZ",
    ),
    "a clock that stands still": ("ms", np.full(COUNT, 5), 0, "do not tell neighbouring", "HZ"),
}


@pytest.mark.parametrize("name", NO_TIME)
def test_a_time_that_cannot_be_used_can_be_done_without(logs, name):
    column, stamps, line, words, rate = NO_TIME[name]
    # a comment and a blank line are counted, too
    text = rows(stamps, TEMP, *GYRO.T)
    for above in (0, 2):
        body = text.replace("\n", "\n# marker\n\n", 1) if above else text
        log = logs.file("log.csv", f"{column},temp,{OWN}\n{body}")
        where = f"log.csv:{line + above}: column" if line else "log.csv: column"
        typed = f"--names _,temp,{OWN} --rate {rate}"
        logs.rejected(log, f"{where} {column}: ", words, typed)
        assert "e+27" not in logs.said(log)
    columns = logs.imported(log, "--names", logs.proposed(log), "--rate", "100")[1]
    logs.check_gyro(columns, time=False)


def test_a_name_that_an_option_cannot_hold_is_proposed_without_its_comma(logs):
    text = rows(stepped(US, 50_000, [500]), *GYRO.T)
    log = logs.file("log.csv", f'us,"gyro, x_dps",gy_dps,gz_dps\n{text}')
    logs.rejected(log, "log.csv:502", "'_,gyro  x_dps,gy_dps,gz_dps' --rate 100")
