"""The library of Arduino: arduino-builder finds it by <davar.h> and builds its sketches for a
Cortex-M4 and for this machine. Here the sketches read simulated sensors (written from the data
sheets) through their registers.
"""

import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from package_case import HERE, RELEASE, run

LAYOUT = RELEASE / "layout/arduino"
SKETCHES = ("ArwMpu6050", "ArwLsm6ds")


class Arduino(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.work = Path(folder.name)
        shutil.copytree(LAYOUT, cls.work / "libraries/davar")
        for sketch in SKETCHES:
            cls.built(sketch, "host")

    @classmethod
    def built(cls, sketch, board, status=0):
        """The program, or the output of arduino-builder if it must fail."""
        there = cls.work / board / sketch
        there.mkdir(parents=True)
        said = run(
            "arduino-builder",
            "-compile",
            "-warnings",
            "all",
            "-hardware",
            HERE / "arduino",
            "-hardware",
            "/usr/share/arduino-builder",
            "-tools",
            "/usr/bin",
            "-libraries",
            cls.work / "libraries",
            "-fqbn",
            f"davar:samd:{board}",
            "-build-path",
            there,
            cls.work / f"libraries/davar/examples/{sketch}/{sketch}.ino",
            status=status,
        )
        return said if status else there / f"{sketch}.ino.elf"

    def rows(self, sketch, *words):
        """The output of the sketch: the title, the rows."""
        lines = subprocess.run(
            [self.work / f"host/{sketch}/{sketch}.ino.elf", *words],
            text=True,
            stdout=subprocess.PIPE,
            check=True,
        ).stdout.splitlines()
        return lines[0], [list(map(float, line.split(","))) for line in lines[1:]]

    def test_the_sketches_report_the_noise_of_the_sensor(self):
        for sketch, sensor in zip(SKETCHES, ("mpu6050", "lsm6ds")):
            with self.subTest(sketch=sketch):
                title, rows = self.rows(sketch, sensor, "60")
                self.assertEqual("window_samples,arw_deg_per_sqrt_h,arw_low,arw_high,gaps", title)
                self.assertGreaterEqual(len(rows), 53)  # one per second, from the sixth onward
                self.assertEqual({0.0}, {row[4] for row in rows})
                for window, value, low, high, _ in rows:
                    self.assertIn(window, (600, 624))
                    self.assertLess(
                        abs(value - 0.3), 0.06
                    )  # four standard deviations for such a window
                    self.assertTrue(low < value < high)
                covered = sum(low <= 0.3 <= high for _, _, low, high, _ in rows) / len(rows)
                self.assertGreater(
                    covered, 0.6
                )  # 95 % on average; neighbours share five sixths of their samples

    def test_samples_lost_while_the_processor_was_busy_are_a_gap(self):
        for sketch, sensor, short, long in (
            (SKETCHES[0], "mpu6050", "4", "7"),
            (SKETCHES[1], "lsm6ds", "0", "1"),
        ):
            with self.subTest(sketch=sketch):
                self.assertEqual(
                    0, self.rows(sketch, sensor, "40", "12", short)[1][-1][4]
                )  # the FIFO holds five seconds
                self.assertEqual(1, self.rows(sketch, sensor, "40", "12", long)[1][-1][4])

    def test_without_a_sensor_they_report_it(self):
        for sketch in SKETCHES:
            said = run(self.work / f"host/{sketch}/{sketch}.ino.elf", "none", "3")
            self.assertRegex(said, r"^(no (MPU-6050|LSM6DS) at 0x6\w.*\n)+$")

    def test_they_are_built_for_a_cortex_m4(self):
        for sketch in SKETCHES:
            self.assertIn(
                "Tag_CPU_arch: v7E-M", run("arm-none-eabi-readelf", "-A", self.built(sketch, "m4"))
            )

    def test_a_board_whose_double_has_32_bits_is_rejected(self):
        self.assertIn("davar needs a double of 64 bits", self.built(SKETCHES[0], "avr", status=1))

    def test_the_properties_list_architectures_and_an_existing_header(self):
        text = (LAYOUT / "library.properties").read_text()
        values = dict(re.findall(r"^(\w+)=(.+)$", text, re.MULTILINE))
        required = {
            "name",
            "version",
            "author",
            "maintainer",
            "sentence",
            "paragraph",
            "category",
            "url",
            "architectures",
        }
        self.assertEqual(set(), required - set(values))  # the library specification, revision 1.5
        architectures = values["architectures"].split(",")
        self.assertFalse({"*", "avr", "megaavr"} & set(architectures))
        self.assertIn("samd", architectures)
        self.assertTrue((LAYOUT / "src" / values["includes"]).is_file())
        self.assertIn(
            values["category"],
            (
                "Display",
                "Communication",
                "Signal Input/Output",
                "Sensors",
                "Device Control",
                "Timing",
                "Data Storage",
                "Data Processing",
                "Other",
            ),
        )


if __name__ == "__main__":
    unittest.main()
