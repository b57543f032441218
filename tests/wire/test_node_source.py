"""davar-node's source: a line is read completely, or it is a fault and a gap of one sample. No line
disappears.
"""

import contextlib
import os
import random
import re
import subprocess
import time

import pytest
from senders import NODE, counters

WHOLE = re.compile(rb"[ \t]*[+-]?[0-9]+[ \t\r]*")
BAD = [
    *(b"", b" ", b"\r", b"nan", b"x", b"#", b"# 5", b"7 8", b"1\x00 34", b"\x00", b"1.0", b"1e3"),
    *(b"0x10", b"--1", b"+", b"5x", b"2147483648", b"-2147483649", b"9" * 30, b"0" * 63 + b"1"),
    *(b"1" * 5000, b"1" * 4095, b"1" * 4096, b"1" * 4097, b" " * 9000, b",5", b"5 6,7"),
    *(b"5\x005,6", b"\xef\xbb\xbf5", b"0" * 24 + b"1"),
]
GOOD = [
    *(b"5", b"-5", b"+5", b" 5", b"5 ", b"5\r", b"\t5\t", b"2147483647", b"-2147483648", b"0005"),
    *(b"5,6,x", b"5,", b" 5 ,6", b"5," + b"6," * 2000, b"0" * 23 + b"1"),
]


def node(text, *options):
    """The counters in its last line: {name: count}. Standard input is a pipe that is filled
    immediately.
    """
    words = [NODE, "--source", "-", "--rate", "100", "--lsb", "0.01", "--out", "slcan:pty"]
    done = subprocess.run([*words, *options], input=text, capture_output=True, check=True)
    return counters(done.stderr.decode())


def assert_counted(lines, samples, header=b""):
    told = node(header + b"".join(line + b"\n" for line in lines))
    found = (told["samples"], told.get("source faults", 0))
    assert found == (samples, len(lines) - samples), (header, lines[:3])
    return told


def test_every_tenth_line_is_no_number():
    lines = [b"nan" if n % 10 == 5 else b"%d" % (n % 7) for n in range(1000)]
    told = assert_counted(lines, 900)
    assert (told["gaps"], told["missing samples"]) == (100, 100)


@pytest.mark.parametrize(
    ("header", "lines", "samples"),
    [
        *((header, [b"1", b"2"], 2) for header in (b"", b"gyro_z_counts\n", b"\r\n")),
        (b"# note: 1\n\n# note: 2\n", [b"1", b"2"], 2),
        (b"# note\ntime_s,gyro_z\r\n", [b"1", b"2"], 2),
        *((b"gyro_z_counts\n", [line, b"1", b"2"], 2) for line in (b"again", b"", b"# late")),
        (b"", [b"nan", b"inf", b"1", b"2"], 2),
        (b"", [b"1", b"2", b""], 2),
        (b"", [b"1", *BAD, b"2"], 2),
        (b"", GOOD, len(GOOD)),
    ],
)
def test_one_header_is_skipped_and_only_at_the_beginning(header, lines, samples):
    assert_counted(lines, samples, header)


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 21))]
)
def test_random_lines(seed):
    source, lines, samples = random.Random(seed), [b"0"], 0
    letters = b"0123456789" * 4 + b" -+,.x\x00\r\xff#"
    for _ in range(300):
        usual = source.random() >= 0.3
        length = source.randrange(1, 9) if usual else source.choice((1, 1, 2, 3, 5, 12, 70, 5000))
        lines.append(bytes(source.choices(letters, k=length)))
    for line in lines:
        first = line.split(b",")[0]
        whole = WHOLE.fullmatch(first) and b"\x00" not in line and len(line) < 4096
        whole = whole and len(first.rstrip()) <= 24
        samples += bool(whole and -(2**31) <= int(first) < 2**31)
    assert_counted(lines, samples)


# --- torn reads: each is a lost sample, and no other sample is lost


def text_of(count, torn, faults=()):
    source = random.Random(2)
    samples = [round(source.gauss(-250, 3)) + torn.get(n, 0) for n in range(count)]
    return b"".join(b"nan\n" if n in faults else b"%d\n" % one for n, one in enumerate(samples))


@pytest.mark.parametrize(
    ("torn", "faults", "expected"),
    [
        ({500: 256, 900: -256, 902: 512, 1500: 65536}, (), (1996, 4, 4, 4)),
        ({500: 256, 700: 256, 900: 256}, (501, 699), (1997, 3, 3, 1)),  # beside a lost one
        ({}, (), (2000, 0, 0, 0)),
    ],
)
def test_torn_reads_are_gaps(torn, faults, expected):
    text = text_of(2000, torn, faults)
    told = node(text, "--skip-torn-reads")
    names = ("samples", "gaps", "missing samples", "torn register reads")
    assert tuple(told.get(name, 0) for name in names) == expected
    told = node(text)
    assert told["samples"] == 2000 - len(faults)
    assert "torn register reads" not in told


@pytest.mark.parametrize("count", range(4))
def test_the_last_sample_is_not_lost(count):
    assert node(text_of(count, {}), "--skip-torn-reads")["samples"] == count


def read_late(seconds):
    """What a peer of davar-node receives that reads nothing for so long."""
    words = [NODE, "--source", "-", "--rate", "100", "--lsb", "0.01", "--out", "slcan:pty"]
    process = subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
    name = re.search(rb"/dev/pts/[0-9]+", process.stderr.readline())[0]
    peer = os.open(name, os.O_RDWR | os.O_NOCTTY)
    process.stdin.write(b"".join(b"%d\n" % (n * n % 37) for n in range(2000)))
    process.stdin.close()
    time.sleep(seconds)
    found = b""
    with contextlib.suppress(OSError):  # the other side has been closed
        while part := os.read(peer, 4096):
            found += part
    os.close(peer)
    assert process.wait() == 0
    process.stderr.close()
    return found


@pytest.mark.slow
def test_a_peer_that_reads_late_receives_every_byte():
    assert read_late(0.0).count(b"\r") > 10
    assert len(read_late(5.0)) == len(read_late(0.0))
