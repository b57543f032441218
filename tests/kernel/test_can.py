"""SocketCAN on a real kernel: values, and every fault of a bus."""

import os
import subprocess
import time
from pathlib import Path

from davar.wire import frames as wire
from kernel_case import (
    IN_GUEST,
    NODE,
    REPLAY,
    SIM,
    KernelCase,
    SerialCan,
    near,
    settle,
    shell,
    sim_csv,
    take,
    wait_for,
)

pytestmark = IN_GUEST


class Values(KernelCase):
    def check(self, content):
        interface = self.vcan()
        receiver, stop_listening = self.listen(interface)
        subprocess.run(
            [SIM, *REPLAY, "--out", f"can:{interface}", "--can-content", content, "--pace", "200"],
            check=True,
        )
        found, wanted = stop_listening(), sim_csv()
        assert receiver.faults.total() == 0, receiver.faults
        assert [int(row["epoch"]) for row in wanted] == [result.epoch for result in found]
        for row, result in zip(wanted, found):
            if row["arw_deg_per_sqrt_h"]:
                assert near(result.values["arw_deg_per_sqrt_h"], float(row["arw_deg_per_sqrt_h"]))
            assert int(row["window_samples"]) == result.values["window_samples"]
            assert int(row["unstable"]) == result.values["unstable"]
            for index, m in enumerate((1, 2, 4, 8, 16, 32, 64) if content != "summary" else ()):
                assert near(result.adev[index], float(row[f"adev_{m}"])), (row, result)

    def test_the_values_on_the_bus_are_those_of_the_csv(self):
        self.check("full")

    def test_in_can_fd_frames_too(self):
        self.check("fd")

    def test_the_data_of_can_fd_goes_at_the_fast_rate(self):
        interface = self.vcan()
        dump = self.start("candump", "-L", "-n", "1", interface)
        settle()
        subprocess.run(
            [SIM, *REPLAY, "--out", f"can:{interface}", "--can-content", "fd"], check=True
        )
        assert " 5D8##5" in dump.communicate(timeout=20)[0]


class Link(KernelCase):
    # Options of vcan() or None, destination, more options, the error.
    REFUSED = (
        (None, "can:can9", (), "No such device"),
        ({"up": False}, "can:vcan0", (), "Network is down"),
        *(
            ({"mtu": 16}, out, more, "the interface is not set to CAN FD (mtu 72)")
            for out, more in (("can:vcan0", ("--can-content", "fd")), ("cyphal:vcan0", ()))
        ),
    )

    def test_an_interface_that_is_missing_down_or_too_slow_is_one_clear_error(self):
        node = (NODE, "--source", "-", "--rate", 100, "--lsb", 1)
        for interface, out, more, why in self.REFUSED:
            with self.subTest(out=out, why=why):
                if interface:
                    self.vcan(**interface)
                told = self.refused(SIM, *REPLAY, "--out", out, *more)
                assert f"davar-sim: --out: {out}: {why}\n" == told
                if not more:
                    told = self.refused(*node, "--out", out)
                    assert f"davar-node: --out: {out}: {why}\n" == told
                if interface:
                    shell("ip", "link", "del", "vcan0")

    def test_down_and_up_again_loses_frames_that_are_counted_on_both_sides(self):
        interface = self.vcan()
        receiver, stop_listening = self.listen(interface)
        node = self.node("--out", f"can:{interface}")
        self.feed(node, 1000)
        wait_for(lambda: receiver.faults.good > 100, "frames")
        shell("ip", "link", "set", interface, "down")
        settle()
        self.feed(node, 500, first=1)
        settle()
        shell("ip", "link", "set", interface, "up")
        before = receiver.faults.good
        settle()
        self.feed(node, 1000, first=2)
        wait_for(
            lambda: receiver.faults.good > before + 100, "frames after the interface came back"
        )
        told = self.last_words(node)
        found = stop_listening()
        health = receiver.channels[0].health
        assert (told["link lost"], told["link restored"]) == (1, 1)
        assert told["frames dropped"] > 100
        assert told["frames dropped"] == health["FramesDropped"]
        state = receiver.sequences[0x5D1]
        assert (
            told["results"] - len(found)
            == state.missing + receiver.faults.missing_results + receiver.faults.incomplete_results
        )
        assert told["samples"] == 2500

    def test_a_node_may_start_before_its_interface(self):
        node = self.node("--out", "can:vcan0", "--wait")
        self.feed(node, 500)
        settle()
        interface = self.vcan()
        receiver, stop_listening = self.listen(interface)
        settle()
        self.feed(node, 500)
        wait_for(lambda: receiver.faults.good > 50, "frames")
        told = self.last_words(node)
        stop_listening()
        assert told["link restored"] == 1
        assert told["frames dropped"] > 50


