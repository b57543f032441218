"""The workbench with a CAN interface: the requests of its page while a sensor sends, and the raw
samples that it freezes and diagnoses. tests/workbench/test_live.py tests the page in a browser.
"""

import csv
import json
import subprocess
import urllib.error
import urllib.parse
import urllib.request

from kernel_case import (
    IN_GUEST,
    RECORDING,
    REPLAY,
    ROOT,
    SIM,
    KernelCase,
    listeners,
    settle,
    sim_csv,
    wait_for,
)

pytestmark = IN_GUEST

LSB = float(REPLAY[REPLAY.index("--lsb") + 1])


class Bench(KernelCase):
    def open(self):
        bench = self.start(ROOT / "tools/davarlab", "open", "--no-browser", cwd=self.folder)
        place = urllib.parse.urlsplit(bench.stdout.readline().strip())
        self.origin, self.token = (
            f"http://{place.netloc}",
            urllib.parse.parse_qs(place.query)["token"][0],
        )

    def ask(self, what, given=None):
        """(status, answer) of a GET request, or of an action with these parameters."""
        data = None if given is None else json.dumps(given).encode()
        request = urllib.request.Request(
            f"{self.origin}/api/{what}", data, {"X-Davar-Token": self.token}
        )
        try:
            with urllib.request.urlopen(request) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as why:
            return why.code, json.load(why)

    def test_results_and_raw_samples_of_a_bus(self):
        interface = self.vcan()
        self.open()
        self.assertEqual(self.ask("listen", {"source": f"can:{interface}"})[0], 200)
        wait_for(lambda: listeners(interface) == 1, "the workbench", 60)
        status, answer = self.ask("freeze", {"channel": 0})
        self.assertEqual((status, "no raw samples received" in answer["error"]), (400, True))
        subprocess.run(
            [SIM, *REPLAY, "--raw", "--pace", "200", "--out", f"can:{interface}"], check=True
        )
        wanted = sim_csv()
        wait_for(lambda: self.ask("live")[1]["count"] >= len(wanted) - 1, "the results")
        settle()
        shown = self.ask("live")[1]
        self.assertEqual(shown["raw"], [0])
        self.assertEqual(shown["faults"].keys(), {"good"})
        for row, true in zip(shown["rows"], wanted):
            self.assertEqual(row["epoch"], int(true["epoch"]))
            self.assertAlmostEqual(
                row["arw_deg_per_sqrt_h"] / float(true["arw_deg_per_sqrt_h"]), 1, delta=1e-6
            )
        status, answer = self.ask("freeze", {"channel": 0})
        self.assertEqual(status, 200, answer)
        self.assertGreater(answer["samples"], 5900)
        status, step = self.ask("step")
        self.assertEqual((status, step["error"] > 0), (200, True))
        self.assertTrue(self.ask("candidates")[1]["candidates"])
        with open(self.folder / "davarlab-files/frozen.csv", encoding="ascii") as file:
            frozen = [
                float(row["gyro_x_dps"])
                for row in csv.DictReader(line for line in file if line[0] != "#")
            ]
        raw = subprocess.run(
            ["zcat", RECORDING], stdout=subprocess.PIPE, text=True, check=True
        ).stdout.splitlines()
        truth = [
            float(row["gyro_z_dps"])
            for row in csv.DictReader(line for line in raw if line[0] != "#")
        ]
        for one, true in zip(frozen, truth):
            self.assertLessEqual(abs(one - true), LSB / 2 + 1e-6)
            self.assertAlmostEqual(one / LSB, round(one / LSB), delta=1e-6)
