"""The first page in a real browser: logs of other programs are dropped, their columns named and
doubted, sensors chosen; each axis has a row in one table.
"""

import gzip
import math
import random
import re

import pytest
from playwright.sync_api import expect
from recordings_made import dead_zone, flight, foreign, noise, two_axes, written
from visiting import (
    accessible,
    altered,
    effects,
    export,
    held_back,
    ranked,
    shot,
    tab,
    told,
    until,
)

ARW = "[data-kind=angle_random_walk] input[type=number]"
BOXES = "(all) => all.map((one) => one.getBoundingClientRect().toJSON())"


def dropped(page, path):
    page.set_input_files("#file", str(path))
    return page


def factor(page, place, value):
    page.fill(f"input[data-index='{place}'][data-key=factor]", value)
    page.locator(f"input[data-index='{place}'][data-key=factor]").blur()


def unit(page, place, value):
    page.select_option(f"select[data-index='{place}'][data-key=unit]", value)


def read(page):
    page.click("#read")
    page.wait_for_selector("#headline h1")


def row_of(page, axis, sensor=None):
    name = f"[data-axis={axis}]" + (f"[data-of='{sensor}']" if sensor else "")
    return page.locator("#all-axes tr", has=page.locator(name))


def arw_of(page):
    return float(page.locator(ARW).first.input_value())


def test_a_log_with_odd_names_is_dropped_guessed_and_read(folder, opened, tabs):
    page = tabs.open(opened())
    dropped(page, foreign(folder / "flight 7.csv"))
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(8)
    said = {
        row.locator("th").inner_text(): [one.input_value() for one in row.locator("select").all()]
        for row in rows.all()
    }
    assert said["GyroX [rad/s]"] == ["gyro", "x", "rad/s"]
    assert said["accZ"] == ["accel", "z", "m/s^2"]
    assert said["<b>vbat</b>"] == ["other", "", ""]
    shot(page, "columns")
    factor(page, 2, "0.05")
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


def test_the_columns_of_a_file_without_names_are_named_in_the_table(folder, opened, tabs):
    raw = foreign(folder / "raw.txt")
    raw.write_text("Logger 7\n" + raw.read_text().split("\n", 1)[1])
    bench = opened()
    page = dropped(tabs.open(bench), raw)
    expect(page.locator("#unnamed")).to_be_visible()
    names = ["time_us", "gyro_x_rad_s", "gyro_z_raw", "", "", "", "temp_degC", "_"]
    for row, name in zip(page.locator("tbody tr").all(), names):
        row.locator("input.name").fill(name)
    page.click("#names")
    expect(page.locator("#unnamed")).to_have_count(0)
    names = [name or f"column_{place}" for place, name in enumerate(names, 1)]
    expect(page.locator("tbody th")).to_have_text([name for name in names if name != "_"])
    expect(page.locator("#landing")).to_contain_text("separated by semicolons, 1 line above")
    factor(page, 2, "0.05")
    read(page)
    expect(page.locator("#recording")).to_contain_text("200 Hz")
    assert f"--names {','.join(names)}" in bench.ask("all")["commands"][0]


def test_lines_are_skipped_and_columns_named(folder, opened, tabs):
    """Numbers above a table of numbers."""
    top = "7,1.5,3\n8,1.5,3\n9,2.5,3"
    path = noise(folder / "log.csv", top, lambda i: 0, lambda i: 25, step=10)
    page = tabs.open(opened(path))
    first = page.locator("tbody tr").first
    expect(first).to_contain_text("7, 8, 9")
    page.fill("#skip", "3")
    page.locator("#skip").blur()
    expect(first).to_contain_text("0, 10, 20")
    expect(page.locator("#log-said")).to_contain_text("6000 rows, 3 lines skipped")
    for place, name in enumerate(("time_ms", "gyro_z_dps", "temp_degC")):
        page.locator("input.name").nth(place).fill(name)
    page.click("#names")
    expect(page.locator("#unnamed")).to_have_count(0)
    expect(page.locator("#skip")).to_have_value("3")
    read(page)
    expect(page.locator("#recording")).to_contain_text("100 Hz")


