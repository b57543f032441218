"""Files that davarlab writes are whole or not there, whatever signal comes at whatever line;
nothing else stays behind.
"""

import os
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "tools/lab"
STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# argv: signal, number of the line of files.py at which it comes, call, file. Says on standard
# output that it has come.
CHILD = """
import os, signal, sys
from davarlab import files
# whoever started the tests may ignore some
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGTERM, signal.SIG_DFL)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
number, left = int(sys.argv[1]), int(sys.argv[2])
def at_line(frame, event, value):
    global left
    if frame.f_code.co_filename == files.__file__:
        left -= event == "line"
        if left == 0 and event == "line":
            print("came", flush=True)
            os.kill(os.getpid(), number)
        return at_line
sys.settrace(at_line)
calls = {"write": lambda path: files.write_whole(path, b"new"), "check": files.check_writable}
calls[sys.argv[3]](sys.argv[4])
"""


class Signals(unittest.TestCase):
    def run_child(self, call, number, line):
        """The exit status of a run with a signal at a line, and what the folder holds then; None:
        it has no such line.
        """
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "file"
            path.write_bytes(b"old")
            done = subprocess.run(
                [sys.executable, "-c", CHILD, str(int(number)), str(line), call, path],
                env=dict(os.environ, PYTHONPATH=str(PACKAGE)),
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
            held = {entry.name: entry.read_bytes() for entry in Path(folder).iterdir()}
        return (done.returncode, held) if done.stdout else None

    def test_at_every_line(self):
        for call, contents in (("write", (b"old", b"new")), ("check", (b"old",))):
            line = 1
            while (
                outcome := self.run_child(call, number := STOPS[line % len(STOPS)], line)
            ) is not None:
                with self.subTest(call=call, number=number, line=line):
                    status, held = outcome
                    self.assertEqual(-number, status)
                    self.assertEqual(["file"], list(held))
                    self.assertIn(held["file"], contents)
                line += 1
            self.assertGreater(line, 5)


if __name__ == "__main__":
    unittest.main()
