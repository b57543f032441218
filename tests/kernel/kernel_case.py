"""Shared by the tests on a real kernel. They run as root inside the guest of tools/support/uml/run
-T.

Time is virtual there: it stops while any process works, and jumps to the next timer when all wait.
A sleeping process therefore wakes when the work is done, however slow the machine is. No deadline
here can be missed because the machine is slow.
"""

import csv
import faulthandler
import fcntl
import io
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
import tty
import unittest
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SIM, NODE = os.environ.get("DAVAR_SIM", "davar-sim"), os.environ.get("DAVAR_NODE", "davar-node")
RECORDING = str(ROOT / "data/demo_disturbance.csv.gz")
REPLAY = (RECORDING, "--lsb", "0.001", "--stride", "100", "--progress", "never")
N_SLCAN = 17  # line discipline
SIOCGIFNAME = 0x8910
HAS_VIRTUAL_TIME = "time-travel=inf-cpu" in Path("/proc/cmdline").read_text()
IN_GUEST = [
    pytest.mark.soak,
    pytest.mark.skipif(not HAS_VIRTUAL_TIME, reason="only in the guest of tools/support/uml/run"),
]
# The command of tools/davarlab live, without the other commands and their requirements
# (test_readme.py runs the complete program).
LIVE = (
    "import sys, json, argparse\nfrom davar.wire import live\n"
    "sys.exit(live.run(argparse.Namespace(**json.loads(sys.argv[1]))))"
)
LIVE_OPTIONS = {"base": 0x5D0, "record": None, "raw": None, "count": None, "idle": None}


def shell(*command):
    return subprocess.run(
        [*map(str, command)],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=True,
    ).stdout


def settle(seconds=0.5):
    """Waits until all processes wait and data of this time has arrived."""
    time.sleep(seconds)


