"""MCAP files of the format's own library, with each of its options: tools/davarlab import, which
reads them with rosbags, gives what that library reads.
"""

import csv
import io
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lab"))

import asking
import numpy as np
from mcap import reader
from mcap.writer import CompressionType, IndexType, Writer
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

KIND = "sensor_msgs/msg/Imu"
COUNT = 120
START_NS = 1_700_000_000_123_456_789
DEFINITION, _ = get_typestore(Stores.ROS2_HUMBLE).generate_msgdef(KIND, ros_version=2)


def vector(rng):
    return dict(zip("xyz", rng.normal(0, 1, 3).tolist()))


def written(**options):
    """The bytes of a log with one topic, by the library's writer of ROS 2 messages."""
    file, rng = io.BytesIO(), np.random.default_rng(5)
    log = Ros2Writer(file, **options)
    schema = log.register_msgdef(KIND, DEFINITION)
    for i in range(COUNT):
        ns = START_NS + 5_000_000 * i
        message = {
            "header": {
                "stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9},
                "frame_id": "imu",
            },
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
            "orientation_covariance": [0.0] * 9,
            "angular_velocity": vector(rng),
            "angular_velocity_covariance": [0.0] * 9,
            "linear_acceleration": vector(rng),
            "linear_acceleration_covariance": [0.0] * 9,
        }
        log.write_message("/imu", schema, message, log_time=ns + 700_000)
    log.finish()
    return file.getvalue()


def copied(data, **options):
    """The same messages, written again with other options."""
    file = io.BytesIO()
    log, ids = Writer(file, **options), {}
    log.start(profile="ros2")
    for schema, channel, message in reader.make_reader(io.BytesIO(data)).iter_messages():
        if channel.id not in ids:
            kind = log.register_schema(schema.name, schema.encoding, schema.data)
            ids[channel.id] = log.register_channel(channel.topic, channel.message_encoding, kind)
        log.add_message(
            ids[channel.id], message.log_time, message.data, message.publish_time, message.sequence
        )
    log.finish()
    return file.getvalue()


def theirs(data):
    """(stamps in ns, gyro in deg/s and accelerometer in g as rows of x, y, z)"""
    found = reader.make_reader(io.BytesIO(data), decoder_factories=[DecoderFactory()])
    messages = [one.decoded_message for one in found.iter_decoded_messages()]
    stamps = [one.header.stamp.sec * 10**9 + one.header.stamp.nanosec for one in messages]
    gyro = [[getattr(one.angular_velocity, axis) for one in messages] for axis in "xyz"]
    accel = [[getattr(one.linear_acceleration, axis) for one in messages] for axis in "xyz"]
    return stamps, np.rad2deg(gyro), np.array(accel) / 9.80665


class Mcap(unittest.TestCase):
    def imported(self, data):
        """(the command with its status and output, name -> values as text)"""
        with tempfile.TemporaryDirectory() as folder:
            log, out = Path(folder, "log.mcap"), Path(folder, "out.csv")
            log.write_bytes(data)
            done = asking.run("import", log, "-o", out)
            lines = out.read_text().splitlines() if out.exists() else []
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
        return done, dict(zip(rows[0], zip(*rows[1:]))) if rows else {}

    def check(self, data):
        done, columns = self.imported(data)
        self.assertEqual(0, done.returncode, done.stderr)
        stamps, gyro, accel = theirs(data)
        whole = [
            int(second) * 10**9 + int(part.ljust(9, "0") or 0)
            for second, _, part in (text.partition(".") for text in columns["time_s"])
        ]
        self.assertEqual(stamps, whole)
        for rows, name in ((gyro, "gyro_{}_dps"), (accel, "accel_{}_g")):
            for row, axis in zip(rows, "xyz"):
                ours = np.float64(columns[name.format(axis)])
                np.testing.assert_allclose(ours, row, rtol=5e-9)  # nine digits

    def test_each_compression_and_many_chunks(self):
        for compression in CompressionType:
            for size in (1024, 1 << 20):
                with self.subTest(compression=compression, size=size):
                    self.check(written(compression=compression, chunk_size=size))

    def test_without_crcs(self):
        self.check(written(enable_crcs=False))

    def test_without_chunks_or_parts_of_the_summary(self):
        data, missing = written(), IndexType.NONE
        for options in (
            {"use_chunking": False},
            {"index_types": missing},
            {"use_statistics": False},
            {"use_summary_offsets": False},
            {"index_types": missing, "repeat_channels": False, "repeat_schemas": False}
            | {"use_statistics": False, "use_summary_offsets": False},
        ):
            with self.subTest(options):
                self.check(copied(data, **options))

    def test_a_summary_that_omits_its_topics_is_the_reason_of_the_error(self):
        for omitted in ("repeat_schemas", "repeat_channels"):
            with self.subTest(omitted):
                done, columns = self.imported(copied(written(), **{omitted: False}))
                self.assertEqual((2, {}), (done.returncode, columns))
                self.assertRegex(
                    done.stderr, "^davarlab: .*log.mcap: no topic with a message .*\n$"
                )

    def test_a_log_without_messages_contains_no_gyro(self):
        file = io.BytesIO()
        log = Writer(file)
        log.start(profile="ros2")
        log.finish()
        done, columns = self.imported(file.getvalue())
        self.assertEqual((2, {}), (done.returncode, columns))
        self.assertRegex(done.stderr, "^davarlab: .*log.mcap: it contains no gyro .*\n$")


if __name__ == "__main__":
    unittest.main()
