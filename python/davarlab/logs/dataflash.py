"""ArduPilot DataFlash (.bin, or .log as text), indexed by pymavlink, whose format messages say what
is where. Gyros in rad/s, accelerometers in m/s^2.

The batch sampler (INS_LOG_BAT_MASK) logs batches of raw samples with pauses between them: ISBH has
the time of the first sample, the rate and the counts per unit; each ISBD after it has 32
samples."""

import contextlib
import io
import os
import re
import sys
import tempfile
from array import array
from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from pymavlink import DFReader

from .. import files
from ..arrays import Ints
from ..errors import BadInput
from ..files import StrPath
from . import units
from .options import Options
from .sensor import Numbers, Samples, Sensor

FIELDS = {"gyro": ("GyrX", "GyrY", "GyrZ"), "accel": ("AccX", "AccY", "AccZ"), "temp": ("T",)}
KINDS = re.compile(r"^(IMU|GYR|ACC)([123]?)$")
BATCHES = {0: ("ISB_ACC", "accel"), 1: ("ISB_GYR", "gyro")}  # by the field `type` of ISBH
BATCH_CLOCK, PER_MESSAGE = "SampleUS + n / smp_rate", 32
CLOCKS = (
    (BATCH_CLOCK, 1),
    ("SampleUS", 1000),
    ("TimeUS", 1000),
    ("TimeMS", 1_000_000),
)  # the moment of the sample first; in nanoseconds
ROWS = 1 << 14
HEAD = b"\xa3\x95"  # of a message


@contextlib.contextmanager
def silenced() -> Iterator[list[str]]:
    """The lines that pymavlink and its indexer, which is C, print meanwhile: a list that is full
    behind the block."""
    said: list[str] = []
    with tempfile.TemporaryFile() as file:
        sys.stdout.flush(), sys.stderr.flush()
        kept = [os.dup(number) for number in (1, 2)]
        try:
            for number in (1, 2):
                os.dup2(file.fileno(), number)
            with (
                contextlib.redirect_stdout(io.StringIO()),
                contextlib.redirect_stderr(io.StringIO()),
            ):
                yield said
        finally:
            for number, before in zip((1, 2), kept):
                os.dup2(before, number)
                os.close(before)
            file.seek(0)
            said += file.read().decode("utf-8", errors="replace").splitlines()


