"""Everything stays on this machine: every control of every live screen is clicked; requests to
foreign origins and popups are counted. Reports fetch nothing: tests/lab/test_report.py.
"""

import socketserver
import threading
import unittest

from playwright.sync_api import expect
from test_door import NAMES, flight, log
from visiting import FIRST, Visiting, ranked, run, until

# Everything that a person can click. What is there twice (the buttons of a row, the steps) is one
# control: its name without its numbers.
CONTROLS = """() => {
  const name = (one) => [one.closest(".plot")?.id || "", one.tagName, one.id,
    one.dataset.kind || one.dataset.key || one.getAttribute("aria-label") || one.textContent]
    .join("|").replace(/[0-9.]+/g, "#");
  const found = new Map();
  for (const one of document.querySelectorAll("a, area, button, input, select, summary, label, "
      + "[role=button], [onclick], .hit, .tread"))
    if (!found.has(name(one)) && !one.disabled) found.set(name(one), one);
  window.controls = found;
  return [...found.keys()];
}"""
CLICK = """(name) => { const one = window.controls.get(name);
  if (one.matches("select")) {
    one.selectedIndex = one.options.length - 1;
    one.dispatchEvent(new Event("change", { bubbles: true }));
  } else if (one.click) one.click();
  else for (const kind of ["pointerdown", "mousedown", "mouseup", "click"])
    one.dispatchEvent(new MouseEvent(kind, { bubbles: true, view: window })); }"""
# Every way out of a page that a script has, short of leaving the page.
WAYS_OUT = """async (there) => {
  const link = Object.assign(document.createElement("a"), { href: there, target: "_blank" });
  const form = Object.assign(document.createElement("form"),
    { action: there, method: "post", target: "_blank" });
  const frame = Object.assign(document.createElement("iframe"), { src: there });
  const picture = Object.assign(document.createElement("img"), { src: there });
  const script = Object.assign(document.createElement("script"), { src: there });
  document.body.append(link, form, frame, picture, script);
  link.click();
  form.submit();
  navigator.sendBeacon(there, "data");
  try { new WebSocket(there.replace("http", "ws")); } catch { /* refused */ }
  const fetched = await fetch(there).then(() => true, () => false);
  return [window.open(there) !== null, fetched];
}"""


class Private(Visiting):
    def setUp(self):
        super().setUp()
        self.popups, self.clicked = [], set()

    def watched(self, page):
        """A page whose requests and popups are counted, those of what it opens too."""
        page.context.on("page", lambda opened: self.popups.append(opened))
        page.context.on(
            "request",
            lambda request: (
                self.foreign.append(request.url)
                if not request.url.startswith(("data:", "blob:", *self.own))
                else None
            ),
        )
        return page

    def assert_private(self):
        self.assertEqual(([one.url for one in self.popups], self.foreign), ([], []))

    def click_all(self, arrive, wanted):
        """Clicks whatever is on a screen, and what appears by clicking, until nothing is new.
        wanted: controls that must have been among them.
        """
        page, clicked = arrive(), set()
        while True:
            new = [name for name in page.evaluate(CONTROLS) if name not in clicked]
            if not new and page.is_closed() is False and not clicked - set(page.evaluate(CONTROLS)):
                break
            if not new:  # the screen has changed: whatever else the first one offers
                page.close()
                page = arrive()
                new = [name for name in page.evaluate(CONTROLS) if name not in clicked]
                if not new:
                    break
            clicked.add(new[0])
            page.evaluate(CLICK, new[0])
            page.wait_for_timeout(30)
            self.assert_private()
        page.close()
        for name in wanted:
            self.assertTrue([one for one in clicked if name in one], (name, sorted(clicked)))
        self.clicked |= clicked

    def live_page(self, bench):
        self.own = (bench.origin, bench.origin.replace("http", "ws"))
        return self.watched(self.page(bench))

    def recording(self, name="rec.csv", seconds=60, effects=""):
        scenario, path = self.folder / "scenario.toml", self.folder / name
        scenario.write_text(
            FIRST.format(rate=50.0, column="gyro_z_dps")
            + effects
            + f"[simulate]\nseed = 4\nduration_s = {seconds}\n"
        )
        self.assertEqual(run("simulate", scenario, "-o", path).returncode, 0)
        return path

    def test_no_control_of_the_bench_sends_anything_anywhere(self):
        recording = self.recording(
            effects='[[effect]]\nkind = "temperature"\ncoefficient_dps_per_degC = 0.05\n'
        )
        bench = self.open(recording)

        def arrive():
            bench.act("open", path=str(recording))
            page = self.live_page(bench)
            ranked(page)
            page.keyboard.press("w")
            return page

        self.click_all(
            arrive,
            [f"BUTTON|tab-{name}" for name in ("fit", "where", "spectrum", "columns", "sheet")]
            + [f"BUTTON|{name}" for name in ("save-svg", "save-png", "stairs-save", "stairs-png")]
            + ["BUTTON|report", "BUTTON|save", "BUTTON|save-px#", "BUTTON|help-button"],
        )

    def test_no_control_of_the_other_screens_does(self):
        log(self.folder / "flight.csv", NAMES)
        flight(self.folder / "flight.bin", (0.1, 0.4))
        bench = self.open()

        def at(path):
            def arrive():
                bench.act("close")
                if path:
                    bench.act("open", path=str(self.folder / path))
                page = self.live_page(bench)
                expect(page.locator("#landing button:visible").first).to_be_visible()
                return page

            return arrive

        self.click_all(at(None), ["BUTTON|tutorial", "BUTTON|listen"])
        self.click_all(at("flight.csv"), ["BUTTON|read"])
        self.click_all(at("flight.bin"), ["IMU:#"])

        def at_a_plan():
            bench.act("close")
            address = bench.address
            bench.address += "#plan"
            page = self.live_page(bench)
            bench.address = address
            expect(page.locator("#plan-files")).to_be_visible()
            return page

        self.click_all(at_a_plan, ["BUTTON|plan-copy", "BUTTON|plan-files", "SELECT|plan-gyro"])

    def test_the_policy_leaves_a_script_no_way_out(self):
        came = []

        def take(request, client, server):
            asked = request.recv(100)
            if asked:  # a browser may connect ahead of a request that it then refuses to send
                came.append(asked)

        with socketserver.ThreadingTCPServer(("127.0.0.1", 0), take) as elsewhere:
            elsewhere.daemon_threads = True
            threading.Thread(target=elsewhere.serve_forever, daemon=True).start()
            there = f"http://127.0.0.1:{elsewhere.server_address[1]}/"
            bare = self.browser.new_page()
            bare.evaluate(WAYS_OUT, there + "bare")
            until(bare, lambda: len(came) >= 4)  # a page without the policy gets out
            bare.context.close()
            bench = self.open()
            page = self.live_page(bench)
            expect(page.locator("#tutorial")).to_be_visible()
            self.assertEqual(page.evaluate(WAYS_OUT, there + "page"), [False, False])
            page.wait_for_timeout(500)
            elsewhere.shutdown()
        # the last ones of the page without it may come late
        came = [asked for asked in came if b" /bare" not in asked]
        self.assertEqual((came, self.popups), ([], []))


if __name__ == "__main__":
    unittest.main()
