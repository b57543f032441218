"""tools/davarlab import, and every command that takes a recording, on other people's logs: what the
formats' own libraries wrote comes back.
"""

import contextlib
import json
import os
import sqlite3
from pathlib import Path

import numpy as np
import pytest
import writing_logs as writing
from asking import ROOT, run
from importing import Logs

REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real")).parent / "logs"


@pytest.fixture
def logs(tmp_path):
    return Logs(tmp_path)


def test_px4_ulog_the_unit_named_with_its_temperature_and_the_accelerometer_at_its_stamps(logs):
    log = logs.work / "log.ulg"
    writing.ulog(log, logs.truth)
    logs.rejected(log, "log.ulg", "--sensor", "sensor_gyro:0", "sensor_gyro:1")
    _, columns = logs.imported(log, "--sensor", "sensor_gyro:1")
    logs.check(columns, gyro=2, accel=False)
    _, columns = logs.imported(log, "--sensor", "sensor_gyro:0")
    logs.check(columns)  # accel: each second sample is its own, the others lie between
    between = (logs.truth.accel[2, 0] + logs.truth.accel[2, 2]) / 2
    assert abs(float(columns["accel_z_g"][1]) - between) < 5e-7
    logs.check_stamps(columns, np.array(writing.boot_us(logs.truth)) * 1000)


def test_ardupilot_dataflash_by_instance(logs):
    log = logs.work / "log.bin"
    writing.dataflash(log, logs.truth)
    logs.rejected(log, "--sensor", "IMU:0", "IMU:1")
    _, columns = logs.imported(log, "--sensor", "IMU:1")
    logs.check(columns, gyro=2)
    logs.check_stamps(columns, np.array(writing.boot_us(logs.truth)) * 1000)


def test_ardupilot_dataflash_in_text(logs):
    log = logs.work / "log.log"
    writing.dataflash_text(log, logs.truth)
    _, columns = logs.imported(log)
    logs.check(columns)
    logs.check_stamps(columns, np.array(writing.boot_us(logs.truth)) * 1000)


def test_ros_1_bag_with_unix_stamps_to_the_nanosecond(logs):
    log = logs.work / "log.bag"
    writing.ros1(log, logs.truth)
    _, columns = logs.imported(log)
    logs.check(columns)
    logs.check_stamps(columns, logs.truth.stamps_ns)


def test_ros_2_db3_mcap_and_the_folder_of_a_bag(logs):
    for storage in ("db3", "mcap"):
        folder = logs.work / f"bag_{storage}"
        file = writing.ros2(folder, logs.truth, storage)
        for log in (file, folder):
            _, columns = logs.imported(log)
            logs.check(columns)
            logs.check_stamps(columns, logs.truth.stamps_ns)


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


def test_matlab_5_and_7_3(logs):
    old, new = logs.work / "old.mat", logs.work / "new.mat"
    writing.matlab_5(old, logs.truth)
    _, columns = logs.imported(old)
    logs.check(columns, temp=False)
    logs.check_stamps(columns, logs.truth.stamps_ns - writing.START_NS)
    writing.matlab_73(new, logs.truth)
    _, columns = logs.imported(new)
    logs.check(columns)
    logs.check_stamps(columns, logs.truth.stamps_ns - writing.START_NS)


def test_numpy_and_parquet(logs):
    for name, write, rest in (
        ("log.npz", writing.npz, True),
        ("log.npy", writing.npy, False),
        ("log.parquet", writing.table, True),
    ):
        write(logs.work / name, logs.truth)
        _, columns = logs.imported(logs.work / name)
        logs.check(columns, accel=rest, temp=rest)
        logs.check_stamps(columns, logs.truth.stamps_ns - (0 if rest else writing.START_NS))


def test_a_temperature_with_a_time_of_its_own(logs):
    writing.apart(logs.work / "log.npz", logs.truth)
    _, columns = logs.imported(logs.work / "log.npz")
    logs.check(columns, accel=False)
    logs.check_stamps(columns, logs.truth.stamps_ns)


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
    found = [
        json.loads(
            run(
                "compare",
                path,
                "-m",
                logs.file(
                    "m.toml",
                    '[sensor]\ncolumn = "gyro_x_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
                    "coefficient_deg_per_sqrt_h = 2.0\n",
                ),
                "--json",
            ).stdout
        )
        for path in (log, own)
    ]
    assert found[0]["samples"] == 3000
    assert abs(found[0]["error"] - found[1]["error"]) < 5e-6


