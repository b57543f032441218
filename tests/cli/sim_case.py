"""What the tests of davar-sim share: the program (environment variable DAVAR_SIM), recordings, and
the form of an error.
"""

import csv
import gzip
import io
import os
import random
import subprocess
from pathlib import Path

import pytest

PROGRAM = os.environ.get("DAVAR_SIM", "davar-sim")
SMALL_WINDOW = ("--window-max", "60", "--window-min", "40", "--segment", "10")
REAL = Path(os.environ.get("DAVAR_REAL_DATA", "../shared/data/real"))


def needs(name):
    """Recordings that may not be distributed are absent in most places."""
    return pytest.mark.skipif(not (REAL / name).is_file(), reason=f"needs the recording {name}")


def noise_rows(count, rate_hz=100.0, columns=1, seed=1):
    """Rows of time_s and white noise on a 0.01 deg/s raster, as text fields."""
    source = random.Random(seed)
    return [
        [f"{i / rate_hz:.4f}"]
        + [f"{0.01 * round(source.gauss(5.0, 30.0)):.2f}" for _ in range(columns)]
        for i in range(count)
    ]


def as_text(header, rows):
    return "\n".join([header] + [",".join(map(str, row)) for row in rows]) + "\n"


def write(path, content):
    """Writes text or bytes, compressed if the name ends in .gz, and returns the path."""
    data = content.encode() if isinstance(content, str) else content
    path.write_bytes(gzip.compress(data) if path.name.endswith(".gz") else data)
    return path


def recording(folder, count=300, name="rec.csv", **details):
    return write(folder / name, as_text("time_s,gyro_x_dps", noise_rows(count, **details)))


def sim(*arguments, stdin=None, **keywords):
    """Runs davar-sim; stdin is bytes, the output is text."""
    command = [PROGRAM, *map(str, arguments)]
    done = subprocess.run(command, input=stdin, capture_output=True, timeout=600, **keywords)
    done.stdout = done.stdout.decode()
    done.stderr = done.stderr.decode(errors="backslashreplace")
    return done


def parsed(text):
    return list(csv.DictReader(io.StringIO(text)))


def results(*arguments, **keywords):
    """The rows of a run that must succeed, as dictionaries."""
    done = sim(*arguments, **keywords)
    assert done.returncode == 0, done.stderr
    return parsed(done.stdout)


def assert_refused(done, *words):
    """Exit status 2, nothing on standard output, one line on standard error with all these
    words.
    """
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith("davar-sim: "), done.stderr
    for word in words:
        assert str(word) in done.stderr
