"""What a page still shows while something else is so already: dimmed, dead, and refused by the
server; and what it says when no server answers.
"""

import contextlib
import http.server
import json
import math
import random
import re
import shlex
import signal
import socket
import threading
import time
import unittest
import urllib.parse
from pathlib import Path

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from visiting import FIRST, STATE, Visiting, ranked, run, until

WARM_X, HUM_Z = 0.05, 0.02  # deg/s per degC on x alone, a line of 1 Hz on z alone


def two_axes(path, rows=3000, first_missing=None):
    """A log of two gyro axes, each with a failing of its own; every third sample of its last part
    missing where wanted.
    """
    rng, lines = random.Random(3), ["time_s,gyro_x_dps,gyro_z_dps,temp_degC"]
    for i in range(rows):
        warm = 25 + 5 * math.sin(i / 400)
        if first_missing is None or i < first_missing or i % 3:
            lines.append(
                f"{i / 50:.2f},{rng.gauss(0, 0.05) + WARM_X * (warm - 25):.6f},"
                f"{rng.gauss(0, 0.05) + HUM_Z * math.sin(2 * math.pi * i / 50):.6f},{warm:.3f}"
            )
    path.write_text("\n".join(lines) + "\n")
    return len(lines) - 1


DROP = """() => {
  const given = new DataTransfer();
  given.items.add(new File(["1,2"], "a.csv"));
  document.dispatchEvent(new DragEvent("drop", { dataTransfer: given, cancelable: true }));
}"""


class Line:
    """What lies between a browser and a server: it can be cut, and joined again."""

    def __init__(self, port):
        self.port, self.ends = port, []
        self.door = socket.create_server(("127.0.0.1", 0))
        self.here = self.door.getsockname()[1]
        self.origin = f"http://127.0.0.1:{self.here}"
        threading.Thread(target=self.take, args=(self.door,), daemon=True).start()

    def take(self, door):
        with contextlib.suppress(OSError):
            while True:
                near, far = door.accept()[0], socket.create_connection(("127.0.0.1", self.port))
                self.ends += [near, far]
                for one, other in ((near, far), (far, near)):
                    threading.Thread(target=self.carry, args=(one, other), daemon=True).start()

    @staticmethod
    def carry(one, other):
        with contextlib.suppress(OSError):
            while data := one.recv(1 << 16):
                other.sendall(data)
            other.shutdown(socket.SHUT_WR)

    def cut(self):
        for end in (self.door, *self.ends):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()
        self.ends = []

    def join(self):
        self.door = socket.create_server(("127.0.0.1", self.here))
        threading.Thread(target=self.take, args=(self.door,), daemon=True).start()


