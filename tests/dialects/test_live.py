"""davarlab live in the dialects: the values that davar sent, and what happens when messages are
lost, repeated or cut, and when the sender starts again. tests/kernel/test_dialects.py has the bus.
"""

import contextlib
import csv
import itertools
import json
import math
import os
import pty
import signal
import socket
import subprocess
import sys
import time
import tty

import numpy as np
import pytest
from davar.wire import dialects, record
from pymavlink.dialects.v20 import common
from random_results import ARW, BI, QN, RR, RRW, packets, results, sent

LIMITS = ("", "_low", "_high")
COLUMNS = {f"arw{limit}_deg_per_sqrt_h": (ARW, at) for at, limit in enumerate(LIMITS)}
COLUMNS |= {"bi_deg_per_h": (BI, 0), "rrw_deg_per_h_per_sqrt_h": (RRW, 0)}
COLUMNS |= {"rr_deg_per_h2": (RR, 0), "qn_deg": (QN, 0)}
REASONS = (None, None, "mixed", "constant", "coarse", "filtered")
COUNT = 200
HANG_S = 600  # however busy the machine is


def consecutive(seed, first=0, count=COUNT):
    """Random results every 100 samples."""
    made = results(seed, count)
    made["epoch"] = first + 99 + 100 * np.arange(count)
    return made


def received(receiver, frames):
    found = [receiver.push(*frame) for frame in frames]
    return [one for one in found if one] + receiver.finish()


EACH = {"mavlink": 3, "dronecan": 6, "cyphal": 1}  # packets of a result
every_dialect = pytest.mark.parametrize("dialect", EACH)


def assert_values(made, found, dialect, channel=4):
    """Results of davar, whole or, of DroneCAN, ARW and BI only."""
    assert len(found) == len(made)
    assert {one.channel for one in found} <= {channel}
    has_all = dialect != "dronecan"
    for name, (kind, column) in list(COLUMNS.items())[: None if has_all else 4]:
        wanted = sent(made["coefficient"][:, kind, column], column == 2)
        np.testing.assert_array_equal(wanted, [one.values[name] for one in found], name)
    if not has_all:
        return
    assert [one.epoch for one in found] == list(made["epoch"])
    for name in ("unstable", "young", "alarm"):
        assert [one.values.get(name, 0) for one in found] == list(made[name]), name
    for one, noise in zip(found, made["noise"]):
        reason = REASONS[noise] if math.isnan(one.values["arw_deg_per_sqrt_h"]) else None
        assert one.values.get("arw_withheld") == reason
        assert one.sender.setup["rate_hz"] == pytest.approx(99.3, abs=1e-5)


@every_dialect
def test_every_dialect_gives_the_values_that_were_sent(dialect):
    made, receiver = consecutive(1), dialects.DialectReceiver(dialect)
    assert_values(made, received(receiver, packets(dialect, made, channel=4)), dialect)
    assert receiver.faults.total() == 0, receiver.faults


@pytest.mark.parametrize("dialect", ["gyro_noise", "dronecan", "cyphal"])
def test_messages_without_a_place_for_the_floor_do_not_change(dialect):
    made = consecutive(3)
    assert packets(dialect, made, floor=1) == packets(dialect, made)


