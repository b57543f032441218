"""The tab with the planner: it shows what tools/davar-plan prints for the command on the tab, for
the newest wishes; what is impossible can be relaxed.
"""

import io
import json
import re
import shlex
import urllib.parse
import zipfile

import pytest
from playwright.sync_api import expect
from visiting import held_back, planned, until

CORE = "cortex-m4f"
SENSOR = {"sensor": "icm42688@1000", "axes": "3", "core": CORE}
EXAMPLE = {**SENSOR, "respond": "2", "longest_tau": "1200", "ram": "20k", "flash": "24k"}
IMPOSSIBLE = {**EXAMPLE, "ram": "4k", "flash": "14k", "arw_percent": "3"}
PLANNING = re.compile(r"/api/plan\?")
# A bar's share of its cell.
SHARE = "(cell) => cell.querySelector('i').offsetWidth / cell.querySelector('.bar').offsetWidth"


def settled(page):
    expect(page.locator("#plan")).to_have_attribute("aria-busy", "false")


@pytest.fixture
def plan(opened, tabs):
    """Opens the tab with these wishes in its address."""
    bench = opened()

    def show(wishes=None, **settings):
        query = f"?{urllib.parse.urlencode(wishes)}" if wishes else ""
        address, bench.address = bench.address, f"{bench.address}#plan{query}"
        page = tabs.open(bench, **settings)
        bench.address = address
        settled(page)
        return page

    return show


def command(page):
    return page.inner_text("#plan-command")


def costs(page, core=CORE):
    """key -> text of its cell."""
    cells = page.locator(f"tr[data-core='{core}'] td[data-key]").all()
    return {cell.get_attribute("data-key"): cell.inner_text().strip() for cell in cells}


def check_as_printed(page):
    """Whatever the tab shows is what the command prints."""
    words = shlex.split(command(page).removesuffix(" -o setup"))[1:]
    found = json.loads(planned(*words, "--json").stdout)
    shown = costs(page)
    if "impossible" in found:
        assert "Impossible: " in page.inner_text("#plan-said")
        for reason in found["impossible"].split("; "):
            assert reason in page.inner_text("#plan-found")
        buttons = 1 if found["together"] else len(found["relax"])
        assert page.locator("#plan-relax button").count() == buttons > 0
        assert shown == {}
        return
    assert len(shown) == 5 and shown == {key: str(found[key]) for key in shown}
    report = " ".join(planned(*words).stdout.split())
    lines = [page.text_content("#plan-said")]
    lines += page.locator("#plan-gives li").all_text_contents()
    assert len(lines) > 2
    for line in lines:
        assert line in report


def test_what_is_moved_typed_or_wrong_is_what_the_command_prints(opened, tabs):
    page = tabs.open(opened())
    page.click("#view-plan")
    expect(page.locator("#landing")).to_be_hidden()
    settled(page)
    check_as_printed(page)
    before, gives = costs(page), page.inner_text("#plan-gives")
    page.get_by_label("Longest averaging time").focus()
    for _ in range(8):
        page.keyboard.press("ArrowRight")
    settled(page)
    assert "--longest-tau 120 " in command(page)
    expect(page.locator("output[for=plan-longest_tau]")).to_have_text("2 min")
    assert int(costs(page)["flash_bytes"]) > int(before["flash_bytes"])
    assert page.inner_text("#plan-gives") != gives
    check_as_printed(page)
    page.select_option("#plan-gyro", "lsm6dso")
    page.fill("#plan-rate", "417")
    page.locator("#plan-rate").blur()
    expect(page.locator("#plan-said")).to_contain_text("--sensor")
    assert costs(page) == {}  # no old one stays
    page.select_option("#plan-gyro", "")
    for option, text in (("rate", "1000"), ("lsb", "0.05"), ("bandwidth", "33:2")):
        page.fill(f"#plan-{option}", text)
        page.locator(f"#plan-{option}").blur()
    expect(page.locator("#plan-command")).to_contain_text("--lsb 0.05 --bandwidth 33:2")
    settled(page)
    check_as_printed(page)
    tabs.forgive("400")


