"""addons/can/DESIGN.md: every table, example and figure is recomputed."""

import re

import crccheck
import pytest
from senders import ROOT, dbc

HEADER = ("Crc", "Counter", "Result")
# Classical, 8 bytes: data, the rest with the gap, worst stuffing.
FRAME_BITS = 64 + 47 + (34 + 64 - 1) // 4
FRAMES = {"summary": 6, "full": 6 + 8 + 5, "intervals": 6 + 8 + 15}


@pytest.fixture(scope="module")
def text():
    return (ROOT / "addons/can/DESIGN.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def rows(text):
    cells = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.splitlines()
        if line.startswith("|")
    ]
    return lambda columns: [
        row for row in cells if len(row) == columns and not set(row[0]) <= {"-"}
    ]


def kind_of(signal):
    return "float32" if signal.is_float else "signed" if signal.is_signed else "unsigned"


def test_the_tables_of_messages_and_signals_are_those_of_the_dbc(rows):
    signals = {
        (row[0], re.match(r"`(\w+)`", row[1]).group(1)): row[2:]
        for row in rows(7)
        if row[0].startswith("DAVAR_")
    }
    there = {
        (message.name, one.name): [
            *(str(one.start), str(one.length), kind_of(one)),
            *(f"{float(one.scale):g}", one.unit or ""),
        ]
        for message in dbc().messages
        for one in message.signals
        if one.name not in HEADER
    }
    assert signals == there
    messages = {
        row[0].strip("`"): (int(row[1]), int(row[2])) for row in rows(4) if row[0][0] == "`"
    }
    assert messages == {m.name: (m.frame_id - 0x5D0, m.length) for m in dbc().messages}


def test_the_table_of_reasons_is_that_of_the_dbc(rows):
    documented = {row[0]: (int(row[1]), int(row[2])) for row in rows(4) if row[1].isdigit()}
    codes = []
    for message in ("DAVAR_Arw", "DAVAR_ResultFd"):
        signal = dbc().get_message_by_name(message).get_signal_by_name("ArwRelativeUncertainty")
        codes.append({str(name): code for code, name in signal.choices.items()})
    del codes[0]["beyond"]  # of a present ARW
    assert {name: documented[name] for name in codes[0]} == {
        name: (code, codes[1][name]) for name, code in codes[0].items()
    }
    assert len(codes[0]) == 5


def test_the_examples_decode_to_the_documented_values(rows):
    examples = [row for row in rows(3) if "#" in row[0]]
    assert len(examples) == 8
    for candump, slcan, says in examples:
        identifier, data = candump.strip("`").split("#")
        assert slcan.strip("`") == f"t{identifier}8{data}"
        signals = dbc().decode_message(int(identifier, 16), bytes.fromhex(data))
        shown = ", ".join(
            f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
            for name, value in signals.items()
            if name not in HEADER
        )
        assert shown == says


def test_the_frame_that_is_read_by_hand(text):
    data = bytes.fromhex("CB802580E7030000")
    signals = dbc().decode_message(0x5D1, data)
    names = ("Counter", "WindowSamples", "Unstable", "Epoch")
    assert tuple(signals[name] for name in names) == (0, 600, 1, 999)
    summed = bytes.fromhex("D1 05 80 25 80 E7 03 00 00")
    assert bytes([0xD1, 5]) + data[1:] == summed
    assert data[0] == crccheck.crc.Crc8SaeJ1850.calc(summed)
    word = int.from_bytes(data[1:4], "little")
    assert (word, word >> 4 & 0x7FFFF) == (0x802580, 600)
    assert "CRC-8 of D1 05 80 25 80 E7 03 00 00 is CB" in text


def test_the_frame_of_can_fd_decodes_to_the_documented_values(text):
    lines = re.findall(r"^([0-9A-F]{16})  (.*)$", text, re.MULTILINE)
    data = bytes.fromhex("".join(line[0] for line in lines))
    signals = dbc().decode_message(0x5D8, data)
    assert signals.pop("Crc") == crccheck.crc.Crc8SaeJ1850.calc(bytes([0xD8, 5]) + data[1:])
    said = [word for line in lines for word in line[1].removeprefix("Crc, ").split(", ")]
    assert dict(word.split(" ") for word in said) == {
        name: f"{value:.6g}" for name, value in signals.items()
    }


def test_the_bus_load(rows, text):
    figures = [row for row in rows(7) if row[0].isdigit()]
    assert len(figures) == 15
    for rate, content, frames, *loads in figures:
        assert int(frames) == FRAMES[content]
        bits = int(rate) * int(frames)
        wanted = [f"{100 * bits * FRAME_BITS / speed:.2f} %" for speed in (125e3, 500e3, 1e6)]
        assert loads == [*wanted, f"{100 * bits * 22 * 10 / 115200:.2f} %"]
    raw = [row for row in rows(6) if row[0].isdigit()]
    assert len(raw) == 6
    for rate, counts, frames, *loads in raw:
        assert int(frames) == int(rate) / {"16 bits": 2, "32 bits, float": 1}[counts]
        speeds = ((FRAME_BITS, 500e3), (FRAME_BITS, 1e6), (220, 115200))
        assert loads == [f"{100 * int(frames) * bits / speed:.1f} %" for bits, speed in speeds]
    seconds = 34 / 500e3 + 677 / 2e6 + 3 * FRAME_BITS / 500e3
    wanted = f"{1e3 * seconds:.3f} ms per result, {100 * 100 * seconds:.2f} % of the bus"
    assert wanted in " ".join(text.split())
