"""Results to CSV as they come, with the columns of davar-sim: memory does not grow, and a cut
leaves whole rows.

What is in the file already stays: a later run goes on behind it, as later stretches. (channel,
stretch, epoch) comes once."""

import itertools
import math
import os
import stat
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import BadInput
from .frames import Channel, Result
from .source import Say

FIELDS = [
    "channel",
    "stretch",
    "epoch",
    "time_s",
    "window_samples",
    "kurtosis",
    "contribution",
    "unstable",
    "arw_deg_per_sqrt_h",
    "arw_low_deg_per_sqrt_h",
    "arw_high_deg_per_sqrt_h",
    "arw_relative_uncertainty",
    "arw_withheld",
    "bi_deg_per_h",
    "rrw_deg_per_h_per_sqrt_h",
    "rr_deg_per_h2",
    "qn_deg",
]
TRACKED = [
    "alarm",
    "cut_age_samples",
    "dispersion",
    "change_m",
    "change_older",
    "change_newer",
    "change_gain",
    "young",
]  # law glr
FLOOR = [
    "floor_deg_per_sqrt_h",
    "floor_low_deg_per_sqrt_h",
    "floor_high_deg_per_sqrt_h",
    "floor_why",
]  # of a sender with --floor
WAITING_MAX = 64  # results: DAVAR_Setup names every cluster size within 35
ROW_BYTES_MAX = 1 << 16

Row = dict[str, Any]  # the values of a result by the names of their columns, as JSON has them


def row(result: Result, channel: Channel) -> Row:
    """A result (wire.Result) as a flat dictionary; absent values are None."""
    values: Row = {"channel": result.channel, "stretch": result.stretch, "epoch": result.epoch}
    if "rate_hz" in channel.setup:
        values["time_s"] = result.epoch / channel.setup["rate_hz"]
    values.update(
        {
            name: value
            for name, value in result.values.items()
            if name in FIELDS or name in TRACKED or name in FLOOR
        }
    )
    for index, value in sorted(result.adev.items()):
        values[f"adev_{channel.clusters.get(index, f'tau{index}')}"] = value
    values.update({name: value for name, value in result.values.items() if name == "model_health"})
    for index, value in sorted(result.deviation.items()):
        values[f"model_deviation_{channel.clusters.get(index, f'tau{index}')}"] = value
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in values.items()
    }


def is_named(result: Result, channel: Channel) -> bool:
    """Has DAVAR_Setup said of all values what they are."""
    return "rate_hz" in channel.setup and set(result.adev) | set(result.deviation) <= set(
        channel.clusters
    )


def cluster_order(name: str) -> tuple[bool, int, str]:
    """Sorts adev_16 behind adev_2, and names that are no numbers last."""
    size = name.rpartition("_")[2]
    return not size.isdigit(), int(size) if size.isdigit() else 0, size


