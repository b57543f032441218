"""Where a model fails: keys, signs without colour, titles above charts; and the first page fits."""

import unittest

from playwright.sync_api import expect
from visiting import FIRST, Visiting, ranked, run, tab

BURST = (
    '[[effect]]\nkind = "noise_step"\nstart_s = 900.0\nstop_s = 930.0\nratio = 6.0\n'
    "[simulate]\nseed = 5\nduration_s = 2400\n"
)
BOXES = "(all) => all.map((one) => one.getBoundingClientRect().toJSON())"


class Where(Visiting):
    def burst(self):
        """A page on a recording that is loud for 30 s."""
        scenario = self.folder / "scenario.toml"
        scenario.write_text(FIRST.format(rate=50.0, column="gyro_z_dps") + BURST)
        self.assertEqual(run("simulate", scenario, "-o", self.folder / "rec.csv").returncode, 0)
        bench = self.open("rec.csv")
        page = self.page(bench, width=1280, height=720)
        ranked(page)
        return bench, page

    def test_w_goes_to_the_cell_of_the_headline_and_arrows_move_from_it(self):
        bench, page = self.burst()
        named = bench.ask("step")[1]["worst"]
        tab(page, "where")
        page.keyboard.press("w")
        expect(page.locator("#cell-said")).to_contain_text("atio")
        self.assertEqual(float(page.input_value("#from")), named["start_s"])
        self.assertEqual(float(page.input_value("#to")), named["stop_s"])
        said = page.inner_text("#cell b")
        page.locator("#map .hit").nth(40).click()
        expect(page.locator("#cell b")).not_to_have_text(said)
        expect(page.locator("#cell-spectrum svg")).to_be_visible()
        page.locator("#map svg").focus()
        at = [float(page.input_value(f"#{end}")) for end in ("from", "to")]
        page.keyboard.press("ArrowRight")
        expect(page.locator("#from")).to_have_value(f"{at[1]:g}")
        page.keyboard.press("ArrowLeft")
        expect(page.locator("#from")).to_have_value(f"{at[0]:g}")
        self.assertTrue(
            page.locator("#map svg").evaluate("(one) => one === document.activeElement")
        )
        self.signs_differ_without_colour_and_titles_stand_above_charts(page)
        self.assert_quiet()

    def signs_differ_without_colour_and_titles_stand_above_charts(self, page):
        heights = {}
        for fill, height in page.locator("#map .strip rect").evaluate_all(
            "(all) => all.map((one) => [one.getAttribute('fill'), one.getAttribute('height')])"
        ):
            heights.setdefault(fill, set()).add(round(float(height), 2))
        low, high = heights["var(--meas)"], heights["var(--model)"]
        self.assertEqual((len(low), len(high)), (1, 1))
        self.assertAlmostEqual(low.pop() / high.pop(), 2, delta=0.1)
        for place in ("#samples-0", "#cell-spectrum"):
            title = page.locator(f"{place} .ytitle").evaluate_all(BOXES)[0]
            for curve in page.locator(f"{place} svg > g[clip-path]").evaluate_all(BOXES):
                self.assertLessEqual(title["bottom"], curve["top"] + 1, place)
        self.assert_quiet()

    def test_the_first_page_fits_one_screen(self):
        bench = self.open()
        page = self.page(bench, width=1280, height=720)

        def full(_, shown):
            names = [f"recording_{i}.csv" for i in range(4)]
            shown["recent"] = [
                {"path": one, "sensor": None, "name": one, "error": 0.1, "floor": 0.04}
                for one in names
            ]
            shown["sources"] = ["can:can0", "slcan:/dev/ttyUSB0", "slcan:/dev/ttyACM1"]
            return shown

        self.altered(page, "**/api/all*", full)
        page.reload()
        expect(page.locator(".recent")).to_have_count(4)
        for box in page.locator("#landing button:visible, #landing #source").evaluate_all(BOXES):
            self.assertLessEqual(box["bottom"], 720)
        self.assertLessEqual(page.locator(".drop").evaluate("(one) => one.offsetHeight"), 160)
        self.shot(page, "landing-full-1280-light")
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