@every_dialect
def test_lost_packets_are_counted_and_no_result_is_mixed(dialect):
    each, made, receiver = EACH[dialect], consecutive(2), dialects.DialectReceiver(dialect)
    frames = packets(dialect, made, channel=4)
    lost = {each * row + row % each for row in range(1, COUNT - 1, 7)}
    found = received(receiver, [frame for at, frame in enumerate(frames) if at not in lost])
    harmed = {at // each for at in lost if dialect != "mavlink" or at % each == 2}
    rest = [row for row in range(COUNT) if row not in harmed]
    assert_values(made[rest], found, dialect)
    assert receiver.faults.missing == len(lost)


@every_dialect
def test_a_second_sender_of_a_channel_is_foreign(dialect):
    made, receiver, each = consecutive(9), dialects.DialectReceiver(dialect), EACH[dialect]
    mine = packets(dialect, made, channel=4)
    others = packets(dialect, consecutive(10), channel=4, node=43)
    rows = [slice(each * row, each * row + each) for row in range(COUNT)]
    frames = [frame for row in rows for side in (mine, others) for frame in side[row]]
    assert_values(made, received(receiver, frames), dialect)
    assert (receiver.faults.foreign, receiver.faults.total()) == (COUNT, 0)


@pytest.mark.parametrize(("dialect", "modulus"), [("mavlink", 2**24), ("cyphal", 2**32)])
def test_a_sender_that_starts_again_and_an_epoch_beyond_what_a_message_holds(dialect, modulus):
    receiver = dialects.DialectReceiver(dialect)
    for stretch, seed in ((1, 3), (2, 4)):
        found = received(receiver, packets(dialect, consecutive(seed), channel=4))
        assert {one.stretch for one in found} == {stretch}
        assert_values(consecutive(seed), found, dialect)
    assert receiver.faults.restarts == 1
    made = consecutive(5, first=modulus - 1000)
    found = received(dialects.DialectReceiver(dialect), packets(dialect, made, channel=4))
    assert [one.epoch for one in found] == list(made["epoch"])


@pytest.mark.parametrize("damaged", [False, True])
def test_a_mavlink_stream_may_be_cut_and_damaged_anywhere(damaged):
    made, source = consecutive(7), np.random.default_rng(7)
    stream = bytearray(b"".join(data for _, data in packets("mavlink", made, channel=4)))
    receiver = dialects.DialectReceiver("mavlink")
    for at in source.integers(0, len(stream), 40 if damaged else 0):
        stream[at] ^= 1 << int(source.integers(8))
    cuts = sorted({0, len(stream), *map(int, source.integers(0, len(stream), 300))})
    found = received(receiver, [(0, bytes(stream[a:b])) for a, b in zip(cuts, cuts[1:])])
    kept = {one.epoch for one in found}
    assert_values(made[[int(row["epoch"]) in kept for row in made]], found, "mavlink")
    assert (receiver.faults.total() > 0) == damaged
    assert len(found) > 120


def test_a_piece_gives_all_its_results_and_a_repeated_message_one():
    stream = b"".join(data for _, data in packets("mavlink", consecutive(7), channel=4))
    receiver = dialects.DialectReceiver("mavlink")
    assert (len(dialects.results(receiver, 0, stream)), len(receiver.ready)) == (COUNT, 0)
    frames = packets("cyphal", consecutive(6), channel=4)
    twice = [frame for frame in frames for _ in range(2)]
    assert len(received(dialects.DialectReceiver("cyphal"), twice)) == COUNT


@pytest.mark.parametrize(
    ("dialect", "identifier", "data"),
    [
        ("dronecan", 0x1801552A, "01020304000000c0"),  # NodeStatus
        ("dronecan", 0x183FF22A, "0000803f415200c0"),  # a key without an axis
        ("dronecan", 0x0, ""),
        ("cyphal", 0x147D552A, "01020304000000e0"),  # Heartbeat
        ("cyphal", 0x146E742A, "01020304000000e0"),  # too short
        ("cyphal", 0x146E732A, "00" * 63 + "e0"),  # another subject
        ("cyphal", 0x0, ""),
    ],
)
def test_a_message_of_another_type_is_no_result(dialect, identifier, data):
    receiver = dialects.DialectReceiver(dialect)
    assert received(receiver, [(identifier, bytes.fromhex(data))]) == []


def test_cyphal_takes_the_subject_of_the_source():
    frames = packets("cyphal", consecutive(8), channel=4, subject=5000)
    assert len(received(dialects.receiver("cyphal:can0@5000"), frames)) == COUNT
    assert received(dialects.receiver("cyphal:can0"), frames) == []


def any_message(dialect, data, number, sender):
    """An intact message with any content, as somebody else may send it."""
    if dialect == "dronecan":
        key = dialects.KEYS[number % 6].encode() + b"X"
        return 0x183FF22A, data[:4] + (data[4:7] if 0 < data[7] < 25 else key) + b"\xc0"
    if dialect == "cyphal":
        last = bytes([data[60] % 12, data[61], data[62], 0xE0 + number % 32])
        return 0x146E742A, data[:60] + last
    floats = np.frombuffer(data[:60] * 4, "f4")[:58].tolist()
    if number % 2:
        floats[13:16], floats[19] = [float(one) for one in data[:3]], float(data[3])
    message = common.MAVLink_debug_float_array_message(0, b"davar", data[0] % 12, floats)
    return 0, message.pack(sender)


@every_dialect
def test_no_message_breaks_the_receiver(dialect):
    source, sender = np.random.default_rng(11), common.MAVLink(None)
    receiver, shown = dialects.DialectReceiver(dialect), 0
    for number in range(2000):
        data = source.integers(0, 256, 63, dtype="u1").tobytes() if number % 3 else bytes(63)
        result = receiver.push(*any_message(dialect, data, number, sender))
        if result:
            json.dumps(record.row(result, result.sender), allow_nan=False)
            assert result.channel < 10
            shown += 1
    assert shown > 100, receiver.faults


# --- the command


def rows_of(path):
    """The results that are recorded so far."""
    if not path.exists():
        return []
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


@contextlib.contextmanager
def line_of(kind):
    """(source, a function that sends to it)."""
    if kind == "udp":
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            address = free.getsockname()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            client.connect(address)
            yield f"mavlink:udp:127.0.0.1:{address[1]}", client.send
    else:
        ours, theirs = pty.openpty()
        tty.setraw(theirs)
        yield f"mavlink:serial:{os.ttyname(theirs)}", lambda data: os.write(ours, data)
        os.close(ours)
        os.close(theirs)


@pytest.mark.parametrize("kind", ["udp", "serial"])
def test_mavlink_by_udp_and_on_a_serial_line(tmp_path, kind):
    made, path, until = consecutive(8), tmp_path / "arw.csv", time.monotonic() + HANG_S
    frames = packets("mavlink", made, channel=1, floor=1)
    with contextlib.ExitStack() as stack:
        source, send = stack.enter_context(line_of(kind))
        command = [sys.executable, "-B", "-m", "davarlab", "live", source, "--record", str(path)]
        pipes = dict.fromkeys(("stdout", "stderr"), subprocess.PIPE)
        live = subprocess.Popen(command, text=True, **pipes)
        stack.callback(live.communicate)
        stack.callback(live.kill)
        # the first until it listens: repetitions are dropped
        first, rest = itertools.cycle(frames[:4]), iter(frames[4:])
        while len(rows := rows_of(path)) < COUNT:
            assert live.poll() is None
            assert time.monotonic() < until
            _, data = next(rest, (0, None)) if rows else next(first)
            with contextlib.suppress(ConnectionRefusedError):
                send(data) if data else None
            time.sleep(0.002)
        live.send_signal(signal.SIGINT)
        shown, told = live.communicate(timeout=HANG_S)
    assert live.returncode == 0, told
    rows = rows_of(path)
    assert (len(rows), len(shown.splitlines())) == (COUNT, COUNT), told
    texts = ["" if np.isnan(one) else f"{one:.9g}" for one in sent(made["coefficient"][:, ARW, 0])]
    assert [row["arw_deg_per_sqrt_h"] for row in rows] == texts
    assert [row["epoch"] for row in rows] == [str(one) for one in made["epoch"]]
    floors = [f"{one:.9g}" if np.isfinite(one) else "" for one in sent(made["floor"][:, 2], True)]
    assert [row["floor_high_deg_per_sqrt_h"] for row in rows] == floors
    assert [row["floor_why"] for row in rows] == [str(one) for one in made["floor_why"]]
