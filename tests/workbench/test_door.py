"""Who may come in, and what may be brought along: tokens, origins, paths, logs of other people,
files that are none.
"""

import gzip
import json
import math
import random
import re
import shlex
import struct
import unittest

from playwright.sync_api import expect
from visiting import FIRST, Visiting, run, tab, until


def log(path, names, rows=2000):
    """A log of somebody: time in us, a rate in rad/s, counts, acceleration in m/s^2, a voltage."""
    rng = random.Random(4)
    lines = [";".join(names)]
    for i in range(rows):
        lines.append(
            f"{1_700_000_000_000_000 + 5000 * i};{rng.gauss(0.01, 0.0017):.7f};"
            f"{round(rng.gauss(3, 20))};{rng.gauss(0.1, 0.02):.5f};"
            f"{rng.gauss(0.0, 0.02):.5f};{rng.gauss(9.8, 0.02):.5f};"
            f"{25 + 0.01 * math.sin(i / 300):.3f};{3.7 + i * 1e-5:.5f}"
        )
    path.write_text("\n".join(lines) + "\n")


def held_back(page, requests):
    """The list of the requests that match, from now on held back."""
    held = []
    page.route(requests, lambda route: held.append(route))
    return held


def flight(path, sigmas_dps, rows=2000, short=None):
    """An ArduPilot log of several IMUs at 200 Hz, gyros in rad/s, each as noisy as it is told.
    short: the IMU that stops after 6 samples."""

    def named(kind, length, name, form, columns):
        return struct.pack("<BBBBB4s16s64s", 0xA3, 0x95, 0x80, kind, length, name, form, columns)

    rng = random.Random(5)
    out = named(0x80, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns") + named(
        0x81, 24, b"IMU", b"QBfff", b"TimeUS,I,GyrX,GyrY,GyrZ"
    )
    for i in range(rows):
        for one, sigma in enumerate(sigmas_dps):
            if one == short and i >= 6:
                continue
            out += struct.pack(
                "<BBBQBfff",
                0xA3,
                0x95,
                0x81,
                5000 * i,
                one,
                *(rng.gauss(0, math.radians(sigma)) for _ in range(3)),
            )
    path.write_bytes(out)


NAMES = (
    "timestamp_us",
    "GyroX [rad/s]",
    "wz_raw",
    "accX",
    "accY",
    "accZ",
    "Temp (C)",
    "<b>vbat</b>",
)


