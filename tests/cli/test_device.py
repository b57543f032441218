"""davar-sim --device COMMAND: faults of a device (tools/davar-mcu tests correct devices)."""

import struct
import unittest

from sim_case import SimCase

RESULT_HEAD, RESULT_REST = 22, 6 + 20
HEALTH = 2**64 - 1


def words(*values):
    return struct.pack(f"<{len(values)}Q", *values)


def head(*values):
    return words(*values, *[0] * (RESULT_HEAD - len(values)))


def result(channel=0, taus=1):
    return head(channel, 300, 600, 0, 0, 0, 0, 0, taus) + words(*[0] * RESULT_REST)


class Device(SimCase):
    def device(self, results, *options):
        """Runs davar-sim with a device that writes `results` (bytes; None: nothing)."""
        recording = self.recording(1000)
        answer = self.folder / "answer"
        command = "true"
        if results is not None:
            answer.write_bytes(results)
            command = f"sh -c 'cp {answer} $2' device"
        return self.sim(recording, "--lsb", "0.01", "--taus", "1", *options, "--device", command)

    def test_incomplete_results_are_rejected(self):
        for name, results in {
            "empty": b"",
            "cut in a head": result()[:40],
            "cut in a result": result()[:-8],
            "no health": result(),
            "foreign channel": result(channel=10**9),
            "foreign taus": result(taus=33),
            "more taus": result(taus=2) + words(*[0] * 6) + head(HEALTH),
            "no taus": result(taus=0) + head(HEALTH),
            "cut health": result() + words(HEALTH, 0),
        }.items():
            for options in ((), ("--out", "jsonl")):
                with self.subTest(name, options=options):
                    done = self.device(results, *options)
                    self.assertEqual(2, done.returncode, done.stderr)
                    self.assertRegex(
                        done.stderr,
                        r"^davar-sim: \S+results: the device's results are incomplete\n$",
                    )

    def test_a_device_without_output_is_reported(self):
        done = self.device(None)
        self.assertEqual((2, ""), (done.returncode, done.stdout))
        self.assertIn("the device wrote no results", done.stderr)

    def test_the_counters_are_the_device_s(self):
        done = self.device(result() + head(HEALTH, 0, 3, 17, 5))
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn("17", done.stderr)

    def test_pace_is_rejected(self):
        done = self.device(None, "--pace", "100")
        self.assertEqual(
            (
                2,
                "",
                "davar-sim: --pace: cannot be used with --device, because a device "
                "has its own clock\n",
            ),
            (done.returncode, done.stdout, done.stderr),
        )


if __name__ == "__main__":
    unittest.main()
