"""Raw text files as loggers, spreadsheets and serial ports write them: what was measured is read,
or one line says what to type.
"""

import binascii
import functools
import json
import operator
import re
import subprocess

import numpy as np
import pytest
from asking import ROOT, run, said
from reading_logs import (
    COUNT,
    FORCE,
    GYRO,
    MPS2,
    MS,
    NAMES,
    NS,
    OTHER,
    OWN,
    RADIANS,
    RATE_HZ,
    RNG,
    STEPS,
    TEMP,
    TIME,
    US,
    plain,
    rows,
    stamped_rows,
)


def sentence(text, crc=False):
    data = text.encode()
    if crc:
        return f"${text}*{binascii.crc_hqx(data, 0):04X}\r\n"
    return f"${text}*{functools.reduce(operator.xor, data):02X}\r\n"


def vnimu(place):
    force, gyro = FORCE[place] * 9.80665, np.radians(GYRO[place])
    fields = ["+000.1000,+000.2000,-000.4000", *(f"{one:+08.5f}" for one in force)]
    fields += [*(f"{one:+.8f}" for one in gyro), f"{TEMP[place]:+.3f}", "+101.325"]
    return "VNIMU," + ",".join(fields)


def dated(count, step_ms, form):
    """Times from 23:59:59 on, in fields of a form: h, m, s, ms."""
    for one in range(86_399_000, 86_399_000 + count * step_ms, step_ms):
        hour, minute = one // 3_600_000 % 24, one // 60_000 % 60
        yield form.format(
            h=hour, m=minute, s=one // 1000 % 60, ms=one % 1000, d=1 + one // 86_400_000
        )


UNITS = "gyro_{}_dps", "accel_{}_g"
NIGHT = list(dated(COUNT, 10, "{h:02d}:{m:02d}:{s:02d}.{ms:03d}"))
CHIP = list(dated(COUNT, 10, "2023-3-{d} {h}:{m}:{s}.{ms}"))  # 16:44:16.5 is 5 ms after 16:44:16
COLON = list(dated(COUNT, 10, "2023/03/{d} {h}:{m:02d}:{s:02d}:{ms:03d}"))
TABLES = {  # texts, all of TIME and GYRO
    "semicolons": NAMES.replace(",", ";") + plain(";"),
    "tabs": NAMES.replace(",", "\t") + plain("\t"),
    "spaces": NAMES.replace(",", "  ") + plain("   "),
    "comma and space": NAMES.replace(",", ", ") + plain(", "),
    "decimal commas": NAMES.replace(",", ";") + plain(";").replace(".", ","),
    "decimal commas and tabs": NAMES.replace(",", "\t") + plain("\t").replace(".", ","),
    "crlf": (NAMES + plain()).replace("\n", "\r\n"),
    "byte order mark": "\ufeff" + NAMES + plain(),
    "excel": "sep=;\n" + NAMES.replace(",", ";") + plain(";"),
    "end of row": NAMES.replace("\n", ",\n") + plain(end=","),
    "end of row, of numbers only": NAMES + plain(end=","),
    "preamble": f"Datalogger 7\nSerial number;12;rev 3\nStart: 2024-01-02\n\n{NAMES}{plain()}",
    "preamble of pairs": f'version,1.3\ntscale,0.001\nid,"bench, left"\n{NAMES}{plain()}',
    "comments": f"// made by a logger\n// rate: 100 Hz\n% third\n{NAMES}{plain()}",
    "two rows, units": "time,gx,gy,gz\ns,deg/s,deg/s,deg/s\n" + plain(),
    "two rows, brackets": "Time;Gyro X;Gyro Y;Gyro Z\n[s]" + ";[\u00b0/s]" * 3 + "\n" + plain(";"),
    "two rows, groups": "Time,Gyroscope,,\n,X (deg/s),Y (deg/s),Z (deg/s)\n" + plain(),
    "three rows": ";Gyro;Gyro;Gyro\nTime;X;Y;Z\ns;deg/s;deg/s;deg/s\n" + plain(";"),
    "names in a comment": "# t gx_dps gy_dps gz_dps\n" + plain(" "),
    "names in a comment of percent": f"%{NAMES}{plain()}",
    "dates beside it": "t,gx_dps,gy_dps,gz_dps,date\n" + plain(end=",2024-01-02 03:04:05"),
    "bars": NAMES.replace(",", "|") + plain("|"),
    "comments below": NAMES + plain().replace("\n", "\n# marker\n", 3),
    "rows of separators below": NAMES + plain() + ",,,\n" * 3,
    "times of day": f"rtcDate,rtcTime,{OWN},\n"
    + stamped_rows(",", ["01/02/2021"] * COUNT, NIGHT, *GYRO.T),
    "blank lines below": NAMES + plain().replace("\n", "\n\n", 3),
}


