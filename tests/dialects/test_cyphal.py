"""Cyphal: the tracer of pycyphal receives every frame, and the class that nunavut generates from
tools/dialects/davar decodes it.
"""

import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import pycyphal.dsdl
from pycyphal.transport import MessageDataSpecifier, Timestamp, TransferTrace
from pycyphal.transport.can import CANCapture, CANTransport
from pycyphal.transport.can.media import DataFrame, FrameFormat
from random_results import MESSAGES, batches, mismatches, packets, quantities

DSDL = Path(__file__).resolve().parents[2] / "tools/dialects/davar"
TERMS = ("angle_random_walk", "bias_instability", "rate_random_walk")
NAMES = [term + limit for term in TERMS for limit in ("", "_low", "_high")]
NAMES += ["rate_ramp", "quantization", "kurtosis", "rate_hz"]


def generated():
    """davar.Noise_1_0, as pycyphal compiles it."""
    folder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(folder.cleanup)
    pycyphal.dsdl.compile(DSDL, output_directory=folder.name)
    sys.path.insert(0, folder.name)
    unittest.addModuleCleanup(sys.path.remove, folder.name)
    import davar

    return davar.Noise_1_0


def setUpModule():
    global NOISE
    NOISE = generated()


class Cyphal(unittest.TestCase):
    def transfers(self, frames):
        """[(transfer, session)] of frames, received one at a time."""
        tracer = CANTransport.make_tracer()
        for identifier, data in frames:
            frame = DataFrame(FrameFormat.EXTENDED, identifier, bytearray(data))
            trace = tracer.update(CANCapture(Timestamp.now(), frame, own=False))
            self.assertIsInstance(trace, TransferTrace)
            yield trace.transfer

    def check(self, made, channel, node, subject):
        count = len(made)
        frames = packets("cyphal", made, channel=channel, node=node, subject=subject)
        self.assertEqual(count, len(frames))
        rows, numbers, froms = np.empty((count, 13)), [], set()
        others = np.empty((count, 7), "u8")
        for row, transfer in enumerate(self.transfers(frames)):
            one = pycyphal.dsdl.deserialize(NOISE, transfer.fragmented_payload)
            rows[row] = [getattr(one, name) for name in NAMES]
            others[row] = (
                one.epoch,
                one.window_samples,
                one.channel,
                one.noise,
                one.unstable,
                one.young,
                one.alarm,
            )
            numbers.append(transfer.metadata.transfer_id)
            session = transfer.metadata.session_specifier
            froms.add((session.source_node_id, session.data_specifier))
        self.assertEqual({(node, MessageDataSpecifier(subject))}, froms)
        self.assertTrue((np.array(numbers) == np.arange(count) % 32).all())
        self.assertEqual(0, mismatches(quantities(made), rows))
        names = ("epoch", "window_samples", "channel", "noise", "unstable", "young", "alarm")
        wanted = {name: made[name] for name in names if name != "channel"}
        wanted |= {"epoch": made["epoch"].astype("u4"), "channel": np.full(count, channel)}
        for column, name in enumerate(names):
            self.assertTrue((others[:, column] == wanted[name]).all(), name)

    def test_every_message_is_read(self):
        for made, channel in batches(MESSAGES):
            self.check(made, channel, 1 + 14 * channel, 910 * channel)


if __name__ == "__main__":
    unittest.main()
