"""The chart of the Allan deviation and the staircase: the curves are those of the model, the ticks
its verdicts, and what a hand, the keys and the pointer do on the chart.
"""

import bisect
import math
import re

import pytest
from playwright.sync_api import expect
from recordings_made import effect, noise, simulated, two_axes
from visiting import accessible, effects, ranked

LINE_HZ = 0.8
SPAN = re.compile("^[0-9.]+ m?s to [0-9.]+ (s|min)$")


def at(curve, values, tau_s):
    """A drawn curve between two of its points."""
    x = [math.log(one) for one in curve["tau_s"]]
    i = min(max(bisect.bisect(x, math.log(tau_s)), 1), len(x) - 1)
    share = (math.log(tau_s) - x[i - 1]) / (x[i] - x[i - 1])
    return math.exp((1 - share) * math.log(values[i - 1]) + share * math.log(values[i]))


def test_the_curves_pass_through_the_verdicts_values_and_a_line_has_its_lobes(folder, opened):
    line = effect("sinusoid", amplitude_dps=0.05, frequency_hz=LINE_HZ)
    bench = opened(simulated(folder, line))
    bench.done("add", place=bench.candidate("sinusoid"))
    drawn = bench.ask("step")["deviation"]
    curve = drawn["curve"]
    octave = sum(1.0 < tau <= 2.0 for tau in curve["tau_s"])
    assert octave == 8
    for tau, model in zip(drawn["tau_s"], drawn["model"]):
        assert at(curve, curve["model"], tau) == pytest.approx(model, rel=1e-6)
    for low, value, high in zip(drawn["measured_low"], drawn["measured"], drawn["measured_high"]):
        assert low < value < high
    lobes = next(one["curve"] for one in drawn["effects"] if one["kind"] == "sinusoid")
    for cycles in (0.25, 0.37, 1.5):  # sin^2(pi f tau) / (pi f tau) of the amplitude
        true = 0.05 * math.sin(math.pi * cycles) ** 2 / (math.pi * cycles)
        assert at(curve, lobes, cycles / LINE_HZ) == pytest.approx(true, rel=0.05)
    (place,) = (i for i, one in enumerate(bench.ask("step")["cards"]) if one["kind"] == "sinusoid")
    held = bench.ask("preview", place=place, name="frequency_hz", value=2 * LINE_HZ)["curve"]
    assert held["tau_s"] == curve["tau_s"]
    assert at(held, held["model"], 0.5 / LINE_HZ) < at(curve, curve["model"], 0.5 / LINE_HZ) / 2


def test_a_drag_the_wheel_and_keys_zoom_and_all_of_it_comes_back(folder, opened, tabs):
    page = tabs.open(opened(simulated(folder)))
    ranked(page)
    span, every = page.locator("#zoomed"), page.locator("#zoom-all")
    model = page.locator("#deviation path.model")
    whole = model.get_attribute("d")
    box = page.locator("#deviation").bounding_box()
    x, y = box["x"] + 0.25 * box["width"], box["y"] + 0.4 * box["height"]

    def drag():
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y + 5)
        page.mouse.move(x + 180, y + 5)
        page.mouse.up()

    ways = (
        (drag, lambda: page.mouse.dblclick(x, y)),
        (lambda: (page.mouse.move(x, y), page.mouse.wheel(0, -400)), every.click),
        (lambda: page.press("#deviation svg", "+"), lambda: page.press("#deviation svg", "Escape")),
        (lambda: page.click("#zoom"), lambda: page.click("#zoom-reset")),
    )
    expect(every).to_be_hidden()
    for zoom, back in ways:
        zoom()
        expect(span).to_have_text(SPAN)
        expect(every).to_be_visible()
        assert model.get_attribute("d") != whole
        back()
        expect(every).to_be_hidden()
        expect(span).to_have_text("")
        expect(model).to_have_attribute("d", whole)
    assert page.evaluate("getSelection().toString()") == ""
    drag()
    expect(every).to_be_visible()
    accessible(page)


