"""Ten hours at real pace: the same values as at full speed, and no lost frame."""

import subprocess
import time
import unittest

from kernel_case import SIM, KernelCase, near

HOURS, RATE_HZ = 10, 2


class TenHours(KernelCase):
    hang_s = 2 * HOURS * 3600

    def recording(self):
        path, value = self.folder / "ten_hours.csv", 1
        with open(path, "w", encoding="ascii") as file:
            file.write("gyro_z_dps\n")
            for _ in range(HOURS * 3600 * RATE_HZ):
                value = (1103515245 * value + 12345) % 2**31
                file.write(f"{((value >> 16) % 200 - 100) * 0.01:.2f}\n")
        return path

    def test_a_replay_at_real_pace_ends_with_the_values_of_full_speed_and_no_drop(self):
        import csv

        options = [
            SIM,
            str(self.recording()),
            "--rate",
            str(RATE_HZ),
            "--lsb",
            "0.01",
            "--stride",
            "120",
            "--progress",
            "never",
        ]
        fast = subprocess.run(
            options, text=True, stdout=subprocess.PIPE, check=True
        ).stdout.splitlines()
        wanted = list(csv.DictReader(fast))
        interface = self.vcan()
        receiver, stop_listening = self.listen(interface, patience_s=600)
        start = time.monotonic()
        subprocess.run([*options, "--pace", "realtime", "--out", f"can:{interface}"], check=True)
        passed = time.monotonic() - start
        found = stop_listening()
        print(f"{passed:.0f} s of virtual time, {receiver.faults.good} frames", flush=True)
        self.assertAlmostEqual(HOURS * 3600, passed, delta=60)
        self.assertEqual(0, receiver.faults.total(), receiver.faults)
        self.assertEqual(0, receiver.channels[0].health["FramesDropped"])
        self.assertEqual([int(row["epoch"]) for row in wanted], [result.epoch for result in found])
        for row, result in zip(wanted, found):
            self.assertTrue(
                near(result.values["arw_deg_per_sqrt_h"], float(row["arw_deg_per_sqrt_h"] or "nan"))
                or not row["arw_deg_per_sqrt_h"]
            )


if __name__ == "__main__":
    unittest.main()
