"""Raw samples on the wire: the recording has the samples that a sender read, whatever is lost,
swapped, repeated or restarted between them.
"""

import csv
import os
import re
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

from davarlab import errors
from davarlab.wire import frames as wire
from davarlab.wire import raw_record, source
from senders import PROBE, ROOT, disturbed, run, seeded

NODE, SIM = os.environ.get("DAVAR_NODE", "davar-node"), os.environ.get("DAVAR_SIM", "davar-sim")
UNIT, RATE_HZ, SEND_RAW = 0.05, 100.0, 32  # of wire_probe


def encoded(samples, channel=0, what="raw"):
    """The library's frames of samples (index, value)."""
    done = subprocess.run(
        [PROBE, what, str(channel)],
        input="".join(f"{index} {value!r}\n" for index, value in samples),
        text=True,
        stdout=subprocess.PIPE,
        check=True,
    )
    return [
        (int(word[1], 16), bytes.fromhex(word[2]))
        for word in map(str.split, done.stdout.splitlines())
    ]


def counts(source, number, first=0, width=16, gaps=0.02):
    """Samples (index, count) of a sensor that loses some."""
    found, index = [], first
    for _ in range(number):
        index += source.choice((1, 3, 700)) if source.random() < gaps else 0
        found.append((index, source.randrange(-1 << width - 1, 1 << width - 1)))
        index += 1
    return found


def stream(samples, session=7, stride=100, channel=0, what="raw", first=0):
    """Frames in the order of a sender: a result follows its newest sample. Epochs count the
    received samples from `first`; sample indices also count the lost ones.
    """
    raw, sent, gone = encoded(samples, channel, what), [], 0
    number = len(samples) // stride + 1
    for n, burst in enumerate(
        run(5, number, session, stride, content=3 | SEND_RAW, first=first, channel=channel).results
    ):
        while raw and gone < min(stride * (n + 1), len(samples) - 1) or raw and n == number:
            gone += held_by(raw[0])
            sent.append(raw.pop(0))
        sent += burst
    return sent


def held_by(frame):
    """The number of samples in a frame."""
    return 2 if frame[1][1] >> 4 & 3 == 0 else 1


def received(sent):
    """(samples from a receiver, {(channel, section): {index: deg/s}}, its faults)."""
    receiver, found = wire.Receiver(), {}
    for identifier, data in sent:
        receiver.push(identifier, data)
    receiver.finish()
    for number, channel, samples in receiver.samples:
        at = found.setdefault((number, channel.stretch), {})
        assert not set(at) & {index for index, _ in samples}
        at.update(samples)
    return found, receiver.faults


