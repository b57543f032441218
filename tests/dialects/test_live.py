"""davarlab live in the dialects: the values that davar sent, and what happens when messages are
lost, repeated or cut, and when the sender starts again. tests/kernel/test_dialects.py has the bus.
"""

import contextlib
import csv
import itertools
import json
import math
import os
import pty
import signal
import socket
import subprocess
import sys
import tempfile
import time
import tty
import unittest
from pathlib import Path

import numpy as np
from davarlab.errors import BadInput
from davarlab.wire import dialects, record
from pymavlink.dialects.v20 import common
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
HANG_S = 600  # however busy the machine is


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

    def test_a_piece_gives_all_its_results(self):
        stream = b"".join(data for _, data in packets("mavlink", consecutive(7), channel=4))
        receiver = dialects.DialectReceiver("mavlink")
        found = dialects.results(receiver, 0, stream)
        self.assertEqual((COUNT, 0), (len(found), len(receiver.ready)))

    def test_a_message_of_another_type_is_no_result(self):
        zeros = bytes(63)
        others = [
            ("dronecan", 0x1801552A, b"\x01\x02\x03\x04\x00\x00\x00\xc0"),  # NodeStatus
            ("dronecan", 0x183FF22A, b"\x00\x00\x80\x3fAR\x00\xc0"),  # a key without an axis
            ("dronecan", 0x0, b""),
            ("cyphal", 0x147D552A, b"\x01\x02\x03\x04\x00\x00\x00\xe0"),  # Heartbeat
            ("cyphal", 0x146E742A, b"\x01\x02\x03\x04\x00\x00\x00\xe0"),  # too short
            ("cyphal", 0x146E732A, zeros + b"\xe0"),  # another subject
            ("cyphal", 0x0, b""),
        ]
        for dialect, identifier, data in others:
            with self.subTest(dialect=dialect, identifier=hex(identifier), data=data.hex()):
                found = received(dialects.DialectReceiver(dialect), [(identifier, data)])
                self.assertEqual([], found)

    def test_cyphal_takes_the_subject_of_the_source(self):
        frames = packets("cyphal", consecutive(8), channel=4, subject=5000)
        self.assertEqual(COUNT, len(received(dialects.receiver("cyphal:can0@5000"), frames)))
        self.assertEqual([], received(dialects.receiver("cyphal:can0"), frames))
        for wrong in ("8192", "-1", "x", ""):
            with self.assertRaisesRegex(BadInput, "subject 0 to 8191 expected"):
                dialects.receiver(f"cyphal:can0@{wrong}")

    def test_a_second_sender_of_a_channel_is_foreign(self):
        for dialect in ("mavlink", "dronecan", "cyphal"):
            made, receiver = consecutive(9), dialects.DialectReceiver(dialect)
            mine = packets(dialect, made, channel=4)
            others = packets(dialect, consecutive(10), channel=4, node=43)
            each = len(mine) // COUNT
            rows = [range(each * row, each * row + each) for row in range(COUNT)]
            frames = [side[at] for row in rows for side in (mine, others) for at in row]
            self.check(made, received(receiver, frames), has_all=dialect != "dronecan")
            self.assertEqual((COUNT, 0), (receiver.faults.foreign, receiver.faults.total()))

    def test_no_message_breaks_the_receiver(self):
        """Intact messages with any content, as somebody else may send them."""
        source, sender = np.random.default_rng(11), common.MAVLink(None)
        for dialect in ("mavlink", "dronecan", "cyphal"):
            receiver, shown = dialects.DialectReceiver(dialect), 0
            for number in range(2000):
                data = source.integers(0, 256, 63, dtype="u1").tobytes()
                if number % 3 == 0:
                    data = bytes(63)
                if dialect == "mavlink":
                    floats = np.frombuffer(data[:60] * 4, "f4")[:58].tolist()
                    if number % 2:
                        floats[13:16] = [float(one) for one in data[:3]]
                    message = common.MAVLink_debug_float_array_message(
                        0, b"davar", data[0] % 12, floats
                    )
                    frame = 0, message.pack(sender)
                elif dialect == "dronecan":
                    key = dialects.KEYS[number % 6].encode() + b"X"
                    key = data[4:7] if 0 < data[7] < 25 else key
                    frame = 0x183FF22A, data[:4] + key + b"\xc0"
                else:
                    last = bytes([data[60] % 12, data[61], data[62], 0xE0 + number % 32])
                    frame = 0x146E742A, data[:60] + last
                result = receiver.push(*frame)
                if result:
                    json.dumps(record.row(result, result.sender), allow_nan=False)
                    self.assertLess(result.channel, 10)
                    shown += 1
            self.assertGreater(shown, 100, (dialect, receiver.faults))


def rows_of(path):
    """The results that are recorded so far."""
    if not path.exists():
        return []
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Live(unittest.TestCase):
    def setUp(self):
        self.hung = time.monotonic() + HANG_S

    def still(self, live):
        """It runs, and not for too long."""
        self.assertIsNone(live.poll())
        self.assertLess(time.monotonic(), self.hung)

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

                # until it listens; repetitions are dropped
                for _, data in itertools.cycle(frames[:3]):
                    with contextlib.suppress(ConnectionRefusedError):
                        send(data)
                    if rows_of(path):
                        break
                    self.still(live)
                    signal.sigtimedwait([], 0.02)
                for _, data in frames[3:]:
                    send(data)
                    signal.sigtimedwait([], 0.002)
                while len(rows_of(path)) < COUNT:
                    self.still(live)
                    signal.sigtimedwait([], 0.02)
                live.send_signal(signal.SIGINT)
                shown, told = live.communicate(timeout=HANG_S)
                self.assertEqual(0, live.returncode, told)
                rows = rows_of(path)
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
