"""Data-ready edges and the alarm on a simulated chip of a real kernel (gpio-sim)."""

import signal

from kernel_case import ALARM, EDGE, IN_GUEST, NODE, PERIOD_S, Chip, KernelCase, settle

pytestmark = IN_GUEST


class Gpio(KernelCase):
    def setUp(self):
        super().setUp()
        self.chip = Chip()
        self.addCleanup(self.chip.close)
        self.interface = self.vcan()

    def gateway(self, source, *options):
        window = ["--window-max", "40", "--window-min", "20", "--segment", "6", "--stride", "4"]
        words = [NODE, "--source", source, "--rate", 1 / PERIOD_S, "--lsb", "0.05", *window]
        words += ["--out", f"can:{self.interface}", "--edges", f"{self.chip.name}:{EDGE}"]
        node = self.start(*words, *options)
        settle()
        return node

    def recording(self, values):
        path = self.folder / "counts.csv"
        path.write_text("gyro_z_counts\n" + "".join(f"{value}\n" for value in values))
        return path

    def test_one_edge_is_one_sample(self):
        receiver, stop_listening = self.listen(self.interface)
        node = self.gateway(self.recording(range(200)))
        for _ in range(100):
            self.chip.edge()
        settle()
        told = self.stop(node)
        self.assertEqual(100, told["samples"])
        self.assertEqual(0, told.get("edges lost", 0))
        self.assertEqual(told["results"], len(stop_listening()))
        self.assertEqual(0, receiver.faults.total())

    def test_edges_faster_than_anybody_reads_are_a_counted_gap(self):
        """The kernel stores 16 edges of a line; the node is stopped for 60 of them."""
        node = self.gateway(self.recording(range(1000)))
        for _ in range(20):
            self.chip.edge()
        settle()
        node.send_signal(signal.SIGSTOP)
        for _ in range(60):
            self.chip.edge()
        node.send_signal(signal.SIGCONT)
        settle()
        self.chip.edge()
        settle()
        told = self.stop(node)
        self.assertGreaterEqual(told["edges lost"], 40)
        self.assertGreaterEqual(told["gaps"], 1)
        self.assertGreaterEqual(told["missing samples"], told["edges lost"])

    def test_the_alarm_rises_when_the_noise_becomes_unstable_and_falls_again(self):
        quiet = [(7 * n * n + 3 * n) % 11 - 5 for n in range(200)]
        burst = [400 if n % 9 == 0 else 0 for n in range(40)]
        alarm = ("--alarm", f"{self.chip.name}:{ALARM}", "--alarm-off", "12")
        node = self.gateway(self.recording(quiet[:80] + burst + quiet), *alarm)
        seen = []
        for _ in range(300):
            self.chip.edge()
            seen.append(self.chip.alarm())
        told = self.stop(node)
        self.assertIn(True, seen[80:140], told)
        self.assertGreaterEqual(told["alarms"], 1)
        self.assertFalse(self.chip.alarm(), "low again at the end")

    def test_a_value_file_is_read_at_each_edge(self):
        value = self.folder / "in_anglvel_z_raw"
        value.write_text("17\n")
        node = self.gateway(f"value:{value}")
        for _ in range(30):
            self.chip.edge()
        settle()
        self.assertEqual(30, self.stop(node)["samples"])

    def rejected(self, *options):
        source = ("--source", "-", "--rate", "100", "--lsb", "1", "--out", f"can:{self.interface}")
        return self.refused(NODE, *source, *options)

    def test_a_chip_or_line_that_does_not_exist_is_reported(self):
        self.assertIn("no gpio chip 'gpiochip77'", self.rejected("--edges", "gpiochip77:0"))
        self.assertIn(f"{self.chip.name}:8: ", self.rejected("--edges", f"{self.chip.name}:8"))
        self.assertIn("CHIP:LINE expected", self.rejected("--alarm", "five"))

    def test_a_busy_line_is_reported(self):
        holder = self.start("gpiomon", self.chip.name, EDGE)
        settle()
        self.assertIn(
            "busy: another program holds it", self.rejected("--edges", f"{self.chip.name}:{EDGE}")
        )
        holder.kill()
