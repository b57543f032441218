"""Names of columns and files of common loggers, and the tick of their time."""

import shlex

import numpy as np
import pytest
from asking import run, said
from reading_logs import (
    COUNT,
    FORCE,
    GYRO,
    MPS2,
    MS,
    NS,
    OTHER,
    OWN,
    RADIANS,
    RNG,
    STEPS,
    TEMP,
    TIME,
    US,
    rows,
    stamped_rows,
)

UNIX_NS = 1_742_324_422_348_709_600 + NS
UNIX = ("Sensor Logger", "Sensor Logger, uncalibrated")


BLACKBOX = {  # name of the gyro before its filters, tenths, text above
    "Betaflight": ("gyroUnfilt", False, ""),
    "INAV": ("gyroRaw", False, ""),
    "Rotorflight": ("gyroRAW", False, ""),
    "high resolution": ("gyroUnfilt", True, ""),
    "high resolution in the header": ("gyroUnfilt", True, '"blackbox_high_resolution",1\n'),
}


@pytest.mark.parametrize("name", BLACKBOX)
def test_of_a_blackbox_log_the_gyro_before_the_filters_is_read(logs, name):
    """As blackbox_decode writes it: whole deg/s, or tenths with the throttle; or as the Explorer
    does, with a header."""
    raw, tenths, above = BLACKBOX[name]
    whole, scale = np.round(30 * GYRO), 10 if tenths else 1
    heads = [f"{one}[{axis}]" for one in ("axisP", "gyroADC", raw) for axis in range(3)]
    throttle = (1500 + np.arange(COUNT) % 100) * scale
    heads += ["motor[0]" if above else "rcCommand[3]"]
    log = logs.file(
        "LOG.csv",
        f"{above}loopIteration,time (us),{','.join(heads)}\n"
        + rows(np.arange(COUNT), US, *np.ones((6, COUNT)), *scale * whole.T, throttle),
    )
    _, found = logs.imported(log)
    for axis, one in enumerate("xyz"):
        np.testing.assert_allclose(np.float64(found[f"gyro_{one}_dps"]), whole[:, axis], atol=1e-6)
    said = logs.said(log)
    unit = "0.1 deg/s by" if tenths else "deg/s by the documentation of Betaflight"
    assert f"{raw}[0] -> gyro_x_dps, {unit}" in said
    assert "doubtful" not in said
    assert heads[-1] in found
    filtered = logs.imported(log, "--sensor", "gyroADC[]")[1]["gyro_x_dps"]
    assert set(np.float64(filtered)) == {1 / scale}
    assert "doubtful" not in logs.said(logs.out, "--sensor", "recording")


def test_a_blackbox_log_in_radians_and_its_debug_mode(logs):
    """blackbox_decode --unit-rotation rad/s; and debug_mode = GYRO_SCALED, by names that are
    typed."""
    heads = [f"gyroADC[{axis}] (rad/s)" for axis in range(3)]
    debug = [f"debug[{axis}]" for axis in range(4)]
    log = logs.file(
        "LOG.csv",
        f"time (us),{','.join(heads)},{','.join(debug)},rcCommand[3]\n"
        + rows(US, *10 * RADIANS.T, *np.round(GYRO * 30).T, STEPS, np.full(COUNT, 15_000)),
    )
    logs.check_gyro(logs.imported(log)[1])
    named = [("--rename", f"debug[{axis}]=debug_gyro_{one}_dps") for axis, one in enumerate("xyz")]
    options = [word for pair in named for word in pair]
    found = logs.imported(log, *options, "--sensor", "debug_gyro__dps")[1]
    np.testing.assert_array_equal(np.float64(found["gyro_z_dps"]), np.round(30 * GYRO[:, 2]))


@pytest.mark.parametrize("file", ["LOG 1.bbl", "log.bfl", "LOG00001.TXT"])
def test_a_packed_blackbox_log_is_rejected_with_the_command_that_decodes_it(logs, file):
    head = b"H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n"
    log = logs.work / file
    log.write_bytes(head + bytes(range(256)) * 100)
    logs.rejected(log, "a packed Blackbox log. Type blackbox_decode --unit-rotation deg/s")
    command, _, decoded = logs.said(log).strip().split(" Type ")[1].rpartition(", and use ")
    assert shlex.split(command)[-1] == str(log)
    assert decoded == f"{log.with_suffix('')}.01.csv"


KNOWN = {  # (file, names, columns): x, y, z of GYRO
    "phyphox": (
        "Raw Data.csv",
        '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)","Gyroscope z (rad/s)",'
        '"Absolute (rad/s)"',
        (TIME, *RADIANS.T, np.abs(OTHER[:, 0])),
    ),
    "Arduino": ("log.csv", "t,aX,aY,aZ,gX,gY,gZ", (TIME, *MPS2.T, *RADIANS.T)),
    "GPS time": ("log.csv", "GPST,Ax,Ay,Az,Gx,Gy,Gz", (390_884.2 + TIME, *MPS2.T, *RADIANS.T)),
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
    "Inertial Sense": (
        "LOG_SN30664_PIMU.csv",
        "time,pqr[0],pqr[1],pqr[2],acc[0],acc[1],acc[2]",
        (TIME, *RADIANS.T, *MPS2.T),
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


def test_a_column_that_may_be_the_time_is_named(logs):
    """What the message says to type works, also with a space in the name."""
    text = "row,GPS SOW,gx_dps,gy_dps,gz_dps\n" + rows(STEPS, 390_000_000 + MS, *GYRO.T)
    log = logs.file("log.csv", text.replace("SOW", "s.o.w"))
    typed = "--unit 'GPS s.o.w=s' (or ms, us, ns). Otherwise, type --rate HZ"
    logs.rejected(log, f"If GPS s.o.w is the time, type {typed}")
    logs.check_gyro(logs.imported(log, "--unit", "GPS s.o.w=ms")[1])
    log = logs.file("log.csv", f"row,{OWN}\n" + rows(STEPS, *GYRO.T))
    logs.rejected(log, "no --rate. Type --rate HZ")


OTHERWISE = {  # names that are nearly those of davarlab
    "gx beside time_s": "time_s,gx_dps,gy_dps,gz_dps",
    "a time in German": "Zeit [s],gx_dps,gy_dps,gz_dps",
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
