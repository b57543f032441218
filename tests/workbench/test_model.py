"""The page of a model in a real browser: what is clicked, dragged and typed does what it says, and
nothing of an old step can be used while another one is computed.
"""

import math
import random
import re

import pytest
from playwright.sync_api import expect
from recordings_made import effect, noise, simulated, two_axes
from visiting import altered, effects, error, held_back, ranked, tab, unfold, until

# A point of a curve in the window, a fifth of the way along it.
WHERE = """(path) => {
  const at = path.getPointAtLength(path.getTotalLength() / 5).matrixTransform(path.getScreenCTM());
  return [at.x, at.y]; }"""
# The marks of the vertical axis: value, height in the window.
MARKS = """(all) => all.filter((one) => one.getAttribute("text-anchor") === "end")
  .map((one) => [Number(one.textContent), one.getBoundingClientRect().y])
  .filter(([value]) => value > 0)"""
# The highest of the points whose text names a frequency near f.
HIGHEST = """(all, f) => all
  .map((one, i) => [i, parseFloat(one.textContent), Number(one.getAttribute("cy"))])
  .filter(([, hz]) => Math.abs(hz - f) < 0.1 * f).reduce((a, b) => (b[2] <= a[2] ? b : a))[0]"""
# Keeps the headline and the number beside it whenever one of them changes, at the end of the frame.
PAIRS = """() => {
  const at = (id) => document.getElementById(id).textContent, seen = (window.pairs = []);
  const keep = () => seen.push([at("headline").match(/^.*?(?=Not)/)[0], at("error-value")]);
  keep();
  const found = new MutationObserver(keep), what = { childList: true, subtree: true };
  for (const id of ["headline", "error-value"]) found.observe(document.getElementById(id), what);
}"""
BOXES = "(all) => all.map((one) => one.getBoundingClientRect().toJSON())"
BARS = "(all) => all.map((one) => [one.getAttribute('fill'), one.getAttribute('height')])"


def pointer(page, x, y, finger):
    """A function that moves the mouse or a finger to a place `up` from (x, y)."""
    touch = page.context.new_cdp_session(page)
    kinds = {"down": "touchStart", "move": "touchMove", "up": "touchEnd"}

    def point(what, up, across=3):
        at = {"x": x + across, "y": y - up}
        if finger:
            places = [] if what == "up" else [at]
            touch.send("Input.dispatchTouchEvent", {"type": kinds[what], "touchPoints": places})
        else:
            page.mouse.move(**at)
            getattr(page.mouse, what)(**at if what == "move" else {})

    return point


def size_of(bench, place=0):
    return bench.ask("step")["cards"][place]["parameters"][0]["value"]


def test_a_candidate_with_which_the_error_rises_makes_room_for_the_next(opened, tabs):
    page = tabs.open(opened())

    def rising(route, found):
        return {**found, "error": 1.0} if "kind=sinusoid" in route.request.url else found

    altered(page, re.compile("/api/candidate_preview"), rising)
    page.click("#tutorial")
    best = page.locator("#next > .best > .candidate")
    expect(best).to_have_attribute("data-kind", "temperature")
    expect(best).to_be_enabled()


def test_cards_are_in_the_order_of_evidence_and_error_and_say_how_to_confirm(opened, tabs):
    bench = opened()
    page = tabs.open(bench)
    page.click("#tutorial")
    ranked(page)
    cards = page.locator("#next > .card")
    expect(cards.locator(".candidate:disabled")).to_have_count(0)
    shown = [float(text.split("→")[1]) for text in cards.locator(".to").all_inner_texts()]
    labels = cards.locator(".pips").evaluate_all("all => all.map((one) => one.ariaLabel)")
    evidence = [int(re.search(r"(\d) of 4", label)[1]) for label in labels]
    assert len(shown) == 3
    order = [(-pips, error) for pips, error in zip(evidence, shown, strict=True)]
    assert order == sorted(order)
    expect(cards.locator(".confirm:visible")).to_have_count(3)
    page.click("#more summary")  # its errors come one after the other
    expect(page.locator("#more [data-error]").last).to_have_text(re.compile(r"^→ .*, p "))
    assert not page.locator("#more .row", has_text="Line at").count()


