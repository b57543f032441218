"""tools/davarlab import, and every command that takes a recording, on other people's logs: what the
formats' own libraries wrote comes back. Raw text files as loggers, spreadsheets and serial ports
write them: what was measured is read, or one line says what to type.
"""

import binascii
import contextlib
import csv
import functools
import json
import operator
import os
import sqlite3
from pathlib import Path

import numpy as np
import pytest
import writing_logs as writing
from asking import MODEL, ROOT, run, said
from davarlab.logs import sensor, ulog
from lab_bench import Lab

REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real")).parent / "logs"
FILTERED = "vehicle_angular_velocity"  # of PX4
SINGLE = 2e-7  # relative, of float32 and of nine digits


class Logs(Lab):
    """A folder with the log of a known gyro, and what import makes of it."""

    def __init__(self, work):
        super().__init__(work)
        self.out = self.work / "out.csv"
        self.truth = writing.Truth()

    def imported(self, log, *options):
        """(notes, name -> values as text) of the recording that import writes."""
        done = run("import", log, "-o", self.out, *options)
        assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
        lines = self.out.read_text().splitlines()
        notes = [line for line in lines if line.startswith("#")]
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
        return notes, dict(zip(rows[0], zip(*rows[1:])))

    def rejected(self, log, *said, options=()):
        """Exit status 2, one line with all that is said, nothing left behind."""
        self.out.unlink(missing_ok=True)
        line = self.refused(said[0], "import", log, "-o", self.out, *options)
        assert all(words in line for words in said), line
        assert not self.out.exists()

    def check(self, columns, gyro=1.0, accel=True, temp=True, first=0):
        for axis, name in enumerate("xyz"):
            rates = np.float64(columns[f"gyro_{name}_dps"])
            np.testing.assert_allclose(rates, self.truth.gyro[axis] * gyro, rtol=SINGLE, atol=1e-8)
            if accel:
                forces = np.float64(columns[f"accel_{name}_g"])[first::2]
                true = self.truth.accel[axis][first::2]
                np.testing.assert_allclose(forces, true, rtol=SINGLE, atol=1e-7)
        if temp:  # after its last stamp it is held
            np.testing.assert_allclose(np.float64(columns["temp_degC"]), self.truth.temp, atol=0.12)

    def check_stamps(self, columns, ns):
        whole = [
            int(second) * 10**9 + int(part.ljust(9, "0") or 0)
            for second, _, part in (text.partition(".") for text in columns["time_s"])
        ]
        assert whole == [int(one) for one in ns]

    def check_gyro(self, columns, atol=1e-6, first=0, time=True):
        for axis, name in enumerate("xyz"):
            rates = np.float64(columns[f"gyro_{name}_dps"])
            np.testing.assert_allclose(rates, GYRO[first:, axis], atol=atol, err_msg=name)
        if time:
            stamps = np.float64(columns["time_s"])
            np.testing.assert_allclose(stamps - stamps[0], TIME[: COUNT - first], atol=1e-9)

    def said(self, log, *options):
        return run("import", log, "-o", self.out, *options).stderr

    def proposed(self, log):
        """The --names that a refusal says to type."""
        return self.said(log).split("--names ")[1].split()[0]


@pytest.fixture
def logs(tmp_path):
    return Logs(tmp_path)


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


# Raw text.


COUNT = 1200
RATE_HZ = 100
RNG = np.random.default_rng(20)
GYRO = np.round(RNG.normal(0, 0.3, (COUNT, 3)), 5)
FORCE = np.round(RNG.normal([0.02, -0.03, 1.0], 0.004, (COUNT, 3)), 5)
TEMP = np.round(25 + np.arange(COUNT) / 1000, 3)
TIME = np.arange(COUNT) / RATE_HZ
OWN = "gyro_x_dps,gyro_y_dps,gyro_z_dps"
US = np.arange(COUNT) * (1_000_000 // RATE_HZ)


def rows(*columns, separator=",", end=""):
    """Text of columns of numbers or text, of one length."""
    return "".join(
        separator.join(one if isinstance(one, str) else f"{one:.10g}" for one in row) + end + "\n"
        for row in zip(*(column.tolist() for column in map(np.asarray, columns)))
    )


def plain(separator=",", end=""):
    return rows(TIME, *GYRO.T, separator=separator, end=end)


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


NAMES = "t,gx_dps,gy_dps,gz_dps\n"
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
    "blank lines below": NAMES + plain().replace("\n", "\n\n", 3),
}


