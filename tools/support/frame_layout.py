"""Makes addons/can/src/frame_layout.h from tools/davar.dbc, so that the layout of the frames has
one definition: encoder and decoder in C include the header, davarlab reads the DBC.

    python3 tools/support/frame_layout.py     writes the header; a test compares it with the DBC

Standard library only.
"""

import re
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
DBC = ROOT / "tools/davar.dbc"
HEADER = ROOT / "addons/can/src/frame_layout.h"
SIGNAL = re.compile(r"^ SG_ (\w+) (?:M |m\d+ )?: (\d+)\|(\d+)@1[+-] \(([^,]+),0\)", re.MULTILINE)
VALUE = (32, 32, 1.0)  # of the number that a frame of 8 bytes carries: a float32 or a count

TOP = """\
/* davar - the place of each signal in its frame: little endian, start bit and width.
 * Made from tools/davar.dbc by tools/support/frame_layout.py: do not edit. */
#ifndef DAVAR_FRAME_LAYOUT_H
#define DAVAR_FRAME_LAYOUT_H

#include "davar/can.h"
#include "number/strict.h"

typedef struct {
    uint16_t start;
    uint8_t bits;
} davar_signal_t;

/* A fixed-point signal: raw = value / unit. All ones means absent. All ones but the
 * last bit means this value or more. */
typedef struct {
    davar_signal_t at;
    float per_unit; /* 1 / unit */
    float unit;
} davar_scaled_t;
"""


class Signal(NamedTuple):
    name: str
    start: int
    bits: int
    unit: float

    @property
    def place(self) -> tuple[int, int, float]:
        return self.start, self.bits, self.unit


class Message(NamedTuple):
    identifier: int
    name: str  # without DAVAR_
    length: int
    signals: list[Signal]


def messages(dbc: str) -> list[Message]:
    """In the order of their identifiers."""
    found = []
    for identifier, name, length, body in re.findall(
        r"^BO_ (\d+) DAVAR_(\w+): (\d+) DAVAR\n((?: SG_ .*\n)+)", dbc, re.MULTILINE
    ):
        signals = [
            Signal(one, int(start), int(bits), float(unit))
            for one, start, bits, unit in SIGNAL.findall(body)
        ]
        assert len(signals) == body.count(" SG_ "), f"{name}: a signal of another form"
        found.append(Message(int(identifier), name, int(length), signals))
    return sorted(found)


def words(name: str) -> str:
    """WindowSamples: window_samples."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def line(prefix: str, signal: Signal) -> str:
    kind, name = "signal", f"{prefix}_{words(signal.name)}"
    value = f"{{{signal.start}, {signal.bits}}}"
    if signal.unit != 1.0:
        kind = "scaled"
        value = f"{{{value}, {1 / signal.unit:.0f}.0F, {signal.unit:.0e}F}}"
    return f"static const davar_{kind}_t {name} = {value};\n"


def table(name: str, signals: list[Signal]) -> str:
    rows = "".join(f"    {{{one.start}, {one.bits}}}, /* {one.name} */\n" for one in signals)
    return f"static const davar_signal_t {name}[{len(signals)}] = {{\n{rows}}};\n"


def signals_of(found: list[Message]) -> str:
    """The signals of the frames of 8 bytes, each once, and those of the CAN FD frame that have
    another place there.
    """
    classical: dict[str, Signal] = {}
    for message in found:
        for signal in message.signals if message.length == 8 else []:
            if signal.place != VALUE:
                known = classical.setdefault(signal.name, signal)
                assert known == signal, f"{signal.name}: two places in frames of 8 bytes"
    (long,) = (message for message in found if message.length != 8)
    own = [one for one in long.signals if one not in classical.values() and one.place != VALUE]
    floats = [one for one in own if one.bits == 32]
    adev = [one for one in floats if one.name.startswith("Adev")]
    coefficients = [one for one in floats if one not in adev]
    text = "\n/* The frames of 8 bytes: the number that each carries, then every other signal. */\n"
    text += line("signal", Signal("Value", *VALUE))
    text += "".join(line("signal", one) for one in classical.values())
    text += f"\n/* DAVAR_{long.name}, where it differs. */\n"
    text += "".join(line("fd", one) for one in own if one not in floats)
    return text + table("fd_coefficient", coefficients) + table("fd_adev", adev)


def numbers(found: list[Message], dbc: str) -> str:
    """The lengths, and what davar/can.h must agree with: identifiers and counters."""
    base = found[0].identifier
    lengths = ", ".join(f"{message.length}U" for message in found)
    health = re.findall(r"^VAL_ \d+ HealthIndex (.*) ;$", dbc, re.MULTILINE)[0]
    equal = [(f"DAVAR_MESSAGE_{words(one.name)}", one.identifier - base) for one in found]
    equal += [
        (f"DAVAR_HEALTH_{words(name)}", int(number))
        for number, name in re.findall(r'(\d+) "(\w+)"', health)
    ]
    checks = [("DAVAR_CAN_BASE", base), ("(int)DAVAR_MESSAGE_COUNT", len(found))]
    checks += [(f"(int){name.upper()}", value) for name, value in equal]
    return (
        "\n/* Data bytes of a message; 0: no such message. */\n"
        "static inline uint8_t message_length(uint32_t message)\n{\n"
        f"    static const uint8_t length[] = {{{lengths}}};\n"
        "    return (message < (uint32_t)DAVAR_MESSAGE_COUNT) ? length[message] : 0U;\n}\n\n"
        + "".join(
            f'_Static_assert({name} == {value}, "tools/davar.dbc");\n' for name, value in checks
        )
    )


def header(dbc: str) -> str:
    found = messages(dbc)
    assert [one.identifier for one in found] == list(
        range(found[0].identifier, found[0].identifier + len(found))
    )
    return f"{TOP}{signals_of(found)}{numbers(found, dbc)}\n#endif\n"


def main() -> None:
    if len(sys.argv) != 1:
        sys.exit(__doc__)
    HEADER.write_text(header(DBC.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
