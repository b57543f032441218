"""Use with interrupts: a timer interrupt pushes, the main loop takes results and sends them over
the UART (firmware/stream.c). DAVAR_SIM: davar-sim.
"""

import os
import pty
import subprocess
import threading
import tty

import pytest
import targets
from on_boards import boards, figures_in, on_every_board

ROOT = targets.ROOT
SIM = os.environ.get("DAVAR_SIM", "davar-sim")
RECORDING = (
    ROOT / "data/demo_disturbance.csv.gz",
    *("--lsb", "0.05", "--mode", "trailing", "--progress", "never"),
)
SHORT_WINDOW = ("--law", "fixed", "--window-max", "300", "--window-min", "300")
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


@pytest.mark.parametrize("target", boards(["cortex-m4f", "rv32imac"]))
def test_blocks_of_a_dma_are_pushed_and_one_that_is_late_is_a_gap(target):
    """examples/bare_metal; a timer interrupt simulates its DMA."""
    image = targets.build(target) / "dma.elf"
    status, output = targets.execute(target, image, shift=LIKE_16_MHZ)
    assert status == 0, output
    told = figures_in(output)
    assert told["lost"] == 1
    assert told["results"] > 45  # of 56: the fit may take longer than the interval of results
    assert told["held"] > 0.85 * told["results"]


def stream(folder, target, period_us, shift, *options):
    """(counters, lines on the UART) of one run."""
    job, serial = folder / "job", folder / "serial"
    device = ("--device", f"sh -c 'cp $0 {job}; exit 1'")
    subprocess.run([SIM, *RECORDING, *options, *device], stderr=subprocess.DEVNULL, check=False)
    image = targets.build(target, "job") / "stream.elf"
    words = f"{job} {period_us}"
    status, output = targets.execute(target, image, words, shift=shift, serial=f"file:{serial}")
    assert status == 0, output
    return figures_in(output), serial.read_bytes().decode("ascii").split("\r")


@on_every_board
def test_nothing_is_lost_at_1_khz_and_the_frames_are_davar_sim_s(target, tmp_path):
    options = ("--stride", "200")
    expected = simulated(*options)
    assert len(expected) > 400
    counters, lines = stream(tmp_path, target, EVERY_MS, LIKE_16_MHZ, *options)
    assert [counters[name] for name in ("samples", "overruns", "missed")] == [SAMPLES, 0, 0]
    own, others = (
        [any_run(line) for line in text if not line.startswith(HEALTH)]
        for text in (lines, expected)
    )
    assert len(own) == len(others)
    assert [at for at, (one, other) in enumerate(zip(own, others)) if one != other] == []


@on_every_board
def test_results_that_the_main_loop_is_too_slow_for_are_counted(target, tmp_path):
    stride = "20" if targets.MACHINES[target]["small"] else "2"
    options = (*SHORT_WINDOW, "--stride", stride)
    rows = subprocess.run([SIM, *RECORDING, *options], stdout=subprocess.PIPE, check=True).stdout
    counters, lines = stream(tmp_path, target, EVERY_MS, OVERLOADED, *options)
    assert [counters[name] for name in ("samples", "overruns")] == [SAMPLES, 0]
    assert counters["missed"] > 0
    assert counters["results"] > 10
    assert counters["results"] + counters["missed"] == rows.count(b"\n") - 1
    assert told(lines)[RESULTS_MISSED] == counters["missed"]


@on_every_board
def test_samples_that_the_interrupt_is_too_slow_for_are_counted_gaps(target, tmp_path):
    counters, lines = stream(tmp_path, target, EVERY_80_US, OVERLOADED, "--stride", "100")
    assert counters["overruns"] > 100
    assert counters["samples"] + counters["overruns"] == SAMPLES
    assert told(lines)[EDGES_LOST] == counters["overruns"]
