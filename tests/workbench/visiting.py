"""The workbench for its tests: its server in this process, or the command as a user starts it, and
pages on it in Debian's chromium.
"""

import asyncio
import contextlib
import io
import json
import os
import pty
import secrets
import signal
import socket
import subprocess
import threading
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

import uvicorn
from axe_playwright_python.sync_playwright import Axe
from davarlab import cli
from davarlab.workbench.server import Server
from davarlab.workbench.session.session import Session
from planner import __main__ as planner
from playwright.sync_api import expect

ROOT = Path(__file__).resolve().parents[2]
# A page that takes longer hangs; a busy machine is not a fault.
HANG_MS = int(os.environ.get("DAVAR_HANG_MS", 600_000))
# Actions on the step that a page shows.
OF_A_STEP = ("add", "line", "set", "refit", "remove", "restore", "go")

expect.set_options(timeout=HANG_MS)


def called(main, words):
    """A command line run in this process, with its exit status and what it printed."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main([str(word) for word in words])
        except SystemExit as why:
            status = why.code
        except planner.BadOption as why:
            status = 2
            print(f"davar-plan: {why}", file=err)
    return subprocess.CompletedProcess(words, status, out.getvalue(), err.getvalue())


def run(*words, cwd="."):
    """A command of davarlab, as if typed in the folder `cwd`."""
    with contextlib.chdir(cwd):
        return called(cli.main, words)


def told(*words, cwd="."):
    """The JSON that a command prints."""
    done = run(*words, "--json", cwd=cwd)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)


def planned(*words):
    """A command of davar-plan."""
    return called(planner.run, words)


def files_in(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


class Bench:
    """A running server."""

    def __init__(self, address):
        place = urllib.parse.urlsplit(address)
        self.address, self.port = address, place.port
        self.origin = f"http://{place.netloc}"
        self.token = urllib.parse.parse_qs(place.query)["token"][0]

    def request(self, path, data=None, headers=None):
        """(status, body)."""
        headers = {"X-Davar-Token": self.token} if headers is None else headers
        wanted = urllib.request.Request(self.origin + path, data, headers)
        try:
            with urllib.request.urlopen(wanted, timeout=HANG_MS / 1000) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as why:
            with why:
                return why.code, why.read()

    def ask(self, what, **given):
        status, answer = self.tried(what, **given)
        assert status == 200, (what, given, answer)
        return answer

    def tried(self, what, **given):
        given = (
            self.shown(what, given)
            if what in ("candidate_preview", "preview", "without")
            else given
        )
        status, text = self.request(f"/api/{what}?{urllib.parse.urlencode(given)}")
        return status, json.loads(text)

    def act(self, what, **given):
        """(status, answer) of an action on what is shown now, unless `state` or `kind` is given."""
        given = self.shown(what, given) if what in OF_A_STEP else given
        status, text = self.request(f"/api/{what}", json.dumps(given).encode())
        return status, json.loads(text)

    def done(self, what, **given):
        status, answer = self.act(what, **given)
        assert status == 200, (what, given, answer)
        return answer

    def shown(self, what, given):
        """The arguments with the state and the kind that an up-to-date page shows."""
        status, step = self.tried("step")
        if status != 200:
            return {"state": "none", **given}
        if type(place := given.get("place")) is int:
            there = {
                "add": lambda: self.ask("candidates")["candidates"],
                "candidate_preview": lambda: self.ask("candidates")["candidates"],
                "restore": lambda: step["off"],
            }.get(what, lambda: step["cards"])()
            kind = there[place]["kind"] if 0 <= place < len(there) else "none"
            given = {"kind": kind, **given}
        return {"state": step["state"], **given}

    def coded(self, what, given, **headers):
        """(status, text) of a request that runs code, as the page of this server sends it."""
        headers = {"X-Davar-Token": self.token, "Origin": self.origin, **headers}
        status, text = self.request(f"/api/{what}", json.dumps(given).encode(), headers)
        return status, text.decode()

    def drop(self, name, data, **more):
        """(status, answer) of a file that is dropped on the page."""
        query = urllib.parse.urlencode({"name": name, **more})
        status, text = self.request(f"/api/drop?{query}", data)
        return status, json.loads(text)

    def saved(self, what="toml"):
        """A file of the menu of exports, of the current step."""
        status, text = self.request(f"/api/save?what={what}")
        assert status == 200, text
        return text.decode()

    def candidate(self, kind):
        listed = self.ask("candidates")["candidates"]
        return next(one["place"] for one in listed if one["kind"] == kind)

    def flagged(self):
        """The frequencies at which the page offers a line, of the current step."""
        found = self.ask("step")["spectrum"]
        peaks = zip(found["peak_hz"], found["peak_ratio"])
        return [f for f, ratio in peaks if ratio > found["peak_chance"]]


class Inside(Bench):
    """The server of `davarlab open` in a thread of this process. code: as if a person at a terminal
    had started it; given: options of the recording.
    """

    def __init__(self, folder, recording=None, code=False, **given):
        self.session = Session(folder, code=code)
        if recording:
            self.session.intake.open(str(Path(folder, recording)), **given)
        self.server, started = Server(self.session), threading.Event()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.session.port = self.listener.getsockname()[1]
        self.server.token = secrets.token_urlsafe(16)
        super().__init__(f"http://127.0.0.1:{self.session.port}/?token={self.server.token}")
        config = uvicorn.Config(
            self.server.app(),
            log_level="critical",
            access_log=False,
            timeout_graceful_shutdown=1,
            proxy_headers=False,
        )
        self.web = uvicorn.Server(config)

        async def serve():
            self.server.loop = asyncio.get_running_loop()
            started.set()
            await self.web.serve(sockets=[self.listener])

        self.thread = threading.Thread(target=lambda: asyncio.run(serve()), daemon=True)
        self.thread.start()
        started.wait()

    def stop(self):
        self.session.superseded = lambda but=None: True  # a ranking gives way
        self.web.should_exit = True
        self.thread.join()
        self.session.listener.quiet()
        for pool in (self.server.worker, self.server.reader, self.server.planner):
            pool.shutdown(cancel_futures=True)
        self.listener.close()


class Started(Bench):
    """The command in a process of its own. terminal: started by a person at one."""

    def __init__(self, folder, state, *words, terminal=False):
        self.terminal, its = pty.openpty() if terminal else (None, subprocess.DEVNULL)
        self.process = subprocess.Popen(
            [ROOT / "tools/davarlab", "open", "--no-browser", *map(str, words)],
            cwd=folder,
            text=True,
            stdin=its,
            env={
                **os.environ,
                "XDG_STATE_HOME": str(state),
                "XDG_DATA_HOME": str(state),
                "DAVAR_BUILT": "1",
            },
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        if terminal:
            os.close(its)
        address = self.process.stdout.readline().strip()
        assert address, self.process.communicate()[1]
        super().__init__(address)

    def stop(self, number=signal.SIGINT):
        """(exit status, messages); nothing if it has been stopped before."""
        if self.process.stdout.closed:
            return None
        self.process.send_signal(number)
        said = self.process.communicate()[1]
        if self.terminal is not None:
            os.close(self.terminal)
        return self.process.returncode, said


class Tabs:
    """Pages in one browser, each in a context of its own. What they complain of, and requests to
    other addresses, are faults unless `forgiven`.
    """

    def __init__(self, browser):
        self.browser, self.contexts = browser, []
        self.complaints, self.foreign, self.popups, self.forgiven = [], [], [], []

    def open(self, address, width=1280, height=720, **settings):
        """A page at the address: a Bench, or text."""
        bench = address if isinstance(address, Bench) else None
        address = bench.address if bench else address
        own = (bench.origin, bench.origin.replace("http", "ws")) if bench else (address,)
        size = {"width": width, "height": height}
        context = self.browser.new_context(viewport=size, accept_downloads=True, **settings)
        self.contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(HANG_MS)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", self.heard)
        context.on("page", lambda opened: self.popups.append(opened))
        context.on("request", lambda request: self.sent(request.url, own))
        page.goto(address)
        return page

    def heard(self, message):
        if message.type == "error":
            self.complaints.append(message.text)

    def sent(self, address, own):
        if not address.startswith(("data:", "blob:", *own)):
            self.foreign.append(address)

    def forgive(self, *words):
        """Complaints with such a word are expected; without words, all of them."""
        self.forgiven += words or [""]

    def check(self):
        wrong = [one for one in self.complaints if not any(word in one for word in self.forgiven)]
        found = (wrong, self.foreign, [one.url for one in self.popups])
        assert found == ([], [], []), found

    def close(self):
        for context in self.contexts:
            context.unroute_all(behavior="ignoreErrors")
            context.close()


def accessible(page, *about):
    """axe finds nothing wrong."""
    found = Axe().run(page).response["violations"]
    assert [(one["id"], [node["target"] for node in one["nodes"]]) for one in found] == [], about


def altered(page, requests, change):
    """The page receives change(route, answer) instead of the server's answer."""

    def answer(route):
        given = route.fetch(timeout=0)
        route.fulfill(response=given, json=change(route, given.json()))

    page.context.route(requests, answer)


