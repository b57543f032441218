"""DroneCAN and Cyphal on a real kernel: other decoders read the bus, davarlab live shows it,
and every fault of a bus is counted and survived.
"""

import csv
import socket
import subprocess
from collections import Counter

import can
import dronecan
import numpy as np
from davar.wire.source import RECEIVE_BYTES, SO_RCVBUFFORCE
from dronecan.transport import Frame, Transfer
from kernel_case import (
    IN_GUEST,
    REPLAY,
    SIM,
    KernelCase,
    listeners,
    near,
    settle,
    shell,
    sim_csv,
    wait_for,
)

pytestmark = IN_GUEST


class Dialects(KernelCase):
    def collected(self, interface, act):
        """[(identifier, data, is_fd)] of extended frames that act() brings onto the bus."""
        with can.Bus(interface="socketcan", channel=interface, fd=True) as bus:
            bus.socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, RECEIVE_BYTES)
            act()
            settle()
            found = []
            while message := bus.recv(0.1):
                assert message.is_extended_id
                found.append((message.arbitration_id, bytes(message.data), message.is_fd))
        return found

    def replay(self, out, *options):
        command = [SIM, *REPLAY, "--out", out, "--pace", "200", *options]
        return lambda: subprocess.run(command, check=True)

    def test_dronecan_has_six_values_a_result_and_about_one_heartbeat_a_second(self):
        """The values: check_live, and tests/dialects/test_dronecan.py."""
        interface, kinds, beats = self.vcan(), Counter(), []
        replay = self.replay(f"dronecan:{interface}")
        for identifier, data, is_fd in self.collected(interface, replay):
            transfer = Transfer()
            transfer.from_frames([Frame(identifier, data)])
            assert (is_fd, transfer.source_node_id) == (False, 100)
            kind, status = dronecan.get_dronecan_data_type(transfer.payload), transfer.payload
            kinds[kind.full_name] += 1
            if kind is dronecan.uavcan.protocol.NodeStatus:
                assert transfer.transfer_id == len(beats) % 32
                assert (status.health, status.mode) == (0, 0)
                beats.append(status.uptime_sec)
        assert kinds.pop("uavcan.protocol.NodeStatus") > 11
        assert kinds == {"uavcan.protocol.debug.KeyValue": 6 * len(sim_csv())}
        assert (np.diff(beats) >= 1).all()

    def test_a_cyphal_message_is_one_frame_of_64_bytes_at_the_fast_rate(self):
        interface, rows = self.vcan(), sim_csv()
        found = self.collected(interface, self.replay(f"cyphal:{interface}"))
        shapes = Counter((one, len(data), fd) for one, data, fd in found)
        assert len(rows) == shapes.pop((0x146E7464, 64, True))
        assert {(0x147D5564, 8, False)} == set(shapes)  # uavcan.node.Heartbeat

    def test_davarlab_live_reads_both_and_survives_a_bus_that_goes(self):
        for dialect in ("dronecan", "cyphal"):
            with self.subTest(dialect=dialect):
                self.check_live(dialect)

    def check_live(self, dialect):
        interface, path = self.vcan(f"v{dialect}"), self.folder / f"{dialect}.csv"
        live = self.live(f"{dialect}:{interface}", record=str(path))
        self.replay(f"{dialect}:{interface}")()
        shell("ip", "link", "set", interface, "down")
        wait_for(lambda: listeners(interface) == 0, "the loss")
        shell("ip", "link", "set", interface, "up")
        wait_for(lambda: listeners(interface) == 1, "the return")
        self.replay(f"{dialect}:{interface}")()
        settle()
        live.terminate()
        shown, told = live.communicate(timeout=20)
        rows, found = sim_csv(), list(csv.DictReader(path.read_text().splitlines()))
        assert 2 * len(rows) == len(found), told
        assert 2 * len(rows) == len(shown.splitlines())
        assert "1 link lost, 1 link restored" in told
        for row, one in zip(rows + rows, found):
            assert (row["arw_deg_per_sqrt_h"] == "") == (one["arw_deg_per_sqrt_h"] == "")
            if row["arw_deg_per_sqrt_h"]:
                assert near(float(one["arw_deg_per_sqrt_h"]), float(row["arw_deg_per_sqrt_h"]))
