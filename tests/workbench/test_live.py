"""A sensor on a serial line, watched in the page: what davar-sim sends over a pty is what it writes
to a file; stopping, ending and wrong sources.
"""

import csv
import io
import json
import random
import re
import signal
import subprocess
import unittest

from playwright.sync_api import expect
from visiting import FIRST, ROOT, Visiting, ranked, run

SIMULATED = (
    ROOT / "tools/davar-sim",
    ROOT / "data/demo_disturbance.csv.gz",
    "--lsb",
    "0.001",
    "--stride",
    "100",
)


class Live(Visiting):
    def sender(self, *options, simulated=SIMULATED):
        """davar-sim on a pty that waits for a reader, and the pty's name."""
        process = subprocess.Popen(
            [*simulated, *options, "--out", "slcan:pty"],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.addCleanup(process.wait)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        return process, "slcan:" + re.search(r"/dev/\S+", process.stderr.readline())[0].rstrip(":")

    def test_what_is_sent_is_shown_and_kept(self):
        truth = {
            int(row["epoch"]): row
            for row in csv.DictReader(
                io.StringIO(
                    subprocess.run(SIMULATED, text=True, capture_output=True, check=True).stdout
                )
            )
        }
        sender, source = self.sender()
        bench = self.open()
        page = self.page(bench)
        page.fill("#source", source)
        page.click("#listen")
        expect(page.locator("#live-state")).to_contain_text("ended")
        last = max(truth)
        expect(page.locator("#live-epoch")).to_have_text(str(last))
        self.assertEqual(sender.wait(), 0)
        self.assertAlmostEqual(
            float(page.inner_text("#live-arw").split()[1])
            / float(truth[last]["arw_deg_per_sqrt_h"]),
            1,
            delta=1e-3,
        )
        expect(page.locator("#live-surface image")).to_have_count(1)
        self.shot(page, "live")
        shown = bench.ask("live")[1]["rows"]
        self.assertEqual([row["epoch"] for row in shown], sorted(truth)[-len(shown) :])
        self.assertEqual(
            json.loads(page.get_attribute("#live-chart", "data-arw")),
            [row["arw_deg_per_sqrt_h"] for row in shown],
        )
        for row in shown:
            told = truth[row["epoch"]]
            for name in ("window_samples", "arw_deg_per_sqrt_h", "adev_16"):
                self.assertAlmostEqual(
                    row[name] / float(told[name]), 1, delta=1e-5, msg=(name, row["epoch"])
                )
            self.assertAlmostEqual(
                (row["arw_high_deg_per_sqrt_h"] - row["arw_low_deg_per_sqrt_h"])
                / (float(told["arw_high_deg_per_sqrt_h"]) - float(told["arw_low_deg_per_sqrt_h"])),
                1,
                delta=2e-3,
            )
        with open(self.folder / "davarlab-files/live.csv", encoding="ascii") as file:
            self.assertEqual([int(row["epoch"]) for row in csv.DictReader(file)], sorted(truth))
        model = self.folder / "model.toml"
        model.write_text(FIRST.format(rate=10.0, column="gyro_x_dps"))
        done = run(
            "compare", self.folder / "davarlab-files/live.csv", "-m", model
        )  # results, which no command takes for samples
        self.assertEqual(done.returncode, 2)
        self.assertIn("live.csv:1: results of davar-sim or davarlab live", done.stderr)
        page.reload()
        expect(page.locator("#live-epoch")).to_have_text(str(last))
        page.click("#deafen")
        expect(page.locator("#live")).to_be_hidden()
        self.assert_quiet()

    def test_the_allan_curve_grows_to_a_day(self):
        recording, source, walk = self.folder / "days.csv", random.Random(1), 0.0
        lines = ["gyro_z_dps"]
        for _ in range(400_000):  # two days and a half: white noise, from five minutes on a walk
            walk += source.gauss(0, 1.5e-4)
            lines.append(f"{walk + source.gauss(0, 0.05):.5f}")
        recording.write_text("\n".join(lines) + "\n")
        simulated = (
            *(ROOT / "tools/davar-sim", recording, "--rate", "2", "--lsb", "0.0005"),
            *("--stride", "600", "--bandwidth", "none", "--longest-tau", "86400"),
        )
        told = list(
            csv.DictReader(
                io.StringIO(
                    subprocess.run(
                        (*simulated, "--details"), text=True, capture_output=True, check=True
                    ).stdout
                )
            )
        )
        _, source = self.sender("--can-content", "intervals", simulated=simulated)
        bench = self.open()
        page = self.page(bench)
        page.set_viewport_size({"width": 1280, "height": 720})
        page.fill("#source", source)
        page.click("#listen")
        expect(page.locator("#live-state")).to_contain_text("ended")
        self.shot(page, "live-curve")
        sizes = [2**t for t in range(18)]  # to 18 h
        first, last = told[0], told[-1]
        self.assertEqual([m for m in sizes if first[f"adev_{m}"]], [m for m in sizes if m <= 256])
        found = bench.ask("live")[1]["curves"]["0"]
        self.assertEqual(found["m"], sizes)
        self.assertEqual(found["tau_s"], [m / 2 for m in sizes])
        for t, m in enumerate(sizes):
            for name, column in (("adev", "adev"), ("low", "adev_low"), ("high", "adev_high")):
                if found[name][t] is None:  # the last ones have too few differences for a limit
                    self.assertGreater(m, 2**15)
                else:
                    self.assertAlmostEqual(
                        found[name][t] / float(last[f"{column}_{m}"]), 1, delta=2e-3, msg=(name, m)
                    )
        # What is drawn is that, on an axis with all sizes, in units of time.
        there = [i for i, value in enumerate(found["adev"]) if value is not None]
        points = page.locator("#live-curve circle")
        expect(points).to_have_count(len(there))
        for place, i in enumerate(there):
            expect(points.nth(place).locator("title")).to_contain_text(
                "no interval" if found["low"][i] is None else "95 %"
            )
        height = [float(points.nth(place).get_attribute("cy")) for place in range(len(there))]
        for a, b in zip(there, there[1:]):  # a logarithmic axis, upwards
            moved = height[there.index(b)] - height[there.index(a)]
            self.assertEqual(found["adev"][a] > found["adev"][b], moved > 0)
        marks = page.locator("#live-curve .mark").all_text_contents()
        self.assertEqual(marks, ["1 s", "10 s", "1 min", "10 min", "1 h", "6 h"])
        ends = json.loads(page.get_attribute("#live-curve", "data-range"))
        self.assertLess(ends[0], found["tau_s"][0])
        self.assertGreater(ends[1], found["tau_s"][-1])
        expect(page.locator("#live-terms")).to_contain_text("RRW")
        chart = page.locator("#live-chart svg").bounding_box()
        self.assertLessEqual(chart["x"] + chart["width"], 1280)
        for seconds, words in (
            (2e-6, "2 µs"),
            (0.01, "10 ms"),
            (0.9999, "1 s"),
            (59.4, "59.4 s"),
            (60, "1 min"),
            (5400, "1.5 h"),
            (86400, "1 d"),
            (2**31 / 100, "249 d"),
        ):
            self.assertEqual(
                page.evaluate(f"import('/page/words.js').then((m) => m.duration({seconds}))"), words
            )
        with open(self.folder / "davarlab-files/live.csv", encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(told))
        for row, wanted in zip(rows, told):
            for m in sizes:
                name = f"adev_{m}"
                self.assertEqual(bool(row[name]), bool(wanted[name]))
                if row[name]:
                    self.assertAlmostEqual(float(row[name]) / float(wanted[name]), 1, delta=1e-6)
        self.assert_quiet()

    def test_a_change_of_the_noise_is_told(self):
        told = [
            row
            for row in csv.DictReader(
                io.StringIO(
                    subprocess.run(
                        (*SIMULATED, "--policy", "glr"), text=True, capture_output=True, check=True
                    ).stdout
                )
            )
            if row["alarm"] == "1"
        ]
        self.assertGreater(len(told), 1)
        _, source = self.sender("--policy", "glr")
        bench = self.open()
        page = self.page(bench)
        page.fill("#source", source)
        page.click("#listen")
        expect(page.locator("#live-state")).to_contain_text("ended")
        expect(page.locator("#live-changed")).to_contain_text(
            f"noise changed at epoch {told[-1]['epoch']}"
        )
        self.shot(page, "live-changed")
        shown = [row for row in bench.ask("live")[1]["rows"] if row["alarm"]]
        self.assertEqual([row["epoch"] for row in shown], [int(row["epoch"]) for row in told])
        for row, wanted in zip(shown, told):
            self.assertEqual(
                (row["change_m"], row["cut_age_samples"], row["young"]),
                tuple(int(wanted[name]) for name in ("change_m", "cut_age_samples", "young")),
            )
            for name in ("change_older", "change_newer", "change_gain"):
                self.assertAlmostEqual(
                    row[name] / float(wanted[name]), 1, delta=1e-5, msg=(name, row["epoch"])
                )
            self.assertAlmostEqual(row["dispersion"], float(wanted["dispersion"]), delta=0.006)
        self.assertEqual(int(page.get_attribute("#live-chart", "data-alarms")), len(told))

    def test_why_there_is_no_angle_random_walk(self):
        recording, source, smooth = self.folder / "smooth.csv", random.Random(1), 0.0
        lines = ["gyro_z_dps"]
        for _ in range(6000):
            smooth += 0.2 * (source.gauss(0, 1) - smooth)  # a low-pass that nobody declares
            lines.append(f"{smooth:.6f}")
        recording.write_text("\n".join(lines) + "\n")
        simulated = (ROOT / "tools/davar-sim", recording, "--rate", "100", "--stride", "100")
        _, source = self.sender(simulated=simulated)
        bench = self.open()
        page = self.page(bench)
        page.fill("#source", source)
        page.click("#listen")
        expect(page.locator("#live-state")).to_contain_text("ended")
        expect(page.locator("#live-arw")).to_have_text("ARW absent")
        expect(page.locator("#live-why")).to_contain_text("(filtered): the short cluster sizes")
        expect(page.locator("#live-why")).to_contain_text("--bandwidth HZ[:ORDER]")
        self.shot(page, "live-why")
        with open(self.folder / "davarlab-files/live.csv", encoding="ascii") as file:
            self.assertEqual({"filtered"}, {row["arw_withheld"] for row in csv.DictReader(file)})
        self.assert_quiet()

    def test_a_sender_that_goes_on_is_frozen_and_stopped_and_a_wrong_source_is_refused(self):
        bench = self.open()
        for wrong, words in (
            ("can:nosuch0", "can:nosuch0: "),
            ("elsewhere", "can:IFACE, slcan:PATH"),
            ("slcan:/etc/passwd", "slcan:/etc/passwd: "),
        ):
            status, answer = bench.act("listen", source=wrong)
            self.assertEqual(status, 400, answer)
            self.assertIn(words, answer["error"])
        sender, source = self.sender("--pace", "5")
        page = self.page(bench)
        page.fill("#source", source)
        page.click("#listen")
        expect(page.locator("#live-epoch")).to_be_visible()
        page.click("#freeze")
        expect(page.locator("#freeze")).to_have_text("Resume")
        frozen = page.inner_text("#live-epoch")
        for _ in range(2):  # more came to this page
            before = page.get_attribute("#live", "data-count")
            expect(page.locator("#live")).not_to_have_attribute("data-count", before)
        self.assertEqual(page.inner_text("#live-epoch"), frozen)
        page.click("#freeze")
        expect(page.locator("#live-epoch")).not_to_have_text(frozen)
        page.click("#tutorial")  # a recording beside it
        expect(page.locator("#headline h1")).to_be_visible()
        page.click("#tab-live")
        expect(page.locator("#live")).to_be_visible()
        self.assertEqual(
            bench.act("listen", source="elsewhere")[0], 400
        )  # what is listened to goes on
        ended = bench.ask("live")[1]["ended"]
        self.assertTrue(not ended or sender.poll() is not None)
        page.click("#deafen")
        expect(page.locator("#live")).to_be_hidden()
        self.assert_quiet()

    def test_raw_samples_are_frozen_and_diagnosed_while_more_come(self):
        recording = self.folder / "sensor.csv"
        self.assertEqual(
            run("simulate", ROOT / "data/tutorial_sensor.toml", "-o", recording).returncode, 0
        )
        process = subprocess.Popen(
            [
                ROOT / "tools/davar-sim",
                recording,
                "--lsb",
                "0.00001",
                "--stride",
                "600",
                "--raw",
                "--pace",
                "1000",
                "--out",
                "slcan:pty",
            ],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        for end in (process.wait, process.stdout.close, process.stderr.close, process.kill):
            self.addCleanup(end)
        bench = self.open()
        page = self.page(bench)
        page.fill("#source", "slcan:" + re.search(r"/dev/[^\s:]+", process.stderr.readline())[0])
        page.click("#listen")
        while (
            int(
                (page.text_content("#live-epoch") if page.locator("#live-epoch").count() else "0")
                or 0
            )
            < 100000
        ):
            before = page.get_attribute("#live", "data-count") or ""
            expect(page.locator("#live")).not_to_have_attribute("data-count", before)
        page.click("#diagnose")
        expect(page.locator("#headline h1")).to_be_visible()
        ranked(page)  # a diagnosis
        page.click("#tab-live")
        expect(page.locator("#live")).to_be_visible()
        self.shot(page, "frozen")
        frozen = self.folder / "davarlab-files/frozen.csv"
        with open(recording, encoding="ascii") as file:
            truth = [
                float(row["gyro_z_dps"])
                for row in csv.DictReader(line for line in file if not line.startswith("#"))
            ]
        with open(frozen, encoding="ascii") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self.assertGreater(len(rows), 99000)
        for n, row in enumerate(rows):
            self.assertAlmostEqual(float(row["time_s"]), n / 50, delta=1e-6)
            self.assertAlmostEqual(float(row["gyro_x_dps"]), truth[n], delta=0.6e-5)
        done = run("compare", frozen, "-m", ROOT / "data/tutorial_model.toml", "--json")
        self.assertIn("gyro_z_dps", done.stderr)  # a model of another column is told
        self.assertEqual(bench.act("freeze", channel=5)[0], 400)
        self.assert_quiet()

    def test_ending_the_server_while_listening_keeps_what_came(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            _, source = self.sender("--pace", "20")
            bench = self.open()
            self.assertEqual(bench.act("listen", source=source)[0], 200)
            page = self.page(bench)
            expect(page.locator("#live-epoch")).to_be_visible()
            status, text = bench.request("/api/drop?name=live.csv", b"time_s,gyro_z_dps\n")
            self.assertEqual(status, 400, text)
            page.close()
            bench.process.send_signal(number)
            said = bench.process.communicate()[1]
            self.assertEqual(
                (
                    bench.process.returncode,
                    [line for line in said.splitlines() if "the workbench is open" not in line],
                ),
                (0, []),
            )
            with open(self.folder / "davarlab-files/live.csv", encoding="ascii") as file:
                rows = list(csv.DictReader(file))
            self.assertGreater(len(rows), 0)
            self.assertEqual(len({len(row) for row in rows}), 1)


if __name__ == "__main__":
    unittest.main()
