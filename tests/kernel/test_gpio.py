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
        assert told["samples"] == 100
        assert told.get("edges lost", 0) == 0
        assert told["results"] == len(stop_listening())
        assert receiver.faults.total() == 0

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
        assert told["edges lost"] >= 40
        assert told["gaps"] >= 1
        assert told["missing samples"] >= told["edges lost"]

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
        assert True in seen[80:140], told
        assert told["alarms"] >= 1
        assert not self.chip.alarm(), "low again at the end"

    def test_a_value_file_is_read_at_each_edge(self):
        value = self.folder / "in_anglvel_z_raw"
        value.write_text("17\n")
        node = self.gateway(f"value:{value}")
        for _ in range(30):
            self.chip.edge()
        settle()
        assert self.stop(node)["samples"] == 30

    def rejected(self, *options):
        source = ("--source", "-", "--rate", "100", "--lsb", "1", "--out", f"can:{self.interface}")
        return self.refused(NODE, *source, *options)

    def test_a_chip_or_line_that_does_not_exist_is_reported(self):
        assert "no gpio chip 'gpiochip77'" in self.rejected("--edges", "gpiochip77:0")
        assert f"{self.chip.name}:8: " in self.rejected("--edges", f"{self.chip.name}:8")
        assert "CHIP:LINE expected" in self.rejected("--alarm", "five")

    def test_a_busy_line_is_reported(self):
        holder = self.start("gpiomon", self.chip.name, EDGE)
        settle()
        assert "busy: another program holds it" in self.rejected(
            "--edges", f"{self.chip.name}:{EDGE}"
        )
        holder.kill()
