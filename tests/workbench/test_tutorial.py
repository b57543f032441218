"""The tutorial's sensor in a real browser: from two effects to an adequate model, back and forth,
through every kind of interruption.
"""

import json
import re
import signal
import tomllib
import unittest

from playwright.sync_api import expect
from visiting import FIRST, ROOT, Visiting, error, export, ranked, run, tab, unfold

FIRST_PAGE = ROOT / "tools/lab/davarlab/workbench/page/tutorial.json"
CLOSE = 0.02  # relative: digits may differ between machines, the story may not


class Tutorial(Visiting):
    def assert_as_on_the_first_page(self, bench):
        """The tutorial that moves on the first page has the numbers of the one that it opens."""
        for number, shown in enumerate(json.loads(FIRST_PAGE.read_text())["steps"]):
            told = bench.ask("step", number=number)[1]
            pairs = [(shown[name], told[name]) for name in ("error", "floor")]
            for name, other in (("tau", "tau_s"), ("measured", "measured"), ("model", "model")):
                pairs += zip(shown[name], told["deviation"][other], strict=True)
            for one, other in pairs:
                self.assertAlmostEqual(one / other, 1, delta=CLOSE, msg=number)

    def test_a_candidate_with_which_the_error_rises_makes_room_for_the_next(self):
        page = self.page(self.open())

        def rising(route, found):
            return {**found, "error": 1.0} if "kind=sinusoid" in route.request.url else found

        self.altered(page, re.compile("/api/ghost"), rising)
        page.click("#tutorial")
        best = page.locator("#next > .best > .candidate")
        expect(best).to_have_attribute("data-kind", "temperature")
        expect(best).to_be_enabled()
        self.assert_quiet()

    def test_a_first_visit_ends_with_an_adequate_model(self):
        bench = self.open()
        page = self.page(bench)
        page.click("#tutorial")
        expect(page.locator("#headline h1")).to_contain_text("off by")
        before = error(page)
        self.assertRegex(page.text_content("#said"), "does not fit")
        ranked(page, "sinusoid")
        page.keyboard.press("w")
        tab(page, "where")
        expect(page.locator("#cell-said")).to_contain_text("proven")
        self.shot(page, "where")
        tab(page, "fit")
        expect(page.locator(".card.best .to")).to_contain_text("→")
        self.shot(page, "before")
        ranked(page).click()
        expect(page.locator(".effect")).to_have_count(3)
        ranked(page, "temperature")
        between = error(page)
        ranked(page, "temperature").click()
        expect(page.locator(".effect")).to_have_count(4)
        expect(page.locator("#head")).to_have_class("head statistical")
        expect(page.locator("#to-held-out")).to_be_visible()
        after = error(page)
        self.assertLess(between, before)
        self.assertLess(after, 1.25 * float(page.text_content("#floor-value")))
        expect(page.locator("#headline h1")).to_have_text("The model fits")
        self.assertEqual(page.locator("button.candidate.go").count(), 0)
        page.keyboard.press("1")  # no card has an effect: the key adds none that is not needed
        page.wait_for_timeout(300)
        self.assertEqual(len(bench.ask("all")[1]["steps"]), 3)
        self.shot(page, "after")
        self.assert_as_on_the_first_page(bench)

        page.keyboard.press("u")
        expect(page.locator(".effect")).to_have_count(3)
        ranked(page)
        self.assertEqual(error(page), between)
        page.keyboard.press("r")
        expect(page.locator(".effect")).to_have_count(4)
        with page.expect_download() as saved:
            export(page, "save")
        model = tomllib.loads(saved.value.path().read_text())
        self.assertEqual(
            [one["kind"] for one in model["effect"]],
            ["angle_random_walk", "bias_instability", "sinusoid", "temperature"],
        )
        self.assertAlmostEqual(model["effect"][2]["frequency_hz"], 0.35, delta=0.001)
        self.assertAlmostEqual(model["effect"][3]["coefficient_dps_per_degC"], 0.012, delta=0.0012)

        self.assertEqual(bench.stop(signal.SIGKILL), -signal.SIGKILL)
        expect(page.locator("#gone")).to_contain_text("tools/davarlab open")
        page.close()
        self.complaints.clear()  # that the server has gone, of which the page speaks itself
        again = self.open(self.folder / "davarlab-files/tutorial_sensor.csv")
        page = self.page(again, width=390, height=844)
        expect(page.locator(".effect")).to_have_count(4)
        self.assertEqual(error(page), after)
        expect(page.locator(".tread")).to_have_count(3)
        self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), 390)
        self.shot(page, "phone")
        self.assert_quiet()

    def test_the_page_says_what_the_terminal_says(self):
        recording, model = self.folder / "rec.csv", self.folder / "first.toml"
        scenario = self.folder / "scenario.toml"
        scenario.write_text(
            FIRST.format(rate=50.0, column="gyro_z_dps")
            + '[[effect]]\nkind = "rate_ramp"\ncoefficient_deg_per_h2 = 40.0\n'
            "[simulate]\nseed = 5\nduration_s = 1800\n"
        )
        self.assertEqual(run("simulate", scenario, "-o", recording).returncode, 0)
        model.write_text(FIRST.format(rate=50.0, column="gyro_z_dps"))
        bench = self.open(recording)
        step = bench.ask("step")[1]
        fitted = json.loads(run("fit", recording, "-m", model, "--json").stdout)
        self.assertEqual(
            [
                [(p["name"], p["value"], p["low"], p["high"]) for p in card["parameters"]]
                for card in step["cards"]
            ],
            [
                [(name, e["value"], e["low"], e["high"]) for name, e in one["parameters"].items()]
                for one in fitted["effects"]
            ],
        )
        self.assertEqual(
            {key: step[key] for key in ("adequacy", "largest_deviation", "shown_to_tau_s")},
            {key: fitted[key] for key in ("adequacy", "largest_deviation", "shown_to_tau_s")},
        )
        told = json.loads(run("diagnose", recording, "-m", model, "--json").stdout)["candidates"]
        shown = bench.ask("candidates")[1]["candidates"]
        self.assertEqual(
            [(one["kind"], one["gain"]) for one in shown[:3]],
            [(one["kind"], one["gain"]) for one in told[:3]],
        )
        self.assertEqual(bench.ask("ghost", place=0)[1]["error"], told[0]["error_after"])

        shown = step["state"]
        # nothing can be compared with a model without noise; what was refused leaves no step behind
        steps = len(bench.ask("all")[1]["steps"])
        self.assertEqual(bench.act("remove", place=1)[0], 200)
        self.assertEqual(
            bench.act("set", place=0, parameters={"coefficient_deg_per_sqrt_h": 0.0})[0], 400
        )
        self.assertEqual(
            bench.act("set", place=0, parameters={"coefficient_deg_per_sqrt_h": 0.5}, state=shown)[
                0
            ],
            409,
        )
        self.assertEqual(bench.act("go", number=0)[0], 200)
        self.assertEqual(len(bench.ask("all")[1]["steps"]), steps + 1)

        # values by hand are judged as `compare` judges them
        given = tomllib.loads(self.model(bench))["effect"][0]["coefficient_deg_per_sqrt_h"] * 1.2
        self.assertEqual(
            bench.act("set", place=0, parameters={"coefficient_deg_per_sqrt_h": given})[0], 200
        )
        step = bench.ask("step")[1]
        model.write_text(self.model(bench))
        compared = json.loads(run("compare", recording, "-m", model, "--json").stdout)
        self.assertAlmostEqual(step["error"], compared["error"], places=9)
        self.assertEqual(step["adequacy"], compared["adequacy"])

    def test_two_tabs_show_one_state_and_a_slider_is_followed(self):
        recording = self.folder / "rec.csv"
        scenario = self.folder / "scenario.toml"
        scenario.write_text(
            FIRST.format(rate=50.0, column="gyro_z_dps")
            + "[simulate]\nseed = 6\nduration_s = 900\n"
        )
        self.assertEqual(run("simulate", scenario, "-o", recording).returncode, 0)
        bench = self.open(recording)
        one, two = self.page(bench), self.page(bench)
        ranked(one), ranked(two)
        slider = one.locator("[data-kind=angle_random_walk] input[type=range]")
        slider.focus()
        slider.press("ArrowRight")
        expect(one.locator("#back")).to_be_visible()
        expect(two.locator("#back")).to_be_visible()
        self.assertEqual(error(one), error(two))
        ranked(one)  # values by hand keep the list
        unfold(one, "bias_instability")
        one.get_by_label("Remove bias instability").click()
        expect(two.locator(".effect.off")).to_have_count(1)
        two.get_by_label("Restore bias instability").click()
        expect(one.locator(".effect.off")).to_have_count(0)
        self.assertEqual(len(bench.ask("all")[1]["steps"]), 4)
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
