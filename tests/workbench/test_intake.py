"""A log before it is read: what is absurd is doubted at once, lines are skipped, columns get names,
and a log that is too short says what it can and cannot tell.
"""

import json
import random
import shlex
import subprocess
import unittest

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import ROOT, Visiting, ranked


class Preview(Visiting):
    def log(self, header, rows=2000, top=(), unit=1.0, step=10):
        """A log with a time in ms, a rate, and a temperature; top: lines above its table."""
        rng, path = random.Random(5), self.folder / "log.csv"
        lines = [*top, *([header] if header else [])]
        lines += [f"{i * step},{rng.gauss(0, 0.05) * unit:.7g},25.{i % 3}" for i in range(rows)]
        path.write_text("\n".join(lines) + "\n")
        return path

    def looked_at(self, page, name):
        """Pictures at a desk and on a phone, light and dark, in which axe finds nothing."""
        for width, height in ((1280, 720), (390, 844)):
            page.set_viewport_size({"width": width, "height": height})
            for scheme in ("light", "dark"):
                page.emulate_media(color_scheme=scheme)
                self.shot(page, f"{name}-{width}-{scheme}")
                found = Axe().run(page).response["violations"]
                self.assertEqual([(one["id"], one["nodes"]) for one in found], [], name)
        page.set_viewport_size({"width": 1280, "height": 720})

    def test_absurd_values_are_doubted_before_anything_is_read(self):
        path = self.log("time_ms,gz (deg/s),temp", unit=1e6)
        bench = self.open(path)
        page = self.page(bench, 1280, 720)
        doubts = page.locator("#doubts")
        expect(doubts).to_contain_text("implausible level")
        self.looked_at(page, "import-doubt")
        self.assertIsNone(bench.ask("all")[1]["recording"])
        page.fill("input[data-index='1'][data-key=factor]", "1e-6")
        page.locator("input[data-index='1'][data-key=factor]").blur()
        expect(doubts).to_be_hidden()
        page.click("#read")
        ranked(page)
        arw = bench.ask("step")[1]["cards"][0]["parameters"][0]["value"]
        self.assertAlmostEqual(arw, 0.05 / 10 * 60, delta=0.02)
        self.assert_quiet()

    def test_lines_are_skipped_and_columns_named_and_the_terminal_does_the_same(self):
        top = ["7,1.5,3", "8,1.5,3", "9,2.5,3"]  # numbers, as the table has
        path = self.log("", top=top)
        bench = self.open(path)
        page = self.page(bench, 1280, 720)
        expect(page.locator("tbody tr").first).to_contain_text("7, 8, 9")
        page.fill("#skip", "3")
        page.locator("#skip").blur()
        expect(page.locator("tbody tr").first).to_contain_text("0, 10, 20")
        expect(page.locator("#log-said")).to_contain_text("2000 rows, 3 lines skipped")
        for place, name in enumerate(("time_ms", "gyro_z_dps", "temp_degC")):
            page.locator("input.name").nth(place).fill(name)
        page.click("#names")
        expect(page.locator("#unnamed")).to_have_count(0)
        expect(page.locator("#skip")).to_have_value("3")
        page.click("#read")
        ranked(page)
        step = bench.ask("step")[1]
        (self.folder / "model.toml").write_text(step["text"])
        for line in bench.ask("all")[1]["commands"][:2]:  # import, compare
            program, *words = shlex.split(line)
            told = subprocess.run(
                [ROOT / program, *words, "--json"], cwd=self.folder, capture_output=True, text=True
            )
            self.assertIn(told.returncode, (0, 1), told.stderr)
        self.assertAlmostEqual(json.loads(told.stdout)["error"], step["error"], places=4)
        page.close()
        bench.stop()
        self.assertEqual(self.open(path).ask("all")[1]["samples"], 2000)  # the session has it
        self.assert_quiet()

    def test_a_short_log_says_what_it_can_and_cannot_tell(self):
        path = self.log("time_ms,gyro_z_dps,temp_degC", rows=356)
        page = self.page(self.open(path), 1280, 720)
        short = page.locator("#short")
        expect(short).to_contain_text("356 of at least 1000 samples")
        expect(short).to_contain_text("Record at least 10 s")
        expect(page.locator("#facts")).to_contain_text("100 Hz")
        expect(page.locator("#facts")).to_contain_text("deg/√h")
        expect(page.locator("#read")).to_be_disabled()
        self.looked_at(page, "import-short")
        path.write_text(path.read_text().replace("time_ms", "time_s"))  # named as davarlab names
        bench = self.open()
        page = self.page(bench, 1280, 720)
        page.set_input_files("#file", str(path))
        expect(page.locator("#short")).to_be_visible()
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
