"""Files that davarlab writes are whole or not there, whatever signal comes at whatever line;
nothing else stays behind.
"""

import os
import signal
import sys

import pytest
from davarlab import files

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
CALLS = {
    "write": (lambda path: files.write_whole(path, b"new"), (b"old", b"new")),
    "check": (files.check_writable, (b"old",)),
}


def interrupted(call, path, number, line):
    """(exit status or signal, did it come) of a child that gets a signal at a line of files.py."""
    there, child_end = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            signal.signal(signal.SIGHUP, signal.SIG_DFL)
            left = line

            def at_line(frame, event, _):
                nonlocal left
                if frame.f_code.co_filename == files.__file__:
                    left -= event == "line"
                    if left == 0 and event == "line":
                        os.write(child_end, b"c")
                        os.kill(os.getpid(), number)
                    return at_line

            sys.settrace(at_line)
            call(path)
        except KeyboardInterrupt:
            sys.settrace(None)
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            os.kill(os.getpid(), signal.SIGINT)
        finally:
            os._exit(0)
    os.close(child_end)
    with os.fdopen(there, "rb") as came:
        found = bool(came.read())
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), found


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
def test_a_signal_at_every_line(tmp_path, name):
    call, contents = CALLS[name]
    path, line = tmp_path / "file", 1
    while True:
        path.write_bytes(b"old")
        number = STOPS[line % len(STOPS)]
        status, came = interrupted(call, path, number, line)
        if not came:
            break
        assert status == -number, line
        assert [entry.name for entry in tmp_path.iterdir()] == ["file"], line
        assert path.read_bytes() in contents, line
        line += 1
    assert line > 6