@pytest.mark.parametrize("name", TABLES)
def test_what_stands_between_and_above_the_numbers(logs, name):
    logs.check_gyro(logs.imported(logs.file("log.csv", TABLES[name]))[1])


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


# The names of common loggers.


MS, NS = np.arange(COUNT) * 10, np.arange(COUNT) * 10_000_000
RADIANS = np.round(np.radians(GYRO), 9)
MPS2 = np.round(FORCE * 9.80665, 6)
UNIX_NS = 1_742_324_422_348_709_600 + NS
UNIX = ("Sensor Logger", "Sensor Logger, uncalibrated")
OTHER = np.round(RNG.normal(0.3, 0.2, (COUNT, 3)), 5)  # no gyro


def test_of_a_blackbox_log_the_gyro_in_front_of_the_filters_is_read(logs):
    """As blackbox_decode writes it: whole deg/s, and a throttle."""
    whole = np.round(30 * GYRO)
    heads = [f"{one}[{axis}]" for one in ("axisP", "gyroADC", "gyroUnfilt") for axis in range(3)]
    columns = (
        np.arange(COUNT),
        US,
        *np.ones((3, COUNT)),
        *np.ones((3, COUNT)),
        *whole.T,
        1500 + US,
    )
    log = logs.file(
        "LOG.csv", f"loopIteration,time (us),{','.join(heads)},throttle\n{rows(*columns)}"
    )
    _, found = logs.imported(log)
    for axis, name in enumerate("xyz"):
        np.testing.assert_array_equal(np.float64(found[f"gyro_{name}_dps"]), whole[:, axis])
    assert "deg/s by the documentation of Betaflight" in logs.said(log)
    assert "throttle" in found
    assert set(logs.imported(log, "--sensor", "gyroADC[]")[1]["gyro_x_dps"]) == {"1"}


