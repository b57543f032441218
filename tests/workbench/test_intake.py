"""The first page in a real browser: logs of other programs are dropped, their columns named and
doubted, sensors chosen; each axis has a row in one table.
"""

import math
import random
import re

import pytest
from playwright.sync_api import expect
from recordings_made import dead_zone, flight, foreign, noise, two_axes, written
from visiting import export, held_back, ranked, tab, until

ARW = "[data-kind=angle_random_walk] input[type=number]"


def dropped(page, path):
    page.set_input_files("#file", str(path))
    return page


def choose(page, place, key, value):
    """A quantity, axis, unit or factor of a column in the table."""
    box = page.locator(f"[data-index='{place}'][data-key={key}]")
    if key == "factor":
        box.fill(value)
        box.blur()
    else:
        box.select_option(value)


def read(page):
    page.click("#read")
    page.wait_for_selector("#headline h1")


def arw_of(page):
    return float(page.locator(ARW).first.input_value())


def test_a_log_with_odd_names_is_dropped_guessed_and_read(folder, opened, tabs):
    page = dropped(tabs.open(opened()), foreign(folder / "flight 7.csv"))
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(8)
    said = {
        row.locator("th").inner_text(): [one.input_value() for one in row.locator("select").all()]
        for row in rows.all()
    }
    assert said["GyroX [rad/s]"] == ["gyro", "x", "rad/s"]
    assert said["accZ"] == ["accel", "z", "m/s^2"]
    assert said["<b>vbat</b>"] == ["other", "", ""]
    choose(page, 2, "factor", "0.05")
    read(page)
    expect(page.locator("#recording")).to_contain_text("200 Hz")
    axes = [option.inner_text() for option in page.locator("#axis option").all()]
    assert axes == ["gyro_x_dps", "gyro_z_dps", "accel_x_g", "accel_y_g", "accel_z_g"]
    assert arw_of(page) == pytest.approx(20 * 0.05 / math.sqrt(200) * 60, abs=0.2)
    before = page.locator(ARW).first.input_value()
    page.select_option("#axis", "gyro_x_dps")
    expect(page.locator(ARW).first).not_to_have_value(before)
    assert arw_of(page) == pytest.approx(math.degrees(0.0017) / math.sqrt(200) * 60, abs=0.03)
    tab(page, "columns")
    page.select_option("#against-column", "<b>vbat</b>")
    expect(page.locator("#against .xtitle")).to_have_text("<b>vbat</b>")
    page.reload()
    page.wait_for_selector("#headline h1")
    assert page.locator("#axis").input_value() == "gyro_x_dps"


def test_lines_are_skipped_and_columns_named(folder, opened, tabs):
    """Numbers above a table of numbers."""
    top = "7,1.5,3\n8,1.5,3\n9,2.5,3"
    path = noise(folder / "log.csv", top, lambda i: 0, lambda i: 25, step=10)
    bench = opened(path)
    page = tabs.open(bench)
    first = page.locator("tbody tr").first
    expect(first).to_contain_text("7, 8, 9")
    page.fill("#skip", "3")
    page.locator("#skip").blur()
    expect(first).to_contain_text("0, 10, 20")
    for place, name in enumerate(("time_ms", "gyro_z_dps", "temp_degC")):
        page.locator("input.name").nth(place).fill(name)
    page.click("#names")
    expect(page.locator("#unnamed")).to_have_count(0)
    expect(page.locator("#skip")).to_have_value("3")
    read(page)
    expect(page.locator("#recording")).to_contain_text("100 Hz")
    assert "--names time_ms,gyro_z_dps,temp_degC" in bench.ask("all")["commands"][0]


def test_the_factors_that_a_log_states_are_shown_and_used(folder, opened, tabs):
    """Counts of 0.001 rad/s every 10 ms, as Gyroflow writes them."""
    top = "GYROFLOW IMU LOG\nversion,1.3\ntscale,0.01\ngscale,0.001\nt,gx,gy,gz\n"
    made = random.Random(4)
    counts = ([round(made.gauss(0, 20)) for _ in range(3)] for _ in range(3000))
    rows = (f"{place},{x},{y},{z}\n" for place, (x, y, z) in enumerate(counts))
    (folder / "log.gcsv").write_text(top + "".join(rows))
    page = dropped(tabs.open(opened()), folder / "log.gcsv")
    factor = page.locator("[data-index='1'][data-key=factor]")
    assert float(factor.input_value()) == pytest.approx(math.degrees(0.001), rel=1e-3)
    read(page)
    expect(page.locator("#recording")).to_contain_text("100 Hz")
    assert arw_of(page) == pytest.approx(math.degrees(0.02) / math.sqrt(100) * 60, rel=0.1)


