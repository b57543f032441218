"""What the tests of the workbench share: `tools/davarlab open` in a folder of its own, and Debian's
chromium driven by Playwright.
"""

import json
import os
import pty
import signal
import subprocess
import tempfile
import unittest
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

from playwright.sync_api import expect, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
COMMAND = ROOT / "tools/davarlab"
SHOTS = ROOT / "build/workbench"  # screenshots, to be looked at
HANG_MS = int(
    os.environ.get("DAVAR_HANG_MS", 600_000)
)  # a page that takes longer hangs; a busy machine is no fault
FIRST = (
    '[sensor]\nrate_hz = {rate}\ncolumn = "{column}"\n[[effect]]\nkind = "angle_random_walk"\n'
    "coefficient_deg_per_sqrt_h = 0.3\n"
    '[[effect]]\nkind = "bias_instability"\ncoefficient_deg_per_h = 5.0\n'
)
STATE = tempfile.TemporaryDirectory()  # of the tests, not the user's

expect.set_options(timeout=HANG_MS)


def run(*arguments, cwd=None):
    """A command of davarlab as a user types it."""
    return subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, cwd=cwd)


OF_A_STEP = (
    "add",
    "line",
    "set",
    "refit",
    "remove",
    "restore",
    "go",
)  # actions on what a page shows


class Workbench:
    """The command, running in `folder`. stdin: a terminal, if it is one that a person started."""

    def __init__(self, folder, *arguments, stdin=subprocess.DEVNULL):
        self.process = subprocess.Popen(
            [COMMAND, "open", "--no-browser", *map(str, arguments)],
            cwd=folder,
            text=True,
            stdin=stdin,
            env={**os.environ, "XDG_STATE_HOME": STATE.name},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.address = self.process.stdout.readline().strip()
        if not self.address:
            raise AssertionError(self.process.stderr.read())
        place = urllib.parse.urlsplit(self.address)
        self.origin, self.token = (
            f"http://{place.netloc}",
            urllib.parse.parse_qs(place.query)["token"][0],
        )

    def stop(self, number=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(number)
        status = self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()
        return status

    def request(self, path, data=None, headers=None):
        """(status, text) of a request as any program on this machine could send it."""
        asked = urllib.request.Request(
            self.origin + path, data, {"X-Davar-Token": self.token} if headers is None else headers
        )
        try:
            with urllib.request.urlopen(asked, timeout=HANG_MS / 1000) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as why:
            with why:
                return why.code, why.read().decode()

    def ask(self, what, **given):
        given = self.shown(what, given) if what in ("ghost", "preview") else given
        status, text = self.request(f"/api/{what}?{urllib.parse.urlencode(given)}")
        return status, json.loads(text)

    def shown(self, what, given):
        """The arguments, with the state and the kind that an up-to-date page shows."""
        status, step = self.ask("step")
        if status != 200:
            return {"state": "none", **given}
        if type(given.get("place")) is int:
            listed = {
                "add": lambda: self.ask("candidates")[1]["candidates"],
                "restore": lambda: step["off"],
            }
            listed["ghost"] = listed["add"]
            there = listed.get(what, lambda: step["cards"])()
            given = {
                "kind": there[given["place"]]["kind"]
                if 0 <= given["place"] < len(there)
                else "none",
                **given,
            }
        return {"state": step["state"], **given}

    def act(self, what, **given):
        given = self.shown(what, given) if what in OF_A_STEP else given
        status, text = self.request(f"/api/{what}", json.dumps(given).encode())
        return status, json.loads(text)


class Visiting(unittest.TestCase):
    """A folder and a browser; what the page complains of is a failure."""

    @classmethod
    def setUpClass(cls):
        cls.playwright = sync_playwright().start()
        cls.browser = cls.playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox"]
        )
        SHOTS.mkdir(parents=True, exist_ok=True)

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.playwright.stop()

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = Path(os.path.realpath(kept.name))
        self.complaints, self.foreign = [], []

    def open(self, *arguments, terminal=False):
        """terminal: started by a person at one."""
        mine, its = pty.openpty() if terminal else (None, subprocess.DEVNULL)
        bench = Workbench(self.folder, *arguments, stdin=its)
        if terminal:
            os.close(its)
            self.addCleanup(os.close, mine)
        self.addCleanup(bench.stop)
        return bench

    def page(self, bench, width=1400, height=1000, **settings):
        context = self.browser.new_context(
            viewport={"width": width, "height": height}, accept_downloads=True, **settings
        )
        self.addCleanup(context.close)
        self.addCleanup(context.unroute_all, behavior="ignoreErrors")  # before it is closed
        page = context.new_page()
        page.set_default_timeout(HANG_MS)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on(
            "console",
            lambda message: message.type == "error" and self.complaints.append(message.text),
        )
        page.on(
            "request",
            lambda request: (
                request.url.startswith((bench.origin, "data:", "blob:"))
                or self.foreign.append(request.url)
            ),
        )
        page.goto(bench.address)
        return page

    def altered(self, page, requests, change):
        """The page receives what change(route, answer) returns, instead of the server's answer."""

        def answer(route):
            given = route.fetch(timeout=0)
            route.fulfill(response=given, json=change(route, given.json()))

        page.context.route(requests, answer)

    def model(self, bench):
        """The model file of the current step, as the page saves it."""
        status, text = bench.request("/api/save?what=toml")
        self.assertEqual(status, 200, text)
        return text

    def shot(self, page, name):
        page.screenshot(path=str(SHOTS / f"{name}.png"), full_page=True)

    def assert_quiet(self):
        self.assertEqual((self.complaints, self.foreign), ([], []))


def ranked(page, kind=None):
    """Waits until the candidates are there; the button of one of them, of the best one without a
    kind.
    """
    button = page.locator(f"#next button.candidate{f'[data-kind={kind}]' if kind else ''}").first
    expect(button).to_be_attached()
    if not button.is_visible():  # below the cards
        page.locator("#more summary").click()
    expect(button).to_be_visible()
    expect(button).to_be_enabled()  # its result is there
    return button


def tab(page, name):
    """Shows one of the tabs over the chart, and waits until it is drawn."""
    page.click(f"#tab-{name}")
    expect(page.locator(f"#panel-{name}")).to_have_attribute("aria-busy", "false")


def export(page, what):
    """Chooses an entry of the menu of exports."""
    page.click("#export")
    page.click(f"#{what}")


def error(page):
    """The error of a step at rest: while one is animated, its number is marked as approximate."""
    expect(page.locator("#gauge")).not_to_contain_text("≈")
    return float(page.text_content("#error-value"))


def flagged(bench):
    """The frequencies at which the page offers a line, of the current step."""
    found = bench.ask("step")[1]["spectrum"]
    peaks = zip(found["peak_hz"], found["peak_ratio"])
    return [f for f, ratio in peaks if ratio > found["peak_chance"]]


def unfold(page, kind):
    """Shows the other values of an effect, and what can be done with it."""
    fold = page.locator(f".effect[data-kind={kind}] .fold")
    if fold.get_attribute("aria-expanded") == "false":
        fold.click()


def until(page, happened):
    """Waits for what the test itself sees; a page that never does it hangs."""
    for _ in range(HANG_MS // 20):
        if happened():
            return
        page.wait_for_timeout(20)
    raise AssertionError(f"not within {HANG_MS} ms")
