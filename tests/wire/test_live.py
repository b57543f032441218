"""davarlab live on a serial line; the test is the other end. Senders restart, and runs follow each
other. tests/kernel/test_live.py tests interfaces and lines that disappear and return.
"""

import csv
import json
import os
import pty
import re
import subprocess
import sys
import tempfile
import threading
import tty
import unittest
from pathlib import Path

from davarlab.wire import frames as wire
from davarlab.wire import live, record, withheld
from senders import ROOT, frames, run

# The command of tools/davarlab live, without the other commands and their requirements.
LIVE = (
    "import sys, json, argparse\nfrom davarlab.wire import live\n"
    "sys.exit(live.run(argparse.Namespace(**json.loads(sys.argv[1]))))"
)


MARK = 9


def text(frame):
    return b"t%03X%d%s\r" % (frame[0], len(frame[1]), frame[1].hex().upper().encode())


def without_arw(result, reason):
    """The frames of a result, its ARW absent for a reason of davar_noise_t; 0: none is sent."""
    arw, end = (next((id_, data) for id_, data in result if id_ & 15 == kind) for kind in (0, 11))
    body = arw[1][1:2] + (65535 - reason).to_bytes(2, "little") + bytes.fromhex("0000C07F")
    new = bytes([wire.crc(arw[0], b"\0" + body)]) + body
    total = int.from_bytes(end[1][4:], "little") - wire.digest(*arw) + wire.digest(arw[0], new)
    body = end[1][1:4] + (total % 2**32).to_bytes(4, "little")
    last = bytes([wire.crc(end[0], b"\0" + body)]) + body
    changed = {arw: (arw[0], new), end: (end[0], last)}
    return [changed.get(frame, frame) for frame in result]