KNOWN = {  # (file, names, columns): x, y, z of GYRO
    "phyphox": (
        "Raw Data.csv",
        '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)","Gyroscope z (rad/s)",'
        '"Absolute (rad/s)"',
        (TIME, *RADIANS.T, np.abs(OTHER[:, 0])),
    ),
    "phyphox, units alone": (
        "Raw Data.csv",
        '"Time (s)","X (rad/s)","Y (rad/s)","Z (rad/s)"',
        (TIME, *RADIANS.T),
    ),
    "Sensor Logger": (
        "Gyroscope.csv",
        "time,seconds_elapsed,z,y,x",
        (UNIX_NS, TIME, *RADIANS.T[::-1]),
    ),
    "Sensor Logger, uncalibrated": (
        "GyroscopeUncalibrated.csv",
        "time,seconds_elapsed,z,y,x",
        (UNIX_NS, TIME, *RADIANS.T[::-1]),
    ),
    "Android, with the bias": (
        "GyroscopeUncalibrated_1.csv",
        "timestamp_ns,x_uncalib,y_uncalib,z_uncalib,x_bias,y_bias,z_bias",
        (NS, *GYRO.T, *OTHER.T),
    ),
    "SensorLog": (
        "log.csv",
        "loggingTime(txt),motionTimestamp_sinceReboot(s),motionYaw(rad),motionRoll(rad),"
        "motionPitch(rad),motionRotationRateX(rad/s),motionRotationRateY(rad/s),"
        "motionRotationRateZ(rad/s),motionGravityX(G),motionGravityY(G),motionGravityZ(G)",
        (["noon"] * COUNT, TIME, *OTHER.T, *RADIANS.T, *FORCE.T),
    ),
    "SensorLog, raw": (
        "log.csv",
        "gyroTimestamp_sinceReboot(s),gyroRotationX(rad/s),gyroRotationY(rad/s),"
        "gyroRotationZ(rad/s),magnetometerX(\u00b5T),magnetometerY(\u00b5T),magnetometerZ(\u00b5T)",
        (TIME, *RADIANS.T, *OTHER.T),
    ),
    "AndroSensor": (
        "Sensor_record.csv",
        "GRAVITY X (m/s\u00b2);GRAVITY Y (m/s\u00b2);GRAVITY Z (m/s\u00b2);GYROSCOPE X (rad/s);"
        "GYROSCOPE Y (rad/s);GYROSCOPE Z (rad/s);Time since start in ms",
        (*MPS2.T, *RADIANS.T, MS),
    ),
    "MbientLab": (
        "MetaWear_Gyroscope_100.000Hz_1.4.4.csv",
        "elapsed (s),x-axis (deg/s),y-axis (deg/s),z-axis (deg/s)",
        (TIME, *GYRO.T),
    ),
    "OpenCamera": ("video_gyro.csv", "X-data,Y-data,Z-data,timestamp (ns)", (*GYRO.T, NS)),
    "MATLAB Mobile": ("AngularVelocity.csv", "Timestamp (ms),X,Y,Z", (MS, *GYRO.T)),
    "rotation rate": ("RotationRate.txt", "t,x,y,z", (TIME, *GYRO.T)),
    "ulog2csv": (
        "log_sensor_gyro_0.csv",
        "timestamp,timestamp_sample,device_id,x,y,z,temperature,error_count",
        (US + 5_000_120, US, np.full(COUNT, 2_490_378), *RADIANS.T, TEMP, np.zeros(COUNT)),
    ),
    "ulog2csv, filtered": (
        "log_vehicle_angular_velocity_0.csv",
        "timestamp,timestamp_sample,xyz[0],xyz[1],xyz[2],"
        "xyz_derivative[0],xyz_derivative[1],xyz_derivative[2]",
        (US + 120, US, *RADIANS.T, *OTHER.T),
    ),
    "Xsens MT Manager": (
        "MT_01.txt",
        "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z",
        (np.arange(COUNT), np.arange(COUNT) * 100 + 1_234_500, *MPS2.T, *GYRO.T),
    ),
    "Movella DOT": (
        "dot.csv",
        "PacketCounter,SampleTimeFine,Gyr_X,Gyr_Y,Gyr_Z",
        (np.arange(COUNT), US + 99, *GYRO.T),
    ),
    "Betaflight": (
        "btfl_001.csv",
        "loopIteration,time (us),axisP[0],axisP[1],axisP[2],axisF[0],axisF[1],axisF[2],"
        "setpoint[0],setpoint[1],setpoint[2],gyroADC[0],gyroADC[1],gyroADC[2]",
        (np.arange(COUNT), US, *OTHER.T, *OTHER.T, *OTHER.T, *GYRO.T),
    ),
    "MAVLink": (
        "imu.csv",
        "time_usec,xacc,yacc,zacc,xgyro,ygyro,zgyro",
        (US, *MPS2.T, *GYRO.T),
    ),
    "WitMotion": (
        "wit.csv",
        "Time(s),Acceleration X(g),Acceleration Y(g),Acceleration Z(g),"
        "Angular velocity X(\u00b0/s),Angular velocity Y(\u00b0/s),Angular velocity Z(\u00b0/s),"
        "Angle X(\u00b0),Angle Y(\u00b0),Angle Z(\u00b0)",
        (TIME, *FORCE.T, *GYRO.T, *OTHER.T),
    ),
    "rates and their set points": (
        "log.csv",
        "t,roll_rate_sp (deg/s),pitch_rate_sp (deg/s),yaw_rate_sp (deg/s),"
        "roll_rate (deg/s),pitch_rate (deg/s),yaw_rate (deg/s)",
        (TIME, *OTHER.T, *GYRO.T),
    ),
    "p, q, r beside a quaternion": (
        "log.csv",
        "t,q[0],q[1],q[2],p (deg/s),q (deg/s),r (deg/s)",
        (TIME, *OTHER.T, *GYRO.T),
    ),
}