def held_back(page, requests):
    """The list of the requests that match, held back from now on."""
    held = []
    page.route(requests, lambda route: held.append(route))
    return held


def ranked(page, kind=None):
    """Waits for the candidates. Returns the button of a kind, or of the best one."""
    button = page.locator(f"#next button.candidate{f'[data-kind={kind}]' if kind else ''}").first
    expect(button).to_be_attached()
    if not button.is_visible():  # below the cards
        page.locator("#more summary").click()
    expect(button).to_be_visible()
    expect(button).to_be_enabled()  # its result is there
    return button


def effects(page, count):
    """Waits until the model has this number of effects."""
    expect(page.locator(".effect")).to_have_count(count)


def tab(page, name):
    """Shows one of the tabs above the chart, and waits until it is drawn."""
    page.click(f"#tab-{name}")
    expect(page.locator(f"#panel-{name}")).to_have_attribute("aria-busy", "false")


def export(page, what):
    """The path of an entry of the menu of exports, downloaded."""
    with page.expect_download() as saved:
        page.click("#export")
        page.click(f"#{what}")
    return saved.value.path()


def error(page):
    """The error of a step at rest: while one is animated, its number is marked as approximate."""
    expect(page.locator("#gauge")).not_to_contain_text("≈")
    return float(page.text_content("#error-value"))


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
