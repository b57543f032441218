"""Raw samples of a sender to recordings that every command reads."""

import os
from pathlib import Path

from ..errors import BadInput
from .raw import written
from .record import Output


class RawRecorder:
    """One recording of each channel and run of its sender: time_s and gyro_x_dps (channel 1: y, 2:
    z, and so on round). The first has the given name, others NAME-2 and so on; none that is there
    is touched. A disk that is full costs samples, which are counted."""

    def __init__(self, path, say):
        self.given, self.say, self.unrecorded, self.failing = Path(path), say, 0, False
        self.outputs = {}  # channel's number -> (stretch, Output) of its newest recording
        if not os.path.isdir(self.given.parent):
            raise BadInput(f"--raw: {path}: No such file or directory")

    def add(self, number, channel, samples):
        """Samples (index, deg/s) of a Channel."""
        try:
            stretch, output = self.outputs.get(number, (None, None))
            if stretch != channel.stretch:
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

    def path(self, number):
        """Where the newest samples of a channel are; None: there are none."""
        return self.outputs[number][1].path if number in self.outputs else None

    def _begin(self, number, channel):
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

    def close(self):
        for _, output in self.outputs.values():
            output.file.close()