@pytest.mark.parametrize("name", KNOWN)
def test_the_names_of_common_loggers(logs, name):
    file, names, columns = KNOWN[name]
    separator = next(one for one in "\t;," if one in names)
    log = logs.file(file, f"{names}\n{stamped_rows(separator, *columns)}")
    in_radians = any(np.shares_memory(one, RADIANS) for one in map(np.asarray, columns))
    options = (
        () if in_radians or "deg/s" in names or "\u00b0/s" in names else ("--unit", "gyro=deg/s")
    )
    columns = logs.imported(log, *options)[1]
    logs.check_gyro(columns, time=name not in UNIX)
    if name in UNIX:
        logs.check_stamps(columns, UNIX_NS)


def stamped_rows(separator, *columns):
    """Text of columns of words, of whole numbers or of ten digits."""
    return rows(*([str(one) for one in column] for column in columns), separator=separator)


def test_a_guess_by_the_name_of_the_file_is_said_and_its_columns_keep_their_names(logs):
    text = "time,x,y,z\n" + rows(TIME, *GYRO.T)
    assert "x, y, z: gyro by the file's name" in logs.said(logs.file("my_gyro.csv", text))
    for file, column in (("my_gyro.csv", "x"), ("my_gyro.csv", "gyro_x"), ("log.csv", "x")):
        renamed = ("--rename", f"{column}=gyro_x_dps")
        columns = logs.imported(logs.file(file, text), *renamed)[1]
        np.testing.assert_allclose(np.float64(columns["gyro_x_dps"]), GYRO[:, 0], atol=1e-6)
    file, names, columns = KNOWN["ulog2csv"]
    said = logs.said(logs.file(file, f"{names}\n{stamped_rows(',', *columns)}"))
    assert "rad/s by the documentation of PX4" in said