def test_a_bar_is_a_share_of_its_limit_and_the_files_are_those_of_the_terminal(folder, plan):
    page = plan(EXAMPLE, permissions=["clipboard-read", "clipboard-write"])
    check_as_printed(page)
    for key, limit in (("flash_bytes", 24576), ("ram_bytes", 20480)):
        cell = page.locator(f"tr[data-core='{CORE}'] td[data-key={key}]")
        share = int(costs(page)[key]) / limit
        assert cell.evaluate(SHARE) == pytest.approx(share, abs=0.02)
        expect(page.locator(f"th[data-key={key}]")).to_contain_text(f"of {limit}")
    with page.expect_download() as saved:
        page.click("#plan-files")
    done = planned(*shlex.split(command(page))[1:-1], folder / "setup")
    assert done.returncode == 0, done.stderr
    here = (str(folder / "setup"), "setup")  # the files name the command
    written = {one.name: one.read_text().replace(*here) for one in (folder / "setup").iterdir()}
    assert "davar_setup.c" in written
    with zipfile.ZipFile(io.BytesIO(saved.value.path().read_bytes())) as archive:
        loaded = {name: archive.read(name).decode() for name in archive.namelist()}
    assert {name.removeprefix("setup/"): text for name, text in loaded.items()} == written
    page.click("#plan-copy")
    expect(page.locator("#plan-copy")).to_have_text("Copied")
    assert page.evaluate("navigator.clipboard.readText()") == command(page)
    last = page.locator("tr[data-core] input").last
    last.check()
    settled(page)
    assert f"--core {last.get_attribute('value')} " in command(page)


def test_what_is_impossible_names_the_reason_and_a_relaxation_helps(plan):
    page = plan(IMPOSSIBLE)
    check_as_printed(page)
    button = page.locator("#plan-relax button").first
    text = button.inner_text()
    button.click()
    expect(page.locator("#plan-gives")).to_be_visible()
    settled(page)
    check_as_printed(page)
    shown = page.locator("#plan-wishes output").all_inner_texts()
    shown += page.locator("#plan-wishes input").evaluate_all("all => all.map((x) => x.value)")
    for one in text.split(" and "):
        assert one.split(": ")[1] in shown, text


def test_an_answer_that_comes_late_is_dropped(plan):
    page = plan(SENSOR)
    held = held_back(page, PLANNING)
    page.get_by_label("Respond within").focus()
    for _ in range(6):
        page.keyboard.press("ArrowRight")
    until(page, lambda: len(held) == 2)  # no more at once; those between are not sent at all
    expect(page.locator("#plan-found")).to_have_js_property("inert", True)
    opacity = "getComputedStyle(document.getElementById('plan-found')).opacity"
    until(page, lambda: float(page.evaluate(opacity)) < 1)
    expect(page.locator("output[for=plan-respond]")).to_have_text("1 s")  # nothing freezes
    sent = [urllib.parse.parse_qs(route.request.url)["respond"] for route in held]
    assert sent == [["0.1"], ["0.2"]]
    held[1].continue_()
    expect(page.locator("#plan-command")).to_contain_text("--respond 0.2 ")
    until(page, lambda: len(held) == 3)
    held[0].continue_()
    page.wait_for_timeout(500)
    assert "--respond 0.2 " in command(page)
    expect(page.locator("#plan")).to_have_attribute("aria-busy", "true")
    held[2].continue_()
    expect(page.locator("#plan-command")).to_contain_text("--respond 1 ")
    settled(page)
    expect(page.locator("#plan-found")).to_have_js_property("inert", False)
    assert len(held) == 3


def test_the_gyro_of_the_open_recording_is_planned_for(opened, tabs):
    """The keys of the model do nothing there."""
    bench = opened()
    bench.done("tutorial")
    page = tabs.open(bench)
    expect(page.locator("#headline h1")).to_be_visible()
    page.click("#view-plan")
    for _ in range(2):
        expect(page.locator("#plan-rate")).to_have_value("50")
        # deg/sqrt(h), of the simulated sensor
        assert float(page.input_value("#plan-noise")) == pytest.approx(0.3, abs=0.003)
        page.select_option("#plan-gyro", index=0)  # another gyro, and back
        page.select_option("#plan-gyro", "")
    expect(page.locator("#undo")).to_be_hidden()
    page.locator("#plan-gyro").blur()
    page.keyboard.press("1")
    page.keyboard.press("f")
    page.wait_for_timeout(300)
    assert len(bench.ask("all")["steps"]) == 1
