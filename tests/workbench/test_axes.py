"""All axes of a recording in one table: each row is what a terminal finds on that axis."""

import json
import unittest

from playwright.sync_api import expect
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


if __name__ == "__main__":
    unittest.main()
