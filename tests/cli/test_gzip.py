"""gzip recordings: davar-sim rejects everything that `gzip -t` rejects. No part of a file is
skipped silently.
"""

import gzip
import random
import subprocess
import zlib

import pytest
from sim_case import SMALL_WINDOW, as_text, assert_refused, noise_rows, results, sim

OPTIONS = ("--rate", "100", "--lsb", "0.01", "--stride", "20", *SMALL_WINDOW)
TEXT = as_text("time_s,gyro_x_dps", noise_rows(200)).encode()
CUT = TEXT.index(b"\n", len(TEXT) // 2) + 1
HALVES = (TEXT[:CUT], TEXT[CUT:])
FIRST, SECOND = map(gzip.compress, HALVES)
WHOLE = gzip.compress(TEXT)


def member(data, extra):
    """One gzip member with an optional field."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    body = packer.compress(data) + packer.flush()
    head = b"\x1f\x8b\x08\x04" + bytes(6) + len(extra).to_bytes(2, "little") + extra
    check = zlib.crc32(data).to_bytes(4, "little") + len(data).to_bytes(4, "little")
    return head + body + check


def flipped(data, at, bits):
    changed = bytearray(data)
    changed[at] ^= bits
    return bytes(changed)


def damaged(data, source):
    """Typical damage of storage and tools: flipped, cut, inserted, lost, added, repeated bytes."""
    last = len(data) - 1 - source.randrange(24)
    at = source.choice([source.randrange(len(data)), source.randrange(24), last])
    some = source.randbytes(source.choice([1, 1, 2, 7, 40]))
    more = source.choice([some, bytes(len(some)), bytes(len(some)) + some, b"\n", b"# end\n"])
    kinds = (
        *[flipped(data, at, 1 << source.randrange(8))] * 3,
        data[:at],
        data[:at] + some + data[at:],
        data[:at] + data[at + len(some) :],
        data + more,
        data + data[source.choice([0, at]) :],
    )
    return source.choice(kinds)


@pytest.fixture
def outcome(tmp_path):
    def run(data):
        path.write_bytes(data)
        return sim(path, *OPTIONS)

    path = tmp_path / "rec.csv.gz"
    run.path = path
    run.whole = run(TEXT).stdout
    assert run.whole.count("\n") == 11
    return run


EMPTY = gzip.compress(b"")
ACCEPTED = {
    "members": FIRST + SECOND,
    "empty members": EMPTY + FIRST + EMPTY + SECOND + EMPTY,
    "a field": member(HALVES[0], b"some field") + SECOND,
    **{f"{count} zeros": FIRST + SECOND + bytes(count) for count in (1, 2, 511, 1000000)},
}
ZEROS, OTHERS = "after the zeros", "not gzip (damaged or appended)"
REST = (b"1", b"\n", b"1.99,0\n", b"# end\n", b"\xff" * 300000)
REJECTED = [
    *(
        (FIRST + SECOND + bytes(count) + rest, ZEROS)
        for count in (1, 511, 1000000)
        for rest in (b"\n", FIRST)
    ),
    *((FIRST + flipped(SECOND, bit // 8, 1 << bit % 8), "") for bit in range(24)),
    *((WHOLE + rest, OTHERS) for rest in REST),
    (WHOLE + b"\x1f", ""),
    (WHOLE + b"\x1f\x8b", "truncated"),
    *((FIRST + SECOND[:length], "truncated") for length in (9, 10, 100, len(SECOND) - 1)),
    *((flipped(FIRST, -byte, 16) + SECOND, "corrupt gzip data") for byte in range(1, 9)),
    *((FIRST + flipped(SECOND, -byte, 16), "corrupt gzip data") for byte in range(1, 9)),
]


@pytest.mark.parametrize("name", ACCEPTED)
def test_members_and_padding_are_accepted(outcome, name):
    done = outcome(ACCEPTED[name])
    assert (done.stderr, done.returncode, done.stdout) == ("", 0, outcome.whole)


def test_a_part_that_is_damaged_or_appended_is_rejected(outcome):
    for data, words in REJECTED:
        assert_refused(outcome(data), outcome.path, words)


@pytest.mark.parametrize("trials", [40, pytest.param(200, marks=pytest.mark.slow)])
def test_any_damage_is_rejected_when_gzip_rejects_it(outcome, trials):
    source, accepted = random.Random(1), 0
    for _ in range(trials):
        data = damaged(source.choice([FIRST + SECOND, WHOLE]), source)
        done = outcome(data)
        test = subprocess.run(["gzip", "-t", outcome.path], stderr=subprocess.DEVNULL)
        if test.returncode != 0:
            assert_refused(done, outcome.path)
        elif gzip.decompress(data) == TEXT:
            assert done.stdout == outcome.whole
            accepted += 1
    assert accepted > trials // 40  # the time stamp in a header, zeros after the end


# --- bombs


@pytest.mark.parametrize(
    ("head", "line", "why"),
    [
        (b"time_s,gyro_x_dps\n", b"0,0." + b"0" * 2000 + b"\n", None),
        (b"gyro_x_dps\n", b"0." + b"0" * 2000 + b"\n", None),
        (b"", b"# note" + b"0" * 60 + b"\n", None),
        (b"gyro_x_dps\n1\n", b" " * 60 + b"\n", None),
        (b"gyro_x_dps\n1", b"1", "line longer than 262144 bytes"),
        (b"", b"a,", "line longer than 262144 bytes"),
    ],
)
def test_a_file_that_unpacks_to_far_more_than_its_size_is_rejected(outcome, head, line, why):
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    block = line * (1000000 // len(line))
    data = packer.compress(head) + b"".join(packer.compress(block) for _ in range(70))
    wanted = (why,) if why else ("more than 64 MiB and 100 times its size", "unpack it first")
    assert_refused(outcome(data + packer.flush()), outcome.path, *wanted)


@pytest.mark.slow
def test_a_long_recording_of_a_stuck_sensor_is_not_a_bomb(outcome):
    rows = b"time_s,gyro_x_dps\n" + b"".join(b"%d,0.%030d\n" % (i, 0) for i in range(1700000))
    assert len(rows) > 64 << 20
    outcome.path.write_bytes(gzip.compress(rows, 6))
    assert len(results(outcome.path, "--lsb", "0.01", "--stride", "600")) == 1700000 // 600
