"""How the workbench feels: a real browser on 360 000 samples (one call of
tools/test --only workbench makes the environment):

build/venv-test/bin/python tests/workbench/benchmark_page.py [REPEATS]
"""

import statistics
import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "python"))
from playwright.sync_api import expect, sync_playwright
from visiting import Started, Tabs, effects, ranked, tab

GOALS = {
    "first curve after the file is there, s": 3.0,
    "slider to curve, ms": 16.0,
    "frame while a curve is dragged, ms": 33.0,
    "the same on a processor four times slower, ms": 33.0,
    "value set by hand to verdict, ms": 300.0,
    "refit, ms": 300.0,
    "first candidates, s": 1.0,
    "all candidates, s": 3.0,
    "a candidate added, s": 1.0,
    "cell to its samples, ms": 300.0,
    "slider to plan, ms": 100.0,
}
SLIDE = """async (input) => {
  const frame = () => new Promise((done) => requestAnimationFrame(() => {
    const c = new MessageChannel();
    c.port1.onmessage = done;
    c.port2.postMessage(0);
  }));
  const spent = [];
  for (let i = 0; i < 60; i++) {
    await frame();
    const begin = performance.now();
    input.value = i / 60;
    input.dispatchEvent(new Event("input", { bubbles: true }));
    spent.push(performance.now() - begin);
  }
  return spent;
}"""
FRAMES = """() => {
  window.frames = [];
  let last = performance.now();
  const tick = () => {
    const now = performance.now();
    window.frames.push(now - last);
    last = now;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}"""
# A point of a curve in the window, a fifth of the way along it.
HANDLE = """(path) => {
  const at = path.getPointAtLength(path.getTotalLength() / 5).matrixTransform(path.getScreenCTM());
  return [at.x, at.y];
}"""
MOVES = 60
PLAN = """async (input) => {
  const spent = [], plan = document.getElementById("plan");
  const move = async (value) => {
    input.value = value;
    input.dispatchEvent(new Event("input", { bubbles: true }));
    while (plan.getAttribute("aria-busy") === "true") await new Promise(requestAnimationFrame);
  };
  for (let value = 0; value <= Number(input.max); value++) {
    const begin = performance.now();
    await move(String(value));
    spent.push(performance.now() - begin);
  }
  await move(input.id.match(/ram|flash/) ? input.max : "0");
  return spent;
}"""
UNTIL = """async () => {{
  const begin = performance.now();
  {act};
  while (!({wanted})) await new Promise(requestAnimationFrame);
  return performance.now() - begin;
}}"""
BACK = "document.getElementById('back')"
QUIET = "document.getElementById('panel-fit').getAttribute('aria-busy') === 'false'"
SLIDER = "[data-kind=angle_random_walk] input[type=range]"
# Until the charts below are drawn too: what a person does next does not wait for them.
REST_MS = 3000


def until(page, act, wanted):
    """Milliseconds from an action in the page until a condition holds there, seen at each frame."""
    page.wait_for_timeout(REST_MS)
    return page.evaluate(UNTIL.format(act=act, wanted=wanted))


def spent(work):
    """Seconds until all of it is done."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def dragged(page, slower):
    """The 95th percentile of the frames, ms, while the mouse drags the curve of the white noise,
    then back."""
    page.wait_for_timeout(REST_MS)
    speed = page.context.new_cdp_session(page)
    speed.send("Emulation.setCPUThrottlingRate", {"rate": slower})
    x, y = page.locator(".part-hit[data-kind=angle_random_walk]").evaluate(HANDLE)
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate(FRAMES)
    for i in range(MOVES):
        page.mouse.move(x, y - i % (MOVES // 2))
    frames = page.evaluate("window.frames")
    page.mouse.move(x, y)
    page.mouse.up()
    speed.send("Emulation.setCPUThrottlingRate", {"rate": 1})
    page.reload()  # ends the measurement
    ranked(page)
    return statistics.quantiles(frames, n=20)[-1]


def one_session(page, data):
    page.click("#tutorial")
    page.wait_for_selector("#headline h1")
    page.click("#close")
    expect(page.locator("#tutorial")).to_be_visible()
    (steps,) = data.rglob("tutorial_sensor.csv.davarlab.json")
    steps.unlink()
    page.click("#tutorial")
    yield spent(lambda: page.wait_for_selector("#deviation path.model"))
    first = spent(lambda: expect(page.locator("#next .early, .candidate").first).to_be_visible())
    every = first + spent(lambda: ranked(page))
    page.wait_for_timeout(REST_MS)
    yield statistics.median(page.locator(SLIDER).evaluate(SLIDE))
    yield from (dragged(page, slower) for slower in (1, 4))
    page.wait_for_timeout(REST_MS)
    page.locator("[data-kind=angle_random_walk] input[type=number]").fill("0.4")
    yield until(page, "document.activeElement.blur()", f"{BACK} && {QUIET}")
    yield until(page, "document.getElementById('refit').click()", f"!{BACK} && {QUIET}")
    yield from (first, every)
    ranked(page)
    page.wait_for_timeout(REST_MS)
    yield spent(lambda: (page.keyboard.press("1"), effects(page, 3)))
    ranked(page)
    page.wait_for_timeout(REST_MS)
    tab(page, "where")
    spectrum = expect(page.locator("#cell-spectrum svg"))
    yield 1000 * spent(lambda: (page.keyboard.press("w"), spectrum.to_be_visible()))
    page.click("#view-plan")
    expect(page.locator("#plan")).to_have_attribute("aria-busy", "false")
    page.wait_for_timeout(REST_MS)
    sliders = page.locator("#plan-wishes input[type=range]").all()
    yield statistics.median(answer for one in sliders for answer in one.evaluate(PLAN))


def measured(browser, folder):
    """The figures of one session, in the order of GOALS."""
    tabs, bench = Tabs(browser), Started(folder, folder / "state")
    try:
        return list(one_session(tabs.open(bench, 1400, 1000), folder / "state"))
    finally:
        tabs.close()
        bench.stop()


def main(repeats):
    rows = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox"]
        )
        for _ in range(repeats):
            with tempfile.TemporaryDirectory() as folder:
                rows.append(measured(browser, Path(folder)))
        browser.close()
    print("| what | median | worst | goal |\n|---|---|---|---|")
    for (name, goal), values in zip(GOALS.items(), zip(*rows), strict=True):
        print(f"| {name} | {statistics.median(values):.3g} | {max(values):.3g} | {goal:g} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