def test_doubts_are_shown_before_anything_is_fitted_and_can_be_corrected(folder, opened, tabs):
    path = noise(folder / "rec.csv", "time_s,gyro_z_dps", step=10000)
    page = tabs.open(opened(path))
    expect(page.locator("#doubts")).to_contain_text(
        "implausible sample rate 0.0001 Hz (gyros: 0.02 Hz to 40 kHz). If the time is in us, "
        "the rate is 100 Hz: use --unit time=us"
    )
    shot(page, "doubt")
    page.click("#read")  # unchanged, it is doubted again
    expect(page.locator("#landing")).to_have_js_property("inert", False)
    expect(page.locator("#doubts")).to_be_visible()
    unit(page, 0, "us")
    read(page)
    expect(page.locator("#recording")).to_contain_text("100 Hz")
    page.click("#close")
    slow = noise(folder / "slow.csv", "time_s,gyro_z_dps", step=10000)
    dropped(page, slow).click("#confirm")
    expect(page.locator("#recording")).to_contain_text("0.0001 Hz")
    page.close()
    loud = noise(folder / "loud.csv", "time_ms,gz (deg/s)", step=10, sigma=5e4)
    page = tabs.open(opened(loud))
    expect(page.locator("#doubts")).to_contain_text("implausible level")
    factor(page, 1, "1e-6")
    expect(page.locator("#doubts")).to_be_hidden()
    read(page)
    assert arw_of(page) == pytest.approx(0.05 / 10 * 60, abs=0.02)


@pytest.mark.parametrize("header", ["usec,gyro_z_dps", "ticks,gyro_z_dps"])
def test_a_column_declared_as_the_time_gets_the_unit_of_its_numbers(folder, opened, tabs, header):
    page = tabs.open(opened(noise(folder / "rec.csv", header, step=10000)))
    page.select_option("select[data-index='0'][data-key=quantity]", "time")
    assert page.locator("select[data-index='0'][data-key=unit]").input_value() == "us"
    read(page)
    expect(page.locator("#recording")).to_contain_text("100 Hz")


def test_a_short_log_shows_what_it_permits(folder, opened, tabs):
    path = noise(folder / "log.csv", "time_ms,gyro_z_dps", rows=356, step=10)
    page = tabs.open(opened(path))
    expect(page.locator("#short")).to_contain_text("356 of at least 1000 samples")
    expect(page.locator("#short")).to_contain_text("Record at least 10 s")
    expect(page.locator("#facts")).to_contain_text("100 Hz")
    expect(page.locator("#facts")).to_contain_text("deg/√h")
    expect(page.locator("#read")).to_be_disabled()
    accessible(page)
    shot(page, "import-short")


def test_a_log_without_a_sensor_is_not_offered_to_be_read(folder, opened, tabs):
    page = tabs.open(opened(noise(folder / "a.csv", "time_s,w", sigma=0.5)))
    page.select_option("select[data-index='1'][data-key=quantity]", "other")
    expect(page.locator("#no-gyro")).to_be_visible()
    expect(page.locator("#read")).to_be_disabled()
    page.select_option("select[data-index='1'][data-key=quantity]", "gyro")
    expect(page.locator("#read")).to_be_disabled()
    page.select_option("select[data-index='1'][data-key=axis]", "z")
    expect(page.locator("#no-gyro")).to_be_hidden()
    read(page)


