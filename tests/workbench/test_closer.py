"""A closer look: stretches alone or cut out against files that hold just that, a lag against the
truth, data sheets against formulas, keys alone.
"""

import json
import math
import unittest

from playwright.sync_api import expect
from visiting import FIRST, Visiting, error, flagged, ranked, run, tab, unfold


def made(folder, effects="", seconds=900, seed=8):
    scenario, recording = folder / "scenario.toml", folder / "rec.csv"
    scenario.write_text(
        FIRST.format(rate=50.0, column="gyro_z_dps")
        + effects
        + f"[simulate]\nseed = {seed}\nduration_s = {seconds}\n"
    )
    done = run("simulate", scenario, "-o", recording)
    assert done.returncode == 0, done.stderr
    return recording


def fit_of(path, folder):
    """What `davarlab fit` says of a file: the values with their intervals, and the judge."""
    model = folder / "first.toml"
    model.write_text(FIRST.format(rate=50.0, column="gyro_z_dps"))
    found = json.loads(run("fit", path, "-m", model, "--json").stdout)
    return [list(one["parameters"].values())[0] for one in found["effects"]], found["adequacy"]


def pointer(page, x, y, finger):
    """A function that moves the mouse or a finger to a place `across` and `up` from (x, y)."""
    touch = page.context.new_cdp_session(page)
    kinds = {"down": "touchStart", "move": "touchMove", "up": "touchEnd"}

    def point(what, up, across=3):
        at = {"x": x + across, "y": y - up}
        if finger:
            places = [] if what == "up" else [at]
            touch.send("Input.dispatchTouchEvent", {"type": kinds[what], "touchPoints": places})
        else:
            page.mouse.move(**at)
            getattr(page.mouse, what)(**at if what == "move" else {})

    return point


# A point of a curve in the window, a fifth of the way along it.
WHERE = """(path) => {
  const at = path.getPointAtLength(path.getTotalLength() / 5).matrixTransform(path.getScreenCTM());
  return [at.x, at.y]; }"""
# The marks of the vertical axis: value, height in the window.
MARKS = """(all) => all.filter((one) => one.getAttribute("text-anchor") === "end")
  .map((one) => [Number(one.textContent), one.getBoundingClientRect().y])
  .filter(([value]) => value > 0)"""
# The highest of the points whose text names a frequency near f.
HIGHEST = """(all, f) => all
  .map((one, i) => [i, parseFloat(one.textContent), Number(one.getAttribute("cy"))])
  .filter(([, hz]) => Math.abs(hz - f) < 0.1 * f).reduce((a, b) => (b[2] <= a[2] ? b : a))[0]"""