def rows_of(logs, name, header, row):
    return logs.file(
        name, header + "\n" + "".join(row(place) + "\n" for place in range(logs.truth.count))
    )


def test_a_guess_is_shown_and_overridden(logs):
    log = rows_of(
        logs,
        "log.txt",
        "t gx gy gz",
        lambda i: f"  {i * 5}   {i % 50 * 100} {i % 31 * 10}\t{i % 7 * 100}",
    )
    done = run("import", log, "-o", logs.out)
    assert "--unit gx=UNIT" in done.stderr
    assert "gyro_x_counts" in done.stdout
    _, columns = logs.imported(log, "--unit", "gyro=0.0175", "--unit", "t=ms")
    np.testing.assert_allclose(np.float64(columns["gyro_x_dps"][:3]), [0, 1.75, 3.5])
    assert columns["time_s"][:3] == ("0", "0.005", "0.01")


def test_unix_times_survive(logs):
    own = rows_of(
        logs,
        "own.csv",
        "time_s,gyro_x_dps",
        lambda i: (
            f"{logs.truth.stamps_ns[i] // 10**9}.{logs.truth.stamps_ns[i] % 10**9:09d},{i % 5}"
        ),
    )
    logs.check_stamps(logs.imported(own)[1], logs.truth.stamps_ns)
    for unit, size in (("ns", 1), ("us", 1000)):
        log = rows_of(
            logs,
            f"{unit}.csv",
            f"timestamp_{unit},gyro_x_dps",
            lambda i, size=size: f"{logs.truth.stamps_ns[i] // size},{i % 5}",
        )
        logs.check_stamps(logs.imported(log)[1], logs.truth.stamps_ns // size * size)
    dates = np.array(logs.truth.stamps_ns, "datetime64[ns]")
    log = rows_of(logs, "date.csv", "time,gyro_x_dps", lambda i: f"{dates[i]},{i % 5}")
    logs.check_stamps(logs.imported(log)[1], logs.truth.stamps_ns)


def test_degree_signs_quotes_and_a_column_of_somebody_elses_name(logs):
    log = rows_of(
        logs,
        "log.csv",
        '"Time (s)","Gyroscope x (\u00b0/s)","Absolute","light"',
        lambda i: f'"{i * 0.005:.3f}","{i % 5}.5",3,{i % 2}',
    )
    _, columns = logs.imported(log)
    assert (columns["gyro_x_dps"][:2], columns["light"][:2]) == (("0.5", "1.5"), ("0", "1"))
    log = rows_of(
        logs,
        "commas.csv",
        "t,gx_dps",
        lambda i: f'"{i * 0.005:.3f}","-{i % 5}.5"'.replace(".", ","),
    )
    assert logs.imported(log)[1]["gyro_x_dps"][:2] == ("-0.5", "-1.5")
    logs.rejected(rows_of(logs, "xyz.csv", "t,x", lambda i: f"{i * 0.005:.3f},{i % 5}"), "--rename")
    columns = logs.imported(logs.work / "xyz.csv", "--rename", "x=gyro_x_rad_s")[1]
    assert abs(float(columns["gyro_x_dps"][1]) - 57.29578) < 5e-5


def test_two_gyros_in_a_table(logs):
    log = rows_of(
        logs, "log.csv", "t,imu0_gx_dps,imu1_gx_dps", lambda i: f"{i * 0.005:.3f},{i % 5},{i % 3}"
    )
    logs.rejected(log, "--sensor", "imu0", "imu1")
    listed = json.loads(run("import", log, "--list", "--json").stdout)["sensors"]
    columns = logs.imported(log, "--sensor", listed[1]["name"])[1]
    assert columns["gyro_x_dps"][:4] == ("0", "1", "2", "0")


def test_what_import_writes_holds_only_what_was_measured(logs):
    kept = [place for place in range(400) if not 100 <= place < 120]
    log = logs.file(
        "log.csv",
        "t;gx_dps\n" + "".join(f"{place * 0.005:.3f};{place % 7}\n" for place in kept),
    )
    assert len(logs.imported(log)[1]["time_s"]) == 380


def test_a_log_cut_short_or_with_another_beginning(logs):
    writers = {
        "log.ulg": writing.ulog,
        "log.bin": writing.dataflash,
        "log.bag": writing.ros1,
        "log.mat": writing.matlab_5,
        "new.mat": writing.matlab_73,
        "log.npz": writing.npz,
        "log.npy": writing.npy,
        "log.parquet": writing.table,
    }
    for name, write in writers.items():
        whole = logs.work / "whole" / name
        whole.parent.mkdir(exist_ok=True)
        write(whole, logs.truth)
        data = whole.read_bytes()
        log = logs.work / name
        for what, damaged in (
            ("empty", b""),
            ("half", data[: len(data) // 2]),
            ("short", data[:-5]),
            ("head", data[:20]),
            ("other", b"something else" + data[14:]),
        ):
            if (name, what) not in (
                ("log.mat", "short"),
                ("new.mat", "other"),
            ):  # padding of a text; the file proper begins behind 512 bytes
                log.write_bytes(damaged)
                named = {"log.ulg": "sensor_gyro:0", "log.bin": "IMU:0"}.get(name)
                logs.rejected(log, name, options=("--sensor", named) if named else ())


def test_ros_2_cut_short(logs):
    for storage in ("db3", "mcap"):
        data = writing.ros2(logs.work / storage, logs.truth, storage).read_bytes()
        log = logs.file(f"log.{storage}", "")
        log.write_bytes(data[: len(data) // 2])
        logs.rejected(log, f"log.{storage}")


def test_nan_empty_topics_and_text_in_numbers(logs):
    logs.truth.gyro[1, 17] = np.nan
    for name, write, options in (
        ("log.ulg", writing.ulog, ("--sensor", "sensor_gyro:0")),
        ("log.bag", writing.ros1, ()),
        ("log.npz", writing.npz, ()),
        ("log.parquet", writing.table, ()),
    ):
        write(logs.work / name, logs.truth)
        logs.rejected(
            logs.work / name,
            name,
            "gyro_y_dps",
            "not a finite number at sample 18",
            options=options,
        )
    logs.rejected(
        logs.file("a.csv", "t;gx_dps\n0,01;1\n0,02;one\n"),
        "a.csv:3",
        "gx_dps",
        "not a number: 'one'",
    )
    logs.rejected(logs.file("b.csv", "t,gx_dps\n0.01,1\n0.02,nan\n"), "b.csv:3", "gx_dps")
    logs.rejected(logs.file("c.csv", "a,b\n1,2\n3,4\n"), "c.csv", "no gyro")
    writing.ros1(logs.work / "empty.bag", writing.Truth(0))
    logs.rejected(logs.work / "empty.bag", "empty.bag")


def test_time_backwards_and_no_time(logs):
    logs.truth.stamps_ns[50] = logs.truth.stamps_ns[40]
    for name, write in (("log.npz", writing.npz), ("log.parquet", writing.table)):
        write(logs.work / name, logs.truth)
        logs.rejected(logs.work / name, name, "time runs backwards")
    logs.rejected(logs.file("c.csv", "gx_dps\n1\n2\n"), "no column time_s and no --rate")


real = pytest.mark.skipif(not REAL.is_dir(), reason=f"no real logs in {REAL}")


@real
def test_px4_at_rest(logs):
    _, columns = logs.imported(
        REAL / "px4_cubeorange_at_rest_6s.ulg", "--sensor", "sensor_combined:0"
    )
    assert len(columns["time_s"]) == 1298
    assert abs(abs(np.mean(np.float64(columns["accel_z_g"]))) - 1) <= 0.05
    assert np.std(np.float64(columns["gyro_x_dps"])) < 1
    assert abs(np.mean(np.float64(columns["temp_degC"])) - 40) <= 3


@real
def test_ardupilot_in_flight(logs):
    _, columns = logs.imported(REAL / "arducopter_dataflash_51s.BIN", "--sensor", "IMU")
    assert (len(columns["time_s"]), columns["time_s"][0]) == (1258, "402.644506")
    assert abs(np.mean(np.float64(columns["temp_degC"])) - 27) <= 3


@real
def test_ros_1_with_a_message_type_of_its_own(logs):
    _, columns = logs.imported(REAL / "ros1_xsens_mtig_at_rest_18s.bag")
    first = columns["time_s"][0], columns["temp_degC"][0]
    assert (len(columns["time_s"]), *first) == (356, "1326899528.368658417", "20.8125")


@real
def test_matlab_with_two_imus_and_an_object_that_breaks_naive_readers(logs):
    log = REAL / "rimu_two_imus_40deg_steps.mat"
    logs.rejected(log, "--sensor", "giro_imu_dps", "giro_bno_dps")
    _, columns = logs.imported(log, "--sensor", "giro_bno_dps")
    assert len(columns["time_s"]) == 40000
    assert abs(np.mean(np.float64(columns["accel_z_g"][:2000])) - 0.95) <= 0.02
