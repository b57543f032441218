"""davar-node's source: a line is read completely, or it is a fault and a gap of one sample. No line
disappears.
"""

import os
import random
import re
import subprocess
import unittest

NODE = os.environ.get("DAVAR_NODE", "davar-node")
WHOLE = re.compile(rb"[ \t]*[+-]?[0-9]+[ \t\r]*")


def node(text, *options):
    """The counters in its last line: {name: count}. Standard input is a pipe that is filled
    immediately.
    """
    done = subprocess.run(
        [NODE, "--source", "-", "--rate", "100", "--lsb", "0.01", "--out", "slcan:pty", *options],
        input=text,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        check=True,
    )
    words = done.stderr.decode().splitlines()[-1].removeprefix("davar-node: ").split(", ")
    return {word.split(" ", 1)[1]: int(word.split(" ", 1)[0]) for word in words}


class Source(unittest.TestCase):
    def check(self, lines, samples, header=b""):
        told = node(header + b"".join(line + b"\n" for line in lines))
        wanted = (samples, len(lines) - samples)
        self.assertEqual(
            wanted, (told["samples"], told.get("source faults", 0)), (header, lines[:20])
        )
        return told

    def test_every_tenth_line_is_no_number(self):
        lines = [b"nan" if n % 10 == 5 else b"%d" % (n % 7) for n in range(1000)]
        told = self.check(lines, 900)
        self.assertEqual((100, 100), (told["gaps"], told["missing samples"]))

    def test_a_value_that_is_not_a_32_bit_integer_is_a_fault(self):
        bad = [
            b"",
            b" ",
            b"\r",
            b"nan",
            b"x",
            b"#",
            b"# 5",
            b"7 8",
            b"1\x00 34",
            b"\x00",
            b"1.0",
            b"1e3",
            b"0x10",
            b"--1",
            b"+",
            b"5x",
            b"2147483648",
            b"-2147483649",
            b"9" * 30,
            b"0" * 63 + b"1",
            b"1" * 5000,
            b"1" * 4095,
            b"1" * 4096,
            b"1" * 4097,
            b" " * 9000,
            b",5",
            b"5 6,7",
            b"5\x005,6",
            b"\xef\xbb\xbf5",
        ]
        good = [
            b"5",
            b"-5",
            b"+5",
            b" 5",
            b"5 ",
            b"5\r",
            b"\t5\t",
            b"2147483647",
            b"-2147483648",
            b"0005",
            b"5,6,x",
            b"5,",
            b" 5 ,6",
            b"5," + b"6," * 2000,
        ]
        for line in bad:
            told = self.check([b"1", line, b"2"], 2)
            self.assertEqual((1, 1), (told["gaps"], told["missing samples"]), line[:20])
        self.check([b"1", *bad, b"2"], 2)
        self.check(good, len(good))

    def test_one_header_is_skipped_and_only_at_the_beginning(self):
        lines = [b"1", b"2"]
        for header in (
            b"",
            b"# note: 1\n\n# note: 2\n",
            b"gyro_z_counts\n",
            b"# note\ntime_s,gyro_z\r\n",
            b"\r\n",
        ):
            self.check(lines, 2, header)
        self.check([b"again", *lines], 2, b"gyro_z_counts\n")
        self.check([b"", *lines], 2, b"gyro_z_counts\n")
        self.check([b"# late", *lines], 2, b"gyro_z_counts\n")
        self.check([b"nan", b"inf", *lines], 2)
        self.check([b"1", b"2", b""], 2)

    def test_random_lines(self):
        source = random.Random(1)
        for _ in range(20):
            lines = [b"0"]
            for _ in range(300):
                length = (
                    source.choice((1, 1, 2, 3, 5, 12, 70, 5000))
                    if source.random() < 0.3
                    else source.randrange(1, 9)
                )
                lines.append(
                    bytes(
                        source.choice(b"0123456789012345678901234567890123456789 -+,.x\x00\r\xff#")
                        for _ in range(length)
                    )
                )
            samples = 0
            for line in lines:
                first = line.split(b",")[0]
                whole = (
                    WHOLE.fullmatch(first)
                    and b"\x00" not in line
                    and len(line) < 4096
                    and len(first.rstrip()) <= 24
                )
                samples += bool(whole and -(2**31) <= int(first) < 2**31)
            self.check(lines, samples)


class Torn(unittest.TestCase):
    """--skip-torn-reads: each torn read is a lost sample, and no other sample is lost."""

    def lines(self, count, torn, faults=()):
        source = random.Random(2)
        samples = [round(source.gauss(-250, 3)) + torn.get(n, 0) for n in range(count)]
        return b"".join(
            b"nan\n" if n in faults else b"%d\n" % sample for n, sample in enumerate(samples)
        )

    def test_torn_reads_are_gaps(self):
        text = self.lines(2000, {500: 256, 900: -256, 902: 512, 1500: 65536})
        told = node(text, "--skip-torn-reads")
        self.assertEqual(
            (1996, 4, 4, 4),
            tuple(told[x] for x in ("samples", "gaps", "missing samples", "torn register reads")),
        )
        told = node(text)
        self.assertEqual(2000, told["samples"])
        self.assertNotIn("torn register reads", told)

    def test_a_sample_beside_a_lost_one_is_not_tested(self):
        text = self.lines(2000, {500: 256, 700: 256, 900: 256}, faults=(501, 699))
        told = node(text, "--skip-torn-reads")
        self.assertEqual(
            (1997, 3, 3, 1),
            tuple(told[x] for x in ("samples", "gaps", "missing samples", "torn register reads")),
        )

    def test_the_last_sample_is_not_lost(self):
        for count in (1, 2, 3):
            self.assertEqual(count, node(self.lines(count, {}), "--skip-torn-reads")["samples"])
        self.assertEqual(0, node(b"", "--skip-torn-reads")["samples"])


if __name__ == "__main__":
    unittest.main()
