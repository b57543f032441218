"""The page of --report in a real browser, at a desk and in a hand: whole, quiet, fetching nothing,
with the verdict that the terminal gives.
"""

import re
import unittest
from html.parser import HTMLParser

from visiting import FIRST, Visiting, run

WARM = '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.02\n'


class Verdict(HTMLParser):
    """What the file says in its verdict."""

    def __init__(self, page):
        super().__init__()
        self.inside, self.text = "", ""
        self.feed(page)
        self.text = " ".join(self.text.split())

    def handle_starttag(self, tag, attributes):
        if dict(attributes).get("id") == "verdict":
            self.inside = tag

    def handle_endtag(self, tag):
        if tag == self.inside:
            self.inside = ""

    def handle_data(self, data):
        self.text += data if self.inside else ""


class StillPage(Visiting):
    def test_a_browser_shows_it_whole_on_a_desk_and_in_a_hand(self):
        model, scenario = self.folder / "model.toml", self.folder / "scenario.toml"
        model.write_text(FIRST.format(rate=50.0, column="gyro_z_dps"))
        for name, effect, seed in (("clean", "", 3), ("warm", WARM, 3), ("other", WARM, 4)):
            scenario.write_text(
                model.read_text() + effect + f"[simulate]\nseed = {seed}\nduration_s = 3600\n"
            )
            self.assertEqual(
                run("simulate", scenario, "-o", self.folder / f"{name}.csv").returncode, 0
            )
        warm, held_out = (
            self.folder / "warm.csv",
            ("--held-out", self.folder / "other.csv", "-o", self.folder / "better.toml"),
        )
        for command, recording, options, words in (
            ("compare", warm, (), "does not fit"),
            ("diagnose", self.folder / "clean.csv", (), "Nothing is missing"),
            ("diagnose", warm, (), "The model lacks temperature"),
            ("improve", warm, held_out, "The model lacks temperature"),
        ):
            path = self.folder / f"{command}-{recording.stem}.html"
            self.assertIn(
                run(command, recording, "-m", model, "--report", path, *options).returncode, (0, 1)
            )
            charts = len(re.findall(r'class="plot', path.read_text()))
            verdict = Verdict(path.read_text()).text
            for width in (1280, 400):
                with self.subTest(path.name, width=width):
                    context = self.browser.new_context(viewport={"width": width, "height": 900})
                    self.addCleanup(context.close)
                    page, requests = context.new_page(), []
                    page.on("pageerror", lambda error: self.complaints.append(str(error)))
                    page.on("console", lambda message: self.complaints.append(message.text))
                    page.on(
                        "request",
                        lambda request, seen=requests: (
                            request.url.startswith("data:") or seen.append(request.url)
                        ),
                    )
                    page.goto(path.as_uri())
                    self.assertEqual(requests, [path.as_uri()])
                    self.assertEqual(page.evaluate("innerWidth"), width)
                    self.assertLessEqual(
                        page.evaluate("document.documentElement.scrollWidth"), width
                    )
                    self.assertGreater(charts, 3)
                    self.assertEqual(page.locator(".plot > svg").count(), charts)
                    self.assertEqual(" ".join(page.inner_text("#verdict").split()), verdict)
                    self.assertIn(words, verdict)
                    self.shot(page, f"{path.stem}-{width}")
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