class Sights(Visiting):
    def assert_same(self, step, told):
        values, adequacy = told
        for card, one in zip(step["cards"], values, strict=True):
            for name in ("value", "low", "high"):
                self.assertAlmostEqual(card["parameters"][0][name] / one[name], 1, places=6)
        self.assertEqual(step["adequacy"], adequacy)

    def test_a_stretch_alone_is_a_file_of_its_own(self):
        recording = made(self.folder)
        header, *rows = [
            line for line in recording.read_text().splitlines() if not line.startswith("#")
        ]
        part = self.folder / "part.csv"
        part.write_text("\n".join([header, *rows[10000:30000]]) + "\n")
        bench = self.open(recording)
        self.assertEqual(bench.act("sight", alone=[200.0, 600.0])[1]["samples"], 20000)
        self.assert_same(bench.ask("step")[1], fit_of(part, self.folder))

    def test_what_is_cut_out_is_as_if_it_had_been_lost(self):
        recording = made(self.folder)
        header, *rows = [
            line for line in recording.read_text().splitlines() if not line.startswith("#")
        ]
        less = self.folder / "less.csv"
        less.write_text("\n".join([header, *rows[:10000], *rows[12500:]]) + "\n")
        bench = self.open(recording)
        self.assertEqual(bench.act("sight", cut=[[200.0, 250.0]])[1]["gaps"], 1)
        self.assert_same(bench.ask("step")[1], fit_of(less, self.folder))

    def test_sights_keep_their_steps_and_nonsense_is_refused(self):
        recording = made(self.folder)
        bench = self.open(recording)
        before = bench.ask("step")[1]["error"]
        bench.act("sight", alone=[100.0, 400.0])
        for wrong in (
            {"alone": [5.0, 4.0]},
            {"alone": [0.0, 5.0]},
            {"alone": [0.0, 1e9]},
            {"cut": [[-1.0, 5.0]]},
            {"column": "temp_degC"},
            {"cut": [[1.0]]},
            {"cut": [[0.0, 900.0]]},
        ):
            status, answer = bench.act("sight", **wrong)
            self.assertEqual((status, "\n" in answer["error"]), (400, False), wrong)
        everything = bench.ask("all")[1]
        self.assertEqual(
            [one["alone"] for one in everything["sights"] if one["here"]], [[100.0, 400.0]]
        )
        elsewhere = self.open(recording)
        self.assertEqual(elsewhere.act("sight")[0], 200)
        self.assertIn("another process", bench.act("refit")[1]["error"])
        self.assertEqual(elsewhere.act("sight", alone=[100.0, 400.0])[0], 200)
        bench.stop(), elsewhere.stop()
        again = self.open(recording)
        self.assertEqual(again.ask("all")[1]["samples"], 15000)
        again.act("sight")
        self.assertEqual(again.ask("step")[1]["error"], before)


