"""lib/WIRE.md: every table, example and figure is recomputed."""

import re
import unittest
from pathlib import Path

import cantools
import crccheck

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "lib/WIRE.md").read_text(encoding="utf-8")
DBC = cantools.database.load_file(ROOT / "tools/davar.dbc", strict=True)
HEADER = ("Crc", "Counter", "Result")
FRAME_BITS = (
    64 + 47 + (34 + 64 - 1) // 4
)  # classical, 8 bytes: data, the rest with the gap, worst stuffing
FRAMES = {"summary": 6, "full": 6 + 8 + 5, "intervals": 6 + 8 + 15}


def rows(columns):
    found = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in TEXT.splitlines()
        if line.startswith("|")
    ]
    return [row for row in found if len(row) == columns and not set(row[0]) <= {"-"}]


class Documentation(unittest.TestCase):
    def test_the_table_of_signals_is_that_of_the_dbc(self):
        documented = {
            (row[0], re.match(r"`(\w+)`", row[1]).group(1)): row[2:]
            for row in rows(7)
            if row[0].startswith("DAVAR_")
        }
        there = {
            (message.name, signal.name): [
                str(signal.start),
                str(signal.length),
                "float32" if signal.is_float else "signed" if signal.is_signed else "unsigned",
                f"{float(signal.scale):g}",
                signal.unit or "",
            ]
            for message in DBC.messages
            for signal in message.signals
            if signal.name not in HEADER
        }
        self.assertEqual(there, documented)

    def test_every_signal_is_little_endian_and_the_header_is_everywhere(self):
        for message in DBC.messages:
            self.assertTrue(all(signal.byte_order == "little_endian" for signal in message.signals))
            wanted = {"Crc": (0, 8), "Counter": (8, 4), "Result": (12, 4)}
            if message.name in ("DAVAR_State", "DAVAR_ResultFd", "DAVAR_Raw"):
                del wanted["Result"]
            self.assertEqual(
                wanted, {s.name: (s.start, s.length) for s in message.signals if s.name in HEADER}
            )

    def test_the_table_of_messages_is_that_of_the_dbc(self):
        documented = {
            row[0].strip("`"): (int(row[1]), int(row[2]))
            for row in rows(4)
            if row[0].startswith("`DAVAR_")
        }
        self.assertEqual({m.name: (m.frame_id - 0x5D0, m.length) for m in DBC.messages}, documented)

    def test_the_table_of_reasons_is_that_of_the_dbc(self):
        documented = {row[0]: (int(row[1]), int(row[2])) for row in rows(4) if row[1].isdigit()}
        named = [
            {
                str(name): code
                for code, name in DBC.get_message_by_name(message)
                .get_signal_by_name("ArwRelativeUncertainty")
                .choices.items()
            }
            for message in ("DAVAR_Arw", "DAVAR_ResultFd")
        ]
        there = {name: (code, named[1][name]) for name, code in named[0].items()}
        del there["beyond"]  # of a present ARW
        self.assertEqual(there, {name: documented[name] for name in there})
        self.assertEqual(5, len(there))

    def test_the_examples_decode_to_the_documented_values(self):
        examples = [row for row in rows(3) if "#" in row[0]]
        self.assertEqual(8, len(examples))
        for candump, slcan, says in examples:
            identifier, data = candump.strip("`").split("#")
            self.assertEqual(f"t{identifier}8{data}", slcan.strip("`"))
            signals = DBC.decode_message(int(identifier, 16), bytes.fromhex(data))
            shown = ", ".join(
                f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
                for name, value in signals.items()
                if name not in HEADER
            )
            self.assertEqual(shown, says)

    def test_the_frame_that_is_read_by_hand(self):
        data = bytes.fromhex("CB802580E7030000")
        signals = DBC.decode_message(0x5D1, data)
        self.assertEqual(
            (0, 600, 1, 999),
            tuple(signals[name] for name in ("Counter", "WindowSamples", "Unstable", "Epoch")),
        )
        summed = bytes.fromhex("D1 05 80 25 80 E7 03 00 00")
        self.assertEqual(bytes([0xD1, 5]) + data[1:], summed)
        self.assertEqual(data[0], crccheck.crc.Crc8SaeJ1850.calc(summed))
        self.assertEqual(
            (0x802580, 600), (int.from_bytes(data[1:4], "little"), 0x802580 >> 4 & 0x7FFFF)
        )
        self.assertIn("CRC-8 of D1 05 80 25 80 E7 03 00 00 is CB", TEXT)

    def test_the_frame_of_can_fd_decodes_to_the_documented_values(self):
        lines = re.findall(r"^([0-9A-F]{16})  (.*)$", TEXT, re.MULTILINE)
        data = bytes.fromhex("".join(line[0] for line in lines))
        signals = DBC.decode_message(0x5D8, data)
        self.assertEqual(
            signals["Crc"], crccheck.crc.Crc8SaeJ1850.calc(bytes([0xD8, 5]) + data[1:])
        )
        said = dict(
            word.split(" ") for line in lines for word in line[1].removeprefix("Crc, ").split(", ")
        )
        self.assertEqual(
            {name: f"{value:.6g}" for name, value in signals.items() if name != "Crc"}, said
        )

    def test_the_bus_load(self):
        figures = [row for row in rows(7) if row[0].isdigit()]
        self.assertEqual(15, len(figures))
        for rate, content, frames, *loads in figures:
            self.assertEqual(FRAMES[content], int(frames))
            bits = int(rate) * int(frames)
            wanted = [f"{100 * bits * FRAME_BITS / speed:.2f} %" for speed in (125e3, 500e3, 1e6)]
            self.assertEqual([*wanted, f"{100 * bits * 22 * 10 / 115200:.2f} %"], loads)

    def test_the_bus_load_of_raw_samples(self):
        figures = [row for row in rows(6) if row[0].isdigit()]
        self.assertEqual(6, len(figures))
        for rate, counts, frames, *loads in figures:
            self.assertEqual(int(rate) / {"16 bits": 2, "32 bits, float": 1}[counts], int(frames))
            wanted = [
                f"{100 * int(frames) * bits / speed:.1f} %"
                for bits, speed in ((FRAME_BITS, 500e3), (FRAME_BITS, 1e6), (220, 115200))
            ]
            self.assertEqual(wanted, loads)

    def test_the_bus_load_of_can_fd(self):
        seconds = 34 / 500e3 + 677 / 2e6 + 3 * FRAME_BITS / 500e3
        self.assertIn(
            f"{1e3 * seconds:.3f} ms per result, {100 * 100 * seconds:.2f} % of the bus",
            " ".join(TEXT.split()),
        )


if __name__ == "__main__":
    unittest.main()