class Bus(KernelCase):
    def test_a_full_transmit_queue_loses_no_frame(self):
        line = SerialCan()
        self.addCleanup(line.close)
        sim = self.start(SIM, *REPLAY, "--out", f"can:{line.name}")
        settle()
        assert sim.poll() is None, "the simulator should wait for room"
        receiver, text = wire.Receiver(), b""
        os.set_blocking(line.master, False)
        while sim.poll() is None or text.count(b"\r"):
            try:
                text += os.read(line.master, 4096)
            except BlockingIOError:
                settle(0.001)
            text = take(text, receiver)
        settle()
        assert sim.returncode == 0
        assert receiver.faults.total() == 0, receiver.faults
        assert receiver.channels[0].health["SendRetries"] > 0
        assert receiver.faults.good > 1000

    def test_error_passive_and_bus_off_are_counted(self):
        line = SerialCan()
        self.addCleanup(line.close)
        node = self.node("--out", f"can:{line.name}")
        settle()
        for state in (b"sp130130", b"sa000000", b"sp130130", b"sb255255"):
            line.say(state + b"\r")
            settle()
        self.feed(node, 2000)
        settle()
        told = self.last_words(node)
        assert (told["error passive"], told["bus off"]) == (2, 1), told
        assert told["samples"] == 2000
        assert told["frames dropped"] == told["results"] * 16 + 19, (
            "all, with what the queue held at the end"
        )

    def count_frames(self, line, receiver, seconds=0.5):
        """How many valid frames the line delivers in this time."""
        before, until = receiver.faults.good, time.monotonic() + seconds
        while time.monotonic() < until:
            line.hear(receiver)
        return receiver.faults.good - before

    def test_after_bus_off_and_a_restart_frames_flow_again_and_all_lost_count(self):
        line, receiver = SerialCan(), wire.Receiver()
        self.addCleanup(line.close)
        node = self.node("--out", f"can:{line.name}")
        self.feed(node, 1000)
        wait_for(
            lambda: self.count_frames(line, receiver, 0.1) >= 0 and receiver.faults.good > 200,
            "frames",
        )
        wait_for(lambda: self.count_frames(line, receiver) == 0, "the last of them")
        line.say(b"sb255255\r")
        wait_for(
            lambda: Path(f"/sys/class/net/{line.name}/carrier").read_text() == "0\n", "bus-off"
        )
        settle()
        line.hear(receiver)
        self.feed(node, 5000, first=1)
        assert self.count_frames(line, receiver) == 0, "nothing is given to a bus that is off"
        line.say(
            b"sa000000\r"
        )  # the controller has recovered; the interface has not been restarted
        assert self.count_frames(line, receiver) == 0
        shell("ip", "link", "set", line.name, "down")
        settle()
        shell("ip", "link", "set", line.name, "up")
        settle()
        before = receiver.faults.good
        self.feed(node, 1000, first=2)
        wait_for(
            lambda: (
                self.count_frames(line, receiver, 0.1) >= 0 and receiver.faults.good > before + 200
            ),
            "frames again",
        )
        node.stdin.close()
        node.stdin = None
        self.count_frames(line, receiver, 2)
        told = self.last_words(node)
        assert (told["bus off"], told["link lost"], told["link restored"]) == (1, 1, 1), told
        assert told["samples"] == 7000
        assert told["frames dropped"] == receiver.channels[0].health["FramesDropped"]
        assert told["frames dropped"] > 1000
        assert receiver.channels[0].health["BusOff"] == 1
        assert receiver.faults.corrupted == 0, receiver.faults

    def test_a_controller_that_restarts_itself_loses_no_queued_frame(self):
        """Sends from another socket the error frames of a controller with restart-ms."""
        interface = self.vcan()
        receiver, stop_listening = self.listen(interface)
        node = self.node("--out", f"can:{interface}")
        self.feed(node, 500)
        wait_for(lambda: receiver.faults.good > 100, "frames")
        settle()
        before = receiver.faults.good
        shell("cansend", interface, "20000040#0000000000000000")  # bus-off
        settle()
        self.feed(node, 500, first=1)
        settle()
        assert before == receiver.faults.good
        shell("cansend", interface, "20000100#0000000000000000")  # restarted
        wait_for(lambda: receiver.faults.good > before + 100, "frames after the restart")
        told = self.last_words(node)
        results = stop_listening()
        assert (told["bus off"], told["link restored"]) == (1, 1), told
        assert "frames dropped" not in told
        assert told["results"] == len(results)
        assert receiver.faults.total() == 0, receiver.faults
