"""tools/davarlab import, and every command that takes a recording, on other people's logs: what the
formats' own libraries wrote comes back.
"""

import contextlib
import json
import os
import re
import sqlite3
from pathlib import Path

import numpy as np
import pytest
import writing_logs as writing
from asking import MODEL, ROOT, run, said
from davarlab.logs import sensor, ulog
from scipy import io

REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real")).parent / "logs"
FILTERED = "vehicle_angular_velocity"  # of PX4


SINCE_START, OF_BOOT = "since the start", "since boot"
LOGS = {  # name: (writer, origin of the stamps; what of it is not checked: options of check)
    "log.log": (writing.dataflash_text, OF_BOOT, {}),
    "log.bag": (writing.ros1, "unix", {}),
    "log.mat": (writing.matlab_5, SINCE_START, {"temp": False}),
    "new.mat": (writing.matlab_73, SINCE_START, {}),
    "log.npz": (writing.npz, "unix", {}),
    "apart.npz": (writing.apart, "unix", {"accel": False}),  # a temperature with its own time
    "log.npy": (
        writing.npy,
        SINCE_START,
        {"accel": False, "temp": False},
        *("--unit", "gyro=deg/s"),
    ),
    "log.parquet": (writing.table, "unix", {}),
}
UNITS = {  # logs of several units: (writer, name of a unit)
    "log.ulg": (writing.ulog, "sensor_gyro"),
    "log.bin": (writing.dataflash, "IMU"),
}


def stamps_of(truth, origin):
    if origin == OF_BOOT:
        return np.array(writing.boot_us(truth)) * 1000
    return truth.stamps_ns - (writing.START_NS if origin == SINCE_START else 0)


@pytest.mark.parametrize("name", LOGS)
def test_what_the_library_of_a_format_wrote_comes_back(logs, name):
    write, origin, checked, *how = LOGS[name]
    write(logs.work / name, logs.truth)
    _, columns = logs.imported(logs.work / name, *how)
    logs.check(columns, **checked)
    logs.check_stamps(columns, stamps_of(logs.truth, origin))


@pytest.mark.parametrize("name", UNITS)
def test_of_several_units_one_is_named(logs, name):
    write, unit = UNITS[name]
    log = logs.work / name
    write(log, logs.truth)
    logs.rejected(log, "--sensor", f"{unit}:0", f"{unit}:1")
    _, columns = logs.imported(log, "--sensor", f"{unit}:1")
    logs.check(columns, gyro=2, accel=name != "log.ulg")
    _, columns = logs.imported(log, "--sensor", f"{unit}:0")
    logs.check(columns)
    logs.check_stamps(columns, stamps_of(logs.truth, OF_BOOT))
    if name == "log.ulg":  # each second sample of accel is its own, the others lie between
        between = (logs.truth.accel[2, 0] + logs.truth.accel[2, 2]) / 2
        assert abs(float(columns["accel_z_g"][1]) - between) < 5e-7


def test_of_the_topics_of_px4_the_raw_ones_are_chosen():
    """In every order of the log: a filtered topic has the same quantity, with less noise."""
    for turn in range(len(ulog.TOPICS)):
        names = [*ulog.TOPICS][turn:] + [*ulog.TOPICS][:turn]
        topics = {
            name: sensor.Sensor(
                name, frozenset(ulog.TOPICS[name][0]), 100, "0", ulog.TOPICS[name][1]
            )
            for name in names
        }
        found = sensor.companions([*topics.values()], topics["sensor_gyro"])
        assert [(one.name, what) for one, what in found] == [("sensor_accel", "accel")]
        two = [one for one in topics.values() if one.name in ("sensor_gyro", FILTERED)]
        assert sensor.chosen(two, None, "x.ulg").name == "sensor_gyro"


@pytest.mark.parametrize("storage", ["db3", "mcap"])
def test_ros_2_by_file_and_by_the_folder_of_a_bag(logs, storage):
    file = writing.ros2(logs.work / "bag", logs.truth, storage)
    for log in (file, file.parent):
        _, columns = logs.imported(log)
        logs.check(columns)
        logs.check_stamps(columns, logs.truth.stamps_ns)
    log = logs.work / f"log.{storage}"
    log.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    logs.rejected(log, log.name)


