"""davar-node: a bad option gives one line with its name, exit status 2, and nothing on standard
output. tests/kernel/test_gpio.py tests lines and chips that do not exist or are busy.
"""

import re
import subprocess

import pytest
from senders import NODE

GOOD = ("--source", "-", "--rate", "100", "--lsb", "0.01", "--out", "slcan:pty")
MAVLINK = "--out mavlink:udp:127.0.0.1:9"
# Values, separated by spaces; '' is the empty one.
REFUSED = {
    "--rate": "0 -5 nan inf 1e400 100x '' x",
    "--lsb": "0 -1 nan x",
    "--bits": "1 33 x -8 4294967312",
    "--bandwidth": "'' x 0.01 -1",
    "--law": "none ''",
    "--kurtosis": "3:2 2 x",
    "--contribution": "1:0",
    "--unstable-rate": "0 1",
    "--taus": "0,1 2,1 1,301 fourier",
    "--shrink": "2147483648 -1",
    "--engine": "grids",
    "--window-max": "0 3 4294967296 -600 6e2 100000000",
    "--window-min": "0 601 x",
    "--segment": "0 400 5000 1.5",
    "--stride": "0 16777217 -1",
    "--longest-tau": "0 -1 nan x 1.27 1e9",
    "--content": "all ''",
    "--base": "5D0h 800 7FF -1 ''",
    "--channel": "35 300 -1 x",
    "--baud": "fast -1",
    "--alarm-on": "-1 nan 1e300 x",
    "--alarm-off": "-1 1e7",
    "--source": "/nonexistent / '' value:/etc/hostname",
}
ANY = "mavlink:.., dronecan:IFACE or cyphal:IFACE"
OWN = "needs --out can:IFACE or slcan:PATH"
FORMS = "mavlink:udp:HOST:PORT, mavlink:serial:PATH, dronecan:IFACE or cyphal:IFACE expected, found"
HOST = "HOST:PORT expected"
NO_FILE = "No such file or directory"
LONG = "no interface has such a long name"
# Words after GOOD, and what the line contains.
TOGETHER = {
    "--bogus": "unknown option '--bogus'",
    "-x": "unknown option '-x'",
    "--raw=1": "--raw: takes no value",
    "--law glr --block 4": "--law glr: ",
    "--unstable-rate 0.01 --kurtosis 2:4": "--unstable-rate: sets the ranges of --kurtosis",
    "--long-cluster 80": "--long-cluster: removed; use --longest-tau",
    "more": "unexpected argument 'more'",
    **{f"--out {out}": f"--out: can:IFACE, slcan:PATH, {FORMS} '{out}'"
       for out in ("can:", "lin:0", "mavlink:", "mavlink:udp:")},
    "--out mavlink:udp:127.0.0.1": f"--out: mavlink:udp:127.0.0.1: {HOST}",
    "--out mavlink:udp:127.0.0.1:": f"--out: mavlink:udp:127.0.0.1:: {HOST}",
    "--out mavlink:udp::14550": f"--out: mavlink:udp::14550: {HOST}",
    "--out mavlink:udp:127.0.0.1:http": "--out: mavlink:udp:127.0.0.1:http: ",
    "--out mavlink:serial:/nonexistent": f"--out: mavlink:serial:/nonexistent: {NO_FILE}",
    "--out slcan:/nonexistent": f"--out: slcan:/nonexistent: {NO_FILE}",
    "--out slcan:/dev/null": "--out: slcan:/dev/null: ",
    "--out dronecan:a_name_that_is_too_long": LONG,
    "--out can:a_name_that_is_too_long": LONG,
    "--content fd": "--out: slcan:pty: a serial line carries no CAN FD frames",
    "--base 7F0 --channel 1": "--base: channel 1 does not fit into 11-bit identifiers",
    **{f"{name} glr --alarm-on 1": "--alarm-on: cannot be used with --law glr"
       for name in ("--law", "--policy")},  # its old name
    "--floor": "--floor: -: the filter is unknown, and the floor reads too low where it is; give "
               "--bandwidth FILTER, or none for raw samples",
    **{f"--out {out} --floor --bandwidth none": "--floor: needs --out can:IFACE, slcan:PATH or "
       "mavlink:.." for out in ("dronecan:can0", "cyphal:can0")},
    "--node-id 5": f"--node-id: needs --out {ANY}",
    **{f"--out {out} --system-id 5": "--system-id: needs --out mavlink:.."
       for out in ("slcan:pty", "dronecan:can0", "cyphal:can0")},
    **{f"--out {out} --subject-id 5": "--subject-id: needs --out cyphal:IFACE"
       for out in ("slcan:pty", "dronecan:can0", "mavlink:serial:pty")},
    **{f"{MAVLINK} {option}": f"{option.split()[0]}: {OWN}"
       for option in ("--raw", "--base 5D0", "--content full")},
    **{f"{MAVLINK} --node-id {value}": "--node-id: " for value in ("0", "256", "x", "4294967295")},
    **{f"{MAVLINK} --system-id {value}": "--system-id: " for value in ("0", "256", "-1")},
    **{f"{MAVLINK} --channel {value}": "--channel: " for value in ("10", "34", "4294967295")},
    **{f"--out {kind}:can0 --node-id {value}": "--node-id: 1 to 127 expected"
       for kind in ("dronecan", "cyphal") for value in ("0", "128")},
    **{f"--out cyphal:can0 --subject-id {value}": "--subject-id: " for value in ("8192", "x")},
    **{f"{option} five": f"{option}: CHIP:LINE expected, found 'five'"
       for option in ("--edges", "--alarm")},
}  # fmt: skip
# A limit that is accepted: the link is what is missing.
ACCEPTED = (
    *("--bits 2", "--bits 32", "--channel 34", "--alarm-on 1e6", "--longest-tau 1.28"),
    *("--base 7F0", "--window-min 600 --segment 100", "--stride 600"),
)


def node(*options):
    return subprocess.run(
        [NODE, *options], text=True, stdin=subprocess.DEVNULL, capture_output=True, timeout=600
    )


def assert_refused(wanted, *options):
    done = node(*options)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert re.fullmatch(r"davar-node: [^\n]+\n", done.stderr)
    assert wanted in done.stderr


@pytest.mark.parametrize("option", REFUSED)
def test_a_bad_or_missing_value_is_rejected_and_its_option_named(option):
    for value in REFUSED[option].split():
        assert_refused(f"{option}: ", *GOOD, option, "" if value == "''" else value)
    assert_refused(f"{option}: needs a value", *GOOD, option)


def test_what_does_not_fit_together_is_rejected():
    for words, wanted in TOGETHER.items():
        assert_refused(wanted, *GOOD, *words.split())
    for option in ("--out", "--edges", "--alarm"):
        assert_refused(f"{option}: needs a value", *GOOD, option)


def test_what_is_at_the_limit_is_accepted():
    for words in ACCEPTED:
        assert_refused(f"--out: slcan:/x: {NO_FILE}", *GOOD, *words.split(), "--out", "slcan:/x")


def test_required_options():
    assert_refused("--source: required")
    assert_refused("--out: required", "--source", "-")
    for missing, rest in (("--rate", ("--lsb", "1")), ("--lsb", ("--rate", "1"))):
        assert_refused(f"{missing}: required", "--source", "-", "--out", "slcan:pty", *rest)


def test_help_states_that_a_process_has_one_channel():
    done = node("--help")
    assert (done.returncode, done.stderr) == (0, "")
    assert "One process handles one channel" in done.stdout
    assert "policy" not in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    assert re.fullmatch(r"davar-node \d+\.\d+\.\d+\n", node("--version").stdout)
