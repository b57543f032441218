"""tools/davarlab import, and every command that takes a recording, on other people's logs: what the
formats' own libraries wrote comes back.
"""

import contextlib
import csv
import json
import os
import sqlite3
import unittest
from pathlib import Path

import asking
import numpy as np
import writing_logs as writing
from asking import ROOT
from test_lab import Folder

run = asking.run  # in this process: hundreds of commands

REAL = Path(os.environ.get("DAVAR_REAL_DATA", ROOT.parent / "shared/data/real")).parent / "logs"
SINGLE = 2e-7  # relative, of float32 and of nine digits


class Logs(Folder):
    def setUp(self):
        super().setUp()
        self.out = self.work / "out.csv"
        self.truth = writing.Truth()

    def imported(self, log, *options):
        """(notes, name -> values as text) of the recording that import writes."""
        done = run("import", log, "-o", self.out, *options)
        self.assertEqual((done.returncode, "Traceback" in done.stderr), (0, False), done.stderr)
        lines = self.out.read_text().splitlines()
        notes = [line for line in lines if line.startswith("#")]
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
        return notes, dict(zip(rows[0], zip(*rows[1:])))

    def refused(self, log, *said, options=()):
        """Exit status 2, one line, nothing left behind."""
        self.out.unlink(missing_ok=True)
        done = run("import", log, "-o", self.out, *options)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        for words in said:
            self.assertIn(words, done.stderr)
        self.assertEqual(
            [
                path.name
                for path in self.work.iterdir()
                if path.name.startswith("out") or path.name.endswith("partial")
            ],
            [],
        )

    def check(self, columns, gyro=1.0, accel=True, temp=True, first=0):
        for axis, name in enumerate("xyz"):
            np.testing.assert_allclose(
                np.float64(columns[f"gyro_{name}_dps"]),
                self.truth.gyro[axis] * gyro,
                rtol=SINGLE,
                atol=1e-8,
            )
            if accel:
                np.testing.assert_allclose(
                    np.float64(columns[f"accel_{name}_g"])[first::2],
                    self.truth.accel[axis][first::2],
                    rtol=SINGLE,
                    atol=1e-7,
                )
        if temp:
            np.testing.assert_allclose(
                np.float64(columns["temp_degC"]), self.truth.temp, atol=0.12
            )  # behind its last stamp it is held

    def check_stamps(self, columns, ns):
        whole = [
            int(second) * 10**9 + int(part.ljust(9, "0") or 0)
            for second, _, part in (text.partition(".") for text in columns["time_s"])
        ]
        self.assertEqual(whole, [int(one) for one in ns])


