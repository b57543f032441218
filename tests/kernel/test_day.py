"""A day of davarlab live: its memory does not grow, each result is recorded once, every counter
adds up. DAVAR_DAY_HZ: samples per second of davar-sim (default 0.1), one result per twelve samples.
"""

import csv
import itertools
import json
import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

from kernel_case import (
    IN_GUEST,
    LIVE_OPTIONS,
    ROOT,
    SIM,
    KernelCase,
    listeners,
    near,
    settle,
    wait_for,
)

pytestmark = IN_GUEST

HOURS = int(os.environ.get("DAVAR_DAY_HOURS", "24"))
RUNS = HOURS // 2  # the sender is restarted every two hours
WARM_H = 2  # from here onward nothing may grow
BLOCKS = 100  # additional memory blocks that Python may hold: less than one per six results
RSS_KIB = 512
RATE_HZ = float(os.environ.get("DAVAR_DAY_HZ", "0.1"))

# Runs davarlab live, and writes a line to a descriptor every hour: blocks and objects that Python
# holds, resident memory in KiB, open files.
LIVE = """
import argparse, gc, json, os, signal, sys
from davar.wire import live, source

def tell(*_):
    gc.collect()
    with open("/proc/self/status", encoding="ascii") as status:
        rss = next(line.split()[1] for line in status if line.startswith("VmRSS"))
    held = sys.getallocatedblocks(), len(gc.get_objects()), rss, len(os.listdir("/proc/self/fd"))
    os.write(int(sys.argv[2]), (" ".join(map(str, held)) + "\\n").encode())

source.POLL_S = 600
signal.signal(signal.SIGALRM, tell)
signal.setitimer(signal.ITIMER_REAL, 3600, 3600)
sys.exit(live.run(argparse.Namespace(**json.loads(sys.argv[1]))))
"""


class Day(KernelCase):
    hang_s = 2 * HOURS * 3600

    def live(self, interface, record):
        """Starts it. Its hourly lines go to the file `hours`, the results to the list `shown`."""
        self.hours, self.shown = self.folder / "hours", []
        more = {"source": f"can:{interface}", "record": str(record), "json": True}
        command = [sys.executable, "-B", "-c", LIVE, json.dumps({**LIVE_OPTIONS, **more})]
        with open(self.hours, "wb") as file:
            out = file.fileno()
            process = self.start(*command, out, cwd=ROOT / "python", pass_fds=(out,))
        reader = threading.Thread(
            target=lambda: self.shown.extend(self.key(json.loads(line)) for line in process.stdout)
        )
        reader.start()
        self.addCleanup(lambda: (process.kill(), reader.join()))
        wait_for(lambda: listeners(interface) == 1, "davarlab live", 60)
        return process, reader

    @staticmethod
    def key(row):
        return int(row["stretch"]), int(row["epoch"])

    def of_simulator(self, interface):
        """Runs of davar-sim, half an hour each, with silence between them, and the rows that the
        recording must have for each.
        """
        path, value, rate = self.folder / "gyro.csv", 1, RATE_HZ
        with open(path, "w", encoding="ascii") as file:
            file.write("gyro_z_dps\n")
            for _ in range(int(HOURS * 3600 // RUNS * rate)):
                value = (1103515245 * value + 12345) % 2**31
                file.write(f"{((value >> 16) % 200 - 100) * 0.01:.2f}\n")
        options = f"--rate {rate} --lsb 0.01 --stride 12 --progress never".split()
        options = [SIM, str(path), *options]
        done = subprocess.run(options, text=True, stdout=subprocess.PIPE, check=True)
        wanted = list(csv.DictReader(done.stdout.splitlines()))
        for run in range(1, RUNS + 1):
            subprocess.run([*options, "--pace", "4", "--out", f"can:{interface}"], check=True)
            time.sleep(self.start_s + run * HOURS * 3600 / RUNS - time.monotonic())
        return [wanted] * RUNS

    def check_memory(self):
        hours = [
            list(map(int, line.split()))
            for line in self.hours.read_text(encoding="ascii").splitlines()
        ]
        assert len(hours) >= HOURS - 1
        for number, (blocks, objects, rss, files) in enumerate(hours, 1):
            print(
                f"hour {number:2}: {blocks} blocks, {objects} objects, {rss} KiB, "
                f"{files} open files",
                flush=True,
            )
        warm = list(
            map(max, *hours[WARM_H - 1 : WARM_H + 1])
        )  # in the middle of a run, and between two runs
        for later in hours[WARM_H + 1 :]:
            for what, before, after, most in zip(
                ("blocks", "objects", "KiB", "open files"),
                warm,
                later,
                (BLOCKS, BLOCKS, RSS_KIB, 0),
            ):
                assert after - before <= most, (what, hours)

    def test_a_day_of_results_is_recorded_completely_in_constant_memory(self):
        interface, record = self.vcan(), self.folder / "arw.csv"
        live, reader = self.live(interface, record)
        self.start_s = time.monotonic()
        wanted = self.of_simulator(interface)
        self.assertAlmostEqual(HOURS * 3600, time.monotonic() - self.start_s, delta=300)
        settle()
        live.send_signal(2)
        live.wait(timeout=700)
        reader.join()
        told = live.stderr.read()
        print(told, flush=True)
        self.check_memory()
        assert live.returncode == 0, told
        keys = [(stretch, int(row["epoch"])) for stretch, of in enumerate(wanted, 1) for row in of]
        assert keys == self.shown
        print(f"{len(keys)} results", flush=True)
        sent = int(
            Path(f"/sys/class/net/{interface}/statistics/tx_packets").read_text(encoding="ascii")
        )
        counted = {
            name: int(count)
            for count, name in re.findall(
                r"(\d+) ([a-z ]+)", told.split("received: ")[1].splitlines()[0]
            )
        }
        assert {"good": sent, "restarts": RUNS - 1} == {
            name: count for name, count in counted.items() if count
        }
        # the guest's memory cannot hold all rows together
        with open(record, encoding="utf-8") as file:
            for row, key, given in itertools.zip_longest(
                csv.DictReader(file), keys, (one for of in wanted for one in of)
            ):
                assert key == self.key(row)
                if given.get("arw_deg_per_sqrt_h"):
                    assert near(
                        float(row["arw_deg_per_sqrt_h"]), float(given["arw_deg_per_sqrt_h"])
                    ), (row, given)
