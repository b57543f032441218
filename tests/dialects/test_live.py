"""davarlab live in the dialects: the values that davar sent, and what happens when messages are
lost, repeated or cut, and when the sender starts again. tests/kernel/test_dialects.py has the bus.
"""

import contextlib
import csv
import json
import math
import os
import pty
import signal
import socket
import subprocess
import sys
import tempfile
import tty
import unittest
from pathlib import Path

import numpy as np
from davarlab.wire import dialects
from random_results import ARW, BI, QN, RR, RRW, packets, results, sent

ROOT = Path(__file__).resolve().parents[2]
NODE = os.environ.get("DAVAR_NODE", "davar-node")
LIVE = (
    "import sys, json, argparse\nfrom davarlab.wire import live\n"
    "sys.exit(live.run(argparse.Namespace(**json.loads(sys.argv[1]))))"
)
COLUMNS = {
    "arw_deg_per_sqrt_h": (ARW, 0),
    "arw_low_deg_per_sqrt_h": (ARW, 1),
    "arw_high_deg_per_sqrt_h": (ARW, 2),
    "bi_deg_per_h": (BI, 0),
    "rrw_deg_per_h_per_sqrt_h": (RRW, 0),
    "rr_deg_per_h2": (RR, 0),
    "qn_deg": (QN, 0),
}
REASONS = (None, None, "mixed", "constant", "coarse", "filtered")
COUNT = 200


def consecutive(seed, first=0, count=COUNT):
    """Random results every 100 samples."""
    made = results(seed, count)
    made["epoch"] = first + 99 + 100 * np.arange(count)
    return made


def received(receiver, frames):
    found = [receiver.push(*frame) for frame in frames]
    return [one for one in found if one] + receiver.finish()


