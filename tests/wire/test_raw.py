"""Raw samples on the wire: the recording has the samples that a sender read, whatever is lost,
swapped, repeated or restarted between them.
"""

import csv

import pytest
from davar.wire import frames as wire
from davar.wire import raw_record
from senders import (
    NODE,
    SIM,
    counts,
    disturbed,
    held_by,
    on_a_line,
    sealed,
    seeded,
    stream,
)

UNIT, RATE_HZ = 0.05, 100.0  # of wire_probe


def received(sent):
    """({(channel, section): {index: deg/s}}, the faults) of a receiver."""
    receiver, found = wire.Receiver(), {}
    for identifier, data in sent:
        receiver.push(identifier, data)
    receiver.finish()
    for number, channel, samples in receiver.samples:
        at = found.setdefault((number, channel.stretch), {})
        assert not set(at) & {index for index, _ in samples}
        at.update(samples)
    return found, receiver.faults


def assert_samples(wanted, found):
    assert [index for index, _ in wanted] == list(found)
    assert list(found.values()) == pytest.approx([UNIT * count for _, count in wanted], rel=1e-9)


def losses(source):
    """Losses of the sensor that exceed the index range together."""
    samples, index = [], 0
    for n in range(20000):
        index += 1 + (9000 if n % 400 == 399 else 0)
        samples.append((index, source.randrange(-30000, 30000)))
    assert index > 1 << 18
    return samples


@pytest.mark.parametrize(
    ("seed", "width", "gaps", "first"),
    [
        (1, 16, 0, 0),
        (2, 16, 0.05, 0),
        (3, 24, 0.02, 0),
        (4, 32, 0, 0),
        (5, 16, 0.01, 261000),
        (6, 17, 0.3, 999900),
        ("losses", 16, 0, 0),
    ],
)
def test_every_sample_arrives_with_its_index(seed, width, gaps, first):
    source = seeded("raw", seed)
    samples = losses(source) if seed == "losses" else counts(source, 3000, first, width, gaps)
    found, faults = received(stream(samples, first=first))
    assert_samples(samples, found[0, 1])
    assert faults.total() == 0, faults


@pytest.mark.slow
def test_a_silence_longer_than_the_index_range():
    samples = counts(seeded("silence"), 300000, gaps=0)
    sent = stream(samples, stride=5000)
    eighth = len(sent) // 8
    found, _ = received(sent[: eighth + 1] + sent[7 * eighth :])
    truth = dict(samples)
    assert max(found[0, 1]) > 290000
    assert all(abs(UNIT * truth[index] - value) < 1e-6 for index, value in found[0, 1].items())