def programs_samples(command, text):
    """The output of a program on its own pty, with text on standard input: as received()."""
    sender = subprocess.Popen(
        [*command, "--raw", "--out", "slcan:pty"],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    feeder = threading.Thread(target=lambda: (sender.stdin.write(text), sender.stdin.close()))
    feeder.start()
    said = sender.stderr.readline()
    while "slcan on" not in said:
        said = sender.stderr.readline()
    faults = wire.Faults()
    port = source.Source("slcan:" + re.search(r"/dev/pts/\d+", said)[0], faults, lambda text: None)
    teller = threading.Thread(target=sender.stderr.read)
    teller.start()
    found = received(port.frames())
    for one in (feeder, teller):
        one.join()
    assert sender.wait() == 0
    sender.stderr.close()
    return found


class Raw(unittest.TestCase):
    def assert_samples(self, wanted, found):
        self.assertEqual([index for index, _ in wanted], list(found))
        for index, count in wanted:
            self.assertAlmostEqual(UNIT * count, found[index], delta=1e-9 * abs(count) + 1e-12)

    def test_every_sample_arrives_with_its_index(self):
        for seed, width, gaps, first in (
            (1, 16, 0, 0),
            (2, 16, 0.05, 0),
            (3, 24, 0.02, 0),
            (4, 32, 0, 0),
            (5, 16, 0.01, 261000),
            (6, 17, 0.3, 999900),
        ):
            samples = counts(seeded("raw", seed), 3000, first, width, gaps)
            found, faults = received(stream(samples, first=first))
            self.assert_samples(samples, found[0, 1])
            self.assertEqual(faults.total(), 0, faults)

    def test_losses_of_the_sensor_that_exceed_the_index_range(self):
        source, samples, index = seeded("losses"), [], 0
        for n in range(20000):
            index += 1 + (9000 if n % 400 == 399 else 0)
            samples.append((index, source.randrange(-30000, 30000)))
        self.assertGreater(index, 1 << 18)
        found, faults = received(stream(samples))
        self.assert_samples(samples, found[0, 1])
        self.assertEqual(faults.total(), 0, faults)

    def test_a_silence_longer_than_the_index_range(self):
        samples = counts(seeded("silence"), 300000, gaps=0)
        sent = stream(samples, stride=5000)
        found, faults = received(
            [frame for n, frame in enumerate(sent) if not len(sent) // 8 < n < 7 * len(sent) // 8]
        )
        truth = dict(samples)
        self.assertGreater(max(found[0, 1]), 290000)
        for index, value in found[0, 1].items():
            self.assertAlmostEqual(UNIT * truth[index], value, delta=1e-6)

    def test_an_index_that_is_damaged_costs_its_own_samples(self):
        samples = counts(seeded("damaged"), 3000, gaps=0)
        sent = stream(samples)
        for place in range(40, len(sent), 397):
            frame = bytearray(sent[place][1])
            if sent[place][0] != 0x5D9:
                continue
            frame[3] ^= 0x5A
            frame[0] = wire.crc(sent[place][0], bytes(frame))
            found, faults = received(
                [*sent[:place], (sent[place][0], bytes(frame)), *sent[place + 1 :]]
            )
            truth = dict(samples)
            wrong = [
                index
                for index, value in found[0, 1].items()
                if abs(truth.get(index, 1e9) * UNIT - value) > 1e-6
            ]
            self.assertLessEqual(len(wrong), 2, (place, wrong))
            self.assertGreaterEqual(len(found[0, 1]), len(samples) - 4, (place, faults))

    def test_a_pair_shares_a_frame_and_a_wide_count_has_its_own(self):
        self.assertEqual(500, len(encoded([(n, n - 500) for n in range(1000)])))
        self.assertEqual(1000, len(encoded([(n, 40000 + n) for n in range(1000)])))
        self.assertEqual(1000, len(encoded([(2 * n, 1) for n in range(1000)])))
        self.assertEqual(2, len(encoded([(n, n) for n in range(3)])))

    def test_rates_arrive_as_float32_without_bad_numbers(self):
        values = [0.1, -2.5, float("nan"), float("inf"), 1e-40, 1e35, -0.0, 3.0]
        found, faults = received(stream([(n, values[n % 8]) for n in range(400)], what="rates"))
        self.assertEqual(faults.total(), 0, faults)
        self.assertEqual([n for n in range(400) if n % 8 not in (2, 3, 5)], list(found[0, 1]))
        for index, value in found[0, 1].items():
            self.assertAlmostEqual(value, values[index % 8] if index % 8 != 4 else 0.0, delta=1e-7)

    def test_a_bad_line_loses_samples_and_changes_none(self):
        for seed in range(30):
            source = seeded("bad line", seed)
            samples = counts(source, 4000, source.choice((0, 0, 260000)), 16, 0.005)
            one = type("One", (), {"results": [stream(samples, first=samples[0][0])]})
            came = disturbed(one, source, 0.02)
            found, faults = received(came)
            truth = dict(samples)
            together = [
                (index, value) for _, part in sorted(found.items()) for index, value in part.items()
            ]
            for index, value in together:
                self.assertAlmostEqual(UNIT * truth[index], value, delta=1e-6, msg=(seed, index))
            self.assertEqual(len({index for index, _ in together}), len(together))
            there = sum(map(held_by, {frame for frame in came if frame[0] == 0x5D9}))
            self.assertGreater(len(together), 0.9 * there, (seed, faults))

    def test_a_restart_begins_another_recording_with_its_first_samples(self):
        source = seeded("restart")
        before, after = counts(source, 2500, gaps=0), counts(source, 2500, gaps=0.01)
        cut = stream(before)
        for end in (len(cut) - 40, len(cut) - 100, 700):
            found, faults = received(cut[:end] + stream(after, session=8))
            self.assertEqual(faults.restarts, 1)
            self.assert_samples(after, found[0, 2])
            self.assertEqual(list(found[0, 1]), [index for index, _ in before][: len(found[0, 1])])
            self.assertGreaterEqual(faults.doubtful_samples + len(found[0, 1]), 0)

    def test_who_joins_late_gets_the_samples_from_the_setup_on(self):
        samples = counts(seeded("late"), 400000, gaps=0)
        sent = stream(samples, stride=2000)
        found, _ = received(sent[len(sent) * 3 // 4 :])
        self.assertEqual(list(found[0, 1]), list(range(min(found[0, 1]), 400000)))
        self.assertLess(min(found[0, 1]), 330000)
        self.assert_samples(samples[min(found[0, 1]) :], found[0, 1])

    def test_channels_and_restarts_have_recordings_of_their_own(self):
        with tempfile.TemporaryDirectory() as folder:
            path, said = Path(folder) / "raw.csv", []
            recorder = raw_record.RawRecorder(path, said.append)
            source = seeded("files")
            parts = {
                (0, 1): counts(source, 900, gaps=0.01),
                (1, 1): counts(source, 500),
                (0, 2): counts(source, 700),
            }
            receiver = wire.Receiver()
            for (channel, stretch), samples in parts.items():
                for frame in stream(samples, session=stretch, channel=channel):
                    receiver.push(*frame)
            for samples in receiver.samples:
                recorder.add(*samples)
            recorder.close()
            self.assertEqual(2, len(said), said)
            for (channel, stretch), name in zip(parts, ("raw.csv", "raw-2.csv", "raw-3.csv")):
                with open(Path(folder) / name, encoding="ascii") as file:
                    self.assertEqual(
                        [f"# channel: {channel}\n", "# unit_per_count_dps: 0.05\n"],
                        [file.readline(), file.readline()],
                    )
                    rows = list(csv.DictReader(file))
                wanted = [
                    (f"{index / RATE_HZ:.12g}", f"{UNIT * count:.9g}")
                    for index, count in parts[channel, stretch]
                ]
                self.assertEqual(
                    wanted, [(row["time_s"], row["gyro_" + "xy"[channel] + "_dps"]) for row in rows]
                )

    def test_the_gateway_and_the_simulator_send_their_input(self):
        source = seeded("programs")
        lines = [
            str(source.randrange(-33000, 33000)) if source.random() > 0.01 else "nan"
            for _ in range(500)
        ]  # the capacity of the gateway's queue
        wanted = [(n, int(line)) for n, line in enumerate(lines) if line != "nan"]
        found, faults = programs_samples(
            [
                NODE,
                "--source",
                "-",
                "--rate",
                "100",
                "--lsb",
                str(UNIT),
                "--window-max",
                "200",
                "--window-min",
                "100",
                "--segment",
                "30",
                "--stride",
                "50",
            ],
            "\n".join(lines) + "\n",
        )
        self.assert_samples(wanted, found[0, 1])
        self.assertEqual(faults.total(), 0, faults)
        rows = "".join(f"{n / 100:.2f},{count * UNIT!r},{-count * UNIT!r}\n" for n, count in wanted)
        for arith in ((), ("--arith", "float")):
            command = [
                SIM,
                "-",
                "--column",
                "gyro_x_dps,gyro_y_dps",
                *(() if arith else ("--lsb", str(UNIT))),
                *arith,
                "--window-max",
                "200",
                "--stride",
                "50",
                "--progress",
                "never",
            ]
            found, faults = programs_samples(command, "time_s,gyro_x_dps,gyro_y_dps\n" + rows)
            for channel, sign in ((0, 1), (1, -1)):
                self.assertEqual([index for index, _ in wanted], list(found[channel, 1]))
                for index, count in wanted:
                    self.assertAlmostEqual(
                        found[channel, 1][index], sign * UNIT * count, delta=1e-4 if arith else 1e-9
                    )
            self.assertEqual(faults.total(), 0, faults)

    def test_raw_without_a_link_is_rejected(self):
        done = subprocess.run(
            [SIM, ROOT / "data/demo_disturbance.csv.gz", "--raw"], capture_output=True, text=True
        )
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("--raw: needs --out can:IFACE or slcan:PATH", done.stderr)

    def test_a_missing_folder_is_rejected(self):
        with self.assertRaisesRegex(
            errors.BadInput, "--raw: /nonexistent/raw.csv: No such file or directory"
        ):
            raw_record.RawRecorder("/nonexistent/raw.csv", print)


if __name__ == "__main__":
    unittest.main()
