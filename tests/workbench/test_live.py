"""A sensor on a serial line, watched in the page: what davar-sim sends over a pty is what it writes to a file; stopping, ending and wrong sources."""

import csv
import io
import re
import subprocess
import unittest

from playwright.sync_api import expect
from visiting import ROOT, Visiting

SIMULATED = (ROOT / "tools/davar-sim", ROOT / "data/demo_disturbance.csv.gz", "--lsb", "0.001", "--stride", "100")


class Live(Visiting):
    def sender(self, *options):
        """davar-sim on a pty that waits for a reader, and the pty's name."""
        process = subprocess.Popen([*SIMULATED, *options, "--out", "slcan:pty"], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.wait)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        return process, "slcan:" + re.search(r"/dev/\S+", process.stderr.readline())[0].rstrip(":")

    def test_what_is_sent_is_shown_and_kept(self):
        truth = {int(row["epoch"]): row for row in csv.DictReader(io.StringIO(subprocess.run(
            SIMULATED, text=True, capture_output=True, check=True).stdout))}
        sender, source = self.sender()
        bench = self.open()
        page = self.page(bench)
        page.fill("#source", source)
        page.click("#listen")
        expect(page.locator("#live-state")).to_contain_text("ended")
        last = max(truth)
        expect(page.locator("#live-epoch")).to_have_text(str(last))
        self.assertEqual(sender.wait(), 0)
        self.assertAlmostEqual(float(page.inner_text("#live-arw").split()[1]) / float(truth[last]["arw_deg_per_sqrt_h"]), 1, delta=1e-3)
        expect(page.locator("#live-surface .heatmaplayer image")).to_have_count(1)
        self.shot(page, "live")
        shown = bench.ask("live")[1]["rows"]
        self.assertEqual([row["epoch"] for row in shown], sorted(truth)[-len(shown):])
        self.assertEqual(page.evaluate("document.getElementById('live-chart').data[2].y"), [row["arw_deg_per_sqrt_h"] for row in shown])
        for row in shown:
            told = truth[row["epoch"]]
            for name in ("window_samples", "arw_deg_per_sqrt_h", "adev_16"):
                self.assertAlmostEqual(row[name] / float(told[name]), 1, delta=1e-5, msg=(name, row["epoch"]))
            self.assertAlmostEqual((row["arw_high_deg_per_sqrt_h"] - row["arw_low_deg_per_sqrt_h"])
                                   / (float(told["arw_high_deg_per_sqrt_h"]) - float(told["arw_low_deg_per_sqrt_h"])), 1, delta=2e-3)
        with open(self.folder / "davarlab-files/live.csv", encoding="ascii") as file:
            self.assertEqual([int(row["epoch"]) for row in csv.DictReader(file)], sorted(truth))
        page.reload()
        expect(page.locator("#live-epoch")).to_have_text(str(last))
        page.click("#deafen")
        expect(page.locator("#live")).to_be_hidden()
        self.assert_quiet()

    def test_a_sender_that_goes_on_is_frozen_and_stopped_and_a_wrong_source_is_refused(self):
        bench = self.open()
        for wrong, words in (("can:nosuch0", "can:nosuch0: "), ("elsewhere", "can:IFACE or slcan:PATH"), ("slcan:/etc/passwd", "slcan:/etc/passwd: ")):
            status, answer = bench.act("listen", source=wrong)
            self.assertEqual(status, 400, answer)
            self.assertIn(words, answer["error"])
        _, source = self.sender("--pace", "20")
        page = self.page(bench)
        page.fill("#source", source)
        page.click("#listen")
        expect(page.locator("#live-epoch")).to_be_visible()
        page.click("#freeze")
        expect(page.locator("#freeze")).to_have_text("Go on")
        frozen = page.inner_text("#live-epoch")
        before = len(bench.ask("live")[1]["rows"])
        while len(bench.ask("live")[1]["rows"]) == before:  # more came
            pass
        self.assertEqual(page.inner_text("#live-epoch"), frozen)
        page.click("#freeze")
        expect(page.locator("#live-epoch")).not_to_have_text(frozen)
        page.click("#tutorial")  # a recording beside it
        expect(page.locator("#error-value")).to_be_visible()
        expect(page.locator("#live")).to_be_visible()
        page.click("#deafen")
        expect(page.locator("#live")).to_be_hidden()
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
