"""examples/ros2 with the message classes of rosbags, which come from ROS 2's own definitions: the
covariance of known noise, what is unknown, gaps, and messages that survive serialization.
"""

import importlib.util
import math
import sys
from unittest import mock

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore
from together import ROOT

RATE_HZ, SECONDS = 200, 60
ARW = (0.2, 0.5, 1.1)  # deg/sqrt(h)
OPTIONS = {"law": "fixed", "window_max": 4000, "window_min": 1000, "segment": 500}
STORE = get_typestore(Stores.ROS2_HUMBLE)


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("imu_noise", ROOT / "examples/ros2/imu_noise.py")
    module = importlib.util.module_from_spec(spec)
    with mock.patch.dict(sys.modules, imu_noise=module):
        spec.loader.exec_module(module)
    return module


@pytest.fixture
def node(example):
    return example.ImuNoise(RATE_HZ, **OPTIONS)


def message(name, **fields):
    return STORE.types[name](**fields)


def again(one, name):
    """A message after serialization."""
    return STORE.deserialize_cdr(STORE.serialize_cdr(one, name), name)


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


def deliver(node, samples):
    """Gives the samples to the node and returns the last message."""
    for number, rates in enumerate(samples):
        one = imu(number, rates)
        node.take(one)
    return one


def statuses(node):
    names = ("diagnostic_msgs/msg/DiagnosticStatus", "diagnostic_msgs/msg/KeyValue")
    return node.statuses(*(STORE.types[name] for name in names))


@pytest.mark.parametrize("seeds", (range(1), pytest.param(range(8), marks=pytest.mark.soak)))
def test_the_diagonal_is_the_variance_of_the_samples(example, seeds):
    ratios, truth = [], np.radians(np.array(ARW)) ** 2 / 3600 * RATE_HZ
    for seed in seeds:
        node, samples = example.ImuNoise(RATE_HZ, **OPTIONS), noise(seed)
        for part in np.split(samples, 2):
            one = deliver(node, part)
            ratios.append(one.angular_velocity_covariance[[0, 4, 8]] / truth)
            assert (one.angular_velocity_covariance[[1, 2, 3, 5, 6, 7]] == 7).all()
        np.testing.assert_array_equal(
            one.angular_velocity_covariance, again(one, one.__msgtype__).angular_velocity_covariance
        )
    # Windows of 4000 samples; the best estimator scatters by 2.2 %.
    assert abs(np.mean(ratios) - 1) < 0.015
    assert np.std(ratios) < 0.06


def test_an_unknown_axis_leaves_the_matrix_of_the_driver(node):
    samples = noise(1, 3000)
    samples[:, 1] = 0.0  # stuck
    assert (deliver(node, samples[:1]).angular_velocity_covariance == 7).all()
    assert {status.message for status in statuses(node)} == {"no result yet"}
    assert (deliver(node, samples).angular_velocity_covariance == 7).all()
    x, y, _ = statuses(node)
    assert (x.level, y.level) == (x.OK, y.WARN)
    assert (y.name, y.values[0].value) == ("gyro y: noise", "nan")


def test_lost_messages_are_gaps(node):
    for number, rates in enumerate(noise(2, 4000)):
        if number % 500 not in (100, 101, 102):
            node.take(imu(number, rates))
    health = node.axes["x"].stream.health
    assert (health["gaps"], health["missing"]) == (8, 24)


def test_diagnostics_survive_serialization(node):
    deliver(node, noise(3, 3000))
    for status in statuses(node):
        read = again(status, "diagnostic_msgs/msg/DiagnosticStatus")
        assert read == status
        values = {one.key: float(one.value) for one in read.values}
        names = (f"arw_{end}deg_per_sqrt_h" for end in ("low_", "", "high_"))
        low, arw, high = (values[name] for name in names)
        assert low < arw < high