def test_an_accelerometer_is_analysed_in_its_own_units(folder, opened, tabs):
    """60 s at rest at 100 Hz, with a noise of 0.12 m/s/sqrt(h)."""

    def at_rest(name, seed):
        rng, header = random.Random(seed), "time_ms,ax (m/s^2),ay (m/s^2),az (m/s^2)"
        rows = (
            f"{i * 10},{rng.gauss(0, 0.02):.6f},{rng.gauss(0, 0.02):.6f},{rng.gauss(9.8, 0.02):.6f}"
            for i in range(6000)
        )
        return written(folder / name, header, rows)

    bench = opened(at_rest("accel.csv", 7))
    page = tabs.open(bench)
    expect(page.locator("#facts")).to_contain_text("VRW of ax (m/s^2)0.12 m/s/√h")
    read(page)
    ranked(page)
    for words in ("VRW", "m/s/√h", "µg"):
        expect(page.locator("#model")).to_contain_text(words)
    walk = bench.ask("step")["cards"][0]["parameters"][0]
    assert walk["low"] < 0.12 < walk["high"]
    assert arw_of(page) == pytest.approx(0.12, abs=0.01)
    for name in ("where", "spectrum", "columns", "sheet", "held", "fit"):
        tab(page, name)
        words = page.inner_text("#bench")
        assert not re.search(r"deg/|\bARW\b|force_mps2|angle random", words), name
        shot(page, f"accel-{name}")
    expect(page.locator("#deviation")).to_contain_text("m/s²")
    accessible(page)
    box = page.locator("#model .effect[data-kind=bias_instability] input[type=number]").first
    box.fill("40")
    box.press("Enter")
    expect(page.locator(".tread title").last).to_contain_text("bias instability")
    step = bench.ask("step")
    size = step["cards"][1]["parameters"][0]["value"]
    assert size == pytest.approx(40 * 9.80665e-6 * 3600, abs=1e-6)  # m/s/h
    assert 'kind = "velocity_random_walk"' in bench.saved()
    assert "velocity_random_walk: coefficient_m_per_s_per_sqrt_h = 0.1" in bench.saved("h")
    assert "adev_mps2" in bench.saved("h")
    assert "accelerometer_noise_density" in bench.saved("kalibr")
    report = export(page, "report").read_text()
    assert "m/s^2" in report and "deg/s" not in report
    page.set_input_files("#held-file", at_rest("second.csv", 8))
    expect(page.locator("#held-out-error")).to_contain_text("floor")
    shown = bench.ask("held_out")
    assert shown["error"] < 2 * shown["floor"]  # of the same noise


def test_nothing_of_a_recording_that_was_left_comes_late(folder, opened, tabs):
    log = foreign(folder / "flight.csv")
    page = tabs.open(opened())
    late, over = held_back(page, re.compile("/api/candidates")), []
    for ended in ("requestfinished", "requestfailed"):
        page.on(ended, lambda one: "/api/candidates" in one.url and over.append(one))
    dropped(page, log)
    factor(page, 2, "0.05")
    page.click("#read")
    until(page, lambda: len(late) == 1)  # the answer is under way
    page.select_option("#axis", index=1)
    until(page, lambda: len(late) == 2)
    page.click("#close")
    expect(page.locator("#file")).to_be_attached()
    for route in late:
        route.continue_()
    until(page, lambda: len(over) == len(late))
    expect(page.locator("#error")).to_be_hidden()


@pytest.mark.parametrize(
    "what, name", [("stretch", "where"), ("against", "columns"), ("axes", "sheet")]
)
def test_no_picture_of_a_recording_that_was_left_is_requested(folder, opened, tabs, what, name):
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
    assert refused == []


def test_a_file_that_is_no_recording_is_refused_in_one_line(opened, tabs):
    page = tabs.open(opened())
    for name, data in (
        ("photo.png", b"\x89PNG\r\n\x1a\n\0\0\0"),
        ("empty.csv", b""),
        ("words.csv", b"time_s,gyro_z_dps\n0,fast\n"),
        ("cut.csv.gz", gzip.compress(b"a,b\n1,2\n" * 1000)[:40]),
    ):
        page.set_input_files("#file", {"name": name, "mimeType": "text/csv", "buffer": data})
        expect(page.locator("#error")).to_contain_text(name)
        assert "Traceback" not in page.inner_text("body")
    assert page.locator("#tutorial").is_visible()
    tabs.forgive("400")


def test_each_axis_has_a_row_and_opens_there(folder, opened, tabs):
    recording = two_axes(folder / "rec.csv")
    page = tabs.open(opened(recording))
    tab(page, "axes")
    fitted = told("fit", recording, "--axes", "gyro")["axes"]
    for column, name in (("gyro_x_dps", "follows temp_degc"), ("gyro_z_dps", "line at 1 hz")):
        row = row_of(page, column)
        expect(row.locator("td.n").first).to_be_visible()
        cells = [text.split("\n")[0] for text in row.locator("td").all_inner_texts()]
        assert name in cells[1].lower()
        size = fitted[column]["effects"][0]["parameters"]["coefficient_deg_per_sqrt_h"]["value"]
        assert float(cells[2]) == float(f"{size:.3g}")
    shot(page, "axes")
    page.click("[data-axis=gyro_x_dps]")
    expect(page.locator("#tab-fit")).to_have_attribute("aria-selected", "true")
    expect(page.locator("#axis")).to_have_value("gyro_x_dps")
    ranked(page, "temperature").click()  # the row follows the model
    effects(page, 3)
    tab(page, "axes")
    expect(row_of(page, "gyro_x_dps").locator("td").nth(1)).to_have_text("Nothing")


