"""What a log holds: its sensors, and the samples of the one that is read."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..arrays import Floats, Ints
from ..errors import BadInput
from ..files import StrPath
from ..tables import table
from ..tables.guess import Guess
from ..thresholds import RECORD

LISTED_MOST = 20
Numbers = npt.NDArray[Any]  # as a log holds them, of whichever type


@dataclass(frozen=True)
class Sensor:
    """name: as --sensor takes it. gives: what it measures, of gyro, accel, temp. samples: how many,
    None where only reading would tell. group: of what belongs together on a device. rank: only
    those of the lowest rank in a log are chosen without being named. alone: it is sampled while no
    other is, so it is not read beside one."""

    name: str
    gives: frozenset[str]
    samples: int | None = None
    group: str = ""
    rank: int = 0
    alone: bool = False

    @property
    def said(self) -> str:
        return f"{self.name} ({', '.join(sorted(self.gives))}" + (
            ")" if self.samples is None else f"; {self.samples} samples)"
        )


@dataclass
class Samples:
    """columns: name -> one number per sample, in deg/s, g and degC where the name says so.
    stamps_ns: int64, None where the log has none. beside: (stamps_ns, columns) of what was measured
    at times of its own. guesses: how names and units were found, of data.guess. line: of the file
    above the numbers, None where a log has no lines. origin_ns: of a column time_s. said: how the
    file was read, in words, where that was not plain. places: of the samples among the rows of a
    file, which decide where no time does; None: all in turn."""

    columns: dict[str, Floats]
    stamps_ns: Ints | None = None
    beside: list[tuple[Ints, dict[str, Floats]]] = field(default_factory=list)
    guesses: list[Guess] = field(default_factory=list)
    notes: dict[str, str] = field(default_factory=dict)
    rate_hz: float | None = None
    line: int | None = None
    origin_ns: int = 0
    said: list[str] = field(default_factory=list)
    places: Ints | None = None


class Log(Protocol):
    """What a reader makes of a file: its sensors, and the samples of one of them."""

    sensors: list[Sensor]

    def read(self, name: str, /) -> Samples: ...


def check_finite(values: Numbers, where: str) -> None:
    """Raises BadInput that names the first sample whose number is none, or one that no sensor
    says."""
    wrong = np.flatnonzero(~(np.abs(values) < table.LARGEST))
    if len(wrong):
        what = (
            f"{values[wrong[0]]:g} is not a sensor value"
            if np.isfinite(values[wrong[0]])
            else "not a finite number"
        )
        raise BadInput(f"{where}: {what} at sample {wrong[0] + 1}")


def listed(sensors: Sequence[Sensor]) -> str:
    names = [sensor.said for sensor in sensors[:LISTED_MOST]]
    return ", ".join(names) + (
        f" and {len(sensors) - LISTED_MOST} more" if len(sensors) > LISTED_MOST else ""
    )


def unnamed(sensors: Sequence[Sensor]) -> list[Sensor]:
    """The gyros that may be chosen without being named: those of the lowest rank, without those
    that are known to be too short while others are not."""
    gyros = [sensor for sensor in sensors if "gyro" in sensor.gives]
    long = [one for one in gyros if one.samples is None or one.samples >= RECORD.minimum_samples]
    gyros = long or gyros
    return [one for one in gyros if one.rank == min(gyro.rank for gyro in gyros)]


def chosen(sensors: Sequence[Sensor], name: str | None, path: StrPath) -> Sensor:
    """The sensor of this name, or the only one that may be chosen without being named. Raises
    BadInput that lists what there is."""
    if name is not None:
        found = next((sensor for sensor in sensors if sensor.name == name), None)
        if found is None:
            raise BadInput(
                f"--sensor {name}: {path} has no such sensor (there are: "
                f"{listed(sensors) or 'none'})"
            )
        return found
    first = unnamed(sensors)
    if not first:
        raise BadInput(
            f"{path}: it contains no gyro ("
            + (
                f"there are: {listed(sensors)}; select one with --sensor NAME)"
                if sensors
                else "no column is named like one. Name them: --names A,B,.., or import --rename "
                "OLD=gyro_x_dps. For a clock, use davar.adev in Python)"
            )
        )
    if len(first) > 1:
        gyros = [sensor for sensor in sensors if "gyro" in sensor.gives]
        raise BadInput(
            f"{path}: more than one gyro. Select one with --sensor NAME (there are: "
            f"{listed(gyros)})"
        )
    return first[0]


def companions(sensors: Sequence[Sensor], main: Sensor) -> list[tuple[Sensor, str]]:
    """(sensor, quantity) of what was measured beside a gyro that the gyro does not say: by the
    first sensor of its group, or by the only one."""
    found = []
    for quantity in ("accel", "temp"):
        if "gyro" in main.gives and quantity not in main.gives:
            others = [
                sensor
                for sensor in sensors
                if quantity in sensor.gives and sensor is not main and not sensor.alone
            ]
            others = sorted(
                others,
                key=lambda sensor: (
                    sensor.rank,
                    "gyro" not in sensor.gives if quantity == "temp" else "gyro" in sensor.gives,
                ),
            )
            own = [sensor for sensor in others if sensor.group == main.group]
            found += [
                (sensor, quantity) for sensor in own[:1] or (others if len(others) == 1 else [])
            ]
    return found