class Log:
    """sensors: of the log; rows: name -> (Source, places of its messages)."""

    def __init__(self, path: StrPath, options: Options) -> None:
        self.path = path
        self.sensors: list[Sensor] = []
        self.rows: dict[str, tuple[Source, Ints]] = {}
        batched: dict[str, tuple[Message, Ints]] = {}
        with silenced() as said:
            log = DFReader.DFReader_binary(str(path))
        self.notes = (
            {"damaged": f"{len(said)} damaged parts of the log were skipped ({said[0]})"}
            if said
            else {}
        )
        end = 0
        try:
            for kind, form in log.formats.items():
                places = np.array(log.offsets[kind], np.int64)
                end = max(end, int(places[-1]) + form.len) if len(places) else end
                if end > log.data_len:
                    raise BadInput(
                        f"{path}: cut short: its last message, {form.name}, is incomplete "
                        f"(ArduPilot DataFlash). {files.without_end(path, int(places[-1]))}"
                    )
                match = KINDS.match(form.name)
                if len(places) and match:
                    self.instances(match[1], match[2], Message(self.path, form), places)
                if len(places) and form.name in ("ISBH", "ISBD"):
                    batched[form.name] = Message(self.path, form), places
        finally:
            log.close()
        with files.reading(path) as file:
            file.seek(end)
            if file.read(len(HEAD)) in (HEAD[:1], HEAD):
                raise BadInput(
                    f"{path}: cut short: after its last message, another one begins (ArduPilot "
                    f"DataFlash). {files.without_end(path, end)}"
                )
        if len(batched) == 2:
            self.batches(*batched["ISBH"], *batched["ISBD"])

    def batches(self, head: "Message", heads: Ints, data: "Message", places: Ints) -> None:
        """One sensor for each gyro and accelerometer of the batch sampler. A message belongs to the
        header before it, if both have the same number of a batch."""
        of = head.columns(
            heads, ["N", "type", "instance", "mul", "smp_cnt", "SampleUS", "smp_rate"]
        )
        above = np.searchsorted(heads, places) - 1
        own = (above >= 0) & (of["N"][above] == data.columns(places, ["N"])["N"])
        above, places = above[own], places[own]
        for kind, one in sorted({*zip(of["type"][above].tolist(), of["instance"][above].tolist())}):
            if kind in BATCHES:
                name, quantity = BATCHES[kind]
                mine = (of["type"][above] == kind) & (of["instance"][above] == one)
                found = {field: column[above[mine]] for field, column in of.items()}
                batch = Batches(f"{name}:{one}", quantity, data, found)
                self.sensors.append(
                    Sensor(
                        batch.form.name,
                        frozenset([quantity]),
                        np.count_nonzero(mine) * PER_MESSAGE,
                        str(one),
                        rank=1,  # with pauses: chosen where there is no other
                        alone=True,
                    )
                )
                self.rows[batch.form.name] = batch, places[mine]

    def instances(
        self, kind: str, number: str, message: "Message | TextMessage", places: Ints
    ) -> None:
        """One sensor for each instance in the messages of a format."""
        if "I" not in message.form.columns:
            self.add(message.form.name, str(max(int(number or 1) - 1, 0)), message, places)
            return
        instance = message.columns(places, ["I"])["I"].astype(int)
        for one in np.unique(instance):
            self.add(f"{kind}:{one}", str(one), message, places[instance == one])

    def add(self, name: str, group: str, message: "Message | TextMessage", places: Ints) -> None:
        gives = [
            quantity
            for quantity, fields in FIELDS.items()
            if set(fields) <= set(message.form.columns)
        ]
        if "temp" in gives and not units.measured(message.columns(places[:ROWS], ["T"])["T"]):
            gives.remove("temp")
        self.sensors.append(Sensor(name, frozenset(gives), len(places), group))
        self.rows[name] = message, places

    def read(self, name: str) -> Samples:
        message, places = self.rows.pop(
            name
        )  # read once: 80 MB of places in a log of ten million messages
        sensor = next(sensor for sensor in self.sensors if sensor.name == name)
        clocks = [(field, unit) for field, unit in CLOCKS if field in message.form.columns]
        if not clocks:
            raise BadInput(f"{self.path}: {name} has no time")
        field, unit = clocks[0]
        wanted = [
            field for quantity in FIELDS if quantity in sensor.gives for field in FIELDS[quantity]
        ]
        found = message.columns(places, [field] + wanted)
        del places
        stamps = units.nanoseconds(found.pop(field), unit, f"{self.path}: {name}: {field}")
        columns = {}
        for quantity in FIELDS:
            if quantity in sensor.gives:
                columns.update(
                    units.axes(
                        quantity, [found.pop(one) for one in FIELDS[quantity]], "rad/s", "m/s^2"
                    )
                )
        return Samples(
            columns,
            stamps,
            notes={
                "source": f"ArduPilot DataFlash, {name}, {field}",
                "time_s": "seconds since boot",
                **self.notes,
            },
        )


