"""ROS 1 bags, ROS 2 bags (a folder, a db3 or an MCAP file), read message by message by rosbags;
message types come from the bag, or from .msg files."""

import io
import os
from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from .. import files
from ..arrays import Ints
from ..errors import BadInput
from ..files import StrPath
from ..tables import guess
from . import named, units
from .options import Options
from .sensor import Numbers, Samples, Sensor

IMU, TEMPERATURE = "sensor_msgs/msg/Imu", "sensor_msgs/msg/Temperature"
KNOWN = {
    IMU: {
        "gyro": [f"angular_velocity.{axis}" for axis in "xyz"],
        "accel": [f"linear_acceleration.{axis}" for axis in "xyz"],
    },
    TEMPERATURE: {"temp": ["temperature"]},
}
OF_OTHERS = (
    "geometry_msgs/",
    "nav_msgs/",
    "tf",
    "sensor_msgs/",
)  # no sensor's own; rates in them are somebody's estimate
UNTYPED = "__schemaless__"  # the name that rosbags gives
LONGEST = 9  # numbers of an array that is looked into


class Held(io.BufferedReader):
    """A file of which no more is asked than it holds: a reader takes the length that a damaged
    record claims, and memory of that size, at its word."""

    def read(self, size: int | None = -1) -> bytes:
        if size is not None and size > io.DEFAULT_BUFFER_SIZE:
            size = min(size, max(os.fstat(self.fileno()).st_size - self.tell(), 0))
        return super().read(size)


class HeldPath(type(Path())):  # type: ignore[misc]  # that of the system: Path has none below it
    """The path of a bag."""

    def open(self, mode: str = "r", *how: Any, **more: Any) -> Any:
        files.check_regular(self)
        return Held(io.FileIO(self)) if mode == "rb" else super().open(mode, *how, **more)


def typestore(paths: Sequence[StrPath]) -> Any:
    """The types of ROS 2, and those of .msg files (PACKAGE/msg/NAME.msg, or a folder of such)."""
    store = get_typestore(Stores.LATEST)
    found = [
        path
        for given in map(Path, paths)
        for path in (sorted(given.rglob("*.msg")) if os.path.isdir(given) else [given])
    ]
    if paths and not found:
        raise BadInput(f"{paths[0]}: it contains no .msg file")
    for path in found:
        place = files.real(path)
        package = place.parts[-3] if place.parent.name == "msg" else place.parent.name
        try:
            store.register(
                get_types_from_msg(
                    files.read_whole(path).decode("utf-8"), f"{package}/msg/{path.stem}"
                )
            )
        except BadInput:
            raise
        except Exception as why:  # whatever the parser of a grammar raises
            raise BadInput(f"{path}: no message definition ({str(why).splitlines()[0]})") from None
    return store


def check_databases(path: StrPath) -> None:
    """Raises BadInput for a bag whose database was cut off: SQLite reads zeros after its end. The
    size in its header counts if both change counters agree (https://sqlite.org/fileformat2.html,
    1.3.8).
    """
    for one in sorted(Path(path).glob("*.db3")) if os.path.isdir(path) else [Path(path)]:
        with files.reading(one) as file:
            head, size = file.read(96), file.seek(0, os.SEEK_END)
        if head.startswith(b"SQLite format 3\0") and head[24:28] == head[92:96]:
            page = int.from_bytes(head[16:18], "big")
            whole = (65536 if page == 1 else page) * int.from_bytes(head[28:32], "big")
            if size < whole:
                raise BadInput(
                    f"{one}: cut short: {size} of {whole} bytes (SQLite; sqlite3 .recover writes "
                    "what is left to a new file)"
                )