class Formats(Logs):
    def test_px4_ulog_the_unit_named_with_its_temperature_and_the_accelerometer_at_its_stamps(self):
        log = self.work / "log.ulg"
        writing.ulog(log, self.truth)
        self.refused(log, "log.ulg", "--sensor", "sensor_gyro:0", "sensor_gyro:1")
        _, columns = self.imported(log, "--sensor", "sensor_gyro:1")
        self.check(columns, gyro=2, accel=False)
        _, columns = self.imported(log, "--sensor", "sensor_gyro:0")
        self.check(columns)  # accel: each second sample is its own, the others lie between
        between = (self.truth.accel[2, 0] + self.truth.accel[2, 2]) / 2
        self.assertAlmostEqual(float(columns["accel_z_g"][1]), between, places=6)
        self.check_stamps(columns, np.array(writing.boot_us(self.truth)) * 1000)

    def test_ardupilot_dataflash_by_instance(self):
        log = self.work / "log.bin"
        writing.dataflash(log, self.truth)
        self.refused(log, "--sensor", "IMU:0", "IMU:1")
        _, columns = self.imported(log, "--sensor", "IMU:1")
        self.check(columns, gyro=2)
        self.check_stamps(columns, np.array(writing.boot_us(self.truth)) * 1000)

    def test_ardupilot_dataflash_in_text(self):
        log = self.work / "log.log"
        writing.dataflash_text(log, self.truth)
        _, columns = self.imported(log)
        self.check(columns)
        self.check_stamps(columns, np.array(writing.boot_us(self.truth)) * 1000)

    def test_ros_1_bag_with_unix_stamps_to_the_nanosecond(self):
        log = self.work / "log.bag"
        writing.ros1(log, self.truth)
        _, columns = self.imported(log)
        self.check(columns)
        self.check_stamps(columns, self.truth.stamps_ns)

    def test_ros_2_db3_mcap_and_the_folder_of_a_bag(self):
        for storage in ("db3", "mcap"):
            folder = self.work / f"bag_{storage}"
            file = writing.ros2(folder, self.truth, storage)
            for log in (file, folder):
                with self.subTest(log=log.name):
                    _, columns = self.imported(log)
                    self.check(columns)
                    self.check_stamps(columns, self.truth.stamps_ns)

    def test_two_topics_are_listed_and_one_is_chosen_by_name(self):
        log = self.work / "log.bag"
        writing.ros1(log, self.truth, ("/imu", "/imu2"))
        self.refused(log, "--sensor", "/imu (", "/imu2 (")
        self.refused(log, "--sensor /imu3", "/imu2 (", options=("--sensor", "/imu3"))
        self.check(self.imported(log, "--sensor", "/imu2")[1], temp=False)
        listed = json.loads(run("import", log, "--list", "--json").stdout)["sensors"]
        self.assertEqual(
            [(one["name"], one["samples"]) for one in listed], [("/imu", 400), ("/imu2", 400)]
        )

    def test_message_types_of_ones_own(self):
        bag, folder = self.work / "log.bag", self.work / "bag"
        writing.ros1(bag, self.truth, ("/raw",))
        self.check(self.imported(bag)[1])
        self.check(self.imported(writing.ros2(folder, self.truth, "mcap", ("/raw",)))[1])

    def test_matlab_5_and_7_3(self):
        old, new = self.work / "old.mat", self.work / "new.mat"
        writing.matlab_5(old, self.truth)
        _, columns = self.imported(old)
        self.check(columns, temp=False)
        self.check_stamps(columns, self.truth.stamps_ns - writing.START_NS)
        writing.matlab_73(new, self.truth)
        _, columns = self.imported(new)
        self.check(columns)
        self.check_stamps(columns, self.truth.stamps_ns - writing.START_NS)

    def test_numpy_and_parquet(self):
        for name, write, rest in (
            ("log.npz", writing.npz, True),
            ("log.npy", writing.npy, False),
            ("log.parquet", writing.table, True),
        ):
            with self.subTest(name=name):
                write(self.work / name, self.truth)
                _, columns = self.imported(self.work / name)
                self.check(columns, accel=rest, temp=rest)
                self.check_stamps(columns, self.truth.stamps_ns - (0 if rest else writing.START_NS))

    def test_a_temperature_with_a_time_of_its_own(self):
        writing.apart(self.work / "log.npz", self.truth)
        _, columns = self.imported(self.work / "log.npz")
        self.check(columns, accel=False)
        self.check_stamps(columns, self.truth.stamps_ns)

    def test_message_types_that_the_bag_does_not_bring(self):
        bag = writing.ros2(self.work / "bag", self.truth, "db3", ("/raw",))
        with contextlib.closing(sqlite3.connect(bag)) as base, base:
            base.execute("DELETE FROM message_definitions")
        self.refused(bag, bag.name)
        folder = self.work / "my_robot" / "msg"
        folder.mkdir(parents=True)
        (folder / "Raw.msg").write_text(writing.CUSTOM)
        self.check(self.imported(bag, "--types", folder / "Raw.msg")[1])
        self.check(self.imported(bag, "--types", self.work / "my_robot")[1])

    def test_every_command_takes_a_log(self):
        log, own = self.work / "log.npz", self.work / "own.csv"
        self.truth = writing.Truth(3000)
        writing.npz(log, self.truth)
        self.imported(log)
        self.out.rename(own)
        found = [
            json.loads(
                run(
                    "compare",
                    path,
                    "-m",
                    self.file(
                        "m.toml",
                        '[sensor]\ncolumn = "gyro_x_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
                        "coefficient_deg_per_sqrt_h = 2.0\n",
                    ),
                    "--json",
                ).stdout
            )
            for path in (log, own)
        ]
        self.assertEqual(found[0]["samples"], 3000)
        self.assertAlmostEqual(found[0]["error"], found[1]["error"], places=5)