class Message:
    """Where the numbers of one format stand in the bytes of its messages."""

    def __init__(self, path: StrPath, form: Any) -> None:
        self.path, self.form = path, form
        codes = [DFReader.FORMAT_TO_STRUCT[one] for one in form.format]
        self.kind = np.dtype(
            [("", "u1")] * 3
            + [(name, numpy_type(code)) for name, (code, _, _) in zip(form.columns, codes)]
        )
        self.factors = {name: factor or 1 for name, (_, factor, _) in zip(form.columns, codes)}

    def columns(self, places: Ints, names: Sequence[str]) -> dict[str, Numbers]:
        """name -> numbers of the messages that begin at these places."""
        out = {name: np.empty(len(places), self.kind[name]) for name in names}
        for first in range(0, len(places), ROWS):
            part = places[first : first + ROWS]
            data = np.fromfile(
                self.path, np.uint8, part[-1] - part[0] + self.kind.itemsize, offset=part[0]
            )
            rows = data[(part - part[0])[:, None] + np.arange(self.kind.itemsize)].view(self.kind)[
                :, 0
            ]
            for name in names:
                out[name][first : first + ROWS] = rows[name]
        return {
            name: column if self.factors[name] == 1 else column * self.factors[name]
            for name, column in out.items()
        }


class Batches:
    """Samples of one sensor of the batch sampler. head: the fields of ISBH for each message of
    data, which are ISBD."""

    def __init__(self, name: str, quantity: str, data: Message, head: dict[str, Numbers]) -> None:
        self.data, self.head, self.axes = data, head, FIELDS[quantity]
        self.form = SimpleNamespace(name=name, columns=[BATCH_CLOCK, *self.axes])

    def columns(self, places: Ints, names: Sequence[str]) -> dict[str, Numbers]:
        rate = self.head["smp_rate"].astype(np.float64)
        if not np.all((rate > 0) & (self.head["mul"] > 0)):
            raise BadInput(f"{self.data.path}: {self.form.name}: smp_rate or mul of ISBH is 0")
        found = self.data.columns(places, ["seqno", "x", "y", "z"])
        if np.any(found["seqno"].astype(np.int64) * PER_MESSAGE >= self.head["smp_cnt"]):
            raise BadInput(
                f"{self.data.path}: {self.form.name}: messages of fewer than {PER_MESSAGE} "
                f"samples. Record with INS_LOG_BAT_LGCT = {PER_MESSAGE}"
            )
        place = found["seqno"][:, None].astype(np.int64) * PER_MESSAGE + np.arange(PER_MESSAGE)
        start = self.head["SampleUS"].astype(np.int64)[:, None] * 1000
        out = {
            BATCH_CLOCK: (start + np.round(place * 1e9 / rate[:, None]).astype(np.int64)).ravel()
        }
        for axis, name in zip("xyz", self.axes):
            counts = found[axis].view("<i2").reshape(place.shape)
            out[name] = (counts / self.head["mul"][:, None].astype(np.float64)).ravel()
        return {name: out[name] for name in names}


class TextMessage:
    """The numbers of one format of a log in text, as pymavlink read them: places are rows."""

    def __init__(self, form: Any) -> None:
        self.form, self.rows = form, {name: array("d") for name in form.columns}

    def append(self, message: Any) -> None:
        for name, column in self.rows.items():
            value = getattr(message, name)
            column.append(value if isinstance(value, (int, float)) else np.nan)

    def columns(self, places: Ints, names: Sequence[str]) -> dict[str, Numbers]:
        return {name: np.frombuffer(self.rows[name])[places] for name in names}


Source = Message | TextMessage | Batches


class TextLog(Log):
    def __init__(self, path: StrPath, options: Options) -> None:
        self.path, self.sensors, self.rows, self.notes = path, [], {}, {}
        found: dict[str, TextMessage] = {}
        with silenced():
            log = DFReader.DFReader_text(str(path))
            kinds = [form.name for form in log.formats.values() if KINDS.match(form.name)]
            while message := log.recv_match(type=kinds):
                found.setdefault(message.get_type(), TextMessage(message.fmt)).append(message)
            log.close()
        for name, message in found.items():
            match = KINDS.match(name)
            if match:
                count = len(message.rows[message.form.columns[0]])
                self.instances(match[1], match[2], message, np.arange(count))


def numpy_type(code: str) -> str:
    return f"S{code[:-1]}" if code.endswith("s") else "<f2" if code == "e" else "<" + code
