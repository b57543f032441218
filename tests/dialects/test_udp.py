"""davar-node and davar-sim send MAVLink by UDP and on a serial line: pymavlink reads the values of
the CSV, and a peer that is not there is counted and survived.
"""

import contextlib
import csv
import io
import math
import os
import re
import select
import socket
import subprocess
import time

import pytest
import serial
from pymavlink import mavutil
from pymavlink.dialects.v20 import common

NODE = os.environ.get("DAVAR_NODE", "davar-node")
SIM = os.environ.get("DAVAR_SIM", "davar-sim")
WINDOW = ("--window-max", "200", "--window-min", "100", "--segment", "30", "--stride", "50")
SETUP = ("--rate", "100", "--lsb", "0.05", *WINDOW)
TRAILING = ("--mode", "trailing", "--law", "or", "--grow", "1")
HANG_S = 600  # however busy the machine is


def counts(number):
    """Counts that look like noise, always the same, one per line."""
    value, lines = 12345, []
    for _ in range(number):
        value = (1103515245 * value + 12345) % 2**31
        lines.append(str((value >> 16) % 200 - 100))
    return "\n".join(lines) + "\n"


class Peer:
    """The receiver of a sender by UDP."""

    def __init__(self, port=0):
        self.parser, self.heartbeats = common.MAVLink(None), []
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", port))
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.port = self.socket.getsockname()[1]
        self.where = f"mavlink:udp:127.0.0.1:{self.port}"

    def received(self, wait_s=0.2):
        """Messages that are there, without heartbeats. Each datagram is one message."""
        found = []
        while select.select([self.socket], [], [], wait_s)[0]:
            messages = self.parser.parse_buffer(self.socket.recv(2048))
            assert len(messages) == 1
            found += messages
        self.heartbeats += [one for one in found if one.get_type() == "HEARTBEAT"]
        return [one for one in found if one.get_type() != "HEARTBEAT"]


@pytest.fixture
def peer():
    found = Peer()
    yield found
    found.socket.close()


def node_to(where, *words):
    command = [NODE, "--source", "-", *SETUP, "--out", where, *words]
    pipes = {"stdin": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, text=True, **pipes)


def feed(node, number):
    node.stdin.write(counts(number))
    node.stdin.flush()


def same(wanted, found):
    """A field of the CSV, and a float32."""
    if wanted == "":
        return found != found
    return float(wanted) == pytest.approx(found, rel=1e-7)


@pytest.mark.parametrize("words", [(), ("--floor", "--bandwidth", "none")])
def test_the_values_are_those_of_the_csv(peer, words):
    text, each = counts(1000), 4 if words else 3
    with node_to(peer.where, "--channel", "2", "--system-id", "9", *words) as node:
        said = node.communicate(text)[1]
    assert re.fullmatch(r"davar-node: 1000 samples, \d+ results[^\n]*\n", said)
    command = [SIM, "-", *SETUP, *TRAILING, *words]
    done = subprocess.run(command, input="gyro_z_counts\n" + text, text=True, capture_output=True)
    found, rows = peer.received(), list(csv.DictReader(io.StringIO(done.stdout)))
    assert len(found) == each * len(rows) > 30
    assert {(one.get_srcSystem(), one.get_srcComponent()) for one in found} == {(9, 193)}
    for row, arw, bi, array in zip(rows, found[0::each], found[1::each], found[2::each]):
        assert (arw.name, bi.name) == ("ARW_Z", "BI_Z")
        assert same(row["arw_deg_per_sqrt_h"], arw.value)
        assert same(row["bi_deg_per_h"], bi.value)
        for at, limit in enumerate(("", "_low", "_high")):
            assert same(row[f"arw{limit}_deg_per_sqrt_h"], array.data[at])
        assert same(row["kurtosis"], array.data[11])
        assert int(row["window_samples"]) == array.data[13]
        assert int(row["unstable"]) == int(array.data[14]) >> 3 & 1
        if words:
            for at, limit in enumerate(("", "_low", "_high")):
                value = array.data[16 + at]
                field = row[f"floor{limit}_deg_per_sqrt_h"]
                assert same(field, math.nan if value == math.inf else value)
            assert int(row["floor_why"]) == array.data[19]
    if words:
        assert [one.name for one in found[3::each]] == ["FLR_Z"] * len(rows)


