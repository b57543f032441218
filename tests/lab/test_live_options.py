"""tools/davarlab live and dbc: bad options and sources give one line, exit status 2 and nothing on
standard output. What they do: tests/kernel/test_live.py, tests/wire/test_dbc.py.
"""

import os
import pty
import tempfile
import unittest
from pathlib import Path

from asking import typed as run

REFUSED = {
    ("live", "lin:0"): "dronecan:IFACE or cyphal:IFACE[@SUBJECT] expected, found 'lin:0'",
    ("live", "mavlink:lin:0"): "expected, found 'mavlink:lin:0'",
    ("live", "mavlink:udp:127.0.0.1"): "mavlink:udp:127.0.0.1: HOST:PORT expected",
    ("live", "mavlink:udp::0"): "mavlink:udp::0: HOST:PORT expected",
    ("live", "mavlink:udp:127.0.0.1:70000"): "mavlink:udp:127.0.0.1:70000: ",
    ("live", "mavlink:serial:/nonexistent"): "No such file or directory",
    ("live", "cyphal:nope"): "cyphal:nope: ",
    ("live", "cyphal:nope@8192"): "subject 0 to 8191 expected, found '8192'",
    ("live", "slcan:/nonexistent"): "slcan:/nonexistent: No such file or directory",
    ("live", "slcan:/dev/null"): "slcan:/dev/null: not a serial line",
    ("live", "can:nope"): "can:nope: ",
    ("live", "can:vcan0", "--count", "0"): "--count: a whole number above 0 expected, found '0'",
    ("live", "can:vcan0", "--idle", "nan"): "--idle: a number above 0 expected, found 'nan'",
    (
        "live",
        "can:vcan0",
        "--base",
        "800",
    ): "--base: a hexadecimal identifier up to 7F6 expected, found '800'",
    ("live",): "source",
    (
        "dbc",
        "--base",
        "x",
        "-o",
        "{0}",
    ): "--base: a hexadecimal identifier up to 7F6 expected, found 'x'",
    (
        "dbc",
        "--base",
        "7F0",
        "--channel",
        "1",
        "-o",
        "{0}",
    ): "--channel: 1 does not fit into 11-bit identifiers from 7F0 on",
    ("dbc", "--channel", "-1", "-o", "{0}"): "--channel: a channel from 0 on expected, found '-1'",
    ("dbc", "-o", "/nonexistent/my.dbc"): "/nonexistent/my.dbc: cannot be written",
}


class Options(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.output = Path(folder.name) / "my.dbc"

    def test_what_cannot_be_done_is_named(self):
        for arguments, why in REFUSED.items():
            with self.subTest(arguments):
                done = run(*(word.format(self.output) for word in arguments))
                self.assertEqual((2, ""), (done.returncode, done.stdout), done.stderr)
                self.assertRegex(done.stderr, r"\Adavarlab: [^\n]+\n\Z")
                self.assertIn(why, done.stderr)
                self.assertFalse(self.output.exists())

    def test_a_recording_that_cannot_be_written_is_named(self):
        ours, its = pty.openpty()
        done = run("live", f"slcan:{os.ttyname(its)}", "--record", "/nonexistent/a.csv")
        os.close(its)
        os.close(ours)
        self.assertEqual(
            (2, "", "davarlab: --record: /nonexistent/a.csv: No such file or directory\n"),
            (done.returncode, done.stdout, done.stderr),
        )

    def test_help_says_what_is_run_and_what_is_kept(self):
        said = " ".join(run("live", "--help").stdout.split())
        self.assertIn("It runs with your rights: load only files that you trust", said)
        self.assertIn("An existing file is appended to", said)

    def test_the_readme_s_dbc(self):
        done = run("dbc", "--base", "600", "--channel", "2", "-o", str(self.output))
        self.assertEqual((0, f"{self.output}\n", ""), (done.returncode, done.stdout, done.stderr))
        self.assertIn("BO_ 1568 DAVAR_Arw: 8", self.output.read_text())


if __name__ == "__main__":
    unittest.main()
