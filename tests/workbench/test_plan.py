"""The tab with the planner: what it shows is what tools/davar-plan prints for the command line on
the tab; its answers are those for the newest wishes; what is impossible can be relaxed.
"""

import json
import os
import re
import shlex
import stat
import subprocess
import sys
import unittest
import urllib.parse
import zipfile
from unittest import mock

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import ROOT, Visiting, ranked, until

COSTS = (
    "flash_bytes",
    "ram_bytes",
    "stack_bytes",
    "mean_instructions",
    "worst_push_instructions",
)
CORE = "cortex-m4f"
SENSOR = {"sensor": "icm42688@1000", "axes": "3", "core": CORE}
EXAMPLE = {**SENSOR, "respond": "2", "longest_tau": "1200", "ram": "20k", "flash": "24k"}
IMPOSSIBLE = (
    {**EXAMPLE, "ram": "10k"},
    {**EXAMPLE, "flash": "16k"},
    {**EXAMPLE, "ram": "4k", "flash": "14k", "arw_percent": "3"},
    {**SENSOR, "respond": "0.1", "arw_percent": "2"},
    {**SENSOR, "clock": "0.5"},
)
PLANNING = re.compile(r"/api/plan\?")
PROGRAMS = ROOT / "build/tools/tools/plan"
HELD = """#!/bin/sh
while [ -e "$(dirname "$0")/hold" ]; do sleep 0.02; done
exec {program} "$@"
"""
# Text of a bar's cell, its bar's share of the cell.
SHARE = "(cell) => cell.querySelector('i').offsetWidth / cell.querySelector('.bar').offsetWidth"


def typed(command, *more):
    """The command of the tab; the workbench has built what tools/davar-plan builds first."""
    words = [sys.executable, "-B", "-m", "planner", *shlex.split(command)[1:], *more]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "tools/plan")}
    return subprocess.run(words, text=True, capture_output=True, env=environment)


def printed(command):
    """(the report, the JSON) of the command without its files."""
    command = command.removesuffix(" -o setup")
    report, found = typed(command), typed(command, "--json")
    return (report.stdout or report.stderr), json.loads(found.stdout)


