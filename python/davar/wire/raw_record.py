"""Raw samples of a sender to recordings that every command reads."""

import os
from collections.abc import Sequence
from pathlib import Path

from ..errors import BadInput
from .frames import Channel
from .raw import Sample, written
from .record import Output
from .source import Say


class RawRecorder:
    """One recording of each channel and run of its sender: time_s and gyro_x_dps (channel 1: y, 2:
    z, and so on round). The first has the given name, others NAME-2 and so on; none that is there
    is touched. A disk that is full costs samples, which are counted."""

    def __init__(self, path: str | Path, say: Say) -> None:
        self.given, self.say, self.unrecorded, self.failing = Path(path), say, 0, False
        # Channel's number -> (stretch, Output) of its newest recording.
        self.outputs: dict[int, tuple[int, Output]] = {}
        if not os.path.isdir(str(self.given.parent)):
            raise BadInput(f"--raw: {path}: No such file or directory")

    def add(self, number: int, channel: Channel, samples: Sequence[Sample]) -> None:
        """Samples (index, deg/s) of a Channel."""
        try:
            found = self.outputs.get(number)
            if found and found[0] == channel.stretch:
                output = found[1]
            else:
                output = self._begin(number, channel)
            rate = written(channel.setup["rate_hz"])
            output.append(
                "".join(f"{index / rate:.12g},{value:.9g}\n" for index, value in samples).encode()
            )
            if self.failing:
                self.say(f"--raw: {output.path}: recording resumed")
            self.failing = False
        except OSError as why:
            self.unrecorded += len(samples)
            if not self.failing:
                self.say(f"--raw: {self.given}: {why.strerror}: samples are lost")
            self.failing = True

    def path(self, number: int) -> Path | None:
        """Where the newest samples of a channel are; None: there are none."""
        return self.outputs[number][1].path if number in self.outputs else None

    def _begin(self, number: int, channel: Channel) -> Output:
        path, count = self.given, 1
        while path.exists() and path.stat().st_size:
            count += 1
            path = self.given.with_name(f"{self.given.stem}-{count}{self.given.suffix}")
        output = Output(path)
        output.append(
            (
                f"# channel: {number}\n"
                f"# unit_per_count_dps: {written(channel.setup['unit_per_count'])!r}\n"
                f"time_s,gyro_{'xyz'[number % 3]}_dps\n"
            ).encode()
        )
        if number in self.outputs:
            self.outputs[number][1].file.close()
        self.outputs[number] = channel.stretch, output
        if path != self.given:
            self.say(f"channel {number}: raw samples go to {path}")
        return output

    def close(self) -> None:
        for _, output in self.outputs.values():
            output.file.close()