def test_two_topics_are_listed_and_one_is_chosen_by_name(logs):
    log = logs.work / "log.bag"
    writing.ros1(log, logs.truth, ("/imu", "/imu2"))
    logs.rejected(log, "--sensor", "/imu (", "/imu2 (")
    logs.rejected(log, "--sensor /imu3", "/imu2 (", options=("--sensor", "/imu3"))
    logs.check(logs.imported(log, "--sensor", "/imu2")[1], temp=False)
    listed = json.loads(run("import", log, "--list", "--json").stdout)["sensors"]
    assert [(one["name"], one["samples"]) for one in listed] == [("/imu", 400), ("/imu2", 400)]


def test_message_types_of_ones_own(logs):
    bag, folder = logs.work / "log.bag", logs.work / "bag"
    writing.ros1(bag, logs.truth, ("/raw",))
    logs.check(logs.imported(bag)[1])
    logs.check(logs.imported(writing.ros2(folder, logs.truth, "mcap", ("/raw",)))[1])


def test_message_types_that_the_bag_does_not_bring(logs):
    bag = writing.ros2(logs.work / "bag", logs.truth, "db3", ("/raw",))
    with contextlib.closing(sqlite3.connect(bag)) as base, base:
        base.execute("DELETE FROM message_definitions")
    logs.rejected(bag, bag.name)
    folder = logs.work / "my_robot" / "msg"
    folder.mkdir(parents=True)
    (folder / "Raw.msg").write_text(writing.CUSTOM)
    logs.check(logs.imported(bag, "--types", folder / "Raw.msg")[1])
    logs.check(logs.imported(bag, "--types", logs.work / "my_robot")[1])


def test_every_command_takes_a_log(logs):
    log, own = logs.work / "log.npz", logs.work / "own.csv"
    logs.truth = writing.Truth(3000)
    writing.npz(log, logs.truth)
    logs.imported(log)
    logs.out.rename(own)
    model = logs.file("m.toml", MODEL.format(column="gyro_x_dps", n=2.0, b=1.0))
    one, other = (said("compare", path, "-m", model, statuses=(0, 1)) for path in (log, own))
    assert one["samples"] == 3000
    assert abs(one["error"] - other["error"]) < 5e-6


def rows_of(logs, name, header, row):
    rows = (row(place) for place in range(logs.truth.count))
    return logs.file(name, "\n".join([header, *rows, ""]))


def test_a_guess_is_shown_and_overridden(logs):
    def row(i):
        return f"  {i * 5}   {i % 50 * 100} {i % 31 * 10}\t{i % 7 * 100}"

    log = rows_of(logs, "log.txt", "t gx gy gz", row)
    done = run("import", log, "-o", logs.out)
    assert "--unit gx=UNIT" in done.stderr
    assert "gyro_x_counts" in done.stdout
    _, columns = logs.imported(log, "--unit", "gyro=0.0175", "--unit", "t=ms")
    np.testing.assert_allclose(np.float64(columns["gyro_x_dps"][:3]), [0, 1.75, 3.5])
    assert columns["time_s"][:3] == ("0", "0.005", "0.01")