OTHERWISE = {  # names that are nearly those of davarlab
    "gx beside time_s": "time_s,gx_dps,gy_dps,gz_dps",
    "sec and nanosec": "sec,nanosec,gx_dps,gy_dps,gz_dps",
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_names_that_are_nearly_those_of_davarlab_are_read(logs, name):
    whole = np.floor(TIME)
    parts = np.round((TIME - whole) * 1e9).astype(int)
    stamps = (whole.astype(int), parts) if "nanosec" in OTHERWISE[name] else (TIME,)
    columns = logs.imported(logs.file("log.csv", f"{OTHERWISE[name]}\n{rows(*stamps, *GYRO.T)}"))[1]
    logs.check_gyro(columns)
    assert len(set(columns["time_s"])) == COUNT


NO_GYRO = {  # file: names
    "log.csv": "t,x,y,z",
    "gyro_accel.csv": "t,x,y,z",  # of both
    "gyro_bias.csv": "t,x,y,z",
    "Gravity.csv": "time,x,y,z",
    "Magnetometer.csv": "t,X [mG],Y [mG],Z [mG]",
    "pid.csv": "t,axisP[0],axisP[1],axisP[2]",
    "rates.csv": "t,rateSetpoint[0],rateSetpoint[1],rateSetpoint[2]",
    "attitude.csv": "t,q[0],q[1],q[2]",
    "angles.csv": "t,motionYaw(rad),motionRoll(rad),motionPitch(rad)",
    "angular_acceleration.csv": "t,x (rad/s^2),y (rad/s^2),z (rad/s^2)",
    "speed.csv": "t,vx (m/s),vy (m/s),vz (m/s)",
}


@pytest.mark.parametrize("file", NO_GYRO)
def test_what_is_no_gyro_is_not_offered_as_one(logs, file):
    log = logs.file(file, f"{NO_GYRO[file]}\n{rows(TIME, *GYRO.T)}")
    logs.rejected(log, file, "no gyro")
    assert "gyro" not in run("import", log, "--list").stdout


def test_accelerometers_by_unit_and_by_file(logs):
    for file, names, force in (
        ("Accelerometer.csv", "t,x,y,z", FORCE),
        ("log.csv", "t,X (m/s^2),Y (m/s^2),Z (m/s^2)", MPS2),
        ("log.csv", "t,x-axis (g),y-axis (g),z-axis (g)", FORCE),
        ("log_sensor_accel_1.csv", "timestamp_sample,x,y,z", MPS2),
        ("acc.csv", "t,x_m_s2,y_m_s2,z_m_s2", MPS2),
    ):
        log = logs.file(file, f"{names}\n{rows(TIME, *force.T)}")
        sensor = run("import", log, "--list").stdout.partition(" (accel")[0]
        columns = logs.imported(log, "--sensor", sensor)[1]
        np.testing.assert_allclose(np.float64(columns["accel_z_g"]), FORCE[:, 2], atol=1e-5)


def test_two_gyros_in_numbered_columns_are_listed_and_one_is_selected(logs):
    for names, one, other in (
        ("gx1,gy1,gz1,gx2,gy2,gz2", "g1", "g2"),
        ("gx_0,gy_0,gz_0,gx_1,gy_1,gz_1", "g_0", "g_1"),
        ("gyro_x1,gyro_y1,gyro_z1,gyro_x2,gyro_y2,gyro_z2", "gyro_1", "gyro_2"),
        ("gyro0.x,gyro0.y,gyro0.z,gyro1.x,gyro1.y,gyro1.z", "gyro0", "gyro1"),
    ):
        log = logs.file("log.csv", f"time_s,{names}\n{rows(TIME, *OTHER.T, *GYRO.T)}")
        logs.rejected(log, "more than one gyro", f"{one} (gyro;", f"{other} (gyro;")
        logs.check_gyro(logs.imported(log, "--sensor", other, "--unit", "gyro=deg/s")[1])


# The tick of the time.


STEPS = np.arange(COUNT)
TICKS = {  # (text above, name of the time, stamps at 100 Hz, or as they say)
    "by Xsens": ("// Update Rate: 100.0Hz\n", "SampleTimeFine", STEPS * 100),
    "by Xsens alone": ("", "SampleTimeFine", STEPS * 100),
    "update rate": ("// Update Rate:    100.0Hz\n", "stamp", STEPS * 100),
    "sample rate": ("# sample rate 100 Hz\n", "stamp", STEPS * 100),
    "fs": ("# fs = 100\n", "stamp", STEPS * 100),
    "before the table": ("Sampling frequency,0.1 kHz,,\n", "stamp", STEPS * 100),
    "of several": ("# gyro ODR: 100\n# GNSS rate 5 Hz\n", "stamp", STEPS * 100_000),
    "fractions": ("# output data rate: 100 Hz\n", "stamp", STEPS * 10 + 0.125),
    "a rate of something else": ("# baud rate: 115200\n", "stamp", STEPS * 10),
    "a full scale": ("# Gyro FS: 2000 dps\n", "stamp", STEPS * 10),
    "in the name": ("", "time (0.1 ms)", STEPS * 100),
    "in the name, us": ("", "time_100us", STEPS * 100),
}


@pytest.mark.parametrize("name", TICKS)
def test_the_tick_that_a_name_or_a_stated_rate_shows(logs, name):
    above, called, stamps = TICKS[name]
    log = logs.file("log.csv", f"{above}{called},gx_dps,gy_dps,gz_dps\n{rows(stamps, *GYRO.T)}")
    assert "doubtful" not in logs.said(log)
    logs.check_gyro(logs.imported(log)[1])


def test_a_stated_rate_that_is_no_whole_number_of_ticks(logs):
    stamps = np.round(STEPS * 2.5)
    log = logs.file("log.csv", f"# fs: 400 Hz\nt,{OWN}\n{rows(stamps, *GYRO.T)}")
    columns = logs.imported(log)[1]
    assert columns["time_s"][400] == "1"


DOUBTED = {  # (text above, stamps, words of the doubt, options that give 100 Hz)
    "0.1 ms": ("", STEPS * 100, "100 Hz in 0.1ms", ("--unit", "time=0.1ms")),
    "a factor": ("", STEPS * 100, "10000 Hz in us", ("--unit", "t=1e-4")),
    "10 us": ("", STEPS * 100, "1000 Hz in 10us", ("--rate", "100")),
    "100 ns": ("", STEPS * 100_000, "100 Hz in 100ns", ("--unit", "time=100ns")),
    "a usual rate": (
        "# Gyro ODR: 1000 Hz\n",
        *(STEPS * 10, "1000 Hz is stated", ("--unit", "time=ms")),
    ),
    "another rate": ("# fs = 400\n", STEPS * 10, "400 Hz is stated", ("--unit", "time=ms")),
}


@pytest.mark.parametrize("name", DOUBTED)
def test_a_tick_that_gives_no_usual_rate_or_not_the_stated_one_is_doubted(logs, name):
    above, stamps, words, cure = DOUBTED[name]
    log = logs.file("log.csv", f"{above}t,{OWN}\n{rows(stamps, *GYRO.T)}")
    told = logs.said(log)
    assert f"doubtful: {'a rate of ' * (words[-1] == 'd')}" in told and words in told
    assert "--unit time=UNIT" in told
    assert "doubtful" not in logs.said(log, *cure)
    logs.check_gyro(logs.imported(log, *cure)[1])


def test_a_doubted_tick_gives_no_verdict(logs):
    white = RNG.normal(0, 0.3, 50_000)
    log = logs.file("log.csv", f"t,gyro_z_dps\n{rows(np.arange(len(white)) * 100, white)}")
    for options, adequate in (((), False), (("--unit", "time=0.1ms"), True)):
        found = said("fit", log, *options, statuses=(0, 1))
        kinds = [one["kind"] for one in found["observations"]]
        assert (found["adequate"], "implausible" in kinds) == (adequate, not adequate)


# Files without names.


@pytest.mark.parametrize("name, separator", [("a.csv", ","), ("a.txt", " "), ("a.tsv", "\t")])
def test_names_are_asked_for_and_taken(logs, name, separator):
    for clock, stamps in (("time_s", US / 1e6), ("time_us", US)):
        log = logs.file(name, rows(stamps, *GYRO.T, TEMP, separator=separator))
        proposed = f"--names {clock},gyro_x,gyro_y,gyro_z,temp_degC"
        logs.rejected(log, f"{name}:1: no names", proposed)
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
    clock = [f"12:{n // 60 % 60:02d}:{n % 60:02d}" for n in range(COUNT)]
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


THOUSANDS = "".join(f"{n};{n % 7},{n % 1000:03d}\n" if n % 7 else f"{n};{n}\n" for n in range(300))
UNREADABLE = {
    "decimal commas between commas": (NAMES + plain().replace(".", ","), "Type"),
    "thousands": ("t;gx_raw\n" + THOUSANDS, "tr -d ,"),
    "twins": ("t,x,y,z,x,y,z\n" + rows(TIME, *GYRO.T, *FORCE.T), "--names"),
    "too few names": ("t,gx_dps\n" + plain(), "--names"),
    "text in a gyro": (NAMES + plain().replace("0.02,", "0.02,x", 1), ":4: column gx_dps"),
    "a clock of text": ("time,gx_dps\n12:00:01.1,5\n12:00:01.2,6\n", ":2: column time"),
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


# Missing values.


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