class Log:
    def __init__(self, path: StrPath, options: Options) -> None:
        self.path, self.units, self.store = path, options.units, typestore(options.types)
        check_databases(path)
        self.sensors: list[Sensor] = []
        self.fields: dict[str, dict[str, list[str]]] = {}
        with self.opened() as bag:
            typed = any(one.msgtype != UNTYPED for one in bag.connections)
            if not typed and (bag.connections or bag.message_count):
                raise BadInput(
                    f"{path}: no topic with a message type (if the summary of an MCAP file omits "
                    "topics or types, mcap recover rewrites the file)"
                )
            for topic in dict.fromkeys(one.topic for one in bag.connections):
                self.look(bag, topic)

    def opened(self) -> Any:
        return AnyReader([HeldPath(self.path)], default_typestore=self.store)

    def look(self, bag: Any, topic: str) -> None:
        """Lists a topic if it is a sensor's."""
        connections = [one for one in bag.connections if one.topic == topic]
        kind, count = connections[0].msgtype, sum(one.msgcount for one in connections)
        fields = KNOWN.get(kind)
        rank = 0 if fields else 2 if kind.startswith(OF_OTHERS) else 1
        if not fields and count and kind in bag.typestore.fielddefs:
            _, _, raw = next(bag.messages(connections))
            fields = sought(bag.deserialize(raw, kind), topic)
        if fields:
            self.fields[topic] = fields
            self.sensors.append(
                Sensor(topic, frozenset(fields), count, topic.rsplit("/", 1)[0], rank)
            )

    def read(self, topic: str) -> Samples:
        fields = [field for names in self.fields[topic].values() for field in names]
        numbers, sent, stamped = [array("d") for _ in fields], array("q"), array("q")
        with self.opened() as bag:
            connections = [one for one in bag.connections if one.topic == topic]
            kind = connections[0].msgtype
            ways = [
                [int(step) if step.isdigit() else step for step in field.split(".")]
                for field in fields
            ]
            for _, when, raw in bag.messages(connections):
                message = bag.deserialize(raw, kind)
                for column, way in zip(numbers, ways):
                    column.append(followed(message, way))
                sent.append(when)
                stamp = getattr(getattr(message, "header", None), "stamp", None)
                stamped.append(stamp.sec * 1_000_000_000 + stamp.nanosec if stamp else 0)
        stamps = np.frombuffer(stamped, np.int64) if len(stamped) else np.array([], np.int64)
        own = len(stamps) > 0 and bool(np.all(stamps > 0))
        notes = {
            "source": f"ROS bag, {topic}, {'header.stamp' if own else 'time of arrival'}",
            "time_s": "seconds of the clock of the robot (Unix, unless simulated)",
        }
        columns = {
            field: np.frombuffer(numbers.pop(0)) for field in fields
        }  # each goes as soon as it is converted
        return self.dressed(
            topic, kind, columns, stamps if own else np.frombuffer(sent, np.int64), notes
        )

    def dressed(
        self,
        topic: str,
        kind: str,
        columns: dict[str, Numbers],
        stamps: Ints,
        notes: dict[str, str],
    ) -> Samples:
        """Samples: of a known type with its units, else guessed."""
        if kind in KNOWN:
            out = {}
            for quantity, names in self.fields[topic].items():
                out.update(
                    units.axes(quantity, [columns.pop(name) for name in names], "rad/s", "m/s^2")
                )
            return Samples(out, stamps, notes=notes)
        quantities = {
            name: quantity for quantity, names in self.fields[topic].items() for name in names
        }
        called = {
            name: name if guess.quantity_of(name) == quantity else f"{quantity}.{name}"
            for name, quantity in quantities.items()
        }
        found = named.dressed(
            {called[name]: column for name, column in columns.items()}, self.units, self.path, {}
        )
        found.stamps_ns, found.notes = stamps, notes
        return found


def followed(message: Any, way: Sequence[int | str]) -> Any:
    for step in way:
        message = message[step] if isinstance(step, int) else getattr(message, step)
    return message


def numbers_of(value: Any, name: str = "") -> Iterator[str]:
    """The names of the numbers in a message, as paths."""
    if isinstance(value, (bool, str, bytes)) or value is None:
        return
    if isinstance(value, (int, float)):
        yield name
    elif isinstance(value, (list, np.ndarray)):
        if len(value) <= LONGEST:
            for place, one in enumerate(value):
                yield from numbers_of(
                    one.item() if hasattr(one, "item") else one, f"{name}.{place}"
                )
    else:
        for field in getattr(value, "__dataclass_fields__", {}):
            if field not in ("header", "__msgtype__"):
                yield from numbers_of(getattr(value, field), f"{name}.{field}".lstrip("."))


def sought(message: Any, topic: str) -> dict[str, list[str]]:
    """quantity -> fields of a message of somebody's own type: axes of a gyro or an accelerometer, a
    temperature; empty without one. A topic that is called after the temperature has it in its first
    number."""
    names = list(numbers_of(message))
    found = named.quantities(names)
    return found or ({"temp": names[:1]} if names and guess.quantity_of(topic) == "temp" else {})
