"""examples/ros2 with the message classes of rosbags, which come from ROS 2's own definitions: the
covariance of known noise, what is unknown, gaps, and messages that survive serialization. rclpy is
a stand-in that delivers them.
"""

import importlib.util
import math
import os
import subprocess
import sys
import types
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
LAB = os.environ.get("DAVAR_LAB_PYTHON", sys.executable)
RATE_HZ, SECONDS = 200, 60
ARW = (0.2, 0.5, 1.1)  # deg/sqrt(h)
OPTIONS = {"policy": "fixed", "window_max": 4000, "window_min": 1000, "segment": 500}


def rosbags():
    """The typestore of the lab's Python; its packages come after our own."""
    words = [LAB, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    done = subprocess.run(words, text=True, stdout=subprocess.PIPE, check=True)
    sys.path.append(done.stdout.strip())
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise unittest.SkipTest("rosbags: not installed") from None
    return get_typestore(Stores.ROS2_HUMBLE)


def setUpModule():
    global STORE, EXAMPLE
    STORE = rosbags()
    spec = importlib.util.spec_from_file_location("imu_noise", ROOT / "examples/ros2/imu_noise.py")
    EXAMPLE = importlib.util.module_from_spec(spec)
    sys.modules["imu_noise"] = EXAMPLE
    spec.loader.exec_module(EXAMPLE)


def message(name, **fields):
    return STORE.types[name](**fields)


def imu(number, rates_rad_s):
    """Message `number` at RATE_HZ, as a driver sends it: its own covariance is 7."""
    ns = round(number * 1e9 / RATE_HZ)
    stamp = message("builtin_interfaces/msg/Time", sec=100 + ns // 10**9, nanosec=ns % 10**9)
    vector = STORE.types["geometry_msgs/msg/Vector3"]
    return message(
        "sensor_msgs/msg/Imu",
        header=message("std_msgs/msg/Header", stamp=stamp, frame_id="imu"),
        orientation=message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=np.full(9, -1.0),
        angular_velocity=vector(*map(float, rates_rad_s)),
        angular_velocity_covariance=np.full(9, 7.0),
        linear_acceleration=vector(0.0, 0.0, 9.8),
        linear_acceleration_covariance=np.zeros(9),
    )


def noise(seed, count=RATE_HZ * SECONDS):
    """White noise of the three ARW, rad/s."""
    density = np.radians(np.array(ARW)) / 60
    return np.random.default_rng(seed).normal(size=(count, 3)) * density * math.sqrt(RATE_HZ)


class Covariance(unittest.TestCase):
    def statuses(self, node):
        names = ("diagnostic_msgs/msg/DiagnosticStatus", "diagnostic_msgs/msg/KeyValue")
        return node.statuses(*(STORE.types[name] for name in names))

    def test_the_diagonal_is_the_variance_of_the_samples(self):
        ratios = []
        for seed in range(8):
            node, samples = EXAMPLE.ImuNoise(RATE_HZ, **OPTIONS), noise(seed)
            for number, rates in enumerate(samples):
                one = imu(number, rates)
                node.take(one)
                if number in (len(samples) // 2, len(samples) - 1):
                    truth = np.radians(np.array(ARW)) ** 2 / 3600 * RATE_HZ
                    ratios.append(one.angular_velocity_covariance[[0, 4, 8]] / truth)
                    self.assertTrue(
                        (one.angular_velocity_covariance[[1, 2, 3, 5, 6, 7]] == 7).all()
                    )
            name = one.__msgtype__
            again = STORE.deserialize_cdr(STORE.serialize_cdr(one, name), name)
            np.testing.assert_array_equal(
                one.angular_velocity_covariance, again.angular_velocity_covariance
            )
        ratios = np.array(ratios)
        # 48 variances from windows of 4000 samples; the best estimator scatters by 2.2 %
        self.assertLess(abs(ratios.mean() - 1), 0.015)
        self.assertLess(ratios.std(), 0.06)

    def test_an_unknown_axis_leaves_the_matrix_of_the_driver(self):
        node, samples = EXAMPLE.ImuNoise(RATE_HZ, **OPTIONS), noise(1, 3000)
        samples[:, 1] = 0.0  # stuck
        for number, rates in enumerate(samples):
            one = imu(number, rates)
            node.take(one)
        self.assertTrue((one.angular_velocity_covariance == 7).all())
        x, y, _ = self.statuses(node)
        self.assertEqual((x.OK, x.WARN), (x.level, y.level))
        self.assertEqual("gyro y: noise", y.name)
        self.assertEqual("nan", y.values[0].value)

    def test_before_the_first_result_nothing_is_claimed(self):
        node, one = EXAMPLE.ImuNoise(RATE_HZ, **OPTIONS), imu(0, (0, 0, 0))
        node.take(one)
        self.assertTrue((one.angular_velocity_covariance == 7).all())
        self.assertEqual({"no result yet"}, {status.message for status in self.statuses(node)})

    def test_lost_messages_are_gaps(self):
        node = EXAMPLE.ImuNoise(RATE_HZ, **OPTIONS)
        for number, rates in enumerate(noise(2, 4000)):
            if number % 500 not in (100, 101, 102):
                node.take(imu(number, rates))
        health = node.axes["x"].stream.health
        self.assertEqual((8, 24), (health["gaps"], health["missing"]))

    def test_diagnostics_survive_serialization(self):
        node = EXAMPLE.ImuNoise(RATE_HZ, **OPTIONS)
        for number, rates in enumerate(noise(3, 3000)):
            node.take(imu(number, rates))
        for status in self.statuses(node):
            name = "diagnostic_msgs/msg/DiagnosticStatus"
            again = STORE.deserialize_cdr(STORE.serialize_cdr(status, name), name)
            self.assertEqual(status, again)
            values = {one.key: float(one.value) for one in again.values}
            arw = values["arw_deg_per_sqrt_h"]
            self.assertLess(values["arw_low_deg_per_sqrt_h"], arw)
            self.assertGreater(values["arw_high_deg_per_sqrt_h"], arw)


class StandIn:
    """A node whose spin delivers messages."""

    def __init__(self, name):
        self.values, self.published, self.timers = {}, {}, []

    def declare_parameter(self, name, value):
        self.values.setdefault(name, value)

    def get_parameter(self, name):
        return types.SimpleNamespace(value=self.values[name])

    def create_publisher(self, kind, topic, qos):
        sent = self.published.setdefault(topic, [])
        return types.SimpleNamespace(publish=sent.append)

    def create_subscription(self, kind, topic, call, qos):
        self.call = call

    def create_timer(self, period_s, call):
        self.timers.append(call)

    def get_clock(self):
        stamp = message("builtin_interfaces/msg/Time", sec=1, nanosec=2)
        return types.SimpleNamespace(now=lambda: types.SimpleNamespace(to_msg=lambda: stamp))

    def destroy_node(self):
        pass


class Main(unittest.TestCase):
    def test_the_node_publishes_what_it_receives(self):
        nodes = []

        def spin(node):
            nodes.append(node)
            for number, rates in enumerate(noise(4, 300)):
                node.call(imu(number, rates))
            node.timers[0]()

        def array(status):
            header = message("std_msgs/msg/Header", stamp=None, frame_id="")
            return message("diagnostic_msgs/msg/DiagnosticArray", header=header, status=status)

        rclpy = mock.MagicMock()
        rclpy.spin, rclpy.node.Node = spin, StandIn
        kinds = {"DiagnosticArray": array}
        for name in ("DiagnosticStatus", "KeyValue"):
            kinds[name] = STORE.types[f"diagnostic_msgs/msg/{name}"]
        modules = {
            "rclpy": rclpy,
            "rclpy.node": rclpy.node,
            "rclpy.qos": rclpy.qos,
            "diagnostic_msgs": mock.MagicMock(),
            "diagnostic_msgs.msg": types.SimpleNamespace(**kinds),
            "sensor_msgs": mock.MagicMock(),
            "sensor_msgs.msg": types.SimpleNamespace(Imu=STORE.types["sensor_msgs/msg/Imu"]),
        }
        with mock.patch.dict(sys.modules, modules):
            EXAMPLE.main()
        (node,) = nodes
        self.assertEqual(300, len(node.published["imu/data"]))
        (diagnostics,) = node.published["/diagnostics"]
        self.assertEqual(3, len(diagnostics.status))
        name = "diagnostic_msgs/msg/DiagnosticArray"
        self.assertEqual(
            diagnostics, STORE.deserialize_cdr(STORE.serialize_cdr(diagnostics, name), name)
        )


if __name__ == "__main__":
    unittest.main()
