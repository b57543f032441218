"""An effect of one's own, written in the page: checked while it is typed, added, saved, and used in
a terminal by the command that the page shows. A server that others reach runs no code.
"""

import json
import math
import random
import re
import shlex
import subprocess
import unittest

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import ROOT, Visiting, error, flagged, ranked, unfold

WRONG = {
    "import numpy as": "SyntaxError",
    "x = 1": "no Effect in it",
    "while True: pass": "did not return within",
    "raise SystemExit": "SystemExit",
    "raise KeyboardInterrupt": "KeyboardInterrupt",
    "raise type('Mute', (Exception,), {'__str__': lambda self: 1 / 0})": "Mute",
    "raise ValueError('\\ud800')": "ValueError",
}
WHERE = {
    "tau_s": 2.6,
    "ratio": 1.5,
    "frequency_hz": None,
    "start_s": 0,
    "stop_s": 40,
    "column": "motor_deg",
    "correlation": 0.3,
}
TYPED = """import numpy as np
from davarlab.effects.base import Effect, Parameter

calls = []

def bias(recording, shape):
    calls.append(1)
    motor = recording.column("motor_deg")
    {body}
    return np.sin(np.radians(motor))

OWN = Effect(
    kind="{kind}", role="mean", regressor=bias,
    parameters=(Parameter("coefficient", "deg/s", -1e9, 1e9),),
    physics="The bias follows the motor.", signature="",
    confirm="Keep it constant.", needs={needs})
"""
PUMP = """import numpy as np
from davarlab.effects.base import Effect, Parameter

def bias(recording, shape):
    return (recording.time_s % 11) < {seconds}

OWN = Effect(
    kind="pump", role="mean", regressor=bias,
    parameters=(Parameter("coefficient", "deg/s", -1e9, 1e9),),
    physics="A pump.", signature="", confirm="Stop it.")
"""
MARK = "open({!r}, 'w').close()"


def gimbal(path, rows=12000):
    """A gyro whose bias is a sine of the angle of a motor, which turns to and fro at random."""
    rng, angle, lines = random.Random(8), 0.0, ["time_s,gyro_z_dps,motor_deg"]
    for i in range(rows):
        angle += rng.gauss(0, 6)
        bias = 0.06 * math.sin(math.radians(angle))
        lines.append(f"{i / 50:.2f},{rng.gauss(bias, 0.05):.6f},{angle:.3f}")
    path.write_text("\n".join(lines) + "\n")
    return path


def pumped(path, rows=15000):
    """White noise and a pump that shifts the bias for 4 s of every 11."""
    rng, lines = random.Random(3), ["time_s,gyro_z_dps"]
    for i in range(rows):
        bias = 0.05 if (i / 50) % 11 < 4 else 0.0
        lines.append(f"{i / 50:.2f},{rng.gauss(bias, 0.05):.6f}")
    path.write_text("\n".join(lines) + "\n")
    return path


