"""tools/davarlab dbc: the same layout at other identifiers."""

import re

import cantools
import frame_layout
import pytest
from davar.wire import dbc, frames
from davarlab import errors
from senders import ROOT
from senders import dbc as original

NUMBER = r"-?\d+(\.\d+)?(e-\d+)?"
RANGE = rf"\({NUMBER},{NUMBER}\) \[{NUMBER}\|{NUMBER}\]"
# SavvyCAN reads a DBC line by line, with one expression for each kind and single spaces. It ignores
# a line of another form without an error, or reports a faulty entry (dbc/dbchandler.cpp, commit
# 9267e2b1, and its pull requests 719 and 775).
SAVVYCAN = {
    "BO_": r"BO_ \d+ \w+: \d+ \w+",
    "SG_": rf'SG_ \w+ (M |m\d+ )?: \d+\|\d+@1[+-] {RANGE} "[^"]*" \w+',
    "SG_MUL_VAL_": r"SG_MUL_VAL_ \d+ \w+ \w+ \d+-\d+;",
    "SIG_VALTYPE_": r"SIG_VALTYPE_ \d+ \w+ : [12];",
    "VAL_": r'VAL_ \d+ \w+ (\d+ "[^"]*" )+;',
    "CM_": r'CM_ (BO_ \d+ |SG_ \d+ \w+ )?"[^"]*";',
}
PARTS = ("name", "start", "length", "is_float", "is_signed", "scale", "unit", "is_multiplexer")
IN_WORDS = ("choices", "multiplexer_ids", "multiplexer_signal")


def layout(message):
    return sorted(
        (*(getattr(one, name) for name in PARTS), *(str(getattr(one, name)) for name in IN_WORDS))
        for one in message.signals
    )


def loaded(text):
    return cantools.database.load_string(text, "dbc", strict=True)


@pytest.mark.parametrize(
    ("base", "channel"), [(0x5D0, 0), (0x600, 2), (0x7F0, 0), (0, 34), (0x5D0, 34)]
)
def test_every_message_is_at_its_place_with_the_same_layout(base, channel):
    found, shift = loaded(dbc.moved(base, [channel])).messages, base - 0x5D0 + 16 * channel
    for one, other in zip(original().messages, found, strict=True):
        assert (other.name, other.length) == (one.name, one.length)
        assert (other.frame_id, layout(other)) == (one.frame_id + shift, layout(one))


def test_the_layout_in_c_is_made_from_the_dbc():
    made = frame_layout.header(frame_layout.DBC.read_text(encoding="utf-8"))
    assert frame_layout.HEADER.read_text(encoding="utf-8") == made, (
        "run tools/support/frame_layout.py"
    )


def test_the_layout_in_c_has_every_signal_where_cantools_has_it():
    """frame_layout.py reads the DBC with expressions of its own."""
    found = frame_layout.messages(frame_layout.DBC.read_text(encoding="utf-8"))
    there = sorted(original().messages, key=lambda message: message.frame_id)
    for one, other in zip(found, there, strict=True):
        assert (one.identifier, f"DAVAR_{one.name}", one.length) == (
            *(other.frame_id, other.name, other.length),
        )
        assert sorted(one.signals) == sorted(
            (signal.name, signal.start, signal.length, float(signal.scale))
            for signal in other.signals
        )


def test_davarlab_has_the_identifiers_of_the_dbc():
    identifiers = [message.frame_id for message in original().messages]
    assert min(identifiers) == frames.BASE
    assert max(identifiers) < frames.BASE + frames.STEP
    counted = {
        signal.name
        for message in original().messages
        if "Result" in {one.name for one in message.signals}
        for signal in message.signals
        if signal.is_multiplexer and message.name not in ("DAVAR_Health", "DAVAR_Setup")
    }
    assert counted == set(frames.PLACES)


def test_every_line_has_the_form_that_savvycan_reads():
    for text in ((ROOT / "tools/davar.dbc").read_text(), dbc.moved(0x600, [0, 2])):
        _, _, text = text.partition("BU_:")  # before it, the names of the kinds
        lines = [line.strip() for line in text.splitlines()]
        for kind, form in SAVVYCAN.items():
            found = [line for line in lines if line.startswith(f"{kind} ")]
            assert found, kind
            assert [line for line in found if not re.fullmatch(form, line)] == []


def test_several_channels_have_names_of_their_own():
    found = loaded(dbc.moved(0x600, [0, 2]))
    assert len(found.messages) == 2 * len(original().messages)
    for one in original().messages:
        for channel in (0, 2):
            other = found.get_message_by_frame_id(one.frame_id + 0x30 + 16 * channel)
            assert (other.name, layout(other)) == (f"{one.name}_{channel}", layout(one))


def test_identifiers_beyond_eleven_bits_are_rejected():
    why = "--channel: 35 does not fit into 11-bit identifiers from 5D0 on"
    with pytest.raises(errors.BadInput, match=why):
        dbc.moved(0x5D0, [34, 35])