class Logs(Visiting):
    def test_a_log_with_odd_names_is_dropped_guessed_and_read(self):
        log(self.folder / "flight 7.csv", NAMES)
        bench = self.open()
        page = self.page(bench)
        page.set_input_files("#file", str(self.folder / "flight 7.csv"))
        expect(page.locator("tbody tr")).to_have_count(8)
        said = {
            row.locator("th").inner_text(): [
                select.input_value() for select in row.locator("select").all()
            ]
            for row in page.locator("tbody tr").all()
        }
        self.assertEqual(said["GyroX [rad/s]"], ["gyro", "x", "rad/s"])
        self.assertEqual(said["accZ"], ["accel", "z", "m/s^2"])
        self.assertEqual(said["<b>vbat</b>"], ["other", "", ""])
        self.shot(page, "columns")
        page.fill("input[data-index='2'][data-key=factor]", "0.05")
        page.locator("input[data-index='2'][data-key=factor]").blur()
        page.click("#read")
        page.wait_for_selector("#headline h1")
        expect(page.locator("#recording")).to_contain_text("200 Hz")
        self.assertEqual(
            [option.inner_text() for option in page.locator("#axis option").all()],
            ["gyro_x_dps", "gyro_z_dps", "accel_x_g", "accel_y_g", "accel_z_g"],
        )
        arw = page.locator("[data-kind=angle_random_walk] input[type=number]").first
        self.assertAlmostEqual(float(arw.input_value()), 20 * 0.05 / math.sqrt(200) * 60, delta=0.2)
        before = arw.input_value()
        page.select_option("#axis", "gyro_x_dps")
        expect(arw).not_to_have_value(before)
        self.assertAlmostEqual(
            float(arw.input_value()), math.degrees(0.0017) / math.sqrt(200) * 60, delta=0.03
        )
        tab(page, "columns")
        page.select_option("#against-column", "<b>vbat</b>")
        expect(page.locator("#against .xtitle")).to_have_text("<b>vbat</b>")
        page.reload()
        page.wait_for_selector("#headline h1")
        self.assertEqual(page.locator("#axis").input_value(), "gyro_x_dps")
        self.assert_quiet()

    def test_the_columns_of_a_file_without_names_are_named_in_the_table(self):
        log(self.folder / "raw.txt", NAMES)
        text = (self.folder / "raw.txt").read_text().split("\n", 1)[1]
        (self.folder / "raw.txt").write_text("Logger 7\n" + text)
        bench = self.open()
        page = self.page(bench)
        page.set_input_files("#file", str(self.folder / "raw.txt"))
        expect(page.locator("#unnamed")).to_be_visible()
        self.shot(page, "unnamed")
        names = ["time_us", "gyro_x_rad_s", "gyro_z_raw", "", "", "", "temp_degC", "_"]
        for row, name in zip(page.locator("tbody tr").all(), names):
            row.locator("input.name").fill(name)
        page.click("#names")
        expect(page.locator("#unnamed")).to_have_count(0)
        names = [name or f"column_{place}" for place, name in enumerate(names, 1)]
        expect(page.locator("tbody th")).to_have_text([name for name in names if name != "_"])
        expect(page.locator("#landing")).to_contain_text("separated by semicolons, 1 line above")
        page.fill("input[data-index='2'][data-key=factor]", "0.05")
        page.locator("input[data-index='2'][data-key=factor]").blur()
        page.click("#read")
        page.wait_for_selector("#headline h1")
        expect(page.locator("#recording")).to_contain_text("200 Hz")
        typed = bench.ask("all")[1]["commands"]
        self.assertIn(f"--names {','.join(names)}", typed[0])
        page.reload()
        page.wait_for_selector("#headline h1")
        self.assert_quiet()

    def test_of_a_log_with_two_gyros_one_is_chosen_and_each_keeps_its_session(self):
        flight(self.folder / "flight.bin", (0.1, 0.4))
        page = self.page(self.open())
        page.set_input_files("#file", str(self.folder / "flight.bin"))
        arw = page.locator("[data-kind=angle_random_walk] input[type=number]").first
        for name, sigma in (("IMU:1", 0.4), ("IMU:0", 0.1)):
            page.click(f"[data-sensor='{name}']")
            page.wait_for_selector("#headline h1")
            self.assertAlmostEqual(
                float(arw.input_value()),
                sigma / math.sqrt(200) * 60,
                delta=0.1 * sigma * 60 / math.sqrt(200),
            )
            self.shot(page, f"sensor {name[-1]}")
            page.click("#close")
            page.set_input_files("#file", str(self.folder / "flight.bin"))
            page.wait_for_selector("[data-sensor]")
        self.shot(page, "sensors")
        self.assertEqual(
            len(list(self.folder.glob("davarlab-files/flight.bin.IMU:?.davarlab.json"))), 2
        )
        self.assert_quiet()
        again = self.open("davarlab-files/flight.bin", "--sensor", "IMU:1")
        seen = again.ask("all")[1]
        self.assertEqual(
            (len(seen["steps"]), seen["gyros"]), (1, ["gyro_x_dps", "gyro_y_dps", "gyro_z_dps"])
        )
        words = shlex.split(next(line for line in seen["commands"] if " import " in line))
        self.assertEqual(words[words.index("--sensor") + 1], "IMU:1")
        (self.folder / "model.toml").write_text(FIRST.format(rate=200.0, column="gyro_y_dps"))
        given = self.open(
            "flight.bin", "-m", "model.toml"
        )  # the model is looked at when the sensor is chosen
        self.assertEqual(given.act("sensor", name="IMU:0")[1]["column"], "gyro_y_dps")
        self.assertEqual(given.ask("all")[1]["steps"][0]["did"], "the model as given")
        refused = run("open", "--no-browser", self.folder / "flight.bin", "--sensor", "IMU:7")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("IMU:7", refused.stderr)

    def test_of_a_recording_that_was_closed_or_left_nothing_comes_late(self):
        log(
            self.folder / "flight.csv",
            (
                "time_us",
                "gyro_x[rad/s]",
                "gyro_y[rad/s]",
                "acc_x",
                "acc_y",
                "acc_z",
                "temp_degC",
                "vbat",
            ),
        )
        page = self.page(self.open())
        late, over = [], []
        page.route(re.compile("/api/candidates"), lambda route: late.append(route))
        for ended in ("requestfinished", "requestfailed"):
            page.on(
                ended,
                lambda request: "/api/candidates" in request.url and over.append(request),
            )

        page.set_input_files("#file", str(self.folder / "flight.csv"))
        page.click("#read")
        page.click("#confirm")  # counts that are called rad/s are doubted
        for asked, leave in (
            (1, lambda: page.select_option("#axis", index=1)),
            (2, lambda: page.click("#close")),
        ):
            # they are under way, and the page waits
            until(page, lambda asked=asked: len(late) == asked)
            leave()
        expect(page.locator("#file")).to_be_attached()
        for route in late:
            route.continue_()
        until(page, lambda: len(over) == len(late))
        expect(page.locator("#error")).to_be_hidden()
        self.assert_quiet()

    def test_no_picture_of_a_recording_that_was_left_is_asked_for(self):
        """The pictures are asked for one after the other: whichever is under way when the recording
        is closed, or drawn, none comes behind it.
        """
        rng = random.Random(3)
        (self.folder / "flight.csv").write_text(
            "time_s,gyro_z_dps,temp_degC\n"
            + "".join(f"{i / 50},{rng.gauss(0, 0.1):.5f},{20 + i / 999:.3f}\n" for i in range(2000))
        )
        page = self.page(self.open())
        refused = []
        page.on("response", lambda answer: answer.status >= 400 and refused.append(answer.url))
        for what, name in (("stretch", "where"), ("against", "columns"), ("axes", "sheet")):
            held = held_back(page, f"**/api/{what}*")
            page.set_input_files("#file", str(self.folder / "flight.csv"))
            page.click(f"#tab-{name}")
            until(page, lambda held=held: held)
            page.click("#close")
            expect(page.locator("#file")).to_be_visible()
            for route in held:
                route.continue_()
            page.unroute(f"**/api/{what}*")
            page.wait_for_load_state("networkidle")
        self.assertEqual(refused, [])
        self.assert_quiet()

    def test_what_is_no_recording_is_refused_in_one_line(self):
        bench = self.open()
        page = self.page(bench)
        for name, data in (
            ("photo.png", b"\x89PNG\r\n\x1a\n\0\0\0"),
            ("empty.csv", b""),
            ("words.csv", b"time_s,gyro_z_dps\n0,fast\n"),
            ("cut.csv.gz", gzip.compress(b"a,b\n1,2\n" * 1000)[:40]),
        ):
            page.set_input_files("#file", {"name": name, "mimeType": "text/csv", "buffer": data})
            expect(page.locator("#error")).to_contain_text(name)
            self.assertNotIn("Traceback", page.inner_text("body"))
        self.assertTrue(page.locator("#tutorial").is_visible())


