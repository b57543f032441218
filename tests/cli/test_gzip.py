"""gzip recordings: davar-sim rejects everything that `gzip -t` rejects. No part of a file is
skipped silently.
"""

import gzip
import random
import subprocess
import unittest
import zlib

from sim_case import SMALL_WINDOW, SimCase, as_text, noise_rows

OPTIONS = ("--rate", "100", "--lsb", "0.01", "--stride", "20", *SMALL_WINDOW)


def member(data, extra=b""):
    """One gzip member; `extra` is its optional field."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    body = packer.compress(data) + packer.flush()
    field = len(extra).to_bytes(2, "little") + extra if extra else b""
    return (
        b"\x1f\x8b\x08"
        + bytes([4 if extra else 0])
        + bytes(6)
        + field
        + body
        + zlib.crc32(data).to_bytes(4, "little")
        + len(data).to_bytes(4, "little")
    )


def damaged(data, source):
    """Typical damage of storage and tools: flipped, cut, inserted, lost, added, repeated bytes."""
    at = source.choice(
        [source.randrange(len(data)), source.randrange(24), len(data) - 1 - source.randrange(24)]
    )
    some = source.randbytes(source.choice([1, 1, 2, 7, 40]))
    kind = source.randrange(8)
    if kind < 3:
        return data[:at] + bytes([data[at] ^ 1 << source.randrange(8)]) + data[at + 1 :]
    return (
        data[:at],
        data[:at] + some + data[at:],
        data[:at] + data[at + len(some) :],
        data + source.choice([some, bytes(len(some)), bytes(len(some)) + some, b"\n", b"# end\n"]),
        data + data[source.choice([0, at]) :],
    )[kind - 3]


class Gzip(SimCase):
    def setUp(self):
        super().setUp()
        text = as_text("time_s,gyro_x_dps", noise_rows(200)).encode()
        cut = text.index(b"\n", len(text) // 2) + 1
        self.halves = (text[:cut], text[cut:])
        self.path = self.folder / "rec.csv.gz"
        self.whole = self.outcome(text)

    def outcome(self, data):
        self.path.write_bytes(data)
        return self.sim(self.path, *OPTIONS)

    def accept(self, data):
        done = self.outcome(data)
        self.assertEqual(("", 0, self.whole.stdout), (done.stderr, done.returncode, done.stdout))

    def refuse(self, data, *words):
        self.assert_refused(self.outcome(data), self.path, *words)

    def gzip_accepts(self):
        return subprocess.run(["gzip", "-t", self.path], stderr=subprocess.DEVNULL).returncode == 0

    def test_members_follow_one_another(self):
        first, second = map(gzip.compress, self.halves)
        self.accept(first + second)
        self.accept(gzip.compress(b"") + first + gzip.compress(b"") + second + gzip.compress(b""))
        self.accept(member(self.halves[0], b"some field") + second)

    def test_zeros_at_the_end_are_padding(self):
        whole = b"".join(map(gzip.compress, self.halves))
        for count in (1, 2, 511, 1000000):
            self.accept(whole + bytes(count))
            self.refuse(whole + bytes(count) + b"\n", "after the zeros")
            self.refuse(whole + bytes(count) + whole, "after the zeros")

    def test_a_later_member_whose_magic_is_damaged(self):
        first, second = map(gzip.compress, self.halves)
        for bit in range(8 * 3):
            broken = bytearray(second)
            broken[bit // 8] ^= 1 << bit % 8
            self.refuse(first + broken)

    def test_bytes_that_are_appended(self):
        whole = gzip.compress(b"".join(self.halves))
        for rest in (b"\n", b"\x1f", b"\x1f\x8b", b"1", b"1.99,0\n", b"# end\n", b"\xff" * 300000):
            self.refuse(whole + rest)
        self.refuse(whole + b"1.99,0\n", "not gzip (damaged or appended)")

    def test_a_member_that_is_cut_or_does_not_agree_with_its_check(self):
        first, second = map(gzip.compress, self.halves)
        for length in (1, 2, 9, 10, 100, len(second) - 1):
            self.refuse(first + second[:length], "truncated")
        for byte in range(1, 9):
            for which in (0, 1):
                parts = [bytearray(first), bytearray(second)]
                parts[which][-byte] ^= 0x10
                self.refuse(b"".join(parts), "corrupt gzip data")

    def test_any_damage_is_rejected_when_gzip_rejects_it(self):
        source = random.Random(1)
        whole = [b"".join(map(gzip.compress, self.halves)), gzip.compress(b"".join(self.halves))]
        accepted = 0
        for trial in range(200):
            data = damaged(source.choice(whole), source)
            done = self.outcome(data)
            with self.subTest(trial=trial):
                if self.gzip_accepts() and gzip.decompress(data) == b"".join(self.halves):
                    self.assertEqual(self.whole.stdout, done.stdout)
                    accepted += 1
                elif not self.gzip_accepts():
                    self.assert_refused(done, self.path)
        self.assertGreater(accepted, 5)  # the time stamp in a header, zeros after the end

    # --- bombs

    def bomb(self, head, line, megabytes=70):
        """A few kilobytes that unpack to many megabytes."""
        packer = zlib.compressobj(9, zlib.DEFLATED, 31)
        block = line * (1000000 // len(line))
        return (
            packer.compress(head)
            + b"".join(packer.compress(block) for _ in range(megabytes))
            + packer.flush()
        )

    def test_a_file_that_unpacks_to_far_more_than_its_size_is_rejected(self):
        zeros = b"0." + b"0" * 60  # fewer rows, so that this takes a second, not a minute
        for head, line in (
            (b"time_s,gyro_x_dps\n", b"0," + zeros + b"\n"),
            (b"gyro_x_dps\n", zeros + b"\n"),
            (b"", b"# note" + zeros + b"\n"),
            (b"gyro_x_dps\n1\n", b" " * 60 + b"\n"),
        ):
            with self.subTest(line=line):
                self.refuse(
                    self.bomb(head, line),
                    "more than 64 MiB and 100 times its size",
                    "unpack it first",
                )

    def test_a_line_without_an_end_and_columns_without_number_are_rejected(self):
        self.refuse(self.bomb(b"gyro_x_dps\n1", b"1"), "line longer than 262144 bytes")
        self.refuse(self.bomb(b"", b"a,"), "line longer than 262144 bytes")

    def test_a_long_recording_of_a_stuck_sensor_is_not_a_bomb(self):
        rows = b"time_s,gyro_x_dps\n" + b"".join(b"%d,0.%030d\n" % (i, 0) for i in range(1700000))
        self.assertGreater(len(rows), 64 << 20)
        self.path.write_bytes(gzip.compress(rows, 6))
        self.assertEqual(
            1700000 // 600, len(self.results(self.path, "--lsb", "0.01", "--stride", "600"))
        )


if __name__ == "__main__":
    unittest.main()
