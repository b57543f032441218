"""Who does not see well can use the page: axe finds nothing in any state, light and dark, at a desk
and on a phone. One visit goes through all states; their pictures are in build/gallery, to be looked
at.
"""

import math
import random
import signal
import unittest

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import ROOT, Visiting, export, ranked, tab

BOTTOM = "(one) => one.getBoundingClientRect().bottom"
DRAWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
GALLERY = ROOT / "build/gallery"
SCREENS = [
    (width, height, scheme)
    for width, height in ((1440, 900), (1280, 720), (390, 844))
    for scheme in ("light", "dark")
]
CHECKED = ((1280, "light"), (1280, "dark"), (390, "light"))  # by axe; each run takes a second
SAMPLES, RATE_HZ = 6000, 50


def log(path, header, *signals, step=1 / RATE_HZ):
    """A log of noise and signals: a function of the sample each."""
    rng = random.Random(3)
    rows = [
        ",".join([f"{i * step:.6f}", *(f"{rng.gauss(0, 0.05) + one(i):.6f}" for one in signals)])
        for i in range(SAMPLES)
    ]
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def drifts_and_hums(i):
    return 0.1 * math.sin(i / 700) + 0.05 * math.sin(2 * math.pi * i / RATE_HZ)


def walks_squared():
    """A course that no known effect has."""
    rng, course = random.Random(5), [0.0]
    while len(course) < SAMPLES:
        course.append(course[-1] + rng.gauss(0, 0.02))
    return lambda i: 0.1 * course[i] ** 2


class Access(Visiting):
    def stage(self, page, name):
        """Looks at a state on every screen."""
        for width, height, scheme in SCREENS:
            page.set_viewport_size({"width": width, "height": height})
            page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
            page.evaluate(DRAWN)
            page.screenshot(
                path=str(GALLERY / f"{name}-{width}-{scheme}.png"),
                full_page=width < 400 or name == "report",
            )
            if (width, scheme) in CHECKED:
                found = Axe().run(page).response["violations"]
                wrong = [(one["id"], [node["target"] for node in one["nodes"]]) for one in found]
                self.assertEqual(wrong, [], (name, width, scheme))

    def drop(self, page, path):
        page.set_input_files("#file", path)

    def close(self, page):
        page.click("#close")
        expect(page.locator("#tutorial")).to_be_visible()

    def test_axe_finds_nothing_in_any_state(self):
        GALLERY.mkdir(parents=True, exist_ok=True)
        bench = self.open()
        page = self.page(bench, reduced_motion="reduce")
        expect(page.locator("#tutorial")).to_be_visible()
        self.stage(page, "landing")
        self.before_reading(page)
        self.a_model_grows(page)
        self.nothing_is_certain(page)
        self.assert_quiet()
        bench.stop(signal.SIGKILL)
        expect(page.locator("#gone")).to_be_visible()
        self.stage(page, "killed")

    def before_reading(self, page):
        flat = log(self.folder / "foreign.csv", "t,wx,wy", drifts_and_hums, lambda i: 0)
        self.drop(page, flat)
        expect(page.locator("#read")).to_be_visible()
        self.stage(page, "preview")
        page.get_by_text("Another file").click()
        expect(page.locator("#tutorial")).to_be_visible()
        late = log(self.folder / "late.csv", "time_s,gyro_x_dps", lambda i: 0, step=10000)
        self.drop(page, late)
        expect(page.locator("#doubts")).to_be_visible()
        self.stage(page, "doubtful")
        page.get_by_text("Another file").click()
        expect(page.locator("#tutorial")).to_be_visible()

    def a_model_grows(self, page):
        page.route("**/api/candidates*", lambda route: None)
        heat = lambda i: 20 + 10 * math.sin(i / 700)  # noqa: E731
        path = log(
            self.folder / "sensor.csv",
            "time_s,gyro_x_dps,gyro_z_dps,temp_degC",
            drifts_and_hums,
            lambda i: 0,
            heat,
        )
        self.drop(page, path)
        expect(page.locator("#trying")).to_be_visible()
        page.select_option("#axis", "gyro_x_dps")
        expect(page.locator("#headline-strong")).to_contain_text("×")
        expect(page.locator("#trying")).to_be_visible()
        self.stage(page, "fitting")
        page.unroute("**/api/candidates*")  # lets them go
        ranked(page)
        self.stage(page, "cards")
        page.keyboard.press("w")
        for name in ("where", "spectrum", "columns", "sheet", "held", "live"):
            tab(page, name)
            self.stage(page, name)
        tab(page, "axes")
        expect(page.locator("#all-axes td.n")).to_have_count(4)
        self.stage(page, "axes")
        page.click("#tab-plan")
        expect(page.locator("#plan")).to_have_attribute("aria-busy", "false")
        self.stage(page, "plan")
        page.click("#view-model")
        tab(page, "fit")
        page.click("#export")
        self.stage(page, "exports")
        page.keyboard.press("Escape")
        ranked(page).click()
        expect(page.locator(".effect")).to_have_count(3)
        ranked(page)
        self.stage(page, "added")
        ranked(page).click()
        expect(page.locator("#to-held-out")).to_be_visible()
        self.stage(page, "adequate")
        with page.expect_download() as saved:
            export(page, "report")
        self.report(saved.value.path())
        self.close(page)

    def report(self, path):
        (self.folder / "report.html").write_bytes(path.read_bytes())
        page = self.browser.new_context().new_page()
        page.goto((self.folder / "report.html").as_uri())
        self.stage(page, "report")
        page.context.close()

    def nothing_is_certain(self, page):
        odd = log(self.folder / "odd.csv", "time_s,gyro_x_dps", walks_squared())
        self.drop(page, odd)
        ranked(page).click()
        expect(page.locator("#next .unknown")).to_be_visible()
        self.stage(page, "unknown")
        self.close(page)
        dead = log(self.folder / "dead.csv", "time_s,gyro_x_dps", lambda i: 0)
        head, *rows = dead.read_text().splitlines()
        kept = [
            row if abs(float(row.split(",")[1])) > 0.07 else f"{row.split(',')[0]},0"
            for row in rows
        ]
        dead.write_text("\n".join([head, *kept]) + "\n")
        self.drop(page, dead)
        expect(page.locator("#nothing")).to_be_visible()
        self.stage(page, "useless")

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
