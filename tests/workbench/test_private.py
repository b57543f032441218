"""Everything stays on this machine: every control of every live screen is clicked; a request to
another origin or a popup is a fault (Tabs). Reports fetch nothing: tests/lab/test_report.py.
"""

import socketserver
import threading

import pytest
from playwright.sync_api import expect
from recordings_made import effect, flight, foreign, simulated
from visiting import ranked, until

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
TABS = [f"tab-{name}" for name in ("fit", "where", "spectrum", "columns", "sheet")]
SAVES = ["save-svg", "save-png", "stairs-save", "stairs-png", "report", "save", "save-px#"]


def click_all(arrive, wanted):
    """Clicks whatever is on a screen, and what appears by clicking, until nothing is new. wanted:
    controls that must have been among them.
    """
    page, clicked = arrive(), set()
    while True:
        there = page.evaluate(CONTROLS)
        new = [name for name in there if name not in clicked]
        if not new and not clicked - set(there):
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
    page.close()
    for name in wanted:
        assert [one for one in clicked if name in one], (name, sorted(clicked))


SCREENS = {
    "": ["BUTTON|tutorial", "BUTTON|listen"],
    "rec.csv": [f"BUTTON|{name}" for name in (*TABS, *SAVES, "help-button")],
    "flight.csv": ["BUTTON|read"],
    "flight.bin": ["IMU:#"],
    "#plan": ["BUTTON|plan-copy", "BUTTON|plan-files", "SELECT|plan-gyro"],
}


@pytest.mark.parametrize("name", SCREENS)
def test_no_control_sends_anything_anywhere(folder, opened, tabs, name):
    warm = effect("temperature", coefficient_dps_per_degC=0.05)
    simulated(folder, warm, seconds=60, seed=4)
    foreign(folder / "flight.csv")
    flight(folder / "flight.bin", (0.1, 0.4))
    bench = opened()
    address = bench.address

    def arrive():
        bench.done("close")
        if "." in name:
            bench.done("open", path=str(folder / name))
        bench.address = address + (name if name == "#plan" else "")
        page = tabs.open(bench)
        if name == "rec.csv":
            ranked(page)
            page.keyboard.press("w")
        else:
            place = "#plan-files" if name == "#plan" else "#landing button:visible"
            expect(page.locator(place).first).to_be_visible()
        return page

    click_all(arrive, SCREENS[name])
    tabs.forgive()  # what a click on everything makes it complain of


def test_the_policy_leaves_a_script_no_way_out(chromium, opened, tabs):
    came = []

    def take(request, client, server):
        sent = request.recv(100)
        if sent:  # a browser may connect ahead of a request that it then refuses to send
            came.append(sent)

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), take) as elsewhere:
        elsewhere.daemon_threads = True
        threading.Thread(target=elsewhere.serve_forever, daemon=True).start()
        there = f"http://127.0.0.1:{elsewhere.server_address[1]}/"
        bare = chromium.new_page()
        bare.evaluate(WAYS_OUT, there + "bare")
        until(bare, lambda: len(came) >= 4)  # a page without the policy gets out
        bare.context.close()
        page = tabs.open(opened())
        expect(page.locator("#tutorial")).to_be_visible()
        assert page.evaluate(WAYS_OUT, there + "page") == [False, False]
        page.wait_for_timeout(500)
        elsewhere.shutdown()
    # the last ones of the page without it may come late
    assert [sent for sent in came if b" /bare" not in sent] == []
    tabs.foreign.clear()  # requests that the browser has refused
    tabs.forgive()