def test_a_pair_is_offered_if_no_effect_helps_alone(opened, tabs):
    bench = opened()
    page = tabs.open(bench)

    def alone(route, found):
        both = "also_kind=temperature" in route.request.url
        return {**found, "error": 0.03 if both and "kind=sinusoid" in route.request.url else 1.0}

    altered(page, re.compile("/api/candidate_preview"), alone)
    page.click("#tutorial")
    cards = page.locator("#next > .card")
    expect(cards.locator("h2")).to_have_text(["Line at 0.35 Hz and follows temp_degC"])
    expect(cards.locator(".confirm")).to_contain_text("To confirm")
    page.keyboard.press("1")
    effects(page, 4)
    assert [one["number"] for one in bench.ask("all")["steps"]] == [0, 1]


def contested(folder):
    """Two noises fit both axes; one has a little of what a third column has, a level a second."""

    def third(i):
        return random.Random(i // 50).gauss(0, 0.2)

    header = "time_s,gyro_x_dps,gyro_z_dps,vbat_V"
    noise(folder / "rec.csv", header, lambda i: 0.0, lambda i: 0.02 * third(i), third)
    return "rec.csv"


@pytest.mark.parametrize("times, offered", [(1.0, 1), (1.02, 0)])
def test_what_speaks_against_a_fit_is_proposed_unless_the_error_rises(
    folder, opened, tabs, times, offered
):
    bench = opened(contested(folder))
    page = tabs.open(bench)
    altered(
        page,
        re.compile("/api/candidate_preview"),
        lambda _, answer: {**answer, "error": times * bench.ask("step")["error"]},
    )
    with page.expect_response(re.compile("/api/candidate_preview")):
        page.select_option("#axis", "gyro_z_dps")
    expect(page.locator("#contrary")).to_contain_text("vbat_V, p")
    page.wait_for_timeout(300)
    for where in ("#contrary button", "#next .best button"):
        expect(page.locator(where)).to_have_count(offered)
    expect(page.locator("#to-held-out")).to_have_count(1 - offered)


def test_a_fit_that_a_candidate_contradicts_is_nowhere_green(folder, opened, tabs):
    page = tabs.open(opened(contested(folder)))
    for axis, fits in (("gyro_x_dps", True), ("gyro_z_dps", False)):
        page.select_option("#axis", axis)
        settled = "settled" if fits else ""
        expect(page.locator("#headline h1")).to_contain_text("The model fits")
        expect(page.locator("#untested")).to_contain_text("Not confirmed above")
        expect(page.locator("#contrary")).to_contain_text("Nothing" if fits else "vbat_V, p")
        expect(page.locator("#contrary button")).to_have_count(0 if fits else 1)
        expect(page.locator("#head")).to_have_class(re.compile(f"^head {settled}$"))
        tab(page, "axes")
        row = page.locator("#all-axes tr", has=page.locator(f"[data-axis={axis}]")).locator("td")
        expect(row.nth(0)).to_have_class("good" if fits else "")
        expect(row.nth(1)).to_have_text("Nothing" if fits else re.compile("vbat_V"))
        tab(page, "fit")
    page.click("#contrary button")
    effects(page, 3)


def test_the_error_and_its_words_are_of_one_state(folder, opened, tabs):
    """In the frame in which the words of a step appear; while a value moves, there are no words."""
    line = effect("sinusoid", amplitude_dps=0.02, frequency_hz=3.0)
    bench = opened(simulated(folder, line, seconds=300))
    page = tabs.open(bench)
    best = ranked(page)
    page.evaluate(PAIRS)
    best.click()
    effects(page, 3)
    ranked(page)
    shown = dict(page.evaluate("window.pairs"))
    assert len(shown) == 2
    for number, words in enumerate(("misfit|off by", "fits")):
        (value,) = [value for said, value in shown.items() if re.search(words, said)]
        assert value == f"{bench.ask('step', number=number)['error']:.3f}"
    page.locator("[data-kind=angle_random_walk] input[type=range]").evaluate(
        "(one) => { one.value = 0.7; one.dispatchEvent(new Event('input')); }"
    )
    expect(page.locator("#gauge")).to_contain_text("≈")
    expect(page.locator("#headline h1")).to_be_hidden()


# value, low, high -> what is shown of them
DIGITS = (
    (0.25, 0.25 - 1e-12, 0.25 + 1e-12, "0.250000000", "narrower than shown"),
    (0.25, 0.25 - 1e-9, 0.25 + 1e-9, "0.250000000", "[0.249999999, 0.250000001]"),
    (0.3, 0.298, 0.302, "0.300", "[0.298, 0.302]"),
    (5.0, 4.51, 5.53, "5.00", "[4.51, 5.53]"),
    (-2.34e-5, -3e-5, -1e-5, "-2.34e-5", "[-3.00e-5, -1.00e-5]"),
    (0.35, 0.34999, 0.35001, "0.35000", "[0.34999, 0.35001]"),
    (0.0004, -0.5, 0.5, "0.000", "[-0.500, 0.500]"),
)


def test_digits_follow_the_interval_which_is_shown_of_a_model_that_fits(folder, opened, tabs):
    bench, seen = opened(simulated(folder)), {}

    def given(route, step):
        one = dict(zip(("value", "low", "high"), seen["case"]))
        step["cards"][1]["parameters"][0] |= {**one, "factor": 1.0}
        step["cards"][1]["superfluous"] = one["low"] <= 0 <= one["high"]
        return {**step, "adequate": seen["fits"]}

    page = tabs.open(bench)
    altered(page, re.compile("/api/step"), given)
    for *case, value, interval in DIGITS:
        seen |= {"case": case, "fits": True}
        page.reload()
        row = page.locator(".effect[data-kind=bias_instability]")
        expect(row.locator("input[type=number]").first).to_have_value(value)
        expect(row.locator(".interval").first).to_have_text(interval)
    expect(row).to_have_class("effect nothing")  # the last one contains 0
    expect(row.get_by_label("Remove bias instability")).to_be_visible()
    row.locator("input[type=number]").first.press("ArrowUp")
    expect(row.locator("input[type=number]").first).to_have_value("0.001")
    seen["fits"] = False
    page.reload()
    expect(row.locator("input[type=number]").first).to_be_visible()
    expect(page.locator(".interval")).to_have_count(0)


@pytest.mark.parametrize("finger", [False, True], ids=["mouse", "finger"])
def test_a_curve_is_dragged_to_another_size(folder, opened, tabs, finger):
    bench = opened(simulated(folder))
    page = tabs.open(bench, *((390, 800) if finger else (1400, 1000)), has_touch=finger)
    ranked(page)
    page.locator("#deviation").scroll_into_view_if_needed()
    before = size_of(bench)
    curve = page.locator(".part-hit[data-kind=angle_random_walk]")
    x, y = curve.evaluate(WHERE)
    marks = page.locator("#deviation svg > g:first-child text").evaluate_all(MARKS)
    (low, far), (high, near) = marks[:2]
    decade = abs(near - far) / abs(math.log10(high / low))
    still = page.locator("#deviation path.model").get_attribute("d")
    point = pointer(page, x, y, finger)
    point("down", 0, 0)
    point("move", decade / 6)
    point("move", decade / 3)
    expect(page.locator("#deviation path.model")).not_to_have_attribute("d", still)
    expect(page.locator("#gauge")).to_contain_text("≈")
    point("up", decade / 3)
    expect(page.locator("#back")).to_be_visible()
    assert size_of(bench) / before == pytest.approx(10 ** (1 / 3), rel=0.03)


def test_everything_can_be_done_with_keys(folder, opened, tabs):
    line = effect("sinusoid", amplitude_dps=0.02, frequency_hz=3.0)
    page = tabs.open(opened(simulated(folder, line)))
    ranked(page)
    for key, count in (("1", 3), ("u", 2), ("r", 3)):
        page.keyboard.press(key)
        effects(page, count)
        ranked(page)
    page.locator("#deviation svg").focus()  # a cell, and its neighbours
    page.keyboard.press("w")
    chosen = page.locator("#deviation svg rect[stroke-width='2.5']")
    place = chosen.get_attribute("x")
    page.keyboard.press("ArrowLeft")
    expect(chosen).not_to_have_attribute("x", place)
    page.keyboard.press("?")
    expect(page.locator("#help")).to_be_visible()
    page.keyboard.press("Escape")
    unfold(page, "sinusoid")
    reached = set()
    for name in ("where", "columns"):
        page.locator("[role=tab][aria-selected=true]").focus()
        while page.get_attribute(f"#tab-{name}", "aria-selected") == "false":
            page.keyboard.press("ArrowRight")
        for _ in range(80):  # once around, with the list of other effects unfolded
            page.keyboard.press("Tab")
            reached.add(page.evaluate("document.activeElement.id || document.activeElement.type"))
    buttons = {"undo", "refit", "export", "axis", "alone", "cut", "against-column", "lag"}
    assert buttons | {"range", "number", "checkbox"} <= reached
    buttons = {"zoom", "zoom-reset", "save-svg", "save-png", "stairs-save", "help-button", "theme"}
    assert buttons <= reached


def test_a_saved_picture_has_a_title_units_and_its_source(folder, opened, tabs):
    page = tabs.open(opened(simulated(folder, seconds=300)))
    ranked(page)
    for button, name in (("save-svg", "rec.csv-fit.svg"), ("stairs-save", "rec.csv-error.svg")):
        with page.expect_download() as saved:
            page.click(f"#{button}")
        assert saved.value.suggested_filename == name
        text = saved.value.path().read_text()
        assert "rec.csv, 5 min at 50 Hz. Step 1: a first model" in text
        assert "var(--" not in text
        if button == "save-svg":
            assert "Allan deviation, measured and model, gyro_z_dps" in text and "deg/s" in text
            hits = re.findall('<path[^>]*class="part-hit"[^>]*>', text)  # styled by the page
            assert hits and all("fill: none" in one for one in hits)
    with page.expect_download() as saved:
        page.click("#save-png")
    assert saved.value.path().read_bytes().startswith(b"\x89PNG")


# Do title and source, the last texts of a saved picture, end within it.
WITHIN = """(text) => {
  const box = document.createElement("div");
  box.style.font = "12px sans-serif";
  box.innerHTML = text;
  document.body.append(box);
  const ends = [...box.querySelectorAll("svg > text")].slice(-2).map((one) => one.getBBox());
  const { width } = box.firstChild.viewBox.baseVal;
  box.remove();
  return ends.map((one) => one.x + one.width <= width);
}"""


@pytest.mark.parametrize(
    "shown, title, drawn",
    [("fit", "Allan deviation", "Model, in windows of"), ("columns", "Against", "vbat_V")],
)
def test_a_saved_picture_is_of_the_main_chart_and_whole(folder, opened, tabs, shown, title, drawn):
    page = tabs.open(opened(contested(folder)))
    ranked(page)
    tab(page, shown)
    with page.expect_download() as saved:
        page.click("#save-svg")
    text = saved.value.path().read_text()
    assert title in text and drawn in text
    if shown == "fit":  # its window
        assert f">{page.text_content('#windows [aria-pressed=true]').strip()}<" in text
    assert page.evaluate(WITHIN, text) == [True, True]


def test_one_screen_holds_it_and_the_next_step_is_six_tabs_away(opened, tabs):
    page = tabs.open(opened())
    page.click("#tutorial")
    ranked(page)
    size = "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    assert page.evaluate(size) == [1280, 720]
    for part in ("#headline", "#gauge", "#deviation", "#staircase", ".card.best", "#model"):
        (box,) = page.locator(part).evaluate_all(BOXES)
        assert box["bottom"] <= 720, part
    page.reload()  # from the top of the page; after an action the focus is on the candidate
    ranked(page)
    for _ in range(6):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.matches('.candidate.go')"):
            break
    page.keyboard.press("Enter")
    effects(page, 3)
    ranked(page)
    assert page.evaluate("document.activeElement.tagName") != "BODY"


def test_two_tabs_show_one_state_and_a_slider_is_followed(folder, opened, tabs):
    bench = opened(simulated(folder, seed=6))
    one, two = tabs.open(bench), tabs.open(bench)
    ranked(one), ranked(two)
    slider = one.locator("[data-kind=angle_random_walk] input[type=range]")
    slider.focus()
    slider.press("ArrowRight")
    expect(one.locator("#back")).to_be_visible()
    expect(two.locator("#back")).to_be_visible()
    assert error(one) == error(two)
    ranked(one)  # values by hand keep the list
    unfold(one, "bias_instability")
    one.get_by_label("Remove bias instability").click()
    for page in (one, two):
        expect(page.locator(".effect.off")).to_have_count(1)
    two.get_by_label("Restore bias instability").click()
    expect(one.locator(".effect.off")).to_have_count(0)
    assert len(bench.ask("all")["steps"]) == 4
    size = size_of(bench)
    unfold(one, "angle_random_walk")
    one.get_by_label("hold angle random walk").check()
    one.click("#refit")
    expect(two.locator(".tread title").last).to_contain_text("Fitted around")
    assert size_of(bench) == size


def test_a_click_on_a_peak_adds_a_line_sharp_or_with_a_width(folder, opened, tabs):
    wide = effect("narrow_band", frequency_hz=5.0, half_width_hz=0.2, std_dps=0.02)
    sharp = effect("sinusoid", frequency_hz=0.7, amplitude_dps=0.02)
    bench = opened(simulated(folder, wide, sharp))
    page = tabs.open(bench)
    for kind, f_hz, number in (("sinusoid", 0.7, 0), ("narrow_band", 5.0, 1)):
        ranked(page)
        tab(page, "spectrum")
        point = page.locator("#spectrum circle").evaluate_all(HIGHEST, f_hz)
        page.locator("#spectrum circle").nth(point).click()
        page.locator("#peak button").nth(number).click()
        expect(page.locator(f".effect[data-kind={kind}]")).to_be_visible()
        card = next(one for one in bench.ask("step")["cards"] if one["kind"] == kind)
        found = {one["name"]: one["value"] for one in card["parameters"]}
        assert found["frequency_hz"] == pytest.approx(f_hz, rel=0.01 if number else 1e-4)


def test_w_goes_to_the_cell_of_the_headline_and_arrows_move_from_it(folder, opened, tabs):
    burst = effect("noise_step", start_s=900.0, stop_s=930.0, ratio=6.0)
    bench = opened(simulated(folder, burst, seconds=2400, seed=5))
    page = tabs.open(bench)
    ranked(page)
    named = bench.ask("step")["worst"]
    tab(page, "where")
    page.keyboard.press("w")
    expect(page.locator("#cell-said")).to_contain_text("atio")

    def ends():
        return [float(page.input_value(f"#{end}")) for end in ("from", "to")]

    assert ends() == [named["start_s"], named["stop_s"]]
    said = page.inner_text("#cell b")
    page.locator("#map .hit").nth(40).click()
    expect(page.locator("#cell b")).not_to_have_text(said)
    expect(page.locator("#cell-spectrum svg")).to_be_visible()
    page.locator("#map svg").focus()
    start, stop = ends()
    for key, begin in (("ArrowRight", stop), ("ArrowLeft", start)):
        page.keyboard.press(key)
        expect(page.locator("#from")).to_have_value(f"{begin:g}")
    heights = {}  # signs differ without colour
    for fill, height in page.locator("#map .strip rect").evaluate_all(BARS):
        heights.setdefault(fill, set()).add(round(float(height), 2))
    (low,), (high,) = heights["var(--meas)"], heights["var(--model)"]
    assert low / high == pytest.approx(2, abs=0.1)


def test_where_lists_every_section_in_which_a_misfit_is_proven(folder, opened, tabs):
    bursts = [effect("noise_step", start_s=s, stop_s=s + 60.0, ratio=6.0) for s in (300.0, 1800.0)]
    bench = opened(simulated(folder, *bursts, seconds=2400, seed=5))
    page = tabs.open(bench)
    one = {"tau_s": 0.02, "proven": True, "ratio": 2.0, "z": 9.0, "measured": 2.0, "model": 1.0}

    def found(route, step):
        places = ((300.0, 450.0, 2.0), (450.0, 600.0, 3.0), (1800.0, 1950.0, 0.5))
        cells = [{**one, "start_s": a, "stop_s": b, "ratio": ratio} for a, b, ratio in places]
        return {**step, "map": cells}

    altered(page, re.compile("/api/step"), found)
    page.reload()
    tab(page, "where")
    shown = page.locator("#cell .sections button")
    assert shown.all_inner_texts() == [
        "5 to 10 min: 3.0× too low at 0.02 s",
        "30 to 32.5 min: 2.0× too high at 0.02 s",
    ]
    shown.first.click()
    expect(page.locator("#from")).to_have_value("450")  # its worst cell
    page.click("#cell button:has-text('All sections')")
    expect(shown).to_have_count(2)


def test_a_thumbnail_is_drawn_large(folder, opened, tabs):
    header = "time_s,gyro_z_dps,vbat_V,temp_degC"
    third = lambda i: math.sin(i / 300)  # noqa: E731
    noise(folder / "rec.csv", header, lambda i: 0.1 * third(i), third, lambda i: 25 + i / 1e4)
    page = tabs.open(opened("rec.csv"))
    tab(page, "columns")
    for column, what in (("temp_degC", "noise"), ("vbat_V", "bias")):
        thumb = page.locator(f"#columns .thumb[data-column={column}][data-what={what}]")
        assert thumb.locator("circle").count() > 20
        thumb.click()
        expect(page.locator("#against-column")).to_have_value(column)
        expect(page.locator("#against-what")).to_have_value(what)
        expect(page.locator("#lag")).to_be_visible(visible=what == "bias")
        expect(page.locator("#against")).to_contain_text("Noise" if what == "noise" else "Residual")
    expect(page.locator("#columns .thumb.tied").first).to_have_attribute("data-column", "vbat_V")


def test_live_and_plan_leave_the_tabs_where_they_are(opened, tabs):
    page = tabs.open(opened())
    page.click("#tutorial")
    ranked(page)
    names = page.locator("#tablist [role=tab]").all_inner_texts()
    assert names == ["Fit", "Where", "Spectrum", "Columns", "Axes", "Data sheet", "Hold-out"]
    assert page.locator("#tablist .group").all_inner_texts() == ["Look", "Compare"]
    page.click("#tab-live")
    expect(page.locator("#panel-live")).to_be_visible()
    expect(page.locator("#tablist [aria-selected=true]")).to_have_count(0)
    tab(page, "where")
    expect(page.locator("#panel-live")).to_be_hidden()
    page.click("#view-plan")
    expect(page.locator("#plan")).to_be_visible()
    for shown in ("#recording", "#axis", "#tab-live"):
        expect(page.locator(shown)).to_be_visible()
    page.click("#view-model")
    expect(page.locator("#panel-where")).to_be_visible()
    page.click("#view-plan")
    page.click("#tab-live")
    expect(page.locator("#plan")).to_be_hidden()
    expect(page.locator("#panel-live")).to_be_visible()


def test_a_recording_is_held_out_and_one_without_the_column_is_named(folder, opened, tabs):
    one = two_axes(folder / "one.csv")
    bench = opened(one)
    bench.done("selection", column="gyro_z_dps")
    page = tabs.open(bench)
    page.set_input_files("#held-file", noise(folder / "two.csv", "time_s,gyro_z_dps"))
    expect(page.locator("#held-name")).to_have_text("two.csv")
    expect(page.locator("#held-out-error")).to_contain_text("floor")
    assert f"{bench.ask('held_out')['error']:.3f}" in page.inner_text("#held-out-error")
    tab(page, "held")
    expect(page.locator("#held-steps tbody tr")).to_have_count(1)
    page.select_option("#axis", "gyro_x_dps")
    expect(page.locator("#held-out-error")).to_contain_text("no column gyro_x_dps")
    for name in ("where", "spectrum", "columns", "sheet", "held"):
        tab(page, name)
    expect(page.locator("#axes svg")).to_be_attached()
    page.click("#let-go")
    expect(page.locator("#held-name")).to_have_text("")
    page.close()
    bench.stop()
    page = tabs.open(opened(one))
    wrong = noise(folder / "wrong.csv", "time_s,temp_degC", rows=1500)
    page.set_input_files("#held-file", wrong)
    expect(page.locator("#error")).to_contain_text("gyro_")
    tabs.forgive("400")


def test_a_model_that_fails_on_the_held_out_recording_is_not_green(folder, opened, tabs):
    bench = opened(noise(folder / "one.csv", "time_s,gyro_z_dps"))
    two = noise(folder / "two.csv", "time_s,gyro_z_dps", seed=4)
    bench.drop("two.csv", two.read_bytes(), purpose="held-out")
    page = tabs.open(bench)
    expect(page.locator("#head")).to_have_class("head settled")
    altered(page, re.compile("/api/held_out"), lambda route, found: {**found, "fails": True})
    page.reload()
    expect(page.locator("#contrary")).to_contain_text("does not fit the held-out recording")
    expect(page.locator("#held-out-error")).to_contain_text("floor")
    expect(page.locator("#head")).to_have_class("head ")


def test_a_kalibr_file_is_drawn_as_a_data_sheet(folder, opened, tabs):
    page = tabs.open(opened(simulated(folder, seed=25)))
    late = held_back(page, "**/api/axes*")
    page.reload()
    page.click("#tab-sheet")
    sheet = folder / "imu.yaml"
    sheet.write_text("gyroscope_noise_density: 1.0e-04\ngyroscope_random_walk: 1.0e-06\n")
    page.set_input_files("#kalibr", sheet)
    expect(page.locator("#sheet-rrw")).not_to_have_value("")
    arw = float(page.input_value("#sheet-arw"))
    assert arw == pytest.approx(1e-4 * 180 / math.pi * 60, abs=1e-5)
    until(page, lambda: late)  # the data sheet may be there before the axes
    for route in late:
        route.continue_()
    page.unroute("**/api/axes*")
    expect(page.locator("#axes")).to_contain_text("data sheet")
    expect(page.locator("#error")).to_be_hidden()
    tab(page, "fit")
    expect(page.locator("#deviation")).to_contain_text("data sheet")