class Output:
    """A file to which whole lines are appended, unbuffered: those of an earlier run stay."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.file = open(  # noqa: SIM115 (open as long as the object is)
            os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666),
            "rb+",
            buffering=0,
        )
        self.regular = stat.S_ISREG(os.fstat(self.file.fileno()).st_mode)

    def size(self) -> int:
        return os.fstat(self.file.fileno()).st_size if self.regular else 0

    def drop_cut_row(self) -> None:
        """A power cut leaves part of a row; it was never whole."""
        start = max(0, self.size() - ROW_BYTES_MAX)
        end = os.pread(self.file.fileno(), ROW_BYTES_MAX, start).rfind(b"\n") + 1
        if end:
            self.file.truncate(start + end)

    def earlier(self) -> tuple[list[str] | None, int]:
        """(columns, last stretch) of what is there: (None, 0) of nothing, ([], 0) of a file that is
        none of ours."""
        if not self.size():
            return None, 0
        with open(self.path, encoding="utf-8", errors="replace") as file:
            header = file.readline(ROW_BYTES_MAX)
            columns = header.strip().split(",")
            if not header.endswith("\n") or not set(FIELDS) <= set(columns):
                return [], 0
            self.drop_cut_row()
            at = columns.index("stretch")
            stretches = (line.split(",", at + 1)[at : at + 1] for line in file)
            return columns, max(
                (int(one) for found in stretches for one in found if one.isdecimal()), default=0
            )

    def append(self, line: bytes) -> None:
        """The whole line, or nothing of it and OSError."""
        size, left = self.size(), memoryview(line)
        try:
            while left:
                left = left[self.file.write(left) :]
        except OSError:
            if self.regular and self.size() > size:
                self.file.truncate(size)
            raise


class Recorder:
    """A CSV file. The first rows of a stretch wait until DAVAR_Setup has named their columns.

    A file that is there and has these columns is continued; beside one that has not, NAME-2.csv is
    (and so on). A disk that is full costs rows, not the recording: they are counted, and the next
    row is tried again."""

    def __init__(self, path: str | Path, say: Say = lambda text: None) -> None:
        self.path, self.given, self.say = Path(path), Path(path), say
        self.waiting: list[tuple[Result, Channel]] = []
        self.columns: list[str] | None = None
        self.before = 0  # stretches of earlier runs in the file
        self.patient: dict[tuple[int, int], bool] = {}  # (channel, stretch) -> may its rows wait?
        self.left_out, self.unrecorded, self.failing = (
            0,
            0,
            False,
        )  # left_out: values without a column
        try:
            self.output = Output(path)
        except (OSError, ValueError) as why:
            raise BadInput(f"--record: {path}: {getattr(why, 'strerror', why)}") from None

    def add(self, result: Result, channel: Channel) -> None:
        self.waiting.append((result, channel))
        if len(self.waiting) == WAITING_MAX:
            self.patient.update({(one.channel, one.stretch): False for one, _ in self.waiting})
        if self.columns or all(map(self._is_named, self.waiting)):
            self._write_named()

    def close(self) -> None:
        self.patient.update({(one.channel, one.stretch): False for one, _ in self.waiting})
        self._write_named()
        self.output.file.close()

    def _is_named(self, waiting: tuple[Result, Channel]) -> bool:
        result, channel = waiting
        return is_named(result, channel) or not self.patient.setdefault(
            (result.channel, result.stretch), True
        )

    def _write_named(self) -> None:
        """Writes the rows whose columns have names, and begins the file when there is none yet."""
        ready = [one for one in self.waiting if self._is_named(one)]
        self.waiting = [one for one in self.waiting if not self._is_named(one)]
        self._forget()
        rows, done = [row(*one) for one in ready], 0
        try:
            for values in rows:
                if not self.columns:
                    self._begin(rows)
                self._write(values)
                if self.failing:
                    self.say(f"--record: {self.path}: recording resumed")
                self.failing = False
                done += 1
        except OSError as why:
            self.unrecorded += len(rows) - done
            if not self.failing:
                self.say(
                    f"--record: {self.path}: {why.strerror}: results are shown, but not recorded"
                )
            self.failing = True

    def _forget(self) -> None:
        """The patience of stretches that are over."""
        newest = dict(sorted(self.patient))  # channel -> stretch
        still = {*newest.items(), *((one.channel, one.stretch) for one, _ in self.waiting)}
        self.patient = {key: may for key, may in self.patient.items() if key in still}

    def _begin(self, rows: Sequence[Row]) -> None:
        """The file whose columns hold these rows, with its header."""
        adevs = {name for one in rows for name in one if name.startswith("adev_")}
        tracked = TRACKED if any("alarm" in one for one in rows) else []
        floor = FLOOR if any("floor_why" in one for one in rows) else []
        columns = FIELDS + tracked + floor + sorted(adevs, key=cluster_order) + self._monitor(rows)
        for number in itertools.count(2):
            found, self.before = self.output.earlier()
            if found is None:
                self.output.append((",".join(columns) + "\n").encode())
            if found is None or set(columns) <= set(found):
                self.columns = found or columns
                return
            other = self.given.with_name(f"{self.given.stem}-{number}{self.given.suffix}")
            self.say(f"--record: {self.path}: exists with other columns. Recording to {other}")
            self.output.file.close()
            self.path, self.output = other, Output(other)

    @staticmethod
    def _monitor(rows: Sequence[Row]) -> list[str]:
        """The columns of the on-device monitor, when there is one."""
        names = {name for one in rows for name in one if name.startswith("model_")}
        return sorted(names & {"model_health"}) + sorted(
            names - {"model_health"}, key=cluster_order
        )

    def _write(self, values: Row) -> None:
        known: Row = {
            name: f"{value:.9g}" if isinstance(value, float) else value
            for name, value in values.items()
            if value is not None
        }
        known["stretch"] += self.before
        columns = self.columns or []
        self.output.append((",".join(str(known.get(name, "")) for name in columns) + "\n").encode())
        self.left_out += len(values.keys() - set(columns))
