"""davarlab live on interfaces and lines that disappear and return, and when it is interrupted.
Noise on a line: tests/hypothesis/test_wire.py.
"""

import csv
import os
import pty
import re
import signal
import subprocess
import tty

import pytest
from davar.wire import frames as wire
from davar.wire import source
from davarlab import errors
from kernel_case import (
    IN_GUEST,
    REPLAY,
    SIM,
    KernelCase,
    listeners,
    settle,
    shell,
    sim_csv,
    wait_for,
)

pytestmark = IN_GUEST
RESULTS = 60
FRAMES = RESULTS * 18 + 19


class Live(KernelCase):
    def send(self, out, pace="200"):
        subprocess.run([SIM, *REPLAY, "--pace", pace, "--out", out], check=True)

    def finish(self, live, how=signal.SIGINT):
        """Ends it and returns (results shown, messages)."""
        settle()
        if live.poll() is None:
            live.send_signal(how)
        shown, told = live.communicate(timeout=20)
        return shown.splitlines(), told

    def epochs(self, path):
        with open(path, encoding="utf-8") as file:
            return [int(row["epoch"]) for row in csv.DictReader(file)]

    def test_an_interface_that_goes_down_and_up_and_one_that_is_recreated(self):
        interface, record = self.vcan(), str(self.folder / "arw.csv")
        live = self.live(f"can:{interface}", record=record)
        self.send(f"can:{interface}")
        shell("ip", "link", "set", interface, "down")
        wait_for(lambda: listeners(interface) == 0, "the loss")
        shell("ip", "link", "set", interface, "up")
        wait_for(lambda: listeners(interface) == 1, "the return")
        self.send(f"can:{interface}")
        shell("ip", "link", "del", interface)
        settle()
        self.vcan(interface)
        wait_for(lambda: listeners(interface) == 1, "the new interface")
        self.send(f"can:{interface}")
        shown, told = self.finish(live)
        assert (live.returncode, len(shown)) == (0, 3 * RESULTS), told
        assert told.count("davarlab live: can:vcan0: lost (") == 2, told
        assert told.count("davarlab live: can:vcan0: reconnected\n") == 2, told
        assert "2 link lost, 2 link restored" in told
        assert len(self.epochs(record)) == 3 * RESULTS
        assert (
            told.count(
                "channel 0: the sender has been restarted: a new section begins with epoch 99\n"
            )
            == 2
        ), told
        with open(record, encoding="utf-8") as file:
            keys = [(row["stretch"], row["epoch"]) for row in csv.DictReader(file)]
        assert (len({stretch for stretch, _ in keys}), len(set(keys))) == (3, 3 * RESULTS)

    def test_a_serial_peer_that_returns_with_the_same_name(self):
        name = self.folder / "board"

        def plug():
            ends = pty.openpty()
            tty.setraw(ends[1])
            name.unlink(missing_ok=True)
            name.symlink_to(os.ttyname(ends[1]))
            return ends

        ends = plug()
        live = self.live(f"slcan:{name}")
        frames = b"".join(frame.encode() + b"\r" for frame in self.text())
        for part, again in ((frames[:1870], True), (frames[1870:3740], False)):
            wait_for(lambda board=ends[0]: b"O\r" in os.read(board, 100), "davarlab live", 60)
            os.write(ends[0], part)
            settle()
            for end in ends:
                os.close(end)
            ends = plug() if again else ()
        shown, told = self.finish(live)
        assert len(shown) == 170 // 18, told
        assert "1 incomplete results" in told  # interrupted in the middle
        assert told.count("board: lost (the device is gone)") == 2, told
        assert (
            "received: 170 good, 0 foreign, 0 corrupted, 0 repeated, 0 swapped, 0 missing," in told
        )
        assert "2 link lost, 1 link restored" in told

    def text(self):
        """The bytes that davar-sim writes on a serial line, frame by frame."""
        ours, its = pty.openpty()
        tty.setraw(its)
        self.start(SIM, *REPLAY, "--out", f"slcan:{os.ttyname(its)}")
        text = b""
        while text.count(b"\r") < FRAMES:
            text += os.read(ours, 65536)
        os.close(its)
        os.close(ours)
        return re.findall(r"t[0-9A-F]{20}", text.decode())

    def test_the_end_of_a_pty_is_the_end(self):
        """Another process may get this name for its terminal later."""
        sim = self.start(SIM, *REPLAY, "--out", "slcan:pty")
        live = self.live(f"slcan:{self.pty_of(sim)}")
        shown, told = live.communicate(timeout=60)
        assert (live.returncode, len(shown.splitlines())) == (0, RESULTS), told
        assert "1 link lost, 0 link restored" in told

    def test_killed_in_the_middle_it_leaves_complete_rows(self):
        interface, record = self.vcan(), str(self.folder / "arw.csv")
        live = self.live(f"can:{interface}", record=record)
        sim = self.start(SIM, *REPLAY, "--pace", "100", "--out", f"can:{interface}")
        for _ in range(30):
            live.stdout.readline()
        live.kill()
        sim.kill()
        wanted, found = sim_csv(), self.epochs(record)
        assert len(found) >= 30
        assert [int(row["epoch"]) for row in wanted[: len(found)]] == found
        with open(record, encoding="utf-8") as file:
            assert [*wanted[0]][-7:] == file.readline().strip().split(",")[-7:]

    def test_a_source_that_cannot_be_opened_is_reported(self):
        self.vcan(up=False)
        for where, why in {  # others: tests/lab/test_bad_input.py
            "can:vcan9": "can:vcan9: no such interface",
            "can:vcan0": "Network is down",
            "can:": "expected, found 'can:'",
        }.items():
            with pytest.raises(errors.BadInput, match=why):
                source.Source(where, wire.Faults(), print)