class Door(Visiting):
    def test_only_the_page_with_the_token_from_this_origin_comes_in(self):
        bench = self.open()
        own = {"X-Davar-Token": bench.token}
        for path in ("/api/all", "/", "/api/step"):
            self.assertEqual(bench.request(path, headers={})[0], 403, path)
            self.assertEqual(bench.request(path, headers={"X-Davar-Token": "x" * 22})[0], 403, path)
            self.assertEqual(
                bench.request(path, headers={**own, "Origin": "http://evil.example"})[0], 403, path
            )
            self.assertEqual(
                bench.request(path, headers={**own, "Host": "evil.example"})[0], 400, path
            )
        self.assertEqual(
            bench.request(
                "/api/open", b'{"path": "/etc/passwd"}', {"Content-Type": "application/json"}
            )[0],
            403,
        )
        self.assertEqual(bench.request("/api/all", headers={**own, "Origin": bench.origin})[0], 200)

    def test_only_the_page_with_the_token_from_this_origin_hears_events(self):
        bench = self.open()
        page = self.browser.new_page()
        self.addCleanup(page.close)
        events = f"ws{bench.origin[4:]}/events"
        for shown, address, heard in (
            (bench.address, f"{events}?token={bench.token}", True),
            (bench.address, events, False),
            (bench.address, f"{events}?token={'x' * 22}", False),
            ("data:text/html,<p>elsewhere", f"{events}?token={bench.token}", False),
        ):
            page.goto(shown)
            opened = page.evaluate(
                """(address) => new Promise((done) => { const s = new WebSocket(address);
                s.onopen = () => done(true); s.onerror = () => done(false); })""",
                address,
            )
            self.assertEqual(opened, heard, (shown, address))

    def test_nothing_but_the_page_is_served(self):
        bench = self.open()
        for path in (
            "/page/../server.py",
            "/page/..%2fserver.py",
            "/page/%2e%2e/server.py",
            "/page//etc/passwd",
            "/page/parts/../../server.py",
            "/page/parts",
            "/page/",
            "/page/nothing.js",
            "/etc/passwd",
        ):
            self.assertEqual(bench.request(path)[0], 404, path)

    def test_a_dropped_file_stays_in_its_folder(self):
        bench = self.open()
        for name in (
            "../away.csv",
            "/tmp/away.csv",
            "a/b.csv",
            "..",
            ".hidden",
            "",
            "new\nline.csv",
        ):
            status, text = bench.request(
                "/api/drop?" + "name=" + name.replace("/", "%2F").replace("\n", "%0A"),
                b"a,b\n1,2\n",
            )
            self.assertEqual(status, 400, name)
            self.assertIn("not a name for a recording", json.loads(text)["error"])
        self.assertEqual([path.name for path in self.folder.rglob("*") if path.is_file()], [])

    def test_another_file_of_the_same_name_takes_nothing_from_the_first(self):
        first, second = self.folder / "one.csv", self.folder / "two.csv"
        for path, loud in ((first, 1), (second, 20)):
            rng = random.Random(loud)
            path.write_text(
                "time_s,gyro_z_dps\n"
                + "".join(f"{i / 50:.2f},{rng.gauss(0, 0.1 * loud):.6f}\n" for i in range(3000))
            )
        bench = self.open()
        names = []
        for path in (first, second, first):
            status, text = bench.request("/api/drop?name=rec.csv", path.read_bytes())
            self.assertEqual(status, 200, text)
            names.append(
                (
                    json.loads(text)["recording"].split("/")[-1],
                    round(json.loads(text)["steps"][0]["error"], 6),
                )
            )
        self.assertEqual([name for name, _ in names], ["rec.csv", "rec-2.csv", "rec.csv"])
        self.assertEqual(names[0], names[2])
        recent = bench.act("close")[1]["recent"]  # the first page lists them, the newest first
        self.assertEqual([one["name"] for one in recent], ["rec.csv", "rec-2.csv"])
        self.assertAlmostEqual(recent[0]["error"], names[0][1], places=6)
        first.write_bytes(second.read_bytes())
        (self.folder / "davarlab-files/rec.csv").write_bytes(second.read_bytes())
        done = run("open", "--no-browser", self.folder / "davarlab-files/rec.csv")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("another recording", done.stderr)

    def test_what_is_asked_wrongly_is_refused_in_one_line(self):
        bench = self.open()
        for wanted, what, given in (
            (409, "step", {}),  # of a recording that is not open, or not any more
            (409, "go", {"number": 3}),
            (400, "set", {"place": 0, "parameters": {}}),
            (409, "refit", {}),
            (400, "read", {"columns": []}),
            (400, "open", {"path": "nowhere.csv"}),
            (400, "open", {}),
            (400, "open", {"path": "x", "more": 1}),
        ):
            status, answer = bench.act(what, **given) if what != "step" else bench.ask(what)
            self.assertEqual((status, "\n" in answer["error"]), (wanted, False), (what, answer))
        self.assertEqual(bench.act("nothing")[0], 404)
        self.assertEqual(bench.request("/api/open", b"[1]")[0], 400)
        self.assertEqual(bench.request("/api/open", b"[" * 100000)[0], 400)

    def test_the_command_refuses_what_is_not_there(self):
        for arguments in (("nowhere.csv",), ("-m", "model.toml"), ("--port", "70000")):
            done = run("open", "--no-browser", *arguments)
            self.assertEqual(
                (done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1), done.stderr
            )


if __name__ == "__main__":
    unittest.main()