class Looks(Visiting):
    def test_a_lag_brings_the_branches_together_where_it_is_true(self):
        recording = made(
            self.folder,
            '[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.05\nlag_s = 60.0\n',
            3600,
        )
        bench = self.open(recording)

        def scatter(lag_s):
            found = bench.ask("against", column="temp_degC", lag_s=lag_s)[1]
            x, y = found["x"], found["left"]
            mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
            slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum(
                (a - mean_x) ** 2 for a in x
            )
            return sum((b - mean_y - slope * (a - mean_x)) ** 2 for a, b in zip(x, y)) / len(x)

        best = scatter(60.0)
        self.assertGreater(scatter(0.0), 1.3 * best)
        self.assertGreater(scatter(200.0), 1.3 * best)

    def test_a_data_sheet_is_its_formula(self):
        bench = self.open(made(self.folder))
        found = bench.ask("sheet", angle_random_walk=0.6)[1]
        for tau, value in zip(found["tau_s"], found["deviation"]):
            self.assertAlmostEqual(value, 0.6 / 60 / math.sqrt(tau), delta=0.01 * value)
        for given in ({}, {"shocks": 1}, {"angle_random_walk": "much"}, {"angle_random_walk": -1}):
            self.assertEqual(bench.ask("sheet", **given)[0], 400, given)

    def test_a_slider_that_is_held_shows_what_it_will_be(self):
        recording, model = made(self.folder), self.folder / "model.toml"
        model.write_text(
            FIRST.format(rate=50.0, column="gyro_z_dps")
            + '[[effect]]\nkind = "gauss_markov"\nstd_dps = 0.01\ncorrelation_time_s = 5.0\n'
        )
        bench = self.open(recording, "-m", model)
        moved = {"place": 2, "name": "correlation_time_s", "value": 40.0}
        held = bench.ask("preview", **moved)[1]
        self.assertEqual(
            bench.act("set", place=2, parameters={moved["name"]: moved["value"]})[0], 200
        )
        shown = bench.ask("step")[1]["deviation"]
        for name in ("tau_s", "model"):
            self.assertEqual(len(held[name]), len(shown[name]))
            for one, other in zip(held[name], shown[name]):
                self.assertAlmostEqual(one / other, 1, places=9)

    def test_a_curve_is_dragged_to_another_size_with_a_mouse_and_a_finger(self):
        recording = made(self.folder)
        for finger in (False, True):
            bench = self.open(recording)
            page = self.page(
                bench, has_touch=finger, **({"width": 390, "height": 800} if finger else {})
            )
            ranked(page)
            page.locator("#deviation").scroll_into_view_if_needed()
            number, before = (bench.ask("step")[1][name] for name in ("number", "cards"))
            curve = page.locator(".part-hit[data-kind=angle_random_walk]")
            x, y = curve.evaluate(WHERE)
            # a decade of the axis, from two of its marks
            marks = page.locator("#deviation svg > g:first-child text").evaluate_all(MARKS)
            (low, far), (high, near) = marks[0], marks[1]
            decade = abs(near - far) / abs(math.log10(high / low))
            still = page.locator("#deviation path.model").get_attribute("d")
            point = pointer(page, x, y, finger)
            point("down", 0, 0)
            point("move", decade / 6)
            point("move", decade / 3)
            expect(page.locator("#deviation path.model")).not_to_have_attribute("d", still)
            expect(page.locator("#gauge")).to_contain_text("≈")
            point("up", decade / 3)
            expect(page.locator("#back")).to_be_visible()
            after = bench.ask("step")[1]
            self.assertGreater(after["number"], number)
            size = after["cards"][0]["parameters"][0]["value"] / before[0]["parameters"][0]["value"]
            self.assertAlmostEqual(size / 10 ** (1 / 3), 1, delta=0.03, msg=finger)
            bench.act("go", number=number)
            page.close()
            bench.stop()
        self.assert_quiet()

    def test_a_click_on_a_peak_adds_a_line_sharp_or_with_a_width(self):
        line = '[[effect]]\nkind = "{}"\nfrequency_hz = {}\n{}\n'
        bench = self.open(
            made(
                self.folder,
                line.format("narrow_band", 5.0, "half_width_hz = 0.2\nstd_dps = 0.02")
                + line.format("sinusoid", 0.7, "amplitude_dps = 0.02"),
            )
        )
        page = self.page(bench)
        for kind, f_hz, number in (("sinusoid", 0.7, 0), ("narrow_band", 5.0, 1)):
            ranked(page)
            tab(page, "spectrum")
            # the highest point near the line
            point = page.locator("#spectrum circle").evaluate_all(HIGHEST, f_hz)
            page.locator("#spectrum circle").nth(point).click()
            page.locator("#peak button").nth(number).click()
            card = page.locator(f".effect[data-kind={kind}]")
            expect(card).to_be_visible()
            found = {
                p["name"]: p
                for one in bench.ask("step")[1]["cards"]
                if one["kind"] == kind
                for p in one["parameters"]
            }
            self.assertAlmostEqual(
                found["frequency_hz"]["value"] / f_hz,
                1,
                delta=0.01 if kind == "narrow_band" else 1e-4,
            )
        told = json.loads(
            run(
                "fit", self.folder / "rec.csv", "-m", self.folder / "scenario.toml", "--json"
            ).stdout
        )["effects"]
        told = next(one for one in told if one["kind"] == "narrow_band")["parameters"]
        for name in ("half_width_hz", "std_dps"):  # as from the truth
            self.assertAlmostEqual(found[name]["value"] / told[name]["value"], 1, delta=0.01)
        self.assert_quiet()

    def test_the_spectrum_over_time_shows_a_line(self):
        bench = self.open(
            made(
                self.folder,
                '[[effect]]\nkind = "sinusoid"\namplitude_dps = 0.05\nfrequency_hz = 3.0\n',
            )
        )
        for column in ("time_s", "temp_degC"):
            found = bench.ask("spectrogram", column=column)[1]
            loudest = max(range(len(found["f_hz"])), key=lambda row: sum(found["density"][row]))
            self.assertAlmostEqual(math.log(found["f_hz"][loudest] / 3.0), 0, delta=0.15)
            self.assertEqual(found["x"], sorted(found["x"]))
        self.assertAlmostEqual(flagged(bench)[0], 3.0, delta=0.01)
        self.assertEqual(bench.act("line", f_hz=3.0)[0], 200)
        self.assertEqual(flagged(bench), [])  # what is in the model is not in its residual

    def test_every_density_is_that_of_the_noise(self):
        bench = self.open(
            made(self.folder)
        )  # 0.3 deg/sqrt(h) of white noise: 0.005 deg/s/sqrt(Hz) on both sides of 0
        step, near, over = (
            bench.ask("step")[1]["spectrum"],
            bench.ask("stretch", start_s=100.0, stop_s=700.0)[1],
            bench.ask("spectrogram")[1],
        )
        for f, values in (
            (step["f_hz"], step["measured"]),
            (step["f_hz"], step["model"]),
            (near["f_hz"], near["density"]),
            (
                over["f_hz"],
                [math.sqrt(sum(x * x for x in row) / len(row)) for row in over["density"]],
            ),
        ):
            white = [value for place, value in zip(f, values) if place > 5.0]
            self.assertGreater(len(white), 8)
            self.assertAlmostEqual(
                math.sqrt(sum(x * x for x in white) / len(white)) / 0.005, 1, delta=0.05
            )

    def test_the_axes_are_those_of_the_library(self):
        recording = made(self.folder)
        bench = self.open(recording)
        (one,) = bench.ask("axes")[1]["axes"]
        rows = [
            line.split(",")
            for line in recording.read_text().splitlines()
            if not line.startswith("#")
        ]
        x = [float(row[rows[0].index("gyro_z_dps")]) for row in rows[1:]]
        total = [0.0]
        for value in x:
            total.append(total[-1] + value)
        m = 16
        square = [
            (total[i + 2 * m] - 2 * total[i + m] + total[i]) ** 2 for i in range(len(x) - 2 * m + 1)
        ]
        self.assertAlmostEqual(
            one["measured"][4], math.sqrt(sum(square) / len(square) / 2) / m, delta=1e-6
        )

    def test_everything_can_be_done_with_keys(self):
        bench = self.open(
            made(
                self.folder,
                '[[effect]]\nkind = "sinusoid"\namplitude_dps = 0.02\nfrequency_hz = 3.0\n',
            )
        )
        page = self.page(bench)
        ranked(page)
        page.keyboard.press("1")
        expect(page.locator(".effect")).to_have_count(3)
        ranked(page)
        after = error(page)
        page.keyboard.press("u")
        expect(page.locator(".effect")).to_have_count(2)
        ranked(page)
        page.keyboard.press("r")
        expect(page.locator(".effect")).to_have_count(3)
        ranked(page)
        self.assertEqual(error(page), after)
        page.locator("#deviation svg").focus()  # a cell, and its neighbours
        page.keyboard.press("w")
        chosen = page.locator("#deviation svg rect[stroke-width='2.5']")
        place = chosen.get_attribute("x")
        page.keyboard.press("ArrowLeft")
        expect(chosen).not_to_have_attribute("x", place)
        page.keyboard.press("?")
        expect(page.locator("#help")).to_be_visible()
        page.keyboard.press("Escape")
        unfold(page, "sinusoid")
        reached = set()
        for name in ("where", "columns"):
            page.locator("[role=tab][aria-selected=true]").focus()
            while page.get_attribute(f"#tab-{name}", "aria-selected") == "false":
                page.keyboard.press("ArrowRight")
            for _ in range(80):  # once around, with the list of other effects unfolded
                page.keyboard.press("Tab")
                reached.add(
                    page.evaluate("document.activeElement.id || document.activeElement.type")
                )
        self.assertLessEqual(
            {
                "undo",
                "refit",
                "export",
                "axis",
                "range",
                "number",
                "checkbox",
                "alone",
                "cut",
                "against-column",
                "lag",
            },
            reached,
        )
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
