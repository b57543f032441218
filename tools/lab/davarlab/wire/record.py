"""Results to CSV as they come, with the columns of davar-sim: memory does not grow, and a cut leaves whole rows."""

import csv
import math

from ..errors import BadInput

FIELDS = ["channel", "epoch", "time_s", "window_samples", "kurtosis", "contribution", "unstable", "arw_deg_per_sqrt_h",
          "arw_low_deg_per_sqrt_h", "arw_high_deg_per_sqrt_h", "arw_relative_uncertainty", "bi_deg_per_h",
          "rrw_deg_per_h_per_sqrt_h", "rr_deg_per_h2", "qn_deg"]
WAITING_MAX = 64  # results: DAVAR_Setup names every cluster size within 34


def row(result, channel):
    """A result (wire.Result) as a flat dictionary; absent values are None."""
    values = {"channel": result.channel, "epoch": result.epoch}
    if "rate_hz" in channel.setup:
        values["time_s"] = result.epoch / channel.setup["rate_hz"]
    values.update({name: value for name, value in result.values.items() if name in FIELDS})
    for index, value in sorted(result.adev.items()):
        values[f"adev_{channel.clusters.get(index, f'tau{index}')}"] = value
    values.update({name: value for name, value in result.values.items() if name == "model_health"})
    for index, value in sorted(result.deviation.items()):
        values[f"model_deviation_{channel.clusters.get(index, f'tau{index}')}"] = value
    return {name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in values.items()}


def cluster_order(name):
    """Sorts adev_16 behind adev_2, and names that are no numbers last."""
    size = name.rpartition("_")[2]
    return not size.isdigit(), int(size) if size.isdigit() else 0, size


class Recorder:
    """A CSV file. The first rows wait until DAVAR_Setup has named the columns; the file is empty until then."""

    def __init__(self, path):
        self.waiting, self.writer, self.left_out = [], None, 0  # left_out: values without a column
        try:
            self.file = open(path, "w", newline="", encoding="utf-8")
        except OSError as why:
            raise BadInput(f"--record: {path}: {why.strerror}") from None

    def add(self, result, channel):
        if self.writer:
            self._write(row(result, channel))
            return
        self.waiting.append((result, channel))
        named = all("rate_hz" in of.setup and set(one.adev) <= set(of.clusters) for one, of in self.waiting)
        if named or len(self.waiting) == WAITING_MAX:
            self._begin()

    def close(self):
        if self.waiting:
            self._begin()
        self.file.close()

    def _begin(self):
        rows = [row(result, channel) for result, channel in self.waiting]
        self.waiting = []
        adevs = {name for one in rows for name in one if name.startswith("adev_")}
        columns = FIELDS + sorted(adevs, key=cluster_order) + self._monitor(rows)
        self.writer = csv.DictWriter(self.file, columns, restval="", lineterminator="\n", extrasaction="ignore")
        self.writer.writeheader()
        for values in rows:
            self._write(values)

    @staticmethod
    def _monitor(rows):
        """The columns of the on-device monitor, when there is one."""
        names = {name for one in rows for name in one if name.startswith("model_")}
        return sorted(names & {"model_health"}) + sorted(names - {"model_health"}, key=cluster_order)

    def _write(self, values):
        self.left_out += len(values.keys() - set(self.writer.fieldnames))
        self.writer.writerow({name: f"{value:.9g}" if isinstance(value, float) else value for name, value in values.items()
                              if value is not None})
        self.file.flush()
