"""davar-node: a bad option gives one line with its name, exit status 2, and nothing on standard
output. tests/kernel/test_gpio.py tests lines and chips that do not exist or are busy.
"""

import os
import subprocess
import unittest

NODE = os.environ.get("DAVAR_NODE", "davar-node")
GOOD = ("--source", "-", "--rate", "100", "--lsb", "0.01", "--out", "slcan:pty")
MAVLINK = ("--out", "mavlink:udp:127.0.0.1:9")
REFUSED = {
    "--rate": ["0", "-5", "nan", "inf", "1e400", "100x", "", "x"],
    "--lsb": ["0", "-1", "nan", "x"],
    "--bits": ["1", "33", "x", "-8", "4294967312"],
    "--window-max": ["0", "3", "4294967296", "-600", "6e2", "100000000"],
    "--window-min": ["0", "601", "x"],
    "--segment": ["0", "400", "5000", "1.5"],
    "--stride": ["0", "16777217", "-1"],
    "--long-cluster": ["x", "-1"],
    "--longest-tau": ["0", "-1", "nan", "x", "1.27", "1e9"],
    "--content": ["all", ""],
    "--base": ["5D0h", "800", "7FF", "-1", ""],
    "--channel": ["35", "300", "-1", "x"],
    "--baud": ["fast", "-1"],
    "--alarm-on": ["-1", "nan", "1e300", "x"],
    "--alarm-off": ["-1", "1e7"],
    "--source": ["/nonexistent", "/", "", "value:/etc/hostname"],
}
FORMS = (
    "can:IFACE, slcan:PATH, mavlink:udp:HOST:PORT, mavlink:serial:PATH, dronecan:IFACE or "
    "cyphal:IFACE"
)
LINKS = {
    "can:": "--out: " + FORMS + " expected, found 'can:'",
    "lin:0": "--out: " + FORMS + " expected, found 'lin:0'",
    "mavlink:": "expected, found 'mavlink:'",
    "mavlink:udp:": "expected, found 'mavlink:udp:'",
    "mavlink:udp:127.0.0.1": "--out: mavlink:udp:127.0.0.1: HOST:PORT expected",
    "mavlink:udp:127.0.0.1:": "--out: mavlink:udp:127.0.0.1:: HOST:PORT expected",
    "mavlink:udp::14550": "--out: mavlink:udp::14550: HOST:PORT expected",
    "mavlink:udp:127.0.0.1:http": "--out: mavlink:udp:127.0.0.1:http: ",
    "mavlink:serial:/nonexistent": "--out: mavlink:serial:/nonexistent: No such file or directory",
    "dronecan:a_name_that_is_too_long": "no interface has such a long name",
    "slcan:/nonexistent": "--out: slcan:/nonexistent: No such file or directory",
    "slcan:/dev/null": "--out: slcan:/dev/null: ",
    "can:a_name_that_is_too_long": "no interface has such a long name",
}


def node(*options):
    return subprocess.run(
        [NODE, *options],
        text=True,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=600,
        check=False,
    )


class BadOptions(unittest.TestCase):
    def refused(self, wanted, *options):
        done = node(*options)
        self.assertEqual((2, ""), (done.returncode, done.stdout), done.stderr)
        self.assertRegex(done.stderr, r"\Adavar-node: [^\n]+\n\Z")
        self.assertIn(wanted, done.stderr)

    def test_a_bad_value_is_rejected_and_its_option_reported(self):
        for option, values in REFUSED.items():
            for value in values:
                with self.subTest(option=option, value=value):
                    self.refused(f"{option}: ", *GOOD, option, value)

    def test_a_value_that_is_missing(self):
        for option in (*REFUSED, "--out", "--edges", "--alarm"):
            self.refused(f"no value for '{option}'", *GOOD, option)

    def test_an_unknown_option_and_a_stray_word(self):
        self.refused("unknown option '--bogus'", *GOOD, "--bogus")
        self.refused("unknown option '-x'", *GOOD, "-x")
        self.refused("unexpected argument 'more'", *GOOD, "more")

    def test_required_notes(self):
        self.refused("--source: required")
        self.refused("--out: required", "--source", "-")
        self.refused("--rate: ", "--source", "-", "--out", "slcan:pty", "--lsb", "1")
        self.refused("--lsb: ", "--source", "-", "--out", "slcan:pty", "--rate", "1")

    def test_a_link_that_cannot_be(self):
        for out, why in LINKS.items():
            self.refused(why, *GOOD, "--out", out)
        for out in ("mavlink:udp:127.0.0.1", "mavlink:udp:127.0.0.1:http"):
            self.refused(LINKS[out], *GOOD, "--out", out, "--wait")
        self.refused(
            "--out: slcan:pty: a serial line carries no CAN FD frames", *GOOD, "--content", "fd"
        )
        self.refused(
            "channel 1 does not fit into 11-bit identifiers",
            *GOOD,
            "--base",
            "7F0",
            "--channel",
            "1",
        )

    def test_an_option_of_another_kind_of_output(self):
        allowed = {
            "--node-id": "mavlink:.., dronecan:IFACE or cyphal:IFACE",
            "--system-id": "mavlink:..",
            "--subject-id": "cyphal:IFACE",
        }
        others = {
            "--node-id": ("slcan:pty",),
            "--system-id": ("slcan:pty", "dronecan:can0", "cyphal:can0"),
            "--subject-id": ("slcan:pty", "dronecan:can0", "mavlink:serial:pty"),
        }
        for option, outputs in others.items():
            for out in outputs:
                self.refused(
                    f"{option}: needs --out {allowed[option]}", *GOOD, "--out", out, option, "5"
                )
        for option in (("--raw",), ("--base", "5D0"), ("--content", "full")):
            self.refused(
                f"{option[0]}: needs --out can:IFACE or slcan:PATH", *GOOD, *MAVLINK, *option
            )

    def test_an_address_that_a_dialect_does_not_have(self):
        for out, option, values in (
            ("mavlink:udp:127.0.0.1:9", "--node-id", ("0", "256", "x", "4294967295")),
            ("mavlink:udp:127.0.0.1:9", "--system-id", ("0", "256", "-1")),
            ("mavlink:udp:127.0.0.1:9", "--channel", ("10", "34", "4294967295")),
            ("dronecan:can0", "--node-id", ("0", "128")),
            ("cyphal:can0", "--node-id", ("0", "128")),
            ("cyphal:can0", "--subject-id", ("8192", "x")),
        ):
            for value in values:
                self.refused(f"{option}: ", *GOOD, "--out", out, option, value)

    def test_a_bad_pin(self):
        for option in ("--edges", "--alarm"):
            self.refused(f"{option}: CHIP:LINE expected, found 'five'", *GOOD, option, "five")

    def test_help_states_that_a_process_has_one_channel(self):
        done = node("--help")
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        self.assertIn("One process handles one channel", done.stdout)
        self.assertEqual([], [line for line in done.stdout.splitlines() if len(line) > 100])


if __name__ == "__main__":
    unittest.main()
