"""A log before it is read: what is absurd is doubted at once, lines are skipped, columns get names,
and a log that is too short says what it can and cannot tell.
"""

import json
import random
import shlex
import subprocess
import unittest

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import FIRST, ROOT, Visiting, ranked


class Preview(Visiting):
    def log(self, header, rows=2000, top=(), unit=1.0, step=10):
        """A log with a time in ms, a rate, and a temperature; top: lines above its table."""
        rng, path = random.Random(5), self.folder / "log.csv"
        lines = [*top, *([header] if header else [])]
        lines += [f"{i * step},{rng.gauss(0, 0.05) * unit:.7g},25.{i % 3}" for i in range(rows)]
        path.write_text("\n".join(lines) + "\n")
        return path

    def looked_at(self, page, name):
        """Pictures at a desk in light and on a phone in dark, in which axe finds nothing."""
        for width, height, scheme in ((1280, 720, "light"), (390, 844, "dark")):
            page.set_viewport_size({"width": width, "height": height})
            page.emulate_media(color_scheme=scheme)
            self.shot(page, f"{name}-{width}-{scheme}")
            found = Axe().run(page).response["violations"]
            self.assertEqual([(one["id"], one["nodes"]) for one in found], [], name)
        page.set_viewport_size({"width": 1280, "height": 720})

    def test_absurd_values_are_doubted_before_anything_is_read(self):
        path = self.log("time_ms,gz (deg/s),temp", unit=1e6)
        bench = self.open(path)
        page = self.page(bench, 1280, 720)
        doubts = page.locator("#doubts")
        expect(doubts).to_contain_text("implausible level")
        self.looked_at(page, "import-doubt")
        self.assertIsNone(bench.ask("all")[1]["recording"])
        page.fill("input[data-index='1'][data-key=factor]", "1e-6")
        page.locator("input[data-index='1'][data-key=factor]").blur()
        expect(doubts).to_be_hidden()
        page.click("#read")
        ranked(page)
        arw = bench.ask("step")[1]["cards"][0]["parameters"][0]["value"]
        self.assertAlmostEqual(arw, 0.05 / 10 * 60, delta=0.02)
        self.assert_quiet()

    def test_lines_are_skipped_and_columns_named_and_the_terminal_does_the_same(self):
        top = ["7,1.5,3", "8,1.5,3", "9,2.5,3"]  # numbers, as the table has
        path = self.log("", top=top)
        bench = self.open(path)
        page = self.page(bench, 1280, 720)
        expect(page.locator("tbody tr").first).to_contain_text("7, 8, 9")
        page.fill("#skip", "3")
        page.locator("#skip").blur()
        expect(page.locator("tbody tr").first).to_contain_text("0, 10, 20")
        expect(page.locator("#log-said")).to_contain_text("2000 rows, 3 lines skipped")
        for place, name in enumerate(("time_ms", "gyro_z_dps", "temp_degC")):
            page.locator("input.name").nth(place).fill(name)
        page.click("#names")
        expect(page.locator("#unnamed")).to_have_count(0)
        expect(page.locator("#skip")).to_have_value("3")
        page.click("#read")
        ranked(page)
        step = bench.ask("step")[1]
        (self.folder / "model.toml").write_text(self.model(bench))
        for line in bench.ask("all")[1]["commands"][:2]:  # import, compare
            told = self.typed(line, "--json")
            self.assertLess(told.returncode, 2, told.stderr)
        self.assertAlmostEqual(json.loads(told.stdout)["error"], step["error"], places=4)
        page.close()
        bench.stop()
        self.assertEqual(self.open(path).ask("all")[1]["samples"], 2000)  # the session has it
        self.assert_quiet()

    def test_skipped_lines_stay_skipped_beside_a_given_model(self):
        path = self.log("time_s,gyro_z_dps,temp_degC", top=["# 100 Hz", "a,b,c"], step=0.01)
        model = self.folder / "model.toml"
        model.write_text(FIRST.format(rate=100.0, column="gyro_z_dps"))
        bench = self.open(path, "-m", model, "--skip-lines", 2)
        self.assertEqual(bench.ask("all")[1]["samples"], 2000)

    def test_a_short_log_says_what_it_can_and_cannot_tell(self):
        path = self.log("time_ms,gyro_z_dps,temp_degC", rows=356)
        page = self.page(self.open(path), 1280, 720)
        short = page.locator("#short")
        expect(short).to_contain_text("356 of at least 1000 samples")
        expect(short).to_contain_text("Record at least 10 s")
        expect(page.locator("#facts")).to_contain_text("100 Hz")
        expect(page.locator("#facts")).to_contain_text("deg/√h")
        expect(page.locator("#read")).to_be_disabled()
        self.looked_at(page, "import-short")
        path.write_text(path.read_text().replace("time_ms", "time_s"))  # named as davarlab names
        bench = self.open()
        page = self.page(bench, 1280, 720)
        page.set_input_files("#file", str(path))
        expect(page.locator("#short")).to_be_visible()
        self.assert_quiet()

    def test_an_accelerometer_is_analysed_in_its_own_units(self):
        path, second = self.folder / "accel.csv", self.folder / "second.csv"
        self.accelerometer(path, 7), self.accelerometer(second, 8)
        bench = self.open(path)
        page = self.page(bench, 1280, 720)
        expect(page.locator("#facts")).to_contain_text("VRW of ax (m/s^2)0.12 m/s/√h")
        self.shot(page, "import-accel")
        page.click("#read")
        ranked(page)
        axes = [one.inner_text() for one in page.locator("#axis option").all()]
        self.assertEqual(axes, ["accel_x_g", "accel_y_g", "accel_z_g"])
        model = page.locator("#model")
        expect(model).to_contain_text("VRW")
        expect(model).to_contain_text("m/s/√h")
        expect(model).to_contain_text("µg")
        walk = bench.ask("step")[1]["cards"][0]["parameters"][0]
        self.assertTrue(walk["low"] < 0.12 < walk["high"], walk)
        shown = float(
            page.locator(
                "#model [data-kind=angle_random_walk] input[type=number]"
            ).first.input_value()
        )
        self.assertAlmostEqual(shown, 0.12, delta=0.01)
        for name in ("where", "spectrum", "columns", "sheet", "held", "fit"):
            page.click(f"#tab-{name}")
            expect(page.locator(f"#panel-{name}")).to_have_attribute("aria-busy", "false")
            self.assertNotRegex(
                page.inner_text("#bench"), r"deg/|\bARW\b|force_mps2|angle random", name
            )
            self.shot(page, f"accel-{name}")
        expect(page.locator("#deviation")).to_contain_text("m/s²")
        self.looked_at(page, "accel")

        box = page.locator("#model .effect[data-kind=bias_instability] input[type=number]").first
        box.fill("40")
        box.press("Enter")
        expect(page.locator(".tread title").last).to_contain_text("bias instability")
        size = bench.ask("step")[1]["cards"][1]["parameters"][0]["value"]
        self.assertAlmostEqual(size, 40 * 9.80665e-6 * 3600, places=6)  # m/s/h
        step = bench.ask("step")[1]
        (self.folder / "model.toml").write_text(self.model(bench))
        self.assertIn('kind = "velocity_random_walk"', self.model(bench))
        for line in bench.ask("all")[1]["commands"][:2]:  # import, compare
            told = self.typed(line, "--json")
            self.assertLess(told.returncode, 2, told.stderr)
        self.assertAlmostEqual(json.loads(told.stdout)["error"], step["error"], places=6)
        status, text = bench.request("/api/save?what=h")
        self.assertIn("velocity_random_walk: coefficient_m_per_s_per_sqrt_h = 0.1", text)
        self.assertIn("adev_mps2", text)
        self.assertIn("accelerometer_noise_density", bench.request("/api/save?what=kalibr")[1])
        status, text = bench.request("/api/report")
        self.assertEqual(status, 200)
        self.assertIn("m/s^2", text)
        self.assertNotIn("deg/s", text)

        page.set_input_files("#held-file", second)
        expect(page.locator("#held-out-error")).to_contain_text("floor")
        shown = bench.ask("held_out")[1]
        self.assertLess(shown["error"], 1.5 * shown["floor"])  # of the same noise
        self.assert_quiet()

    @staticmethod
    def accelerometer(path, seed):
        """Writes a recording at rest, 60 s at 100 Hz with a noise of 0.12 m/s/sqrt(h)."""
        rng, rows = random.Random(seed), ["time_ms,ax (m/s^2),ay (m/s^2),az (m/s^2)"]
        for i in range(6000):
            x, y, z = rng.gauss(0, 0.02), rng.gauss(0, 0.02), rng.gauss(9.8, 0.02)
            rows.append(f"{i * 10},{x:.6f},{y:.6f},{z:.6f}")
        path.write_text("\n".join(rows) + "\n")

    def typed(self, line, *more):
        """What a command says, as it is typed."""
        program, *words = shlex.split(line)
        words = [ROOT / program, *words, *more]
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True)
        self.assertLess(done.returncode, 3, done.stderr)
        return done


if __name__ == "__main__":
    unittest.main()