@pytest.mark.slow
def test_who_joins_late_gets_the_samples_from_the_setup_on():
    samples = counts(seeded("late"), 400000, gaps=0)
    sent = stream(samples, stride=2000)
    found, _ = received(sent[len(sent) * 3 // 4 :])
    begin = min(found[0, 1])
    assert begin < 330000
    assert_samples(samples[begin:], found[0, 1])


def test_an_index_that_is_damaged_costs_its_own_samples():
    samples = counts(seeded("damaged"), 3000, gaps=0)
    sent, truth = stream(samples), dict(samples)
    for place in range(40, len(sent), 397):
        identifier, data = sent[place]
        if identifier == 0x5D9:
            payload = bytes([data[2], data[3] ^ 0x5A]) + data[4:]
            other = sealed(identifier, payload, data[1])
            found, _ = received([*sent[:place], other, *sent[place + 1 :]])
            wrong = [
                index
                for index, value in found[0, 1].items()
                if abs(truth.get(index, 1e9) * UNIT - value) > 1e-6
            ]
            assert len(wrong) <= 2
            assert len(found[0, 1]) >= len(samples) - 4


def test_rates_arrive_as_float32_without_bad_numbers():
    values = [0.1, -2.5, float("nan"), float("inf"), 1e-40, 1e35, -0.0, 3.0]
    found, faults = received(stream([(n, values[n % 8]) for n in range(400)], what="rates"))
    assert faults.total() == 0, faults
    wanted = {n: values[n % 8] for n in range(400) if n % 8 not in (2, 3, 5)}
    assert found[0, 1] == pytest.approx(wanted, rel=1e-7, abs=1e-30)


@pytest.mark.parametrize(
    "seed", [*range(3), *(pytest.param(n, marks=pytest.mark.slow) for n in range(3, 30))]
)
def test_a_bad_line_loses_samples_and_changes_none(seed):
    source = seeded("bad line", seed)
    samples = counts(source, 4000, source.choice((0, 0, 260000)), 16, 0.005)
    came = disturbed(stream(samples, first=samples[0][0]), source, 0.02)
    found, _ = received(came)
    truth = dict(samples)
    together = [pair for _, part in sorted(found.items()) for pair in part.items()]
    assert all(abs(UNIT * truth[index] - value) < 1e-6 for index, value in together)
    assert len({index for index, _ in together}) == len(together)
    there = sum(map(held_by, {frame for frame in came if frame[0] == 0x5D9}))
    assert len(together) > 0.9 * there


def test_a_restart_begins_another_recording_with_its_first_samples():
    source = seeded("restart")
    before, after = counts(source, 2500, gaps=0), counts(source, 2500, gaps=0.01)
    cut = stream(before)
    for end in (len(cut) - 40, len(cut) - 100, 700):
        found, faults = received(cut[:end] + stream(after, session=8))
        assert faults.restarts == 1
        assert_samples(after, found[0, 2])
        assert_samples(before[: len(found[0, 1])], found[0, 1])


def test_channels_and_restarts_have_recordings_of_their_own(tmp_path):
    said, source, receiver = [], seeded("files"), wire.Receiver()
    recorder = raw_record.RawRecorder(tmp_path / "raw.csv", said.append)
    parts = {
        (0, 1): counts(source, 900, gaps=0.01),
        (1, 1): counts(source, 500),
        (0, 2): counts(source, 700),
    }
    for (channel, stretch), samples in parts.items():
        for frame in stream(samples, session=stretch, channel=channel):
            receiver.push(*frame)
    for samples in receiver.samples:
        recorder.add(*samples)
    recorder.close()
    assert len(said) == 2, said
    names = ("raw.csv", "raw-2.csv", "raw-3.csv")
    for ((channel, _), samples), name in zip(parts.items(), names, strict=True):
        notes, *lines = (tmp_path / name).read_text().split("\n", 2)
        assert [notes, lines[0]] == [f"# channel: {channel}", "# unit_per_count_dps: 0.05"]
        rows = list(csv.DictReader(lines[1].splitlines()))
        column = "gyro_" + "xy"[channel] + "_dps"
        assert [(row["time_s"], row[column]) for row in rows] == [
            (f"{index / RATE_HZ:.12g}", f"{UNIT * count:.9g}") for index, count in samples
        ]


# --- the programs

WINDOW = ("--window-max", 200, "--window-min", 100, "--segment", 30, "--stride", 50)


@pytest.fixture(scope="module")
def lines():
    source = seeded("programs")
    return [
        str(source.randrange(-33000, 33000)) if source.random() > 0.01 else "nan"
        for _ in range(500)  # the capacity of the gateway's queue
    ]


def test_the_gateway_sends_its_input(lines):
    words = ("--source", "-", "--rate", 100, "--lsb", UNIT, *WINDOW, "--raw")
    found, faults = received(on_a_line(NODE, *words, text="\n".join(lines) + "\n")[0])
    assert_samples([(n, int(line)) for n, line in enumerate(lines) if line != "nan"], found[0, 1])
    assert faults.total() == 0, faults


@pytest.mark.parametrize("words", [("--lsb", UNIT), ("--arith", "float")])
def test_the_simulator_sends_its_input(lines, words):
    """A sample that is lost has an index too."""
    wanted = [(n, int(line)) for n, line in enumerate(lines) if line != "nan"]
    rows = "".join(f"{n / 100:.2f},{count * UNIT!r},{-count * UNIT!r}\n" for n, count in wanted)
    columns = ("--column", "gyro_x_dps,gyro_y_dps", "--window-max", 200, "--stride", 50, "--raw")
    text = "time_s,gyro_x_dps,gyro_y_dps\n" + rows
    found, faults = received(on_a_line(SIM, "-", *columns, *words, text=text)[0])
    for channel, sign in ((0, 1), (1, -1)):
        truth = {index: sign * UNIT * count for index, count in wanted}
        assert found[channel, 1] == pytest.approx(truth, rel=1e-7, abs=1e-9)
        assert list(found[channel, 1]) == list(truth)
    assert faults.total() == 0, faults
