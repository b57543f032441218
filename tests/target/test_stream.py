"""Use with interrupts: a timer interrupt pushes, the main loop takes results and sends them over
the UART (firmware/stream.c). DAVAR_SIM: davar-sim.
"""

import os
import pty
import re
import subprocess
import sys
import tempfile
import threading
import tty
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import targets

ROOT = Path(__file__).resolve().parents[2]
SIM = os.environ.get("DAVAR_SIM", "davar-sim")
RECORDING = (
    ROOT / "data/demo_disturbance.csv.gz",
    "--lsb",
    "0.05",
    "--mode",
    "trailing",
    "--progress",
    "never",
)
SHORT_WINDOW = ("--policy", "fixed", "--window-max", "300", "--window-min", "300")
SAMPLES = 6000
EVERY_MS = 1000  # us
EVERY_80_US = 80
LIKE_16_MHZ = 6  # 2^6 ns per instruction
OVERLOADED = 8
RESULTS_MISSED, EDGES_LOST = 5, 13  # items of DAVAR_Health
HEALTH = "t5D5"
OF_A_RUN = ("t5D68", "t5DB8")  # DAVAR_Setup and DAVAR_End, which identify the sender's run


def simulated(*options):
    """The text of davar-sim on a serial line, as lines."""
    ours, its = pty.openpty()
    tty.setraw(its)
    sim = subprocess.Popen([SIM, *RECORDING, *options, "--out", f"slcan:{os.ttyname(its)}"])
    threading.Thread(target=lambda: (sim.wait(), os.close(its))).start()
    text = b""
    try:
        while piece := os.read(ours, 65536):
            text += piece
    except OSError:  # its end is closed
        pass
    os.close(ours)
    return text.decode("ascii").split("\r")


def told(lines):
    """Item -> count, from the last frames of DAVAR_Health."""
    frames = [bytes.fromhex(line[5:]) for line in lines if line.startswith(HEALTH)]
    return {frame[2]: int.from_bytes(frame[4:8], "little") for frame in frames}


def any_run(line):
    """A frame without Session, and without Crc if it covers Session, because davar-sim's session
    differs at every start.
    """
    return f"{line[:5]}--{line[7:11]}--{line[13:]}" if line.startswith(OF_A_RUN) else line


class Dma(unittest.TestCase):
    """examples/bare_metal; a timer interrupt simulates its DMA."""

    def test_blocks_of_a_dma_are_pushed_and_one_that_is_late_is_a_gap(self):
        for target in ("cortex-m4f", "rv32imac"):
            with self.subTest(target=target):
                status, output = targets.execute(
                    target, targets.build(target) / "dma.elf", shift=LIKE_16_MHZ
                )
                self.assertEqual(0, status, output)
                told = {
                    name: int(value)
                    for name, value in re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)
                }
                self.assertEqual(1, told["lost"])
                self.assertGreater(
                    told["results"], 45, told
                )  # of 56: the fit may take longer than the interval of results
                self.assertGreater(told["held"], 0.85 * told["results"], told)


class Stream(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)

    def stream(self, target, period_us, shift, *options):
        """(counters, lines on the UART) of one run."""
        job, serial = self.folder / "job", self.folder / f"serial-{target}"
        subprocess.run(
            [SIM, *RECORDING, *options, "--device", f"sh -c 'cp $0 {job}; exit 1'"],
            stderr=subprocess.DEVNULL,
            check=False,
        )
        targets.build(target, "job")
        status, output = targets.execute(
            target,
            targets.folder(target, "job") / "stream.elf",
            f"{job} {period_us}",
            shift=shift,
            serial=f"file:{serial}",
        )
        self.assertEqual(0, status, output)
        return (
            {
                name: int(count)
                for name, count in re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)
            },
            serial.read_bytes().decode("ascii").split("\r"),
        )

    def same(self, expected, lines):
        """assertEqual would take minutes to describe a difference of a thousand lines."""
        self.assertEqual(len(expected), len(lines))
        for number, (one, other) in enumerate(zip(expected, lines)):
            self.assertEqual(one, other, f"line {number}")

    def test_nothing_is_lost_at_1_khz_and_the_frames_are_davar_sim_s(self):
        options = ("--stride", "200")
        expected = simulated(*options)
        self.assertGreater(len(expected), 400)
        for target in targets.BARE:
            with self.subTest(target=target):
                counters, lines = self.stream(target, EVERY_MS, LIKE_16_MHZ, *options)
                self.assertEqual(
                    (SAMPLES, 0, 0),
                    tuple(counters[name] for name in ("samples", "overruns", "missed")),
                )
                self.same(
                    [any_run(line) for line in expected if not line.startswith(HEALTH)],
                    [any_run(line) for line in lines if not line.startswith(HEALTH)],
                )

    def test_results_that_the_main_loop_is_too_slow_for_are_counted(self):
        for target in targets.BARE:
            options = (
                *SHORT_WINDOW,
                "--stride",
                "20" if targets.MACHINES[target]["small"] else "2",
            )
            rows = (
                subprocess.run(
                    [SIM, *RECORDING, *options], stdout=subprocess.PIPE, check=True
                ).stdout.count(b"\n")
                - 1
            )
            with self.subTest(target=target):
                counters, lines = self.stream(target, EVERY_MS, OVERLOADED, *options)
                self.assertEqual((SAMPLES, 0), (counters["samples"], counters["overruns"]))
                self.assertGreater(counters["missed"], 0)
                self.assertGreater(counters["results"], 10)
                self.assertEqual(rows, counters["results"] + counters["missed"])
                self.assertEqual(counters["missed"], told(lines)[RESULTS_MISSED])

    def test_samples_that_the_interrupt_is_too_slow_for_are_counted_gaps(self):
        for target in targets.BARE:
            with self.subTest(target=target):
                counters, lines = self.stream(target, EVERY_80_US, OVERLOADED, "--stride", "100")
                self.assertGreater(counters["overruns"], 100)
                self.assertEqual(SAMPLES, counters["samples"] + counters["overruns"])
                self.assertEqual(counters["overruns"], told(lines)[EDGES_LOST])


if __name__ == "__main__":
    unittest.main()