def test_pymavlink_reads_a_serial_line():
    with node_to("mavlink:serial:pty") as node:
        name = re.search(r"mavlink:serial on (\S+)", node.stderr.readline())[1]
        with contextlib.closing(mavutil.mavlink_connection(name, dialect="common")) as line:
            # pyserial discards what arrives while it opens the line
            assert line.wait_heartbeat(timeout=HANG_S) is not None
            node.stdin.write(counts(400))
            node.stdin.close()
            for kind, wanted in (("NAMED_VALUE_FLOAT", "ARW_X"), ("DEBUG_FLOAT_ARRAY", "davar")):
                assert line.recv_match(type=kind, blocking=True, timeout=HANG_S).name == wanted
            with contextlib.suppress(serial.SerialException):  # the pty ends with the node
                while line.recv_match(blocking=True, timeout=0.5):
                    pass
        assert node.wait(timeout=HANG_S) == 0
        assert "dropped" not in node.stderr.read()


def test_a_peer_that_goes_and_comes_back_is_counted(peer):
    with node_to(peer.where) as node:
        feed(node, 200)
        assert len(peer.received()) == 9
        peer.socket.close()
        for _ in range(5):
            feed(node, 50)
            time.sleep(0.1)
        again, until = Peer(peer.port), time.monotonic() + 3
        while time.monotonic() < until:
            feed(node, 50)
            time.sleep(0.1)
        assert len(again.received()) > 10
        again.socket.close()
        node.stdin.close()
        assert node.wait(timeout=HANG_S) == 0
        told = node.stderr.read()
    assert ", 1 link lost" in told
    assert ", 1 link restored" in told
    assert 5 <= int(re.search(r"(\d+) frames dropped", told)[1]) <= 15


def test_a_heartbeat_comes_every_second_without_a_result(peer):
    with node_to(peer.where, "--system-id", "9") as node:
        peer.socket.settimeout(20)
        times, found = [], []
        for _ in range(3):
            found += peer.parser.parse_buffer(peer.socket.recv(2048))
            times.append(time.monotonic())
        node.stdin.close()
    assert times[2] - times[0] > 1.5
    heads = [(one.get_srcSystem(), one.get_srcComponent(), one.get_seq()) for one in found]
    assert heads == [(9, 191, number) for number in range(3)]
    states = {(one.type, one.autopilot, one.system_status, one.mavlink_version) for one in found}
    kind = (common.MAV_TYPE_ONBOARD_CONTROLLER, common.MAV_AUTOPILOT_INVALID)
    assert states == {(*kind, common.MAV_STATE_ACTIVE, 3)}


def simulated(peer, number, *options):
    """What davar-sim sends of two axes."""
    lines = ["gyro_x_counts,gyro_y_counts"] + [f"{n},{n}" for n in counts(number).split()]
    words = [*SETUP, *TRAILING, *options, "--out", peer.where, "--column", lines[0]]
    text = "\n".join(lines)
    done = subprocess.run([SIM, "-", *words], input=text, text=True, capture_output=True)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    return peer.received()


def test_davar_sim_sends_every_axis_with_the_time_of_the_recording(peer):
    found = simulated(peer, 400)
    assert {one.name for one in found} == {"ARW_X", "BI_X", "ARW_Y", "BI_Y", "davar"}
    assert {one.get_srcComponent() for one in found} == {191, 192}
    assert [one.get_srcComponent() for one in peer.heartbeats] == [191, 192] * 4
    arrays = [one for one in found if one.name == "davar" and one.get_srcComponent() == 191]
    assert [one.time_usec for one in arrays] == [10_000 * n for n in range(99, 400, 50)]


def test_heartbeats_are_as_many_as_the_seconds_of_the_recording(peer):
    """20 s, and results every 0.3 s from 2 s on: at most a second apart, on average."""
    simulated(peer, 2000, "--stride", "30")
    senders = [one.get_srcComponent() for one in peer.heartbeats]
    assert {senders.count(component) for component in (191, 192)} <= {18, 19}