class Text(Logs):
    def rows(self, name, header, row):
        return self.file(
            name, header + "\n" + "".join(row(place) + "\n" for place in range(self.truth.count))
        )

    def test_semicolons_decimal_commas_odd_names_and_units(self):
        gyro, accel = self.truth.rad_s, self.truth.m_s2
        log = self.rows(
            "log.csv",
            "Zeit;Time (ms);GyroX [rad/s];GyroY [rad/s];GyroZ [rad/s];AccX m/s2;AccY "
            "m/s2;AccZ m/s2;Temperature",
            lambda i: ";".join(
                f"{value:.9f}"
                for value in (7, i * 5, *gyro[:, i], *accel[:, i], self.truth.temp[i])
            ).replace(".", ","),
        )
        done = run("import", log, "-o", self.out)
        self.assertIn("GyroX [rad/s] -> gyro_x_dps, rad/s by its name", done.stderr)
        _, columns = self.imported(log)
        for axis, name in enumerate("xyz"):
            np.testing.assert_allclose(
                np.float64(columns[f"gyro_{name}_dps"]), self.truth.gyro[axis], atol=1e-6
            )
            np.testing.assert_allclose(
                np.float64(columns[f"accel_{name}_g"]), self.truth.accel[axis], atol=1e-6
            )
        self.check_stamps(columns, self.truth.stamps_ns - writing.START_NS)

    def test_a_guess_is_shown_and_overridden(self):
        log = self.rows(
            "log.txt",
            "t gx gy gz",
            lambda i: f"  {i * 5}   {i % 50 * 100} {i % 31 * 10}\t{i % 7 * 100}",
        )
        done = run("import", log, "-o", self.out)
        self.assertIn("--unit gx=UNIT", done.stderr)
        self.assertIn("gyro_x_counts", done.stdout)
        _, columns = self.imported(log, "--unit", "gyro=0.0175", "--unit", "t=ms")
        np.testing.assert_allclose(np.float64(columns["gyro_x_dps"][:3]), [0, 1.75, 3.5])
        self.assertEqual(columns["time_s"][:3], ("0", "0.005", "0.01"))

    def test_unix_times_survive(self):
        own = self.rows(
            "own.csv",
            "time_s,gyro_x_dps",
            lambda i: (
                f"{self.truth.stamps_ns[i] // 10**9}.{self.truth.stamps_ns[i] % 10**9:09d},{i % 5}"
            ),
        )
        self.check_stamps(self.imported(own)[1], self.truth.stamps_ns)
        for unit, size in (("ns", 1), ("us", 1000)):
            log = self.rows(
                f"{unit}.csv",
                f"timestamp_{unit},gyro_x_dps",
                lambda i, size=size: f"{self.truth.stamps_ns[i] // size},{i % 5}",
            )
            self.check_stamps(self.imported(log)[1], self.truth.stamps_ns // size * size)
        dates = np.array(self.truth.stamps_ns, "datetime64[ns]")
        log = self.rows("date.csv", "time,gyro_x_dps", lambda i: f"{dates[i]},{i % 5}")
        self.check_stamps(self.imported(log)[1], self.truth.stamps_ns)

    def test_degree_signs_quotes_and_a_column_of_somebody_elses_name(self):
        log = self.rows(
            "log.csv",
            '"Time (s)","Gyroscope x (\u00b0/s)","Absolute","light"',
            lambda i: f'"{i * 0.005:.3f}","{i % 5}.5",3,{i % 2}',
        )
        _, columns = self.imported(log)
        self.assertEqual(
            (columns["gyro_x_dps"][:2], columns["light"][:2]), (("0.5", "1.5"), ("0", "1"))
        )
        log = self.rows(
            "commas.csv", "t,gx_dps", lambda i: f'"{i * 0.005:.3f}","-{i % 5}.5"'.replace(".", ",")
        )
        self.assertEqual(self.imported(log)[1]["gyro_x_dps"][:2], ("-0.5", "-1.5"))
        self.refused(self.rows("xyz.csv", "t,x", lambda i: f"{i * 0.005:.3f},{i % 5}"), "--rename")
        columns = self.imported(self.work / "xyz.csv", "--rename", "x=gyro_x_rad_s")[1]
        self.assertAlmostEqual(float(columns["gyro_x_dps"][1]), 57.29578, places=4)

    def test_two_gyros_in_a_table(self):
        log = self.rows(
            "log.csv", "t,imu0_gx_dps,imu1_gx_dps", lambda i: f"{i * 0.005:.3f},{i % 5},{i % 3}"
        )
        self.refused(log, "--sensor", "imu0", "imu1")
        listed = json.loads(run("import", log, "--list", "--json").stdout)["sensors"]
        columns = self.imported(log, "--sensor", listed[1]["name"])[1]
        self.assertEqual(columns["gyro_x_dps"][:4], ("0", "1", "2", "0"))

    def test_what_import_writes_holds_only_what_was_measured(self):
        kept = [place for place in range(400) if not 100 <= place < 120]
        log = self.file(
            "log.csv",
            "t;gx_dps\n" + "".join(f"{place * 0.005:.3f};{place % 7}\n" for place in kept),
        )
        self.assertEqual(len(self.imported(log)[1]["time_s"]), 380)


class Refused(Logs):
    def test_a_log_cut_short_or_with_another_beginning(self):
        writers = {
            "log.ulg": writing.ulog,
            "log.bin": writing.dataflash,
            "log.bag": writing.ros1,
            "log.mat": writing.matlab_5,
            "new.mat": writing.matlab_73,
            "log.npz": writing.npz,
            "log.npy": writing.npy,
            "log.parquet": writing.table,
        }
        for name, write in writers.items():
            whole = self.work / "whole" / name
            whole.parent.mkdir(exist_ok=True)
            write(whole, self.truth)
            data = whole.read_bytes()
            log = self.work / name
            for what, damaged in (
                ("empty", b""),
                ("half", data[: len(data) // 2]),
                ("short", data[:-5]),
                ("head", data[:20]),
                ("other", b"something else" + data[14:]),
            ):
                if (name, what) not in (
                    ("log.mat", "short"),
                    ("new.mat", "other"),
                ):  # padding of a text; the file proper begins behind 512 bytes
                    with self.subTest(name=name, what=what):
                        log.write_bytes(damaged)
                        named = {"log.ulg": "sensor_gyro:0", "log.bin": "IMU:0"}.get(name)
                        self.refused(log, name, options=("--sensor", named) if named else ())

    def test_ros_2_cut_short(self):
        for storage in ("db3", "mcap"):
            data = writing.ros2(self.work / storage, self.truth, storage).read_bytes()
            log = self.file(f"log.{storage}", "")
            log.write_bytes(data[: len(data) // 2])
            with self.subTest(storage=storage):
                self.refused(log, f"log.{storage}")

    def test_nan_empty_topics_and_text_in_numbers(self):
        self.truth.gyro[1, 17] = np.nan
        for name, write, options in (
            ("log.ulg", writing.ulog, ("--sensor", "sensor_gyro:0")),
            ("log.bag", writing.ros1, ()),
            ("log.npz", writing.npz, ()),
            ("log.parquet", writing.table, ()),
        ):
            with self.subTest(name=name):
                write(self.work / name, self.truth)
                self.refused(
                    self.work / name,
                    name,
                    "gyro_y_dps",
                    "not a finite number at sample 18",
                    options=options,
                )
        self.refused(
            self.file("a.csv", "t;gx_dps\n0,01;1\n0,02;one\n"),
            "a.csv:3",
            "gx_dps",
            "not a number: 'one'",
        )
        self.refused(self.file("b.csv", "t,gx_dps\n0.01,1\n0.02,nan\n"), "b.csv:3", "gx_dps")
        self.refused(self.file("c.csv", "a,b\n1,2\n3,4\n"), "c.csv", "no gyro")
        writing.ros1(self.work / "empty.bag", writing.Truth(0))
        self.refused(self.work / "empty.bag", "empty.bag")

    def test_time_backwards_and_no_time(self):
        self.truth.stamps_ns[50] = self.truth.stamps_ns[40]
        for name, write in (("log.npz", writing.npz), ("log.parquet", writing.table)):
            with self.subTest(name=name):
                write(self.work / name, self.truth)
                self.refused(self.work / name, name, "time runs backwards")
        self.refused(self.file("c.csv", "gx_dps\n1\n2\n"), "no column time_s and no --rate")


@unittest.skipUnless(REAL.is_dir(), f"no real logs in {REAL}")
class Real(Logs):
    def test_px4_at_rest(self):
        _, columns = self.imported(
            REAL / "px4_cubeorange_at_rest_6s.ulg", "--sensor", "sensor_combined:0"
        )
        self.assertEqual(len(columns["time_s"]), 1298)
        self.assertAlmostEqual(abs(np.mean(np.float64(columns["accel_z_g"]))), 1, delta=0.05)
        self.assertLess(np.std(np.float64(columns["gyro_x_dps"])), 1)
        self.assertAlmostEqual(np.mean(np.float64(columns["temp_degC"])), 40, delta=3)

    def test_ardupilot_in_flight(self):
        _, columns = self.imported(REAL / "arducopter_dataflash_51s.BIN", "--sensor", "IMU")
        self.assertEqual((len(columns["time_s"]), columns["time_s"][0]), (1258, "402.644506"))
        self.assertAlmostEqual(np.mean(np.float64(columns["temp_degC"])), 27, delta=3)

    def test_ros_1_with_a_message_type_of_its_own(self):
        _, columns = self.imported(REAL / "ros1_xsens_mtig_at_rest_18s.bag")
        self.assertEqual(
            (len(columns["time_s"]), columns["time_s"][0], columns["temp_degC"][0]),
            (356, "1326899528.368658417", "20.8125"),
        )

    def test_matlab_with_two_imus_and_an_object_that_breaks_naive_readers(self):
        log = REAL / "rimu_two_imus_40deg_steps.mat"
        self.refused(log, "--sensor", "giro_imu_dps", "giro_bno_dps")
        _, columns = self.imported(log, "--sensor", "giro_bno_dps")
        self.assertEqual(len(columns["time_s"]), 40000)
        self.assertAlmostEqual(np.mean(np.float64(columns["accel_z_g"][:2000])), 0.95, delta=0.02)


if __name__ == "__main__":
    unittest.main()
