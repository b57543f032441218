"""What is implausible about a recording is shown before anything is fitted, and can be corrected or
confirmed there.
"""

import random
import unittest

from playwright.sync_api import expect
from visiting import Visiting, ranked


class Doubtful(Visiting):
    def recording(self, header, step):
        rng = random.Random(5)
        path = self.folder / "rec.csv"
        path.write_text(
            header + "\n" + "".join(f"{i * step},{rng.gauss(0, 0.05):.6f}\n" for i in range(3000))
        )
        return path

    def test_a_time_in_microseconds_called_seconds_is_doubted_before_anything_is_fitted(self):
        bench = self.open(self.recording("time_s,gyro_z_dps", 10000))
        page = self.page(bench)
        expect(page.locator("#doubts")).to_contain_text(
            "implausible sample rate 0.0001 Hz (gyros: 0.02 Hz to 40 kHz). If the time is in us, "
            "the rate is 100 Hz: use --unit time=us"
        )
        self.assertIsNone(bench.ask("all")[1]["recording"])
        self.shot(page, "doubt")
        page.click("#read")  # as it was: it is doubted again
        expect(page.locator("#landing")).to_have_js_property("inert", False)
        expect(page.locator("#doubts")).to_be_visible()
        page.select_option("select[data-index='0'][data-key=unit]", "us")
        page.click("#read")
        ranked(page)
        expect(page.locator("#recording")).to_contain_text("100 Hz")
        self.assertAlmostEqual(
            bench.ask("step")[1]["cards"][0]["parameters"][0]["value"], 0.3, delta=0.02
        )
        self.assert_quiet()

    def test_who_confirms_is_believed_and_the_commands_say_so(self):
        path = self.recording("time_s,gyro_z_dps", 10000)
        bench = self.open(path)
        page = self.page(bench)
        page.click("#confirm")
        ranked(page)
        expect(page.locator("#recording")).to_contain_text("0.0001 Hz")
        self.assertIn("--as-recorded", bench.ask("all")[1]["commands"][0])
        page.close()
        bench.stop()
        self.assertEqual(self.open(path).ask("all")[1]["samples"], 3000)  # the session knows it

    def test_a_column_that_somebody_says_is_the_time_gets_the_unit_of_its_name_and_numbers(self):
        for header in ("usec,gyro_z_dps", "ticks,gyro_z_dps"):
            with self.subTest(header):
                page = self.page(self.open(self.recording(header, 10000)))
                page.select_option("select[data-index='0'][data-key=quantity]", "time")
                self.assertEqual(
                    page.locator("select[data-index='0'][data-key=unit]").input_value(), "us"
                )
                page.click("#read")
                ranked(page)
                expect(page.locator("#recording")).to_contain_text("100 Hz")
                page.close()
                (self.folder / "rec.csv.davarlab.json").unlink()


if __name__ == "__main__":
    unittest.main()
