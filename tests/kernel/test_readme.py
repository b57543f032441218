"""docs/STREAMS.md: runs its commands unchanged, each in its own terminal, on a kernel that has the
bus, the pins and the tty of the page. A file simulates the sensor's driver for davar-node.
"""

import contextlib
import csv
import os
import pty
import re
import signal
import subprocess
import tempfile
import tty
from pathlib import Path

from davar.wire import frames as wire
from kernel_case import (
    IN_GUEST,
    ROOT,
    Chip,
    KernelCase,
    listeners,
    near,
    settle,
    shell,
    take,
    wait_for,
)

SECTION = (ROOT / "docs/STREAMS.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^```sh\n(.*?)\n```$", SECTION, re.DOTALL | re.MULTILINE)
IIO = "iio/devices/iio:device0/in_anglvel_z_raw"
SIM_CSV = ("tools/davar-sim", "data/demo_disturbance.csv.gz", "--lsb", "0.001", "--stride", "100")
EDGE_LINE, EDGES, RESULTS = 17, 1500, 60


def command(*words):
    """The command of the section that has all these words."""
    found = [one for one in COMMANDS if all(word in one for word in words)]
    assert len(found) == 1, f"docs/STREAMS.md: {len(found)} commands with {words}"
    return found[0]


pytestmark = IN_GUEST


class Readme(KernelCase):
    @classmethod
    def setUpClass(cls):
        """A driver's file in a place where only a driver can create one, and a tty that does not
        exist.
        """
        value = Path("/run/sensor") / IIO
        value.parent.mkdir(parents=True)
        value.write_text("17\n")
        shell(
            "mount", "-t", "overlay", "overlay", "-o", "lowerdir=/run/sensor:/sys/bus", "/sys/bus"
        )
        cls.addClassCleanup(shell, "umount", "/sys/bus")

    def terminal(self, text):
        """Starts a command. Its output goes to a file, so that it never waits for a reader."""
        shown, said = (
            self.enterContext(tempfile.TemporaryFile("w+", encoding="utf-8")) for _ in range(2)
        )
        process = subprocess.Popen(
            ["bash", "-c", text],
            cwd=ROOT,
            text=True,
            stdin=subprocess.DEVNULL,
            stdout=shown,
            stderr=said,
            start_new_session=True,
        )
        process.shown, process.said = shown, said
        self.addCleanup(process.wait)
        self.addCleanup(lambda: process.poll() is None and os.killpg(process.pid, 9))
        return process

    def hang_up(self, process):
        """Sends Control-C and returns the output."""
        os.killpg(process.pid, signal.SIGINT)
        process.wait(timeout=30)
        wait_for(
            lambda: (
                subprocess.run(
                    ["pgrep", "-g", str(process.pid)], stdout=subprocess.DEVNULL
                ).returncode
            ),
            "its pipeline",
        )
        return self.printed(process)

    @staticmethod
    def printed(process):
        for file in (process.shown, process.said):
            file.seek(0)
        return process.shown.read(), process.said.read()

    def test_every_command_is_one_of_these_tests(self):
        assert len(COMMANDS) == 6

    def test_two_receivers_and_two_senders_on_a_bus(self):
        chip = Chip(lines=32)
        self.addCleanup(chip.close)
        assert chip.name == "gpiochip0"
        shell("bash", "-c", command("ip link add"))
        self.addCleanup(shell, "ip", "link", "del", "vcan0")
        decoder = self.terminal(command("candump", "cantools"))
        live = self.terminal(command("davarlab live"))
        wait_for(lambda: listeners("vcan0") == 2, "two receivers")
        sender = self.terminal(command("davar-sim", "can:vcan0"))
        assert sender.wait() == 0, self.printed(sender)
        results = self.gateway(chip)
        settle()
        decoded, complaints = self.hang_up(decoder)
        shown, told = self.hang_up(live)
        self.check_decoded(decoded, complaints)
        self.check_live(shown, told, results)

    def gateway(self, chip):
        """Runs davar-node with enough edges for a few results and returns the number sent."""
        node = self.terminal(command("davar-node"))
        wait_for(lambda: shell("gpioinfo", chip.name).count("davar-node") == 2, "davar-node")
        settle()
        for _ in range(EDGES):
            chip.edge(EDGE_LINE)
        _, errors = self.hang_up(node)
        assert re.search(rf"^davar-node: {EDGES} samples, \d+ results", errors)
        return int(re.search(r"(\d+) results", errors)[1])

    def check_decoded(self, text, complaints):
        for word in (
            "DAVAR_State(",
            "ArwDegPerSqrtH: 0.29",
            "deg/sqrt(h)",
            "DAVAR_Adev(",
            "HealthIndex: Alarms",
        ):
            assert word in text, complaints

    def check_live(self, shown, told, results):
        assert shown.count("channel 0  epoch") == RESULTS, shown + told
        assert results == shown.count("channel 1  epoch"), shown + told
        assert results > 2
        assert re.search(
            r"received: \d+ good, 0 foreign, 0 corrupted, 0 repeated, 0 swapped, 0 missing", told
        )
        with open(ROOT / "build/arw.csv", encoding="utf-8") as file:
            recorded = [row for row in csv.DictReader(file) if row["channel"] == "0"]
        done = subprocess.run(SIM_CSV, cwd=ROOT, text=True, stdout=subprocess.PIPE, check=True)
        wanted = list(csv.DictReader(done.stdout.splitlines()))
        assert [row["epoch"] for row in wanted] == [row["epoch"] for row in recorded]
        for one, other in zip(wanted, recorded):
            for name in ("time_s", "arw_deg_per_sqrt_h", "adev_1", "adev_64"):
                assert near(float(other[name]), float(one[name]), 1e-7), (name, one, other)

    def test_a_recording_on_a_serial_line(self):
        ours, its = pty.openpty()
        self.addCleanup(os.close, ours)
        tty.setraw(its)
        Path("/dev/ttyUSB0").symlink_to(os.ttyname(its))
        self.addCleanup(Path("/dev/ttyUSB0").unlink)
        sender = self.terminal(command("slcan:/dev/ttyUSB0"))
        receiver, text = wire.Receiver(), b""
        os.set_blocking(ours, False)
        while sender.poll() is None:
            settle(0.02)
            with contextlib.suppress(BlockingIOError):
                text = take(text + os.read(ours, 65536), receiver)
        os.close(its)
        assert (sender.returncode, receiver.faults.total()) == (0, 0), receiver.faults
        assert receiver.faults.good == RESULTS * (3 + 7 + 5 + 3) + 19
