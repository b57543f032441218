"""The page of --report in a real browser, at a desk and in a hand: whole, quiet, fetching nothing, with the verdict that the terminal gives."""

import re
import unittest

from visiting import FIRST, Visiting, run

WARM = '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.02\n'


class StillPage(Visiting):
    def test_a_browser_shows_it_whole_on_a_desk_and_in_a_hand(self):
        model, scenario, recording = (self.folder / name for name in ("model.toml", "scenario.toml", "rec.csv"))
        model.write_text(FIRST.format(rate=50.0, column="gyro_z_dps"))
        scenario.write_text(model.read_text() + WARM + "[simulate]\nseed = 3\nduration_s = 3600\n")
        self.assertEqual(run("simulate", scenario, "-o", recording).returncode, 0)
        for command, words in (("compare", "not adequate"), ("diagnose", "The model lacks temperature")):
            path = self.folder / f"{command}.html"
            self.assertIn(run(command, recording, "-m", model, "--report", path).returncode, (0, 1))
            pictures = len(re.findall(r"<img\b", path.read_text()))
            for width in (1280, 400):
                with self.subTest(command, width=width):
                    context = self.browser.new_context(viewport={"width": width, "height": 900})
                    self.addCleanup(context.close)
                    page, requests = context.new_page(), []
                    page.on("pageerror", lambda error: self.complaints.append(str(error)))
                    page.on("console", lambda message: self.complaints.append(message.text))
                    page.on("request", lambda request, seen=requests: request.url.startswith("data:") or seen.append(request.url))
                    page.goto(path.as_uri())
                    self.assertEqual(requests, [path.as_uri()])
                    self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), width)
                    sizes = page.evaluate("[...document.images].map((one) => (one.complete ? one.naturalWidth * one.naturalHeight : 0))")
                    self.assertEqual(len(sizes), pictures)
                    self.assertGreater(min(sizes), 0)
                    self.assertIn(words, page.inner_text("#verdict"))
                    self.shot(page, f"{command}-{width}")
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
