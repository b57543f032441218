"""tools/davarlab dbc: the same layout at other identifiers."""

import random
import re
import tempfile
import unittest
from pathlib import Path

import cantools
from davarlab import errors
from davarlab.wire import dbc

ROOT = Path(__file__).resolve().parents[2]

ORIGINAL = cantools.database.load_file(ROOT / "tools/davar.dbc", strict=True)

NUMBER = r"-?\d+(\.\d+)?(e-\d+)?"
# SavvyCAN reads a DBC line by line, with one expression for each kind and single spaces. It ignores
# a line of another form without an error, or reports a faulty entry (dbc/dbchandler.cpp, commit
# 9267e2b1, and its pull requests 719 and 775).
SAVVYCAN = {
    "BO_": r"BO_ \d+ \w+: \d+ \w+",
    "SG_": rf"SG_ \w+ (M |m\d+ )?: \d+\|\d+@1[+-] \({NUMBER},{NUMBER}\) \[{NUMBER}\|{NUMBER}\]"
    r' "[^"]*" \w+',
    "SG_MUL_VAL_": r"SG_MUL_VAL_ \d+ \w+ \w+ \d+-\d+;",
    "SIG_VALTYPE_": r"SIG_VALTYPE_ \d+ \w+ : [12];",
    "VAL_": r'VAL_ \d+ \w+ (\d+ "[^"]*" )+;',
    "CM_": r'CM_ (BO_ \d+ |SG_ \d+ \w+ )?"[^"]*";',
}


def layout(message):
    return sorted(
        (
            s.name,
            s.start,
            s.length,
            s.is_float,
            s.is_signed,
            s.scale,
            s.unit,
            str(s.choices),
            s.is_multiplexer,
            str(s.multiplexer_ids),
            str(s.multiplexer_signal),
        )
        for s in message.signals
    )


def loaded(text):
    with tempfile.NamedTemporaryFile("w", suffix=".dbc", newline="") as file:
        file.write(text)
        file.flush()
        return cantools.database.load_file(file.name, strict=True)


class Dbc(unittest.TestCase):
    def test_every_message_is_at_its_place_with_the_same_layout(self):
        for base, channel in ((0x5D0, 0), (0x600, 2), (0x7F4, 0), (0, 34)):
            found = loaded(dbc.moved(base, [channel]))
            self.assertEqual(
                [
                    (m.name, m.frame_id + base - 0x5D0 + 16 * channel, m.length)
                    for m in ORIGINAL.messages
                ],
                [(m.name, m.frame_id, m.length) for m in found.messages],
            )
            for one, other in zip(ORIGINAL.messages, found.messages):
                self.assertEqual(layout(one), layout(other), one.name)

    def test_frames_decode_to_the_same(self):
        source, found = random.Random(1), loaded(dbc.moved(0x600, [0, 2]))
        self.assertEqual(2 * len(ORIGINAL.messages), len(found.messages))
        for _ in range(2000):
            message, channel = source.choice(ORIGINAL.messages), source.choice((0, 2))
            data = source.randbytes(message.length)
            data = bytes([data[0], data[1] & 0xDF, source.randrange(2), *data[3:]])
            identifier = message.frame_id + 0x30 + 16 * channel
            self.assertEqual(str(message.decode(data)), str(found.decode_message(identifier, data)))
            self.assertEqual(
                f"{message.name}_{channel}", found.get_message_by_frame_id(identifier).name
            )

    def test_every_line_has_the_form_that_savvycan_reads(self):
        for text in ((ROOT / "tools/davar.dbc").read_text(), dbc.moved(0x600, [0, 2])):
            _, _, text = text.partition("BU_:")  # before it, the names of the kinds
            lines = [line.strip() for line in text.splitlines()]
            for kind, form in SAVVYCAN.items():
                found = [line for line in lines if line.startswith(f"{kind} ")]
                self.assertTrue(found, kind)
                self.assertEqual([], [line for line in found if not re.fullmatch(form, line)])

    def test_identifiers_beyond_eleven_bits_are_rejected(self):
        with self.assertRaisesRegex(
            errors.BadInput, "--channel: 35 does not fit into 11-bit identifiers from 5D0 on"
        ):
            dbc.moved(0x5D0, [34, 35])
        dbc.moved(0x5D0, [34])


if __name__ == "__main__":
    unittest.main()
