"""Who does not see well can use the page: axe finds nothing, light and dark, at a desk and on a
phone, at every stage of a visit. The pictures of the stages are in build/workbench.
"""

import unittest

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import Visiting, ranked, tab

BOTTOM = "(one) => one.getBoundingClientRect().bottom"


class Access(Visiting):
    def assert_accessible(self, page, stage):
        found = Axe().run(page).response["violations"]
        self.assertEqual(
            [(one["id"], [node["target"] for node in one["nodes"]]) for one in found], [], stage
        )

    def test_axe_finds_nothing(self):
        bench = self.open()
        for scheme in ("light", "dark"):
            for width, height in ((1440, 900), (1280, 720), (390, 844)):
                page = self.page(bench, width=width, height=height, color_scheme=scheme)

                def stage(name, page=page, size=f"{width}-{scheme}"):
                    self.shot(page, f"{name}-{size}")
                    self.assert_accessible(page, (size, name))

                if bench.ask("all")[1]["recording"] is None:
                    expect(
                        page.locator("#tutorial")
                    ).to_be_visible()  # until the page knows what is open it is empty
                    stage("landing")
                    page.click("#tutorial")
                ranked(page)
                stage("a-model-that-fails")
                page.keyboard.press("w")
                for name in ("where", "spectrum", "columns", "sheet", "held", "live"):
                    tab(page, name)
                    stage(name)
                tab(page, "fit")
                page.click("#export")
                stage("exports")
                page.close()
        self.assert_quiet()

    def test_one_screen_holds_it_and_the_keyboard_is_quick(self):
        bench = self.open()
        page = self.page(bench, width=1280, height=720)
        page.click("#tutorial")
        ranked(page)
        size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
        self.assertEqual(page.evaluate(size), [1280, 720])
        for part in ("#headline", "#gauge", "#deviation", "#staircase", ".card.best", "#model"):
            self.assertLessEqual(page.locator(part).evaluate(BOTTOM), 720, part)
        page.reload()  # from the top of the page; after an action the focus is on the candidate
        ranked(page)
        stops, reached = 0, False
        while stops < 6 and not reached:
            page.keyboard.press("Tab")
            stops += 1
            reached = page.evaluate("document.activeElement.matches('.candidate.go')")
        self.assertTrue(reached, stops)
        page.keyboard.press("Enter")
        expect(page.locator(".effect")).to_have_count(3)
        ranked(page)
        self.assertNotEqual(page.evaluate("document.activeElement.tagName"), "BODY")
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