@pytest.mark.parametrize("name", TABLES)
def test_what_stands_between_and_above_the_numbers(logs, name):
    logs.check_gyro(logs.imported(logs.file("log.csv", TABLES[name]))[1])


DATES = {
    "WitMotion": "Chiptime\twx(deg/s)\twy(deg/s)\twz(deg/s)\tT(\u00b0)\t\n"
    + stamped_rows("\t", CHIP, *GYRO.T, TEMP, [""] * COUNT),
    "milliseconds behind a colon": f"Time,{OWN},T (C)\n" + stamped_rows(",", COLON, *GYRO.T, TEMP),
}


@pytest.mark.parametrize("name", DATES)
def test_dates_of_loggers(logs, name):
    columns = logs.imported(logs.file("log.txt", DATES[name]))[1]
    logs.check_gyro(columns, time=False)
    logs.check_stamps(columns, int(np.datetime64("2023-03-01T23:59:59", "ns")) + NS)
    np.testing.assert_allclose(np.float64(columns["temp_degC"]), TEMP)


def test_dates_of_whole_seconds_are_in_seconds(logs):
    dates = dated(COUNT, 1000, "2021-03-0{d} {h:02d}:{m:02d}:{s:02d}")
    log = logs.file("log.csv", f"time,{OWN}\n" + stamped_rows(",", dates, *GYRO.T))
    assert "time -> time_s, s as it is written" in logs.said(log)
    assert set(np.diff(np.float64(logs.imported(log)[1]["time_s"]))) == {1.0}


