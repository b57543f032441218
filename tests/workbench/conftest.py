"""One browser for all tests that show a page: they form one group of xdist, so one worker starts
it. Only the story runs by day; tools/soak runs the others.
"""

import os
import subprocess
from pathlib import Path

import pytest
from davarlab.effects import own
from playwright.sync_api import sync_playwright
from visiting import Inside, Started, Tabs


def pytest_itemcollected(item):
    if "chromium" in getattr(item, "fixturenames", ()):
        item.add_marker(pytest.mark.xdist_group("tests/workbench::browser"))
        if not item.get_closest_marker("story"):
            item.add_marker(pytest.mark.soak)


def pytest_configure(config):
    config.addinivalue_line("markers", "story: the browser test of the quick gear")


# For the package, not the session: while Playwright runs, its event loop occupies the main thread.
@pytest.fixture(scope="package")
def chromium():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox"]
        )
        yield browser
        browser.close()


@pytest.fixture
def folder(tmp_path):
    return Path(os.path.realpath(tmp_path))


@pytest.fixture(autouse=True)
def no_effects_left():
    """Takes effects that a test has loaded out of the table."""
    yield
    for kind in list(own.LOADED):
        own.drop(kind)


@pytest.fixture
def opened(folder):
    """Starts a server in this process: opened(recording, ...)."""
    benches = []

    def start(recording=None, **given):
        benches.append(Inside(folder, recording, **given))
        return benches[-1]

    yield start
    for bench in benches:
        bench.stop()


@pytest.fixture
def started(folder, tmp_path_factory):
    """Starts the command `davarlab open`: started(words, ...). started.state: where its tokens are
    kept.
    """
    benches = []

    def start(*words, **given):
        benches.append(Started(folder, start.state, *words, **given))
        return benches[-1]

    start.state = tmp_path_factory.mktemp("state")
    yield start
    for bench in benches:
        bench.stop()


@pytest.fixture
def tabs(chromium, opened, started):
    """Pages; after the test they must have been quiet."""
    made = Tabs(chromium)
    yield made
    made.close()
    made.check()


@pytest.fixture
def sender():
    """Starts davar-sim on a pty, where it waits for a reader: sender(words) is (process,
    source).
    """
    processes = []

    def start(*words):
        process = subprocess.Popen(
            [*map(str, words), "--out", "slcan:pty"],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        processes.append(process)
        place = process.stderr.readline().split("/dev/")[1].split()[0].rstrip(":")
        return process, f"slcan:/dev/{place}"

    yield start
    for process in processes:
        process.kill()
        process.communicate()