def test_unix_times_survive(logs):
    ns = logs.truth.stamps_ns
    dates = ns.astype("datetime64[ns]")
    for column, stamps, digit in (
        ("time_s", [f"{one // 10**9}.{one % 10**9:09d}" for one in ns], 1),
        ("timestamp_ns", ns, 1),
        ("timestamp_us", ns // 1000, 1000),
        ("time", dates, 1),
    ):
        row = (lambda stamps: lambda i: f"{stamps[i]},{i % 5}")(stamps)
        log = rows_of(logs, "log.csv", f"{column},gyro_x_dps", row)
        logs.check_stamps(logs.imported(log)[1], ns // digit * digit)


TEXTS = [  # names, row, options, columns of the result
    (
        '"Time (s)","Gyroscope x (\u00b0/s)","Absolute","light"',
        '"{t:.3f}","{i5}.5",3,{i2}',
        (),
        {"gyro_x_dps": ("0.5", "1.5"), "light": ("0", "1")},
    ),
    ("t,gx_dps", '"{comma}","-{i5},5"', (), {"gyro_x_dps": ("-0.5", "-1.5")}),
    ("t,x", "{t:.3f},{i5}", ("--rename", "x=gyro_x_dps"), {"gyro_x_dps": ("0", "1")}),
    (
        "t;g",
        "{t:.3f};{i5}",
        ("--rename", "t=time_s", "--rename", "g=gyro_x_dps", "--scale", "gyro_x_dps=0.5"),
        {"time_s": ("0", "0.005"), "gyro_x_dps": ("0", "0.5")},
    ),
    (
        "t,imu0_gx_dps,imu1_gx_dps",
        "{t:.3f},{i5},{i2}",
        ("--sensor", "imu1_g_dps"),
        {"gyro_x_dps": ("0", "1")},
    ),
]


@pytest.mark.parametrize(
    "names, form, options, expected",
    TEXTS,
    ids=["quotes", "decimal commas in quotes", "renamed", "scaled", "two gyros"],
)
def test_columns_of_somebody_elses_name(logs, names, form, options, expected):
    def row(i):
        t = i * 0.005
        return form.format(t=t, comma=f"{t:.3f}".replace(".", ","), i5=i % 5, i2=i % 2)

    log = rows_of(logs, "log.csv", names, row)
    if options:
        logs.rejected(log, options[0], *(("imu0", "imu1") if "imu0" in names else ()))
    _, columns = logs.imported(log, *options)
    assert {name: columns[name][:2] for name in expected} == expected


def test_what_import_writes_holds_only_what_was_measured(logs):
    kept = [place for place in range(400) if not 100 <= place < 120]
    text = "".join(f"{place * 0.005:.3f};{place % 7}\n" for place in kept)
    assert len(logs.imported(logs.file("log.csv", "t;gx_dps\n" + text))[1]["time_s"]) == 380


@pytest.mark.parametrize("name", [*UNITS, *sorted(set(LOGS) - {"log.log", "apart.npz"})])
def test_a_log_cut_short_or_with_another_beginning(logs, name):
    log, (write, *_) = logs.work / name, {**LOGS, **UNITS}[name]
    write(log, logs.truth)
    data = log.read_bytes()
    for what, damaged in (
        ("empty", b""),
        ("half", data[: len(data) // 2]),
        ("short", data[:-5]),
        ("head", data[:20]),
        ("other", b"something else" + data[14:]),
    ):
        # padding of a text; the file proper begins behind 512 bytes
        if (name, what) not in (("log.mat", "short"), ("new.mat", "other")):
            log.write_bytes(damaged)
            named = ("--sensor", f"{UNITS[name][1]}:0") if name in UNITS else ()
            logs.rejected(log, name, options=named)


def test_nan_empty_topics_and_text_in_numbers(logs):
    logs.truth.gyro[1, 17] = np.nan
    for name, options in (
        ("log.ulg", ("--sensor", "sensor_gyro:0")),
        *((name, ()) for name in ("log.bag", "log.npz", "log.parquet")),
    ):
        {**LOGS, **UNITS}[name][0](logs.work / name, logs.truth)
        why = (name, "gyro_y_dps", "not a finite number at sample 18")
        logs.rejected(logs.work / name, *why, options=options)
    for text, *why in (
        ("t;gx_dps\n0,01;1\n0,02;one\n", "a.csv:3", "gx_dps", "not a number: 'one'"),
        ("t,gx_dps\n0.01,1\n0.02,true\n", "a.csv:3", "gx_dps", "not a number: 'true'"),
        ("t,gx_dps\n0.01,1\nnan,2\n", "a.csv:3", "column t: not a number: 'nan'"),
        ("a,b\n1,2\n3,4\n", "a.csv", "no gyro"),
    ):
        logs.rejected(logs.file("a.csv", text), *why)
    writing.ros1(logs.work / "empty.bag", writing.Truth(0))
    logs.rejected(logs.work / "empty.bag", "empty.bag")


def test_time_backwards_and_no_time(logs):
    logs.truth.stamps_ns[50] = logs.truth.stamps_ns[40]
    for name, write in (("log.npz", writing.npz), ("log.parquet", writing.table)):
        write(logs.work / name, logs.truth)
        logs.rejected(logs.work / name, name, "time runs backwards")
    logs.rejected(logs.file("c.csv", "gx_dps\n1\n2\n"), "no column time_s and no --rate")


@pytest.mark.parametrize("name", UNITS)
def test_a_log_that_was_cut_off_is_read_after_the_command_of_the_message(logs, name):
    log = logs.work / name
    UNITS[name][0](log, logs.truth, 1)
    whole = log.read_bytes()
    for cut in (1, 20):
        log.write_bytes(whole[:-cut])
        logs.rejected(log, "cut short", "head -c ")
        size = int(re.search(rf"Type head -c (\d+) {log} > NEW", logs.said(log))[1])
        log.write_bytes(whole[:size])
        found = np.float64(logs.imported(log)[1]["gyro_x_dps"])
        np.testing.assert_allclose(found, logs.truth.gyro[0][: len(found)], rtol=1e-6, atol=1e-8)
        assert logs.truth.count - 1 <= len(found) <= logs.truth.count


def test_arrays_of_matlab_whose_names_do_not_say_what_they_are(logs):
    truth, log = logs.truth, logs.work / "log.mat"
    fields = {"sig": truth.rad_s.T, "other": truth.m_s2.T, "R": np.eye(3)}
    io.savemat(log, {"data": fields, "t": truth.since_start})
    name = "data.sig as gyro"
    logs.rejected(log, "no gyro", f"{name} (unknown; 400 samples)", "--sensor NAME")
    logs.check(
        logs.imported(log, "--sensor", name, "--unit", "gyro=rad/s")[1], accel=False, temp=False
    )
    io.savemat(log, {"imu": {"wb": truth.rad_s.T, "fb": truth.m_s2.T, "t": truth.since_start}})
    logs.check(logs.imported(log, "--unit", "gyro=rad/s")[1], temp=False)
    io.savemat(log, {"note": "a timetable is an object, too"})
    logs.rejected(log, "no arrays of numbers", "writetimetable(NAME, 'log.csv')")


real = pytest.mark.skipif(not REAL.is_dir(), reason=f"no real logs in {REAL}")
REAL_LOGS = {  # name: (--sensor, samples, first stamp, mean temperature and how far off)
    "px4_cubeorange_at_rest_6s.ulg": ("sensor_combined:0", 1298, "", 40, 3),
    "arducopter_dataflash_51s.BIN": ("IMU", 1258, "402.644506", 27, 3),
    "ros1_xsens_mtig_at_rest_18s.bag": (None, 356, "1326899528.368658417", 20.8, 0.2),
}


@real
@pytest.mark.parametrize("name", REAL_LOGS)
def test_a_real_log(logs, name):
    sensor, samples, start, mean, off = REAL_LOGS[name]
    _, columns = logs.imported(REAL / name, *(("--sensor", sensor) if sensor else ()))
    assert len(columns["time_s"]) == samples
    assert columns["time_s"][0] == start or not start
    assert abs(np.mean(np.float64(columns["temp_degC"])) - mean) <= off
    if "at_rest" in name:
        assert abs(abs(np.mean(np.float64(columns["accel_z_g"]))) - 1) <= 0.05
        assert np.std(np.float64(columns["gyro_x_dps"])) < 1


@real
def test_matlab_with_two_imus_and_an_object_that_breaks_naive_readers(logs):
    log = REAL / "rimu_two_imus_40deg_steps.mat"
    logs.rejected(log, "--sensor", "giro_imu_dps", "giro_bno_dps")
    _, columns = logs.imported(log, "--sensor", "giro_bno_dps")
    assert len(columns["time_s"]) == 40000
    assert abs(np.mean(np.float64(columns["accel_z_g"][:2000])) - 0.95) <= 0.02
