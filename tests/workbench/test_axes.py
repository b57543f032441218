"""All axes of a recording in one table: each row is what a terminal finds on that axis."""

import json
import math
import random
import re
import unittest

from playwright.sync_api import expect
from test_door import flight
from test_stale import two_axes
from visiting import Visiting, ranked, run, tab

MISSING = {"gyro_x_dps": "follows temp_degc", "gyro_z_dps": "line at 1 hz"}


class Axes(Visiting):
    def test_each_row_is_what_a_terminal_finds_and_opens_its_axis(self):
        two_axes(self.folder / "rec.csv")
        bench = self.open("rec.csv")
        page = self.page(bench, width=1280, height=720)
        tab(page, "axes")
        for column in MISSING:
            row = page.locator("#all-axes tr", has=page.locator(f"[data-axis={column}]"))
            expect(row.locator("td.n").first).to_be_visible()
        terminal = json.loads(
            run("fit", "rec.csv", "--axes", "gyro", "--json", cwd=self.folder).stdout
        )
        for column, name in MISSING.items():
            row = page.locator("#all-axes tr", has=page.locator(f"[data-axis={column}]"))
            cells = [text.split("\n")[0] for text in row.locator("td").all_inner_texts()]
            self.assertIn(name, cells[1].lower())
            fitted = terminal["axes"][column]["effects"][0]["parameters"]
            self.assertEqual(
                float(cells[2]), float(f"{fitted['coefficient_deg_per_sqrt_h']['value']:.3g}")
            )
        self.shot(page, "axes-1280-light")
        page.click("[data-axis=gyro_x_dps]")
        expect(page.locator("#tab-fit")).to_have_attribute("aria-selected", "true")
        expect(page.locator("#axis")).to_have_value("gyro_x_dps")
        ranked(page, "temperature").click()  # the row follows the model
        expect(page.locator(".effect")).to_have_count(3)
        tab(page, "axes")
        row = page.locator("#all-axes tr", has=page.locator("[data-axis=gyro_x_dps]"))
        expect(row.locator("td").nth(1)).to_have_text("Nothing")
        self.assert_quiet()

    def test_all_sensors_of_a_log_have_rows_each_and_one_of_another_sensor_opens_it(self):
        sigmas = {"IMU:0": 0.1, "IMU:1": 0.4}
        flight(self.folder / "flight.bin", [*sigmas.values(), 0.2], short=2)
        page = self.page(self.open("flight.bin", "--sensor", "IMU:1"), width=1280, height=720)
        tab(page, "axes")

        def row(sensor, axis):
            name = f"[data-of='{sensor}'][data-axis=gyro_{axis}_dps]"
            return page.locator("#all-axes tr", has=page.locator(name))

        for sensor, sigma in sigmas.items():
            for axis in "xyz":
                cell = row(sensor, axis).locator("td.n").first
                expect(cell).to_be_visible()
                arw = 60 * sigma / math.sqrt(200)
                self.assertAlmostEqual(float(cell.inner_text().split()[0]), arw, delta=0.06 * arw)
        few = page.locator("#all-axes").get_by_text(
            "6 samples; at least 1000 are needed", exact=True
        )
        expect(few).to_have_count(1)
        self.shot(page, "sensors-1280")
        page.locator("[data-of='IMU:0'][data-axis=gyro_x_dps]").click()
        expect(page.locator("#axis")).to_have_value("gyro_x_dps")
        box = page.locator("[data-kind=angle_random_walk] input[type=number]").first
        self.assertAlmostEqual(float(box.input_value()), 60 * 0.1 / math.sqrt(200), delta=0.03)
        tab(page, "axes")
        expect(row("IMU:1", "z").locator("td.n").first).to_be_visible()
        self.assert_quiet()

    def test_an_axis_that_cannot_be_analysed_says_so_in_its_row(self):
        rng, path = random.Random(4), self.folder / "rec.csv"
        rows = [f"{i / 50:.2f},0.25,{rng.gauss(0, 0.05):.6f}" for i in range(2000)]
        path.write_text("\n".join(["time_s,gyro_x_dps,gyro_y_dps", *rows]) + "\n")
        page = self.page(self.open(path))
        tab(page, "axes")
        row = page.locator("#all-axes tr", has=page.locator("[data-axis=gyro_x_dps]"))
        expect(row).to_contain_text("hardly changes")
        expect(page.locator("#error")).to_be_hidden()
        self.assert_quiet()

    def test_numbers_of_a_recording_that_permits_no_model_are_withheld(self):
        """Small rates that are all 0, opened while the spectrum of another recording is shown."""
        two_axes(self.folder / "rec.csv")
        rng, path = random.Random(5), self.folder / "dead.csv"
        lines = ["time_s,gyro_z_dps"]
        for i in range(6000):
            x = rng.gauss(0, 0.05) + 0.02 * math.sin(i / 900)
            lines.append(f"{i / 50:.2f},{0.0 if abs(x) < 0.04 else round(x / 0.0002) * 0.0002:.4f}")
        path.write_text("\n".join(lines) + "\n")
        bench = self.open("rec.csv")
        page = self.page(bench, width=1280, height=720)
        ranked(page)
        tab(page, "spectrum")
        bench.act("open", path=str(path))
        expect(page.locator("#headline")).to_contain_text("not what the sensor measures")
        expect(page.locator("#model .effect").first).to_have_text(re.compile("withheld"))
        expect(page.locator("#spectrum")).to_have_attribute("class", re.compile("plot"))
        expect(page.locator("#error")).to_be_hidden()
        self.shot(page, "withheld")
        tab(page, "axes")
        cell = page.locator("#all-axes tbody td.n").first
        expect(cell).to_have_text("withheld")
        for what in ("toml", "h", "kalibr"):
            status, answer = bench.request(f"/api/save?what={what}")
            self.assertEqual((status, "dead zone" in answer), (400, True), answer)
        page.click("#close")
        expect(page.locator(".recent", has_text="dead.csv")).to_contain_text("–")
        # what the page had asked about the recording before is refused
        self.complaints = [one for one in self.complaints if "409" not in one]
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