def test_the_factors_of_a_log_of_gyroflow(logs):
    rad_s, g = 0.00122173047, 0.00048828125
    head = f"GYROFLOW IMU LOG\nversion,1.3\nid,logger\ntscale,0.01\ngscale,{rad_s}\nascale,{g}\n"
    counts, force = np.round(GYRO * 100), np.round(FORCE / g)
    body = rows(STEPS, *counts.T, *force.T)
    columns = logs.imported(logs.file("log.gcsv", f"{head}t,gx,gy,gz,ax,ay,az\n{body}"))[1]
    np.testing.assert_allclose(np.float64(columns["time_s"]), TIME)
    for axis, name in enumerate("xyz"):
        rates, forces = (np.float64(columns[one.format(name)]) for one in UNITS)
        np.testing.assert_allclose(rates, np.degrees(counts[:, axis] * rad_s), rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(forces, force[:, axis] * g, rtol=1e-7)


def test_an_index_of_pandas_and_columns_of_text_and_of_nothing_are_beside_it(logs):
    text = "".join(
        f"{place},{place / 100:.2f},imu_link,{x:.5f},{y:.5f},{z:.5f},\n"
        for place, (x, y, z) in enumerate(GYRO.tolist())
    )
    log = logs.file("log.csv", ",time,frame_id,wx_dps,wy_dps,wz_dps,note\n" + text)
    said = logs.said(log)
    assert "skipped: frame_id (text), note (empty)" in said
    columns = logs.imported(log)[1]
    logs.check_gyro(columns)
    assert columns["column_1"][:3] == ("0", "1", "2")


def stamped(ns, *columns):
    """Text of stamps, words and numbers with nine decimals."""
    return "".join(
        ",".join(one if isinstance(one, str) else f"{one:.9f}" for one in (f"{stamp}", *row)) + "\n"
        for stamp, *row in zip(ns.tolist(), *columns)
    )


def test_names_of_a_rostopic_and_of_euroc(logs):
    gyro = np.radians(GYRO)
    ns = 1_403_636_579_758_555_392 + np.arange(COUNT) * 10_000_000
    text = (
        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
        "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
    ) + stamped(ns, *gyro.T, *(FORCE.T * 9.80665))
    columns = logs.imported(logs.file("data.csv", text))[1]
    logs.check_gyro(columns, time=False)
    logs.check_stamps(columns, ns)
    np.testing.assert_allclose(np.float64(columns["accel_z_g"]), FORCE[:, 2], atol=1e-6)
    text = (
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,"
        "field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z\n"
    ) + stamped(ns, map(str, range(COUNT)), map(str, ns), ["imu"] * COUNT, *gyro.T)
    log = logs.file("echo.csv", text)
    columns = logs.imported(log, "--unit", "gyro=rad/s")[1]
    logs.check_gyro(columns, time=False)
    logs.check_stamps(columns, ns)


def test_a_column_in_microseconds(logs):
    for step in (2000, 10_000, 200_000):  # 500 Hz to 5 Hz
        stamps = 77_000_000 + np.arange(COUNT) * step
        log = logs.file("log.csv", "usec,gx_dps,gy_dps,gz_dps\n" + rows(stamps, *GYRO.T))
        logs.check_stamps(logs.imported(log)[1], stamps * 1000)
    log = logs.file("log.csv", f"usec,{OWN}\n" + rows(US, *GYRO.T))
    logs.check_gyro(logs.imported(log, "--rate", "100")[1])


def test_seconds_and_their_parts_in_two_columns(logs):
    stamps = 1_700_000_000 * 10**9 + np.arange(COUNT) * 10_000_000
    for names, tick in ((("sec", "usec"), 1000), (("stamp.secs", "stamp.nsecs"), 1)):
        text = f"{','.join(names)},gx_dps,gy_dps,gz_dps\n" + "".join(
            f"{ns // 10**9},{ns % 10**9 // tick},{x},{y},{z}\n"
            for ns, (x, y, z) in zip(stamps.tolist(), GYRO.tolist())
        )
        columns = logs.imported(logs.file("log.csv", text))[1]
        logs.check_stamps(columns, stamps)
        logs.check_gyro(columns, time=False)


# Files without names.


@pytest.mark.parametrize("name, separator", [("a.csv", ","), ("a.txt", " "), ("a.tsv", "\t")])
def test_names_are_asked_for_and_taken(logs, name, separator):
    for clock, stamps in (("time_s", US / 1e6), ("time_us", US)):
        log = logs.file(name, rows(stamps, *GYRO.T, TEMP, separator=separator))
        proposed = f"--names {clock},gyro_x,gyro_y,gyro_z,temp_degC"
        alone = "If columns 2 to 4 are a gyro", "a linear acceleration looks the same"
        logs.rejected(log, f"{name}:1: no names", *alone, proposed)
    columns = logs.imported(log, "--names", "time_us,gx_dps,gy_dps,gz_dps,_")[1]
    logs.check_gyro(columns)
    assert set(columns) == {"time_s", *(f"gyro_{a}_dps" for a in "xyz")}


def test_what_the_refusal_proposes_can_be_typed(logs):
    for columns in ((US, *GYRO.T), (US, *GYRO.T, TEMP, TEMP, TEMP)):
        log = logs.file("log.csv", rows(*columns))
        logs.check_gyro(logs.imported(log, "--names", logs.proposed(log))[1])
    log = logs.file("log.csv", rows(*GYRO.T))
    names = logs.proposed(log)
    logs.rejected(log, "--rate HZ", options=("--names", names))
    logs.imported(log, "--names", names, "--rate", "100")
    clock = [f"12h{n // 60 % 60:02d}m{n % 60:02d}" for n in range(COUNT)]
    temp = [f"{one}" if place % 100 != 50 else "off" for place, one in enumerate(TEMP)]
    for header, columns, why, rate in (
        (f"time,{OWN}", (clock, *GYRO.T), ":2: column time: not a number", ["--rate", "100"]),
        (f"t,{OWN},temp", (TIME, *GYRO.T, temp), ":52: column temp: not a number: 'off'", []),
    ):
        log = logs.file("log.csv", f"{header}\n{rows(*columns)}")
        logs.rejected(log, f"log.csv{why}", *rate[:1])
        columns = logs.imported(log, "--names", logs.proposed(log), *rate)[1]
        logs.check_gyro(columns, time=not rate)


FIELD = np.round(RNG.normal([20.0, -10.0, 42.0], 0.3, (COUNT, 3)), 3)
COUNTS = np.round(FORCE * 16384)
BACK = STEPS % 256
GYROS, FORCES = "gyro_x,gyro_y,gyro_z", "accel_x_{0},accel_y_{0},accel_z_{0}"
SHOWN = {  # columns: what their numbers show
    "ns, m/s^2, gyro": ((NS, *MPS2.T, *RADIANS.T), f"time_ns,{FORCES.format('m_s2')},{GYROS}"),
    "gyro before g": ((TIME, *GYRO.T, *FORCE.T), f"time_s,{GYROS},{FORCES.format('g')}"),
    "mg": ((MS, *FORCE.T * 1000, *GYRO.T), f"time_ms,{FORCES.format('mg')},{GYROS}"),
    "counts": ((US, *COUNTS.T, *GYRO.T), f"time_us,{FORCES.format('counts')},{GYROS}"),
    "a counter of rows": (
        (STEPS, TIME, *FORCE.T, *GYRO.T),
        f"_,time_s,{FORCES.format('g')},{GYROS}",
    ),
    "one that begins again": ((BACK, MS, *GYRO.T), f"_,time_ms,{GYROS}"),
    "a field": ((TIME, *FORCE.T, *GYRO.T, *FIELD.T), f"time_s,{FORCES.format('g')},{GYROS},_,_,_"),
    "temperature between": (
        (MS, *FORCE.T, TEMP, *GYRO.T),
        f"time_ms,{FORCES.format('g')},temp_degC,{GYROS}",
    ),
    "two of them": ((MS, *GYRO.T, TEMP, TEMP), f"time_ms,{GYROS},_,_"),
    "zeros": ((MS, *GYRO.T, 0 * TEMP), f"time_ms,{GYROS},_"),
}
UNSHOWN = {
    "an accelerometer alone": (TIME, *FORCE.T),
    "a field alone": (TIME, *FIELD.T),
    "an accelerometer and a field": (TIME, *FORCE.T, *FIELD.T),
    "two gyros": (TIME, *GYRO.T, *OTHER.T),
    "one axis": (TIME, GYRO[:, 0]),
    "a doubtful tick": (STEPS * 100, *GYRO.T),
    "many columns": (TIME, *GYRO.T, *OTHER.T, *GYRO.T, *OTHER.T, *GYRO.T),
}


@pytest.mark.parametrize("name", SHOWN)
def test_the_proposed_names_are_those_that_the_numbers_show(logs, name):
    columns, names = SHOWN[name]
    log = logs.file("log.csv", stamped_rows(",", *columns))
    logs.rejected(log, f"log.csv:1: no names above the {len(columns)} columns")
    assert logs.proposed(log) == names
    unit = "rad/s" if any(np.shares_memory(one, RADIANS) for one in columns) else "deg/s"
    logs.check_gyro(logs.imported(log, "--names", names, "--unit", f"gyro={unit}")[1])


@pytest.mark.parametrize("name", UNSHOWN)
def test_names_that_the_numbers_do_not_show_are_to_be_replaced(logs, name):
    columns = UNSHOWN[name]
    log = logs.file("log.csv", stamped_rows(",", *columns))
    logs.rejected(log, f"log.csv:1: no names above the {len(columns)} columns", "NAME_1,NAME_2")
    logs.rejected(log, "NAME_1 stands for a name", options=("--names", logs.proposed(log)))


def clock_of(place, marks):
    second = 86_399_000 + place * 10  # ms: over midnight
    of = second // 3_600_000 % 24, second // 60_000 % 60, second // 1000 % 60, second % 1000
    return marks.format("{:02d}:{:02d}:{:02d}.{:03d}".format(*of))


MONITORS = {  # (marks of the time of day, separator, line above)
    "Arduino IDE": ("{} -> ", ",", ""),
    "names": ("{} -> ", ",", OWN),
    "spaces": ("{} -> ", " ", ""),
    "tabs, after a greeting": ("{} -> ", "\t", "IMU ready"),
    "PlatformIO": ("{} > ", ",", ""),
    "brackets": ("[{}] ", ", ", ""),
}


@pytest.mark.parametrize("name", MONITORS)
def test_a_serial_monitor_with_the_time_of_day(logs, name):
    marks, separator, above = MONITORS[name]
    lines = [above] * bool(above) + rows(*GYRO.T, separator=separator).splitlines()
    shift = len(lines) - COUNT
    text = "".join(clock_of(at - shift, marks) + one + "\n" for at, one in enumerate(lines))
    log = logs.file("serial.txt", text)
    unit = ("--unit", "gyro=deg/s")
    if above == OWN:
        logs.check_gyro(logs.imported(log)[1])
        return
    logs.rejected(log, "no names above the 4 columns")
    assert logs.proposed(log) == "time_s,gyro_x,gyro_y,gyro_z"
    for names in (logs.proposed(log), "gyro_x,gyro_y,gyro_z"):
        logs.check_gyro(logs.imported(log, "--names", names, *unit)[1])


def adafruit(x, y, z, a, b, c):
    return (
        f"Acceleration X: {a}, Y: {b}, Z: {c} m/s^2\nRotation X: {x}, Y: {y}, Z: {z} rad/s\n"
        "Temperature: 25.00 degC\n\n"
    )


RAW = "gyro=deg/s"
LABELLED = {  # text of x, y, z of a gyro in deg/s or rad/s, and of an accelerometer; --unit
    "spaces": (lambda x, y, z, *_: f"gx:{x} gy:{y} gz:{z}\n", RAW),
    "plotter": (lambda x, y, z, *_: f"GyroX:{x},GyroY:{y},GyroZ:{z}\r\n", RAW),
    "tabs and spaces": (lambda x, y, z, *_: f"gyroX : {x}\tgyroY : {y}\tgyroZ : {z}\n", RAW),
    "equals, with text": (lambda x, y, z, *_: f"gx={x} gy={y} gz={z}\nall is well\n", RAW),
    "a vector": (lambda x, y, z, *_: f"Accel: 0.1, 0.2, 9.8 Gyro: {x}, {y}, {z}\n", RAW),
    "json": (lambda x, y, z, *_: f'{{"gx": {x}, "gy": {y}, "gz": {z}, "n": 3}}\n', RAW),
    "teleplot": (lambda x, y, z, *_: f">gx:{x}\n>gy:{y}\n>gz:{z}\n", RAW),
    "units, several lines": (adafruit, "gyro=rad/s"),
}


@pytest.mark.parametrize("name", LABELLED)
def test_a_label_before_each_number(logs, name):
    written, unit = LABELLED[name]
    gyro = RADIANS if unit.endswith("rad/s") else GYRO
    text = "".join(written(*one, *force) for one, force in zip(gyro.tolist(), MPS2.tolist()))
    log = logs.file("serial.txt", f"IMU ready\n{text}")
    assert "a label before each number" in logs.said(log, "--rate", "100")
    columns = logs.imported(log, "--rate", "100", "--unit", unit)[1]
    logs.check_gyro(columns, time=False)
    if name.startswith("units"):
        assert "rad/s by its name" in logs.said(log, "--rate", "100")
        np.testing.assert_allclose(np.float64(columns["accel_z_g"]), FORCE[:, 2], atol=1e-6)
        assert set(columns["temp_degC"]) == {"25"}


def test_labels_with_their_time_and_a_lost_value(logs):
    lines = [f"t:{n * 10} gx:{x} gy:{y} gz:{z}\n" for n, (x, y, z) in enumerate(GYRO.tolist())]
    log = logs.file("serial.txt", "".join(lines))
    logs.check_gyro(logs.imported(log, "--unit", RAW)[1])
    lines[600] = lines[600].partition(" gz")[0] + "\n"
    log = logs.file("serial.txt", "".join(lines))
    assert "1 of 1200 rows omitted: no value of gz" in logs.said(log, "--unit", RAW)
    clock = [clock_of(place, "{} -> ") + one for place, one in enumerate(lines[:600])]
    log = logs.file("serial.txt", "".join(clock).replace("t:", "n:"))
    times = np.float64(logs.imported(log, "--unit", RAW)[1]["time_s"])
    np.testing.assert_allclose(np.diff(times), 0.01, atol=1e-6)


def test_names_replace_those_of_the_file(logs):
    log = logs.file("log.csv", "a,b,c,d\n1,u,v,w\n"[:8] + plain())
    logs.rejected(log, "no gyro", "--names")
    logs.check_gyro(logs.imported(log, "--names", "t,gx_dps,gy_dps,gz_dps")[1])
    logs.rejected(log, "--names: 3 names", "4 columns", options=("--names", "t,gx,gy"))
    logs.rejected(log, "appears twice", options=("--names", "t,gx_dps,gx_dps,gz_dps"))


def test_a_row_that_was_cut_off_is_no_header_and_no_sample(logs):
    log = logs.file("log.csv", "0.31,7\n" + rows(US, *GYRO.T) + "12000000,0.1")
    logs.rejected(log, "log.csv:2: no names")
    names = ("--names", "us,gx_dps,gy_dps,gz_dps")
    assert f"line {COUNT + 2} is cut off" in logs.said(log, *names)
    logs.check_gyro(logs.imported(log, *names)[1])


def test_vectornav(logs):
    for crc in (False, True):
        text = "".join(
            sentence(vnimu(place), crc) + sentence("VNYPR,+1.0,+2.0,+3.0") * (place % 3 == 0)
            for place in range(COUNT)
        )
        log = logs.file("log.txt", text)
        logs.rejected(log, "--rate HZ")
        columns = logs.imported(log, "--rate", "100")[1]
        logs.check_gyro(columns, time=False)
        np.testing.assert_allclose(np.float64(columns["accel_z_g"]), FORCE[:, 2], atol=1e-5)
        np.testing.assert_allclose(np.float64(columns["temp_degC"]), TEMP)


def test_with_a_time_in_front_and_cut_off_at_both_ends(logs):
    text = "".join(f"{place / 100:.2f}," + sentence(vnimu(place)) for place in range(COUNT))
    log = logs.file("log.txt", text[40:] + "12.00,$VNIMU,+0.1,")
    logs.check_gyro(logs.imported(log)[1], first=1)


def test_a_damaged_sentence_is_named(logs):
    lines = [sentence(vnimu(place)) for place in range(COUNT)]
    for damaged in (lines[700].replace("101.325", "101.326"), lines[700][:40] + "\r\n"):
        log = logs.file("log.txt", "".join([*lines[:700], damaged, *lines[701:]]))
        logs.rejected(log, "log.txt:701: a damaged sentence", options=("--rate", "100"))


def test_sentences_of_another_maker_are_named_by_their_user(logs):
    text = "".join(
        sentence(f"PXIMU,{place * 10},{x},{y},{z}") for place, (x, y, z) in enumerate(GYRO.tolist())
    )
    log = logs.file("log.txt", text)
    logs.rejected(log, "log.txt:1: no names", "--names")
    logs.check_gyro(logs.imported(log, "--names", "ms,gx_dps,gy_dps,gz_dps")[1])


TAGGED = {  # rows of two sensors: text above, one of each, what to type
    "GnssLogger": (
        "# Raw,utcTimeMillis,TimeNanos,x\n"
        "# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,"
        "UncalGyroZRadPerSec\n# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,x,y,z\n#\n",
        lambda n, x, y, z: f"UncalGyro,{n * 10},{n * 10**7},{x},{y},{z}\n",
        lambda n, x, y, z: f"UncalAccel,{n * 10},{n * 10**7},{x},{y},{z}\n",
        ["--unit", "gyro=deg/s"],
    ),
    "a column": (
        "t;sensor;x;y;z\n",
        lambda n, x, y, z: f"{n / 100:.2f};gyro dps;{x};{y};{z}\n",
        lambda n, x, y, z: f"{n / 100:.2f};accel g;{x};{y};{z}\n",
        ["--names", "t,_,gyro_x_dps,gyro_y_dps,gyro_z_dps"],
    ),
    "an IMU and a GPS": (
        "type,t,gx_dps,gy_dps,gz_dps\n",
        lambda n, x, y, z: f"IMU,{n / 100:.2f},{x},{y},{z}\n",
        lambda n, x, y, z: f"GPS,{n / 100:.2f},48.1,11.6\n" * (n % 10 == 5),
        [],
    ),
    "names for each, and a GPS that begins late": (
        "IMU t gx_dps gy_dps gz_dps\nGPS t lat lon\n",
        lambda n, x, y, z: f"IMU {n / 100:.2f} {x} {y} {z}\n",
        lambda n, x, y, z: f"GPS {n / 100:.2f} 48.1 11.6\n" * (n > 700),
        [],
    ),
    "more fields of the other": (
        "",
        lambda n, x, y, z: f"imu0\t{n / 100:.2f}\t{x}\t{y}\t{z}\n",
        lambda n, x, y, z: f"gnss\t{n}\t1\t2\t3\t4\tfix\n" * (n % 5 == 0),
        ["--names", "_,t,gx_dps,gy_dps,gz_dps"],
    ),
}


@pytest.mark.parametrize("name", TAGGED)
def test_of_rows_of_several_sensors_those_of_the_gyro_are_read(logs, name):
    head, gyro, other, options = TAGGED[name]
    both = zip(range(COUNT), GYRO.tolist(), FORCE.tolist())
    text = "".join(gyro(n, *rate) + other(n, *force) for n, rate, force in both)
    log = logs.file("log.txt", head + text)
    logs.check_gyro(logs.imported(log, *options)[1])
    tags = [
        re.search("[A-Za-z][a-z0-9A-Z ]+(?=[\t,; ])", one(705, *GYRO[0]))[0]
        for one in (gyro, other)
    ]
    said = logs.said(log, *options)
    assert all(
        f"{words} {tag.split()[0]}" in said
        for words, tag in zip(("only rows tagged", "those of"), tags)
    )


def test_a_damaged_row_among_rows_of_several_sensors_is_an_error(logs):
    text = "".join(
        f"IMU,{n / 100:.2f},{x},0,0\nGPS,1,2\n" for n, x in enumerate(GYRO[:, 0].tolist())
    )
    log = logs.file(
        "log.csv", "IMU,t,gx_dps,gy_dps,gz_dps\n" + text.replace("IMU,6.00,", "IMU,6.00,,,")
    )
    logs.rejected(log, "log.csv:1202: 7 fields")


def test_rows_that_look_like_comments_are_read_as_the_message_says(logs):
    """NovAtel: # or % before each row, ; behind its header."""
    text = "".join(
        f"%RAWIMUSA,1105,{n / 100:.2f};{n / 100:.2f},{x},{y},{z}*5aa9\n"
        for n, (x, y, z) in enumerate(GYRO.tolist())
    )
    log = logs.file("my log.asc", text)
    logs.rejected(log, "lines are comments", "type tr")
    command, _, new = logs.said(log).split("type ")[1].strip().rpartition(", and use ")
    subprocess.run(command, shell=True, cwd=logs.work, check=True)
    names = ("--names", "_,_,_,t,gx_dps,gy_dps,gz_dps,_")
    logs.check_gyro(logs.imported(logs.work / new, *names)[1])


def test_a_binary_file_of_no_known_format_is_named(logs):
    for head in (b"\xfa\xff\x3e\x00", b"\xb5\x62\x10\x02\x00", b"MAGIC\0"):
        log = logs.work / "MT_1.mtb"
        log.write_bytes(head * 500)
        logs.rejected(log, "a binary file of a format that davarlab does not read", "Export it")


def test_a_value_of_a_column_beside_it_that_is_too_large_has_a_way_on(logs):
    values = ["1.797e308" if n == 700 else "1" for n in range(COUNT)]
    log = logs.file("log.csv", f"time_s,{OWN},gain\n" + rows(TIME, *GYRO.T, values))
    logs.rejected(log, "column gain: not a finite number", "To do without this column")
    typed = logs.said(log).split("--names ")[1].split()[0]
    logs.check_gyro(logs.imported(log, "--names", typed.strip("'"))[1])


THOUSANDS = "".join(f"{n};{n % 7},{n % 1000:03d}\n" if n % 7 else f"{n};{n}\n" for n in range(300))
UNREADABLE = {
    "decimal commas between commas": (NAMES + plain().replace(".", ","), "Type"),
    "thousands": ("t;gx_raw\n" + THOUSANDS, "tr -d ,"),
    "twins": ("t,x,y,z,x,y,z\n" + rows(TIME, *GYRO.T, *FORCE.T), "--names"),
    "too few names": ("t,gx_dps\n" + plain(), "--names"),
    "text in a gyro": (NAMES + plain().replace("0.02,", "0.02,x", 1), ":4: column gx_dps"),
    "the phase of a clock": ("time_s,phase_s\n" + rows(TIME, TEMP), "use davar.adev in Python"),
    "a clock of text": ("time,gx_dps\n12h00m01.1,5\n12h00m01.2,6\n", ":2: column time"),
    "a row too long": (NAMES + "1,2,3,4,5\n" + plain(), ":2: 5 fields"),
    "no numbers": ("Some text,\nand more of it\n", ":2: no numbers"),
    "a serial monitor": ("12:00:01.123 -> 1,2,3\n" * 99, ":1: no names above the 4 columns"),
    "UTF-16": ("\ufefft,gx_dps\n1,2\n", "iconv -f UTF-16 -t UTF-8 "),
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_what_cannot_be_told_says_what_to_type(logs, name):
    text, words = UNREADABLE[name]
    log = logs.file("log.csv", text)
    if name == "UTF-16":
        log.write_bytes(text.encode("utf-16-le"))
    logs.rejected(log, "log.csv", words)


ARW = 0.3 / RATE_HZ**0.5 * 60
TUTORIAL = ROOT / "data/tutorial_model.toml"


def test_without_a_model_it_starts_from_the_data(logs):
    """The documented path, on a file of a stranger: white noise of 0.3 deg/s."""
    log = logs.file("log.csv", "usec;wx_dps;wy_dps;wz_dps\n" + rows(US, *GYRO.T, separator=";"))
    model = logs.work / "fitted.toml"
    for more, note in ((("-o", model), "gyro_z_dps are fitted"), (("-m", TUTORIAL), "")):
        done = run("fit", log, *more, "--json")
        assert (done.returncode, note in done.stderr) == (0, True), done.stderr
        found = json.loads(done.stdout)["effects"][0]
        assert found["kind"] == "angle_random_walk"
        value = found["parameters"]["coefficient_deg_per_sqrt_h"]["value"]
        assert abs(value / ARW - 1) <= 0.1  # of 1200 samples: 2 %, five times
    assert len(said("fit", log, "--axes", "gyro")["axes"]) == 3
    said("compare", log, "-m", model, statuses=(0, 1))


def test_a_fit_that_cannot_be_says_the_way_on(logs):
    log = logs.file("log.csv", "usec;wz_dps\n" + rows(US, GYRO[:, 2], separator=";"))
    why = "Remove rate_hz from the model, or fit without -m"
    logs.refused(why, "fit", log, "-m", logs.model, lines=None)
    log = logs.file("log.csv", "usec,accel_x,accel_y,accel_z\n" + rows(US, *FORCE.T))
    logs.refused("--axes accel", "fit", log, "--sensor", "accel", lines=None)