class Own(Visiting):
    def assert_accessible(self, page):
        found = Axe().run(page).response["violations"]
        self.assertEqual([(one["id"], one["nodes"]) for one in found], [])

    def test_an_effect_is_written_checked_added_and_used_in_a_terminal(self):
        recording = gimbal(self.folder / "my rec.csv")
        bench = self.open(recording, terminal=True)
        page = self.page(bench, 1280, 720)
        button = page.locator("#next button.write")
        expect(button).to_be_visible()
        self.shot(page, "own-way")
        button.click()
        said, add = page.locator("#own-said"), page.locator("#own-add")
        expect(said).to_contain_text("own_effect returns 12000 values from ")  # the template works
        expect(add).to_be_enabled()
        template = page.input_value("#own-code")
        self.assertIn("motor_deg", template)
        for width, height, scheme in ((1280, 720, "light"), (390, 844, "dark")):
            page.set_viewport_size({"width": width, "height": height})
            page.emulate_media(color_scheme=scheme)
            self.shot(page, f"own-{width}-{scheme}")
            self.assert_accessible(page)
        page.set_viewport_size({"width": 1280, "height": 720})
        self.assertLessEqual(
            page.locator("#own-add").evaluate("(one) => one.getBoundingClientRect().bottom"), 720
        )
        page.fill("#own-code", template.replace("return recording", "return recording_"))
        expect(said).to_contain_text("Not yet: own_effect: regressor: NameError")
        expect(add).to_be_disabled()
        self.shot(page, "own-wrong")
        written = template.replace(
            'return recording.column("motor_deg")',
            'return np.sin(np.radians(recording.column("motor_deg")))',
        ).replace("own_effect", "gimbal")
        page.fill("#own-code", written)
        expect(said).to_contain_text("✓ gimbal returns 12000 values from -1 to 1")
        self.shot(page, "own-right")
        before = error(page)
        add.click()
        expect(page.locator(".effect[data-kind=gimbal]")).to_be_visible()
        expect(page.locator("#own")).to_be_hidden()
        after = error(page)
        self.assertLess(after, before / 2)
        coefficient = bench.ask("step")[1]["cards"][2]["parameters"][0]
        self.assertTrue(coefficient["low"] < 0.06 < coefficient["high"], coefficient)
        self.assertEqual((self.folder / "my rec.csv.gimbal.py").read_text(), written)
        ranked(page)
        self.shot(page, "own-added")

        page.click("#export")
        commands = page.text_content("#commands")
        command = next(one for one in commands.splitlines() if " compare " in one)
        self.assertIn("--effects", command)
        (self.folder / "model.toml").write_text(self.model(bench))
        program, *words = shlex.split(command)
        told = subprocess.run(
            [ROOT / program, *words, "--json"], cwd=self.folder, capture_output=True, text=True
        )
        self.assertAlmostEqual(json.loads(told.stdout)["error"], after, places=3)

        # what a step uses stays as it is; another recording does not have it
        state = bench.ask("step")[1]["state"]
        changed = {"text": written.replace("np.sin", "np.cos"), "state": state}
        status, answer = self.coded(bench, "add_own", changed)
        self.assertEqual(status, 400)
        self.assertIn("which a step uses", answer)
        self.assertEqual((self.folder / "my rec.csv.gimbal.py").read_text(), written)
        again = bench.ask("all")[1]["again"]
        bench.act("open", path=str(gimbal(self.folder / "other.csv", 2000)))
        self.assertNotIn("--effects", bench.ask("all")[1]["again"])
        bench.act("open", path=str(recording))
        self.assertIn("--effects", bench.ask("all")[1]["again"])
        bench.stop()

        other = self.open()  # started without it: says what to type, which works
        status, answer = other.act("open", path=str(recording))
        self.assertEqual(status, 400)
        self.assertIn(again[again.index("--effects") :], answer["error"])
        fresh = self.open(*shlex.split(again)[2:])
        self.assertEqual(len(fresh.ask("step")[1]["cards"]), 3)
        self.assert_quiet()

    def test_a_pump_is_written_edited_and_gone_from_the_residual(self):
        bench = self.open(pumped(self.folder / "rec.csv"), terminal=True)
        page = self.page(bench, 1280, 577)
        ranked(page)
        self.why_closes(page)
        at = flagged(bench)
        self.assertTrue(any(abs(f * 11 - 1) < 0.1 for f in at), at)
        page.click("#next button.write")  # without unfolding anything
        said, add = page.locator("#own-said"), page.locator("#own-add")
        expect(add).to_be_enabled()
        template = page.input_value("#own-code")
        page.fill("#own-code", "junk")
        page.get_by_role("button", name="Cancel").click()
        page.click("#next button.write")
        self.assertEqual(page.input_value("#own-code"), template)
        tops = "['own', 'own-code'].map((id) => document.getElementById(id).scrollTop)"
        self.assertEqual(page.evaluate(tops), [0, 0])
        page.fill("#own-code", PUMP.format(seconds=3))
        expect(said).to_contain_text("✓ pump returns 15000 values from 0 to 1")
        add.click()
        expect(page.locator(".effect[data-kind=pump]")).to_be_visible()
        self.assertNotEqual(flagged(bench), [])  # of a second that it lacks
        self.edited(page)
        self.assertEqual(flagged(bench), [])
        page.click("#home")
        expect(page.locator("#tutorial")).to_be_visible()
        page.click("#view-plan")
        page.click("#home")
        expect(page.locator("#tutorial")).to_be_visible()
        self.assert_quiet()

    def why_closes(self, page):
        why = page.locator("#why")
        for leave in (
            lambda: page.keyboard.press("Escape"),
            lambda: page.click("#headline h1"),
        ):
            page.click("#why summary")
            expect(why).to_have_attribute("open", "")
            leave()
            expect(why).not_to_have_attribute("open", "")

    def edited(self, page):
        """Another shape for the effect that was added; it replaces the first."""
        unfold(page, "pump")
        page.get_by_role("button", name="Edit").click()
        expect(page.locator("#own-add")).to_be_enabled()
        text = page.input_value("#own-code")
        self.assertEqual(text, PUMP.format(seconds=3).replace('"pump"', '"pump_2"'))
        page.fill("#own-code", text.replace("< 3", "< 4"))
        expect(page.locator("#own-add")).to_be_enabled()
        page.click("#own-add")
        expect(page.locator(".effect[data-kind=pump_2]")).to_be_visible()
        expect(page.locator(".effect[data-kind=pump]")).to_have_count(0)

    def coded(self, bench, what, given, **headers):
        """(status, text) of what runs code, as the page of this server sends it."""
        headers = {"X-Davar-Token": bench.token, "Origin": bench.origin, **headers}
        return bench.request(f"/api/{what}", json.dumps(given).encode(), headers)

    def test_what_is_wrong_is_said_and_an_endless_loop_ends(self):
        bench = self.open(gimbal(self.folder / "rec.csv", 2000), terminal=True)
        for text, words in WRONG.items():
            status, answer = self.coded(bench, "check_own", {"text": text})
            self.assertEqual(status, 200, text)
            self.assertIn(words, json.loads(answer)["error"])
        self.assertEqual(bench.ask("step")[0], 200)  # the worker goes on

    def test_code_neither_changes_the_recording_nor_stops_the_worker(self):
        """Nor does a refused Add leave a file or a kind behind."""
        bench = self.open(gimbal(self.folder / "rec.csv", 2000), terminal=True)
        step, files = bench.ask("step")[1], set(self.folder.iterdir())
        text = TYPED.format(kind="mine", body="motor -= motor.mean()", needs="()")
        status, answer = self.coded(bench, "check_own", {"text": text})
        self.assertIn("read-only", json.loads(answer)["error"])
        for body, needs, words in (
            ("while len(calls) > 1: pass", "()", "did not return within"),
            ("", '("supply_V",)', "needs a column"),
            ("if len(calls) > 1: raise ValueError('late')", "()", "late"),
        ):
            text = TYPED.format(kind="mine", body=body, needs=needs)
            status, answer = self.coded(bench, "add_own", {"text": text, "state": step["state"]})
            self.assertEqual(status, 400, answer)
            self.assertIn(words, answer)
            self.assertEqual(set(self.folder.iterdir()), files)
            self.assertEqual(bench.ask("step")[1], step)  # the worker goes on, the data are as read
        text = TYPED.format(kind="mine", body="", needs="()")
        status, answer = self.coded(bench, "add_own", {"text": text, "state": step["state"]})
        self.assertEqual(status, 200, answer)

    def test_a_server_started_again_goes_on_with_the_effect(self):
        recording = gimbal(self.folder / "rec.csv", 2000)
        bench = self.open(recording, terminal=True)
        texts = [TYPED.format(kind="mine", body=body, needs="()") for body in ("", "pass")]
        state = bench.ask("step")[1]["state"]
        self.assertEqual(self.coded(bench, "add_own", {"text": texts[0], "state": state})[0], 200)
        bench.act("go", number=0)
        bench.stop()
        other = self.open(recording, "--effects", f"{recording}.mine.py", terminal=True)
        given = {"text": texts[0], "state": other.ask("step")[1]["state"]}
        self.assertEqual(self.coded(other, "add_own", given)[0], 200)
        given = {"text": texts[1], "state": other.ask("step")[1]["state"]}
        status, answer = self.coded(other, "add_own", given)
        self.assertEqual((status, "which a step uses" in answer), (400, True), answer)

    def unknown(self, bench):
        """A page on which no known effect explains the misfit."""

        def unexplained(_, found):
            more = {"candidates": [], "nothing": ["", "All were tried."]}
            more["unknown"] = {"where": WHERE, "next": ["Log the motor's current."]}
            return {**found, **more}

        page = self.page(bench, 1280, 720)
        self.altered(page, re.compile("/api/candidates"), unexplained)
        page.reload()
        expect(page.locator("#nothing")).to_contain_text("motor_deg")
        return page

    def test_code_runs_only_for_the_person_at_the_terminal(self):
        recording, mark = gimbal(self.folder / "rec.csv", 2000), self.folder / "ran"
        given = {"text": MARK.format(str(mark))}
        served = self.open(recording)  # by a service, for whoever reaches it
        self.assertEqual(self.coded(served, "check_own", given)[0], 403)
        state = served.ask("step")[1]["state"]
        self.assertEqual(self.coded(served, "add_own", {**given, "state": state})[0], 403)
        self.assertFalse(served.ask("all")[1]["code"])
        page = self.unknown(served)
        expect(page.locator("#next button.write")).to_have_count(0)
        expect(page.locator("#next pre").last).to_contain_text("--effects effect.py")
        self.shot(page, "own-off")
        self.assert_accessible(page)
        page.close()
        served.stop()

        bench = self.open(recording, terminal=True)
        for headers in (
            {"X-Davar-Token": "guessed"},
            {"Origin": "https://elsewhere.example"},
            {"Origin": "null"},
            {"Host": "elsewhere.example"},
            {"X-Forwarded-For": "127.0.0.1"},
            {"Forwarded": "for=10.0.0.7"},
            {"Via": "1.1 proxy"},
        ):
            status, _ = self.coded(bench, "check_own", given, **headers)
            self.assertIn(status, (400, 403), headers)
        status, _ = bench.request("/api/check_own", json.dumps(given).encode())  # no page sent it
        self.assertEqual(status, 403)
        self.assertEqual(bench.request("/api/check_own?text=1")[0], 404)
        self.assertFalse(mark.exists())
        self.assertEqual(self.coded(bench, "check_own", given)[0], 200)
        self.assertTrue(mark.exists())
        page = self.unknown(bench)
        self.shot(page, "own-unknown")
        page.click("#next button.write")
        expect(page.locator("#own-said")).to_contain_text("own_effect returns 2000 values")
        self.assertIn('recording.column("motor_deg")', page.input_value("#own-code"))
        page.get_by_role("button", name="Cancel").click()
        expect(page.locator("#next button.write")).to_be_focused()


if __name__ == "__main__":
    unittest.main()
