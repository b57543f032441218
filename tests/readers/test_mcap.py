"""MCAP files of the format's own library, with each of its options: tools/davarlab import, which
reads them with rosbags, gives what that library reads.
"""

import csv
import functools
import io

import asking
import numpy as np
import pytest
from mcap import reader
from mcap.writer import CompressionType, IndexType, Writer
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

KIND = "sensor_msgs/msg/Imu"
COUNT = 120
START_NS = 1_700_000_000_123_456_789
LEAN = {"use_statistics": False, "use_summary_offsets": False, "index_types": IndexType.NONE}
LEAN |= {"repeat_channels": False, "repeat_schemas": False}
OPTIONS = [
    *(
        {"compression": one, "chunk_size": size}
        for one in CompressionType
        for size in (1024, 1 << 20)
    ),
    {"enable_crcs": False},
    {"use_chunking": False},
    {"index_types": IndexType.NONE},
    {"use_statistics": False},
    {"use_summary_offsets": False},
    LEAN,
]


@functools.cache
def written():
    """The bytes of a log with one topic, by the library's writer of ROS 2 messages."""
    file, rng = io.BytesIO(), np.random.default_rng(5)
    definition, _ = get_typestore(Stores.ROS2_HUMBLE).generate_msgdef(KIND, ros_version=2)
    log = Ros2Writer(file)
    schema = log.register_msgdef(KIND, definition)
    unknown = [0.0] * 9
    for i in range(COUNT):
        ns = START_NS + 5_000_000 * i
        stamp = {"sec": ns // 10**9, "nanosec": ns % 10**9}
        rate, force = (dict(zip("xyz", rng.normal(0, 1, 3).tolist())) for _ in range(2))
        message = {
            "header": {"stamp": stamp, "frame_id": "imu"},
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
            "orientation_covariance": unknown,
            "angular_velocity": rate,
            "angular_velocity_covariance": unknown,
            "linear_acceleration": force,
            "linear_acceleration_covariance": unknown,
        }
        log.write_message("/imu", schema, message, log_time=ns + 700_000)
    log.finish()
    return file.getvalue()


def copied(messages=True, **options):
    """The same messages, or none, written again with other options."""
    file = io.BytesIO()
    log, ids = Writer(file, **options), {}
    log.start(profile="ros2")
    there = reader.make_reader(io.BytesIO(written())).iter_messages() if messages else ()
    for schema, channel, one in there:
        if channel.id not in ids:
            kind = log.register_schema(schema.name, schema.encoding, schema.data)
            ids[channel.id] = log.register_channel(channel.topic, channel.message_encoding, kind)
        log.add_message(ids[channel.id], one.log_time, one.data, one.publish_time, one.sequence)
    log.finish()
    return file.getvalue()


def theirs(data):
    """(stamps in ns, gyro in deg/s and accelerometer in g as rows of x, y, z)."""
    found = reader.make_reader(io.BytesIO(data), decoder_factories=[DecoderFactory()])
    messages = [one.decoded_message for one in found.iter_decoded_messages()]
    stamps = [one.header.stamp.sec * 10**9 + one.header.stamp.nanosec for one in messages]
    gyro = [[getattr(one.angular_velocity, axis) for one in messages] for axis in "xyz"]
    accel = [[getattr(one.linear_acceleration, axis) for one in messages] for axis in "xyz"]
    return stamps, np.rad2deg(gyro), np.array(accel) / 9.80665


def imported(folder, data):
    """(the command with its status and output, name -> values as text)."""
    log, out = folder / "log.mcap", folder / "out.csv"
    log.write_bytes(data)
    done = asking.run("import", log, "-o", out)
    lines = out.read_text().splitlines() if out.exists() else []
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    return done, dict(zip(rows[0], zip(*rows[1:]))) if rows else {}


def nanoseconds(text):
    second, _, part = text.partition(".")
    return int(second) * 10**9 + int(part.ljust(9, "0") or 0)


@pytest.mark.parametrize("options", OPTIONS, ids=lambda one: "-".join(map(str, one.values())))
def test_a_log_is_read_as_the_library_reads_it(tmp_path, options):
    data = copied(**options)
    done, columns = imported(tmp_path, data)
    assert done.returncode == 0, done.stderr
    stamps, gyro, accel = theirs(data)
    assert [nanoseconds(text) for text in columns["time_s"]] == stamps
    assert len(stamps) == COUNT
    for rows, name in ((gyro, "gyro_{}_dps"), (accel, "accel_{}_g")):
        for row, axis in zip(rows, "xyz"):
            ours = np.float64(columns[name.format(axis)])
            np.testing.assert_allclose(ours, row, rtol=5e-9)  # nine digits


@pytest.mark.parametrize(
    "options, words",
    [
        ({"repeat_schemas": False}, "no topic with a message"),
        ({"repeat_channels": False}, "no topic with a message"),
        ({"messages": False}, "it contains no gyro"),
    ],
    ids=["no schemas", "no channels", "no messages"],
)
def test_a_log_without_readable_topics_is_rejected_with_the_reason(tmp_path, options, words):
    done, columns = imported(tmp_path, copied(**options))
    assert (done.returncode, columns) == (2, {})
    assert done.stderr.startswith("davarlab: ") and done.stderr.count("\n") == 1
    assert f"log.mcap: {words} " in done.stderr