class Live(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.record = self.folder / "arw.csv"

    def live(self, sent, **options):
        """Sends frames to davarlab live, then disconnects. Returns (its lines, its messages).
        Frames of channel MARK come last: if one of their results is shown, everything before them
        has been read.
        """
        ours, its = pty.openpty()
        tty.setraw(its)
        wanted = {
            "source": f"slcan:{os.ttyname(its)}",
            "base": wire.BASE,
            "record": str(self.record),
            "raw": None,
            "count": None,
            "idle": None,
            "json": True,
            **options,
        }
        process = subprocess.Popen(
            [sys.executable, "-B", "-c", LIVE, json.dumps(wanted)],
            cwd=ROOT / "tools/lab",
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        told, shown = [], []
        teller = threading.Thread(target=lambda: told.extend(process.stderr))
        writer = threading.Thread(
            target=self.play, args=(ours, [*sent, *frames(run(99, 2, session=1, channel=MARK))])
        )
        teller.start()
        writer.start()
        for line in process.stdout:
            shown.append(line)
            if json.loads(line)["channel"] == MARK and its is not None:
                writer.join()
                os.close(its)
                os.close(ours)
                its = None
        teller.join()
        self.assertEqual(0, process.wait(), told)
        process.stdout.close()
        process.stderr.close()
        self.all_shown = len(shown)
        return [line for line in shown if json.loads(line)["channel"] != MARK], "".join(told)

    @staticmethod
    def play(ours, sent):
        heard = b""
        while b"O\r" not in heard:
            heard += os.read(ours, 100)
        data = memoryview(b"".join(map(text, sent)))
        while data:
            data = data[os.write(ours, data[:1000]) :]

    def rows(self, path=None):
        with open(path or self.record, encoding="utf-8") as file:
            return [row for row in csv.DictReader(file) if row["channel"] != str(MARK)]

    def keys(self, path=None):
        return [(row["channel"], row["stretch"], row["epoch"]) for row in self.rows(path)]

    def test_a_restart_is_reported_and_begins_a_new_section(self):
        one, two = run(1, 60, session=7), run(2, 60, session=7)
        shown, told = self.live(frames(one) + frames(two))
        self.assertEqual(
            1,
            told.count(
                "davarlab live: channel 0: the sender has been restarted: a new section "
                "begins with epoch 99\n"
            ),
        )
        self.assertIn(" 0 orphaned,", told)
        self.assertIn(" 1 restarts", told)
        self.assertEqual(
            [("0", str(stretch), str(100 * n + 99)) for stretch in (1, 2) for n in range(60)],
            self.keys(),
        )
        self.assertEqual(
            [(int(row["stretch"]), int(row["epoch"])) for row in self.rows()],
            [(row["stretch"], row["epoch"]) for row in map(json.loads, shown)],
        )
        self.assertNotIn("", [row["time_s"] for row in self.rows()])
        self.assertEqual(["adev_1", "adev_2", "adev_4", "adev_8"], [*self.rows()[0]][-4:])

    def test_a_later_run_continues_after_the_earlier_one(self):
        one = run(1, 20, session=7)
        for _ in range(3):
            self.live(frames(one))
        self.assertEqual(
            [("0", str(stretch), str(100 * n + 99)) for stretch in (1, 2, 3) for n in range(20)],
            self.keys(),
        )
        self.assertEqual(1, self.record.read_text().count("epoch"))

    def test_a_row_broken_by_a_power_cut_is_removed(self):
        one = run(1, 20, session=7)
        self.live(frames(one))
        whole = self.record.read_bytes()
        for cut in (len(whole) - 1, len(whole) - 30):
            self.record.write_bytes(whole[:cut])
            before = len(whole[:cut].splitlines()) - 2  # without the header and the broken row
            self.live(frames(one))
            self.assertEqual(before + self.all_shown, len(self.record.read_text().splitlines()) - 1)
            self.assertEqual(len(self.keys()), len(set(self.keys())))
            self.assertTrue(
                self.record.read_bytes().startswith(whole[: whole.rindex(b"\n", 0, -1) + 1])
            )

    def test_a_file_with_other_columns_stays_unchanged(self):
        for there in (b"time_s,gyro_z_dps\n0,1\n0.1,2", b"\x00" * 100, b"channel,epoch\n"):
            self.record.write_bytes(there)
            shown, told = self.live(frames(run(1, 20, session=7)))
            self.assertEqual((20, there), (len(shown), self.record.read_bytes()))
            self.assertIn("arw.csv: exists with other columns. Recording to ", told)
        self.assertEqual(60, len(set(self.keys(self.folder / "arw-2.csv"))))

    def test_a_device_that_is_always_full(self):
        shown, told = self.live(frames(run(1, 20, session=7)), record="/dev/full")
        self.assertEqual(20, len(shown))
        self.assertIn(
            "/dev/full: No space left on device: results are shown, but not recorded\n", told
        )
        self.assertIn(f"/dev/full: {self.all_shown} results not recorded\n", told)

    def test_why_arw_is_absent_is_shown_recorded_and_explained_once(self):
        one = run(1, 60, session=7)
        for code, reason in enumerate(("", "", "mixed", "constant", "coarse", "filtered")):
            sent = [frame for result in one.results[:-1] for frame in without_arw(result, code)]
            with self.subTest(reason=reason):
                self.record.unlink(missing_ok=True)
                shown, told = self.live(sent)
                self.assertEqual(60, len(shown))
                self.assertEqual({reason}, {row["arw_withheld"] for row in self.rows()})
                self.assertEqual({""}, {row["arw_relative_uncertainty"] for row in self.rows()})
                self.assertEqual(
                    {reason or None}, {json.loads(line).get("arw_withheld") for line in shown}
                )
                said = f"channel 0: no angle random walk ({reason}): "
                self.assertEqual(1 if reason else 0, told.count(said), told)

    def test_what_chance_withholds_is_shown_but_not_explained(self):
        one = run(1, 60, session=7)
        sent = [
            frame
            for n, result in enumerate(one.results[:-1])
            for frame in without_arw(result, 2 if n in (25, 59) else 0)
        ]
        shown, told = self.live(sent)
        reasons = [json.loads(line).get("arw_withheld") for line in shown]
        self.assertEqual([25, 59], [n for n, reason in enumerate(reasons) if reason == "mixed"])
        self.assertNotIn("channel 0: no angle random walk", told)

    def test_a_rate_of_zero_is_rejected_and_counted(self):
        one = run(1, 20, session=7)
        setup = bytes([0, 0, 0, 7, 0, 0, 0, 0])
        zero = (0x5D6, bytes([wire.crc(0x5D6, setup)]) + setup[1:])
        shown, told = self.live(frames(one)[:100] + [zero] + frames(one)[100:])
        self.assertEqual(20, len(shown))
        self.assertIn(" 1 impossible,", told)


class Words(unittest.TestCase):
    def test_a_line_names_the_reason(self):
        values = {"channel": 0, "epoch": 9, "arw_deg_per_sqrt_h": None, "window_samples": 600}
        self.assertIn("ARW       absent deg", live.line(values))
        for reason in withheld.REASONS:
            said = live.line(values | {"arw_withheld": reason})
            self.assertIn(f"ARW       absent ({reason}) deg", said)

    def test_a_line_has_the_slow_terms_that_are_resolved(self):
        values = {"channel": 0, "epoch": 7, "arw_deg_per_sqrt_h": 0.3, "window_samples": 600}
        plain = live.line(values | {"bi_deg_per_h": None})
        self.assertTrue(plain.endswith("window 600"), plain)
        said = live.line(values | {"bi_deg_per_h": 5.125, "rrw_deg_per_h_per_sqrt_h": 12.0})
        self.assertEqual(said, plain + "  BI 5.125 deg/h  RRW 12 deg/h/sqrt(h)")

    def test_davar_sim_uses_the_same_words(self):
        source = (ROOT / "host_sim/output/report.c").read_text()
        source = re.sub(r'"\s*"', "", source)
        for reason, words in (
            ("filtered", "the short cluster sizes read low, as after a low-pass"),
            ("coarse", "the noise is below half a count, so rounding hides the angle random walk"),
        ):
            self.assertIn(words, source)
            self.assertTrue(withheld.REASONS[reason].startswith(words))
        self.assertIn(f"#define FEW {withheld.FEW}U", source)


class Waiting(unittest.TestCase):
    def test_rows_of_a_new_section_wait_for_their_names_and_delay_no_others(self):
        with tempfile.TemporaryDirectory() as folder:
            recorder = record.Recorder(Path(folder) / "x.csv")
            known, unknown = wire.Channel(), wire.Channel(2)
            known.setup["rate_hz"], known.clusters = 100.0, {0: 1}
            recorder.add(wire.Result(0, 0, 99, {}, {0: 1.0}), known)
            for n in range(500):
                recorder.add(wire.Result(1, 0, n, {}, {0: 1.0}, stretch=2), unknown)
                recorder.add(wire.Result(0, 0, 100 + n, {}, {0: 1.0}), known)
                self.assertLess(len(recorder.waiting), record.WAITING_MAX)
            recorder.close()
            with open(Path(folder) / "x.csv", encoding="utf-8") as file:
                self.assertEqual(1001, len(list(csv.DictReader(file))))


if __name__ == "__main__":
    unittest.main()
