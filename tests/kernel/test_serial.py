"""SLCAN text on serial lines: a real slcan interface at the other end, and misbehaving peers."""

import os
import subprocess
import tty

from davar.wire import frames as wire
from kernel_case import IN_GUEST, REPLAY, SIM, KernelCase, near, settle, sim_csv, take, wait_for

pytestmark = IN_GUEST


class Serial(KernelCase):
    def test_slcand_turns_the_line_into_an_interface_with_the_same_values(self):
        sim = self.start(SIM, *REPLAY, "--out", "slcan:pty", "--pace", "50")
        line = self.pty_of(sim)
        self.start("slcand", "-F", line, "slcan0")
        wait_for(lambda: os.path.exists("/sys/class/net/slcan0"), "slcan0")
        subprocess.run(["ip", "link", "set", "slcan0", "up"], check=True)
        receiver, stop_listening = self.listen("slcan0")
        sim.wait(timeout=60)
        found, wanted = {result.epoch: result for result in stop_listening()}, sim_csv()
        assert receiver.faults.total() == 0, receiver.faults
        assert len(found) > 20
        for row in wanted:
            result = found.get(int(row["epoch"]))
            if result and row["arw_deg_per_sqrt_h"]:
                assert near(result.values["arw_deg_per_sqrt_h"], float(row["arw_deg_per_sqrt_h"]))

    def test_a_slow_reader_gets_every_frame(self):
        """The pty accepts some hundred bytes at a time, so every write is short."""
        sim = self.start(SIM, *REPLAY, "--out", "slcan:pty")
        descriptor = os.open(self.pty_of(sim), os.O_RDWR | os.O_NOCTTY)
        receiver, text = wire.Receiver(), b""
        try:
            while chunk := os.read(descriptor, 37):
                text = take(text + chunk, receiver)
        except OSError:
            pass  # the other end is closed
        os.close(descriptor)
        assert (sim.wait(timeout=10), receiver.faults.total()) == (0, 0), receiver.faults
        assert receiver.faults.good == 60 * 18 + 19

    def test_a_peer_that_disconnects_and_returns(self):
        node = self.node("--out", "slcan:pty")
        line = self.pty_of(node)
        receiver = wire.Receiver()
        first = os.open(line, os.O_RDWR | os.O_NOCTTY)
        self.feed(node, 1000)
        settle()
        take(os.read(first, 100000), receiver)
        os.close(first)
        settle()
        self.feed(node, 1000, first=1)
        settle()
        second = os.open(line, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(second)
        settle()
        self.feed(node, 300, first=2)
        settle()
        take(os.read(second, 100000), receiver)
        told = self.last_words(node)
        os.close(second)
        assert (told["link lost"], told["link restored"], told["samples"]) == (1, 1, 2300), told
        assert told["frames dropped"] > 0
        assert receiver.faults.missing > 0

    def test_noise_on_the_line_is_counted_and_an_slcan_host_is_no_noise(self):
        node = self.node("--out", "slcan:pty")
        descriptor = os.open(self.pty_of(node), os.O_RDWR | os.O_NOCTTY)
        tty.setraw(descriptor)
        os.write(descriptor, b"C\rS6\rO\rV\r")
        os.write(descriptor, b"\xff\x00garbage!\r" + b"x" * 50 + b"\r")
        settle()
        self.feed(node, 200)
        settle()
        told = self.last_words(node)
        os.close(descriptor)
        assert told["noise bytes"] == 60