def test_doubts_are_shown_before_anything_is_fitted_and_can_be_corrected(folder, opened, tabs):
    page = tabs.open(opened(noise(folder / "rec.csv", "time_s,gyro_z_dps", step=10000)))
    expect(page.locator("#doubts")).to_contain_text("implausible sample rate 0.0001 Hz")
    page.click("#read")  # unchanged, it is doubted again
    expect(page.locator("#landing")).to_have_js_property("inert", False)
    expect(page.locator("#doubts")).to_be_visible()
    choose(page, 0, "unit", "us")
    read(page)
    expect(page.locator("#recording")).to_contain_text("100 Hz")
    page.click("#close")
    slow = noise(folder / "slow.csv", "time_s,gyro_z_dps", step=10000)
    dropped(page, slow).click("#confirm")
    expect(page.locator("#recording")).to_contain_text("0.0001 Hz")


def test_a_log_is_read_only_when_it_is_long_enough_and_has_a_sensor(folder, opened, tabs):
    page = tabs.open(opened(noise(folder / "log.csv", "time_ms,gyro_z_dps", rows=356, step=10)))
    expect(page.locator("#short")).to_contain_text("356 of at least 1000 samples")
    expect(page.locator("#read")).to_be_disabled()
    page.close()
    page = tabs.open(opened(noise(folder / "a.csv", "ticks,w", step=10000, sigma=0.5)))
    choose(page, 0, "quantity", "time")
    unit = page.locator("[data-index='0'][data-key=unit]")
    expect(unit).to_have_value("us")  # by its numbers
    choose(page, 1, "quantity", "other")
    expect(page.locator("#no-gyro")).to_be_visible()
    expect(page.locator("#read")).to_be_disabled()
    choose(page, 1, "quantity", "gyro")
    expect(page.locator("#read")).to_be_disabled()
    choose(page, 1, "axis", "z")
    expect(page.locator("#no-gyro")).to_be_hidden()
    read(page)
    expect(page.locator("#recording")).to_contain_text("100 Hz")


def test_an_accelerometer_is_analysed_in_its_own_units(folder, opened, tabs):
    """60 s at rest at 100 Hz, with a noise of 0.12 m/s/sqrt(h)."""
    rng, header = random.Random(7), "time_ms,ax (m/s^2),ay (m/s^2),az (m/s^2)"
    rows = (
        ",".join([str(i * 10), *(f"{rng.gauss(mean, 0.02):.6f}" for mean in (0, 0, 9.8))])
        for i in range(6000)
    )
    bench = opened(written(folder / "accel.csv", header, rows))
    page = tabs.open(bench)
    expect(page.locator("#facts")).to_contain_text("VRW of ax (m/s^2)0.12 m/s/√h")
    read(page)
    ranked(page)
    for words in ("VRW", "m/s/√h", "µg"):
        expect(page.locator("#model")).to_contain_text(words)
    assert arw_of(page) == pytest.approx(0.12, abs=0.01)
    for name in ("where", "spectrum", "columns", "sheet", "held", "fit"):
        tab(page, name)
        words = page.inner_text("#bench")
        assert not re.search(r"deg/|\bARW\b|force_accel|angle random", words), name
    box = page.locator("#model .effect[data-kind=bias_instability] input[type=number]").first
    box.fill("40")
    box.press("Enter")
    expect(page.locator(".tread title").last).to_contain_text("bias instability")
    size = bench.ask("step")["cards"][1]["parameters"][0]["value"]
    assert size == pytest.approx(40 * 9.80665e-6 * 3600, abs=1e-6)  # m/s/h
    assert "adev_mps2" in bench.saved("h")
    report = export(page, "report").read_text()
    assert "m/s^2" in report and "deg/s" not in report


@pytest.mark.parametrize(
    ("what", "name"),
    [("candidates", "fit"), ("stretch", "where"), ("against", "columns"), ("axes", "sheet")],
)
def test_nothing_of_a_recording_that_was_left_comes_late(folder, opened, tabs, what, name):
    header = "time_s,gyro_z_dps,temp_degC"
    path = noise(folder / "rec.csv", header, lambda i: 0, lambda i: 20 + i / 999, rows=2000)
    page, refused = tabs.open(opened()), []
    page.on("response", lambda answer: answer.status >= 400 and refused.append(answer.url))
    held = held_back(page, f"**/api/{what}*")
    dropped(page, path)
    page.click(f"#tab-{name}")
    until(page, lambda: held)
    page.click("#close")
    expect(page.locator("#file")).to_be_visible()
    for route in held:
        route.continue_()
    page.unroute(f"**/api/{what}*")
    page.wait_for_load_state("networkidle")
    expect(page.locator("#error")).to_be_hidden()
    # Only the search may be refused: it has been stopped.
    assert all(what == "candidates" and "/api/candidates" in url for url in refused), refused


