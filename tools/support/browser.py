"""Debian's chromium without a window, driven over its own debugging pipe. Standard library only.

    with Browser() as browser:
        page = browser.open("/some/page.html", width=400)
        page.evaluate("document.title"), page.requests, page.complaints, page.screenshot()
"""

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

PATIENCE_S = 600


class Closed(Exception):
    """The browser has gone or does not answer."""


class Browser:
    """One browser process with a profile of its own that goes with it."""

    def __init__(self, program="chromium"):
        self.profile = tempfile.mkdtemp(prefix="davar-browser-")
        to_read, self.commands = os.pipe()
        self.answers, to_write = os.pipe()
        options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                   "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
                   f"--user-data-dir={self.profile}", "--remote-debugging-pipe", "about:blank"]
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{to_read} 4>&{to_write}', "bash", program, *options], pass_fds=(to_read, to_write),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        self.buffer, self.count, self.events = b"", 0, []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for pipe in (self.commands, self.answers):
            os.close(pipe)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def receive(self, deadline):
        """The next message, an answer or an event."""
        while b"\0" not in self.buffer:
            if not select.select([self.answers], [], [], max(0, deadline - time.monotonic()))[0]:
                raise Closed("no answer")
            data = os.read(self.answers, 1 << 16)
            if not data:
                raise Closed("the browser has gone")
            self.buffer += data
        message, _, self.buffer = self.buffer.partition(b"\0")
        return json.loads(message)

    def call(self, method, session=None, **parameters):
        """Sends a command and returns its result; events on the way are kept."""
        self.count += 1
        command = {"id": self.count, "method": method, "params": parameters, **({"sessionId": session} if session else {})}
        os.write(self.commands, json.dumps(command).encode() + b"\0")
        deadline = time.monotonic() + PATIENCE_S
        while (message := self.receive(deadline)).get("id") != self.count:
            self.events.append(message)
        if "error" in message:
            raise Closed(f"{method}: {message['error']['message']}")
        return message["result"]

    def wait_for(self, method, session):
        deadline = time.monotonic() + PATIENCE_S
        while not any(e.get("method") == method and e.get("sessionId") == session for e in self.events):
            self.events.append(self.receive(deadline))

    def open(self, path, width=1280, height=900):
        """Loads a file into a new tab of this size (CSS pixels) and waits until everything in it is there."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable", session)
        self.call("Emulation.setDeviceMetricsOverride", session, width=width, height=height, deviceScaleFactor=1,
                  mobile=False)
        self.events.clear()
        self.call("Page.navigate", session, url=Path(path).resolve().as_uri())
        self.wait_for("Page.loadEventFired", session)
        return Page(self, session)


@dataclass
class Page:
    browser: Browser = field(repr=False)
    session: str

    def seen(self, method):
        return [event["params"] for event in self.browser.events
                if event.get("method") == method and event.get("sessionId") == self.session]

    @property
    def requests(self):
        """Addresses that were fetched, pictures inside the page left out."""
        urls = [event["request"]["url"] for event in self.seen("Network.requestWillBeSent")]
        return [url for url in urls if not url.startswith("data:")]

    @property
    def complaints(self):
        """What the console would show: errors, warnings, exceptions."""
        return ([event["entry"]["text"] for event in self.seen("Log.entryAdded")]
                + [event["exceptionDetails"]["text"] for event in self.seen("Runtime.exceptionThrown")]
                + [str(event["args"]) for event in self.seen("Runtime.consoleAPICalled")])

    def evaluate(self, expression):
        answer = self.browser.call("Runtime.evaluate", self.session, expression=expression, returnByValue=True,
                                   awaitPromise=True)
        if "exceptionDetails" in answer:
            raise Closed(answer["exceptionDetails"]["text"])
        return answer["result"].get("value")

    def screenshot(self, height=None, element=None):
        """PNG of the whole page, of its first `height` CSS pixels, or of the box of an element (a selector)."""
        size = self.browser.call("Page.getLayoutMetrics", self.session)["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": height or size["height"]}
        if element:
            clip = self.evaluate(f"(r => ({{x: r.x + scrollX, y: r.y + scrollY, width: r.width, height: r.height}}))"
                                 f"(document.querySelector({json.dumps(element)}).getBoundingClientRect())")
        picture = self.browser.call("Page.captureScreenshot", self.session, format="png", clip={**clip, "scale": 1},
                                    captureBeyondViewport=True)
        return base64.b64decode(picture["data"])

    def pdf(self):
        """The page as it would be printed."""
        return base64.b64decode(self.browser.call("Page.printToPDF", self.session)["data"])