class Receiver(unittest.TestCase):
    def check(self, made, found, has_all=True, channel=4):
        self.assertEqual(len(made), len(found))
        self.assertEqual({channel}, {one.channel for one in found})
        for name, (kind, column) in list(COLUMNS.items())[: None if has_all else 4]:
            wanted = sent(made["coefficient"][:, kind, column], column == 2)
            np.testing.assert_array_equal(wanted, [one.values[name] for one in found], name)
        if not has_all:
            return
        self.assertEqual(list(made["epoch"]), [one.epoch for one in found])
        for name in ("unstable", "young", "alarm"):
            values = [one.values.get(name, 0) for one in found]
            self.assertEqual(list(made[name]), values, name)
        for one, noise in zip(found, made["noise"]):
            reason = REASONS[noise] if math.isnan(one.values["arw_deg_per_sqrt_h"]) else None
            self.assertEqual(reason, one.values.get("arw_withheld"))
        self.assertTrue(all(abs(one.sender.setup["rate_hz"] - 99.3) < 1e-5 for one in found))

    def test_every_dialect_gives_the_values_that_were_sent(self):
        for dialect in ("mavlink", "dronecan", "cyphal"):
            with self.subTest(dialect=dialect):
                made, receiver = consecutive(1), dialects.DialectReceiver(dialect)
                found = received(receiver, packets(dialect, made, channel=4))
                self.check(made, found, has_all=dialect != "dronecan")
                self.assertEqual(0, receiver.faults.total(), receiver.faults)

    def test_lost_packets_are_counted_and_no_result_is_mixed(self):
        for dialect, each in (("mavlink", 3), ("dronecan", 6), ("cyphal", 1)):
            with self.subTest(dialect=dialect):
                made, receiver = consecutive(2), dialects.DialectReceiver(dialect)
                frames = packets(dialect, made, channel=4)
                lost = {each * row + row % each for row in range(1, COUNT - 1, 7)}
                kept = [frame for at, frame in enumerate(frames) if at not in lost]
                found = received(receiver, kept)
                harmed = {at // each for at in lost if dialect != "mavlink" or at % each == 2}
                rest = [row for row in range(COUNT) if row not in harmed]
                self.check(made[rest], found, has_all=dialect != "dronecan")
                self.assertEqual(len(lost), receiver.faults.missing)

    def test_a_sender_that_starts_again_begins_a_new_section(self):
        for dialect in ("mavlink", "cyphal"):
            with self.subTest(dialect=dialect):
                receiver = dialects.DialectReceiver(dialect)
                first = received(receiver, packets(dialect, consecutive(3), channel=4))
                second = received(receiver, packets(dialect, consecutive(4), channel=4))
                self.assertEqual({1}, {one.stretch for one in first})
                self.assertEqual({2}, {one.stretch for one in second})
                self.check(consecutive(4), second)
                self.assertEqual(1, receiver.faults.restarts)

    def test_an_epoch_goes_on_beyond_what_a_message_holds(self):
        for dialect, modulus in (("mavlink", 2**24), ("cyphal", 2**32)):
            made = consecutive(5, first=modulus - 1000)
            found = received(dialects.DialectReceiver(dialect), packets(dialect, made, channel=4))
            self.assertEqual(list(made["epoch"]), [one.epoch for one in found])

    def test_a_repeated_message_is_one_result(self):
        receiver = dialects.DialectReceiver("cyphal")
        frames = packets("cyphal", consecutive(6), channel=4)
        found = received(receiver, [frame for frame in frames for _ in range(2)])
        self.assertEqual(COUNT, len(found))

    def test_a_mavlink_stream_may_be_cut_and_damaged_anywhere(self):
        made, source = consecutive(7), np.random.default_rng(7)
        stream = b"".join(data for _, data in packets("mavlink", made, channel=4))
        for damaged in (False, True):
            receiver = dialects.DialectReceiver("mavlink")
            bytes_ = bytearray(stream)
            for at in source.integers(0, len(bytes_), 40 if damaged else 0):
                bytes_[at] ^= 1 << int(source.integers(8))
            cuts = sorted({0, len(bytes_), *map(int, source.integers(0, len(bytes_), 300))})
            pieces = [(0, bytes(bytes_[a:b])) for a, b in zip(cuts, cuts[1:])]
            found = received(receiver, pieces)
            kept = {one.epoch for one in found}
            self.check(made[[int(row["epoch"]) in kept for row in made]], found)
            self.assertEqual(damaged, receiver.faults.total() > 0)
            self.assertGreater(len(found), 120)

    def test_messages_of_others_are_foreign_or_ignored(self):
        for dialect in ("dronecan", "cyphal"):
            receiver = dialects.DialectReceiver(dialect)
            self.assertIsNone(receiver.push(0x18015501, bytes(7) + b"\xc0"))
            self.assertIsNone(receiver.push(0x0, b""))
            self.assertEqual([], receiver.finish())


class Live(unittest.TestCase):
    def live(self, source, *, record):
        wanted = {"source": source, "base": 0x5D0, "record": record, "raw": None, "count": None}
        command = [
            sys.executable,
            "-B",
            "-c",
            LIVE,
            json.dumps({**wanted, "idle": None, "json": False}),
        ]
        live = subprocess.Popen(
            command,
            cwd=ROOT / "tools/lab",
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.addCleanup(live.communicate)
        self.addCleanup(live.kill)
        return live

    def test_mavlink_by_udp_and_on_a_serial_line(self):
        made = consecutive(8)
        frames = packets("mavlink", made, channel=1)
        for kind in ("udp", "serial"):
            with self.subTest(kind=kind), tempfile.TemporaryDirectory() as folder:
                path = Path(folder, "arw.csv")
                if kind == "udp":
                    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
                        free.bind(("127.0.0.1", 0))
                        address = free.getsockname()
                    live = self.live(f"mavlink:udp:127.0.0.1:{address[1]}", record=str(path))
                    client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                    self.addCleanup(client.close)
                    client.connect(address)
                    send = client.send
                else:
                    ours, theirs = pty.openpty()
                    tty.setraw(theirs)
                    self.addCleanup(os.close, ours)
                    live = self.live(f"mavlink:serial:{os.ttyname(theirs)}", record=str(path))
                    self.addCleanup(os.close, theirs)

                    def send(data, ours=ours):
                        os.write(ours, data)

                first = frames[:3] * 200  # until it listens; repetitions are dropped
                for _, data in first:
                    with contextlib.suppress(ConnectionRefusedError):
                        send(data)
                    if path.exists() and path.stat().st_size:
                        break
                    live.poll()
                    signal.sigtimedwait([], 0.02)
                for _, data in frames[3:]:
                    send(data)
                    signal.sigtimedwait([], 0.002)
                signal.sigtimedwait([], 1.0)
                live.send_signal(signal.SIGINT)
                shown, told = live.communicate(timeout=20)
                self.assertEqual(0, live.returncode, told)
                with open(path, encoding="utf-8") as file:
                    rows = list(csv.DictReader(file))
                self.assertEqual(COUNT, len(rows), told)
                self.assertEqual(COUNT, len(shown.splitlines()))
                wanted = sent(made["coefficient"][:, ARW, 0])
                for value, row in zip(wanted, rows):
                    text = row["arw_deg_per_sqrt_h"]
                    self.assertEqual("" if np.isnan(value) else f"{value:.9g}", text)
                self.assertEqual(
                    [str(one) for one in made["epoch"]], [row["epoch"] for row in rows]
                )


if __name__ == "__main__":
    unittest.main()