def wait_for(condition, what, seconds=20):
    """Waits until condition() is true; returns its value."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        value = condition()
        if value:
            return value
        settle(0.02)
    raise AssertionError(f"waited in vain for {what}")


@cache
def sim_csv(*options):
    done = subprocess.run([SIM, *REPLAY, *options], text=True, stdout=subprocess.PIPE, check=True)
    return list(csv.DictReader(io.StringIO(done.stdout)))


def listeners(interface):
    """The number of sockets that receive from an interface."""
    lists = (Path(f"/proc/net/can/rcvlist_{kind}").read_text() for kind in ("all", "fil"))
    return len(re.findall(rf"^ *{interface} ", "".join(lists), re.MULTILINE))


def take(text, receiver):
    """Feeds the complete lines of SLCAN text to a receiver; returns the rest."""
    *lines, rest = text.split(b"\r")
    for line in lines:
        if re.fullmatch(rb"t[0-9A-F]{3}8[0-9A-F]{16}", line):
            receiver.push(int(line[1:4], 16), bytes.fromhex(line[5:].decode()))
        elif line:
            receiver.faults.noise += 1
    return rest


def near(a, b, relative=2**-24):
    return abs(a - b) <= relative * abs(b) * 1.01


class SerialCan:
    """A real SLCAN interface whose serial line ends here: the test acts as the adapter."""

    def __init__(self):
        self.master, self.slave = pty.openpty()
        self.text = b""
        tty.setraw(self.slave)
        fcntl.ioctl(self.slave, termios.TIOCSETD, struct.pack("i", N_SLCAN))
        self.name = fcntl.ioctl(self.slave, SIOCGIFNAME, bytes(40)).split(b"\0")[0].decode()
        shell("ip", "link", "set", self.name, "txqueuelen", "10", "up")

    def say(self, text):
        os.write(self.master, text)

    def hear(self, receiver):
        """Feeds new data of the line to a receiver. slcan sends a frame after the last one has been
        read.
        """
        while select.select([self.master], [], [], 0.01)[0]:
            self.text += os.read(self.master, 65536)
        *lines, self.text = self.text.split(b"\r")
        for line in lines:
            receiver.push(int(line[1:4], 16), bytes.fromhex(line[5:].decode()))

    def close(self):
        os.close(self.slave)
        os.close(self.master)


GPIO_SIM = Path("/sys/kernel/config/gpio-sim/davar")
EDGE, ALARM = 2, 5
PERIOD_S = 0.004


class Chip:
    """A gpio-sim chip."""

    def __init__(self, lines=8):
        (GPIO_SIM / "bank").mkdir(parents=True)
        (GPIO_SIM / "bank/num_lines").write_text(str(lines))
        (GPIO_SIM / "live").write_text("1")
        self.name = (GPIO_SIM / "bank/chip_name").read_text().strip()
        device = (GPIO_SIM / "dev_name").read_text().strip()
        self.lines = Path("/sys/devices/platform") / device / self.name

    def edge(self, line=EDGE, period_s=PERIOD_S):
        pull = self.lines / f"sim_gpio{line}/pull"
        pull.write_text("pull-up")
        time.sleep(period_s / 2)  # gpio-sim merges edges closer than a tick
        pull.write_text("pull-down")
        time.sleep(period_s / 2)

    def alarm(self):
        return (self.lines / f"sim_gpio{ALARM}/value").read_text().strip() == "1"

    def close(self):
        (GPIO_SIM / "live").write_text("0")
        (GPIO_SIM / "bank").rmdir()
        GPIO_SIM.rmdir()


class KernelCase(unittest.TestCase):
    hang_s = 3600  # after this time a test ends with the stacks of its threads

    def setUp(self):
        faulthandler.dump_traceback_later(self.hang_s, exit=True)
        self.addCleanup(faulthandler.cancel_dump_traceback_later)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def vcan(self, name="vcan0", mtu=None, up=True):
        shell("ip", "link", "add", name, "type", "vcan")
        self.addCleanup(
            lambda: subprocess.run(
                ["ip", "link", "del", name], stderr=subprocess.DEVNULL, check=False
            )
        )
        if mtu:
            shell("ip", "link", "set", name, "mtu", mtu)
        if up:
            shell("ip", "link", "set", name, "up")
        return name

    def start(self, *command, **keywords):
        process = subprocess.Popen(
            [*map(str, command)],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            **keywords,
        )
        self.addCleanup(self.end, process)
        return process

    def live(self, source, **options):
        """Starts davarlab live. On a bus, it listens when this returns."""
        wanted = json.dumps({**LIVE_OPTIONS, "source": source, "json": False, **options})
        live = self.start(sys.executable, "-B", "-c", LIVE, wanted, cwd=ROOT / "python")
        kind, _, interface = source.partition(":")
        if kind != "slcan":
            wait_for(lambda: listeners(interface) == 1, "davarlab live", 60)
        return live

    def pty_of(self, process):
        """The name of the pty that a program has created."""
        return re.search(r"/dev/pts/\d+", process.stderr.readline()).group()

    def refused(self, *command):
        """The line on standard error of a command that is refused."""
        done = subprocess.run(
            [*map(str, command)],
            text=True,
            capture_output=True,
            check=False,
            stdin=subprocess.DEVNULL,
        )
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.count("\n") == 1, done.stderr
        return done.stderr

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.kill()
        process.communicate()

    def node(self, *options, source="-", **keywords):
        window = ["--window-max", "200", "--window-min", "100", "--segment", "30", "--stride", "50"]
        words = [NODE, "--source", source, "--rate", "1000", "--lsb", "0.05", *window, *options]
        return self.start(*words, stdin=subprocess.PIPE, **keywords)

    def stop(self, node):
        """Ends a node with SIGTERM and returns its last line as {name: count}. Its unread input
        stays unread.
        """
        node.send_signal(signal.SIGTERM)
        return self.last_words(node)

    def last_words(self, node):
        """Ends the input of a node, which reads the rest and ends. Returns its last line as {name:
        count}.
        """
        if node.stdin:
            node.stdin.close()
            node.stdin = None
        _, errors = node.communicate(timeout=20)
        assert node.returncode == 0, errors
        words = errors.strip().splitlines()[-1].removeprefix("davar-node: ").split(", ")
        return {word.split(" ", 1)[1]: int(word.split(" ", 1)[0]) for word in words}

    def listen(self, interface, patience_s=0.1):
        """A Receiver fed by a thread. stop_listening() ends it when no more data arrives."""
        import can
        from davar.wire import frames as wire

        receiver = wire.Receiver()
        bus = can.Bus(interface="socketcan", channel=interface, fd=True)
        done, collected = threading.Event(), []

        def work():
            message = None
            while message or not done.is_set():  # also reads the rest in the socket at the end
                try:
                    message = bus.recv(patience_s)
                except can.CanError:  # the interface is down; the socket stays valid
                    message = None
                    settle(0.05)
                    continue
                if message and not message.is_error_frame:
                    result = receiver.push(message.arbitration_id, bytes(message.data))
                    collected.extend([result] if result else [])
            collected.extend(receiver.finish())
            bus.shutdown()

        thread = threading.Thread(target=work)
        thread.start()

        def stop_listening():
            settle()
            done.set()
            thread.join()
            return collected

        self.addCleanup(done.set)
        return receiver, stop_listening

    def feed(self, node, count, first=0):
        """Counts that look like noise, always the same."""
        value = 12345 + first
        for _ in range(count):
            value = (1103515245 * value + 12345) % 2**31
            node.stdin.write(f"{(value >> 16) % 200 - 100}\n")
        node.stdin.flush()
