"""PX4 ULog (docs.px4.io, ULog file format), read by pyulog. Gyros in rad/s, accelerometers in
m/s^2, stamps in microseconds since boot."""

import contextlib
import io
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from pyulog import ULog

from .. import files
from ..arrays import Ints
from ..errors import BadInput
from ..files import StrPath
from . import units
from .options import Options
from .sensor import Numbers, Samples, Sensor

SINCE_BOOT, SELECTION = "seconds since boot", "sensor_selection"
XYZ = ("x", "y", "z")
HEADER = 3  # bytes before each message
# topic: (what it measures: fields of x, y, z; rank). Rank 1: filtered, made of the others.
TOPICS: dict[str, tuple[dict[str, Sequence[str]], int]] = {
    "sensor_combined": (
        {
            "gyro": [f"gyro_rad[{i}]" for i in range(3)],
            "accel": [f"accelerometer_m_s2[{i}]" for i in range(3)],
        },
        0,
    ),
    "sensor_gyro": ({"gyro": XYZ, "temp": ["temperature"]}, 0),
    "sensor_gyro_fifo": ({"gyro": XYZ}, 0),
    "sensor_accel": ({"accel": XYZ, "temp": ["temperature"]}, 0),
    "sensor_accel_fifo": ({"accel": XYZ}, 1),
    "vehicle_angular_velocity": ({"gyro": [f"xyz[{i}]" for i in range(3)]}, 1),
    "vehicle_acceleration": ({"accel": [f"xyz[{i}]" for i in range(3)]}, 1),
}
NO_ACCEL = np.iinfo(
    np.int32
).max  # sensor_combined.accelerometer_timestamp_relative of a sample without one


class Log:
    def __init__(self, path: StrPath, options: Options) -> None:
        self.path = path
        with files.reading(path) as file, contextlib.redirect_stdout(io.StringIO()) as said:
            whole = Watched(file, os.path.getsize(path))
            log = ULog(whole, [*TOPICS, SELECTION], True)
        if whole.cut:
            raise BadInput(
                f"{path}: cut short: its last message is incomplete (PX4 ULog). "
                f"{files.without_end(path, whole.begun)}"
            )
        if log.file_corruption:
            what = [*said.getvalue().strip().splitlines(), "messages of a wrong length"][0]
            raise BadInput(f"{path}: damaged ({what})")
        self.data = {
            f"{one.name}:{one.multi_id}": one
            for one in log.data_list
            if one.name in TOPICS and set(fields(one)) <= set(one.data)
        }
        selected = selected_gyro(log.data_list)
        self.sensors = [
            Sensor(
                name,
                frozenset(gives(one)),
                len(one.data["timestamp"]),
                str(one.multi_id)
                if one.name.startswith("sensor_") and one.name != "sensor_combined"
                else selected,
                TOPICS[one.name][1],
            )
            for name, one in self.data.items()
        ]

    def read(self, name: str) -> Samples:
        one = self.data[name]
        found = (fifo if one.name.endswith("_fifo") else plain)(one, f"{self.path}: {name}")
        found.notes.update({"source": f"PX4 ULog, {name}", "time_s": SINCE_BOOT})
        return found


class Watched:
    """A file that remembers whether somebody asked for more than was left of it, other than at its
    very end, and where the last message began: with a header of three bytes."""

    def __init__(self, file: io.BufferedReader, size: int) -> None:
        self.file, self.size, self.cut, self.begun = file, size, False, 0

    def read(self, count: int) -> bytes:
        if count == HEADER:
            self.begun = self.file.tell()
        data = self.file.read(count)
        self.cut |= 0 < len(data) < count or not data and count > HEADER
        return data

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)


def selected_gyro(topics: Iterable[Any]) -> str:
    """The instance of the gyro that sensor_combined was made of; empty where the log does not say,
    or it changed."""
    device = next(
        (set(one.data["gyro_device_id"].tolist()) for one in topics if one.name == SELECTION), set()
    )
    return next(
        (
            str(one.multi_id)
            for one in topics
            if one.name == "sensor_gyro"
            and set(one.data.get("device_id", np.array([-1])).tolist()) == device
        ),
        "",
    )


def fields(one: Any) -> list[str]:
    """Those that a topic must have: its axes."""
    if one.name.endswith("_fifo"):
        return [f"{axis}[0]" for axis in XYZ] + ["dt", "samples", "scale", "timestamp_sample"]
    return [
        field
        for quantity, names in TOPICS[one.name][0].items()
        if quantity != "temp"
        for field in names
    ]


def gives(one: Any) -> list[str]:
    return [
        quantity
        for quantity, names in TOPICS[one.name][0].items()
        if quantity != "temp" or units.measured(one.data.get(names[0]))
    ]


def stamps(data: Mapping[str, Numbers], where: str) -> Ints:
    """Of the samples where the topic has them, else of its messages: nanoseconds."""
    sampled = data.get("timestamp_sample")
    return units.nanoseconds(
        sampled if sampled is not None and np.all(sampled > 0) else data["timestamp"], 1000, where
    )


def plain(one: Any, where: str) -> Samples:
    data, own, beside = one.data, {}, []
    for quantity in gives(one):
        columns = units.axes(
            quantity, [data[field] for field in TOPICS[one.name][0][quantity]], "rad/s", "m/s^2"
        )
        late = data.get("accelerometer_timestamp_relative") if quantity == "accel" else None
        if late is None:
            own.update(columns)
            continue
        there = late != NO_ACCEL
        when = stamps(data, where)[there] + late[there].astype(np.int64) * 1000
        beside += (
            [(when, {name: column[there] for name, column in columns.items()})]
            if np.any(there)
            else []
        )
    return Samples(own, stamps(data, where), beside)


def fifo(one: Any, where: str) -> Samples:
    """Many samples in a message, dt microseconds apart, the last of them at timestamp_sample."""
    data, quantity = one.data, next(iter(TOPICS[one.name][0]))
    width = sum(name.startswith("x[") for name in data)
    place, count = np.arange(width), data["samples"].astype(np.int64)[:, None]
    there = place < count
    ago = (count - 1 - place) * data["dt"].astype(np.float64)[:, None] * 1000
    when = (
        units.nanoseconds(data["timestamp_sample"], 1000, where)[:, None]
        - np.round(ago).astype(np.int64)
    )[there]
    values = [
        (
            np.stack([data[f"{axis}[{i}]"] for i in range(width)], 1)
            * data["scale"].astype(np.float64)[:, None]
        )[there]
        for axis in XYZ
    ]
    return Samples(units.axes(quantity, values, "rad/s", "m/s^2"), when)
