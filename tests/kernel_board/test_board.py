"""From the interrupt to candump. An emulated Cortex-M4F (firmware/stream.c) sends its results over
its UART. A real kernel makes a CAN interface of the serial line, and candump reads it there. The
decoded values are those of davar-sim's CSV.

Runs on the host: the board and the kernel (User-Mode Linux) are two processes, joined by the serial
line. DAVAR_SIM: davar-sim. DAVAR_KERNEL: the kernel.
"""

import csv
import io
import os
import re
import socket
import subprocess
import tempfile
import unittest
from pathlib import Path

import pytest
import targets
from davarlab.wire import frames as wire

pytestmark = pytest.mark.soak

ROOT = targets.ROOT

SIM, KERNEL = os.environ.get("DAVAR_SIM", "davar-sim"), os.environ.get("DAVAR_KERNEL", "linux")
TARGET = "cortex-m4f"
JOB = (
    ROOT / "data/demo_disturbance.csv.gz",
    "--lsb",
    "0.05",
    "--mode",
    "trailing",
    "--stride",
    "200",
    "--progress",
    "never",
)
SAMPLES, PERIOD_US = 6000, 1000
HANG_S = 600  # real seconds; idle machines take ten
LIKE_16_MHZ = 6  # 2^6 ns per instruction
FRAMES_A_RESULT, FAREWELL = 3 + 7 + 5 + 3, 19  # at the end each counter of davar_health once
# The commands of a user with a board on /dev/ttyS0; -r: room for frames that arrive faster than
# they are printed. The frame of cansend reaches the board's end of the line when candump listens,
# so that the board may start. candump drops this frame, which it may or may not receive.
GUEST = """slcand ttyS0 slcan0 || exit
until ip link set slcan0 up; do sleep 0.1; done 2>/dev/null
candump -L -r 4000000 -n {} slcan0,7FF~7FF &
until grep -q '^ *slcan0 ' /proc/net/can/rcvlist_inv; do sleep 0.1; done
cansend slcan0 7FF# && wait $!"""
READY = b"t7FF0\r"
EXACT = ("window_samples", "unstable")
SINGLE = (
    "arw_deg_per_sqrt_h",
    "bi_deg_per_h",
    "rrw_deg_per_h_per_sqrt_h",
    "rr_deg_per_h2",
    "qn_deg",
)
SCALED = {"kurtosis": 1e-3, "contribution": 1e-5}


def sim_rows():
    done = subprocess.run([SIM, *JOB], text=True, stdout=subprocess.PIPE, check=True)
    return list(csv.DictReader(io.StringIO(done.stdout)))


def received(lines):
    """Results and the receiver, from the lines of candump -L."""
    receiver, results = wire.Receiver(), []
    for identifier, data in re.findall(r"slcan0 ([0-9A-F]{3})#([0-9A-F]*)", lines):
        result = receiver.push(int(identifier, 16), bytes.fromhex(data))
        results += [result] if result else []
    return results + receiver.finish(), receiver


def serial_line():
    """Two ends of a line that buffers everything the board sends, because the board's clock does
    not wait for a reader. A pair of Unix sockets is full after 280 single bytes; TCP joins them.
    """
    with socket.create_server(("127.0.0.1", 0)) as server:
        one = socket.create_connection(server.getsockname())
        other, _ = server.accept()
    return one, other


class Board(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def board(self, uart):
        """The emulator's command for the job of JOB, its UART on an open socket."""
        job = self.folder / "job"
        subprocess.run(
            [SIM, *JOB, "--device", f"sh -c 'cp $0 {job}; exit 1'"],
            stderr=subprocess.DEVNULL,
            check=False,
        )
        image = targets.build(TARGET, "job", "stream") / "stream.elf"
        return [
            *targets.command(TARGET, image, f"{job} {PERIOD_US}", LIKE_16_MHZ, "chardev:uart"),
            "-chardev",
            f"socket,id=uart,fd={uart.fileno()}",
        ]

    def start(self, command, inherited):
        process = subprocess.Popen(
            command,
            text=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=[inherited.fileno()],
        )
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.kill)
        return process

    @staticmethod
    def wait_for_guest(uart):
        heard = b""
        uart.settimeout(HANG_S)
        while READY not in heard:
            heard += uart.recv(100)
        uart.settimeout(None)

    def chain(self, frames):
        """Runs board and kernel; returns (output of the board, output of candump)."""
        uart, line = serial_line()
        with uart, line:
            command = self.board(uart)
            guest = self.start(
                [
                    ROOT / "tools/support/uml/run",
                    "-t",
                    str(HANG_S),
                    "-s",
                    str(line.fileno()),
                    KERNEL,
                    "bash",
                    "-c",
                    GUEST.format(frames),
                ],
                line,
            )
            self.wait_for_guest(uart)
            board = self.start(command, uart)
            told, _ = board.communicate(timeout=HANG_S)
            self.assertIn("missed 0\n", told)
            printed, _ = guest.communicate(timeout=HANG_S)
        self.assertEqual((0, 0), (board.returncode, guest.returncode), told + printed)
        return told, printed

    def same(self, row, result):
        for name in EXACT:
            self.assertEqual(int(row[name]), result.values[name], name)
        for name in SINGLE:
            self.assert_single(row[name], result.values[name], name)
        for name, unit in SCALED.items():
            self.assertLessEqual(abs(float(row[name]) - result.values[name]), 0.501 * unit, name)
        clusters = [name for name in row if name.startswith("adev_")]
        self.assertEqual(len(clusters), len(result.adev))
        for index, name in enumerate(clusters):
            self.assert_single(row[name], result.adev[index], name)

    def assert_single(self, text, value, name):
        """The CSV's number, rounded to float32; an empty field is NaN."""
        if text == "":
            self.assertNotEqual(value, value, name)
        else:
            self.assertLessEqual(
                abs(value - float(text)), 1.01 * 2**-24 * abs(float(text)) + 1e-45, name
            )

    def test_the_values_that_candump_saw_are_those_of_the_csv(self):
        rows = sim_rows()
        frames = len(rows) * FRAMES_A_RESULT + FAREWELL
        told, printed = self.chain(frames)
        results, receiver = received(printed)
        self.assertIn(f"samples {SAMPLES}\n", told)
        self.assertIn("overruns 0\n", told)
        self.assertEqual(
            (frames, 0), (receiver.faults.good, receiver.faults.total()), receiver.faults
        )
        self.assertEqual(FAREWELL, len(receiver.channels[0].health))
        self.assertEqual([int(row["epoch"]) for row in rows], [result.epoch for result in results])
        for row, result in zip(rows, results):
            with self.subTest(epoch=result.epoch):
                self.same(row, result)