class Plan(Visiting):
    def tab(self, bench, wishes=None, **settings):
        """A page at the tab, with these wishes in its address."""
        address, more = bench.address, urllib.parse.urlencode(wishes or {})
        bench.address = f"{address}#plan{f'?{more}' if more else ''}"
        page = self.page(bench, **{"width": 1280, "height": 720, **settings})
        bench.address = address
        self.settled(page)
        return page

    @staticmethod
    def settled(page):
        expect(page.locator("#plan")).to_have_attribute("aria-busy", "false")

    def command(self, page):
        return page.inner_text("#plan-command")

    def costs(self, page, core=CORE):
        """key -> text of its cell."""
        cells = page.locator(f"tr[data-core='{core}'] td[data-key]").all()
        return {cell.get_attribute("data-key"): cell.inner_text().strip() for cell in cells}

    def assert_as_printed(self, page):
        """Whatever the tab shows is what the command prints."""
        report, found = printed(self.command(page))
        said = " ".join(report.split())
        if "impossible" in found:
            self.assertIn("Impossible: ", page.inner_text("#plan-said"))
            for reason in found["impossible"].split("; "):
                self.assertIn(reason, page.inner_text("#plan-found"))
            buttons = 1 if found["together"] else len(found["relax"])
            self.assertEqual(page.locator("#plan-relax button").count(), buttons)
            self.assertEqual(self.costs(page), {})
            return
        self.assertEqual(self.costs(page), {key: str(found[key]) for key in COSTS})
        lines = [page.text_content("#plan-said")]
        lines += page.locator("#plan-gives li").all_text_contents()
        self.assertGreater(len(lines), 2)
        for line in lines:
            self.assertIn(line, said)

    def test_a_moved_slider_changes_bars_and_words(self):
        bench = self.open()
        page = self.page(bench, width=1280, height=720)
        page.click("#view-plan")
        expect(page.locator("#landing")).to_be_hidden()
        self.settled(page)
        self.assert_as_printed(page)
        before, gives = self.costs(page), page.inner_text("#plan-gives")
        page.get_by_label("Longest averaging time").focus()
        for _ in range(8):
            page.keyboard.press("ArrowRight")
        self.settled(page)
        self.assertIn("--longest-tau 120 ", self.command(page))
        expect(page.locator("output[for=plan-longest_tau]")).to_have_text("2 min")
        self.assertGreater(int(self.costs(page)["flash_bytes"]), int(before["flash_bytes"]))
        self.assertNotEqual(page.inner_text("#plan-gives"), gives)
        self.assert_as_printed(page)
        self.assert_quiet()

    def test_a_bar_is_a_share_of_its_limit(self):
        page = self.tab(self.open(), EXAMPLE)
        self.assert_as_printed(page)
        for key, limit in (("flash_bytes", 24576), ("ram_bytes", 20480)):
            cell = page.locator(f"tr[data-core='{CORE}'] td[data-key={key}]")
            share = int(self.costs(page)[key]) / limit
            self.assertAlmostEqual(cell.evaluate(SHARE), share, delta=0.02)
            expect(page.locator(f"th[data-key={key}]")).to_contain_text(f"of {limit}")
        self.assert_quiet()

    def test_the_row_of_a_core_is_what_the_command_prints_for_it(self):
        page = self.tab(self.open(), EXAMPLE)
        command = self.command(page)
        for row in page.locator("tr[data-core]").all():
            core = row.get_attribute("data-core")
            found = printed(command.replace(f"--core {CORE}", f"--core {core}"))[1]
            expected = {} if "impossible" in found else {key: str(found[key]) for key in COSTS}
            self.assertEqual(self.costs(page, core), expected, core)
        last = page.locator("tr[data-core] input").last
        last.check()
        self.settled(page)
        self.assertIn(f"--core {last.get_attribute('value')} ", self.command(page))
        self.assert_quiet()

    def test_what_is_impossible_names_the_reason_and_each_relaxation_helps(self):
        bench = self.open()
        for wishes in IMPOSSIBLE:
            page = self.tab(bench, wishes)
            self.assert_as_printed(page)
            buttons = page.locator("#plan-relax button").count()
            self.assertGreater(buttons, 0, wishes)
            page.close()
            for place in range(buttons):
                page = self.tab(bench, wishes)
                text = page.locator("#plan-relax button").nth(place).inner_text()
                page.locator("#plan-relax button").nth(place).click()
                expect(page.locator("#plan-gives")).to_be_visible()
                self.settled(page)
                self.assert_as_printed(page)
                shown = page.locator("#plan-wishes output").all_inner_texts()
                inputs = page.locator("#plan-wishes input").evaluate_all(
                    "all => all.map((one) => one.value)"
                )
                for one in text.split(" and "):
                    self.assertIn(one.split(": ")[1], shown + inputs, text)
                page.close()
        self.assert_quiet()

    def test_the_download_has_the_files_of_the_command(self):
        page = self.tab(self.open(), EXAMPLE)
        with page.expect_download() as saved:
            page.click("#plan-files")
        program, *words = shlex.split(self.command(page))
        done = subprocess.run([ROOT / program, *words], cwd=self.folder, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        written = {path.name: path.read_text() for path in (self.folder / "setup").iterdir()}
        self.assertIn("davar_setup.c", written)
        with zipfile.ZipFile(saved.value.path()) as archive:
            loaded = {
                name.removeprefix("setup/"): archive.read(name).decode()
                for name in archive.namelist()
            }
        self.assertEqual(loaded, written)
        self.assert_quiet()

    def test_the_command_is_copied(self):
        page = self.tab(self.open(), EXAMPLE, permissions=["clipboard-read", "clipboard-write"])
        page.click("#plan-copy")
        expect(page.locator("#plan-copy")).to_have_text("Copied")
        self.assertEqual(
            page.evaluate("navigator.clipboard.readText()"),
            self.command(page),
        )
        self.assert_quiet()

    def test_an_answer_that_comes_late_is_dropped(self):
        page, held = self.tab(self.open(), SENSOR), []
        page.route(PLANNING, lambda route: held.append(route))
        slider = page.get_by_label("Respond within")
        slider.focus()
        for _ in range(6):
            page.keyboard.press("ArrowRight")
        until(page, lambda: len(held) == 2)  # no more at once; those between are not sent at all
        expect(page.locator("#plan-found")).to_have_js_property("inert", True)
        opacity = "getComputedStyle(document.getElementById('plan-found')).opacity"
        until(page, lambda: float(page.evaluate(opacity)) < 1)
        expect(page.locator("output[for=plan-respond]")).to_have_text("1 s")  # nothing freezes
        asked = [urllib.parse.parse_qs(route.request.url)["respond"] for route in held]
        self.assertEqual(asked, [["0.1"], ["0.2"]])
        held[1].continue_()
        expect(page.locator("#plan-command")).to_contain_text("--respond 0.2 ")
        until(page, lambda: len(held) == 3)
        held[0].continue_()
        page.wait_for_timeout(500)
        self.assertIn("--respond 0.2 ", self.command(page))
        expect(page.locator("#plan")).to_have_attribute("aria-busy", "true")
        held[2].continue_()
        expect(page.locator("#plan-command")).to_contain_text("--respond 1 ")
        self.settled(page)
        expect(page.locator("#plan-found")).to_have_js_property("inert", False)
        self.assertEqual(len(held), 3)
        self.assert_quiet()

    def test_a_planner_that_computes_for_long_holds_nothing_up(self):
        bench = None
        for name in ("davar-plan", "davar-promise"):
            program = self.folder / name
            program.write_text(HELD.format(program=shlex.quote(str(PROGRAMS / name))))
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
        hold = self.folder / "hold"
        hold.touch()
        self.addCleanup(lambda: hold.unlink(missing_ok=True))
        with mock.patch.dict(os.environ, DAVAR_PLAN=str(self.folder / "davar-plan")):
            bench = self.open()
        page = self.page(bench)
        page.click("#view-plan")
        expect(page.locator("#plan")).to_have_attribute("aria-busy", "true")
        page.get_by_label("RAM limit").focus()
        page.keyboard.press("ArrowLeft")
        expect(page.locator("output[for=plan-ram]")).to_have_text("512k")
        page.click("#view-model")
        page.click("#tutorial")  # a fit
        ranked(page)
        self.assertEqual(bench.ask("all")[0], 200)
        page.click("#tab-plan")
        hold.unlink()
        self.settled(page)
        self.assert_as_printed(page)
        self.assert_quiet()

    def test_a_missing_planner_is_named(self):
        with mock.patch.dict(os.environ, DAVAR_PLAN=str(self.folder / "davar-plan")):
            bench = self.open()
        page = self.page(bench)
        page.click("#view-plan")
        expect(page.locator("#plan-missing")).to_contain_text(str(self.folder / "davar-plan"))
        expect(page.locator("#plan-missing")).to_contain_text("gcc")
        status, answer = bench.ask("plan", **SENSOR)
        self.assertEqual((status, "davar-plan" in answer["error"]), (400, True))
        self.assert_quiet()

    def test_a_wrong_value_is_named_and_no_old_cost_stays(self):
        bench = self.open()
        page = self.tab(bench, {**SENSOR, "sensor": "lsm6dso@416"})
        self.assert_as_printed(page)
        page.fill("#plan-rate", "417")
        page.locator("#plan-rate").blur()
        expect(page.locator("#plan-said")).to_contain_text("--sensor")
        self.assertEqual(self.costs(page), {})
        page.select_option("#plan-gyro", "")
        page.fill("#plan-rate", "1000")
        page.locator("#plan-rate").blur()
        for option, text in (("#plan-lsb", "0.05"), ("#plan-bandwidth", "33:2")):
            page.fill(option, text)
            page.locator(option).blur()
        expect(page.locator("#plan-command")).to_contain_text("--lsb 0.05 --bandwidth 33:2")
        self.settled(page)
        self.assert_as_printed(page)
        for given in (
            {"core": CORE},
            {**SENSOR, "core": "z80"},
            {**SENSOR, "respond": "--json"},
            {**SENSOR, "ram": "1e99"},
        ):
            status, answer = bench.ask("plan", **given)
            self.assertEqual((status, answer["error"][:2]), (400, "--"), answer)
        self.assertEqual(bench.ask("plan", **SENSOR, o="/tmp/x")[0], 400)
        self.assertEqual(bench.ask("setup", **IMPOSSIBLE[0])[0], 400)
        self.complaints = [one for one in self.complaints if "400" not in one]
        self.assert_quiet()

    def test_the_gyro_of_the_open_recording_is_planned_for(self):
        bench = self.open()
        page = self.page(bench)
        page.click("#tutorial")
        expect(page.locator("#headline h1")).to_be_visible()
        page.click("#tab-plan")
        for _ in range(2):
            expect(page.locator("#plan-rate")).to_have_value("50")
            arw = float(page.input_value("#plan-noise"))
            self.assertAlmostEqual(arw, 0.3, delta=0.003)  # deg/sqrt(h), of the simulated sensor
            page.select_option("#plan-gyro", index=0)  # another gyro, and back
            page.select_option("#plan-gyro", "")
        self.assert_quiet()

    def test_keys_of_the_model_do_nothing_here_and_its_charts_come_back_whole(self):
        bench = self.open()
        bench.act("tutorial")
        page = self.tab(bench)
        expect(page.locator("#undo")).to_be_hidden()
        page.keyboard.press("1")
        page.keyboard.press("f")
        page.wait_for_timeout(300)
        self.assertEqual(len(bench.ask("all")[1]["steps"]), 1)
        page.click("#view-model")
        ranked(page)
        width = "document.querySelector('#deviation svg').getBoundingClientRect().width"
        room = "document.querySelector('#deviation').getBoundingClientRect().width"
        until(page, lambda: abs(page.evaluate(width) - page.evaluate(room)) < 2)
        self.assert_quiet()

    def test_axe_finds_nothing_and_nothing_scrolls_on_a_small_desk(self):
        bench = self.open()
        for scheme in ("light", "dark"):
            for width, height in ((1280, 720), (390, 800)):
                for name, wishes in (("plan", EXAMPLE), ("impossible", IMPOSSIBLE[0])):
                    page = self.tab(bench, wishes, width=width, height=height, color_scheme=scheme)
                    self.shot(page, f"{name}-{width}-{scheme}")
                    found = Axe().run(page).response["violations"]
                    self.assertEqual([one["id"] for one in found], [], (scheme, width, name))
                    size = page.evaluate(
                        "[document.documentElement.scrollWidth, "
                        "document.documentElement.scrollHeight]"
                    )
                    self.assertLessEqual(size[0], width)
                    if width == 1280:
                        self.assertLessEqual(size[1], height)
                    page.close()
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
