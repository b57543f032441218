"""Who does not see well can use the page: axe finds nothing, light and dark, at a desk and on a
phone, at every stage of a visit.
"""

import unittest

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import Visiting, ranked


class Access(Visiting):
    def assert_accessible(self, page, stage):
        found = Axe().run(page).response["violations"]
        self.assertEqual(
            [(one["id"], [node["target"] for node in one["nodes"]]) for one in found], [], stage
        )

    def test_axe_finds_nothing(self):
        bench = self.open()
        for scheme in ("light", "dark"):
            for width in (1400, 390):
                page = self.page(bench, width=width, color_scheme=scheme)
                if bench.ask("all")[1]["recording"] is None:
                    expect(
                        page.locator("#tutorial")
                    ).to_be_visible()  # until the page knows what is open it is empty
                    self.assert_accessible(page, (scheme, width, "landing"))
                    page.click("#tutorial")
                ranked(page)
                self.assert_accessible(page, (scheme, width, "a model that fails"))
                page.keyboard.press("w")
                expect(page.locator("#cell-spectrum .main-svg").first).to_be_visible()
                self.assert_accessible(page, (scheme, width, "a cell"))
                page.close()
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
