"""Live view of a CAN or serial source: prints the stream, records it to CSV.

    python -m davarlab.live can:vcan0 [--record FILE.csv] [--count N] [--idle SECONDS] [--base HEX] [--json]
"""

import argparse
import contextlib
import csv
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path

import can

if __package__:
    from . import wire
else:  # run as a file
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    import wire

FIELDS = ["channel", "epoch", "time_s", "window_samples", "kurtosis", "contribution", "unstable", "arw_deg_per_sqrt_h",
          "arw_low_deg_per_sqrt_h", "arw_high_deg_per_sqrt_h", "arw_relative_uncertainty", "bi_deg_per_h",
          "rrw_deg_per_h_per_sqrt_h", "rr_deg_per_h2", "qn_deg"]


class SourceError(Exception):
    """The source cannot be opened; the text names it."""


def open_source(source):
    """A python-can bus for can:IFACE or slcan:PATH."""
    kind, _, name = source.partition(":")
    if kind not in ("can", "slcan") or not name:
        raise SourceError(f"can:IFACE or slcan:PATH expected, found '{source}'")
    try:
        if kind == "can":
            return can.Bus(interface="socketcan", channel=name, fd=True)
        return can.Bus(interface="slcan", channel=name, sleep_after_open=0, rtscts=False)
    except (OSError, can.CanError, ValueError) as why:
        raise SourceError(f"{source}: {why}") from why


@contextlib.contextmanager
def opened(source):
    """open_source for a with block; a peer that is gone does not spoil the end."""
    bus = open_source(source)
    try:
        yield bus
    finally:
        with contextlib.suppress(OSError, can.CanError):
            bus.shutdown()


def frames(bus, receiver, idle_s):
    """Yields (identifier, data) until nothing has come for idle_s seconds (None: for ever) or the source is gone."""
    while True:
        try:
            message = bus.recv(idle_s)
        except ValueError:  # python-can's slcan met a line that is no frame
            receiver.faults.noise += 1
            continue
        except (OSError, can.CanError):
            return
        if message is None:
            return
        if not (message.is_error_frame or message.is_remote_frame or message.is_extended_id):
            yield message.arbitration_id, bytes(message.data)


def results(bus, receiver, idle_s=None):
    """Yields results as they become complete."""
    for identifier, data in frames(bus, receiver, idle_s):
        result = receiver.push(identifier, data)
        if result:
            yield result
    yield from receiver.finish()


def row(result, channel):
    """A result as a flat dictionary; absent values are None."""
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


class Recorder:
    """CSV with the columns of davar-sim; rows wait until the cluster sizes are known, so that columns have names."""

    def __init__(self, path):
        self.path, self.waiting = path, []

    def add(self, result, channel):
        self.waiting.append((result, channel))

    def close(self):
        rows = [row(result, channel) for result, channel in self.waiting]
        adevs = sorted({name for one in rows for name in one if name.startswith("adev_")},
                       key=lambda name: (not name[5:].isdigit(), int(name[5:]) if name[5:].isdigit() else 0, name))
        with open(self.path, "w", newline="", encoding="utf-8") as file:
            monitor = list(dict.fromkeys(name for one in rows for name in one if name.startswith("model_")))
            writer = csv.DictWriter(file, FIELDS + adevs + monitor, restval="", lineterminator="\n")
            writer.writeheader()
            writer.writerows({k: f"{v:.9g}" if isinstance(v, float) else v for k, v in one.items() if v is not None}
                             for one in rows)


def line(values):
    """One result for people."""
    arw, doubt = values.get("arw_deg_per_sqrt_h"), values.get("arw_relative_uncertainty")
    shown = "      absent" if arw is None else f"{arw:12.6g}" + ("" if doubt is None else f" +-{100 * doubt:.0f} %")
    window = f"window {values.get('window_samples', '?')}"
    return f"channel {values['channel']}  epoch {values['epoch']:>9}  ARW {shown} deg/sqrt(h)  {window}" + \
        ("" if values.get("model_health") is None else f"  model health {values['model_health']:.2f}") + \
        ("  UNSTABLE" if values.get("unstable") else "")


def run(source, record=None, count=None, idle_s=None, base=wire.BASE, as_json=False, out=sys.stdout):
    """Prints results of `source` to `out`; returns the receiver with its counts of faults and health."""
    receiver = wire.Receiver(base)
    recorder = Recorder(record) if record else None
    try:
        with opened(source) as bus:
            for n, result in enumerate(results(bus, receiver, idle_s), 1):
                channel = receiver.channels[result.channel]
                values = row(result, channel)
                print(json.dumps(values) if as_json else line(values), file=out, flush=True)
                if recorder:
                    recorder.add(result, channel)
                if n == count:
                    break
    finally:  # however it ends, by hand or by a fault
        if recorder:
            recorder.close()
    return receiver


def summary(receiver):
    """Two lines: what the receiver met, what the device says it met."""
    faults = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in asdict(receiver.faults).items())
    lines = [f"received: {faults}"]
    for index, channel in sorted(receiver.channels.items()):
        told = ", ".join(f"{name} {count}" for name, count in channel.health.items() if count)
        lines.append(f"channel {index} reports: {told or 'nothing lost'}")
    return "\n".join(lines)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="davarlab live", description="Prints the stream of a CAN or serial source.")
    parser.add_argument("source", help="can:IFACE or slcan:PATH")
    parser.add_argument("--record", metavar="FILE.csv", help="also write the results there, at the end")
    parser.add_argument("--count", type=int, help="stop after so many results")
    parser.add_argument("--idle", type=float, metavar="S", help="stop when nothing has come for so long")
    parser.add_argument("--base", type=lambda text: int(text, 16), default=wire.BASE, help="identifier (hex)")
    parser.add_argument("--json", action="store_true", help="one JSON object per result")
    options = parser.parse_args(arguments)
    try:
        receiver = run(options.source, options.record, options.count, options.idle, options.base, options.json)
    except SourceError as why:
        print(f"davarlab live: {why}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0
    print(summary(receiver), file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