@pytest.mark.parametrize("width", [1280, 390])
def test_the_names_of_sensors_are_whole(folder, opened, tabs, width):
    log = flight(folder / "flight.bin", [0.1, 0.2])
    page = tabs.open(opened(log), width=width)
    rows = page.locator("[data-sensor] > span")
    expect(rows).to_have_count(2)
    assert rows.evaluate_all("all => all.map((one) => one.scrollWidth <= one.clientWidth)") == [
        True,
        True,
    ]


def test_back_closes_a_recording_and_forward_opens_it_again(folder, opened, tabs):
    page = tabs.open(opened())
    first = page.locator("#choose")
    dropped(page, noise(folder / "rec.csv", "time_s,gyro_z_dps"))
    expect(page.locator("#headline h1")).to_be_visible()
    page.go_back()
    expect(first).to_be_visible()
    page.go_forward()
    expect(page.locator("#headline h1")).to_be_visible()
    page.click("#close")
    expect(first).to_be_visible()
    dropped(page, flight(folder / "flight.bin", [0.1, 0.2]))
    expect(page.locator("[data-sensor]")).to_have_count(2)
    page.go_back()
    expect(first).to_be_visible()


def test_a_page_says_what_it_opens_until_the_first_step_is_there(folder, opened, tabs):
    bench = opened(noise(folder / "rec.csv", "time_s,gyro_z_dps"))
    page = tabs.open(bench)
    expect(page.locator("#headline h1")).to_be_visible()
    late = held_back(page, re.compile("/api/step"))
    page.reload()
    until(page, lambda: late)
    expect(page.locator("#landing h1")).to_have_text("Opening rec.csv")
    late[0].continue_()
    expect(page.locator("#headline h1")).to_be_visible()
    expect(page.locator("#landing")).to_be_hidden()


def test_a_tab_says_that_another_one_has_opened_or_closed_a_recording(folder, opened, tabs):
    bench = opened(noise(folder / "rec.csv", "time_s,gyro_z_dps"))
    page = tabs.open(bench)
    expect(page.locator("#headline h1")).to_be_visible()
    for act, said in (
        (lambda: bench.drop("other.csv", two_axes(folder / "other.csv").read_bytes()), "opened"),
        (lambda: bench.done("close"), "closed rec.csv"),
    ):
        act()
        expect(page.locator("#error-said")).to_contain_text(f"Another tab {said}")
        page.get_by_role("button", name="Open rec.csv again").click()
        expect(page.locator("#recording")).to_contain_text("rec.csv")
        expect(page.locator("#headline h1")).to_be_visible()
        expect(page.locator("#error")).to_be_hidden()
    tabs.forgive("409")  # what the page had requested about the recording before


def test_all_sensors_of_a_log_have_rows_and_one_of_another_sensor_opens_it(folder, opened, tabs):
    sigmas = {"IMU:0": 0.1, "IMU:1": 0.4}
    flight(folder / "flight.bin", [*sigmas.values(), 0.2], short=2)
    page = tabs.open(opened("flight.bin", sensor="IMU:1"))
    tab(page, "axes")

    def cell(axis, sensor):
        name = page.locator(f"[data-axis=gyro_{axis}_dps][data-of='{sensor}']")
        return page.locator("#all-axes tr", has=name).locator("td.n").first

    for sensor, sigma in sigmas.items():
        for axis in "xyz":
            expect(cell(axis, sensor)).to_be_visible()
            arw = 60 * sigma / math.sqrt(200)
            shown = float(cell(axis, sensor).inner_text().split()[0])
            assert shown == pytest.approx(arw, rel=0.06)
    few = page.locator("#all-axes").get_by_text("6 samples; at least 1000 are needed", exact=True)
    expect(few).to_have_count(1)
    page.locator("[data-of='IMU:0'][data-axis=gyro_x_dps]").click()
    expect(page.locator("#axis")).to_have_value("gyro_x_dps")
    assert arw_of(page) == pytest.approx(60 * 0.1 / math.sqrt(200), abs=0.03)
    tab(page, "axes")
    expect(cell("z", "IMU:1")).to_be_visible()


def test_numbers_of_a_recording_that_permits_no_model_are_withheld(folder, opened, tabs):
    """A dead zone, opened while the spectrum of another recording is shown."""
    two_axes(folder / "rec.csv")
    bench = opened("rec.csv")
    page = tabs.open(bench)
    ranked(page)
    tab(page, "spectrum")
    bench.done("open", path=str(dead_zone(folder / "dead.csv")))
    expect(page.locator("#headline")).to_contain_text("not what the sensor measures")
    expect(page.locator("#model .effect").first).to_have_text(re.compile("withheld"))
    expect(page.locator("#error")).to_contain_text("Another tab opened dead.csv")
    page.click("#error-close")
    tab(page, "axes")
    expect(page.locator("#all-axes tbody td.n").first).to_have_text("withheld")
    page.click("#close")
    expect(page.locator(".recent", has_text="dead.csv")).to_contain_text("–")
    tabs.forgive("409")  # what the page had requested about the recording before
