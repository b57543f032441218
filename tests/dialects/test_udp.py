"""davar-node and davar-sim send MAVLink by UDP and on a serial line: pymavlink reads the values of
the CSV, and a peer that is not there is counted and survived.
"""

import contextlib
import csv
import io
import os
import re
import select
import socket
import subprocess
import time
import unittest

import serial
from pymavlink import mavutil
from pymavlink.dialects.v20 import common

NODE = os.environ.get("DAVAR_NODE", "davar-node")
SIM = os.environ.get("DAVAR_SIM", "davar-sim")
WINDOW = ("--window-max", "200", "--window-min", "100", "--segment", "30", "--stride", "50")
SETUP = ("--rate", "100", "--lsb", "0.05", *WINDOW)
TRAILING = ("--mode", "trailing", "--policy", "or", "--grow", "1")
COLUMNS = ("", "_low", "_high")
HANG_S = 600  # however busy the machine is


def counts(number):
    """Counts that look like noise, always the same, one per line."""
    value, lines = 12345, []
    for _ in range(number):
        value = (1103515245 * value + 12345) % 2**31
        lines.append(str((value >> 16) % 200 - 100))
    return "\n".join(lines) + "\n"


class Mavlink(unittest.TestCase):
    def setUp(self):
        self.parser, self.heartbeats = common.MAVLink(None), []
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.addCleanup(self.socket.close)
        self.where = f"mavlink:udp:127.0.0.1:{self.socket.getsockname()[1]}"

    def received(self):
        """Messages that are there, without heartbeats. Each datagram is one message."""
        found = []
        while select.select([self.socket], [], [], 0.2)[0]:
            messages = self.parser.parse_buffer(self.socket.recv(2048))
            self.assertEqual(1, len(messages))
            found += messages
        self.heartbeats += [one for one in found if one.get_type() == "HEARTBEAT"]
        return [one for one in found if one.get_type() != "HEARTBEAT"]

    def rows(self, text):
        """The rows of davar-sim for these counts."""
        done = subprocess.run(
            [SIM, "-", *SETUP, *TRAILING],
            input="gyro_z_counts\n" + text,
            text=True,
            stdout=subprocess.PIPE,
            check=True,
        )
        return list(csv.DictReader(io.StringIO(done.stdout)))

    def same(self, wanted, found):
        """A field of the CSV, and a float32."""
        self.assertEqual(wanted == "", found != found)
        if wanted:
            self.assertAlmostEqual(float(wanted), found, delta=1e-7 * abs(found))

    def test_the_values_are_those_of_the_csv(self):
        text = counts(1000)
        words = [NODE, "--source", "-", *SETUP, "--out", self.where, "--channel", "2"]
        done = subprocess.run(
            [*words, "--system-id", "9"], input=text, text=True, capture_output=True, check=True
        )
        self.assertRegex(done.stderr, r"\Adavar-node: 1000 samples, \d+ results[^\n]*\n\Z")
        found, rows = self.received(), self.rows(text)
        self.assertEqual(3 * len(rows), len(found))
        self.assertGreater(len(rows), 10)
        self.assertEqual(
            {(9, 193)}, {(one.get_srcSystem(), one.get_srcComponent()) for one in found}
        )
        for row, arw, bi, array in zip(rows, found[0::3], found[1::3], found[2::3]):
            self.assertEqual(("ARW_Z", "BI_Z"), (arw.name, bi.name))
            self.same(row["arw_deg_per_sqrt_h"], arw.value)
            self.same(row["bi_deg_per_h"], bi.value)
            for at, limit in enumerate(COLUMNS):
                self.same(row[f"arw{limit}_deg_per_sqrt_h"], array.data[at])
            self.same(row["kurtosis"], array.data[11])
            self.assertEqual(int(row["window_samples"]), array.data[13])
            self.assertEqual(int(row["unstable"]), int(array.data[14]) >> 3 & 1)

    def test_pymavlink_reads_a_serial_line(self):
        words = [NODE, "--source", "-", *SETUP, "--out", "mavlink:serial:pty"]
        with subprocess.Popen(
            words, text=True, stdin=subprocess.PIPE, stderr=subprocess.PIPE
        ) as node:
            name = re.search(r"mavlink:serial on (\S+)", node.stderr.readline())[1]
            with contextlib.closing(mavutil.mavlink_connection(name, dialect="common")) as line:
                # pyserial discards what arrives while it opens the line
                self.assertIsNotNone(line.wait_heartbeat(timeout=HANG_S))
                node.stdin.write(counts(400))
                node.stdin.close()
                found = [line.recv_match(type="NAMED_VALUE_FLOAT", blocking=True, timeout=HANG_S)]
                found.append(
                    line.recv_match(type="DEBUG_FLOAT_ARRAY", blocking=True, timeout=HANG_S)
                )
                self.assertEqual(["ARW_X", "davar"], [one.name for one in found])
                with contextlib.suppress(serial.SerialException):  # the pty ends with the node
                    while line.recv_match(blocking=True, timeout=0.5):
                        pass
            self.assertEqual(0, node.wait(timeout=HANG_S))
            self.assertNotIn("dropped", node.stderr.read())

    def test_a_peer_that_goes_and_comes_back_is_counted(self):
        port = self.socket.getsockname()[1]
        words = [NODE, "--source", "-", *SETUP, "--out", self.where]
        with subprocess.Popen(
            words, text=True, stdin=subprocess.PIPE, stderr=subprocess.PIPE
        ) as node:

            def feed(number):
                node.stdin.write(counts(number))
                node.stdin.flush()

            feed(200)
            self.assertEqual(9, len(self.received()))
            self.socket.close()
            for _ in range(5):
                feed(50)
                time.sleep(0.1)
            self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.socket.bind(("127.0.0.1", port))
            until = time.monotonic() + 3
            while time.monotonic() < until:
                feed(50)
                time.sleep(0.1)
            self.assertGreater(len(self.received()), 10)
            self.socket.close()
            node.stdin.close()
            self.assertEqual(0, node.wait(timeout=HANG_S))
            told = node.stderr.read()
        self.assertIn(", 1 link lost", told)
        self.assertIn(", 1 link restored", told)
        dropped = int(re.search(r"(\d+) frames dropped", told)[1])
        self.assertGreaterEqual(dropped, 5)
        self.assertLessEqual(dropped, 15)

    def test_a_heartbeat_comes_every_second_without_a_result(self):
        words = [NODE, "--source", "-", *SETUP, "--out", self.where, "--system-id", "9"]
        with subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL) as node:
            self.socket.settimeout(20)
            times = []
            for _ in range(3):
                self.heartbeats += self.parser.parse_buffer(self.socket.recv(2048))
                times.append(time.monotonic())
            node.stdin.close()
        self.assertGreater(times[2] - times[0], 1.5)
        for number, one in enumerate(self.heartbeats):
            self.assertEqual(
                (9, 191, number), (one.get_srcSystem(), one.get_srcComponent(), one.get_seq())
            )
            self.assertEqual(
                (common.MAV_TYPE_ONBOARD_CONTROLLER, common.MAV_AUTOPILOT_INVALID),
                (one.type, one.autopilot),
            )
            self.assertEqual((common.MAV_STATE_ACTIVE, 3), (one.system_status, one.mavlink_version))

    def test_nobody_there_is_no_error(self):
        self.socket.close()
        words = [NODE, "--source", "-", *SETUP, "--out", self.where]
        done = subprocess.run(words, input=counts(1000), text=True, capture_output=True, check=True)
        self.assertIn("1 link lost", done.stderr)

    def simulate(self, number, *options):
        """Two axes, through davar-sim."""
        lines = ["gyro_x_counts,gyro_y_counts"] + [f"{n},{n}" for n in counts(number).split()]
        done = subprocess.run(
            [SIM, "-", *SETUP, *TRAILING, *options, "--out", self.where, "--column", lines[0]],
            input="\n".join(lines),
            text=True,
            capture_output=True,
            check=False,
        )
        self.assertEqual((0, ""), (done.returncode, done.stdout), done.stderr)
        return self.received()

    def test_heartbeats_are_as_many_as_the_seconds_of_the_recording(self):
        """20 s, and results every 0.3 s from 2 s on: at most a second apart, on average."""
        self.simulate(2000, "--stride", "30")
        for component in (191, 192):
            found = [one for one in self.heartbeats if one.get_srcComponent() == component]
            self.assertIn(len(found), (18, 19))

    def test_davar_sim_sends_every_axis(self):
        found = self.simulate(400)
        names = {one.name for one in found}
        self.assertEqual({"ARW_X", "BI_X", "ARW_Y", "BI_Y", "davar"}, names)
        self.assertEqual({191, 192}, {one.get_srcComponent() for one in found})
        self.assertEqual([191, 192] * 4, [one.get_srcComponent() for one in self.heartbeats])


if __name__ == "__main__":
    unittest.main()
