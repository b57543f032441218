"""How the workbench feels: a real browser on 360 000 and on 1 000 000 samples (one call of
tools/test --only workbench makes the environment):

build/venv-browser/bin/python tests/workbench/benchmark_page.py [REPEATS]
"""

import statistics
import sys
import time
import unittest
from pathlib import Path

from playwright.sync_api import expect
from visiting import FIRST, Visiting, ranked, run, tab

GOALS = {
    "first curve after the file is there, s": 3.0,
    "slider to curve, ms": 16.0,
    "value set by hand to verdict, ms": 300.0,
    "refit, ms": 300.0,
    "first candidates, s": 1.0,
    "all candidates, s": 3.0,
    "a candidate added, s": 1.0,
    "cell to its samples, ms": 300.0,
    "slider to plan, ms": 100.0,
    "10^6 samples: slider to curve, ms": 16.0,
    "10^6 samples: release to last chart, ms": 300.0,
    "10^6 samples: record drawn, ms": 300.0,
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


PLAN = """async (input) => {
  const spent = [], plan = document.getElementById("plan");
  for (const value of [...Array(Number(input.max) + 1).keys()].map(String)) {
    const begin = performance.now();
    input.value = value;
    input.dispatchEvent(new Event("input", { bubbles: true }));
    while (plan.getAttribute("aria-busy") === "true") await new Promise(requestAnimationFrame);
    spent.push(performance.now() - begin);
  }
  input.value = input.id.match(/ram|flash/) ? input.max : "0";
  input.dispatchEvent(new Event("input", { bubbles: true }));
  while (plan.getAttribute("aria-busy") === "true") await new Promise(requestAnimationFrame);
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
REST_MS = (
    3000  # until the charts below are drawn too: what a person does next does not wait for them
)


def until(page, act, wanted):
    """Milliseconds from an action in the page until a condition holds there, seen at each frame."""
    return page.evaluate(UNTIL.format(act=act, wanted=wanted))


def spent(work):
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def one_visit(case):
    found, bench = {}, case.open()
    page = case.page(bench)
    page.click("#tutorial")
    page.wait_for_selector("#headline h1")
    page.click("#close")
    expect(page.locator("#tutorial")).to_be_visible()
    Path(case.folder / "davarlab-files/tutorial_sensor.csv.davarlab.json").unlink()
    found["first curve after the file is there, s"] = spent(
        lambda: (page.click("#tutorial"), page.wait_for_selector("#deviation path.model"))
    )
    found["first candidates, s"] = spent(
        lambda: expect(page.locator("#next .early, .candidate").first).to_be_visible()
    )
    found["all candidates, s"] = found["first candidates, s"] + spent(lambda: ranked(page))
    page.wait_for_timeout(REST_MS)
    slider = page.locator("[data-kind=angle_random_walk] input[type=range]")
    found["slider to curve, ms"] = statistics.median(slider.evaluate(SLIDE))
    box = page.locator("[data-kind=angle_random_walk] input[type=number]")
    page.wait_for_timeout(REST_MS)
    box.fill("0.4")
    found["value set by hand to verdict, ms"] = until(
        page, "document.activeElement.blur()", f"{BACK} && {QUIET}"
    )
    page.wait_for_timeout(REST_MS)
    found["refit, ms"] = until(
        page, "document.getElementById('refit').click()", f"!{BACK} && {QUIET}"
    )
    ranked(page)
    page.wait_for_timeout(REST_MS)
    found["a candidate added, s"] = spent(
        lambda: (page.keyboard.press("1"), expect(page.locator(".effect")).to_have_count(3))
    )
    ranked(page)
    page.wait_for_timeout(REST_MS)
    tab(page, "where")
    found["cell to its samples, ms"] = 1000 * spent(
        lambda: (
            page.keyboard.press("w"),
            expect(page.locator("#cell-spectrum svg")).to_be_visible(),
        )
    )
    page.click("#tab-plan")
    expect(page.locator("#plan")).to_have_attribute("aria-busy", "false")
    page.wait_for_timeout(REST_MS)
    found["slider to plan, ms"] = statistics.median(
        answer
        for one in page.locator("#plan-wishes input[type=range]").all()
        for answer in one.evaluate(PLAN)
    )
    return found


def long_visit(case):
    """The charts of a record of 1 000 000 samples."""
    found, scenario = {}, case.folder / "long.toml"
    scenario.write_text(
        FIRST.format(rate=100.0, column="gyro_z_dps") + "[simulate]\nseed = 3\nduration_s = 10000\n"
    )
    assert run("simulate", scenario, "-o", case.folder / "long.csv").returncode == 0
    page = case.page(case.open("long.csv"))
    expect(page.locator("#to-held-out")).to_be_visible()
    page.wait_for_timeout(REST_MS)
    slider = page.locator("[data-kind=angle_random_walk] input[type=range]")
    found["10^6 samples: slider to curve, ms"] = statistics.median(slider.evaluate(SLIDE))
    release = (
        "document.querySelector('[data-kind=angle_random_walk] input[type=range]')"
        ".dispatchEvent(new Event('change', { bubbles: true }))"
    )
    found["10^6 samples: release to last chart, ms"] = until(page, release, f"{BACK} && {QUIET}")
    page.wait_for_timeout(REST_MS)
    found["10^6 samples: record drawn, ms"] = until(
        page,
        "document.getElementById('tab-where').click()",
        "document.querySelector('#map .record')",
    )
    return found


class Benchmark(Visiting):
    def runTest(self):
        self.rows = one_visit(self) | long_visit(self)


def main(repeats):
    Benchmark.setUpClass()
    rows = []
    for _ in range(repeats):
        case = Benchmark()
        result = unittest.TestResult()
        case.run(result)
        for _, why in result.errors + result.failures:
            raise SystemExit(why)
        rows.append(case.rows)
    Benchmark.tearDownClass()
    print("| what | median | worst | goal |\n|---|---|---|---|")
    for name, goal in GOALS.items():
        values = [row[name] for row in rows]
        print(f"| {name} | {statistics.median(values):.3g} | {max(values):.3g} | {goal:g} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
