"""tools/davarlab live and dbc: bad options and sources give one line, exit status 2 and nothing on
standard output. What they do: tests/kernel/test_live.py, tests/wire/test_dbc.py.
"""

import os
import pty

import pytest

REFUSED = {
    "live lin:0": "dronecan:IFACE or cyphal:IFACE[@SUBJECT] expected, found 'lin:0'",
    "live mavlink:lin:0": "expected, found 'mavlink:lin:0'",
    "live mavlink:udp:127.0.0.1": "mavlink:udp:127.0.0.1: HOST:PORT expected",
    "live mavlink:udp::0": "mavlink:udp::0: HOST:PORT expected",
    "live mavlink:udp:127.0.0.1:70000": "mavlink:udp:127.0.0.1:70000: ",
    "live mavlink:serial:/nonexistent": "No such file or directory",
    "live cyphal:nope": "cyphal:nope: ",
    "live cyphal:nope@8192": "subject 0 to 8191 expected, found '8192'",
    "live slcan:/nonexistent": "slcan:/nonexistent: No such file or directory",
    "live slcan:/dev/null": "slcan:/dev/null: not a serial line",
    "live can:nope": "can:nope: ",
    "live can:vcan0 --count 0": "--count: a whole number above 0 expected, found '0'",
    "live can:vcan0 --idle nan": "--idle: a number above 0 expected, found 'nan'",
    "live can:vcan0 --base 800": "--base: a hexadecimal identifier up to 7F6 expected, found '800'",
    "live": "source",
    "dbc --base x -o OUT": "--base: a hexadecimal identifier up to 7F6 expected, found 'x'",
    "dbc --base 7F0 --channel 1 -o OUT": "--channel: 1 does not fit into 11-bit identifiers from",
    "dbc --channel -1 -o OUT": "--channel: a channel from 0 on expected, found '-1'",
    "dbc -o /nonexistent/my.dbc": "/nonexistent/my.dbc: cannot be written",
}


@pytest.mark.parametrize("command", REFUSED)
def test_what_cannot_be_done_is_named(lab, command):
    lab.refused(REFUSED[command], *command.replace("OUT", str(lab.work / "my.dbc")).split())


def test_a_recording_that_cannot_be_written_is_named(lab):
    ours, its = pty.openpty()
    why = "--record: /nonexistent/a.csv: No such file or directory"
    lab.refused(why, "live", f"slcan:{os.ttyname(its)}", "--record", "/nonexistent/a.csv")
    os.close(its)
    os.close(ours)
