"""Cyphal: the tracer of pycyphal receives every frame, and the class that nunavut generates from
tools/dialects/davar decodes it.
"""

import sys
from pathlib import Path

import numpy as np
import pycyphal.dsdl
import pytest
from pycyphal.transport import MessageDataSpecifier, Timestamp, TransferTrace
from pycyphal.transport.can import CANCapture, CANTransport
from pycyphal.transport.can.media import DataFrame, FrameFormat
from random_results import MESSAGES, batches, mismatches, packets, quantities

DSDL = Path(__file__).resolve().parents[2] / "tools/dialects/davar"
TERMS = ("angle_random_walk", "bias_instability", "rate_random_walk")
NAMES = [term + limit for term in TERMS for limit in ("", "_low", "_high")]
NAMES += ["rate_ramp", "quantization", "kurtosis", "rate_hz"]
OTHERS = ("epoch", "window_samples", "channel", "noise", "unstable", "young", "alarm")


@pytest.fixture(scope="module")
def noise_type(tmp_path_factory):
    """davar.Noise_1_0, as pycyphal compiles it. python/davar has the same name."""
    folder = str(tmp_path_factory.mktemp("dsdl"))
    pycyphal.dsdl.compile(DSDL, output_directory=folder)
    kept = {
        name: sys.modules.pop(name) for name in list(sys.modules) if name.split(".")[0] == "davar"
    }
    sys.path.insert(0, folder)
    import davar

    yield davar.Noise_1_0
    sys.path.remove(folder)
    for name in [name for name in sys.modules if name.split(".")[0] == "davar"]:
        del sys.modules[name]
    sys.modules.update(kept)


def transfers(frames):
    """The transfers of frames, received one at a time."""
    tracer = CANTransport.make_tracer()
    for identifier, data in frames:
        frame = DataFrame(FrameFormat.EXTENDED, identifier, bytearray(data))
        trace = tracer.update(CANCapture(Timestamp.now(), frame, own=False))
        assert isinstance(trace, TransferTrace)
        yield trace.transfer


@pytest.mark.parametrize("number", MESSAGES)
def test_every_message_is_read(noise_type, number):
    for made, channel in batches(number):
        count, node, subject = len(made), 1 + 14 * channel, 910 * channel
        frames = packets("cyphal", made, channel=channel, node=node, subject=subject)
        found = list(transfers(frames))
        assert len(found) == len(frames) == count
        read = [pycyphal.dsdl.deserialize(noise_type, one.fragmented_payload) for one in found]
        heads = [one.metadata.session_specifier for one in found]
        froms = {(one.source_node_id, one.data_specifier) for one in heads}
        assert froms == {(node, MessageDataSpecifier(subject))}
        assert [one.metadata.transfer_id for one in found] == [n % 32 for n in range(count)]
        values = [[getattr(one, name) for name in NAMES] for one in read]
        assert mismatches(quantities(made), values) == 0
        wanted = {name: made[name] for name in OTHERS if name != "channel"}
        wanted |= {"epoch": made["epoch"].astype("u4"), "channel": np.full(count, channel)}
        for name in OTHERS:
            assert ([getattr(one, name) for one in read] == wanted[name]).all(), name
