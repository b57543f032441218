"""ROS 2 node: fills the gyro covariance of sensor_msgs/Imu with the measured noise, and reports it.

    ros2 topic:  imu/data_raw (sensor_msgs/Imu)  ->  imu/data, /diagnostics
    run:         python3 imu_noise.py --ros-args -p rate_hz:=200.0 -p bandwidth:=41:2

Parameters: rate_hz (of the messages), full_scale_dps (of the gyro), bandwidth (its low-pass, see
docs/PYTHON.md; empty: unknown). The node needs the Python package davar (`pip install .`).

The diagonal is replaced only while all three axes have an angle random walk. Otherwise imu/data has
the matrix of the driver, because 0 would mean a gyro without noise. The diagonal is the variance of
one message, (rad/s)^2, of the white noise. It has no bias instability.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import davar

AXES = ("x", "y", "z")
DIAGONAL = (0, 4, 8)
RAD_PER_SQRT_S = math.pi / 180 / 60  # of 1 deg/sqrt(h)


@dataclass
class Axis:
    """One axis, and its newest epoch: column -> value."""

    stream: davar.Stream
    newest: dict[str, float] = field(default_factory=dict)

    def push(self, rate_dps: float, missing: int) -> None:
        if missing:
            self.stream.gap(missing)
        if self.stream.push(rate_dps):
            epochs = self.stream.results()
            self.newest = {name: float(column[-1]) for name, column in epochs.items()}

    def variance(self, rate_hz: float) -> float:
        """Of one sample, (rad/s)^2; NaN: unknown."""
        arw = self.newest.get("arw_deg_per_sqrt_h", math.nan)
        return (arw * RAD_PER_SQRT_S) ** 2 * rate_hz

    def problem(self) -> str:
        """Why its noise must not be trusted; empty: nothing."""
        if not self.newest:
            return "no result yet"
        if self.newest["filtered"]:
            return "the short cluster sizes read low: set bandwidth to the gyro's low-pass"
        if math.isnan(self.newest["arw_deg_per_sqrt_h"]):
            return "white noise cannot be separated from other noise, or no sample changes"
        return "the noise is changing" if self.newest["unstable"] else ""


class ImuNoise:
    """Three axes. rate_hz: of the messages. full_scale_dps: samples beyond it count as saturated.
    options: of davar.Stream."""

    def __init__(self, rate_hz: float, full_scale_dps: float = 2000.0, **options: Any) -> None:
        def stream() -> davar.Stream:
            settings = {"mode": "trailing", "stride": max(1, round(rate_hz / 10)), **options}
            return davar.Stream(rate_hz, full_scale=full_scale_dps, **settings)

        self.rate_hz, self.last_s = rate_hz, math.nan
        self.axes = {name: Axis(stream()) for name in AXES}

    def take(self, imu: Any) -> None:
        """Takes a sensor_msgs/Imu and fills its covariance. A hole between time stamps is a gap."""
        stamp_s = imu.header.stamp.sec + 1e-9 * imu.header.stamp.nanosec
        steps = (stamp_s - self.last_s) * self.rate_hz
        missing = max(0, round(steps) - 1) if steps > 1.5 else 0
        self.last_s = stamp_s
        for name, axis in self.axes.items():
            axis.push(math.degrees(getattr(imu.angular_velocity, name)), missing)
        variances = [axis.variance(self.rate_hz) for axis in self.axes.values()]
        if not any(map(math.isnan, variances)):
            for place, variance in zip(DIAGONAL, variances, strict=True):
                imu.angular_velocity_covariance[place] = variance

    def statuses(self, status_type: Any, key_value_type: Any) -> list[Any]:
        """A diagnostic_msgs/DiagnosticStatus for each axis."""
        found = []
        for name, axis in self.axes.items():
            problem = axis.problem()
            columns = ("arw", "arw_low", "arw_high")
            shown = [f"{column}_deg_per_sqrt_h" for column in columns]
            shown += ["bi_deg_per_h", "window_samples"]
            found.append(
                status_type(
                    level=status_type.WARN if problem else status_type.OK,
                    name=f"gyro {name}: noise",
                    message=problem or "the angle random walk is known",
                    hardware_id="",
                    values=[
                        key_value_type(key=one, value=f"{axis.newest.get(one, math.nan):.6g}")
                        for one in shown
                    ],
                )
            )
        return found


def main() -> None:
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    from rclpy.node import Node
    from rclpy.qos import qos_profile_sensor_data
    from sensor_msgs.msg import Imu

    rclpy.init()
    node = Node("imu_noise")
    for name, usual in (("rate_hz", 100.0), ("full_scale_dps", 2000.0), ("bandwidth", "")):
        node.declare_parameter(name, usual)
    noise = ImuNoise(
        node.get_parameter("rate_hz").value,
        node.get_parameter("full_scale_dps").value,
        bandwidth=node.get_parameter("bandwidth").value or None,
    )
    filled = node.create_publisher(Imu, "imu/data", qos_profile_sensor_data)
    diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def on_imu(imu: Any) -> None:
        noise.take(imu)
        filled.publish(imu)

    def on_timer() -> None:
        array = DiagnosticArray(status=noise.statuses(DiagnosticStatus, KeyValue))
        array.header.stamp = node.get_clock().now().to_msg()
        diagnostics.publish(array)

    node.create_subscription(Imu, "imu/data_raw", on_imu, qos_profile_sensor_data)
    node.create_timer(1.0, on_timer)
    try:
        rclpy.spin(node)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