def test_all_sensors_of_a_log_have_rows_and_one_of_another_sensor_opens_it(folder, opened, tabs):
    sigmas = {"IMU:0": 0.1, "IMU:1": 0.4}
    flight(folder / "flight.bin", [*sigmas.values(), 0.2], short=2)
    page = tabs.open(opened("flight.bin", sensor="IMU:1"))
    tab(page, "axes")
    for sensor, sigma in sigmas.items():
        for axis in "xyz":
            cell = row_of(page, f"gyro_{axis}_dps", sensor).locator("td.n").first
            expect(cell).to_be_visible()
            arw = 60 * sigma / math.sqrt(200)
            assert float(cell.inner_text().split()[0]) == pytest.approx(arw, rel=0.06)
    few = page.locator("#all-axes").get_by_text("6 samples; at least 1000 are needed", exact=True)
    expect(few).to_have_count(1)
    page.locator("[data-of='IMU:0'][data-axis=gyro_x_dps]").click()
    expect(page.locator("#axis")).to_have_value("gyro_x_dps")
    assert arw_of(page) == pytest.approx(60 * 0.1 / math.sqrt(200), abs=0.03)
    tab(page, "axes")
    expect(row_of(page, "gyro_z_dps", "IMU:1").locator("td.n").first).to_be_visible()


def test_an_axis_that_cannot_be_analysed_shows_why(folder, opened, tabs):
    rng = random.Random(4)
    rows = [f"{i / 50:.2f},0.25,{rng.gauss(0, 0.05):.6f}" for i in range(2000)]
    path = written(folder / "rec.csv", "time_s,gyro_x_dps,gyro_y_dps", rows)
    page = tabs.open(opened(path))
    tab(page, "axes")
    expect(row_of(page, "gyro_x_dps")).to_contain_text("hardly changes")
    expect(page.locator("#error")).to_be_hidden()


def test_numbers_of_a_recording_that_permits_no_model_are_withheld(folder, opened, tabs):
    """A dead zone, opened while the spectrum of another recording is shown."""
    two_axes(folder / "rec.csv")
    dead = dead_zone(folder / "dead.csv")
    bench = opened("rec.csv")
    page = tabs.open(bench)
    ranked(page)
    tab(page, "spectrum")
    bench.done("open", path=str(dead))
    expect(page.locator("#headline")).to_contain_text("not what the sensor measures")
    expect(page.locator("#model .effect").first).to_have_text(re.compile("withheld"))
    expect(page.locator("#spectrum")).to_have_attribute("class", re.compile("plot"))
    expect(page.locator("#error")).to_be_hidden()
    shot(page, "withheld")
    tab(page, "axes")
    expect(page.locator("#all-axes tbody td.n").first).to_have_text("withheld")
    page.click("#close")
    expect(page.locator(".recent", has_text="dead.csv")).to_contain_text("–")
    tabs.forgive("409")  # what the page had requested about the recording before


def test_the_first_page_fits_one_screen(opened, tabs):
    page = tabs.open(opened())

    def full(_, shown):
        names = [f"recording_{i}.csv" for i in range(4)]
        shown["recent"] = [
            {"path": one, "sensor": None, "name": one, "error": 0.1, "floor": 0.04} for one in names
        ]
        shown["sources"] = ["can:can0", "slcan:/dev/ttyUSB0", "slcan:/dev/ttyACM1"]
        return shown

    altered(page, "**/api/all*", full)
    page.reload()
    expect(page.locator(".recent")).to_have_count(4)
    for box in page.locator("#landing button:visible, #landing #source").evaluate_all(BOXES):
        assert box["bottom"] <= 720
    assert page.locator(".drop").evaluate("(one) => one.offsetHeight") <= 160
    shot(page, "landing-full")
