"""A person who does not see well can use the page: axe finds nothing in any state, light and dark,
on a desktop and on a phone. One session goes through all states; their pictures are in
build/gallery, to be looked at.
"""

import math
import random
import signal

import pytest
from playwright.sync_api import expect
from recordings_made import dead_zone, noise
from visiting import ROOT, accessible, effects, export, ranked, tab

DRAWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
GALLERY = ROOT / "build/gallery"
SCREENS = [
    (width, height, scheme)
    for width, height in ((1440, 900), (1280, 720), (390, 844))
    for scheme in ("light", "dark")
]
CHECKED = ((1280, "light"), (1280, "dark"), (390, "light"))  # by axe; each run takes a second
PLAN = "sensor=icm42688@1000&axes=3&core=cortex-m4f&respond=2&longest_tau=1200&flash=24k&ram="


def hum(i):
    return 0.1 * math.sin(i / 700) + 0.05 * math.sin(2 * math.pi * i / 50)


def squared_walk():
    """A course that no known effect has."""
    rng, course = random.Random(5), [0.0]
    while len(course) < 6000:
        course.append(course[-1] + rng.gauss(0, 0.02))
    return lambda i: 0.1 * course[i] ** 2


def stage(page, name):
    """Looks at a state on every screen. It is never wider than the screen."""
    GALLERY.mkdir(parents=True, exist_ok=True)
    for width, height, scheme in SCREENS:
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        page.evaluate(DRAWN)
        assert page.evaluate("document.documentElement.scrollWidth") <= width, name
        path = str(GALLERY / f"{name}-{width}-{scheme}.png")
        page.screenshot(path=path, full_page=width < 400 or name == "report")
        if (width, scheme) in CHECKED:
            accessible(page, name, width, scheme)


@pytest.fixture
def page(started, tabs):
    page = tabs.open(started(), reduced_motion="reduce")
    expect(page.locator("#tutorial")).to_be_visible()
    return page


def drop(page, path):
    page.set_input_files("#file", path)


def leave(page, way="#close"):
    page.click(way)
    expect(page.locator("#tutorial")).to_be_visible()


def test_axe_finds_nothing_before_a_recording_is_read(folder, page):
    stage(page, "landing")
    drop(page, noise(folder / "foreign.csv", "t,wx,wy", hum, lambda i: 0))
    expect(page.locator("#read")).to_be_visible()
    stage(page, "preview")
    leave(page, "text=Another file")
    drop(page, noise(folder / "late.csv", "time_s,gyro_x_dps", step=10000))
    expect(page.locator("#doubts")).to_be_visible()
    stage(page, "doubtful")


def test_axe_finds_nothing_while_a_model_grows(folder, page, tabs):
    page.route("**/api/candidates*", lambda route: None)
    header = "time_s,gyro_x_dps,gyro_z_dps,temp_degC"
    heat = lambda i: 20 + 10 * math.sin(i / 700)  # noqa: E731
    drop(page, noise(folder / "sensor.csv", header, hum, lambda i: 0, heat))
    expect(page.locator("#trying")).to_be_visible()
    page.select_option("#axis", "gyro_x_dps")
    expect(page.locator("#headline-strong")).to_contain_text("×")
    expect(page.locator("#trying")).to_be_visible()
    stage(page, "fitting")
    page.unroute("**/api/candidates*")  # lets them go
    ranked(page)
    stage(page, "cards")
    page.keyboard.press("w")
    for name in ("where", "spectrum", "columns", "sheet", "held", "live"):
        tab(page, name)
        stage(page, name)
    tab(page, "axes")
    expect(page.locator("#all-axes td.n")).to_have_count(4)
    stage(page, "axes")
    tab(page, "fit")
    page.click("#export")
    stage(page, "exports")
    page.keyboard.press("Escape")
    ranked(page).click()
    effects(page, 3)
    ranked(page)
    stage(page, "added")
    ranked(page).click()
    expect(page.locator("#to-held-out")).to_be_visible()
    stage(page, "adequate")
    report = folder / "report.html"
    report.write_bytes(export(page, "report").read_bytes())
    stage(tabs.open(report.as_uri()), "report")


def test_axe_finds_nothing_where_nothing_is_certain(folder, page):
    drop(page, noise(folder / "odd.csv", "time_s,gyro_x_dps", squared_walk()))
    ranked(page).click()
    expect(page.locator("#next .unknown")).to_be_visible()
    stage(page, "unknown")
    leave(page)
    drop(page, dead_zone(folder / "dead.csv"))
    expect(page.locator("#nothing")).to_be_visible()
    stage(page, "useless")


def test_axe_finds_nothing_in_the_editor_and_without_a_server(folder, started, tabs):
    path = noise(folder / "rec.csv", "time_s,gyro_z_dps,motor_deg", hum, lambda i: i % 360)
    bench = started(path.name, terminal=True)
    page = tabs.open(bench)
    page.locator("#next button.write").click()
    expect(page.locator("#own-said")).to_contain_text("own_effect returns")
    stage(page, "own")
    page.get_by_role("button", name="Cancel").click()
    ranked(page)
    bench.stop(signal.SIGKILL)
    expect(page.locator("#gone")).to_be_visible()
    stage(page, "killed")
    tabs.forgive()


@pytest.mark.parametrize("name, ram", [("plan", "20k"), ("impossible", "10k")])
def test_axe_finds_nothing_at_the_plan_which_fits_one_screen(opened, tabs, name, ram):
    bench = opened()
    bench.address += f"#plan?{PLAN}{ram}"
    page = tabs.open(bench)
    expect(page.locator("#plan")).to_have_attribute("aria-busy", "false")
    stage(page, name)
    page.set_viewport_size({"width": 1280, "height": 720})
    assert page.evaluate("document.documentElement.scrollHeight") <= 720
