"""One recording of a known gyro, written as the log of every program whose logs davarlab reads, by
the writers of those formats' own libraries.
"""

import struct
from pathlib import Path

import h5py
import numpy as np
import pyarrow
from pyarrow import parquet
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy import io

START_NS = 1_700_000_000_123_456_789
RATE_HZ = 200
G = 9.80665
CUSTOM = "std_msgs/Header header\nfloat32[3] gyro_dps\nfloat32[3] acc_g\nfloat32 temp\n"


class Truth:
    """count samples: stamps_ns (int64), gyro (deg/s, 3 rows), accel (g), temp (degC), as float32
    can hold them.
    """

    def __init__(self, count=400, seed=3):
        rng = np.random.default_rng(seed)
        self.count = count
        self.stamps_ns = START_NS + np.arange(count, dtype=np.int64) * (10**9 // RATE_HZ)
        self.gyro, self.accel = (
            rng.normal(0, sigma, (3, count)).astype(np.float32) + np.float32([[x], [y], [z]])
            for sigma, x, y, z in ((0.5, 1, -2, 0.25), (0.01, 0.1, 0, 1))
        )
        self.temp = np.linspace(20, 25, count).astype(np.float32)
        self.since_start = (self.stamps_ns - START_NS) / 1e9

    @property
    def rad_s(self):
        return np.deg2rad(self.gyro.astype(np.float64))

    @property
    def m_s2(self):
        return self.accel.astype(np.float64) * G


def ulog(path, truth, gyros=2):
    """PX4: sensor_gyro of several units, sensor_accel at half the rate and 10 degrees warmer, boot
    times. pyulog writes only what it has read: the bytes are ours, by the documented layout of the
    format, and pyulog reads them.
    """

    fields = (
        "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;"
        "float x;float y;float z;float temperature"
    )
    topics = [("sensor_gyro", one) for one in range(gyros)] + [("sensor_accel", 0)]
    out = ulog_head({"sensor_gyro": fields, "sensor_accel": fields}, topics)

    def data(topic, unit, us, values, temp):
        body = struct.pack("<HQQI4f", topic, us + 150, us, unit, *values, temp)
        return ulog_message("D", body)

    for place, us in enumerate(boot_us(truth)):
        temp = truth.temp[place]
        for unit in range(gyros):
            out += data(unit, unit, us, truth.rad_s[:, place] * (unit + 1), temp)
        if place % 2 == 0:
            out += data(gyros, 9, us, truth.m_s2[:, place], temp + 10)
    Path(path).write_bytes(out)


def ulog_message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def ulog_head(formats, topics):
    """What stands before the data: name -> fields, and (name, instance) of each topic."""
    out = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + ulog_message("B", bytes(40))
    for topic, fields in formats.items():
        out += ulog_message("F", f"{topic}:{fields};".encode())
    for number, (topic, one) in enumerate(topics):
        out += ulog_message("A", struct.pack("<BH", one, number) + topic.encode())
    return out


FIFO = (
    "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float dt;float scale;"
    "int16_t[32] x;int16_t[32] y;int16_t[32] z;uint8_t samples;uint8_t[3] _padding0"
)


def fifo(path, counts, rate_hz, scale, sizes, first_us=5_000_000):
    """PX4: sensor_gyro_fifo (SensorGyroFifo.msg) of counts (3 rows), in messages of these sizes by
    turns; timestamp_sample is that of the last sample of each."""
    out, place, turn = ulog_head({"sensor_gyro_fifo": FIFO}, [("sensor_gyro_fifo", 0)]), 0, 0
    while place < counts.shape[1]:
        part = counts[:, place : place + sizes[turn % len(sizes)]]
        place, turn = place + part.shape[1], turn + 1
        us = first_us + round((place - 1) * 1e6 / rate_hz)
        axes = np.zeros((3, 32), "<i2")
        axes[:, : part.shape[1]] = part
        out += ulog_message(
            "D",
            struct.pack("<HQQIff", 0, us + 300, us, 7, 1e6 / rate_hz, scale)
            + axes.tobytes()
            + struct.pack("<B", part.shape[1]),
        )
    Path(path).write_bytes(out)


def boot_us(truth):
    return ((truth.stamps_ns - START_NS) // 1000 + 5_000_000).tolist()


def dataflash(path, truth, instances=2):
    """ArduPilot: FMT messages, then IMU with an instance field. pymavlink cannot write these."""

    out = dataflash_format(0x80, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    out += dataflash_format(
        0x81, 3 + 8 + 1 + 28, b"IMU", b"QBfffffff", b"TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T"
    )
    for place, us in enumerate(boot_us(truth)):
        rest = (*truth.m_s2[:, place], truth.temp[place])
        for one in range(instances):
            numbers = (*(truth.rad_s[:, place] * (one + 1)), *rest)
            out += struct.pack("<BBBQB7f", 0xA3, 0x95, 0x81, us, one, *numbers)
    Path(path).write_bytes(out)


def dataflash_format(kind, length, name, form, columns):
    return struct.pack("<BBB", 0xA3, 0x95, 0x80) + struct.pack(
        "<BB4s16s64s", kind, length, name, form, columns
    )


def batches(path, found):
    """ArduPilot: the batch sampler (AP_InertialSensor/LogStructure.h). found: (type,
    instance, counts per unit, first stamp in us, rate in Hz, counts in 3 rows) of each batch."""
    out = dataflash_format(0x80, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    out += dataflash_format(
        0x82, 31, b"ISBH", b"QHBBHHQf", b"TimeUS,N,type,instance,mul,smp_cnt,SampleUS,smp_rate"
    )
    out += dataflash_format(0x83, 207, b"ISBD", b"QHHaaa", b"TimeUS,N,seqno,x,y,z")
    for number, (kind, one, mul, us, rate_hz, counts) in enumerate(found):
        head = us + 900, number, kind, one, mul, counts.shape[1], us, rate_hz
        out += b"\xa3\x95\x82" + struct.pack("<QHBBHHQf", *head)
        for seqno in range(counts.shape[1] // 32):
            part = np.ascontiguousarray(counts[:, seqno * 32 : seqno * 32 + 32], "<i2")
            out += b"\xa3\x95\x83" + struct.pack("<QHH", us + 1000, number, seqno)
            out += part.tobytes()
    Path(path).write_bytes(out)


def dataflash_text(path, truth):
    lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 129, 43, IMU, Qfffffff, TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T",
    ]
    for place, us in enumerate(boot_us(truth)):
        numbers = [*truth.rad_s[:, place], *truth.m_s2[:, place], truth.temp[place]]
        lines.append(f"IMU, {us}, " + ", ".join(f"{value:.12f}" for value in numbers))
    Path(path).write_text("\n".join(lines) + "\n")


def stamp_of(store, ns):
    return store.types["builtin_interfaces/msg/Time"](sec=int(ns // 10**9), nanosec=int(ns % 10**9))


def vector(store, values):
    return store.types["geometry_msgs/msg/Vector3"](*map(float, values))


def header(store, truth, place, ros1):
    own = {"seq": place} if ros1 else {}
    stamp = stamp_of(store, truth.stamps_ns[place])
    return store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="imu", **own)


def imu(store, truth, place, head):
    unknown = np.zeros(9)
    return store.types["sensor_msgs/msg/Imu"](
        header=head,
        orientation=store.types["geometry_msgs/msg/Quaternion"](0, 0, 0, 1),
        orientation_covariance=unknown,
        angular_velocity=vector(store, truth.rad_s[:, place]),
        angular_velocity_covariance=unknown,
        linear_acceleration=vector(store, truth.m_s2[:, place]),
        linear_acceleration_covariance=unknown,
    )


def temperature(store, truth, place, head):
    kind = store.types["sensor_msgs/msg/Temperature"]
    return kind(header=head, temperature=float(truth.temp[place]), variance=0.0)


def custom(store, truth, place, head):
    return store.types["my_robot/msg/Raw"](
        header=head,
        gyro_dps=truth.gyro[:, place].copy(),
        acc_g=truth.accel[:, place].copy(),
        temp=float(truth.temp[place]),
    )


KINDS = {
    "/imu": ("sensor_msgs/msg/Imu", imu, 1),
    "/imu2": ("sensor_msgs/msg/Imu", imu, 1),
    "/temp": ("sensor_msgs/msg/Temperature", temperature, 10),
    "/raw": ("my_robot/msg/Raw", custom, 1),
}  # topic: (type, maker, every how many samples)


def fill(bag, truth, topics, ros1):
    """Writes the messages of the topics, received 0.7 ms late."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(CUSTOM, "my_robot/msg/Raw"))
    written = store.serialize_ros1 if ros1 else store.serialize_cdr
    topics = [
        (bag.add_connection(topic, KINDS[topic][0], typestore=store), *KINDS[topic])
        for topic in topics
    ]
    for place in range(truth.count):
        head = header(store, truth, place, ros1)
        for connection, kind, make, every in topics:
            if place % every == 0:
                data = written(make(store, truth, place, head), kind)
                bag.write(connection, int(truth.stamps_ns[place]) + 700_000, data)


def ros1(path, truth, topics=("/imu", "/temp")):
    with rosbag1.Writer(path) as bag:
        fill(bag, truth, topics, True)


def ros2(folder, truth, storage, topics=("/imu", "/temp")):
    """The path of the one file in the bag, db3 or mcap."""
    plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
    with rosbag2.Writer(folder, version=9, storage_plugin=plugin) as bag:
        fill(bag, truth, topics, False)
    return next(Path(folder).glob(f"*.{storage}"))


def matlab_5(path, truth):
    imu = {"gyro_rad_s": truth.rad_s.T, "acc_m_s2": truth.m_s2.T}
    io.savemat(path, {"t": truth.since_start, "imu": imu, "note": "text"})


def matlab_73(path, truth):
    """HDF5 behind 512 bytes, arrays transposed, as MATLAB writes."""
    with h5py.File(path, "w", userblock_size=512) as file:
        file["time_us"] = ((truth.stamps_ns - START_NS) // 1000)[None, :]
        file["gyro_dps"], file["accel_g"], file["temp"] = truth.gyro, truth.accel, truth.temp[None]
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b" "))


def npz(path, truth):
    columns = {"gyro_dps": truth.gyro.T, "accel_g": truth.accel.T, "temperature": truth.temp}
    np.savez(path, timestamp_ns=truth.stamps_ns, **columns)


def apart(path, truth):
    """A temperature at a rate and with a time of its own."""
    columns = {"temp_time_ns": truth.stamps_ns[::10], "temp": truth.temp[::10]}
    np.savez(path, gyro_time_ns=truth.stamps_ns, gyro_dps=truth.gyro, **columns)


def npy(path, truth):
    np.save(path, np.column_stack([truth.since_start, truth.gyro.T.astype(np.float64)]))


def table(path, truth):
    columns = {"stamp": pyarrow.array(truth.stamps_ns, pyarrow.timestamp("ns")), "temp": truth.temp}
    columns |= {f"w{'xyz'[axis]} [rad/s]": truth.rad_s[axis] for axis in range(3)}
    columns |= {f"a{name}_mps2": truth.m_s2[axis] for axis, name in enumerate("xyz")}
    parquet.write_table(pyarrow.table(columns), path)