def test_two_fingers_zoom_and_one_still_scrolls(folder, opened, tabs):
    page = tabs.open(opened(simulated(folder)), 390, 800, has_touch=True)
    ranked(page)
    page.locator("#deviation").scroll_into_view_if_needed()
    box = page.locator("#deviation").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 0.4 * box["height"]
    touch = page.context.new_cdp_session(page)

    def fingers(what, apart):
        places = [{"x": x - apart, "y": y, "id": 0}, {"x": x + apart, "y": y, "id": 1}]
        given = {"type": what, "touchPoints": [] if what == "touchEnd" else places}
        touch.send("Input.dispatchTouchEvent", given)

    for what, apart in (("touchStart", 20), ("touchMove", 25), ("touchMove", 60), ("touchEnd", 0)):
        fingers(what, apart)
    expect(page.locator("#zoomed")).to_have_text(SPAN)
    page.click("#zoom-all")
    expect(page.locator("#zoomed")).to_have_text("")
    assert page.evaluate("getComputedStyle(document.getElementById('deviation')).touchAction") == (
        "pan-y"
    )


def test_one_crosshair_reads_out_the_chart_and_the_cell_below(folder, opened, tabs):
    page = tabs.open(opened(simulated(folder)))
    ranked(page)
    cell = page.locator("#deviation .strip rect").nth(3)
    cell.hover(force=True)
    readout = page.locator("#readout")
    expect(readout).to_have_text(
        re.compile(r"s: measured [\d.e-]+ \[.*\], model [\d.e-]+, [\d.]+×; .+ to .+: [\d.]+×$")
    )
    chosen = page.locator("#deviation rect[stroke-width='2.5']")
    expect(chosen).to_have_attribute("width", "0")
    cell.click(force=True)
    expect(chosen).not_to_have_attribute("width", "0")
    said = readout.inner_text()
    page.mouse.move(5, 5)
    expect(readout).to_have_text(said)  # the selected cell
    page.press("#deviation svg", "w")  # with keys, the cell that the headline names
    expect(readout).to_contain_text("measured")


def test_a_step_an_axis_or_a_second_recording_is_laid_over(folder, opened, tabs):
    bench = opened(two_axes(folder / "one.csv"))
    bench.done("add", place=0)
    page = tabs.open(bench)
    ranked(page)
    page.set_input_files("#held-file", noise(folder / "two.csv", "time_s,gyro_z_dps,gyro_x_dps"))
    choices = page.locator("#over option")
    expect(choices).to_have_count(4)
    for number in (1, 2, 3):
        page.select_option("#over", index=number)
        expect(page.locator("#deviation path.overlay")).to_have_attribute("d", re.compile("^M"))
        name = choices.nth(number).inner_text()
        expect(page.locator("#deviation")).to_contain_text(name[:15])
    page.select_option("#over", "")
    expect(page.locator("#deviation path.overlay")).to_have_count(0)


def test_a_tick_of_the_staircase_is_the_verdict_of_its_step_then_and_later(folder, opened, tabs):
    line = effect("sinusoid", amplitude_dps=0.02, frequency_hz=3.0)
    bench = opened(simulated(folder, line))
    page = tabs.open(bench)
    ranked(page).click()
    effects(page, 3)
    ticks = page.locator("#staircase .tread", has_text="✓")
    expect(page.locator("#head")).to_have_class(re.compile("settled"))
    expect(ticks).to_have_count(1)
    expect(ticks).to_contain_text("+ line at 3 Hz")
    value = {"coefficient_deg_per_sqrt_h": 1.0}
    bench.done("set", place=0, kind="angle_random_walk", parameters=value)
    expect(page.locator("#staircase .tread")).to_have_count(3)
    expect(ticks).to_contain_text("+ line at 3 Hz")  # of a model that fits no more, the one before
    page.reload()
    expect(page.locator("#staircase .tread")).to_have_count(3)
    expect(ticks).to_have_count(1)
    assert [one["fits"] for one in bench.ask("all")["steps"]][:2] == [False, True]
    # axis and labels in one unit
    shown = [one["error"] for one in bench.ask("all")["steps"]]
    last = float(page.locator("#staircase .tread .strong").last.text_content())
    assert last == pytest.approx(shown[2], abs=5.1e-4)
    marks = page.locator("#staircase > svg > text[text-anchor=end]").all_text_contents()
    assert max(float(one) for one in marks if one != "Error") < 1.15 * shown[2]