class Stale(Visiting):
    def test_while_another_axis_is_computed_nothing_of_the_old_one_can_be_added(self):
        two_axes(self.folder / "rec.csv")
        bench = self.open(self.folder / "rec.csv")
        page, late = self.page(bench), []
        old = ranked(page)
        self.assertEqual(old.inner_text(), "Add")
        kind, shown = old.get_attribute("data-kind"), bench.ask("step")[1]["state"]
        page.route(re.compile("/api/step"), lambda route: late.append(route))
        page.select_option("#axis", "gyro_x_dps")
        until(page, lambda: late)  # the answer is under way, the old list still stands
        expect(old).to_be_visible()
        self.assertTrue(page.evaluate("document.getElementById('bench').inert"))
        self.assertLess(
            float(page.evaluate("getComputedStyle(document.getElementById('bench')).opacity")), 1
        )
        self.shot(page, "stale")
        page.keyboard.press("1")
        page.keyboard.press("w")
        box = old.bounding_box()
        page.mouse.click(box["x"] + 20, box["y"] + 10)
        for name in ("undo", "redo", "export"):
            self.assertTrue(page.locator(f"#{name}").is_disabled(), name)
        page.wait_for_timeout(300)
        self.assertEqual(len(bench.ask("all")[1]["steps"]), 1)
        # what a page sent before it knew is refused, and nothing is added
        for what, more in (
            ("add", {"place": 0, "kind": kind}),
            ("refit", {}),
            ("go", {"number": 0}),
            ("line", {"f_hz": 5.0}),
            ("remove", {"place": 1, "kind": "bias_instability"}),
            (
                "set",
                {
                    "place": 0,
                    "kind": "angle_random_walk",
                    "parameters": {"coefficient_deg_per_sqrt_h": 1.0},
                },
            ),
        ):
            self.assertEqual(bench.act(what, state=shown, **more)[0], 409, what)
        self.assertEqual(bench.request(f"/api/save?what=toml&state={shown}")[0], 409)
        self.assertEqual(len(bench.ask("all")[1]["steps"]), 1)
        for route in late:
            route.continue_()
        page.unroute(re.compile("/api/step"))
        fresh = ranked(page)
        expect(page.locator("#bench")).to_have_js_property("inert", False)
        wanted = fresh.get_attribute("data-kind")
        fresh.click()
        expect(page.locator(".effect")).to_have_count(3)
        self.assertIn(wanted, [card["kind"] for card in bench.ask("step")[1]["cards"]])
        self.assertEqual(bench.ask("all")[1]["column"], "gyro_x_dps")
        self.assert_quiet()

    def test_an_action_says_for_which_state_and_kind_it_is_meant(self):
        two_axes(self.folder / "rec.csv")
        bench = self.open(self.folder / "rec.csv")
        first, second = (one["kind"] for one in bench.ask("candidates")[1]["candidates"][:2])
        for given in ({"place": 0, "kind": second}, {"place": 0, "kind": "nonsense"}):
            self.assertEqual(bench.act("add", **given)[0], 409, given)
        state = bench.ask("step")[1]["state"]
        for given in ({"place": 0}, {"place": 0, "kind": first}, {"place": 0, "state": state}):
            self.assertEqual(bench.request("/api/add", json.dumps(given).encode())[0], 400, given)
        self.assertEqual(len(bench.ask("all")[1]["steps"]), 1)
        self.assertEqual(bench.act("add", place=0, kind=first)[0], 200)
        self.assertEqual(bench.act("go", number=0)[0], 200)
        self.assertEqual(
            bench.ask("step")[1]["state"], state
        )  # who comes back is where the page was

    def test_add_takes_over_the_preview_of_its_card(self):
        two_axes(self.folder / "rec.csv", rows=40000)
        bench = self.open(self.folder / "rec.csv")
        found = bench.ask("candidates")[1]["candidates"]
        slow = next(one for one in found if one["kind"] == "low_pass")  # several fits, seconds
        given = {"place": slow["place"], "kind": slow["kind"]}
        given["state"] = bench.ask("step")[1]["state"]
        seen = []

        def ghost():
            query = urllib.parse.urlencode(given)
            seen.append(json.loads(bench.request(f"/api/ghost?{query}")[1]))

        preview = threading.Thread(target=ghost)
        preview.start()
        time.sleep(0.1)  # it runs, or waits for the worker
        status, _ = bench.request("/api/add", json.dumps(given).encode())
        preview.join()
        self.assertEqual(status, 200)
        self.assertNotIn("superseded", seen[0])
        self.assertEqual(seen[0]["error"], bench.ask("step")[1]["error"])

    def test_a_tab_whose_server_stops_for_a_while_goes_on_by_itself(self):
        two_axes(self.folder / "rec.csv")
        bench = self.open(self.folder / "rec.csv")
        line = Line(int(bench.origin.rsplit(":", 1)[1]))
        self.addCleanup(line.cut)
        bench.address, bench.origin = bench.address.replace(bench.origin, line.origin), line.origin
        page = self.page(bench)
        ranked(page)
        line.cut()
        expect(page.locator("#gone")).to_be_visible()
        self.assertTrue(page.evaluate("document.getElementById('bench').inert"))
        line.join()
        expect(page.locator("#gone")).to_be_hidden()
        expect(page.locator("#bench")).to_have_js_property("inert", False)
        ranked(page).click()
        expect(page.locator(".effect")).to_have_count(3)
        self.complaints.clear()  # that nobody answered

    def test_a_tab_whose_server_was_killed_says_what_is_kept_and_what_to_type(self):
        two_axes(self.folder / "my rec.csv")
        bench = self.open(self.folder / "my rec.csv")
        page = self.page(bench)
        ranked(page).click()
        expect(page.locator(".effect")).to_have_count(3)
        ranked(page)
        bench.stop(signal.SIGKILL)
        gone = page.locator("#gone")
        expect(gone).to_be_visible()
        expect(gone).to_contain_text("The 2 steps are saved in")
        port = bench.origin.rsplit(":", 1)[1]
        command = f"tools/davarlab open '{self.folder}/my rec.csv' --port {port}"
        expect(gone.locator("code")).to_have_text(command)
        self.shot(page, "gone")
        page.keyboard.press("1")
        page.wait_for_timeout(1500)  # it has tried to come back meanwhile
        expect(page.locator("#error")).to_be_hidden()
        self.assertNotIn("nothing is lost", page.inner_text("body"))
        self.assertNotIn("Failed to fetch", page.inner_text("body"))
        self.assertTrue(page.evaluate("document.getElementById('bench').inert"))
        self.assert_accessible(page)
        for arguments in (shlex.split(command)[2:], ["--port", port]):
            again = self.open(*arguments)  # what it says is true, also without the recording
            expect(gone).to_be_hidden()
            expect(page.locator("#bench")).to_have_js_property("inert", False)
            ranked(page)
            self.assertEqual([one["number"] for one in again.ask("all")[1]["steps"]], [0, 1])
            again.stop(signal.SIGKILL)
            expect(gone).to_be_visible()
        self.complaints.clear()  # that nobody answered

    def assert_accessible(self, page):
        found = Axe().run(page).response["violations"]
        self.assertEqual([(one["id"], one["nodes"]) for one in found], [])

    def test_a_tab_gives_its_token_to_no_other_server_on_its_port(self):
        two_axes(self.folder / "rec.csv")
        bench = self.open(self.folder / "rec.csv")
        page = self.page(bench)
        ranked(page)
        bench.stop(signal.SIGKILL)
        expect(page.locator("#gone")).to_be_visible()
        asked = []

        class Thief(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                asked.append(self.path + str(self.headers))
                self.send_response(200)
                self.end_headers()
                self.wfile.write(b"00" * 32)

            do_POST = do_GET

            def log_message(self, *_):
                pass

        port = int(bench.origin.rsplit(":", 1)[1])
        with http.server.ThreadingHTTPServer(("127.0.0.1", port), Thief) as thief:
            threading.Thread(target=thief.serve_forever, daemon=True).start()
            expect(page.locator("#gone")).to_contain_text("Another server uses this address")
            until(page, lambda: len(asked) > 2)
            self.shot(page, "gone-other")
            page.click("#close")
            page.evaluate(DROP)
            page.wait_for_timeout(300)
            thief.shutdown()
        self.assertEqual({one.split("?")[0] for one in asked}, {"/proof"})
        self.assertNotIn(bench.token, "".join(asked))
        (kept,) = Path(STATE.name, "davarlab").glob(f"{port}.token")
        self.assertEqual(kept.parent.stat().st_mode & 0o777, 0o700)
        kept.write_text("x" * 22)  # of a server with another token
        other = self.open("--port", port)
        self.assertNotEqual(other.token, bench.token)
        expect(page.locator("#gone")).to_contain_text("Another server uses this address")
        other.stop()
        kept.write_text(bench.token)
        kept.parent.chmod(0o755)  # others could read it: not taken up
        self.addCleanup(kept.parent.chmod, 0o700)
        self.assertNotEqual(self.open("--port", port).token, bench.token)
        self.complaints.clear()


class Honest(Visiting):
    def test_only_samples_that_are_there_are_counted(self):
        there = two_axes(self.folder / "rec.csv", first_missing=1500)
        bench = self.open(self.folder / "rec.csv")
        shown = bench.ask("all")[1]
        self.assertEqual(
            (there, shown["samples"], shown["missing"]), (2500, 2500, 500 - (2999 % 3 == 0))
        )
        page = self.page(bench)
        (self.folder / "model.toml").write_text(FIRST.format(rate=50.0, column="gyro_z_dps"))
        told = json.loads(
            run(
                "compare",
                self.folder / "rec.csv",
                "-m",
                self.folder / "model.toml",
                "--json",
                "--report",
                self.folder / "r.html",
            ).stdout
        )
        self.assertEqual((told["samples"], told["samples_missing"]), (2500, shown["missing"]))
        self.assertRegex(
            (self.folder / "r.html").read_text(),
            rf'data-key="samples" value="2500.0">2,500</data> samples \({shown["missing"]} '
            r"others are missing\)",
        )
        expect(page.locator("#recording")).to_contain_text(f"{shown['missing']} missing")
        expect(page.locator("#close")).to_have_attribute(
            "title",
            re.compile(rf"2500 samples \({shown['missing']} missing in {shown['gaps']} gaps\)"),
        )

    def test_a_model_that_was_given_has_the_list_and_can_be_fitted(self):
        two_axes(self.folder / "rec.csv")
        (self.folder / "model.toml").write_text(FIRST.format(rate=50.0, column="gyro_z_dps"))
        page = self.page(self.open(self.folder / "rec.csv", "-m", self.folder / "model.toml"))
        ranked(page)  # the list is that of the same effects at their best
        self.shot(page, "given")
        page.click("#refit")
        expect(page.locator(".tread title").last).to_have_text("Fitted")
        ranked(page)
        self.assert_quiet()

    def test_a_log_without_a_sensor_is_not_offered_to_be_read(self):
        rng = random.Random(2)
        (self.folder / "a.csv").write_text(
            "time_s,w\n" + "".join(f"{i / 50:.2f},{rng.gauss(0, 0.5):.5f}\n" for i in range(2000))
        )
        page = self.page(self.open(self.folder / "a.csv"))
        page.select_option("select[data-index='1'][data-key=quantity]", "other")
        expect(page.locator("#no-gyro")).to_be_visible()
        expect(page.locator("#read")).to_be_disabled()
        self.shot(page, "no gyro")
        page.select_option("select[data-index='1'][data-key=quantity]", "gyro")
        expect(page.locator("#read")).to_be_disabled()
        page.select_option("select[data-index='1'][data-key=axis]", "z")
        expect(page.locator("#no-gyro")).to_be_hidden()
        page.click("#read")
        ranked(page)
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
